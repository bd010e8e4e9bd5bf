//! Compilers, headers and files for tests.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::Command,
};

use tatu_core::errors::{Error, Result};
use tatu_plugin_api::safe::program_file;

/// Returns a command that compiles a source file to a library, without the file and the output.
pub fn compiler(folder: &Path, source: &Path) -> Result<Command> {
    let is_c = source.extension().is_some_and(|e| e == "c");
    let (variable, default, standard) = if is_c { ("CC", "cc", "-std=c11") } else { ("CXX", "c++", "-std=c++17") };
    let words = std::env::var(variable).unwrap_or_default();
    let mut words = words.split_whitespace();
    let mut command = Command::new(words.next().unwrap_or(default));
    command.args(words).args([standard, "-g", "-Wall", "-Wextra"]);
    command.arg(if cfg!(target_os = "macos") { "-dynamiclib" } else { "-shared" });
    if cfg!(unix) {
        command.args(["-fPIC", "-fvisibility=hidden"]);
    }
    command.arg("-I").arg(headers(folder)?);
    Ok(command)
}

/// Returns the folder of the headers: the plugin's SDK, TATU_INCLUDE, or a folder of the program.
fn headers(folder: &Path) -> Result<PathBuf> {
    let mut places = vec![folder.join("sdk/include"), folder.join("include")];
    places.extend(std::env::var_os("TATU_INCLUDE").map(PathBuf::from));
    if let Some(home) = home() {
        places.extend([home.join("include"), home.join("../include"), home.join("../lib/tatu/include")]);
    }
    // The source tree from which the program was built.
    places.push(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api/include"));
    places.into_iter().find(|place| place.join("tatu/test.h").is_file()).ok_or_else(|| {
        Error::new("E621", "the header tatu/test.h was not found")
            .expected("the header in `sdk/include` of the plugin, or in `include` next to the program")
            .help("set TATU_INCLUDE to the folder that contains tatu.h")
    })
}

/// Returns the folder of this program.
pub fn home() -> Option<PathBuf> {
    program_file()?.parent().map(Path::to_owned)
}

/// Returns the program named by the variable CARGO, which cargo sets for its children; otherwise `cargo`.
pub fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Returns the file name of a library on this system.
pub fn library_name(stem: &str) -> String {
    format!("{}{stem}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX)
}

/// Returns the files in a folder with one of these suffixes, sorted by name. A folder that does not exist has no files.
pub fn files(folder: &Path, suffixes: &[&str]) -> Vec<PathBuf> {
    let is_one = |p: &PathBuf| p.is_file() && p.extension().is_some_and(|e| suffixes.iter().any(|s| e == *s));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut all: Vec<PathBuf> = entries.map(|e| e.path()).filter(is_one).collect();
    all.sort();
    all
}

/// Returns a path for display, relative to the plugin's folder.
pub fn shown(folder: &Path, path: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).display().to_string()
}
