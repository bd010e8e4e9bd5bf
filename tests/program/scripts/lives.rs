//! Tests of the effects of scripts on each other and on physics, and of the end of a run, line by line against
//! tests/facts/call-order.md, 1, 3 and 4, and tests/facts/script-api.md, 2.

use tatu_core::{Phase, World};

use crate::{
    kit::*,
    scripts::order::take_line_texts,
    state::restart::{registry, world},
};

/// Loads a scene and starts its world.
pub fn started(scene: &str) -> (TestFolder, World) {
    let place = TestFolder::scene(scene);
    let world = world(&place.path().join("scene.toml"), &registry());
    world.start();
    (place, world)
}

/// Returns child scripts on A/B, A and C, and a customization script on A, in the order of their calls (call-order.md,
/// 1).
fn four(script: impl Fn(&str) -> String) -> String {
    let one = |kind: &str, name: &str| format!("{{ kind = \"{kind}\", text = '''{}''' }}", script(name));
    format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"A\"\nscripts = [{}, {}]\n\
         [[object]]\nkind = \"dummy\"\nalias = \"B\"\nparent = \"A\"\nscripts = [{}]\n\
         [[object]]\nkind = \"dummy\"\nalias = \"C\"\nscripts = [{}]\n",
        one("child", "parent"),
        one("customization", "cust"),
        one("child", "child"),
        one("child", "sibling")
    )
}

