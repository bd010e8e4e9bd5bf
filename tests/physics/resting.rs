//! Tests of bodies that rest on, or are held by, several points.

use crate::{kit::*, scenes::*};

/// Checks that the four force sensors `NAME0` to `NAME3` below a load of 10 kg read a force, N, along z after 3 s: to
/// 1e-6 of the load as trees, where statics determines it, and to 1e-3 in the other forms.
#[track_caller]
fn sensors_read(scene: String, name: &str, force: f64) {
    let script = "function sysCall_sensing()
            local forces = {}
            for i = 0, 3 do forces[i + 1] = select(2, sim.readForceSensor(sim.getObject('/NAME' .. i)))[3] end
            sim.addStatusbarMessage(table.concat(forces, ' '))
        end";
    let lines = watch_run(&(scene + &watcher("reader", &script.replace("NAME", name))), &[], 3.0);
    let within = if crate::SETTINGS.is_empty() { 1e-6 } else { 1e-3 };
    for read in lines[lines.len() - 1].status()[0].split(' ') {
        near("force, N", read.parse().unwrap(), force, within * 10.0 * G);
    }
}

/// A symmetric body of 10 kg on four legs of 0.2 kg, each below a force sensor. By symmetry, each sensor carries a
/// quarter of the body.
#[test]
fn four_legs_carry_equal_shares() {
    let mut scene = floor(1.0) + &body("body", "", "box", [0.8, 0.5, 0.1], 10.0, "position_m = [0.0, 0.0, 0.451]");
    for (i, (x, y)) in [(-0.35, -0.2), (0.35, -0.2), (-0.35, 0.2), (0.35, 0.2)].into_iter().enumerate() {
        scene += &format!(
            "[[object]]\nkind = \"force_sensor\"\nalias = \"f{i}\"\nparent = \"/body\"\nposition_m = [{x:?}, {y:?}, -0.05]\n"
        );
        let more = "position_m = [0.0, 0.0, -0.2]\nrespondable = true\nrespondable_mask = 65280";
        scene += &body(&format!("leg{i}"), &format!("/body/f{i}"), "capsule", [0.04, 0.04, 0.4], 0.2, more);
    }
    sensors_read(scene, "f", 10.0 * G / 4.0);
}

/// A table of 10 kg on four load cells, each below a plate; by symmetry, each carries a quarter.
#[test]
fn load_cells_below_a_table_carry_equal_shares() {
    let mut scene = floor(1.0);
    for (i, (x, y)) in [(-0.4, -0.3), (0.4, -0.3), (-0.4, 0.3), (0.4, 0.3)].into_iter().enumerate() {
        let foot = format!("position_m = [{x:?}, {y:?}, 0.05]");
        scene += &format!(
            "[[object]]\nkind = \"shape\"\nalias = \"foot{i}\"\nsize_m = [0.1, 0.1, 0.1]\n{foot}\nrespondable = true\n\
             [[object]]\nkind = \"force_sensor\"\nalias = \"cell{i}\"\nparent = \"/foot{i}\"\nposition_m = [0, 0, 0.05]\n"
        );
        let plate = "position_m = [0, 0, 0.01]\nrespondable = true";
        scene += &body(&format!("plate{i}"), &format!("/foot{i}/cell{i}"), "box", [0.1, 0.1, 0.02], 0.1, plate);
    }
    scene += &body("table", "", "box", [1.0, 0.8, 0.05], 10.0, "position_m = [0, 0, 0.145]\nrespondable = true");
    // A sensor carries its plate, too, and reads the force on its child, which points down.
    sensors_read(scene, "cell", -(10.0 / 4.0 + 0.1) * G);
}

