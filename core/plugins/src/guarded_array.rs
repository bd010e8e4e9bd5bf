//! Arrays that a plugin writes to during a call, with guards on both sides that reveal most writes out of bounds.

use std::{
    marker::PhantomData,
    ops::{Deref, DerefMut},
};

use bytemuck::Pod;

use crate::state_block::GUARD;

/// Size of a guard, words: large enough to detect that a plugin wrote a wrench where a force was expected, or a few
/// elements instead of one.
const GUARD_WORDS: usize = 72;

/// An array of `T` between two guards. [`GuardedArray::fill`] can move it to other memory.
#[derive(Debug)]
pub struct GuardedArray<T> {
    /// Guard, elements, guard; the second guard begins directly after the last byte.
    words: Vec<u64>,
    n: usize,
    of: PhantomData<T>,
}

impl<T> Default for GuardedArray<T> {
    fn default() -> Self {
        GuardedArray { words: Vec::new(), n: 0, of: PhantomData }
    }
}

impl<T: Pod> GuardedArray<T> {
    /// Resizes the array to `n` elements of this value, and restores the guards.
    pub fn fill(&mut self, n: usize, value: T) {
        let words = (n * size_of::<T>()).div_ceil(8);
        self.words.clear();
        self.words.resize(words + 2 * GUARD_WORDS, GUARD);
        self.n = n;
        self.deref_mut().fill(value);
    }

    /// Returns the pointer to pass to plugins.
    pub fn first_mut(&mut self) -> *mut T {
        self.words.as_mut_ptr().wrapping_add(GUARD_WORDS).cast()
    }

    /// Returns whether the guards are intact.
    pub fn guards_intact(&self) -> bool {
        if self.words.is_empty() {
            return true;
        }
        let end = GUARD_WORDS * 8 + self.n * size_of::<T>();
        let (full, part) = (end.div_ceil(8), end % 8);
        let behind = |word: u64| word.to_ne_bytes()[part..] == GUARD.to_ne_bytes()[part..];
        self.words[..GUARD_WORDS].iter().all(|w| *w == GUARD)
            && (part == 0 || behind(self.words[full - 1]))
            && self.words[full..].iter().all(|w| *w == GUARD)
    }
}

impl<T: Pod> Deref for GuardedArray<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        if self.n == 0 {
            return &[];
        }
        &bytemuck::cast_slice(&self.words[GUARD_WORDS..self.words.len() - GUARD_WORDS])[..self.n]
    }
}

impl<T: Pod> DerefMut for GuardedArray<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        if self.n == 0 {
            return &mut [];
        }
        let end = self.words.len() - GUARD_WORDS;
        &mut bytemuck::cast_slice_mut(&mut self.words[GUARD_WORDS..end])[..self.n]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn write_outside_guarded_array_is_detected() {
        for n in 0..5 {
            for at in [-64, -1, 0, 1, 3, 60] {
                let mut array = GuardedArray::<i32>::default();
                array.fill(n, 7);
                assert!(array.guards_intact() && array.iter().all(|x| *x == 7) && array.len() == n);
                let bytes = n as isize * 4;
                let place = if at < 0 { at } else { bytes + at };
                // SAFETY: the offsets are chosen within the guards.
                unsafe { array.first_mut().cast::<u8>().offset(place).write(1) };
                assert!(!array.guards_intact(), "{n} {at}");
                assert!(array.iter().all(|x| *x == 7));
                array.fill(n, 7);
                assert!(array.guards_intact());
            }
        }
    }
}
