//! Tests of input logs, replays, and the difference of two traces.

use serde_json::{Value, json};

use crate::{
    kit::*,
    remote::jsonl::{RunningProgram, arena},
};

/// Creates a scene of several files with a robot whose script draws random numbers.
fn of_many_files() -> TestFolder {
    let place = TestFolder::scene(&format!(
        "seed = 3\n{FLOOR}[[model]]\nmodel = \"pioneer_p3dx\"\nscript = \"scripts/drive.lua\"\n\
         [[model]]\nmodel = \"parts/gate.toml\"\nposition_m = [3.0, 0.0, 0.0]\n"
    ));
    place.write("parts/gate.toml", &format!("format = 1\n{}", cuboid("post", [0.2; 3], [0.0, 0.0, 0.1], "")));
    place.write("scripts/drive.lua", "function sysCall_actuation()\n  turn(2)\nend\n");
    place.write(
        "other.lua",
        "function sysCall_actuation()
            for _, side in ipairs{'left', 'right'} do
                local motor = sim.getObject('/Pioneer_p3dx_' .. side .. 'Motor')
                sim.setJointTargetVelocity(motor, 1 + math.random())
            end
        end",
    );
    place
}

#[test]
fn a_log_needs_no_scene() {
    let place = of_many_files();
    let changes = ["--seed", "11", "--set", "post.position_m=[0.1, 0.7, 0.1]", "--script", "/Pioneer_p3dx=other.lua"];
    let run = [&["--steps", "50", "--log", "run.log", "--trace", "t.jsonl", "--hashes"][..], &changes].concat();
    place.run(&run).good();
    let other = TestFolder::new();
    std::fs::copy(place.path().join("run.log"), other.path().join("run.log")).unwrap();
    other.tatu(&["run", "--replay", "run.log", "--trace", "t.jsonl", "--hashes"]).good();
    assert_eq!(other.read("t.jsonl"), place.read("t.jsonl"));
    assert_eq!(other.lines("t.jsonl").len(), 50, "the replay must have as many steps as the run");
    // The number of steps is counted from the start, and can be lower or higher than that in the log.
    for steps in ["20", "60"] {
        let done = other.tatu(&["run", "--replay", "run.log", "--steps", steps, "--json"]).good();
        assert_eq!(done.json()["steps"].to_string(), steps);
    }
    // The log contains the scene and the seed: a replay takes neither from the command line.
    other.tatu(&["run", "--replay", "run.log", "--seed", "1"]).refused(&["--replay", "--seed"]);
    other.tatu(&["run", "scene.toml", "--replay", "run.log"]).refused(&["--replay"]);
    other.tatu(&["run"]).refused(&["SCENE"]);
}

#[test]
fn files_read_by_scripts_are_reported_in_a_replay() {
    let script = "function sysCall_init()
        local f = io.open('gains.txt')
        sim.addStatusbarMessage('gain ' .. f:read('l'))
        f:close()
    end";
    let place = TestFolder::scene(&watcher("w", script));
    place.write("gains.txt", "0.5\n");
    place.run(&["--steps", "2", "--log", "run.log"]).good();
    let done = place.tatu(&["run", "--replay", "run.log"]).good();
    done.reports(&["not in the log", "gains.txt"]);
    assert!(done.out.contains("gain 0.5"));
}

#[test]
fn a_pause_of_a_script_does_not_stop_a_replay() {
    let script = "function sysCall_actuation()
        if sim.getSimulationTime() > 0.12 then sim.pauseSimulation() end
        sim.addStatusbarMessage('t ' .. sim.getSimulationTime())
    end";
    let place = TestFolder::scene(&watcher("w", script));
    let run = RunningProgram::start(&place, ",wait_for=1", &["--log", "run.log", "--trace", "t.jsonl"]);
    let mut client = run.client();
    client.ask(json!({ "stepping": false }));
    // A start request takes effect at the end of the barrier. Until then the run is paused.
    let mut last = json!(0);
    for ask in ["start", "start", "start", "stop"] {
        last = loop {
            let now = client.ask(json!({ "state": true }));
            if now["state"] == "paused" && now["step"] != last {
                break now["step"].clone();
            }
        };
        client.ask(json!({ "request": ask }));
    }
    run.end().good();
    place.tatu(&["run", "--replay", "run.log", "--trace", "again.jsonl"]).good();
    assert_eq!(place.read("again.jsonl"), place.read("t.jsonl"));
    assert!(place.lines("t.jsonl").len() >= 6);
}

