//! One test binary; each module holds one promise of the library.

mod layering;
