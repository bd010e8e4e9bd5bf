//! Poses and velocities of links, and the Jacobians of their points.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::{
    error::{DynamicsError, check},
    paths::NO_INDEX,
    spatial::{SpatialForce, SpatialInertia, SpatialMotion},
    state::{TreeState, quaternion},
    tree::{Tree, TreeJointKind, TreeNode},
    vector::{
        IDENTITY, Mat3, Vec3, ZERO, add, column, cross, dot, product, quaternion_of, rotation, rotation_of, scale, sub,
        turn, turned_about,
    },
};

/// Poses of all links, axes of all velocities and inertias in world axes, for one state.
///
/// Positions are stored relative to `origin`, a point at the root of the tree, so that no precision is lost for a robot
/// far from the origin of the world.
#[derive(Debug, Clone)]
pub struct Kinematics {
    pub(crate) origin: Vec3,
    pub(crate) rotations: Vec<Mat3>,
    pub(crate) places: Vec<Vec3>,
    /// For each axis, the motion that it causes when its velocity is 1; for a geared joint, that of its leader.
    pub(crate) axes: Vec<SpatialMotion>,
    pub(crate) inertias: Vec<SpatialInertia>,
    /// Velocity of each link, as set by `update`.
    motions: Vec<SpatialMotion>,
}

impl Kinematics {
    /// Allocates the memory for a tree, with all joints at position 0.
    pub fn new(tree: &Tree) -> Self {
        let n = tree.nodes.len();
        let mut out = Kinematics {
            origin: ZERO,
            rotations: vec![IDENTITY; n],
            places: vec![ZERO; n],
            axes: vec![SpatialMotion::default(); tree.axes()],
            inertias: vec![SpatialInertia::default(); n],
            motions: vec![SpatialMotion::default(); n],
        };
        let rest = TreeState::new(tree);
        out.place(tree, &rest.q);
        out
    }

    /// Computes poses and velocities of all links. Complexity: linear in the number of links.
    ///
    /// # Errors
    ///
    /// Fails if the state or this object has a size that does not match the tree, or a value is not finite.
    pub fn update(&mut self, tree: &Tree, state: &TreeState) -> Result<(), DynamicsError> {
        self.check_tree(tree)?;
        state.check(tree)?;
        self.place(tree, &state.q);
        for (i, node) in tree.nodes.iter().enumerate() {
            let mut motion =
                if node.parent == NO_INDEX { SpatialMotion::default() } else { self.motions[node.parent as usize] };
            for (axis, v) in self.axes[node.axes()].iter().zip(&state.v[node.range()]) {
                motion = motion.plus(axis.times(*v));
            }
            self.motions[i] = motion;
        }
        Ok(())
    }

    /// Returns the pose of a link's frame in the world, m, or `None` if there is no such link.
    pub fn pose(&self, link: usize) -> Option<Isometry3<f64>> {
        let place = add(self.origin, *self.places.get(link)?);
        let [w, x, y, z] = quaternion_of(&self.rotations[link]);
        let turned = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        Some(Isometry3::from_parts(Translation3::from(Vector3::from(place)), turned))
    }

