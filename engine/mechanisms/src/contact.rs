//! Contact points: an input of an island's step, which also updates their impulses and distances.

use nalgebra::Vector3;

/// A link of a tree of the island.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ContactSide {
    /// Index of the member.
    pub member: usize,
    /// Index of the link in the member's tree.
    pub link: usize,
}

/// A point at which two bodies may touch, found by collision detection. It remains valid while the bodies rotate only
/// slightly.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPoint {
    /// The two bodies; `None` stands for a body that is not a link of a tree. At least one of them must be a link.
    pub sides: [Option<ContactSide>; 2],
    /// Vector from the origin of each link to the point, in world axes, m; ignored for a body that is not a link. It
    /// does not rotate with the link, because a rolling wheel always touches the ground below its axle.
    pub arms: [Vector3<f64>; 2],
    /// Distance between the surfaces along the normal, m; negative if they overlap. A step updates it from the
    /// velocities of the point on both bodies.
    pub distance: f64,
    /// Velocity of the point on the second body minus that on the first, m/s, in world axes, due to bodies that are not
    /// links, such as a vehicle that the engine moves.
    pub drift: Vector3<f64>,
    /// Unit vector from the first body to the second, in world axes.
    pub normal: Vector3<f64>,
    /// Tangential velocity of the second body relative to the first at which friction vanishes, m/s, in world axes; not
    /// 0 for a conveyor belt.
    pub slide: Vector3<f64>,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
    /// Coefficient of restitution: ratio of the separation speed to the impact speed.
    pub restitution: f64,
    /// Rate at which an overlap is removed, as a fraction of the overlap per second, 1/s.
    pub recovery: f64,
    /// Impulse on the second body, N s, in world axes. As an input, the impulse of the previous step, for a warm start;
    /// as an output, the impulse of this step.
    pub impulse: Vector3<f64>,
}

/// Maximum speed at which overlapping bodies are separated, m/s.
pub(crate) const MAX_RECOVERY_SPEED: f64 = 3.0;

impl ContactPoint {
    /// Returns whether all values are finite and in their valid ranges.
    pub(crate) fn is_valid(&self) -> bool {
        let vectors = [&self.arms[0], &self.arms[1], &self.drift, &self.normal, &self.slide, &self.impulse];
        let numbers = [self.friction, self.restitution, self.recovery];
        vectors.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && self.distance.is_finite()
            && numbers.iter().all(|x| x.is_finite() && *x >= 0.0)
    }
}
