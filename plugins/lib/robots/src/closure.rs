//! Closes loops: a joint whose child already has a joint above it holds two bodies together by linked dummies.
//!
//! Linked dummies hold all six directions. A joint that moves is built below its parent with a light link, which carries
//! one of the dummies.

use nalgebra::{Isometry3, Matrix3, Vector3};
use tatu_importers_common::Mass;
use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{
    findings::{FindingKind, Findings},
    form::set_object_pose,
    joint::joint,
    robot::{Joint, JointKind, MotorKind, Robot, alias},
    tree::BodyTree,
};

/// Share of the child's mass that the link of a closing joint has, and the least radius of gyration of that link, m.
const LINK_SHARE: f64 = 1e-3;
const LINK_RADIUS_M: f64 = 0.01;
/// Full size of a link, which is neither seen nor collides, m.
const LINK_SIZE_M: f64 = 0.01;

/// Builds the joints that close loops. Of each body, `nodes` has the shape, `paths` its path below the base.
pub fn close_loops<'b>(
    builder: &Builder<'b>,
    robot: &Robot,
    tree: &BodyTree,
    (nodes, paths, masses): (&[Node<'b>], &[String], &[Mass]),
    findings: &Findings,
) -> Result {
    for closure in &tree.closures {
        let source = &robot.joints[closure.joint];
        let [(above, frame), (below, own)] = &closure.ends;
        let name = alias(&source.name);
        let moves = source.kind.has_axis() || source.kind == JointKind::Ball;
        let (parent, pose, path) = if moves {
            // A motor would have to overcome the whole loop; those of the other joints move it.
            let passive = Joint { motor: MotorKind::Off, mimic: None, ..source.clone() };
            let made = joint(builder, nodes[*above], (robot, &passive), frame, findings)?;
            let link = builder.object("shape", Some(made), &format!("{name}_link"))?;
            link.set("shape.size", [LINK_SIZE_M; 3])?
                .set("object.visible", false)?
                .set("shape.detectable", false)?
                .set("shape.dynamic", true)?;
            let mass = masses[*below].mass.max(1e-3) * LINK_SHARE;
            let inertia = Matrix3::from_diagonal(&Vector3::repeat(mass * LINK_RADIUS_M * LINK_RADIUS_M));
            link.set("shape.mass", mass)?
                .set("shape.com", [0.0; 3])?
                .set("shape.inertia", Value::Floats(inertia.as_slice().to_vec()))?;
            (link, Isometry3::identity(), format!("{}/{name}/{name}_link", paths[*above]))
        } else {
            (nodes[*above], *frame, paths[*above].clone())
        };
        let ends = [(parent, pose, path, "parent"), (nodes[*below], *own, paths[*below].clone(), "child")];
        let [first, second] = ends.map(|(parent, pose, path, end)| (parent, pose, path, format!("{name}_{end}")));
        let path_of = |(_, _, path, name): &(Node<'b>, Isometry3<f64>, String, String)| format!(":{path}/{name}");
        for ((parent, pose, _, name), other) in [(&first, &second), (&second, &first)] {
            let dummy = set_object_pose(builder.object("dummy", Some(*parent), name)?, pose)?;
            dummy.set("dummy.link", path_of(other).as_str())?;
        }
        let text = format!(
            "the joint `{}` closes a loop: linked dummies hold `{}` at it{}",
            source.name,
            source.child,
            if moves { ", by a link of 1/1000 of its mass" } else { "" }
        );
        findings.note(FindingKind::Loop, source.line, text);
    }
    Ok(())
}
