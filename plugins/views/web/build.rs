//! Embeds the page and its libraries, so the program needs neither Node nor a network at run time. npm fetches the
//! libraries into cargo's output folder, in the versions that `page/package-lock.json` pins. If they cannot be fetched,
//! the program is built nevertheless, and its page explains how to install them.

use std::{
    env, fs,
    hash::{DefaultHasher, Hash, Hasher},
    io,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use serde_json::{Map, Value, json};

/// The libraries: the specifier by which modules import each of them, and its file in `node_modules`.
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
    ("@codemirror/legacy-modes/mode/python", "@codemirror/legacy-modes/mode/python.js"),
    ("@lezer/common", "@lezer/common/dist/index.js"),
    ("@lezer/highlight", "@lezer/highlight/dist/index.js"),
    ("@lezer/lr", "@lezer/lr/dist/index.js"),
    ("@marijn/find-cluster-break", "@marijn/find-cluster-break/src/index.js"),
    ("crelt", "crelt/index.js"),
    ("style-mod", "style-mod/src/style-mod.js"),
    ("w3c-keyname", "w3c-keyname/index.js"),
];

/// Further files in `node_modules`, which libraries import by relative path.
const BESIDE: &[&str] = &["three/build/three.core.min.js"];

/// Folders of the page that are not embedded.
const NOT_EMBEDDED: &[&str] = &["node_modules", "tests"];

/// Appends the files in a folder of the page and in its subfolders, each with its name: `prefix` and its path from
/// that folder, with slashes on every system.
fn list(folder: &Path, prefix: &str, out: &mut Vec<(String, PathBuf)>) {
    for entry in fs::read_dir(folder).expect("cannot list a folder of the page").flatten() {
        let path = entry.path();
        let Ok(name) = entry.file_name().into_string() else { continue };
        if path.is_file() {
            out.push((format!("{prefix}{name}"), path));
        } else if path.is_dir() && !NOT_EMBEDDED.contains(&name.as_str()) {
            list(&path, &format!("{prefix}{name}/"), out);
        }
    }
}

/// Returns the content type of a file, or `None` if files with its extension are not embedded.
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

/// The environment variable that prevents this script from running npm if it has the value in `OFF`.
const SWITCH: &str = "TATU_PAGE_NPM";
const OFF: &str = "off";
/// Arguments of npm. Failed downloads are not retried and time out after 10 s, because the build waits for them.
const NPM: &[&str] =
    &["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=0", "--fetch-timeout=10000"];
/// The files that `npm ci` reads.
const LOCK: &str = "package-lock.json";
const PACKAGE: &str = "package.json";
/// A copy of the lock file, written when the installation is complete, so that later builds can skip it.
const INSTALLED: &str = "installed-lock.json";
/// If npm fails within this time, every later build runs it again.
const QUICK: Duration = Duration::from_secs(5);

/// Returns the folder that contains the libraries, installing them if necessary. If they are not available, prints a
/// warning and returns `None`.
fn libraries(page: &Path, out: &Path) -> Option<PathBuf> {
    println!("cargo::rerun-if-env-changed={SWITCH}");
    let folder = out.join("page");
    let modules = folder.join("node_modules");
    let has_all = || {
        let mut files = LIBRARIES.iter().map(|(_, file)| *file).chain(BESIDE.iter().copied());
        files.all(|file| modules.join(file).is_file())
    };
    let lock = fs::read(page.join(LOCK)).expect("cannot read package-lock.json of the page");
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
            fs::write(folder.join(INSTALLED), lock).expect("cannot write the copy of package-lock.json");
            return Some(modules);
        }
        Ok(()) => warn("npm did not install all files that build.rs lists", "correct `LIBRARIES` in build.rs"),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            warn("npm was not found", "install it (Debian: `apt-get install npm`), and build again");
            // Installing npm changes one of the folders in PATH, which makes cargo run this script again.
            let path = env::var_os("PATH").unwrap_or_default();
            for commands in env::split_paths(&path).filter(|p| p.is_absolute() && p.is_dir()) {
                println!("cargo::rerun-if-changed={}", commands.display());
            }
        }
        Err(e) if began.elapsed() < QUICK => {
            warn(&format!("`npm ci` failed: {e}"), "fix this, and build again");
            // Cargo runs this script in every build while a file that it watches does not exist.
            println!("cargo::rerun-if-changed={}", folder.join(INSTALLED).display());
        }
        Err(e) => warn(&format!("`npm ci` failed: {e}"), &format!("fix this, and build with {SWITCH}=again")),
    }
    None
}

