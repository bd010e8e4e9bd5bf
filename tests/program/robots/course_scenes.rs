//! Tests of the ten unmodified scripts of the 2015 course in the scenes created for them. Their output on the status
//! bar, on consoles and in files is compared with values computed from the poses in the trace.
//!
//! The scripts are not part of the repository and are read from `../shared/seeds/scripts`. The room is
//! `scenes/course/parts/arena.toml`. The cones of the sonar ring are described in the robot's README: 15 degrees to
//! each side, a range of 1 m, and at most 72 degrees to a surface's normal.

use std::path::PathBuf;

use crate::{kit::*, robots::manta::radius};

const ROBOT: &str = "/Pioneer_p3dx";

/// Each script and the object to which it is attached.
const COURSE_SCRIPTS: [(&str, &str); 10] = [
    ("hokuyo_reads_signals", "/Hokuyo"),
    ("laser_scanner_2d_signal_tube_log", "/LaserScanner_2D"),
    ("manta_keyboard_statusbar", "/Manta"),
    ("pioneer_braitenberg", ROBOT),
    ("pioneer_console", ROBOT),
    ("pioneer_follows_laser_signal", ROBOT),
    ("pioneer_log_append", ROBOT),
    ("pioneer_pose", ROBOT),
    ("pioneer_signals", ROBOT),
    ("pioneer_statusbar", ROBOT),
];

fn seed(name: &str) -> PathBuf {
    shared(&format!("seeds/scripts/{name}.lua"))
}

/// The output of a scene of the course that was run in a separate folder, with added objects and scripts.
struct CourseRun {
    place: TestFolder,
    lines: Vec<TraceLine>,
    stderr: String,
}

fn course(scene: &str, more: &str, scripts: &[(&str, PathBuf)], watch: &[&str], seconds: &str) -> CourseRun {
    let folder = root().join("scenes/course");
    let text = std::fs::read_to_string(folder.join(format!("{scene}.toml"))).unwrap();
    let text = ["parts/", "lua/"]
        .iter()
        .fold(text, |t, part| t.replace(&format!("\"{part}"), &format!("\"{}", folder.join(part).display())));
    let place = TestFolder::new();
    place.write("scene.toml", &format!("{text}\n{more}"));
    let mut args: Vec<String> = vec!["--seconds".into(), seconds.into(), "--trace".into(), "trace.jsonl".into()];
    scripts.iter().for_each(|(o, file)| args.extend(["--script".into(), format!("{o}={}", file.display())]));
    watch.iter().for_each(|w| args.extend(["--watch".into(), (*w).into()]));
    let done = place.run(&args.iter().map(String::as_str).collect::<Vec<_>>()).good();
    assert_eq!(done.json()["errors"].as_array().unwrap().len(), 0, "{}", done.err);
    CourseRun { lines: place.all_lines("trace.jsonl"), place, stderr: done.err }
}

impl CourseRun {
    /// Returns what was printed on a console, line by line.
    fn console(&self, title: &str) -> Vec<&str> {
        let head = format!("[{title}] ");
        self.stderr.lines().filter_map(|l| l.strip_prefix(head.as_str())).collect()
    }
}

/// A box of the room: size (m), centre (m), and rotation about the vertical (degrees).
type RoomBox = ([f64; 3], [f64; 3], f64);

const ROOM_BOXES: [RoomBox; 6] = [
    ([6.2, 0.1, 0.5], [0.0, 3.05, 0.25], 0.0),
    ([6.2, 0.1, 0.5], [0.0, -3.05, 0.25], 0.0),
    ([0.1, 6.2, 0.5], [3.05, 0.0, 0.25], 0.0),
    ([0.1, 6.2, 0.5], [-3.05, 0.0, 0.25], 0.0),
    ([0.5, 0.7, 0.5], [1.2, 1.0, 0.25], 30.0),
    ([0.4, 0.4, 0.6], [-1.4, -1.1, 0.3], 0.0),
];

const SONAR_RANGE_M: f64 = 1.0;

