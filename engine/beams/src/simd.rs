//! Selection of the SIMD level of the processor, once per process. The same code is compiled for each level.
//!
//! All levels produce bit-identical results: operations are rounded individually (no fused multiply-add), lanes are
//! independent, and minima and maxima are computed by comparisons, which define the results for signed zeros and NaN.

use std::sync::OnceLock;

use fearless_simd::{Level, prelude::*};

/// Returns the level to use: the best available, or the lowest if the environment contains `TATU_SIMD=off`.
pub(crate) fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| match std::env::var("TATU_SIMD") {
        Ok(word) if word == "off" => Level::baseline(),
        _ => Level::new(),
    })
}

/// Runs `work` with the token of a level, in code that is compiled for this level: on x86 with registers of 512, 256 or
/// 128 bits, elsewhere for the baseline of the architecture.
///
/// The macro `dispatch` of `fearless_simd` would compile the code twice for 128 bits. Closures in `work` that use the
/// token need `#[inline(always)]`, as do functions; otherwise they are not compiled for the level.
macro_rules! dispatch {
    ($level:expr, $simd:ident => $work:expr) => {{
        let level: fearless_simd::Level = $level;
        'done: {
            #[cfg(target_arch = "x86_64")]
            {
                if let Some($simd) = level.as_avx512() {
                    break 'done fearless_simd::Simd::vectorize(
                        $simd,
                        #[inline(always)]
                        || $work,
                    );
                }
                if let Some($simd) = level.as_avx2() {
                    break 'done fearless_simd::Simd::vectorize(
                        $simd,
                        #[inline(always)]
                        || $work,
                    );
                }
                let Some($simd) = level.as_sse2() else { unreachable!("every x86-64 has SSE2") };
                break 'done fearless_simd::Simd::vectorize(
                    $simd,
                    #[inline(always)]
                    || $work,
                );
            }
            #[cfg(not(target_arch = "x86_64"))]
            fearless_simd::dispatch!(level, $simd => $work)
        }
    }};
}
pub(crate) use dispatch;

/// Returns the smaller value of each pair; the second one if either is NaN.
#[inline(always)]
pub(super) fn least<S: Simd, T: SimdFloat<S>>(a: T, b: T) -> T {
    a.simd_lt(b).select(a, b)
}

/// Returns the greater value of each pair; the second one if either is NaN.
#[inline(always)]
pub(super) fn greatest<S: Simd, T: SimdFloat<S>>(a: T, b: T) -> T {
    a.simd_gt(b).select(a, b)
}
