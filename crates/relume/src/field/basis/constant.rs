//! The basis of a plain picture: the constant function 1.

use super::Domain;
use super::moments::moment;
use crate::numeric::Matrix;

pub(super) fn gram(domain: Domain) -> Matrix {
    Matrix::from_fn(1, 1, |_, _| moment(domain, 0, 0))
}