fn rotate([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let u = [x, y, z];
    let t = cross(u, v).map(|c| 2.0 * c);
    let s = cross(u, t);
    std::array::from_fn(|i| v[i] + w * t[i] + s[i])
}

/// Intersects a ray with the outside of a box. Returns the distance, and the cosine of the angle to the face's normal.
fn ray(block: &RoomBox, from: [f64; 3], along: [f64; 3]) -> Option<(f64, f64)> {
    let (size, at, turn) = block;
    let (s, c) = turn.to_radians().sin_cos();
    let into = |v: [f64; 3]| [c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2]];
    let (o, d) = (into([from[0] - at[0], from[1] - at[1], from[2] - at[2]]), into(along));
    let (mut enter, mut leave, mut cosine) = (f64::NEG_INFINITY, f64::INFINITY, 0.0);
    for i in 0..3 {
        let half = size[i] / 2.0;
        if d[i].abs() < 1e-12 {
            if o[i].abs() > half {
                return None;
            }
            continue;
        }
        let (a, b) = ((-half - o[i]) / d[i], (half - o[i]) / d[i]);
        if a.min(b) > enter {
            (enter, cosine) = (a.min(b), d[i].abs());
        }
        leave = leave.min(a.max(b));
    }
    (enter > 0.0 && enter <= leave).then_some((enter, cosine))
}

/// Returns the distance from a point to the outline of a box, in the plane.
fn horizontal_distance((size, at, turn): &RoomBox, from: [f64; 3]) -> f64 {
    let (s, c) = turn.to_radians().sin_cos();
    let [x, y] = [from[0] - at[0], from[1] - at[1]];
    let outside = |along: f64, size: f64| (along.abs() - size / 2.0).max(0.0);
    f64::hypot(outside(c * x + s * y, size[0]), outside(-s * x + c * y, size[1]))
}

/// Returns the reading of a sonar at a pose: the distance to the nearest point of any surface in its cone. All surfaces
/// are vertical, so this point is at the height of the sonar, and a fan of rays in that plane is sufficient.
fn sonar(at: [f64; 3], q: [f64; 4]) -> Option<f64> {
    let ahead = rotate(q, [0.0, 0.0, 1.0]);
    let heading = ahead[1].atan2(ahead[0]);
    let least = 72f64.to_radians().cos();
    // What is out of range needs no rays.
    let near: Vec<&RoomBox> = ROOM_BOXES.iter().filter(|b| horizontal_distance(b, at) <= SONAR_RANGE_M).collect();
    if near.is_empty() {
        return None;
    }
    let mut nearest = f64::INFINITY;
    for i in -2000..=2000 {
        let a = heading + f64::from(i) / 2000.0 * 15f64.to_radians();
        let seen = near.iter().filter_map(|b| ray(b, at, [a.cos(), a.sin(), 0.0]));
        nearest = seen.filter(|(_, cosine)| *cosine >= least).map(|(d, _)| d).fold(nearest, f64::min);
    }
    (0.05..=SONAR_RANGE_M).contains(&nearest).then_some(nearest)
}

fn sonar_paths() -> Vec<String> {
    (1..=16).map(|i| format!("{ROBOT}/Pioneer_p3dx_visible/Pioneer_p3dx_ultrasonicSensor{i}")).collect()
}

/// Compares the reported sonar readings with those computed from the poses at the end of the previous step, when the
/// sonars measured.
fn compare_sonars(ran: &CourseRun, told: &[Vec<f64>]) {
    let paths = sonar_paths();
    assert_eq!(told.len(), ran.lines.len());
    assert!(told[0].iter().all(|d| *d == 0.0), "a sonar has a reading before the first step");
    let (mut seen, mut worst) = (0, 0.0_f64);
    for (now, line) in told[1..].iter().zip(&ran.lines) {
        for (d, path) in now.iter().zip(&paths) {
            let want = sonar(line.object(path, "position"), line.object(path, "quaternion"));
            match want {
                Some(want) if *d > 0.0 => {
                    seen += 1;
                    worst = worst.max((d - want).abs());
                }
                // At the ends of the range, the sonar may or may not detect the surface.
                Some(want) => {
                    assert!(!(0.052..=0.997).contains(&want), "{path} at {}: no reading instead of {want}", line.time())
                }
                None => {
                    assert!(*d == 0.0 || *d > 0.997 || *d < 0.052, "{path} at {}: {d}, expected nothing", line.time())
                }
            }
        }
    }
    println!("{seen} readings, off by at most {:.2} mm", worst * 1e3);
    assert!(seen > 500 && worst < 0.002, "{seen} readings with errors up to {worst} m");
}

/// Returns the sixteen numbers of a line `S[1]=0.0 S[2]=...`.
fn sonars_of(line: &str) -> Vec<f64> {
    let parts = line.split_whitespace().enumerate();
    parts.map(|(i, p)| p.strip_prefix(&format!("S[{}]=", i + 1)).unwrap().parse().unwrap()).collect()
}

