//! What describes a link and the joint that carries it, and the checks of both.

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::error::TreeError;

/// How a link moves relative to its parent. Every joint lies in the origin of the link's own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joint {
    /// Not at all.
    Fixed,
    /// It turns about a unit axis, in the link's frame; position in rad.
    Revolute(Vector3<f64>),
    /// It slides along a unit axis, in the link's frame; position in m.
    Prismatic(Vector3<f64>),
    /// It turns any way. Position: a unit quaternion, w, x, y, z, from the link's frame to its frame at rest. Velocity:
    /// the angular velocity relative to the parent in the link's own axes, rad/s.
    Spherical,
    /// It moves any way in the world; only links without a parent can be free, and [`Link::frame`] does not count.
    /// Position: origin in the world, m, and unit quaternion, w, x, y, z. Velocity: of the origin in world axes, m/s,
    /// and the angular velocity in the link's own axes, rad/s. The same layout as MuJoCo's.
    Free,
}

impl Joint {
    /// Returns the number of velocities.
    pub fn velocities(&self) -> usize {
        match self {
            Joint::Fixed => 0,
            Joint::Revolute(_) | Joint::Prismatic(_) => 1,
            Joint::Spherical => 3,
            Joint::Free => 6,
        }
    }
    /// Returns the number of positions: one more than of velocities where there is a quaternion.
    pub fn positions(&self) -> usize {
        match self {
            Joint::Spherical => 4,
            Joint::Free => 7,
            _ => self.velocities(),
        }
    }
}

/// A rigid link and the joint that carries it.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Index of the link that carries it, which comes before it; none: the world.
    pub parent: Option<usize>,
    /// Pose of the link's frame in its parent's at joint position 0; lengths in m.
    pub frame: Isometry3<f64>,
    /// How it moves there.
    pub joint: Joint,
    /// kg; 0 for a link without mass.
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    pub center: Vector3<f64>,
    /// Inertia about the centre of mass, in the link's axes, kg m².
    pub inertia: Matrix3<f64>,
    /// Inertia of a motor's rotor as the joint feels it, that is times the square of the gear's ratio: kg m², or kg for
    /// a prismatic joint. Added to the diagonal of the mass matrix; of 3 or 6 velocities, to each.
    pub armature: f64,
    /// Viscous friction, Nm s/rad or N s/m, of each velocity.
    pub damping: f64,
    /// Dry friction, Nm or N, of each velocity: the most that it resists with.
    pub friction: f64,
    /// Least and greatest position, rad or m, of revolute and prismatic joints.
    pub limits: Option<[f64; 2]>,
}

impl Link {
    /// Returns a link without friction, armature and limits. Lengths in m; see the fields.
    pub fn new(
        parent: Option<usize>,
        frame: Isometry3<f64>,
        joint: Joint,
        mass: f64,
        center: Vector3<f64>,
        inertia: Matrix3<f64>,
    ) -> Self {
        Link { parent, frame, joint, mass, center, inertia, armature: 0.0, damping: 0.0, friction: 0.0, limits: None }
    }

