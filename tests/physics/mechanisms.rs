//! Tests of loops, springs, friction in joints, armature, spherical joints, limits and gears.

use std::f64::consts::PI;

use crate::{kit::*, scenes::*};

/// Returns the scene entry of a bar between two points of the plane y = 0.
fn bar(alias: &str, parent: &str, from: [f64; 3], to: [f64; 3]) -> String {
    let (dx, dz) = (to[0] - from[0], to[2] - from[2]);
    let middle = [(from[0] + to[0]) / 2.0, 0.0, (from[2] + to[2]) / 2.0];
    let place = placed(middle, [0.0, 1.0, 0.0], -dz.atan2(dx));
    body(alias, parent, "box", [dx.hypot(dz), 0.02, 0.02], 0.2, &place)
}

/// A crank of 0.1 m, a coupler of 0.3 m and a rocker of 0.25 m on a base of 0.3 m: the loop stays closed for a minute.
#[test]
fn a_four_bar_loop_stays_closed() {
    let (o, c, p): ([f64; 3], [f64; 3], [f64; 3]) = ([0.0; 3], [0.0, 0.0, 0.1], [0.3, 0.0, 0.0]);
    // The intersection of the circles about the crank's end and the rocker's pivot.
    let (ux, uz, d) = (p[0] - c[0], p[2] - c[2], f64::hypot(p[0] - c[0], p[2] - c[2]));
    let a = (0.09 - 0.0625 + d * d) / (2.0 * d);
    let h = (0.09 - a * a).sqrt();
    let e = [c[0] + (a * ux - h * uz) / d, 0.0, c[2] + (a * uz + h * ux) / d];
    let (tip, pin) = ("/base/crank/b1/elbow/b2/tip", "/base/rocker/b3/hinge/pin/end");
    let dummy = |alias: &str, parent: &str, link: &str| {
        let place = placed(e, [1.0, 0.0, 0.0], 0.0);
        format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\nparent = \"{parent}\"\n{place}\n{link}\n")
    };
    let motor = "\ncontrol = \"velocity\"\ntarget_velocity_rad_s = 2.0\nmax_force_nm = 10.0";
    let scene = base([0.0; 3])
        + &joint("crank", "/base", &(about_y(o) + motor))
        + &bar("b1", "/base/crank", o, c)
        + &joint("elbow", "/base/crank/b1", &about_y(c))
        + &bar("b2", "/base/crank/b1/elbow", c, e)
        + &joint("rocker", "/base", &about_y(p))
        + &bar("b3", "/base/rocker", p, e)
        + &joint("hinge", "/base/rocker/b3", &about_y(e))
        + &body("pin", "/base/rocker/b3/hinge", "sphere", [0.02; 3], 0.05, &placed(e, [1.0, 0.0, 0.0], 0.0))
        + &dummy("tip", "/base/crank/b1/elbow/b2", &format!("link = \"{pin}\""))
        + &dummy("end", "/base/rocker/b3/hinge/pin", "");
    let lines = watch_run(&scene, &[tip, pin, "/base/crank"], 60.0);
    for line in &lines {
        assert!(distance(position(line, tip), position(line, pin)) < 1e-4, "the loop is open at {} s", line.time());
        near("crank", of_joint(line, "/base/crank", "velocity"), 2.0, 0.01);
    }
}

/// Simulates a mass of 1 kg on a slide along x without gravity, with `keys` in the joint. Returns times and positions.
fn slide(keys: &str, seconds: f64) -> (Vec<f64>, Vec<f64>) {
    let place = placed([0.0; 3], [0.0, 1.0, 0.0], PI / 2.0);
    let scene = String::from("dt_s = 0.01\ngravity_m_s2 = [0, 0, 0]\n")
        + &base([0.0; 3])
        + &joint("j", "/base", &format!("type = \"prismatic\"\n{place}\n{keys}"))
        + &body("m", "/base/j", "box", [0.1; 3], 1.0, "");
    let lines = watch_run(&scene, &["/base/j"], seconds);
    (lines.iter().map(|l| l.time()).collect(), lines.iter().map(|l| of_joint(l, "/base/j", "position")).collect())
}

/// A mass on a spring with damping oscillates like an oscillator of 10 rad/s with a damping ratio of 0.1.
#[test]
fn spring_and_damper() {
    let (t, x) = slide("joint_position_m = 0.1\nstiffness_n_m = 100.0\ndamping_ns_m = 2.0", 5.0);
    let peaks = peaks(&t, &x);
    near("period", (peaks[4].0 - peaks[0].0) / 4.0 / (2.0 * PI / (10.0 * 0.99f64.sqrt())), 1.0, 0.01);
    near("decay", (peaks[0].1 / peaks[4].1).ln() / (peaks[4].0 - peaks[0].0), 1.0, 0.01);
}

