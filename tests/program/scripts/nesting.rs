//! Tests of scripts that call each other, remove each other, or never return: the results are well defined, and other
//! scripts continue.

use crate::kit::*;

/// Creates two scripts, `a` and `b`, that can call each other through the variable `other`.
fn pair(a: &str, b: &str) -> TestFolder {
    let find =
        |other| format!("function sysCall_init() other = sim.getScript(sim.scripttype_childscript, '/{other}') end\n");
    TestFolder::scene(&format!("{}{}", watcher("a", &(find("b") + a)), watcher("b", &(find("a") + b))))
}

/// Returns a Lua function that counts down by mutual calls; `at_0` runs in the innermost call.
fn down(at_0: &str) -> String {
    format!(
        "function down(n)
            if n == 0 then {at_0} return 'bottom' end
            return sim.callScriptFunction('down', other, n - 1) .. ' ' .. n
        end"
    )
}

/// Lua code of `a` that starts the calls in the second step, because in the first step the text of `b` has not run yet
/// when `a` is called (tests/facts/call-order.md, 1).
const START_CALLS: &str = "
function sysCall_actuation()
    step = (step or 0) + 1
    if step == 2 then sim.addStatusbarMessage(tostring(down(10))) end
    if step > 2 then sim.addStatusbarMessage('a lives') end
end";

#[test]
fn two_scripts_call_each_other_ten_deep() {
    let place = pair(&(down("") + START_CALLS), &down(""));
    let lines = place.trace(&[], &["--steps", "2"]);
    assert_eq!(lines[1].status()[0], "bottom 1 2 3 4 5 6 7 8 9 10");
}

#[test]
fn one_removes_the_other_s_object_at_the_bottom() {
    // At a depth of ten calls the innermost script is a, which removes b; at nine it is b, which removes a's object.
    for (depth, by_a, by_b) in
        [(10, "sim.removeObject(sim.getObject('/b'))", ""), (9, "", "sim.removeObject(sim.getObject('/a'))")]
    {
        let start = START_CALLS.replace("10", &depth.to_string());
        let b = down(by_b)
            + "\nfunction sysCall_sensing() if sim.getSimulationTime() > 0.09 then sim.addStatusbarMessage('b lives') end end";
        let lines = pair(&(down(by_a) + &start), &b).trace(&[], &["--steps", "4"]);
        // A running call ends as usual, ...
        let expected: Vec<String> = (1..=depth).map(|n| format!(" {n}")).collect();
        assert_eq!(lines[1].status()[0], format!("bottom{}", expected.concat()));
        // ... and a script whose object was removed is not called any more.
        let later: Vec<&str> = lines[2..].iter().flat_map(|l| l.status()).collect();
        assert_eq!(later, if depth == 10 { ["a lives", "a lives"] } else { ["b lives", "b lives"] });
    }
}

#[test]
fn scripts_of_removed_objects_cannot_be_called() {
    // Half way, b removes a's object and calls a again. This raises an error, which propagates through all calls.
    let b = down("").replace("if n == 0", "if n == 5 then sim.removeObject(sim.getObject('/a')) end if n == 0");
    let errors = pair(&(down("") + START_CALLS), &b).run(&["--steps", "3"]).errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert_eq!(errors[0]["kind"], "missing_object", "{errors:?}");

    // An error that a script catches is an ordinary value.
    let b = "function down(n)
        sim.removeObject(sim.getObject('/a'))
        local ok, message = pcall(sim.callScriptFunction, 'down', other, n - 1)
        return tostring(ok) .. ': ' .. tostring(message)
    end";
    let lines = pair(&(down("") + START_CALLS), b).trace(&[], &["--steps", "3"]);
    assert!(lines[1].status()[0].starts_with("false: "), "{:?}", lines[1].status());
    assert_eq!(lines[2].status().len(), 0, "the removed script a is called");
}

