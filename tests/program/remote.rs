//! What tests of remote services share: a program that serves a scene, and what its clients tell.

use std::{
    io::{BufRead, BufReader},
    net::TcpStream,
    process::{Child, Command, Output, Stdio},
    time::Duration,
};

use crate::kit::*;

/// A program that serves a scene by one service, which ends with the test.
pub struct Served {
    process: Child,
    /// Where the service listens.
    pub port: u16,
}

impl Served {
    /// Serves a scene; the service chooses its port.
    pub fn new(service: &str, scene: &str) -> Served {
        let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
            .current_dir(root())
            .args(["serve", scene, "--service", &format!("{service}:port=0")])
            .env_remove("TATU_PLUGIN_PATH")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut err = BufReader::new(process.stderr.take().unwrap());
        let port = loop {
            let mut line = String::new();
            assert!(err.read_line(&mut line).unwrap() > 0, "the program ended before it listened");
            if let Some(port) = line.trim().strip_prefix(&format!("{service}: listening on 127.0.0.1:")) {
                break port.parse().unwrap();
            }
        };
        // What it says further on is read, so that it never waits for us.
        std::thread::spawn(move || std::io::copy(&mut err, &mut std::io::sink()));
        Served { process, port }
    }
    /// A connection of bytes.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// What a client printed that did well.
pub fn good(done: &Output) -> String {
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8_lossy(&done.stdout).into_owned()
}
