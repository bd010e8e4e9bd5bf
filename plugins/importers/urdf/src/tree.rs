//! The tree of links and joints. Links that are fixed to each other are merged into a body.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use tatu_plugin_api::safe::{Fail, Result};

use crate::robot::{Joint, Robot, UrdfJointKind, UrdfPose};

/// Maximum number of joints from the root to a leaf.
const MAX_DEPTH: usize = 256;

/// Links that are fixed to each other and form one body.
pub struct LinkGroup {
    /// The index of each link, and its pose in the frame of the body, which is that of the first link.
    pub links: Vec<(usize, Isometry3<f64>)>,
    /// Indices of the joint above this body and of the body above that joint, and the joint's frame in the frame of the
    /// latter body. The joint's axis is the z axis of its frame. `None` for the root.
    pub joint: Option<(usize, usize, Isometry3<f64>)>,
    /// Transform from the joint's moving frame to the body's frame.
    pub below: Isometry3<f64>,
}

/// The bodies of a robot. Parents precede children, so the first body is the root.
pub struct BodyTree {
    /// The bodies, parents before children.
    pub bodies: Vec<LinkGroup>,
    /// Joints of unsupported types or without an axis, which are treated as fixed.
    pub stiffened: Vec<usize>,
}

/// Returns an error unless all numbers are finite and have absolute values of at most 1e12.
pub fn check_finite(numbers: &[f64], what: &str, line: u64) -> Result {
    match numbers.iter().find(|x| !x.is_finite() || x.abs() > 1e12) {
        Some(x) => {
            Err(Fail::argument(format!("{what}: {x} is out of range; expected a number from -1e12 to 1e12"))
                .at("", line))
        }
        None => Ok(()),
    }
}

/// Validates and converts a pose in the file; `what` names it in errors.
pub fn pose(p: &UrdfPose, what: &str, line: u64) -> Result<Isometry3<f64>> {
    check_finite(&p.xyz, what, line)?;
    check_finite(&p.rpy, what, line)?;
    let [r, p_, y] = p.rpy;
    Ok(Isometry3::from_parts(Translation3::from(Vector3::from(p.xyz)), UnitQuaternion::from_euler_angles(r, p_, y)))
}

/// Returns the rotation that maps the z axis to the joint's axis, or `None` if the axis has no direction.
fn to_axis(joint: &Joint) -> Result<Option<UnitQuaternion<f64>>> {
    let (axis, line) = (Vector3::from(joint.axis), joint.line);
    check_finite(axis.as_slice(), &format!("axis of the joint `{}`", joint.name), line)?;
    let Some(axis) = axis.try_normalize(1e-9) else { return Ok(None) };
    // Between opposite directions, the shortest rotation is not unique; a half turn about any perpendicular axis works.
    let about_x = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Ok(Some(UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap_or(about_x)))
}

