//! Tests of clients of `jsonl` that leave, and that stop a script which does not return.

use serde_json::json;

use super::jsonl::RunningProgram;
use crate::kit::*;

/// Clients that have left with a command that waits count as clients, of which there are at most 256: further ones take
/// their place.
#[test]
fn clients_that_left_with_a_waiting_command_do_not_block_others() {
    let place = TestFolder::scene(&watcher("d", ""));
    let run = RunningProgram::start(&place, ",wait_for=1", &[]);
    let mut first = run.client();
    first.stepping();
    for _ in 0..600 {
        let mut client = run.client();
        client.send(json!({ "call": "sim.wait", "args": [1000.0] }));
    }
    // The first client, which has not left, is still answered, and so is a new one.
    first.step(1);
    let mut last = run.client();
    assert!(last.ask(json!({ "state": true }))["step"].is_u64());
    // A client that has shut down only its sending direction of the connection still receives its answer.
    let mut half = run.client();
    half.send(json!({ "call": "sim.wait", "args": [0.1] }));
    half.end_sending();
    // Its wait begins when its line has arrived.
    while half.is_silent() {
        first.step(1);
    }
    assert_eq!(half.receive()["id"], 1);
    #[cfg(target_os = "linux")]
    {
        let threads = std::fs::read_dir(format!("/proc/{}/task", run.id())).unwrap().count();
        assert!(threads < 600, "{threads} threads");
    }
    first.ask(json!({ "request": "stop" }));
    run.end().good();
}

/// A script that does not return is ended by a client's request to stop.
#[test]
fn a_stop_of_a_client_ends_a_script_that_does_not_return() {
    let script = "function sysCall_actuation() if sim.getInt32Signal('spin') then while true do sim.getSimulationTime() end end end
        function sysCall_cleanup() print('never') end";
    let place = TestFolder::scene(&format!("budget = {{ instructions = 1000000000000 }}\n{}", watcher("d", script)));
    let run = RunningProgram::start(&place, ",wait_for=1", &[]);
    let mut client = run.client();
    client.stepping();
    client.step(1);
    client.call("sim.setInt32Signal", json!(["spin", 1]));
    // Both lines may arrive before the step begins.
    client.send_bytes(b"{\"id\":90,\"step\":1}\n{\"id\":91,\"request\":\"stop\"}\n");
    let ended = run.end();
    assert_eq!(ended.code, Some(1), "{}", ended.err);
    assert!(ended.err.contains("F206") && ended.err.contains("after a stop was requested"), "{}", ended.err);
}

#[test]
fn silent_holder_of_the_run_is_reported_to_clients() {
    let place = TestFolder::scene("");
    let run = RunningProgram::start(&place, "", &[]);
    let (mut still, mut watching) = (run.client(), run.client());
    watching.ask(json!({ "events": true }));
    still.stepping();
    still.step(1);
    // From now on, the first client sends nothing.
    let told = watching.receive();
    assert_eq!(told["event"], "held");
    let text = told["payload"]["text"].as_str().unwrap();
    assert!(text.contains("the service `jsonl`") && text.contains("has held the run for 5 s"), "{text}");
    watching.ask(json!({ "request": "stop" }));
    run.end().good();
}
