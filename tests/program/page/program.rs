//! Helpers that start the program with its page, and that connect clients of the page's protocol.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process::{Child, Command, Stdio},
    time::Duration,
};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, stream::MaybeTlsStream};

/// A client's WebSocket connection.
pub type PageSocket = WebSocket<MaybeTlsStream<TcpStream>>;

/// The folder for the user's state, used in place of that of the user who runs the tests.
pub const STATE: &str = env!("CARGO_TARGET_TMPDIR");

/// The program with its page, which is killed when this value is dropped.
pub struct PageServer {
    pub process: Child,
    /// The address of the page, as printed by the program.
    pub url: String,
}

impl PageServer {
    /// Starts the program in a folder.
    pub fn new(dir: &Path, args: &[&str]) -> PageServer {
        PageServer::with_state(dir, args, Path::new(STATE))
    }
    /// Starts the program with a folder for the user's state.
    pub fn with_state(dir: &Path, args: &[&str], state: &Path) -> PageServer {
        let process = Command::new(env!("CARGO_BIN_EXE_tatu"))
            .current_dir(dir)
            .args(args)
            .env_remove("TATU_PLUGIN_PATH")
            .env("XDG_STATE_HOME", state)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        PageServer::of(process)
    }
    /// Takes ownership of a started program, which prints its address.
    pub fn of(mut process: Child) -> PageServer {
        let mut url = String::new();
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut url).unwrap();
        PageServer { process, url: url.trim().to_owned() }
    }
    /// Returns the address as 127.0.0.1:PORT.
    pub fn host(&self) -> &str {
        self.url.trim_start_matches("http://").split('/').next().unwrap()
    }
    /// Returns the token that grants control.
    pub fn token(&self) -> &str {
        self.url.split("token=").nth(1).unwrap()
    }
    /// Sends an HTTP request with the given head, and returns the answer.
    pub fn ask(&self, head: &str) -> String {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        let mut out = Vec::new();
        let _ = stream.read_to_end(&mut out);
        String::from_utf8_lossy(&out).into_owned()
    }
    /// Connects a client.
    pub fn socket(&self) -> PageSocket {
        tungstenite::connect(format!("ws://{}/ws?token={}", self.host(), self.token())).unwrap().0
    }
}

impl Drop for PageServer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Returns the next message of a type.
pub fn next(socket: &mut PageSocket, kind: &str) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["type"] == kind {
                return message;
            }
        }
    }
}

/// Sends a message.
pub fn send_message(socket: &mut PageSocket, message: Value) {
    socket.send(Message::text(message.to_string())).unwrap();
}

/// Calls a command; returns the answer.
pub fn call(socket: &mut PageSocket, name: &str, args: Value) -> Value {
    // Answers arrive in the order of the calls, so all calls can have the same id.
    send_message(socket, json!({ "type": "call", "id": 1, "name": name, "args": args }));
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["of"] == 1 {
                return message;
            }
        }
    }
}

/// The path of a scene with a Pioneer.
pub const ROBOT: &str = "scenes/first/pioneer_avoids_walls.toml";
