//! Tests of the unmodified scripts of the 2015 course, whose output is compared with that in V-REP.
//!
//! The expected values are from `tests/facts/pioneer.md`, 4. The scripts are not part of the repository and are read
//! from `../shared/seeds/scripts`.

use std::{collections::BTreeMap, fmt::Write};

use crate::kit::*;

const ROBOT: &str = "/Pioneer_p3dx";

/// Returns a Pioneer with the script `name` of the course.
fn student(name: &str, more: &str) -> String {
    let text = std::fs::read_to_string(shared(&format!("seeds/scripts/{name}.lua"))).unwrap();
    pioneer(&text, more)
}

/// Returns the sixteen numbers of a line of `pioneer_statusbar.lua`.
fn sonars(line: &str) -> Vec<f64> {
    let parts = line.split_whitespace().enumerate();
    parts.map(|(i, p)| p.strip_prefix(&format!("S[{}]=", i + 1)).unwrap().parse().unwrap()).collect()
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_status_bar_shows_the_original_picture() {
    // The values of sonars 4, 5 and 6 in the tutorial, which V-REP printed. All other sonars are always 0.0 there.
    const ORIGINAL: [[f64; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [0.0, 0.9999, 0.0],
        [0.0, 0.9904, 0.0],
        [0.9990, 0.9808, 0.9932],
        [0.9893, 0.9713, 0.9836],
        [0.9797, 0.9617, 0.9740],
        [0.9700, 0.9521, 0.9644],
        [0.9604, 0.9426, 0.9548],
    ];
    // The robot approaches the wall at 11 degrees. Sonar 5 is then perpendicular to the wall and comes 9.57 mm closer
    // per step (the 9.75 mm that the wheels roll, times the cosine), as in the tutorial.
    let robot = student("pioneer_statusbar", "orientation_deg = [0.0, 0.0, 11.0]");
    // The starting point is chosen so that sonar 5 first detects the wall just within its range, as in the tutorial.
    let wall = cuboid("wall", [0.1, 8.0, 1.0], [2.0546, 0.0, 0.5], "respondable = true");
    let lines = TestFolder::scene(&format!("{FLOOR}{wall}{robot}")).trace(&[], &["--seconds", "5"]);
    let all: Vec<Vec<f64>> = lines.iter().map(|l| sonars(l.status()[0])).collect();
    assert!(all.iter().flatten().all(|d| *d <= 1.0), "a sonar has detected something beyond 1 m");
    let first = all.iter().position(|s| s.iter().any(|d| *d > 0.0)).expect("the robot reaches the wall") - 1;
    let picture = &all[first..first + 8];
    for (ours, theirs) in picture.iter().zip(ORIGINAL) {
        println!("{:?}  original {theirs:?}", &ours[3..6]);
        for (i, d) in ours.iter().enumerate() {
            let shown = if (3..6).contains(&i) { theirs[i - 3] } else { 0.0 };
            assert_eq!(*d > 0.0, shown > 0.0, "sonar {}: {d}, original {shown}", i + 1);
        }
    }
    // The starting point is not exact: the reading of sonar 5 exceeds that in the tutorial by this distance.
    let ahead = picture[1][4] - ORIGINAL[1][1];
    for (ours, theirs) in picture.iter().zip(ORIGINAL) {
        for (d, shown) in ours[3..6].iter().zip(theirs) {
            // V-REP's cones are pyramids with eight faces, up to 1.1 degrees narrower than a cone. The distances
            // differ by up to 3 mm.
            let off = if shown > 0.0 { (d - shown - ahead).abs() } else { 0.0 };
            assert!(off < 0.004, "{d} m, original {shown} m, {ahead} m ahead");
        }
    }
    for pair in picture.windows(2) {
        for (a, b) in pair[0].iter().zip(&pair[1]).filter(|(a, _)| **a > 0.0) {
            let nearer = (a - b) * 1e3;
            assert!((9.35..9.85).contains(&nearer), "{nearer} mm nearer in a step");
        }
    }
}

/// Runs a course script in a small arena; returns the status lines of each step and standard error.
fn runs(robot: &str, others: &str) -> (TestFolder, Vec<Vec<String>>, String) {
    let wall = |i: i32, size, at| cuboid(&format!("wall_{i}"), size, at, "respondable = true");
    let scene = format!(
        "{FLOOR}{}{}{}{robot}{others}",
        wall(1, [0.1, 4.0, 0.5], [1.5, 0.0, 0.25]),
        wall(2, [0.1, 4.0, 0.5], [-1.5, 0.0, 0.25]),
        cuboid("crate", [0.4, 0.4, 0.4], [0.8, 0.7, 0.2], "respondable = true"),
    );
    let place = TestFolder::scene(&scene);
    let done = place.run(&["--seconds", "10", "--trace", "trace.jsonl"]).good();
    assert_eq!(done.json()["errors"].as_array().unwrap().len(), 0);
    let owned = |l: &TraceLine| l.status().iter().map(|s| s.to_string()).collect();
    let status = place.lines("trace.jsonl").iter().map(owned).collect();
    (place, status, done.err)
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_console_gets_a_line_a_step() {
    let robot = student("pioneer_console", "");
    let (_, _, told) = runs(&robot, "");
    let lines: Vec<&str> = told.lines().filter_map(|l| l.strip_prefix("[Sensors] ")).collect();
    // 200 steps, and three passes after the stop request (tests/facts/call-order.md, 1).
    assert_eq!(lines.len(), 203, "{told}");
    assert!(lines.iter().all(|l| sonars(l).len() == 16));
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_printed_pose_is_that_of_the_robot() {
    let robot = student("pioneer_pose", "position_m = [0.5, -0.25, 0.0]");
    let (_, _, told) = runs(&robot, "");
    let lines: Vec<&str> = told.lines().filter_map(|l| l.strip_prefix("[Pose] ")).collect();
    assert_eq!(lines.len(), 203);
    // The first line is the initial position. The base frame is 0.1388 m above the floor (tests/facts/pioneer.md, 1).
    assert!(lines[0].starts_with("0.5000 -0.2500 0.138"), "{}", lines[0]);
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_log_file_grows_by_two_lines_a_step() {
    let robot = student("pioneer_log_append", "");
    let (place, _, _) = runs(&robot, "");
    let log = place.read("usensors-log.log");
    assert_eq!(log.lines().count(), 406);
    // os.clock() returns the simulated time, which is 0 in the first step, to make runs reproducible.
    assert!(log.lines().nth(1).unwrap().ends_with(" 0.00"), "{log}");
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn signals_pass_from_script_to_script() {
    let robot = student("pioneer_signals", "");
    let reader = std::fs::read_to_string(shared("seeds/scripts/hokuyo_reads_signals.lua")).unwrap();
    let (_, _, told) = runs(&robot, &watcher("Hokuyo", &reader));
    // The script prints the speeds of both wheels without a separator: 2 and 2 if no sonar detects anything.
    assert!(told.lines().any(|l| l.starts_with("[Signals] 22")), "{told}");

    let robot = student("pioneer_follows_laser_signal", "");
    let laser = "function sysCall_actuation() sim.setFloatSignal('LaserFrontal', sim.getSimulationTime() < 1 and 2.0 or 0.2) end
        function sysCall_sensing() sim.addStatusbarMessage(string.format('%g',
            sim.getJointTargetVelocity(sim.getObject('/Pioneer_p3dx_leftMotor')))) end";
    let (_, status, _) = runs(&robot, &watcher("laser", laser));
    assert_eq!(status[0], ["2"]);
    assert_eq!(status[199], ["-2"], "the robot must turn away from the near object");
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_other_scripts_run_on_objects_of_the_same_names() {
    let laser = shared("seeds/scripts/laser_scanner_2d_signal_tube_log.lua");
    let laser = std::fs::read_to_string(laser).unwrap();
    let scanner = format!(
        "{}[[object]]\nkind = \"joint\"\nalias = \"LaserScannerJoint_2D\"\nparent = \"LaserScanner_2D\"\nmode = \"kinematic\"\n\
         [[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"LaserScannerLaser_2D\"\n\
         parent = \"LaserScannerJoint_2D\"\norientation_deg = [0.0, 90.0, 0.0]\nrange_m = 5.0\nexplicit = true\n\
         [[object]]\nkind = \"dummy\"\nalias = \"LaserScannerGraph_2D\"\n",
        watcher("LaserScanner_2D", &laser).replace("[[object]]", "[[object]]\nposition_m = [0.0, 0.0, 0.2]"),
    );
    let manta = std::fs::read_to_string(shared("seeds/scripts/manta_keyboard_statusbar.lua")).unwrap();
    let car = format!(
        "{}[[object]]\nkind = \"joint\"\nalias = \"steer_joint\"\n[[object]]\nkind = \"joint\"\nalias = \"motor_joint\"\n{}",
        watcher("Manta", &manta),
        // A second script sends two keys, up and s.
        watcher(
            "keys",
            "function sysCall_sensing() if sim.getSimulationTime() == 0 then
            vrep.sendMessage(sim.message_keypress, {2007, 0}) vrep.sendMessage(sim.message_keypress, {115, 0}) end end"
        ),
    );
    let (place, status, _) = runs(&scanner, &car);
    let keys: Vec<&String> = status.iter().flatten().collect();
    assert_eq!(keys, ["Tecla: 2007", "Tecla: 115"]);
    // The scan has 181 beams, one per degree. The face of the wall is 1.45 m straight ahead.
    let scan = place.read("dados-sensor.log");
    assert_eq!(scan.lines().count(), 203);
    assert!(scan.lines().all(|l| l.contains("(0.0000;1.4500,)")), "{}", scan.lines().next().unwrap());
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_braitenberg_robot_moves_on_and_stays_free() {
    for seed in [1, 2] {
        let robot = student("pioneer_braitenberg", &format!("orientation_deg = [0, 0, {}]", 137 * seed));
        let scene = format!("seed = {seed}\n{FLOOR}{}{robot}{}", arena(seed), watcher("witness", CONTACT_LOGGER));
        let lines = TestFolder::scene(&scene).trace(&[ROBOT], &["--seconds", "60"]);
        let places: Vec<[f64; 3]> = lines.iter().map(|l| l.object(ROBOT, "position")).collect();
        let path: f64 = places.windows(2).map(|w| f64::hypot(w[1][0] - w[0][0], w[1][1] - w[0][1])).sum();
        let leans = lines.iter().map(|l| lean(l.object(ROBOT, "quaternion"))).fold(0.0, f64::max).to_degrees();
        // The longest sequence of steps in which the robot touches the same object.
        let (mut touching, mut longest) = (BTreeMap::new(), 0);
        for line in &lines {
            let now = line.status().into_iter().map(|s| (s.to_owned(), touching.get(s).copied().unwrap_or(0) + 1));
            touching = now.collect();
            longest = touching.values().copied().fold(longest, u32::max);
        }
        println!("seed {seed}: {path:.2} m, contact {:.2} s, leans {leans:.2} degrees", longest as f64 * 0.05);
        assert!(path >= 3.0, "seed {seed}: a path of only {path} m in a minute");
        assert!(longest <= 10, "seed {seed}: a contact lasts {longest} steps");
        assert!(leans < 3.0, "seed {seed}: the robot leans by {leans} degrees");
    }
}

/// Prints in each step the parts of the arena that the robot touches.
const CONTACT_LOGGER: &str = "
function sysCall_sensing()
    local told, i = {}, 0
    while true do
        local pair = sim.getContactInfo(0, sim.handle_all, i)
        if not pair then break end
        local a, b = sim.getObjectAlias(pair[1]), sim.getObjectAlias(pair[2])
        if a:find('Pioneer') then a, b = b, a end
        if b:find('Pioneer') and not a:find('Pioneer') and a ~= 'floor' and not told[a] then
            told[a] = true
            sim.addStatusbarMessage(a)
        end
        i = i + 1
    end
end";

/// Returns the walls of an arena of 10 x 10 m and 8 boxes whose positions are drawn from the seed. All gaps, including
/// those to the robot's start in the middle, are at least 1 m.
fn arena(seed: u64) -> String {
    let mut out = String::new();
    for (i, (size, at)) in
        [([0.2, 10.4], [5.1, 0.0]), ([0.2, 10.4], [-5.1, 0.0]), ([10.4, 0.2], [0.0, 5.1]), ([10.4, 0.2], [0.0, -5.1])]
            .into_iter()
            .enumerate()
    {
        out += &cuboid(&format!("wall_{i}"), [size[0], size[1], 0.6], [at[0], at[1], 0.3], "respondable = true");
    }
    // The linear congruential generator of Numerical Recipes is good enough to place boxes.
    let mut state = seed;
    let mut draw = |low: f64, high: f64| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    // The bounding circles of the robot (first) and of the boxes. A gap between circles guarantees at least that gap
    // between the boxes.
    let mut placed = vec![[0.0, 0.0, 0.35]];
    while placed.len() < 9 {
        let (sx, sy, turn) = (draw(0.3, 0.8), draw(0.3, 0.8), draw(0.0, 180.0));
        let (x, y, r) = (draw(-4.0, 4.0), draw(-4.0, 4.0), f64::hypot(sx, sy) / 2.0);
        let inside = x.abs().max(y.abs()) + r + 1.0 <= 5.0;
        if inside && placed.iter().all(|[a, b, q]| f64::hypot(x - a, y - b) >= r + q + 1.0) {
            let more = format!("respondable = true\norientation_deg = [0.0, 0.0, {turn:?}]");
            let _ = write!(out, "{}", cuboid(&format!("box_{}", placed.len()), [sx, sy, 0.6], [x, y, 0.3], &more));
            placed.push([x, y, r]);
        }
    }
    out
}
