//! Helpers for all tests, which run the program, create scenes in temporary folders and compile plugins.

use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
    time::Duration,
};

use serde_json::Value;
use tatu_core::plugins::{Registry, SearchPath};
use tempfile::TempDir;

/// A scene entry for a horizontal plane at z = 0 that collides with everything.
pub const FLOOR: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";

/// Makes cargo build a project that is built once without what only later builds and debuggers need.
pub const SINGLE_BUILD: [(&str, &str); 2] = [("CARGO_INCREMENTAL", "0"), ("CARGO_PROFILE_DEV_DEBUG", "0")];

/// Returns the root folder of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the path of a file in the folder `shared` next to the repository. Tests that use a missing file are ignored.
pub fn shared(path: &str) -> PathBuf {
    let full = root().join("../shared").join(path);
    full.canonicalize().unwrap_or_else(|e| panic!("{}: {e}", full.display()))
}

/// The result of running the program.
pub struct RunOutput {
    pub code: i32,
    /// The signal that killed the program, if any.
    pub signal: Option<i32>,
    pub out: String,
    pub err: String,
}

impl RunOutput {
    /// Parses standard output, which must be JSON: for example, the summary of `run --json` or the array of `list
    /// --json`.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out)
            .unwrap_or_else(|e| panic!("stdout is not JSON ({e}):\n{}\n{}", self.out, self.err))
    }
    /// Checks that the program exited with 0.
    #[track_caller]
    pub fn good(self) -> Self {
        assert!(self.code == 0, "exit {}\n{}\n{}", self.code, self.err, self.out);
        self
    }
    /// Checks that the run exited with 1, and returns its errors.
    #[track_caller]
    pub fn errors(&self) -> Vec<Value> {
        assert_eq!(self.code, 1, "{}\n{}", self.err, self.out);
        self.json()["errors"].as_array().unwrap().clone()
    }
    /// Checks that the program refused to start, and that standard error contains all of `words`.
    #[track_caller]
    pub fn refused(&self, words: &[&str]) {
        assert_eq!(self.code, 2, "{}\n{}", self.err, self.out);
        self.reports(words);
    }
    /// Checks that standard error contains all of `words`.
    #[track_caller]
    pub fn reports(&self, words: &[&str]) {
        for w in words {
            assert!(self.err.contains(w), "standard error does not contain `{w}`:\n{}", self.err);
        }
        assert!(!self.err.contains("panicked"), "a panic:\n{}", self.err);
    }
}

