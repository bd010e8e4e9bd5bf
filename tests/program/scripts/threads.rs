//! Tests of threaded scripts of old and new versions, which run as coroutines that are preempted after a number of
//! instructions.

use crate::kit::*;

/// Returns the lines that scripts and their threads print, step by step.
fn status_lines(scene: &str, steps: &str) -> Vec<Vec<String>> {
    let lines = TestFolder::scene(scene).trace(&[], &["--steps", steps]);
    lines.iter().map(|l| l.status().iter().map(|s| s.to_string()).collect()).collect()
}

#[test]
fn an_old_text_is_a_thread() {
    // See tests/facts/script-api.md, 1: the text runs once, in its thread. This is the usual form around a thread
    // function.
    let script = "simSetThreadSwitchTiming(200)
        threadFunction=function()
            local n = 0
            while simGetSimulationState()~=sim_simulation_advancing_abouttostop do
                simAddStatusbarMessage('tick '..n)
                n = n + 1
                simSwitchThread()
            end
        end
        simAddStatusbarMessage('begins')
        local res, err = xpcall(threadFunction, function(err) return debug.traceback(err) end)
        if not res then simAddStatusbarMessage('Lua runtime error: '..err) end";
    let said = status_lines(&watcher("a", script), "3");
    assert_eq!(said, [vec!["begins", "tick 0"], vec!["tick 1"], vec!["tick 2"]]);
}

#[test]
fn a_thread_waits_in_simulation_time() {
    let script = "simSetThreadAutomaticSwitch(true)
        local ok, err = pcall(function()
            for i = 1, 3 do simAddStatusbarMessage('at '..string.format('%.2f', simGetSimulationTime())) simWait(0.1) end
        end)
        simAddStatusbarMessage(tostring(ok))";
    let said = status_lines(&watcher("a", script), "7").concat();
    assert_eq!(said, ["at 0.00", "at 0.10", "at 0.20", "true"]);
}

/// A thread that never yields, and counts its iterations.
const BUSY: &str = "n = 0 while true do n = n + 1 simSetFloatSignal('n', n) end simSwitchThread()";
/// Prints the counter in each step.
const COUNTER: &str =
    "function sysCall_sensing() simAddStatusbarMessage(string.format('%d', simGetFloatSignal('n') or 0)) end";

#[test]
fn a_busy_thread_is_preempted_at_the_same_place_in_every_run() {
    let scene = format!("{}{}{FLOOR}{}", watcher("busy", BUSY), watcher("other", COUNTER), pioneer("", ""));
    let place = TestFolder::scene(&scene);
    let runs: Vec<(Vec<String>, Vec<String>)> = (0..3)
        .map(|_| {
            let lines = place.trace(&[], &["--steps", "20"]);
            let hashes = lines.iter().map(|l| l.hash().to_owned()).collect();
            (hashes, lines.iter().map(|l| l.status().concat()).collect())
        })
        .collect();
    assert_eq!(runs[0], runs[1]);
    assert_eq!(runs[0], runs[2]);
    // The other script was called in every step, and the thread had advanced before each call.
    let counts: Vec<u64> = runs[0].1.iter().map(|s| s.parse().unwrap()).collect();
    assert_eq!(counts.len(), 20);
    assert!(counts.windows(2).all(|w| w[0] < w[1]), "{counts:?}");
}

#[test]
fn slices_have_the_length_that_is_set() {
    // 1 ms corresponds to 20,000 instructions; the default is 2 ms (docs/guide/scripts.md, "Threads").
    let far = |set: &str| -> f64 {
        let said =
            status_lines(&format!("{}{}", watcher("busy", &format!("{set} {BUSY}")), watcher("other", COUNTER)), "11");
        let at = |i: usize| said[i].concat().parse::<f64>().unwrap();
        (at(10) - at(0)) / 10.0
    };
    let usual = far("");
    for (ms, times) in [(2.0, 1.0), (20.0, 10.0), (200.0, 100.0)] {
        let ratio = far(&format!("simSetThreadSwitchTiming({ms})")) / usual;
        assert!((ratio / times - 1.0).abs() < 0.05, "{ms} ms: {ratio}");
    }
    // Each iteration has five instructions and a call, which cost between 4 and 20 instructions together.
    assert!((2000.0..10_000.0).contains(&usual), "{usual}");
}

