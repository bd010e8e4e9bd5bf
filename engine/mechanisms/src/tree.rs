//! A validated tree of links, in the form that computations need.

use std::ops::Range;

use nalgebra::Isometry3;

use crate::{
    error::TreeError,
    gear::{ResolvedGear, resolve_gears},
    link::{Joint, Link},
    paths::{AxisPaths, MassTerm, NO_INDEX, TreeAxis, elimination_parents},
    vector::{IDENTITY, Mat3, Quat, Vec3, ZERO, normalized, rotation_of, turn},
};

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
    /// Indices of the first position and the first velocity; those of the leader if the joint is geared.
    pub position: usize,
    pub velocity: usize,
    pub velocities: usize,
    /// Index of the first axis.
    pub first_axis: usize,
    pub gear: NodeGear,
}

/// The gear of a node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeGear {
    /// Whether the joint is geared: its position is `ratio` times that of its leader plus `offset`.
    pub geared: bool,
    pub ratio: f64,
    pub offset: f64,
}

impl TreeNode {
    /// Returns the range of the indices of the joint's velocities.
    #[inline(always)]
    pub fn range(&self) -> Range<usize> {
        self.velocity..self.velocity + self.velocities
    }
    /// Returns the range of the indices of the joint's axes.
    #[inline(always)]
    pub fn axes(&self) -> Range<usize> {
        self.first_axis..self.first_axis + self.velocities
    }
}

/// Change of a lever arm, m, that is considered equivalent to a rotation of 1 rad: a typical distance between joints.
const LEVER_LENGTH: f64 = 0.25;

/// The parameters of one velocity: the sums of those of all joints that it moves, in the coordinate of the independent
/// one.
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
    /// The axes that the velocity moves: a range of [`Tree::axes_by_velocity`].
    first_axis: usize,
    end_axis: usize,
}

impl Dof {
    /// Adds the parameters of a joint that is geared to this velocity.
    fn add_joint(&mut self, link: &Link, &ResolvedGear { ratio, offset, .. }: &ResolvedGear) {
        self.armature += ratio * ratio * link.armature;
        self.damping += ratio * ratio * link.damping;
        self.friction += ratio.abs() * link.friction;
        self.turning = self.turning.max(ratio.abs() * turning_of(&link.joint, 0));
        let [low, high] = link.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        if ratio != 0.0 {
            let ends = [(low - offset) / ratio, (high - offset) / ratio];
            let (low, high) = (self.low.max(ends[0].min(ends[1])), self.high.min(ends[0].max(ends[1])));
            // Limits that exclude each other would leave no position.
            if low <= high {
                (self.low, self.high) = (low, high);
            }
        }
    }
}

