//! Tests of inertial units, wheel encoders, compasses and barometers against closed forms.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::kit::*;

fn sensor(kind: &str, parent: &str, keys: &str) -> String {
    format!("[[object]]\nkind = \"sensor\"\nalias = \"{kind}\"\nsensor = \"{kind}\"\nparent = \"{parent}\"\n{keys}\n")
}

fn vector<const N: usize>(line: &TraceLine, path: &str, field: &str) -> [f64; N] {
    let value = &line.0["readings"][path][field];
    numbers(value).try_into().unwrap_or_else(|v| panic!("{field}: {v:?} in {}", line.0["readings"]))
}

/// Returns a motor that rotates an arm about the vertical with a constant velocity, rad/s.
fn turntable(velocity: f64) -> String {
    format!(
        "{}[[object]]\nkind = \"joint\"\nalias = \"motor\"\nparent = \"/stand\"\nposition_m = [0.0, 0.0, 0.5]\n\
         control = \"velocity\"\ntarget_velocity_rad_s = {velocity:?}\nmax_force_nm = 1e6\n{}",
        cuboid("stand", [0.1, 0.1, 1.0], [0.0, 0.0, 0.5], ""),
        cuboid("arm", [1.2, 0.05, 0.05], [0.0, 0.0, 0.1], "parent = \"/stand/motor\"\ndynamic = true\nmass_kg = 2.0"),
    )
}

#[test]
fn a_unit_at_rest_reads_gravity_upwards() {
    let body = cuboid("box", [0.2; 3], [0.0, 0.0, 0.1], "dynamic = true\nrespondable = true\nmass_kg = 1.0");
    // The sensor is rotated by 90 degrees about x, so its +y axis points up.
    let turned =
        sensor("imu", "/box", "orientation_deg = [90.0, 0.0, 0.0]").replace("alias = \"imu\"", "alias = \"turned\"");
    let scene =
        format!("sleep = false\n{FLOOR}{body}{}{turned}", sensor("imu", "/box", "position_m = [0.1, 0.1, 0.1]"));
    let lines = TestFolder::scene(&scene).trace(&["/box/imu", "/box/turned"], &["--seconds", "5"]);
    for line in &lines[60..] {
        let [x, y, z] = vector(line, "/box/imu", "imu.acceleration");
        assert!(x.abs() < 1e-6 && y.abs() < 1e-6 && (z - 9.81).abs() < 1e-6, "{x} {y} {z}");
        let [x, y, z] = vector(line, "/box/turned", "imu.acceleration");
        assert!(x.abs() < 1e-6 && (y - 9.81).abs() < 1e-6 && z.abs() < 1e-6, "{x} {y} {z}");
        assert!(vector::<3>(line, "/box/imu", "imu.angular_velocity").iter().all(|w| w.abs() < 1e-6));
    }
}

#[test]
fn a_turntable_pulls_inwards() {
    let scene = format!("{}{}", turntable(3.0), sensor("imu", "/stand/motor/arm", "position_m = [0.5, 0.0, 0.0]"));
    let lines = TestFolder::scene(&scene).trace(&["/stand/motor/arm/imu"], &["--seconds", "3"]);
    // The sensor measures the centripetal acceleration, 3^2 · 0.5 m/s^2, and gravity.
    for line in &lines[5..] {
        let [x, y, z] = vector(line, "/stand/motor/arm/imu", "imu.acceleration");
        assert!((x + 4.5).abs() < 4.5e-3 && y.abs() < 4.5e-3 && (z - 9.81).abs() < 4.5e-3, "{x} {y} {z}");
        let [_, _, w] = vector(line, "/stand/motor/arm/imu", "imu.angular_velocity");
        assert!((w - 3.0).abs() < 1e-6, "{w}");
    }
}

/// Returns the angle and the angular velocity of a rod of 1 m at a time after it was released from the horizontal. It
/// integrates angle'' = 3/2 g cos(angle) by the Runge-Kutta method in steps of 0.1 ms.
fn pendulum(time: f64) -> (f64, f64) {
    let n = (time / 1e-4).ceil();
    let h = time / n;
    let slope = |(p, w): (f64, f64)| (w, 1.5 * 9.81 * f64::cos(p));
    let mut at = (0.0, 0.0);
    for _ in 0..n as usize {
        let along = |k: (f64, f64), h: f64| (at.0 + h * k.0, at.1 + h * k.1);
        let a = slope(at);
        let b = slope(along(a, h / 2.0));
        let c = slope(along(b, h / 2.0));
        let d = slope(along(c, h));
        at.0 += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
        at.1 += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
    }
    at
}