/// Two fingers of 20 N hold 1 kg by friction 1, which could carry 40 N: at most 17.7 N while it is shaken by 5 cm at 2
/// Hz. The faces also resist the torque of an object that is held above its centre of mass.
#[test]
fn grip_with_friction_to_spare_does_not_pivot() {
    let finger = |side: f64, alias: &str| {
        let slide = placed([0.06 * side, 0.0, 1.14], [0.0, -side, 0.0], std::f64::consts::FRAC_PI_2);
        let drive = format!(
            "type = \"prismatic\"\ncontrol = \"force\"\nmax_force_n = 20.0\ntarget_velocity_m_s = 0.1\n{slide}"
        );
        let pad = placed([0.06 * side, 0.0, 1.14], [1.0, 0.0, 0.0], 0.0) + "\nrespondable = true\nfriction = 1.0";
        joint(&format!("j{alias}"), "/base/lift/palm", &drive)
            + &body(alias, &format!("/base/lift/palm/j{alias}"), "box", [0.01, 0.04, 0.1], 0.1, &pad)
    };
    let lift = "type = \"prismatic\"\ncontrol = \"position\"\nmax_force_n = 2000.0";
    let palm = placed([0.0, 0.0, 1.2], [1.0, 0.0, 0.0], 0.0);
    let table = "[[object]]\nkind = \"shape\"\nalias = \"table\"\nsize_m = [0.06, 0.06, 0.98]\n\
                 position_m = [0, 0, 0.57]\nrespondable = true\n";
    let hand = watcher(
        "hand",
        "function sysCall_actuation()
            local t = sim.getSimulationTime()
            local z = t < 1 and 0 or math.min(0.3, (t - 1) * 0.2)
            if t > 3 then z = 0.3 + 0.05 * math.sin(4 * math.pi * (t - 3)) end
            sim.setJointTargetPosition(sim.getObject('/base/lift'), z)
        end",
    );
    let held = "position_m = [0, 0, 1.1]\nrespondable = true\nfriction = 1.0";
    let scene = floor(1.0)
        + &base([0.0, 0.0, 1.5])
        + &joint("lift", "/base", lift)
        + &body("palm", "/base/lift", "box", [0.2, 0.1, 0.02], 1.0, &palm)
        + &finger(-1.0, "left")
        + &finger(1.0, "right")
        + table
        + &body("held", "", "box", [0.06, 0.06, 0.08], 1.0, held)
        + &hand;
    let lines = watch_run(&scene, &["/held", "/base/lift/palm"], 13.0);
    let apart = |l: &TraceLine| position(l, "/held")[2] - position(l, "/base/lift/palm")[2];
    let start = lines.iter().find(|l| l.time() >= 2.7).unwrap();
    let (mut slip, mut tilt) = (0.0f64, 0.0f64);
    for line in lines.iter().filter(|l| l.time() >= 2.7) {
        slip = slip.max((apart(line) - apart(start)).abs());
        let [x, y, ..] = line.object::<4>("/held", "quaternion");
        tilt = tilt.max(2.0 * x.hypot(y));
    }
    near("slip, m", slip, 0.0, 5e-4);
    near("tilt, rad", tilt, 0.0, 0.01);
}

/// A ball of 4 cm at 20 m/s moves by 2.5 times its diameter in a physics step. A plate of 2 cm on a joint stops it.
#[test]
fn fast_ball_does_not_pass_a_plate_on_a_joint() {
    let plate = placed([0.0, 0.0, 0.75], [1.0, 0.0, 0.0], 0.0) + "\nrespondable = true";
    let ball = |more: &str| {
        format!("position_m = [-0.5, 0, 0.6]\nrespondable = true\n{more}{}", starts([20.0, 0.0, 0.0], [0.0; 3]))
    };
    // In reduced form, the engine moves both, and only bullets stop.
    let with = if crate::SETTINGS.is_empty() { vec!["", "bullet = true\n"] } else { vec!["bullet = true\n"] };
    for more in with {
        let scene = "gravity_m_s2 = [0, 0, 0]\ndt_s = 0.005\n".to_owned()
            + &base([0.0, 0.0, 1.0])
            + &joint("j", "/base", "control = \"free\"\norientation_deg = [-90, 0, 0]")
            + &body("plate", "/base/j", "box", [0.02, 0.3, 0.5], 2.0, &plate)
            + &body("ball", "", "sphere", [0.04; 3], 1.0, &ball(more));
        let lines = watch_run(&scene, &["/ball", "/base/j"], 0.05);
        let end = &lines[lines.len() - 1];
        assert!(of_joint(end, "/base/j", "velocity").abs() > 1.0, "the plate swings");
        assert!(speed(end, "/ball") < 15.0, "{}", speed(end, "/ball"));
    }
}
