//! Random numbers of sensors: a function of seed, count and index, not of what was drawn before.

use std::f64::consts::TAU;

use tatu_plugin_api::abi::tatu_random;

/// The key of one measure of one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key(u64);

impl Key {
    /// `seed`: of the sensor; `drawn`: how often it has measured; `stream`: who draws, 0 the plugin.
    pub fn new(seed: u64, drawn: u64, stream: u64) -> Self {
        Key(mixed(mixed(mixed(seed).wrapping_add(drawn)).wrapping_add(stream)))
    }

    /// Number `index`, from 0 to below 1.
    pub fn uniform(self, index: u64) -> f64 {
        (self.bits(index) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Number `index` of the normal distribution: mean 0, standard deviation 1.
    ///
    /// Box and Muller (1958): each index has two uniform numbers of its own, so that no index depends on another.
    pub fn normal(self, index: u64) -> f64 {
        let radius = (1.0 - self.uniform(2 * index)).ln() * -2.0;
        radius.sqrt() * (TAU * self.uniform(2 * index + 1)).cos()
    }

    fn bits(self, index: u64) -> u64 {
        mixed(self.0.wrapping_add(index.wrapping_mul(GOLDEN)))
    }
}

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// SplitMix64's step: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(GOLDEN);
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
    unsafe { fill(table, i, first, n, out, Key::uniform) }
}

unsafe extern "C" fn normal(table: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: as in `fill`.
    unsafe { fill(table, i, first, n, out, Key::normal) }
}

/// # Safety
/// `table` is one of ours, `out` has `n` places: by the contract.
unsafe fn fill(table: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64, number: fn(Key, u64) -> f64) {
    // SAFETY: as promised; an instance that is not there draws nothing.
    unsafe {
        if i < (*table).reserved {
            let key = *(*table).ctx.cast::<Key>().add(i as usize);
            (0..n).for_each(|k| *out.add(k as usize) = number(key, first.wrapping_add(k)));
        }
    }
}
