//! Normal maps and their records.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| relume_fuzz::normals(bytes));
