//! Which registers the processor has, asked once; the same code is compiled for each of them.
//!
//! Every level gives the same bits: all operations are rounded alike (nothing is fused), lanes do not mix, and smaller
//! and larger of two numbers are chosen by comparisons, which settle zeros and what is no number.

use std::sync::OnceLock;

use fearless_simd::{Level, prelude::*};

/// The level to use: the best there is, or the least where the environment says `TATU_SIMD=off`.
pub(crate) fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| match std::env::var("TATU_SIMD") {
        Ok(word) if word == "off" => Level::baseline(),
        _ => Level::new(),
    })
}

/// Runs `work` with the token of a level, in code compiled for it: on x86 with 512, 256 or 128 bits, elsewhere with what
/// every processor of its kind has.
///
/// The crate's own macro would compile the code twice for 128 bits. Closures in `work` that use the token need
/// `#[inline(always)]`, as functions do: else they are compiled for no level.
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

/// The smaller of each two; the second where one is no number.
#[inline(always)]
pub(super) fn least<S: Simd, T: SimdFloat<S>>(a: T, b: T) -> T {
    a.simd_lt(b).select(a, b)
}

/// The greater of each two, likewise.
#[inline(always)]
pub(super) fn greatest<S: Simd, T: SimdFloat<S>>(a: T, b: T) -> T {
    a.simd_gt(b).select(a, b)
}
