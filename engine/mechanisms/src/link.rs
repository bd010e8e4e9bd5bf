//! The description of a link and its joint, and their validation.

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::error::TreeError;

/// The type of a joint, which defines how a link can move relative to its parent. The joint is at the origin of the
/// link's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joint {
    /// No motion.
    Fixed,
    /// Rotation about a unit axis in the link's frame; position in rad.
    Revolute(Vector3<f64>),
    /// Translation along a unit axis in the link's frame; position in m.
    Prismatic(Vector3<f64>),
    /// Rotation about any axis. Position: a unit quaternion, w, x, y, z, from the link's frame to its frame at position
    /// 0. Velocity: the angular velocity relative to the parent in the link's own axes, rad/s.
    Spherical,
    /// Free motion in the world; only for links without a parent, whose [`Link::frame`] is ignored. Position: origin in
    /// the world, m, and unit quaternion, w, x, y, z. Velocity: that of the origin in world axes, m/s, and the angular
    /// velocity in the link's own axes, rad/s. The layout is that of MuJoCo.
    Free,
}

impl Joint {
    /// Returns the number of velocities of the joint: its degrees of freedom.
    pub fn velocities(&self) -> usize {
        match self {
            Joint::Fixed => 0,
            Joint::Revolute(_) | Joint::Prismatic(_) => 1,
            Joint::Spherical => 3,
            Joint::Free => 6,
        }
    }
    /// Returns the number of positions, which exceeds the number of velocities by one if they include a quaternion.
    pub fn positions(&self) -> usize {
        match self {
            Joint::Spherical => 4,
            Joint::Free => 7,
            _ => self.velocities(),
        }
    }
}

/// A rigid link and the joint that connects it to its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Index of the parent, which must be an earlier link; `None`: the world.
    pub parent: Option<usize>,
    /// Pose of the link's frame in its parent's frame at joint position 0; lengths in m.
    pub frame: Isometry3<f64>,
    /// The joint to the parent.
    pub joint: Joint,
    /// Mass, kg; may be 0.
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    pub center: Vector3<f64>,
    /// Inertia about the centre of mass, in the link's axes, kg m².
    pub inertia: Matrix3<f64>,
    /// Inertia of a motor's rotor, reflected to the joint (multiplied by the squared gear ratio): kg m², or kg for a
    /// prismatic joint. Added to the diagonal of the mass matrix for each velocity of the joint.
    pub armature: f64,
    /// Viscous friction of each velocity, Nm s/rad or N s/m.
    pub damping: f64,
    /// Maximum dry friction of each velocity, Nm or N.
    pub friction: f64,
    /// Minimum and maximum position of a revolute or prismatic joint, rad or m.
    pub limits: Option<[f64; 2]>,
    /// The coupling of a revolute or prismatic joint to another one, or `None` if the joint is independent.
    pub gear: Option<JointGear>,
}

/// The coupling of a joint to another joint of the same tree, in the same branch or in another one: its position is
/// `ratio` times that of the leader plus `offset`. Each loads the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointGear {
    /// Index of the link whose joint is the leader: revolute or prismatic, and possibly geared to a third joint.
    pub leader: usize,
    /// Change of the position per unit of the leader's position.
    pub ratio: f64,
    /// Position if the leader is at 0, rad or m.
    pub offset: f64,
}

impl Link {
    /// Returns a link without damping, friction, armature, limits or gear; the units are those of the fields.
    pub fn new(
        parent: Option<usize>,
        frame: Isometry3<f64>,
        joint: Joint,
        mass: f64,
        center: Vector3<f64>,
        inertia: Matrix3<f64>,
    ) -> Self {
        let (armature, damping, friction, limits, gear) = (0.0, 0.0, 0.0, None, None);
        Link { parent, frame, joint, mass, center, inertia, armature, damping, friction, limits, gear }
    }

    /// Checks the values of this link, without reference to other links. `link` is its index, for the error; `real`
    /// states whether the inertia must be that of a rigid body.
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
            // An infinite limit is allowed, and means that there is no limit.
            ("limits", self.limits.is_none_or(|l| !l[0].is_nan() && !l[1].is_nan())),
            ("gear", self.gear.is_none_or(|g| g.ratio.is_finite() && g.offset.is_finite())),
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
                return Err(TreeError::Joint { link, why: "only revolute and prismatic joints can have limits" });
            }
            if low > high || low == f64::INFINITY || high == f64::NEG_INFINITY {
                return Err(TreeError::Limits { link, low, high });
            }
        }
        if self.joint == Joint::Free && self.parent.is_some() {
            return Err(TreeError::Joint { link, why: "only a link without a parent can have a free joint" });
        }
        let checked = if real { check_inertia(&self.inertia, self.mass) } else { check_signs(&self.inertia) };
        checked.map_err(|why| TreeError::Inertia { link, why })
    }
}

/// Checks that an inertia is symmetric up to rounding, and has no negative moment on its diagonal.
fn check_signs(inertia: &Matrix3<f64>) -> Result<(), &'static str> {
    let slack = 1e-9 * inertia.amax();
    if (inertia - inertia.transpose()).amax() > slack {
        return Err("it is not symmetric");
    }
    let negative = inertia.diagonal().iter().any(|moment| *moment < 0.0);
    if negative { Err("a moment is negative") } else { Ok(()) }
}

/// Checks that an inertia is symmetric and physically possible: no principal moment is negative or exceeds the sum of
/// the other two (the triangle inequality). Equivalently, the second moment of the mass, `tr(I) / 2 - I`, is positive
/// semidefinite, which is tested by its principal minors.
///
/// The tolerance of 1e-9 of the trace allows for values that were rounded in a file.
fn check_inertia(inertia: &Matrix3<f64>, mass: f64) -> Result<(), &'static str> {
    let trace = inertia[(0, 0)] + inertia[(1, 1)] + inertia[(2, 2)];
    let slack = 1e-9 * trace.abs();
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        if (inertia[(i, j)] - inertia[(j, i)]).abs() > slack {
            return Err("it is not symmetric");
        }
    }
    if mass == 0.0 && inertia.iter().any(|x| *x != 0.0) {
        return Err("it must be 0 if the mass is 0");
    }
    let half = 0.5 * trace;
    let p = |i: usize, j: usize| if i == j { half - inertia[(i, j)] + slack } else { -inertia[(i, j)] };
    let minor = |i: usize, j: usize| p(i, i) * p(j, j) - p(i, j) * p(j, i);
    let det = p(0, 0) * minor(1, 2) - p(0, 1) * (p(1, 0) * p(2, 2) - p(1, 2) * p(2, 0))
        + p(0, 2) * (p(1, 0) * p(2, 1) - p(1, 1) * p(2, 0));
    // Principal minors of the matrix, shifted by `slack`; the last terms are a tolerance for rounding.
    let (square, cube) = (1e-15 * trace * trace, 1e-15 * trace * trace * trace.abs());
    let ok = (0..3).all(|i| p(i, i) >= 0.0)
        && minor(0, 1) >= -square
        && minor(0, 2) >= -square
        && minor(1, 2) >= -square
        && det >= -cube;
    if ok { Ok(()) } else { Err("a principal moment is negative or exceeds the sum of the other two") }
}
