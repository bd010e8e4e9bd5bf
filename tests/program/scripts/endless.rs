//! Tests that scripts whose commands do not end are ended: by their budget, by the watchdog, and by a stop from
//! outside.

use std::process::Command;

use crate::kit::*;

/// A scene with a box and a script, whose loop consists of commands.
fn place(script: &str) -> TestFolder {
    TestFolder::scene(&format!(
        "{FLOOR}[[object]]\nkind = \"shape\"\nalias = \"box\"\n{}",
        watcher("d", &format!("local box = sim.getObject('/box')\n{script}"))
    ))
}

const LOOP: &str = "function sysCall_actuation()\nwhile sim.checkCollision(box, sim.handle_all) >= 0 do end\nend\n";

#[test]
fn commands_cost_the_budget_of_the_script_that_calls_them() {
    for script in [
        LOOP,
        "function sysCall_actuation() while true do pcall(sim.checkCollision, box, sim.handle_all) end end",
        "function sysCall_actuation() coroutine.wrap(function() while true do sim.getObjectPosition(box, -1) end end)() end",
        "function sysCall_actuation() repeat until not sim.getObjects(0, sim.handle_all) end",
        "function f() end
         function sysCall_actuation() while true do sim.callScriptFunction('f', sim.handle_self) end end",
        "function sysCall_actuation() while true do pcall(sim.getObject, '/none') end end",
        "function sysCall_actuation() while true do sim.removeObjects({sim.createDummy(0.1)}) end end",
    ] {
        let place = place(&format!("{script}\nfunction sysCall_cleanup() print('never') end"));
        let args = [
            "run",
            "scene.toml",
            "--steps",
            "3",
            "--no-addons",
            "--json",
            "--set",
            "scene.budget.instructions=2000000",
        ];
        let done = run(program(), place.path(), &args, &[]);
        let errors = done.errors();
        assert_eq!(errors.len(), 1, "{script}: {errors:?}");
        assert_eq!(errors[0]["code"], "F206", "{script}: {errors:?}");
        assert_eq!(errors[0]["object"], "/d");
        assert_eq!(done.json()["steps"], 3, "the run continues");
    }
}

/// The cost depends only on what the commands do, so the script ends in the same place in every run.
#[test]
fn the_budget_of_commands_ends_in_the_same_place() {
    let script = "local n = 0
        function sysCall_actuation() while true do n = n + 1; sim.setIntSignal('n', n); sim.checkCollision(box, sim.handle_all) end end";
    let place = place(script);
    let hash = |threads: &str| {
        let args = [
            "run",
            "scene.toml",
            "--steps",
            "2",
            "--no-addons",
            "--json",
            "--threads",
            threads,
            "--set",
            "scene.budget.instructions=1000000",
        ];
        run(program(), place.path(), &args, &[]).json()["hash"].as_str().unwrap().to_owned()
    };
    let first = hash("1");
    assert_eq!((hash("1"), hash("2")), (first.clone(), first));
}

#[test]
fn a_command_that_fails_with_the_budget_of_another_script_fails_only_itself() {
    let other = "function spin() while true do end end";
    let place = TestFolder::scene(&format!(
        "budget = {{ instructions = 1000000 }}\n{}{}",
        watcher("other", other),
        watcher("d", "function sysCall_actuation()
            local ok, why = pcall(sim.callScriptFunction, 'spin', sim.getScript(sim.scripttype_childscript, sim.getObject('/other')))
            if not told then told = true; print('told', ok, why) end
        end
        function sysCall_cleanup() print('goes on to the end') end")
    ));
    let done = run(program(), place.path(), &["run", "scene.toml", "--steps", "2", "--no-addons"], &[]);
    assert!(done.out.contains("told\tfalse") && done.out.contains("goes on to the end"), "{}{}", done.out, done.err);
}

const LARGE_BUDGET: [&str; 2] = ["--set", "scene.budget.instructions=1000000000000"];

#[test]
fn the_watchdog_looks_at_scripts_that_call_commands() {
    let args = ["run", "scene.toml", "--steps", "1", "--no-addons", "--watchdog", "1"];
    let done = run(program(), place(LOOP).path(), &[&args[..], &LARGE_BUDGET].concat(), &[]);
    assert_eq!(done.code, 1, "{}", done.err);
    done.reports(&["F210", "tatu.script.lua", "has not returned", "/d"]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_any_script() {
    use std::{
        io::{BufRead, BufReader},
        process::Stdio,
    };
    for script in [LOOP, "function sysCall_actuation() while true do end end"] {
        let place = place(&format!("function sysCall_init() print('begins') end\n{script}"));
        // The watchdog ends a run that the interrupt does not end.
        let args = ["run", "scene.toml", "--steps", "1000", "--no-addons", "--watchdog", "250"];
        let mut child = Command::new(program())
            .current_dir(place.path())
            .args([&args[..], &LARGE_BUDGET].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_secs(1));
        succeed(Command::new("kill").args(["-INT", &child.id().to_string()]));
        let err = BufReader::new(child.stderr.take().unwrap());
        let lines: Vec<String> = err.lines().map(Result::unwrap).collect();
        assert_eq!(child.wait().unwrap().code(), Some(1), "{lines:?}");
        assert!(lines.iter().any(|l| l.contains("F206") && l.contains("after a stop was requested")), "{lines:?}");
    }
}
