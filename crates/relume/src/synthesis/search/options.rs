//! Options of the search.

use serde::Serialize;

use crate::names::named;

/// The methods of searching; all give identical candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchMethod {
    /// The one that [`super::plan`] expects to be fastest.
    #[default]
    Auto,
    /// Projection kernels with rejection.
    Projection,
    /// Correlation by the fast Fourier transform.
    Fft,
    /// Every position in full.
    Brute,
}

named!(SearchMethod { Auto => "auto", Projection => "projection", Fft => "fft", Brute => "brute" });

/// The sources of projection kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum KernelBasis {
    /// The leading directions of a sample of the neighbourhood ensemble.
    #[default]
    Svd,
    /// Discrete cosines, one plane at a time.
    Dct,
    /// Walsh-Hadamard functions, one plane at a time.
    WalshHadamard,
}

named!(KernelBasis { Svd => "svd", Dct => "dct", WalshHadamard => "walsh-hadamard" });

/// Options of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SearchOptions {
    /// The method.
    pub method: SearchMethod,
    /// The basis of the projection search.
    pub basis: KernelBasis,
    /// The most kernels for each cell in the first look of the projection search.
    pub kernels: usize,
    /// Whether the rejection curve is measured on a sample of the blocks, which takes time.
    pub curve: bool,
    /// Whether large exemplars are searched at a reduced resolution first ([`super::coarse`]): many times faster, and nearly
    /// as good.
    pub coarse: bool,
}

impl Default for SearchOptions {
    /// Automatic choice, singular vectors, at most 28 kernels per cell for the first look.
    fn default() -> Self {
        Self { method: SearchMethod::Auto, basis: KernelBasis::Svd, kernels: 28, curve: false, coarse: false }
    }
}
