//! Random numbers for sensors without a host.

use tatu_plugin_api::abi::tatu_random;

/// Where a sensor's random numbers come from. As in a host, a number depends on its index, not on what was drawn before.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Random {
    /// None: normal numbers are 0, uniform ones 0.5. What is measured is then exact.
    #[default]
    Still,
    /// Numbers that follow from this seed, the same in each run; not those that a host would give.
    Seed(u64),
    /// These, by index, from the beginning again after the last; for uniform numbers they lie in [0, 1).
    Fixed(Vec<f64>),
}

impl Random {
    /// A uniform number in [0, 1).
    fn uniform(&self, index: u64) -> f64 {
        match self {
            Random::Still => 0.5,
            Random::Seed(seed) => (mixed(seed.wrapping_add(mixed(index))) >> 11) as f64 / (1u64 << 53) as f64,
            Random::Fixed(_) => self.fixed(index),
        }
    }

    /// A normally distributed number: mean 0, standard deviation 1.
    fn normal(&self, index: u64) -> f64 {
        match self {
            Random::Still => 0.0,
            // Box and Muller, from two numbers of the same index.
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

/// SplitMix64.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// The table of a batch whose instances draw from these; it is not to be used for longer than they live.
pub fn table(sources: &[Random]) -> tatu_random {
    tatu_random {
        size: size_of::<tatu_random>() as u32,
        reserved: 0,
        ctx: sources.as_ptr().cast_mut().cast(),
        uniform: Some(uniform),
        normal: Some(normal),
    }
}

unsafe extern "C" fn uniform(random: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: what `fill` asks for is what the caller promises.
    unsafe { fill(random, i, first, n, out, Random::uniform) }
}

unsafe extern "C" fn normal(random: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: what `fill` asks for is what the caller promises.
    unsafe { fill(random, i, first, n, out, Random::normal) }
}

/// # Safety
/// `random` is a table of [`table`] whose sources live and have an instance `i`; `out` has room for `n`.
unsafe fn fill(random: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64, get: fn(&Random, u64) -> f64) {
    // SAFETY: the caller promises it.
    unsafe {
        let source = &*(*random).ctx.cast::<Random>().add(i as usize);
        for k in 0..n {
            out.add(k as usize).write(get(source, first + k));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_give_numbers_of_the_right_distribution() {
        let numbers: Vec<f64> = (0..20_000).map(|i| Random::Seed(7).normal(i)).collect();
        let n = numbers.len() as f64;
        let mean = numbers.iter().sum::<f64>() / n;
        let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        // Four standard errors of each.
        assert!(mean.abs() < 4.0 / n.sqrt() && (variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{mean} {variance}");
        assert!((0..1000).all(|i| (0.0..1.0).contains(&Random::Seed(1).uniform(i))));
    }
}
