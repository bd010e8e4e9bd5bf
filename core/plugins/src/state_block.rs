//! State blocks of instances: host memory that a plugin writes to, with guards on both sides.

use std::{
    ffi::c_void,
    ops::{Deref, DerefMut},
};

/// The guard word around memory that plugins write to; it is unlikely to occur as a number, a pointer or a string.
pub const GUARD: u64 = 0x5EED_A11A_D0E5_7A7C;
/// Number of guard words on each side: enough to catch small overruns.
pub const GUARD_WORDS: usize = 8;

/// The state block of an instance, initially zero, at a stable address. As a slice, it contains the words between the
/// guards.
#[derive(Debug)]
pub struct StateBlock(Vec<u64>);

impl StateBlock {
    /// Creates a block of at least this size, in bytes.
    pub fn new(bytes: u32) -> Self {
        let n = (bytes as usize).div_ceil(8);
        let mut block = StateBlock(vec![0; n + 2 * GUARD_WORDS]);
        block.restore_guards();
        block
    }

    /// Returns the pointer to pass to plugins, which is null if the block is empty.
    #[inline]
    pub fn data_ptr(&self) -> *mut c_void {
        if self.0.len() == 2 * GUARD_WORDS {
            return std::ptr::null_mut();
        }
        self.0.as_ptr().wrapping_add(GUARD_WORDS).cast_mut().cast()
    }

    /// Returns whether the nearest guard word on each side is intact, which is checked after each call.
    #[inline]
    pub fn guards_intact(&self) -> bool {
        self.0[GUARD_WORDS - 1] == GUARD && self.0[self.0.len() - GUARD_WORDS] == GUARD
    }

    /// Restores the guards after an overrun has been reported.
    pub fn restore_guards(&mut self) {
        let end = self.0.len() - GUARD_WORDS;
        self.0[..GUARD_WORDS].fill(GUARD);
        self.0[end..].fill(GUARD);
    }
}

impl Deref for StateBlock {
    type Target = [u64];
    #[inline]
    fn deref(&self) -> &[u64] {
        &self.0[GUARD_WORDS..self.0.len() - GUARD_WORDS]
    }
}

impl DerefMut for StateBlock {
    fn deref_mut(&mut self) -> &mut [u64] {
        let end = self.0.len() - GUARD_WORDS;
        &mut self.0[GUARD_WORDS..end]
    }
}

/// The error message for a plugin that wrote outside a state block.
pub const PAST_STATE: &str =
    "broke the contract: it wrote past the end of its state block (`tatu_life.state_bytes`), or before its beginning";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overrun_is_detected_until_guards_are_restored() {
        let mut block = StateBlock::new(12);
        assert_eq!((block.len(), block.guards_intact()), (2, true));
        for beside in [-1, 2] {
            // SAFETY: the words before and after the block belong to its guards, which live as long as `block`.
            unsafe { block.data_ptr().cast::<u64>().offset(beside).write(1) };
            assert!(!block.guards_intact());
            block.restore_guards();
            assert!(block.guards_intact() && block.iter().all(|w| *w == 0));
        }
        assert!(StateBlock::new(0).data_ptr().is_null());
    }
}
