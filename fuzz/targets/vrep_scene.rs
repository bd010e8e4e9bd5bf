//! Whole files as they come: header, packing, sections.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tatu_fuzz::look_at(bytes));
