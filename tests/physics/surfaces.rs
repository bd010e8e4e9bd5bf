//! Tests of belts, skates, rolling resistance, materials, and friction in contact reports.

use crate::{kit::*, scenes::*};

/// A box on a belt reaches the belt's speed with an acceleration of friction * g, and keeps it.
#[test]
fn a_belt_carries() {
    let belt = "[[object]]\nkind = \"shape\"\nalias = \"belt\"\nsize_m = [4.0, 0.5, 0.1]\nposition_m = [0.0, 0.0, -0.05]\nrespondable = true\nfriction = 1.0\nsurface_velocity_m_s = [0.5, 0.0, 0.0]\n";
    let scene = belt.to_owned()
        + &body("b", "", "box", [0.1; 3], 1.0, "position_m = [0.0, 0.0, 0.05]\nrespondable = true\nfriction = 0.1");
    let lines = watch_run(&scene, &["/b"], 3.0);
    let v = |l: &TraceLine| l.object::<3>("/b", "linear_velocity")[0];
    near("early", v(&lines[4]), 0.1 * G * lines[4].time(), 2e-3);
    near("later", v(&lines[lines.len() - 1]), 0.5, 1e-4);
}

/// A skate slides along its axis and holds across it; friction along the axis slows it by its coefficient.
#[test]
fn a_skate_has_an_axis() {
    let skate = |friction: f64, v: [f64; 3]| {
        let more = format!(
            "position_m = [0.0, 0.0, 0.05]\nrespondable = true\nfriction = 0.8\nfriction_axis = [1, 0, 0]\naxis_friction = {friction:?}\n{}",
            starts(v, [0.0; 3])
        );
        floor(1.0) + &body("b", "", "box", [0.2, 0.1, 0.1], 1.0, &more)
    };
    let end = |scene: &str| {
        let lines = watch_run(scene, &["/b"], 0.5);
        (lines[lines.len() - 1].object::<3>("/b", "linear_velocity"), lines[lines.len() - 1].time())
    };
    near("free", end(&skate(0.0, [1.0, 0.0, 0.0])).0[0], 1.0, 1e-3);
    let (v, t) = end(&skate(0.1, [1.0, 0.0, 0.0]));
    near("slowed", v[0], 1.0 - 0.1 * G * t, 0.01);
    let (v, _) = end(&skate(0.0, [0.5, 0.5, 0.0]));
    near("along", v[0], 0.5, 0.01);
    near("across", v[1], 0.0, 1e-3);
    // On a slope of 10 degrees the skate slides along its axis without friction, and does not slide across it.
    let on_slope = |axis: &str| {
        let more = format!("position_m = [0.0, 0.0, 0.05]\nrespondable = true\nfriction = 0.8\nfriction_axis = {axis}");
        slope(10.0) + &floor(1.0) + &body("b", "", "box", [0.2, 0.1, 0.1], 1.0, &more)
    };
    let (v, t) = end(&on_slope("[1, 0, 0]"));
    near("down", v[0], G * 10f64.to_radians().sin() * t, 0.02);
    let (v, _) = end(&on_slope("[0, 1, 0]"));
    near("held", v[0], 0.0, 2e-3);
}

/// A rolling ball decelerates by 5/7 of g times the lever of the rolling resistance over the radius. A spinning ball
/// comes to rest, and a ball at rest does not start to roll on a slope gentler than lever / radius.
#[test]
fn rolling_and_spinning_are_resisted() {
    let ball = |more: &str| {
        floor(1.0)
            + &body(
                "b",
                "",
                "sphere",
                [0.2; 3],
                1.0,
                &format!("position_m = [0.0, 0.0, 0.1]\nrespondable = true\n{more}"),
            )
    };
    let start = starts([1.0, 0.0, 0.0], [0.0, 10.0, 0.0]);
    let lines = watch_run(&ball(&format!("rolling_friction_m = 0.002\n{start}")), &["/b"], 2.0);
    let end = &lines[lines.len() - 1];
    near("rolling", speed(end, "/b"), 1.0 - 0.002 / 0.1 * G * 5.0 / 7.0 * end.time(), 0.01);
    let start = starts([0.0; 3], [0.0, 0.0, 5.0]);
    let lines = watch_run(&ball(&format!("spinning_friction_m = 0.001\n{start}")), &["/b"], 1.0);
    let end = &lines[lines.len() - 1];
    near("spinning", end.object::<3>("/b", "angular_velocity")[2], 5.0 - 0.001 * G / (0.4 * 0.01) * end.time(), 0.05);
    let scene = slope(0.5) + &ball("rolling_friction_m = 0.002");
    let lines = watch_run(&scene, &["/b"], 5.0);
    near("stays", position(&lines[lines.len() - 1], "/b")[0], 0.0, 1e-3);
}

