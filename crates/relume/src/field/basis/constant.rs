//! The basis of a plain picture: the constant function 1.

use super::Domain;
use super::moments;
use crate::numeric::Matrix;

pub(super) fn gram(domain: Domain) -> Matrix {
    moments::gram(domain, &[(0, 0)])
}