/// A tree of rigid links in which parents come before their children, and each link has one joint. Several links may
/// have no parent; the tree is then a forest, whose trees are independent unless gears couple them.
///
/// Geared joints have no positions and velocities: their motion is that of their leaders. If the limits of a geared
/// joint exclude all positions that those of the joints before it allow, they are ignored.
///
/// A tree contains only constant data; positions and velocities are stored in a [`TreeState`](crate::TreeState).
#[derive(Debug, Clone)]
pub struct Tree {
    links: Vec<Link>,
    pub(crate) nodes: Vec<TreeNode>,
    pub(crate) dofs: Vec<Dof>,
    positions: usize,
    /// For each velocity, the indices of the velocities on the path from the root, itself last: row `i` is
    /// `columns[rows[i]..rows[i + 1]]`. All other entries of the lower triangle of the mass matrix are 0. Gears
    /// lengthen these paths: see `paths`.
    pub(crate) rows: Vec<usize>,
    pub(crate) columns: Vec<u32>,
    /// Index of the last velocity on the path from the root to each link, or [`NO_INDEX`].
    pub(crate) last: Vec<u32>,
    /// The axes of all joints. Without gears, there is one per velocity, with the same index.
    pub(crate) axes: Vec<TreeAxis>,
    /// Indices of all axes, sorted by velocity.
    pub(crate) axes_by_velocity: Vec<u32>,
    /// The axes that move each link.
    pub(crate) axis_paths: AxisPaths,
    /// For each entry of `axis_paths`, its place in the mass matrix; empty if no joint is geared.
    pub(crate) mass_terms: Vec<MassTerm>,
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
        let gears = resolve_gears(&links)?;
        check_masses(&links, &gears)?;
        let mut tree = Tree {
            nodes: Vec::with_capacity(links.len()),
            dofs: vec![],
            positions: 0,
            rows: vec![0],
            columns: vec![],
            last: vec![],
            links: vec![],
            axes: vec![],
            axes_by_velocity: vec![],
            axis_paths: AxisPaths::default(),
            mass_terms: vec![],
        };
        // The first position and velocity of each independent joint. They are numbered when the first joint that they
        // move is reached, so that they precede those of all links that they carry.
        let mut starts: Vec<Option<(usize, usize)>> = vec![None; links.len()];
        for (link, gear) in links.iter().zip(&gears) {
            let start = *starts[gear.leader].get_or_insert_with(|| tree.add_velocities(&links[gear.leader]));
            tree.push(link, gear, start);
        }
        for (i, (link, gear)) in links.iter().zip(&gears).enumerate().filter(|(i, (_, gear))| gear.leader != *i) {
            tree.dofs[tree.nodes[i].velocity].add_joint(link, gear);
        }
        tree.links = links;
        tree.find_paths();
        Ok(tree)
    }

    /// Adds the velocities and positions of an independent joint; returns the indices of the first position and the
    /// first velocity.
    fn add_velocities(&mut self, link: &Link) -> (usize, usize) {
        let start = (self.positions, self.dofs.len());
        let velocities = link.joint.velocities();
        let [low, high] = link.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let &Link { armature, damping, friction, .. } = link;
        for k in 0..velocities {
            let position = if velocities == 1 { self.positions as u32 } else { NO_INDEX };
            let turning = turning_of(&link.joint, k);
            let (first_axis, end_axis) = (0, 0);
            self.dofs.push(Dof { armature, damping, friction, turning, low, high, position, first_axis, end_axis });
        }
        self.positions += link.joint.positions();
        start
    }

    fn push(&mut self, link: &Link, gear: &ResolvedGear, (position, velocity): (usize, usize)) {
        let (rotation, place) = pose_arrays(&link.frame);
        let (kind, axis) = match link.joint {
            Joint::Fixed => (TreeJointKind::Fixed, ZERO),
            Joint::Revolute(axis) => (TreeJointKind::Revolute, axis.into()),
            Joint::Prismatic(axis) => (TreeJointKind::Prismatic, axis.into()),
            Joint::Spherical => (TreeJointKind::Spherical, ZERO),
            Joint::Free => (TreeJointKind::Free, ZERO),
        };
        let (node, velocities, first) = (self.nodes.len(), link.joint.velocities(), self.axes.len());
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
            position,
            velocity,
            velocities,
            first_axis: first,
            gear: NodeGear { geared: gear.leader != node, ratio: gear.ratio, offset: gear.offset },
        });
        let velocities = velocity..velocity + velocities;
        self.axes.extend(velocities.map(|d| TreeAxis { velocity: d as u32, node: node as u32 }));
        self.axis_paths.push(link.parent, first..self.axes.len());
    }

    /// Computes the paths of velocities, and where the products of axes belong in the mass matrix.
    fn find_paths(&mut self) {
        let mut sorted: Vec<u32> = (0..self.axes.len() as u32).collect();
        sorted.sort_by_key(|axis| self.axes[*axis as usize].velocity);
        let mut first = 0;
        for (d, dof) in self.dofs.iter_mut().enumerate() {
            let count = sorted[first..].iter().take_while(|a| self.axes[**a as usize].velocity as usize == d).count();
            (dof.first_axis, dof.end_axis) = (first, first + count);
            first += count;
        }
        self.axes_by_velocity = sorted;
        let parents = elimination_parents(self.dofs.len(), &self.axis_paths, &self.axes);
        for (d, parent) in parents.into_iter().enumerate() {
            if parent != NO_INDEX {
                let (a, b) = (self.rows[parent as usize], self.rows[parent as usize + 1]);
                self.columns.extend_from_within(a..b);
            }
            self.columns.push(d as u32);
            self.rows.push(self.columns.len());
        }
        let last = |link: usize| {
            let moving = self.axis_paths.of_link(link).iter().map(|axis| self.axes[*axis as usize].velocity);
            moving.max().unwrap_or(NO_INDEX)
        };
        self.last = (0..self.nodes.len()).map(last).collect();
        if self.nodes.iter().any(|node| node.gear.geared) {
            self.mass_terms = self.axis_paths.mass_terms(&self.axes, &self.rows, &self.columns);
        }
    }

    /// Returns the indices of the axes that a velocity moves.
    #[inline(always)]
    pub(crate) fn axes_of(&self, velocity: usize) -> &[u32] {
        let dof = &self.dofs[velocity];
        &self.axes_by_velocity[dof.first_axis..dof.end_axis]
    }

    /// Returns the link to which an axis belongs.
    #[inline(always)]
    pub(crate) fn node_of(&self, axis: u32) -> &TreeNode {
        &self.nodes[self.axes[axis as usize].node as usize]
    }

    /// Moves a geared link to another offset from its leader, rad or m, for example to close a gap gradually. Limits
    /// remain those of the offset with which the tree was created. Does nothing for other links.
    pub fn set_gear_offset(&mut self, link: usize, offset: f64) {
        if let Some(node) = self.nodes.get_mut(link).filter(|node| node.gear.geared && offset.is_finite()) {
            node.gear.offset = offset;
        }
    }

    /// Returns the ratio and offset, rad or m, with which the position of a geared link follows the position that
    /// [`offsets`](Self::offsets) gives, or `None` if the link is not geared.
    pub fn gear(&self, link: usize) -> Option<(f64, f64)> {
        self.nodes.get(link).filter(|node| node.gear.geared).map(|node| (node.gear.ratio, node.gear.offset))
    }

    /// Returns the links as passed to [`Tree::new`].
    pub fn links(&self) -> &[Link] {
        &self.links
    }
    /// Returns the number of positions of a state.
    pub fn positions(&self) -> usize {
        self.positions
    }
    /// Returns the number of axes of all joints: those of geared joints, and one for each velocity.
    pub fn axes(&self) -> usize {
        self.axes.len()
    }
    /// Returns the number of velocities of a state, which is the number of degrees of freedom.
    pub fn velocities(&self) -> usize {
        self.dofs.len()
    }
    /// Returns the indices of a link's first position and first velocity in a state, or `None` if there is no such
    /// link. For a geared link, they are those of its leader.
    pub fn offsets(&self, link: usize) -> Option<(usize, usize)> {
        self.nodes.get(link).map(|n| (n.position, n.velocity))
    }
    /// Returns the index of a link's first axis, or `None` if there is no such link.
    pub fn axis(&self, link: usize) -> Option<usize> {
        self.nodes.get(link).map(|n| n.first_axis)
    }
    /// Returns the number of structurally nonzero entries in the lower triangle of the mass matrix, including the
    /// diagonal.
    pub(crate) fn entries(&self) -> usize {
        self.columns.len()
    }
}