#[test]
fn the_tip_of_a_swinging_rod_feels_four_times_its_weight() {
    // The axis of the hinge is horizontal. The x axis of the rod points away from the hinge, and its y axis initially
    // up.
    let script = "function sysCall_init() imu = sim.getObject('/post/hinge/rod/imu') end
        function sysCall_sensing()
            local r = tatu.read(imu)
            sim.addStatusbarMessage(string.format('%.17g %.17g %.17g %.17g', r.time, r.acceleration[1],
                r.acceleration[2], r.angular_velocity[3]))
        end";
    let scene = format!(
        "{}[[object]]\nkind = \"joint\"\nalias = \"hinge\"\nparent = \"/post\"\norientation_deg = [90.0, 0.0, 0.0]\n{}{}{}",
        cuboid("post", [0.1; 3], [0.0, 0.0, 3.0], ""),
        cuboid("rod", [1.0, 0.001, 0.001], [0.5, 0.0, 0.0], "parent = \"/post/hinge\"\ndynamic = true\nmass_kg = 1.0"),
        sensor("imu", "/post/hinge/rod", "position_m = [0.5, 0.0, 0.0]"),
        watcher("reader", script),
    );
    // The step equals the default physics step, so the sensor is read in each physics step.
    let scene = format!("dt_s = 0.005\n{scene}");
    let lines = TestFolder::scene(&scene).trace(&[], &["--seconds", "0.6"]);
    let told: Vec<Vec<f64>> = lines
        .iter()
        .flat_map(|l| {
            l.status().into_iter().map(|s| s.split(' ').map(|x| x.parse().unwrap()).collect()).collect::<Vec<_>>()
        })
        .collect();
    // The rod is at its lowest point after 0.4834 s. There the sensor at the tip measures 3 g from the motion and 1 g
    // from gravity.
    let mut greatest = 0.0_f64;
    for row in told.iter().filter(|row| (0.45..0.517).contains(&row[0])) {
        let (angle, velocity) = pendulum(row[0]);
        let inwards = velocity * velocity + 9.81 * angle.sin();
        let across = 9.81 * angle.cos() - 1.5 * 9.81 * angle.cos();
        assert!((row[1] + inwards).abs() < 1e-3 * 39.24, "along the rod at {} s: {}, not {}", row[0], row[1], -inwards);
        assert!((row[2] - across).abs() < 1e-3 * 39.24, "across at {} s: {}, not {across}", row[0], row[2]);
        assert!((row[3] + velocity).abs() < 2e-3 * velocity, "{} not {}", row[3], -velocity);
        greatest = greatest.max(-row[1]);
    }
    assert!((greatest - 39.24).abs() < 1e-3 * 39.24, "{greatest}");
}

#[test]
fn counts_are_the_turns_of_the_wheel() {
    let keys = "counts_per_turn = 1000.0\ngear = 2.0";
    let scene = format!("{}{}", turntable(37.0), sensor("wheel_encoder", "/stand/motor", keys));
    let path = "/stand/motor/wheel_encoder";
    let lines = TestFolder::scene(&scene).trace(&[path, "/stand/motor/arm"], &["--seconds", "30"]);
    // The direction of the arm determines the fraction of a turn, and its velocity the number of full turns.
    let mut turns = 0.0;
    for (i, line) in lines.iter().enumerate() {
        let angle = yaw(line.object("/stand/motor/arm", "quaternion")) / TAU;
        let expected = 37.0 * line.time() / TAU;
        turns = angle + (expected - angle).round();
        let ticks = line.sensor(path, "encoder.ticks");
        assert!((ticks - 2000.0 * turns).abs() <= 1.0, "step {i}: {ticks} counts, {turns} turns");
    }
    assert!((170.0..180.0).contains(&turns), "{turns}");
    assert!((lines.last().unwrap().sensor(path, "encoder.velocity") - 37.0).abs() < TAU / 2000.0 / 0.005);
}

