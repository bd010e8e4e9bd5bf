//! Contact points of hulls and meshes.
//!
//! Parry truncates the face of a hull to its first four corners, so a prism with six sides would fall over. Rapier
//! solves at most four points of a manifold, and reduces more to four that depend on which is deepest. For a pair with
//! a hull or a mesh, contact points are therefore found here: `face` finds the face of a hull, `clip` clips two faces,
//! `spread` selects points that enclose as much of the face as possible, and `merge` writes them to manifolds of four
//! points. Only rapier's warm start, and the normals of forms that touch exactly, depend on previous steps. Everything
//! else is left to parry.

mod clip;
mod face;
mod merge;
mod spread;

use rapier3d::{
    geometry::{ContactData, ContactManifold, ContactManifoldData, Shape},
    math::{Pose, Real, Vector},
    parry::{
        query::{
            ClosestPoints, Contact, DefaultQueryDispatcher, NonlinearRigidMotion, PersistentQueryDispatcher,
            QueryDispatcher, ShapeCastHit, ShapeCastOptions, ShapeDistance, ShapeIntersection, Unsupported,
            details::{
                ContactManifoldsWorkspace, NormalConstraints, contact_manifolds_composite_shape_composite_shape,
                contact_manifolds_trimesh_shape_shapes,
            },
        },
        shape::ConvexPolyhedron,
    },
    pipeline::PhysicsWorld,
};

/// The dispatcher that finds contacts of hulls and meshes. It also discards the points of contacts with cylinders, for
/// the reason given in `refresh`.
struct ManifoldDispatcher;

/// Makes a world find its contacts with this module. It must be called again after the world is restored from a
/// snapshot.
pub(crate) fn install(world: &mut PhysicsWorld) {
    world.narrow_phase.set_query_dispatcher(ManifoldDispatcher.chain(DefaultQueryDispatcher));
    // `merge` does this for meshes; rapier would reduce the points of a large face to four.
    world.integration_parameters.contact_clustering = false;
}

/// Finds the contact faces of two shapes; `pos12` is the pose of the second in the frame of the first, and `guess` the
/// normal in the previous step in the frame of the first. Points that are farther apart than `prediction`, m, may be
/// missing. `manifolds` is replaced.
pub(crate) fn find(
    pos12: &Pose,
    [a, b]: [&dyn Shape; 2],
    prediction: f64,
    guess: Option<Vector>,
    manifolds: &mut Vec<ContactManifold>,
) {
    manifolds.clear();
    let has_parts = |shape| unwrapped(shape).as_composite_shape().is_some();
    if let Some(normal) = guess.filter(|_| !has_parts(a) && !has_parts(b)) {
        let mut manifold = ContactManifold::new();
        manifold.local_n1 = normal;
        manifolds.push(manifold);
    }
    let dispatcher = ManifoldDispatcher.chain(DefaultQueryDispatcher);
    if dispatcher.contact_manifolds(pos12, a, b, prediction, manifolds, &mut None).is_err() {
        manifolds.clear();
    }
    for manifold in manifolds {
        merge::reduce(&mut manifold.points, manifold.local_n1);
    }
}

/// Returns the shape itself, or the hull that `shapes` has wrapped in a compound.
fn unwrapped(shape: &dyn Shape) -> &dyn Shape {
    match shape.as_compound().map(|compound| compound.shapes()) {
        Some([(pose, part)]) if *pose == Pose::IDENTITY => &**part,
        _ => shape,
    }
}

/// Returns whether one of two shapes is a half-space and the local bounding box of the other one is farther from it than
/// `prediction`, m. A half-space has no bounding box, so every moving shape is a pair with each half-space in every step.
fn is_far_from_plane(pos12: &Pose, a: &dyn Shape, b: &dyn Shape, prediction: f64) -> bool {
    let (pose, plane, other) = match (a.as_halfspace(), b.as_halfspace()) {
        (Some(plane), None) => (*pos12, plane, b),
        (None, Some(plane)) => (pos12.inverse(), plane, a),
        _ => return false,
    };
    let bounds = other.compute_local_aabb();
    let up = pose.rotation.inverse() * plane.normal;
    let centre = bounds.center().dot(up) + pose.translation.dot(plane.normal);
    centre - bounds.half_extents().dot(up.abs()) > prediction
}

