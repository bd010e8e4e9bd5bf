//! The trees of links and joints. Links that are fixed to each other are merged into a body.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use tatu_plugin_api::safe::{Fail, Result};

use crate::robot::{Joint, JointKind, Robot, RobotStructure};

/// Maximum number of joints from the root to a leaf.
const MAX_DEPTH: usize = 256;

/// Links that are fixed to each other and form one body.
pub struct LinkGroup {
    /// The index of each link, and its pose in the frame of the body. That is the frame of the first link; if the robot
    /// has only one root, that of the robot for the root's body.
    pub links: Vec<(usize, Isometry3<f64>)>,
    /// Indices of the joint above this body and of the body above that joint, and the joint's frame in the frame of the
    /// latter body. The joint's axis is the z axis of its frame. `None` for roots.
    pub joint: Option<(usize, usize, Isometry3<f64>)>,
    /// Transform from the joint's moving frame to the body's frame; for roots, from the frame of the robot.
    pub below: Isometry3<f64>,
}

/// The bodies of a robot. Parents precede children, so the first body is a root.
#[derive(Default)]
pub struct BodyTree {
    /// The bodies, parents before children.
    pub bodies: Vec<LinkGroup>,
    /// Joints of unsupported types or without an axis, which are treated as fixed.
    pub stiffened: Vec<usize>,
    /// Joints that close loops.
    pub closures: Vec<LoopClosure>,
}

