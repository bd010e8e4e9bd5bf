//! The nearest point of a sphere, or of the hemisphere that caps a capsule, in a cone; in closed form.
//!
//! The points of a sphere at a distance `d` from the apex form a circle around the line to the centre, seen at an angle
//! `spread` from that line. Every limit of a beam is a condition on `d` alone: near, far, side and incidence directly,
//! and the cone as a range of `spread`. The admissible distances therefore form intervals, and the nearest one is the
//! smallest end of an interval that satisfies all conditions.

use nalgebra::Vector3;

use super::{planar::any_perpendicular, sight::BeamCone};

/// Tolerance for conditions that a candidate satisfies exactly, except for rounding.
const ROUNDING_TOLERANCE: f64 = 1e-12;

/// Returns the nearest admissible point of a sphere; `centre` is relative to the apex.
///
/// With `half`, only the hemisphere on that side of the centre is considered, without its rim, which belongs to the
/// adjoining part of the surface.
pub(super) fn sphere(
    cone: &BeamCone,
    centre: &Vector3<f64>,
    radius: f64,
    half: Option<&Vector3<f64>>,
) -> Option<(f64, Vector3<f64>)> {
    let view = SphereInCone::new(cone, centre, radius);
    let sight = &cone.sight;
    let (r, c) = (radius, sight.cos_incidence);
    let mut best: Option<(f64, Vector3<f64>)> = None;
    let mut offer = |d: f64, spread: f64| {
        if best.is_none_or(|(least, _)| d < least)
            && let Some(point) = view.point(d, spread, half)
        {
            best = Some((d, point));
        }
    };

    // The nearest and the farthest point.
    offer((view.away - r).abs(), if view.away >= r { 0.0 } else { std::f64::consts::PI });
    offer(view.away + r, 0.0);
    // Distances at which the circle enters the cone.
    for spread in [view.off_axis - cone.half_angle, view.off_axis + cone.half_angle] {
        if (0.0..=std::f64::consts::PI).contains(&spread) {
            let middle = view.away * libm::cos(spread);
            let root = (middle * middle - view.power).sqrt();
            offer(middle - root, spread);
            offer(middle + root, spread);
        }
    }
    // The near limit.
    offer(sight.near, view.spread(sight.near));
    // The silhouette, and the ends of the incidence limit on the front and on the back.
    if view.power > 0.0 {
        let d = view.power.sqrt();
        offer(d, view.spread(d));
    }
    let root = (r * r * c * c + view.power).sqrt();
    for d in [root - r * c, r * c + root, r * c - root] {
        offer(d, view.spread(d));
    }
    best
}

/// A sphere, with quantities relative to the apex and axis of a cone.
struct SphereInCone<'a> {
    cone: &'a BeamCone,
    centre: Vector3<f64>,
    radius: f64,
    /// Distance to the centre.
    away: f64,
    /// `away^2 - radius^2`: the product of the near and the far distance along any line.
    power: f64,
    /// Unit vector towards the centre.
    ahead: Vector3<f64>,
    /// Unit vector perpendicular to `ahead`, on the side of the axis.
    beside: Vector3<f64>,
    /// Angle between the axis and the direction to the centre.
    off_axis: f64,
}

impl<'a> SphereInCone<'a> {
    fn new(cone: &'a BeamCone, centre: &Vector3<f64>, radius: f64) -> Self {
        let axis = cone.sight.axis;
        let away = centre.norm();
        let ahead = centre.try_normalize(0.0).unwrap_or(axis);
        let along = ahead.dot(&axis);
        let across = axis - ahead * along;
        Self {
            cone,
            centre: *centre,
            radius,
            away,
            power: (away - radius) * (away + radius),
            ahead,
            beside: across.try_normalize(1e-300).unwrap_or_else(|| any_perpendicular(&ahead)),
            off_axis: libm::atan2(across.norm(), along),
        }
    }

    /// Returns the angle from the centre line at which points at distance `d` are seen.
    fn spread(&self, d: f64) -> f64 {
        libm::acos(((d * d + self.power) / (2.0 * self.away * d)).clamp(-1.0, 1.0))
    }

    /// Returns the point at distance `d` and angle `spread` that is nearest to the axis, if it is admissible.
    fn point(&self, d: f64, spread: f64, half: Option<&Vector3<f64>>) -> Option<Vector3<f64>> {
        let sight = &self.cone.sight;
        let size = self.away + self.radius;
        let on_sphere =
            d >= (self.away - self.radius).abs() - ROUNDING_TOLERANCE * size && d <= size * (1.0 + ROUNDING_TOLERANCE);
        if !(d >= sight.near && d <= sight.far && d > 0.0 && on_sphere) {
            return None;
        }
        // Cosine of the incidence; positive on the front.
        let cos = (self.power - d * d) / (2.0 * self.radius * d);
        let slack = ROUNDING_TOLERANCE * size / self.radius;
        let front = sight.faces.front && cos >= sight.cos_incidence - slack;
        let back = sight.faces.back && -cos >= sight.cos_incidence - slack;
        // Cosines lose precision at small angles, so callers that need exact candidates pass an exact spread.
        let in_cone = (self.off_axis - spread).abs() <= self.cone.half_angle + ROUNDING_TOLERANCE;
        if !(front || back) || !in_cone {
            return None;
        }
        match half {
            None => Some(self.at(d, spread, 0.0)),
            Some(side) => self.on_half(d, spread, side),
        }
    }

    /// Returns the point of the circle at an angle along it, measured from the point nearest to the axis.
    fn at(&self, d: f64, spread: f64, turn: f64) -> Vector3<f64> {
        let around = self.beside * libm::cos(turn) + self.ahead.cross(&self.beside) * libm::sin(turn);
        (self.ahead * libm::cos(spread) + around * libm::sin(spread)) * d
    }

    /// Returns the point of the circle on one side of the centre that is nearest to the axis, if it is in the cone.
    fn on_half(&self, d: f64, spread: f64, side: &Vector3<f64>) -> Option<Vector3<f64>> {
        let first = self.at(d, spread, 0.0);
        if (first - self.centre).dot(side) >= 0.0 {
            return Some(first);
        }
        // Solve side . (p - centre) = even + swing cos(turn - lean).
        let even = side.dot(&(self.ahead * (d * libm::cos(spread)) - self.centre));
        let (x, y) = (side.dot(&self.beside), side.dot(&self.ahead.cross(&self.beside)));
        let swing = d * libm::sin(spread) * crate::length(x, y);
        let width = libm::acos(-even / swing);
        let lean = libm::atan2(y, x);
        // If no point of the circle is on that side, the result is NaN, which fails the cone test.
        let turn = if lean >= 0.0 { lean - width } else { lean + width };
        let point = self.at(d, spread, turn);
        (turn.is_finite() && self.cone.contains(&point)).then_some(point)
    }
}
