//! Tests of an interactive run in a pseudo-terminal.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read, Write},
    os::fd::FromRawFd,
    process::{Child, Command, Stdio},
};

use crate::{cli::keys::LISTENER, kit::*};

/// The program, with a pseudo-terminal as its standard input.
struct InteractiveRun {
    child: Child,
    /// The master side of the pseudo-terminal, to which the test writes keys.
    keyboard: File,
    stdout: BufReader<std::process::ChildStdout>,
}

impl InteractiveRun {
    fn start(place: &TestFolder, args: &[&str]) -> Self {
        let (mut master, mut slave) = (-1, -1);
        let none = std::ptr::null_mut();
        // SAFETY: `openpty` writes both descriptors; null pointers mean that name, settings and size are not used.
        let made = unsafe { libc::openpty(&mut master, &mut slave, none, none.cast(), none.cast()) };
        assert_eq!(made, 0, "no pseudo-terminal");
        // SAFETY: both descriptors are open, and nothing else owns them.
        let (keyboard, terminal) = unsafe { (File::from_raw_fd(master), File::from_raw_fd(slave)) };
        let mut child = Command::new(program())
            .args(args)
            .current_dir(place.path())
            .stdin(Stdio::from(terminal))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let told = BufReader::new(child.stdout.take().unwrap());
        InteractiveRun { child, keyboard, stdout: told }
    }
    fn press(&mut self, keys: &[u8]) {
        self.keyboard.write_all(keys).unwrap();
    }
    /// Reads the output of scripts up to a line that contains `text`.
    fn until(&mut self, text: &str) {
        let mut line = String::new();
        while !line.contains(text) {
            line.clear();
            assert!(self.stdout.read_line(&mut line).unwrap() > 0, "no line with `{text}`: {}", self.errors());
        }
    }
    fn errors(&mut self) -> String {
        let mut text = String::new();
        let _ = self.child.stderr.take().unwrap().read_to_string(&mut text);
        text
    }
    #[track_caller]
    fn end(mut self) {
        let status = self.child.wait().unwrap();
        assert!(status.success(), "{status}: {}", self.errors());
    }
}

// Sequences sent by a terminal (xterm).
const UP: &[u8] = b"\x1b[A";
const F5: &[u8] = b"\x1b[15~";
const F6: &[u8] = b"\x1b[17~";
const F7: &[u8] = b"\x1b[18~";

fn place() -> TestFolder {
    let place = TestFolder::new();
    place.write("listen.lua", &format!("{LISTENER}\nfunction sysCall_sensing() print('step') end"));
    place
}
const ARGS: [&str; 4] = ["run", "--script", "listen.lua", "--stand-ins"];

#[test]
fn a_session_replays_with_the_same_hashes() {
    let place = place();
    let session = ["--interactive", "--log", "run.log", "--trace", "a.jsonl"];
    let mut played = InteractiveRun::start(&place, &[&ARGS[..], &session].concat());
    played.until("step");
    played.press(b"++");
    played.press(b"s");
    played.until("6 115 0");
    played.press(UP);
    played.until("6 2007 0");
    played.press(F7);
    played.end();
    place.tatu(&["run", "--replay", "run.log", "--trace", "b.jsonl"]).good();
    place.tatu(&["diff", "a.jsonl", "b.jsonl"]).good();
    let told: Vec<String> = place.lines("a.jsonl").iter().map(|l| l.status().join(",")).collect();
    let keys: Vec<&String> = told.iter().filter(|t| !t.is_empty()).collect();
    assert_eq!(keys, ["6 115 0", "6 2007 0"]);
}

#[test]
fn a_session_is_paused_and_continued_step_by_step() {
    let place = place();
    place.write(
        "listen.lua",
        &format!("{}\nfunction sysCall_suspend() print('suspended') end", place.read("listen.lua")),
    );
    let session = ["--interactive", "--trace", "t.jsonl", "--log", "run.log"];
    let mut played = InteractiveRun::start(&place, &[&ARGS[..], &session].concat());
    played.until("step");
    // A key pressed while the simulation is paused is delivered in the next step.
    played.press(F5);
    played.until("suspended");
    played.press(b"a");
    played.press(F6);
    played.until("6 97 0");
    played.press(b"b");
    played.press(F6);
    played.until("6 98 0");
    played.press(F7);
    played.end();
    let lines = place.lines("t.jsonl");
    let of = |key: &str| lines.iter().position(|l| l.status().contains(&key)).unwrap();
    assert_eq!(of("6 98 0"), of("6 97 0") + 1, "the second key must be delivered one step after the first");
    let counted = lines.iter().filter(|l| l.0.get("stopping").is_none()).count();
    assert_eq!(counted, of("6 98 0") + 1, "no further key must be delivered");
    place.tatu(&["run", "--replay", "run.log", "--trace", "again.jsonl"]).good();
    place.tatu(&["diff", "t.jsonl", "again.jsonl"]).good();
}

#[test]
fn interactive_runs_need_a_terminal() {
    let place = place();
    place.tatu(&[&ARGS[..], &["--interactive"]].concat()).refused(&["E105", "terminal", "--keys"]);
}
