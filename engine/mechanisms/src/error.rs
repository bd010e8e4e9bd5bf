//! Errors of trees and of computations on them.

/// An error in the description of a tree. Links are identified by their indices, from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TreeError {
    /// There are no links.
    #[error("a tree needs at least one link")]
    Empty,
    /// The parent of a link is not an earlier link.
    #[error("link {link}: its parent has the index {parent}, but must be an earlier link")]
    Parent {
        /// Index of the link.
        link: usize,
        /// Index of the given parent.
        parent: usize,
    },
    /// A value is infinite or NaN.
    #[error("link {link}: `{what}` must be finite")]
    NotFinite {
        /// Index of the link.
        link: usize,
        /// The name of the value.
        what: &'static str,
    },
    /// A value that must not be negative is negative.
    #[error("link {link}: `{what}` must not be negative, but is {value}")]
    Negative {
        /// Index of the link.
        link: usize,
        /// The name of the value.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// The axis of a joint is not a unit vector.
    #[error("link {link}: the length of the joint's axis must be 1 (within 1e-9), but is {length}")]
    Axis {
        /// Index of the link.
        link: usize,
        /// Length of the axis.
        length: f64,
    },
    /// The inertia is not that of a rigid body: it is not symmetric, it is not 0 although the mass is, or a principal
    /// moment is negative or exceeds the sum of the other two.
    #[error("link {link}: `inertia` is not that of a rigid body: {why}")]
    Inertia {
        /// Index of the link.
        link: usize,
        /// The condition that is violated.
        why: &'static str,
    },
    /// A joint moves no mass and has no armature, so its acceleration would be undefined.
    #[error("link {link}: its joint moves no mass: the link and its descendants have none, and the armature is 0")]
    Massless {
        /// Index of the link.
        link: usize,
    },
    /// The limits of a joint do not allow any position: the lower limit exceeds the upper limit or is positive
    /// infinity, or the upper limit is negative infinity.
    #[error("link {link}: the limits {low} to {high} must contain a finite position")]
    Limits {
        /// Index of the link.
        link: usize,
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
    /// A joint that cannot have limits or a gear has one, or a link with a parent has a free joint.
    #[error("link {link}: {why}")]
    Joint {
        /// Index of the link.
        link: usize,
        /// The condition that is not met.
        why: &'static str,
    },
    /// The leader of a geared joint is not a joint to which it can be geared.
    #[error("link {link}: the leader of its gear is the joint of link {leader}, {why}")]
    Gear {
        /// Index of the link.
        link: usize,
        /// Index of the leader.
        leader: usize,
        /// The condition that is violated.
        why: &'static str,
    },
}

/// An error of a computation on a tree. No state was changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// The length of a list does not match the tree.
    #[error("`{what}` has {found} entries, but the tree needs {expected}")]
    Length {
        /// The name of the list.
        what: &'static str,
        /// Length of the list.
        found: usize,
        /// Length that the tree requires.
        expected: usize,
    },
    /// An argument is infinite or NaN.
    #[error("`{what}` must be finite")]
    NotFinite {
        /// The name of the value or list.
        what: &'static str,
    },
    /// The duration of a step is not positive and finite.
    #[error("the duration of a step must be positive and finite, but is {h} s")]
    Step {
        /// The duration, s.
        h: f64,
    },
    /// There is no link with this index.
    #[error("there is no link {link}: the tree has {links} links")]
    NoLink {
        /// The requested index.
        link: usize,
        /// Number of links of the tree.
        links: usize,
    },
    /// A parameter of a drive or spring is invalid.
    #[error("degree of freedom {dof}: `{what}` {why}")]
    Drive {
        /// Index of the velocity on which the drive or spring acts.
        dof: usize,
        /// The name of the parameter.
        what: &'static str,
        /// The condition that is violated.
        why: &'static str,
    },
    /// The mass matrix is singular in this pose.
    #[error("the links moved by degree of freedom {dof} have no inertia about its axis in this pose; set an armature")]
    Singular {
        /// Index of the velocity.
        dof: usize,
    },
    /// A link turns too fast for a step of this duration: see [`FastTurns::Fail`](crate::FastTurns::Fail).
    #[error(
        "degree of freedom {dof} turns by {turn} rad in a step, which gyroscopic forces do not allow; use a shorter step"
    )]
    TooFast {
        /// Index of the velocity.
        dof: usize,
        /// The turn, rad.
        turn: f64,
    },
    /// The result is infinite or NaN.
    #[error("the result is not finite: forces or velocities are too large for a step of this duration")]
    Diverged,
}

/// An error of a step of an island. No positions or velocities were changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IslandError {
    /// The step of a member failed, or gravity or the duration of the step is invalid.
    #[error("member {member}: {source}")]
    Member {
        /// Index of the member; 0 if gravity or the duration is invalid.
        member: usize,
        /// The error of the member.
        source: DynamicsError,
    },
    /// A contact is invalid.
    #[error("contact {contact}: {why}")]
    Contact {
        /// Index of the contact.
        contact: usize,
        /// The condition that is violated.
        why: &'static str,
    },
}

/// Returns an error if a list does not have the expected length, or contains a value that is not finite.
pub(crate) fn check(what: &'static str, list: &[f64], expected: usize) -> Result<(), DynamicsError> {
    if list.len() != expected {
        return Err(DynamicsError::Length { what, found: list.len(), expected });
    }
    if list.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(DynamicsError::NotFinite { what }) }
}
