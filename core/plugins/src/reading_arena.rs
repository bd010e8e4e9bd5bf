//! The memory of readings. Readings are written and read in the order in which their sensors were created, so small
//! ones are adjacent in memory in this order.

use std::{
    cell::UnsafeCell,
    ops::{Deref, DerefMut},
    rc::Rc,
};

use serde::{Deserialize, Serialize};

/// Words per chunk of the arena: enough for a few hundred distance sensors.
const CHUNK_WORDS: usize = 1 << 12;
/// Readings with more words than this are allocated separately.
const MAX_SHARED_WORDS: usize = 1 << 6;

/// The words of a reading, initially zero, at a stable address. A clone has separate memory.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(from = "Vec<u64>", into = "Vec<u64>")]
pub struct ReadingBuffer {
    shelf: Rc<[UnsafeCell<u64>]>,
    first: u32,
    len: u32,
}

impl ReadingBuffer {
    /// Allocates a separate buffer.
    pub fn new(len: usize) -> Self {
        ReadingBuffer { shelf: zeroed_words(len), first: 0, len: len as u32 }
    }
}

impl Deref for ReadingBuffer {
    type Target = [u64];
    #[inline]
    fn deref(&self) -> &[u64] {
        let at = UnsafeCell::raw_get(self.shelf.as_ptr()).wrapping_add(self.first as usize);
        // SAFETY: `first + len` words are within the chunk, which the `Rc` keeps alive, and the arena hands out each
        // word to a single buffer.
        unsafe { std::slice::from_raw_parts(at, self.len as usize) }
    }
}

impl DerefMut for ReadingBuffer {
    #[inline]
    fn deref_mut(&mut self) -> &mut [u64] {
        let at = UnsafeCell::raw_get(self.shelf.as_ptr()).wrapping_add(self.first as usize);
        // SAFETY: `first + len` words are within the chunk, which the `Rc` keeps alive. The arena hands out each word
        // to a single buffer, which is borrowed exclusively here.
        unsafe { std::slice::from_raw_parts_mut(at, self.len as usize) }
    }
}

impl PartialEq for ReadingBuffer {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl From<Vec<u64>> for ReadingBuffer {
    fn from(from: Vec<u64>) -> Self {
        let mut words = ReadingBuffer::new(from.len());
        words.copy_from_slice(&from);
        words
    }
}

impl From<ReadingBuffer> for Vec<u64> {
    fn from(words: ReadingBuffer) -> Self {
        words.to_vec()
    }
}

impl Clone for ReadingBuffer {
    fn clone(&self) -> Self {
        self.to_vec().into()
    }
}

/// An allocator of buffers, which remain valid after it is dropped.
#[derive(Debug, Default)]
pub struct ReadingArena {
    last: Rc<[UnsafeCell<u64>]>,
    used: usize,
}

impl ReadingArena {
    /// Returns whether a buffer of this many words is allocated separately.
    pub fn is_large(len: usize) -> bool {
        len > MAX_SHARED_WORDS
    }

    /// Allocates a buffer, next to the previous one unless it is large or the chunk is full.
    pub fn allocate(&mut self, len: usize) -> ReadingBuffer {
        if Self::is_large(len) {
            return ReadingBuffer::new(len);
        }
        if self.used + len > self.last.len() {
            (self.last, self.used) = (zeroed_words(CHUNK_WORDS), 0);
        }
        let first = self.used;
        self.used += len;
        ReadingBuffer { shelf: self.last.clone(), first: first as u32, len: len as u32 }
    }
}

fn zeroed_words(len: usize) -> Rc<[UnsafeCell<u64>]> {
    (0..len).map(|_| UnsafeCell::new(0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_readings_are_adjacent_at_stable_addresses() {
        let mut arena = ReadingArena::default();
        let mut all: Vec<ReadingBuffer> = (0..3000).map(|_| arena.allocate(9)).collect();
        for (i, words) in all.iter_mut().enumerate() {
            assert_eq!(**words, [0; 9]);
            words.fill(i as u64);
        }
        assert_eq!(all[1].as_ptr(), all[0].as_ptr().wrapping_add(9));
        let large = arena.allocate(MAX_SHARED_WORDS + 1);
        assert_eq!(large.len(), MAX_SHARED_WORDS + 1);
        let before = all[7].as_ptr();
        drop(arena);
        all.truncate(2000);
        assert!(all.iter().enumerate().all(|(i, words)| **words == [i as u64; 9]));
        assert_eq!(all[7].as_ptr(), before);
        assert!(ReadingBuffer::default().is_empty());
    }
}