    /// Returns the angular velocity of a link, rad/s, and the velocity of one of its points, m/s, both in world axes;
    /// the point is in the world frame, m. Returns `None` if there is no such link.
    pub fn velocity(&self, link: usize, point: Vector3<f64>) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let motion = self.motions.get(link)?;
        let arm = sub(point.into(), self.origin);
        Some((motion.angular.into(), add(motion.linear, cross(motion.angular, arm)).into()))
    }

    /// Writes the Jacobian of a point of a link, given in the world frame, m, in row-major order: 6 rows, with one
    /// column per velocity. The first three rows yield the point's velocity, m/s, the others the link's angular
    /// velocity, rad/s, in world axes. Complexity: linear in the number of velocities.
    ///
    /// Column j is the motion that a unit velocity j causes: the sum of the axes on the path from the root to the link
    /// that it moves.
    ///
    /// # Errors
    ///
    /// Fails if there is no such link, this object was created for a tree of another size, or the length of `out` is
    /// not 6 times the number of velocities.
    pub fn jacobian(
        &self,
        tree: &Tree,
        link: usize,
        point: Vector3<f64>,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        let n = tree.velocities();
        let chain = self.chain(tree, link)?;
        if out.len() != 6 * n {
            return Err(DynamicsError::Length { what: "out", found: out.len(), expected: 6 * n });
        }
        out.fill(0.0);
        let arm = sub(point.into(), self.origin);
        for &axis in chain {
            let d = tree.axes[axis as usize].velocity as usize;
            let axis = &self.axes[axis as usize];
            let linear = add(axis.linear, cross(axis.angular, arm));
            for k in 0..3 {
                out[k * n + d] += linear[k];
                out[(3 + k) * n + d] += axis.angular[k];
            }
        }
        Ok(())
    }

    /// Adds to `out` the generalised forces, Nm or N, of a force, N, at a point of a link, m, and of a torque, Nm, all
    /// in the world frame: the product of the transposed Jacobian and the wrench. Complexity: depth of the link.
    ///
    /// # Errors
    ///
    /// Fails if there is no such link, this object was created for a tree of another size, `out` does not have one
    /// entry per velocity, or a value is not finite.
    pub fn add_force(
        &self,
        tree: &Tree,
        link: usize,
        point: Vector3<f64>,
        force: Vector3<f64>,
        torque: Vector3<f64>,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        let chain = self.chain(tree, link)?;
        check("out", out, tree.velocities())?;
        if !point.iter().chain(force.iter()).chain(torque.iter()).all(|x| x.is_finite()) {
            return Err(DynamicsError::NotFinite { what: "force" });
        }
        let arm = sub(point.into(), self.origin);
        let wrench = SpatialForce { torque: add(torque.into(), cross(arm, force.into())), force: force.into() };
        for &axis in chain {
            out[tree.axes[axis as usize].velocity as usize] += self.axes[axis as usize].dot(&wrench);
        }
        Ok(())
    }

    /// Returns an error if the tree has a different size from the one for which this object was created.
    pub(crate) fn check_tree(&self, tree: &Tree) -> Result<(), DynamicsError> {
        let (found, expected) = (self.places.len(), tree.nodes.len());
        if found != expected {
            return Err(DynamicsError::Length { what: "links", found, expected });
        }
        let (found, expected) = (self.axes.len(), tree.axes());
        if found != expected {
            return Err(DynamicsError::Length { what: "axes", found, expected });
        }
        Ok(())
    }

    /// Returns the indices of the axes that move a link, starting at the root.
    fn chain<'a>(&self, tree: &'a Tree, link: usize) -> Result<&'a [u32], DynamicsError> {
        self.check_tree(tree)?;
        if link >= tree.nodes.len() {
            return Err(DynamicsError::NoLink { link, links: tree.nodes.len() });
        }
        Ok(tree.axis_paths.of_link(link))
    }

    /// Returns the motion of a link per unit of velocity `d`.
    #[inline]
    pub(crate) fn motion_per_velocity(&self, tree: &Tree, link: usize, d: u32) -> SpatialMotion {
        if tree.mass_terms.is_empty() {
            return self.axes[d as usize];
        }
        let path = tree.axis_paths.of_link(link);
        let moving = tree.axes_of(d as usize).iter().filter(|axis| path.binary_search(axis).is_ok());
        moving.fold(SpatialMotion::default(), |sum, axis| sum.plus(self.axes[*axis as usize]))
    }

    /// Returns the potential energy under gravity, m/s², which is 0 at the world's origin, J.
    pub(crate) fn potential_energy(&self, gravity: Vec3) -> f64 {
        let lever = |inertia: &SpatialInertia| add(inertia.first, scale(self.origin, inertia.mass));
        -self.inertias.iter().map(|inertia| dot(gravity, lever(inertia))).sum::<f64>()
    }

    /// Computes poses, axes and inertias from positions.
    pub(crate) fn place(&mut self, tree: &Tree, q: &[f64]) {
        let root = &tree.nodes[0];
        let origin = match root.kind {
            TreeJointKind::Free => [q[0], q[1], q[2]],
            _ => root.place,
        };
        self.origin = origin;
        for (i, node) in tree.nodes.iter().enumerate() {
            let (above, base) = if node.parent == NO_INDEX {
                (&IDENTITY, sub(ZERO, origin))
            } else {
                (&self.rotations[node.parent as usize], self.places[node.parent as usize])
            };
            let joint = node.position;
            let position = || if node.gear.geared { node.gear.ratio * q[joint] + node.gear.offset } else { q[joint] };
            let mut place = add(base, turn(above, node.place));
            let turned = match node.kind {
                TreeJointKind::Fixed => product(above, &node.rotation),
                TreeJointKind::Revolute => {
                    let axis = turn(above, node.axis_in_parent);
                    self.axes[node.first_axis] = SpatialMotion { angular: axis, linear: cross(place, axis) };
                    let (sine, cosine) = libm::sincos(position());
                    let before = if node.straight { *above } else { product(above, &node.rotation) };
                    match node.coordinate {
                        Some((axis, sign)) => turned_about(&before, axis, sign * sine, cosine),
                        None => product(&before, &rotation(node.axis, sine, cosine)),
                    }
                }
                TreeJointKind::Prismatic => {
                    let axis = turn(above, node.axis_in_parent);
                    self.axes[node.first_axis] = SpatialMotion { angular: ZERO, linear: axis };
                    place = add(place, scale(axis, position()));
                    product(above, &node.rotation)
                }
                TreeJointKind::Spherical => {
                    let own = rotation_of(quaternion(q, joint));
                    let turned = product(&product(above, &node.rotation), &own);
                    self.turn_axes(node.first_axis, &turned, place);
                    turned
                }
                TreeJointKind::Free => {
                    place = sub([q[joint], q[joint + 1], q[joint + 2]], origin);
                    let turned = rotation_of(quaternion(q, joint + 3));
                    for k in 0..3 {
                        let mut linear = ZERO;
                        linear[k] = 1.0;
                        self.axes[node.first_axis + k] = SpatialMotion { angular: ZERO, linear };
                    }
                    self.turn_axes(node.first_axis + 3, &turned, place);
                    turned
                }
            };
            if node.gear.geared {
                self.axes[node.first_axis] = self.axes[node.first_axis].times(node.gear.ratio);
            }
            self.rotations[i] = turned;
            self.places[i] = place;
            self.inertias[i] = inertia(node, &turned, place);
        }
    }

    /// Sets the axes of three velocities to those of a rotation of a link about its origin.
    fn turn_axes(&mut self, first: usize, turned: &Mat3, place: Vec3) {
        for k in 0..3 {
            let axis = column(turned, k);
            self.axes[first + k] = SpatialMotion { angular: axis, linear: cross(place, axis) };
        }
    }
}

/// Returns a link's inertia about the common origin in world axes (Featherstone, chapter 2).
#[inline(always)]
fn inertia(node: &TreeNode, turned: &Mat3, place: Vec3) -> SpatialInertia {
    let m = node.mass;
    let c = add(place, turn(turned, node.center));
    let t = product(turned, &node.inertia);
    let own = |i: usize, j: usize| {
        t[3 * i] * turned[3 * j] + t[3 * i + 1] * turned[3 * j + 1] + t[3 * i + 2] * turned[3 * j + 2]
    };
    let square = dot(c, c);
    SpatialInertia {
        mass: m,
        first: scale(c, m),
        second: [
            own(0, 0) + m * (square - c[0] * c[0]),
            own(1, 1) + m * (square - c[1] * c[1]),
            own(2, 2) + m * (square - c[2] * c[2]),
            own(0, 1) - m * c[0] * c[1],
            own(0, 2) - m * c[0] * c[2],
            own(1, 2) - m * c[1] * c[2],
        ],
    }
}
