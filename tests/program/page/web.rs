//! Tests of the page and its server: from outside, and in a real browser if there is one.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    process::{Child, Command, Stdio},
    time::Duration,
};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, client::IntoClientRequest, stream::MaybeTlsStream};

use crate::{
    kit::browser::{Page, browser, wait_for},
    kit::*,
};

/// The folder for what the program keeps for its user, in place of that of who runs the tests.
const STATE: &str = env!("CARGO_TARGET_TMPDIR");

/// The program with its page; it ends with the test.
pub(super) struct Served {
    pub(super) process: Child,
    pub(super) url: String,
}

impl Served {
    fn new(dir: &std::path::Path, args: &[&str]) -> Served {
        Served::with_state(dir, args, std::path::Path::new(STATE))
    }
    /// Serves with a folder for what is kept from run to run.
    pub(super) fn with_state(dir: &std::path::Path, args: &[&str], state: &std::path::Path) -> Served {
        let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
            .current_dir(dir)
            .args(args)
            .env_remove("TATU_PLUGIN_PATH")
            .env("XDG_STATE_HOME", state)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut url).unwrap();
        Served { process, url: url.trim().to_owned() }
    }
    /// Returns the address as 127.0.0.1:PORT.
    pub(super) fn host(&self) -> &str {
        self.url.trim_start_matches("http://").split('/').next().unwrap()
    }
    pub(super) fn token(&self) -> &str {
        self.url.split("token=").nth(1).unwrap()
    }
    /// Returns the answer to a request.
    pub(super) fn ask(&self, head: &str) -> String {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        let mut out = Vec::new();
        let _ = stream.read_to_end(&mut out);
        String::from_utf8_lossy(&out).into_owned()
    }
    pub(super) fn socket(&self) -> WebSocket<MaybeTlsStream<TcpStream>> {
        tungstenite::connect(format!("ws://{}/ws?token={}", self.host(), self.token())).unwrap().0
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Returns the next JSON message that has a key.
pub(super) fn next(socket: &mut WebSocket<MaybeTlsStream<TcpStream>>, key: &str) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let message: Value = serde_json::from_str(&text).unwrap();
            if message.get(key).is_some() {
                return message;
            }
        }
    }
}

const ROBOT: &str = "scenes/first/pioneer_avoids_walls.toml";

#[test]
fn only_who_has_the_token_and_comes_from_here_is_let_in() {
    let served = Served::new(root(), &["open", ROBOT, "--no-browser"]);
    let host = served.host();
    let get = |path: &str, more: &str| served.ask(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n"));
    let page = get("/", "");
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("Content-Security-Policy: default-src 'none'"), "{page}");
    assert!(page.contains("Referrer-Policy: no-referrer") && !page.contains(served.token()));
    assert!(served.ask("GET / HTTP/1.1\r\nHost: elsewhere.org\r\n\r\n").starts_with("HTTP/1.1 421"));
    assert!(get("/../Cargo.toml", "").starts_with("HTTP/1.1 404"));
    let upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    assert!(get("/ws", upgrade).starts_with("HTTP/1.1 401"));
    assert!(get("/ws?token=0123456789abcdef0123456789abcdef", upgrade).starts_with("HTTP/1.1 401"));
    let good = format!("/ws?token={}", served.token());
    assert!(get(&good, &format!("{upgrade}Origin: http://elsewhere.org\r\n")).starts_with("HTTP/1.1 403"));
    assert!(get(&good, "").starts_with("HTTP/1.1 426"));
    let mut request = format!("ws://{host}{good}").into_client_request().unwrap();
    request.headers_mut().insert("Origin", format!("http://{host}").parse().unwrap());
    assert_eq!(tungstenite::connect(request).unwrap().1.status(), 101);
    // Invalid bytes, an incomplete head, and a message that is too large only affect their sender.
    for bytes in [&b"\x00\xFF\x01\x02\r\n\r\n"[..], b"GET / HTT"] {
        let mut stream = TcpStream::connect(host).unwrap();
        stream.write_all(bytes).unwrap();
    }
    let mut large = served.socket();
    let _ = large.send(Message::text("x".repeat(8 << 20)));
    let mut socket = served.socket();
    socket.send(Message::text("no JSON")).unwrap();
    assert!(next(&mut socket, "error")["error"].as_str().unwrap().contains("an unknown request"));
}

