//! The nearest point of the curved side of a cylinder or capsule in a convex volume, by a branch-and-bound search over
//! one angle, as for a cone (see `cylinder`). Intervals are dropped only if their lower bound shows that no point in
//! them is nearer than the best point so far by more than [`TOLERANCE`].

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector3;

use super::{ConvexVolume, nearest_on_face};
use crate::{beam::Faces, planar::quadratic};

/// Maximum excess over the true minimum distance, in metres.
const TOLERANCE: f64 = 2e-10;
/// Maximum number of intervals per level. More intervals remain only if a whole range of angles is equally near; the
/// search then stops, and the nearest of the samples is the result.
const MAX_INTERVALS: usize = 128;
/// Maximum number of halvings, after which the samples are closer than rounding.
const MAX_HALVINGS: usize = 44;

/// The side of a cylinder, and the volume in the frame of the cylinder.
pub(super) struct SideInVolume<'a> {
    pub space: &'a ConvexVolume,
    pub radius: f64,
    pub half_length: f64,
}

/// A point of the side: its distance, its position relative to the origin, and its outward normal.
pub(super) type SidePoint = (f64, Vector3<f64>, Vector3<f64>);

impl SideInVolume<'_> {
    /// Returns the nearest admissible point.
    pub fn nearest(&self) -> Option<SidePoint> {
        let sight = &self.space.sight;
        let origin = sight.origin.coords;
        if self.radius <= 0.0 || self.half_length.is_nan() || self.half_length < 0.0 {
            return None;
        }
        let away = crate::length(origin.x, origin.y);
        let toward = libm::atan2(origin.y, origin.x);
        let edge = if away > self.radius { libm::acos(self.radius / away) } else { 0.0 };
        let arcs = [
            (edge > 0.0 && sight.faces.front).then_some((toward - edge, toward + edge)),
            sight.faces.back.then_some((toward + edge, toward + TAU - edge)),
        ];
        let mut best = None;
        for (start, end) in arcs.into_iter().flatten() {
            let pieces = ((end - start) / FRAC_PI_2).ceil().clamp(2.0, 4.0);
            let mut half_width = 0.5 * (end - start) / pieces;
            let mut level: Vec<f64> = (0..pieces as usize).map(|i| start + half_width * (2 * i + 1) as f64).collect();
            level.iter().for_each(|middle| self.sample(*middle, &mut best));
            for _ in 0..MAX_HALVINGS {
                let mut next = Vec::new();
                for &middle in &level {
                    let known = best.map_or(f64::INFINITY, |(distance, ..): SidePoint| distance);
                    if self.bound(middle, half_width).is_none_or(|bound| bound >= known - TOLERANCE) {
                        continue;
                    }
                    for child in [middle - 0.5 * half_width, middle + 0.5 * half_width] {
                        self.sample(child, &mut best);
                        next.push(child);
                    }
                }
                if next.is_empty() || next.len() > MAX_INTERVALS {
                    break;
                }
                level = next;
                half_width *= 0.5;
            }
        }
        best
    }

    /// Updates `best` with the nearest admissible point on the straight line along the surface at one angle.
    fn sample(&self, angle: f64, best: &mut Option<SidePoint>) {
        let sight = &self.space.sight;
        let normal = Vector3::new(libm::cos(angle), libm::sin(angle), 0.0);
        let foot = normal * self.radius - sight.origin.coords;
        let rise = Vector3::new(0.0, 0.0, self.half_length);
        let reach = sight.reach(normal.dot(&foot).abs());
        if let Some((distance, point)) = segment(self.space, &(foot - rise), &(rise * 2.0), reach)
            && best.is_none_or(|(least, ..)| distance < least)
        {
            *best = Some((distance, point, normal));
        }
    }

    /// Returns a lower bound of the distance of all admissible points within `half_width` of an angle, or `None` if
    /// there are none.
    fn bound(&self, middle: f64, half_width: f64) -> Option<f64> {
        let sight = &self.space.sight;
        // The strip lies halfway between the chord and the tangent of its arc.
        let offset = self.radius * libm::sin(0.5 * half_width).powi(2);
        let reach = self.radius * libm::sin(half_width);
        let normal = Vector3::new(libm::cos(middle), libm::sin(middle), 0.0);
        let tangent = Vector3::new(-normal.y, normal.x, 0.0);
        let centre = normal * (self.radius - offset) - sight.origin.coords;
        let beside = (centre.dot(&tangent).abs() - reach).max(0.0);
        let above = (centre.z.abs() - self.half_length).max(0.0);
        let least = Vector3::new(centre.dot(&normal), beside, above).norm();
        if least <= 2.0 * offset {
            return Some((least - offset).max(0.0));
        }
        let mut grown = self.space.grown(offset);
        grown.sight.near = (sight.near - offset).max(0.0);
        grown.sight.far = sight.far + offset;
        grown.sight.faces = Faces::BOTH;
        if sight.cos_incidence > 0.0 {
            // Moving a point at this distance by `offset` changes its direction by at most `turn`.
            let turn = libm::asin(offset / least);
            let widest = libm::acos(sight.cos_incidence) + half_width + turn;
            grown.sight.cos_incidence = libm::cos(widest.min(FRAC_PI_2)).max(0.0);
        }
        let (across, along) = (tangent * reach, Vector3::new(0.0, 0.0, self.half_length));
        let corners =
            [centre - across - along, centre + across - along, centre + across + along, centre - across + along];
        nearest_on_face(&grown, &corners, &normal, None).map(|(distance, _)| distance - offset)
    }
}

