//! Tests of determinism: the same scene and seed give the same bytes in every run and with any number of threads, also
//! if scripts run; two robots of one model are independent.

use crate::kit::*;

/// Uses everything that differs from run to run in ordinary Lua: the order of keys of every type, addresses, the clock,
/// and random numbers. The results are written to the status bar, to a signal and to the wheels, so the trace and the
/// hash depend on them.
const NONDETERMINISTIC_SCRIPT: &str = "
local function digest(t)
    local words = {}
    for k, v in pairs(t) do words[#words + 1] = tostring(k) .. '=' .. tostring(v) end
    return table.concat(words, ' ')
end
function sysCall_init()
    left = sim.getObject('./Pioneer_p3dx_leftMotor')
    right = sim.getObject('./Pioneer_p3dx_rightMotor')
    names, keys = {}, {}
    for i = 1, 40 do names['name_' .. (i * 7919) % 41] = i end
    for i = 1, 20 do keys[{}] = i keys[function() return i end] = -i end
    keys[print], keys[math.sin], keys[coroutine.create(print)], keys[io.write] = 'print', 'sin', 'coroutine', 'write'
end
function sysCall_actuation()
    local first = 0
    for _, v in pairs(keys) do if type(v) == 'number' then first = v break end end
    keys[{}], names[tostring({})] = math.random(100), os.clock()
    local words = digest(names) .. ' | ' .. digest(keys) .. ' | ' .. os.time() .. ' ' .. os.date()
    sim.addStatusbarMessage(words)
    print({}, print, words, string.format('%s %p', {}, keys))
    sim.setStringSignal('words', words)
    sim.setJointTargetVelocity(left, 2 + math.random() + first / 100)
    sim.setJointTargetVelocity(right, 2 + math.random() - os.clock() / 100)
end";

/// Creates a scene with three robots that run [`NONDETERMINISTIC_SCRIPT`] among boxes.
fn restless() -> TestFolder {
    let robots: Vec<String> =
        (0..3).map(|i| pioneer(NONDETERMINISTIC_SCRIPT, &format!("position_m = [0.0, {}.0, 0.0]", 2 * i))).collect();
    let boxes: Vec<String> = (0..20)
        .map(|i| {
            let at = [1.2 + 0.31 * (i % 5) as f64, 0.9 * (i / 5) as f64, 0.101];
            cuboid(&format!("box_{i}"), [0.2, 0.2, 0.2], at, "respondable = true\ndynamic = true\nmass_kg = 0.5")
        })
        .collect();
    TestFolder::scene(&format!("{FLOOR}{}{}", robots.concat(), boxes.concat()))
}

/// Returns trace and standard error of a run.
fn record(place: &TestFolder, args: &[&str]) -> (Vec<String>, String) {
    let all = [&["--seconds", "5", "--trace", "t.jsonl", "--watch", "/Pioneer_p3dx[1]"], args].concat();
    let done = place.run(&all).good();
    (place.read("t.jsonl").lines().map(str::to_owned).collect(), done.err)
}

#[track_caller]
fn same(a: &(Vec<String>, String), b: &(Vec<String>, String)) {
    // 100 steps, and three passes after the stop request.
    assert_eq!(a.0.len(), 103);
    for (i, (x, y)) in a.0.iter().zip(&b.0).enumerate() {
        assert!(x == y, "step {}:\n{x}\n{y}", i + 1);
    }
    assert_eq!(a.1, b.1, "the printed lines differ");
}

#[test]
fn runs_repeat() {
    let place = restless();
    same(&record(&place, &[]), &record(&place, &[]));
}

#[test]
fn threads_do_not_change_results() {
    let place = restless();
    let one = record(&place, &["--threads", "1"]);
    same(&one, &record(&place, &["--threads", "2"]));
    same(&one, &record(&place, &["--threads", "5"]));
}

#[test]
fn the_seed_changes_random_numbers() {
    let script = "function sysCall_actuation()
        sim.addStatusbarMessage(string.format('%.17g %d %.17g', math.random(), math.random(1000), sim.getRandom()))
    end";
    let place = TestFolder::scene(&format!("seed = 5\n{}{}", watcher("a", script), watcher("b", script)));
    let told = |args: &[&str]| -> Vec<String> {
        let lines = place.trace(&[], &[&["--steps", "5"], args].concat());
        lines.iter().flat_map(|l| l.status().iter().map(|s| s.to_string()).collect::<Vec<_>>()).collect()
    };
    let (five, again, seven) = (told(&[]), told(&["--seed", "5"]), told(&["--seed", "7"]));
    assert_eq!(five, again, "--seed must have the same effect as the scene's own seed");
    assert_eq!(told(&["--set", "scene.seed=7"]), seven);
    for i in 0..10 {
        assert_ne!(five[i], seven[i], "different seeds must give different numbers");
        for j in 0..i {
            assert_ne!(five[i], five[j], "different scripts and steps must give different numbers");
        }
    }
}

#[test]
fn an_added_sensor_does_not_change_the_hash() {
    // Random numbers are replaced by constants, because those of a script depend on when it was created.
    let calm = NONDETERMINISTIC_SCRIPT.replace("math.random(100)", "7").replace("math.random()", "0.5");
    let robot = format!("{FLOOR}{}", pioneer(&calm, ""));
    let sensor =
        "[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"feeler\"\nposition_m = [0.0, 0.0, 1.0]\n";
    let hashes = |scene: &str| -> Vec<String> {
        let lines = TestFolder::scene(scene).trace(&[], &["--steps", "40"]);
        lines.iter().map(|l| l.hash().to_owned()).collect()
    };
    let alone = hashes(&robot);
    assert_eq!(alone, hashes(&format!("{robot}{sensor}")), "a sensor after the robot changes its motion");
    assert_eq!(alone, hashes(&format!("{sensor}{robot}")), "a sensor before the robot changes its motion");
}

#[test]
fn two_robots_are_moved_by_their_own_scripts() {
    // One robot drives ahead, and the other turns on the spot. The old dialect refers to motors by name, the new one by
    // path.
    let old = |l, r| {
        format!(
            "if sim_call_type == sim_childscriptcall_actuation then
                simSetJointTargetVelocity(simGetObjectHandle('Pioneer_p3dx_leftMotor'), {l})
                simSetJointTargetVelocity(simGetObjectHandle('Pioneer_p3dx_rightMotor'), {r})
            end"
        )
    };
    let new = |l, r| {
        format!(
            "function sysCall_actuation()
                sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), {l})
                sim.setJointTargetVelocity(sim.getObject(':/Pioneer_p3dx_rightMotor'), {r})
            end"
        )
    };
    for (a, b) in [(old(2, 2), old(-1, 1)), (new(2, 2), new(-1, 1)), (old(2, 2), new(-1, 1))] {
        let scene = format!("{FLOOR}{}{}", pioneer(&a, ""), pioneer(&b, "position_m = [0.0, 3.0, 0.0]"));
        let place = TestFolder::scene(&scene);
        let paths = ["/Pioneer_p3dx[0]", "/Pioneer_p3dx[1]"];
        let last = place.trace(&paths, &["--seconds", "4"]).pop().unwrap();
        let ([first, second], [q, r]) =
            (paths.map(|p| last.object::<3>(p, "position")), paths.map(|p| last.object::<4>(p, "quaternion")));
        // 4 s at 2 * 0.0975 m/s, minus the distance lost during the acceleration.
        assert!(first[0] > 0.7 && first[1].abs() < 0.05 && yaw(q).abs() < 0.02, "{first:?}");
        assert!(f64::hypot(second[0], second[1] - 3.0) < 0.1 && yaw(r) > 1.0, "{second:?} {r:?}");
    }
}

