//! Forces the contacts of cylinders and of small forms to be recomputed in every step.
//!
//! Parry keeps the points of a contact until the two bodies have rotated by 1 degree, and rapier keeps them longer if
//! the smaller body has hardly moved. On the curved side of a cylinder, the points rotate with it: the floor then
//! pushes behind the axle, and a can that rolls at 0.02 m/s is accelerated to 0.17 m/s, as if it rolled down a slope of
//! half a degree. `faces` therefore discards the points of cylinders in every step in which it is called.
//!
//! For any two forms, rapier keeps the points until one has moved by 5 cm relative to the other. This distance is too
//! large for the pad of a gripper: a pad continued to press with 150 N on a cube that it had released, and that was 15
//! mm away.

use rapier3d::pipeline::ActiveHooks;
use tatu_geometry::{Form, Mesh};

/// Maximum extent of a small form, m: 1.6 times the distance that bodies can move before rapier updates their contacts.
const MAX_SMALL_EXTENT: f64 = 0.08;

/// Returns a hook that prevents rapier from reusing contacts over several steps, because rapier does this only for
/// colliders without hooks. The hook itself is called only for sensor colliders, which this engine does not use.
pub(crate) fn required_hooks(form: &Form) -> ActiveHooks {
    let is_small = match form {
        Form::Plane => false,
        Form::Box { half } => 2.0 * half.max() < MAX_SMALL_EXTENT,
        Form::Sphere { radius } => 2.0 * radius < MAX_SMALL_EXTENT,
        Form::Cylinder { .. } => true,
        Form::Capsule { radius, half_length } => 2.0 * (radius + half_length) < MAX_SMALL_EXTENT,
        Form::Mesh { mesh, .. } => extent(mesh) < MAX_SMALL_EXTENT,
    };
    if is_small { ActiveHooks::FILTER_INTERSECTION_PAIR } else { ActiveHooks::empty() }
}

/// Returns the greatest extent of a mesh along an axis, m.
fn extent(mesh: &Mesh) -> f64 {
    let ends = (0..3).map(|axis| {
        let along = mesh.vertices.iter().map(|p| p[axis]);
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    });
    ends.fold(0.0, f64::max)
}
