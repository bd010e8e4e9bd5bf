//! Tests of the order in which scripts are called, line by line against tests/facts/call-order.md, sections 1 and 2.
//! Deliberate differences are listed in docs/guide/coming-from-vrep.md, "Order of calls".

use std::sync::Arc;

use tatu_core::{Phase, World, document::ScriptSpec, plugins::Registry};

use crate::{
    kit::*,
    state::restart::{registry, world},
};

/// A script whose callbacks log name, callback, time and state.
pub const LOGGING_SCRIPT: &str = "
local function log(what)
    sim.addStatusbarMessage(string.format('%s %s %.2f %d', NAME, what, sim.getSimulationTime(), sim.getSimulationState()))
end
log('chunk')
for _, callback in ipairs{'info', 'init', 'cleanup', 'nonSimulation', 'beforeSimulation', 'afterSimulation', 'actuation',
        'sensing', 'suspend', 'suspended', 'resume', 'beforeMainScript'} do
    _G['sysCall_' .. callback] = function() log(callback) end
end
";

/// A thread function that ends when the simulation is stopping.
const THREAD_FUNCTION: &str = "
function sysCall_thread()
    sim.addStatusbarMessage('thread of ' .. NAME .. ' begins')
    while not sim.getSimulationStopping() do
        sim.step()
        sim.addStatusbarMessage('thread of ' .. NAME)
    end
    sim.addStatusbarMessage('thread of ' .. NAME .. ' ends')
end
";

fn text(name: &str, more: &str) -> String {
    format!("NAME = '{name}'{LOGGING_SCRIPT}{more}")
}

/// Returns the scene entry of an object with scripts, each given by kind, priority and text.
fn object(alias: &str, parent: &str, scripts: &[(&str, &str, String)]) -> String {
    let parent = if parent.is_empty() { String::new() } else { format!("parent = \"{parent}\"\n") };
    let script = |(kind, priority, text): &(&str, &str, String)| {
        format!("{{ kind = \"{kind}\", priority = \"{priority}\", text = '''{text}''' }}")
    };
    let scripts: Vec<String> = scripts.iter().map(script).collect();
    format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\n{parent}scripts = [{}]\n", scripts.join(", "))
}

/// Adds a script that is not in the document to a world.
fn attach(world: &World, registry: &Registry, kind: &str, name: &str) {
    let language = registry.scripting.languages.iter().position(|l| l.id == "lua").unwrap();
    let spec = ScriptSpec {
        side_by_side: false,
        language,
        dialect: String::new(),
        kind: kind.into(),
        priority: 1,
        name: name.into(),
        text: text(name, "").into_bytes(),
    };
    world.attach(&spec).unwrap();
}

/// Returns the lines printed since the last call.
pub fn take_line_texts(world: &World) -> Vec<String> {
    world.take_lines().into_iter().map(|l| l.text).collect()
}

/// Returns the expected line "NAME CALLBACK TIME STATE" for each name, in order.
fn calls(names: &[&str], callback: &str, at: &str) -> Vec<String> {
    names.iter().map(|n| format!("{n} {callback} {at}")).collect()
}

/// Loads the scene of call-order.md, 1: objects A, A/B, C, D.
fn observed_scene() -> (TestFolder, World, Arc<Registry>) {
    let child = |name: &str, more: &str| ("child", "normal", text(&format!("child {name}"), more));
    let cust = |name: &str| ("customization", "normal", text(&format!("cust {name}"), ""));
    let scene = [
        object("A", "", &[child("A", ""), cust("A")]),
        object("B", "A", &[child("B", ""), cust("B")]),
        object("C", "", &[child("C", THREAD_FUNCTION)]),
        object("D", "", &[child("D", "")]),
    ];
    let place = TestFolder::scene(&scene.concat());
    let registry = registry();
    let world = world(&place.path().join("scene.toml"), &registry);
    attach(&world, &registry, "addon", "add-on");
    attach(&world, &registry, "sandbox", "sandbox");
    // Allows the world to pause, because the test resumes it.
    world.set_interactive(true);
    (place, world, registry)
}

const CHILD_SCRIPTS: [&str; 4] = ["child B", "child A", "child C", "child D"];
/// Scripts that live as long as the world.
const WORLD_SCRIPTS: [&str; 4] = ["cust B", "cust A", "add-on", "sandbox"];
const ALL_SCRIPTS: [&str; 8] = ["child B", "child A", "child C", "child D", "cust B", "cust A", "add-on", "sandbox"];

/// Returns the lines of a complete normal step. `thread` contains the endings of the lines `thread of child C...` that
/// are printed before the actuation of C.
fn step_lines(at: &str, thread: &[&str]) -> Vec<String> {
    let mut out = calls(&ALL_SCRIPTS, "beforeMainScript", at);
    for name in ALL_SCRIPTS {
        if name == "child C" {
            out.extend(thread.iter().map(|t| format!("thread of child C{t}")));
        }
        out.extend(calls(&[name], "actuation", at));
    }
    out.extend(calls(&ALL_SCRIPTS, "sensing", at));
    out
}

