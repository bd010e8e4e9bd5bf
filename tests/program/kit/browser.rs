//! Drives a real browser over its own protocol, as far as tests of the page need it.

use std::{
    net::TcpStream,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, stream::MaybeTlsStream};

/// A page in a headless browser.
pub struct Page {
    process: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    number: u64,
    /// Errors of the page.
    pub wrong: Vec<String>,
    _folder: tempfile::TempDir,
}

/// Returns the browser of this machine.
pub fn browser() -> PathBuf {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path).flat_map(|d| names.map(|n| d.join(n))).find(|p| p.is_file());
    found.expect("Chromium, which was there when the tests were built")
}

fn wait<T>(what: &str, f: impl FnMut() -> Option<T>) -> T {
    wait_for(what, Duration::from_secs(60), f)
}

/// Polls until there is a result.
pub fn wait_for<T>(what: &str, limit: Duration, mut f: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = f() {
            return found;
        }
        assert!(begin.elapsed() < limit, "{what}: not within {limit:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

impl Page {
    /// Opens an address.
    pub fn open(browser: &Path, url: &str) -> Page {
        let folder = tempfile::tempdir().unwrap();
        let process = Command::new(browser)
            .args(["--headless=new", "--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"])
            .args(["--remote-debugging-port=0", "--remote-allow-origins=*", "--window-size=1366,768", "about:blank"])
            .arg(format!("--user-data-dir={}", folder.path().display()))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let file = folder.path().join("DevToolsActivePort");
        let port: u16 =
            wait("the browser's port", || std::fs::read_to_string(&file).ok()?.lines().next()?.parse().ok());
        let target = wait("the browser's page", || {
            let mut stream = TcpStream::connect(("127.0.0.1", port)).ok()?;
            let request = format!("GET /json HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n");
            std::io::Write::write_all(&mut stream, request.as_bytes()).ok()?;
            // The browser keeps the connection open; its answer arrives quickly.
            stream.set_read_timeout(Some(Duration::from_millis(500))).ok()?;
            let mut bytes = Vec::new();
            let _ = std::io::Read::read_to_end(&mut stream, &mut bytes);
            let text = String::from_utf8_lossy(&bytes);
            let all: Value = serde_json::from_str(&text[text.find("\r\n\r\n")? + 4..]).ok()?;
            let page = all.as_array()?.iter().find(|t| t["type"] == "page")?.clone();
            Some(page["webSocketDebuggerUrl"].as_str()?.to_owned())
        });
        let (socket, _) = tungstenite::connect(&target).unwrap();
        let mut page = Page { process, socket, number: 0, wrong: Vec::new(), _folder: folder };
        page.send("Runtime.enable", json!({}));
        page.send("Log.enable", json!({}));
        page.send("Page.navigate", json!({ "url": url }));
        page
    }

    fn send(&mut self, method: &str, params: Value) -> Value {
        self.number += 1;
        let number = self.number;
        let text = json!({ "id": number, "method": method, "params": params }).to_string();
        self.socket.send(Message::text(text)).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["id"] == number {
                return message["result"].clone();
            }
            if matches!(message["method"].as_str(), Some("Runtime.exceptionThrown" | "Log.entryAdded")) {
                self.wrong.push(message["params"].to_string());
            }
        }
    }

    /// Returns the value of an expression, or of its promise.
    pub fn js(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let result = self.send("Runtime.evaluate", params);
        assert!(result.get("exceptionDetails").is_none(), "{expression}: {result}");
        result["result"]["value"].clone()
    }

    /// Returns a text on the page.
    pub fn text(&mut self, selector: &str) -> String {
        self.js(&format!("document.querySelector({selector:?})?.textContent ?? ''")).as_str().unwrap_or("").to_owned()
    }

    /// Clicks an element of the page.
    pub fn click(&mut self, selector: &str) {
        self.js(&format!("document.querySelector({selector:?}).click()"));
    }

    /// Presses a key.
    pub fn key(&mut self, key: &str, code: u32) {
        for kind in ["keyDown", "keyUp"] {
            let params = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            self.send("Input.dispatchKeyEvent", params);
        }
    }

    /// Takes a screenshot of the page, as PNG.
    pub fn picture(&mut self, [width, height]: [u32; 2]) -> Vec<u8> {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.send("Emulation.setDeviceMetricsOverride", size);
        std::thread::sleep(Duration::from_secs(3));
        let picture = self.send("Page.captureScreenshot", json!({ "format": "png" }));
        STANDARD.decode(picture["data"].as_str().unwrap()).unwrap()
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, expression: &str) {
        wait_for(expression, Duration::from_secs(30), || (self.js(expression) == json!(true)).then_some(()));
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
