//! Mass matrix, bias forces, inverse and forward dynamics of a tree, for control and planning.

use nalgebra::Vector3;

use crate::{
    composite::MassMatrix,
    error::{DynamicsError, check},
    factor::SparseFactor,
    kinematics::Kinematics,
    newton_euler::NewtonEuler,
    state::TreeState,
    tree::Tree,
    vector::Vec3,
};

/// The dynamics of a tree in a given state.
///
/// Call [`update`](Self::update) with a state before the other functions. Only [`new`](Self::new) allocates memory.
/// Armatures are included in the mass matrix. Damping, dry friction and limits are ignored; only
/// [`TreeSolver`](crate::TreeSolver) applies them.
#[derive(Debug, Clone)]
pub struct Dynamics {
    kinematics: Kinematics,
    mass: MassMatrix,
    factor: SparseFactor,
    factored: bool,
    newton_euler: NewtonEuler,
    v: Vec<f64>,
    zeros: Vec<f64>,
    none: Vec<bool>,
    work: Vec<f64>,
}

impl Dynamics {
    /// Allocates the memory for a tree. Until the first update, all its joints are at position 0 and at rest.
    pub fn new(tree: &Tree) -> Self {
        let n = tree.velocities();
        let kinematics = Kinematics::new(tree);
        let mut mass = MassMatrix::new(tree);
        mass.update(tree, &kinematics);
        Dynamics {
            kinematics,
            mass,
            factor: SparseFactor::new(tree),
            factored: false,
            newton_euler: NewtonEuler::new(tree),
            v: vec![0.0; n],
            zeros: vec![0.0; n],
            none: vec![false; n],
            work: vec![0.0; n],
        }
    }

    /// Computes poses, velocities and mass matrix for a state.
    ///
    /// # Errors
    ///
    /// Fails if the state or this object has a size that does not match the tree, or a value is not finite.
    pub fn update(&mut self, tree: &Tree, state: &TreeState) -> Result<(), DynamicsError> {
        self.kinematics.update(tree, state)?;
        self.v.copy_from_slice(&state.v);
        self.mass.update(tree, &self.kinematics);
        self.factored = false;
        Ok(())
    }

    /// Returns poses, velocities and Jacobians of the links.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Writes the mass matrix M in row-major order, with one row and column per velocity; kg m², kg m or kg.
    ///
    /// # Errors
    ///
    /// Fails if the length of `out` is not the square of the number of velocities, or this object was created for a
    /// tree of another size.
    pub fn mass_matrix(&self, tree: &Tree, out: &mut [f64]) -> Result<(), DynamicsError> {
        self.kinematics.check_tree(tree)?;
        let n = tree.velocities();
        if out.len() != n * n {
            return Err(DynamicsError::Length { what: "out", found: out.len(), expected: n * n });
        }
        out.fill(0.0);
        for i in 0..n {
            for k in tree.rows[i]..tree.rows[i + 1] {
                let j = tree.columns[k] as usize;
                out[i * n + j] = self.mass.entries[k];
                out[j * n + i] = self.mass.entries[k];
            }
        }
        Ok(())
    }

    /// Writes the bias forces b, Nm or N: the forces at zero acceleration, which balance gravity (m/s²), Coriolis and
    /// centrifugal forces. Complexity: linear in the number of links.
    ///
    /// # Errors
    ///
    /// Fails if `out` does not have one entry per velocity, this object was created for a tree of another size, or
    /// gravity is not finite.
    pub fn bias(&mut self, tree: &Tree, gravity: Vector3<f64>, out: &mut [f64]) -> Result<(), DynamicsError> {
        let gravity = self.check_arguments(tree, gravity, out)?;
        self.newton_euler.compute_forces(tree, &self.kinematics, &self.v, None, gravity, out);
        Ok(())
    }