/// A script that reads all signals at the start of each callback, and then sets its own signal.
const SIGNALS: &str = "
local function look(when)
    local seen = {}
    for _, who in ipairs{'child', 'parent', 'sibling', 'cust'} do
        local value = sim.getInt32Signal(who)
        seen[#seen + 1] = who .. '=' .. (value or '-')
    end
    sim.addStatusbarMessage(NAME .. ' ' .. when .. ': ' .. table.concat(seen, ' '))
end
step = 0
function sysCall_init() look('init') end
function sysCall_actuation()
    step = step + 1
    look('actuation')
    sim.setInt32Signal(NAME, 10 * step)
end
function sysCall_sensing()
    look('sensing')
    sim.setInt32Signal(NAME, 10 * step + 1)
end
function sysCall_cleanup() look('cleanup') end
function sysCall_afterSimulation() look('after') end
";

#[test]
fn signals_are_seen_in_the_step_that_was_observed() {
    let (_place, world) = started(&four(|name| format!("NAME = '{name}'{SIGNALS}")));
    take_line_texts(&world);
    world.step();
    // call-order.md, 4: a signal that a script sets in actuation is visible to later scripts in the same actuation (in
    // step 1 already in `init`), and to earlier scripts in the sensing of the same step. A signal set in sensing is
    // visible to later scripts in the same sensing.
    let wanted = [
        "child init: child=- parent=- sibling=- cust=-",
        "child actuation: child=- parent=- sibling=- cust=-",
        "parent init: child=10 parent=- sibling=- cust=-",
        "parent actuation: child=10 parent=- sibling=- cust=-",
        "sibling init: child=10 parent=10 sibling=- cust=-",
        "sibling actuation: child=10 parent=10 sibling=- cust=-",
        "cust actuation: child=10 parent=10 sibling=10 cust=-",
        "child sensing: child=10 parent=10 sibling=10 cust=10",
        "parent sensing: child=11 parent=10 sibling=10 cust=10",
        "sibling sensing: child=11 parent=11 sibling=10 cust=10",
        "cust sensing: child=11 parent=11 sibling=11 cust=10",
    ];
    assert_eq!(take_line_texts(&world), wanted);
    // Signals that a later script sets in sensing are visible in the actuation of the next step.
    world.step();
    assert_eq!(take_line_texts(&world)[0], "child actuation: child=11 parent=11 sibling=11 cust=11");
    world.stop();
    let lines = take_line_texts(&world);
    let last: Vec<&str> =
        lines.iter().map(String::as_str).filter(|l| !l.contains("ing:") && !l.contains("uation:")).collect();
    // In `cleanup` of child scripts all signals still exist. The signals of child scripts are removed before
    // `afterSimulation`, but those of customization scripts are not. The run has two steps, and three passes after the
    // stop request.
    let all = "child=51 parent=51 sibling=51 cust=51";
    let wanted = [
        format!("child cleanup: {all}"),
        format!("parent cleanup: {all}"),
        format!("sibling cleanup: {all}"),
        "cust after: child=- parent=- sibling=- cust=51".into(),
    ];
    assert_eq!(last, wanted);
}

#[test]
fn tubes_carry_packets_in_the_step_that_was_observed() {
    // call-order.md, 4: the parent, which is called later, reads in the same actuation what the child has written in
    // actuation. The child reads what the parent has written in the sensing of the same step. Each packet can be read
    // only once; afterwards the result is nil.
    let script = |name: &str| {
        format!(
            "local function read(when)
                local data = sim.tubeRead(tube)
                sim.addStatusbarMessage('{name} ' .. when .. ' ' .. (data or 'nil'))
            end
            function sysCall_init() tube = sim.tubeOpen(0, 'both', 1) end
            function sysCall_actuation()
                read('actuation')
                sim.tubeWrite(tube, '{name}' .. string.format('%.2f', sim.getSimulationTime()))
            end
            function sysCall_sensing() read('sensing') read('again') end"
        )
    };
    let object = |alias: &str, parent: &str, name: &str| {
        format!(
            "[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\n{parent}scripts = [{{ text = '''{}''' }}]\n",
            script(name)
        )
    };
    let (_place, world) = started(&(object("A", "", "parent") + &object("B", "parent = \"A\"\n", "child")));
    // In step 1 the second end of the tube is opened after the first has written. The rule applies from step 2 on.
    world.step();
    take_line_texts(&world);
    world.step();
    let wanted = [
        "child actuation nil",
        "parent actuation child0.05",
        "child sensing parent0.05",
        "child again nil",
        "parent sensing nil",
        "parent again nil",
    ];
    assert_eq!(take_line_texts(&world), wanted);
}

#[test]
fn an_error_of_a_modern_script_silences_it_until_the_next_start() {
    // call-order.md, 4: a runtime error in actuation.
    let script = |name: &str| {
        format!(
            "local function log(what) sim.addStatusbarMessage('{name} ' .. what) end
            function sysCall_init() log('init') n = 0 end
            function sysCall_actuation()
                n = n + 1
                log('actuation ' .. n)
                if '{name}' == 'parent' and n == 2 then error('mine') end
            end
            function sysCall_sensing() log('sensing ' .. n) end
            function sysCall_cleanup() log('cleanup') end"
        )
    };
    let (_place, world) = started(&four(script));
    let status =
        |world: &World| -> Vec<String> { take_line_texts(world).into_iter().filter(|l| !l.contains("mine")).collect() };
    world.step();
    take_line_texts(&world);
    world.step();
    let of_parent: Vec<String> = status(&world);
    let wanted = [
        "child actuation 2",
        "parent actuation 2",
        "parent cleanup",
        "sibling actuation 2",
        "cust actuation 2",
        "child sensing 2",
        "sibling sensing 2",
        "cust sensing 2",
    ];
    assert_eq!(of_parent, wanted);
    world.stop();
    let lines = status(&world);
    assert!(!lines.iter().any(|l| l.starts_with("parent")), "{lines:?}");
    assert_eq!(world.faults().len(), 1);
    world.start();
    world.step();
    let lines = status(&world);
    assert!(lines.iter().any(|l| l == "parent init") && lines.iter().any(|l| l == "parent actuation 1"), "{lines:?}");
    // script-api.md, 2: up to 4.1 the script is called again in the next step.
    let old = "n = 0 function sysCall_actuation() n = n + 1 simAddStatusbarMessage('call '..n) error('mine') end";
    let place = TestFolder::scene(&format!("dialect = \"4.1\"\n{}", watcher("A", old)));
    let done = place.run(&["--steps", "3"]);
    assert_eq!(done.errors()[0]["count"], 6, "expected three steps and three passes after the stop request");
}

#[test]
fn a_stop_restores_poses_and_removes_new_objects() {
    // call-order.md, 4: positions of objects and joints are restored, and objects created during the simulation are
    // removed. The visibility layer is not restored.
    let script = "function sysCall_actuation()
            if made then return end
            made = sim.createDummy(0.01)
            sim.setObjectAlias(made, 'made')
            sim.setObjectPosition(sim.getObject('/moved'), {1, 2, 3})
            sim.setJointPosition(sim.getObject('/hinge'), 0.5)
            sim.setObjectInt32Param(sim.getObject('/moved'), sim.objintparam_visibility_layer, 256)
        end";
    let scene = format!(
        "{}[[object]]\nkind = \"dummy\"\nalias = \"moved\"\n[[object]]\nkind = \"joint\"\nalias = \"hinge\"\nmode = \"kinematic\"\n",
        watcher("mover", script)
    );
    let (_place, world) = started(&scene);
    world.step();
    assert!(world.faults().is_empty(), "{:?}", world.faults());
    let seen = |path: &str| world.observe(path);
    assert_eq!(seen("/moved").unwrap().pose[..3], [1.0, 2.0, 3.0]);
    assert_eq!(seen("/hinge").unwrap().joint.unwrap()[0], 0.5);
    assert!(seen("/made").is_some());
    world.stop();
    assert_eq!(seen("/moved").unwrap().pose[..3], [0.0, 0.0, 0.0]);
    assert_eq!(seen("/hinge").unwrap().joint.unwrap()[0], 0.0);
    assert!(seen("/made").is_none());
    assert_eq!(world.property("/moved", "object.layer").map(|v| format!("{v:?}")).unwrap(), "Int(256)");
}

#[test]
fn physics_has_its_callbacks_between_its_steps() {
    // call-order.md, 3, with physics steps of 5 ms: a box resting on a floor, a joint that a script controls. In
    // V-REP, `contact` for a contact that exists at the start comes before the first `dyn`; here it is called after
    // the physics step in which the contact begins, as for all others.
    let log = |name: &str, more: &str| {
        format!(
            "local function log(text) sim.addStatusbarMessage('{name} ' .. text) end
            function sysCall_dyn(d)
                log(string.format('dyn %d %d %s %g', d.passCnt, d.totalPasses, tostring(d.afterStep), d.dt))
            end {more}"
        )
    };
    let child = log(
        "child",
        "function sysCall_joint(d)
            log(string.format('joint %d %d %d %g %s', d.mode, d.passCnt, d.totalPasses, d.dt, tostring(d.first)))
            return {vel = 2, force = 1000}
        end
        function sysCall_contact(d) log('contact') end",
    );
    let scene = format!(
        "physics_dt_s = 0.005\n{FLOOR}{}{}\
         [[object]]\nkind = \"joint\"\nalias = \"hinge\"\nparent = \"base\"\ncontrol = \"callback\"\n{}\
         [[object]]\nkind = \"dummy\"\nalias = \"D\"\nscripts = [{{ text = '''{child}''' }}, \
         {{ kind = \"customization\", text = '''{}''' }}]\n",
        cuboid("box", [0.2, 0.2, 0.2], [0.0, 0.0, 0.1], "dynamic = true\nrespondable = true\nmass_kg = 1.0"),
        cuboid("base", [0.2, 0.2, 0.2], [3.0, 0.0, 1.0], ""),
        cuboid("arm", [0.1, 0.1, 0.1], [0.0, 0.0, 0.0], "parent = \"hinge\"\ndynamic = true\nmass_kg = 1.0"),
        log("cust", "")
    );
    let (_place, world) = started(&scene);
    take_line_texts(&world);
    for step in 0..3 {
        world.step();
        let mut wanted = Vec::new();
        for n in 1..=10 {
            for who in ["child", "cust"] {
                wanted.push(format!("{who} dyn {n} 10 false 0.005"));
            }
            wanted.push(format!("child joint 5 {n} 10 0.005 {}", step == 0 && n == 1));
            if step == 0 && n == 1 {
                wanted.push("child contact".into());
            }
            for who in ["child", "cust"] {
                wanted.push(format!("{who} dyn {n} 10 true 0.005"));
            }
        }
        assert_eq!(take_line_texts(&world), wanted, "step {step}");
    }
    // The joint has the velocity that the callbacks return: 2 rad/s for three steps of 50 ms.
    let [position, velocity, _] = world.observe("/base/hinge").unwrap().joint.unwrap();
    assert!((position - 0.3).abs() < 0.01 && (velocity - 2.0).abs() < 1e-3, "{position} {velocity}");
    assert!(world.faults().is_empty(), "{:?}", world.faults());
}

#[test]
fn the_answer_to_a_contact_applies_from_the_next_physics_step() {
    // A box slides over the floor. With friction 0 it keeps its speed, and without a collision response it falls
    // through.
    let fall = |answer: &str| {
        let script = format!("function sysCall_contact(d) return {answer} end");
        let body = "dynamic = true\nrespondable = true\nmass_kg = 1.0\nfriction = 1.0";
        let scene = format!(
            "physics_dt_s = 0.005\n{FLOOR}{}{}",
            cuboid("box", [0.2, 0.2, 0.2], [0.0, 0.0, 0.1], body),
            watcher("w", &script)
        );
        let (_place, world) = started(&scene);
        for _ in 0..20 {
            world.step();
        }
        assert!(world.faults().is_empty(), "{:?}", world.faults());
        world.observe("/box").unwrap().pose[2]
    };
    assert!((fall("nil") - 0.1).abs() < 1e-3);
    assert!((fall("{collisionResponse = true, bullet = {friction = 0}}") - 0.1).abs() < 1e-3);
    // Free fall for 1 s minus the physics step in which it started: 0.5 * 9.81 * 0.995^2 = 4.86 m.
    let z = fall("{collisionResponse = false}");
    assert!((z - (0.1 - 4.86)).abs() < 0.05, "{z}");
}

#[test]
fn a_script_may_end_or_restart_itself_or_hold_a_step_back() {
    // script-api.md, 1: the values that a callback can return.
    let script = "function sysCall_init() sim.addStatusbarMessage('init') n = 0 end
        function sysCall_actuation() n = n + 1 sim.addStatusbarMessage('n ' .. n) if n == 2 then return {cmd = 'WHAT'} end end
        function sysCall_cleanup() sim.addStatusbarMessage('cleanup') end";
    for (what, wanted) in [
        ("cleanup", vec!["init", "n 1", "n 2", "cleanup"]),
        ("restart", vec!["init", "n 1", "n 2", "cleanup", "init", "n 1", "n 2", "cleanup"]),
    ] {
        let (_place, world) = started(&watcher("A", &script.replace("WHAT", what)));
        for _ in 0..4 {
            world.step();
        }
        let lines = take_line_texts(&world);
        assert_eq!(lines[..wanted.len()], wanted, "{what}: {lines:?}");
        assert!(world.faults().is_empty(), "{:?}", world.faults());
    }
    // With `doNotRunMainScript` the main script is not called, and time does not advance.
    let hold = "n = 0 function sysCall_beforeMainScript() n = n + 1 return {doNotRunMainScript = n % 2 == 1} end
        function sysCall_actuation() sim.addStatusbarMessage(string.format('%.2f', sim.getSimulationTime())) end";
    let scene = format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"H\"\nscript = {{ kind = \"customization\", text = '''{hold}''' }}\n"
    );
    let (_place, world) = started(&scene);
    for _ in 0..4 {
        world.step();
    }
    assert_eq!(take_line_texts(&world), ["0.00", "0.05"]);
    assert_eq!((world.steps(), world.time()), (4, 0.1));
    world.stop();
    assert_eq!(world.phase(), Phase::Stopped, "a script must not prevent a stop");
}

