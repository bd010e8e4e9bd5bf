//! The nearest point of the curved side of a cylinder or capsule in a cone, by a branch-and-bound search over one
//! angle.
//!
//! At a given angle around the axis of the cylinder, the surface is a straight line, whose nearest admissible point has
//! a closed form. Over an interval of angles, the surface is within a known offset of a flat strip. A lower bound is
//! the distance of the nearest point of that strip in a cone widened by the offset, minus the offset. Intervals whose
//! bound is not below the distance of the best point so far by more than [`TOLERANCE`] are dropped, and all others are
//! halved. Because the offset decreases with the square of the width, only a few intervals remain at each level. When
//! no interval is left, the result is the global minimum to within the tolerance.
//!
//! The common case, a convex cone and a solid seen from outside, is settled beforehand by a tangent plane
//! ([`CylinderSide::prove_nearest`]).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use super::{
    beam::Faces,
    planar::{NearestPoint, edge, plane, polygon},
    sight::{BeamCone, SightLine},
};

/// Maximum excess over the true minimum distance, in metres.
const TOLERANCE: f64 = 2e-10;
/// Maximum distance, as a fraction of the radius, between the point found in a tangent plane and the plane's line of
/// contact at which the proof succeeds.
const PROOF_TOLERANCE: f64 = 1e-10;
/// Maximum number of intervals per level. More intervals remain only if a whole range of angles is equally near, for
/// example because the apex is on the axis. The search then stops, and the nearest of the samples, which are dense by
/// then, is the result.
const MAX_INTERVALS: usize = 256;
/// Maximum number of halvings, after which the samples are closer than rounding.
const MAX_HALVINGS: usize = 44;

/// The side of a cylinder as seen from the apex of a cone, in the frame of the cylinder.
pub(super) struct CylinderSide {
    cone: BeamCone,
    radius: f64,
    half_length: f64,
    skip_back: bool,
}

/// A point of the side: its distance, its position relative to the apex, and its outward normal.
pub(super) type CylinderSidePoint = (f64, Vector3<f64>, Vector3<f64>);

/// The result of a proof by tangent planes of a convex solid.
pub(super) enum TangentProof {
    /// No point of the solid is admissible.
    Nothing,
    /// This is the nearest admissible point.
    Nearest(CylinderSidePoint),
    /// Nothing is proven.
    Unproven,
}

impl CylinderSide {
    /// Creates a side. With `skip_back`, back faces are skipped, because a nearer surface always covers them.
    pub fn new(cone: &BeamCone, radius: f64, half_length: f64, skip_back: bool) -> Self {
        let mut cone = *cone;
        // The range is slightly enlarged, so that a limit from another target never changes the course of the search.
        cone.sight.far += 2.0 * TOLERANCE;
        Self { cone, radius, half_length, skip_back }
    }

    /// Returns the nearest admissible point.
    pub fn nearest(&self) -> Option<CylinderSidePoint> {
        let mut level = [0.0; MAX_INTERVALS];
        let mut next = [0.0; MAX_INTERVALS];
        // The front is searched first, since it usually contains the nearest point.
        let mut best = (f64::INFINITY, Vector3::zeros(), Vector3::zeros());
        for (start, end) in self.arcs().into_iter().flatten() {
            let pieces = ((end - start) / FRAC_PI_2).ceil().max(2.0);
            let mut half_width = 0.5 * (end - start) / pieces;
            let mut count = pieces as usize;
            for (i, middle) in level[..count].iter_mut().enumerate() {
                *middle = start + half_width * (2 * i + 1) as f64;
                self.sample(*middle, &mut best);
            }
            for _ in 0..MAX_HALVINGS {
                let strip = FlatStrip::new(self.radius, half_width);
                let mut next_count = 0;
                for &middle in &level[..count] {
                    if self.bound(middle, &strip) >= best.0 - TOLERANCE {
                        continue;
                    }
                    for child in [middle - 0.5 * half_width, middle + 0.5 * half_width] {
                        self.sample(child, &mut best);
                        if next_count < MAX_INTERVALS {
                            next[next_count] = child;
                        }
                        next_count += 1;
                    }
                }
                if next_count == 0 || next_count > MAX_INTERVALS {
                    break;
                }
                (level, count) = (next, next_count);
                half_width *= 0.5;
            }
        }
        (best.0 <= self.cone.sight.far - 2.0 * TOLERANCE).then_some(best)
    }

