//! Statistical tests of noise: each check accepts the correct model and rejects wrong ones. All seeds are fixed.

use super::{judge::*, tests::*};

const SAMPLES: usize = 200_000;

/// Returns the errors of `SAMPLES` elements that all measure `value`.
fn errors(noise: &str, value: f64, seed: u64) -> Vec<f64> {
    let mut s = TestSensor::new(noise, SAMPLES, seed);
    s.measure(0.0, |fields| fields.of(FIELD_MANY).fill(value));
    s.read(FIELD_MANY).iter().map(|x| x - value).collect()
}

#[test]
fn white_noise_is_normal_and_independent() {
    white(&errors("many.sigma = 0.01", 3.0, 1), 0.01).unwrap();
    // Noise over successive measurements, in double and single precision.
    let mut s = TestSensor::new("one.sigma = 0.5\nsmall.sigma = 0.01", 1, 2);
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for i in 0..SAMPLES {
        s.measure(i as f64 * 0.05, |f| (f.of(FIELD_ONE)[0], f.of32(FIELD_SMALL)[0]) = (2.0, 2.0));
        x.push(s.read(FIELD_ONE)[0] - 2.0);
        y.push(f64::from(s.read32(FIELD_SMALL)[0]) - 2.0);
    }
    white(&x, 0.5).unwrap();
    white(&y, 0.01).unwrap();
    let together = correlation(&x, &y);
    assert!(together.abs() < 4.0 / (SAMPLES as f64).sqrt(), "{together}");
}

/// Noise that is not white noise of this sigma must be rejected.
#[test]
fn wrong_models_of_white_noise_are_rejected() {
    let fails = |x: &[f64], why: &str| assert!(white(x, 0.01).unwrap_err().starts_with(why), "{:?}", white(x, 0.01));
    fails(&errors("many.sigma = 0.011", 3.0, 1), "standard deviation");
    fails(&errors("many.sigma = 0.0101", 3.0, 1), "standard deviation");
    // Uniform noise with the same standard deviation.
    fails(&errors(&format!("many.uniform = {}", 0.01 * 3f64.sqrt()), 3.0, 1), "Kolmogorov");
    fails(&errors("many = { sigma = 0.01, step = 0.005 }", 3.0, 1), "standard deviation");
    let right = errors("many.sigma = 0.01", 3.0, 1);
    fails(&right.iter().map(|x| x + 0.0002).collect::<Vec<_>>(), "mean");
    // Each number contains a tenth of the previous one, with the same standard deviation.
    let mut before = 0.0;
    let correlated = right.iter().map(|x| {
        before = 0.1 * before + 0.99f64.sqrt() * x;
        before
    });
    fails(&correlated.collect::<Vec<_>>(), "correlation");
    // Each number occurs twice.
    let twice: Vec<f64> = right[..SAMPLES / 2].iter().flat_map(|x| [*x, *x]).collect();
    assert!(white(&twice, 0.01).is_err());
}

#[test]
fn uniform_noise_is_uniform_and_independent() {
    even(&errors("many.uniform = 0.1", 3.0, 1), 0.1).unwrap();
    assert!(even(&errors("many.uniform = 0.102", 3.0, 1), 0.1).is_err());
    assert!(even(&errors("many.sigma = 0.0577", 3.0, 1), 0.1).is_err());
}

#[test]
fn sigma_is_a_polynomial_in_the_value_or_another_field() {
    // 1.5 mm - 0.5 z + 0.3 z^2 is 1.7 mm at 2 m.
    white(&errors("many.sigma = [1.5e-3, -0.5e-3, 0.3e-3]", 2.0, 1), 1.7e-3).unwrap();
    assert!(white(&errors("many.sigma = [1.5e-3, -0.5e-3, 0.3e-3]", 3.0, 1), 1.7e-3).is_err());
    white(&errors("many.sigma = [0, 0, 0, 1e-3]", 2.0, 1), 8e-3).unwrap();
    // The polynomial depends on a different field, which is twice as large for half of the elements. The noise of that
    // field does not affect it.
    for more in ["", "\nother.sigma = 5"] {
        let mut s = TestSensor::new(&format!("many = {{ sigma = [0, 0.01], of = \"other\" }}{more}"), SAMPLES, 1);
        s.measure(0.0, |f| {
            f.of(FIELD_MANY).fill(7.0);
            f.of(FIELD_OTHER).iter_mut().enumerate().for_each(|(i, x)| *x = 1.0 + (i % 2) as f64);
        });
        let (even, odd): (Vec<_>, Vec<_>) =
            s.read(FIELD_MANY).iter().map(|x| x - 7.0).enumerate().partition(|(i, _)| i % 2 == 0);
        let plain = |v: Vec<(usize, f64)>| v.into_iter().map(|(_, x)| x).collect::<Vec<_>>();
        white(&plain(even), 0.01).unwrap();
        white(&plain(odd), 0.02).unwrap();
    }
}

