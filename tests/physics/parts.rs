//! Tests of screws, gears, controllers, motors with a speed-torque curve, and force sensors.

use std::f64::consts::TAU;

use crate::{kit::*, scenes::*};

/// A nut of 1 kg on a thread of 10 mm lead, turned at 2 turns per second: it climbs at 20 mm/s, and its motor carries
/// the weight.
#[test]
fn a_screw_lifts() {
    let motor =
        "lead_m = 0.01\ncontrol = \"velocity\"\ntarget_velocity_rad_s = 12.566370614359172\nmax_force_nm = 10.0";
    let scene = base([0.0; 3]) + &joint("j", "/base", motor) + &body("nut", "/base/j", "cylinder", [0.1; 3], 1.0, "");
    let lines = watch_run(&scene, &["/base/j", "/base/j/nut"], 5.0);
    let end = &lines[lines.len() - 1];
    near("speed", speed(end, "/base/j/nut"), 0.02, 1e-4);
    let start = position(&lines[19], "/base/j/nut")[2];
    near("height", position(end, "/base/j/nut")[2] - start, 0.02 * (end.time() - lines[19].time()), 1e-3);
    near("torque", of_joint(end, "/base/j", "effort"), G * 0.01 / TAU, 1e-4);
}

/// Without a motor the weight rotates the nut: the torque m g lead / 2 pi accelerates its inertia and its mass.
#[test]
fn a_weight_turns_a_screw() {
    let scene = base([0.0; 3])
        + &joint("j", "/base", "lead_m = 0.1")
        + &body("nut", "/base/j", "cylinder", [0.1; 3], 1.0, "inertia_kg_m2 = [0.01, 0.01, 0.01]");
    let lines = watch_run(&scene, &["/base/j"], 1.0);
    let lead = 0.1 / TAU;
    let rate = -G * lead / (0.01 + lead * lead);
    let end = &lines[lines.len() - 1];
    near("speed", of_joint(end, "/base/j", "velocity"), rate * end.time(), 1e-3 * rate.abs());
}

