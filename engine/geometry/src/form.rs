//! Solid forms.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

/// A triangle mesh. Vertices are in metres; triangles wind counter-clockwise as seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Corner points of the triangles.
    pub vertices: Vec<Point3<f64>>,
    /// Three indices into `vertices` per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of each vertex, for `TextureMapping::Mesh`: right and up, each 0 to 1 inside the image.
    /// Empty if the mesh has no texture coordinates.
    pub coordinates: Vec<[f32; 2]>,
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
