//! Which Python interpreter runs a scene's scripts.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::Mutex,
};

use tatu_plugin_api::safe::*;

/// The environment variable that names the interpreter.
const VARIABLE: &str = "TATU_PYTHON";
/// The folder of a virtual environment beside the scene.
const BESIDE_SCENE: &str = ".venv/bin/python";

/// What errors advise.
pub(super) const HOW_TO_SET: &str =
    "name a Python interpreter with `--language python:interpreter=PATH`, or by the environment variable TATU_PYTHON";

/// Returns the interpreter for scripts of a scene in this folder: the one that is set, the one that `TATU_PYTHON` names,
/// that of the virtual environment beside the scene, that of the active virtual environment, or `python3`.
pub(super) fn choose(set: Option<&Path>, scene_folder: Option<&Path>) -> Result<PathBuf> {
    let set = set.filter(|path| !path.as_os_str().is_empty()).map(PathBuf::from);
    let named = || std::env::var_os(VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from);
    let beside = || scene_folder.map(|folder| folder.join(BESIDE_SCENE)).filter(|file| file.is_file());
    let active = || std::env::var_os("VIRTUAL_ENV").map(|v| Path::new(&v).join("bin/python")).filter(|f| f.is_file());
    let wanted = set.or_else(named).or_else(beside).or_else(active).unwrap_or_else(|| "python3".into());
    let file = match wanted.components().count() {
        1 => in_path(&wanted),
        _ => Some(wanted.clone()).filter(|file| file.is_file()),
    };
    let Some(file) = file else {
        let fail = Fail::missing(format!("there is no Python interpreter `{}`", wanted.display()));
        return Err(fail.help(format!("install Python 3.8 or later, or {HOW_TO_SET}")));
    };
    behind_wrapper(file)
}

/// Finds a program in `PATH`.
fn in_path(name: &Path) -> Option<PathBuf> {
    std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// If the file is a shell script that starts an interpreter, as version managers install, returns that interpreter,
/// because such scripts are slow and start other programs.
fn behind_wrapper(file: PathBuf) -> Result<PathBuf> {
    let mut first = [0; 2];
    if File::open(&file).and_then(|mut f| f.read_exact(&mut first)).is_err() || first != *b"#!" {
        return Ok(file);
    }
    static KNOWN: Mutex<Vec<(PathBuf, PathBuf)>> = Mutex::new(Vec::new());
    let mut known = KNOWN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some((_, found)) = known.iter().find(|(wrapper, _)| *wrapper == file) {
        return Ok(found.clone());
    }
    let asked = Command::new(&file)
        .args(["-I", "-c", "import sys; sys.stdout.write(sys.executable)"])
        .stdin(Stdio::null())
        .output()
        .map_err(|e| Fail::new(format!("the Python interpreter `{}` cannot be started: {e}", file.display())))?;
    let found = PathBuf::from(String::from_utf8_lossy(&asked.stdout).into_owned());
    if !asked.status.success() || !found.is_file() {
        let said = String::from_utf8_lossy(&asked.stderr).trim().to_owned();
        return Err(Fail::new(format!("the Python interpreter `{}` cannot be started: {said}", file.display())));
    }
    known.push((file, found.clone()));
    Ok(found)
}