/// A joint that closes a loop.
pub struct LoopClosure {
    pub joint: usize,
    /// For the parent and for the child: the body, and the joint's frame in the frame of the body.
    pub ends: [(usize, Isometry3<f64>); 2],
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

/// Validates and converts a position (m) and angles (rad): roll, pitch and yaw about the fixed axes x, y and z. `what`
/// names the pose in errors.
pub fn pose(xyz: [f64; 3], rpy: [f64; 3], what: &str, line: u64) -> Result<Isometry3<f64>> {
    check_finite(&xyz, what, line)?;
    check_finite(&rpy, what, line)?;
    let [r, p, y] = rpy;
    Ok(Isometry3::from_parts(Translation3::from(Vector3::from(xyz)), UnitQuaternion::from_euler_angles(r, p, y)))
}

/// Returns the rotation that maps the z axis to the joint's axis, or `None` if the axis has no direction.
fn to_axis(joint: &Joint, sign: f64) -> Result<Option<UnitQuaternion<f64>>> {
    if joint.kind == JointKind::Ball {
        return Ok(Some(UnitQuaternion::identity()));
    }
    let (axis, line) = (Vector3::from(joint.axis) * sign, joint.line);
    check_finite(axis.as_slice(), &format!("axis of the joint `{}`", joint.name), line)?;
    let Some(axis) = axis.try_normalize(1e-9) else { return Ok(None) };
    // Between opposite directions, the shortest rotation is not unique; a half turn about any perpendicular axis works.
    let about_x = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Ok(Some(UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap_or(about_x)))
}

/// A joint as it is passed from one link to another.
struct JointPassage {
    joint: usize,
    to: usize,
    /// Pose of the joint in the frame of the link from which it is passed, and of the other link in that of the joint.
    pose: Isometry3<f64>,
    other: Isometry3<f64>,
    /// 1, or -1 if the joint is passed from its child to its parent.
    sign: f64,
}

impl JointPassage {
    fn down(joint: usize, to: usize, source: &Joint) -> Self {
        JointPassage { joint, to, pose: source.pose, other: source.child_pose, sign: 1.0 }
    }
    fn up(joint: usize, to: usize, source: &Joint) -> Self {
        let (pose, other) = (source.child_pose.inverse(), source.pose.inverse());
        JointPassage { joint, to, pose, other, sign: -1.0 }
    }
}

/// Returns the parent and the child of each joint. Fails if a name is missing or doubled.
fn connections(robot: &Robot) -> Result<Vec<(usize, usize)>> {
    let mut by_name: BTreeMap<&str, usize> = BTreeMap::new();
    for (i, link) in robot.links.iter().enumerate() {
        let line = link.line;
        if link.name.is_empty() {
            return Err(Fail::argument("a link has no name: expected a nonempty attribute `name`").at("", line));
        }
        if let Some(first) = by_name.insert(&link.name, i) {
            let first = robot.links[first].line;
            let text = format!("two links are named `{}`; the first is in line {first}", link.name);
            return Err(Fail::argument(text).at("", line));
        }
    }
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    let mut ends = Vec::with_capacity(robot.joints.len());
    for (i, joint) in robot.joints.iter().enumerate() {
        let fail = |text: String| Fail::argument(text).at("", joint.line);
        if joint.name.is_empty() {
            return Err(fail("a joint has no name: expected a nonempty attribute `name`".to_owned()));
        }
        if let Some(other) = names.insert(&joint.name, i) {
            let line = robot.joints[other].line;
            return Err(fail(format!(
                "the joint in line {line} is also named `{}`: expected names that differ",
                joint.name
            )));
        }
        let find = |name: &str, role: &str| {
            by_name.get(name).copied().ok_or_else(|| {
                fail(format!("the joint `{}` refers to the {role} link `{name}`, which does not exist", joint.name))
            })
        };
        let (parent, child) = (find(&joint.parent, "parent")?, find(&joint.child, "child")?);
        if parent == child {
            return Err(fail(format!(
                "the joint `{}` connects a link to itself: its parent and its child are the same",
                joint.name
            )));
        }
        ends.push((parent, child));
    }
    Ok(ends)
}

/// Returns the root of a robot whose links form one tree. Fails if they do not.
fn only_root(robot: &Robot, ends: &[(usize, usize)]) -> Result<usize> {
    // The joint above each link.
    let mut above: Vec<Option<usize>> = vec![None; robot.links.len()];
    for ((_, child), (i, joint)) in ends.iter().zip(robot.joints.iter().enumerate()) {
        if let Some(other) = above[*child].replace(i) {
            let other = &robot.joints[other].name;
            let text = format!("the link `{}` has two parent joints, `{other}` and `{}`", joint.child, joint.name);
            return Err(Fail::argument(text).help("in a tree, a link has exactly one parent joint").at("", joint.line));
        }
    }
    let mut roots = (0..robot.links.len()).filter(|l| above[*l].is_none());
    match (roots.next(), roots.next()) {
        (Some(one), None) => Ok(one),
        (Some(first), Some(second)) => {
            let [a, b] = [&robot.links[first].name, &robot.links[second].name];
            Err(Fail::argument(format!("the robot is not connected: neither `{a}` nor `{b}` has a parent joint"))
                .at("", robot.links[second].line))
        }
        (None, _) if robot.links.is_empty() => Err(Fail::argument("the robot has no links")
            .help("a file that only defines macros is read by the file that includes it")
            .at("", 1)),
        (None, _) => {
            Err(Fail::argument("the joints form a loop: every link has a parent joint").at("", robot.joints[0].line))
        }
    }
}

/// Sets of links.
struct LinkSets(Vec<usize>);

impl LinkSets {
    /// Returns the link that stands for the set of a link.
    fn of(&mut self, mut link: usize) -> usize {
        while self.0[link] != link {
            // Each look-up halves the way of the next one.
            self.0[link] = self.0[self.0[link]];
            link = self.0[link];
        }
        link
    }
    /// Joins the sets of two links. Returns whether they were different.
    fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a] = b;
        a != b
    }
}

impl BodyTree {
    /// Checks how links are connected and merges them into bodies.
    pub fn new(robot: &Robot) -> Result<BodyTree> {
        let mut tree = BodyTree::default();
        if robot.structure == RobotStructure::Static {
            (0..robot.links.len()).for_each(|link| tree.add_root(robot, link, false));
            return Ok(tree);
        }
        let ends = connections(robot)?;
        let mut passages: Vec<Vec<JointPassage>> = robot.links.iter().map(|_| Vec::new()).collect();
        if robot.structure == RobotStructure::Tree {
            let root = only_root(robot, &ends)?;
            for (i, (parent, child)) in ends.iter().enumerate() {
                passages[*parent].push(JointPassage::down(i, *child, &robot.joints[i]));
            }
            tree.add_root(robot, root, true);
            let mut seen = vec![false; robot.links.len()];
            tree.grow(robot, root, &passages, &mut seen)?;
            return match seen.iter().position(|seen| !seen) {
                Some(lost) => Err(Fail::argument(format!(
                    "the link `{}` cannot be reached from the root: joints above it form a loop",
                    robot.links[lost].name
                ))
                .at("", robot.links[lost].line)),
                None => Ok(tree),
            };
        }
        let mut sets = LinkSets((0..robot.links.len()).collect());
        let mut has_parent = vec![false; robot.links.len()];
        let mut closing = Vec::new();
        for (i, (parent, child)) in ends.iter().enumerate() {
            if sets.join(*parent, *child) {
                passages[*parent].push(JointPassage::down(i, *child, &robot.joints[i]));
                passages[*child].push(JointPassage::up(i, *parent, &robot.joints[i]));
                has_parent[*child] = true;
            } else {
                closing.push(i);
            }
        }
        // Of the links that are connected, one that cannot move is the root, or else the first without a parent.
        let mut order: Vec<usize> = (0..robot.links.len()).collect();
        order.sort_by_key(|link| (!robot.links[*link].is_fixed, has_parent[*link]));
        let mut roots: BTreeMap<usize, usize> = BTreeMap::new();
        for link in order {
            roots.entry(sets.of(link)).or_insert(link);
        }
        let mut roots: Vec<usize> = roots.into_values().collect();
        roots.sort_unstable();
        let mut seen = vec![false; robot.links.len()];
        for root in &roots {
            tree.add_root(robot, *root, roots.len() == 1);
            tree.grow(robot, *root, &passages, &mut seen)?;
        }
        tree.close(robot, &ends, closing)?;
        Ok(tree)
    }

