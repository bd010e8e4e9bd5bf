//! Why a tree cannot be built, or a computation cannot be done.

/// The reason why a description is no tree of rigid links. Links are counted from 0 in the order given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TreeError {
    /// No links at all.
    #[error("a tree needs at least one link")]
    Empty,
    /// The parent of a link does not come before it.
    #[error("link {link}: its parent, {parent}, must come before it")]
    Parent {
        /// The link.
        link: usize,
        /// The parent given.
        parent: usize,
    },
    /// A number is infinite or not a number.
    #[error("link {link}: `{what}` must be finite")]
    NotFinite {
        /// The link.
        link: usize,
        /// Which number.
        what: &'static str,
    },
    /// A number that must not be negative is.
    #[error("link {link}: `{what}` must not be negative, but is {value}")]
    Negative {
        /// The link.
        link: usize,
        /// Which number.
        what: &'static str,
        /// The number given.
        value: f64,
    },
    /// The axis of a joint has not the length 1.
    #[error("link {link}: the axis of its joint has the length {length}; it must be 1 (to 1e-9)")]
    Axis {
        /// The link.
        link: usize,
        /// Length of the axis given.
        length: f64,
    },
    /// No rigid body has this inertia: it is not symmetric, or a principal moment exceeds the sum of the other two.
    #[error("link {link}: no rigid body has this inertia: {why}")]
    Inertia {
        /// The link.
        link: usize,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A joint moves nothing that has mass, and has no armature.
    #[error("link {link}: its joint moves no mass: the link and all beyond it have none, and its armature is 0")]
    Massless {
        /// The link.
        link: usize,
    },
    /// The lower limit of a joint is above the upper one.
    #[error("link {link}: the lower limit, {low}, is above the upper one, {high}")]
    Limits {
        /// The link.
        link: usize,
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
    /// A joint that cannot have limits, or a free joint that is not at the world.
    #[error("link {link}: {why}")]
    Joint {
        /// The link.
        link: usize,
        /// What is wrong.
        why: &'static str,
    },
}

/// The reason why a computation on a tree was refused. Nothing was changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// A state, force or drive list belongs to another tree.
    #[error("`{what}` has {found} entries, but the tree needs {expected}")]
    Length {
        /// Which list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// A number that was handed in is infinite or not a number.
    #[error("`{what}` must be finite")]
    NotFinite {
        /// Which number or list.
        what: &'static str,
    },
    /// The length of a step is not above 0.
    #[error("the length of a step must be above 0, but is {h} s")]
    Step {
        /// The length given, s.
        h: f64,
    },
    /// A link number beyond the tree's.
    #[error("there is no link {link}: the tree has {links}")]
    NoLink {
        /// The number given.
        link: usize,
        /// Number of links of the tree.
        links: usize,
    },
    /// A drive's bound or gain is negative, or its speeds are in the wrong order.
    #[error("velocity {dof}: `{what}` of its drive {why}")]
    Drive {
        /// The velocity that the drive acts on.
        dof: usize,
        /// Which number.
        what: &'static str,
        /// What it must be.
        why: &'static str,
    },
    /// The mass matrix is singular here: what lies beyond this velocity has no inertia about its axis.
    #[error("velocity {dof} moves nothing that has inertia about its axis in this pose; give its joint an armature")]
    Singular {
        /// The velocity in question.
        dof: usize,
    },
    /// The result is beyond what numbers can hold.
    #[error("the result is not finite: forces or velocities are too large for a step of this length")]
    Diverged,
}

/// The reason why the step of a group was refused. No state was changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GroupError {
    /// A member cannot be moved.
    #[error("member {member}: {source}")]
    Member {
        /// Its index.
        member: usize,
        /// Why.
        source: DynamicsError,
    },
    /// A contact makes no sense.
    #[error("contact {contact} {why}")]
    Contact {
        /// Its index.
        contact: usize,
        /// What is wrong with it.
        why: &'static str,
    },
}

/// Refuses a list of another length than the tree needs, or with a number that is not finite.
pub(crate) fn check(what: &'static str, list: &[f64], expected: usize) -> Result<(), DynamicsError> {
    if list.len() != expected {
        return Err(DynamicsError::Length { what, found: list.len(), expected });
    }
    if list.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(DynamicsError::NotFinite { what }) }
}
