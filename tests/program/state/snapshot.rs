//! Tests of snapshots: a run that is saved to a file and continued in a new process is bit-identical to the
//! uninterrupted run in each step. State that cannot be saved is restored by a replay and reported. The expected values
//! are those in the trace of the uninterrupted run.

use std::fs;

use tatu_core::state::Snapshot;

use crate::{
    kit::*,
    state::restart::{registry, world},
};

/// Runs the scene of a folder for ten seconds, then with a snapshot at `at` s, and then from the snapshot. All three
/// must be equal. Returns standard error of the resumed run.
#[track_caller]
fn check_resumed_run(place: &TestFolder, at: f64, watch: &[&str], args: &[&str]) -> String {
    let trace = |name: &str, more: &[&str]| {
        let mut all = vec!["--seconds", "10", "--trace", name];
        watch.iter().for_each(|w| all.extend(["--watch", *w]));
        let done = place.run(&[&all, args, more].concat()).good();
        (place.read(name).lines().map(str::to_owned).collect::<Vec<_>>(), done)
    };
    let (whole, first) = trace("whole.jsonl", &[]);
    let (written, second) = trace("written.jsonl", &["--snapshot-at", &at.to_string(), "state"]);
    assert!(whole == written, "saving a snapshot changed the run");
    assert_eq!(first.out_without_clock(), second.out_without_clock());
    let (rest, third) = trace("rest.jsonl", &["--from", "state"]);
    let done = whole.len() - rest.len();
    let time = whole
        .get(done.wrapping_sub(1))
        .map_or(0.0, |l| serde_json::from_str::<serde_json::Value>(l).unwrap()["time"].as_f64().unwrap());
    assert!((time - at).abs() < 0.051, "the resumed run starts at {time} s");
    for (a, b) in whole[done..].iter().zip(&rest) {
        assert!(a == b, "the resumed run differs:\n{a}\n{b}");
    }
    assert_eq!(first.out_without_clock(), third.out_without_clock());
    third.err
}

impl RunOutput {
    /// Returns the summary without the elapsed time.
    fn out_without_clock(&self) -> serde_json::Value {
        let mut all = self.json();
        (all["wall_s"], all["step_wall_s"]) = (0.into(), 0.into());
        all
    }
}

#[track_caller]
fn restored(err: &str) {
    assert!(!err.contains("replay"), "{err}");
}

/// Drives with every kind of state that a script can hold: shared tables, cycles, metatables, closures, random numbers,
/// pairs.
const STATEFUL_SCRIPT: &str = "
local Wheel = {} Wheel.__index = Wheel
function Wheel.new(name) return setmetatable({handle = sim.getObject('./' .. name), speed = 1}, Wheel) end
function Wheel:turn(by) self.speed = self.speed * 0.9 + by sim.setJointTargetVelocity(self.handle, self.speed) end
local function counter() local n = 0 return function() n = n + 1 return n end, function() return n end end
local count, counted = counter()
local memory = {}
function sysCall_init()
    wheels = {left = Wheel.new('Pioneer_p3dx_leftMotor'), right = Wheel.new('Pioneer_p3dx_rightMotor')}
    wheels.me, wheels.both = wheels, {wheels.left, wheels.right}
    later = {}
