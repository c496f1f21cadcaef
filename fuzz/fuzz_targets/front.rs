//! The front end: any bytes, recognised and read as whatever they are.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| relume_fuzz::front(bytes));
