//! What a search for positions gets and returns.

use crate::{linkage::FrameId, reach_task::Distance};

/// From where a solver starts, and what bounds it.
#[derive(Debug, Clone, Copy)]
pub struct ReachSettings<'a> {
    /// Positions to start from, rad or m, one for each of [`ReachSolver::joints`](crate::ReachSolver::joints).
    pub start: &'a [f64],
    /// Positions that the joints shall be near to, as far as the goals permit; `None`: no such positions.
    pub posture: Option<&'a [f64]>,
    /// Greatest distances of the positions from `start`, such as velocity limits times the time of a step; `None`: no such
    /// bounds. With bounds, there are no restarts.
    pub max_change: Option<&'a [f64]>,
    /// Maximum number of starts from other positions; at most [`MAX_RESTARTS`] count. Default 10.
    pub restarts: u32,
    /// Maximum number of iterations from each start. Default 100.
    pub iterations: u32,
    /// Seed of the other positions. Equal seeds give equal results on all processors. Default 1.
    pub seed: u64,
}

/// Most starts from other positions.
pub const MAX_RESTARTS: u32 = 10;

impl<'a> ReachSettings<'a> {
    /// Returns the defaults, with these positions to start from.
    pub fn from(start: &'a [f64]) -> Self {
        ReachSettings { start, posture: None, max_change: None, restarts: MAX_RESTARTS, iterations: 100, seed: 1 }
    }
}

/// What a search has cost, and where it ended.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reached {
    /// How far the tips are from their goals.
    pub distance: Distance,
    /// Iterations of all starts.
    pub iterations: u32,
    /// Starts after the first one; more than [`MAX_RESTARTS`] if the positions were found by the search for a reason.
    pub restarts: u32,
}

/// Why goals cannot be reached. The joints are then as near as they came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// An array has the wrong length, or a value is not finite; the text names it.
    Invalid(&'static str),
    /// The position cannot be reached at any positions of the joints.
    OutOfReach {
        /// The least distance, m.
        by: f64,
        /// Whether the goal is inside of what the tip can reach, as in a dead zone around the base, instead of too far.
        inside: bool,
        /// Whether the position alone could be reached, but not with the goal's orientation.
        oriented: bool,
    },
    /// The position can be reached, but the tip cannot turn to the orientation: the least angle, rad.
    Orientation {
        /// What is missing, rad.
        by: f64,
    },
    /// Only positions beyond the limits of joints reach the goals.
    Limit {
        /// The joint that must exceed its limit most.
        joint: FrameId,
        /// By how much, rad or m; negative below the lower limit.
        by: f64,
    },
    /// The goals can be reached, but not by the greatest changes from the start.
    Change {
        /// The joint that must change most beyond its bound.
        joint: FrameId,
        /// By how much, rad or m.
        by: f64,
    },
    /// The goals can be reached, but from the start no motion leads towards them: in this direction of the goals, no joint
    /// moves the tip.
    Singular {
        /// The direction in the world: translation, then rotation; of length 1.
        direction: [f64; 6],
    },
    /// All positions that were found would collide: what the first of them touches, as the caller named it.
    Collision(u64),
    /// No positions were found, and none of the other reasons applies.
    NotFound(Distance),
}