fn hull(shape: &dyn Shape) -> Option<&ConvexPolyhedron> {
    shape.as_convex_polyhedron()
}

impl PersistentQueryDispatcher<ContactManifoldData, ContactData> for ManifoldDispatcher {
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        a: &dyn Shape,
        b: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<ContactManifold>,
        _: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        if is_far_from_plane(pos12, a, b, prediction) {
            manifolds.iter_mut().for_each(|m| m.points.clear());
            return Ok(());
        }
        let (a, b) = (unwrapped(a), unwrapped(b));
        if a.as_trimesh().is_some() || b.as_trimesh().is_some() {
            let inner = ManifoldDispatcher.chain(DefaultQueryDispatcher);
            let (mut found, workspace) = (Vec::new(), &mut None);
            match (a.as_composite_shape(), b.as_composite_shape()) {
                (Some(a), Some(b)) => contact_manifolds_composite_shape_composite_shape(
                    &inner, pos12, a, b, prediction, &mut found, workspace,
                ),
                _ => contact_manifolds_trimesh_shape_shapes(&inner, pos12, a, b, prediction, &mut found, workspace),
            }
            merge::write(merge::join(found, prediction), manifolds);
            return Ok(());
        }
        if hull(a).is_some() || hull(b).is_some() {
            let mut found = ContactManifold::new();
            found.local_n1 = manifolds.first().map_or(Vector::ZERO, |m| m.local_n1);
            self.contact_manifold_convex_convex(pos12, a, b, None, None, prediction, &mut found)?;
            merge::write(vec![found], manifolds);
            return Ok(());
        }
        if a.as_cylinder().is_some() || b.as_cylinder().is_some() {
            manifolds.iter_mut().for_each(ContactManifold::mark_shapes_deformed);
        }
        Err(Unsupported)
    }

    /// Finds all points of a hull with another convex form or with a plane; points of other pairs are left to parry.
    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        a: &dyn Shape,
        b: &dyn Shape,
        limits_a: Option<&dyn NormalConstraints>,
        limits_b: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut ContactManifold,
    ) -> Result<(), Unsupported> {
        match (hull(a), hull(b)) {
            (None, None) => return Err(Unsupported),
            (Some(hull), _) if b.as_halfspace().is_some() => {
                let plane = b.as_halfspace().map_or(Vector::Z, |p| p.normal);
                face::on_plane(&pos12.inverse(), plane, hull, prediction, true, manifold);
            }
            (_, Some(hull)) if a.as_halfspace().is_some() => {
                let plane = a.as_halfspace().map_or(Vector::Z, |p| p.normal);
                face::on_plane(pos12, plane, hull, prediction, false, manifold);
            }
            _ => return clip::contacts(pos12, (a, limits_a), (b, limits_b), prediction, manifold),
        }
        Ok(())
    }
}

/// Other queries are left to parry.
impl QueryDispatcher for ManifoldDispatcher {
    fn intersection_test(&self, _: &Pose, _: &dyn Shape, _: &dyn Shape) -> Result<ShapeIntersection, Unsupported> {
        Err(Unsupported)
    }

    fn distance(&self, _: &Pose, _: &dyn Shape, _: &dyn Shape) -> Result<ShapeDistance, Unsupported> {
        Err(Unsupported)
    }

    fn contact(&self, _: &Pose, _: &dyn Shape, _: &dyn Shape, _: Real) -> Result<Option<Contact>, Unsupported> {
        Err(Unsupported)
    }

    fn closest_points(&self, _: &Pose, _: &dyn Shape, _: &dyn Shape, _: Real) -> Result<ClosestPoints, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes(
        &self,
        _: &Pose,
        _: Vector,
        _: &dyn Shape,
        _: &dyn Shape,
        _: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes_nonlinear(
        &self,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: Real,
        _: Real,
        _: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }
}
