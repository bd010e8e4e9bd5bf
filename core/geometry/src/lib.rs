//! Solid forms, shared by physics, beams and the scene.
//!
//! Lengths are in metres, in the frame of the form. V-REP's conventions apply: z is up, and the axis of a cylinder is
//! z.

mod texture;

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};

pub use texture::{BLENDS, Blend, Image, MAPPINGS, MOST_PIXELS, Mapping, Projection, Texture};

/// A triangle mesh. Vertices are in metres; triangles wind counter-clockwise as seen from outside.
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
    /// The half-space z <= 0; its surface is the plane z = 0, facing +z.
    Plane,
    /// A box centred at the origin.
    Box {
        /// Half of the edge lengths, in metres.
        half: Vector3<f64>,
    },
    /// A sphere centred at the origin.
    Sphere {
        /// Radius, in metres.
        radius: f64,
    },
    /// A cylinder around the z axis, centred at the origin.
    Cylinder {
        /// Radius, in metres.
        radius: f64,
        /// Half of the length along z, in metres.
        half_length: f64,
    },
    /// A cylinder along z with hemispheres at its ends, centred at the origin.
    Capsule {
        /// Radius of the cylinder and of the hemispheres, in metres.
        radius: f64,
        /// Half of the length of the straight part, in metres.
        half_length: f64,
    },
    /// A triangle mesh. In physics, a `convex` mesh is solid, and any other mesh is hollow.
    Mesh {
        /// The triangles, shared between copies.
        mesh: Arc<Mesh>,
        /// Whether the mesh is its own convex hull.
        convex: bool,
    },
}

/// A form and its pose in the frame of its owner.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Transform from the part to the owner.
    pub pose: Isometry3<f64>,
    /// The form.
    pub form: Form,
    /// Friction coefficient; `None`: that of the owner.
    pub friction: Option<f64>,
    /// Red, green and blue, each 0 to 1; `None`: the colour of the owner.
    pub color: Option<[f64; 3]>,
    /// The image on it, in its frame.
    pub texture: Option<Arc<Texture>>,
}

/// Returns an angle wrapped to (-pi, pi], in radians.
pub fn wrap_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let wrapped = angle % TAU;
    match wrapped {
        w if w > PI => w - TAU,
        w if w <= -PI => w + TAU,
        w => w,
    }
}