#[test]
fn the_log_of_a_killed_run_can_be_used() {
    let place = arena();
    let run = RunningProgram::start(&place, ",wait_for=1", &["--log", "run.log"]);
    let mut client = run.client();
    client.stepping();
    let (robot, motor) = (client.handle("/Pioneer_p3dx"), client.handle("/Pioneer_p3dx_leftMotor"));
    let mut seen = Vec::new();
    for i in 0..20 {
        client.call("sim.setJointTargetVelocity", json!([motor, f64::from(i) / 3.0]));
        client.step(1);
        seen.push(numbers(&client.call("sim.getObjectPosition", json!([robot, -1]))[0]));
    }
    // The run ends abruptly, as by SIGKILL.
    drop(run);
    let args = ["run", "--replay", "run.log", "--trace", "t.jsonl", "--watch", "/Pioneer_p3dx"];
    place.tatu(&args).good().reports(&["did not end normally"]);
    let lines = place.lines("t.jsonl");
    assert!(lines.len() >= 20);
    for (line, seen) in lines.iter().zip(&seen) {
        assert_eq!(line.object::<3>("/Pioneer_p3dx", "position").as_slice(), seen);
    }
}

#[test]
fn damaged_logs_are_refused() {
    let place = arena();
    let run = RunningProgram::start(&place, ",wait_for=1", &["--log", "run.log"]);
    let mut client = run.client();
    client.stepping();
    client.handle("/crate");
    client.step(2);
    client.ask(json!({ "request": "stop" }));
    run.end().good();
    let whole = std::fs::read(place.path().join("run.log")).unwrap();
    let lines: Vec<&[u8]> = whole.split_inclusive(|b| *b == b'\n').collect();
    assert_eq!(lines.len(), 4, "header, call, request, end");
    let replay = |bytes: &[u8]| {
        std::fs::write(place.path().join("bad.log"), bytes).unwrap();
        place.tatu(&["run", "--replay", "bad.log", "--steps", "3"])
    };
    // Truncated anywhere: within the header it is not a log; after it, the incomplete line is ignored.
    let header = lines[0].len();
    for cut in (0..whole.len()).step_by(whole.len() / 23) {
        let done = replay(&whole[..cut]);
        match cut {
            _ if cut < header => done.refused(&["E116"]),
            _ => drop(done.good()),
        }
    }
    replay(&whole[..header + 10]).good().reports(&["last line of the input log is incomplete"]);
    // A line in the middle is damaged, out of order, or of an unknown kind.
    for line in ["{\"step\":0", "{}", "nonsense", "\u{0}", "{\"step\":0,\"at\":0,\"service\":\"x\",\"client\":1}"] {
        let bad = [lines[0], line.as_bytes(), b"\n", lines[1]].concat();
        replay(&bad).refused(&["E116", "bad.log", "damaged"]);
    }
    replay(&[lines[0], lines[2], lines[1]].concat()).refused(&["E116", "line 2"]);
    replay(b"{\"tatu_input_log\":99}\n").refused(&["E116", "format 99"]);
    replay(b"step,time\n1,0.05\n").refused(&["E116", "not an input log", "--log"]);
    place.tatu(&["run", "--replay", "none.log"]).refused(&["E105", "none.log"]);
    place.run(&["--log", "no/such/folder/x.log"]).refused(&["E105", "no/such/folder/x.log"]);

    // A different version of a plugin and a missing plugin are reported, and the replay continues.
    let mut head: Value = serde_json::from_slice(lines[0]).unwrap();
    head["plugins"][0]["version"] = json!("99.0.0");
    head["plugins"].as_array_mut().unwrap().push(json!({ "id": "org.example.none", "version": "1.0.0" }));
    head.as_object_mut().unwrap().remove("check");
    let head = head.to_string();
    let rest = [lines[1], lines[3]].concat();
    let other = format!("{},\"check\":\"\"}}\n{}", head.strip_suffix('}').unwrap(), String::from_utf8_lossy(&rest));
    replay(sealed_anew(&other, str::to_owned).as_bytes()).good().reports(&[
        "E117",
        "had version 99.0.0",
        "`org.example.none` 1.0.0 is missing",
    ]);
}