#[test]
fn who_may_look_cannot_act() {
    let served = Served::new(root(), &["open", ROBOT, "--no-browser"]);
    let mut socket = served.socket();
    let look = next(&mut socket, "hello")["hello"]["look"].as_str().unwrap().to_owned();
    let token = look.split("token=").nth(1).unwrap();
    let mut eye = tungstenite::connect(format!("ws://{}/ws?token={token}", served.host())).unwrap().0;
    assert_eq!(next(&mut eye, "hello")["hello"]["acts"], false);
    eye.send(Message::text(json!({ "do": "start" }).to_string())).unwrap();
    assert!(next(&mut eye, "error")["error"].as_str().unwrap().contains("may only view"));
    eye.send(Message::text(json!({ "details": 1 }).to_string())).unwrap();
    assert!(next(&mut eye, "details")["rows"].as_array().unwrap().len() > 10);
}

#[test]
fn short_readings_of_any_sensor_are_listed_with_its_properties() {
    let sensor = |kind: &str, keys: &str| {
        format!("[[object]]\nkind = \"sensor\"\nalias = \"{kind}\"\nsensor = \"{kind}\"\n{keys}\n")
    };
    let battery = sensor("battery", "idle_current_a = 1.5");
    let spots = sensor("floor", "count = 17");
    let place =
        Place::scene(&format!("{battery}{}{spots}", sensor("compass", "strength_t = 0.5\ninclination_deg = 0.0")));
    let served = Served::new(place.path(), &["open", "scene.toml", "--no-browser"]);
    let mut socket = served.socket();
    let objects = next(&mut socket, "scene")["scene"]["objects"].clone();
    let handle = |alias: &str| objects.as_array().unwrap().iter().find(|o| o["alias"] == alias).unwrap()["id"].clone();
    let (battery, compass, spots) = (handle("battery"), handle("compass"), handle("floor"));
    for what in ["start", "pause"] {
        socket.send(Message::text(json!({ "do": what }).to_string())).unwrap();
    }
    let mut listed = |id: &Value, key: &str| {
        socket.send(Message::text(json!({ "details": id }).to_string())).unwrap();
        let rows = next(&mut socket, "details")["rows"].clone();
        rows.as_array().unwrap().iter().find(|r| r["key"] == key).map(|r| r["value"].clone())
    };
    wait_for("a reading", Duration::from_secs(20), || {
        (listed(&battery, "battery.current") == Some(json!([1.5]))).then_some(())
    });
    let field = listed(&compass, "magnetic_field.field").unwrap();
    assert!((field[1].as_f64().unwrap() - 0.5).abs() < 1e-9, "{field}");
    assert_eq!(listed(&spots, "reflectance.value"), None, "17 numbers are too many");
}

/// Viewers that flood the server with requests do not delay clients with control rights, and get no more than their
/// share.
#[test]
fn viewers_who_flood_wait_for_those_who_act() {
    let served = Served::new(root(), &["open", ROBOT, "--no-browser"]);
    let mut socket = served.socket();
    let look = next(&mut socket, "hello")["hello"]["look"].as_str().unwrap().to_owned();
    let token = look.split("token=").nth(1).unwrap();
    let mut viewers: Vec<_> =
        (0..3).map(|_| tungstenite::connect(format!("ws://{}/ws?token={token}", served.host())).unwrap().0).collect();
    for viewer in &mut viewers {
        for i in 0..600 {
            let what = ["commands", "files"][i % 2];
            viewer.send(Message::text(json!({ what: true }).to_string())).unwrap();
        }
    }
    socket.send(Message::text(json!({ "call": "sim.getSimulationTime", "args": [], "id": 7 }).to_string())).unwrap();
    assert_eq!(next(&mut socket, "result")["of"], 7);
    for viewer in &mut viewers {
        if let MaybeTlsStream::Plain(stream) = viewer.get_mut() {
            stream.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
        }
        // Count what arrives within four seconds.
        let (mut lists, end) = (0, std::time::Instant::now() + Duration::from_secs(4));
        while std::time::Instant::now() < end {
            let Ok(message) = viewer.read() else { continue };
            let text = message.to_text().unwrap_or_default();
            lists += usize::from(text.starts_with("{\"commands\"") || text.starts_with("{\"files\""));
        }
        // All 600 would take five minutes.
        assert!((1..200).contains(&lists), "{lists}");
    }
}

