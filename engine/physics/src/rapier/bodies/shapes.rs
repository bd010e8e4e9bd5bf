//! Rapier's shapes, shared by bodies with equal forms.

use std::{collections::BTreeMap, sync::Arc};

use rapier3d::{geometry::SharedShape, math::Pose};
use tatu_geometry::{Form, Mesh};

use crate::convert;

/// A cache of rapier's shapes. A hundred equal robots share their shapes, so each hull is computed once and less memory
/// is read.
#[derive(Default)]
pub(crate) struct ShapeCache {
    meshes: Vec<(Arc<Mesh>, bool, SharedShape)>,
    /// Primitives, by kind and the bits of their sizes.
    pub(crate) primitives: BTreeMap<[u64; 4], (SharedShape, Pose)>,
}

/// Maximum number of points of a hull whose world bounding box is computed from all points.
const MAX_UNBOXED_POINTS: usize = 24;

/// Wraps a hull of many points in a compound. For a hull, rapier computes the world bounding box from all points in
/// every step; for a compound, it transforms the local box. Contacts are computed from the hull as before.
fn wrap_large_hull(shape: SharedShape) -> SharedShape {
    match shape.as_convex_polyhedron().is_some_and(|hull| hull.points().len() > MAX_UNBOXED_POINTS) {
        true => SharedShape::compound(vec![(Pose::IDENTITY, shape)]),
        false => shape,
    }
}

impl ShapeCache {
    pub fn shape(&mut self, form: &Form) -> Option<(SharedShape, Pose)> {
        match form {
            Form::Mesh { mesh, convex } => self.mesh(mesh, *convex, form),
            Form::Plane => self.primitive([0; 4], form),
            Form::Box { half } => self.primitive([1, half.x.to_bits(), half.y.to_bits(), half.z.to_bits()], form),
            Form::Sphere { radius } => self.primitive([2, radius.to_bits(), 0, 0], form),
            Form::Cylinder { radius, half_length } => {
                self.primitive([3, radius.to_bits(), half_length.to_bits(), 0], form)
            }
            Form::Capsule { radius, half_length } => {
                self.primitive([4, radius.to_bits(), half_length.to_bits(), 0], form)
            }
        }
    }

    fn mesh(&mut self, mesh: &Arc<Mesh>, convex: bool, form: &Form) -> Option<(SharedShape, Pose)> {
        let known = self.meshes.iter().find(|(m, c, _)| Arc::ptr_eq(m, mesh) && *c == convex);
        if let Some((_, _, shape)) = known {
            return Some((shape.clone(), Pose::IDENTITY));
        }
        // A mesh that is no longer used elsewhere cannot be requested again, because meshes are compared by address.
        self.meshes.retain(|(m, _, _)| Arc::strong_count(m) > 1);
        let (shape, pose) = convert::shape(form)?;
        let shape = wrap_large_hull(shape);
        self.meshes.push((mesh.clone(), convex, shape.clone()));
        Some((shape, pose))
    }

    fn primitive(&mut self, key: [u64; 4], form: &Form) -> Option<(SharedShape, Pose)> {
        if let Some(known) = self.primitives.get(&key) {
            return Some(known.clone());
        }
        // Unused primitives are dropped whenever the number of primitives reaches a power of two.
        if self.primitives.len().is_power_of_two() {
            self.primitives.retain(|_, (shape, _)| Arc::strong_count(&shape.0) > 1);
        }
        let new = convert::shape(form)?;
        self.primitives.insert(key, new.clone());
        Some(new)
    }
}