/// Returns the nearest point in the volume on the line segment from `start` to `start + way`, at a distance from the
/// near limit to `reach`.
fn segment(space: &ConvexVolume, start: &Vector3<f64>, way: &Vector3<f64>, reach: f64) -> Option<(f64, Vector3<f64>)> {
    let (mut low, mut high) = (0.0, 1.0);
    for plane in &space.planes {
        let (at, slope) = (plane.excess(start), plane.normal.dot(way));
        if slope > 0.0 {
            high = f64::min(high, -at / slope);
        } else if slope < 0.0 {
            low = f64::max(low, -at / slope);
        } else if at > 0.0 {
            return None;
        }
    }
    if let Some(side) = &space.side {
        // Inside the round side, and on the correct side of its tip if it widens: |across|^2 <= (radius + rise
        // along)^2.
        let (a0, a1) = (side.axis.dot(start), side.axis.dot(way));
        let (c0, c1) = (start - side.axis * a0, way - side.axis * a1);
        let (r0, r1) = (side.radius + side.rise * a0, side.rise * a1);
        let (a, b, c) = (c1.norm_squared() - r1 * r1, 2.0 * (c0.dot(&c1) - r0 * r1), c0.norm_squared() - r0 * r0);
        let inside = |t: f64| (c0 + c1 * t).norm() <= r0 + r1 * t + 1e-12;
        // The volume is convex, so at most one interval between crossings is inside.
        let mut cuts = [low, high, low, high];
        for (cut, root) in cuts[2..].iter_mut().zip(quadratic(a, b, c)) {
            *cut = root.filter(|t| *t > low && *t < high).unwrap_or(*cut);
        }
        cuts.sort_by(f64::total_cmp);
        let within = cuts.windows(2).filter(|w| inside(0.5 * (w[0] + w[1])));
        let (first, last) = within.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), w| (l.min(w[0]), h.max(w[1])));
        (low, high) = (low.max(first), high.min(last));
    }
    if low.is_nan() || high.is_nan() || low > high {
        return None;
    }
    let square = way.norm_squared();
    let closest = if square > 0.0 { (-start.dot(way) / square).clamp(low, high) } else { low };
    let place = |t: f64| start + way * t;
    let (near, point) = (space.sight.near, place(closest));
    let distance = point.norm();
    if distance >= near {
        return (distance <= reach).then_some((distance, point));
    }
    if near > reach {
        return None;
    }
    let roots = quadratic(square, 2.0 * start.dot(way), start.norm_squared() - near * near);
    let on_limit = roots.into_iter().flatten().find(|t| *t >= low && *t <= high);
    on_limit.map(|t| (near, place(t)))
}
