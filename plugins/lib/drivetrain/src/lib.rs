//! Kinematics of wheeled robots: converts a velocity of the robot to velocities of its joints, and the motion of the
//! joints to the motion of the robot. The property `object.drive` declares the wheels, which are assumed not to slip.
//!
//! Velocities refer to the centre of the driven axle: forward and to the left in m/s, counter-clockwise in rad/s.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

use nalgebra::{Matrix3, Vector3};
use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Fail, Prop, Result, ValueRef, World},
};

/// Maximum steering angle, rad. It is less than 90 degrees because a steered robot cannot turn on the spot.
const MAX_STEERING_ANGLE_RAD: f64 = 85.0 * std::f64::consts::PI / 180.0;

/// A driven or steering joint, and the factor, 1 or -1, that makes forward rotation or steering to the left positive.
#[derive(Debug, Clone, Copy, PartialEq)]
struct WheelJoint {
    joint: tatu_object,
    sign: f64,
}

/// The type of a drive, which determines how the motion of its joints is related to the motion of the robot.
#[derive(Debug, Clone, PartialEq)]
enum DriveType {
    Differential,
    Ackermann {
        wheelbase: f64,
    },
    /// For each wheel, the distance that its rim moves per metre of forward motion, per metre to the left, and per
    /// radian about the centre.
    Omni(Vec<[f64; 3]>),
}

/// The drive of a robot: its type, its joints and its dimensions.
#[derive(Debug, Clone, PartialEq)]
pub struct Drivetrain {
    form: DriveType,
    driven: Vec<WheelJoint>,
    steering: Vec<WheelJoint>,
    /// Radius of the wheels, m.
    pub radius: f64,
    /// Distance between the left and right wheels, m.
    pub track: f64,
    /// Distance of the driven axle in front of the base's origin, m.
    pub axle: f64,
}

/// The state of the joints at one instant. Forward rotation and steering to the left are positive.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WheelState {
    /// Positions of the driven joints, rad; those of joints without limits wrap around after a full turn.
    pub driven: Vec<f64>,
    /// Velocities of the driven joints, rad/s.
    pub speeds: Vec<f64>,
    /// Positions of the steering joints, rad.
    pub steered: Vec<f64>,
}

impl WheelState {
    /// Returns the rotation of the driven joints since `before`, `dt` seconds earlier, including whole turns, rad.
    pub fn turns_since(&self, before: &WheelState, dt: f64) -> Vec<f64> {
        use std::f64::consts::TAU;
        let speeds = self.speeds.iter().zip(&before.speeds).map(|(a, b)| (a + b) / 2.0);
        let ways = self.driven.iter().zip(&before.driven).map(|(now, then)| now - then);
        // Add the number of whole turns that the mean velocity implies.
        ways.zip(speeds).map(|(way, speed)| way + TAU * ((speed * dt - way) / TAU).round()).collect()
    }
}

/// Interned keys of the properties that a drivetrain reads and writes.
#[derive(Debug, Clone, Copy)]
pub struct Props {
    /// `object.drive`
    pub drive: Prop,
    /// `joint.position`
    pub position: Prop,
    /// `joint.velocity`
    pub velocity: Prop,
    /// `joint.target_velocity`
    pub target_velocity: Prop,
    /// `joint.target_position`
    pub target_position: Prop,
}

impl Props {
    /// Interns the keys.
    pub fn new(host: &tatu_plugin_api::safe::Host) -> Self {
        Props {
            drive: host.prop("object.drive"),
            position: host.prop("joint.position"),
            velocity: host.prop("joint.velocity"),
            target_velocity: host.prop("joint.target_velocity"),
            target_position: host.prop("joint.target_position"),
        }
    }
}

impl Drivetrain {
    /// Returns the drivetrain that a robot's base declares, or `None` if it declares none. Returns an error if a
    /// declared joint does not exist.
    pub fn of(world: &World<'_>, p: &Props, base: tatu_object) -> Result<Option<Self>> {
        let told = world.get(base, p.drive)?;
        if told.is_empty() {
            return Ok(None);
        }
        let number = |key: &str| told.get(key).and_then(|v| v.as_f64()).unwrap_or(0.0);
        let wheels = |key: &str| -> Result<Vec<WheelJoint>> {
            let list = told.get(key).and_then(|v| v.list()).unwrap_or_default();
            list.iter().map(|path| wheel(world, base, *path)).collect()
        };
        let (driven, steering) = (wheels("joints")?, wheels("steering")?);
        let (radius, track, wheelbase) = (number("radius"), number("track"), number("wheelbase"));
        let angles = told.get("angles").and_then(|v| v.numbers()).unwrap_or_default();
        let form = match told.get("type").and_then(|v| v.as_str()).as_deref() {
            Some("differential") => DriveType::Differential,
            Some("ackermann") => DriveType::Ackermann { wheelbase },
            _ => DriveType::Omni(omni_coefficients(track, wheelbase, &angles)),
        };
        Ok(Some(Drivetrain { form, driven, steering, radius, track, axle: number("axle") }))
    }

