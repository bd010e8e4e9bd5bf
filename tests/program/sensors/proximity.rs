//! Tests of the volumes of proximity sensors, and of detectable objects in them, against closed-form geometry.
//!
//! The sensor is at the origin and faces up, so its frame is that of the world. Cones are tested in `pioneer_sonar.rs`.

use crate::kit::*;

fn eye(keys: &str) -> String {
    format!("[[object]]\nkind = \"sensor\"\nalias = \"eye\"\nsensor = \"proximity\"\n{keys}\n")
}

/// Returns the distance that the sensor measures, or `None` if it detects nothing.
fn read(scene: &str) -> Option<f64> {
    let line = TestFolder::scene(scene).trace(&["/eye"], &["--steps", "2"]).pop().unwrap();
    let seen = line.sensor("/eye", "proximity.detected") == 1.0;
    seen.then(|| line.sensor("/eye", "proximity.distance"))
}

#[track_caller]
fn expect(keys: &str, things: &str, wanted: Option<f64>) {
    let found = read(&format!("{}{things}", eye(keys)));
    let same = match (found, wanted) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-6,
        (a, b) => a == b,
    };
    assert!(same, "{keys}: {found:?} instead of {wanted:?}");
}

/// Returns a wall whose inner side is at x = `a`.
fn wall_x(a: f64) -> String {
    cuboid("wall", [0.1, 6.0, 6.0], [a + 0.05, 0.0, 0.0], "")
}
/// Returns a wall whose inner side is at y = `a`.
fn wall_y(a: f64) -> String {
    cuboid("wall", [6.0, 0.1, 6.0], [0.0, a + 0.05, 0.0], "")
}
/// Returns a plate with a thickness of 2 cm whose lower side is at z = `a`.
fn plate(a: f64) -> String {
    cuboid("plate", [3.0, 3.0, 0.02], [0.0, 0.0, a + 0.01], "")
}
fn ball(at: [f64; 3], radius: f64) -> String {
    let d = 2.0 * radius;
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [{d}, {d}, {d}]\n\
         position_m = {at:?}\n"
    )
}

#[test]
fn a_pyramid_is_cut_off_flat_at_both_ends() {
    // Half the width of the pyramid is 0.1 m at a height of 0.2 m, and 0.5 m (x) or 0.3 m (y) at 1.2 m.
    let keys = "volume = \"pyramid\"\nnear_m = 0.2\nrange_m = 1.2\nsize_near_m = [0.2, 0.2]\nsize_far_m = [1.0, 0.6]";
    expect(keys, &plate(1.1), Some(1.1));
    expect(keys, &plate(0.15), None);
    expect(keys, &plate(1.21), None);
    // The pyramid reaches the walls at z = 0.7, where 0.1 + 0.4 (z - 0.2) = 0.3 and 0.1 + 0.2 (z - 0.2) = 0.2.
    expect(keys, &wall_x(0.3), Some(0.3_f64.hypot(0.7)));
    expect(keys, &wall_y(0.2), Some(0.2_f64.hypot(0.7)));
    expect(keys, &wall_x(0.51), None);
    // An object in a far corner is at a distance greater than the height of the far end.
    let corner = (0.45_f64.powi(2) + 0.2_f64.powi(2) + 1.15_f64.powi(2)).sqrt() - 0.01;
    assert!(corner > 1.2);
    expect(keys, &ball([0.45, 0.2, 1.15], 0.01), Some(corner));
    expect(keys, &ball([0.45, 0.32, 1.15], 0.01), None);
}

#[test]
fn a_cylinder_may_widen() {
    let straight = "volume = \"cylinder\"\nrange_m = 1.2\nradius_near_m = 0.1\nradius_far_m = 0.1";
    expect(straight, &plate(0.5), Some(0.5));
    expect(straight, &wall_x(0.101), None);
    expect(straight, &wall_x(0.05), Some(0.05));
    let widening = "volume = \"cylinder\"\nnear_m = 0.2\nrange_m = 1.2\nradius_near_m = 0.1\nradius_far_m = 0.5";
    // The cylinder widens in all directions as the pyramid does along x.
    expect(widening, &wall_x(0.3), Some(0.3_f64.hypot(0.7)));
    expect(widening, &wall_y(0.3), Some(0.3_f64.hypot(0.7)));
    expect(widening, &plate(0.15), None);
    expect(widening, &plate(1.21), None);
    expect(
        widening,
        &ball([0.33, 0.33, 1.15], 0.005),
        Some((2.0 * 0.33_f64.powi(2) + 1.15_f64.powi(2)).sqrt() - 0.005),
    );
    expect(widening, &ball([0.37, 0.37, 1.15], 0.005), None);
}

