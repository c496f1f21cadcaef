//! Reflectance models in the place of linear functions, and what is to be said of these.

use super::field_file::FieldFile;
use crate::field::ParametricField;
use crate::fit::parametric::linear_remark;

/// Reflectance models, and by how much their linear form differs from what they show.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelModels {
    /// The models.
    pub models: ParametricField,
    /// The root mean square of the difference, of encoded values with white at 1.
    pub rmse: f64,
}

impl FieldFile {
    /// What is to be said where the field stands for reflectance models.
    pub fn linear_remark(&self) -> Option<String> {
        self.models.as_ref().map(|of| linear_remark(&of.models, &self.field, of.rmse))
    }

    /// What is to be said where the field serves to compare texels, and the numbers of the models are kept.
    pub fn comparison_remark(&self) -> Option<String> {
        self.models.as_ref().map(|of| {
            format!(
                "texels of the reflectance model {} are compared by {} learned functions, which differ from what it shows by {:.2} of \
                 255 (root mean square)",
                of.models.model().name(),
                self.field.basis().len(),
                255.0 * of.rmse
            )
        })
    }
}
