//! Tests of access control: which clients may connect, and what each client may do.

use std::{
    io::Write,
    net::TcpStream,
    process::{Command, Stdio},
    time::Duration,
};

use serde_json::json;
use tungstenite::{Message, client::IntoClientRequest, stream::MaybeTlsStream};

use super::program::{PageServer, ROBOT, STATE, next};
use crate::{kit::browser::wait_for, kit::*};

#[test]
fn only_local_clients_with_the_token_are_admitted() {
    let served = PageServer::new(root(), &["open", ROBOT, "--no-browser"]);
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
    // Invalid bytes, an incomplete request head, and a message that is too large affect only their sender.
    for bytes in [&b"\x00\xFF\x01\x02\r\n\r\n"[..], b"GET / HTT"] {
        let mut stream = TcpStream::connect(host).unwrap();
        stream.write_all(bytes).unwrap();
    }
    let mut large = served.socket();
    let _ = large.send(Message::text("x".repeat(8 << 20)));
    let mut socket = served.socket();
    socket.send(Message::text("no JSON")).unwrap();
    assert!(next(&mut socket, "error")["error"].as_str().unwrap().contains("expected a JSON object"));
}

#[test]
fn view_only_clients_cannot_act() {
    let served = PageServer::new(root(), &["open", ROBOT, "--no-browser"]);
    let mut socket = served.socket();
    let look = next(&mut socket, "hello")["look"].as_str().unwrap().to_owned();
    let token = look.split("token=").nth(1).unwrap();
    let mut eye = tungstenite::connect(format!("ws://{}/ws?token={token}", served.host())).unwrap().0;
    assert_eq!(next(&mut eye, "hello")["acts"], false);
    eye.send(Message::text(json!({ "type": "run", "action": "start" }).to_string())).unwrap();
    assert!(next(&mut eye, "error")["error"].as_str().unwrap().contains("may only view"));
    eye.send(Message::text(json!({ "type": "details", "object": 1 }).to_string())).unwrap();
    assert!(next(&mut eye, "details")["rows"].as_array().unwrap().len() > 10);
}

/// Viewers that flood the server with requests do not delay clients with control rights, and their requests are
/// rate-limited.
#[test]
fn flooding_viewers_are_rate_limited_and_do_not_delay_others() {
    let served = PageServer::new(root(), &["open", ROBOT, "--no-browser"]);
    let mut socket = served.socket();
    let look = next(&mut socket, "hello")["look"].as_str().unwrap().to_owned();
    let token = look.split("token=").nth(1).unwrap();
    let mut viewers: Vec<_> =
        (0..3).map(|_| tungstenite::connect(format!("ws://{}/ws?token={token}", served.host())).unwrap().0).collect();
    for viewer in &mut viewers {
        for i in 0..600 {
            let what = ["commands", "files"][i % 2];
            viewer.send(Message::text(json!({ "type": what }).to_string())).unwrap();
        }
    }
    socket
        .send(Message::text(
            json!({ "type": "call", "name": "sim.getSimulationTime", "args": [], "id": 7 }).to_string(),
        ))
        .unwrap();
    assert_eq!(next(&mut socket, "result")["of"], 7);
    for viewer in &mut viewers {
        if let MaybeTlsStream::Plain(stream) = viewer.get_mut() {
            stream.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
        }
        // Counts the answers within four seconds.
        let (mut lists, end) = (0, std::time::Instant::now() + Duration::from_secs(4));
        while std::time::Instant::now() < end {
            let Ok(message) = viewer.read() else { continue };
            let text = message.to_text().unwrap_or_default();
            lists += usize::from(text.starts_with("{\"type\":\"commands\"") || text.starts_with("{\"type\":\"files\""));
        }
        // At the limited rate, all 600 answers would take five minutes.
        assert!((1..200).contains(&lists), "{lists}");
    }
}

/// Pipes and other special files below `scenes` do not block the page, and are not listed in its gallery.
#[cfg(unix)]
#[test]
fn the_gallery_has_plain_files_only() {
    let place = TestFolder::new();
    let text = "# A ball\nformat = 1\n";
    place.write("scenes/good.toml", text).write("scenes/folder.toml/inner.toml", text).write("scenes/other.toml", text);
    let at = |name: &str| place.path().join("scenes").join(name);
    succeed(Command::new("mkfifo").args([at("pipe.toml"), at("pipe.ttt"), at("good.png")]));
    std::os::unix::fs::symlink("/dev/zero", at("zero.toml")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", at("other.png")).unwrap();
    let _socket = std::os::unix::net::UnixListener::bind(at("socket.toml")).unwrap();
    let served = PageServer::new(place.path(), &["open", "--no-browser"]);
    let mut socket = served.socket();
    socket.send(Message::text(json!({ "type": "files" }).to_string())).unwrap();
    let mut files = next(&mut socket, "files")["files"].as_array().unwrap().clone();
    files.retain(|f| f["in"] == "own");
    let names: Vec<_> = files.iter().map(|f| f["file"].as_str().unwrap()).collect();
    assert_eq!(names, ["scenes/good.toml", "scenes/other.toml", "scenes/folder.toml/inner.toml"]);
    assert!(files.iter().all(|f| f["about"] == "A ball" && f["picture"].is_null()), "{files:?}");
}

/// The token is never an argument of a program: the browser is started with a file that only its owner can read, and
/// which is removed once the page has connected.
#[cfg(unix)]
#[test]
fn a_browser_is_started_without_the_token() {
    use std::os::unix::fs::PermissionsExt;
    let place = TestFolder::new();
    place.write("bin/xdg-open", "#!/bin/sh\nprintf '%s\\n' \"$@\" > opened.part\nmv opened.part opened\n");
    place.write("run/.keep", "");
    let mode = |file: &std::path::Path, bits| std::fs::set_permissions(file, PermissionsExt::from_mode(bits)).unwrap();
    mode(&place.path().join("bin/xdg-open"), 0o755);
    let path = format!("{}:{}", place.path().join("bin").display(), std::env::var("PATH").unwrap());
    let process = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(place.path())
        .args(["open"])
        .env("PATH", path)
        .env("XDG_STATE_HOME", STATE)
        .env("XDG_RUNTIME_DIR", place.path().join("run"))
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let served = PageServer::of(process);
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
