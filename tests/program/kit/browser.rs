//! Controls a real browser by the part of the Chrome DevTools Protocol that tests of the page need.

use std::{
    io::{BufRead, BufReader, Read},
    net::TcpStream,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, stream::MaybeTlsStream};

/// A page in a headless browser.
pub struct BrowserPage {
    process: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    number: u64,
    /// Errors that the page has reported.
    pub wrong: Vec<String>,
    _folder: tempfile::TempDir,
}

/// Returns the path of this machine's browser.
pub fn browser() -> PathBuf {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path).flat_map(|d| names.map(|n| d.join(n))).find(|p| p.is_file());
    found.expect("Chromium was found when the tests were built, but is missing now")
}

fn wait<T>(what: &str, f: impl FnMut() -> Option<T>) -> T {
    wait_for(what, Duration::from_secs(60), f)
}

/// Polls `f` until it returns a result; panics after `limit`.
pub fn wait_for<T>(what: &str, limit: Duration, mut f: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = f() {
            return found;
        }
        assert!(begin.elapsed() < limit, "{what}: no result within {limit:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Returns the body of an HTTP answer with a stated length; the browser keeps the connection open after it.
fn body_of_answer(stream: TcpStream) -> Option<Vec<u8>> {
    let mut reader = BufReader::new(stream);
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).ok()?;
        match line.trim_end().split_once(':') {
            Some((name, value)) if name.eq_ignore_ascii_case("content-length") => length = value.trim().parse().ok()?,
            None if line.trim_end().is_empty() => break,
            _ => {}
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    Some(body)
}

impl BrowserPage {
    /// Opens an address.
    pub fn open(browser: &Path, url: &str) -> BrowserPage {
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
            stream.set_read_timeout(Some(Duration::from_secs(10))).ok()?;
            let all: Value = serde_json::from_slice(&body_of_answer(stream)?).ok()?;
            let page = all.as_array()?.iter().find(|t| t["type"] == "page")?.clone();
            Some(page["webSocketDebuggerUrl"].as_str()?.to_owned())
        });
        let (socket, _) = tungstenite::connect(&target).unwrap();
        let mut page = BrowserPage { process, socket, number: 0, wrong: Vec::new(), _folder: folder };
        page.send("Runtime.enable", json!({}));
        page.send("Log.enable", json!({}));
        page.send("Page.navigate", json!({ "url": url }));
        page
    }

    /// Calls a method of the browser's protocol and returns its result.
    pub fn send(&mut self, method: &str, params: Value) -> Value {
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

    /// Evaluates a JavaScript expression and returns its value; waits if the value is a promise.
    pub fn js(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let result = self.send("Runtime.evaluate", params);
        assert!(result.get("exceptionDetails").is_none(), "{expression}: {result}");
        result["result"]["value"].clone()
    }

    /// Returns the text of the element that `selector` matches.
    pub fn text(&mut self, selector: &str) -> String {
        self.js(&format!("document.querySelector({selector:?})?.textContent ?? ''")).as_str().unwrap_or("").to_owned()
    }

    /// Calls the `click` method of an element.
    pub fn click(&mut self, selector: &str) {
        self.js(&format!("document.querySelector({selector:?}).click()"));
    }

    /// Returns the centre of an element, in CSS pixels, once it has stayed there from one frame to the next, since a
    /// click at an element that is about to move would miss it.
    pub fn middle(&mut self, selector: &str) -> [f64; 2] {
        let found = self.js(&format!(
            "(async () => {{ \
             const e = document.querySelector({selector:?}); e.scrollIntoView({{ block: 'nearest' }}); \
             const at = () => {{ const b = e.getBoundingClientRect(); \
                                return [b.left + b.width / 2, b.top + b.height / 2]; }}; \
             for (let now = at(), frames = 0; ; frames++) {{ \
                 await new Promise((done) => requestAnimationFrame(() => setTimeout(done))); \
                 const next = at(); \
                 if (`${{now}}` === `${{next}}` || frames === 30) return next; \
                 now = next; \
             }} }})()"
        ));
        [0, 1].map(|i| found[i].as_f64().unwrap_or_else(|| panic!("{selector}: {found}")))
    }

    /// Moves, presses or releases the mouse: `mouseMoved`, `mousePressed` or `mouseReleased`.
    pub fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], clicks: u32, shift: bool) {
        let buttons = u32::from(kind != "mouseReleased" && clicks > 0);
        let button = if clicks > 0 { "left" } else { "none" };
        let params = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": clicks,
            "modifiers": if shift { 8 } else { 0 },
        });
        self.send("Input.dispatchMouseEvent", params);
    }

    /// Clicks at a position with the mouse, `clicks` times in a row.
    pub fn click_at(&mut self, at: [f64; 2], clicks: u32) {
        self.mouse("mouseMoved", at, 0, false);
        for n in 1..=clicks {
            self.mouse("mousePressed", at, n, false);
            self.mouse("mouseReleased", at, n, false);
        }
    }

    /// Clicks the centre of an element with the mouse.
    pub fn click_on(&mut self, selector: &str) {
        let at = self.middle(selector);
        self.click_at(at, 1);
    }

    /// Presses the mouse button at a position and moves the mouse to another one, in steps; the button stays pressed.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2], shift: bool) {
        const STEPS: u32 = 12;
        self.mouse("mouseMoved", from, 0, shift);
        self.mouse("mousePressed", from, 1, shift);
        for i in 1..=STEPS {
            let part = f64::from(i) / f64::from(STEPS);
            let at = [0, 1].map(|k| from[k] + part * (to[k] - from[k]));
            self.mouse("mouseMoved", at, 1, shift);
        }
    }

    /// Enters text into the focused element.
    pub fn enter(&mut self, text: &str) {
        self.send("Input.insertText", json!({ "text": text }));
    }

    /// Presses or releases a key. `modifiers` is the sum of 2 for Ctrl and 8 for Shift.
    pub fn key_event(&mut self, kind: &str, key: &str, code: u32, modifiers: u32) {
        let params =
            json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code, "modifiers": modifiers });
        self.send("Input.dispatchKeyEvent", params);
    }

    /// Presses and releases a key.
    pub fn key(&mut self, key: &str, code: u32) {
        for kind in ["keyDown", "keyUp"] {
            self.key_event(kind, key, code, 0);
        }
    }

    /// Presses Enter. The event includes the text of the key, without which buttons do not react.
    pub fn press_enter(&mut self) {
        let key = json!({ "key": "Enter", "code": "Enter", "windowsVirtualKeyCode": 13, "text": "\r" });
        for kind in ["keyDown", "keyUp"] {
            let mut params = key.clone();
            params["type"] = kind.into();
            self.send("Input.dispatchKeyEvent", params);
        }
    }

    /// Selects files in a file input.
    pub fn choose_files(&mut self, selector: &str, files: &[PathBuf]) {
        let found =
            self.send("Runtime.evaluate", json!({ "expression": format!("document.querySelector({selector:?})") }));
        let field = found["result"]["objectId"].clone();
        self.send("DOM.setFileInputFiles", json!({ "objectId": field, "files": files }));
    }

    /// Drops files or folders on the page.
    pub fn drop_files(&mut self, [x, y]: [f64; 2], files: &[PathBuf]) {
        let data = json!({ "items": [], "files": files, "dragOperationsMask": 1 });
        for kind in ["dragEnter", "dragOver", "drop"] {
            self.send("Input.dispatchDragEvent", json!({ "type": kind, "x": x, "y": y, "data": data }));
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
        const LIMIT: Duration = Duration::from_secs(90);
        let begin = Instant::now();
        while self.js(expression) != json!(true) {
            if begin.elapsed() > LIMIT {
                let output = self.js("document.getElementById('output')?.textContent ?? null");
                panic!("{expression}: not true within {LIMIT:?}; the page has said: {output}");
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for BrowserPage {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
