//! Embeds the page and its libraries, so that the program needs neither Node nor a network. npm fetches the libraries
//! into cargo's output folder of this build, in the versions that `page/package-lock.json` pins. If they are missing,
//! the program is built nevertheless, and its page reports what is missing.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use serde_json::{Map, Value, json};

/// Libraries: the name by which modules import them, and the file in `node_modules`.
const LIBRARIES: &[(&str, &str)] = &[
    ("three", "three/build/three.module.min.js"),
    ("three/controls", "three/examples/jsm/controls/OrbitControls.js"),
    ("three/gizmo", "three/examples/jsm/controls/TransformControls.js"),
    ("@codemirror/state", "@codemirror/state/dist/index.js"),
    ("@codemirror/view", "@codemirror/view/dist/index.js"),
    ("@codemirror/language", "@codemirror/language/dist/index.js"),
    ("@codemirror/commands", "@codemirror/commands/dist/index.js"),
    ("@codemirror/autocomplete", "@codemirror/autocomplete/dist/index.js"),
    ("@codemirror/lint", "@codemirror/lint/dist/index.js"),
    ("@codemirror/legacy-modes/mode/lua", "@codemirror/legacy-modes/mode/lua.js"),
    ("@lezer/common", "@lezer/common/dist/index.js"),
    ("@lezer/highlight", "@lezer/highlight/dist/index.js"),
    ("@lezer/lr", "@lezer/lr/dist/index.js"),
    ("@marijn/find-cluster-break", "@marijn/find-cluster-break/src/index.js"),
    ("crelt", "crelt/index.js"),
    ("style-mod", "style-mod/src/style-mod.js"),
    ("w3c-keyname", "w3c-keyname/index.js"),
];

/// Files that libraries import by relative path.
const BESIDE: &[&str] = &["three/build/three.core.min.js"];

fn kind(path: &Path) -> Option<&'static str> {
    Some(match path.extension()?.to_str()? {
        "html" => "text/html; charset=utf-8",
        "lua" => "text/plain; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "svg" => "image/svg+xml",
        _ => return None,
    })
}

/// The variable that switches npm off, and its value.
const SWITCH: &str = "TATU_PAGE_NPM";
const OFF: &str = "off";
/// Arguments of npm. Each file is requested only once and with a short timeout, because the build waits.
const NPM: &[&str] =
    &["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=0", "--fetch-timeout=10000"];
/// The files that `npm ci` reads.
const LOCK: &str = "package-lock.json";
const PACKAGE: &str = "package.json";
/// A copy of the lock file, written when everything in it has been installed.
const INSTALLED: &str = "installed-lock.json";
/// If npm fails within this time, it is started again in every build.
const QUICK: Duration = Duration::from_secs(5);

/// Returns the folder with the libraries, installing them if necessary, or `None` after a warning if they are not
/// available.
fn libraries(page: &Path, out: &Path) -> Option<PathBuf> {
    println!("cargo::rerun-if-env-changed={SWITCH}");
    let folder = out.join("page");
    let modules = folder.join("node_modules");
    let has_all = || {
        let mut files = LIBRARIES.iter().map(|(_, file)| *file).chain(BESIDE.iter().copied());
        files.all(|file| modules.join(file).is_file())
    };
    let lock = fs::read(page.join(LOCK)).expect("the lock of the page's libraries");
    if fs::read(folder.join(INSTALLED)).is_ok_and(|installed| installed == lock) && has_all() {
        return Some(modules);
    }
    if env::var_os(SWITCH).is_some_and(|value| value == OFF) {
        warn(&format!("{SWITCH}={OFF}"), "build without this variable");
        return None;
    }
    let began = Instant::now();
    match install(page, &folder) {
        Ok(()) if has_all() => {
            fs::write(folder.join(INSTALLED), lock).expect("the copy of the lock");
            return Some(modules);
        }
        Ok(()) => warn("npm has installed other files than those in build.rs", "correct LIBRARIES there"),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            warn("npm was not found", "install it (Debian: `apt-get install npm`), and build again");
            // Installing npm changes one of the folders in PATH, and so triggers another build.
            let path = env::var_os("PATH").unwrap_or_default();
            for commands in env::split_paths(&path).filter(|p| p.is_absolute() && p.is_dir()) {
                println!("cargo::rerun-if-changed={}", commands.display());
            }
        }
        Err(e) if began.elapsed() < QUICK => {
            warn(&format!("`npm ci` has failed: {e}"), "correct this, and build again");
            // Cargo runs this script in every build as long as a file that it names does not exist.
            println!("cargo::rerun-if-changed={}", folder.join(INSTALLED).display());
        }
        Err(e) => warn(&format!("`npm ci` has failed: {e}"), &format!("correct this, and build with {SWITCH}=again")),
    }
    None
}

