//! Tests of the Pioneer's geometry: wheels that touch the floor, the direction of the motors, closed meshes.

use super::{
    flat::is_closed,
    pioneer_model::{both, close, vrep},
};

#[test]
fn all_wheels_touch_the_floor() {
    for robot in both() {
        for name in ["leftWheel", "rightWheel", "caster_wheel"] {
            let wheel = robot.get(&format!("Pioneer_p3dx_{name}"));
            let centre = robot.frame(wheel).point([0.0; 3]);
            let bottom = centre[2] - wheel.numbers("collide_size_m")[0] / 2.0;
            assert!(close(bottom, 0.0, 0.2e-3), "{name}: {bottom}");
            let axis = robot.frame(wheel).direction([0.0, 0.0, 1.0]);
            assert!(close(axis[1].abs(), 1.0, 1e-9), "{name}: {axis:?}");
        }
    }
}

#[test]
fn a_positive_speed_of_both_motors_drives_ahead() {
    for robot in both() {
        for (side, sign) in [("left", 1.0), ("right", -1.0)] {
            let motor = robot.frame(robot.get(&format!("Pioneer_p3dx_{side}Motor")));
            // A wheel with angular velocity w moves its centre by w x (0, 0, r), r being the height of the centre above
            // the floor.
            let w = motor.direction([0.0, 0.0, 1.0]);
            let rolls = [w[1], -w[0], 0.0];
            assert!(close(rolls[0], 1.0, 1e-9) && close(rolls[1], 0.0, 1e-9), "{side}");
            let y = motor.point([0.0; 3])[1];
            assert!(close(y, sign * 0.1655, 1e-9), "{side}: {y}");
        }
    }
}

/// The rows contain positions relative to the parent, m, copied from the objects of V-REP's file. Those below the
/// caster are expressed in the frames of this model.
#[test]
fn local_positions_match_the_file_within_a_millimetre() {
    let rows = [
        ("Pioneer_p3dx_rightMotor", [0.044515, -0.165501, -0.041275]),
        ("Pioneer_p3dx_leftMotor", [0.04451, 0.165499, -0.041252]),
        ("Pioneer_p3dx_caster_freeJoint1", [-0.149027, -0.000001, -0.077842]),
        ("Pioneer_p3dx_caster_freeJoint2", [0.021243_f64.hypot(0.006445), 0.0, -0.031079]),
        ("Pioneer_p3dx_connection1", [0.044472, -0.000001, 0.098307]),
        ("Pioneer_p3dx_connection8", [-0.137394, -0.105001, 0.098307]),
        ("Pioneer_p3dx_connection11", [0.219472, -0.000001, -0.071093]),
    ];
    let robot = vrep();
    for (alias, expected) in rows {
        let found = robot.get(alias).numbers("position_m");
        for i in 0..3 {
            assert!(close(found[i], expected[i], 1e-3), "{alias}: {found:?} {expected:?}");
        }
    }
    let [base] = [robot.get("Pioneer_p3dx").numbers("position_m")];
    assert!(close(base[2], 0.138793, 1e-3) && base[..2] == [0.0, 0.0]);
}

#[test]
fn the_caster_trails() {
    for robot in both() {
        let at = |alias: &str| robot.frame(robot.get(alias)).point([0.0; 3]);
        let (swivel, wheel) = (at("Pioneer_p3dx_caster_freeJoint1"), at("Pioneer_p3dx_caster_wheel"));
        assert!(close(wheel[0] - swivel[0], -0.0222, 1e-9), "{swivel:?} {wheel:?}");
        assert!(close(wheel[1], 0.0, 1e-9));
    }
}

#[test]
fn meshes_are_closed_small_and_turned_outward() {
    for robot in both() {
        let meshes: Vec<_> = robot.objects.iter().filter(|o| o.has("mesh")).map(|o| robot.mesh(o)).collect();
        assert_eq!(meshes.len(), 3);
        let triangles: usize = meshes.iter().map(|m| m.1.len()).sum();
        assert!(triangles < 600, "{triangles}");
        meshes.iter().for_each(is_closed);
    }
}

#[test]
fn collision_boxes_are_clear_of_floor_and_wheels() {
    for robot in both() {
        let mut low = f64::INFINITY;
        for (size, at) in robot.get("Pioneer_p3dx").parts() {
            let z = at[2] + 0.1388 - size[2] / 2.0;
            low = low.min(z);
            // Below the deck the boxes must fit between the wheels, whose inner faces are 0.1405 m from the middle.
            if z < 0.195 {
                assert!(size[1] / 2.0 < 0.1405 - 0.002, "{size:?}");
            }
        }
        assert!(close(low, 0.06, 1e-9), "{low}");
    }
}