/// Runs a program in a folder, without a plugin path, and kills it if it hangs.
pub fn run(program: &Path, dir: &Path, args: &[&str], env: &[(&str, &str)]) -> RunOutput {
    let mut command = assert_cmd::Command::new(program);
    command.current_dir(dir).args(args).env_remove("TATU_PLUGIN_PATH").timeout(Duration::from_secs(300));
    // Allows the scenes of tests to load plugins from their own folder.
    command.env("TATU_TRUST", dir);
    // Plugins installed by the user who runs the tests must not be found.
    command.env("XDG_DATA_HOME", dir.join(".data"));
    // Neither must packed scenes be unpacked into the user's cache.
    command.env("XDG_CACHE_HOME", dir.join(".cache"));
    for (key, value) in env {
        command.env(key, value);
    }
    let output = loop {
        match command.output() {
            // A process that another test has just forked may still have the freshly copied program open for writing.
            Err(e) if e.kind() == ErrorKind::ExecutableFileBusy => std::thread::sleep(Duration::from_millis(10)),
            other => break other.unwrap(),
        }
    };
    RunOutput {
        code: output.status.code().unwrap_or(-1),
        signal: signal(output.status),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

#[cfg(unix)]
fn signal(status: std::process::ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}
#[cfg(not(unix))]
fn signal(_: std::process::ExitStatus) -> Option<i32> {
    None
}

/// Loads plugins in this process. Waiting for a program with a time limit installs a handler of SIGCHLD in the process
/// when it is first done, which must not happen during a call of a plugin: the host would take the handler for the
/// plugin's, and remove it.
pub fn load_registry(search: SearchPath) -> Arc<Registry> {
    static HANDLER: std::sync::Once = std::sync::Once::new();
    HANDLER.call_once(|| drop(run(program(), &std::env::temp_dir(), &["--version"], &[])));
    Arc::new(Registry::load(search, tatu_core::host_tables()))
}

/// Returns the program under test.
pub fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_tatu"))
}

/// A temporary folder in which the program runs.
pub struct TestFolder {
    dir: TempDir,
}

impl TestFolder {
    pub fn new() -> Self {
        TestFolder { dir: TempDir::with_prefix("tatu-test-").unwrap() }
    }
    /// Creates a folder with a scene `scene.toml`; `text` begins within the table `[scene]`.
    pub fn scene(text: &str) -> Self {
        let place = TestFolder::new();
        place.write("scene.toml", &format!("format = 1\n[scene]\n{text}"));
        place
    }
    pub fn path(&self) -> &Path {
        self.dir.path()
    }
    pub fn write(&self, name: &str, text: &str) -> &Self {
        let file = self.path().join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
        self
    }
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).unwrap()
    }
    /// Runs the program with any arguments.
    pub fn tatu(&self, args: &[&str]) -> RunOutput {
        run(program(), self.path(), args, &[])
    }
    /// Runs `tatu run scene.toml --json` with more arguments.
    pub fn run(&self, args: &[&str]) -> RunOutput {
        self.tatu(&[&["run", "scene.toml", "--json"], args].concat())
    }
    /// Runs the scene with a trace of watched objects; it must end without an error.
    #[track_caller]
    pub fn trace(&self, watch: &[&str], args: &[&str]) -> Vec<TraceLine> {
        let mut all = vec!["--trace", "trace.jsonl"];
        watch.iter().for_each(|w| all.extend(["--watch", *w]));
        self.run(&[&all, args].concat()).good();
        self.lines("trace.jsonl")
    }
    /// Returns the lines of a trace up to the stop request.
    pub fn lines(&self, file: &str) -> Vec<TraceLine> {
        self.all_lines(file).into_iter().filter(|l| !l.is_stopping()).collect()
    }
    /// Returns all lines of a trace.
    pub fn all_lines(&self, file: &str) -> Vec<TraceLine> {
        self.read(file).lines().map(|l| TraceLine(serde_json::from_str(l).unwrap())).collect()
    }
}

/// One line of a trace.
pub struct TraceLine(pub Value);

impl TraceLine {
    /// Returns whether the line belongs to a pass after a stop was requested.
    pub fn is_stopping(&self) -> bool {
        self.0["stopping"] == Value::Bool(true)
    }
    pub fn time(&self) -> f64 {
        self.0["time"].as_f64().unwrap()
    }
    pub fn hash(&self) -> &str {
        self.0["hash"].as_str().unwrap()
    }
    pub fn status(&self) -> Vec<&str> {
        self.0["statusbar"].as_array().unwrap().iter().map(|s| s.as_str().unwrap()).collect()
    }
    /// Returns the "position", "quaternion", "linear_velocity" or "angular_velocity" of a watched object.
    #[track_caller]
    pub fn object<const N: usize>(&self, path: &str, what: &str) -> [f64; N] {
        let found = numbers(&self.0["objects"][path][what]);
        found.try_into().unwrap_or_else(|v| panic!("`{path}` {what}: {v:?} in {}", self.0))
    }
    /// Returns a scalar field of a watched sensor's reading.
    #[track_caller]
    pub fn sensor(&self, path: &str, field: &str) -> f64 {
        let value = &self.0["readings"][path][field];
        value.as_f64().unwrap_or_else(|| panic!("`{path}` {field}: {value} in {}", self.0))
    }
}

/// Changes the lines of an input log and recomputes their checksums. `change` maps a line without its checksum.
pub fn sealed_anew(log: &str, change: impl Fn(&str) -> String) -> String {
    let mut check = 0;
    let lines = log.lines().map(|line| {
        let (open, _) = line.rsplit_once(",\"check\":").unwrap();
        let open = change(open);
        check = xxhash_rust::xxh3::xxh3_64_with_seed(open.as_bytes(), check);
        format!("{open},\"check\":\"{check:016x}\"}}\n")
    });
    lines.collect()
}