    fn add_root(&mut self, robot: &Robot, link: usize, is_only: bool) {
        let (pose, identity) = (robot.links[link].pose, Isometry3::identity());
        let (own, below) = if is_only { (pose, identity) } else { (identity, pose) };
        self.bodies.push(LinkGroup { links: vec![(link, own)], joint: None, below });
    }

    /// Adds the bodies that can be reached from a root, which is the last body.
    fn grow(&mut self, robot: &Robot, root: usize, passages: &[Vec<JointPassage>], seen: &mut [bool]) -> Result {
        let body = self.bodies.len() - 1;
        seen[root] = true;
        // The queue of links to be visited: each link, its body, its pose in that body, and its depth in joints.
        let mut open = VecDeque::from([(root, body, self.bodies[body].links[0].1, 0)]);
        while let Some((link, body, frame, depth)) = open.pop_front() {
            for passage in &passages[link] {
                let joint = &robot.joints[passage.joint];
                if std::mem::replace(&mut seen[passage.to], true) {
                    continue;
                }
                if depth >= MAX_DEPTH {
                    let text = format!("the chain of joints from the root is longer than {MAX_DEPTH} joints");
                    return Err(Fail::argument(text).at("", joint.line));
                }
                let origin = frame * passage.pose;
                let moves = joint.kind.has_axis() || joint.kind == JointKind::Ball;
                let turn = if moves { to_axis(joint, passage.sign)? } else { None };
                let Some(turn) = turn else {
                    if joint.kind != JointKind::Fixed {
                        self.stiffened.push(passage.joint);
                    }
                    let frame = origin * passage.other;
                    self.bodies[body].links.push((passage.to, frame));
                    open.push_back((passage.to, body, frame, depth + 1));
                    continue;
                };
                self.bodies.push(LinkGroup {
                    links: vec![(passage.to, Isometry3::identity())],
                    joint: Some((passage.joint, body, origin * turn)),
                    below: Isometry3::from_parts(Translation3::identity(), turn.inverse()) * passage.other,
                });
                open.push_back((passage.to, self.bodies.len() - 1, Isometry3::identity(), depth + 1));
            }
        }
        Ok(())
    }

    /// Adds the joints that close loops.
    fn close(&mut self, robot: &Robot, ends: &[(usize, usize)], closing: Vec<usize>) -> Result {
        let mut place: Vec<(usize, Isometry3<f64>)> = vec![(0, Isometry3::identity()); robot.links.len()];
        for (body, group) in self.bodies.iter().enumerate() {
            group.links.iter().for_each(|(link, frame)| place[*link] = (body, *frame));
        }
        for i in closing {
            let joint = &robot.joints[i];
            let ((a, parent), (b, child)) = (place[ends[i].0], place[ends[i].1]);
            // Within a body, the loop consists of fixed joints.
            if a == b {
                continue;
            }
            let moves = joint.kind.has_axis() || joint.kind == JointKind::Ball;
            let turn = if moves { to_axis(joint, 1.0)? } else { None };
            let turn = turn.unwrap_or_default();
            let ends = [(a, parent * joint.pose * turn), (b, child * joint.child_pose.inverse() * turn)];
            self.closures.push(LoopClosure { joint: i, ends });
        }
        Ok(())
    }
}
