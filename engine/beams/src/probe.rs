//! A beam prepared for intersection tests, in the frame of the form it is tested against.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Vector3};

use super::{
    beam::{Beam, Volume},
    convex::ConvexVolume,
    sight::{BeamCone, SightLine},
};

/// A beam as one of the shapes that the intersection tests support.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "probes live on the stack one at a time, and small ones are created most often"
)]
pub(super) enum Probe {
    Ray(SightLine),
    Cone(BeamCone),
    Convex(ConvexVolume),
}

/// Minimum half angle of a cone, in radians; a narrower cone is treated as a ray.
const MIN_CONE_HALF_ANGLE: f64 = 1e-9;

impl Probe {
    /// Returns one piece of the beam in the world frame, or `None` if its limits exclude everything.
    pub fn new(beam: &Beam, piece: usize) -> Option<Self> {
        // At a right angle or more there is no limit. Just below a right angle, the cosine is still positive.
        let cos_incidence = if beam.max_incidence < FRAC_PI_2 { libm::cos(beam.max_incidence.max(0.0)) } else { 0.0 };
        let sight = SightLine {
            origin: beam.world_from_beam.translation.vector.into(),
            axis: beam.world_from_beam.rotation * Vector3::z(),
            near: beam.near.max(0.0),
            far: beam.far,
            cos_incidence,
            faces: beam.faces,
        };
        if sight.near > sight.far || sight.far.is_nan() {
            return None;
        }
        match beam.volume {
            Volume::Ray => Some(Self::Ray(sight)),
            Volume::Cone { half_angle } if half_angle < MIN_CONE_HALF_ANGLE => Some(Self::Ray(sight)),
            Volume::Cone { half_angle } => Some(Self::Cone(BeamCone::new(sight, half_angle))),
            Volume::Pyramid { .. } | Volume::Cylinder { .. } | Volume::Disc { .. } => {
                let space = ConvexVolume::new(&sight, &beam.volume, piece)?;
                Some(Self::Convex(space.rotated(|v| beam.world_from_beam.rotation * v)))
            }
        }
    }

    /// Returns the probe in the frame of a form, limited to the distance `far`.
    pub fn in_form(&self, world_from_form: &Isometry3<f64>, far: f64) -> Self {
        match self {
            Self::Ray(sight) => Self::Ray(sight.in_form(world_from_form, far)),
            Self::Cone(cone) => Self::Cone(cone.in_form(world_from_form, far)),
            Self::Convex(space) => Self::Convex(space.in_form(world_from_form, far)),
        }
    }

    /// Returns the maximum distance at which surfaces are searched for.
    pub fn far(&self) -> f64 {
        match self {
            Self::Ray(sight) => sight.far,
            Self::Cone(cone) => cone.sight.far,
            Self::Convex(space) => space.sight.far,
        }
    }
}
