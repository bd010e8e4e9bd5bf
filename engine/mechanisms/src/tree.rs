//! A validated tree of links, in the form that computations need.

use std::ops::Range;

use nalgebra::Isometry3;

use crate::{
    error::TreeError,
    link::{Joint, Link},
    vector::{IDENTITY, Mat3, Quat, Vec3, ZERO, normalized, rotation_of, turn},
};

/// Index that stands for "no parent", "no velocity closer to the root" or "no single position".
pub(crate) const NO_INDEX: u32 = u32::MAX;

/// The type of a joint, without its axis.
#[derive(Debug, Clone, Copy)]
pub(crate) enum TreeJointKind {
    Fixed,
    Revolute,
    Prismatic,
    Spherical,
    Free,
}

/// A link in the form that computations need.
#[derive(Debug, Clone)]
pub(crate) struct TreeNode {
    /// Index of the parent, or [`NO_INDEX`].
    pub parent: u32,
    pub kind: TreeJointKind,
    /// Rotation and translation of the frame relative to the parent at joint position 0.
    pub rotation: Mat3,
    pub place: Vec3,
    /// The joint's axis in the parent's frame, at joint position 0.
    pub axis_in_parent: Vec3,
    pub axis: Vec3,
    /// Special cases that apply to most joints and save three quarters of the multiplications: whether `rotation` is
    /// the identity and, if the joint's axis is a coordinate axis, its index and sign.
    pub straight: bool,
    pub coordinate: Option<(usize, f64)>,
    pub mass: f64,
    pub center: Vec3,
    /// Inertia about the centre of mass, in link axes, kg m².
    pub inertia: Mat3,
    /// Indices of the first position and the first velocity.
    pub position: usize,
    pub velocity: usize,
    pub velocities: usize,
}

impl TreeNode {
    /// Returns the range of the indices of the joint's velocities.
    #[inline(always)]
    pub fn range(&self) -> Range<usize> {
        self.velocity..self.velocity + self.velocities
    }
}

/// Change of a lever arm, m, that is considered equivalent to a rotation of 1 rad: a typical distance between joints.
const LEVER_LENGTH: f64 = 0.25;

/// The parameters of one velocity.
#[derive(Debug, Clone)]
pub(crate) struct Dof {
    pub armature: f64,
    pub damping: f64,
    pub friction: f64,
    /// See [`Tree::turning`].
    pub turning: f64,
    /// Limits of the position, rad or m; infinite if there are none.
    pub low: f64,
    pub high: f64,
    /// Index of the corresponding position of a revolute or prismatic joint; otherwise [`NO_INDEX`].
    pub position: u32,
}

/// A tree of rigid links in which parents come before their children, and each link has one joint. Several links may
/// have no parent; the tree is then a forest of independent trees.
///
/// A tree contains only constant data; positions and velocities are stored in a [`TreeState`](crate::TreeState).
#[derive(Debug, Clone)]
pub struct Tree {
    links: Vec<Link>,
    pub(crate) nodes: Vec<TreeNode>,
    pub(crate) dofs: Vec<Dof>,
    positions: usize,
    /// For each velocity, the indices of the velocities on the path from the root, itself last: row `i` is
    /// `columns[rows[i]..rows[i + 1]]`. All other entries of the lower triangle of the mass matrix are 0.
    pub(crate) rows: Vec<usize>,
    pub(crate) columns: Vec<u32>,
    /// Index of the last velocity on the path from the root to each link, or [`NO_INDEX`].
    pub(crate) last: Vec<u32>,
}

impl Tree {
    /// Returns the rate at which a velocity of 1 changes the directions and lever arms of links, relative to a rotation
    /// at 1 rad/s: 1 if it is angular, 4 1/m for a prismatic joint, and 0 for the linear velocities of a free link, or
    /// if there is no velocity with this index.
    pub fn turning(&self, velocity: usize) -> f64 {
        self.dofs.get(velocity).map_or(0.0, |dof| dof.turning)
    }

    /// Creates a tree after checking its description. Complexity in time and memory: number of links times depth.
    ///
    /// # Errors
    ///
    /// Returns a [`TreeError`] if there are no links, or a link is invalid.
    pub fn new(links: Vec<Link>) -> Result<Self, TreeError> {
        Self::checked(links, true)
    }

    /// Creates a tree like [`Tree::new`], but allows inertias that are not those of rigid bodies; for example, a
    /// principal moment may exceed the sum of the other two. Such inertias occur in descriptions of robots, and are
    /// used unchanged.
    ///
    /// # Errors
    ///
    /// Fails like [`Tree::new`]; inertias must still be symmetric, without negative moments on the diagonal.
    pub fn with_any_inertia(links: Vec<Link>) -> Result<Self, TreeError> {
        Self::checked(links, false)
    }