    /// Searches for the nearest point of the convex solid that this side belongs to, if that point is on the side and a
    /// tangent plane proves that it is the nearest.
    ///
    /// The solid lies behind each of its tangent planes, so the part of a plane in the cone is at least as near as the
    /// part of the solid in the cone. At the nearest point of the solid both distances are equal. The search looks for
    /// the plane that touches there.
    pub fn prove_nearest(&self) -> TangentProof {
        let [Some((mut low, mut high)), None] = self.arcs() else {
            return TangentProof::Unproven;
        };
        let (mut at_low, mut at_high) = (None, None);
        let mut went_up = false;
        for round in 0..40 {
            let angle = match (at_low, at_high) {
                (Some(a), Some(b)) if round % 8 != 7 => (low * b - high * a) / (b - a),
                _ => 0.5 * (low + high),
            };
            let normal = Vector3::new(libm::cos(angle), libm::sin(angle), 0.0);
            let foot = normal * self.radius - self.cone.sight.origin.coords;
            let Some((bound, point)) = plane(&self.cone, normal.dot(&foot), &normal) else {
                return TangentProof::Nothing;
            };
            // Signed distance of the nearest point of the plane from the line of contact.
            let beside = Vector3::new(-normal.y, normal.x, 0.0).dot(&(point - foot));
            if beside.abs() < PROOF_TOLERANCE * self.radius {
                // If the point is on the line but beyond the end of the side, the nearest point of the solid is at that
                // end.
                let on_side = (point.z + self.cone.sight.origin.z).abs() <= self.half_length;
                let nearest = TangentProof::Nearest((bound, point, normal));
                return if on_side { nearest } else { TangentProof::Unproven };
            }
            // The value at an end that is retained twice in a row is halved (Illinois variant), since plain false
            // position converges slowly.
            if beside > 0.0 {
                at_high = at_high.map(|x: f64| if went_up { 0.5 * x } else { x });
                (low, at_low, went_up) = (angle, Some(beside), true);
            } else {
                at_low = at_low.map(|x: f64| if went_up { x } else { 0.5 * x });
                (high, at_high, went_up) = (angle, Some(beside), false);
            }
        }
        TangentProof::Unproven
    }

    /// Returns the range of angles at which the front of the surface faces the apex, and the range at which the back
    /// does.
    fn arcs(&self) -> [Option<(f64, f64)>; 2] {
        let SightLine { origin, faces, .. } = &self.cone.sight;
        let away = crate::length(origin.x, origin.y);
        let toward = libm::atan2(origin.y, origin.x);
        let edge = if away > self.radius { libm::acos(self.radius / away) } else { 0.0 };
        let front = edge > 0.0 && faces.front;
        let back = faces.back && !self.skip_back;
        [front.then_some((toward - edge, toward + edge)), back.then_some((toward + edge, toward + TAU - edge))]
    }

    /// Updates `best` with the nearest admissible point on the straight line along the surface at one angle.
    fn sample(&self, angle: f64, best: &mut CylinderSidePoint) {
        let sight = &self.cone.sight;
        let normal = Vector3::new(libm::cos(angle), libm::sin(angle), 0.0);
        let foot = normal * self.radius - sight.origin.coords;
        let rise = Vector3::new(0.0, 0.0, self.half_length);
        let mut nearest = NearestPoint::new(sight.near, sight.reach(normal.dot(&foot).abs()));
        edge(&self.cone, &(foot - rise), &(foot + rise), &mut nearest);
        if nearest.distance < best.0 {
            *best = (nearest.distance, nearest.point, normal);
        }
    }

    /// Returns a lower bound of the distance of all admissible points at the angles of a strip around `middle`.
    fn bound(&self, middle: f64, strip: &FlatStrip) -> f64 {
        let BeamCone { sight, cos, sin, half_angle } = &self.cone;
        let offset = strip.offset;
        let normal = Vector3::new(libm::cos(middle), libm::sin(middle), 0.0);
        let tangent = Vector3::new(-normal.y, normal.x, 0.0);
        let centre = normal * (self.radius - offset) - sight.origin.coords;
        let beside = (centre.dot(&tangent).abs() - strip.reach).max(0.0);
        let above = (centre.z.abs() - self.half_length).max(0.0);
        let least = Vector3::new(centre.dot(&normal), beside, above).norm();
        if least <= 2.0 * offset {
            return (least - offset).max(0.0);
        }
        // Moving a point at this distance by `offset` changes its direction by at most `turn`.
        let (sin_turn, turn) = (offset / least, libm::asin(offset / least));
        let cos_turn = (1.0 - sin_turn * sin_turn).sqrt();
        let mut widened = BeamCone {
            half_angle: half_angle + turn,
            cos: cos * cos_turn - sin * sin_turn,
            sin: sin * cos_turn + cos * sin_turn,
            sight: SightLine {
                near: (sight.near - offset).max(0.0),
                far: sight.far + offset,
                faces: Faces::BOTH,
                ..*sight
            },
        };
        if widened.half_angle >= PI {
            widened = BeamCone::new(widened.sight, PI);
        }
        if sight.cos_incidence > 0.0 {
            let max_incidence = libm::acos(sight.cos_incidence) + strip.half_width + turn;
            widened.sight.cos_incidence = libm::cos(max_incidence.min(FRAC_PI_2)).max(0.0);
        }
        let (across, along) = (tangent * strip.reach, Vector3::new(0.0, 0.0, self.half_length));
        let corners =
            [centre - across - along, centre + across - along, centre + across + along, centre - across + along];
        polygon(&widened, &corners, &normal).map_or(f64::INFINITY, |(distance, _)| distance - offset)
    }
}

/// Properties shared by the flat strips of one level: each strip lies halfway between the chord and the tangent of its
/// arc.
struct FlatStrip {
    half_width: f64,
    /// Maximum distance of the surface from the strip.
    offset: f64,
    /// Half the width of the strip, in metres.
    reach: f64,
}

impl FlatStrip {
    fn new(radius: f64, half_width: f64) -> Self {
        let offset = radius * libm::sin(0.5 * half_width).powi(2);
        Self { half_width, offset, reach: radius * libm::sin(half_width) }
    }
}
