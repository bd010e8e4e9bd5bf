//! The drives, springs and external forces with which users act on the joints of a tree.

use crate::{
    error::{DynamicsError, check},
    paths::NO_INDEX,
    tree::Tree,
};

/// The force limits of a drive, which are the same in both directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceBound {
    /// Maximum force, Nm or N; may be infinite.
    pub force: f64,
    /// Speed up to which the full force is available, rad/s or m/s; infinite: at any speed.
    pub full_speed: f64,
    /// Speed above which no accelerating force is available; between `full_speed` and this speed, the force decreases
    /// linearly. The full force is always available for braking. Infinite if `full_speed` is infinite.
    pub no_load_speed: f64,
}

impl ForceBound {
    /// Unlimited force at all speeds.
    pub const NONE: ForceBound = ForceBound::force(f64::INFINITY);

    /// Returns a bound with the same force, Nm or N, at all speeds.
    pub const fn force(force: f64) -> Self {
        ForceBound { force, full_speed: f64::INFINITY, no_load_speed: f64::INFINITY }
    }

    /// Returns the bound of a motor whose maximum force decreases linearly from `force` at rest to 0 at
    /// `no_load_speed`.
    pub const fn motor(force: f64, no_load_speed: f64) -> Self {
        ForceBound { force, full_speed: 0.0, no_load_speed }
    }
}

/// The drive that acts on one axis of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DofDrive {
    /// No drive.
    Off,
    /// Holds a velocity with the force that this requires, limited to the bound.
    Velocity {
        /// Velocity to hold, rad/s or m/s.
        target: f64,
        /// Limits of the force.
        bound: ForceBound,
    },
    /// Acts like a spring and a damper, with the force `stiffness (target - q) + damping (velocity - v)`, limited to
    /// the bound. Only for revolute and prismatic joints.
    Position {
        /// Target position, rad or m.
        target: f64,
        /// Target velocity, rad/s or m/s.
        velocity: f64,
        /// Stiffness, Nm/rad or N/m.
        stiffness: f64,
        /// Damping, Nm s/rad or N s/m.
        damping: f64,
        /// Limits of the force.
        bound: ForceBound,
    },
    /// Exerts a force, limited to the bound.
    Force {
        /// Desired force, Nm or N.
        force: f64,
        /// Limits of the force.
        bound: ForceBound,
    },
}

/// A spring and a damper at a revolute or prismatic joint, in addition to its drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointSpring {
    /// Position at which the spring is relaxed, rad or m.
    pub rest: f64,
    /// Stiffness, Nm/rad or N/m.
    pub stiffness: f64,
    /// Damping, Nm s/rad or N s/m.
    pub damping: f64,
}

/// All drives, springs and external forces that act on the joints of a tree. Drives and springs of geared joints act in
/// addition to those of their leaders.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeDrives {
    /// The drive of each axis: see [`Tree::axis`].
    pub drive: Vec<DofDrive>,
    /// The spring of each axis.
    pub spring: Vec<JointSpring>,
    /// External generalised forces, Nm or N, one per velocity; see
    /// [`Kinematics::add_force`](crate::Kinematics::add_force).
    pub force: Vec<f64>,
}

impl TreeDrives {
    /// Returns drives that are off, springs without stiffness, and zero forces.
    pub fn new(tree: &Tree) -> Self {
        let n = tree.axes();
        let force = vec![0.0; tree.velocities()];
        TreeDrives { drive: vec![DofDrive::Off; n], spring: vec![JointSpring::default(); n], force }
    }

