//! What drives, springs and forces act on the joints of a tree: what its user sets.

use crate::{
    error::{DynamicsError, check},
    tree::{NONE, Tree},
};

/// What a drive can do at most, the same both ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Greatest force, Nm or N; may be infinite.
    pub force: f64,
    /// Speed up to which the whole force is there, rad/s or m/s; infinite: at any.
    pub full_speed: f64,
    /// Speed at which none is left: in between, it falls in a line. Beyond, the drive does not push; it always brakes
    /// with the whole force. Infinite if `full_speed` is.
    pub no_load_speed: f64,
}

impl Bound {
    /// No bound.
    pub const NONE: Bound = Bound::force(f64::INFINITY);

    /// Returns the same force, Nm or N, at all speeds.
    pub const fn force(force: f64) -> Self {
        Bound { force, full_speed: f64::INFINITY, no_load_speed: f64::INFINITY }
    }

    /// Returns the bound of a motor whose force falls in a line from `force`, at rest, to 0 at `no_load_speed`.
    pub const fn motor(force: f64, no_load_speed: f64) -> Self {
        Bound { force, full_speed: 0.0, no_load_speed }
    }
}

/// What acts on one velocity of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// Nothing.
    Off,
    /// Holds a velocity, rad/s or m/s, with whatever force that takes within the bound.
    Velocity {
        /// Velocity to hold.
        target: f64,
        /// What it can do.
        bound: Bound,
    },
    /// Pulls towards a position like a spring and a damper: `stiffness (target - q) + damping (velocity - v)`, within
    /// the bound. Only for revolute and prismatic joints.
    Position {
        /// Position to pull to, rad or m.
        target: f64,
        /// Velocity that the damper pulls to, rad/s or m/s.
        velocity: f64,
        /// Nm/rad or N/m.
        stiffness: f64,
        /// Nm s/rad or N s/m.
        damping: f64,
        /// What it can do.
        bound: Bound,
    },
    /// A force, Nm or N, within the bound.
    Force {
        /// The force wanted.
        force: f64,
        /// What it can do.
        bound: Bound,
    },
}

/// A spring with a damper at a revolute or prismatic joint, beside its drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spring {
    /// Position at which it is slack, rad or m.
    pub rest: f64,
    /// Nm/rad or N/m.
    pub stiffness: f64,
    /// Nm s/rad or N s/m.
    pub damping: f64,
}

/// Everything that acts on the velocities of a tree, one entry for each.
#[derive(Debug, Clone, PartialEq)]
pub struct Drives {
    /// Drives.
    pub drive: Vec<Drive>,
    /// Springs.
    pub spring: Vec<Spring>,
    /// Generalised forces from outside, Nm or N; see [`Kinematics::add_force`](crate::Kinematics::add_force).
    pub force: Vec<f64>,
}

impl Drives {
    /// Returns drives that are off, springs without stiffness and no forces.
    pub fn new(tree: &Tree) -> Self {
        let n = tree.velocities();
        Drives { drive: vec![Drive::Off; n], spring: vec![Spring::default(); n], force: vec![0.0; n] }
    }

    /// Refuses lists of other trees, numbers that are not finite and bounds that make no sense.
    pub(crate) fn check(&self, tree: &Tree) -> Result<(), DynamicsError> {
        let expected = tree.velocities();
        for (what, found) in [("drive", self.drive.len()), ("spring", self.spring.len())] {
            if found != expected {
                return Err(DynamicsError::Length { what, found, expected });
            }
        }
        check("force", &self.force, expected)?;
        for (dof, (drive, spring)) in self.drive.iter().zip(&self.spring).enumerate() {
            let has_position = tree.dofs[dof].position != NONE;
            drive.check(dof, has_position)?;
            if *spring != Spring::default() {
                numbers(
                    dof,
                    &[("rest", spring.rest)],
                    &[("stiffness", spring.stiffness), ("damping", spring.damping)],
                )?;
                if !has_position {
                    return Err(DynamicsError::Drive { dof, what: "spring", why: "needs a joint with one position" });
                }
            }
        }
        Ok(())
    }
}

impl Drive {
    fn check(&self, dof: usize, has_position: bool) -> Result<(), DynamicsError> {
        let bound = match self {
            Drive::Off => return Ok(()),
            Drive::Velocity { target, bound } => {
                numbers(dof, &[("target", *target)], &[])?;
                bound
            }
            Drive::Position { target, velocity, stiffness, damping, bound } => {
                let gains = [("stiffness", *stiffness), ("damping", *damping)];
                numbers(dof, &[("target", *target), ("velocity", *velocity)], &gains)?;
                if !has_position {
                    return Err(DynamicsError::Drive { dof, what: "target", why: "needs a joint with one position" });
                }
                bound
            }
            Drive::Force { force, bound } => {
                numbers(dof, &[("force", *force)], &[])?;
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
            return wrong("bound.no_load_speed", "must be above `full_speed`");
        }
        if full.is_finite() && (none.is_infinite() || bound.force.is_infinite()) {
            return wrong("bound.no_load_speed", "must be finite, and so must `force`, if `full_speed` is");
        }
        Ok(())
    }
}

/// Refuses numbers that are not finite, and gains that are negative.
fn numbers(dof: usize, any: &[(&'static str, f64)], gains: &[(&'static str, f64)]) -> Result<(), DynamicsError> {
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
