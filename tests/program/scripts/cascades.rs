//! Tests of scripts that call the scripts of their descendants, as in versions before 3.3, and of scripts of kind
//! `threaded`.

use crate::kit::*;

fn below(parent: &str, alias: &str, script: &str) -> String {
    watcher(alias, script).replace("kind = \"dummy\"", &format!("kind = \"dummy\"\nparent = \"{parent}\""))
}

#[test]
fn a_script_calls_those_below_it_once_with_its_arguments() {
    // See tests/facts/script-api.md, 1: arguments are passed to the scripts of descendants, which are not called again
    // in the same pass.
    let script = |name: &str| {
        format!(
            "if sim_call_type == sim_childscriptcall_actuation then
                local base, text = ...
                simAddStatusbarMessage('{name} '..tostring(base)..tostring(text))
                simHandleChildScripts(sim_call_type, 7, 'q')
                simAddStatusbarMessage('{name} done')
            end
            if sim_call_type == sim_childscriptcall_sensing then
                simAddStatusbarMessage('{name} senses')
            end"
        )
    };
    let scene = format!(
        "dialect = \"3.2\"\n{}{}{}",
        watcher("a", &script("a")),
        below("/a", "b", &script("b")),
        watcher("c", &script("c"))
    );
    for line in &TestFolder::scene(&scene).trace(&[], &["--steps", "2"])[..2] {
        let wanted = ["a nilnil", "b 7q", "b done", "a done", "c nilnil", "c done", "a senses", "b senses", "c senses"];
        assert_eq!(line.status(), wanted);
    }
}

#[test]
fn the_oldest_texts_call_those_below_them() {
    // See tests/facts/script-api.md, 1: the execution count begins at 0.
    let script = |name: &str| {
        format!(
            "local n = simGetScriptExecutionCount()
            simHandleChildScript(sim_handle_all_except_explicit)
            simAddStatusbarMessage('{name} '..n)"
        )
    };
    let scene = format!("{}{}", watcher("a", &script("a")), below("/a", "b", &script("b")));
    let lines = TestFolder::scene(&scene).trace(&[], &["--steps", "2"]);
    assert_eq!(lines[0].status(), ["b 0", "a 0"]);
    assert_eq!(lines[1].status(), ["b 1", "a 1"]);
}

#[test]
fn a_script_of_kind_threaded_runs_as_a_thread() {
    // See tests/facts/script-api.md, 1: threaded child scripts are a separate type, which cannot be recognised from
    // this text.
    let script = "for i = 1, 2 do
            simAddStatusbarMessage('run '..i)
            _G['simSwitch'..'Thread']()
        end
        local me = simGetScriptAssociatedWithObject(simGetObjectHandle('a'))
        simAddStatusbarMessage('script '..tostring(me > 0))";
    let scene = format!("dialect = \"3.2\"\n{}", watcher("a", script)).replace("text =", "kind = \"threaded\", text =");
    let place = TestFolder::scene(&scene);
    let lines = place.trace(&[], &["--steps", "4"]);
    let told: Vec<_> = lines[..4].iter().map(|l| l.status().join(",")).collect();
    assert_eq!(told, ["run 1", "run 2", "script true", ""]);
    assert_eq!(place.run(&["--steps", "1"]).json()["scripts"][0]["kind"], "threaded");
}

#[test]
fn tables_in_tables_reach_other_scripts() {
    let told = "function sysCall_msg(m) simAddStatusbarMessage(m.id..m.data.x..m.data.deep[1].y) end";
    let reports = "sim = require 'sim'
        function sysCall_actuation() sim.broadcastMsg({id = 'hi', data = {x = 3, deep = {{y = 4}}}, z = {a = 1}}) end";
    let scene = format!("{}{}", watcher("a", told), watcher("b", reports));
    assert_eq!(TestFolder::scene(&scene).trace(&[], &["--steps", "1"])[0].status(), ["hi34"]);
}
