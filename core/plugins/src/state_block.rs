//! State blocks of instances: memory of the host that a plugin writes to. A word behind each tells whether it wrote too far.

use std::{
    ffi::c_void,
    ops::{Deref, DerefMut},
};

/// What stands behind memory that a plugin may write to. Unlikely as a number, a pointer or a text.
pub const GUARD: u64 = 0x5EED_A11A_D0E5_7A7C;

/// The state block of an instance, zero at first; its address stays. As a slice: its words, without what stands behind them.
#[derive(Debug)]
pub struct StateBlock(Vec<u64>);

impl StateBlock {
    /// One of so many bytes.
    pub fn new(bytes: u32) -> Self {
        let mut words = vec![0; (bytes as usize).div_ceil(8) + 1];
        if let Some(guard) = words.last_mut() {
            *guard = GUARD;
        }
        StateBlock(words)
    }

    /// As plugins get it: null if it has no bytes.
    #[inline]
    pub fn place(&self) -> *mut c_void {
        if self.0.len() == 1 { std::ptr::null_mut() } else { self.0.as_ptr().cast_mut().cast() }
    }

    /// Whether nobody has written past its end.
    #[inline]
    pub fn is_whole(&self) -> bool {
        self.0.last() == Some(&GUARD)
    }

    /// It is whole again: what was written past its end has been told.
    pub fn mend(&mut self) {
        if let Some(guard) = self.0.last_mut() {
            *guard = GUARD;
        }
    }
}

impl Deref for StateBlock {
    type Target = [u64];
    #[inline]
    fn deref(&self) -> &[u64] {
        &self.0[..self.0.len() - 1]
    }
}

impl DerefMut for StateBlock {
    fn deref_mut(&mut self) -> &mut [u64] {
        let n = self.0.len() - 1;
        &mut self.0[..n]
    }
}

/// What is said of an instance whose plugin wrote past its state block.
pub const PAST_STATE: &str = "broke the contract: it wrote past the end of its state block (`tatu_life.state_bytes`)";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_too_far_is_noticed_until_it_is_mended() {
        let mut block = StateBlock::new(12);
        assert_eq!((block.len(), block.is_whole()), (2, true));
        let place = block.place().cast::<u64>();
        // SAFETY: the third word is the guard's.
        unsafe { place.add(2).write(1) };
        assert!(!block.is_whole());
        block.mend();
        assert!(block.is_whole());
    }
}
