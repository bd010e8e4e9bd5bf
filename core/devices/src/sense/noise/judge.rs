//! Statistical checks for tests. The seeds are fixed, so each check either always passes or always fails. Each
//! threshold is chosen such that correct noise with a different seed would exceed it in less than one case in a
//! thousand.

/// Returns the mean.
pub fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Returns the standard deviation about a known mean of 0.
pub fn deviation(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

/// Returns Pearson's correlation of numbers with mean 0.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let product = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
    product / (deviation(a) * deviation(b))
}

/// Returns the standard normal distribution function at `z`.
pub fn phi(z: f64) -> f64 {
    libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2) / 2.0
}

/// Kolmogorov-Smirnov test: D is the greatest difference between the share of numbers below x and `below(x)`. The
/// probability that D sqrt(n) exceeds 1.95 is 2 exp(-2 * 1.95^2) = 0.001.
pub fn kolmogorov_smirnov(x: &[f64], below: impl Fn(f64) -> f64) -> Result<(), String> {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let gap = |(i, x): (usize, &f64)| (below(*x) - i as f64 / n).abs().max((below(*x) - (i + 1) as f64 / n).abs());
    let d = sorted.iter().enumerate().map(gap).fold(0.0, f64::max) * n.sqrt();
    if d < 1.95 { Ok(()) } else { Err(format!("Kolmogorov-Smirnov {d}")) }
}

/// Checks that numbers are independent. The correlation of n independent pairs has the standard deviation 1 / sqrt(n);
/// one in 16,000 exceeds 4 of these.
pub fn independent(x: &[f64]) -> Result<(), String> {
    let about = mean(x);
    let x: Vec<f64> = x.iter().map(|x| x - about).collect();
    for lag in [1, 2, 3, 7, 256] {
        let r = correlation(&x[lag..], &x[..x.len() - lag]);
        if r.abs() > 4.0 / (x.len() as f64).sqrt() {
            return Err(format!("correlation {r} at lag {lag}"));
        }
    }
    Ok(())
}

/// Checks for white normal noise of mean 0 and standard deviation `sigma`. The mean of n numbers has the standard
/// deviation sigma / sqrt(n), their standard deviation has sigma / sqrt(2 n); the tolerance is 4 of each.
pub fn white(x: &[f64], sigma: f64) -> Result<(), String> {
    let n = x.len() as f64;
    if mean(x).abs() > 4.0 * sigma / n.sqrt() {
        return Err(format!("mean {}", mean(x)));
    }
    if (deviation(x) / sigma - 1.0).abs() > 4.0 / (2.0 * n).sqrt() {
        return Err(format!("standard deviation {}", deviation(x)));
    }
    kolmogorov_smirnov(x, |x| phi(x / sigma))?;
    independent(x)
}

/// Checks that numbers are uniformly distributed in [-a, a].
pub fn even(x: &[f64], a: f64) -> Result<(), String> {
    kolmogorov_smirnov(x, |x| ((x / a + 1.0) / 2.0).clamp(0.0, 1.0))?;
    independent(x)
}

/// Returns the Allan deviation for averages over `m` consecutive samples: the square root of half the mean square of
/// the differences between successive averages.
pub fn allan(x: &[f64], m: usize) -> f64 {
    let averages: Vec<f64> = x.chunks_exact(m).map(mean).collect();
    let squares = averages.windows(2).map(|w| (w[1] - w[0]).powi(2));
    (squares.sum::<f64>() / (2.0 * (averages.len() - 1) as f64)).sqrt()
}

/// Returns the Allan deviation of a Gauss-Markov process (IEEE Std 952-1997, annex C.1.6) with the long-run variance
/// sigma^2 = q^2 tau / 2, for averages over time `t`.
pub fn allan_of_walk(sigma: f64, tau: f64, t: f64) -> f64 {
    let x = t / tau;
    let rest = 1.0 - (3.0 - 4.0 * libm::exp(-x) + libm::exp(-2.0 * x)) / (2.0 * x);
    (2.0 * sigma * sigma / x * rest).sqrt()
}
