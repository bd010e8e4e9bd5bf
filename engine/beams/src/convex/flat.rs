//! The nearest point of a flat face in a convex volume.

use arrayvec::ArrayVec;
use nalgebra::{Vector2, Vector3};

use super::{CONTACT_TOLERANCE_M, ConvexVolume, HalfSpace};
use crate::planar::any_perpendicular;

/// Maximum number of cuts, after which the remaining error is within rounding.
const MAX_CUTS: usize = 56;
/// Maximum number of corners of a face after all cuts.
const MAX_CORNERS: usize = 4 + 6 + MAX_CUTS + 2;

/// The circular rim of a face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DiscRim {
    pub centre: Vector3<f64>,
    pub radius: f64,
}

/// Returns the nearest admissible point of a convex polygon or, if `rim` is given, of the disc in it that `rim` bounds.
/// The corners are relative to the origin, counter-clockwise around `normal`.
pub(crate) fn nearest_on_face(
    space: &ConvexVolume,
    corners: &[Vector3<f64>],
    normal: &Vector3<f64>,
    rim: Option<DiscRim>,
) -> Option<(f64, Vector3<f64>)> {
    let sight = &space.sight;
    let h = normal.dot(corners.first()?);
    let reach = sight.reach(h.abs());
    if h.abs() > reach || !sight.sees_side(h) || reach.is_nan() {
        return None;
    }
    let mut face = FlatFace::new(normal, h, corners)?;
    for plane in &space.planes {
        face.clip(plane);
    }
    // The polygon contains the region. While its nearest point is outside the region, that point is cut off.
    let mut point = face.nearest()?;
    for _ in 0..MAX_CUTS {
        let place = face.unproject(&point);
        if place.norm() > reach {
            return None;
        }
        let Some(plane) = face.separating_plane(space, rim, &place) else { break };
        face.clip(&plane);
        point = face.nearest()?;
    }
    let place = face.unproject(&point);
    let distance = place.norm();
    if distance > reach {
        return None;
    }
    if distance >= sight.near {
        return Some((distance, place));
    }
    // The region is convex, so if a part of it is beyond the near limit, a point of it is on the limit.
    for _ in 0..MAX_CUTS {
        let far = face.corners.iter().copied().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
        let place = face.unproject(&far);
        if place.norm() < sight.near {
            return None;
        }
        let Some(plane) = face.separating_plane(space, rim, &place) else {
            return (sight.near <= reach).then(|| (sight.near, face.unproject(&face.at(&point, &far, sight.near))));
        };
        face.clip(&plane);
    }
    None
}

/// A convex polygon in its plane, whose origin is the foot of the perpendicular.
struct FlatFace {
    foot: Vector3<f64>,
    u: Vector3<f64>,
    v: Vector3<f64>,
    corners: ArrayVec<Vector2<f64>, MAX_CORNERS>,
}

impl FlatFace {
    fn new(normal: &Vector3<f64>, h: f64, corners: &[Vector3<f64>]) -> Option<Self> {
        let u = any_perpendicular(normal);
        let mut face = Self { foot: normal * h, u, v: normal.cross(&u), corners: ArrayVec::new() };
        for corner in corners {
            let place = face.project(corner);
            if !(place.x.is_finite() && place.y.is_finite()) || face.corners.is_full() {
                return None;
            }
            face.corners.push(place);
        }
        Some(face)
    }

    fn project(&self, p: &Vector3<f64>) -> Vector2<f64> {
        Vector2::new(self.u.dot(p), self.v.dot(p))
    }

    fn unproject(&self, x: &Vector2<f64>) -> Vector3<f64> {
        self.foot + self.u * x.x + self.v * x.y
    }

    /// Returns a plane that separates a point outside the volume or the rim from the region, or `None` if the point is
    /// inside.
    fn separating_plane(&self, space: &ConvexVolume, rim: Option<DiscRim>, place: &Vector3<f64>) -> Option<HalfSpace> {
        let rim = rim.and_then(|rim| {
            let out = place - rim.centre;
            let normal = out.try_normalize(1e-300)?;
            (out.norm() > rim.radius + CONTACT_TOLERANCE_M)
                .then(|| HalfSpace { normal, height: normal.dot(&rim.centre) + rim.radius })
        });
        // The volume's planes were clipped exactly; only round sides are approximated.
        rim.or_else(|| {
            space.side.map(|side| side.tangent_plane(place)).filter(|plane| plane.excess(place) > CONTACT_TOLERANCE_M)
        })
    }

    /// Removes the part in front of a plane.
    fn clip(&mut self, plane: &HalfSpace) {
        let (slope, height) = (self.project(&plane.normal), plane.height - plane.normal.dot(&self.foot));
        let excess = |x: &Vector2<f64>| slope.dot(x) - height;
        let mut out = ArrayVec::<Vector2<f64>, MAX_CORNERS>::new();
        for (i, a) in self.corners.iter().enumerate() {
            let b = &self.corners[(i + 1) % self.corners.len()];
            let (at_a, at_b) = (excess(a), excess(b));
            let crossing = || a + (b - a) * (at_a / (at_a - at_b));
            if at_a <= 0.0 && out.try_push(*a).is_err() {
                return;
            }
            let crosses = at_a < 0.0 && at_b > 0.0 || at_a > 0.0 && at_b < 0.0;
            if crosses && out.try_push(crossing()).is_err() {
                return;
            }
        }
        self.corners = out;
    }

    /// Returns the point nearest to the foot of the perpendicular.
    fn nearest(&self) -> Option<Vector2<f64>> {
        let corners = &self.corners;
        let n = corners.len();
        let mut best: Option<Vector2<f64>> = None;
        let (mut inside, mut area) = (true, 0.0);
        for (i, a) in corners.iter().enumerate() {
            let along = corners[(i + 1) % n] - a;
            let turn = along.perp(&-a);
            inside &= turn >= 0.0;
            area += turn;
            let length = along.norm_squared();
            let t = if length > 0.0 { (-a.dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
            let point = a + along * t;
            if best.is_none_or(|best| point.norm_squared() < best.norm_squared()) {
                best = Some(point);
            }
        }
        if inside && area > 0.0 && n > 2 { Some(Vector2::zeros()) } else { best }
    }

    /// Returns the point between a near and a far one that has a given distance from the sensor.
    fn at(&self, near: &Vector2<f64>, far: &Vector2<f64>, distance: f64) -> Vector2<f64> {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let t = 0.5 * (low + high);
            if self.unproject(&near.lerp(far, t)).norm() < distance { low = t } else { high = t }
        }
        near.lerp(far, high)
    }
}