/// Returns the numbers of a JSON array.
pub fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

/// Returns the yaw of the quaternion (x, y, z, w), rad.
pub fn yaw([x, y, z, w]: [f64; 4]) -> f64 {
    f64::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
}

/// Returns the angle between a body's z axis and the vertical, rad. It is an upper bound of roll and pitch.
pub fn lean([x, y, _, _]: [f64; 4]) -> f64 {
    (1.0 - 2.0 * (x * x + y * y)).clamp(-1.0, 1.0).acos()
}

/// Returns a Pioneer with an inline script; `more` has further keys.
pub fn pioneer(script: &str, more: &str) -> String {
    format!("[[model]]\nmodel = \"pioneer_p3dx\"\n{more}\nscript = {{ text = '''\n{script}\n''' }}\n")
}

/// Returns a dummy with an inline script.
pub fn watcher(alias: &str, script: &str) -> String {
    format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\nscript = {{ text = '''\n{script}\n''' }}\n")
}

/// Returns a box; `more` has further keys.
pub fn cuboid(alias: &str, size: [f64; 3], at: [f64; 3], more: &str) -> String {
    format!("[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nsize_m = {size:?}\nposition_m = {at:?}\n{more}\n")
}

/// Returns the file name of a library on this system.
pub fn library(stem: &str) -> String {
    format!("{}{stem}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX)
}

/// Builds a template as its README describes, in a copy of its folder; returns the folder of the library.
pub fn template(place: &TestFolder, name: &str) -> PathBuf {
    let api = root().join("plugin-api");
    let here = place.path().join("template").join(name);
    copy(&api.join("include"), &place.path().join("include"));
    copy(&api.join("template").join(name), &here);
    let readme = fs::read_to_string(here.join("README.md")).unwrap();
    build(&readme, &here);
    here
}

/// Runs the first line of a README that builds a library.
pub fn build(readme: &str, folder: &Path) {
    let line = readme.lines().find(|l| l.contains(" -shared ")).expect("the README has a line to build it");
    // The line is written for Linux; on other systems the name of the library differs.
    let mut words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
    for w in &mut words {
        if w.starts_with("lib") && w.ends_with(".so") {
            *w = library(w.trim_start_matches("lib").trim_end_matches(".so"));
        }
    }
    succeed(Command::new(compiler(&words[0])).args(&words[1..]).current_dir(folder));
}

/// Returns the compiler for "cc" or "c++": that in the variable CC or CXX if it is set, otherwise the system's.
pub fn compiler(name: &str) -> String {
    let variable = if name == "cc" { "CC" } else { "CXX" };
    std::env::var(variable).unwrap_or_else(|_| name.to_owned())
}

/// Runs a command that must succeed; returns its output.
#[track_caller]
pub fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    assert!(output.status.success(), "{command:?}\n{}", text(&output.stderr));
    text(&output.stdout)
}

/// Copies a folder recursively.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to),
            false => drop(fs::copy(entry.path(), to).unwrap()),
        }
    }
}

/// Returns the C headers below a folder: `tatu.h`, then those in `tatu/` by name, which old revisions do not have.
pub fn headers(include: &Path) -> Vec<PathBuf> {
    let mut parts: Vec<PathBuf> =
        fs::read_dir(include.join("tatu")).into_iter().flatten().map(|e| e.unwrap().path()).collect();
    parts.retain(|p| p.extension().is_some_and(|e| e == "h"));
    parts.sort();
    parts.insert(0, include.join("tatu.h"));
    parts
}

/// Returns the text of the headers, concatenated.
pub fn header_text(include: &Path) -> String {
    headers(include).iter().map(|p| fs::read_to_string(p).unwrap()).collect()
}

/// Writes the headers to another folder, each changed by `change`.
pub fn changed_headers(to: &Path, change: impl Fn(String) -> String) {
    let include = root().join("plugin-api/include");
    fs::create_dir_all(to.join("tatu")).unwrap();
    for file in headers(&include) {
        let text = change(fs::read_to_string(&file).unwrap());
        fs::write(to.join(file.strip_prefix(&include).unwrap()), text).unwrap();
    }
}
