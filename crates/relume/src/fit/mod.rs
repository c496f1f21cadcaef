//! Fitting: from photographs under known lights to coefficients.
