//! The nearest point of a sphere, or of the hemisphere that caps a capsule, in a convex volume.
//!
//! Points of a sphere at the same distance from the origin form a circle around the line to its centre, and every limit
//! except the volume is a limit on that distance. The nearest admissible point is therefore in one of these places:
//!
//! - on the circle at the distance of one of these limits;
//! - on a plane of the volume, at the nearest or farthest point of the circle in which the plane cuts the sphere;
//! - at an intersection of two planes and the sphere.

use arrayvec::ArrayVec;
use nalgebra::Vector3;

use super::{CONTACT_TOLERANCE_M, ConvexVolume, HalfSpace};
use crate::planar::any_perpendicular;

/// Tolerance for conditions that a candidate satisfies exactly, except for rounding.
const ROUNDING_TOLERANCE: f64 = 1e-11;
/// Maximum number of planes that approximate a round side.
const MAX_TANGENT_PLANES: usize = 40;

type PlaneList = ArrayVec<HalfSpace, { 6 + 1 + MAX_TANGENT_PLANES }>;

/// Returns the nearest admissible point of a sphere; `centre` is relative to the origin. With `half`, only the
/// hemisphere on that side is considered.
pub(super) fn sphere(
    space: &ConvexVolume,
    centre: &Vector3<f64>,
    radius: f64,
    half: Option<&Vector3<f64>>,
) -> Option<(f64, Vector3<f64>)> {
    if space.misses_ball(centre, radius) || radius <= 0.0 {
        return None;
    }
    let mut planes: PlaneList = space.planes.iter().copied().collect();
    planes.extend(half.map(|side| HalfSpace { normal: -side, height: -side.dot(centre) }));
    let view = SphereInVolume::new(space, centre, radius);
    loop {
        let (distance, point) = view.nearest(&planes)?;
        let touching = space
            .side
            .map(|side| side.tangent_plane(&point))
            .filter(|plane| plane.excess(&point) > CONTACT_TOLERANCE_M);
        match touching {
            Some(plane) if !planes.is_full() => planes.push(plane),
            _ => return Some((distance, point)),
        }
    }
}

/// A sphere, with quantities relative to the origin.
struct SphereInVolume<'a> {
    space: &'a ConvexVolume,
    centre: Vector3<f64>,
    radius: f64,
    /// Distance to the centre.
    away: f64,
    /// `away^2 - radius^2`.
    power: f64,
    /// Unit vector towards the centre.
    ahead: Vector3<f64>,
    beside: [Vector3<f64>; 2],
}

impl<'a> SphereInVolume<'a> {
    fn new(space: &'a ConvexVolume, centre: &Vector3<f64>, radius: f64) -> Self {
        // At the centre of a sphere, all its points are equally far away. A negligible displacement avoids this special
        // case.
        let least = 1e-10 * radius;
        let centre = if centre.norm() < least { space.sight.axis * least } else { *centre };
        let away = centre.norm();
        let ahead = centre / away;
        let first = any_perpendicular(&ahead);
        Self {
            space,
            centre,
            radius,
            away,
            power: (away - radius) * (away + radius),
            ahead,
            beside: [first, ahead.cross(&first)],
        }
    }

    fn nearest(&self, planes: &[HalfSpace]) -> Option<(f64, Vector3<f64>)> {
        let mut best: Option<(f64, Vector3<f64>)> = None;
        let (r, sight) = (self.radius, &self.space.sight);
        let c = sight.cos_incidence;
        let root = (r * r * c * c + self.power).sqrt();
        let ends = [
            (self.away - r).abs(),
            self.away + r,
            sight.near,
            self.power.sqrt(),
            root - r * c,
            r * c + root,
            r * c - root,
        ];
        for d in ends {
            if best.is_none_or(|(least, _)| d < least)
                && self.is_admissible(d)
                && let Some(point) = self.on_circle(d, planes)
            {
                best = Some((d, point));
            }
        }
        let mut offer = |point: Vector3<f64>| {
            let d = point.norm();
            let within = |plane: &HalfSpace| plane.excess(&point) <= ROUNDING_TOLERANCE * (1.0 + d);
            if best.is_none_or(|(least, _)| d < least) && self.is_admissible(d) && planes.iter().all(within) {
                best = Some((d, point));
            }
        };
        for (i, plane) in planes.iter().enumerate() {
            let off = plane.excess(&self.centre);
            if off.abs() > r {
                continue;
            }
            let middle = self.centre - plane.normal * off;
            let width = (r * r - off * off).sqrt();
            let flat = middle - plane.normal * plane.height;
            let toward = flat.try_normalize(1e-300).unwrap_or_else(|| any_perpendicular(&plane.normal));
            offer(middle - toward * width);
            offer(middle + toward * width);
            for other in &planes[..i] {
                // The points where the circle crosses the other plane.
                let along = plane.normal.cross(&other.normal);
                let Some(along) = along.try_normalize(1e-9) else { continue };
                let down = along.cross(&plane.normal);
                let step = -other.excess(&middle) / other.normal.dot(&down);
                let half = (width * width - step * step).sqrt();
                offer(middle + down * step + along * half);
                offer(middle + down * step - along * half);
            }
        }
        best
    }

    /// Returns whether points at a distance satisfy all limits except the volume.
    fn is_admissible(&self, d: f64) -> bool {
        let sight = &self.space.sight;
        let size = self.away + self.radius;
        let on_sphere =
            d >= (self.away - self.radius).abs() - ROUNDING_TOLERANCE * size && d <= size * (1.0 + ROUNDING_TOLERANCE);
        if !(d >= sight.near && d <= sight.far && d > 0.0 && on_sphere) {
            return false;
        }
        // Cosine of the incidence; positive on the front.
        let cos = (self.power - d * d) / (2.0 * self.radius * d);
        let slack = ROUNDING_TOLERANCE * size / self.radius;
        (sight.faces.front && cos >= sight.cos_incidence - slack)
            || (sight.faces.back && -cos >= sight.cos_incidence - slack)
    }

    /// Returns a point of the sphere that is at the distance `d` and behind all planes, or `None` if there is none.
    fn on_circle(&self, d: f64, planes: &[HalfSpace]) -> Option<Vector3<f64>> {
        let cos = ((d * d + self.power) / (2.0 * self.away * d)).clamp(-1.0, 1.0);
        let (middle, width) = (self.ahead * (d * cos), d * (1.0 - cos * cos).max(0.0).sqrt());
        let at = |turn: f64| middle + (self.beside[0] * libm::cos(turn) + self.beside[1] * libm::sin(turn)) * width;
        let inside = |p: &Vector3<f64>| planes.iter().all(|plane| plane.excess(p) <= ROUNDING_TOLERANCE * (1.0 + d));
        let start = at(0.0);
        if inside(&start) {
            return Some(start);
        }
        // The arcs behind all planes start and end where the circle crosses a plane, unless the whole circle is behind
        // them.
        for plane in planes {
            let (x, y) = (plane.normal.dot(&self.beside[0]), plane.normal.dot(&self.beside[1]));
            let turn = libm::atan2(y, x);
            let reach = libm::acos((-plane.excess(&middle) / (width * crate::length(x, y))).clamp(-1.0, 1.0));
            for point in [at(turn + reach), at(turn - reach)] {
                if inside(&point) {
                    return Some(point);
                }
            }
        }
        None
    }
}
