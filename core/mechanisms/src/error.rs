//! Errors of trees and of computations on them.

/// An error in the description of a tree. Links are counted from 0, in the given order.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TreeError {
    /// There are no links.
    #[error("a tree needs at least one link")]
    Empty,
    /// The parent of a link is not an earlier link.
    #[error("link {link}: its parent, {parent}, must come before it")]
    Parent {
        /// The link.
        link: usize,
        /// The given parent.
        parent: usize,
    },
    /// A value is infinite or NaN.
    #[error("link {link}: `{what}` must be finite")]
    NotFinite {
        /// The link.
        link: usize,
        /// The name of the value.
        what: &'static str,
    },
    /// A value is negative that must not be.
    #[error("link {link}: `{what}` must not be negative, but is {value}")]
    Negative {
        /// The link.
        link: usize,
        /// The name of the value.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// The axis of a joint is not a unit vector.
    #[error("link {link}: the axis of its joint must have the length 1 (within 1e-9), but has {length}")]
    Axis {
        /// The link.
        link: usize,
        /// Length of the axis.
        length: f64,
    },
    /// The inertia is not that of a rigid body: it is not symmetric, or a principal moment exceeds the sum of the other
    /// two.
    #[error("link {link}: `inertia` is not that of a rigid body: {why}")]
    Inertia {
        /// The link.
        link: usize,
        /// The condition that is not met.
        why: &'static str,
    },
    /// A joint moves no mass, and has no armature.
    #[error("link {link}: its joint moves no mass: the link and its descendants have none, and the armature is 0")]
    Massless {
        /// The link.
        link: usize,
    },
    /// The limits of a joint allow no position, because the lower limit exceeds the upper one or is positive infinity,
    /// or the upper limit is negative infinity.
    #[error("link {link}: the limits {low} to {high} allow no position; the lower limit must not exceed the upper one")]
    Limits {
        /// Index of the link.
        link: usize,
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
    /// Limits of a joint that cannot have any, or a free joint below another link.
    #[error("link {link}: {why}")]
    Joint {
        /// The link.
        link: usize,
        /// The condition that is not met.
        why: &'static str,
    },
}

/// An error of a computation on a tree. No state was changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// A list has the wrong length, because it belongs to another tree.
    #[error("`{what}` has {found} entries, but the tree needs {expected}")]
    Length {
        /// The name of the list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The expected length.
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
        /// The index.
        link: usize,
        /// Number of links of the tree.
        links: usize,
    },
    /// A parameter of a drive or spring is invalid.
    #[error("degree of freedom {dof}: `{what}` {why}")]
    Drive {
        /// Index of the velocity that the drive or spring acts on.
        dof: usize,
        /// The name of the parameter.
        what: &'static str,
        /// The condition that is not met.
        why: &'static str,
    },
    /// The mass matrix is singular in this pose.
    #[error("the links that velocity {dof} moves have no inertia about its axis in this pose; set an armature")]
    Singular {
        /// Index of the velocity.
        dof: usize,
    },
    /// The result is infinite or NaN.
    #[error("the result is not finite: forces or velocities are too large for a step of this duration")]
    Diverged,
}

/// An error of a step of a group. No state was changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GroupError {
    /// The step of a member failed.
    #[error("member {member}: {source}")]
    Member {
        /// Its index.
        member: usize,
        /// The error of the member.
        source: DynamicsError,
    },
    /// A contact is invalid.
    #[error("contact {contact} {why}")]
    Contact {
        /// Its index.
        contact: usize,
        /// The condition that is not met.
        why: &'static str,
    },
}

/// Returns an error if a list does not have the expected length, or has a value that is not finite.
pub(crate) fn check(what: &'static str, list: &[f64], expected: usize) -> Result<(), DynamicsError> {
    if list.len() != expected {
        return Err(DynamicsError::Length { what, found: list.len(), expected });
    }
    if list.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(DynamicsError::NotFinite { what }) }
}
