//! Tests that gripped objects do not slip.

use std::f64::consts::FRAC_PI_2;

use crate::{kit::*, scenes::*};

/// Simulates a palm on a vertical slide with two fingers that press from the left and the right; `left` and `right` are
/// the keys of their joints. The palm grips for 2 s, rises by 0.3 m, and then shakes up and down. Returns how far the
/// object slips on the fingers, m.
fn creep(mass: f64, left: &str, right: &str, seconds: f64) -> f64 {
    creep_between(0.2, mass, left, right, seconds)
}

/// Like [`creep`], with the mass `fingers` (kg) of each finger.
fn creep_between(fingers: f64, mass: f64, left: &str, right: &str, seconds: f64) -> f64 {
    let finger = |alias: &str, x: f64, drive: &str| {
        let slide = placed([x, 0.0, 0.2], [0.0, 1.0, 0.0], FRAC_PI_2);
        let pad = placed([x, 0.0, 0.16], [1.0, 0.0, 0.0], 0.0) + "\nrespondable = true";
        joint(
            &format!("j{alias}"),
            "/base/lift/palm",
            &format!("type = \"prismatic\"\nlimits_m = [-0.1, 0.1]\n{slide}\n{drive}"),
        ) + &body(&format!("f{alias}"), &format!("/base/lift/palm/j{alias}"), "box", [0.02, 0.04, 0.3], fingers, &pad)
    };
    let lift = "type = \"prismatic\"\ncontrol = \"position\"\nmax_force_n = 1000.0\nmax_velocity_m_s = 0.2\nlimits_m = [-0.5, 0.5]";
    let palm = placed([0.0, 0.0, 0.3], [1.0, 0.0, 0.0], 0.0);
    let hand = watcher(
        "hand",
        "function sysCall_actuation()
            local t = sim.getSimulationTime()
            local z = t < 2 and 0 or t < 5 and 0.3 or 0.3 + 0.02 * math.sin(6 * (t - 5))
            sim.setJointTargetPosition(sim.getObject('/base/lift'), z)
        end",
    );
    let object = "respondable = true\nposition_m = [0, 0, 0.05]";
    let scene = floor(1.0)
        + &base([0.0, 0.0, 1.0])
        + &joint("lift", "/base", lift)
        + &body("palm", "/base/lift", "box", [0.2, 0.05, 0.05], 1.0, &palm)
        + &finger("l", -0.06, left)
        + &finger("r", 0.06, right)
        + &body("o", "", "box", [0.04, 0.04, 0.1], mass, object)
        + &hand;
    let lines = watch_run(&scene, &["/o", "/base/lift/palm"], seconds);
    let height = |l: &TraceLine| position(l, "/o")[2] - position(l, "/base/lift/palm")[2];
    let lifted = lines.iter().position(|l| l.time() >= 5.0).unwrap();
    assert!(position(&lines[lifted], "/o")[2] > 0.3, "{mass} kg: not lifted");
    (height(&lines[lines.len() - 1]) - height(&lines[lifted])).abs()
}

fn force(n: f64) -> String {
    format!("control = \"force\"\nmax_force_n = {n:?}")
}

#[test]
fn grips_with_both_fingers() {
    for (mass, n) in [(0.1, 20.0), (1.0, 200.0)] {
        near("creep with two pressing fingers", creep(mass, &force(n), &force(-n), 20.0), 0.0, 5e-4);
    }
}

#[test]
fn grips_with_one_finger_held() {
    for (mass, n) in [(0.1, 20.0), (1.0, 200.0)] {
        let held = "control = \"position\"\ntarget_position_m = 0.04\nmax_force_n = 1000.0";
        near("creep with one finger held in position", creep(mass, held, &force(-n), 60.0), 0.0, 5e-4);
    }
}

/// The gripper closes at a given velocity with a limited force.
#[test]
fn grips_at_the_limit_of_a_motor() {
    let drive = |v: f64| format!("control = \"velocity\"\ntarget_velocity_m_s = {v:?}\nmax_force_n = 20.0");
    near("creep", creep(0.1, &drive(0.1), &drive(-0.1), 20.0), 0.0, 5e-4);
}

/// Keys of a finger joint that is geared to the other finger, which has the motor.
const GEARED_KEYS: &str = "follows = \"/base/lift/palm/jl\"\nfollow_factor = -1.0\ngeared = true\n";

