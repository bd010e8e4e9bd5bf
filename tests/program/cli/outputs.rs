//! Tests that failures to write are reported with exit code 1, and that a second Ctrl-C ends the program immediately.

#![cfg(target_os = "linux")]

use std::{
    fs::File,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use crate::kit::*;

/// Returns exit code and standard error of the program with standard output on a full disk.
fn on_a_full_disk(place: &TestFolder, args: &[&str]) -> (Option<i32>, String) {
    let full = File::options().write(true).open("/dev/full").unwrap();
    let done = Command::new(program()).args(args).current_dir(place.path()).stdout(full).output().unwrap();
    (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
}

#[test]
fn a_full_disk_is_reported() {
    let place = TestFolder::scene("");
    for args in [
        &["run", "scene.toml", "--json", "--seconds", "1"][..],
        &["list", "models"],
        &["list", "models", "--json"],
        &["describe", "proximity"],
        &["check", "scene.toml"],
    ] {
        let (code, err) = on_a_full_disk(&place, args);
        assert_eq!(code, Some(1), "{args:?}\n{err}");
        assert!(err.contains("cannot write standard output: No space left on device"), "{args:?}\n{err}");
    }
    for (option, words) in
        [("--trace", "cannot write the trace /dev/full"), ("--log", "the input log /dev/full cannot be continued")]
    {
        let done = place.run(&["--seconds", "100", option, "/dev/full"]);
        assert!(done.code != 0 && done.err.contains(words), "{option}: {}\n{}", done.code, done.err);
    }
}

#[test]
fn a_closed_pipe_ends_quietly() {
    let mut child = Command::new(program())
        .args(["list", "commands", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let done = child.wait_with_output().unwrap();
    assert!(done.status.success() && done.stderr.is_empty(), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn a_second_interrupt_ends_the_program() {
    let place = TestFolder::scene("");
    succeed(Command::new("mkfifo").arg(place.path().join("keys")));
    // The program reads a pipe to which nothing is ever written.
    let mut child = Command::new(program())
        .args(["run", "scene.toml", "--seconds", "1000000", "--realtime", "--keys", "keys"])
        .current_dir(place.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let writer = File::options().write(true).read(true).open(place.path().join("keys")).unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let begin = Instant::now();
    let mut signals = 0;
    let code = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if signals < 2 && begin.elapsed() >= Duration::from_millis(500 * signals) {
            succeed(Command::new("kill").args(["-INT", &child.id().to_string()]));
            signals += 1;
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "two interrupts did not end the program");
        std::thread::sleep(Duration::from_millis(20));
    };
    drop(writer);
    assert!(code.code().is_none_or(|c| c == 130 || c == 0), "{code}");
}
