//! Fuzzes the reader with uncompressed sections after a valid header, so that all mutations affect the sections.
#![no_main]

use tatu_importers_vrep_scene::read::made;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tatu_fuzz::look_at(&made::file(25, bytes)));
