//! Random numbers of sensors: a function of seed, count and index, not of what was drawn before.

use tatu_plugin_api::abi::tatu_random;

use super::normal;

/// The key of one measure of one sensor, for one who draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key {
    at: u64,
    /// Odd, and different for each key: two keys walk in different steps, so that one's numbers are never the other's,
    /// moved along.
    step: u64,
}

impl Key {
    /// `seed`: of the sensor; `drawn`: how often it has measured; `stream`: who draws, 0 the plugin.
    pub fn new(seed: u64, drawn: u64, stream: u64) -> Self {
        let at = mixed(mixed(mixed(seed).wrapping_add(drawn)).wrapping_add(stream));
        let step = mixed(at) | 1;
        // Too regular a step would leave neighbours alike.
        let regular = (step ^ (step >> 1)).count_ones() < 24;
        Key { at, step: if regular { step ^ 0xAAAA_AAAA_AAAA_AAAA } else { step } }
    }

    /// Number `index`, from 0 to below 1.
    pub fn uniform(self, index: u64) -> f64 {
        (self.bits(index) >> 11) as f64 * UNIT
    }

    /// Number `index` of the normal distribution: mean 0, standard deviation 1.
    ///
    /// The inverse of the distribution function at a number between 0 and 1: each index has its own, and the same bits on
    /// every processor.
    pub fn normal(self, index: u64) -> f64 {
        normal::quantile(self.between(index))
    }

    /// Numbers of the normal distribution from `first` on; faster than one by one.
    pub fn normals(self, first: u64, out: &mut [f64]) {
        (first..).zip(out.iter_mut()).for_each(|(i, x)| *x = self.between(i));
        normal::quantiles(out);
    }

    /// Between 0 and 1, neither of which is met.
    fn between(self, index: u64) -> f64 {
        ((self.bits(index) >> 11) as f64 + 0.5) * UNIT
    }

    fn bits(self, index: u64) -> u64 {
        finished(self.at.wrapping_add(index.wrapping_mul(self.step)))
    }
}

const UNIT: f64 = 1.0 / (1u64 << 53) as f64;

/// SplitMix64: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014. Keys are split as there: each has
/// a step of its own.
fn mixed(x: u64) -> u64 {
    finished(x.wrapping_add(0x9E37_79B9_7F4A_7C15))
}

fn finished(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// The table for a batch whose instances have these keys; valid as long as they are.
pub(super) fn table(keys: &[Key]) -> tatu_random {
    tatu_random {
        size: size_of::<tatu_random>() as u32,
        reserved: keys.len() as u32,
        ctx: keys.as_ptr().cast_mut().cast(),
        uniform: Some(uniform),
        normal: Some(normal),
    }
}

unsafe extern "C" fn uniform(table: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: as in `fill`.
    unsafe {
        fill(table, i, n, out, |key, out| {
            (0..n).zip(out).for_each(|(k, x)| *x = key.uniform(first.wrapping_add(k)));
        });
    }
}

unsafe extern "C" fn normal(table: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: as in `fill`.
    unsafe { fill(table, i, n, out, |key, out| key.normals(first, out)) }
}

/// # Safety
/// `table` is one of ours, `out` has `n` places: by the contract.
unsafe fn fill(table: *const tatu_random, i: u32, n: u64, out: *mut f64, numbers: impl Fn(Key, &mut [f64])) {
    // SAFETY: as promised; an instance that is not there draws nothing. The places may never have been written to.
    unsafe {
        if i < (*table).reserved && n > 0 && !out.is_null() {
            let key = *(*table).ctx.cast::<Key>().add(i as usize);
            out.write_bytes(0, n as usize);
            numbers(key, std::slice::from_raw_parts_mut(out, n as usize));
        }
    }
}
