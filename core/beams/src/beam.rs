//! Beams and their hits.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Point3, Vector3};

/// The region that a beam searches, in the frame of the beam, which looks along +z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Volume {
    /// The half line along +z; the first surface it meets counts.
    Ray,
    /// A spherical sector; the nearest surface point at most `half_angle` off +z counts.
    Cone {
        /// Half of the opening angle, in radians; 0 to pi, so values beyond pi/2 are allowed.
        half_angle: f64,
    },
    /// A frustum between two rectangles perpendicular to +z and centred on it; the beam's near and far are their
    /// heights. All points in it count, regardless of their distance from the origin.
    Pyramid {
        /// Full size of the near end along x, in metres.
        x_near: f64,
        /// Full size of the near end along y, in metres.
        y_near: f64,
        /// Full size of the far end along x, in metres.
        x_far: f64,
        /// Full size of the far end along y, in metres.
        y_far: f64,
    },
    /// A round frustum around +z; the beam's near and far are the heights of its flat ends.
    Cylinder {
        /// Radius of the near end, in metres.
        radius_near: f64,
        /// Radius of the far end, in metres.
        radius_far: f64,
    },
    /// A flat sector: directions in the xz plane at an angle of at most half of `angle` from +z, and points at most
    /// half of `height` away from that plane. Near and far are distances from the origin.
    Disc {
        /// Full opening angle, in radians; 2 pi covers all directions in the plane.
        angle: f64,
        /// Thickness along y, in metres.
        height: f64,
        /// Opening around +z that is left out, in radians; 0 for none.
        gap: f64,
    },
}

/// The sides of surfaces that count as hits. The front is the outside of a solid form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Faces {
    /// Whether hits on the outside of a surface count.
    pub front: bool,
    /// Whether hits on the inside of a surface count.
    pub back: bool,
}

impl Faces {
    /// Both sides.
    pub const BOTH: Self = Self { front: true, back: true };
    /// Only the outside.
    pub const FRONT: Self = Self { front: true, back: false };
    /// Only the inside.
    pub const BACK: Self = Self { front: false, back: true };
}

/// One query to a [`BeamScene`](super::BeamScene).
///
/// A surface point counts when it lies in the volume, at a distance from `near` to `far`, shows a side in `faces` and
/// meets the line of sight at no more than `max_incidence`. Surfaces do not occlude one another from a volume: the
/// result is the nearest point that counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Pose of the beam, which starts at the origin and looks along +z.
    pub world_from_beam: Isometry3<f64>,
    /// The region searched.
    pub volume: Volume,
    /// Minimum distance from the origin, in metres; for a pyramid or cylinder the height of its near end.
    pub near: f64,
    /// Maximum distance from the origin, in metres, which bounds a sphere and not a plane; for a pyramid or cylinder
    /// the height of its far end.
    pub far: f64,
    /// Maximum angle between the surface normal and the line of sight, in radians; pi/2 or more is no limit.
    pub max_incidence: f64,
    /// Sides of surfaces that count.
    pub faces: Faces,
    /// A group to ignore, such as the model that carries the sensor.
    pub skip_group: Option<u32>,
    /// If set, only this object is considered; other objects neither count nor occlude it.
    pub only_object: Option<u64>,
}

impl Beam {
    /// Returns a ray with a range of `far` metres for which both sides count, without other limits.
    pub fn ray(world_from_beam: Isometry3<f64>, far: f64) -> Self {
        Self {
            world_from_beam,
            volume: Volume::Ray,
            near: 0.0,
            far,
            max_incidence: FRAC_PI_2,
            faces: Faces::BOTH,
            skip_group: None,
            only_object: None,
        }
    }

    /// Returns a cone of `half_angle` radians with a range of `far` metres for which both sides count, without other
    /// limits.
    pub fn cone(world_from_beam: Isometry3<f64>, half_angle: f64, far: f64) -> Self {
        Self { volume: Volume::Cone { half_angle }, ..Self::ray(world_from_beam, far) }
    }
}

/// The nearest surface point that counts for a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance from the origin of the beam to the point, in metres; infinity if there is no hit.
    pub distance: f64,
    /// The point, in the frame of the beam.
    pub point: Point3<f64>,
    /// Unit surface normal on the side of the sensor, in the frame of the beam.
    pub normal: Vector3<f64>,
    /// Tag of the target. Among equal distances the lowest tag wins, then the lowest primitive.
    pub object: u64,
    /// Part of the form: the triangle of a mesh; the face of a box (-x +x -y +y -z +z); for a cylinder or capsule 0 for
    /// the side, 1 for the end at +z, 2 for the end at -z; otherwise 0.
    pub primitive: u32,
}

impl Hit {
    /// The result if there is no hit: an infinite distance; all other fields are zero.
    pub const NONE: Self = Self {
        distance: f64::INFINITY,
        point: Point3::new(0.0, 0.0, 0.0),
        normal: Vector3::new(0.0, 0.0, 0.0),
        object: 0,
        primitive: 0,
    };

    /// Returns whether there is a hit.
    pub fn is_some(&self) -> bool {
        self.distance < f64::INFINITY
    }
}
