//! One search for joint positions within bounds: starts, and iterations from each.

use crate::{
    bounded_step::BoundedStep,
    chain::Chain,
    random::Random,
    reach_task::{Distance, Goal, Target, measure, write_jacobian},
};

/// Iterations without enough progress after which a start is given up, and what is enough.
const MAX_SLOW_ITERATIONS: u32 = 12;
const PROGRESS: f64 = 0.98;
/// A full turn, rad.
const TURN: f64 = 2.0 * std::f64::consts::PI;
/// Largest step of a joint in an iteration, rad or m.
const MAX_STEP: f64 = 1.0;
/// Damping grows with the error: `DAMPING_SHARE` times the squared error, plus `MIN_DAMPING`. Values, as those above, by
/// experiments on arms with 6 and 7 joints.
const DAMPING_SHARE: f64 = 0.01;
const MIN_DAMPING: f64 = 1e-8;
/// Share of the way to the posture, and largest step towards it in an iteration.
const POSTURE_SHARE: f64 = 0.3;
const MAX_POSTURE_STEP: f64 = 0.2;
/// A posture is assumed if no joint moves more than this in an iteration, rad or m.
const POSTURE_PRECISION: f64 = 1e-7;
/// Range of joints without limits in random positions, rad or m.
const FREE_RANGE: f64 = std::f64::consts::PI;
/// The same for distances that are reported, which must be accurate.
const MAX_SLOW_REPORTED: u32 = 40;
const PROGRESS_REPORTED: f64 = 0.9999;
const MAX_ITERATIONS_REPORTED: u32 = 400;

/// How a descent goes on.
#[derive(Clone, Copy)]
pub(crate) struct Descent<'a> {
    iterations: u32,
    posture: Option<&'a [f64]>,
    slow: u32,
    progress: f64,
    /// Whether a step that increases the error is taken back, and damping grows: slower, but also converges where the
    /// goals are out of reach.
    careful: bool,
}

impl<'a> Descent<'a> {
    /// Returns a descent that ends soon if the goals seem to be out of reach.
    pub fn quick(iterations: u32, posture: Option<&'a [f64]>) -> Self {
        Descent { iterations, posture, slow: MAX_SLOW_ITERATIONS, progress: PROGRESS, careful: false }
    }
    /// Returns a descent to the least error, also of goals that are out of reach.
    pub fn careful() -> Self {
        Descent {
            iterations: MAX_ITERATIONS_REPORTED,
            posture: None,
            slow: MAX_SLOW_REPORTED,
            progress: PROGRESS_REPORTED,
            careful: true,
        }
    }
}

/// The joints, their targets and bounds, and the positions of a search. The memory is allocated once.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    pub chain: Chain,
    pub step: BoundedStep,
    pub targets: Vec<Target>,
    pub rows: usize,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    q: Vec<f64>,
    toward: Vec<f64>,
    /// Iterations since the beginning of the search.
    pub iterations: u32,
    /// The best positions of the last descent, and how far they are: squared weighted error, and distances.
    pub best: Vec<f64>,
    pub best_error: f64,
    pub best_distance: Distance,
}

impl Search {
    /// Allocates the memory for a chain.
    pub fn new(chain: Chain) -> Self {
        let n = chain.joints().len();
        let zeros = || vec![0.0; n];
        Search {
            step: BoundedStep::new(6 * chain.tips(), n),
            targets: Vec::with_capacity(chain.tips()),
            rows: 0,
            low: zeros(),
            high: zeros(),
            q: zeros(),
            toward: zeros(),
            iterations: 0,
            best: zeros(),
            best_error: f64::INFINITY,
            best_distance: Distance::default(),
            chain,
        }
    }

    /// Sets the targets; `oriented` is false if orientations shall not count.
    pub fn set_targets(&mut self, goals: &[Goal], oriented: bool) {
        self.targets.clear();
        self.targets.extend(goals.iter().map(|g| Target::new(g, oriented)));
        self.rows = self.targets.iter().map(Target::rows).sum();
        self.step.set_rows(self.rows);
    }

    /// Bounds the positions by the limits of the joints and, if given, by the greatest changes from a start.
    pub fn set_box(&mut self, change: Option<(&[f64], &[f64])>) {
        for (i, [low, high]) in self.chain.limits().iter().enumerate() {
            (self.low[i], self.high[i]) = (*low, *high);
            if let Some((start, change)) = change {
                let from = start[i].clamp(*low, *high);
                (self.low[i], self.high[i]) = (low.max(from - change[i]), high.min(from + change[i]));
            }
        }
    }

    /// Removes all bounds.
    pub fn remove_box(&mut self) {
        self.low.fill(f64::NEG_INFINITY);
        self.high.fill(f64::INFINITY);
    }

    /// Returns how far the tips are from their targets at some positions, where the chain and the Jacobian are then.
    pub fn look(&mut self, q: &[f64]) -> Distance {
        self.chain.place(q);
        write_jacobian(&self.chain, &self.targets, self.rows, &mut self.step.jacobian);
        measure(&self.chain, &self.targets, &mut self.step.error).0
    }

