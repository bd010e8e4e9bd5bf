//! Makes paths shorter and smoother, and divides them.

use crate::{
    problem::{Path, PlanError, Settings, Validity},
    search::{Observer, Search, Stop},
    space::StateSpace,
};

/// Attempts without a gain after which a path counts as short.
const MAX_VAIN_ATTEMPTS: usize = 40;
/// Attempts with all of a path's states as ends before random ones.
const MAX_PAIRS: usize = 200;

/// Removes detours: first states that are not needed, then by ways between random points of the path. Returns the
/// number of checks. The path never becomes longer.
///
/// # Errors
///
/// Fails if the observer ends it; the path is then possible, too.
pub fn shorten<'a>(
    path: &mut Path,
    space: &'a StateSpace,
    settings: &Settings,
    validity: &'a mut dyn Validity,
    observer: &'a mut Observer<'a>,
) -> Result<u64, PlanError> {
    let mut search = Search::new(space, settings, validity, observer);
    match drop_states(path, &mut search).and_then(|()| cut_corners(path, &mut search)) {
        Err(Stop::Cancelled) => Err(search.error(Stop::Cancelled, None)),
        Ok(()) | Err(Stop::Budget) => Ok(search.checks),
    }
}

/// Leaves out states where the direct way is shorter and possible: the longest jumps first.
fn drop_states(path: &mut Path, search: &mut Search<'_>) -> Result<(), Stop> {
    let (mut first, mut pairs) = (0, 0);
    while first + 2 < path.states.len() {
        for last in (first + 2..path.states.len()).rev() {
            let (a, b) = (&path.states[first], &path.states[last]);
            let along: f64 = path.states[first..=last].windows(2).map(|w| search.space.distance(&w[0], &w[1])).sum();
            if search.space.distance(a, b) >= along - 1e-9 {
                continue;
            }
            pairs += 1;
            if pairs > MAX_PAIRS {
                return Ok(());
            }
            if search.is_free(a, b)? {
                path.states.drain(first + 1..last);
                break;
            }
        }
        first += 1;
    }
    Ok(())
}

/// Replaces parts between random points of the path by direct ways.
fn cut_corners(path: &mut Path, search: &mut Search<'_>) -> Result<(), Stop> {
    let space = search.space;
    let mut vain = 0;
    while vain < MAX_VAIN_ATTEMPTS && path.states.len() > 2 {
        vain += 1;
        let lengths: Vec<f64> = path.states.windows(2).map(|w| space.distance(&w[0], &w[1])).collect();
        let total: f64 = lengths.iter().sum();
        let (x, y) = (search.random.unit() * total, search.random.unit() * total);
        let (i, a) = point(space, path, &lengths, x.min(y));
        let (j, b) = point(space, path, &lengths, x.max(y));
        if i == j || space.distance(&a, &b) >= (x - y).abs() - 1e-9 * total {
            continue;
        }
        if search.is_free(&a, &b)? {
            let gain = (x - y).abs() - space.distance(&a, &b);
            path.states.splice(i + 1..=j, [a, b]);
            path.states.dedup();
            if gain > 1e-3 * total {
                vain = 0;
            }
        }
    }
    Ok(())
}

/// Returns the state at a length along a path, and the number of the state before it.
fn point(space: &StateSpace, path: &Path, lengths: &[f64], at: f64) -> (usize, Vec<f64>) {
    let mut rest = at;
    for (i, length) in lengths.iter().enumerate() {
        if rest <= *length && *length > 0.0 {
            return (i, space.motion(&path.states[i], &path.states[i + 1]).at(rest / length));
        }
        rest -= length;
    }
    let last = path.states.len() - 1;
    (last.saturating_sub(1), path.states[last].clone())
}

/// Rounds corners: each pass replaces every inner state by the middle of its neighbours' middles, where the ways remain
/// possible. Returns the number of checks.
///
/// # Errors
///
/// Fails if the observer ends it; the path is then possible, too.
pub fn smooth<'a>(
    path: &mut Path,
    passes: usize,
    space: &'a StateSpace,
    settings: &Settings,
    validity: &'a mut dyn Validity,
    observer: &'a mut Observer<'a>,
) -> Result<u64, PlanError> {
    let mut search = Search::new(space, settings, validity, observer);
    for _ in 0..passes {
        match round_corners(path, &mut search) {
            Ok(()) => {}
            Err(Stop::Budget) => break,
            Err(Stop::Cancelled) => return Err(search.error(Stop::Cancelled, None)),
        }
    }
    Ok(search.checks)
}

fn round_corners(path: &mut Path, search: &mut Search<'_>) -> Result<(), Stop> {
    let space = search.space;
    let count = path.states.len();
    let mut finer = Vec::with_capacity(2 * count);
    for pair in path.states.windows(2) {
        finer.push(pair[0].clone());
        finer.push(space.motion(&pair[0], &pair[1]).at(0.5));
    }
    finer.extend(path.states.last().cloned());
    for corner in (2..finer.len().saturating_sub(2)).step_by(2) {
        let chord = space.motion(&finer[corner - 1], &finer[corner + 1]).at(0.5);
        let inner = space.motion(&finer[corner], &chord).at(0.5);
        if space.distance(&finer[corner], &chord) > 1e-9
            && search.is_valid(&inner)?
            && search.is_free(&inner, &finer[corner + 1])?
            && search.is_free(&finer[corner - 1], &inner)?
        {
            finer[corner] = inner;
        }
    }
    path.states = finer;
    Ok(())
}

/// Divides a path into at least `count` states, evenly by distance; the states that it has remain.
pub fn divide(path: &Path, space: &StateSpace, count: usize) -> Path {
    let lengths: Vec<f64> = path.states.windows(2).map(|w| space.distance(&w[0], &w[1])).collect();
    let total: f64 = lengths.iter().sum();
    let missing = count.saturating_sub(path.states.len());
    if total <= 0.0 || missing == 0 {
        return path.clone();
    }
    // Each piece gets its share of what is still missing, so that the sum is exact.
    let (mut added, mut passed) = (0, 0.0);
    let mut states = Vec::with_capacity(count);
    for (pair, length) in path.states.windows(2).zip(&lengths) {
        passed += length;
        let here = (libm::round(missing as f64 * (passed / total)) as usize).saturating_sub(added);
        added += here;
        states.push(pair[0].clone());
        let motion = space.motion(&pair[0], &pair[1]);
        states.extend((1..=here).map(|i| motion.at(i as f64 / (here + 1) as f64)));
    }
    states.extend(path.states.last().cloned());
    Path { states }
}

/// Divides a path so that no motion is longer than a share of the extent of any part of the space.
pub fn divide_by_resolution(path: &Path, space: &StateSpace, share: f64) -> Path {
    let mut states = Vec::new();
    for pair in path.states.windows(2) {
        let (motion, pieces) = (space.motion(&pair[0], &pair[1]), space.pieces(&pair[0], &pair[1], share));
        states.push(pair[0].clone());
        states.extend((1..pieces).map(|i| motion.at(i as f64 / pieces as f64)));
    }
    states.extend(path.states.last().cloned());
    Path { states }
}
