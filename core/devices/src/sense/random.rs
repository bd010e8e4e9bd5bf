//! Counter-based random numbers of sensors. Each is a function of the seed, the measurement count, a stream and an
//! index, and does not depend on earlier draws.

use tatu_plugins::RandomNumbers;

use super::normal;

/// The key of one measurement of one sensor, for one stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RandomKey {
    at: u64,
    /// An odd increment, different for each key, so that no key's sequence is a shifted copy of another's.
    step: u64,
}

impl RandomKey {
    /// Creates a key from the sensor's seed, the number of its previous measurements, and the stream, which is 0 for
    /// the plugin's own numbers.
    pub fn new(seed: u64, drawn: u64, stream: u64) -> Self {
        let at = mixed(mixed(mixed(seed).wrapping_add(drawn)).wrapping_add(stream));
        let step = mixed(at) | 1;
        // An increment with too few bit transitions would make neighbouring numbers similar.
        let regular = (step ^ (step >> 1)).count_ones() < 24;
        RandomKey { at, step: if regular { step ^ 0xAAAA_AAAA_AAAA_AAAA } else { step } }
    }

    /// Returns the random number with this index, uniformly distributed in [0, 1).
    pub fn uniform(self, index: u64) -> f64 {
        (self.bits(index) >> 11) as f64 * UNIT
    }

    /// Returns the random number with this index, from the standard normal distribution.
    ///
    /// It is computed from a single uniform number by the inverse of the distribution function, so the numbers of
    /// different indices are independent, and each has the same bits on every processor.
    pub fn normal(self, index: u64) -> f64 {
        normal::quantile(self.between(index))
    }

    /// Fills `out` with normal numbers, starting at index `first`. This is faster than generating them one by one.
    pub fn normals(self, first: u64, out: &mut [f64]) {
        (first..).zip(out.iter_mut()).for_each(|(i, x)| *x = self.between(i));
        normal::quantiles(out);
    }

    /// Returns the random number with this index, uniformly distributed in the open interval (0, 1).
    fn between(self, index: u64) -> f64 {
        // The largest 53-bit number would otherwise be rounded to 1, which has no quantile.
        (((self.bits(index) >> 11) as f64 + 0.5) * UNIT).min(1.0 - UNIT)
    }

    fn bits(self, index: u64) -> u64 {
        finished(self.at.wrapping_add(index.wrapping_mul(self.step)))
    }
}

const UNIT: f64 = 1.0 / (1u64 << 53) as f64;

/// SplitMix64: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014. Keys are split as described
/// there, each with a different increment.
fn mixed(x: u64) -> u64 {
    finished(x.wrapping_add(0x9E37_79B9_7F4A_7C15))
}

fn finished(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

impl RandomNumbers for RandomKey {
    fn uniforms(self, first: u64, out: &mut [f64]) {
        (0..).zip(out).for_each(|(k, x)| *x = self.uniform(first.wrapping_add(k)));
    }
    fn normals(self, first: u64, out: &mut [f64]) {
        RandomKey::normals(self, first, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sense::noise::judge::*;

    /// Returns numbers along one of the four dimensions in which keys and indices can differ, with the others fixed.
    fn along(way: usize) -> impl Fn(u64) -> (RandomKey, u64) {
        move |i| match way {
            0 => (RandomKey::new(7, 3, 1), i),
            1 => (RandomKey::new(7, i, 1), 5),
            2 => (RandomKey::new(7, 3, i), 5),
            _ => (RandomKey::new(i, 3, 1), 5),
        }
    }

    #[test]
    fn uniform_numbers_are_independent_along_each_dimension() {
        for way in 0..4 {
            let at = along(way);
            let all: Vec<f64> = (0..100_000).map(|i| at(i).0.uniform(at(i).1)).collect();
            kolmogorov_smirnov(&all, |x| x).unwrap();
            independent(&all).unwrap();
            // Each bit is 1 in half of the numbers. The standard deviation of a count of n coins is sqrt(n) / 2; the
            // tolerance is 5 of these, since 64 bits are tested at once.
            for bit in 0..64 {
                let ones = (0..100_000).filter(|i| at(*i).0.bits(at(*i).1) >> bit & 1 == 1).count() as f64;
                assert!((ones - 50_000.0).abs() < 5.0 * 100_000f64.sqrt() / 2.0, "way {way}, bit {bit}: {ones}");
            }
        }
    }

    #[test]
    fn normal_numbers_are_independent_along_each_dimension() {
        for way in 0..4 {
            let at = along(way);
            let all: Vec<f64> = (0..100_000).map(|i| at(i).0.normal(at(i).1)).collect();
            white(&all, 1.0).unwrap_or_else(|e| panic!("way {way}: {e}"));
        }
    }

    /// Keys that differ in one bit or by one, as neighbours in a run do, are uncorrelated.
    #[test]
    fn neighbouring_keys_are_uncorrelated() {
        let n = 50_000;
        let numbers = |k: RandomKey| (0..n).map(|i| k.normal(i)).collect::<Vec<f64>>();
        let first = numbers(RandomKey::new(1 << 40, 1000, 99));
        let others = (0..64).map(|b| RandomKey::new(1 << 40 ^ 1 << b, 1000, 99));
        let others =
            others.chain([(1000, 100), (1001, 99), (999, 99), (1000, 98)].map(|(d, s)| RandomKey::new(1 << 40, d, s)));
        for (i, key) in others.enumerate() {
            let other = numbers(key);
            for lag in 0..3 {
                let r = correlation(&first[lag..], &other[..other.len() - lag]);
                // The standard deviation of a correlation of independent numbers is 1 / sqrt(n); the tolerance is 5 of
                // these for about 200 tests.
                assert!(r.abs() < 5.0 / (n as f64).sqrt(), "{i}, lag {lag}: {r}");
            }
        }
    }

    #[test]
    fn numbers_in_bulk_equal_single_numbers() {
        let key = RandomKey::new(1, 2, 3);
        let mut many = [0.0; 1000];
        key.normals(17, &mut many);
        many.iter().zip(17..).for_each(|(x, i)| assert_eq!(x.to_bits(), key.normal(i).to_bits()));
        let (keys, mut out) = ([RandomKey::new(9, 9, 9), key], [0.0; 10]);
        let table = tatu_plugins::RandomTable::new(&keys);
        let table = table.raw();
        // SAFETY: the table and its keys are alive, and `out` has room for 10 numbers.
        unsafe { table.normal.unwrap()(table, 1, 20, 10, out.as_mut_ptr()) };
        assert_eq!(out, many[3..13]);
        // SAFETY: the table and its keys are alive, and `out` has room for 10 numbers.
        unsafe { table.uniform.unwrap()(table, 1, 20, 10, out.as_mut_ptr()) };
        assert_eq!(out[0], key.uniform(20));
        // For an instance that does not exist, nothing is written.
        // SAFETY: the table and its keys are alive, and `out` has room for 10 numbers.
        unsafe { table.normal.unwrap()(table, 2, 20, 10, out.as_mut_ptr()) };
        assert_eq!(out[0], key.uniform(20));
    }
}