/// The friction between two shapes follows from theirs by the `friction_rule`, unless `friction_pairs` has a value for
/// their materials.
#[test]
fn materials_and_rules() {
    let slid = |settings: &str, material: &str| {
        let more = format!(
            "position_m = [0.0, 0.0, 0.05]\nrespondable = true\nfriction = 0.2\n{material}\n{}",
            starts([1.0, 0.0, 0.0], [0.0; 3])
        );
        let floor = floor(1.0) + "material = \"steel\"\n";
        let lines = watch_run(
            &(settings.to_owned() + &floor + &body("b", "", "box", [0.3, 0.3, 0.1], 1.0, &more)),
            &["/b"],
            0.1,
        );
        let end = &lines[lines.len() - 1];
        (1.0 - speed(end, "/b")) / (G * end.time())
    };
    let pairs = "friction_pairs = [[\"rubber\", \"steel\", 0.4], [\"ice\", \"steel\", 0.05, 0.5]]\n";
    near("product", slid("", ""), 0.2, 0.002);
    near("mean", slid("friction_rule = \"mean\"\n", ""), 0.6, 0.01);
    near("least", slid("friction_rule = \"least\"\n", ""), 0.2, 0.002);
    near("rubber", slid(pairs, "material = \"rubber\""), 0.4, 0.004);
    near("ice", slid(pairs, "material = \"ice\""), 0.05, 0.001);
    near("other", slid(pairs, "material = \"wood\""), 0.2, 0.002);
}

/// The contact forces on a box on a slope add up to its weight, including friction.
#[test]
fn contact_forces_include_friction() {
    let reader = "[[object]]\nkind = \"dummy\"\nalias = \"reader\"\nscript = { text = '''\nfunction sysCall_init() b = sim.getObject('/b') end\nfunction sysCall_sensing()\n local x, y, z, i = 0, 0, 0, 0\n while true do\n  local o, p, f = sim.getContactInfo(sim.handle_all, b, i)\n  if not o then break end\n  local s = o[2] == b and 1 or -1\n  x, y, z, i = x + s * f[1], y + s * f[2], z + s * f[3], i + 1\n end\n sim.addStatusbarMessage(string.format('%.6f %.6f %.6f', x, y, z))\nend\n''' }\n";
    for base in [floor(1.0), "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nsize_m = [4.0, 4.0, 1.0]\nposition_m = [0.0, 0.0, -0.5]\nrespondable = true\n".to_owned()] {
        let block = body("b", "", "box", [0.2, 0.2, 0.1], 2.0, "position_m = [0.0, 0.0, 0.05]\nrespondable = true");
        let lines = watch_run(&(slope(15.0) + &base + &block + reader), &[], 0.5);
        let forces: Vec<f64> = lines[lines.len() - 1].status()[0].split(' ').map(|x| x.parse().unwrap()).collect();
        let a = 15f64.to_radians();
        near("along", forces[0], -2.0 * G * a.sin(), 0.02);
        near("across", forces[1], 0.0, 0.02);
        near("normal", forces[2], 2.0 * G * a.cos(), 0.02);
    }
}

/// A frame on four Mecanum wheels moves as their speeds determine. The rollers are at 45 degrees to the axle at any
/// angle of the wheel.
#[test]
fn mecanum_wheels_go_sideways() {
    let (r, x, y) = (0.1, 0.2, 0.15);
    // Front left, front right, rear left, rear right: position, angle of the rollers, and the factors by which the
    // wheel's speed depends on the speeds forward and to the left.
    let wheels = [(x, y, 45, 1.0, -1.0), (x, -y, -45, 1.0, 1.0), (-x, y, -45, 1.0, 1.0), (-x, -y, 45, 1.0, -1.0)];
    let drive = |forward: f64, left: f64| {
        let mut scene = floor(1.0) + &body("frame", "", "box", [0.5, 0.25, 0.1], 10.0, "position_m = [0, 0, 0.15]");
        for (i, (x, y, angle, f, l)) in wheels.into_iter().enumerate() {
            let at = placed([x, y, r], [1.0, 0.0, 0.0], -std::f64::consts::FRAC_PI_2);
            let rate = (f * forward + l * left) / r;
            scene += &joint(
                &format!("j{i}"),
                "/frame",
                &format!("{at}\ncontrol = \"velocity\"\ntarget_velocity_rad_s = {rate:?}\nmax_force_nm = 20.0"),
            );
            let rollers =
                format!("{at}\nrespondable = true\nfriction_axis = [0, 0, 1]\nfriction_axis_angle_deg = {angle}");
            scene += &body(&format!("w{i}"), &format!("/frame/j{i}"), "cylinder", [0.2, 0.2, 0.05], 1.0, &rollers);
        }
        let lines = watch_run(&scene, &["/frame"], 5.0);
        let (from, to) = (&lines[19], &lines[lines.len() - 1]);
        let (a, b) = (position(from, "/frame"), position(to, "/frame"));
        let q = to.object::<4>("/frame", "quaternion");
        ([(b[0] - a[0]) / (to.time() - from.time()), (b[1] - a[1]) / (to.time() - from.time())], yaw(q))
    };
    for (forward, left) in [(0.0, 0.5), (0.5, 0.0), (0.3, -0.3)] {
        let (v, turned) = drive(forward, left);
        near("forward", v[0], forward, 0.01);
        near("to the left", v[1], left, 0.01);
        near("turned", turned, 0.0, 0.02);
    }
}