    /// Sets the targets of the joints for a velocity, as closely as the drive permits: differential and steered drives
    /// cannot move sideways, and a steered drive cannot turn on the spot.
    pub fn drive(&self, world: &World<'_>, p: &Props, twist: [f64; 3]) -> Result {
        let angles = self.angles(twist);
        for (wheel, angle) in self.steering.iter().zip(&angles) {
            world.set_f64s(wheel.joint, p.target_position, &[wheel.sign * angle])?;
        }
        for (wheel, speed) in self.driven.iter().zip(self.speeds(twist)) {
            world.set_f64s(wheel.joint, p.target_velocity, &[wheel.sign * speed])?;
        }
        Ok(())
    }

    /// Reads the current state of the joints.
    pub fn read(&self, world: &World<'_>, p: &Props) -> Result<WheelState> {
        let all = |wheels: &[WheelJoint], prop| -> Result<Vec<f64>> {
            wheels.iter().map(|w| Ok(w.sign * world.f64(w.joint, prop)?)).collect()
        };
        Ok(WheelState {
            driven: all(&self.driven, p.position)?,
            speeds: all(&self.driven, p.velocity)?,
            steered: all(&self.steering, p.position)?,
        })
    }

    /// Returns the motion of the robot for a rotation of its driven joints and for steering angles, rad. If the
    /// rotation is in rad, the motion is a displacement in m and rad; if it is in rad/s, the motion is a velocity.
    pub fn motion(&self, turns: &[f64], steered: &[f64]) -> [f64; 3] {
        let mean = |from: usize| {
            let some: Vec<f64> = turns.iter().skip(from).step_by(2).copied().collect();
            self.radius * some.iter().sum::<f64>() / some.len().max(1) as f64
        };
        let middle = self.radius * turns.iter().sum::<f64>() / turns.len().max(1) as f64;
        match &self.form {
            DriveType::Differential => [(mean(0) + mean(1)) / 2.0, 0.0, (mean(1) - mean(0)) / self.track],
            DriveType::Ackermann { wheelbase } => [middle, 0.0, middle * self.curvature(*wheelbase, steered)],
            DriveType::Omni(rows) => least_squares(rows, turns, self.radius),
        }
    }

    /// Returns the curvature of the path, 1/m; it is positive for a left turn.
    fn curvature(&self, wheelbase: f64, steered: &[f64]) -> f64 {
        let of = |(i, angle): (usize, &f64)| {
            let t = libm::tan(*angle);
            // The two wheels of a steered pair turn about the same centre, at different distances.
            let side = if steered.len() == 1 { 0.0 } else { self.side(i) };
            t / (wheelbase + side * t)
        };
        steered.iter().enumerate().map(of).sum::<f64>() / steered.len().max(1) as f64
    }

    /// Returns the lateral position of wheel `i`, m; left is positive. Left and right wheels alternate.
    fn side(&self, i: usize) -> f64 {
        if i.is_multiple_of(2) { self.track / 2.0 } else { -self.track / 2.0 }
    }

    fn speeds(&self, [vx, vy, wz]: [f64; 3]) -> Vec<f64> {
        let of = |i: usize| match &self.form {
            DriveType::Omni(rows) => {
                let [a, b, c] = rows.get(i).copied().unwrap_or_default();
                (a * vx + b * vy + c * wz) / self.radius
            }
            _ if self.driven.len() == 1 => vx / self.radius,
            _ => (vx - self.side(i) * wz) / self.radius,
        };
        (0..self.driven.len()).map(of).collect()
    }

    /// Returns the steering angles, rad. The wheels point straight ahead if the robot does not turn or does not move
    /// forward or backward.
    fn angles(&self, [vx, _, wz]: [f64; 3]) -> Vec<f64> {
        let DriveType::Ackermann { wheelbase } = self.form else { return Vec::new() };
        let of = |i: usize| {
            if wz == 0.0 || vx == 0.0 {
                return 0.0;
            }
            let side = if self.steering.len() == 1 { 0.0 } else { self.side(i) };
            // The axle of the wheel must point to the centre of the turn.
            let radius = vx / wz - side;
            libm::atan(wheelbase / radius).clamp(-MAX_STEERING_ANGLE_RAD, MAX_STEERING_ANGLE_RAD)
        };
        (0..self.steering.len()).map(of).collect()
    }
}

