//! Which registers the processor has, asked once; the same code is compiled for each of them.
//!
//! Every level gives the same bits: all operations are rounded alike (nothing is fused), lanes do not mix, and smaller
//! and larger of two numbers are chosen by comparisons, which settle zeros and what is no number.

use std::sync::OnceLock;

use fearless_simd::{Fallback, Level};

/// The level to use: the best there is, or the fallback where the environment says `TATU_SIMD=off`.
pub(crate) fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| match std::env::var("TATU_SIMD") {
        Ok(word) if word == "off" => fallback(),
        _ => Level::new(),
    })
}

/// One number at a time, on any processor.
pub(crate) fn fallback() -> Level {
    Level::Fallback(Fallback::new())
}

/// Runs `work` with the token of a level, in code compiled for it: 512 or 256 bits on x86, Neon, else the fallback.
///
/// The crate's own macro would compile the code for the smaller registers of x86 too, which are no faster than the
/// fallback once the compiler has put that side by side.
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
            }
            #[cfg(target_arch = "aarch64")]
            if let Some($simd) = level.as_neon() {
                break 'done fearless_simd::Simd::vectorize(
                    $simd,
                    #[inline(always)]
                    || $work,
                );
            }
            let _ = level;
            let $simd = fearless_simd::Fallback::new();
            $work
        }
    }};
}
pub(crate) use dispatch;
