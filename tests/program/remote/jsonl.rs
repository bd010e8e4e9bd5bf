//! Tests of services by clients with real sockets, against the built program.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process::{Child, Command, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

use serde_json::{Value, json};

use crate::kit::*;

/// Timeout of all waits, which is long enough for any answer on a busy machine.
const WAIT_TIMEOUT: Duration = Duration::from_secs(60);

/// A running program with a service that listens on a port.
pub struct RunningProgram {
    child: Child,
    pub port: u16,
    /// Lines of standard error after the one with the port, and of standard output.
    err: Receiver<String>,
    out: Receiver<String>,
}

/// The exit status and the output of a program that has ended.
pub struct ProgramOutput {
    pub code: Option<i32>,
    pub err: String,
    pub out: String,
}

fn lines(from: impl Read + Send + 'static) -> Receiver<String> {
    let (to, lines) = channel();
    thread::spawn(move || BufReader::new(from).lines().map_while(Result::ok).try_for_each(|l| to.send(l)));
    lines
}

impl RunningProgram {
    /// Starts `tatu run scene.toml --service jsonl:port=0,...` with more arguments.
    pub fn start(place: &TestFolder, service: &str, args: &[&str]) -> RunningProgram {
        let service = format!("jsonl:port=0{service}");
        let mut child = Command::new(program())
            .args(["run", "scene.toml", "--service", &service])
            .args(args)
            .current_dir(place.path())
            .env_remove("TATU_PLUGIN_PATH")
            .env("TATU_TRUST", place.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (err, out) = (lines(child.stderr.take().unwrap()), lines(child.stdout.take().unwrap()));
        let mut before = String::new();
        let port = loop {
            let Ok(line) = err.recv_timeout(WAIT_TIMEOUT) else { panic!("the program never listened:\n{before}") };
            match line.split_once("jsonl: listening on 127.0.0.1:") {
                Some((_, port)) => break port.parse().unwrap(),
                None => before += &format!("{line}\n"),
            }
        };
        RunningProgram { child, port, err, out }
    }
    pub fn client(&self) -> TestClient {
        TestClient::connect(self.port)
    }
    pub fn id(&self) -> u32 {
        self.child.id()
    }
    /// Sends a signal to the program.
    #[cfg(unix)]
    pub fn signal(&self, name: &str) {
        succeed(Command::new("kill").arg(format!("-{name}")).arg(self.child.id().to_string()));
    }
    /// Waits for the program to exit.
    #[track_caller]
    pub fn end(mut self) -> ProgramOutput {
        let began = Instant::now();
        let status = loop {
            match self.child.try_wait().unwrap() {
                Some(status) => break status,
                None if began.elapsed() > WAIT_TIMEOUT => {
                    self.child.kill().unwrap();
                    panic!("the program does not exit");
                }
                None => thread::sleep(Duration::from_millis(5)),
            }
        };
        let all = |lines: &Receiver<String>| lines.iter().fold(String::new(), |all, l| all + &l + "\n");
        let ended = ProgramOutput { code: status.code(), err: all(&self.err), out: all(&self.out) };
        assert!(!ended.err.contains("panicked"), "{}", ended.err);
        ended
    }
}

impl Drop for RunningProgram {
    fn drop(&mut self) {
        // A failed test must not leave behind a program that waits indefinitely.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl ProgramOutput {
    #[track_caller]
    pub fn good(self) -> Self {
        assert_eq!(self.code, Some(0), "{}\n{}", self.err, self.out);
        self
    }
}

/// A client's connection.
pub struct TestClient {
    to: TcpStream,
    from: BufReader<TcpStream>,
    id: u64,
}

impl TestClient {
    pub fn connect(port: u16) -> TestClient {
        let to = TcpStream::connect(("127.0.0.1", port)).unwrap();
        to.set_read_timeout(Some(WAIT_TIMEOUT)).unwrap();
        TestClient { from: BufReader::new(to.try_clone().unwrap()), to, id: 0 }
    }
    pub fn end_sending(&mut self) {
        self.to.shutdown(std::net::Shutdown::Write).unwrap();
    }
    pub fn send_bytes(&mut self, bytes: &[u8]) {
        self.to.write_all(bytes).unwrap();
    }
    /// Sends a message and returns its number.
    pub fn send(&mut self, mut message: Value) -> u64 {
        self.id += 1;
        message["id"] = json!(self.id);
        self.send_bytes(format!("{message}\n").as_bytes());
        self.id
    }
    #[track_caller]
    pub fn receive(&mut self) -> Value {
        let mut line = String::new();
        self.from.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap_or_else(|e| panic!("{e}: {line:?}"))
    }
    /// Sends a message and returns its answer, which must be the next line.
    #[track_caller]
    pub fn ask(&mut self, message: Value) -> Value {
        let id = self.send(message);
        let answer = self.receive();
        assert_eq!(answer["id"], id, "{answer}");
        answer
    }
    /// Calls a command, which must succeed, and returns its results.
    #[track_caller]
    pub fn call(&mut self, name: &str, args: Value) -> Value {
        let answer = self.ask(json!({ "call": name, "args": args }));
        assert!(answer.get("error").is_none(), "{name}: {answer}");
        answer["result"].clone()
    }
    #[track_caller]
    pub fn stepping(&mut self) {
        assert_eq!(self.ask(json!({ "stepping": true }))["result"], json!([]));
    }
    /// Runs `n` steps and returns the number of steps done since the start.
    #[track_caller]
    pub fn step(&mut self, n: u64) -> u64 {
        self.ask(json!({ "step": n }))["step"].as_u64().unwrap()
    }
    #[track_caller]
    pub fn handle(&mut self, name: &str) -> i64 {
        self.call("sim.getObject", json!([name]))[0].as_i64().unwrap()
    }
    /// Returns whether nothing is received for 150 ms. An unexpected message would arrive immediately.
    pub fn is_silent(&mut self) -> bool {
        self.to.set_read_timeout(Some(Duration::from_millis(150))).unwrap();
        let nothing = self.from.fill_buf().is_err();
        self.to.set_read_timeout(Some(WAIT_TIMEOUT)).unwrap();
        nothing
    }
}

/// Creates a scene with a robot without a script, and a box beside it.
pub fn arena() -> TestFolder {
    let robot = "[[model]]\nmodel = \"pioneer_p3dx\"\n";
    let crate_ = cuboid("crate", [0.3; 3], [2.0, 0.0, 0.15], "dynamic = true\nrespondable = true\nmass_kg = 2.0");
    TestFolder::scene(&format!("seed = 5\n{FLOOR}{robot}{crate_}"))
}

/// Creates a scene whose script prints when it starts and when it cleans up.
fn start_and_cleanup_scene() -> TestFolder {
    let script = "function sysCall_init() print('begun') end\nfunction sysCall_cleanup() print('cleaned up') end";
    TestFolder::scene(&watcher("w", script))
}

/// If the caller is not attached to an object, a path that begins with a dot starts at the top of the scene.
#[test]
fn relative_paths_of_clients_begin_at_the_top() {
    let place = TestFolder::scene(
        "[[object]]\nkind = \"dummy\"\nalias = \"base\"\n[[object]]\nkind = \"dummy\"\nalias = \"tip\"\nparent = \"base\"\n",
    );
    let running = RunningProgram::start(&place, "", &["--seconds", "1000"]);
    let mut client = running.client();
    for path in ["./tip", "./base", "./base/tip"] {
        let found = client.call("sim.getObject", json!([path]));
        let alias = client.call("sim.getObjectAlias", json!([found[0]]));
        assert_eq!(alias[0], path.rsplit('/').next().unwrap());
    }
}

#[test]
fn two_clients_drive_in_step_and_a_replay_repeats_them() {
    let place = arena();
    let traced = ["--hashes", "--watch", "/Pioneer_p3dx", "--watch", "crate"];
    let live = [&["--log", "run.log", "--trace", "live.jsonl"], &traced[..]].concat();
    let run = RunningProgram::start(&place, ",wait_for=2", &live);
    let (mut left, mut right) = (run.client(), run.client());
    left.stepping();
    right.stepping();
    let (motor_l, motor_r) = (left.handle("/Pioneer_p3dx_leftMotor"), right.handle("/Pioneer_p3dx_rightMotor"));
    let (robot, box_) = (left.handle("/Pioneer_p3dx"), right.handle("/crate"));
    let mut seen = Vec::new();
    for i in 0..60_u64 {
        left.call("sim.setJointTargetVelocity", json!([motor_l, 2.0 + 0.1 * (i % 7) as f64]));
        left.send(json!({ "step": 1 }));
        if i == 20 {
            assert!(left.is_silent(), "a step was done before both clients requested it");
        }
        right.call("sim.setJointTargetVelocity", json!([motor_r, 2.5 - 0.1 * (i % 5) as f64]));
        if i == 30 {
            right.call("sim.setObjectPosition", json!([box_, -1, [0.1 + 1.0 / 3.0, 1.0, 0.15]]));
        }
        assert_eq!(right.step(1), i + 1);
        assert_eq!(left.receive()["step"], i + 1);
        seen.push(numbers(&left.call("sim.getObjectPosition", json!([robot, -1]))[0]));
    }
    right.ask(json!({ "request": "stop" }));
    let ended = run.end().good();
    assert!(ended.err.contains("60 steps"), "{}", ended.err);

    let lines = place.lines("live.jsonl");
    assert_eq!(lines.len(), 60);
    for (line, seen) in lines.iter().zip(&seen) {
        assert_eq!(line.object::<3>("/Pioneer_p3dx", "position").as_slice(), seen);
    }
    assert!(seen[59][0] > 0.3, "the robot has not driven: {:?}", seen[59]);

    // The log alone is sufficient, in another folder and with any number of threads. The log of a replay is the same.
    let other = TestFolder::new();
    std::fs::copy(place.path().join("run.log"), other.path().join("run.log")).unwrap();
    for threads in ["1", "2"] {
        let args = ["run", "--replay", "run.log", "--trace", "again.jsonl", "--log", "again.log", "--threads", threads];
        other.tatu(&[&args, &traced[..]].concat()).good();
        assert_eq!(other.read("again.jsonl"), place.read("live.jsonl"));
        assert!(other.read("again.log") == place.read("run.log"), "the replay's log differs");
    }
}

#[test]
fn commands_are_executed_between_the_steps_that_were_asked_for() {
    let place = TestFolder::scene(&watcher("d", ""));
    let run = RunningProgram::start(&place, ",wait_for=1", &["--trace", "t.jsonl", "--watch", "d"]);
    let mut client = run.client();
    client.stepping();
    let d = client.handle("/d");
    // All messages are sent together. The service must process them in order, and pause after each requested step.
    for i in 0..20 {
        client.send(json!({ "call": "sim.setObjectPosition", "args": [d, -1, [i, 0, 0]] }));
        client.send(json!({ "step": 2 }));
    }
    for i in 0..20 {
        assert_eq!(client.receive()["result"], json!([]));
        let stepped = client.receive();
        assert_eq!(stepped["step"], 2 * (i + 1));
        // Each request has run two steps of 0.05 s.
        assert!((stepped["time"].as_f64().unwrap() - 0.1 * (i + 1) as f64).abs() < 1e-12, "{stepped}");
    }
    client.ask(json!({ "request": "quit" }));
    run.end().good();
    let x: Vec<f64> = place.lines("t.jsonl").iter().map(|l| l.object::<3>("/d", "position")[0]).collect();
    let wanted: Vec<f64> = (0..40).map(|step| f64::from(step / 2)).collect();
    assert_eq!(x, wanted);
}

#[test]
fn a_disconnected_client_does_not_block_the_run() {
    let place = arena();
    let run = RunningProgram::start(&place, ",wait_for=2", &["--steps", "40"]);
    let (mut one, mut other) = (run.client(), run.client());
    one.stepping();
    other.stepping();
    // The client disconnects while it holds the world, with a command that waits and half a line.
    one.send(json!({ "call": "sim.wait", "args": [100.0] }));
    other.send(json!({ "step": 10 }));
    assert!(other.is_silent(), "a step was done although the other client holds the run");
    one.send_bytes(b"{\"id\": 7, \"call\": \"sim.get");
    drop(one);
    assert_eq!(other.receive()["step"], 10);
    // A third client disconnects without reading its answer.
    let mut third = run.client();
    third.send(json!({ "stepping": true }));
    third.send(json!({ "state": true }));
    assert!(!third.is_silent());
    drop(third);
    assert_eq!(other.step(10), 20);
    drop(other);
    // No client is left: the run continues to its end.
    let ended = run.end().good();
    assert!(ended.err.contains("40 steps"), "{}", ended.err);
}

#[test]
fn invalid_messages_are_answered_with_errors() {
    let place = arena();
    let run = RunningProgram::start(&place, ",wait_for=1", &[]);
    let mut client = run.client();
    client.stepping();
    for line in ["{", "[]", "nonsense", "{\"call\": 3}", "{\"step\": -1}", "{\"call\": \"a\", \"step\": 1}", "\u{1}"] {
        client.send_bytes(format!("{line}\n").as_bytes());
        let answer = client.receive();
        assert!(answer["id"].is_null() && answer["error"]["text"].is_string(), "{line}: {answer}");
    }
    client.send_bytes(b"\xff\xfe\n\r\n\n");
    assert!(client.receive()["error"]["text"].as_str().unwrap().contains("JSON"));
    client.send_bytes(format!("{}1{}\n", "[".repeat(500), "]".repeat(500)).as_bytes());
    assert!(client.receive()["error"]["text"].as_str().unwrap().contains("recursion"));
    // The lines are one byte too long and much too long.
    for length in [(16 << 20) + 1, 20 << 20] {
        client.send_bytes(&vec![b'x'; length]);
        client.send_bytes(b"\n");
        assert!(client.receive()["error"]["text"].as_str().unwrap().contains("longer than"));
    }
    // Errors of commands have the codes of tatu.h.
    let unknown = client.ask(json!({ "call": "sim.noSuch" }));
    assert_eq!(unknown["error"]["code"], -6, "{unknown}");
    let gone = client.ask(json!({ "call": "sim.getObjectPosition", "args": [99999] }));
    assert_eq!(gone["error"]["code"], -3, "{gone}");
    let wrong = client.ask(json!({ "call": "sim.setObjectPosition", "args": [1, -1, "here"] }));
    assert_eq!(wrong["error"]["code"], -2, "{wrong}");
    let world = client.ask(json!({ "world": 3 }));
    assert!(world["error"]["text"].as_str().unwrap().contains("world 3 does not exist"), "{world}");
    // A line can arrive byte by byte, and several lines can arrive at once.
    for byte in b"{\"id\": 500, \"call\": \"sim.getSimulationTime\"}\n" {
        client.send_bytes(&[*byte]);
    }
    assert_eq!(client.receive(), json!({ "id": 500, "result": [0.0] }));
    client.send_bytes(b"{\"id\": 501, \"state\": true}\n{\"id\": 502, \"state\": true}\n");
    assert_eq!((client.receive()["id"].clone(), client.receive()["id"].clone()), (json!(501), json!(502)));
    client.ask(json!({ "request": "stop" }));
    run.end().good();
}

#[test]
fn a_stop_ends_the_run_in_order() {
    let place = start_and_cleanup_scene();
    let run = RunningProgram::start(&place, "", &[]);
    let (mut client, mut other) = (run.client(), run.client());
    other.ask(json!({ "events": true }));
    other.stepping();
    let before = other.step(1);
    other.send(json!({ "step": 1_000_000_000 }));
    // Waits for the steps, because an earlier request would stop time before they are done.
    while client.ask(json!({ "state": true }))["step"].as_u64().unwrap() <= before {}
    client.ask(json!({ "request": "stop" }));
    let ended = run.end().good();
    assert_eq!(ended.out, "begun\ncleaned up\n");
    // Pending requests are answered before the connection ends.
    let answers = [other.receive(), other.receive()];
    assert!(answers.iter().any(|a| a["event"] == "stopped"), "{answers:?}");
    assert!(answers.iter().any(|a| a["error"]["code"] == -4), "{answers:?}");
}

#[test]
fn a_pause_stops_time_until_it_is_lifted() {
    let place = TestFolder::scene(&watcher("d", ""));
    let run = RunningProgram::start(&place, "", &[]);
    let (mut client, mut watching) = (run.client(), run.client());
    watching.ask(json!({ "events": true }));
    client.ask(json!({ "request": "pause" }));
    assert_eq!(watching.receive()["event"], "paused");
    let before = client.ask(json!({ "state": true }));
    assert_eq!(before["state"], "paused");
    // Commands still work.
    let d = client.handle("/d");
    client.call("sim.setObjectPosition", json!([d, -1, [1, 2, 3]]));
    assert_eq!(client.call("sim.getObjectPosition", json!([d, -1])), json!([[1.0, 2.0, 3.0]]));
    let after = client.ask(json!({ "state": true }));
    assert_eq!((&after["state"], &after["step"]), (&json!("paused"), &before["step"]));
    client.ask(json!({ "request": "start" }));
    assert_eq!(watching.receive()["event"], "resumed");
    let passed = client.step(3);
    assert!(passed >= before["step"].as_u64().unwrap() + 3);
    // A script can also pause the run, because there is a client that can resume it.
    client.call("sim.pauseSimulation", json!([]));
    assert_eq!(watching.receive()["event"], "paused");
    client.ask(json!({ "request": "stop" }));
    run.end().good();
}

#[test]
fn passes_of_scripts_during_a_pause_are_replayed() {
    // The number of calls depends on the clock, so the script stores it in the scene.
    let script = "n = 0
        function sysCall_suspended() n = n + 1 sim.setObjectPosition(sim.getObject('/A'), {n, 0, 0}) end";
    let place = TestFolder::scene(&format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"A\"\nscript = {{ kind = \"customization\", text = \"\"\"{script}\"\"\" }}\n"
    ));
    let run = RunningProgram::start(&place, "", &["--log", "run.log", "--trace", "t.jsonl"]);
    let (mut client, mut watching) = (run.client(), run.client());
    watching.ask(json!({ "events": true }));
    client.ask(json!({ "request": "pause" }));
    assert_eq!(watching.receive()["event"], "paused");
    let object = client.handle("/A");
    while client.call("sim.getObjectPosition", json!([object, -1]))[0][0].as_f64() < Some(3.0) {}
    client.ask(json!({ "request": "start" }));
    assert_eq!(watching.receive()["event"], "resumed");
    client.ask(json!({ "request": "stop" }));
    run.end().good();
    assert!(place.read("run.log").matches("\"pass\":true").count() >= 3);
    place.tatu(&["run", "--replay", "run.log", "--trace", "again.jsonl"]).good();
    assert_eq!(place.read("again.jsonl"), place.read("t.jsonl"));
}

#[cfg(unix)]
#[test]
fn signals_end_a_held_run_in_order() {
    for signal in ["INT", "TERM"] {
        let place = start_and_cleanup_scene();
        let run = RunningProgram::start(&place, ",wait_for=1", &["--log", "run.log"]);
        let mut client = run.client();
        client.stepping();
        assert_eq!(client.step(3), 3);
        run.signal(signal);
        let ended = run.end().good();
        assert!(ended.err.contains("3 steps"), "{}", ended.err);
        assert_eq!(ended.out, "begun\ncleaned up\n", "{signal}");
        assert!(place.read("run.log").contains("{\"begun\":true,\"end\":3,"));
    }
}

#[test]
fn a_command_that_waits_is_answered_when_it_is_over() {
    let place = TestFolder::scene(&watcher("d", ""));
    let run = RunningProgram::start(&place, ",wait_for=1", &["--log", "run.log", "--trace", "t.jsonl"]);
    let mut client = run.client();
    client.stepping();
    let wait = client.send(json!({ "call": "sim.wait", "args": [0.2] }));
    let signal = client.send(json!({ "call": "sim.waitForSignal", "args": ["ready"] }));
    // The client is not blocked meanwhile.
    assert_eq!(client.step(3), 3);
    client.send(json!({ "step": 2 }));
    // 0.2 s are four steps of 0.05 s.
    assert_eq!(client.receive()["id"], wait);
    assert_eq!(client.receive()["step"], 5);
    client.call("sim.setStringSignal", json!(["ready", "yes"]));
    client.send(json!({ "step": 1 }));
    assert_eq!(client.receive(), json!({ "id": signal, "result": ["yes"] }));
    assert_eq!(client.receive()["step"], 6);
    // A wait that never completes is cancelled when the run ends.
    let never = client.send(json!({ "call": "sim.wait", "args": [1000.0] }));
    client.send(json!({ "request": "stop" }));
    assert_eq!(client.receive()["result"], json!([]));
    let answer = client.receive();
    assert_eq!((answer["id"].as_u64(), answer["error"]["code"].as_i64()), (Some(never), Some(-4)), "{answer}");
    run.end().good();
    place.tatu(&["run", "--replay", "run.log", "--trace", "again.jsonl"]).good();
    assert_eq!(place.read("again.jsonl"), place.read("t.jsonl"));
}

#[test]
fn a_scene_may_request_a_service_and_mistakes_are_refused() {
    let scene = |service: &str| TestFolder::scene(&format!("{}{service}", watcher("d", "")));
    let place = scene("[[service]]\nid = \"jsonl\"\nport = 1\nwait_for = 1\n");
    // The command line overrides the scene.
    let run = RunningProgram::start(&place, "", &["--steps", "2"]);
    let mut client = run.client();
    client.ask(json!({ "stepping": false }));
    run.end().good();
    scene("[[service]]\nid = \"jsnl\"\n").run(&[]).refused(&["E115", "`jsnl`", "did you mean `jsonl`?", "scene.toml:"]);
    scene("[[service]]\nid = \"jsonl\"\nprot = 1\n").run(&[]).refused(&["E101", "`prot`", "`port`"]);
    scene("[[service]]\nid = \"jsonl\"\nport = 70000\n").run(&[]).refused(&["E102", "from 0 to 65535"]);
    scene("[[service]]\nport = 1\n").run(&[]).refused(&["E104", "id"]);
    let twice = "[[service]]\nid = \"jsonl\"\nport = 0\n".repeat(2);
    scene(&twice).run(&[]).refused(&["E102", "twice"]);
    scene("").run(&["--service", "jsonl:port"]).refused(&["E102", "KEY=VALUE"]);
    let held = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = held.local_addr().unwrap().port();
    let taken = scene("").run(&["--service", &format!("jsonl:port={port}")]);
    taken.refused(&["E404", "tatu.service.jsonl", &format!("127.0.0.1:{port}"), "port"]);
}

#[test]
fn users_set_defaults_of_services_for_their_machine() {
    let held = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = held.local_addr().unwrap().port();
    let place = TestFolder::scene(&format!("{}[[service]]\nid = \"jsonl\"\n", watcher("d", "")));
    let settings = |text: &str| {
        std::fs::create_dir_all(place.path().join(".data/tatu")).unwrap();
        place.write(".data/tatu/settings.toml", text);
    };
    settings(&format!("[service.jsonl]\nport = {port}\n[service.unknown]\nport = 1\n"));
    place.run(&["--steps", "2"]).refused(&["E404", &format!("127.0.0.1:{port}")]);
    // The scene and the command line override these settings.
    place.run(&["--steps", "2", "--service", "jsonl:port=0"]).good();
    settings("[service.jsonl]\nprot = 1\n");
    place.run(&["--steps", "2"]).refused(&["E101", "`prot`", "settings.toml"]);
    settings("[physics]\nstep = 1\n");
    place.run(&["--steps", "2"]).refused(&["E101", "`physics`", "[service.ID]", "settings.toml:1"]);
}

/// A plugin in C with a service whose parameter `how` selects what it does.
const SERVICE_IN_C: &str = r#"
#include <stdio.h>
#include "tatu.h"
typedef struct { int64_t how, turns; tatu_session *session; const tatu_host *host; int64_t *count; } my_data;
static const tatu_host *the_host; /* good enough for a test */
static tatu_status TATU_CALL create(void *self, const tatu_instance *i, void **data, tatu_error *e) {
  static my_data d;
  const tatu_value *p = i->params;
  (void)self;
  if (p[0].u.i == 3) return tatu_fail(e, TATU_ERR, "it will not");
  d.how = p[0].u.i; d.turns = 0; d.session = i->session; d.host = the_host; d.count = i->state;
  *data = &d;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { (void)data; }
static tatu_status TATU_CALL barrier(void *data, tatu_world *w, uint64_t step, tatu_error *e) {
  my_data *d = data;
  const tatu_host_session *s = d->host->service(d->host, TATU_HOST_SESSION);
  const tatu_host_log *log = d->host->service(d->host, TATU_HOST_LOG);
  d->turns++;
  if (d->how == 1 && step == 3) return 7;             /* neither go nor hold */
  if (d->how == 2 && step == 3) return TATU_ERR;
  if (d->how == 5 && step == 3) return tatu_fail(e, TATU_ERR, "the wire broke");
  if (d->how == 6) { /* its state block goes on with the world */
    char text[40];
    ++*d->count;
    snprintf(text, sizeof text, "turn %d of %d", (int)*d->count, (int)d->turns);
    log->write(d->host, w, TATU_LOG_INFO, tatu_text(text));
  }
  if (d->how == 4 && d->turns % 3 != 0) { s->wake(d->session); return TATU_HOLD; }
  if (d->how == 4) log->write(d->host, w, TATU_LOG_INFO, tatu_text("third turn"));
  return TATU_GO;
}
static const tatu_param how = {sizeof how, TATU_I64, 0, 0, "how", 0, 0, 0, {TATU_I64, 0, {0}}, 0, "what to do", 0};
static const tatu_param *const params[] = {&how, 0};
static tatu_status TATU_CALL last(void *data, tatu_world *w, tatu_error *e) {
  my_data *d = data;
  const tatu_host_log *log = d->host->service(d->host, TATU_HOST_LOG);
  const tatu_host_session *s = d->host->service(d->host, TATU_HOST_SESSION);
  (void)e;
  if (d->how != 6) return TATU_OK;
  log->write(d->host, w, TATU_LOG_INFO, tatu_text("the last turn"));
  return s->request(w, TATU_REQUEST_START); /* refused: nothing is to be changed any more */
}
static tatu_status TATU_CALL save(void *data, const tatu_writer *w, tatu_error *e) { (void)data; (void)w; (void)e; return TATU_OK; }
static tatu_status TATU_CALL load(void *data, tatu_str b, uint32_t v, tatu_error *e) { (void)data; (void)b; (void)v; (void)e; return TATU_OK; }
static const tatu_life life = {.size = sizeof life, .state_bytes = 8, .create = create, .destroy = destroy,
                               .save = save, .load = load, .version = 1};
static const tatu_service service = {sizeof service, 0, "odd", "Does odd things.", params, &life, barrier, 0, 0, 0, 0, last};
static const tatu_service *const services[] = {&service, 0};
static const tatu_ext_service ext = {sizeof ext, 0, services};
static tatu_status TATU_CALL init(const tatu_host *h, void **self, tatu_error *e) {
  (void)self; (void)e; the_host = h; return TATU_OK;
}
static const void *TATU_CALL extension(void *self, const char *id) {
  const char *a = TATU_SERVICE;
  (void)self;
  while (*a && *a == *id) a++, id++;
  return *a == *id ? &ext : 0;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {sizeof tatu_plugin, TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.odd",
  "Odd", "1.0.0", "MIT", 0, init, 0, extension};
"#;

/// Compiles the plugin in the scene's folder.
fn odd(place: &TestFolder) {
    place.write("odd.c", SERVICE_IN_C);
    std::fs::create_dir_all(place.path().join("plugins")).unwrap();
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["odd.c", "-o"])
            .arg(Path::new("plugins").join(library("tatu_odd")))
            .current_dir(place.path()),
    );
}

#[test]
fn a_service_in_c_that_fails_is_switched_off_and_named_once() {
    let place = TestFolder::scene(&format!("plugins = [\"plugins\"]\n{}", watcher("d", "")));
    odd(&place);
    for (how, words) in [
        (1, "it returned 7 [tatu_service.barrier]"),
        (2, "failed with status -1 [tatu_service.barrier]"),
        (5, "`odd`: the wire broke [tatu_service.barrier]"),
    ] {
        let done = place.run(&["--steps", "10", "--service", &format!("odd:how={how}")]);
        let errors = done.errors();
        assert_eq!(errors.len(), 1, "{errors:?}");
        let e = &errors[0];
        assert_eq!((e["code"].as_str(), e["plugin"].as_str()), (Some("F207"), Some("org.example.odd")), "{e}");
        assert!(e["message"].as_str().unwrap().contains(words) && e["count"] == 1, "{e}");
        assert_eq!(done.json()["steps"], 10, "the run must continue");
    }
    place.run(&["--service", "odd:how=3"]).refused(&["E404", "`odd`", "it will not"]);
    // The service holds the run twice before each step, and wakes the host itself.
    let done = place.run(&["--steps", "4", "--service", "odd:how=4"]).good();
    assert_eq!(done.err.matches("third turn").count(), 4, "{}", done.err);
}

#[test]
fn the_state_of_a_service_goes_on_from_a_snapshot_and_it_sees_the_end() {
    let place = TestFolder::scene(&format!("plugins = [\"plugins\"]\n{}", watcher("d", "")));
    odd(&place);
    let service = ["--service", "odd:how=6"];
    let done = place.run(&[&["--steps", "6", "--snapshot-at", "0.15", "t.snap"], &service[..]].concat());
    done.reports(&["turn 6 of 6", "the last turn"]);
    // In `last`, a service can only read.
    let errors = done.errors();
    assert!(errors.is_empty() || errors[0]["message"].as_str().unwrap().contains("`session.request`"), "{errors:?}");
    let again = place.run(&[&["--from", "t.snap", "--steps", "6"], &service[..]].concat());
    // The first process had three turns before the snapshot. The new process counts its own turns from 0.
    again.reports(&["turn 4 of 1", "turn 6 of 3"]);
    // Without the service, the world continues.
    place.run(&["--from", "t.snap", "--steps", "6"]).good();
}

#[test]
fn faults_are_sent_to_clients_that_subscribe_to_events() {
    let place = TestFolder::scene(&watcher("w", "function sysCall_actuation() error('a fault of mine') end"));
    let run = RunningProgram::start(&place, ",wait_for=1", &[]);
    let mut client = run.client();
    client.ask(json!({ "events": true }));
    client.stepping();
    client.send(json!({ "step": 1 }));
    // The event is delivered at the barrier after the step, before the answer.
    let event = client.receive();
    assert_eq!((&event["event"], &event["payload"]["code"]), (&json!("fault"), &json!("F205")), "{event}");
    assert!(event["payload"]["message"].as_str().unwrap().contains("a fault of mine"), "{event}");
    assert_eq!(client.receive()["step"], 1);
    client.ask(json!({ "request": "stop" }));
    assert_eq!(run.end().code, Some(1), "a run with an error must exit with 1");
}

/// A malicious page can make a browser send an HTTP request to the port. Its body must not be executed as commands.
#[test]
fn a_client_whose_first_line_is_no_message_is_refused() {
    let place = arena();
    let run = RunningProgram::start(&place, "", &["--seconds", "1000000", "--log", "run.log"]);
    let mut page = run.client();
    page.send_bytes(b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n{\"id\":1,\"request\":\"quit\"}\n");
    let refused = page.receive();
    assert!(refused["error"]["text"].as_str().unwrap().contains("the connection is closed"), "{refused}");
    let mut client = run.client();
    client.stepping();
    assert_eq!(client.ask(json!({ "state": true }))["state"], "running");
    client.ask(json!({ "request": "stop" }));
    run.end().good();
    assert!(!place.read("run.log").contains("quit"));
}

#[test]
fn a_token_lets_clients_in() {
    let place = arena();
    let run = RunningProgram::start(&place, ",wait_for=1,token=open-sesame", &[]);
    for first in [json!({ "request": "quit" }), json!({ "token": "sesame" })] {
        let mut stranger = run.client();
        let refused = stranger.ask(first);
        assert!(refused["error"]["text"].as_str().unwrap().contains("token"), "{refused}");
    }
    let mut client = run.client();
    assert!(client.ask(json!({ "token": "open-sesame" }))["result"].is_array());
    client.stepping();
    client.step(2);
    client.ask(json!({ "request": "stop" }));
    run.end().good();
}

/// A step cannot be done while the simulation is paused; the next line of the same client resumes the simulation.
#[test]
fn a_step_that_waits_in_a_pause_does_not_block_the_start() {
    let place = arena();
    let run = RunningProgram::start(&place, ",wait_for=1", &[]);
    let mut client = run.client();
    client.stepping();
    client.step(2);
    client.ask(json!({ "request": "pause" }));
    client.step(1);
    let step = client.send(json!({ "step": 3 }));
    let start = client.send(json!({ "request": "start" }));
    let mut answered = vec![client.receive()["id"].as_u64().unwrap(), client.receive()["id"].as_u64().unwrap()];
    answered.sort_unstable();
    assert_eq!(answered, [step, start]);
    client.ask(json!({ "request": "stop" }));
    run.end().good();
}
