//! Tests of the behaviour on which scripts of older versions rely: numbers as text, Lua 5.1, call types, and 32-bit
//! numbers.

use crate::kit::*;

/// Returns the strings that a script of a dialect passes to `say(...)` in `init`.
fn status_lines(dialect: &str, text: &str) -> Vec<String> {
    let script = format!(
        "say = simAddStatusbarMessage
        function sysCall_init()
            {text}
        end"
    );
    let place = TestFolder::scene(&format!("dialect = \"{dialect}\"\n{}", watcher("a", &script)));
    place.trace(&[], &["--steps", "1"])[0].status().iter().map(|s| s.to_string()).collect()
}

#[test]
fn numbers_are_written_as_their_time_wrote_them() {
    // See tests/facts/script-api.md, 3: in Lua 5.1 all numbers are floats, printed with %.14g.
    let text = "local t = {[10/2 .. ''] = 'key'}
        say('v='..10/2) say(tostring(10/2)) say(string.format('%s', 10/2)) say(table.concat({10/2, 0.5, -4/2}, ' '))
        say(t['5'] or 'none') say((10/2)..'|'..2^31) say(''..1e15) say(''..2^53) say(('x'):rep(10/2))
        say(tostring(0.1)) say(''..-0.0) say(''..1/0)";
    let plain = [
        "v=5",
        "5",
        "5",
        "5 0.5 -2",
        "key",
        "5|2147483648",
        "1e+15",
        "9.007199254741e+15",
        "xxxxx",
        "0.1",
        "-0",
        "inf",
    ];
    for dialect in ["3.2", "4.1"] {
        assert_eq!(status_lines(dialect, text), plain, "{dialect}");
    }
    let modern = text.replace("simAdd", "sim.add");
    let shown = status_lines("4.9", &modern);
    assert_eq!(shown[..4], ["v=5.0", "5.0", "5.0", "5.0 0.5 -2.0"], "Lua 5.4");
    assert_eq!(shown[4], "none");
}

#[test]
fn scripts_of_both_eras_run_in_one_scene() {
    // The old script calls the new one, which uses the number format of its own dialect. Afterwards the old script
    // still uses the old format.
    let old = "function sysCall_actuation()
        local other = simGetScriptAssociatedWithObject(simGetObjectHandle('new'))
        simAddStatusbarMessage(simCallScriptFunction('told', other, 4/2)..' '..4/2)
    end";
    let new = "function told(x) return 'new '..x end";
    let with = |dialect: &str, alias: &str, text: &str| {
        watcher(alias, text).replace("text =", &format!("dialect = \"{dialect}\", text ="))
    };
    let scene = format!("{}{}", with("4.9", "new", new), with("3.2", "old", old));
    let lines = TestFolder::scene(&scene).trace(&[], &["--steps", "2"]);
    assert_eq!(lines[1].status(), ["new 2.0 2"]);
}

#[test]
fn the_library_of_lua_5_1_is_available() {
    // Lua 5.1 reference manual; tests/facts/script-api.md, 3, lists what scripts use of it.
    let cases = [
        ("local goto = 3 say(''..goto)", "3"),
        (r"say('50\% of \/ \.')", "50% of / ."),
        ("say(table.getn({1, 2})..unpack({7}))", "27"),
        ("say(string.format('%d %i %x', 3.7, -3.7, '255.9'))", "3 -3 ff"),
        ("say(''..loadstring('return 4/2')())", "2"),
        ("local t = {1} table.insert(t, 5.5, 'x') table.remove(t, 9) say(t[5])", "x"),
        ("local t = {} table.insert(t, 3, 'c') say(''..(t[3] or 'none'))", "c"),
        ("say(tostring(NULL)..tostring(null))", "nilnil"),
        ("local function f(...) return arg.n..arg[2] end say(f('a', 'b'))", "2b"),
        ("say(''..math.mod(7, 4)..math.pow(2, 3)..math.log10(1000))", "383"),
        ("say(tostring(math.fmod(1, 0) ~= math.fmod(1, 0)))", "true"),
        ("say(('abc'):sub(1.9, 2.1)..string.rep('-', 2.7)..string.char(65.5))", "ab--A"),
        ("local n = 0 for w in string.gfind('a b', '%a') do n = n + 1 end say(''..n)", "2"),
        ("say(''..12345678901234567890)", "1.2345678901235e+19"),
        ("say(type(setfenv)..type(getfenv(1))..type(table.foreach))", "functiontablefunction"),
    ];
    for (text, told) in cases {
        for dialect in ["2.6", "3.2", "4.1"] {
            assert_eq!(status_lines(dialect, text), [told], "{text} in {dialect}");
        }
    }
}

