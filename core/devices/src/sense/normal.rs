//! The inverse of the standard normal distribution function.
//!
//! This is the variant PPND16 of Wichura, "Algorithm AS 241: The percentage points of the normal distribution", Applied
//! Statistics 37 (1988), 477-484: rational functions, accurate to about 1 in 10^16. Apart from the four basic
//! operations and the square root, which give the same results on every processor, it needs a logarithm for the tails
//! (15 % of the numbers). The logarithm of the `libm` crate gives the same results on every processor as well.

#![allow(clippy::excessive_precision, reason = "the coefficients are copied digit by digit from the paper")]

/// Returns the `p`-quantile of the standard normal distribution. `p` must be greater than 0 and less than 1.
pub(super) fn quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= CENTRAL_RANGE { middle(q) } else { tail(p, q) }
}

/// Replaces each number by its `quantile`.
pub(super) fn quantiles(all: &mut [f64]) {
    let mut tails = [0u32; BLOCK_LEN + 1];
    for block in all.chunks_mut(BLOCK_LEN) {
        // This loop has no branches, so that the compiler can vectorise it.
        let mut n = 0;
        let mut kept = [0.0; BLOCK_LEN];
        for (i, p) in block.iter_mut().enumerate() {
            let q = *p - 0.5;
            kept[i] = *p;
            tails[n] = i as u32;
            n += usize::from(q.abs() > CENTRAL_RANGE);
        }
        for p in block.iter_mut() {
            *p = middle(*p - 0.5);
        }
        for i in &tails[..n] {
            let p = kept[*i as usize];
            block[*i as usize] = tail(p, p - 0.5);
        }
    }
}

const BLOCK_LEN: usize = 128;
const CENTRAL_RANGE: f64 = 0.425;

/// Returns the quantile of `p = 0.5 + q` for `|q|` of at most 0.425.
#[inline(always)]
fn middle(q: f64) -> f64 {
    let r = 0.180_625 - q * q;
    q * polynomial(&A, r) / polynomial(&B, r)
}

#[inline(never)]
fn tail(p: f64, q: f64) -> f64 {
    let r = (-libm::log(p.min(1.0 - p))).sqrt();
    let z = if r <= 5.0 {
        polynomial(&C, r - 1.6) / polynomial(&D, r - 1.6)
    } else {
        polynomial(&E, r - 5.0) / polynomial(&F, r - 5.0)
    };
    if q < 0.0 { -z } else { z }
}

#[inline(always)]
fn polynomial(c: &[f64; 8], x: f64) -> f64 {
    ((((((c[7] * x + c[6]) * x + c[5]) * x + c[4]) * x + c[3]) * x + c[2]) * x + c[1]) * x + c[0]
}

const A: [f64; 8] = [
    3.387_132_872_796_366_608_0e0,
    1.331_416_678_917_843_774_5e2,
    1.971_590_950_306_551_442_7e3,
    1.373_169_376_550_946_112_5e4,
    4.592_195_393_154_987_145_7e4,
    6.726_577_092_700_870_085_3e4,
    3.343_057_558_358_812_810_5e4,
    2.509_080_928_730_122_672_7e3,
];
const B: [f64; 8] = [
    1.0,
    4.231_333_070_160_091_125_2e1,
    6.871_870_074_920_579_083_0e2,
    5.394_196_021_424_751_107_7e3,
    2.121_379_430_158_659_586_7e4,
    3.930_789_580_009_271_061_0e4,
    2.872_908_573_572_194_267_4e4,
    5.226_495_278_852_854_561_0e3,
];
const C: [f64; 8] = [
    1.423_437_110_749_683_577_34e0,
    4.630_337_846_156_545_295_90e0,
    5.769_497_221_460_691_405_50e0,
    3.647_848_324_763_204_605_04e0,
    1.270_458_252_452_368_382_58e0,
    2.417_807_251_774_506_117_70e-1,
    2.272_384_498_926_918_458_33e-2,
    7.745_450_142_783_414_076_40e-4,
];
const D: [f64; 8] = [
    1.0,
    2.053_191_626_637_758_821_87e0,
    1.676_384_830_183_803_849_40e0,
    6.897_673_349_851_000_045_50e-1,
    1.481_039_764_274_800_745_90e-1,
    1.519_866_656_361_645_719_66e-2,
    5.475_938_084_995_344_946_00e-4,
    1.050_750_071_644_416_843_24e-9,
];
const E: [f64; 8] = [
    6.657_904_643_501_103_777_20e0,
    5.463_784_911_164_114_369_90e0,
    1.784_826_539_917_291_335_80e0,
    2.965_605_718_285_048_912_30e-1,
    2.653_218_952_657_612_309_30e-2,
    1.242_660_947_388_078_438_60e-3,
    2.711_555_568_743_487_578_15e-5,
    2.010_334_399_292_288_132_65e-7,
];
const F: [f64; 8] = [
    1.0,
    5.998_322_065_558_879_376_90e-1,
    1.369_298_809_227_358_053_10e-1,
    1.487_536_129_085_061_485_25e-2,
    7.868_691_311_456_132_591_00e-4,
    1.846_318_317_510_054_681_80e-5,
    1.421_511_758_316_445_888_70e-7,
    2.044_263_103_389_939_785_64e-15,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the standard normal distribution function at `z`: Phi(z) = erfc(-z / sqrt 2) / 2.
    fn phi(z: f64) -> f64 {
        libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2) / 2.0
    }

    #[test]
    fn quantile_is_the_inverse_of_the_distribution_function() {
        for k in 1..100_000 {
            for p in [f64::from(k) / 1e5, 1.7f64.powi(-(k % 60) - 1)] {
                let back = phi(quantile(p));
                // `erfc` itself is accurate to 1 in 10^15; beyond z = 8, the rounding error of its argument is
                // multiplied by z^2.
                assert!((back - p).abs() < 1e-13 * p.min(1.0 - p) + 2e-16, "{p}: {back}");
            }
        }
        // Abramowitz and Stegun, table 26.5.
        assert!((quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-14);
        assert_eq!(quantile(0.5), 0.0);
    }

    #[test]
    fn quantiles_equal_single_quantiles() {
        let p: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.618_033_988_75 + 1e-3).fract()).collect();
        let mut many = p.clone();
        quantiles(&mut many);
        p.iter().zip(&many).for_each(|(p, z)| assert_eq!(quantile(*p).to_bits(), z.to_bits()));
        // All numbers of the blocks are in a tail.
        let mut tails = [1e-9; BLOCK_LEN + 3];
        quantiles(&mut tails);
        assert!(tails.iter().all(|z| *z == quantile(1e-9)));
    }
}
