//! Tests of free flight, bounces, and free rotation.

use crate::{kit::*, scenes::*};

/// With a first-order integrator and sub-steps h, a body falls g h / 2 too far in 1 s.
#[test]
fn falls() {
    let more = "position_m = [0, 0, 20]";
    let lines = watch_run(&body("b", "", "sphere", [0.1; 3], 1.0, more), &["/b"], 1.0);
    let last = &lines[lines.len() - 1];
    near("fallen in 1 s", 20.0 - position(last, "/b")[2], G / 2.0, 7e-3);
    near("speed", speed(last, "/b"), G, 1e-9);
}

/// The height of each apex is that of the one before times the square of the restitution.
#[test]
fn bounces() {
    for restitution in [0.5f64, 0.9, 1.0] {
        let floor = floor(1.0) + "restitution = 1.0\n";
        let ball = format!("respondable = true\nrestitution = {restitution}\nposition_m = [0, 0, 1.05]");
        let scene = format!("dt_s = 0.01\n{floor}{}", body("b", "", "sphere", [0.1; 3], 1.0, &ball));
        let lines = watch_run(&scene, &["/b"], 4.0);
        let t: Vec<f64> = lines.iter().map(|l| l.time()).collect();
        let z: Vec<f64> = lines.iter().map(|l| position(l, "/b")[2] - 0.05).collect();
        for (i, (_, apex)) in peaks(&t, &z).iter().take(3).enumerate() {
            let bounce = i as i32 + 1;
            near(&format!("apex {bounce} at {restitution}"), apex / restitution.powi(2 * bounce), 1.0, 0.01);
        }
    }
}

/// A freely rotating body keeps its energy and angular momentum for a minute.
#[test]
fn tumbling_conserves_energy_and_momentum() {
    for (inertia, w) in [
        ([0.01, 0.02, 0.03], [2.0, 1.0, 3.0]),
        ([0.01, 0.01, 0.02], [1.0, 0.0, 10.0]),
        ([0.01, 0.02, 0.03], [0.01, 5.0, 0.01]),
    ] {
        let more = format!("inertia_kg_m2 = {inertia:?}\n{}", starts([0.0; 3], w));
        let scene = format!("gravity_m_s2 = [0, 0, 0]\n{}", body("b", "", "box", [0.3, 0.2, 0.1], 1.0, &more));
        let lines = watch_run(&scene, &["/b"], 60.0);
        let last = &lines[lines.len() - 1];
        let now = into_body(last.object("/b", "quaternion"), last.object("/b", "angular_velocity"));
        let sum = |w: [f64; 3], power: i32| (0..3).map(|i| f64::powi(inertia[i], power) * w[i] * w[i]).sum::<f64>();
        near("energy", sum(now, 1) / sum(w, 1), 1.0, 0.01);
        near("momentum", (sum(now, 2) / sum(w, 2)).sqrt(), 1.0, 0.005);
    }
}

/// A body that rotates about its intermediate axis flips 12 times in a minute.
#[test]
fn the_middle_axis_flips() {
    let more = format!("inertia_kg_m2 = [0.01, 0.02, 0.03]\n{}", starts([0.0; 3], [0.01, 5.0, 0.01]));
    let scene = format!("gravity_m_s2 = [0, 0, 0]\n{}", body("b", "", "box", [0.3, 0.2, 0.1], 1.0, &more));
    let about: Vec<f64> = watch_run(&scene, &["/b"], 60.0)
        .iter()
        .map(|l| into_body(l.object("/b", "quaternion"), l.object("/b", "angular_velocity"))[1])
        .collect();
    let flips = about.windows(2).filter(|w| w[0] * w[1] < 0.0).count();
    assert_eq!(flips, 12);
}

#[test]
fn a_fast_spin_is_not_limited() {
    let more = format!("inertia_kg_m2 = [0.01, 0.01, 0.02]\n{}", starts([0.0; 3], [0.0, 0.0, 200.0]));
    let free = format!("gravity_m_s2 = [0, 0, 0]\n{}", body("b", "", "box", [0.3, 0.2, 0.1], 1.0, &more));
    let lines = watch_run(&free, &["/b"], 5.0);
    near("alone", lines[lines.len() - 1].object::<3>("/b", "angular_velocity")[2], 200.0, 0.1);
    let motor = "control = \"velocity\"\ntarget_velocity_rad_s = 200.0\nmax_force_nm = 10.0";
    let driven =
        base([0.0; 3]) + &joint("j", "/base", motor) + &body("w", "/base/j", "cylinder", [0.2, 0.2, 0.05], 1.0, "");
    let lines = watch_run(&driven, &["/base/j"], 3.0);
    near("by a motor", of_joint(&lines[lines.len() - 1], "/base/j", "velocity"), 200.0, 0.1);
}

/// A body that falls without end, or moves extremely fast, is reported once, by name.
#[test]
fn bodies_that_fly_away_are_reported_once() {
    let scene = body("fallen", "", "sphere", [0.1; 3], 1.0, "")
        + &body("thrown", "", "sphere", [0.1; 3], 1.0, &starts([0.0, 150.0, 0.0], [0.0; 3]))
        + &body("calm", "", "sphere", [0.1; 3], 1.0, &starts([0.0, 0.0, 40.0], [0.0; 3]));
    let err = TestFolder::scene(&scene).run(&["--seconds", "12"]).good().err;
    println!("{err}");
    assert_eq!(err.matches("/fallen moves at 100 m/s").count(), 1, "{err}");
    assert_eq!(err.matches("/thrown moves at 150 m/s, 8 m from its start, at 0.05 s").count(), 1, "{err}");
    assert!(!err.contains("/calm"), "{err}");
}

/// A force added between physics steps acts during one physics step. Added in the actuation stage, it acts during the
/// whole step of the world.
#[test]
fn added_forces_act_as_long_as_they_are_added() {
    for (name, add) in [
        ("sysCall_dyn(d) if not d.afterStep then", "sim.addForce(h, {0, 0, 0}, {1, 0, 0}) end"),
        ("sysCall_dyn(d) if d.afterStep then", "sim.addForceAndTorque(h, {1, 0, 0}, {0, 0, 0}) end"),
        ("sysCall_actuation()", "sim.addForce(h, {0, 0, 0}, {1, 0, 0})"),
        ("sysCall_actuation()", "sim.addForceAndTorque(h, {1, 0, 0})"),
    ] {
        let script = format!("function sysCall_init() h = sim.getObject('/b') end function {name} {add} end");
        let scene = "gravity_m_s2 = [0.0, 0.0, 0.0]\n".to_owned()
            + &body("b", "", "box", [0.1; 3], 1.0, "")
            + &watcher("hand", &script);
        let lines = watch_run(&scene, &["/b"], 1.0);
        let end = &lines[lines.len() - 1];
        near(name, end.object::<3>("/b", "linear_velocity")[0], end.time(), 0.006);
    }
}
