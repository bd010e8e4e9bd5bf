//! Memory that is asked for before it is needed.
//!
//! A pass over thousands of robots finds little of what it needs in the processor's caches. Where the next address is
//! known early, the line can be on its way while something else is done.

/// Asks for the line of the processor's cache at an address, whatever is there. Nothing waits for it, and nothing is read.
#[inline(always)]
pub fn fetch<T>(at: *const T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a hint that is valid for any address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(at.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = at;
}

/// The same for all lines of something.
#[inline(always)]
pub fn fetch_all<T>(what: &T) {
    for line in (0..size_of::<T>()).step_by(64) {
        fetch((&raw const *what).cast::<u8>().wrapping_add(line));
    }
}
