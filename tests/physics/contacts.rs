//! Tests of friction, rolling, sleeping bodies, and bodies that are fast and small (bullets).

use crate::{kit::*, scenes::*};

fn block(friction: f64) -> String {
    let more = format!("respondable = true\nfriction = {friction}\nposition_m = [0, 0, 0.1]");
    body("b", "", "box", [0.4, 0.4, 0.2], 1.0, &more)
}

#[test]
fn slips_at_the_angle_of_friction() {
    for friction in [0.3, 0.5, 0.8] {
        let angle = f64::atan(friction).to_degrees();
        let way = |degrees: f64, seconds: f64| {
            let lines = watch_run(&(slope(degrees) + &floor(1.0) + &block(friction)), &["/b"], seconds);
            position(&lines[lines.len() - 1], "/b")[0]
        };
        assert!(way(angle - 0.05, 3.0) < 0.005, "friction {friction}: the box slips below {angle} degrees");
        assert!(way(angle + 0.05, 3.0) > 0.005, "friction {friction}: the box does not slip above {angle} degrees");
        near("creep in 10 s, 2 degrees below", way(angle - 2.0, 10.0), 0.0, 1e-4);
    }
}

/// A sliding box has the acceleration g (sin a - mu cos a).
#[test]
fn slides() {
    let (friction, angle) = (0.5, 30.0f64);
    let lines = watch_run(&(slope(angle) + &floor(1.0) + &block(friction)), &["/b"], 3.0);
    let v = |i: usize| lines[i].object::<3>("/b", "linear_velocity")[0];
    let (a, b) = (20, lines.len() - 1);
    let is = (v(b) - v(a)) / (lines[b].time() - lines[a].time());
    let wanted = G * (angle.to_radians().sin() - friction * angle.to_radians().cos());
    near("sliding acceleration", is / wanted, 1.0, 1e-4);
}

/// A ball and a cylinder that roll without slip have accelerations of 5/7 and 2/3 of g sin a.
#[test]
fn rolls() {
    for (primitive, share, size) in [("sphere", 5.0 / 7.0, [0.4; 3]), ("cylinder", 2.0 / 3.0, [0.4, 0.4, 0.2])] {
        let more = "respondable = true\nposition_m = [0, 0, 0.2]\norientation_deg = [90, 0, 0]";
        let scene = slope(20.0) + &floor(1.0) + &body("b", "", primitive, size, 1.0, more);
        let lines = watch_run(&scene, &["/b"], 2.0);
        let wanted = 0.5 * share * G * 20f64.to_radians().sin() * 4.0;
        near(primitive, position(&lines[lines.len() - 1], "/b")[0] / wanted, 1.0, 1e-3);
    }
}

/// A rolling body on a horizontal floor keeps its speed.
#[test]
fn rolls_evenly() {
    let board = "[[object]]\nkind = \"shape\"\nalias = \"board\"\nprimitive = \"box\"\nsize_m = [4, 4, 0.2]\n\
                 position_m = [0, 0, -0.1]\nrespondable = true\n";
    for (primitive, size) in [("sphere", [0.06; 3]), ("cylinder", [0.06, 0.06, 0.15])] {
        for v in [0.02, 0.2] {
            let more = format!(
                "respondable = true\nposition_m = [0, 0, 0.03]\norientation_deg = [90, 0, 0]\n{}",
                starts([v, 0.0, 0.0], [0.0, v / 0.03, 0.0])
            );
            let lines = watch_run(&(String::from(board) + &body("b", "", primitive, size, 0.2, &more)), &["/b"], 6.0);
            near(primitive, speed(&lines[lines.len() - 1], "/b") / v, 1.0, 1e-3);
        }
    }
}

/// The reported velocity matches the motion: a ball that rolls on a horizontal floor has no vertical velocity.
#[test]
fn velocities_are_those_of_the_motion() {
    let more = format!("respondable = true\nposition_m = [0, 0, 0.05]\n{}", starts([1.0, 0.0, 0.0], [0.0, 20.0, 0.0]));
    let lines = watch_run(&(floor(1.0) + &body("b", "", "sphere", [0.1; 3], 1.0, &more)), &["/b"], 5.0);
    for line in &lines[10..] {
        near("vertical speed", line.object::<3>("/b", "linear_velocity")[2], 0.0, 1e-4);
        near("speed", line.object::<3>("/b", "linear_velocity")[0], 1.0, 5e-3);
    }
}