/// Returns a walk of a million measurements, 0.1 s apart.
fn walk(sigma: f64, tau: f64) -> Vec<f64> {
    let mut s = TestSensor::new(&format!("one.walk = {{ sigma = {sigma}, tau_s = {tau} }}"), 1, 4);
    let measured = (0..1_000_000).map(|i| {
        s.measure(f64::from(i) * 0.1, |f| f.of(FIELD_ONE)[0] = 0.5);
        s.read(FIELD_ONE)[0] - 0.5
    });
    measured.collect()
}

/// Checks that the Allan deviation is that of a Gauss-Markov process: it must be proportional to the square root of
/// time for times much shorter than tau, and to its inverse for times much longer.
fn is_walk(x: &[f64], sigma: f64, tau: f64) -> Result<(), String> {
    let mut found = Vec::new();
    for m in [10usize, 40, 200, 1000, 4000, 16_000] {
        let t = m as f64 * 0.1;
        let (is, wanted) = (allan(x, m), allan_of_walk(sigma, tau, t));
        // The k differences are nearly independent, so the relative standard deviation is about 1 / sqrt(2 k), or
        // slightly more because neighbours share an average. The tolerance is 4 of these, plus 0.5 % for averages of
        // few samples.
        let close = 4.0 * 1.2 / (2.0 * (x.len() / m - 1) as f64).sqrt() + 0.005;
        if (is / wanted - 1.0).abs() > close {
            return Err(format!("Allan deviation {is} at {t} s, expected {wanted} within {close}"));
        }
        found.push(libm::log(is));
    }
    let slope = |i: usize| (found[i + 1] - found[i]) / libm::log(4f64);
    // The slopes from 1 s to 4 s, and from 400 s to 1600 s, for tau = 10 s, are 0.44 and -0.49 in closed form.
    let (rising, falling) = (slope(0), slope(4));
    match (rising - 0.5).abs() < 0.1 && (falling + 0.5).abs() < 0.15 {
        true => Ok(()),
        false => Err(format!("slopes {rising} and {falling}")),
    }
}

#[test]
fn bias_walk_is_a_gauss_markov_process() {
    let right = walk(2.0, 10.0);
    is_walk(&right, 2.0, 10.0).unwrap();
    // Over a long time, the standard deviation of the walk is its sigma, and values tau apart have the correlation 1/e.
    // There are 10^5 s / (2 tau) independent values.
    let sd = (right.iter().map(|x| x * x).sum::<f64>() / right.len() as f64).sqrt();
    assert!((sd / 2.0 - 1.0).abs() < 4.0 / (2.0 * 5000f64).sqrt(), "{sd}");
    let r = correlation(&right[100..], &right[..right.len() - 100]);
    assert!((r - (-1f64).exp()).abs() < 4.0 / 5000f64.sqrt(), "{r}");

    assert!(is_walk(&walk(2.2, 10.0), 2.0, 10.0).is_err(), "sigma times 1.1");
    assert!(is_walk(&walk(2.0, 12.0), 2.0, 10.0).is_err(), "tau times 1.2");
    let white = errors("many.sigma = 2", 0.5, 1);
    assert!(is_walk(&white, 2.0, 10.0).is_err(), "white noise");
    // An unbounded random walk.
    let mut sum = 0.0;
    let endless: Vec<f64> = white
        .iter()
        .map(|x| {
            sum += x * (2.0 * 0.1 / 10.0f64).sqrt();
            sum
        })
        .collect();
    assert!(is_walk(&endless, 2.0, 10.0).is_err(), "a walk without tau");
}

