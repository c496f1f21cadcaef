//! The header of a multires folder, whose pictures are the bytes after it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| relume_fuzz::multires(bytes));
