//! Beams and their hits.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Point3, Vector3};

/// The region that a beam searches, in the frame of the beam, which points along +z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Volume {
    /// The half-line along +z.
    Ray,
    /// A spherical sector: all directions at an angle of at most `half_angle` from +z.
    Cone {
        /// Half of the opening angle, in radians; 0 to pi, so values beyond pi/2 are allowed.
        half_angle: f64,
    },
    /// A frustum between two rectangles that are perpendicular to +z and centred on it; `near` and `far` of the beam
    /// are their heights. The distance of points from the origin is not limited otherwise.
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
    /// A round frustum around +z; `near` and `far` of the beam are the heights of its flat ends.
    Cylinder {
        /// Radius of the near end, in metres.
        radius_near: f64,
        /// Radius of the far end, in metres.
        radius_far: f64,
    },
    /// A flat sector: directions in the xz plane at an angle of at most `angle / 2` from +z, and points at most
    /// `height / 2` away from that plane. `near` and `far` of the beam are distances from the origin.
    Disc {
        /// Full opening angle, in radians; 2 pi covers all directions in the plane.
        angle: f64,
        /// Thickness along y, in metres.
        height: f64,
        /// Full angle of a gap around +z that is not searched, in radians; 0 for no gap.
        gap: f64,
    },
}

/// The sides of surfaces that a beam detects. The front is the outside of a solid form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Faces {
    /// Whether the outside of surfaces is detected.
    pub front: bool,
    /// Whether the inside of surfaces is detected.
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
/// A surface point is admissible if it is in the volume at a distance from `near` to `far`, faces the origin with a
/// side in `faces`, and its normal is at an angle of at most `max_incidence` from the line of sight. The result is the
/// nearest admissible point; points that are not admissible do not occlude others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Pose of the beam's frame in the world. The beam starts at the origin of this frame and points along +z.
    pub world_from_beam: Isometry3<f64>,
    /// The region that is searched.
    pub volume: Volume,
    /// Minimum distance from the origin, in metres; for a pyramid or cylinder, the height of the near end.
    pub near: f64,
    /// Maximum distance from the origin, in metres, so the far end is spherical; for a pyramid or cylinder, the height
    /// of the flat far end.
    pub far: f64,
    /// Maximum angle between the surface normal and the line of sight, in radians; pi/2 or more means no limit.
    pub max_incidence: f64,
    /// Sides of surfaces that are detected.
    pub faces: Faces,
    /// Group of targets to ignore, such as the model that carries the sensor.
    pub skip_group: Option<u32>,
    /// If set, only this object is considered; other objects are neither detected nor occlude it.
    pub only_object: Option<u64>,
}

impl Beam {
    /// Returns a ray with a range of `far` metres, which detects both sides of surfaces at any incidence.
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

    /// Returns a cone of `half_angle` radians with a range of `far` metres, which detects both sides of surfaces at any
    /// incidence.
    pub fn cone(world_from_beam: Isometry3<f64>, half_angle: f64, far: f64) -> Self {
        Self { volume: Volume::Cone { half_angle }, ..Self::ray(world_from_beam, far) }
    }
}

/// The result of a beam: the nearest admissible surface point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance from the origin of the beam to the point, in metres; infinity if there is no hit.
    pub distance: f64,
    /// The point, in the frame of the beam.
    pub point: Point3<f64>,
    /// Unit surface normal on the side that faces the sensor, in the frame of the beam.
    pub normal: Vector3<f64>,
    /// Tag of the target. Among hits at the same distance, that with the lowest tag is returned, then that with the
    /// lowest primitive.
    pub object: u64,
    /// Index of the part of the form that was hit: the triangle of a mesh, or the face of a box (-x +x -y +y -z +z);
    /// for a cylinder or capsule 0 for the side, 1 for the end at +z and 2 for the end at -z; otherwise 0.
    pub primitive: u32,
}

impl Hit {
    /// The result if there is no hit: the distance is infinite, and all other fields are zero.
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
