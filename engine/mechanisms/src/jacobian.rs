//! Jacobian rows of contacts, which map the velocities of trees to those of contact points.
//!
//! With M = L'DL and z = L v, a row J becomes y = L^-T J', which is 0 except on the path from the body to the root. An
//! impulse l along the row changes z by D^-1 y l, and the velocity of the row is y.z. The cost of a sweep is therefore
//! the sum of the depths of the rows, not of the numbers of velocities. The same holds for the matrix of a step with
//! stiff drives and springs, which [`PivotSolver`](crate::pivot::PivotSolver) factorises.
//!
//! Source: Featherstone, chapter 6, for the sparsity; `docs/mechanisms.md` derives the rest.

use crate::{
    contact::{ContactPoint, ContactSide},
    factor::SparseFactor,
    island_tree::IslandTree,
    paths::NO_INDEX,
    spatial::SpatialForce,
    tree::Tree,
    vector::{Vec3, ZERO, add, cross, dot, scale, sub},
};

/// Minimum response of a contact along its normal, relative to that of the two links without joints; a contact with a
/// smaller response transmits no force. The first value is for contacts of different trees or with other bodies, the
/// second for contacts between links of the same tree.
///
/// If the joints hardly allow motion along the normal, as between a drawer and its rails, even a slight tilt of the
/// normal would cause very large forces, whose residuals after the sweeps would move the whole body. The second value
/// corresponds to a tilt of 0.6 degrees.
const MIN_RESPONSE: [f64; 2] = [1e-9, 1e-4];

/// Maximum distance at which a contact touches, m. A body that rests on some contacts would otherwise never load others
/// that are apart by rounding only, and its weight would not be distributed evenly.
const MAX_TOUCH_DISTANCE: f64 = 1e-7;

/// The part of a row that belongs to one tree: a range of columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HalfRow {
    pub member: usize,
    pub first: usize,
    pub end: usize,
}

/// The three rows of one contact: along the normal and two tangents.
#[derive(Debug, Clone)]
pub(crate) struct ContactRows {
    pub halves: [Option<HalfRow>; 2],
    pub axes: [Vec3; 3],
    /// Distance after half a step at the initial velocities, m.
    pub distance: f64,
    /// Velocity along the normal at the start of the step, m/s.
    pub approach: f64,
    /// Velocity of each row due to bodies that are not links, m/s.
    pub drift: Vec3,
    /// Minimum response of the normal, 1/kg; a smaller response is treated as 0.
    min_response: f64,
    /// Response of the normal: velocity per impulse, 1/kg.
    pub normal: f64,
    /// Responses of the tangents, 1/kg: entries 11, 12 and 22 of a symmetric matrix.
    pub tangents: [f64; 3],
    /// Velocity of each row before the impulses in `z`, m/s.
    pub start: Vec3,
}

impl ContactRows {
    /// Returns the minimum velocity along the normal at the end of a step of duration `h`, m/s: bodies that are apart
    /// may approach until they touch.
    #[inline]
    pub fn min_velocity(&self, h: f64) -> f64 {
        if self.distance > MAX_TOUCH_DISTANCE { -2.0 * self.distance / h } else { 0.0 }
    }
}

/// Rows of all contacts of an island.
#[derive(Debug, Clone, Default)]
pub(crate) struct ContactJacobian {
    pub points: Vec<ContactRows>,
    pub columns: Vec<u32>,
    jacobian: Vec<Vec3>,
    pub y: Vec<Vec3>,
    /// D^-1 y of each column.
    pub response: Vec<Vec3>,
    /// Changes of z by impulses, for all members in sequence.
    pub z: Vec<f64>,
    /// Start offset of each member in `z`.
    pub offsets: Vec<usize>,
    work: Vec<Vec3>,
}

