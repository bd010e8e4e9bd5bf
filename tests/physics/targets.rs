//! Tests that position targets are interpolated between steps of the scene, so that they do not shake the driven
//! bodies.

use crate::{kit::*, scenes::*};

/// Simulates a cart on a slide whose position target is a sine of 0.1 m at 1 Hz, set once per step of the scene.
/// Returns the maximum acceleration between physics steps, m/s^2. The exact value is 3.95.
fn peak(scene: &str, keys: &str) -> f64 {
    let slide = "type = \"prismatic\"\norientation_deg = [0, 90, 0]\ncontrol = \"position\"\nmax_force_n = 500.0\n";
    let hand = watcher(
        "hand",
        "function sysCall_init() j = sim.getObject('/base/j') most, last = 0, 0 end
        function sysCall_actuation()
            sim.setJointTargetPosition(j, 0.1 * math.sin(2 * math.pi * (sim.getSimulationTime() + 0.05)))
        end
        function sysCall_dyn(d)
            if not d.afterStep then return end
            local v = sim.getJointVelocity(j)
            if sim.getSimulationTime() > 0.5 then most = math.max(most, math.abs(v - last) / d.dt) end
            last = v
        end
        function sysCall_cleanup() print(string.format('peak %.3f', most)) end",
    );
    let scene = scene.to_owned()
        + &base([0.0; 3])
        + &joint("j", "/base", &(slide.to_owned() + keys))
        + &body("cart", "/base/j", "box", [0.1; 3], 1.0, "")
        + &hand;
    let out = TestFolder::scene(&scene).run(&["--seconds", "3"]).good().err;
    let told = out.lines().find_map(|l| l.split_once("peak ")).unwrap_or_else(|| panic!("{out}"));
    told.1.trim().parse().unwrap()
}

#[test]
fn a_sine_is_followed_without_jumps() {
    let smooth = peak("", "");
    println!("peak: {smooth}");
    assert!(smooth < 5.0, "{smooth}");
    let jumping = peak("", "smooth_target = false\n");
    assert!(jumping > 100.0, "without `smooth_target` the target jumps once per scene step: {jumping}");
}

/// The same holds with custom gains that include a derivative part.
#[test]
fn a_controller_follows_without_jumps() {
    let peak = peak("", "gains = [20.0, 0.0, 0.1]\n");
    assert!(peak < 6.0, "{peak}");
}

#[test]
fn one_physics_step_in_a_scene_step_is_as_before() {
    assert_eq!(peak("dt_s = 0.005\n", ""), peak("dt_s = 0.005\n", "smooth_target = false\n"));
}

/// A joint lags behind a sine of 0.5 Hz by one and a half steps of the scene (the target is set before the step that
/// follows it, and the spline is half a step behind), however fast it is; at most 80 ms at the default step.
#[test]
fn a_sine_is_followed_within_80_ms() {
    let omega = std::f64::consts::PI;
    for (keys, lag) in [
        ("", 0.075),
        // The target's velocity as a second input leaves the delay of the target, which jumps once per step.
        ("smooth_target = false\ngains = [20.0, 0.0, 0.0]\n", 0.075),
        ("smooth_target = false\ngains = [20.0, 0.0, 0.0]\nforward = true\n", 0.025),
    ] {
        let forward = keys.contains("forward");
        let drive = "control = \"position\"\nmax_force_nm = 500.0\n".to_owned() + &keys.replace("forward = true\n", "");
        let velocity = "sim.setJointTargetVelocity(j, 0.5 * math.pi * math.cos(math.pi * sim.getSimulationTime()))";
        let hand = watcher(
            "hand",
            &format!(
                "function sysCall_init() j = sim.getObject('/base/j') end
                function sysCall_actuation()
                    sim.setJointTargetPosition(j, 0.5 * math.sin(math.pi * sim.getSimulationTime()))
                    {}
                end",
                if forward { velocity } else { "" }
            ),
        );
        let scene = base([0.0; 3])
            + &joint("j", "/base", &(drive + &about_y([0.0; 3])))
            + &body("bob", "/base/j", "box", [0.1; 3], 1.0, "world_pose = [0.2, 0, 0, 0, 0, 0, 1]")
            + &hand;
        let lines = watch_run(&scene, &["/base/j"], 10.0);
        // The phase of the fundamental over whole periods, after the start.
        let (mut a, mut b) = (0.0, 0.0);
        for line in lines.iter().filter(|l| l.time() > 2.0 + 1e-9) {
            let (s, c) = (omega * line.time()).sin_cos();
            let x = of_joint(line, "/base/j", "position");
            (a, b) = (a + x * s, b + x * c);
        }
        let measured = -b.atan2(a) / omega;
        near(keys, measured, lag, 0.004);
        assert!(measured <= 0.08);
    }
}