#[track_caller]
fn same(moment: &str, got: Vec<String>, wanted: Vec<String>) {
    for (i, (g, w)) in got.iter().zip(&wanted).enumerate() {
        assert_eq!(g, w, "{moment}, call {i}:\n{}", got.join("\n"));
    }
    assert_eq!(got.len(), wanted.len(), "{moment}:\n{}", got.join("\n"));
}

#[test]
fn the_life_of_a_run_is_the_observed_one() {
    let (_place, world, _registry) = observed_scene();
    // Row "first loop pass, stopped".
    world.idle();
    let mut wanted = Vec::new();
    for name in WORLD_SCRIPTS {
        for callback in ["chunk", "info", "init", "nonSimulation"] {
            wanted.extend(calls(&[name], callback, "0.00 0"));
        }
    }
    same("first loop pass, stopped", take_line_texts(&world), wanted);
    // Row "next loop passes, stopped".
    world.idle();
    same("next loop pass, stopped", take_line_texts(&world), calls(&WORLD_SCRIPTS, "nonSimulation", "0.00 0"));
    // Row "start requested".
    world.start();
    same("start requested", take_line_texts(&world), calls(&WORLD_SCRIPTS, "beforeSimulation", "0.00 0"));
    // Row "step 1".
    assert!(world.step());
    let mut wanted = calls(&WORLD_SCRIPTS, "beforeMainScript", "0.00 16");
    for name in CHILD_SCRIPTS {
        for callback in ["chunk", "info", "init"] {
            wanted.extend(calls(&[name], callback, "0.00 16"));
        }
        if name == "child C" {
            wanted.push("thread of child C begins".into());
        }
        wanted.extend(calls(&[name], "actuation", "0.00 16"));
    }
    wanted.extend(calls(&WORLD_SCRIPTS, "actuation", "0.00 16"));
    wanted.extend(calls(&ALL_SCRIPTS, "sensing", "0.00 16"));
    same("step 1", take_line_texts(&world), wanted);
    // Row "step 2, 3".
    for at in ["0.05 17", "0.10 17"] {
        assert!(world.step());
        same("step 2, 3", take_line_texts(&world), step_lines(at, &[""]));
    }
    // Row "pause requested, pass 1" and "pass 2".
    world.request_pause();
    assert!(world.step());
    same("pause requested, pass 1", take_line_texts(&world), step_lines("0.15 17", &[""]));
    assert!(world.step());
    let mut wanted = step_lines("0.20 19", &[""]);
    wanted.extend(calls(&ALL_SCRIPTS, "suspend", "0.25 8"));
    same("pause, pass 2", take_line_texts(&world), wanted);
    // Row "further passes while paused".
    for _ in 0..3 {
        assert!(world.step());
        same("paused", take_line_texts(&world), calls(&ALL_SCRIPTS, "suspended", "0.25 8"));
        assert_eq!((world.phase(), world.steps()), (Phase::Paused, 5));
    }
    // Row "start requested while paused".
    world.request_start();
    same("start requested while paused", take_line_texts(&world), calls(&ALL_SCRIPTS, "resume", "0.25 8"));
    // Row "step after resume".
    assert!(world.step());
    same("step after resume", take_line_texts(&world), step_lines("0.25 20", &[""]));
    assert!(world.step());
    same("the step after that", take_line_texts(&world), step_lines("0.30 17", &[""]));
    // Rows "stop requested, pass 1" to "pass 3".
    world.request_stop();
    assert!(world.step());
    same("stop requested, pass 1", take_line_texts(&world), step_lines("0.35 17", &[""]));
    assert!(world.step());
    same("stop, pass 2", take_line_texts(&world), step_lines("0.40 21", &["", " ends"]));
    assert!(world.step());
    let mut wanted = step_lines("0.45 22", &[]);
    wanted.extend(calls(&CHILD_SCRIPTS, "cleanup", "0.45 22"));
    same("stop, pass 3", take_line_texts(&world), wanted);
    assert!(!world.step(), "the run has ended");
    same("the end", take_line_texts(&world), calls(&WORLD_SCRIPTS, "afterSimulation", "0.50 0"));
    // Row "next pass".
    world.idle();
    same("next pass", take_line_texts(&world), calls(&WORLD_SCRIPTS, "nonSimulation", "0.50 0"));
    // Row "scene load", scripts attached to objects: root first.
    world.end();
    same("scene load", take_line_texts(&world), calls(&["cust A", "cust B", "add-on", "sandbox"], "cleanup", "0.50 0"));
    assert!(world.faults().is_empty(), "{:?}", world.faults());
}

