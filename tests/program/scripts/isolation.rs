//! Tests of the isolation of scripts: how they cannot affect each other, and what they cannot access.

use crate::kit::*;

/// Scripts that misbehave: the text of `actuation`, the kind of the error, and a part of its message.
const FAULTY_SCRIPTS: &[(&str, &str, &str)] = &[
    ("while true do end", "budget", "instructions"),
    ("while true do pcall(function() while true do end end) end", "budget", "instructions"),
    ("coroutine.wrap(function() while true do end end)()", "budget", "instructions"),
    ("while true do coroutine.wrap(function() for i = 1, 100 do end end)() end", "budget", "instructions"),
    ("table.sort({3, 2, 1}, function() while true do end end)", "budget", "instructions"),
    (
        "setmetatable({}, {__gc = function() while true do end end}) collectgarbage() while true do end",
        "budget",
        "instructions",
    ),
    ("('a'):rep(30):find(('a?'):rep(30)..('a'):rep(30)..'b')", "budget", "instructions"),
    ("('a'):rep(300):gsub(('a-'):rep(20)..'b', '')", "budget", "instructions"),
    ("while true do ('x'):rep(1e6) end", "budget", "instructions"),
    ("local s = 'x' while true do s = (s..s):sub(1, 1e6) end", "budget", "instructions"),
    ("local t = {} while true do t[#t + 1] = {} end", "budget", "memory"),
    ("('x'):rep(1e9)", "budget", "memory"),
    ("local s = 'x' while true do s = s..s end", "budget", "memory"),
    // Blocks of growing size, which cannot reuse freed memory, fill the memory before the limit is reached.
    ("local t = {} while true do t[#t + 1] = ('x'):rep(5000 + #t) end", "budget", "memory"),
    ("local s = ('x'):rep(1e6) while true do s:reverse() end", "budget", "instructions"),
    ("local s = ('x'):rep(1e6) while true do s:upper() end", "budget", "instructions"),
    ("error('every time')", "runtime", "every time"),
    ("coroutine.yield()", "runtime", "outside a coroutine"),
    (
        "while sim.getSimulationTime() == 0 do end while true do local t = os.clock() while os.clock() == t do end end",
        "budget",
        "instructions",
    ),
    ("load('\\27Lua')()", "runtime", "nil value"),
];

#[test]
fn a_faulty_script_does_not_affect_the_other_robot() {
    let drive = "function sysCall_actuation()
        sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 2)
        sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_rightMotor'), 1)
    end";
    let hashes = |way: &str| {
        let bad = format!("function sysCall_actuation()\n{way}\nend");
        // The robots are far from each other.
        let scene = format!(
            "[scene.budget]\ninstructions = 2000000\nmemory_mb = 16\n{}{FLOOR}{}",
            watcher("bad", &bad),
            pioneer(drive, "")
        );
        let place = TestFolder::scene(&scene);
        let done = place.run(&["--steps", "3", "--trace", "t.jsonl", "--hashes"]);
        let robot: Vec<String> =
            place.lines("t.jsonl").iter().map(|l| l.0["hashes"]["/Pioneer_p3dx"].to_string()).collect();
        (robot, done)
    };
    let (alone, done) = hashes("");
    done.good();
    for (way, kind, words) in FAULTY_SCRIPTS {
        let (robot, done) = hashes(way);
        assert_eq!(robot, alone, "{way}");
        let errors = done.errors();
        assert_eq!(errors.len(), 1, "{way}: {errors:?}");
        assert_eq!(errors[0]["kind"], *kind, "{way}: {errors:?}");
        assert_eq!(errors[0]["object"], "/bad", "{way}: {errors:?}");
        assert!(errors[0]["message"].as_str().unwrap().contains(words), "{way}: {errors:?}");
        assert_eq!(errors[0]["line"], 2, "{way}: {errors:?}");
        assert!(errors[0]["traceback"].as_str().is_some_and(|t| !t.is_empty()), "{way}: {errors:?}");
    }
}

#[test]
fn a_script_is_stopped_at_the_same_instruction_in_every_run() {
    // The endless script stores its progress in a signal, which another script prints.
    let bad = "function sysCall_actuation() local n = 0 while true do n = n + 1 sim.setFloatSignal('n', n) end end";
    let told = "function sysCall_sensing() sim.addStatusbarMessage(tostring(sim.getFloatSignal('n'))) end";
    let scene = format!("[scene.budget]\ninstructions = 300000\n{}{}", watcher("bad", bad), watcher("told", told));
    let place = TestFolder::scene(&scene);
    let far = || {
        place.run(&["--steps", "2", "--trace", "t.jsonl"]).errors();
        place.lines("t.jsonl").iter().map(|l| l.status().concat()).collect::<Vec<_>>()
    };
    let first = far();
    assert!(first[0].parse::<f64>().unwrap() > 10_000.0, "{first:?}");
    assert_eq!(first[0], first[1], "the script was called again");
    assert_eq!(first, far());
    assert_eq!(first, far());
}