/// Files below `scenes` that are not regular neither block the page nor appear in its gallery.
#[cfg(unix)]
#[test]
fn the_gallery_has_plain_files_only() {
    let place = Place::new();
    let text = "# A ball\nformat = 1\n";
    place.write("scenes/good.toml", text).write("scenes/folder.toml/inner.toml", text).write("scenes/other.toml", text);
    let at = |name: &str| place.path().join("scenes").join(name);
    succeed(Command::new("mkfifo").args([at("pipe.toml"), at("pipe.ttt"), at("good.png")]));
    std::os::unix::fs::symlink("/dev/zero", at("zero.toml")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", at("other.png")).unwrap();
    let _socket = std::os::unix::net::UnixListener::bind(at("socket.toml")).unwrap();
    let served = Served::new(place.path(), &["open", "--no-browser"]);
    let mut socket = served.socket();
    socket.send(Message::text(json!({ "files": true }).to_string())).unwrap();
    let mut files = next(&mut socket, "files")["files"].as_array().unwrap().clone();
    files.retain(|f| f["in"] == "own");
    let names: Vec<_> = files.iter().map(|f| f["file"].as_str().unwrap()).collect();
    assert_eq!(names, ["scenes/good.toml", "scenes/other.toml", "scenes/folder.toml/inner.toml"]);
    assert!(files.iter().all(|f| f["about"] == "A ball" && f["picture"].is_null()), "{files:?}");
}

/// No program gets the token as an argument: a browser is started with a file that only its owner can read, and that is
/// removed once the page has connected.
#[cfg(unix)]
#[test]
fn a_browser_is_started_without_the_token() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    place.write("bin/xdg-open", "#!/bin/sh\nprintf '%s\\n' \"$@\" > opened.part\nmv opened.part opened\n");
    place.write("run/.keep", "");
    let mode = |file: &std::path::Path, bits| std::fs::set_permissions(file, PermissionsExt::from_mode(bits)).unwrap();
    mode(&place.path().join("bin/xdg-open"), 0o755);
    let path = format!("{}:{}", place.path().join("bin").display(), std::env::var("PATH").unwrap());
    let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(place.path())
        .args(["open"])
        .env("PATH", path)
        .env("XDG_STATE_HOME", STATE)
        .env("XDG_RUNTIME_DIR", place.path().join("run"))
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut url = String::new();
    BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut url).unwrap();
    let served = Served { process, url: url.trim().to_owned() };
    let opened =
        wait_for("xdg-open", Duration::from_secs(60), || std::fs::read_to_string(place.path().join("opened")).ok());
    assert!(!opened.contains(served.token()), "{opened}");
    let file = std::path::PathBuf::from(opened.trim());
    assert!(file.starts_with(place.path().join("run")), "{opened}");
    let bits = |path: &std::path::Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!((bits(&file), bits(file.parent().unwrap())), (0o600, 0o700));
    assert!(std::fs::read_to_string(&file).unwrap().contains(&format!("url={}\"", served.url)));
    let _socket = served.socket();
    wait_for("the file goes", Duration::from_secs(60), || (!file.parent().unwrap().exists()).then_some(()));
}

