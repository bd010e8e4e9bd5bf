//! Tests that joints carry their load: arms, cantilevers, chains.

use std::f64::consts::FRAC_PI_2;

use crate::{kit::*, scenes::*};

/// Masses of the links of an arm, kg. Its seven joints rotate about z, y, z, y, z, y, z and are 0.2 m apart; it is the
/// arm of the comparison with other simulators (`bench/peers/scenes.py`).
const MASSES: [f64; 7] = [4.0, 4.0, 3.0, 3.0, 2.0, 1.5, 1.0];

/// Builds the arm in an upright pose; `keys(i)` returns the keys of joint `i`. Returns the scene, the paths of the
/// joints, and the path of the last link.
fn arm(keys: impl Fn(usize) -> String) -> (String, Vec<String>, String) {
    let (mut scene, mut at, mut joints) = (base([0.0; 3]) + "model_base = true\n", String::from("/base"), Vec::new());
    for (i, mass) in MASSES.iter().enumerate() {
        let z = 0.2 * i as f64;
        let frame = if i % 2 == 0 { placed([0.0, 0.0, z], [1.0, 0.0, 0.0], 0.0) } else { about_y([0.0, 0.0, z]) };
        scene += &joint(&format!("j{i}"), &at, &format!("{frame}\n{}", keys(i)));
        at += &format!("/j{i}");
        joints.push(at.clone());
        let place = placed([0.0, 0.0, z + 0.1], [1.0, 0.0, 0.0], 0.0);
        scene += &body(&format!("l{i}"), &at, "box", [0.08, 0.08, 0.2], *mass, &place);
        at += &format!("/l{i}");
    }
    (scene, joints, at)
}

/// Position control holds the arm horizontally, with a torque of 65 N m in the second joint.
#[test]
fn an_arm_held_level() {
    let target = |i: usize| if i == 1 { FRAC_PI_2 } else { 0.0 };
    let keys =
        |i: usize| format!("control = \"position\"\ntarget_position_rad = {:?}\nmax_force_nm = 1000.0", target(i));
    let (scene, joints, last) = arm(keys);
    let mut watch: Vec<&str> = joints.iter().map(String::as_str).collect();
    watch.push(&last);
    let lines = watch_run(&scene, &watch, 5.0);
    let end = &lines[lines.len() - 1];
    for (i, path) in joints.iter().enumerate() {
        near(path, of_joint(end, path, "position").to_degrees(), target(i).to_degrees(), 0.05);
        near("at rest", of_joint(end, path, "velocity"), 0.0, 1e-6);
    }
    near("tip", distance(position(end, &last), [1.1, 0.0, 0.2]), 0.0, 1e-3);
    // The sum of each link's weight times its distance.
    let load: f64 = (1..7).map(|i| MASSES[i] * G * (0.2 * i as f64 - 0.1)).sum();
    near("torque", of_joint(end, &joints[1], "effort"), -load, 0.01 * load);
}

