//! Eight numbers at once, in loops that the compiler turns into vector instructions.

use std::sync::OnceLock;

use fearless_simd::Level;
#[cfg(target_arch = "x86_64")]
use fearless_simd::Simd;

/// Number of states that are computed at once.
pub(super) const LANES: usize = 8;
/// A number of each state.
pub(super) type Lane = [f64; LANES];

/// Runs code that is compiled with vectors of 256 bits if the processor has them and the environment does not contain
/// `TATU_SIMD=off`, and for any processor otherwise. The results are the same: nothing is fused.
#[inline(always)]
pub(super) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    let level = *LEVEL.get_or_init(|| match std::env::var("TATU_SIMD") {
        Ok(word) if word == "off" => Level::baseline(),
        _ => Level::new(),
    });
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = level.as_avx2() {
        #[allow(clippy::redundant_closure, reason = "only a closure with this attribute is compiled for the level")]
        return simd.vectorize(
            #[inline(always)]
            || work(),
        );
    }
    let _ = level;
    work()
}

/// A number whose addition rounds to whole numbers: 1.5 times 2^52.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Returns sines and cosines, with errors below 1e-15 for angles up to some thousand rad.
#[inline(always)]
pub(super) fn sines_and_cosines(angles: &Lane) -> (Lane, Lane) {
    let (mut sines, mut cosines) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        // The angle is a number of quarter turns and a rest of at most π/4.
        let shifted = angles[l] * std::f64::consts::FRAC_2_PI + ROUNDER;
        let quarters = shifted - ROUNDER;
        // π/2 in two parts, of which the first has few bits, so that the product is exact.
        let x = (angles[l] - quarters * 1.5707963109016418) - quarters * 1.5893254773528196e-08;
        let s = x * x;
        let sine = x + x
            * s
            * (-1.0 / 6.0
                + s * (1.0 / 120.0
                    + s * (-1.0 / 5040.0
                        + s * (1.0 / 362_880.0
                            + s * (-1.0 / 39_916_800.0
                                + s * (1.0 / 6_227_020_800.0 + s * (-1.0 / 1_307_674_368_000.0)))))));
        let cosine = 1.0
            + s * (-0.5
                + s * (1.0 / 24.0
                    + s * (-1.0 / 720.0
                        + s * (1.0 / 40_320.0
                            + s * (-1.0 / 3_628_800.0
                                + s * (1.0 / 479_001_600.0
                                    + s * (-1.0 / 87_178_291_200.0 + s * (1.0 / 20_922_789_888_000.0))))))));
        let quarter = shifted.to_bits();
        let swaps = quarter & 1 == 1;
        let (a, b) = if swaps { (cosine, sine) } else { (sine, cosine) };
        sines[l] = if quarter & 2 == 2 { -a } else { a };
        cosines[l] = if (quarter + 1) & 2 == 2 { -b } else { b };
    }
    (sines, cosines)
}

/// One point of each state, m.
pub(super) type LanePoint = [Lane; 3];

/// A pose of each state: a rotation matrix by rows, and a translation.
#[derive(Debug, Clone, Copy)]
pub(super) struct LanePose {
    pub rotation: [Lane; 9],
    pub translation: LanePoint,
}

impl LanePose {
    pub const IDENTITY: LanePose = {
        let (one, zero) = ([1.0; LANES], [0.0; LANES]);
        LanePose { rotation: [one, zero, zero, zero, one, zero, zero, zero, one], translation: [zero, zero, zero] }
    };

    /// Returns points of the frame in the world.
    #[inline(always)]
    pub fn point(&self, p: &[f64; 3]) -> LanePoint {
        let mut out = self.translation;
        for (row, o) in out.iter_mut().enumerate() {
            let [a, b, c] = [&self.rotation[3 * row], &self.rotation[3 * row + 1], &self.rotation[3 * row + 2]];
            for l in 0..LANES {
                o[l] += (a[l] * p[0] + b[l] * p[1]) + c[l] * p[2];
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_agree_with_those_of_the_library() {
        for i in -4000..4000 {
            let angles = std::array::from_fn(|l| 0.0137 * (f64::from(i) + l as f64 / 8.0));
            let (sines, cosines) = sines_and_cosines(&angles);
            for l in 0..LANES {
                assert!((sines[l] - libm::sin(angles[l])).abs() < 2e-15, "sin {}", angles[l]);
                assert!((cosines[l] - libm::cos(angles[l])).abs() < 2e-15, "cos {}", angles[l]);
            }
        }
    }
}
