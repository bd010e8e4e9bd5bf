//! The nearest point of a flat disc in a cone, among candidates in the plane and on the rim.

use nalgebra::Vector3;

use super::{
    planar::{InteriorResult, NearestPoint, any_perpendicular, nearest_interior_point},
    sight::BeamCone,
};

/// Returns the nearest admissible point of a disc; `centre` is relative to the apex.
pub(super) fn disc(
    cone: &BeamCone,
    centre: &Vector3<f64>,
    normal: &Vector3<f64>,
    radius: f64,
) -> Option<(f64, Vector3<f64>)> {
    let inside = |p: &Vector3<f64>| (p - centre).norm_squared() <= radius * radius;
    let mut best = match nearest_interior_point(cone, normal.dot(centre), normal, inside) {
        InteriorResult::Nothing => return None,
        InteriorResult::Nearest(nearest) => return nearest.distance_and_point(),
        InteriorResult::Maybe(nearest) => nearest,
    };
    rim(cone, centre, normal, radius, &mut best);
    best.distance_and_point()
}

/// Updates `best` with the candidates on the rim: its nearest and farthest point, and its crossings with the cone and
/// with the near limit.
fn rim(cone: &BeamCone, centre: &Vector3<f64>, normal: &Vector3<f64>, radius: f64, best: &mut NearestPoint) {
    // Angles are measured from the nearest point of the rim, so |p|^2 = even + swing cos(angle) with swing <= 0.
    let flat = normal * normal.dot(centre) - centre;
    let first = flat.try_normalize(1e-300).unwrap_or_else(|| any_perpendicular(normal));
    let second = normal.cross(&first);
    let at = |angle: f64| centre + (first * libm::cos(angle) + second * libm::sin(angle)) * radius;
    let even = centre.norm_squared() + radius * radius;
    let swing = 2.0 * radius * centre.dot(&first);

    let closest = at(0.0);
    let least = closest.norm();
    if least > best.reach || least >= best.distance {
        return;
    }
    let farthest = centre - first * radius;
    for point in [closest, farthest] {
        if cone.contains(&point) {
            best.offer(point);
        }
    }

    // (axis . p)^2 = cos^2 |p|^2 is a quartic in the tangent of half the angle.
    let axis = &cone.sight.axis;
    let (a, b, c) = (axis.dot(centre), radius * axis.dot(&first), radius * axis.dot(&second));
    let k2 = cone.cos * cone.cos;
    let quartic = [
        (a + b) * (a + b) - k2 * (even + swing),
        4.0 * (a + b) * c,
        2.0 * (a * a - b * b) + 4.0 * c * c - k2 * 2.0 * even,
        4.0 * (a - b) * c,
        (a - b) * (a - b) - k2 * (even - swing),
    ];
    let mut offer = |angle: f64| {
        // One Newton step on the unsquared equation, since squaring loses precision.
        let point = at(angle);
        let tangent = (second * libm::cos(angle) - first * libm::sin(angle)) * radius;
        let split = |p: &Vector3<f64>| (axis.dot(p), (p - axis * axis.dot(p)).norm());
        let excess = |p: &Vector3<f64>| cone.excess(split(p).0, split(p).1);
        let (height, width) = split(&point);
        // The mirror image of the cone also satisfies the squared equation.
        if height * cone.cos < 0.0 && cone.cos.abs() > 1e-12 {
            return;
        }
        let rise = axis.dot(&tangent);
        let across = point - axis * height;
        let slope = cone.sin * rise - cone.cos * across.dot(&(tangent - axis * rise)) / width;
        let better = at(angle - excess(&point) / slope);
        let point = if excess(&better).abs() < excess(&point).abs() { better } else { point };
        best.offer(point);
    };
    let mut reversed = quartic;
    reversed.reverse();
    roots(&quartic, |t| offer(2.0 * libm::atan(t)));
    roots(&reversed, |t| offer(2.0 * libm::atan2(1.0_f64, t)));

    // Points on the near limit: |p| = near.
    let cos = (best.near * best.near - even) / swing;
    if cos.abs() <= 1.0 {
        for angle in [libm::acos(cos), -libm::acos(cos)] {
            if cone.contains(&at(angle)) {
                best.offer_at(best.near, at(angle));
            }
        }
    }
}

/// Calls `found` for each argument in [-1, 1] where a quartic (lowest power first) changes sign.
///
/// A polynomial is monotone between neighbouring stationary points, which are found as the sign changes of its
/// derivative, recursively.
fn roots(quartic: &[f64; 5], mut found: impl FnMut(f64)) {
    // Derivatives, from the quartic down to the linear polynomial.
    let mut levels = [*quartic; 4];
    for i in 1..4 {
        for power in 0..5 {
            let next = if power < 4 { levels[i - 1][power + 1] } else { 0.0 };
            levels[i][power] = next * (power + 1) as f64;
        }
    }
    let value = |level: usize, t: f64| levels[level].iter().rev().fold(0.0, |sum, c| sum * t + c);

    let mut stops = [-1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    let mut count = 2;
    for level in (0..4).rev() {
        let mut next = [-1.0; 6];
        let mut next_count = 1;
        for pair in stops[..count].windows(2) {
            if let Some(t) = bisect(pair[0], pair[1], |t| value(level, t)) {
                next[next_count] = t;
                next_count += 1;
            }
        }
        if level == 0 {
            next[1..next_count].iter().for_each(|&t| found(t));
            return;
        }
        next[next_count] = 1.0;
        (stops, count) = (next, next_count + 1);
    }
}

/// Finds the sign change of a function that is monotone on an interval, by false position with halved weights.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut f_low, mut f_high) = (f(low), f(high));
    let change = f_low * f_high <= 0.0 && (f_low != 0.0 || f_high != 0.0);
    if !change {
        return None;
    }
    for round in 0..200 {
        if high - low < 1e-15 {
            break;
        }
        // Every third round bisects, so that the search also converges where the function is nearly flat.
        let t = if round % 3 == 2 { 0.5 * (low + high) } else { (low * f_high - high * f_low) / (f_high - f_low) };
        if !(t > low && t < high) {
            break;
        }
        let f_t = f(t);
        if f_t == 0.0 {
            return Some(t);
        }
        if (f_t > 0.0) == (f_high > 0.0) {
            (high, f_high) = (t, f_t);
            f_low *= 0.5;
        } else {
            (low, f_low) = (t, f_t);
            f_high *= 0.5;
        }
    }
    Some(if f_low.abs() < f_high.abs() { low } else { high })
}