end
function sysCall_actuation()
    local n = count()
    memory['at_' .. n % 37], memory[n % 11], memory['at_' .. n % 5] = n, math.random(), nil
    local sum, words = 0, {}
    for k, v in pairs(memory) do sum = (sum * 3 + v) % 7 words[#words + 1] = tostring(k) end
    later[#later + 1] = function() return sum + counted() * 1e-3 end
    if #later > 5 then table.remove(later, 1) end
    wheels.both[1]:turn(later[1]() * 0.1)
    wheels.me.right:turn(math.random() * 0.5)
    sim.setFloatSignal('sum', (sim.getFloatSignal('sum') or 0) + sum)
    sim.addStatusbarMessage(n .. ' ' .. table.concat(words, ' ') .. ' ' .. sim.getFloatSignal('sum') .. ' ' .. sim.getRandom())
end";

#[test]
fn the_first_scene_goes_on() {
    let place = TestFolder::new();
    for file in ["pioneer_avoids_walls.toml", "avoid_walls.lua"] {
        let text = fs::read_to_string(root().join("scenes/first").join(file)).unwrap();
        place.write(if file.ends_with("toml") { "scene.toml" } else { file }, &text);
    }
    let watch = ["/Pioneer_p3dx", "Pioneer_p3dx_ultrasonicSensor4", "Pioneer_p3dx_leftMotor"];
    restored(&check_resumed_run(&place, 5.0, &watch, &[]));
}

#[test]
fn rich_scripts_go_on_with_any_number_of_threads() {
    let robots: Vec<String> =
        (0..10).map(|i| pioneer(STATEFUL_SCRIPT, &format!("position_m = [{}.0, {}.0, 0.0]", i % 4, i / 4))).collect();
    let boxes: Vec<String> = (0..12)
        .map(|i| {
            let at = [0.5 + 0.31 * (i % 5) as f64, 0.5 + 0.9 * (i / 5) as f64, 0.101];
            cuboid(&format!("box_{i}"), [0.2, 0.2, 0.2], at, "respondable = true\ndynamic = true\nmass_kg = 0.5")
        })
        .collect();
    let place = TestFolder::scene(&format!("{FLOOR}{}{}", robots.concat(), boxes.concat()));
    let watch = ["/Pioneer_p3dx[3]", "Pioneer_p3dx_ultrasonicSensor4"];
    restored(&check_resumed_run(&place, 3.0, &watch, &[]));
    restored(&check_resumed_run(&place, 7.0, &watch, &["--threads", "2"]));
}

#[test]
fn snapshots_of_a_resumed_run_go_on_too() {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer(STATEFUL_SCRIPT, "")));
    let whole = place.trace(&["/Pioneer_p3dx"], &["--seconds", "9"]);
    place.run(&["--seconds", "3", "--snapshot-at", "2", "two"]).good();
    place.run(&["--seconds", "5", "--from", "two", "--snapshot-at", "4", "four"]).good();
    let rest = place.trace(&["/Pioneer_p3dx"], &["--seconds", "9", "--from", "four"]);
    assert_eq!(rest.len(), 100);
    assert!(rest.iter().zip(&whole[80..]).all(|(a, b)| a.0 == b.0));
}