    /// Returns an error if an array does not have one entry per axis, or velocity, a value is not finite, a gain is
    /// negative, a bound is invalid, or a spring or position drive acts on a joint with several velocities.
    pub(crate) fn check(&self, tree: &Tree) -> Result<(), DynamicsError> {
        let expected = tree.axes();
        for (what, found) in [("drive", self.drive.len()), ("spring", self.spring.len())] {
            if found != expected {
                return Err(DynamicsError::Length { what, found, expected });
            }
        }
        check("force", &self.force, tree.velocities())?;
        for (dof, (drive, spring)) in self.drive.iter().zip(&self.spring).enumerate() {
            let has_position = tree.dofs[tree.axes[dof].velocity as usize].position != NO_INDEX;
            drive.check(dof, has_position)?;
            if *spring != JointSpring::default() {
                check_numbers(
                    dof,
                    &[("rest", spring.rest)],
                    &[("stiffness", spring.stiffness), ("damping", spring.damping)],
                )?;
                if !has_position {
                    return Err(DynamicsError::Drive { dof, what: "spring", why: "requires a single-axis joint" });
                }
            }
        }
        Ok(())
    }
}

impl DofDrive {
    /// Returns the drive that has the same effect on the leader of a geared joint.
    pub(crate) fn through_gear(&self, ratio: f64, offset: f64) -> DofDrive {
        if ratio == 0.0 {
            return DofDrive::Off;
        }
        let on_leader = |bound: ForceBound| ForceBound {
            force: ratio.abs() * bound.force,
            full_speed: bound.full_speed / ratio.abs(),
            no_load_speed: bound.no_load_speed / ratio.abs(),
        };
        match *self {
            DofDrive::Off => DofDrive::Off,
            DofDrive::Velocity { target, bound } => {
                DofDrive::Velocity { target: target / ratio, bound: on_leader(bound) }
            }
            DofDrive::Position { target, velocity, stiffness, damping, bound } => DofDrive::Position {
                target: (target - offset) / ratio,
                velocity: velocity / ratio,
                stiffness: ratio * ratio * stiffness,
                damping: ratio * ratio * damping,
                bound: on_leader(bound),
            },
            DofDrive::Force { force, bound } => DofDrive::Force { force: ratio * force, bound: on_leader(bound) },
        }
    }

    fn check(&self, dof: usize, has_position: bool) -> Result<(), DynamicsError> {
        let bound = match self {
            DofDrive::Off => return Ok(()),
            DofDrive::Velocity { target, bound } => {
                check_numbers(dof, &[("target", *target)], &[])?;
                bound
            }
            DofDrive::Position { target, velocity, stiffness, damping, bound } => {
                let gains = [("stiffness", *stiffness), ("damping", *damping)];
                check_numbers(dof, &[("target", *target), ("velocity", *velocity)], &gains)?;
                if !has_position {
                    return Err(DynamicsError::Drive { dof, what: "target", why: "requires a single-axis joint" });
                }
                bound
            }
            DofDrive::Force { force, bound } => {
                check_numbers(dof, &[("force", *force)], &[])?;
                bound
            }
        };
        let wrong = |what, why| Err(DynamicsError::Drive { dof, what, why });
        if bound.force.is_nan() || bound.force < 0.0 {
            return wrong("bound.force", "must not be negative");
        }
        if bound.full_speed.is_nan() || bound.full_speed < 0.0 {
            return wrong("bound.full_speed", "must not be negative");
        }
        let (full, none) = (bound.full_speed, bound.no_load_speed);
        if none.is_nan() || (full.is_finite() && none <= full) || (full.is_infinite() && none.is_finite()) {
            return wrong("bound.no_load_speed", "must exceed `bound.full_speed`, and be infinite if that is infinite");
        }
        if full.is_finite() && (none.is_infinite() || bound.force.is_infinite()) {
            return wrong("bound.no_load_speed", "must be finite, as must `force`, because `full_speed` is finite");
        }
        Ok(())
    }
}

/// Returns an error if a value is not finite, or a gain is negative.
fn check_numbers(dof: usize, any: &[(&'static str, f64)], gains: &[(&'static str, f64)]) -> Result<(), DynamicsError> {
    for &(what, x) in any.iter().chain(gains) {
        if !x.is_finite() {
            return Err(DynamicsError::Drive { dof, what, why: "must be finite" });
        }
    }
    match gains.iter().find(|(_, x)| *x < 0.0) {
        Some(&(what, _)) => Err(DynamicsError::Drive { dof, what, why: "must not be negative" }),
        None => Ok(()),
    }
}