/// The number of passes in 20 s, and three more from the stop request to the end.
const PASSES: usize = 400 + 3;

#[test]
fn every_scene_runs_with_its_own_script() {
    for (name, _) in COURSE_SCRIPTS {
        assert_eq!(course(name, "", &[], &[], "20").lines.len(), PASSES, "{name}");
        // The comment at the top of each scene describes what to try.
        let text = std::fs::read_to_string(root().join(format!("scenes/course/{name}.toml"))).unwrap();
        assert!(text.starts_with("# ") && text.contains("What to try:"), "{name}");
    }
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn every_script_runs_in_its_scene() {
    for (name, object) in COURSE_SCRIPTS {
        let ran = course(name, "", &[(object, seed(name))], &[], "20");
        assert_eq!(ran.lines.len(), PASSES, "{name}");
    }
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn status_bar_and_console_show_the_sonar_readings() {
    let paths = sonar_paths();
    let watch: Vec<&str> = paths.iter().map(String::as_str).collect();
    let file = seed("pioneer_statusbar");
    let ran = course("pioneer_statusbar", "", &[(ROBOT, file)], &watch, "40");
    let told: Vec<Vec<f64>> = ran.lines.iter().map(|l| sonars_of(l.status()[0])).collect();
    compare_sonars(&ran, &told);
    let file = seed("pioneer_console");
    let ran = course("pioneer_console", "", &[(ROBOT, file)], &watch, "40");
    let told: Vec<Vec<f64>> = ran.console("Sensors").into_iter().map(sonars_of).collect();
    compare_sonars(&ran, &told);
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_console_shows_the_pose_of_the_trace() {
    let file = seed("pioneer_pose");
    let ran = course("pioneer_pose", "", &[(ROBOT, file)], &[ROBOT], "20");
    let told = ran.console("Pose");
    assert_eq!(told.len(), ran.lines.len());
    // The script reports the state at the end of the previous step.
    for (text, line) in told[1..].iter().zip(&ran.lines) {
        let numbers: Vec<f64> =
            text.replace("# ", "").replace("Orientacao:", "").split_whitespace().map(|n| n.parse().unwrap()).collect();
        let (p, [x, y, z, w]) = (line.object::<3>(ROBOT, "position"), line.object::<4>(ROBOT, "quaternion"));
        // Euler angles about x, the rotated y and the rotated z, for the rotation matrix Rx Ry Rz.
        let alpha = f64::atan2(-2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y));
        let beta = f64::asin(2.0 * (x * z + w * y));
        let gamma = f64::atan2(-2.0 * (x * y - w * z), 1.0 - 2.0 * (y * y + z * z));
        // The script contains this incorrect value of pi.
        let want = [p[0], p[1], p[2], alpha, beta, gamma, gamma * 180.0 / 3.1415936];
        for (i, (a, b)) in numbers.iter().zip(want).enumerate() {
            // The tolerance allows for four printed digits, and for single-precision floats in the old API.
            assert!((a - b).abs() < 5.1e-5 + b.abs() * 1e-7, "{i}: {a} instead of {b}");
        }
        assert_eq!(numbers.len(), 7);
    }
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_log_file_contains_readings_speeds_and_simulation_time() {
    let file = seed("pioneer_log_append");
    let paths = sonar_paths();
    let watch: Vec<&str> = paths.iter().map(String::as_str).collect();
    let ran = course("pioneer_log_append", "", &[(ROBOT, file)], &watch, "30");
    let log = ran.place.read("usensors-log.log");
    let rows: Vec<&str> = log.lines().collect();
    assert_eq!(rows.len(), 2 * ran.lines.len());
    let mut told = Vec::new();
    for (k, pair) in rows.chunks(2).enumerate() {
        // Numbers are followed by a tab, but "nil" directly by the next number.
        let row: Vec<f64> = pair[0]
            .replace("nil", "0\t")
            .split_terminator('\t')
            .map(|n| n.parse().unwrap_or_else(|_| panic!("{}", pair[0])))
            .collect();
        assert_eq!(row.len(), 16, "{}", pair[0]);
        let detect = |d: f64| if d > 0.0 && d < 0.5 { 1.0 - (d.max(0.2) - 0.2) / 0.3 } else { 0.0 };
        let speed = |weights: [f64; 8]| 2.0 + row.iter().zip(weights).map(|(d, w)| w * detect(*d)).sum::<f64>();
        let left = speed([-0.2, -0.4, -0.6, -0.8, -1.0, -1.2, -1.4, -1.6]);
        let right = speed([-1.6, -1.4, -1.2, -1.0, -0.8, -0.6, -0.4, -0.2]);
        let numbers: Vec<f64> = pair[1].split_whitespace().map(|n| n.parse().unwrap()).collect();
        assert!((numbers[0] - left).abs() < 0.006 && (numbers[1] - right).abs() < 0.006, "{pair:?}: {left} {right}");
        assert!((numbers[2] - 0.05 * k as f64).abs() < 0.0051, "{pair:?} at {k}");
        told.push(row);
    }
    compare_sonars(&ran, &told);
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn signals_are_those_of_the_same_step() {
    let (robot, reader) = (seed("pioneer_signals"), seed("hokuyo_reads_signals"));
    // This listener prints the signals with separators, and the target speeds of the wheels in the same step.
    let listener = "
        if sim_call_type == sim_childscriptcall_sensing then
            local l, r = simGetFloatSignal('GVLeft'), simGetFloatSignal('GVRight')
            local a = simGetJointTargetVelocity(simGetObjectHandle('Pioneer_p3dx_leftMotor'))
            local b = simGetJointTargetVelocity(simGetObjectHandle('Pioneer_p3dx_rightMotor'))
            simAddStatusbarMessage(string.format('%.17g %.17g %.17g %.17g', l, r, a, b))
        end";
    let more = watcher("listener", listener);
    let ran = course("pioneer_signals", &more, &[(ROBOT, robot), ("/Hokuyo", reader)], &[], "30");
    let printed = ran.console("Signals").concat();
    let (mut rest, mut slow) = (printed.as_str(), 0);
    for line in &ran.lines {
        // See tests/facts/call-order.md, 4: sensing reads the values that actuation has set in the same step.
        let numbers: Vec<f64> = line.status()[0].split(' ').map(|n| n.parse().unwrap()).collect();
        let [l, r, a, b] = numbers[..] else { panic!("{numbers:?}") };
        assert!((l - a).abs() < 1e-6 && (r - b).abs() < 1e-6, "{} s: {numbers:?}", line.time());
        slow += usize::from(l != 2.0 || r != 2.0);
        // The course's reader prints the numbers without separators.
        for number in [l, r] {
            let text = texts(number).into_iter().find(|t| rest.starts_with(t.as_str()));
            let text = text.unwrap_or_else(|| panic!("{number} at {} s: {}", line.time(), &rest[..40.min(rest.len())]));
            rest = &rest[text.len()..];
        }
    }
    assert!(slow > 50, "the robot was slowed down by obstacles in only {slow} steps");
    assert_eq!(rest, "");
}

/// Returns the two forms in which a number may be printed: with all its digits, or with 14 as in Lua 5.1.
fn texts(number: f64) -> [String; 2] {
    let digits = (13.0 - number.abs().max(1e-300).log10().floor()).clamp(0.0, 30.0) as usize;
    let short = format!("{number:.digits$}");
    let short = short.trim_end_matches('0').trim_end_matches('.');
    [format!("{number}"), short.to_owned()]
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_scan_is_where_rays_meet_the_room_and_steers_the_robot_a_step_later() {
    let names = ("laser_scanner_2d_signal_tube_log", "pioneer_follows_laser_signal");
    let (laser, robot) = (seed(names.0), seed(names.1));
    let scanner = format!("{ROBOT}/LaserScanner_2D");
    let witness = "
        if sim_call_type == sim_childscriptcall_sensing then
            local a = simGetJointTargetVelocity(simGetObjectHandle('Pioneer_p3dx_leftMotor'))
            simAddStatusbarMessage('' .. a)
        end";
    let scripts = [("/LaserScanner_2D", laser), (ROBOT, robot)];
    let ran = course(names.0, &watcher("witness", witness), &scripts, &[&scanner], "20");
    let log = ran.place.read("dados-sensor.log");
    let scans: Vec<Vec<(f64, f64)>> = log
        .lines()
        .map(|l| {
            let entries = l.split_terminator(",) ").map(|e| e.trim_start_matches('(').split_once(';').unwrap());
            entries.map(|(a, d)| (a.parse().unwrap(), d.parse().unwrap())).collect()
        })
        .collect();
    assert_eq!(scans.len(), ran.lines.len());
    let mut worst = 0.0_f64;
    for (scan, line) in scans.iter().zip(&ran.lines) {
        let (p, q) = (line.object::<3>(&scanner, "position"), line.object::<4>(&scanner, "quaternion"));
        // The ray starts at the model's origin, because V-REP's `World-Sick180-Log` has the joint and the laser there.
        let from = p;
        assert_eq!(scan.len(), 181, "in a room every ray must hit something");
        for (angle, d) in scan {
            let (s, c) = angle.to_radians().sin_cos();
            let along = rotate(q, [c, s, 0.0]);
            let want =
                ROOM_BOXES.iter().filter_map(|b| ray(b, from, along)).map(|(d, _)| d).fold(f64::INFINITY, f64::min);
            // A ray close to an edge may hit or miss it, because the angle is written with only four digits.
            if (d - want).abs() > 0.001 {
                let beside = [-1e-4_f64, 1e-4].map(|e| {
                    let (s, c) = (angle.to_radians() + e).sin_cos();
                    let along = rotate(q, [c, s, 0.0]);
                    ROOM_BOXES.iter().filter_map(|b| ray(b, from, along)).map(|(d, _)| d).fold(f64::INFINITY, f64::min)
                });
                assert!(beside.iter().any(|b| (b - d).abs() < 0.002), "{angle} degrees: {d} instead of {want}");
                continue;
            }
            worst = worst.max((d - want).abs());
        }
    }
    println!("scans are off by at most {:.3} mm", worst * 1e3);
    assert!(worst < 2e-4, "the largest error is {worst} m");
    let mut turns = 0;
    for (k, line) in ran.lines.iter().enumerate() {
        // See tests/facts/call-order.md, 4: actuation reads the values that sensing has set in the previous step.
        let least = if k == 0 { 1000.0 } else { scans[k - 1].iter().map(|s| s.1).fold(1000.0, f64::min) };
        let want = if least < 0.5 { -2.0 } else { 2.0 };
        turns += usize::from(want < 0.0);
        if (least - 0.5).abs() > 1e-4 {
            assert_eq!(line.status()[0].parse::<f64>().unwrap(), want, "step {k}: {least} m");
        }
    }
    assert!(turns > 10, "the robot turned in only {turns} steps");
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_manta_obeys_keys() {
    let file = seed("manta_keyboard_statusbar");
    // The key "left" is sent five times, which steers by 0.5 rad, and then s. The messages have the form of keyboard
    // messages.
    let hand = "
        if sim_call_type == sim_childscriptcall_sensing then
            local step = math.floor(simGetSimulationTime() / 0.05 + 0.5)
            if step >= 100 and step < 105 then vrep.sendMessage(sim.message_keypress, {2009, 0}) end
            if step == 400 then vrep.sendMessage(sim.message_keypress, {115, 0}) end
        end";
    let ran = course("manta_keyboard_statusbar", &watcher("hand", hand), &[("/Manta", file)], &["/Manta"], "25");
    let at = |i: usize| ran.lines[i].object::<3>("/Manta", "position");
    let speed = (at(99)[0] - at(59)[0]) / 2.0;
    assert!((speed / 0.9 - 1.0).abs() < 0.02, "10 rad/s: {speed} m/s");
    let r = radius(at(200), at(260), at(320));
    assert!((r / 1.098 - 1.0).abs() < 0.05, "0.5 rad: a radius of {r} m");
    let rest = f64::hypot(at(499)[0] - at(460)[0], at(499)[1] - at(460)[1]);
    assert!(rest < 0.005, "the car has moved {rest} m in the two seconds after s");
    let keys: Vec<&str> = ran.lines.iter().flat_map(|l| l.status()).collect();
    assert_eq!(keys, ["Tecla: 2009", "Tecla: 2009", "Tecla: 2009", "Tecla: 2009", "Tecla: 2009", "Tecla: 115"]);
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn the_avoiding_robot_of_the_course_stays_free() {
    let file = seed("pioneer_braitenberg");
    let ran = course("pioneer_braitenberg", "", &[(ROBOT, file)], &[ROBOT], "60");
    let places: Vec<[f64; 3]> = ran.lines.iter().map(|l| l.object(ROBOT, "position")).collect();
    let way: f64 = places.windows(2).map(|w| f64::hypot(w[1][0] - w[0][0], w[1][1] - w[0][1])).sum();
    assert!(way > 3.0, "{way} m in a minute");
    // The walls of the room are at 3 m, and the robot extends at least 0.15 m to its sides.
    assert!(places.iter().all(|p| p[0].abs() < 2.85 && p[1].abs() < 2.85));
}
