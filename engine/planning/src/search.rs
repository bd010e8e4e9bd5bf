//! What all planners share: tests of states and motions within a budget.

use crate::{
    problem::{Goal, GoalDistance, Path, PlanError, Problem, Progress, Settings, Validity},
    random::Random,
    space::StateSpace,
};

/// The observer is asked once in this many checks.
const CHECKS_BETWEEN_REPORTS: u64 = 256;

/// So many comparisons of a sample with nodes cost about as much as the test of a state, and count as one.
const COMPARISONS_PER_CHECK: usize = 256;

/// Why a search ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stop {
    Budget,
    Cancelled,
}

/// Asked now and then how to go on: `false` ends the search.
pub type Observer<'a> = dyn FnMut(Progress) -> bool + 'a;

/// Tests of states and motions, which count.
pub(crate) struct Search<'a> {
    pub space: &'a StateSpace,
    pub random: Random,
    pub checks: u64,
    pub nodes: usize,
    validity: &'a mut dyn Validity,
    observer: &'a mut Observer<'a>,
    max_checks: u64,
    resolution: f64,
    next_report: u64,
    buffer: Vec<f64>,
}

impl<'a> Search<'a> {
    pub fn new(
        space: &'a StateSpace,
        settings: &Settings,
        validity: &'a mut dyn Validity,
        observer: &'a mut Observer<'a>,
    ) -> Self {
        Search {
            space,
            random: Random::new(settings.seed),
            checks: 0,
            nodes: 0,
            validity,
            observer,
            max_checks: settings.max_checks,
            resolution: settings.resolution,
            next_report: CHECKS_BETWEEN_REPORTS,
            buffer: Vec::new(),
        }
    }

    /// Counts checks before they are made.
    fn charge(&mut self, count: u64) -> Result<(), Stop> {
        if self.checks >= self.max_checks {
            return Err(Stop::Budget);
        }
        self.checks += count;
        if self.checks >= self.next_report {
            self.next_report = self.checks + CHECKS_BETWEEN_REPORTS;
            if !(self.observer)(Progress { checks: self.checks, nodes: self.nodes }) {
                return Err(Stop::Cancelled);
            }
        }
        Ok(())
    }

    /// Counts a comparison of a sample with all nodes of a tree: without it, the time of a search would grow with the
    /// square of its budget.
    pub fn charge_comparisons(&mut self, nodes: usize) -> Result<(), Stop> {
        self.charge((nodes / COMPARISONS_PER_CHECK) as u64)
    }

    /// Returns whether a state is possible.
    pub fn is_valid(&mut self, state: &[f64]) -> Result<bool, Stop> {
        self.charge(1)?;
        Ok(self.validity.is_valid(state))
    }

    /// Returns whether a motion between two states, the first of which has been tested, is possible.
    pub fn is_free(&mut self, from: &[f64], to: &[f64]) -> Result<bool, Stop> {
        let (space, lanes) = (self.space, self.validity.lanes().max(1));
        let pieces = space.pieces(from, to, self.resolution);
        let motion = space.motion(from, to);
        let rounds = pieces.div_ceil(lanes);
        let dimension = space.dimension();
        // The end comes first, and each round is spread over the whole motion: what is far from what has been tested is
        // the most likely to collide.
        for round in 0..rounds {
            self.buffer.clear();
            let mut i = pieces - round;
            for _ in 0..lanes {
                motion.append_at(i as f64 / pieces as f64, &mut self.buffer);
                if i <= rounds {
                    break;
                }
                i -= rounds;
            }
            self.charge((self.buffer.len() / dimension) as u64)?;
            if !self.validity.are_valid(&self.buffer, dimension) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns whether a motion is possible whose end has been tested, and not its start.
    pub fn is_free_from(&mut self, from: &[f64], to: &[f64]) -> Result<bool, Stop> {
        if self.space.is_symmetric() {
            self.is_free(to, from)
        } else {
            Ok(self.is_valid(from)? && self.is_free(from, to)?)
        }
    }

    /// Returns the error for the end of a search.
    pub fn error(&self, stop: Stop, nearest: Option<(Path, f64)>) -> PlanError {
        match stop {
            Stop::Budget => PlanError::NotFound { checks: self.checks, nearest },
            Stop::Cancelled => PlanError::Cancelled { checks: self.checks },
        }
    }
}

/// Start and goals that have been tested.
pub(crate) struct Ends<'a> {
    pub start: Vec<f64>,
    pub goals: Vec<Vec<f64>>,
    pub region: Option<GoalDistance<'a>>,
}

impl<'a> Ends<'a> {
    pub fn new(problem: Problem<'a>, settings: &Settings, search: &mut Search<'_>) -> Result<Self, PlanError> {
        let space = problem.space;
        let argument = PlanError::Argument;
        let checked = |what: &str, state: &[f64]| {
            if state.len() != space.dimension() {
                let (given, wanted) = (state.len(), space.dimension());
                return Err(argument(format!("{what} has {given} numbers; expected {wanted}, those of a state")));
            }
            if let Some(flawed) = state.iter().position(|x| !x.is_finite()) {
                return Err(argument(format!(
                    "number {} of {what} is {}; expected a finite one",
                    flawed + 1,
                    state[flawed]
                )));
            }
            Ok(())
        };
        if !(settings.resolution > 0.0 && settings.resolution <= 1.0) {
            return Err(argument(format!("the resolution is {}; expected a share from 0 to 1", settings.resolution)));
        }
        if !(settings.range >= 0.0 && settings.range.is_finite()) {
            return Err(argument(format!("the range is {}; expected a distance of at least 0", settings.range)));
        }
        checked("the start", problem.start)?;
        let failed = |stop, search: &Search<'_>| search.error(stop, None);
        let possible = |search: &mut Search<'_>, state: &[f64]| -> Result<bool, PlanError> {
            Ok(space.is_within(state) && search.is_valid(state).map_err(|stop| failed(stop, search))?)
        };
        if !possible(search, problem.start)? {
            return Err(PlanError::StartInvalid);
        }
        let (mut goals, mut region) = (Vec::new(), None);
        match problem.goal {
            Goal::States(states) if states.is_empty() => {
                return Err(argument("there is no goal; expected a state".to_owned()));
            }
            Goal::States(states) => {
                for (i, state) in states.into_iter().enumerate() {
                    checked(&format!("goal {}", i + 1), &state)?;
                    if possible(search, &state)? {
                        goals.push(state);
                    }
                }
                if goals.is_empty() {
                    return Err(PlanError::GoalInvalid);
                }
            }
            Goal::Region(distance) => region = Some(distance),
        }
        Ok(Ends { start: problem.start.to_vec(), goals, region })
    }

    /// Returns the distance of a state from the goal, 0 if it is one.
    pub fn distance(&mut self, space: &StateSpace, state: &[f64]) -> f64 {
        match &mut self.region {
            Some(region) => region(state).max(0.0),
            None => self.goals.iter().map(|goal| space.distance(state, goal)).fold(f64::INFINITY, f64::min),
        }
    }
}
