//! Finds the library of the host, and that of the plugin under test.

use std::{
    env::consts::{DLL_PREFIX, DLL_SUFFIX},
    path::{Path, PathBuf},
};

use crate::{Error, Result};

/// Returns the path of a package's library: the `cdylib` that cargo has built beside the running test.
///
/// # Errors
/// Fails if there is no such file, for example because the crate is not a `cdylib`, or only unit tests are built.
pub fn plugin_library(package: &str) -> Result<PathBuf> {
    let name = format!("{DLL_PREFIX}{}{DLL_SUFFIX}", package.replace('-', "_"));
    let test = std::env::current_exe().map_err(|e| Error::new(format!("cannot get the path of this test: {e}")))?;
    // The test is in target/debug/deps; the library is in the same folder, or in target/debug.
    let folders = test.ancestors().skip(1).take(2);
    folders.map(|f| f.join(&name)).find(|file| file.is_file()).ok_or_else(|| {
        Error::new(format!(
            "{name} is not beside {}\n  expected: `crate-type = [\"cdylib\", \"rlib\"]` below [lib] in Cargo.toml, and \
             the test in the folder `tests`: cargo builds the library only for these\n  help: if [lib] has a `name`, \
             pass it: plugin!(\"tatu_lamp\")",
            test.display()
        ))
    })
}

/// Returns the path of the host's library: TATU_TESTHOST or, without it, the library of the program in TATU_HOME or
/// PATH.
pub fn host_library() -> Result<PathBuf> {
    if let Some(file) = std::env::var_os("TATU_TESTHOST").map(PathBuf::from) {
        return match file.is_file() {
            true => Ok(file),
            false => Err(Error::new(format!("TATU_TESTHOST is set to {}, which is not a file", file.display()))),
        };
    }
    if let Some(home) = std::env::var_os("TATU_HOME").map(PathBuf::from) {
        return host_library_beside(&home).ok_or_else(|| {
            let text = format!("TATU_HOME is set to {}, which does not contain {}", home.display(), host_name());
            Error::new(text + "\n  expected: the folder of the program `tatu`")
        });
    }
    let program = format!("tatu{}", std::env::consts::EXE_SUFFIX);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folder = std::env::split_paths(&path).find(|folder| folder.join(&program).is_file());
    let folder = folder.ok_or_else(|| {
        Error::new(
            "Tatu was not found\n  help: put the program `tatu` into PATH, or set TATU_HOME to its folder; \
             `tatu plugin test` does so itself",
        )
    })?;
    // The program in PATH may be a symbolic link.
    let real = folder.join(&program).canonicalize().ok().and_then(|p| p.parent().map(Path::to_owned));
    let found = host_library_beside(&folder).or_else(|| host_library_beside(&real?));
    found.ok_or_else(|| {
        let text = format!("the program `tatu` in {} has no {} beside it", folder.display(), host_name());
        Error::new(text + "\n  help: build or install all of Tatu; the library is part of it")
    })
}

fn host_name() -> String {
    format!("{DLL_PREFIX}tatuhost{DLL_SUFFIX}")
}

/// Returns the host's library of a program in `folder`: beside the program, where cargo builds it, or in the library
/// folder of an installation.
fn host_library_beside(folder: &Path) -> Option<PathBuf> {
    let places = ["", "deps", "../lib/tatu", "bin", "lib/tatu"];
    places.iter().map(|place| folder.join(place).join(host_name())).find(|file| file.is_file())
}