/// A spring too stiff for any sub-step comes to rest instead of oscillating.
#[test]
fn stiff_spring() {
    let (_, x) = slide("joint_position_m = 0.1\nstiffness_n_m = 1e7\ndamping_ns_m = 2.0\nrest_position_m = 0.05", 5.0);
    near("rest", x[x.len() - 1], 0.05, 1e-6);
}

/// A force of 3 N against 2 N of dry friction moves 1 kg at 1 m/s^2, and 1 N does not move it.
#[test]
fn dry_friction() {
    let way = |n: f64| slide(&format!("control = \"force\"\nmax_force_n = {n:?}\ndry_friction_n = 2.0"), 2.0).1[199];
    near("3 N", way(3.0), 2.0, 0.02);
    near("1 N", way(1.0), 0.0, 1e-6);
}

/// With 3 kg of armature, a force of 1 N accelerates 1 kg by 0.25 m/s^2.
#[test]
fn armature() {
    let way = slide("control = \"force\"\nmax_force_n = 1.0\narmature_kg = 3.0", 2.0).1[199];
    near("distance in 2 s", way, 0.5, 0.005);
}

/// Under the force F with the damping c, the final velocity is F / c.
#[test]
fn damping() {
    let (t, x) = slide("control = \"force\"\nmax_force_n = 1.0\ndamping_ns_m = 10.0", 4.0);
    near("speed", (x[399] - x[299]) / (t[399] - t[299]), 0.1, 1e-4);
}

/// A ball on a spherical joint swings like a pendulum, in a plane that does not rotate.
#[test]
fn spherical_joint() {
    let bob = placed([0.6, 0.0, -0.8], [1.0, 0.0, 0.0], 0.0);
    let scene = base([0.0; 3])
        + &joint("j", "/base", "type = \"spherical\"")
        + &body("bob", "/base/j", "sphere", [0.1; 3], 1.0, &bob);
    for line in watch_run(&scene, &["/base/j/bob"], 20.0) {
        let at = position(&line, "/base/j/bob");
        near("distance", norm(at), 1.0, 1e-6);
        near("aside", at[1], 0.0, 1e-6);
        let energy = 0.5 * speed(&line, "/base/j/bob").powi(2) + G * at[2];
        near("energy", energy, -0.8 * G, 0.02 * G);
    }
}

