//! What is planned: start, goal, validity and limits; and what comes out.

use crate::space::StateSpace;

/// Says which states are possible.
///
/// A closure `FnMut(&[f64]) -> bool` is one.
pub trait Validity {
    /// Returns whether a state is possible.
    fn is_valid(&mut self, state: &[f64]) -> bool;

    /// Returns whether all states, one after another in one slice, are possible. May test several at once.
    fn are_valid(&mut self, states: &[f64], dimension: usize) -> bool {
        states.chunks_exact(dimension).all(|state| self.is_valid(state))
    }

    /// Returns how many states [`Validity::are_valid`] tests at once, at no higher cost than one.
    fn lanes(&self) -> usize {
        1
    }
}

impl<F: FnMut(&[f64]) -> bool> Validity for F {
    fn is_valid(&mut self, state: &[f64]) -> bool {
        self(state)
    }
}

/// Returns the distance of a state from a goal.
pub type GoalDistance<'a> = Box<dyn FnMut(&[f64]) -> f64 + 'a>;

/// Where a path shall end.
pub enum Goal<'a> {
    /// At any of these states.
    States(Vec<Vec<f64>>),
    /// At a state for which this is at most 0; elsewhere, the distance from such states, or an estimate of it.
    Region(GoalDistance<'a>),
}

/// A method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Algorithm {
    /// Two trees, from the start and from the goals, which grow towards each other. The fastest for most problems.
    #[default]
    RrtConnect,
    /// One tree from the start.
    Rrt,
    /// One tree whose branches are renewed when a shorter way is found. Uses the whole budget to shorten the path.
    RrtStar,
    /// A network of random states, until start and goal are connected by it.
    Prm,
    /// A network whose states are connected to more neighbours the more there are. Uses the whole budget.
    PrmStar,
}

/// How a problem is to be solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The method. Default: RRT-Connect.
    pub algorithm: Algorithm,
    /// Seed of the random numbers. Equal seeds give equal paths.
    pub seed: u64,
    /// Maximum number of states that are tested; 256 comparisons of a sample with nodes of a tree count as one.
    /// Default 100 000.
    pub max_checks: u64,
    /// Largest motion between two tests, as a share of the extent of each part of the state space. Default 0.01.
    pub resolution: f64,
    /// Length of a branch of a tree, as a distance in the state space; 0: a fifth of its extent. Default 0.
    pub range: f64,
    /// Share of the samples of a single tree that are goals. Default 0.05.
    pub goal_bias: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let algorithm = Algorithm::RrtConnect;
        Settings { algorithm, seed: 1, max_checks: 100_000, resolution: 0.01, range: 0.0, goal_bias: 0.05 }
    }
}

/// How far a search has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// States tested so far.
    pub checks: u64,
    /// States in trees or in the network.
    pub nodes: usize,
}

/// A problem.
pub struct Problem<'a> {
    /// The space of states.
    pub space: &'a StateSpace,
    /// Where the path begins.
    pub start: &'a [f64],
    /// Where it may end.
    pub goal: Goal<'a>,
}

/// A path.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// The states from the start to the goal, between which motions are possible.
    pub states: Vec<Vec<f64>>,
}

impl Path {
    /// Returns the length: the sum of distances.
    pub fn length(&self, space: &StateSpace) -> f64 {
        self.states.windows(2).map(|pair| space.distance(&pair[0], &pair[1])).sum()
    }
}

/// A solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The path.
    pub path: Path,
    /// Number of states tested.
    pub checks: u64,
}

/// Why there is no path.
#[derive(Debug, Clone, PartialEq)]
pub enum PlanError {
    /// An argument cannot be used; the text says which, and what is expected.
    Argument(String),
    /// The start is outside of the bounds or not possible.
    StartInvalid,
    /// No goal is within the bounds and possible.
    GoalInvalid,
    /// None was found within the budget.
    NotFound {
        /// Number of states tested.
        checks: u64,
        /// The path to the state nearest to a goal, and its distance.
        nearest: Option<(Path, f64)>,
    },
    /// The observer ended the search.
    Cancelled {
        /// Number of states tested.
        checks: u64,
    },
}

impl std::fmt::Display for PlanError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PlanError::Argument(text) => f.write_str(text),
            PlanError::StartInvalid => f.write_str("the start is not valid: out of bounds, or in collision"),
            PlanError::GoalInvalid => f.write_str("no goal is valid: all are out of bounds or in collision"),
            PlanError::NotFound { checks, .. } => write!(f, "no path was found within {checks} checks"),
            PlanError::Cancelled { checks } => write!(f, "the search was cancelled after {checks} checks"),
        }
    }
}

impl std::error::Error for PlanError {}
