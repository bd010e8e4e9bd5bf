//! Tests that all effects of the page are recorded in the input log.

use std::{
    io::{BufRead, BufReader},
    process::{Command, Stdio},
    time::Duration,
};

use serde_json::{Value, json};
use tungstenite::Message;

use super::program::{ROBOT, STATE, next};
use crate::kit::*;

#[test]
fn viewers_do_not_change_the_hash() {
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
fn actions_in_the_page_are_replayed_from_the_log() {
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
    let scene = next(&mut socket, "scene");
    let of = |alias: &str| scene["objects"].as_array().unwrap().iter().find(|o| o["alias"] == alias).unwrap().clone();
    let script = of("Pioneer_p3dx")["scripts"][0]["id"].clone();
    let mut say = |message: Value| socket.send(Message::text(message.to_string())).unwrap();
    let pause = || std::thread::sleep(Duration::from_millis(150));
    say(json!({ "type": "script", "script": script }));
    let text = next(&mut socket, "script")["text"].as_str().unwrap().replace("cruise = 3.0", "cruise = 1.5");
    let mut say = |message: Value| socket.send(Message::text(message.to_string())).unwrap();
    pause();
    say(json!({ "type": "call", "name": "tatu.setScript", "args": [script, text], "id": 1 }));
    pause();
    say(json!({ "type": "key", "key": "up" }));
    say(
        json!({ "type": "call", "name": "tatu.set", "args": [of("barrel")["id"], "object.position", [0.5, -0.5, 0.4]], "id": 2 }),
    );
    say(json!({ "type": "run", "action": "pause" }));
    pause();
    say(json!({ "type": "run", "action": "start" }));
    pause();
    say(json!({ "type": "run", "action": "quit" }));
    let out = process.wait_with_output().unwrap();
    let live = String::from_utf8_lossy(&out.stderr).into_owned();
    drop(socket);
    let again =
        Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(root()).args(["run", "--replay", &log]).output().unwrap();
    let again = String::from_utf8_lossy(&again.stderr).into_owned();
    assert_eq!(hash(&live), hash(&again), "{live}\n{again}");
    assert!(!live.contains(" 0 steps") && live.contains("steps"), "{live}");
}