    /// Writes the generalised forces M a + b, Nm or N, that cause the accelerations a, rad/s² or m/s². Complexity:
    /// linear in the number of links.
    ///
    /// # Errors
    ///
    /// Fails like [`bias`](Self::bias), and if `acceleration` has the wrong length or is not finite.
    pub fn inverse(
        &mut self,
        tree: &Tree,
        acceleration: &[f64],
        gravity: Vector3<f64>,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        let gravity = self.check_arguments(tree, gravity, out)?;
        check("acceleration", acceleration, tree.velocities())?;
        self.newton_euler.compute_forces(tree, &self.kinematics, &self.v, Some(acceleration), gravity, out);
        for ((out, a), dof) in out.iter_mut().zip(acceleration).zip(&tree.dofs) {
            *out += dof.armature * a;
        }
        Ok(())
    }

    /// Writes the accelerations a, rad/s² or m/s², under generalised forces, Nm or N: the solution of M a = force - b.
    /// Complexity: number of links plus the sum of depths; for the first call after an update, which factorises the
    /// matrix, at most the sum of squared depths.
    ///
    /// # Errors
    ///
    /// Fails like [`bias`](Self::bias), and if `force` has the wrong length or is not finite. Fails with
    /// [`DynamicsError::Singular`] if the links that a joint moves have no inertia about its axis.
    pub fn forward(
        &mut self,
        tree: &Tree,
        force: &[f64],
        gravity: Vector3<f64>,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        let gravity = self.check_arguments(tree, gravity, out)?;
        check("force", force, tree.velocities())?;
        self.factorize(tree)?;
        self.newton_euler.compute_forces(tree, &self.kinematics, &self.v, None, gravity, out);
        for (out, force) in out.iter_mut().zip(force) {
            *out = force - *out;
        }
        self.factor.solve(tree, out);
        Ok(())
    }

    /// Replaces `x` by the solution y of M y = x, for example impulses by the velocity changes that they cause.
    /// Complexity: that of [`forward`](Self::forward).
    ///
    /// # Errors
    ///
    /// Fails if `x` does not have one entry per velocity or is not finite, or this object was created for a tree of
    /// another size. Fails with [`DynamicsError::Singular`] like [`forward`](Self::forward).
    pub fn solve(&mut self, tree: &Tree, x: &mut [f64]) -> Result<(), DynamicsError> {
        self.kinematics.check_tree(tree)?;
        check("x", x, tree.velocities())?;
        self.factorize(tree)?;
        self.factor.solve(tree, x);
        Ok(())
    }

    /// Returns the kinetic energy, including that of armatures, and the potential energy, which is 0 at the world's
    /// origin, both in J.
    ///
    /// # Errors
    ///
    /// Fails if this object was created for a tree of another size, or gravity is not finite.
    pub fn energy(&mut self, tree: &Tree, gravity: Vector3<f64>) -> Result<(f64, f64), DynamicsError> {
        let mut work = std::mem::take(&mut self.work);
        let ready = self.check_arguments(tree, gravity, &work);
        if let Ok(gravity) = ready {
            self.newton_euler.compute_forces(tree, &self.kinematics, &self.v, None, gravity, &mut work);
        }
        self.work = work;
        let gravity = ready?;
        let mut kinetic = self.newton_euler.kinetic_energy(&self.kinematics);
        for (dof, v) in tree.dofs.iter().zip(&self.v) {
            kinetic += 0.5 * dof.armature * v * v;
        }
        Ok((kinetic, self.kinematics.potential_energy(gravity)))
    }

    fn factorize(&mut self, tree: &Tree) -> Result<(), DynamicsError> {
        if !self.factored {
            let result = self.factor.update(tree, &self.mass.entries, &self.zeros, &self.none);
            result.map_err(|dof| DynamicsError::Singular { dof })?;
            self.factored = true;
        }
        Ok(())
    }

    fn check_arguments(&self, tree: &Tree, gravity: Vector3<f64>, out: &[f64]) -> Result<Vec3, DynamicsError> {
        self.kinematics.check_tree(tree)?;
        let (found, expected) = (out.len(), tree.velocities());
        if found != expected {
            return Err(DynamicsError::Length { what: "out", found, expected });
        }
        if !gravity.iter().all(|x| x.is_finite()) {
            return Err(DynamicsError::NotFinite { what: "gravity" });
        }
        Ok(gravity.into())
    }
}
