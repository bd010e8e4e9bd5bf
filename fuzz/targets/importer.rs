//! Fuzzes the importer of one kind of file as the program runs it: the plugin is loaded, and the host builds a document
//! from what it reads. `run.sh` sets TATU_FUZZ_PLUGIN, the path of the instrumented plugin, and TATU_FUZZ_FILE, the name
//! under which it gets the bytes.
#![no_main]

use std::{env, path::PathBuf, sync::LazyLock};

use tatu_core::{
    document::{self, LoadOptions, SourceFiles},
    errors::Error,
    host_tables,
    plugins::{Registry, SearchPath},
};

/// The plugin, and the path of the file, in an empty folder that nothing else writes to.
static IMPORTER: LazyLock<(Registry, PathBuf)> = LazyLock::new(|| {
    let of = |key: &str| env::var_os(key).unwrap_or_else(|| panic!("{key} is not set; start this with fuzz/run.sh"));
    let search = SearchPath { only: Some(of("TATU_FUZZ_PLUGIN").into()), ..SearchPath::standard(None, None, &[]) };
    let registry = Registry::load(search, host_tables());
    assert!(registry.load_report.refused.is_empty(), "{:?}", registry.load_report.refused);
    (registry, PathBuf::from(of("TATU_FUZZ_FILE")))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let (registry, file) = &*IMPORTER;
    let sources = SourceFiles::of([(file.clone(), bytes.to_vec())]);
    let loaded = document::load(file, registry, &LoadOptions { sources, ..Default::default() });
    // Panics of a plugin end at its border, and the host reports them as errors.
    let broken = |error: &Error| {
        let text = error.to_string();
        text.contains("panicked") || text.contains("broke the contract")
    };
    if let Err(error) = &loaded
        && broken(error)
    {
        panic!("{error}");
    }
});