#[test]
fn changed_objects_and_script_data_are_restored() {
    let busy = "
    function sysCall_init() made, n = {}, 0 tube = sim.tubeOpen(1, 'line', 5) console = sim.auxiliaryConsoleOpen('log', 10, 0) end
    function sysCall_actuation()
        n = n + 1
        if n % 7 == 0 then
            made[#made + 1] = sim.createPureShape(0, 8 + 4, {0.1, 0.1, 0.1}, 0.2)
            sim.setObjectPosition(made[#made], -1, {0.3 * (n % 5), 0.3 * (n % 3), 1})
        end
        if n % 20 == 0 then sim.removeObject(table.remove(made, 1)) end
        if n == 40 then sim.removeObject(sim.getObject('/gone')) end
        sim.setIntegerSignal('n' .. n % 3, n)
        sim.tubeWrite(tube, 'packet ' .. n)
        sim.auxiliaryConsolePrint(console, n % 4 == 0 and 'end\\n' or 'part ')
    end";
    let other = "
    function sysCall_init() tube = sim.tubeOpen(1, 'line', 3) end
    function sysCall_sensing()
        local words = {}
        for i = 0, 2 do words[#words + 1] = tostring((sim.getIntegerSignal('n' .. i))) end
        if sim.getSimulationTime() % 0.3 < 0.06 then words[#words + 1] = tostring((sim.tubeRead(tube))) end
        sim.addStatusbarMessage(table.concat(words, ' '))
    end";
    let gone = watcher("gone", "function sysCall_actuation() sim.addStatusbarMessage('still here') end");
    let place = TestFolder::scene(&format!("{FLOOR}{}{}{gone}", watcher("maker", busy), watcher("reader", other)));
    for at in [1.5, 6.05] {
        restored(&check_resumed_run(&place, at, &["/maker"], &[]));
    }
}

#[test]
fn a_robot_that_has_fallen_stays_so() {
    let floor = cuboid("ledge", [2.0, 2.0, 1.0], [0.0, 0.0, 0.5], "respondable = true");
    let drive = "function sysCall_actuation()
        for _, side in ipairs({'left', 'right'}) do
            sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_' .. side .. 'Motor'), 6)
        end
    end";
    let robot = pioneer(drive, "position_m = [0.3, 0.0, 1.0]");
    let place = TestFolder::scene(&format!("{FLOOR}{floor}{robot}"));
    restored(&check_resumed_run(&place, 6.0, &["/Pioneer_p3dx"], &[]));
    let end = place.lines("whole.jsonl").pop().unwrap();
    assert!(end.object::<3>("/Pioneer_p3dx", "position")[2] < 0.9, "the robot has not left the ledge");
}

#[test]
fn a_changed_table_order_after_a_restore_is_reported() {
    let script = "function sysCall_actuation()
        local set = {[{}] = 1, [{}] = 2}
        for _ in pairs(set) do end
    end";
    let place = TestFolder::scene(&watcher("thing", script));
    let first = place.run(&["--seconds", "1", "--snapshot-at", "0.5", "state"]).good();
    assert!(!first.err.contains("order"), "{}", first.err);
    let rest = place.run(&["--seconds", "1", "--from", "state"]).good();
    assert_eq!(rest.err.matches("their order may differ").count(), 1, "{}", rest.err);
}

#[test]
fn errors_before_a_snapshot_are_restored() {
    let script = "function sysCall_actuation() if sim.getSimulationTime() > 1 then error('broken') end end";
    let place = TestFolder::scene(&format!("{FLOOR}{}", watcher("thing", script)));
    let whole = place.run(&["--seconds", "4", "--snapshot-at", "2", "state"]);
    let rest = place.run(&["--seconds", "4", "--from", "state"]);
    assert_eq!(whole.errors(), rest.errors());
    assert!(!rest.err.contains("broken"), "the error was already reported before the snapshot: {}", rest.err);
}

/// A script that continues in its own coroutine.
const COROUTINE_SCRIPT: &str = "
function sysCall_init()
    co = coroutine.create(function()
        local speed = 1
        while true do speed = speed * 1.01 coroutine.yield(speed + math.random()) end
    end)
end
function sysCall_actuation()
    local _, speed = coroutine.resume(co)
    sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), speed)
    sim.addStatusbarMessage(tostring(speed))
end";

#[test]
fn a_suspended_coroutine_is_restored_by_replay_and_named() {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer(COROUTINE_SCRIPT, "")));
    let err = check_resumed_run(&place, 5.0, &["/Pioneer_p3dx"], &[]);
    assert!(err.contains("restored by replay"), "{err}");
    assert!(err.contains("/Pioneer_p3dx") && err.contains("variable `co` is a suspended coroutine"), "{err}");
}

#[test]
fn a_waiting_thread_is_restored_by_replay() {
    let threaded = "function sysCall_threadmain() end
    function sysCall_thread()
        while true do sim.wait(0.5) sim.addStatusbarMessage('waited ' .. sim.getSimulationTime()) end
    end";
    let place = TestFolder::scene(&format!("{FLOOR}{}", watcher("waiter", threaded)));
    let err = check_resumed_run(&place, 5.0, &[], &[]);
    assert!(err.contains("restored by replay: the script of /waiter: its thread function is waiting"), "{err}");
}

#[test]
fn files_that_are_not_whole_are_refused() {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer(STATEFUL_SCRIPT, "")));
    place.run(&["--seconds", "1", "--snapshot-at", "0.5", "state"]).good();
    let bytes = fs::read(place.path().join("state")).unwrap();
    let try_with = |bytes: &[u8]| {
        fs::write(place.path().join("bad"), bytes).unwrap();
        place.run(&["--seconds", "1", "--from", "bad"])
    };
    for cut in [0, 1, 7, 8, 11, 12, 19, 20, 21, 1000, bytes.len() / 2, bytes.len() - 1] {
        try_with(&bytes[..cut]).refused(&["E501", "bad: "]);
    }
    for at in [0, 3, 15, 20, 100, 2000, bytes.len() / 3, bytes.len() - 1] {
        let mut changed = bytes.clone();
        changed[at] ^= 0x10;
        try_with(&changed).refused(&["E501"]);
    }
    let mut newer = bytes.clone();
    newer[8] += 1;
    try_with(&newer).refused(&["E502", "this program reads format", "write it again"]);
    try_with(&[&bytes[..], b"more"].concat()).refused(&["E501", "checksum"]);
    place.run(&["--from", "nowhere"]).refused(&["E105", "nowhere"]);
}

#[test]
fn another_scene_is_refused() {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer(STATEFUL_SCRIPT, "")));
    place.run(&["--seconds", "1", "--snapshot-at", "0.5", "state"]).good();
    place.run(&["--seed", "5", "--from", "state"]).refused(&["E502", "a different scene", "--seed"]);
    let text = place.read("scene.toml");
    place.write("scene.toml", &text.replace("0.9", "0.8"));
    place.run(&["--from", "state"]).refused(&["E502", "a different scene"]);
    // The scene's folder and its comments have no effect.
    place.write("scene.toml", &format!("# a comment\n{text}"));
    place.run(&["--seconds", "1", "--from", "state"]).good();
}

#[test]
fn snapshots_that_were_not_written_are_reported() {
    let place = TestFolder::scene(FLOOR);
    let late = place.run(&["--seconds", "1", "--snapshot-at", "5", "state"]);
    assert_eq!(late.code, 1);
    late.reports(&["E505", "state was not written", "1 s"]);
    assert_eq!(place.run(&["--seconds", "1", "--snapshot-at", "0.5", "no/such/folder"]).code, 1);
    place.run(&["--snapshot-at", "soon", "state"]).refused(&["E102", "soon"]);
    place.run(&["--seconds", "1", "--snapshot-at", "0", "a", "--snapshot-at", "0.5", "b"]).good();
    for file in ["a", "b"] {
        place.run(&["--seconds", "1", "--from", file]).good();
    }
}