#[test]
fn a_compass_measures_its_heading() {
    let horizontal = 5e-5 * f64::cos(1.0);
    for (yaw_deg, declination_deg) in [(0.0, 0.0), (90.0, 0.0), (37.0, 0.0), (-120.0, 11.5), (180.0, -20.0)] {
        let keys = format!(
            "orientation_deg = [0.0, 0.0, {yaw_deg:?}]\ndeclination_deg = {declination_deg:?}\nstrength_t = 5e-5\n\
             inclination_rad = 1.0"
        );
        let scene = sensor("compass", "", &keys).replace("parent = \"\"\n", "");
        let line = TestFolder::scene(&scene).trace(&["/compass"], &["--steps", "2"]).pop().unwrap();
        let heading = line.sensor("/compass", "magnetic_field.heading");
        let wanted = (FRAC_PI_2 - f64::to_radians(yaw_deg + declination_deg)).rem_euclid(TAU);
        assert!((heading - wanted).abs() < 1e-9, "yaw {yaw_deg}: {heading}, not {wanted}");
        let [x, y, z] = vector(&line, "/compass", "magnetic_field.field");
        assert!((x - horizontal * wanted.cos()).abs() < 1e-15 && (y - horizontal * wanted.sin()).abs() < 1e-15);
        assert!((z + 5e-5 * f64::sin(1.0)).abs() < 1e-15, "{z}");
    }
}

#[test]
fn the_heading_follows_from_the_noisy_field() {
    let keys = "orientation_deg = [0.0, 0.0, 90.0]\nnoise.field = { sigma = 1e-6 }\nscale = [1.0, 1.0, 0.5]";
    let scene = sensor("compass", "", keys).replace("parent = \"\"\n", "");
    let lines = TestFolder::scene(&scene).trace(&["/compass"], &["--steps", "20"]);
    let mut headings = Vec::new();
    for line in &lines {
        let [x, y, _] = vector(line, "/compass", "magnetic_field.field");
        let heading = line.sensor("/compass", "magnetic_field.heading");
        assert!((heading - y.atan2(x).rem_euclid(TAU)).abs() < 1e-12, "{heading}");
        headings.push(heading.to_bits());
    }
    headings.sort_unstable();
    headings.dedup();
    assert_eq!(headings.len(), 20);
}

#[test]
fn a_barometer_reads_the_standard_atmosphere() {
    // The pressure of the standard atmosphere in the lowest layer, as a function of the geopotential altitude.
    let standard = |z: f64| {
        let h = 6_356_766.0 * z / (6_356_766.0 + z);
        101_325.0 * (1.0 - 0.0065 * h / 288.15).powf(5.255_876)
    };
    for (origin, z) in [(0.0, 0.0), (1000.0, 0.0), (4000.0, 1000.0), (-400.0, 0.0), (8000.0, -12.5)] {
        let pressure = standard(origin + z);
        let scene = format!(
            "origin = {{ lat_deg = 48.0, alt_m = {origin:?} }}\n{}",
            sensor("barometer", "", &format!("position_m = [3.0, 4.0, {z:?}]")).replace("parent = \"\"\n", "")
        );
        let line = TestFolder::scene(&scene).trace(&["/barometer"], &["--steps", "1"]).pop().unwrap();
        let found = line.sensor("/barometer", "pressure.pressure");
        assert!((found - pressure).abs() < 0.1, "{found} Pa at {} m, not {pressure}", origin + z);
        assert!((line.sensor("/barometer", "pressure.altitude") - origin - z).abs() < 1e-6);
    }
    // If the pressure at sea level is 10 hPa lower, an altimeter that is not adjusted shows a higher altitude.
    let scene = sensor("barometer", "", "sea_level_pressure_pa = 100325.0").replace("parent = \"\"\n", "");
    let line = TestFolder::scene(&scene).trace(&["/barometer"], &["--steps", "1"]).pop().unwrap();
    assert_eq!(line.sensor("/barometer", "pressure.pressure"), 100_325.0);
    let told = line.sensor("/barometer", "pressure.altitude");
    assert!((83.0..84.5).contains(&told), "{told}");
}
