//! Rapier's forms, shared by equal bodies.

use std::{collections::BTreeMap, sync::Arc};

use rapier3d::{geometry::SharedShape, math::Pose};
use tatu_geometry::{Form, Mesh};

use crate::convert;

/// Rapier's forms, so that a hundred equal robots share theirs: one hull to be made, and few lines of memory to be read.
#[derive(Default)]
pub(super) struct ShapeCache {
    meshes: Vec<(Arc<Mesh>, bool, SharedShape)>,
    /// By what they are and their sizes, bit by bit.
    pub(super) primitives: BTreeMap<[u64; 4], (SharedShape, Pose)>,
}

/// Points of a hull up to which its box in the world is found from them all.
const FEW_POINTS: usize = 24;

/// A hull of many points, in a box that turns with it: rapier asks each point of a hull for its box in the world, in each step
/// and wherever it is, and of a compound the box alone. What touches is found from the hull as before.
fn boxed(shape: SharedShape) -> SharedShape {
    match shape.as_convex_polyhedron().is_some_and(|hull| hull.points().len() > FEW_POINTS) {
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
        // Meshes that nobody else holds any more cannot be asked for again.
        self.meshes.retain(|(m, _, _)| Arc::strong_count(m) > 1);
        let (shape, pose) = convert::shape(form)?;
        let shape = boxed(shape);
        self.meshes.push((mesh.clone(), convex, shape.clone()));
        Some((shape, pose))
    }

    fn primitive(&mut self, key: [u64; 4], form: &Form) -> Option<(SharedShape, Pose)> {
        if let Some(known) = self.primitives.get(&key) {
            return Some(known.clone());
        }
        // Those that nobody uses any more go whenever their number would double.
        if self.primitives.len().is_power_of_two() {
            self.primitives.retain(|_, (shape, _)| Arc::strong_count(&shape.0) > 1);
        }
        let new = convert::shape(form)?;
        self.primitives.insert(key, new.clone());
        Some(new)
    }
}
