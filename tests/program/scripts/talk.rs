//! Tests of messages between scripts, and of the state that outlives a run (tests/facts/call-order.md, 4).

use tatu_core::{World, document::ScriptSpec};

use crate::{
    kit::*,
    scripts::order::take_line_texts,
    state::restart::{registry, world},
};

fn object(alias: &str, parent: &str, scripts: &[(&str, &str)]) -> String {
    let parent = if parent.is_empty() { String::new() } else { format!("parent = \"{parent}\"\n") };
    let all: Vec<_> =
        scripts.iter().map(|(kind, text)| format!("{{ kind = \"{kind}\", text = '''{text}''' }}")).collect();
    format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\n{parent}scripts = [{}]\n", all.join(", "))
}

fn started(scene: &str) -> (TestFolder, World) {
    let place = TestFolder::scene(scene);
    let world = world(&place.path().join("scene.toml"), &registry());
    world.start();
    (place, world)
}

fn status(world: &World) -> Vec<String> {
    take_line_texts(world).into_iter().filter(|l| l.starts_with("> ")).map(|l| l[2..].to_owned()).collect()
}

// A broadcast is delivered during the call to the other scripts in their order: child scripts, deepest first, and then
// customization scripts.
#[test]
fn a_broadcast_reaches_the_others_within_the_call() {
    let hears = |name: &str| {
        format!("function sysCall_msg(m, origin) sim.addStatusbarMessage('> {name} ' .. m.id .. ' ' .. m.data.n) end")
    };
    let sends = format!(
        "{}\nfunction sysCall_actuation()
            sim.addStatusbarMessage('> before')
            sim.broadcastMsg({{id = 'hello', data = {{n = 3}}}})
            sim.addStatusbarMessage('> behind')
        end",
        hears("sender")
    );
    let scene = [
        object("A", "", &[("child", &sends), ("customization", &hears("cust"))]),
        object("B", "A", &[("child", &hears("deep"))]),
        object("C", "", &[("child", &hears("late"))]),
    ]
    .concat();
    let (_place, world) = started(&scene);
    world.step();
    // In the first step C has not been initialized when A is called.
    assert_eq!(status(&world), ["before", "deep hello 3", "cust hello 3", "behind"]);
    world.step();
    assert_eq!(status(&world), ["before", "deep hello 3", "late hello 3", "cust hello 3", "behind"]);
}

// When a run stops, model properties are restored, but custom data blocks are not.
#[test]
fn a_stop_leaves_custom_data_and_restores_model_properties() {
    let script = "function sysCall_init()
            a = sim.getObject('/A')
            sim.writeCustomStringData(a, 'tag', 'first')
        end
        function sysCall_actuation()
            sim.writeCustomStringData(a, 'tag', 'then')
            sim.setModelProperty(a, sim.modelproperty_not_visible)
        end
        function sysCall_sensing()
            sim.addStatusbarMessage('> ' .. sim.readCustomStringData(a, 'tag') .. ' ' .. sim.getModelProperty(a))
        end
        function sysCall_afterSimulation() sysCall_sensing() end";
    let (_place, world) = started(&object("A", "", &[("customization", script)]));
    world.step();
    let running = status(&world);
    world.stop();
    let stopped = status(&world);
    assert_eq!(running, ["then 256"], "sim.modelproperty_not_visible is 0x100: script-api.md, appendix A");
    assert_eq!(stopped.last().map(String::as_str), Some("then 61440"), "0xF000: not a model, as before");
}

// Signals of customization scripts and of the sandbox remain after a run; those of child scripts are removed before
// `afterSimulation`.
#[test]
fn signals_of_the_sandbox_stay() {
    let child = "function sysCall_actuation() sim.setInt32Signal('child', 1) end";
    let place = TestFolder::scene(&object("A", "", &[("child", child)]));
    let registry = registry();
    let world = world(&place.path().join("scene.toml"), &registry);
    let language = registry.scripting.languages.iter().position(|l| l.id == "lua").unwrap();
    let text = "function sysCall_actuation() sim.setInt32Signal('sandbox', 2) end
        function sysCall_afterSimulation()
            sim.addStatusbarMessage('> ' .. tostring(sim.getInt32Signal('child') or '-') .. ' ' .. (sim.getInt32Signal('sandbox') or '-'))
        end";
    let spec = ScriptSpec {
        side_by_side: false,
        language,
        dialect: "4.9".into(),
        kind: "sandbox".into(),
        priority: 1,
        name: "sandbox".into(),
        text: text.into(),
    };
    world.attach(&spec).unwrap();
    world.idle();
    world.start();
    world.step();
    world.stop();
    assert_eq!(status(&world), ["- 2"], "{:?}", world.faults());
}

// A user who edits a script or restarts the run must see that the error is still there.
#[test]
fn an_error_is_reported_once_in_each_run() {
    let script = "function sysCall_actuation() error('mine') end";
    let (_place, world) = started(&object("A", "", &[("child", script)]));
    for run in 1..=3 {
        world.step();
        world.step();
        world.stop();
        let lines = world.take_lines();
        assert_eq!(lines.iter().filter(|l| l.text.contains("mine")).count(), 1, "run {run}: {lines:?}");
        world.start();
    }
    let faults = world.faults();
    assert!(faults.len() == 1 && faults[0].count >= 3, "{faults:?}");
}
