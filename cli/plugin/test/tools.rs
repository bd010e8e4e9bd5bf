//! Compilers: what the environment says, or what the system has.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::Command,
};

use tatu_core::errors::{Error, Result};
use tatu_plugin_api::safe::program_file;

/// A call of the compiler for a source that makes a library of it.
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

/// The folder of the headers: the plugin's own SDK, what TATU_INCLUDE names, or what came with the program.
fn headers(folder: &Path) -> Result<PathBuf> {
    let mut places = vec![folder.join("sdk/include"), folder.join("include")];
    places.extend(std::env::var_os("TATU_INCLUDE").map(PathBuf::from));
    if let Some(home) = home() {
        places.extend([home.join("include"), home.join("../include"), home.join("../lib/tatu/include")]);
    }
    // Where the program was built.
    places.push(Path::new(env!("CARGO_MANIFEST_DIR")).join("plugin-api/include"));
    places.into_iter().find(|place| place.join("tatu/test.h").is_file()).ok_or_else(|| {
        Error::new("E621", "the header tatu/test.h was not found")
            .expected("it in `sdk/include` of the plugin, or beside the program")
            .help("set TATU_INCLUDE to the folder that holds tatu.h")
    })
}

/// The folder of this program.
pub fn home() -> Option<PathBuf> {
    program_file()?.parent().map(Path::to_owned)
}

/// Cargo, as what called us names it.
pub fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// The name of a library on this system.
pub fn library_name(stem: &str) -> String {
    format!("{}{stem}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX)
}

/// Files of a folder with one of these suffixes, in order of their names; a folder that is not there has none.
pub fn files(folder: &Path, suffixes: &[&str]) -> Vec<PathBuf> {
    let is_one = |p: &PathBuf| p.is_file() && p.extension().is_some_and(|e| suffixes.iter().any(|s| e == *s));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut all: Vec<PathBuf> = entries.map(|e| e.path()).filter(is_one).collect();
    all.sort();
    all
}

/// A path as tests are told by: from the plugin's folder.
pub fn shown(folder: &Path, path: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).display().to_string()
}