#[test]
fn numbers_pass_as_32_bit_floats_before_4_5() {
    // tests/facts/script-api.md, 1: simGetFloatSignal after 0.1 gives 0.10000000149012.
    let text = "simSetFloatSignal('x', 0.1) say(''..simGetFloatSignal('x'))
        simSetObjectPosition(simGetObjectHandle('a'), -1, {0.1, 2, 0.3})
        local p = simGetObjectPosition(simGetObjectHandle('a'), -1) say(p[1]..' '..p[2]..' '..p[3])";
    assert_eq!(status_lines("3.2", text), ["0.10000000149012", "0.10000000149012 2 0.30000001192093"]);
    // From 4.5 on all values are doubles (tests/facts/script-api.md, 1).
    assert_eq!(status_lines("4.5", text)[0], "0.1");
    assert_eq!(status_lines("4.4", text)[0], "0.10000000149012");
}

/// Scripts, each with the era that must be detected: A for versions up to 3.4, B for 3.5 to 4.1, C for 4.2 and later.
const ERA_EXAMPLES: &[(&str, &str)] = &[
    // Flat names only.
    ("if (sim_call_type==sim_childscriptcall_actuation) then x = 1 end", "A"),
    ("if (simGetScriptExecutionCount()==0) then x = simGetObjectHandle('t#') end", "A"),
    ("-- sim.setStepping is not meant\nx = simGetSimulationTime() y = 'sim.getObject'", "A"),
    // The name space, in the dialect of 3.5 to 4.1.
    ("if (sim_call_type==sim.syscb_init) then x = sim.getSimulationTime() end", "B"),
    ("function sysCall_init() h = sim.getObjectHandle('t') end", "B"),
    ("function sysCall_threadmain() end function sysCall_cleanup() end", "B"),
    ("function sysCall_init() sim.getSimulationTime() simGetSimulationTime() end", "B"),
    // From 4.2 on.
    ("sim = require('sim') function sysCall_init() end", "C"),
    ("local sim=require'sim'", "C"),
    ("function sysCall_init() h = sim.getObject('/t') end", "C"),
    ("function sysCall_thread() sim.setStepping(true) end", "C"),
    ("function sysCall_actuation() sim.addLog(1, 'x') end", "C"),
    ("x = 7 // 2", "C"),
    // Nothing indicates a version.
    ("x = 1", "C"),
];

#[test]
fn the_era_of_a_text_is_found() {
    let scene: String = ERA_EXAMPLES.iter().enumerate().map(|(i, (text, _))| watcher(&format!("t{i}"), text)).collect();
    let summary = TestFolder::scene(&scene).run(&["--steps", "1"]).json();
    let scripts = summary["scripts"].as_array().unwrap();
    assert_eq!(scripts.len(), ERA_EXAMPLES.len());
    for (i, (script, (text, era))) in scripts.iter().zip(ERA_EXAMPLES).enumerate() {
        assert_eq!(script["object"], format!("/t{i}"));
        assert_eq!(script["era"], *era, "{text}");
        assert_eq!(script["kind"], "child");
    }
    // A given dialect takes precedence.
    let place = TestFolder::scene(&format!("dialect = \"3.2\"\n{}", watcher("a", "function sysCall_thread() end")));
    assert_eq!(place.run(&["--steps", "1"]).json()["scripts"][0]["era"], "A");
}

#[test]
fn calls_are_counted_by_callback() {
    let script = "function sysCall_init() end function sysCall_actuation() end
        function sysCall_sensing() for i = 1, 10000 do end end function sysCall_cleanup() end";
    let summary = TestFolder::scene(&watcher("a", script)).run(&["--steps", "3"]).good().json();
    let a = &summary["scripts"][0];
    for (callback, least) in [("init", 1), ("actuation", 3), ("sensing", 3), ("cleanup", 1)] {
        assert!(a["calls"][callback].as_u64().unwrap() >= least, "{a}");
    }
    assert_eq!(a["calls"]["init"], 1);
    // Three runs of a loop with 10,000 iterations of one instruction each. Instructions are counted in thousands.
    assert!(a["instructions"].as_u64().unwrap() >= 29_000, "{a}");
}

