//! Rays and cones prepared for intersection tests, and their hits.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Point3, Vector3};

use super::beam::Faces;

/// The common part of rays and volumes.
#[derive(Debug, Clone, Copy)]
pub(super) struct SightLine {
    pub origin: Point3<f64>,
    /// Direction of the beam, a unit vector.
    pub axis: Vector3<f64>,
    pub near: f64,
    /// Maximum distance, inclusive, which is lowered to the nearest hit so far.
    pub far: f64,
    /// Cosine of the maximum incidence; 0 means no limit.
    pub cos_incidence: f64,
    pub faces: Faces,
}

/// A cone with its apex at the origin of its sight.
#[derive(Debug, Clone, Copy)]
pub(super) struct BeamCone {
    pub sight: SightLine,
    pub half_angle: f64,
    pub cos: f64,
    pub sin: f64,
}

/// A hit, relative to the origin of the sight. The normal is the outward normal of the form.
#[derive(Debug, Clone, Copy)]
pub(super) struct FormHit {
    pub distance: f64,
    pub point: Vector3<f64>,
    pub normal: Vector3<f64>,
    pub primitive: u32,
}

impl FormHit {
    /// Returns the nearer of two hits or, if they are equally near, the one with the lower primitive.
    pub fn nearer(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        match (a, b) {
            (Some(x), Some(y)) => Some(if (y.distance, y.primitive) < (x.distance, x.primitive) { y } else { x }),
            (a, b) => a.or(b),
        }
    }
}

impl SightLine {
    /// Returns the sight in a form's frame, limited to `far`.
    pub fn in_form(&self, world_from_form: &Isometry3<f64>, far: f64) -> Self {
        Self {
            origin: world_from_form.inverse_transform_point(&self.origin),
            axis: world_from_form.inverse_transform_vector(&self.axis),
            far,
            ..*self
        }
    }

    /// Returns whether the side of a flat face that faces the origin is detected; `h` is the signed height of the face,
    /// positive if the origin is behind it.
    pub fn sees_side(&self, h: f64) -> bool {
        (h <= 0.0 && self.faces.front) || (h >= 0.0 && self.faces.back)
    }

    /// Returns the maximum distance at which a point of a plane at `height` is admissible.
    ///
    /// On a plane, the cosine of the incidence is height divided by distance, so the incidence limit is a distance
    /// limit.
    pub fn reach(&self, height: f64) -> f64 {
        if self.cos_incidence > 0.0 { self.far.min(height / self.cos_incidence) } else { self.far }
    }
}

impl BeamCone {
    pub fn new(sight: SightLine, half_angle: f64) -> Self {
        let half_angle = half_angle.clamp(0.0, PI);
        Self { sight, half_angle, cos: libm::cos(half_angle), sin: libm::sin(half_angle) }
    }

    /// Returns the cone in a form's frame, limited to `far`.
    pub fn in_form(&self, world_from_form: &Isometry3<f64>, far: f64) -> Self {
        Self { sight: self.sight.in_form(world_from_form, far), ..*self }
    }

    /// Returns whether the cone is wider than a half-space, and therefore not convex.
    pub fn is_wide(&self) -> bool {
        self.half_angle > FRAC_PI_2
    }

    /// Returns whether the direction of `p` is in the cone, which includes the apex.
    pub fn contains(&self, p: &Vector3<f64>) -> bool {
        let along = self.sight.axis.dot(p);
        if !self.is_wide() && along < 0.0 {
            return false;
        }
        // The test sin(half_angle - angle) >= 0 is accurate near the surface of the cone, unlike a comparison of
        // cosines.
        self.excess(along, (p - self.sight.axis * along).norm()) >= 0.0 || self.half_angle >= PI - 1e-12
    }

    /// Returns the signed distance from the cone's surface, positive inside, for a point `along` the axis and `across`
    /// it.
    pub fn excess(&self, along: f64, across: f64) -> f64 {
        self.sin * along - self.cos * across
    }

    /// Returns whether a ball certainly misses the cone.
    pub fn misses_ball(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        let along = self.sight.axis.dot(centre);
        let across = (centre - self.sight.axis * along).norm();
        // For points behind a convex cone, the apex is its nearest point.
        if !self.is_wide() && along * self.cos + across * self.sin < 0.0 {
            return along * along + across * across > radius * radius;
        }
        self.excess(along, across) < -radius
    }
}
