//! Parts of compounds.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_geometry::Mesh;

use super::Primitive;
use crate::texture::ShapeTexture;

/// A part of a compound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapePart {
    /// Form of the part.
    pub primitive: Primitive,
    /// Full extents, m.
    pub size: Vector3<f64>,
    /// Pose in the shape's frame.
    pub pose: Isometry3<f64>,
    /// Red, green and blue, each 0 to 1, if the colour differs from the shape's.
    pub color: Option<[f64; 3]>,
    /// Opacity, from 0 (invisible) to 1, if it differs from the shape's.
    pub opacity: Option<f64>,
    /// Texture, if it differs from the shape's.
    pub texture: Option<ShapeTexture>,
    /// Friction coefficient, if it differs from the shape's.
    pub friction: Option<f64>,
    /// Number of the part's mesh in the document, from 1; 0 if the part is not a mesh.
    pub mesh_number: u32,
    /// The mesh with this number; not stored in snapshots.
    #[serde(skip)]
    pub mesh: Option<Arc<Mesh>>,
    /// Whether the convex hull of the mesh replaces the mesh.
    pub convex: bool,
}
