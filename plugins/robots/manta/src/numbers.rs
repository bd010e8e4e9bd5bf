//! Dimensions and masses of the car, with the source of each number. m, kg, kg m^2, rad, N m.
//!
//! Sources: **S**: constants in public copies of V-REP's script of this model; **estimate**: chosen here, with the
//! reason.

/// Radius of the wheels. S
pub const RADIUS: f64 = 0.09;
/// Width of the wheels. Estimate, for a model car of this size.
pub const WIDTH: f64 = 0.06;
/// Distance between rear and front axle. S
pub const WHEELBASE: f64 = 0.6;
/// Distance between the centres of the wheels of an axle. S
pub const TRACK: f64 = 0.35;

/// Greatest steering angle to either side, 30 degrees. S
pub const STEER_LIMIT: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// Greatest velocity of the steering, 70 degrees per second. S
pub const STEER_SPEED: f64 = 70.0 * std::f64::consts::PI / 180.0;
/// Greatest torque of the steering. Estimate: enough to turn the wheels while the car does not move.
pub const STEER_TORQUE: f64 = 20.0;

/// Greatest torque of the motor. S
pub const MOTOR_TORQUE: f64 = 60.0;
/// Reduction of a rear wheel's speed per N m, rad/s. Like a differential, it lets the wheels differ in a turn: at the
/// smallest radius their speeds are 17 % above and below the motor's, which at 10 rad/s takes 0.9 N m each, a third of
/// what their tyres can transmit. Estimate.
pub const SLIP: f64 = 2.0;

/// Mass of the body and everything inside. Estimate: a model car with batteries.
pub const BODY_MASS: f64 = 10.0;
/// Inertia of a uniform block of 0.8 x 0.3 x 0.12 m: m / 12 times the sum of squares of the two other sides.
pub const BODY_INERTIA: [f64; 3] = [0.087, 0.545, 0.608];
/// Centre of mass: the middle of the wheelbase, a little above the axles. Estimate.
pub const BODY_COM: [f64; 3] = [WHEELBASE / 2.0, 0.0, 0.03];
/// Mass of a wheel. Estimate.
pub const WHEEL_MASS: f64 = 0.8;
/// Inertia of a uniform disc about its axis z: m r^2 / 2, and m (3 r^2 + w^2) / 12 across.
pub const WHEEL_INERTIA: [f64; 3] = [0.00186, 0.00186, 0.00324];
/// Mass of parts between joints: knuckles, steering column, motor shaft. Estimate.
pub const LINK_MASS: f64 = 0.4;
/// Inertia of such a part about each axis. It is larger than that of a real part of this size, so that joints between
/// very different bodies stay stiff. Estimate.
pub const LINK_INERTIA: [f64; 3] = [0.001, 0.001, 0.001];

/// Returns the angle of a front wheel at `y` to the left of the middle, for a steering angle: all four wheels turn
/// about one point on the line of the rear axle, `WHEELBASE / tan(steering)` to the left.
pub fn ackermann(steering: f64, y: f64) -> f64 {
    let t = libm::tan(steering);
    libm::atan2(WHEELBASE * t, WHEELBASE - y * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn front_wheels_turn_about_one_point() {
        for steering in [0.1, 0.3, 0.5, -0.5] {
            let centre = WHEELBASE / libm::tan(steering);
            for y in [-TRACK / 2.0, TRACK / 2.0] {
                // The wheel's axle, perpendicular to its heading, must meet the line of the rear axle there.
                let angle = ackermann(steering, y);
                assert!((y + WHEELBASE / angle.tan() - centre).abs() < 1e-12, "{steering} {y}");
            }
        }
        assert_eq!(ackermann(0.0, 0.175), 0.0);
    }
}