#[test]
fn a_text_of_branches_runs_for_those_it_has() {
    let branches = "if (sim_call_type==sim_childscriptcall_initialization) then n = 0 end
        if (sim_call_type==sim_childscriptcall_actuation) then n = n + 1 print('acts', n) end
        if (sim_call_type==sim_childscriptcall_sensing) then
            -- put some code here
        end
        if (sim_call_type==sim_childscriptcall_cleanup) then print('ends', n) end";
    let outside = format!("{branches} m = (m or 0) + 1");
    for (script, sensing) in [(branches, None), (outside.as_str(), Some(3))] {
        let place = TestFolder::scene(&format!("dialect = \"3.2\"\n{}", watcher("a", script)));
        let ran = place.run(&["--steps", "3"]).good();
        assert!(ran.err.contains("acts\t3") || ran.out.contains("acts\t3"), "{} {}", ran.out, ran.err);
        assert!(ran.err.contains("ends\t") || ran.out.contains("ends\t"), "{} {}", ran.out, ran.err);
        let calls = ran.json()["scripts"][0]["calls"].clone();
        assert_eq!((calls["init"].as_u64(), calls["cleanup"].as_u64()), (Some(1), Some(1)), "{calls}");
        assert!(calls["actuation"].as_u64() >= Some(3), "{calls}");
        assert!(calls["sensing"].as_u64() >= sensing && calls["sensing"].is_u64() == sensing.is_some(), "{calls}");
    }
}

#[test]
fn the_call_type_has_the_numbers_of_its_era() {
    // tests/facts/script-api.md, 1: call types of child scripts.
    for (dialect, names, numbers) in [
        ("3.2", "sim_childscriptcall_", ["0 0", "2 2", "3 3"]),
        ("3.6", "sim_childscriptcall_", ["0 0", "5 5", "6 6"]),
        ("4.9", "sim.childscriptcall_", ["2 2", "6 6", "7 7"]),
    ] {
        let script = format!(
            "local what = {{'initialization', 'actuation', 'sensing'}}
            for i, name in ipairs {{{names}initialization, {names}actuation, {names}sensing}} do
                if sim_call_type == name then simAddStatusbarMessage(name..' '..sim_call_type) end
            end"
        );
        let place = TestFolder::scene(&format!("dialect = \"{dialect}\"\n{}", watcher("a", &script)));
        let lines = place.trace(&[], &["--steps", "1"]);
        assert_eq!(lines[0].status(), numbers, "{dialect}");
    }
    // The same callbacks by their names of 3.5 and later.
    for (dialect, numbers) in [("4.1", ["0", "5", "6"]), ("4.9", ["2", "6", "7"])] {
        let script = "for _, name in ipairs {sim.syscb_init, sim.syscb_actuation, sim.syscb_sensing} do
            if sim_call_type == name then sim.addStatusbarMessage(''..name) end end";
        let place = TestFolder::scene(&format!("dialect = \"{dialect}\"\n{}", watcher("a", script)));
        assert_eq!(place.trace(&[], &["--steps", "1"])[0].status(), numbers, "{dialect}");
    }
}

#[test]
fn an_old_script_is_not_called_after_its_clean_up() {
    // Scripts that use bare globals are called in any scene, and their last call is that for clean-up.
    let script = "print('call '..sim_call_type..' '..(last or ''))
        if sim_call_type == sim_childscriptcall_cleanup then last = 'after clean-up' end";
    let told = TestFolder::scene(&watcher("a", script)).run(&["--steps", "2"]).good().err;
    assert_eq!(told.matches("call 1 ").count(), 1, "{told}");
    assert!(!told.contains("after clean-up"), "{told}");
}

#[test]
fn the_oldest_texts_run_once_a_step() {
    // See tests/facts/script-api.md, 1, first row: scripts use an execution counter that starts at 0, and no call
    // types.
    let script = "if (simGetScriptExecutionCount()==0) then simAddStatusbarMessage('first') end
        simHandleChildScript(sim_handle_all_except_explicit)
        simAddStatusbarMessage('run '..simGetScriptExecutionCount()..' '..tostring(_G['sim_call_'..'type']))";
    let lines = TestFolder::scene(&watcher("a", script)).trace(&[], &["--steps", "3"]);
    assert_eq!(lines[0].status(), ["first", "run 0 nil"]);
    assert_eq!(lines[1].status(), ["run 1 nil"]);
    assert_eq!(lines[2].status(), ["run 2 nil"]);
}