#[test]
fn scripts_can_remove_themselves() {
    let script = "function sysCall_actuation()
        sim.removeObject(sim.getObject('.'))
        sim.addStatusbarMessage('last words')
    end";
    let place = TestFolder::scene(&format!("dialect = \"4.2\"\n{}", watcher("a", script)));
    let lines = place.trace(&[], &["--steps", "3"]);
    let told: Vec<&str> = lines.iter().flat_map(|l| l.status()).collect();
    assert_eq!(told, ["last words"]);
}

#[test]
fn endless_recursion_through_commands_ends_with_an_error() {
    let endless = "function down(n) return sim.callScriptFunction('down', other, n + 1) end";
    let place = pair(&(endless.to_owned() + START_CALLS), endless);
    let done = place.run(&["--steps", "3"]);
    done.reports(&[]);
    let errors = done.errors();
    let e = &errors[0];
    assert_eq!((errors.len(), e["object"].as_str()), (1, Some("/a")), "{errors:?}");
    // The error names the chain of calls.
    let words = format!("{} {}", e["message"], e["traceback"]);
    assert!(words.contains("down") && words.contains("64"), "{e}");
    assert_eq!(done.json()["steps"], 3, "the run must continue");
}

#[test]
fn endless_recursion_within_a_script_ends_with_an_error() {
    let place = TestFolder::scene(&watcher("a", "function f() return 1 + f() end\nfunction sysCall_init() f() end"));
    let errors = place.run(&["--steps", "2"]).errors();
    assert!(errors[0]["message"].as_str().unwrap().contains("overflow"), "{errors:?}");
}

/// Creates two robots. The script of the first executes `deed` from 0.5 s on.
fn robots(deed: &str) -> TestFolder {
    let drive = |l, r, deed: &str| {
        format!(
            "function sysCall_actuation()
                sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), {l})
                sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_rightMotor'), {r})
                if sim.getSimulationTime() > 0.49 then {deed} end
            end"
        )
    };
    let (a, b) = (drive(1, 1, deed), drive(2, 1, ""));
    TestFolder::scene(&format!(
        "script_budget = 300000\n{FLOOR}{}{}",
        pioneer(&a, "alias = \"first\""),
        pioneer(&b, "alias = \"second\"\nposition_m = [0.0, 3.0, 0.0]")
    ))
}

#[test]
fn a_script_that_never_ends_is_stopped_and_the_others_do_not_notice() {
    let calm = robots("").run(&["--seconds", "2"]).good().json();
    for deed in [
        "while true do end",
        "while true do pcall(function() while true do end end) end",
        "local co = coroutine.wrap(function() while true do end end) co()",
        "while true do sim.getSimulationTime() end",
        "string.rep('a', 30):find(string.rep('a?', 30) .. string.rep('a', 30) .. 'b') while true do end",
    ] {
        let done = robots(deed).run(&["--seconds", "2"]);
        let (errors, result) = (done.errors(), done.json());
        assert_eq!(errors.len(), 1, "{deed}: {errors:?}");
        let e = &errors[0];
        assert_eq!((e["kind"].as_str(), e["object"].as_str()), (Some("budget"), Some("/first")), "{deed}: {e}");
        assert_eq!(
            (e["line"].as_u64(), e["count"].as_u64()),
            (Some(4), Some(1)),
            "{deed}: expected one error with its line: {e}"
        );
        assert_eq!(result["steps"], 40);
        assert_eq!(result["objects"]["/second"], calm["objects"]["/second"], "{deed}");
    }
}

#[test]
fn a_script_with_an_error_leaves_the_others_alone() {
    let calm = robots("").run(&["--seconds", "2"]).good().json();
    for deed in [
        "error('mine')",
        "local x = nil + 1",
        "sim.removeModel(sim.getObject('.'))",
        "local t = {} while true do t[#t + 1] = ('x'):rep(1e6) end",
    ] {
        let done = robots(deed).run(&["--seconds", "2"]);
        done.reports(&[]);
        assert_eq!(done.json()["objects"]["/second"], calm["objects"]["/second"], "{deed}");
    }
}