#[test]
fn the_second_robot_has_names_of_its_own() {
    let told = "function sysCall_init()
        sim.addStatusbarMessage(sim.getObjectName(sim.getObject('.')))
        sim.addStatusbarMessage(sim.getObjectAlias(sim.getObject('./Pioneer_p3dx_leftMotor'), 1))
    end";
    let scene =
        format!("dialect = \"4.2\"\n{FLOOR}{}{}", pioneer(told, ""), pioneer(told, "position_m = [0.0, 3.0, 0.0]"));
    let lines = TestFolder::scene(&scene).trace(&[], &["--steps", "1"]);
    // As in V-REP, the names of the copy end in #0; paths distinguish siblings with the same alias by their order.
    assert_eq!(
        lines[0].status(),
        [
            "Pioneer_p3dx",
            "/Pioneer_p3dx[0]/Pioneer_p3dx_leftMotor",
            "Pioneer_p3dx#0",
            "/Pioneer_p3dx[1]/Pioneer_p3dx_leftMotor"
        ]
    );
}

/// Random numbers depend on the object and not on its position in the file: adding other objects does not change them.
#[test]
fn added_objects_do_not_change_random_numbers() {
    let script = "function sysCall_actuation() sim.addStatusbarMessage(tostring(math.random(1000000))) end";
    let dummy = |alias: &str| format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\n");
    let told = |before: &str, after: &str| {
        let place = TestFolder::scene(&format!("{before}{}{after}", watcher("teller", script)));
        let trace = place.trace(&[], &["--steps", "5"]);
        trace.iter().flat_map(|l| l.status()).map(str::to_owned).collect::<Vec<_>>()
    };
    let alone = told("", "");
    assert_eq!(alone.len(), 5);
    assert_eq!(alone, told(&dummy("a"), &dummy("b")));
}
