//! Combines the masses of links into those of bodies.

use nalgebra::{Isometry3, Matrix3, Vector3};
use tatu_plugin_api::safe::{Fail, Result};

use crate::{
    robot::Link,
    tree::{check_finite, pose},
};

/// Mass (kg), centre of mass (m) and inertia about the centre of mass (kg m^2), in the frame of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mass {
    pub mass: f64,
    pub com: Vector3<f64>,
    pub inertia: Matrix3<f64>,
}

impl Mass {
    /// The mass properties of a body without mass.
    pub const ZERO: Mass = Mass {
        mass: 0.0,
        com: Vector3::new(0.0, 0.0, 0.0),
        inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// Returns the mass of a link whose frame in the body is `frame`.
    pub fn of(link: &Link, frame: &Isometry3<f64>) -> Result<Mass> {
        let what = format!("inertial of the link `{}`", link.name);
        let (line, mass) = (link.line, link.inertial.mass);
        let [xx, xy, xz, yy, yz, zz] = link.inertial.inertia;
        check_finite(&[mass, xx, xy, xz, yy, yz, zz], &what, line)?;
        if mass < 0.0 {
            return Err(Fail::argument(format!("{what}: the mass {mass} kg is negative")).at("", line));
        }
        let at = frame * pose(&link.inertial.origin, &what, line)?;
        let turn = at.rotation.to_rotation_matrix();
        let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Ok(Mass { mass, com: at.translation.vector, inertia: turn.matrix() * own * turn.matrix().transpose() })
    }

    /// Returns the combined mass of two rigidly connected bodies.
    pub fn combined_with(&self, other: &Mass) -> Mass {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return Mass::ZERO;
        }
        // A link without mass can have an inertia, which counts.
        let com = (self.com * self.mass + other.com * other.mass) / mass;
        let about = |m: &Mass| {
            let d = m.com - com;
            m.inertia + m.mass * (Matrix3::identity() * d.norm_squared() - d * d.transpose())
        };
        Mass { mass, com, inertia: about(self) + about(other) }
    }

    /// Returns whether the inertia is positive definite, as that of a rigid body is. The triangle inequality of the
    /// principal moments is not checked.
    pub fn is_possible(&self) -> bool {
        let least = self.inertia.symmetric_eigenvalues().min();
        least.is_finite() && least > 1e-12 * self.inertia.norm()
    }
}
