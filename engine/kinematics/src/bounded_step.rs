//! The step of damped least squares between bounds.

/// Finds the step d between bounds that minimises |J d - e|² + damping |d|², by an active set: steps at a bound are fixed
/// there, and freed if they would leave it inward. The memory is allocated once.
#[derive(Debug, Clone)]
pub(crate) struct BoundedStep {
    rows: usize,
    columns: usize,
    /// The Jacobian, column by column.
    pub jacobian: Vec<f64>,
    /// What is missing in each row.
    pub error: Vec<f64>,
    /// The bounds of the step, and the step.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    pub step: Vec<f64>,
    fixed: Vec<bool>,
    square: Vec<f64>,
    /// Working memory, and the result of [`weakest_direction`](Self::weakest_direction).
    pub rest: Vec<f64>,
}

/// Slack of bounds, as a share of a step of 1: below it, a step counts as being at its bound.
const SLACK: f64 = 1e-12;
/// Iterations towards the weakest direction, and the damping with which the matrix can be factored.
const WEAKEST_ITERATIONS: u32 = 30;
const WEAKEST_DAMPING: f64 = 1e-8;

impl BoundedStep {
    /// Allocates the memory for at most this many rows.
    pub fn new(max_rows: usize, columns: usize) -> Self {
        BoundedStep {
            rows: max_rows,
            columns,
            jacobian: vec![0.0; max_rows * columns],
            error: vec![0.0; max_rows],
            low: vec![0.0; columns],
            high: vec![0.0; columns],
            step: vec![0.0; columns],
            fixed: vec![false; columns],
            square: vec![0.0; max_rows * max_rows],
            rest: vec![0.0; max_rows],
        }
    }

    /// Sets the number of rows in use.
    pub fn set_rows(&mut self, rows: usize) {
        self.rows = rows;
    }

    /// Computes the step. Returns `false` if there is none, because a value is not finite.
    pub fn solve(&mut self, damping: f64) -> bool {
        for c in 0..self.columns {
            // A joint at a limit that the gradient pushes against.
            let slope: f64 = self.column(c).iter().zip(&self.error).map(|(j, e)| j * e).sum();
            self.fixed[c] = (self.high[c] <= SLACK && slope > 0.0) || (self.low[c] >= -SLACK && slope < 0.0);
            self.step[c] = 0.0_f64.clamp(self.low[c], self.high[c]);
        }
        for _ in 0..2 * self.columns + 2 {
            if !self.solve_free(damping) {
                return false;
            }
            let mut changed = false;
            for c in 0..self.columns {
                let wanted: f64 = self.column(c).iter().zip(&self.rest).map(|(j, y)| j * y).sum();
                let (low, high) = (self.low[c], self.high[c]);
                if !self.fixed[c] {
                    self.step[c] = wanted.clamp(low, high);
                    if wanted < low - SLACK || wanted > high + SLACK {
                        self.fixed[c] = true;
                        changed = true;
                    }
                } else if (self.step[c] <= low && wanted > low + SLACK)
                    || (self.step[c] >= high && wanted < high - SLACK)
                {
                    // A joint that cannot move at all stays fixed.
                    if high - low > SLACK {
                        self.fixed[c] = false;
                        changed = true;
                    }
                }
            }
            if !changed {
                break;
            }
        }
        self.step.iter().all(|s| s.is_finite())
    }

    /// Computes, in `rest`, the unit vector u among the rows for which |J' u| is least, by inverse iteration from the
    /// error; returns that value. Returns `None` if there is no error, or a value is not finite.
    pub fn weakest_direction(&mut self) -> Option<f64> {
        let m = self.rows;
        self.fixed.fill(false);
        if !self.solve_free(WEAKEST_DAMPING) {
            return None;
        }
        for i in 0..WEAKEST_ITERATIONS {
            let norm = self.rest[..m].iter().map(|x| x * x).sum::<f64>().sqrt();
            // Also refuses a value that is not a number.
            if norm.is_nan() || norm <= 0.0 {
                return None;
            }
            self.rest[..m].iter_mut().for_each(|x| *x /= norm);
            if i + 1 < WEAKEST_ITERATIONS {
                solve_factored(&self.square[..m * m], &mut self.rest[..m]);
            }
        }
        let moved = |c| self.column(c).iter().zip(&self.rest).map(|(j, u)| j * u).sum::<f64>();
        Some((0..self.columns).map(moved).map(|x| x * x).sum::<f64>().sqrt())
    }

