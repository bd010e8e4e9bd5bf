//! Intersection of convex volumes (pyramids, cylinders and flat sectors) with every form.
//!
//! A volume is the intersection of half-spaces and, in some cases, of a round side. The nearest point of a flat face in
//! the volume is found by clipping the face. A round side is approximated from outside by tangent planes, which are
//! added where a nearest point turns out to be outside. The distance in each step is therefore a lower bound, and the
//! final point is in the volume. Spheres have a closed form, and the sides of cylinders are searched over one angle.

mod ball;
mod flat;
mod solid;
mod strip;

use arrayvec::ArrayVec;
use nalgebra::{Isometry3, Vector3};

use super::{aabb::BOX_TOLERANCE_M, beam::Volume, sight::SightLine};

pub(super) use flat::nearest_on_face;
pub(super) use solid::cast;

/// Maximum distance outside a round side at which a point is still treated as inside, in metres.
const CONTACT_TOLERANCE_M: f64 = 1e-11;

/// A half-space: `normal . p <= height`.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfSpace {
    pub normal: Vector3<f64>,
    pub height: f64,
}

impl HalfSpace {
    /// Returns the signed distance of a point in front of the plane.
    pub fn excess(&self, p: &Vector3<f64>) -> f64 {
        self.normal.dot(p) - self.height
    }
}

/// A round side around the axis of the volume; at a height along the axis, its radius is `radius + rise * height`.
#[derive(Debug, Clone, Copy)]
pub(super) struct TaperedSide {
    axis: Vector3<f64>,
    radius: f64,
    rise: f64,
}

impl TaperedSide {
    /// Returns the tangent plane of the side nearest to a point.
    pub fn tangent_plane(&self, p: &Vector3<f64>) -> HalfSpace {
        let along = self.axis.dot(p);
        let out = (p - self.axis * along).try_normalize(1e-300).unwrap_or_else(Vector3::zeros);
        let scale = 1.0 / crate::length(self.rise, 1.0);
        HalfSpace { normal: (out - self.axis * self.rise) * scale, height: self.radius * scale }
    }
}

/// A convex volume relative to the origin of the sight, in the frame of the form it is tested against.
///
/// The near and far limits of the sight apply to distances, in addition to the planes.
#[derive(Debug, Clone)]
pub(super) struct ConvexVolume {
    pub sight: SightLine,
    planes: ArrayVec<HalfSpace, 6>,
    side: Option<TaperedSide>,
    /// Maximum distance of any point of the volume from the origin.
    size: f64,
}

/// Maximum angle of a piece, in radians. Wider sectors are split, so that each piece is convex by a good margin.
const MAX_PIECE_ANGLE: f64 = 2.0;

/// Returns the number of convex pieces into which a volume is split.
pub(super) fn pieces(volume: &Volume) -> usize {
    match volume {
        Volume::Disc { angle, gap, .. } => {
            let (count, sides) = arcs(*angle, *gap);
            count * sides
        }
        _ => 1,
    }
}

/// Returns the number of pieces on each side of a gap, and the number of sides.
fn arcs(angle: f64, gap: f64) -> (usize, usize) {
    let sides = if gap > 0.0 { 2 } else { 1 };
    let width = (angle - gap.max(0.0)).max(0.0) / sides as f64;
    // The angle is at most a full turn. A NaN angle results in one piece, in which nothing is found.
    (((width / MAX_PIECE_ANGLE).ceil() as usize).clamp(1, 4), sides)
}