#[test]
fn passes_after_a_stop_are_traced_and_not_counted() {
    let script = "function sysCall_actuation()
        sim.addStatusbarMessage('state ' .. sim.getSimulationState() .. ' ' .. tostring(sim.getSimulationStopping()))
        if STOP and sim.getSimulationTime() > 0.12 then STOP = false sim.stopSimulation() end
    end";
    for (asks, args, steps, states) in [
        // After a request between two passes, an ordinary pass follows.
        (false, &["--steps", "3"][..], 3, vec![16, 17, 17, 17, 21, 22]),
        // A script requests the stop in the fourth pass, which is counted; the run ends as usual.
        (true, &["--steps", "50"][..], 4, vec![16, 17, 17, 17, 21, 22]),
    ] {
        let place = TestFolder::scene(&watcher("A", &format!("STOP = {asks} {script}")));
        let done = place.run(&[&["--trace", "t.jsonl"], args].concat()).good();
        let result = done.json();
        assert_eq!(result["steps"], steps);
        let all = place.all_lines("t.jsonl");
        let wanted: Vec<String> = states.iter().map(|s| format!("state {s} {}", *s > 20)).collect();
        assert_eq!(all.iter().flat_map(|l| l.status()).collect::<Vec<_>>(), wanted);
        let counted: Vec<bool> = all.iter().map(|l| !l.is_stopping()).collect();
        assert_eq!(counted.iter().filter(|c| **c).count() as u64, steps);
        assert!(counted[..steps as usize].iter().all(|c| *c));
        assert_eq!(all[steps as usize - 1].hash(), result["hash"].as_str().unwrap());
    }
}

