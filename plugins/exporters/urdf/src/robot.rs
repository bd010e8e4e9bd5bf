//! Chooses the bodies that form the robot, and their links.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use tatu_exporters_common::{Export, Mechanisms, NameSpace, Tie};
use tatu_plugin_api::safe::{Fail, Result};

/// Number of robots that an error lists.
const MAX_LISTED: usize = 20;
/// Name of the link that stands for the world, to which robots with a fixed base are attached.
pub const WORLD: &str = "world";

/// A body as a link.
pub struct Link {
    /// Index of the body.
    pub body: usize,
    /// Name of the link.
    pub name: String,
    /// Pose of the link in the frame of the link above it, or of the world, with all joints at 0. The frame of a link lies
    /// at the joint above it.
    pub origin: Isometry3<f64>,
    /// Pose of the body in the frame of the link.
    pub below: Isometry3<f64>,
}

/// The robot that is exported.
pub struct Robot {
    /// Name of the robot.
    pub name: String,
    /// The links of its bodies; the first is the root, and parents precede children.
    pub links: Vec<Link>,
    /// Index of the link of each body.
    pub link_of: Vec<Option<usize>>,
    /// Whether the root is fixed to the world.
    pub is_fixed: bool,
    /// Objects of dummies that stand for the root link itself.
    pub root_frames: BTreeSet<usize>,
    /// Names of links.
    pub names: NameSpace,
}

/// Chooses the root of the robot.
fn root(all: &Mechanisms, export: &Export<'_>) -> Result<usize> {
    let tops: Vec<usize> =
        (1..all.bodies.len()).filter(|b| matches!(all.bodies[*b].tie, Tie::World | Tie::Free)).collect();
    let children = all.children();
    let robots: Vec<usize> = tops.iter().copied().filter(|top| !children[*top].is_empty()).collect();
    // A joint below no shape moves a body that hangs on the world itself.
    let hangs = children[0].iter().any(|b| matches!(all.bodies[*b].tie, Tie::Joint { .. } | Tie::Rigid { .. }));
    let mut chosen = if robots.is_empty() && !hangs { tops } else { robots };
    if hangs {
        chosen.push(0);
    }
    let is_world = chosen.is_empty() && !all.bodies[0].parts.is_empty();
    match chosen.as_slice() {
        [one] => Ok(*one),
        [] if is_world && (export.base != 0 || all.items.len() == 1) => Ok(0),
        [] => Err(Fail::missing("there is no robot to export: nothing moves, and nothing carries joints")
            .help("name the object to export: `--object /path`; an object that does not move can be exported, too")),
        several => {
            let paths: Vec<&str> = several.iter().take(MAX_LISTED).map(|b| all.path_of(*b)).collect();
            let more = several.len().saturating_sub(MAX_LISTED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            Err(Fail::argument(format!(
                "a URDF file holds one robot, and there are {}: {}{more}",
                several.len(),
                paths.join(", ")
            ))
            .help("name one of them: `--object /path`"))
        }
    }
}

/// Returns whether a pose is exactly the identity.
fn is_identity(pose: &Isometry3<f64>) -> bool {
    pose.translation.vector == nalgebra::Vector3::zeros() && pose.rotation.coords.xyz() == nalgebra::Vector3::zeros()
}

impl Robot {
    /// Chooses the robot, and names its links.
    pub fn choose(all: &Mechanisms, export: &Export<'_>) -> Result<Self> {
        let root = root(all, export)?;
        let is_fixed = all.bodies[root].mass.is_none();
        let mut names = NameSpace::default();
        let mut root_frames = BTreeSet::new();
        if is_fixed {
            names.derived(WORLD);
        }
        // The importer places the root link as a dummy at the base, which has the name of the robot.
        let stands_for_root = all.bodies[root].frames.iter().filter(|f| {
            let item = &all.items[f.item];
            item.parent == all.bodies[root].item && item.children.is_empty() && is_identity(&f.pose)
        });
        let mut root_name = None;
        for frame in stands_for_root {
            let alias = all.items[frame.item].alias.as_str();
            if is_fixed && alias == WORLD {
                root_frames.insert(frame.item);
            } else if root_name.is_none() {
                root_frames.insert(frame.item);
                root_name = Some(alias);
            }
        }
        // An object that was chosen gives the robot its name; in a scene of several, the root does.
        let tops = all.items.iter().filter(|item| item.parent.is_none()).count();
        let name = match all.items.first().filter(|_| tops == 1) {
            Some(item) => item.alias.clone(),
            None if root == 0 => export.name.clone(),
            None => all.name_of(root).to_owned(),
        };
        let own = if root == 0 { name.as_str() } else { all.name_of(root) };
        let root_name = names.name(root_name.unwrap_or(own));
        let mut robot =
            Robot { name, links: Vec::new(), link_of: vec![None; all.bodies.len()], is_fixed, root_frames, names };
        robot.add(all, root, root_name);
        for body in 1..all.bodies.len() {
            let (Tie::Joint { parent, .. } | Tie::Rigid { parent }) = all.bodies[body].tie else { continue };
            if robot.link_of[parent].is_some() {
                let name = robot.names.name(all.name_of(body));
                robot.add(all, body, name);
            }
        }
        Ok(robot)
    }

    fn add(&mut self, all: &Mechanisms, body: usize, name: String) {
        let of = &all.bodies[body];
        // Pose of the body above in the frame of its link.
        let above = self.link_of[all.parent_of(body)].map_or(Isometry3::identity(), |above| self.links[above].below);
        let (origin, below) = match &of.tie {
            Tie::Joint { frame, below, .. } if !self.links.is_empty() => {
                let turn = below.rotation;
                let shift = turn.inverse() * below.translation.vector;
                let at_joint = frame * Isometry3::from_parts(Translation3::identity(), turn);
                (above * at_joint, Isometry3::from_parts(shift.into(), UnitQuaternion::identity()))
            }
            _ => (above * of.in_parent, Isometry3::identity()),
        };
        self.link_of[body] = Some(self.links.len());
        self.links.push(Link { body, name, origin, below });
    }
}