    /// Sets the positions from which a descent starts: those given, or else random ones.
    pub fn start(&mut self, restart: u32, start: &[f64], random: &mut Random) {
        for (i, q) in self.q.iter_mut().enumerate() {
            let [low, high] = self.chain.limits()[i];
            *q = if restart == 0 {
                start[i].clamp(self.low[i], self.high[i])
            } else {
                let low = low.max(start[i].min(high) - FREE_RANGE);
                let high = high.min(start[i].max(low) + FREE_RANGE);
                low + (high - low) * random.next()
            };
        }
    }

    /// Iterates until the goals are reached, which returns `true`, or until nothing improves. `best` is then where the
    /// error was least.
    pub fn descend(&mut self, how: Descent<'_>) -> bool {
        self.best_error = f64::INFINITY;
        let (mut slow, mut gate, mut reached_once, mut extra) = (0, f64::INFINITY, false, 0.0);
        for iteration in 0..=how.iterations {
            self.chain.place(&self.q);
            let (distance, reached) = measure(&self.chain, &self.targets, &mut self.step.error);
            let error: f64 = self.step.error[..self.rows].iter().map(|e| e * e).sum();
            if error < self.best_error || (reached && how.posture.is_some()) {
                (self.best_error, self.best_distance) = (error, distance);
                self.best.copy_from_slice(&self.q);
            }
            if how.careful {
                if error > self.best_error {
                    self.q.copy_from_slice(&self.best);
                    self.chain.place(&self.q);
                    measure(&self.chain, &self.targets, &mut self.step.error);
                    extra = f64::max(4.0 * extra, DAMPING_SHARE * self.best_error + MIN_DAMPING);
                } else {
                    extra *= 0.5;
                }
            }
            reached_once |= reached;
            if reached && how.posture.is_none() || iteration == how.iterations {
                break;
            }
            if error < gate * how.progress {
                (gate, slow) = (error, 0);
            } else if !reached {
                slow += 1;
                if slow > how.slow {
                    break;
                }
            }
            self.iterations += 1;
            let moved = self.advance(DAMPING_SHARE * error + MIN_DAMPING + extra, how.posture);
            // Without a number, the step was not finite.
            if moved.is_none_or(|moved| reached && moved < POSTURE_PRECISION) {
                break;
            }
        }
        reached_once
    }

    /// Moves the joints by one step; returns the largest change.
    fn advance(&mut self, damping: f64, posture: Option<&[f64]>) -> Option<f64> {
        write_jacobian(&self.chain, &self.targets, self.rows, &mut self.step.jacobian);
        let n = self.q.len();
        for i in 0..n {
            self.step.low[i] = self.low[i] - self.q[i];
            self.step.high[i] = self.high[i] - self.q[i];
        }
        // With d = step - toward, damping pulls towards the posture, where the goals leave the joints free.
        if let Some(posture) = posture {
            for (i, wanted) in posture.iter().enumerate() {
                let toward = ((wanted - self.q[i]) * POSTURE_SHARE).clamp(-MAX_POSTURE_STEP, MAX_POSTURE_STEP);
                self.toward[i] = toward;
                self.step.low[i] -= toward;
                self.step.high[i] -= toward;
                let column = &self.step.jacobian[i * self.rows..][..self.rows];
                self.step.error.iter_mut().zip(column).for_each(|(e, j)| *e -= j * toward);
            }
        }
        if !self.step.solve(damping) {
            return None;
        }
        if posture.is_some() {
            self.step.step.iter_mut().zip(&self.toward).for_each(|(step, toward)| *step += toward);
        }
        let largest = self.step.step.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let scale = if largest > MAX_STEP { MAX_STEP / largest } else { 1.0 };
        for i in 0..n {
            self.q[i] = (self.q[i] + scale * self.step.step[i]).clamp(self.low[i], self.high[i]);
        }
        Some(largest)
    }

    /// Turns joints by full turns to the positions that are nearest to `start`.
    pub fn turn_towards(&mut self, start: &[f64]) {
        for i in (0..self.best.len()).filter(|i| self.chain.repeats(*i)) {
            let [low, high] = self.chain.limits()[i];
            // Turns downwards and upwards that the limits allow; `best` is within them.
            let [down, up] = [low, high].map(|limit| ((limit - self.best[i]) / TURN).trunc());
            let turns = ((start[i] - self.best[i]) / TURN).round().clamp(down.min(0.0), up.max(0.0));
            self.best[i] = (self.best[i] + turns * TURN).clamp(low, high);
        }
    }

    /// Turns joints by full turns to the middle of their limits.
    pub fn turn_into_limits(&mut self) {
        for i in (0..self.best.len()).filter(|i| self.chain.repeats(*i)) {
            let [low, high] = self.chain.limits()[i];
            if low.is_finite() && high.is_finite() {
                self.best[i] -= TURN * ((self.best[i] - 0.5 * (low + high)) / TURN).round();
            }
        }
    }
}
