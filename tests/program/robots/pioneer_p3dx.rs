//! Tests that the Pioneer drives and rests as in V-REP.
//!
//! The measurements are from `tests/facts/pioneer.md`, 3, on an empty floor. With both motors at 2 rad/s the robot
//! moves at 0.19495 m/s (pure rolling: 2 * 0.0975 = 0.195). With 1 and 2 rad/s it turns at 0.29465 rad/s (pure rolling:
//! 0.0975 / 0.331 = 0.29456). At rest it creeps by 0.5 to 3 mm in 10 s.

use crate::kit::*;

const ROBOT: &str = "/Pioneer_p3dx";

/// Variants of preset and physics step. The presets have the same wheels and track, so the robot drives in the same
/// way.
const VARIANTS: [(&str, &str); 4] = [
    ("", ""),
    ("", "preset = \"as the data sheet\""),
    ("physics_dt_s = 0.005\n", ""),
    ("physics_dt_s = 0.005\n", "preset = \"as the data sheet\""),
];

/// Drives a robot with the given motor speeds, rad/s. Returns time (s), position (m) and heading (rad) at the start and
/// after each step.
fn drive(variant: (&str, &str), left: f64, right: f64, seconds: f64) -> Vec<(f64, [f64; 3], f64)> {
    let script = format!(
        "function sysCall_init()
            sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), {left})
            sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_rightMotor'), {right})
        end"
    );
    let place = TestFolder::scene(&format!("{}{FLOOR}{}", variant.0, pioneer(&script, variant.1)));
    let lines = place.trace(&[ROBOT], &["--seconds", &seconds.to_string()]);
    let start = (0.0, [0.0, 0.0, 0.1388], 0.0);
    let rows = lines.iter().map(|l| (l.time(), l.object(ROBOT, "position"), yaw(l.object(ROBOT, "quaternion"))));
    std::iter::once(start).chain(rows).collect()
}

/// Returns the row at the given time.
fn at(rows: &[(f64, [f64; 3], f64)], time: f64) -> (f64, [f64; 3], f64) {
    *rows.iter().find(|r| (r.0 - time).abs() < 1e-6).unwrap()
}

#[test]
fn straight_as_the_wheels_roll() {
    for variant in VARIANTS {
        let rows = drive(variant, 2.0, 2.0, 24.0);
        // As in the measurements in V-REP, the speed is the mean from 2 s to 10 s after the start.
        let ((_, a, _), (_, b, _)) = (at(&rows, 2.0), at(&rows, 10.0));
        let speed = f64::hypot(b[0] - a[0], b[1] - a[1]) / 8.0;
        println!("{variant:?}: {speed:.5} m/s");
        assert!((speed / 0.195 - 1.0).abs() < 0.005, "{variant:?}: {speed} m/s");
        // The robot starts along x, so its lateral error is y.
        let four = rows.iter().find(|r| r.1[0] >= 4.0).expect("the robot drives 4 m");
        println!("{variant:?}: {:.2} mm to the side in 4 m", four.1[1] * 1e3);
        assert!(four.1[1].abs() < 0.01, "{variant:?}: {} m to the side", four.1[1]);
    }
}

#[test]
fn turns_as_the_wheels_roll() {
    for variant in VARIANTS {
        let rows = drive(variant, 1.0, 2.0, 10.0);
        let ((_, _, a), (_, _, b)) = (at(&rows, 2.0), at(&rows, 10.0));
        let rate = (b - a).rem_euclid(std::f64::consts::TAU) / 8.0;
        println!("{variant:?}: {rate:.5} rad/s");
        assert!((rate / 0.2946 - 1.0).abs() < 0.015, "{variant:?}: {rate} rad/s");
    }
}

#[test]
fn parked_robot_does_not_creep() {
    for variant in VARIANTS {
        let rows = drive(variant, 0.0, 0.0, 10.0);
        let most = rows.iter().map(|(_, p, _)| f64::hypot(p[0], p[1])).fold(0.0, f64::max);
        println!("{variant:?}: {:.3} mm in 10 s", most * 1e3);
        assert!(most < 0.003, "{variant:?}: the robot creeps by {most} m");
        let turned = rows.iter().map(|(_, _, h)| h.abs()).fold(0.0, f64::max);
        assert!(turned < 0.01, "{variant:?}: the robot turns by {turned} rad");
    }
}