/// A body without contacts does not fall asleep, and a ball starts to roll even on a very gentle slope.
#[test]
fn slow_bodies_do_not_fall_asleep() {
    for v in [0.001, 0.004, 0.01] {
        let scene = String::from("gravity_m_s2 = [0, 0, 0]\n")
            + &body("b", "", "box", [0.1; 3], 1.0, &starts([v, 0.0, 0.0], [0.0; 3]));
        let lines = watch_run(&scene, &["/b"], 10.0);
        near("way", position(&lines[lines.len() - 1], "/b")[0], 10.0 * v, 1e-6);
    }
    let ball = "respondable = true\nposition_m = [0, 0, 0.05]";
    let lines = watch_run(&(slope(0.03) + &floor(1.0) + &body("b", "", "sphere", [0.1; 3], 1.0, ball)), &["/b"], 10.0);
    let wanted = 0.5 * 5.0 / 7.0 * G * 0.03f64.to_radians().sin() * 100.0;
    near("rolls down 0.03 degrees", position(&lines[lines.len() - 1], "/b")[0] / wanted, 1.0, 0.02);
}

/// A shape that starts asleep stays in the air until something touches it; then it falls like any other.
#[test]
fn shapes_that_start_asleep_stay_until_they_are_touched() {
    let shelf = |z: f64, more: &str| {
        body("b", "", "box", [0.2, 0.2, 0.1], 1.0, &format!("respondable = true\nposition_m = [0, 0, {z}]\n{more}"))
    };
    let alone = watch_run(&(floor(1.0) + &shelf(1.0, "asleep = true")), &["/b"], 2.0);
    assert_eq!(position(&alone[alone.len() - 1], "/b")[2], 1.0);
    for sleep in ["", "sleep = false\n"] {
        let ball = body("a", "", "sphere", [0.1; 3], 1.0, "respondable = true\nposition_m = [0, 0, 2]");
        let lines =
            watch_run(&(String::from(sleep) + &floor(1.0) + &shelf(1.0, "asleep = true") + &ball), &["/b"], 2.0);
        let height = |t: f64| position(lines.iter().find(|l| l.time() > t).unwrap(), "/b")[2];
        assert_eq!(height(0.3), 1.0, "the ball has not yet arrived");
        near("final height on the floor", height(1.9), 0.05, 5e-3);
    }
    let pushed = shelf(1.0, "asleep = true\ninitial_velocity_m_s = [0, 0, 0.1]");
    let lines = watch_run(&(floor(1.0) + &pushed), &["/b"], 2.0);
    near("a shape with a velocity is awake", position(&lines[lines.len() - 1], "/b")[2], 0.05, 5e-3);
}

#[test]
fn sleep_can_be_switched_off() {
    let resting = "respondable = true\nposition_m = [0, 0, 0.05]";
    let scene = |sleep: &str| String::from(sleep) + &floor(1.0) + &body("b", "", "box", [0.1; 3], 1.0, resting);
    let asleep = TestFolder::scene(&scene("")).run(&["--seconds", "5"]).good();
    let awake = TestFolder::scene(&scene("sleep = false\n")).run(&["--seconds", "5"]).good();
    // A body that is kept awake keeps settling, so the last bits of its state differ.
    assert_ne!(asleep.json()["hash"], awake.json()["hash"]);
}

/// A ball of 1 cm does not pass through a movable wall of 1 cm.
#[test]
fn bullets_do_not_tunnel() {
    for v in [5.0, 50.0] {
        let wall = "respondable = true\nposition_m = [1, 0, 0]";
        let ball = format!("respondable = true\nbullet = true\n{}", starts([v, 0.0, 0.0], [0.0; 3]));
        let scene = String::from("gravity_m_s2 = [0, 0, 0]\n")
            + &body("wall", "", "box", [0.01, 2.0, 2.0], 100.0, wall)
            + &body("b", "", "sphere", [0.01; 3], 0.01, &ball);
        let lines = watch_run(&scene, &["/b", "/wall"], 1.0);
        let ahead = |l: &TraceLine| position(l, "/b")[0] - position(l, "/wall")[0];
        let most = lines.iter().map(ahead).fold(f64::MIN, f64::max);
        assert!(most < 0.0, "at {v} m/s the ball is {most} m beyond the wall");
    }
}