fn wheel(world: &World<'_>, base: tatu_object, path: ValueRef<'_>) -> Result<WheelJoint> {
    let text = path.as_str().unwrap_or_default();
    let (path, sign) = text.strip_prefix('-').map_or((&*text, 1.0), |path| (path, -1.0));
    let joint = world.find(base, path).map_err(|_| {
        Fail::missing(format!("the drive's joint `{path}` does not exist"))
            .help("the paths in `object.drive` are relative to the object with this property")
    })?;
    Ok(WheelJoint { joint, sign })
}

/// Returns the coefficients of `DriveType::Omni` for each wheel.
fn omni_coefficients(track: f64, wheelbase: f64, angles: &[f64]) -> Vec<[f64; 3]> {
    if angles.is_empty() {
        // Mecanum: rollers at 45 degrees, in an X seen from above.
        let arm = (track + wheelbase) / 2.0;
        return [[1.0, -1.0, -arm], [1.0, 1.0, arm], [1.0, 1.0, -arm], [1.0, -1.0, arm]].to_vec();
    }
    angles.iter().map(|a| [-libm::sin(*a), libm::cos(*a), track / 2.0]).collect()
}

/// Returns the motion that best fits the rotation of all wheels, by solving the normal equations, or zero if the wheels
/// do not determine the motion.
fn least_squares(rows: &[[f64; 3]], turns: &[f64], radius: f64) -> [f64; 3] {
    let (mut squares, mut way) = (Matrix3::zeros(), Vector3::zeros());
    for (row, turn) in rows.iter().zip(turns) {
        let row = Vector3::from(*row);
        squares += row * row.transpose();
        way += row * (turn * radius);
    }
    squares.cholesky().map_or([0.0; 3], |c| c.solve(&way).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn train(form: DriveType, driven: usize, steering: usize) -> Drivetrain {
        let wheels = |n| vec![WheelJoint { joint: 0, sign: 1.0 }; n];
        Drivetrain { form, driven: wheels(driven), steering: wheels(steering), radius: 0.1, track: 0.4, axle: 0.0 }
    }

    fn assert_round_trip(train: &Drivetrain, twist: [f64; 3]) {
        let back = train.motion(&train.speeds(twist), &train.angles(twist));
        for (a, b) in back.iter().zip(twist) {
            assert!((a - b).abs() < 1e-12, "{train:?}: {twist:?} came back as {back:?}");
        }
    }

    #[test]
    fn velocity_round_trips_through_wheel_speeds() {
        for n in [2, 4] {
            assert_round_trip(&train(DriveType::Differential, n, 0), [0.5, 0.0, -0.7]);
            assert_round_trip(&train(DriveType::Ackermann { wheelbase: 0.6 }, n, 2), [0.5, 0.0, 0.3]);
        }
        assert_round_trip(&train(DriveType::Ackermann { wheelbase: 0.6 }, 1, 1), [-0.5, 0.0, 0.3]);
        assert_round_trip(&train(DriveType::Omni(omni_coefficients(0.4, 0.5, &[])), 4, 0), [0.5, -0.3, 0.7]);
        let third = std::f64::consts::TAU / 3.0;
        assert_round_trip(
            &train(DriveType::Omni(omni_coefficients(0.4, 0.0, &[0.1, third, 2.0 * third])), 3, 0),
            [0.5, -0.3, 0.7],
        );
    }

    #[test]
    fn whole_turns_are_counted() {
        let stand = |at: f64| WheelState { driven: vec![at], speeds: vec![100.0], steered: vec![] };
        // The joint rotates from 3 rad to 8 rad, but its position wraps around at a whole turn.
        let turns = stand(8.0 - std::f64::consts::TAU).turns_since(&stand(3.0), 0.05);
        assert!((turns[0] - 5.0).abs() < 1e-12, "{turns:?}");
    }

    #[test]
    fn wheel_speeds_depend_on_wheel_positions() {
        // The outer wheel moves at twice the speed; the inner one does not turn.
        let speeds = train(DriveType::Differential, 2, 0).speeds([0.2, 0.0, 1.0]);
        assert!((speeds[0]).abs() < 1e-12 && (speeds[1] - 4.0).abs() < 1e-12, "{speeds:?}");
        // When a mecanum robot moves to the left, the front left and rear right wheels turn backwards.
        let speeds = train(DriveType::Omni(omni_coefficients(0.4, 0.5, &[])), 4, 0).speeds([0.0, 1.0, 0.0]);
        assert_eq!(speeds, [-10.0, 10.0, 10.0, -10.0]);
        // In a left turn, the steering angle of the left wheel is greater.
        let angles = train(DriveType::Ackermann { wheelbase: 0.6 }, 2, 2).angles([1.0, 0.0, 0.5]);
        assert!(angles[0] > angles[1] && angles[1] > 0.0, "{angles:?}");
        assert_eq!(train(DriveType::Ackermann { wheelbase: 0.6 }, 2, 2).angles([0.0, 0.0, 0.5]), [0.0, 0.0]);
    }
}