#[test]
fn a_difference_of_traces_names_step_object_and_fields() {
    let place = arena();
    let run = |file: &str, args: &[&str]| {
        place.run(&[&["--steps", "20", "--trace", file], args].concat()).good();
    };
    let diff = |a: &str, b: &str| place.tatu(&["diff", a, b]);
    run("a.jsonl", &["--hashes", "--watch", "crate"]);
    run("same.jsonl", &["--hashes", "--watch", "crate", "--threads", "2"]);
    assert_eq!(diff("a.jsonl", "same.jsonl").good().out, "equal: 20 steps\n");

    // The crate is 1 mm farther away from the first step on, and nothing else differs.
    let moved = ["--set", "crate.position_m=[2.001, 0.0, 0.15]"];
    run("b.jsonl", &[&["--hashes", "--watch", "crate"], &moved[..]].concat());
    let done = diff("a.jsonl", "b.jsonl");
    assert_eq!(done.code, 1);
    assert!(done.out.starts_with("step 1 (t = 0.05 s): /crate\n  "), "{}", done.out);
    assert!(done.out.contains("\n  position: [") && done.out.contains("and [2.00"), "{}", done.out);

    // Without hashes only watched objects can be named.
    run("watched.jsonl", &["--watch", "crate"]);
    run("watched_b.jsonl", &[&["--watch", "crate"], &moved[..]].concat());
    let done = diff("watched.jsonl", "watched_b.jsonl");
    assert!(done.code == 1 && done.out.contains("/crate") && done.out.contains("--hashes"), "{}", done.out);
    run("plain.jsonl", &[]);
    run("plain_b.jsonl", &moved);
    let done = diff("plain.jsonl", "plain_b.jsonl");
    assert!(done.code == 1 && done.out.contains("step 1 ") && done.out.contains("not watched"), "{}", done.out);

    // One trace ends earlier; another file is not a trace.
    place.run(&["--steps", "5", "--trace", "short.jsonl"]).good();
    let done = diff("short.jsonl", "plain.jsonl");
    assert!(done.code == 1 && done.out.contains("5 steps; then short.jsonl ends"), "{}", done.out);
    diff("a.jsonl", "scene.toml").refused(&["E119", "scene.toml"]);
    diff("none.jsonl", "a.jsonl").refused(&["E105", "none.jsonl"]);
    let cut = &place.read("a.jsonl")[..5000];
    place.write("cut.jsonl", cut);
    diff("cut.jsonl", "a.jsonl").refused(&["E119", "cut.jsonl"]);
}

#[test]
fn a_difference_begins_where_the_runs_part() {
    let place = arena();
    let run = RunningProgram::start(&place, ",wait_for=1", &["--log", "run.log", "--trace", "a.jsonl", "--hashes"]);
    let mut client = run.client();
    client.stepping();
    client.step(7);
    let motor = client.handle("/Pioneer_p3dx_leftMotor");
    client.call("sim.setJointTargetVelocity", json!([motor, 0.1 + 0.2]));
    client.step(5);
    client.ask(json!({ "request": "stop" }));
    run.end().good();
    // In a copy of the log, one velocity differs in its last bit. The seventh step is the last with equal hashes.
    let log = place.read("run.log");
    assert!(log.contains("0.30000000000000004"));
    let other = sealed_anew(&log, |line| {
        let line = line.replace("0.30000000000000004", "0.3");
        // Removes the recorded final hash, because that of the changed run is different.
        line.split_once(",\"hash\":").map_or(line.clone(), |(open, _)| open.to_owned())
    });
    place.write("other.log", &other);
    place.tatu(&["run", "--replay", "other.log", "--trace", "b.jsonl", "--hashes"]).good();
    let done = place.tatu(&["diff", "a.jsonl", "b.jsonl"]);
    assert_eq!(done.code, 1);
    assert!(done.out.starts_with("step 8 (t = 0.4 s): /Pioneer_p3dx"), "{}", done.out);
}
