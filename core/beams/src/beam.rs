//! What is cast and what comes back.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Point3, Vector3};

/// The space a beam searches, in its own frame, looking along +z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Volume {
    /// The half line along +z: the first surface it meets.
    Ray,
    /// A ball sector: the nearest surface point at most `half_angle` off +z.
    Cone {
        /// Half of the opening, in radians; 0 to pi, also beyond pi/2.
        half_angle: f64,
    },
    /// A frustum between two rectangles square to +z, whose middles are on it: the beam's near and far are their
    /// heights. All points in it count, however far from the origin.
    Pyramid {
        /// Full size of the near end along x, in metres.
        x_near: f64,
        /// Full size of the near end along y.
        y_near: f64,
        /// Full size of the far end along x.
        x_far: f64,
        /// Full size of the far end along y.
        y_far: f64,
    },
    /// A round frustum around +z: the beam's near and far are the heights of its flat ends.
    Cylinder {
        /// Radius of the near end, in metres.
        radius_near: f64,
        /// Radius of the far end.
        radius_far: f64,
    },
    /// A flat sector: directions whose angle from +z towards +x or -x, in the plane of x and z, is at most half of
    /// `angle`, no farther than half of `height` from that plane. Near and far are distances from the origin.
    Disc {
        /// The full opening, in radians; a full turn is seen all around.
        angle: f64,
        /// The thickness along y, in metres.
        height: f64,
        /// The opening around +z that is left out, in radians; 0 for none.
        gap: f64,
    },
}

/// The sides of a surface that are seen. The front is the outside of a solid form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Faces {
    /// Surfaces that show their outside.
    pub front: bool,
    /// Surfaces that show their inside.
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

/// One question to a [`BeamScene`](super::BeamScene).
///
/// A surface point counts when it lies in the volume, at a distance from `near` to `far`, shows a side in `faces`
/// and meets the line of sight at no more than `max_incidence`. Surfaces do not hide one another from a volume:
/// its answer is the nearest point that counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Origin and direction (+z) of the beam.
    pub world_from_beam: Isometry3<f64>,
    /// The space searched.
    pub volume: Volume,
    /// Least distance from the origin, in metres; for a pyramid or cylinder the height of its near end.
    pub near: f64,
    /// Greatest distance from the origin, in metres: a ball around the origin, not a plane, but for a pyramid or
    /// cylinder, where it is the height of the far end.
    pub far: f64,
    /// Greatest angle between the surface normal and the line of sight, in radians; pi/2 or more is no limit.
    pub max_incidence: f64,
    /// Sides seen.
    pub faces: Faces,
    /// A group that is passed over, such as the model that carries the sensor.
    pub skip_group: Option<u32>,
    /// The one object that is looked for; the others neither count nor hide it.
    pub only_object: Option<u64>,
}

impl Beam {
    /// A ray to `far` metres, with both sides seen and no other limit.
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

    /// A cone of `half_angle` radians to `far` metres, with both sides seen and no other limit.
    pub fn cone(world_from_beam: Isometry3<f64>, half_angle: f64, far: f64) -> Self {
        Self { volume: Volume::Cone { half_angle }, ..Self::ray(world_from_beam, far) }
    }
}

/// The nearest point a beam sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// From the beam's origin to the point, in metres; infinity when nothing is seen.
    pub distance: f64,
    /// The point, in the beam's frame.
    pub point: Point3<f64>,
    /// The surface normal on the side of the sensor, in the beam's frame; of length 1.
    pub normal: Vector3<f64>,
    /// The tag of the target. Between equal distances the lowest tag wins, then the lowest primitive.
    pub object: u64,
    /// The place on the form: a mesh's triangle; a box's face (-x +x -y +y -z +z); of a cylinder or capsule
    /// 0 the side, 1 the end at +z, 2 the end at -z; else 0.
    pub primitive: u32,
}

impl Hit {
    /// Nothing seen. The other fields are zero.
    pub const NONE: Self = Self {
        distance: f64::INFINITY,
        point: Point3::new(0.0, 0.0, 0.0),
        normal: Vector3::new(0.0, 0.0, 0.0),
        object: 0,
        primitive: 0,
    };

    /// Whether something is seen.
    pub fn is_some(&self) -> bool {
        self.distance < f64::INFINITY
    }
}
