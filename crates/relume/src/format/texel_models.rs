//! Reflectance models in files, beside the linear functions that stand for them.

use crate::field::ParametricField;

/// Reflectance models, and by how much their linear form differs from what they show.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelModels {
    /// The models.
    pub models: ParametricField,
    /// The root mean square of the difference, of encoded values with white at 1.
    pub rmse: f64,
}