#[test]
fn a_stop_while_paused_resumes_first() {
    // call-order.md, 1: a stop while paused goes to state 20 first.
    let (_place, world, _registry) = observed_scene();
    world.start();
    world.step();
    world.request_pause();
    while world.phase() != Phase::Paused {
        world.step();
    }
    take_line_texts(&world);
    world.stop();
    let states: Vec<String> =
        take_line_texts(&world).into_iter().filter(|l| l.starts_with("child D ")).map(|l| l[8..].to_owned()).collect();
    let at = |s: &str| ["beforeMainScript", "actuation", "sensing"].map(|c| format!("{c} {s}")).to_vec();
    let mut wanted = vec!["resume 0.15 8".to_owned()];
    for state in ["0.15 20", "0.20 17", "0.25 21", "0.30 22"] {
        wanted.extend(at(state));
    }
    wanted.push("cleanup 0.30 22".into());
    assert_eq!(states, wanted);
    assert_eq!(world.phase(), Phase::Stopped);
}

/// Returns the order in which the child scripts of several trees are called in actuation, in a scene with a dialect.
fn order_in(dialect: &str, first: &str) -> Vec<String> {
    let script = |name: &str| {
        let priority = if name == first { "first" } else { "normal" };
        let text = format!("function sysCall_actuation() sim.addStatusbarMessage('{name}') end");
        vec![("child", priority, text)]
    };
    let forest =
        [("X", ""), ("Y", "X"), ("U", "X"), ("Z", ""), ("W", "Z"), ("V", "W"), ("Q2", ""), ("Q1", ""), ("Q0", "")];
    let objects: Vec<String> = forest.iter().map(|(name, parent)| object(name, parent, &script(name))).collect();
    let dialect = if dialect.is_empty() { String::new() } else { format!("dialect = \"{dialect}\"\n") };
    let place = TestFolder::scene(&format!("{dialect}{}", objects.concat()));
    let world = world(&place.path().join("scene.toml"), &registry());
    world.start();
    world.step();
    take_line_texts(&world)
}

#[test]
fn each_dialect_has_its_order() {
    // See call-order.md, 2. A scene without a dialect is treated as modern if it has modern scripts.
    for dialect in ["4.4", "4.9", ""] {
        assert_eq!(order_in(dialect, ""), ["V", "Y", "U", "W", "X", "Z", "Q2", "Q1", "Q0"], "`{dialect}`");
    }
    // Priority has no effect on different objects.
    assert_eq!(order_in("4.9", "Q0"), order_in("4.9", ""));
    // Up to 3.5, trees are processed one by one with parents first, and siblings by execution order.
    for dialect in ["3.2", "3.5"] {
        assert_eq!(order_in(dialect, ""), ["X", "Y", "U", "Z", "W", "V", "Q2", "Q1", "Q0"], "`{dialect}`");
    }
    assert_eq!(order_in("3.2", "Q0"), ["Q0", "X", "Y", "U", "Z", "W", "V", "Q2", "Q1"]);
    assert_eq!(order_in("3.2", "U"), ["X", "U", "Y", "Z", "W", "V", "Q2", "Q1", "Q0"]);
    // From 3.6 to 4.3, trees are processed one by one with descendants first, and siblings by priority.
    for dialect in ["3.6", "4.3"] {
        assert_eq!(order_in(dialect, ""), ["Y", "U", "X", "V", "W", "Z", "Q2", "Q1", "Q0"], "`{dialect}`");
    }
    assert_eq!(order_in("4.3", "U"), ["U", "Y", "X", "V", "W", "Z", "Q2", "Q1", "Q0"]);
}

#[test]
fn scripts_of_one_object_go_by_priority() {
    // See call-order.md, 2: three scripts on one object ran in the order of their priorities first, normal, last.
    let script = |p| ("child", p, format!("function sysCall_actuation() sim.addStatusbarMessage('{p}') end"));
    let place = TestFolder::scene(&object("A", "", &["last", "normal", "first"].map(script)));
    let world = world(&place.path().join("scene.toml"), &registry());
    world.start();
    world.step();
    assert_eq!(take_line_texts(&world), ["first", "normal", "last"]);
    let wrong = place.read("scene.toml").replace("priority = \"last\"", "priority = \"later\"");
    place.write("scene.toml", &wrong);
    place.tatu(&["check", "scene.toml"]).refused(&["E102", "priority `later`", "first, normal, last"]);
}

#[test]
fn an_old_scene_counts_as_old_without_a_dialect() {
    let script = |name: &str| {
        let text = format!("if sim_call_type==sim_childscriptcall_actuation then simAddStatusbarMessage('{name}') end");
        vec![("child", "normal", text)]
    };
    let scene = [object("A", "", &script("A")), object("B", "A", &script("B"))];
    let place = TestFolder::scene(&scene.concat());
    let one = world(&place.path().join("scene.toml"), &registry());
    one.start();
    one.step();
    assert_eq!(take_line_texts(&one), ["A", "B"], "parents must be called first");
    // A scene with a single modern script is treated as modern.
    let modern = ("child", "normal", "function sysCall_actuation() sim.addStatusbarMessage('C') end".to_owned());
    let scene = format!("{}{}", scene.concat(), object("C", "", &[modern]));
    let place = TestFolder::scene(&scene);
    let two = world(&place.path().join("scene.toml"), &registry());
    two.start();
    two.step();
    assert_eq!(take_line_texts(&two), ["B", "A", "C"], "the deepest must be called first");
}