    fn checked(links: Vec<Link>, real: bool) -> Result<Self, TreeError> {
        if links.is_empty() {
            return Err(TreeError::Empty);
        }
        for (i, link) in links.iter().enumerate() {
            if let Some(parent) = link.parent.filter(|p| *p >= i) {
                return Err(TreeError::Parent { link: i, parent });
            }
            link.check(i, real)?;
        }
        check_masses(&links)?;
        let mut tree = Tree {
            nodes: Vec::with_capacity(links.len()),
            dofs: vec![],
            positions: 0,
            rows: vec![0],
            columns: vec![],
            last: vec![],
            links: vec![],
        };
        for link in &links {
            tree.push(link);
        }
        tree.links = links;
        Ok(tree)
    }

    fn push(&mut self, link: &Link) {
        let (rotation, place) = pose_arrays(&link.frame);
        let (kind, axis) = match link.joint {
            Joint::Fixed => (TreeJointKind::Fixed, ZERO),
            Joint::Revolute(axis) => (TreeJointKind::Revolute, axis.into()),
            Joint::Prismatic(axis) => (TreeJointKind::Prismatic, axis.into()),
            Joint::Spherical => (TreeJointKind::Spherical, ZERO),
            Joint::Free => (TreeJointKind::Free, ZERO),
        };
        let (velocity, velocities) = (self.dofs.len(), link.joint.velocities());
        let i = &link.inertia;
        let inertia =
            [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(0, 1)], i[(1, 1)], i[(1, 2)], i[(0, 2)], i[(1, 2)], i[(2, 2)]];
        self.nodes.push(TreeNode {
            parent: link.parent.map_or(NO_INDEX, |p| p as u32),
            kind,
            rotation,
            place,
            axis_in_parent: turn(&rotation, axis),
            axis,
            straight: rotation == IDENTITY,
            coordinate: (0..3).find(|k| axis[*k].abs() == 1.0).map(|k| (k, axis[k])),
            mass: link.mass,
            center: link.center.into(),
            inertia,
            position: self.positions,
            velocity,
            velocities,
        });
        let mut last = link.parent.map_or(NO_INDEX, |p| self.last[p]);
        let [low, high] = link.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        for d in velocity..velocity + velocities {
            if last != NO_INDEX {
                let (a, b) = (self.rows[last as usize], self.rows[last as usize + 1]);
                self.columns.extend_from_within(a..b);
            }
            self.columns.push(d as u32);
            self.rows.push(self.columns.len());
            last = d as u32;
            let position = if velocities == 1 { self.positions as u32 } else { NO_INDEX };
            let &Link { armature, damping, friction, .. } = link;
            let turning = match link.joint {
                Joint::Revolute(_) | Joint::Spherical => 1.0,
                Joint::Free if d >= velocity + 3 => 1.0,
                Joint::Prismatic(_) => 1.0 / LEVER_LENGTH,
                Joint::Fixed | Joint::Free => 0.0,
            };
            self.dofs.push(Dof { armature, damping, friction, turning, low, high, position });
        }
        self.last.push(last);
        self.positions += link.joint.positions();
    }

    /// Returns the links as passed to [`Tree::new`].
    pub fn links(&self) -> &[Link] {
        &self.links
    }
    /// Returns the number of positions of a state.
    pub fn positions(&self) -> usize {
        self.positions
    }
    /// Returns the number of velocities of a state, which is the number of degrees of freedom.
    pub fn velocities(&self) -> usize {
        self.dofs.len()
    }
    /// Returns the indices of a link's first position and first velocity in a state, or `None` if there is no such
    /// link.
    pub fn offsets(&self, link: usize) -> Option<(usize, usize)> {
        self.nodes.get(link).map(|n| (n.position, n.velocity))
    }
    /// Returns the number of structurally nonzero entries in the lower triangle of the mass matrix, including the
    /// diagonal.
    pub(crate) fn entries(&self) -> usize {
        self.columns.len()
    }
}

/// Returns an error if a joint moves no mass, because its acceleration would be undefined.
fn check_masses(links: &[Link]) -> Result<(), TreeError> {
    let mut carried: Vec<f64> = links.iter().map(|l| l.mass).collect();
    for i in (0..links.len()).rev() {
        if links[i].joint.velocities() > 0 && carried[i] == 0.0 && links[i].armature == 0.0 {
            return Err(TreeError::Massless { link: i });
        }
        if let Some(parent) = links[i].parent {
            carried[parent] += carried[i];
        }
    }
    Ok(())
}

/// Returns the rotation and translation of a pose as plain arrays.
fn pose_arrays(pose: &Isometry3<f64>) -> (Mat3, Vec3) {
    let q = pose.rotation.quaternion();
    let q: Quat = normalized([q.w, q.i, q.j, q.k]);
    (rotation_of(q), pose.translation.vector.into())
}
