//! Rays and cones made ready for the geometry, and what they find.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Point3, Vector3};

use super::beam::Faces;

/// What rays and volumes share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    pub origin: Point3<f64>,
    /// Of length 1.
    pub axis: Vector3<f64>,
    pub near: f64,
    /// Also lowered to the best distance so far; points at this very distance still count.
    pub far: f64,
    /// Cosine of the greatest incidence; 0 when there is no limit.
    pub cos_incidence: f64,
    pub faces: Faces,
}

/// A cone with its apex at the sight's origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cone {
    pub sight: Sight,
    pub half_angle: f64,
    pub cos: f64,
    pub sin: f64,
}

/// A point seen, relative to the sight's origin; the normal is the form's outward one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub distance: f64,
    pub point: Vector3<f64>,
    pub normal: Vector3<f64>,
    pub primitive: u32,
}

impl Found {
    /// The nearer of two, the lower primitive between equals.
    pub fn nearer(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        match (a, b) {
            (Some(x), Some(y)) => Some(if (y.distance, y.primitive) < (x.distance, x.primitive) { y } else { x }),
            (a, b) => a.or(b),
        }
    }
}

impl Sight {
    /// The same sight in a form's frame, looking no further than `far`.
    pub fn in_form(&self, world_from_form: &Isometry3<f64>, far: f64) -> Self {
        Self {
            origin: world_from_form.inverse_transform_point(&self.origin),
            axis: world_from_form.inverse_transform_vector(&self.axis),
            far,
            ..*self
        }
    }

    /// Whether a flat face at signed height `h` (positive: the sight's origin is behind it) shows a wanted side.
    pub fn sees_side(&self, h: f64) -> bool {
        (h <= 0.0 && self.faces.front) || (h >= 0.0 && self.faces.back)
    }

    /// The greatest distance at which a point of a plane at `height` still counts.
    ///
    /// On one plane the cosine of the incidence is height over distance, so the incidence limit is a distance limit.
    pub fn reach(&self, height: f64) -> f64 {
        if self.cos_incidence > 0.0 { self.far.min(height / self.cos_incidence) } else { self.far }
    }
}

impl Cone {
    pub fn new(sight: Sight, half_angle: f64) -> Self {
        let half_angle = half_angle.clamp(0.0, PI);
        Self { sight, half_angle, cos: libm::cos(half_angle), sin: libm::sin(half_angle) }
    }

    /// The same cone in a form's frame, looking no further than `far`.
    pub fn in_form(&self, world_from_form: &Isometry3<f64>, far: f64) -> Self {
        Self { sight: self.sight.in_form(world_from_form, far), ..*self }
    }

    /// Whether the cone is more than a half space, and so not convex.
    pub fn wide(&self) -> bool {
        self.half_angle > FRAC_PI_2
    }

    /// Whether the direction of `p` lies in the cone. The apex itself does.
    pub fn contains(&self, p: &Vector3<f64>) -> bool {
        let along = self.sight.axis.dot(p);
        if !self.wide() && along < 0.0 {
            return false;
        }
        // sin(half_angle - angle) >= 0, which loses no digits near the edge, unlike a comparison of cosines.
        self.excess(along, (p - self.sight.axis * along).norm()) >= 0.0 || self.half_angle >= PI - 1e-12
    }

    /// Positive inside the cone: the distance to its surface, for a point `along` the axis and `across` it.
    pub fn excess(&self, along: f64, across: f64) -> f64 {
        self.sin * along - self.cos * across
    }

    /// Whether a ball misses the cone for certain.
    pub fn misses_ball(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        let along = self.sight.axis.dot(centre);
        let across = (centre - self.sight.axis * along).norm();
        // Behind a convex cone the apex is its nearest point.
        if !self.wide() && along * self.cos + across * self.sin < 0.0 {
            return along * along + across * across > radius * radius;
        }
        self.excess(along, across) < -radius
    }
}
