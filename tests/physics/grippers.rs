//! What is gripped stays where it is gripped.

use std::f64::consts::FRAC_PI_2;

use crate::{kit::*, scenes::*};

/// A palm on a vertical slide with two fingers that press from the left and the right; `left` and `right` are the keys of
/// their drives. Grips for 2 s, lifts by 0.3 m, then shakes up and down; how far the object creeps on the fingers, m.
fn creep(mass: f64, left: &str, right: &str, seconds: f64) -> f64 {
    let finger = |alias: &str, x: f64, drive: &str| {
        let slide = placed([x, 0.0, 0.2], [0.0, 1.0, 0.0], FRAC_PI_2);
        let pad = placed([x, 0.0, 0.16], [1.0, 0.0, 0.0], 0.0) + "\nrespondable = true";
        joint(
            &format!("j{alias}"),
            "/base/lift/palm",
            &format!("type = \"prismatic\"\nlimits_m = [-0.1, 0.1]\n{slide}\n{drive}"),
        ) + &body(&format!("f{alias}"), &format!("/base/lift/palm/j{alias}"), "box", [0.02, 0.04, 0.3], 0.2, &pad)
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
    let height = |l: &Line| position(l, "/o")[2] - position(l, "/base/lift/palm")[2];
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
        near("creep of both pressing", creep(mass, &force(n), &force(-n), 20.0), 0.0, 5e-4);
    }
}

#[test]
fn grips_with_one_finger_held() {
    for (mass, n) in [(0.1, 20.0), (1.0, 200.0)] {
        let held = "control = \"position\"\ntarget_position_m = 0.04\nmax_force_n = 1000.0";
        near("creep of one held", creep(mass, held, &force(-n), 60.0), 0.0, 5e-4);
    }
}

/// Closing at a speed, with a limit of force.
#[test]
fn grips_at_the_limit_of_a_motor() {
    let drive = |v: f64| format!("control = \"velocity\"\ntarget_velocity_m_s = {v:?}\nmax_force_n = 20.0");
    near("creep", creep(0.1, &drive(0.1), &drive(-0.1), 20.0), 0.0, 5e-4);
}
