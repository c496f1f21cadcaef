//! Measures of difference between pictures and fields.