#[test]
fn a_disc_is_flat() {
    let keys = "volume = \"disc\"\nangle_deg = 60.0\nheight_m = 0.1\nnear_m = 0.1\nrange_m = 2.0";
    expect(keys, &plate(0.5), Some(0.5));
    expect(keys, &plate(2.01), None);
    // The edge is at 30 degrees from the axis, so it reaches x = 0.3 at a distance of 0.3 / sin 30°.
    expect(keys, &wall_x(0.3), Some(0.6));
    // Half the height of the volume is 0.05 m. A block that starts at y = 0.04 extends into it, but one at 0.06 does
    // not.
    let block = |y: f64| cuboid("block", [1.0, 1.0, 0.1], [0.0, y + 0.5, 1.05], "");
    expect(keys, &block(0.04), Some(1_f64.hypot(0.04)));
    expect(keys, &block(0.06), None);
    // A gap of 20 degrees to either side of the axis.
    let gap = format!("{keys}\ngap_deg = 40.0");
    expect(&gap, &plate(1.0), Some(1.0 / 20_f64.to_radians().cos()));
}

#[test]
fn random_rays_lie_in_their_cone_and_change() {
    let keys = "volume = \"random_rays\"\nangle_deg = 20.0\nrange_m = 3.0\nsamples = 200";
    let scene = format!("{}{}", eye(keys), plate(1.0));
    let run = || TestFolder::scene(&scene).trace(&["/eye"], &["--steps", "10"]);
    let mut read: Vec<f64> = run().iter().map(|l| l.sensor("/eye", "proximity.distance")).collect();
    let again: Vec<f64> = run().iter().map(|l| l.sensor("/eye", "proximity.distance")).collect();
    assert_eq!(read, again, "two runs with the same seed differ");
    // The reading is that of the nearest of 200 rays. All are within 10 degrees, and at least one is within 3 degrees,
    // except with a probability of 0.91^200.
    assert!(read.iter().all(|d| *d >= 1.0 - 1e-9 && *d <= 1.0 / 3_f64.to_radians().cos()), "{read:?}");
    read.dedup();
    assert_eq!(read.len(), 10, "each measurement must use new rays");
    // The plate covers half of the cone, so about 100 rays hit it, with a standard deviation of 7.
    let half = cuboid("half", [3.0, 3.0, 0.02], [1.5, 0.0, 1.01], "");
    let seen =
        |needed: u32| self::read(&format!("{}{half}", eye(&format!("{keys}\nsamples_needed = {needed}")))).is_some();
    assert!(seen(1) && seen(60) && !seen(140));
}

#[test]
fn undetected_surfaces_occlude_only_on_request() {
    // With back faces only, the far side of a box would be detected, but its near side hides it.
    let block = cuboid("block", [1.0, 1.0, 0.1], [0.0, 0.0, 0.55], "");
    let keys = "volume = \"cone\"\nangle_deg = 30.0\nrange_m = 2.0\nfront_faces = false";
    expect(keys, &block, Some(0.6));
    expect(&format!("{keys}\nocclusion = true"), &block, None);
    // A plate that is tilted by 60 degrees is too slanted to be detected, but hides the plate above it.
    let leaning = cuboid("leaning", [0.02, 2.0, 0.8], [0.0, 0.0, 0.6], "orientation_deg = [0.0, 30.0, 0.0]");
    let keys = "volume = \"cone\"\nangle_deg = 10.0\nrange_m = 3.0\nmax_incidence_deg = 45.0";
    expect(keys, &format!("{leaning}{}", plate(1.5)), Some(1.5));
    expect(&format!("{keys}\nocclusion = true"), &format!("{leaning}{}", plate(1.5)), None);
    expect(&format!("{keys}\nocclusion = true"), &plate(1.5), Some(1.5));
}

