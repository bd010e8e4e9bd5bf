//! What the car measures and weighs, with the source of each number. m, kg, kg m^2, rad, N m.
//!
//! Sources: **S** constants in public copies of V-REP's script of this model, **estimate** chosen here, with the reason.

/// Radius of the wheels. S
pub const RADIUS: f64 = 0.09;
/// Width of the wheels. Estimate: of a model car of this size.
pub const WIDTH: f64 = 0.06;
/// From the rear axle to the front axle. S
pub const WHEELBASE: f64 = 0.6;
/// Between the middles of the wheels of an axle. S
pub const TRACK: f64 = 0.35;

/// How far the steering goes to either side, 30 degrees. S
pub const STEER_LIMIT: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// How fast it goes there, 70 degrees a second. S
pub const STEER_SPEED: f64 = 70.0 * std::f64::consts::PI / 180.0;
/// Greatest torque of the steering. Estimate: turns the wheels of the standing car.
pub const STEER_TORQUE: f64 = 20.0;

/// Greatest torque of the motor. S
pub const MOTOR_TORQUE: f64 = 60.0;
/// Speed that a rear wheel gives up for each N m, rad/s. It lets the wheels differ in a bend, as a differential does: at
/// the tightest radius they want 17 % more and less than the motor's speed, which at 10 rad/s takes 0.9 N m each, a third
/// of what their tyres hold. Estimate.
pub const SLIP: f64 = 2.0;

/// Of the body with all that sits in it. Estimate: a model car with batteries.
pub const BODY_MASS: f64 = 10.0;
/// An even block of 0.8 x 0.3 x 0.12 m: m / 12 times the squares of the two other sides.
pub const BODY_INERTIA: [f64; 3] = [0.087, 0.545, 0.608];
/// Middle of the wheelbase, a little above the axles. Estimate.
pub const BODY_COM: [f64; 3] = [WHEELBASE / 2.0, 0.0, 0.03];
/// Of a wheel. Estimate.
pub const WHEEL_MASS: f64 = 0.8;
/// An even disc about its axis z: m r^2 / 2, and m (3 r^2 + w^2) / 12 across.
pub const WHEEL_INERTIA: [f64; 3] = [0.00186, 0.00186, 0.00324];
/// Of what moves between joints: knuckles, steering column, motor shaft. Estimate.
pub const LINK_MASS: f64 = 0.4;
/// About each axis; larger than a small part's own, so that joints of such different bodies stay stiff. Estimate.
pub const LINK_INERTIA: [f64; 3] = [0.001, 0.001, 0.001];

/// Angle of a front wheel, `y` to the left of the middle, for an angle of the steering: all four wheels turn about one
/// point on the line of the rear axle, `WHEELBASE / tan(steering)` to the left.
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
                // The wheel's axle, square to its heading, meets the line of the rear axle there.
                let angle = ackermann(steering, y);
                assert!((y + WHEELBASE / angle.tan() - centre).abs() < 1e-12, "{steering} {y}");
            }
        }
        assert_eq!(ackermann(0.0, 0.175), 0.0);
    }
}
