//! Fuzzes the reader of SDF files: repairs of XML, elements, frames and poses.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = tatu_importers_sdf::count_links(&String::from_utf8_lossy(bytes));
});
