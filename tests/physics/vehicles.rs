//! Tests that a Pioneer moves as its wheel speeds determine.

use crate::{kit::*, scenes::*};

/// Radius of the wheels and distance between them, m.
const RADIUS: f64 = 0.0975;
const TRACK: f64 = 0.331;

fn drive(left: f64, right: f64, seconds: f64, watch: &[&str]) -> Vec<TraceLine> {
    let wheels = format!(
        "[model.set]\n\"Pioneer_p3dx_leftMotor.target_velocity_rad_s\" = {left:?}\n\
         \"Pioneer_p3dx_rightMotor.target_velocity_rad_s\" = {right:?}\n\"Pioneer_p3dx.joint_solver\" = \"{}\"\n",
        crate::VEHICLES
    );
    watch_run(&format!("{}[[model]]\nmodel = \"pioneer_p3dx\"\n{wheels}", floor(1.0)), watch, seconds)
}

const ROBOT: &str = "/Pioneer_p3dx";

#[test]
fn straight_on() {
    let lines = drive(3.0, 3.0, 20.0, &[ROBOT]);
    let at = |t: f64| lines.iter().position(|l| l.time() >= t - 1e-9).unwrap();
    let (a, b) = (at(5.0), at(20.0));
    let way = position(&lines[b], ROBOT)[0] - position(&lines[a], ROBOT)[0];
    near("speed", way / (lines[b].time() - lines[a].time()) / (3.0 * RADIUS), 1.0, 2e-4);
    near("lateral deviation after 6 s", position(&lines[at(6.0)], ROBOT)[1], 0.0, 5e-3);
    let rolls = lines[a..=b].iter().map(|l| l.object::<3>(ROBOT, "angular_velocity")[0].powi(2)).sum::<f64>();
    near("roll, rms", (rolls / (b - a + 1) as f64).sqrt(), 0.0, 1e-3);
}

#[test]
fn on_the_spot() {
    let lines = drive(-2.0, 2.0, 20.0, &[ROBOT]);
    let half = &lines[lines.len() / 2..];
    let mean = half.iter().map(|l| l.object::<3>(ROBOT, "angular_velocity")[2]).sum::<f64>() / half.len() as f64;
    near("rate of turn", mean / (4.0 * RADIUS / TRACK), 1.0, 5e-4);
}

/// A robot whose motors hold speed 0 stays where it is, level and on a slope; before the second second, it settles.
#[test]
fn parked_robot_stays() {
    for degrees in [0.0, 15.0] {
        for solver in ["impulse", "reduced", "tree"] {
            let set = format!("[model.set]\n\"Pioneer_p3dx.joint_solver\" = \"{solver}\"\n");
            let model = "[[model]]\nmodel = \"pioneer_p3dx\"\nscript = { text = \"function sysCall_init() end\" }\n";
            let lines = watch_run(&(slope(degrees) + &floor(1.0) + model + &set), &[ROBOT], 22.0);
            let at = |t: f64| position(lines.iter().find(|l| l.time() >= t - 1e-9).unwrap(), ROBOT);
            let way: f64 = at(2.5).into_iter().zip(at(22.0)).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            near(&format!("{solver} on {degrees} degrees: speed"), way / 19.5, 0.0, 1e-6);
        }
    }
}

/// Turning does not accelerate the wheel of the caster, which slides: within ten minutes, its speed remains below 0.5
/// rad/s.
#[test]
fn the_caster_does_not_wind_up() {
    let caster = "/Pioneer_p3dx/Pioneer_p3dx_caster_freeJoint1/Pioneer_p3dx_caster_link/Pioneer_p3dx_caster_freeJoint2";
    let lines = drive(1.0, 3.0, 600.0, &[caster]);
    for line in &lines {
        near("caster", of_joint(line, caster, "velocity"), 0.0, 0.5);
    }
}