/// Returns [`Tree::turning`] of a velocity of a joint of its own.
fn turning_of(joint: &Joint, velocity: usize) -> f64 {
    match joint {
        Joint::Revolute(_) | Joint::Spherical => 1.0,
        Joint::Free if velocity >= 3 => 1.0,
        Joint::Prismatic(_) => 1.0 / LEVER_LENGTH,
        Joint::Fixed | Joint::Free => 0.0,
    }
}

/// Returns an error if a joint and those geared to it move no mass, because its acceleration would be undefined.
fn check_masses(links: &[Link], gears: &[ResolvedGear]) -> Result<(), TreeError> {
    let mut carried: Vec<f64> = links.iter().map(|l| l.mass).collect();
    for i in (0..links.len()).rev() {
        if let Some(parent) = links[i].parent {
            carried[parent] += carried[i];
        }
    }
    let mut moves = vec![false; links.len()];
    for (i, gear) in gears.iter().enumerate() {
        moves[gear.leader] |= gear.ratio != 0.0 && (carried[i] != 0.0 || links[i].armature != 0.0);
    }
    let massless = |i: &usize| links[*i].joint.velocities() > 0 && gears[*i].leader == *i && !moves[*i];
    (0..links.len()).rev().find(massless).map_or(Ok(()), |link| Err(TreeError::Massless { link }))
}

/// Returns the rotation and translation of a pose as plain arrays.
fn pose_arrays(pose: &Isometry3<f64>) -> (Mat3, Vec3) {
    let q = pose.rotation.quaternion();
    let q: Quat = normalized([q.w, q.i, q.j, q.k]);
    (rotation_of(q), pose.translation.vector.into())
}