#[test]
fn modern_threads_are_preempted_unless_they_step() {
    // See tests/facts/script-api.md, 1: threads are switched automatically except in stepping mode, and `setStepping`
    // returns the level.
    let script = "sim = require('sim')
        function sysCall_thread()
            local before = sim.setStepping(true)
            local level = sim.setStepping(true)
            sim.addStatusbarMessage('levels '..before..' '..level)
            sim.setStepping(0)
            local t = sim.getSimulationTime()
            while sim.getSimulationTime() == t do end
            sim.addStatusbarMessage('time went on')
            sim.setStepping(true)
            sim.step()
            local t = sim.getSimulationTime()
            for i = 1, 1e6 do end
            sim.addStatusbarMessage(tostring(t == sim.getSimulationTime()))
        end
        function sysCall_actuation() sim.addStatusbarMessage('a') end";
    let said = status_lines(&watcher("a", script), "3");
    // The thread continues right before its script's actuation (tests/facts/call-order.md, 1).
    assert_eq!(said, [vec!["levels 0 1", "a"], vec!["time went on", "a"], vec!["true", "a"]]);
}

#[test]
fn threads_of_3_5_have_a_function() {
    let script = "function sysCall_threadmain()
            local h = sim.getObjectAssociatedWithScript(sim.handle_self)
            sim.setThreadAutomaticSwitch(false)
            for i = 1, 2 do sim.addStatusbarMessage('main '..i/1) sim.switchThread() end
        end
        function sysCall_cleanup() print('cleaned') end";
    let place = TestFolder::scene(&watcher("a", script));
    let lines = place.trace(&[], &["--steps", "3"]);
    let said: Vec<_> = lines.iter().map(|l| l.status().concat()).collect();
    assert_eq!(said, ["main 1", "main 2", ""]);
    assert!(place.run(&["--steps", "3"]).good().err.contains("cleaned"));
}

#[test]
fn yields_pass_through_protected_calls_metamethods_and_iterators() {
    let script = "function sysCall_thread()
        local t = setmetatable({}, {__add = function() sim.step() return 1 end, __index = function(_, k) sim.step() return k end})
        local n = t + t
        local k = t.key
        for i in function(_, i) sim.step() i = (i or 0) + 1 return i < 3 and i or nil end do n = n + i end
        local ok = xpcall(function() sim.step() error('x') end, function(e) return e end)
        sim.addStatusbarMessage(n..k..tostring(ok))
    end";
    let said = status_lines(&watcher("a", script), "8");
    // Six waits, one step each.
    assert_eq!(said[6], ["4keyfalse"]);
    assert_eq!(said.concat().len(), 1);
}

#[test]
fn preemption_in_a_sort_or_a_coroutine_is_deferred() {
    // If a thread cannot be preempted, it continues to the next point at which it can. A coroutine in it is never
    // preempted.
    let script = "function sysCall_thread()
        local t = {} for i = 1, 300 do t[i] = (i * 7919) % 503 end
        for round = 1, 5 do table.sort(t, function(a, b) for i = 1, 20 do end return a < b end) end
        local co = coroutine.wrap(function() for i = 1, 1e5 do end coroutine.yield('in') return 'out' end)
        sim.addStatusbarMessage(co()..co()..t[1])
    end";
    assert_eq!(
        status_lines(&watcher("a", script), "3").concat(),
        ["inout0"].map(|s| s.replace('0', &lowest().to_string()))
    );
}

/// Returns the smallest of the numbers that the script sorts.
fn lowest() -> u64 {
    (1..=300).map(|i| (i * 7919) % 503).min().unwrap()
}

#[test]
fn a_thread_that_never_lets_go_is_stopped_by_its_budget() {
    let script = "function sysCall_thread()\nsim.setStepping(true)\nwhile true do end\nend";
    let scene = format!("[scene.budget]\ninstructions = 300000\n{}{}", watcher("a", script), watcher("b", COUNTER));
    let place = TestFolder::scene(&scene);
    let done = place.run(&["--steps", "3", "--trace", "t.jsonl"]);
    let errors = done.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert_eq!((&errors[0]["kind"], &errors[0]["line"]), (&"budget".into(), &3.into()), "{errors:?}");
    assert!(place.lines("t.jsonl").iter().all(|l| l.status().len() == 1), "the other script must continue");
}