/// The case of the benchmark with other simulators: a PD controller sets torques in each physics step of 2 ms. All
/// engines agree on 0.2019 rad.
#[test]
fn an_arm_under_pd_torques() {
    let (mut scene, joints, _) = arm(|_| "control = \"callback\"\nmax_force_nm = 1000.0".into());
    let script = "script = { dialect = \"4.9\", text = '''
        kp = {100, 200, 60, 150, 30, 30, 10}
        kd = {2, 20, 1.5, 15, 0.6, 3, 0.15}
        function sysCall_init() t = 0 n = {} for i = 0, 6 do n[sim.getObject(':/j'..i)] = i end end
        function sysCall_dyn(d) if d.afterStep then t = t + d.dt end end
        function sysCall_joint(d)
            local i = n[d.handle]
            return {force = kp[i + 1] * (0.5 * math.sin(t + i) - d.pos) - kd[i + 1] * d.vel}
        end
    ''' }\n";
    scene = scene.replacen("model_base = true\n", &format!("model_base = true\n{script}"), 1);
    let watch: Vec<&str> = joints.iter().map(String::as_str).collect();
    let lines = watch_run(&format!("physics_dt_s = 0.002\n{scene}"), &watch, 20.0);
    let end = &lines[lines.len() - 1];
    let behind = |i: usize| (0.5 * (20.0 + i as f64).sin() - of_joint(end, &joints[i], "position")).abs();
    let most = (0..7).map(behind).fold(0.0, f64::max);
    near("greatest error", most / 0.2019, 1.0, 0.01);
}

#[test]
fn cantilevers_do_not_droop() {
    for n in [5, 10] {
        let (mut scene, mut at) = (base([0.0; 3]), String::from("/base"));
        for i in 0..n {
            let x = 0.2 * f64::from(i);
            let place = placed([x, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0);
            scene += &format!("[[object]]\nkind = \"force_sensor\"\nalias = \"f{i}\"\nparent = \"{at}\"\n{place}\n");
            at += &format!("/f{i}");
            scene += &body(
                &format!("l{i}"),
                &at,
                "box",
                [0.2, 0.1, 0.1],
                1.0,
                &placed([x + 0.1, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0),
            );
            at += &format!("/l{i}");
        }
        let lines = watch_run(&scene, &[&at], 5.0);
        near("droop", position(&lines[lines.len() - 1], &at)[2], 0.0, 1e-3);
    }
}

/// A chain of twenty links of 0.1 m and 0.1 kg carries 10 kg at its end.
#[test]
fn a_chain_does_not_stretch() {
    let (mut scene, mut at) = (base([0.0; 3]), String::from("/base"));
    for i in 0..20 {
        let z = -0.1 * f64::from(i);
        let frame = if i % 2 == 0 { about_y([0.0, 0.0, z]) } else { placed([0.0, 0.0, z], [0.0, 1.0, 0.0], FRAC_PI_2) };
        scene += &joint(&format!("j{i}"), &at, &frame);
        at += &format!("/j{i}");
        let mass = if i == 19 { 10.0 } else { 0.1 };
        let place = placed([0.0, 0.0, z - 0.05], [1.0, 0.0, 0.0], 0.0);
        scene += &body(&format!("l{i}"), &at, "box", [0.02, 0.02, 0.1], mass, &place);
        at += &format!("/l{i}");
    }
    for line in watch_run(&scene, &[&at], 5.0) {
        near("length", -position(&line, &at)[2] + 0.05, 2.0, 2e-3);
    }
}

/// The motors are switched off during a swing, and a joint in the middle of the arm is then removed: the run continues
/// without an error.
#[test]
fn joints_and_bodies_may_go_while_it_moves() {
    let (scene, joints, last) =
        arm(|_| "control = \"position\"\ntarget_position_rad = 0.6\nmax_force_nm = 200.0".into());
    let script = watcher(
        "hand",
        "function sysCall_actuation()
            local t = sim.getSimulationTime()
            if t > 0.3 and not free then
                free = true
                for i = 0, 6 do sim.setJointMaxForce(sim.getObject(':/j'..i), 0) end
            end
            if t > 0.5 and not gone then
                gone = true
                sim.removeObject(sim.getObject(':/j3'))
            end
        end",
    );
    let done =
        scene_of(&(scene + &script)).run(&["--seconds", "2", "--watch", &joints[1], "--trace", "t.jsonl"]).good();
    assert!(done.json()["errors"].as_array().unwrap().is_empty(), "{last}: {}", done.err);
}

/// A target beyond a limit acts like one at the limit: the motor carries the load and does not press against the limit.
#[test]
fn a_target_beyond_a_limit_is_at_the_limit() {
    let motor = "control = \"position\"\ntarget_position_deg = 0.0\nmax_force_nm = 50.0\nlimits_deg = [20, 90]\njoint_position_deg = 45";
    let frame = "position_m = [0, 0, 1]\norientation_deg = [90, 0, 0]";
    let scene = base([0.0; 3])
        + &joint("j", "/base", &format!("{motor}\n{frame}"))
        + &body("link", "/base/j", "box", [0.4, 0.05, 0.05], 1.0, "position_m = [0.2, 0, 0]");
    let lines = watch_run(&scene, &["/base/j"], 3.0);
    let end = &lines[lines.len() - 1];
    near("position", of_joint(end, "/base/j", "position").to_degrees(), 20.0, 1e-3);
    near("torque", of_joint(end, "/base/j", "effort").abs(), 0.2 * G * 20f64.to_radians().cos(), 0.01);
}
