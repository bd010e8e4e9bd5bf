//! The rules by which the engine's bodies and joints are created from the tree of objects.

use tatu_physics::MotionType;

use super::{ObjectVariant, Scene};

/// Returns how a shape's body moves, or `None` if it needs no body. A shape that is neither dynamic nor respondable
/// needs a body only if a joint or force sensor connects a dynamic shape to it.
pub(super) fn motion_of(scene: &Scene, slot: u32) -> Option<MotionType> {
    let shape = scene.get(slot)?.shape()?;
    match shape.dynamic {
        true => Some(MotionType::Dynamic),
        false if !shape.respondable && !carries_tie(scene, slot) => None,
        false if is_carried(scene, slot) => Some(MotionType::Kinematic),
        false => Some(MotionType::Static),
    }
}

/// Returns the shape that a dynamic shape is connected to, and the dynamic joint or unbroken force sensor between them.
/// Returns `None` if there is no such connection.
pub(super) fn tie_of(scene: &Scene, slot: u32) -> Option<(u32, u32)> {
    let child = scene.get(slot)?;
    if !child.shape()?.dynamic {
        return None;
    }
    let tie = scene.get(child.parent)?;
    match &tie.data {
        ObjectVariant::Joint(j) if j.dynamic => {}
        ObjectVariant::ForceSensor(f) if !f.broken => {}
        _ => return None,
    }
    scene.get(tie.parent)?.shape()?;
    Some((tie.parent, child.parent))
}

fn carries_tie(scene: &Scene, slot: u32) -> bool {
    scene
        .children(slot)
        .iter()
        .any(|tie| scene.children(*tie).iter().any(|c| tie_of(scene, *c).is_some_and(|(above, _)| above == slot)))
}

/// Returns whether an object is a shape with axis, rolling or spinning friction.
pub(super) fn has_special_surface(scene: &Scene, slot: u32) -> bool {
    scene.get(slot).and_then(|o| o.shape()).is_some_and(|s| s.surface.is_special())
}

/// Returns whether an object can be moved by one of its ancestors, that is by a joint or a dynamic shape.
pub(super) fn is_carried(scene: &Scene, slot: u32) -> bool {
    let mut at = scene.get(slot).map_or(0, |o| o.parent);
    while let Some(o) = scene.get(at) {
        if matches!(&o.data, ObjectVariant::Joint(_)) || o.shape().is_some_and(|s| s.dynamic) {
            return true;
        }
        at = o.parent;
    }
    false
}

/// Returns the topmost shape among an object and its ancestors, which identifies its tree, or the object itself if
/// none of them is a shape.
pub(super) fn top_shape(scene: &Scene, slot: u32) -> u32 {
    let (mut at, mut top) = (slot, slot);
    while let Some(o) = scene.get(at) {
        if o.shape().is_some() {
            top = at;
        }
        at = o.parent;
    }
    top
}