fn warn(why: &str, help: &str) {
    println!("cargo::warning=the program is built without its page, whose libraries are missing: {why}; {help}");
}

/// Installs the libraries by running npm in a separate folder. If npm cannot be started, returns that error; if it
/// fails, returns its first informative message.
fn install(page: &Path, folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    // From here on, `node_modules` may be incomplete, so the mark of an earlier installation is removed.
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
    // npm prints the error code and the failed system call before the message, so such lines are skipped.
    let details = ["code ", "errno ", "syscall ", "path "];
    let is_said = |line: &&str| !line.is_empty() && !details.iter().any(|word| line.starts_with(word));
    let mut lines = text.lines().filter_map(|line| line.strip_prefix("npm error ")).filter(is_said);
    Err(io::Error::other(lines.next().map_or_else(|| out.status.to_string(), str::to_owned)))
}

/// Returns a hash of the names and contents of all files. The same files have the same hash in every build.
fn version(entries: &[(String, &'static str, PathBuf)]) -> String {
    let mut hasher = DefaultHasher::new();
    for (name, _, path) in entries {
        (name, fs::read(path).expect("cannot read a file of the page")).hash(&mut hasher);
    }
    format!("{:016x}", hasher.finish())
}

fn main() {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR")).join("page");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let mut entries: Vec<(String, &'static str, PathBuf)> = Vec::new();
    // By the specifier, the path of each module.
    let mut modules: Vec<(String, String)> = Vec::new();
    let mut files: Vec<(String, PathBuf)> = Vec::new();
    list(&root, "", &mut files);
    files.sort();
    for (name, path) in files {
        // Not the folder as a whole, since npm installs tools of the page's tests in it. A new file is noticed because an
        // older one must import it.
        println!("cargo::rerun-if-changed={}", path.display());
        let Some(kind) = kind(&path) else { continue };
        if let Some(stem) = name.strip_suffix(".js") {
            modules.push((format!("tatu/{stem}"), format!("/page/{name}")));
        }
        entries.push((format!("/page/{name}"), kind, path));
    }
    let installed = libraries(&root, &out);
    if let Some(installed) = &installed {
        let files = LIBRARIES.iter().map(|(_, f)| *f).chain(BESIDE.iter().copied());
        for file in files {
            entries.push((format!("/lib/{file}"), "text/javascript; charset=utf-8", installed.join(file)));
        }
        for (name, file) in LIBRARIES {
            modules.push(((*name).to_owned(), format!("/lib/{file}")));
        }
    }
    let version = version(&entries);
    let imports: Map<String, Value> =
        modules.into_iter().map(|(name, path)| (name, Value::String(format!("/{version}{path}")))).collect();
    let whole = installed.is_some();
    // Read by the program's build script: browser tests of the page can run only if the libraries are embedded.
    println!("cargo::metadata=whole={whole}");
    let axe = installed.map(|modules| modules.join("axe-core/axe.min.js")).filter(|file| file.is_file());
    println!("cargo::metadata=axe={}", axe.unwrap_or_default().display());
    let map = json!({ "imports": imports }).to_string();
    let mut text = String::from(
        "/// Path, content type and bytes of each embedded file.\npub static FILES: &[(&str, &str, &[u8])] = &[\n",
    );
    for (name, kind, path) in &entries {
        text += &format!("    ({name:?}, {kind:?}, include_bytes!({:?})),\n", path.display().to_string());
    }
    text += &format!(
        "];\n/// The first folder of the paths under which browsers may store the files: a hash of all files.\npub const VERSION: &str = {version:?};\n"
    );
    text += &format!("/// The import map of the page, JSON.\npub const IMPORT_MAP: &str = {map:?};\n");
    text += &format!("/// Whether the page's libraries are embedded.\npub const HAS_LIBRARIES: bool = {whole};\n");
    fs::write(out.join("files.rs"), text).expect("cannot write files.rs");
}
