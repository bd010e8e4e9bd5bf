//! Random numbers for sensors without a host.

use std::mem::MaybeUninit;

use tatu_plugin_api::abi::tatu_random;

/// The source of a sensor's random numbers. As in the host, a number depends only on its index, not on earlier
/// requests.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Random {
    /// No randomness: normally distributed numbers are 0, and uniform ones 0.5, so that readings are exact.
    #[default]
    Still,
    /// Numbers that depend on this seed. They are the same in every run, but differ from those of the host.
    Seed(u64),
    /// The number with index `i` is element `i` of this list, which repeats; for uniform numbers, all elements must be
    /// in [0, 1).
    Fixed(Vec<f64>),
}

impl Random {
    /// Returns a uniform number in [0, 1).
    fn uniform(&self, index: u64) -> f64 {
        match self {
            Random::Still => 0.5,
            Random::Seed(seed) => (mixed(seed.wrapping_add(mixed(index))) >> 11) as f64 / (1u64 << 53) as f64,
            Random::Fixed(_) => self.fixed(index),
        }
    }

    /// Returns a normally distributed number with mean 0 and standard deviation 1.
    fn normal(&self, index: u64) -> f64 {
        match self {
            Random::Still => 0.0,
            // Box-Muller transform of two uniform numbers with the same index.
            Random::Seed(seed) => {
                let radius = (1.0 - self.uniform(index)).ln() * -2.0;
                let turn = Random::Seed(mixed(*seed)).uniform(index) * std::f64::consts::TAU;
                radius.sqrt() * turn.cos()
            }
            Random::Fixed(_) => self.fixed(index),
        }
    }

    fn fixed(&self, index: u64) -> f64 {
        match self {
            Random::Fixed(all) if !all.is_empty() => all[(index % all.len() as u64) as usize],
            _ => 0.0,
        }
    }
}

/// Returns the output of the SplitMix64 generator for the state `x`.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// Returns the table for a batch whose instances have these sources. It must not be used after `sources` is dropped.
pub fn table(sources: &[Random]) -> tatu_random {
    tatu_random {
        size: size_of::<tatu_random>() as u32,
        reserved: 0,
        ctx: sources.as_ptr().cast_mut().cast(),
        uniform: Some(draw::<false>),
        normal: Some(draw::<true>),
    }
}

unsafe extern "C" fn draw<const NORMAL: bool>(random: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: the caller passes the table that [`table`] created, from sources that are alive and include index `i`, and
    // room for `n` numbers, which need not be initialised.
    let (source, out) = unsafe {
        let out = std::slice::from_raw_parts_mut(out.cast::<MaybeUninit<f64>>(), n as usize);
        (&*(*random).ctx.cast::<Random>().add(i as usize), out)
    };
    for (index, place) in (first..).zip(out) {
        place.write(if NORMAL { source.normal(index) } else { source.uniform(index) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeded_numbers_have_the_right_distribution() {
        let numbers: Vec<f64> = (0..20_000).map(|i| Random::Seed(7).normal(i)).collect();
        let n = numbers.len() as f64;
        let mean = numbers.iter().sum::<f64>() / n;
        let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        // The tolerances are four standard errors.
        assert!(mean.abs() < 4.0 / n.sqrt() && (variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{mean} {variance}");
        assert!((0..1000).all(|i| (0.0..1.0).contains(&Random::Seed(1).uniform(i))));
    }
}