    fn column(&self, c: usize) -> &[f64] {
        &self.jacobian[c * self.rows..][..self.rows]
    }

    /// Computes `rest`, y = (J J' + damping)⁻¹ (e - J d), in which J J' counts the free columns and J d the fixed ones:
    /// the free steps are then J' y.
    fn solve_free(&mut self, damping: f64) -> bool {
        let m = self.rows;
        self.rest[..m].copy_from_slice(&self.error[..m]);
        self.square[..m * m].fill(0.0);
        for r in 0..m {
            self.square[r * m + r] = damping;
        }
        for c in 0..self.columns {
            let column = &self.jacobian[c * m..][..m];
            if self.fixed[c] {
                let step = self.step[c];
                if step != 0.0 {
                    self.rest.iter_mut().zip(column).for_each(|(rest, j)| *rest -= j * step);
                }
                continue;
            }
            for r in 0..m {
                let own = column[r];
                let row = &mut self.square[r * m..][..r + 1];
                row.iter_mut().zip(column).for_each(|(square, j)| *square += own * j);
            }
        }
        factor(&mut self.square[..m * m], m) && {
            solve_factored(&self.square[..m * m], &mut self.rest[..m]);
            true
        }
    }
}

/// Replaces the lower triangle of a matrix A, row by row, by L with L L' = A, but with the reciprocals of the diagonal.
fn factor(a: &mut [f64], m: usize) -> bool {
    for i in 0..m {
        let (above, row) = a.split_at_mut(i * m);
        for j in 0..i {
            let other = &above[j * m..][..j + 1];
            let mut x = row[j];
            for (k, value) in other[..j].iter().enumerate() {
                x -= row[k] * value;
            }
            row[j] = x * other[j];
        }
        let mut pivot = row[i];
        for value in &row[..i] {
            pivot -= value * value;
        }
        // Also refuses a value that is not a number.
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        row[i] = 1.0 / pivot.sqrt();
    }
    true
}

fn solve_factored(l: &[f64], x: &mut [f64]) {
    let m = x.len();
    for i in 0..m {
        let mut value = x[i];
        for k in 0..i {
            value -= l[i * m + k] * x[k];
        }
        x[i] = value * l[i * m + i];
    }
    for i in (0..m).rev() {
        let mut value = x[i];
        for k in i + 1..m {
            value -= l[k * m + i] * x[k];
        }
        x[i] = value * l[i * m + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of x + y towards 2, with x at most 0.5: the minimum of the Lagrangian by hand.
    #[test]
    fn joint_at_its_bound_is_made_up_for_by_another() {
        let mut all = BoundedStep::new(1, 2);
        all.jacobian.copy_from_slice(&[1.0, 1.0]);
        all.error[0] = 2.0;
        all.low.copy_from_slice(&[-1.0, -10.0]);
        all.high.copy_from_slice(&[0.5, 10.0]);
        assert!(all.solve(1e-9));
        assert_eq!(all.step[0], 0.5);
        assert!((all.step[1] - 1.5).abs() < 1e-8);
    }

    #[test]
    fn step_without_room_is_zero() {
        let mut all = BoundedStep::new(1, 1);
        (all.jacobian[0], all.error[0]) = (1.0, 1.0);
        assert!(all.solve(1e-9));
        assert_eq!(all.step[0], 0.0);
    }

    #[test]
    fn value_that_is_no_number_is_refused() {
        let mut all = BoundedStep::new(1, 1);
        (all.jacobian[0], all.error[0]) = (f64::NAN, 1.0);
        (all.low[0], all.high[0]) = (-1.0, 1.0);
        assert!(!all.solve(1e-9));
    }
}