#[test]
fn a_pause_that_cannot_be_lifted_ends_the_run_with_a_message() {
    let script = "function sysCall_actuation() if sim.getSimulationTime() > 0.12 then sim.pauseSimulation() end end
        function sysCall_suspend() sim.addStatusbarMessage('suspended') end";
    let done = TestFolder::scene(&watcher("A", script)).run(&["--steps", "50"]).good();
    // The pause is requested in the fourth step; the fifth is the last before the pause.
    assert_eq!(done.json()["steps"], 5);
    done.reports(&["suspended", "nothing can resume it"]);
}

/// A plugin in C with a command that adds a script to an object.
const ADDER: &str = r#"
#include "tatu.h"
static const tatu_host_scripts *scripts;
static tatu_status init(const tatu_host *host, void **self, tatu_error *error) {
  (void)self; (void)error;
  scripts = host->service(host, TATU_HOST_SCRIPTS);
  return scripts && TATU_HAS(scripts, add) ? TATU_OK : TATU_ERR;
}
static tatu_str text(const char *s) {
  tatu_str out = {s, 0};
  while (s[out.len]) out.len++;
  return out;
}
static tatu_status run(tatu_call *call) {
  tatu_object made = 0;
  return scripts->add(call->world, (tatu_object)tatu_arg_int(call, 0), text("lua"), text(""), text("child"),
                      text("late"), tatu_arg_text(call, 1), &made);
}
static const tatu_name name = {.size = sizeof name, .name = "script.add"};
static const tatu_name *const names[] = {&name, 0};
static const tatu_command command = {.size = sizeof command, .flags = TATU_COMMAND_RAW, .names = names, .call = run};
static const tatu_command *const commands[] = {&command, 0};
static const tatu_ext_command ext = {.size = sizeof ext, .commands = commands};
static const void *extension(void *self, const char *id) {
  (void)self;
  const char *want = TATU_COMMAND;
  while (*want && *want == *id) want++, id++;
  return *want == *id ? &ext : 0;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.adder", .name = "Adder", .version = "0.1.0", .licence = "MIT",
  .init = init, .extension = extension};