#[test]
fn viewers_change_nothing() {
    let run = |viewers: usize| {
        let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
            .current_dir(root())
            .args(["run", ROBOT, "--steps", "400", "--service", "web:speed=0"])
            .env("XDG_STATE_HOME", STATE)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut url).unwrap();
        let address = url.trim().replace("http", "ws").replace("/?", "/ws?");
        let sockets: Vec<_> = (0..viewers).filter_map(|_| tungstenite::connect(&address).ok()).collect();
        let out = process.wait_with_output().unwrap();
        drop(sockets);
        let text = String::from_utf8_lossy(&out.stderr).into_owned();
        text.split("hash ").nth(1).unwrap_or_else(|| panic!("{text}"))[..16].to_owned()
    };
    let alone = run(0);
    assert_eq!(alone, run(1));
    assert_eq!(alone, run(20));
}

#[test]
fn a_scene_is_opened_started_changed_and_reset() {
    let served = Served::new(root(), &["open", "--no-browser"]);
    let mut socket = served.socket();
    assert_eq!(next(&mut socket, "scene")["scene"]["objects"], json!([]));
    let call = |socket: &mut WebSocket<_>, name: &str, args: Value| {
        socket.send(Message::text(json!({ "call": name, "args": args, "id": name }).to_string())).unwrap();
        loop {
            let message = next(socket, "of");
            if message["of"] == name {
                return message;
            }
        }
    };
    let gone = call(&mut socket, "tatu.open", json!(["scenes/nothing.toml"]));
    assert!(gone["error"].is_string(), "{gone}");
    socket.send(Message::text(json!({ "call": "tatu.open", "args": [ROBOT] }).to_string())).unwrap();
    let scene = next(&mut socket, "scene")["scene"].clone();
    let objects = scene["objects"].as_array().unwrap();
    let robot = objects.iter().find(|o| o["alias"] == "Pioneer_p3dx").unwrap_or_else(|| panic!("{scene}"));
    let (id, script) = (robot["id"].clone(), robot["scripts"][0]["id"].clone());
    let begin = robot["pose"][0].as_f64().unwrap();
    let text = call(&mut socket, "tatu.getScript", json!([script]))["result"][0].clone();
    let broken = call(&mut socket, "tatu.setScript", json!([script, "x = = 1"]));
    assert!(broken["error"].as_str().unwrap().contains("cannot be loaded"), "{broken}");
    assert_eq!(call(&mut socket, "tatu.getScript", json!([script]))["result"][0], text);
    let place = |socket: &mut WebSocket<_>| {
        call(socket, "tatu.get", json!([id, "object.position"]))["result"][0][0].as_f64().unwrap()
    };
    socket.send(Message::text(json!({ "speed": 10 }).to_string())).unwrap();
    socket.send(Message::text(json!({ "do": "start" }).to_string())).unwrap();
    wait_for("the robot drives", Duration::from_secs(30), || ((place(&mut socket) - begin).abs() > 0.1).then_some(()));
    socket.send(Message::text(json!({ "do": "stop" }).to_string())).unwrap();
    wait_for("it is reset", Duration::from_secs(30), || ((place(&mut socket) - begin).abs() < 1e-9).then_some(()));
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_student_drives_and_changes_a_robot() {
    let browser = browser();
    let served = Served::new(root(), &["open", "scenes/course/manta_keyboard_statusbar.toml", "--no-browser"]);
    let mut page = Page::open(&browser, &served.url);
    page.until("document.querySelectorAll('#tree .item').length > 5");
    page.click("#play");
    page.until("document.getElementById('play').className === 'on'");
    page.js("document.getElementById('view').focus()");
    page.key("ArrowLeft", 37);
    page.until("document.getElementById('output').textContent.includes('key 2009')");
    page.click("#pause");
    page.until("document.getElementById('pause').className === 'on'");
    let stood = page.text("#time");
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(page.text("#time"), stood);
    page.click("#step");
    page.until(&format!("document.getElementById('time').textContent !== {stood:?}"));
    page.click("#stop");
    page.until("document.getElementById('stop').className === 'on'");
    // Another scene: its script is opened, a number is changed, and the wheels turn more slowly.
    page.js(&format!("import('tatu/net').then((m) => m.call('tatu.open', {ROBOT:?}))"));
    page.until("document.getElementById('name').textContent === 'pioneer_avoids_walls.toml'");
    // Arrow keys drive the selected robot while they are held.
    page.js("(async () => { const store = await import('tatu/store'); \
         store.select([...store.scene.objects.values()].find((o) => o.alias.endsWith('leftWheel')).id); })()");
    let press = |kind: &str| {
        format!(
            "document.getElementById('view').dispatchEvent(new KeyboardEvent('{kind}', \
             {{ key: 'ArrowUp', bubbles: true, cancelable: true }}))"
        )
    };
    let speed = "(async () => { const [net, store] = [await import('tatu/net'), await import('tatu/store')]; \
        const j = [...store.scene.objects.values()].find((o) => o.alias.endsWith('leftMotor')); \
        return (await net.call('tatu.get', j.id, 'joint.target_velocity'))[0]; })()";
    page.until(&format!("{}, {speed}.then((v) => v === 4)", press("keydown")));
    page.js(&press("keyup"));
    page.until(&format!("{speed}.then((v) => v === 0)"));
    page.click("#tree .tool");
    page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('cruise = 3.0')");
    page.click("#play");
    page.until(&format!("{speed}.then((v) => v > 2)"));
    page.js("(async () => { const { EditorView } = await import('@codemirror/view'); \
         const v = EditorView.findFromDOM(document.querySelector('.cm-editor')); \
         const at = v.state.doc.toString().indexOf('cruise = 3.0') + 9; \
         v.dispatch({ changes: { from: at, to: at + 3, insert: '1.0' } }); \
         document.getElementById('script-save').click(); })()");
    page.until(&format!("{speed}.then((v) => v <= 1)"));
    // A window of a script: moving its slider calls the script, which changes a label.
    page.js("import('tatu/net').then((m) => m.call('tatu.open', 'plugins/commands/simui/demo.toml'))");
    page.until("document.getElementById('name').textContent === 'demo.toml'");
    page.click("#play");
    page.until("document.querySelector('.window .title')?.textContent.startsWith('Pioneer')");
    page.js("(() => { const s = document.querySelector('.window input[type=range]'); s.value = 35; s.oninput(); })()");
    page.until("document.querySelector('.window')?.textContent.includes('3.5 rad/s')");
    page.until(&format!("{speed}.then((v) => v === 3.5)"));
    // Screen readers get a name for each control.
    assert_eq!(
        page.js(
            "[...document.querySelectorAll('button, input, select, [tabindex]')].filter((e) => !e.closest('[hidden]') && \
             !(e.ariaLabel || e.title || e.textContent.trim() || e.placeholder || e.labels?.[0]?.textContent.trim())).length",
        ),
        0
    );
    // The view shows more than its background.
    page.until(
        "(() => { const c = document.querySelector('#view canvas'); const p = document.createElement('canvas'); \
         p.width = c.width; p.height = c.height; const x = p.getContext('2d'); x.drawImage(c, 0, 0); \
         const d = x.getImageData(0, 0, p.width, p.height).data; const s = new Set(); \
         for (let i = 0; i < d.length; i += 4000) s.add(`${d[i]},${d[i + 1]},${d[i + 2]}`); return s.size > 8; })()",
    );
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}

#[test]
fn what_was_done_in_the_page_is_repeated_from_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("session.jsonl").display().to_string();
    let hash = |text: &str| text.split("hash ").nth(1).unwrap_or_else(|| panic!("{text}"))[..16].to_owned();
    let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(root())
        .args(["run", ROBOT, "--service", "web:speed=5", "--log", &log])
        .env("XDG_STATE_HOME", STATE)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut url = String::new();
    BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut url).unwrap();
    let (mut socket, _) = tungstenite::connect(url.trim().replace("http", "ws").replace("/?", "/ws?")).unwrap();
    let scene = next(&mut socket, "scene")["scene"].clone();
    let of = |alias: &str| scene["objects"].as_array().unwrap().iter().find(|o| o["alias"] == alias).unwrap().clone();
    let script = of("Pioneer_p3dx")["scripts"][0]["id"].clone();
    let mut say = |message: Value| socket.send(Message::text(message.to_string())).unwrap();
    let pause = || std::thread::sleep(Duration::from_millis(150));
    say(json!({ "script": script }));
    let text = next(&mut socket, "text")["text"].as_str().unwrap().replace("cruise = 3.0", "cruise = 1.5");
    let mut say = |message: Value| socket.send(Message::text(message.to_string())).unwrap();
    pause();
    say(json!({ "call": "tatu.setScript", "args": [script, text], "id": 1 }));
    pause();
    say(json!({ "key": "up" }));
    say(json!({ "call": "tatu.set", "args": [of("barrel")["id"], "object.position", [0.5, -0.5, 0.4]], "id": 2 }));
    say(json!({ "do": "pause" }));
    pause();
    say(json!({ "do": "start" }));
    pause();
    say(json!({ "do": "quit" }));
    let out = process.wait_with_output().unwrap();
    let live = String::from_utf8_lossy(&out.stderr).into_owned();
    drop(socket);
    let again =
        Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(root()).args(["run", "--replay", &log]).output().unwrap();
    let again = String::from_utf8_lossy(&again.stderr).into_owned();
    assert_eq!(hash(&live), hash(&again), "{live}\n{again}");
    assert!(!live.contains(" 0 steps") && live.contains("steps"), "{live}");
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_film_shows_any_time_of_a_run() {
    let browser = browser();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (film, trace) = (at("film.html"), at("trace.jsonl"));
    let run = |more: &[&str]| {
        let args = [&["run", ROBOT, "--seconds", "20"], more].concat();
        let out = Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(root()).args(args).output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.success(), "{text}");
        text.split("hash ").nth(1).unwrap()[..16].to_owned()
    };
    // Recording changes nothing.
    assert_eq!(run(&["--html", &film]), run(&["--trace", &trace, "--watch", "/Pioneer_p3dx"]));
    assert!(std::fs::metadata(&film).unwrap().len() < 5 << 20);
    let mut page = Page::open(&browser, &format!("file://{film}#3"));
    page.until("(document.getElementById('time')?.textContent ?? '').startsWith('3.00 of 20')");
    let lines: Vec<Value> = std::fs::read_to_string(&trace)
        .unwrap()
        .lines()
        .filter_map(|l| serde_json::from_str(l).ok())
        .filter(|l: &Value| l["objects"].is_object())
        .collect();
    for time in [12.5, 0.05, 19.95, 7.0] {
        page.js(&format!(
            "(() => {{ const s = document.getElementById('slider'); s.value = {time}; s.oninput(); }})()"
        ));
        let seen = page.js(
            "Promise.all([import('tatu/objects'), import('tatu/store')]).then(([o, s]) => \
             o.groups.get([...s.scene.objects.values()].find((x) => x.alias === 'Pioneer_p3dx').id).position.toArray())",
        );
        let then = lines.iter().find(|l| (l["time"].as_f64().unwrap_or(0.0) - time).abs() < 1e-6).unwrap();
        assert_eq!(seen, then["objects"]["/Pioneer_p3dx"]["position"], "{time}");
    }
    page.click("#tree .tool");
    page.until("document.getElementById('editor').textContent.includes('cruise = 3.0')");
    page.click("#play");
    page.until("Number(document.getElementById('slider').value) > 8");
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_for_the_guide() {
    let served = Served::new(root(), &["open", "scenes/first/pioneer_looks_around.toml", "--no-browser"]);
    let mut page = Page::open(&browser(), &format!("{}#select=eye&script&play", served.url));
    page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('cruise')");
    std::fs::write(root().join("docs/images/page.png"), page.picture([1180, 680])).unwrap();
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_of_a_window() {
    let served = Served::new(root(), &["open", "plugins/commands/simui/demo.toml", "--no-browser"]);
    let mut page = Page::open(&browser(), &format!("{}#select=Pioneer_p3dx&play", served.url));
    page.until("(document.getElementById('time')?.textContent ?? '').includes(':06.')");
    page.click("#pause");
    page.click("#fit");
    // The robot is next to the window, not behind it.
    page.js("import('tatu/view').then((v) => { v.camera.setViewOffset(100, 100, -26, 0, 100, 100); v.redraw(); })");
    std::fs::write(root().join("docs/images/window.png"), page.picture([1180, 620])).unwrap();
}