/// A rod that falls onto a joint limit comes to rest there.
#[test]
fn limit() {
    let rod = placed([0.5, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0);
    let scene = base([0.0; 3])
        + &joint("j", "/base", &(about_y([0.0; 3]) + "\nlimits_deg = [-45.0, 45.0]"))
        + &body("rod", "/base/j", "box", [1.0, 0.05, 0.05], 2.0, &rod);
    let lines = watch_run(&scene, &["/base/j"], 5.0);
    let angle = |l: &TraceLine| of_joint(l, "/base/j", "position").to_degrees();
    assert!(lines.iter().all(|l| angle(l) < 45.3), "the rod exceeds the limit of 45 degrees");
    near("at the limit", angle(&lines[lines.len() - 1]), 45.0, 0.01);
}

/// The scene of [`everything`] gives the same bits with 1, 2 and 4 threads, when it writes a snapshot, and when it is
/// continued from that snapshot.
#[test]
fn all_kinds_have_the_same_bits_on_any_number_of_threads() {
    let place = scene_of(&everything());
    let hash = |args: &[&str]| place.run(&[&["--seconds", "4"], args].concat()).good().json()["hash"].clone();
    let one = hash(&["--threads", "1"]);
    assert_eq!(one, hash(&["--threads", "2"]));
    assert_eq!(one, hash(&["--threads", "4"]));
    assert_eq!(one, hash(&["--snapshot-at", "2", "half.state"]));
    assert_eq!(one, hash(&["--from", "half.state"]));
}

/// Returns a scene with many kinds of joints, motors and contacts, in which both joint solvers are used.
fn everything() -> String {
    let mut scene = "friction_pairs = [[\"ice\", \"ice\", 0.3]]\n".to_owned()
        + &floor(1.0)
        + "[[model]]\nmodel = \"pioneer_p3dx\"\n"
        + &base([2.0, 0.0, 1.0]);
    let at = |x: f64, z: f64| placed([x, 0.0, z], [1.0, 0.0, 0.0], 0.0);
    scene += &joint("r", "/base", &(about_y([2.0, 0.0, 1.0]) + "\ndry_friction_nm = 0.01\narmature_kg_m2 = 0.01"));
    scene += &body("one", "/base/r", "box", [0.2, 0.05, 0.05], 1.0, &at(2.1, 1.0));
    scene += &joint("s", "/base/r/one", &(at(2.2, 1.0) + "\ntype = \"spherical\"\ndamping_nms_rad = 0.01"));
    scene += &body("two", "/base/r/one/s", "box", [0.2, 0.05, 0.05], 1.0, &(at(2.3, 1.0) + "\nrespondable = true"));
    scene += &joint(
        "p",
        "/base/r/one/s/two",
        &(at(2.4, 1.0) + "\ntype = \"prismatic\"\nstiffness_n_m = 200.0\nlimits_m = [-0.1, 0.1]"),
    );
    scene += &body(
        "three",
        "/base/r/one/s/two/p",
        "sphere",
        [0.1; 3],
        0.5,
        &(at(2.4, 0.9) + "\nrespondable = true\nbullet = true"),
    );
    scene += &format!("[[object]]\nkind = \"force_sensor\"\nalias = \"f\"\nparent = \"/base\"\n{}\n", at(1.9, 1.0));
    scene += &body("tied", "/base/f", "box", [0.1; 3], 1.0, &at(1.8, 1.0));
    scene += &joint(
        "m",
        "/base/f/tied",
        &(about_y([1.7, 0.0, 1.0]) + "\ncontrol = \"position\"\ntarget_position_deg = 40.0\nmax_force_nm = 20.0"),
    );
    scene += &body("driven", "/base/f/tied/m", "box", [0.2, 0.05, 0.05], 1.0, &at(1.6, 1.0));
    let still = |alias: &str, x: f64| {
        format!(
            "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nsize_m = [0.05, 0.05, 0.05]\nposition_m = [{x:?}, 2.0, 1.0]\n"
        )
    };
    let up = |x: f64| placed([x, 2.0, 1.0], [1.0, 0.0, 0.0], 0.0);
    scene += &(still("press", 0.0)
        + &joint("screw", "/press", &format!("{}\nlead_m = 0.05", up(0.0)))
        + &body("nut", "/press/screw", "cylinder", [0.1; 3], 1.0, &up(0.0)));
    scene += &(still("box", 1.0)
        + &joint(
            "in",
            "/box",
            &format!(
                "{}\ncontrol = \"velocity\"\ntarget_velocity_rad_s = 3.0\nmax_force_nm = 1.0\nno_load_speed_rad_s = 5.0",
                up(1.0)
            ),
        )
        + &body("gear", "/box/in", "cylinder", [0.1; 3], 1.0, &up(1.0))
        + &joint("out", "/box", &format!("{}\nfollows = \":/in\"\nfollow_factor = -2.0\ngeared = true", up(1.5)))
        + &body("pinion", "/box/out", "cylinder", [0.1; 3], 1.0, &up(1.5)));
    scene += &(still("servo", 2.5)
        + &joint(
            "pid",
            "/servo",
            &format!(
                "{}\ncontrol = \"position\"\ntarget_position_deg = 60.0\nmax_force_nm = 5.0\ngains = [5.0, 2.0, 0.01]",
                up(2.5)
            ),
        )
        + &body("horn", "/servo/pid", "box", [0.1; 3], 1.0, &up(2.55)));
    let lying = |alias: &str, x: f64, more: &str| {
        body(
            alias,
            "",
            "sphere",
            [0.1; 3],
            1.0,
            &format!(
                "position_m = [{x:?}, -2.0, 0.051]\nrespondable = true\n{more}\n{}",
                starts([0.5, 0.2, 0.0], [0.0, 1.0, 3.0])
            ),
        )
    };
    scene += &lying("rolls", 0.0, "rolling_friction_m = 0.002\nspinning_friction_m = 0.002");
    scene += &lying("skates", 1.0, "friction_axis = [1, 0, 0]\naxis_friction = 0.05\nmaterial = \"ice\"");
    scene += "[[object]]\nkind = \"shape\"\nalias = \"belt\"\nsize_m = [2.0, 0.5, 0.1]\nposition_m = [4.0, -2.0, 0.05]\nrespondable = true\nsurface_velocity_m_s = [0.3, 0.0, 0.0]\nmaterial = \"ice\"\n";
    scene += &body(
        "carried",
        "",
        "box",
        [0.1; 3],
        1.0,
        "position_m = [4.0, -2.0, 0.151]\nrespondable = true\nmaterial = \"ice\"",
    );
    for i in 0..5 {
        let more = format!("respondable = true\nposition_m = [-1.0, 0.0, {}]", 0.05 + 0.11 * f64::from(i));
        scene += &body(&format!("b{i}"), "", "box", [0.1; 3], 1.0, &more);
    }
    scene
}