#[test]
fn budgets_are_set_in_the_scene() {
    let script = "function sysCall_init() for i = 1, 1000000 do end end";
    TestFolder::scene(&watcher("a", script)).run(&["--steps", "1"]).good();
    let errors = TestFolder::scene(&format!("[scene.budget]\ninstructions = 50000\n{}", watcher("a", script)))
        .run(&["--steps", "1"])
        .errors();
    assert!(errors[0]["message"].as_str().unwrap().contains("50000 instructions"), "{errors:?}");
    let place = TestFolder::scene(&watcher("a", script));
    let errors = place.run(&["--steps", "1", "--set", "scene.budget.instructions=50000"]).errors();
    assert_eq!(errors[0]["kind"], "budget");
    // The default budget is 50 million instructions.
    let endless = TestFolder::scene(&watcher("a", "function sysCall_init() while true do end end"));
    let errors = endless.run(&["--steps", "1"]).errors();
    assert!(errors[0]["message"].as_str().unwrap().contains("50000000 instructions"), "{errors:?}");
    TestFolder::scene("[scene.budget]\nmemory = 1\n").run(&[]).refused(&["memory_mb"]);
    TestFolder::scene("[scene.budget]\nmemory_mb = 0\n").run(&[]).refused(&["memory_mb"]);
}

#[test]
fn programs_and_libraries_are_unavailable_unless_allowed() {
    let script = "function sysCall_init()
        sim.addStatusbarMessage(type(os.execute)..' '..type(io.popen)..' '..type(package.loadlib))
        if io.popen then sim.addStatusbarMessage(io.popen('echo from outside'):read('l')) end
        if os.execute then sim.addStatusbarMessage(tostring(os.execute('exit 0'))) end
    end";
    let place = TestFolder::scene(&watcher("a", script));
    let said = |args: &[&str]| {
        let lines = place.trace(&[], &[&["--steps", "1"], args].concat());
        lines[0].status().iter().map(|s| s.to_string()).collect::<Vec<_>>()
    };
    assert_eq!(said(&[]), ["nil nil nil"]);
    assert_eq!(said(&["--allow", "native"]), ["nil nil function"]);
    if cfg!(unix) {
        assert_eq!(said(&["--allow", "exec,native"]), ["function function function", "from outside", "true"]);
    }
    place.tatu(&["run", "scene.toml", "--allow", "all"]).refused(&["exec", "native"]);
    // The error about a missing function states how to allow it.
    let errors = TestFolder::scene(&watcher("a", "function sysCall_init() os.execute('ls') end"))
        .run(&["--steps", "1"])
        .errors();
    assert!(errors[0]["help"].as_str().unwrap().contains("--allow"), "{errors:?}");
}

/// Among a hundred robots that do not meet, a script that never returns is named, and the other 99 are unaffected.
#[test]
fn an_endless_loop_leaves_99_other_robots_alone() {
    let scene: String = (0..100)
        .map(|i| {
            let (x, y) = (5 * (i % 10), 5 * (i / 10));
            format!(
                "[[model]]\nmodel = \"pioneer_p3dx\"\nalias = \"r{i}\"\nposition_m = [{x}, {y}, 0]\nscript = {{ text = '''{DRIVE}''' }}\n"
            )
        })
        .collect();
    const DRIVE: &str = "function sysCall_actuation()
            sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 2)
        end";
    let place = TestFolder::scene(&scene);
    place.write("loop.lua", "function sysCall_actuation() while true do end end");
    let run = |more: &[&str]| place.tatu(&[&["run", "scene.toml", "--steps", "10", "--json"], more].concat()).json();
    let (all, one) = (run(&[]), run(&["--script", "/r42=loop.lua"]));
    let errors = one["errors"].as_array().unwrap();
    assert_eq!(
        (errors.len(), errors[0]["kind"].as_str(), errors[0]["object"].as_str()),
        (1, Some("budget"), Some("/r42"))
    );
    assert_eq!(all["errors"], serde_json::json!([]));
    let same = |i: usize| all["objects"][format!("/r{i}")]["hash"] == one["objects"][format!("/r{i}")]["hash"];
    let changed: Vec<usize> = (0..100).filter(|i| !same(*i)).collect();
    assert_eq!(changed, [42], "only the robot with the endless script may differ");
}
