//! Tests of pendulums and gyroscopes.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::{kit::*, scenes::*};

/// Returns the period of a pendulum with any amplitude (rad), computed by the arithmetic-geometric mean.
fn period(length: f64, inertia: f64, amplitude: f64) -> f64 {
    let (mut a, mut b) = (1.0, (amplitude / 2.0).cos());
    for _ in 0..30 {
        (a, b) = ((a + b) / 2.0, f64::sqrt(a * b));
    }
    2.0 * PI * ((length * length + inertia) / (G * length)).sqrt() / a
}

/// A ball of 1 kg swings on a rod of 1 m with the right period within 0.1 %, and keeps its energy for 100 s.
#[test]
fn pendulum() {
    for degrees in [5.0f64, 90.0] {
        let q = degrees.to_radians();
        let bob = placed([q.sin(), 0.0, -q.cos()], [1.0, 0.0, 0.0], 0.0);
        let scene = base([0.0; 3])
            + &joint("j", "/base", &about_y([0.0; 3]))
            + &body("bob", "/base/j", "sphere", [0.1; 3], 1.0, &bob);
        let lines = watch_run(&scene, &["/base/j", "/base/j/bob"], 100.0);
        let angle = |l: &TraceLine| {
            let p = position(l, "/base/j/bob");
            p[0].atan2(-p[2])
        };
        // Upward crossings of the vertical, linearly interpolated between samples.
        let crossings: Vec<f64> = lines
            .windows(2)
            .filter(|w| angle(&w[0]) < 0.0 && angle(&w[1]) >= 0.0)
            .map(|w| {
                let (a, b) = (angle(&w[0]), angle(&w[1]));
                w[0].time() - a / (b - a) * (w[1].time() - w[0].time())
            })
            .collect();
        let mean = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
        let inertia = 0.4 * 0.05 * 0.05;
        near(&format!("period at {degrees} degrees"), mean / period(1.0, inertia, q), 1.0, 1e-3);
        let energy = |l: &TraceLine| {
            let w = norm(l.object("/base/j/bob", "angular_velocity"));
            let v = speed(l, "/base/j/bob");
            0.5 * v * v + 0.5 * inertia * w * w + G * (position(l, "/base/j/bob")[2] + 1.0)
        };
        let last = lines[lines.len() - 100..].iter().map(energy).sum::<f64>() / 100.0;
        near("energy", last / (G * (1.0 - q.cos())), 1.0, 0.01);
    }
}

/// A double pendulum released from the horizontal keeps its energy within 5 % of 3 m g L for 20 s.
#[test]
fn double_pendulum() {
    let at = |x: f64| placed([x, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0);
    let (one, two) = ("/base/j/one", "/base/j/one/k/two");
    let scene = String::from("dt_s = 0.01\n")
        + &base([0.0; 3])
        + &joint("j", "/base", &about_y([0.0; 3]))
        + &body("one", "/base/j", "sphere", [0.1; 3], 1.0, &at(1.0))
        + &joint("k", one, &about_y([1.0, 0.0, 0.0]))
        + &body("two", "/base/j/one/k", "sphere", [0.1; 3], 1.0, &at(2.0));
    let energy = |l: &TraceLine| {
        let of = |p: &str| {
            let w = norm(l.object(p, "angular_velocity"));
            0.5 * speed(l, p).powi(2) + 0.5 * 0.4 * 0.05 * 0.05 * w * w + G * position(l, p)[2]
        };
        of(one) + of(two)
    };
    let lines = watch_run(&scene, &[one, two], 20.0);
    let worst = lines.iter().map(|l| energy(l).abs()).fold(0.0, f64::max);
    near("energy lost or gained, of 3 m g L", worst / (3.0 * G), 0.0, 0.05);
}

/// A wheel that spins at 60 rad/s on a horizontal arm precesses at m g r / (I w) and does not sink.
#[test]
fn precession() {
    let (mass, reach, spin, along, across) = (1.0, 0.1, 60.0, 0.02, 0.0101);
    let rate = mass * G * reach / (along * spin);
    let small = |w: [f64; 3]| format!("inertia_kg_m2 = [2e-4, 2e-4, 2e-4]\n{}", starts([0.0; 3], w));
    let turning = [0.0, 0.0, rate];
    let wheel = format!(
        "inertia_kg_m2 = [{across}, {across}, {along}]\n{}",
        starts([0.0, rate * reach, 0.0], [spin, 0.0, rate])
    );
    let arm = "/base/yaw/hub/pitch/arm";
    let scene = base([0.0; 3])
        + &joint("yaw", "/base", "")
        + &body("hub", "/base/yaw", "sphere", [0.05; 3], 0.2, &small(turning))
        + &joint("pitch", "/base/yaw/hub", &about_y([0.0; 3]))
        + &body(
            "arm",
            "/base/yaw/hub/pitch",
            "sphere",
            [0.05; 3],
            0.2,
            &(small(turning) + "\nworld_pose = [0, 0, 0, 0, 0, 0, 1]"),
        )
        + &joint("spin", arm, &placed([reach, 0.0, 0.0], [0.0, 1.0, 0.0], FRAC_PI_2))
        + &body("wheel", &format!("{arm}/spin"), "cylinder", [0.4, 0.4, 0.02], mass, &wheel);
    let lines = watch_run(&scene, &["/base/yaw", "/base/yaw/hub/pitch"], 20.0);
    let turned: f64 = lines
        .windows(2)
        .map(|w| {
            let way = of_joint(&w[1], "/base/yaw", "position") - of_joint(&w[0], "/base/yaw", "position");
            way - (2.0 * PI) * (way / (2.0 * PI)).round()
        })
        .sum();
    let time = lines[lines.len() - 1].time() - lines[0].time();
    near("rate of precession", turned / time / rate, 1.0, 5e-3);
    let sunk = of_joint(&lines[lines.len() - 1], "/base/yaw/hub/pitch", "position").to_degrees();
    near("degrees that the arm sinks in 20 s", sunk, 0.0, 2.0);
}
