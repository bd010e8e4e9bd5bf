//! Tests of scripts that run in parallel: which state they read, when their actions take effect, and that results do
//! not depend on the number of threads.

use std::sync::Arc;

use tatu_core::{World, document};

use crate::{kit::*, scripts::order::take_line_texts, state::restart::registry};

/// Returns an object `name` with a joint below it and a script.
fn jointed(name: &str, side_by_side: bool, script: &str) -> String {
    format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"{name}\"\nscript = {{ side_by_side = {side_by_side}, \
         text = '''NAME = '{name}' {script}''' }}\n\
         [[object]]\nkind = \"joint\"\nalias = \"joint\"\nparent = \"{name}\"\n"
    )
}

/// Returns a script that counts, reads the joint of another object, sets its own joint, and prints what it has read.
fn reading_script(other: &str, more: &str) -> String {
    format!(
        "
function sysCall_init() own, other, n = sim.getObject('./joint'), sim.getObject('/{other}/joint'), 0 end
function sysCall_actuation()
    n = n + 1
    local seen = sim.getJointTargetVelocity(other)
    sim.setJointTargetVelocity(own, n)
    print(string.format('%s %d: %g %g at %.2f', NAME, n, seen, sim.getJointTargetVelocity(own), sim.getSimulationTime()))
    {more}
end
function sysCall_cleanup() print(NAME .. ' ends') end"
    )
}

/// Runs a scene with `threads` threads. Returns the lines of each step, the errors, and the last hash.
fn run(scene: &str, threads: usize, steps: usize) -> (Vec<Vec<String>>, Vec<String>, String) {
    let place = TestFolder::scene(scene);
    let registry = registry();
    let document =
        document::load(&place.path().join("scene.toml"), &registry, &document::LoadOptions::default()).unwrap();
    let world = World::with_threads(Arc::new(document), registry, threads).unwrap();
    world.start();
    let mut lines = vec![take_line_texts(&world)];
    for _ in 0..steps {
        world.step();
        lines.push(take_line_texts(&world));
    }
    let faults = world.faults().iter().map(|f| format!("{} {:?} {:?}", f.message, f.line, f.object)).collect();
    let used: u64 = world.scripts().iter().map(|s| s.instructions).sum();
    (lines, faults, format!("{:?} {used}", world.hash().total))
}

/// Runs a scene with one to four threads, whose results must be equal.
#[track_caller]
fn run_all(scene: &str, steps: usize) -> (Vec<Vec<String>>, Vec<String>) {
    let first = run(scene, 1, steps);
    for threads in 2..5 {
        assert_eq!(run(scene, threads, steps), first, "{threads} threads");
    }
    (first.0, first.1)
}

#[test]
fn parallel_scripts_see_the_old_world_and_their_own_changes() {
    let name = |i: usize| format!("r{:02}", i % 70);
    // Each script reads the joint of the previous one, which in sequential execution would already have been set.
    let scene: String = (0..70).map(|i| jointed(&name(i), true, &reading_script(&name(i + 69), ""))).collect();
    let (lines, faults) = run_all(&scene, 4);
    assert_eq!(faults, [""; 0]);
    // In the first step the scripts are initialised one after the other.
    for (step, told) in lines.iter().enumerate().skip(2) {
        let at = 0.05 * (step - 1) as f64;
        let wanted: Vec<String> =
            (0..70).map(|i| format!("{} {step}: {} {step} at {at:.2}", name(i), step - 1)).collect();
        assert_eq!(*told, wanted);
    }
}

#[test]
fn a_serial_script_separates_parallel_ones() {
    let scene = [
        jointed("a", true, &reading_script("d", "")),
        jointed("b", true, &reading_script("a", "")),
        jointed("c", false, &reading_script("b", "")),
        jointed("d", true, &reading_script("c", "")),
        jointed("e", true, &reading_script("d", "")),
    ];
    let (lines, _) = run_all(&scene.concat(), 3);
    // c reads what b has set, and d what c has set, but b and e read neighbours that run in parallel with them.
    let wanted = ["a 3: 2 3", "b 3: 2 3", "c 3: 3 3", "d 3: 3 3", "e 3: 2 3"].map(|l| format!("{l} at 0.10"));
    assert_eq!(lines[3], wanted);
}