/// Measurements at different intervals sample the same process, since the walk depends on the elapsed time.
#[test]
fn walk_depends_on_the_elapsed_time() {
    for dt in [0.02, 0.5] {
        let mut s = TestSensor::new("one.walk = { sigma = 1, tau_s = 5 }", 1, 4);
        let n = 400_000;
        let x: Vec<f64> = (0..n)
            .map(|i| {
                s.measure(f64::from(i) * dt, |f| f.of(FIELD_ONE)[0] = 0.5);
                s.read(FIELD_ONE)[0] - 0.5
            })
            .collect();
        let lag = (5.0 / dt) as usize;
        let r = correlation(&x[lag..], &x[..x.len() - lag]);
        let independent = f64::from(n) * dt / 10.0;
        assert!((r - (-1f64).exp()).abs() < 4.0 / independent.sqrt(), "dt {dt}: {r}");
    }
}

#[test]
fn elements_drop_out_with_their_probability() {
    let lost = |noise: &str| errors(noise, 3.0, 1).iter().filter(|x| x.is_infinite()).count() as f64;
    // The standard deviation of the count is sqrt(n p (1 - p)) = 44.5; the tolerance is 4 of these.
    let close = 4.0 * (SAMPLES as f64 * 0.01 * 0.99).sqrt();
    assert!((lost("many.dropout = 0.01") - 2000.0).abs() < close);
    assert!((lost("many.dropout = 0.011") - 2000.0).abs() > close);
    assert_eq!((lost("many.dropout = 0"), lost("many.dropout = 1")), (0.0, SAMPLES as f64));
}

#[test]
fn outliers_have_their_declared_probability_and_size() {
    let found: Vec<f64> =
        errors("many.outliers = { probability = 0.05, sigma = 1 }", 3.0, 1).into_iter().filter(|x| *x != 0.0).collect();
    assert!((found.len() as f64 - 10_000.0).abs() < 4.0 * (SAMPLES as f64 * 0.05 * 0.95).sqrt(), "{}", found.len());
    white(&found, 1.0).unwrap();
    let found = errors("many.outliers = { probability = 0.05, uniform = 2 }", 3.0, 1);
    even(&found.into_iter().filter(|x| *x != 0.0).collect::<Vec<_>>(), 2.0).unwrap();
}

#[test]
fn shift_is_drawn_once_per_run() {
    let shifts = |noise: &str, component: usize| -> Vec<f64> {
        let of = |seed: u64| {
            let mut s = TestSensor::new(noise, 1, seed);
            let mut first = None;
            for i in 0..3 {
                s.measure(f64::from(i), |f| f.of(FIELD_PLACE).fill(10.0));
                let x = s.read(FIELD_PLACE)[component] - 10.0;
                assert_eq!(*first.get_or_insert(x), x);
            }
            first.unwrap_or_default()
        };
        (0..20_000).map(of).collect()
    };
    let x = shifts("place.shift = [1, 1, 0.5]", 0);
    let z = shifts("place.shift = [1, 1, 0.5]", 2);
    even(&x, 1.0).unwrap();
    even(&z, 0.5).unwrap();
    assert!(even(&z, 0.55).is_err());
    assert!(correlation(&x, &z).abs() < 4.0 / 20_000f64.sqrt());
    white(&shifts("place.shift_sigma = 2", 1), 2.0).unwrap();
}

#[test]
fn rounding_errors_are_uniform() {
    let mut s = TestSensor::new("many.step = 0.01", SAMPLES, 1);
    // These values are unrelated to the grid.
    let value = |i: usize| 1.0 + (i as f64 * 0.618_033_988_749).fract();
    s.measure(0.0, |f| f.of(FIELD_MANY).iter_mut().enumerate().for_each(|(i, x)| *x = value(i)));
    let read = s.read(FIELD_MANY);
    assert!(read.iter().all(|x| (x / 0.01 - (x / 0.01).round()).abs() < 1e-9));
    let errors: Vec<f64> = read.iter().enumerate().map(|(i, x)| x - value(i)).collect();
    kolmogorov_smirnov(&errors, |x| ((x / 0.005 + 1.0) / 2.0).clamp(0.0, 1.0)).unwrap();
}

