//! Tests of the Manta's driving against closed forms. Wheels with a radius of 0.09 m at 10 rad/s move it at 0.9 m/s.
//! With a wheelbase of 0.6 m, the middle of the rear axle, which is the origin of the base, moves on a circle with a
//! radius of 0.6 / tan(steering).

use crate::kit::*;

const CAR: &str = "/Manta";

fn car(script: &str) -> String {
    format!("{FLOOR}[[model]]\nmodel = \"manta\"\nscript = {{ text = '''\n{script}\n''' }}\n")
}

/// Returns the trace of a car with constant steering angle and speed.
fn drive(speed: f64, steering: f64, seconds: &str) -> Vec<TraceLine> {
    let script = format!(
        "function sysCall_init()
            sim.setJointTargetPosition(sim.getObject('./steer_joint'), {steering})
            sim.setJointTargetVelocity(sim.getObject('./motor_joint'), {speed})
        end"
    );
    TestFolder::scene(&car(&script)).trace(&[CAR, "/steer_joint"], &["--seconds", seconds])
}

/// Returns the signed radius of the circle through three points of the plane; positive if the centre is on the left.
pub fn radius(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    let side = |p: [f64; 3], q: [f64; 3]| f64::hypot(p[0] - q[0], p[1] - q[1]);
    let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    side(a, b) * side(b, c) * side(c, a) / (2.0 * cross)
}

#[test]
fn ten_radians_a_second_are_nine_tenths_of_a_metre() {
    for speed in [10.0, 4.0, -2.0] {
        let lines = drive(speed, 0.0, "6");
        let x = |i: usize| lines[i].object::<3>(CAR, "position")[0];
        let v = (x(119) - x(39)) / 4.0;
        println!("{speed} rad/s: {v:.4} m/s");
        assert!((v / (0.09 * speed) - 1.0).abs() < 0.01, "{speed} rad/s: {v} m/s");
        let y = lines[119].object::<3>(CAR, "position")[1];
        assert!(y.abs() < 0.02, "{y} m to the side");
    }
}

#[test]
fn it_turns_about_a_point_on_the_line_of_its_rear_axle() {
    for (speed, steering) in [(10.0, 0.5), (10.0, -0.5), (5.0, 0.3), (3.0, 0.1)] {
        let lines = drive(speed, steering, "12");
        let at = |i: usize| lines[i].object(CAR, "position");
        let r = radius(at(80), at(140), at(200));
        let want = 0.6 / f64::tan(steering);
        println!("{speed} rad/s, {steering} rad: {r:.4} m, wanted {want:.4}");
        assert!((r / want - 1.0).abs() < 0.03, "{speed} rad/s, {steering} rad: {r} m");
    }
}

#[test]
fn the_steering_has_its_speed_and_its_limit() {
    let script = "
        function sysCall_init()
            steer = sim.getObject('./steer_joint')
            sim.setJointTargetPosition(steer, 1.0)
        end
        function sysCall_sensing()
            local angles = {}
            for i, name in ipairs{'steer_joint', 'fl_steer_joint', 'fr_steer_joint'} do
                angles[i] = string.format('%.5f', sim.getJointPosition(sim.getObject('/' .. name)))
            end
            sim.addStatusbarMessage(table.concat(angles, ' '))
        end";
    let lines = TestFolder::scene(&car(script)).trace(&[], &["--seconds", "2"]);
    let angles = |i: usize| -> Vec<f64> {
        lines[i].status()[0].split(' ').map(|a| a.parse::<f64>().unwrap().to_degrees()).collect()
    };
    // 70 degrees per second: 14 degrees in the first four steps, slightly less since it starts from rest.
    assert!((11.0..=14.1).contains(&angles(3)[0]), "{:?}", angles(3));
    let end = angles(39);
    assert!((end[0] - 30.0).abs() < 0.3, "{end:?}");
    // Ackermann steering: tan(angle) is 0.6 tan 30 / (0.6 -+ 0.175 tan 30), for the inner wheel first.
    for (angle, y) in [(end[1], 0.175), (end[2], -0.175)] {
        let t = end[0].to_radians().tan();
        let want = f64::atan2(0.6 * t, 0.6 - y * t).to_degrees();
        assert!((angle - want).abs() < 0.2, "{angle} instead of {want} degrees");
    }
}

#[test]
fn a_follower_without_a_leader_is_reported() {
    let joint = "[[object]]\nkind = \"joint\"\nalias = \"j\"\nfollows = \"/nobody\"\n";
    TestFolder::scene(joint).run(&["--steps", "1"]).good().reports(&["/j", "/nobody"]);
    let odd = "[[object]]\nkind = \"joint\"\nalias = \"j\"\nfollow_curve = [1.0, 2.0, 3.0]\n";
    assert_eq!(TestFolder::scene(odd).run(&["--steps", "1"]).code, 2, "an odd number of values must be refused");
}

#[test]
fn gears_and_cams_follow_without_physics_too() {
    let joints = "
        [[object]]\nkind = \"joint\"\nalias = \"crank\"\nmode = \"kinematic\"
        [[object]]\nkind = \"joint\"\nalias = \"gear\"\nmode = \"kinematic\"\nfollows = \"/crank\"\nfollow_factor = -2.0\nfollow_offset_rad = 0.1
        [[object]]\nkind = \"joint\"\ntype = \"prismatic\"\nalias = \"lifter\"\nmode = \"kinematic\"\nfollows = \"/crank\"
        follow_curve = [0.0, 0.0, 1.0, 0.02, 2.0, 0.0]\n";
    let script = "
        function sysCall_actuation() sim.setJointPosition(sim.getObject('/crank'), 0.5) end
        function sysCall_sensing()
            local function near(name, want)
                local is = sim.getJointPosition(sim.getObject(name))
                if math.abs(is - want) > 1e-6 then error(name .. ' at ' .. is) end
            end
            near('/gear', -0.9) near('/lifter', 0.01)
        end";
    TestFolder::scene(&format!("{joints}{}", watcher("hand", script))).run(&["--steps", "2"]).good();
}
