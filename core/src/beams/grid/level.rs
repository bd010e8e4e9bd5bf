//! Which instructions of the processor are used.
//!
//! Every level runs the same source: loops over 16 numbers that the compiler turns into the widest instructions it may
//! use. No operation is fused and none is reordered, so all give the same bits.

use std::sync::OnceLock;

/// A set of instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    /// What every processor of this kind has.
    Plain,
    /// AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 with its byte, double word and shorter forms.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// The widest there is; `TATU_SIMD=off` in the environment forbids all but the plain one.
    pub fn widest() -> Self {
        static LEVEL: OnceLock<Level> = OnceLock::new();
        *LEVEL.get_or_init(|| {
            let off = std::env::var_os("TATU_SIMD").is_some_and(|value| value == "off");
            if off { Self::Plain } else { Self::all().pop().unwrap_or(Self::Plain) }
        })
    }

    /// All that this processor has, the widest last.
    pub fn all() -> Vec<Self> {
        #[allow(unused_mut, reason = "only one processor has more")]
        let mut all = vec![Self::Plain];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                all.push(Self::Avx2);
            }
            let wide = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512bw");
            if wide && is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl") {
                all.push(Self::Avx512);
            }
        }
        all
    }
}
