//! Data that is computed once from the form of a shape, and discarded when the form changes.

use std::sync::{Arc, OnceLock};

use nalgebra::{Isometry3, Vector3};
use tatu_geometry::{Mesh, Moments};

use super::primitive::Primitive;

/// A part of a shape as a solid of uniform density.
#[derive(Debug, Clone)]
pub(crate) struct MassLump {
    /// Pose in the shape's frame.
    pub pose: Isometry3<f64>,
    pub solid: LumpForm,
    /// Volume, m^3; 0 for planes and flat meshes.
    pub volume: f64,
    /// Number of open edges of a mesh whose hull replaces it because it is not closed.
    pub open: usize,
}

/// The form of a lump.
#[derive(Debug, Clone)]
pub(crate) enum LumpForm {
    /// A primitive with its full extents, m.
    Primitive(Primitive, Vector3<f64>),
    /// A mesh.
    Mesh(Moments),
}

/// The parts of a shape as solids, and the centroid of all.
#[derive(Debug, Clone)]
pub(crate) struct MassDistribution {
    pub lumps: Vec<MassLump>,
    /// Centroid in the shape's frame, m.
    pub centre: Vector3<f64>,
}

/// Data derived from the form of a shape. Setting a property that the form depends on discards it.
#[derive(Debug, Clone, Default)]
pub struct DerivedGeometry {
    pub(crate) mass_distribution: OnceLock<MassDistribution>,
    /// The meshes of spheres whose extents differ, with the extents.
    pub(crate) ellipsoids: OnceLock<Vec<(Vector3<f64>, Arc<Mesh>)>>,
}