#[test]
fn noise_of_the_distance_moves_the_point() {
    let keys = "volume = \"cone\"\nrange_m = 2.0\nnoise = { distance = { sigma = 0.1 } }";
    let scene = format!("{}{}", eye(keys), ball([0.1, 0.1, 0.9], 0.05));
    let lines = TestFolder::scene(&scene).trace(&["/eye"], &["--steps", "20"]);
    let exact = (0.1_f64 * 0.1 * 2.0 + 0.81).sqrt() - 0.05;
    let mut most = 0.0_f64;
    for line in &lines {
        let distance = line.sensor("/eye", "proximity.distance");
        let p = numbers(&line.0["readings"]["/eye"]["proximity.point"]);
        assert!((p.iter().map(|x| x * x).sum::<f64>().sqrt() - distance).abs() < 1e-9);
        assert!((p[0] / p[2] - 0.1 / 0.9).abs() < 1e-9 && p[2] > 0.0, "not on the line of sight: {p:?}");
        most = most.max((distance - exact).abs());
    }
    assert!(most > 0.05, "the points have no noise");
}

#[test]
fn scripts_look_with_limits_of_their_own() {
    // A block from 0.5 m to 0.6 m, and a plate above it.
    let things = format!("{}{}", cuboid("block", [1.0, 1.0, 0.1], [0.0, 0.0, 0.55], ""), plate(1.5));
    let script = "function sysCall_init()
        local eye, block, plate = sim.getObject('/eye'), sim.getObject('/block'), sim.getObject('/plate')
        local function look(what, mode, most, angle)
            local seen, distance = sim.checkProximitySensorEx(eye, what, mode, most, angle)
            return seen == 1 and string.format('%.3f', distance) or 'nothing'
        end
        local told = {
            look(sim.handle_all, 1, 0, 0), look(sim.handle_all, 2, 0, 0), look(sim.handle_all, 2 + 16, 0, 0),
            look(sim.handle_all, 3, 0.4, 0), look(sim.handle_all, 3, 9, 0), look(plate, 3, 0, 0), look(plate, 3, 1, 0),
            look(plate, 3 + 8, 0, 0.2), look(block, 3, 0.6, 0),
        }
        sim.addStatusbarMessage(table.concat(told, ' '))
        -- Without limits of a script the sensor's own apply again.
        sim.addStatusbarMessage(string.format('%.3f', select(2, sim.handleProximitySensor(eye))))
        -- 16: detectable by ultrasonic sensors, 64: by lasers.
        sim.setObjectSpecialProperty(block, 64)
        assert(sim.getObjectSpecialProperty(block) & 0x1F0 == 64)
        sim.addStatusbarMessage(string.format('%.3f', select(2, sim.handleProximitySensor(eye))))
        sim.setObjectSpecialProperty(block, 64 + 16)
        sim.addStatusbarMessage(string.format('%.3f', select(2, sim.handleProximitySensor(eye))))
        assert(not pcall(sim.checkProximitySensorEx, eye, sim.handle_all, 4, 0, 0), 'no faces')
    end";
    let keys = "volume = \"cone\"\nangle_deg = 20.0\nrange_m = 2.0\nwaves = \"ultrasonic\"";
    let script = watcher("script", script).replace("{ text", "{ language = \"lua\", text");
    let place = TestFolder::scene(&format!("{}{things}{script}", eye(keys)));
    let lines = place.trace(&[], &["--steps", "1"]);
    let told: Vec<&str> = lines.iter().flat_map(|l| l.status()).collect();
    // The far side of the plate is 1.52 m away. The far side of the block is at 0.6 m and is hidden by its front, even
    // with back faces only.
    let wanted = ["0.500 0.600 nothing nothing 0.500 1.500 nothing 1.500 0.500", "0.500", "1.500", "0.500"];
    assert_eq!(told, wanted);
}

#[test]
fn a_threshold_of_a_script_does_not_bend_a_pyramid() {
    // Half the width of the pyramid is half its height, so it reaches a wall at x = 0.3 at z = 0.6, 0.671 m away.
    let keys = "volume = \"pyramid\"\nrange_m = 2.0\nsize_near_m = [0.0, 0.0]\nsize_far_m = [2.0, 2.0]";
    let script = "function sysCall_init()
        local eye = sim.getObject('/eye')
        for _, most in ipairs({ 0.0, 0.68, 0.66 }) do
            local seen, distance = sim.checkProximitySensorEx(eye, sim.handle_all, 3, most, 0)
            sim.addStatusbarMessage(seen == 1 and string.format('%.3f', distance) or 'nothing')
        end
    end";
    let script = watcher("script", script).replace("{ text", "{ language = \"lua\", text");
    let place = TestFolder::scene(&format!("{}{}{script}", eye(keys), wall_x(0.3)));
    let lines = place.trace(&[], &["--steps", "1"]);
    let told: Vec<&str> = lines.iter().flat_map(|l| l.status()).collect();
    assert_eq!(told, ["0.671", "0.671", "nothing"]);
}