fn warn(why: &str, help: &str) {
    println!("cargo::warning=the program is built without its page, whose libraries are missing: {why}; {help}");
}

/// Runs npm in a separate folder. The error is that of starting npm, or npm's first message.
fn install(page: &Path, folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    // From here on, the libraries of an earlier build may be incomplete.
    match fs::remove_file(folder.join(INSTALLED)) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
        _ => {}
    }
    for file in [PACKAGE, LOCK] {
        fs::copy(page.join(file), folder.join(file))?;
    }
    let npm = if cfg!(windows) { "npm.cmd" } else { "npm" };
    let out = Command::new(npm).args(NPM).current_dir(folder).stdin(Stdio::null()).output()?;
    if out.status.success() {
        return Ok(());
    }
    let text = String::from_utf8_lossy(&out.stderr);
    // The first lines only describe the failed system call.
    let details = ["code ", "errno ", "syscall ", "path "];
    let is_said = |line: &&str| !line.is_empty() && !details.iter().any(|word| line.starts_with(word));
    let mut lines = text.lines().filter_map(|line| line.strip_prefix("npm error ")).filter(is_said);
    Err(io::Error::other(lines.next().map_or_else(|| out.status.to_string(), str::to_owned)))
}

fn main() {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets the folder")).join("page");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets the folder"));
    let mut entries: Vec<(String, &'static str, PathBuf)> = Vec::new();
    let mut imports = Map::new();
    let mut names: Vec<PathBuf> = fs::read_dir(&root).expect("the page").flatten().map(|e| e.path()).collect();
    names.sort();
    println!("cargo::rerun-if-changed=page");
    for path in names.into_iter().filter(|p| p.is_file()) {
        let (Some(kind), Some(name)) = (kind(&path), path.file_name().and_then(|n| n.to_str())) else { continue };
        if let Some(stem) = name.strip_suffix(".js") {
            imports.insert(format!("tatu/{stem}"), Value::String(format!("/page/{name}")));
        }
        entries.push((format!("/page/{name}"), kind, path.clone()));
    }
    let modules = libraries(&root, &out);
    if let Some(modules) = &modules {
        let files = LIBRARIES.iter().map(|(_, f)| *f).chain(BESIDE.iter().copied());
        for file in files {
            entries.push((format!("/lib/{file}"), "text/javascript; charset=utf-8", modules.join(file)));
        }
        for (name, file) in LIBRARIES {
            imports.insert((*name).to_owned(), Value::String(format!("/lib/{file}")));
        }
    }
    let whole = modules.is_some();
    // For the build script of the program: its browser tests of the page need the libraries.
    println!("cargo::metadata=whole={whole}");
    let axe = modules.map(|modules| modules.join("axe-core/axe.min.js")).filter(|file| file.is_file());
    println!("cargo::metadata=axe={}", axe.unwrap_or_default().display());
    let map = json!({ "imports": imports }).to_string();
    let mut text =
        String::from("/// Path, type and bytes of each file.\npub static FILES: &[(&str, &str, &[u8])] = &[\n");
    for (name, kind, path) in &entries {
        text += &format!("    ({name:?}, {kind:?}, include_bytes!({:?})),\n", path.display().to_string());
    }
    text += &format!("];\n/// The import map.\npub const IMPORT_MAP: &str = {map:?};\n");
    text += &format!("/// Whether the libraries are embedded.\npub const WHOLE: bool = {whole};\n");
    fs::write(out.join("files.rs"), text).expect("the list of files");
}
