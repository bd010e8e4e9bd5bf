//! Tests of the geometry: composed frames, wheels touching the floor, the direction of the motors, closed meshes.

use super::{
    both, close,
    recorder::{Object, Record},
    vrep,
};

/// A pose: position, and quaternion x y z w.
#[derive(Clone, Copy)]
pub struct Frame([f64; 3], [f64; 4]);

impl Frame {
    fn turn([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let t = cross([x, y, z], v).map(|e| 2.0 * e);
        let u = cross([x, y, z], t);
        [v[0] + w * t[0] + u[0], v[1] + w * t[1] + u[1], v[2] + w * t[2] + u[2]]
    }
    pub fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        Self::turn(self.1, v)
    }
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let d = self.direction(p);
        std::array::from_fn(|i| self.0[i] + d[i])
    }
    fn then(&self, Frame(p, [bx, by, bz, bw]): Frame) -> Frame {
        let [x, y, z, w] = self.1;
        let q = [
            w * bx + x * bw + y * bz - z * by,
            w * by - x * bz + y * bw + z * bx,
            w * bz + x * by - y * bx + z * bw,
            w * bw - x * bx - y * by - z * bz,
        ];
        Frame(self.point(p), q)
    }
}

/// Returns the frame of an object relative to the world when all joints are at 0.
pub fn frame(robot: &Record, object: &Object) -> Frame {
    let array = |key: &str, default: &[f64]| {
        if object.properties.contains_key(key) { object.numbers(key) } else { default.to_vec() }
    };
    let position = array("object.position", &[0.0; 3]).try_into().unwrap();
    let quaternion = array("object.quaternion", &[0.0, 0.0, 0.0, 1.0]).try_into().unwrap();
    let local = Frame(position, quaternion);
    robot.parent(object).map_or(local, |p| frame(robot, p).then(local))
}

#[test]
fn all_wheels_touch_the_floor() {
    for robot in both() {
        for name in ["leftWheel", "rightWheel", "caster_wheel"] {
            let wheel = robot.get(&format!("Pioneer_p3dx_{name}"));
            let centre = frame(&robot, wheel).point([0.0; 3]);
            let bottom = centre[2] - wheel.numbers("shape.collide_size")[0] / 2.0;
            assert!(close(bottom, 0.0, 0.2e-3), "{name}: {bottom}");
            let axis = frame(&robot, wheel).direction([0.0, 0.0, 1.0]);
            assert!(close(axis[1].abs(), 1.0, 1e-9), "{name}: {axis:?}");
        }
    }
}

#[test]
fn a_positive_speed_of_both_motors_drives_ahead() {
    for robot in both() {
        for (side, sign) in [("left", 1.0), ("right", -1.0)] {
            let motor = frame(&robot, robot.get(&format!("Pioneer_p3dx_{side}Motor")));
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

/// Local poses, copied from the file's list of objects (w x y z, x y z), with the caster's link rotated as here.
#[test]
fn local_positions_are_the_files_within_a_millimetre() {
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
        let found = robot.get(alias).numbers("object.position");
        for i in 0..3 {
            assert!(close(found[i], expected[i], 1e-3), "{alias}: {found:?} {expected:?}");
        }
    }
    let [base] = [robot.get("Pioneer_p3dx").numbers("object.position")];
    assert!(close(base[2], 0.138793, 1e-3) && base[..2] == [0.0, 0.0]);
}

#[test]
fn the_caster_trails() {
    for robot in both() {
        let at = |alias: &str| frame(&robot, robot.get(alias)).point([0.0; 3]);
        let (swivel, wheel) = (at("Pioneer_p3dx_caster_freeJoint1"), at("Pioneer_p3dx_caster_wheel"));
        assert!(close(wheel[0] - swivel[0], -0.0222, 1e-9), "{swivel:?} {wheel:?}");
        assert!(close(wheel[1], 0.0, 1e-9));
    }
}

#[test]
fn meshes_are_closed_small_and_turned_outward() {
    for robot in both() {
        assert_eq!(robot.meshes.len(), 3);
        let triangles: usize = robot.meshes.iter().map(|m| m.1.len()).sum();
        assert!(triangles < 600, "{triangles}");
        for (points, triangles) in &robot.meshes {
            let mut edges = std::collections::BTreeMap::new();
            let mut volume = 0.0;
            for &[a, b, c] in triangles {
                for edge in [(a, b), (b, c), (c, a)] {
                    *edges.entry(edge).or_insert(0) += 1;
                }
                let [p, q, r] = [a, b, c].map(|i| points[i as usize]);
                volume += (p[0] * (q[1] * r[2] - q[2] * r[1])
                    + p[1] * (q[2] * r[0] - q[0] * r[2])
                    + p[2] * (q[0] * r[1] - q[1] * r[0]))
                    / 6.0;
            }
            for (&(a, b), &n) in &edges {
                assert_eq!((n, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
            }
            assert!(volume > 1e-3, "{volume}");
        }
    }
}

#[test]
fn collision_boxes_keep_clear_of_floor_and_wheels() {
    use tatu_plugin_api::safe::Value;
    for robot in both() {
        let base = robot.get("Pioneer_p3dx");
        let Value::List(parts) = &base.properties["shape.parts"] else { panic!() };
        let mut low = f64::INFINITY;
        for part in parts {
            let Value::Map(entries) = part else { panic!() };
            let get = |key: &str| {
                let found = entries.iter().find(|(k, _)| *k == Value::text(key)).unwrap();
                match &found.1 {
                    Value::Floats(x) => x.clone(),
                    other => panic!("{other:?}"),
                }
            };
            let (size, at) = (get("size"), get("position"));
            let z = at[2] + 0.1388 - size[2] / 2.0;
            low = low.min(z);
            // Below the deck the boxes must fit between the wheels, whose inner faces are 0.1405 from the middle.
            if z < 0.195 {
                assert!(size[1] / 2.0 < 0.1405 - 0.002, "{size:?}");
            }
        }
        assert!(close(low, 0.06, 1e-9), "{low}");
    }
}
