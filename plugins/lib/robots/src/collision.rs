//! Builds the collision geometry of bodies.

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::{SelfCollisionMasks, merge_pieces};
use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{
    findings::{FindingKind, Findings},
    form::{PlacedSolid, SolidForm},
    robot::Surface,
    settings::BuildSettings,
    tree::{BodyTree, LoopClosure},
};

/// Collision mask of a link that collides with everything except other links of the same robot.
const OTHERS_MASK: i64 = 0xFF00;

/// Largest vertical component of the axis of a wheel; a plate on a vertical axis cannot roll on a floor.
const MAX_VERTICAL: f64 = 0.7;

/// A geometry that collides, in the frame of its body, with its surface.
pub struct CollidingSolid<'s> {
    pub solid: &'s PlacedSolid,
    pub surface: &'s Surface,
}

/// Returns the collision mask of each body. With `self_collision`, those that have collision geometry collide with each
/// other, unless a joint connects them.
pub fn masks(tree: &BodyTree, has_collision: &[bool], self_collision: bool, findings: &Findings) -> Vec<i64> {
    let count = tree.bodies.len();
    if !self_collision {
        return vec![OTHERS_MASK; count];
    }
    let connects = |a: usize, b: usize| {
        let above =
            |child: usize, parent: usize| tree.bodies[child].joint.as_ref().is_some_and(|(_, p, _)| *p == parent);
        let closes = |closure: &LoopClosure| {
            let ends = [closure.ends[0].0, closure.ends[1].0];
            ends == [a, b] || ends == [b, a]
        };
        above(b, a) || above(a, b) || tree.closures.iter().any(closes)
    };
    let masks = SelfCollisionMasks::choose(count, |a, b| has_collision[a] && has_collision[b] && !connects(a, b));
    if masks.missing > 0 {
        let text = format!(
            "{} pairs of links do not collide although no joint connects them, since masks cannot express all pairs",
            masks.missing
        );
        findings.warn(FindingKind::SelfCollision, 0, text);
    }
    masks.low.iter().map(|low| OTHERS_MASK | i64::from(*low)).collect()
}

/// Gives a body its collision geometry, which must not be empty. `rolls_about` is the axis of the joint above, in the
/// frame of the body, if the body can roll. Returns the number of cylinders that collide as spheres.
pub fn set_collision_geometry(
    builder: &Builder<'_>,
    node: Node<'_>,
    solids: &[CollidingSolid<'_>],
    rolls_about: Option<Vector3<f64>>,
    friction: f64,
    settings: &BuildSettings,
) -> Result<usize> {
    let stated = solids.iter().find_map(|s| s.surface.friction);
    node.set("shape.friction", stated.unwrap_or(friction))?;
    let restitution = solids.iter().map(|s| s.surface.restitution).fold(0.0, f64::max);
    if restitution > 0.0 {
        node.set("shape.restitution", restitution)?;
    }
    if let [CollidingSolid { solid: PlacedSolid { pose, form: SolidForm::Mesh(pieces) }, .. }] = solids
        && settings.decompose == 0
    {
        let (points, triangles) = merge_pieces(&pieces.iter().map(|p| p.moved([1.0; 3], pose)).collect::<Vec<_>>());
        let number = builder.mesh(&points, &triangles)?;
        node.set("shape.primitive", "mesh")?.set("shape.mesh", number)?.set("shape.convex", !settings.concave)?;
        return Ok(0);
    }
    let mut wheels = 0;
    let mut parts = Vec::with_capacity(solids.len());
    for CollidingSolid { solid, surface } in solids {
        let ball = rolls_about.filter(|_| settings.wheels_as_balls).and_then(|axis| sphere_for_wheel(&axis, solid));
        wheels += usize::from(ball.is_some());
        let solid: &PlacedSolid = ball.as_ref().unwrap_or(solid);
        let convex = solid.convex_parts(settings.decompose);
        for solid in if convex.is_empty() { std::slice::from_ref(solid) } else { &convex } {
            // Without a friction of its own, a part has that of the shape, which a statement of another part changes.
            let own = surface.friction.or(stated.map(|_| friction));
            parts.push(solid.part(builder, !settings.concave, own)?);
        }
    }
    node.set("shape.primitive", "compound")?.set("shape.parts", Value::List(parts))?;
    Ok(wheels)
}

/// Sets the direction in which the friction of a body differs, if one of its solids states one. Returns whether others
/// state other directions.
pub fn set_friction_axis(node: Node<'_>, solids: &[CollidingSolid<'_>]) -> Result<bool> {
    let Some((axis, along)) = solids.iter().find_map(|s| s.surface.axis) else { return Ok(false) };
    node.set("shape.friction_axis", axis)?.set("shape.axis_friction", along)?;
    Ok(solids.iter().any(|s| s.surface.axis != Some((axis, along))))
}

/// Returns the axis of a continuous joint in the frame of the body that it moves, if something can roll on a floor about
/// it. `joint` is the pose of the joint's frame in the frame of the root, `below` that of the body in the joint's.
pub fn rolling_axis(joint: &Isometry3<f64>, below: &Isometry3<f64>) -> Option<Vector3<f64>> {
    let axis = joint * Vector3::z();
    (axis.z.abs() <= MAX_VERTICAL).then(|| below.inverse() * Vector3::z())
}

/// Returns the sphere that replaces a cylinder coaxial with the joint above, or `None` for other geometries. A cylinder
/// touches the floor along a line, which slows the rotation of a robot.
fn sphere_for_wheel(axis: &Vector3<f64>, solid: &PlacedSolid) -> Option<PlacedSolid> {
    let SolidForm::Primitive("cylinder", [d, _, length]) = solid.form else { return None };
    let own = solid.pose * Vector3::z();
    let at = solid.pose.translation.vector;
    // The tolerance allows for quarter turns rounded to 1.57.
    let centred = (at - axis * at.dot(axis)).norm() < 1e-6;
    (centred && own.cross(axis).norm() < 1e-3 && length <= d)
        .then_some(PlacedSolid { pose: solid.pose, form: SolidForm::Primitive("sphere", [d; 3]) })
}
