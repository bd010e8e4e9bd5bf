//! Helpers for tests of remote services: a program that serves a scene, and the output of its clients.

use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader},
    net::TcpStream,
    path::PathBuf,
    process::{Child, Command, Output, Stdio},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use crate::kit::*;

/// A program that serves a scene through one service; it is killed when this value is dropped.
pub struct ServedScene {
    process: Child,
    /// The port on which the service listens.
    pub port: u16,
    /// What the program has written to standard error since it listens.
    log: Arc<Mutex<String>>,
}

impl ServedScene {
    /// Serves a scene on a free port, which the system chooses.
    pub fn new(service: &str, scene: &str) -> ServedScene {
        Self::with(service, scene, &[])
    }
    /// Serves a scene, or if the name is empty no scene, with additional command-line arguments. Parameters may follow
    /// the service: `jsonl:wait_for=1`.
    pub fn with(service: &str, scene: &str, more: &[&str]) -> ServedScene {
        let (service, parameters) = service.split_once(':').unwrap_or((service, ""));
        let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
            .current_dir(root())
            .arg("serve")
            .args(Some(scene).filter(|scene| !scene.is_empty()))
            .args([
                "--service",
                &format!("{service}:port=0{}{parameters}", if parameters.is_empty() { "" } else { "," }),
            ])
            .args(more)
            .env_remove("TATU_PLUGIN_PATH")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut err = BufReader::new(process.stderr.take().unwrap());
        let port = loop {
            let mut line = String::new();
            assert!(err.read_line(&mut line).unwrap() > 0, "the program exited before it listened");
            if let Some(port) = line.trim().strip_prefix(&format!("{service}: listening on 127.0.0.1:")) {
                break port.parse().unwrap();
            }
        };
        let log = Arc::new(Mutex::new(String::new()));
        let written = log.clone();
        // Reads the rest of standard error, because the program would block if the pipe were full.
        std::thread::spawn(move || {
            let mut line = String::new();
            while err.read_line(&mut line).is_ok_and(|n| n > 0) {
                written.lock().unwrap().push_str(&line);
                line.clear();
            }
        });
        ServedScene { process, port, log }
    }
    /// Returns what the program has written to standard error since it listens.
    pub fn logged(&self) -> String {
        self.log.lock().unwrap().clone()
    }
    /// Sends the program the signal of Ctrl-C, and returns whether it exits within 20 s.
    pub fn interrupt(&mut self) -> bool {
        succeed(Command::new("kill").args(["-INT", &self.process.id().to_string()]));
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(20) {
            if self.process.try_wait().unwrap().is_some() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        false
    }
    /// Returns whether the program is still running.
    pub fn is_there(&mut self) -> bool {
        self.process.try_wait().unwrap().is_none()
    }
    /// Opens a TCP connection to the service.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream
    }
}

impl Drop for ServedScene {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Hint that is printed if a package cannot be installed.
pub const OFFLINE_HINT: &str = "; set TATU_OFFLINE=1 to have the tests that need it ignored";

/// Returns the Python interpreter of a virtual environment that contains packages from PyPI, separated by blanks.
pub fn python(package: &str, module: &str) -> PathBuf {
    static INTERPRETERS: Mutex<BTreeMap<String, PathBuf>> = Mutex::new(BTreeMap::new());
    let mut known = INTERPRETERS.lock().unwrap();
    let found = known.entry(package.to_owned()).or_insert_with(|| {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(package.replace(' ', "_"));
        let program = folder.join("bin/python");
        let has = |program: &PathBuf| {
            let done = Command::new(program).args(["-c", &format!("import {module}")]).output();
            done.is_ok_and(|o| o.status.success())
        };
        if !has(&program) {
            let made = Command::new("python3").args(["-m", "venv"]).arg(&folder).output();
            if made.is_ok_and(|o| o.status.success()) {
                let _ = Command::new(&program).args(["-m", "pip", "install", "-q"]).args(package.split(' ')).output();
            }
        }
        assert!(has(&program), "{package} cannot be installed from PyPI{OFFLINE_HINT}");
        program
    });
    found.clone()
}

/// Checks that a client has succeeded, and returns its standard output.
pub fn good(done: &Output) -> String {
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8_lossy(&done.stdout).into_owned()
}
