//! Sections behind a sound header that are not packed, so that whatever is tried lies in them.
#![no_main]

use tatu_importers_vrep_scene::read::made;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tatu_fuzz::look_at(&made::file(25, bytes)));
