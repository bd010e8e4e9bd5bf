//! Tests of keys from a file, consoles in the trace, and runs in real time.

use serde_json::json;

use crate::kit::*;

/// A script that prints each key, and moves an object according to its code.
pub const LISTENER: &str = "
function sysCall_init()
    box = sim.getObject('/box')
end
function sysCall_actuation()
    local message, aux = sim.getSimulatorMessage()
    while message ~= -1 do
        sim.addStatusbarMessage(message .. ' ' .. aux[1] .. ' ' .. aux[2])
        local p = sim.getObjectPosition(box, -1)
        sim.setObjectPosition(box, -1, {p[1] + aux[1], p[2] + sim.getSimulationTime(), p[3]})
        message, aux = sim.getSimulatorMessage()
    end
end";

/// Returns a scene with two scripts that read keys, and an object that both move.
fn scene() -> TestFolder {
    let object = |alias: &str| format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\nscript = \"listen.lua\"\n");
    let place = TestFolder::scene(&format!(
        "dt_s = 0.05\n[[object]]\nkind = \"dummy\"\nalias = \"box\"\n{}{}",
        object("one"),
        object("two")
    ));
    place.write("listen.lua", LISTENER);
    place
}

/// Each script receives its own copy of the message about a key. The codes are from tests/facts/script-api.md, 5.
#[test]
fn keys_enter_before_the_first_step_at_or_after_their_time() {
    let place = scene();
    // 0.12 is between the third step, which begins at 0.1, and the fourth.
    place.write("keys.txt", "# a comment\n0 s\n0.12 up\n0.12 2010\n0.3 ctrl+s\n0.3 S\n");
    let lines = place.trace(&["/box"], &["--steps", "8", "--keys", "keys.txt", "--log", "run.log"]);
    let told: Vec<_> = lines.iter().map(|l| l.status().join(", ")).collect();
    let twice = |a: &str, b: &str| format!("6 {a}, 6 {b}, 6 {a}, 6 {b}");
    let expected = ["6 115 0, 6 115 0", "", "", &twice("2007 0", "2010 0"), "", "", &twice("2014 1", "83 0"), ""];
    assert_eq!(told, expected);
    // Three runs in the same folder: the replay needs only the log.
    let hash = |line: Option<&TraceLine>| line.unwrap().hash().to_owned();
    let first = hash(lines.last());
    std::fs::remove_file(place.path().join("keys.txt")).unwrap();
    place.tatu(&["run", "--replay", "run.log", "--trace", "again.jsonl"]).good();
    assert_eq!(hash(place.lines("again.jsonl").last()), first);
    assert!(place.read("run.log").contains(r#""input":"key""#));
}

#[test]
fn lines_that_press_no_key_are_reported() {
    let place = scene();
    place.write("keys.txt", "0 s\nsoon up\n");
    place.run(&["--keys", "keys.txt"]).refused(&["E102", "keys.txt:2", "TIME KEY"]);
    place.run(&["--keys", "none.txt"]).refused(&["E105", "none.txt"]);
    place.write("keys.txt", "0 nokey\n");
    place.run(&["--keys", "keys.txt", "--steps", "2"]).good().reports(&["there is no key `nokey`"]);
}

#[test]
fn a_snapshot_contains_the_keys_pressed_before_it() {
    let place = scene();
    place.write("keys.txt", "0.1 a\n0.3 b\n");
    let keys = ["--keys", "keys.txt", "--steps", "8"];
    let whole = place.run(&[&keys[..], &["--snapshot-at", "0.2", "at.snap"]].concat()).good().json();
    let rest = place.run(&[&keys[..], &["--from", "at.snap"]].concat()).good().json();
    assert_eq!(rest["hash"], whole["hash"]);
}

/// The text of a console grows until a script clears it. The trace of a step contains what was printed in that step.
#[test]
fn console_output_is_in_the_trace() {
    let place = TestFolder::new();
    place.write(
        "s.lua",
        "function sysCall_init() c = sim.auxiliaryConsoleOpen('Log', 10, 0); n = 0 end
         function sysCall_actuation()
            n = n + 1
            if n == 1 then sim.auxiliaryConsolePrint(c, 'a=1'); sim.auxiliaryConsolePrint(c, ' b=2\\n') end
            if n == 2 then sim.auxiliaryConsolePrint(c, nil) end
            if n == 3 then sim.auxiliaryConsolePrint(c, 'x'); sim.auxiliaryConsolePrint(c, nil); sim.auxiliaryConsolePrint(c, 'y') end
         end",
    );
    place.tatu(&["run", "--script", "s.lua", "--stand-ins", "--steps", "4", "--trace", "t.jsonl"]).good();
    let told: Vec<_> = place.lines("t.jsonl").iter().map(|l| l.0["console"].clone()).collect();
    assert_eq!(told, [json!({ "Log": "a=1 b=2\n" }), json!({ "Log": null }), json!({ "Log": "y" }), json!({})]);
}

/// Clocks show the simulated time, which starts with the first second of 2015. In a run at a given speed (`--speed`),
/// they show the system time.
#[test]
fn clocks_are_simulation_time_unless_the_run_is_in_real_time() {
    let place = TestFolder::new();
    place.write(
        "s.lua",
        "function sysCall_actuation()
            print(os.date('%Y'), os.clock() == sim.getSimulationTime(), sim.getSystemTime() == os.clock())
         end",
    );
    let run = |more: &[&str]| {
        let args = ["run", "--script", "s.lua", "--stand-ins", "--steps", "3"];
        place.tatu(&[&args, more].concat()).good().out
    };
    // Three steps, and three passes until the end.
    assert_eq!(run(&[]), "2015\ttrue\ttrue\n".repeat(6));
    let real = run(&["--speed", "40", "--log", "run.log"]);
    assert!(!real.contains("2015") && real.lines().all(|l| l.ends_with("false\ttrue")), "{real}");
    assert_eq!(place.tatu(&["run", "--replay", "run.log"]).good().out, real, "the replay shows other times");
}
