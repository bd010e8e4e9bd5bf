//! Tests of script errors: their kinds, their handling in scripts of old and new versions, and their hints for
//! beginners.

use serde_json::Value;

use crate::kit::*;

/// Returns the errors of a run of two steps with a script in a dialect.
fn errors(script: &str, dialect: &str) -> Vec<Value> {
    let dialect = if dialect.is_empty() { String::new() } else { format!("dialect = \"{dialect}\"\n") };
    TestFolder::scene(&format!("{dialect}{}", watcher("a", script))).run(&["--steps", "2"]).errors()
}

#[test]
fn every_mistake_has_its_kind() {
    let cases = [
        ("simIGL.setup(1)", "unknown_function", "`simIGL`"),
        ("simFooBar(1)", "unknown_function", "`simFooBar`"),
        ("sim.fooBar(1)", "unknown_function", "`sim.fooBar`"),
        ("require('simIGL')", "unsupported", "`simIGL`"),
        ("require 'simIGL'", "unsupported", "`simIGL`"),
        ("require 'socket.http'", "unsupported", "`socket.http`"),
        ("sim.getObjectPosition({}, -1)", "bad_argument", "sim.getObjectPosition"),
        ("local x = nothing + 1", "runtime", "arithmetic on a nil value"),
        ("error('own words')", "runtime", "own words"),
        ("x = robot.arm", "runtime", "index a nil value (global 'robot')"),
    ];
    for (text, kind, words) in cases {
        let found = errors(&format!("function sysCall_init()\n{text}\nend"), "4.9");
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        assert_eq!(found[0]["kind"], kind, "{text}: {found:?}");
        assert!(found[0]["message"].as_str().unwrap().contains(words), "{text}: {found:?}");
        // Lines are counted from the opening quotes, so the first line of text is line 2.
        assert_eq!(found[0]["line"], 2, "{text}: {found:?}");
    }
    // Unknown names are nil, so scripts can test whether they exist.
    let asks = "function sysCall_init() if simIGL or simExtFoo or sim.fooBar then error('there') end end";
    TestFolder::scene(&watcher("a", asks)).run(&["--steps", "1"]).good();
}

#[test]
fn old_scripts_go_on_after_an_error() {
    // See tests/facts/script-api.md, 2: up to 4.1 an error ends the call, and the script is called again in the next
    // step.
    for dialect in ["3.2", "4.1"] {
        let script = "function sysCall_actuation()
            n = (n or 0) + 1
            simAddStatusbarMessage('before '..n)
            local x = nothing + 1
            simAddStatusbarMessage('after')
        end
        function sysCall_sensing() simAddStatusbarMessage('sensing') end";
        let place = TestFolder::scene(&format!("dialect = \"{dialect}\"\n{}", watcher("a", script)));
        let done = place.run(&["--steps", "3", "--trace", "t.jsonl"]);
        let errors = done.errors();
        assert_eq!(errors.len(), 1, "expected one error: {errors:?}");
        assert!(errors[0]["count"].as_u64().unwrap() >= 3, "expected a higher count: {errors:?}");
        let lines = place.lines("t.jsonl");
        assert_eq!(lines[2].status(), ["before 3", "sensing"], "{dialect}");
    }
}

#[test]
fn flat_names_go_on_after_a_refusal_and_new_names_raise() {
    let script = "function sysCall_init()
        simAddStatusbarMessage('handle '..tostring(simGetObjectParent(9999)))
        simAddStatusbarMessage('value '..tostring(simGetObjectPosition(9999, -1)))
        simAddStatusbarMessage('new '..tostring(pcall(sim.getObjectParent, 9999)))
    end";
    for dialect in ["3.2", "4.1"] {
        let place = TestFolder::scene(&format!("dialect = \"{dialect}\"\n{}", watcher("a", script)));
        let done = place.run(&["--steps", "1", "--trace", "t.jsonl"]);
        assert_eq!(done.errors().len(), 2, "{dialect}");
        // See tests/facts/script-api.md, 2: after an error, handles are -1 and values are nil.
        let told = place.lines("t.jsonl")[0].status().join(",");
        assert!(told.starts_with("handle -1,value nil,new false"), "{told}");
    }
    // Errors in different lines are reported separately.
    let script = "function sysCall_actuation()
        h = simGetObjectHandle('Pionier')
        simSetJointTargetVelocity(h, 1)
        h = simGetObjectHandle('Pionier')
    end";
    let lines: Vec<_> = errors(script, "3.2").iter().map(|e| (e["line"].as_u64(), e["file"].is_string())).collect();
    assert_eq!(lines, [(Some(2), true), (Some(3), true), (Some(4), true)]);
    // From 4.2 on, flat names raise errors too (tests/facts/call-order.md, 5).
    let script = "function sysCall_init() sim.addStatusbarMessage(tostring(pcall(simGetObjectParent, 9999))) end";
    let lines =
        TestFolder::scene(&format!("dialect = \"4.9\"\n{}", watcher("a", script))).trace(&[], &["--steps", "1"]);
    assert!(lines[0].status()[0].starts_with("false"), "{:?}", lines[0].status());
}

