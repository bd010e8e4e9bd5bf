//! Warnings about scenes that physics probably simulates differently than intended: meshes that enclose no volume,
//! spheres that are ellipsoids, solvers that are not used, and dynamic shapes below kinematic joints.

use std::collections::BTreeMap;

use super::state::Dynamics;
use crate::{
    forms::ellipsoids,
    mass_properties::open_edges,
    notices::NoticeKind,
    object::{ObjectVariant, Shape},
    tree::Scene,
};

impl Dynamics {
    /// Adds the warnings about all objects of a scene. `unused` pairs each shape whose `joint_solver` has no effect
    /// with the shape whose `joint_solver` applies instead.
    pub(super) fn warn(&mut self, scene: &Scene, unused: &[(u32, u32)]) {
        // Equal warnings are merged, so a hundred equal objects cause a single message.
        let mut found: BTreeMap<(NoticeKind, String), Vec<u32>> = BTreeMap::new();
        for (slot, o) in scene.slots() {
            let ObjectVariant::Shape(shape) = &o.data else { continue };
            for (notice, why) in
                [open_mesh(shape), ellipsoid(shape), kinematic_joint(scene, slot, shape)].into_iter().flatten()
            {
                if self.notices.is_new(notice, o.uid) {
                    found.entry((notice, why)).or_default().push(slot);
                }
            }
        }
        for (slot, root) in unused {
            let Some(o) = scene.get(*slot) else { continue };
            if self.notices.is_new(NoticeKind::Solver, o.uid) {
                let why = format!(
                    "its `joint_solver` is not used, because a mechanism has one solver, and `{}` sets another for the \
                     same mechanism; set it there",
                    scene.path(*root)
                );
                found.entry((NoticeKind::Solver, why)).or_default().push(*slot);
            }
        }
        for ((_, why), slots) in found {
            let others = if slots.len() > 1 { format!(" (and {} more)", slots.len() - 1) } else { String::new() };
            self.notices.add(format!("`{}`{others}: {why}", scene.path(slots[0])));
        }
    }
}

fn open_mesh(shape: &Shape) -> Option<(NoticeKind, String)> {
    if !shape.dynamic || open_edges(shape) == 0 {
        return None;
    }
    let lacking = [("mass", shape.mass.is_none()), ("centre of mass", shape.com.is_none())];
    let lacking = lacking.into_iter().chain([("inertia", shape.inertia.is_none())]);
    let names: Vec<&str> = lacking.filter(|(_, lacks)| *lacks).map(|(name, _)| name).collect();
    let text = format!(
        "its mesh is not closed (edges without a second triangle, or triangles that face opposite ways), so its {} \
         come from its convex hull; close the mesh, or state the values",
        names.join(", ")
    );
    Some((NoticeKind::OpenMesh, text))
}

fn ellipsoid(shape: &Shape) -> Option<(NoticeKind, String)> {
    let size = *ellipsoids(shape).first()?;
    let text = format!(
        "a sphere of {} x {} x {} m is an ellipsoid: it collides and is detected as a convex mesh of 642 points; set \
         equal sizes for a ball",
        size.x, size.y, size.z
    );
    Some((NoticeKind::Ellipsoid, text))
}

/// Returns a warning if a shape is dynamic but its parent is a kinematic joint, which does not constrain it.
fn kinematic_joint(scene: &Scene, slot: u32, shape: &Shape) -> Option<(NoticeKind, String)> {
    let joint = scene.get(slot)?.parent;
    let object = scene.get(joint)?;
    let kinematic = object.joint().is_some_and(|j| !j.dynamic) && scene.get(object.parent)?.shape().is_some();
    (shape.dynamic && kinematic).then(|| {
        let text = "the shape is dynamic, but the joint above it is kinematic and does not hold it, so the shape moves \
                    freely; make the joint dynamic, or the shape static";
        (NoticeKind::KinematicJoint, text.to_owned())
    })
}