/// With two shafts geared 1 to -3, a torque on the first accelerates the inertia of both.
#[test]
fn gears_load_each_other() {
    let shaft = |alias: &str, x: f64, more: &str| {
        let at = placed([x, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0);
        joint(alias, "/base", &format!("{at}\n{more}"))
            + &body(
                &format!("{alias}_disc"),
                &format!("/base/{alias}"),
                "cylinder",
                [0.1, 0.1, 0.02],
                1.0,
                &format!("{at}\ninertia_kg_m2 = [0.01, 0.01, 0.02]"),
            )
    };
    let scene = base([0.0; 3])
        + &shaft("a", 0.0, "control = \"force\"\nmax_force_nm = 0.2")
        + &shaft(
            "b",
            0.5,
            "follows = \":/a\"\nfollow_factor = -3.0\nfollow_offset_deg = 10.0\ngeared = true\njoint_position_deg = 10.0",
        );
    let lines = watch_run(&scene, &["/base/a", "/base/b"], 2.0);
    let end = &lines[lines.len() - 1];
    let rate = 0.2 / (0.02 + 9.0 * 0.02);
    near("speed", of_joint(end, "/base/a", "velocity"), rate * end.time(), 1e-3);
    near("ratio", of_joint(end, "/base/b", "velocity"), -3.0 * rate * end.time(), 3e-3);
    let apart = of_joint(end, "/base/b", "position") + 3.0 * of_joint(end, "/base/a", "position");
    near("offset", (apart - 10f64.to_radians() + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0, 0.0, 1e-4);
}

/// P and I control moves a joint to its target against a load; with the target's velocity it follows a ramp without
/// lag.
#[test]
fn controllers() {
    let scene = |gains: &str| {
        let keys = format!("control = \"position\"\nmax_force_nm = 50.0\nmax_velocity_rad_s = 5.0\n{gains}");
        base([0.0; 3])
            + &joint("j", "/base", &format!("{}\n{keys}", about_y([0.0; 3])))
            + &body("bob", "/base/j", "sphere", [0.1; 3], 1.0, "position_m = [0.0, 0.3, 0.0]")
    };
    // With P alone, the error decays to 1/e in the time 1/P, and slightly faster in discrete steps of 5 ms.
    let lines = watch_run(&scene("target_position_rad = 1.0\ngains = [4.0, 0.0, 0.0]"), &["/base/j"], 3.0);
    let way = |l: &TraceLine| 1.0 - of_joint(l, "/base/j", "position");
    let (early, late) = (&lines[9], &lines[19]);
    near(
        "shrinks",
        (way(early) / way(late)).ln() / (late.time() - early.time()),
        -(1.0 - 4.0 * 0.005f64).ln() / 0.005,
        0.05,
    );
    // P alone follows a ramp with a lag of velocity / P; with the target's velocity as a second input there is no lag.
    let ramp = "[[object]]\nkind = \"dummy\"\nalias = \"hand\"\nscript = { text = '''\nfunction sysCall_init() j = sim.getObject('/base/j') end\nfunction sysCall_actuation() sim.setJointTargetPosition(j, 0.5 * (sim.getSimulationTime() + 0.05)) end\n''' }\n";
    for (gains, lag) in [
        ("gains = [10.0, 0.0, 0.0]", 0.05),
        ("gains = [10.0, 0.0, 0.0]\ntarget_velocity_rad_s = 0.5", 0.0),
        ("gains = [10.0, 20.0, 0.0]", 0.0),
    ] {
        let lines = watch_run(&(scene(gains) + ramp), &["/base/j"], 4.0);
        let end = &lines[lines.len() - 1];
        near(gains, 0.5 * end.time() - of_joint(end, "/base/j", "position"), lag, 0.02);
    }
}

/// A motor with 2 N m and a no-load speed of 10 rad/s reaches half that speed against a load of 1 N m.
#[test]
fn a_motor_weakens_with_speed() {
    for control in ["control = \"velocity\"\ntarget_velocity_rad_s = 100.0", "control = \"force\""] {
        let motor = format!("{control}\nmax_force_nm = 2.0\nno_load_speed_rad_s = 10.0\ndry_friction_nm = 1.0");
        let scene = base([0.0; 3])
            + &joint("j", "/base", &motor)
            + &body("w", "/base/j", "cylinder", [0.2, 0.2, 0.05], 1.0, "");
        let lines = watch_run(&scene, &["/base/j"], 3.0);
        near(control, of_joint(&lines[lines.len() - 1], "/base/j", "velocity"), 5.0, 0.02);
    }
    // Where the load is below the speed-torque line, the motor reaches its target velocity.
    let motor = "control = \"velocity\"\ntarget_velocity_rad_s = 3.0\nmax_force_nm = 2.0\nno_load_speed_rad_s = 10.0\ndry_friction_nm = 1.0";
    let scene =
        base([0.0; 3]) + &joint("j", "/base", motor) + &body("w", "/base/j", "cylinder", [0.2, 0.2, 0.05], 1.0, "");
    let lines = watch_run(&scene, &["/base/j"], 3.0);
    near("slow", of_joint(&lines[lines.len() - 1], "/base/j", "velocity"), 3.0, 0.01);
    // 2 N m would accelerate a wheel of 5 g far beyond the no-load speed within one sub-step. Tested with both solvers.
    for solver in ["reduced", "impulse"] {
        for control in ["control = \"velocity\"\ntarget_velocity_rad_s = 100.0", "control = \"force\""] {
            let motor = format!("{control}\nmax_force_nm = 2.0\nno_load_speed_rad_s = 6.0");
            let scene = base([0.0; 3]).replacen("alias", &format!("joint_solver = \"{solver}\"\nalias"), 1)
                + &joint("j", "/base", &motor)
                + &body("w", "/base/j", "cylinder", [0.04, 0.04, 0.005], 0.005, "");
            let lines = watch_run(&scene, &["/base/j"], 2.0);
            near(solver, of_joint(&lines[lines.len() - 1], "/base/j", "velocity"), 6.0, 0.06);
        }
    }
}

const FORCE_READER: &str = "[[object]]\nkind = \"dummy\"\nalias = \"reader\"\nscript = { text = '''\nfunction sysCall_init() f = sim.getObject('/base/f') end\nfunction sysCall_sensing() local r, a, b = sim.readForceSensor(f) sim.addStatusbarMessage(string.format('%d %.6f %.6f %.6f %.6f %.6f %.6f', r, a[1], a[2], a[3], b[1], b[2], b[3])) end\n''' }\n";

fn readings(scene: &str, seconds: f64) -> Vec<Vec<f64>> {
    let lines = watch_run(&format!("{scene}{FORCE_READER}"), &[], seconds);
    lines.iter().map(|l| l.status()[0].split(' ').map(|x| x.parse().unwrap()).collect()).collect()
}

/// A force sensor measures the weight of a body, its torque, a body carried by a joint, and a body resting on top.
#[test]
fn a_force_sensor_weighs() {
    let sensor = "[[object]]\nkind = \"force_sensor\"\nalias = \"f\"\nparent = \"/base\"\n";
    let arm =
        body("arm", "/base/f", "box", [0.2, 0.1, 0.1], 2.0, "world_pose = [0.1, 0, 1, 0, 0, 0, 1]\nrespondable = true");
    let scene = floor(1.0) + &base([0.0, 0.0, 1.0]) + sensor + &arm;
    let end = readings(&scene, 1.0).pop().unwrap();
    for (i, wanted) in [0.0, 0.0, -2.0 * G, 0.0, 2.0 * G * 0.1, 0.0].into_iter().enumerate() {
        near(&format!("value {i}"), end[i + 1], wanted, 1e-3);
    }
    assert_eq!(end[0], 1.0);
    // A box of 1 kg falls on its end and stays there.
    let load = body("load", "", "box", [0.05; 3], 1.0, "position_m = [0.15, 0.0, 1.08]\nrespondable = true");
    let end = readings(&(scene.clone() + &load), 3.0).pop().unwrap();
    near("with a load", end[3], -3.0 * G, 0.01);
    near("torque of the load", end[5], G * (2.0 * 0.1 + 0.15), 0.02);
    // A pendulum hangs below the sensor, at rest or swinging: then the force at the lowest point is m g + m v^2 / r.
    let hung = |q: f64| {
        let at = placed([0.5 * q.sin(), 0.0, 1.0 - 0.5 * q.cos()], [1.0, 0.0, 0.0], 0.0);
        base([0.0, 0.0, 1.0])
            + sensor
            + &body("link", "/base/f", "box", [0.02; 3], 0.001, "world_pose = [0, 0, 1, 0, 0, 0, 1]")
            + &joint("j", "/base/f/link", &about_y([0.0, 0.0, 1.0]))
            + &body("bob", "/base/f/link/j", "sphere", [0.02; 3], 1.0, &at)
    };
    let all = readings(&hung(0.5), 6.0);
    let most = all.iter().map(|r| r[3]).fold(0.0, f64::min);
    near("swinging", most, -G * (1.0 + 2.0 * (1.0 - 0.5f64.cos())), 0.05);
}

/// A force sensor breaks above its threshold, and releases its load.
#[test]
fn a_force_sensor_breaks() {
    let sensor = |n: f64| {
        format!(
            "[[object]]\nkind = \"force_sensor\"\nalias = \"f\"\nparent = \"/base\"\nbreak_force_n = {n}\nbreak_count = 10\n"
        )
    };
    let arm = body("arm", "/base/f", "box", [0.1; 3], 1.0, "");
    for (limit, broken) in [(10.0, false), (9.0, true)] {
        let end = readings(&(base([0.0, 0.0, 1.0]) + &sensor(limit) + &arm), 1.0).pop().unwrap();
        assert_eq!(end[0] as i64 & 2 != 0, broken, "{end:?}");
        let lines = watch_run(&(base([0.0, 0.0, 1.0]) + &sensor(limit) + &arm), &["/base/f/arm"], 1.0);
        let fallen = 1.0 - position(&lines[lines.len() - 1], "/base/f/arm")[2] > 1.0;
        assert_eq!(fallen, broken);
    }
}

/// In force mode the sign of a joint's target force determines its direction.
#[test]
fn a_negative_target_force_pushes_the_other_way() {
    let run = |set: &str| {
        let script = format!(
            "function sysCall_init() j = sim.getObject('/base/j')
                sim.setObjectInt32Param(j, sim.jointintparam_dynctrlmode, sim.jointdynctrl_force) end
            function sysCall_actuation() {set} end
            function sysCall_cleanup() print(string.format('force %.3f', sim.getJointTargetForce(j))) end"
        );
        let place = TestFolder::scene(
            &("gravity_m_s2 = [0.0, 0.0, 0.0]\n".to_owned()
                + &base([0.0; 3])
                + &joint("j", "/base", "")
                + &body("w", "/base/j", "box", [0.2; 3], 1.0, "inertia_kg_m2 = [1.0, 1.0, 1.0]")
                + &watcher("hand", &script)),
        );
        let done = place.run(&["--seconds", "1", "--trace", "t.jsonl", "--watch", "/base/j"]).good();
        let lines = place.lines("t.jsonl");
        (of_joint(&lines[lines.len() - 1], "/base/j", "velocity") / lines[lines.len() - 1].time(), done.err)
    };
    for (set, force) in [
        ("sim.setJointTargetForce(j, -2)", -2.0),
        ("sim.setJointTargetForce(j, 2)", 2.0),
        ("sim.setJointForce(j, -2)", -2.0),
        ("sim.setJointTargetForce(j, -2, false)", 2.0),
    ] {
        let (rate, told) = run(set);
        near(set, rate, force, 0.01);
        assert!(told.contains(&format!("force {force:.3}")), "{set}: {told}");
    }
}