/// Simulates two flat fingers of 15 g that slide towards each other under a palm, one coupled to the other, and lift
/// 0.2 kg by 0.1 m within a second. Returns how far the object slips on them in the following four seconds, m.
fn slip(left: &str, right: &str) -> f64 {
    let finger = |alias: &str, x: f64, drive: &str| {
        let turn = -90.0 * x.signum();
        let slide = format!(
            "type = \"prismatic\"\nposition_m = [{x}, 0, 0]\norientation_deg = [0, {turn}, 0]\nlimits_m = [-0.1, 0.1]\n{drive}"
        );
        let (joint_name, parent) = (format!("j{alias}"), format!("/base/lift/palm/j{alias}"));
        let pad = "position_m = [-0.05, 0, 0]\nrespondable = true\nfriction = 0.9"
            .replace("-0.05", &format!("{}", -0.05 * x.signum()));
        joint(&joint_name, "/base/lift/palm", &slide)
            + &body(&format!("f{alias}"), &parent, "box", [0.1, 0.02, 0.015], 0.015, &pad)
    };
    let hand = watcher(
        "hand",
        "function sysCall_actuation()
            local t = math.min(math.max(sim.getSimulationTime() - 1, 0), 1)
            sim.setJointTargetPosition(sim.getObject('/base/lift'), 0.1 * (3 * t ^ 2 - 2 * t ^ 3))
        end",
    );
    let object = "respondable = true\nfriction = 0.9\nposition_m = [0, 0, 0.7]";
    let scene = "dt_s = 0.005\n".to_owned()
        + &base([0.0, 0.0, 0.8])
        + &joint(
            "lift",
            "/base",
            "type = \"prismatic\"\ncontrol = \"position\"\nmax_force_n = 500.0\nlimits_m = [-0.3, 0.6]",
        )
        + &body("palm", "/base/lift", "box", [0.2, 0.06, 0.03], 0.5, "position_m = [0, 0, -0.05]")
        + &finger("l", 0.06, left)
        + &finger("r", -0.06, right)
        + &cuboid("table", [0.04, 0.3, 0.05], [0.0, 0.0, 0.65], "respondable = true")
        + &body("o", "", "box", [0.05; 3], 0.2, object)
        + &hand;
    let lines = watch_run(&scene, &["/o", "/base/lift/palm"], 5.0);
    let apart = |l: &TraceLine| {
        let (o, palm) = (position(l, "/o"), position(l, "/base/lift/palm"));
        [0, 1, 2].map(|i| o[i] - palm[i])
    };
    let held = lines.iter().find(|l| l.time() >= 0.95).map(apart).unwrap();
    distance(apart(&lines[lines.len() - 1]), held)
}

#[test]
fn geared_fingers_hold_a_heavy_object() {
    let geared = GEARED_KEYS.replace("-1.0", "1.0");
    let drive = |n: f64| format!("control = \"velocity\"\ntarget_velocity_m_s = 0.05\nmax_force_n = {n:?}\n");
    for (motor, follower) in [
        (drive(20.0), format!("{}{geared}", drive(20.0))),
        // The follower moves with the leader, even if its own motor has another target.
        (drive(20.0), format!("control = \"velocity\"\nmax_force_n = 20.0\n{geared}")),
        (drive(40.0), geared.clone()),
    ] {
        near("slip", slip(&motor, &follower), 0.0, 5e-4);
    }
}

/// With the rotor inertia that the URDF importer gives to light coupled links, the grip holds at both closing speeds,
/// and also with position and force control.
#[test]
fn geared_fingers_with_a_rotor_hold_in_every_control() {
    let rotor = "armature_kg = 0.05\n";
    for drive in [
        "control = \"velocity\"\ntarget_velocity_m_s = 0.1\n",
        "control = \"velocity\"\ntarget_velocity_m_s = 0.3\n",
        "control = \"position\"\ntarget_position_m = 0.08\n",
        "control = \"force\"\n",
    ] {
        for mass in [0.2, 0.5] {
            let motor = format!("{drive}max_force_n = 40.0\n{rotor}");
            near(drive, creep_between(0.015, mass, &motor, &format!("{GEARED_KEYS}{rotor}"), 10.0), 0.0, 1e-4);
        }
    }
}
