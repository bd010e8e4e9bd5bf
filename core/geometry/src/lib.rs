//! Solid forms, shared by physics, beams and the scene.
//!
//! Lengths are metres, in the form's own frame; V-REP's conventions: z is up, the axis of a cylinder is z.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};

/// A triangle mesh. Vertices in metres; triangles wind counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Corner points.
    pub vertices: Vec<Point3<f64>>,
    /// Three indices into `vertices` per triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// One solid form.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// The half space z <= 0; its surface is the plane z = 0, facing +z.
    Plane,
    /// A box around the origin.
    Box {
        /// Half of the edge lengths.
        half: Vector3<f64>,
    },
    /// A ball around the origin.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A cylinder around the z axis, centred at the origin.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Half of the length along z.
        half_length: f64,
    },
    /// A cylinder with half balls at its ends, along z, centred at the origin.
    Capsule {
        /// Radius of the cylinder and of the balls.
        radius: f64,
        /// Half of the length of the straight part.
        half_length: f64,
    },
    /// A surface of triangles. For physics a `convex` one is solid, any other is hollow.
    Mesh {
        /// The triangles; shared between copies.
        mesh: Arc<Mesh>,
        /// Whether the mesh is its own convex hull.
        convex: bool,
    },
}

/// A form and its place in the frame of what it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Part to owner.
    pub pose: Isometry3<f64>,
    /// The form.
    pub form: Form,
    /// Friction coefficient, if not its owner's.
    pub friction: Option<f64>,
    /// Red, green and blue, 0 to 1, if not its owner's.
    pub color: Option<[f64; 3]>,
}

/// An angle in (-pi, pi], whatever its size; rad.
pub fn wrap_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let wrapped = angle % TAU;
    match wrapped {
        w if w > PI => w - TAU,
        w if w <= -PI => w + TAU,
        w => w,
    }
}