#[test]
fn errors_of_parallel_scripts_are_reported_in_script_order() {
    let odd = |i: usize| match i {
        3 => "if n == 2 then error('lost') end",
        5 => "if n == 2 then sim.setObjectPosition(own, {1, 1, 1}) end",
        7 => "if n == 2 then print(NAME, pcall(sim.setInt32Signal, 'x', 1)) end",
        9 => "if n == 2 then return {cmd = 'restart'} end",
        11 => "if n == 2 then return {cmd = 'cleanup'} end",
        13 => "if n == 2 then print(NAME, pcall(io.open, 'x')) end",
        15 => "if n == 2 then sim.wait(0.1) end",
        17 => "if n == 2 then print(NAME, pcall(sim.setJointTargetVelocity, own, 0/0)) end",
        19 => "if n == 2 then while true do end end",
        _ => "",
    };
    let scene: String = (0..40)
        .map(|i| jointed(&format!("r{i:02}"), true, &reading_script(&format!("r{:02}", 39 - i), odd(i))))
        .collect();
    let scene = format!("[scene.budget]\ninstructions = 100000\n{scene}");
    let (lines, faults) = run_all(&scene, 4);
    let second = lines[2].join("\n");
    let place = |what: &str| second.find(what).unwrap_or_else(|| panic!("no `{what}` in\n{second}"));
    let order = [
        "r02 2:",
        "r03 2:",
        "lost",
        "r03 ends",
        "r04 2:",
        "r05 2:",
        "scripts that run in parallel",
        "r05 ends",
        "r06 2:",
        "r07 2:",
        "r07\tfalse",
        "r08 2:",
        "r09 2:",
        "r09 ends",
        "r11 2:",
        "r11 ends",
        "r12 2:",
        "r39 2:",
    ];
    assert!(order.map(place).is_sorted(), "{second}");
    for what in [
        "setInt32Signal: scripts that run in parallel with others (`side_by_side`) cannot call it",
        "expected a number, found NaN",
    ] {
        place(what);
    }
    // r09 has been restarted, but r11 has not.
    let third = lines[3].join("\n");
    assert!(third.contains("r09 1:") && !third.contains("r11 ") && third.contains("r38 3:"), "{third}");
    for (object, what) in [
        ("/r03", "lost"),
        ("/r05", "sim.setObjectPosition"),
        ("/r15", "wait"),
        ("/r19", "instructions for a single call"),
    ] {
        assert!(faults.iter().any(|f| f.contains(object) && f.contains(what)), "{object} {what}: {faults:#?}");
    }
    assert_eq!(faults.len(), 4, "{faults:#?}");
}

#[test]
fn the_clean_up_of_a_failed_script_overrides_its_commands() {
    let stops = "
function sysCall_init() own = sim.getObject('./joint') end
function sysCall_actuation()
    if sim.getSimulationTime() > 0.04 then sim.setJointTargetVelocity(own, 5) error('lost') end
end
function sysCall_cleanup() sim.setJointTargetVelocity(own, -1) end";
    let scene = [jointed("a", true, stops), jointed("b", true, &reading_script("a", ""))];
    let (lines, faults) = run_all(&scene.concat(), 3);
    assert_eq!(lines[3], ["b 3: -1 3 at 0.10"]);
    assert_eq!(faults.len(), 1, "{faults:#?}");
}

#[test]
fn old_names_return_their_values_in_parallel_scripts() {
    let script = "
        if sim_call_type == sim_childscriptcall_initialization then own = simGetObjectHandle('joint') n = 0 end
        if sim_call_type == sim_childscriptcall_actuation then
            n = n + 1
            if n == 2 then simAddStatusbarMessage(NAME .. ' ' .. simSetObjectPosition(own, -1, {0, 0, 1})) end
        end";
    let scene: String = ["a", "b"].map(|name| jointed(name, true, script)).concat();
    let (lines, faults) = run_all(&scene, 3);
    assert_eq!(lines[2].len(), 4, "{:#?}", lines[2]);
    assert!(lines[2][1] == "a -1" && lines[2][3] == "b -1", "{:#?}", lines[2]);
    assert_eq!(faults.len(), 2, "{faults:#?}");
}

#[test]
fn threads_and_waits_work_in_parallel_scripts() {
    let thread = "
function sysCall_thread()
    for i = 1, 3 do print(NAME .. ' ' .. i) sim.wait(0.05) end
end";
    let scene: String = (0..20).map(|i| jointed(&format!("r{i:02}"), true, thread)).collect();
    let (lines, faults) = run_all(&scene, 4);
    assert_eq!(faults, [""; 0]);
    for (step, told) in lines.iter().enumerate().take(4).skip(1) {
        assert_eq!(*told, (0..20).map(|i| format!("r{i:02} {step}")).collect::<Vec<_>>());
    }
}

#[test]
fn side_by_side_must_be_a_boolean() {
    let scene = "[[object]]\nkind = \"dummy\"\nalias = \"a\"\nscript = { text = \"\", side_by_side = \"yes\" }\n";
    TestFolder::scene(scene).tatu(&["run", "scene.toml", "--steps", "1"]).refused(&["side_by_side", "true or false"]);
}