    /// Checks everything that does not depend on other links. `link` is its number, for the error; `real`: whether the
    /// inertia must be that of a rigid body.
    pub(crate) fn check(&self, link: usize, real: bool) -> Result<(), TreeError> {
        let rotation = self.frame.rotation.quaternion().coords;
        let axis = match self.joint {
            Joint::Revolute(axis) | Joint::Prismatic(axis) => Some(axis),
            _ => None,
        };
        let finite = [
            ("frame", rotation.iter().chain(self.frame.translation.vector.iter()).all(|x| x.is_finite())),
            ("axis", axis.is_none_or(|a| a.iter().all(|x| x.is_finite()))),
            ("mass", self.mass.is_finite()),
            ("center", self.center.iter().all(|x| x.is_finite())),
            ("inertia", self.inertia.iter().all(|x| x.is_finite())),
            ("armature", self.armature.is_finite()),
            ("damping", self.damping.is_finite()),
            ("friction", self.friction.is_finite()),
            // an infinite limit is no limit
            ("limits", self.limits.is_none_or(|l| !l[0].is_nan() && !l[1].is_nan())),
        ];
        if let Some((what, _)) = finite.iter().find(|(_, ok)| !ok) {
            return Err(TreeError::NotFinite { link, what });
        }
        let signs =
            [("mass", self.mass), ("armature", self.armature), ("damping", self.damping), ("friction", self.friction)];
        if let Some(&(what, value)) = signs.iter().find(|(_, x)| *x < 0.0) {
            return Err(TreeError::Negative { link, what, value });
        }
        if let Some(a) = axis {
            let length = (a.x * a.x + a.y * a.y + a.z * a.z).sqrt();
            if (length - 1.0).abs() > 1e-9 {
                return Err(TreeError::Axis { link, length });
            }
        }
        if let Some([low, high]) = self.limits {
            if axis.is_none() {
                return Err(TreeError::Joint { link, why: "only revolute and prismatic joints have limits" });
            }
            if low > high || low == f64::INFINITY || high == f64::NEG_INFINITY {
                return Err(TreeError::Limits { link, low, high });
            }
        }
        if self.joint == Joint::Free && self.parent.is_some() {
            return Err(TreeError::Joint { link, why: "only a link without a parent can be free" });
        }
        let checked = if real { check_inertia(&self.inertia, self.mass) } else { check_signs(&self.inertia) };
        checked.map_err(|why| TreeError::Inertia { link, why })
    }
}

/// Checks that an inertia is symmetric, up to rounding, and has no negative moment.
fn check_signs(inertia: &Matrix3<f64>) -> Result<(), &'static str> {
    let slack = 1e-9 * inertia.amax();
    if (inertia - inertia.transpose()).amax() > slack {
        return Err("it is not symmetric");
    }
    let negative = inertia.diagonal().iter().any(|moment| *moment < 0.0);
    if negative { Err("a moment is negative") } else { Ok(()) }
}

/// Checks that some distribution of mass has this inertia about its centre: half of the trace less the inertia, which
/// is the integral of r r' over the mass, must have no negative principal value.
///
/// The tolerance, 1e-9 of the trace, is for numbers that were rounded in a file.
fn check_inertia(inertia: &Matrix3<f64>, mass: f64) -> Result<(), &'static str> {
    let trace = inertia[(0, 0)] + inertia[(1, 1)] + inertia[(2, 2)];
    let slack = 1e-9 * trace.abs();
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        if (inertia[(i, j)] - inertia[(j, i)]).abs() > slack {
            return Err("it is not symmetric");
        }
    }
    if mass == 0.0 && inertia.iter().any(|x| *x != 0.0) {
        return Err("a link without mass has none");
    }
    let half = 0.5 * trace;
    let p = |i: usize, j: usize| if i == j { half - inertia[(i, j)] + slack } else { -inertia[(i, j)] };
    let minor = |i: usize, j: usize| p(i, i) * p(j, j) - p(i, j) * p(j, i);
    let det = p(0, 0) * minor(1, 2) - p(0, 1) * (p(1, 0) * p(2, 2) - p(1, 2) * p(2, 0))
        + p(0, 2) * (p(1, 0) * p(2, 1) - p(1, 1) * p(2, 0));
    // principal minors of a matrix that is at least `slack` away from negative values; the last terms are for rounding
    let (square, cube) = (1e-15 * trace * trace, 1e-15 * trace * trace * trace.abs());
    let ok = (0..3).all(|i| p(i, i) >= 0.0)
        && minor(0, 1) >= -square
        && minor(0, 2) >= -square
        && minor(1, 2) >= -square
        && det >= -cube;
    if ok { Ok(()) } else { Err("a principal moment is negative or exceeds the sum of the other two") }
}
