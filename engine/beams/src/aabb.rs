//! Axis-aligned bounding boxes.

use nalgebra::{Isometry3, Vector3};
use tatu_geometry::Form;

/// An axis-aligned bounding box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Aabb {
    pub low: Vector3<f64>,
    pub high: Vector3<f64>,
}

/// Tolerance added to every bound, in metres. It is far greater than rounding errors, but too small to slow the search.
pub(super) const BOX_TOLERANCE_M: f64 = 1e-9;

/// Returns the minimum and the maximum coordinates of a form in the world frame, or `None` if the form is unbounded or
/// its coordinates are not finite.
pub fn bounds(form: &Form, pose: &Isometry3<f64>) -> Option<[Vector3<f64>; 2]> {
    let around = Aabb::of_form(form, pose).filter(Aabb::is_valid)?;
    Some([around.low, around.high])
}

impl Aabb {
    pub const EMPTY: Self = Self {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub fn of_points<'a>(points: impl IntoIterator<Item = &'a Vector3<f64>>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { low: b.low.inf(p), high: b.high.sup(p) })
    }

    pub fn merge(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Returns the bounding box of a form in the world frame, or `None` for an unbounded form.
    pub fn of_form(form: &Form, pose: &Isometry3<f64>) -> Option<Self> {
        let rotation = pose.rotation.to_rotation_matrix();
        let rotation = rotation.matrix();
        let centre = pose.translation.vector;
        let along = rotation.column(2).abs();
        let (centre, half) = match form {
            Form::Plane => return None,
            Form::Box { half } => (centre, rotation.abs() * half),
            Form::Sphere { radius } => (centre, Vector3::repeat(*radius)),
            Form::Capsule { radius, half_length } => (centre, (along * *half_length).add_scalar(*radius)),
            Form::Cylinder { radius, half_length } => {
                let across = along.map(|x| (1.0 - x * x).max(0.0).sqrt());
                (centre, along * *half_length + across * *radius)
            }
            Form::Mesh { mesh, .. } => {
                let own = Self::of_points(mesh.vertices.iter().map(|p| &p.coords));
                return Some(own.transformed(pose));
            }
        };
        Some(Self { low: centre - half, high: centre + half })
    }

    /// Returns a box that contains this one after a rigid motion.
    pub fn transformed(&self, pose: &Isometry3<f64>) -> Self {
        let centre = pose * nalgebra::Point3::from((self.low + self.high) * 0.5);
        let half = pose.rotation.to_rotation_matrix().matrix().abs() * ((self.high - self.low) * 0.5);
        Self { low: centre.coords - half, high: centre.coords + half }
    }

    /// Returns whether the box is non-empty and has finite corners.
    pub fn is_valid(&self) -> bool {
        (0..3).all(|i| self.low[i] <= self.high[i] && self.low[i].is_finite() && self.high[i].is_finite())
    }

    pub fn centre(&self) -> Vector3<f64> {
        (self.low + self.high) * 0.5
    }

    /// Returns the estimated cost of testing `items` items in this box.
    pub fn cost(&self, items: usize) -> f64 {
        if items == 0 { 0.0 } else { self.area() * items as f64 }
    }

    pub fn area(&self) -> f64 {
        let size = self.high - self.low;
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}