/// Returns the errors of `n` measurements at 100 Hz, the rate that the tests assume for noise densities.
fn at_100_hz(noise: &str, n: usize) -> Vec<f64> {
    let mut s = TestSensor::new(noise, 1, 6);
    let measured = (0..n).map(|i| {
        s.measure(i as f64 * 0.01, |f| f.of(FIELD_ONE)[0] = 0.5);
        s.read(FIELD_ONE)[0] - 0.5
    });
    measured.collect()
}

/// Checks that the Allan deviation at `t` s is `level` t^slope, from averages of 10 to 10,000 samples.
fn follows(x: &[f64], level: f64, slope: f64) -> Result<(), String> {
    for m in [10usize, 100, 1000, 10_000] {
        let t = m as f64 * 0.01;
        let (is, wanted) = (allan(x, m), level * libm::pow(t, slope));
        // The tolerance is 4 standard deviations of about 1 / sqrt(2 k) for k differences, as above, plus 1 % for
        // averages of few samples.
        let close = 4.0 * 1.2 / (2.0 * (x.len() / m - 1) as f64).sqrt() + 0.01;
        if (is / wanted - 1.0).abs() > close {
            return Err(format!("Allan deviation {is} at {t} s, expected {wanted} within {close}"));
        }
    }
    Ok(())
}

/// IEEE Std 952-1997, annex C: white noise of density N has the Allan deviation N / sqrt(t), and a random walk of K per
/// square root of a second has K sqrt(t / 3).
#[test]
fn densities_and_random_walks_have_the_declared_allan_deviations() {
    const ALLAN_SAMPLES: usize = 2_000_000;
    let white = at_100_hz("one.density = 0.02", ALLAN_SAMPLES);
    follows(&white, 0.02, -0.5).unwrap();
    assert!(follows(&white, 0.021, -0.5).is_err(), "density times 1.05");
    let walk = at_100_hz("one.random_walk = 0.03", ALLAN_SAMPLES);
    follows(&walk, 0.03 / 3f64.sqrt(), 0.5).unwrap();
    assert!(follows(&walk, 0.034 / 3f64.sqrt(), 0.5).is_err(), "a walk times 1.13");
    assert!(follows(&white, 0.02, 0.5).is_err() && follows(&walk, 0.03 / 3f64.sqrt(), -0.5).is_err());
}

#[test]
fn random_walk_starts_at_zero_and_grows_with_the_root_of_time() {
    let ends: Vec<f64> = (0..2000)
        .map(|seed| {
            let mut s = TestSensor::new("one.random_walk = 0.5", 1, seed);
            s.measure(0.0, |f| f.of(FIELD_ONE)[0] = 1.0);
            assert_eq!(s.read(FIELD_ONE)[0], 1.0, "no time has passed");
            s.measure(9.0, |f| f.of(FIELD_ONE)[0] = 1.0);
            s.read(FIELD_ONE)[0] - 1.0
        })
        .collect();
    white(&ends, 1.5).unwrap();
    assert!(white(&ends, 1.7).is_err());
}

#[test]
fn values_are_clamped_after_noise_and_before_rounding() {
    let values = errors("many = { sigma = 1.0, clamp = [-1.0, 2.0] }", 0.0, 3);
    let share = |at: f64| values.iter().filter(|x| **x == at).count() as f64 / SAMPLES as f64;
    // The share of a normal distribution beyond one standard deviation is 0.1587, and beyond two 0.0228.
    assert!((share(-1.0) - 0.1587).abs() < 0.004 && (share(2.0) - 0.0228).abs() < 0.002);
    assert!(values.iter().all(|x| (-1.0..=2.0).contains(x)));
    // Values are rounded to steps after they are clamped; here, -1 and 1 are rounded to the first step on each side.
    let rough = errors("many = { sigma = 1.0, clamp = [-1.0, 1.0], step = 0.7 }", 0.0, 3);
    let mut steps: Vec<i64> = rough.iter().map(|x| (x / 0.7).round() as i64).collect();
    steps.sort_unstable();
    steps.dedup();
    assert_eq!(steps, [-1, 0, 1]);
}
