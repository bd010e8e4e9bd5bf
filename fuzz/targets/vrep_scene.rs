//! Fuzzes the reader with whole files: header, compression and sections.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tatu_fuzz::look_at(bytes));