/// The integral does not grow while a wall blocks the drive at its limit: when the target returns, so does the joint,
/// at once, as P alone would.
#[test]
fn the_integral_does_not_wind_up_at_the_limit() {
    let run = |i: f64| {
        let slide = format!(
            "type = \"prismatic\"\norientation_deg = [0, 90, 0]\ncontrol = \"position\"\nmax_force_n = 100.0\n\
             gains = [4.0, {i:?}, 0.0]\nsmooth_target = false\ntarget_position_m = 0.1"
        );
        let wall = "[[object]]\nkind = \"shape\"\nalias = \"wall\"\nsize_m = [0.1, 1, 1]\nposition_m = [0.3, 0, 0]\n\
                    respondable = true\n";
        let cart = placed([0.2, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0) + "\nrespondable = true";
        let hand = watcher(
            "hand",
            "function sysCall_actuation()
                if sim.getSimulationTime() > 4.99 then sim.setJointTargetPosition(sim.getObject('/base/j'), -0.1) end
            end",
        );
        let scene = "gravity_m_s2 = [0, 0, 0]\n".to_owned()
            + &base([-0.5, 0.0, 0.0])
            + &joint("j", "/base", &slide)
            + &body("cart", "/base/j", "box", [0.1; 3], 1.0, &cart)
            + wall
            + &hand;
        let lines = watch_run(&scene, &["/base/j"], 5.5);
        of_joint(&lines[lines.len() - 1], "/base/j", "position")
    };
    // x = -0.1 (1 - exp(-4 t)) after half a second
    let alone = run(0.0);
    near("P", alone, -0.1 * (1.0 - (-2.0f64).exp()), 1e-3);
    // With I, in continuous time: x'' + 4 x' + 2 x = -0.2 from rest at the start of the return, where x' = -0.4.
    let (root, t) = (2.0f64.sqrt(), 0.5);
    let (fast, slow) = (-2.0 - root, -2.0 + root);
    // x + 0.1 = a exp(fast t) + b exp(slow t), with x(0) = 0 and x'(0) = -0.4
    let a = (-0.4 - 0.1 * slow) / (fast - slow);
    let exact = -0.1 + a * (fast * t).exp() + (0.1 - a) * (slow * t).exp();
    near("P and I", run(2.0), exact, 2e-3);
}

/// Targets that a script sets between physics steps take effect immediately.
#[test]
fn targets_set_between_physics_steps_act_at_once() {
    let run = |keys: &str| {
        let slide = "type = \"prismatic\"\ncontrol = \"position\"\nmax_force_n = 500.0\n".to_owned() + keys;
        let hand = watcher(
            "hand",
            "function sysCall_init() j = sim.getObject('/base/j') n = 0 end
            function sysCall_dyn(d)
                if d.afterStep then return end
                n = n + 1
                sim.setJointTargetPosition(j, 0.1 * math.sin(0.02 * n))
            end",
        );
        let scene = base([0.0; 3]) + &joint("j", "/base", &slide) + &body("c", "/base/j", "box", [0.1; 3], 1.0, "");
        let lines = watch_run(&(scene + &hand), &["/base/j"], 2.0);
        of_joint(&lines[lines.len() - 1], "/base/j", "position")
    };
    near("position", run(""), run("smooth_target = false\n"), 1e-5);
}

/// A gripper holds its object while a hand, whose targets are set 20 times per second, shakes it at 2 Hz.
#[test]
fn a_shaken_gripper_does_not_lose_its_object() {
    let finger = |alias: &str, x: f64, angle: f64| {
        let slide = placed([x, 0.0, 0.2], [0.0, 1.0, 0.0], angle);
        let pad = placed([x, 0.0, 0.16], [1.0, 0.0, 0.0], 0.0) + "\nrespondable = true\nfriction = 0.9";
        let drive = "type = \"prismatic\"\nlimits_m = [-0.1, 0.1]\ncontrol = \"force\"\nmax_force_n = 20.0\n";
        joint(&format!("j{alias}"), "/base/lift/palm", &(drive.to_owned() + &slide))
            + &body(&format!("f{alias}"), &format!("/base/lift/palm/j{alias}"), "box", [0.02, 0.04, 0.3], 0.05, &pad)
    };
    let hand = watcher(
        "hand",
        "function sysCall_actuation()
            local t = sim.getSimulationTime()
            local z = t < 1 and 0 or t < 2 and 0.1 * (3 * (t - 1) ^ 2 - 2 * (t - 1) ^ 3)
                or 0.1 + 0.02 * math.min(1, t - 2) ^ 2 * math.sin(4 * math.pi * (t - 2))
            sim.setJointTargetPosition(sim.getObject('/base/lift'), z)
        end",
    );
    let lift = "type = \"prismatic\"\ncontrol = \"position\"\nmax_force_n = 1000.0\nlimits_m = [-0.5, 0.5]";
    let palm = placed([0.0, 0.0, 0.3], [1.0, 0.0, 0.0], 0.0);
    let object = "respondable = true\nfriction = 0.9\nposition_m = [0, 0, 0.05]";
    let scene = floor(1.0)
        + &base([0.0, 0.0, 1.0])
        + &joint("lift", "/base", lift)
        + &body("palm", "/base/lift", "box", [0.2, 0.05, 0.05], 1.0, &palm)
        + &finger("l", -0.06, std::f64::consts::FRAC_PI_2)
        + &finger("r", 0.06, -std::f64::consts::FRAC_PI_2)
        + &body("o", "", "box", [0.04, 0.04, 0.1], 0.2, object)
        + &hand;
    let lines = watch_run(&scene, &["/o", "/base/lift/palm"], 12.0);
    let height = |l: &TraceLine| position(l, "/o")[2] - position(l, "/base/lift/palm")[2];
    let held = lines.iter().find(|l| l.time() >= 2.0).map(height).unwrap();
    assert!(position(&lines[lines.len() - 1], "/o")[2] > 0.1, "the object was not lifted");
    near("slip", height(&lines[lines.len() - 1]) - held, 0.0, 5e-4);
}
