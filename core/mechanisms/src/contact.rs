//! Points at which bodies may touch: what a user of a group describes, and gets back.

use nalgebra::Vector3;

/// A link of a member of a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    /// Index of the member.
    pub member: usize,
    /// Index of the link in its tree.
    pub link: usize,
}

/// A point at which two bodies may touch. Collision detection finds it; it is valid for as long as the bodies turn little.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// The two bodies; none: something that no member moves. At least one of them is a link.
    pub sides: [Option<Side>; 2],
    /// From the origin of each link to the point, in world axes, m. It does not turn with the link: a wheel that rolls
    /// touches the ground below its axle all the time.
    pub arms: [Vector3<f64>; 2],
    /// Distance between the surfaces along the normal, m; negative where they overlap. A step changes it by the
    /// velocities of the point on both bodies.
    pub distance: f64,
    /// Velocity of the second body's point less that of the first, m/s, as far as they are no links: of a conveyor or of
    /// a vehicle that something else moves. World axes.
    pub drift: Vector3<f64>,
    /// Unit vector from the first body to the second, in the world.
    pub normal: Vector3<f64>,
    /// Velocity at which the second body is to slide over the first, m/s, as on a belt. World axes.
    pub slide: Vector3<f64>,
    /// Coulomb's coefficient of friction.
    pub friction: f64,
    /// Share of the speed of an impact at which the bodies part.
    pub restitution: f64,
    /// Share of an overlap that is removed per second, 1/s.
    pub recovery: f64,
    /// Impulse on the second body, N s, in world axes: in the step before, where the search begins, then in this one.
    pub impulse: Vector3<f64>,
}

/// Speed at which overlapping bodies part at most, m/s.
pub(crate) const FASTEST_RECOVERY: f64 = 3.0;

impl Contact {
    /// Returns whether all its numbers are finite and those that must not be negative are not.
    pub(crate) fn is_sound(&self) -> bool {
        let vectors = [&self.arms[0], &self.arms[1], &self.drift, &self.normal, &self.slide, &self.impulse];
        let numbers = [self.friction, self.restitution, self.recovery];
        vectors.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && self.distance.is_finite()
            && numbers.iter().all(|x| x.is_finite() && *x >= 0.0)
    }
}
