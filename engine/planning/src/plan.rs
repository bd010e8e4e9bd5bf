//! Solves problems by any of the methods.

use std::sync::{
    Mutex,
    atomic::{AtomicU64, AtomicUsize, Ordering},
};

use crate::{
    connect::rrt_connect,
    problem::{Algorithm, Goal, PlanError, Problem, Progress, Settings, Solution, Validity},
    roadmap::prm,
    rrt::rrt,
    search::{Ends, Observer, Search},
    space::StateSpace,
};

/// Range of a branch as a share of the extent of the space, unless set.
const RANGE_SHARE: f64 = 0.2;

/// Searches a path. The same arguments give the same path on all processors.
///
/// RRT-Connect and the networks need goals that are states; for a region, a single tree is grown instead. So it is
/// instead of a network in the space of a car that only moves forward.
///
/// ```
/// use tatu_planning::{Goal, Problem, Settings, StateSpace, plan};
///
/// // A point in a square, with a wall that is open at the top.
/// let space = StateSpace::reals(&[0.0, 0.0], &[1.0, 1.0])?;
/// let mut validity = |p: &[f64]| !((0.45..0.55).contains(&p[0]) && p[1] < 0.8);
/// let problem = Problem { space: &space, start: &[0.1, 0.1], goal: Goal::States(vec![vec![0.9, 0.1]]) };
/// let found = plan(problem, &Settings::default(), &mut validity, &mut |_| true)?;
/// assert_eq!(found.path.states.last(), Some(&vec![0.9, 0.1]));
/// assert!(found.path.length(&space) > 1.4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns the reason if an argument cannot be used, start or goal are not possible, nothing was found within the
/// budget, or the observer has ended the search, which is asked about once in 256 checks.
pub fn plan<'a>(
    problem: Problem<'a>,
    settings: &Settings,
    validity: &'a mut dyn Validity,
    observer: &'a mut Observer<'a>,
) -> Result<Solution, PlanError> {
    let space = problem.space;
    let mut search = Search::new(space, settings, validity, observer);
    let mut ends = Ends::new(problem, settings, &mut search)?;
    let range = if settings.range > 0.0 { settings.range } else { RANGE_SHARE * space.extent() };
    let single = ends.region.is_some();
    // The edges of a network are used in both directions.
    let one_way = !space.is_symmetric();
    let path = match settings.algorithm {
        Algorithm::RrtStar => rrt(&mut search, &mut ends, settings, range, true),
        Algorithm::Rrt => rrt(&mut search, &mut ends, settings, range, false),
        _ if single => rrt(&mut search, &mut ends, settings, range, false),
        Algorithm::RrtConnect => rrt_connect(&mut search, &mut ends, range),
        Algorithm::Prm | Algorithm::PrmStar if one_way => rrt(&mut search, &mut ends, settings, range, false),
        Algorithm::Prm => prm(&mut search, &ends, false),
        Algorithm::PrmStar => prm(&mut search, &ends, true),
    }?;
    Ok(Solution { path, checks: search.checks })
}

/// How many searches with different seeds are made, and on how many threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seeds {
    /// Number of searches; their seeds follow that of the settings.
    pub count: usize,
    /// Number of threads, which does not change the result.
    pub threads: usize,
}

/// Solves a problem several times with different seeds, on several threads, and returns the solution that needed the
/// fewest checks; of equal ones, that of the first seed. The number of threads does not change the result.
///
/// `validity` makes a test of states for each search.
///
/// # Errors
///
/// As [`plan`], with the error of the first seed.
pub fn plan_with_seeds<V: Validity>(
    space: &StateSpace,
    start: &[f64],
    goals: &[Vec<f64>],
    settings: &Settings,
    Seeds { count: seeds, threads }: Seeds,
    validity: &(dyn Fn() -> V + Sync),
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<Solution, PlanError> {
    let (next, least) = (AtomicUsize::new(0), AtomicU64::new(u64::MAX));
    let found: Mutex<Vec<(usize, Result<Solution, PlanError>)>> = Mutex::new(Vec::new());
    let work = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= seeds.max(1) {
                return;
            }
            let own = Settings { seed: settings.seed.wrapping_add(i as u64), ..*settings };
            let problem = Problem { space, start, goal: Goal::States(goals.to_vec()) };
            // A search that has needed more than another one's total cannot win.
            let mut observer = |progress: Progress| progress.checks <= least.load(Ordering::Relaxed) && !is_cancelled();
            let outcome = plan(problem, &own, &mut validity(), &mut observer);
            if let Ok(solution) = &outcome {
                least.fetch_min(solution.checks, Ordering::Relaxed);
            }
            if let Ok(mut all) = found.lock() {
                all.push((i, outcome));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.clamp(1, seeds.max(1)) {
            scope.spawn(work);
        }
        work();
    });
    let mut all = found.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    all.sort_by_key(|(i, _)| *i);
    let best = all.iter().filter_map(|(i, r)| r.as_ref().ok().map(|s| (s.checks, *i))).min();
    let wanted = best.map_or(0, |(_, i)| i);
    let chosen = all.into_iter().find(|(i, _)| *i == wanted).map(|(_, outcome)| outcome);
    chosen.unwrap_or(Err(PlanError::NotFound { checks: 0, nearest: None }))
}
