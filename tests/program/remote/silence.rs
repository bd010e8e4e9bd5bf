//! Tests of clients that control the steps of a simulation and then send nothing: after a time limit, the simulation
//! continues without them.

use std::{
    io::{BufRead, BufReader, Write},
    net::TcpStream,
    time::{Duration, Instant},
};

use serde_json::{Value, json};

use super::legacy_remote::wire::{PacketConnection, ints};
use crate::{kit::served_scene::ServedScene, kit::*};

/// Sends a line, and returns the answer.
fn ask(to: &mut TcpStream, message: &Value) -> Value {
    writeln!(to, "{message}").unwrap();
    let mut line = String::new();
    BufReader::new(to.try_clone().unwrap()).read_line(&mut line).unwrap();
    serde_json::from_str(&line).unwrap()
}

/// Polls the simulation time until it is above `from`, for at most 20 s.
fn time_passes(client: &mut TcpStream, from: f64) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(20) {
        if ask(client, &json!({ "id": 1, "state": true }))["time"].as_f64().unwrap() > from {
            return true;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    false
}

fn scene() -> TestFolder {
    TestFolder::scene("[[object]]\nkind = \"dummy\"\n")
}

#[test]
fn silent_client_is_left_behind_by_the_others() {
    let place = scene();
    let file = place.path().join("scene.toml").display().to_string();
    let served = ServedScene::with("jsonl:hold_timeout_s=0.5", &file, &[]);
    let (mut silent, mut other) = (served.connect(), served.connect());
    ask(&mut silent, &json!({ "id": 1, "stepping": true }));
    ask(&mut silent, &json!({ "id": 2, "request": "start" }));
    let step = ask(&mut silent, &json!({ "id": 3, "step": 2 }));
    let held = step["time"].as_f64().unwrap_or_else(|| panic!("{step}"));
    assert!(time_passes(&mut other, held + 0.5), "{}", served.logged());
    assert!(served.logged().contains("held the simulation for 0.5 s"), "{}", served.logged());
}

#[test]
fn legacy_client_that_triggers_no_more_is_left_behind() {
    let place = scene();
    let file = place.path().join("scene.toml").display().to_string();
    let served = ServedScene::with("legacy_remote:hold_timeout_s=0.5", &file, &[]);
    let mut wire = PacketConnection::new(&served);
    wire.done(0x0001, b"", b"");
    wire.done(0x1007, &ints(&[0]), b"");
    wire.done(0x0003, b"", b"");
    let begin = Instant::now();
    while !served.logged().contains("held the simulation for 0.5 s") {
        assert!(begin.elapsed() < Duration::from_secs(20), "{}", served.logged());
        std::thread::sleep(Duration::from_millis(20));
    }
    // Steps are no longer triggered by the client.
    wire.bad(0x0003, b"", b"");
}

#[test]
fn one_service_listens_on_two_ports() {
    let place = scene();
    let file = place.path().join("scene.toml").display().to_string();
    let second = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap().local_addr().unwrap().port();
    let served = ServedScene::with("legacy_remote", &file, &["--service", &format!("legacy_remote:port={second}")]);
    let mut wire = PacketConnection::new(&served);
    wire.done(0x1007, &ints(&[0]), b"");
    let begin = Instant::now();
    while TcpStream::connect(("127.0.0.1", second)).is_err() {
        assert!(begin.elapsed() < Duration::from_secs(20), "{}", served.logged());
    }
}