#[test]
fn common_script_errors_include_help() {
    let cases = [
        // A misspelt command, a misspelt function of the script, and a misspelt variable.
        ("sim.setJointTargetVelocty(1, 2)", "there is no command", "did you mean `sim.setJointTargetVelocity`?"),
        ("simGetObjectHandel('a')", "there is no command", "did you mean `simGetObjectHandle`?"),
        ("drvie()", "attempt to call a nil value (global 'drvie')", "did you mean `drive`?"),
        (
            "local v = speeed * 2",
            "attempt to perform arithmetic on a nil value (global 'speeed')",
            "did you mean `speed`?",
        ),
        ("local t = {} print(t.a.b)", "attempt to index a nil value (field 'a')", "`a` is nil"),
    ];
    for (text, words, help) in cases {
        let script = format!("speed = 1\nfunction drive() end\nfunction sysCall_init()\n{text}\nend");
        let found = errors(&script, "4.9");
        assert!(found[0]["message"].as_str().unwrap().contains(words), "{found:?}");
        assert!(found[0]["help"].as_str().unwrap().contains(help), "{found:?}");
        assert_eq!(found[0]["line"], 4, "{found:?}");
    }
    let cases = [
        ("function sysCall_init()\nif x then\ny = 1\nend", "'end' expected", "of line 1 has none"),
        ("if x = 1 then end", "'then' expected near '='", "`==`"),
        ("x = 'open", "unfinished string", "same line"),
        ("for i = 1, 3 do end end", "<eof> expected near 'end'", "this `end` does not belong to a block"),
    ];
    for (script, words, help) in cases {
        let found = errors(script, "");
        assert!(found[0]["message"].as_str().unwrap().contains(words), "{found:?}");
        assert!(found[0]["help"].as_str().unwrap_or_default().contains(help), "{found:?}");
        assert!(found[0]["line"].as_u64().is_some(), "{found:?}");
    }
}

#[test]
fn the_first_line_is_short() {
    let script = "function inner() error('deep') end\nfunction sysCall_init() inner() end";
    let done = TestFolder::scene(&watcher("a", script)).run(&["--steps", "1"]);
    let line = done.err.lines().find(|l| l.contains("deep")).unwrap();
    assert!(line.len() < 100, "{line}");
    assert!(done.errors()[0]["traceback"].as_str().unwrap().contains("inner"));
}

/// Endless loops of C functions are stopped with an error of their script, and the run continues.
#[test]
fn loops_of_the_library_use_up_a_budget() {
    let calls = [
        "table.remove(setmetatable({}, {__len = function() return 1e15 end}), 1)",
        "load(function() return ' ' end)",
        "load(os.time)",
        "local s = ('x'):rep(1e6) while true do s:upper() end",
    ];
    let scene: String = calls
        .iter()
        .enumerate()
        .map(|(i, call)| watcher(&format!("bad{i}"), &format!("function sysCall_actuation()\n{call}\nend")))
        .collect();
    let good = watcher("good", "function sysCall_actuation() print('step', sim.getSimulationTime()) end");
    let done =
        TestFolder::scene(&format!("[scene.budget]\ninstructions = 1000000\n{scene}{good}")).run(&["--steps", "3"]);
    let found = done.errors();
    let codes: Vec<_> = found.iter().map(|e| (e["code"].as_str().unwrap(), e["count"].as_u64())).collect();
    assert_eq!(codes, [("F206", Some(1)); 4], "{found:?}");
    assert_eq!(done.json()["steps"], 3);
}