/// A position target is reached after two steps. A snapshot taken after the first step continues the motion, whereas a
/// restarted run does not continue the motion of the previous run.
#[test]
fn targets_that_are_under_way_go_on() {
    let scene = format!(
        "[[object]]\nkind = \"shape\"\nalias = \"base\"\n\
         [[object]]\nkind = \"joint\"\nalias = \"j\"\nparent = \"base\"\ncontrol = \"position\"\nmax_force_nm = 100.0\n\
         [[object]]\nkind = \"shape\"\nalias = \"arm\"\nparent = \"/base/j\"\ndynamic = true\n{}",
        watcher(
            "hand",
            "function sysCall_actuation()
                local n = math.floor(sim.getSimulationTime() / 0.05 + 0.5)
                sim.setJointTargetPosition(sim.getObject('/base/j'), n % 20 < 10 and 0.5 or -0.5)
            end"
        )
    );
    let place = TestFolder::scene(&scene);
    for at in [1.0, 1.05, 1.1, 1.15] {
        restored(&check_resumed_run(&place, at, &["/base/j"], &[]));
    }
    let world = world(&place.path().join("scene.toml"), &registry());
    let run = || {
        world.start();
        let hashes: Vec<_> = (0..42).map(|_| (world.step(), world.hash()).1).collect();
        world.stop();
        hashes
    };
    let first = run();
    assert_eq!(first, run(), "the second run depends on the first");
}

#[test]
fn worlds_of_one_process_restore_and_start_again() {
    let (registry, place) = (registry(), TestFolder::scene(&format!("{FLOOR}{}", pioneer(STATEFUL_SCRIPT, ""))));
    let new = || world(&place.path().join("scene.toml"), &registry);
    let steps = |w: &tatu_core::World, n| (0..n).for_each(|_| _ = w.step());
    let first = new();
    first.start();
    steps(&first, 60);
    let snapshot = Snapshot::from_bytes(&first.snapshot().unwrap().to_bytes().unwrap()).unwrap();
    assert!(snapshot.is_complete());
    let second = new();
    second.restore(&snapshot, false).unwrap();
    // Both worlds exist at the same time and are stepped alternately.
    for _ in 0..60 {
        assert_eq!(first.hash(), second.hash());
        steps(&first, 1);
        steps(&second, 1);
    }
    assert_eq!(second.restore(&snapshot, false).unwrap_err().code, "E503", "the world has already run");
    let end = first.hash();
    for w in [&first, &second] {
        w.stop();
        w.start();
        steps(w, 120);
        assert_eq!(w.hash(), end, "a restarted run must equal the first");
        w.stop();
        assert_eq!(w.snapshot().unwrap_err().code, "E503", "the world is not running");
    }
}

#[test]
fn scripts_missing_in_a_snapshot_restart_if_allowed() {
    let (registry, robots) =
        (registry(), pioneer(STATEFUL_SCRIPT, "") + &pioneer(COROUTINE_SCRIPT, "position_m = [0.0, 2.0, 0.0]"));
    let place = TestFolder::scene(&format!("{FLOOR}{robots}"));
    let new = || world(&place.path().join("scene.toml"), &registry);
    let steps = |w: &tatu_core::World, n| (0..n).for_each(|_| _ = w.step());
    let whole = new();
    whole.start();
    steps(&whole, 40);
    let snapshot = whole.snapshot().unwrap();
    let [missed] = &snapshot.head.missed[..] else { panic!("{:?}", snapshot.head.missed) };
    assert_eq!(missed.object, "the script of /Pioneer_p3dx[1]");
    let refused = new().restore(&snapshot, false).unwrap_err();
    assert!(refused.code == "E503" && refused.text.contains("`co`"), "{refused}");
    let (partial, replayed) = (new(), new());
    partial.restore(&snapshot, true).unwrap();
    replayed.replay(&snapshot).unwrap();
    for w in [&whole, &partial, &replayed] {
        steps(w, 40);
    }
    assert_eq!(whole.hash(), replayed.hash());
    let robot = |w: &tatu_core::World, path: &str| w.hash().subtree(path);
    assert_eq!(robot(&whole, "/Pioneer_p3dx[0]"), robot(&partial, "/Pioneer_p3dx[0]"), "the other robot differs");
    assert_ne!(robot(&whole, "/Pioneer_p3dx[1]"), robot(&partial, "/Pioneer_p3dx[1]"), "this robot must start over");
    assert_eq!(partial.faults(), []);
}
