//! Spatial (six-dimensional) motion and force vectors, and spatial inertias, in world axes about one common point.
//!
//! Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 2. Because all quantities are in the same axes
//! about the same point, inertias and forces of links can be added without transformations between links.

use crate::vector::{Vec3, add, cross, dot, scale, sub};

/// A motion (angular velocity, rad/s, and velocity of the common point, m/s) or its derivative.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SpatialMotion {
    pub angular: Vec3,
    pub linear: Vec3,
}

/// A force, N, and its torque about the common point, N m.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SpatialForce {
    pub torque: Vec3,
    pub force: Vec3,
}

/// The inertia of a rigid body, or of several bodies that move as one, about the common point.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SpatialInertia {
    /// Mass, kg.
    pub mass: f64,
    /// Mass times centre of mass, kg m.
    pub first: Vec3,
    /// Rotational inertia, kg m²: xx, yy, zz, xy, xz, yz.
    pub second: [f64; 6],
}

impl SpatialMotion {
    #[inline(always)]
    pub fn plus(self, other: SpatialMotion) -> SpatialMotion {
        SpatialMotion { angular: add(self.angular, other.angular), linear: add(self.linear, other.linear) }
    }
    #[inline(always)]
    pub fn times(self, s: f64) -> SpatialMotion {
        SpatialMotion { angular: scale(self.angular, s), linear: scale(self.linear, s) }
    }
    /// Returns the time derivative of a motion vector that is fixed in a body with this velocity.
    #[inline(always)]
    pub fn cross(&self, m: &SpatialMotion) -> SpatialMotion {
        SpatialMotion {
            angular: cross(self.angular, m.angular),
            linear: add(cross(self.angular, m.linear), cross(self.linear, m.angular)),
        }
    }
    /// Returns the time derivative of a force vector that is fixed in a body with this velocity.
    #[inline(always)]
    pub fn cross_force(&self, f: &SpatialForce) -> SpatialForce {
        SpatialForce {
            torque: add(cross(self.angular, f.torque), cross(self.linear, f.force)),
            force: cross(self.angular, f.force),
        }
    }
    /// Returns the power of a force, or a generalised force if this is the axis of a joint.
    #[inline(always)]
    pub fn dot(&self, f: &SpatialForce) -> f64 {
        dot(self.angular, f.torque) + dot(self.linear, f.force)
    }
}

impl SpatialForce {
    #[inline(always)]
    pub fn plus(self, other: SpatialForce) -> SpatialForce {
        SpatialForce { torque: add(self.torque, other.torque), force: add(self.force, other.force) }
    }
}

impl SpatialInertia {
    /// Returns the momentum of a body with this inertia and the given velocity.
    #[inline(always)]
    pub fn times(&self, m: &SpatialMotion) -> SpatialForce {
        let (i, w) = (&self.second, m.angular);
        let turned = [
            i[0] * w[0] + i[3] * w[1] + i[4] * w[2],
            i[3] * w[0] + i[1] * w[1] + i[5] * w[2],
            i[4] * w[0] + i[5] * w[1] + i[2] * w[2],
        ];
        SpatialForce {
            torque: add(turned, cross(self.first, m.linear)),
            force: sub(scale(m.linear, self.mass), cross(self.first, m.angular)),
        }
    }
    #[inline(always)]
    pub fn accumulate(&mut self, other: &SpatialInertia) {
        self.mass += other.mass;
        self.first = add(self.first, other.first);
        for (a, b) in self.second.iter_mut().zip(&other.second) {
            *a += b;
        }
    }
}
