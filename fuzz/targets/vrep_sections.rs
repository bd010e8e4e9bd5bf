//! Fuzzes the reader with uncompressed sections after a valid header, so that all mutations affect the sections.
#![no_main]

use tatu_importers_vrep_scene::read::test_files;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tatu_fuzz::look_at(&test_files::file(25, bytes)));
