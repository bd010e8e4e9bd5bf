//! Angles.

/// Returns an angle wrapped to (-pi, pi], in radians.
pub fn wrap_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let wrapped = angle % TAU;
    match wrapped {
        w if w > PI => w - TAU,
        w if w <= -PI => w + TAU,
        w => w,
    }
}
