//! Benchmarks of Relume.