impl ConvexVolume {
    /// Returns one piece of a volume, in the frame of the beam, or `None` if it is empty or its sizes are invalid.
    ///
    /// This function must not be inlined, because the compiler would hoist a part of it above the match on the volume.
    /// For rays it would then compute with the bytes of other variants, mostly denormal numbers, which takes a fifth of
    /// the time of a cast.
    #[inline(never)]
    pub fn new(sight: &SightLine, volume: &Volume, piece: usize) -> Option<Self> {
        let (near, far) = (sight.near, sight.far);
        let half = |x: f64, y: f64, z: f64, height: f64| {
            let length = crate::length(crate::length(x, y), z);
            HalfSpace { normal: Vector3::new(x, y, z) / length, height: height / length }
        };
        let ends = [half(0.0, 0.0, 1.0, far), half(0.0, 0.0, -1.0, -near)];
        let flat_ends = SightLine { near: 0.0, far: f64::INFINITY, ..*sight };
        // Returns the growth of a half size per metre, and its value at the origin.
        let line = |at_near: f64, at_far: f64| {
            let rise = (at_far - at_near) / (far - near);
            (rise, at_near - rise * near)
        };
        match *volume {
            Volume::Pyramid { x_near, y_near, x_far, y_far } => {
                let sizes = [x_near, y_near, x_far, y_far];
                if !(sizes.iter().all(|s| *s >= 0.0 && s.is_finite()) && far.is_finite() && near < far) {
                    return None;
                }
                let ((bx, ax), (by, ay)) = (line(x_near / 2.0, x_far / 2.0), line(y_near / 2.0, y_far / 2.0));
                let sides = [
                    half(1.0, 0.0, -bx, ax),
                    half(-1.0, 0.0, -bx, ax),
                    half(0.0, 1.0, -by, ay),
                    half(0.0, -1.0, -by, ay),
                ];
                let size = [(x_near, y_near, near), (x_far, y_far, far)]
                    .map(|(x, y, z)| crate::length(crate::length(x / 2.0, y / 2.0), z));
                Some(Self {
                    sight: flat_ends,
                    planes: ends.into_iter().chain(sides).collect(),
                    side: None,
                    size: size[0].max(size[1]),
                })
            }
            Volume::Cylinder { radius_near, radius_far } => {
                let sizes = [radius_near, radius_far];
                if !(sizes.iter().all(|s| *s >= 0.0 && s.is_finite()) && far.is_finite() && near < far) {
                    return None;
                }
                let (rise, radius) = line(radius_near, radius_far);
                Some(Self {
                    sight: flat_ends,
                    planes: ends.into_iter().collect(),
                    side: Some(TaperedSide { axis: Vector3::z(), radius, rise }),
                    size: crate::length(radius_near, near).max(crate::length(radius_far, far)),
                })
            }
            Volume::Disc { angle, height, gap } => {
                let numbers = angle > 0.0 && height >= 0.0 && gap < angle;
                if !(numbers && angle.is_finite() && height.is_finite()) {
                    return None;
                }
                let (angle, gap) = (angle.min(std::f64::consts::TAU), gap.max(0.0));
                let (count, sides) = arcs(angle, gap);
                let start = if piece < count || sides == 1 { -angle / 2.0 } else { gap / 2.0 };
                let width = (angle - gap) / (count * sides) as f64;
                let first = start + width * (piece % count) as f64;
                let last = first + width;
                let planes = [
                    half(libm::cos(last), 0.0, -libm::sin(last), 0.0),
                    half(-libm::cos(first), 0.0, libm::sin(first), 0.0),
                    half(0.0, 1.0, 0.0, height / 2.0),
                    half(0.0, -1.0, 0.0, height / 2.0),
                ];
                Some(Self { sight: *sight, planes: planes.into_iter().collect(), side: None, size: far })
            }
            Volume::Ray | Volume::Cone { .. } => None,
        }
    }

    /// Returns the rotated volume, for example from the frame of the beam to that of the world.
    pub fn rotated(&self, turn: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Self {
        let mut out = self.clone();
        for plane in &mut out.planes {
            plane.normal = turn(&plane.normal);
        }
        if let Some(side) = &mut out.side {
            side.axis = turn(&side.axis);
        }
        out
    }

    /// Returns the volume in the frame of a form, limited to the distance `far`.
    pub fn in_form(&self, world_from_form: &Isometry3<f64>, far: f64) -> Self {
        let mut out = self.rotated(|v| world_from_form.inverse_transform_vector(v));
        out.sight = self.sight.in_form(world_from_form, far);
        out
    }

    /// Returns a volume that contains this one and all points within `by` of it.
    fn grown(&self, by: f64) -> Self {
        let mut out = self.clone();
        for plane in &mut out.planes {
            plane.height += by;
        }
        if let Some(side) = &mut out.side {
            side.radius += by * crate::length(side.rise, 1.0);
        }
        out.size += by;
        out
    }

    /// Returns a plane behind which the whole volume lies and in front of which the point lies by more than `slack`, if
    /// there is one.
    pub fn separating_plane(&self, p: &Vector3<f64>, slack: f64) -> Option<HalfSpace> {
        let side = self.side.map(|side| side.tangent_plane(p));
        let planes = self.planes.iter().copied().chain(side);
        let worst = planes.max_by(|a, b| a.excess(p).total_cmp(&b.excess(p)))?;
        (worst.excess(p) > slack).then_some(worst)
    }

    /// Returns whether a sphere certainly misses the volume. `false` does not imply that they intersect.
    pub fn misses_ball(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        self.separating_plane(centre, radius).is_some() || centre.norm() - radius > self.size
    }

    /// Returns whether a box certainly misses the volume; `centre` is relative to the origin, `half` is half of its
    /// size.
    pub fn misses_box(&self, centre: &Vector3<f64>, half: &Vector3<f64>) -> bool {
        let beyond = |plane: &HalfSpace| plane.excess(centre) > plane.normal.abs().dot(half) + BOX_TOLERANCE_M;
        self.planes.iter().any(beyond) || self.side.is_some_and(|side| beyond(&side.tangent_plane(centre)))
    }
}