impl ContactJacobian {
    /// Builds the rows of all contacts for the current poses. `h` is the duration of the step, s.
    pub fn build(&mut self, members: &[IslandTree<'_>], contacts: &[ContactPoint], h: f64) {
        self.points.clear();
        self.columns.clear();
        self.jacobian.clear();
        self.offsets.clear();
        let mut total = 0;
        for member in members {
            self.offsets.push(total);
            total += member.tree.velocities();
        }
        self.z.clear();
        self.z.resize(total, 0.0);
        self.work.resize(self.work.len().max(total), ZERO);
        for contact in contacts {
            let point = self.point(members, contact, h);
            self.points.push(point);
        }
        self.y.clear();
        self.y.resize(self.columns.len(), ZERO);
        self.response.clear();
        self.response.resize(self.columns.len(), ZERO);
    }

    fn point(&mut self, members: &[IslandTree<'_>], contact: &ContactPoint, h: f64) -> ContactRows {
        let normal: Vec3 = contact.normal.into();
        let (first, second) = tangents(normal);
        let axes = [normal, first, second];
        let halves = self.halves(members, contact, &axes);
        let drift = axes.map(|axis| dot(contact.drift.into(), axis));
        let same = matches!(contact.sides, [Some(a), Some(b)] if a.member == b.member);
        let mobility: f64 = contact.sides.iter().flatten().map(|s| 1.0 / mass_of_link(members, *s)).sum();
        let approach = drift[0] + self.approach_velocity(&halves, members);
        ContactRows {
            halves,
            axes,
            distance: contact.distance + 0.5 * h * approach,
            approach,
            drift,
            min_response: MIN_RESPONSE[usize::from(same)] * mobility,
            normal: 0.0,
            tangents: [0.0; 3],
            start: ZERO,
        }
    }

    /// Appends the Jacobian of a contact. If both links belong to the same tree, they share a half.
    fn halves(&mut self, members: &[IslandTree<'_>], contact: &ContactPoint, axes: &[Vec3; 3]) -> [Option<HalfRow>; 2] {
        let mut halves = [None; 2];
        for (k, sign) in [(0, -1.0), (1, 1.0)] {
            let Some(side) = contact.sides[k] else { continue };
            let IslandTree { tree, solver, .. } = &members[side.member];
            let kinematics = &solver.step.kinematics;
            let arm = add(kinematics.places[side.link], contact.arms[k].into());
            let wrenches = axes.map(|axis| {
                let force = scale(axis, sign);
                SpatialForce { torque: cross(arm, force), force }
            });
            let of = |d: u32| {
                let motion = kinematics.motion_per_velocity(tree, side.link, d);
                wrenches.map(|wrench| motion.dot(&wrench))
            };
            match halves[0] {
                Some(HalfRow { member, first, .. }) if member == side.member => {
                    self.merge(first, velocities_to_root(tree, side.link), of);
                    halves[0] = Some(HalfRow { member, first, end: self.columns.len() });
                }
                _ => {
                    let first = self.columns.len();
                    for &d in velocities_to_root(tree, side.link) {
                        self.columns.push(d);
                        self.jacobian.push(of(d));
                    }
                    halves[k] = Some(HalfRow { member: side.member, first, end: self.columns.len() });
                }
            }
        }
        halves
    }

    /// Returns the Jacobian of a column: the velocities along the normal and both tangents per velocity of the member.
    pub fn jacobian(&self, column: usize) -> Vec3 {
        self.jacobian[column]
    }

    /// Merges a second path to the root into the columns from index `first`, which remain sorted.
    fn merge(&mut self, first: usize, path: &[u32], of: impl Fn(u32) -> Vec3) {
        for &d in path {
            let at = first + self.columns[first..].partition_point(|c| *c < d);
            if self.columns.get(at) == Some(&d) {
                self.jacobian[at] = add(self.jacobian[at], of(d));
            } else {
                self.columns.insert(at, d);
                self.jacobian.insert(at, of(d));
            }
        }
    }

    /// Computes y and D^-1 y of all rows on one member from a factorisation of its matrix.
    pub fn factorize(&mut self, factor: &SparseFactor, members: &[IslandTree<'_>], member: usize) {
        let tree = members[member].tree;
        for i in 0..self.points.len() {
            for half in self.points[i].halves.into_iter().flatten().filter(|h| h.member == member) {
                for k in half.first..half.end {
                    self.work[self.columns[k] as usize] = self.jacobian[k];
                }
                for k in (half.first..half.end).rev() {
                    let column = self.columns[k] as usize;
                    let own = self.work[column];
                    self.y[k] = own;
                    self.response[k] = scale(own, factor.inverse[column]);
                    for (l, above) in factor.row(tree, column) {
                        self.work[above as usize] = sub(self.work[above as usize], scale(own, l));
                    }
                }
            }
        }
    }

    /// Computes the responses of each contact from those of its halves.
    pub fn update_responses(&mut self) {
        for i in 0..self.points.len() {
            let mut sums = [0.0; 4];
            for half in self.points[i].halves.into_iter().flatten() {
                for k in half.first..half.end {
                    let (y, r) = (&self.y[k], &self.response[k]);
                    sums[0] += y[0] * r[0];
                    sums[1] += y[1] * r[1];
                    sums[2] += y[1] * r[2];
                    sums[3] += y[2] * r[2];
                }
            }
            let point = &mut self.points[i];
            point.normal = if sums[0] > point.min_response { sums[0] } else { 0.0 };
            point.tangents =
                if sums[1] + sums[3] > point.min_response { [sums[1], sums[2], sums[3]] } else { [0.0; 3] };
        }
    }

    /// Sets the velocities of rows before impulses from the members' velocities at the end of the step, and clears `z`.
    pub fn read_velocities(&mut self, members: &[IslandTree<'_>]) {
        self.z.fill(0.0);
        for i in 0..self.points.len() {
            let mut start = self.points[i].drift;
            for half in self.points[i].halves.into_iter().flatten() {
                let ends = &members[half.member].solver.step.pivot.ends;
                for k in half.first..half.end {
                    start = add(start, scale(self.jacobian[k], ends[self.columns[k] as usize]));
                }
            }
            self.points[i].start = start;
        }
    }

    /// Returns the velocity of the links along the normal at the start of the step, m/s.
    fn approach_velocity(&self, halves: &[Option<HalfRow>; 2], members: &[IslandTree<'_>]) -> f64 {
        let mut sum = 0.0;
        for half in halves.iter().flatten() {
            let v = &members[half.member].state.v;
            for k in half.first..half.end {
                sum += self.jacobian[k][0] * v[self.columns[k] as usize];
            }
        }
        sum
    }

    /// Returns the change of the velocity of a row of a contact due to the impulses so far, m/s.
    #[inline]
    pub fn velocity_change(&self, point: &ContactRows, row: usize) -> f64 {
        let mut sum = 0.0;
        for half in point.halves.iter().flatten() {
            let z = &self.z[self.offsets[half.member]..];
            for (column, y) in self.columns[half.first..half.end].iter().zip(&self.y[half.first..half.end]) {
                sum += y[row] * z[*column as usize];
            }
        }
        sum
    }

    /// Applies an impulse along a row of a contact, N s.
    #[inline]
    pub fn apply_impulse(&mut self, point: usize, row: usize, impulse: f64) {
        for half in self.points[point].halves.into_iter().flatten() {
            let z = &mut self.z[self.offsets[half.member]..];
            for (column, r) in self.columns[half.first..half.end].iter().zip(&self.response[half.first..half.end]) {
                z[*column as usize] += r[row] * impulse;
            }
        }
    }

    /// Adds the generalised forces of impulses along the rows of a contact, as mean forces over the time `h`.
    pub fn add_forces(&self, point: &ContactRows, impulse: Vec3, h: f64, members: &mut [IslandTree<'_>]) {
        for half in point.halves.iter().flatten() {
            let contact = &mut members[half.member].solver.step.contact;
            for k in half.first..half.end {
                contact[self.columns[k] as usize] += dot(self.jacobian[k], impulse) / h;
            }
        }
    }
}

/// Returns the mass of a link, kg, or that of its tree if the link has no mass.
fn mass_of_link(members: &[IslandTree<'_>], side: ContactSide) -> f64 {
    let nodes = &members[side.member].tree.nodes;
    let own = nodes[side.link].mass;
    if own > 0.0 { own } else { nodes.iter().map(|n| n.mass).sum::<f64>().max(f64::MIN_POSITIVE) }
}

/// Returns the indices of the velocities that move a link, starting at the root.
pub(crate) fn velocities_to_root(tree: &Tree, link: usize) -> &[u32] {
    match tree.last[link] {
        NO_INDEX => &[],
        d => &tree.columns[tree.rows[d as usize]..tree.rows[d as usize + 1]],
    }
}

/// Returns two unit vectors orthogonal to a unit vector and to each other.
fn tangents(normal: Vec3) -> (Vec3, Vec3) {
    // Use an axis that is not nearly parallel to the normal.
    let other = if normal[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let along = cross(normal, other);
    let first = scale(along, 1.0 / dot(along, along).sqrt());
    (first, cross(normal, first))
}