"#;

#[test]
fn a_script_added_in_actuation_begins_in_the_sensing_of_that_step() {
    // call-order.md, 4: if a script is created in the actuation of step n, its chunk and `init` run in the sensing part
    // of step n, after the existing scripts. `sensing` is called from step n on, `actuation` from n + 1.
    let late = "sim.addStatusbarMessage('late chunk')
        for _, c in ipairs{'init', 'actuation', 'sensing', 'cleanup'} do
            _G['sysCall_' .. c] = function() sim.addStatusbarMessage('late ' .. c) end
        end";
    let script = format!(
        "function sysCall_actuation()
            sim.addStatusbarMessage('actuation')
            if sim.getSimulationTime() == 0 then script.add(sim.getObject('/A/B'), [[{late}]]) end
        end
        function sysCall_sensing() sim.addStatusbarMessage('sensing') end"
    );
    let below = "[[object]]\nkind = \"dummy\"\nalias = \"B\"\nparent = \"A\"\n";
    let place = TestFolder::scene(&format!("plugins = [\".\"]\n{}{below}", watcher("A", &script)));
    place.write("adder.c", ADDER);
    let (include, out) = (root().join("plugin-api/include"), library("tatu_adder"));
    let mut cc = std::process::Command::new(compiler("cc"));
    cc.args(["-std=c11", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-shared", "-fPIC", "-I"]).arg(include);
    succeed(cc.args(["-o", &out, "adder.c"]).current_dir(place.path()));
    let done = place.run(&["--steps", "2", "--trace", "t.jsonl"]).good();
    let status: Vec<String> = place.all_lines("t.jsonl").iter().flat_map(|l| l.status()).map(str::to_owned).collect();
    let first = ["actuation", "sensing", "late chunk", "late init", "late sensing"];
    assert_eq!(status[..5], first, "{}", done.err);
    // From the next step on it is called in the regular order, in which the deepest objects come first.
    assert_eq!(status[5..9], ["late actuation", "actuation", "late sensing", "sensing"]);
    assert_eq!(status.last().unwrap(), "late cleanup");
}

/// A window of a customization script stays open after a run and in the next run, but that of a child script does not.
#[test]
fn windows_of_customization_scripts_outlive_the_run() {
    let child = "simUI = require 'simUI'
        function sysCall_init() ui = simUI.create('<ui><label id=\"1\" text=\"child\"/></ui>') end
        function sysCall_actuation() sim.addStatusbarMessage('child ' .. ui) end";
    let customization = "simUI = require 'simUI'
        function sysCall_init() ui = simUI.create('<ui><label id=\"1\" text=\"cust\"/></ui>') end
        function sysCall_afterSimulation()
            simUI.setLabelText(ui, 1, simUI.getLabelText(ui, 1) .. '+')
            sim.addStatusbarMessage('after ' .. simUI.getLabelText(ui, 1))
            sim.addStatusbarMessage('gone ' .. tostring(pcall(simUI.getLabelText, ui + 1, 1)))
        end
        function sysCall_cleanup()
            simUI.destroy(ui)
            sim.addStatusbarMessage('closed')
        end";
    let scene = format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"D\"\nscripts = [{{ kind = \"customization\", text = \'\'\'{customization}\'\'\' }}, {{ text = \'\'\'{child}\'\'\' }}]\n"
    );
    let (_place, world) = started(&scene);
    for after in ["cust+", "cust++"] {
        world.step();
        world.stop();
        let lines: Vec<String> = take_line_texts(&world).into_iter().filter(|l| l != "child 2").collect();
        assert_eq!(lines, [format!("after {after}"), "gone false".into()]);
        world.start();
    }
    world.end();
    assert!(world.faults().is_empty(), "{:?}", world.faults());
    assert!(take_line_texts(&world).contains(&"closed".to_owned()));
}