impl BodyTree {
    /// Checks the tree and merges links into bodies.
    pub fn new(robot: &Robot) -> Result<BodyTree> {
        let mut by_name: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, link) in robot.links.iter().enumerate() {
            let line = link.line;
            if link.name.is_empty() {
                return Err(Fail::argument("a link has no name: expected a nonempty attribute `name`").at("", line));
            }
            if let Some(first) = by_name.insert(&link.name, i) {
                let first = robot.links[first].line;
                return Err(Fail::argument(format!(
                    "two links are named `{}`; the first is in line {first}",
                    link.name
                ))
                .at("", line));
            }
        }
        let mut names: BTreeMap<&str, usize> = BTreeMap::new();
        // The joint above each link, and the joints below each link.
        let mut above: Vec<Option<usize>> = vec![None; robot.links.len()];
        let mut below: Vec<Vec<(usize, usize)>> = vec![Vec::new(); robot.links.len()];
        for (i, joint) in robot.joints.iter().enumerate() {
            let line = joint.line;
            if names.insert(&joint.name, i).is_some() || joint.name.is_empty() {
                return Err(Fail::argument(format!(
                    "the joint name `{}` is empty, or another joint has the same name",
                    joint.name
                ))
                .at("", line));
            }
            let find = |name: &str, role: &str| {
                by_name.get(name).copied().ok_or_else(|| {
                    Fail::argument(format!(
                        "the joint `{}` refers to the {role} link `{name}`, which does not exist",
                        joint.name
                    ))
                    .at("", line)
                })
            };
            let (parent, child) = (find(&joint.parent, "parent")?, find(&joint.child, "child")?);
            if parent == child {
                return Err(Fail::argument(format!(
                    "the joint `{}` connects a link to itself: its parent and its child are the same",
                    joint.name
                ))
                .at("", line));
            }
            if let Some(other) = above[child].replace(i) {
                let other = &robot.joints[other].name;
                let text = format!("the link `{}` has two parent joints, `{other}` and `{}`", joint.child, joint.name);
                return Err(Fail::argument(text).help("in a tree, a link has exactly one parent joint").at("", line));
            }
            below[parent].push((i, child));
        }
        let roots: Vec<usize> = (0..robot.links.len()).filter(|l| above[*l].is_none()).collect();
        let root = match roots.as_slice() {
            [one] => *one,
            [] if robot.links.is_empty() => {
                return Err(Fail::argument("the robot has no links")
                    .help("a file that only defines macros is read by the file that includes it")
                    .at("", 1));
            }
            [] => {
                return Err(Fail::argument("the joints form a loop: every link has a parent joint")
                    .at("", robot.joints[0].line));
            }
            [first, second, ..] => {
                let [a, b] = [&robot.links[*first].name, &robot.links[*second].name];
                return Err(Fail::argument(format!(
                    "the robot is not connected: neither `{a}` nor `{b}` has a parent joint"
                ))
                .at("", robot.links[*second].line));
            }
        };
        let mut tree = BodyTree { bodies: Vec::new(), stiffened: Vec::new() };
        tree.bodies.push(LinkGroup {
            links: vec![(root, Isometry3::identity())],
            joint: None,
            below: Isometry3::identity(),
        });
        let mut seen = 1;
        // The queue of links to be visited: each link, its body, its pose in that body, and its depth in joints.
        let mut open = std::collections::VecDeque::from([(root, 0, Isometry3::identity(), 0)]);
        while let Some((link, body, frame, depth)) = open.pop_front() {
            for (j, child) in &below[link] {
                let joint = &robot.joints[*j];
                let line = joint.line;
                seen += 1;
                if depth >= MAX_DEPTH {
                    return Err(Fail::argument(format!(
                        "the chain of joints from the root is longer than {MAX_DEPTH} joints"
                    ))
                    .at("", line));
                }
                let origin = frame * pose(&joint.origin, &format!("origin of the joint `{}`", joint.name), line)?;
                let moves = matches!(
                    joint.kind,
                    UrdfJointKind::Revolute | UrdfJointKind::Continuous | UrdfJointKind::Prismatic
                );
                let turn = if moves { to_axis(joint)? } else { None };
                let Some(turn) = turn else {
                    if joint.kind != UrdfJointKind::Fixed {
                        tree.stiffened.push(*j);
                    }
                    tree.bodies[body].links.push((*child, origin));
                    open.push_back((*child, body, origin, depth + 1));
                    continue;
                };
                tree.bodies.push(LinkGroup {
                    links: vec![(*child, Isometry3::identity())],
                    joint: Some((*j, body, origin * turn)),
                    below: Isometry3::from_parts(Translation3::identity(), turn.inverse()),
                });
                open.push_back((*child, tree.bodies.len() - 1, Isometry3::identity(), depth + 1));
            }
        }
        if seen < robot.links.len() {
            let lost = above.iter().position(|a| a.is_some_and(|j| !tree.is_child_in(robot, j))).unwrap_or(root);
            return Err(Fail::argument(format!(
                "the link `{}` cannot be reached from the root: joints above it form a loop",
                robot.links[lost].name
            ))
            .at("", robot.links[lost].line));
        }
        Ok(tree)
    }

    /// Returns whether the child link of a joint is part of a body in this tree.
    fn is_child_in(&self, robot: &Robot, joint: usize) -> bool {
        let child = &robot.joints[joint].child;
        self.bodies.iter().flat_map(|b| &b.links).any(|(l, _)| robot.links[*l].name == *child)
    }
}
