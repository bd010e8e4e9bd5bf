//! Numbers and rotations as text.

use nalgebra::UnitQuaternion;

/// Magnitudes below this one are written with an exponent.
const LEAST_PLAIN: f64 = 1e-5;
/// Magnitudes from this one on are written with an exponent.
const MAX_PLAIN: f64 = 1e15;

/// Returns the shortest text that is read back as the same number. A zero has no sign.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".to_owned()
    } else if size.is_finite() && !(LEAST_PLAIN..MAX_PLAIN).contains(&size) {
        format!("{x:e}")
    } else {
        format!("{x}")
    }
}

/// Returns numbers separated by spaces.
pub fn numbers(all: impl IntoIterator<Item = f64>) -> String {
    let all: Vec<String> = all.into_iter().map(number).collect();
    all.join(" ")
}

/// Returns the angles of rotations about the fixed axes x, y, z, in this order, that together are this rotation. The
/// result is precise for every pitch: roll is what is left when yaw has been undone.
pub fn roll_pitch_yaw(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let m = rotation.to_rotation_matrix();
    let m = m.matrix();
    let level = libm::hypot(m[(0, 0)], m[(1, 0)]);
    let pitch = libm::atan2(-m[(2, 0)], level);
    // At a pitch of a quarter turn, roll and yaw turn about the same axis, and yaw is chosen as 0.
    let yaw = if level < 1e-12 { 0.0 } else { libm::atan2(m[(1, 0)], m[(0, 0)]) };
    let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
    let roll = libm::atan2(sin * m[(0, 2)] - cos * m[(1, 2)], cos * m[(1, 1)] - sin * m[(0, 1)]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_a_number_is_read_back_exactly() {
        for x in [0.1, 1.0 / 3.0, 1e-9, -2.5e300, 5e-324, 123456.0, 1e15, -0.00012] {
            assert_eq!(number(x).parse::<f64>().unwrap(), x, "{}", number(x));
        }
        assert_eq!(numbers([0.5, -0.0, 1e-7, 20.0]), "0.5 0 1e-7 20");
    }

    #[test]
    fn angles_return_the_rotation_even_at_a_quarter_turn_of_pitch() {
        let quarter = std::f64::consts::FRAC_PI_2;
        for pitch in [0.0, 0.3, -1.2, quarter, -quarter, quarter - 1e-8, quarter - 1e-13] {
            for (roll, yaw) in [(0.0, 0.0), (0.4, -2.9), (-3.1, 1.0)] {
                let wanted = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
                let [r, p, y] = roll_pitch_yaw(&wanted);
                let error = wanted.angle_to(&UnitQuaternion::from_euler_angles(r, p, y));
                assert!(error < 1e-12, "{roll} {pitch} {yaw}: {error}");
            }
        }
    }
}
