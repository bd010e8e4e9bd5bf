//! A smooth curve through points.

/// A cubic spline in several coordinates through points at increasing parameters, with continuous second derivatives.
/// At both ends the third derivative is continuous across the second point and the last but one ("not a knot"), so that
/// points of one cubic curve give this curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    /// Parameter of each point.
    parameters: Vec<f64>,
    /// Number of coordinates.
    dimension: usize,
    /// Coordinates of each point, and second derivatives there.
    values: Vec<f64>,
    curvatures: Vec<f64>,
}

/// Position and derivatives by the parameter.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SplinePoint {
    /// Each coordinate.
    pub position: Vec<f64>,
    /// Its first derivative.
    pub first: Vec<f64>,
    /// Its second derivative.
    pub second: Vec<f64>,
}

impl Spline {
    /// Returns the spline through points of `dimension` coordinates each, one after another in `values`. Returns `None` if
    /// there are fewer than two points, if their number differs from that of the parameters, if a number is not finite,
    /// or if the parameters do not ascend.
    pub fn new(parameters: &[f64], dimension: usize, values: &[f64]) -> Option<Spline> {
        let n = parameters.len();
        let ascending = parameters.windows(2).all(|w| w[0] < w[1]);
        let finite = parameters.iter().chain(values).all(|x| x.is_finite());
        if n < 2 || dimension == 0 || values.len() != n * dimension || !ascending || !finite {
            return None;
        }
        let steps: Vec<f64> = parameters.windows(2).map(|w| w[1] - w[0]).collect();
        let mut curvatures = vec![0.0; n * dimension];
        for c in 0..dimension {
            let slope = |k: usize| (values[(k + 1) * dimension + c] - values[k * dimension + c]) / steps[k];
            for (k, curvature) in second_derivatives(&steps, slope).into_iter().enumerate() {
                curvatures[k * dimension + c] = curvature;
            }
        }
        Some(Spline { parameters: parameters.to_vec(), dimension, values: values.to_vec(), curvatures })
    }

    /// Returns the number of coordinates.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Returns the least and the greatest parameter.
    pub fn range(&self) -> [f64; 2] {
        [self.parameters[0], self.parameters[self.parameters.len() - 1]]
    }

    /// Returns the point at a parameter, which is clamped to the range.
    pub fn at(&self, parameter: f64) -> SplinePoint {
        let [least, greatest] = self.range();
        let s = parameter.clamp(least, greatest);
        let k = self.parameters.partition_point(|p| *p <= s).clamp(1, self.parameters.len() - 1) - 1;
        let h = self.parameters[k + 1] - self.parameters[k];
        let (b, a) = ((s - self.parameters[k]) / h, (self.parameters[k + 1] - s) / h);
        let mut point = SplinePoint::default();
        for c in 0..self.dimension {
            let [y0, y1] = [k, k + 1].map(|k| self.values[k * self.dimension + c]);
            let [m0, m1] = [k, k + 1].map(|k| self.curvatures[k * self.dimension + c]);
            point.position.push(a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0);
            point.first.push((y1 - y0) / h + ((1.0 - 3.0 * a * a) * m0 + (3.0 * b * b - 1.0) * m1) * h / 6.0);
            point.second.push(a * m0 + b * m1);
        }
        point
    }
}

/// Returns the second derivatives at all points, given the steps of the parameter and the slope in each step.
fn second_derivatives(steps: &[f64], slope: impl Fn(usize) -> f64) -> Vec<f64> {
    let n = steps.len() + 1;
    match n {
        2 => return vec![0.0; 2],
        // One parabola through three points.
        3 => return vec![2.0 * (slope(1) - slope(0)) / (steps[0] + steps[1]); 3],
        _ => {}
    }
    // Rows of the inner points: below, diagonal, above, right side. The conditions at the ends are substituted into the
    // first and the last one.
    let mut rows: Vec<[f64; 4]> = (1..n - 1)
        .map(|k| [steps[k - 1], 2.0 * (steps[k - 1] + steps[k]), steps[k], 6.0 * (slope(k) - slope(k - 1))])
        .collect();
    let last = rows.len() - 1;
    let (h0, h1) = (steps[0], steps[1]);
    rows[0][1] += h0 + h0 * h0 / h1;
    rows[0][2] -= h0 * h0 / h1;
    let (h0, h1) = (steps[n - 2], steps[n - 3]);
    rows[last][1] += h0 + h0 * h0 / h1;
    rows[last][0] -= h0 * h0 / h1;
    for k in 1..rows.len() {
        let factor = rows[k][0] / rows[k - 1][1];
        rows[k][1] -= factor * rows[k - 1][2];
        rows[k][3] -= factor * rows[k - 1][3];
    }
    let mut m = vec![0.0; n];
    for k in (0..rows.len()).rev() {
        let above = if k == last { 0.0 } else { rows[k][2] * m[k + 2] };
        m[k + 1] = (rows[k][3] - above) / rows[k][1];
    }
    m[0] = m[1] - steps[0] / steps[1] * (m[2] - m[1]);
    m[n - 1] = m[n - 2] + steps[n - 2] / steps[n - 3] * (m[n - 2] - m[n - 3]);
    m
}
