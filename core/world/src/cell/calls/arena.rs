//! Memory for values that are passed to and from plugins: a stack of chunks with stable addresses.
//!
//! Each block is followed by a guard word, which reveals that a plugin wrote past its end.
//!
//! The limit applies to the blocks in use, not to the chunks allocated so far. It therefore depends neither on earlier
//! calls nor on whether the world was restored from a snapshot.

use std::{mem::MaybeUninit, ptr::NonNull};

use tatu_plugin_api::safe::Room;
use tatu_plugins::state_block::GUARD;

/// Minimum size of a chunk, bytes.
const MIN_CHUNK_BYTES: usize = 64 * 1024;
/// Maximum size of all blocks in use, bytes. Each block is rounded up to a multiple of 16 bytes, and its guard takes 16
/// more.
const MAX_ARENA_BYTES: usize = 256 * 1024 * 1024;
/// Number of guards to which the limit does not apply, so that 256 blocks of 1 MB fit.
const EXEMPT_GUARDS: usize = 4096;

/// A stack allocator, which releases all blocks allocated since a mark at once.
#[derive(Default)]
pub struct Arena {
    chunks: Vec<ArenaChunk>,
    /// Index of the current chunk.
    chunk: usize,
    /// Number of words used in the current chunk.
    used: usize,
}

/// A chunk of 16-byte aligned words, and the number of words in use in the chunks before it. The words are in a `Vec`,
/// because its pointer can be taken without borrowing them while plugins use them.
struct ArenaChunk(Vec<u128>, usize);

impl Arena {
    /// Allocates `bytes` bytes, 16-byte aligned. Returns null if the limit would be exceeded.
    pub fn alloc(&mut self, bytes: usize) -> *mut u8 {
        let block = bytes.div_ceil(16).max(1);
        let words = block + 1;
        let before = self.chunks.get(self.chunk).map_or(0, |c| c.1) + self.used;
        if bytes > MAX_ARENA_BYTES || before + words > MAX_ARENA_BYTES / 16 + EXEMPT_GUARDS {
            return std::ptr::null_mut();
        }
        let fits = |c: Option<&ArenaChunk>, used: usize| c.is_some_and(|c| used + words <= c.0.len());
        if !fits(self.chunks.get(self.chunk), self.used) {
            let next = if self.chunks.is_empty() { 0 } else { self.chunk + 1 };
            if !fits(self.chunks.get(next), 0) {
                // The chunks after the current one are unused, and the first of them is too small.
                self.chunks.truncate(next);
                self.chunks.push(ArenaChunk(vec![0; words.max(MIN_CHUNK_BYTES / 16 + 1)], before));
            }
            (self.chunk, self.used) = (next, 0);
            self.chunks[next].1 = before;
        }
        let at = self.used;
        self.used += words;
        let first = self.chunks[self.chunk].0.as_mut_ptr();
        // SAFETY: `used + words <= len` was checked or the chunk was made large enough, so the guard word at `at +
        // block` is within the chunk.
        unsafe { first.add(at + block).write(guard(block)) };
        first.wrapping_add(at).cast()
    }

    /// Copies items into a new block, and returns a pointer to the first one. Returns null if the limit would be
    /// exceeded.
    pub fn store<T: Copy>(&mut self, items: &[T]) -> *mut T {
        const { assert!(align_of::<T>() <= 16) };
        let room = self.alloc(size_of_val(items)).cast::<T>();
        if !room.is_null() {
            // SAFETY: `room` points to a new block that is large enough and aligned, so it does not overlap `items`.
            unsafe { room.copy_from_nonoverlapping(items.as_ptr(), items.len()) };
        }
        room
    }

    /// Returns whether the guards of the blocks allocated since the mark are intact. Blocks in earlier chunks are not
    /// checked, because few calls allocate blocks in more than one chunk.
    pub fn is_intact_since(&self, mark: u64) -> bool {
        let (chunk, used) = ((mark >> 32) as usize, (mark & 0xFFFF_FFFF) as usize);
        let begin = if chunk == self.chunk { used } else { 0 };
        let mut end = self.used;
        while end > begin {
            let first = self.chunks[self.chunk].0.as_ptr();
            // SAFETY: `end - 1 < used <= len`, so the word is within the chunk. It is read through a raw pointer
            // because plugins write to the words before it.
            let word = unsafe { first.add(end - 1).read() };
            let block = (word as u64 ^ GUARD) as usize;
            if word != guard(block) || block >= end {
                return false;
            }
            end -= block + 1;
        }
        true
    }

    /// Returns the size of all blocks in use, with their guards, bytes.
    pub fn in_use(&self) -> usize {
        16 * (self.chunks.get(self.chunk).map_or(0, |c| c.1) + self.used)
    }

    /// Returns a mark for [`release`](Self::release): the current position.
    pub fn mark(&self) -> u64 {
        (self.chunk as u64) << 32 | self.used as u64
    }

    /// Releases all blocks allocated since the mark. A mark beyond the current position is ignored.
    pub fn release(&mut self, mark: u64) {
        let (chunk, used) = ((mark >> 32) as usize, (mark & 0xFFFF_FFFF) as usize);
        if (chunk, used) <= (self.chunk, self.used) {
            (self.chunk, self.used) = (chunk, used);
        }
    }
}

/// Returns the guard word after a block of `block` words. A plugin is unlikely to write this value by accident.
fn guard(block: usize) -> u128 {
    u128::from(GUARD) << 64 | u128::from(block as u64 ^ GUARD)
}

impl Room for Arena {
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]> {
        let at = NonNull::new(self.alloc(8 * n))?;
        // SAFETY: `at` points to `8 * n` bytes, 16-byte aligned, which live as long as the arena and are not handed out
        // again before a release.
        Some(unsafe { std::slice::from_raw_parts_mut(at.cast().as_ptr(), n) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_stable_and_release_returns_to_the_mark() {
        let mut a = Arena::default();
        let first = a.alloc(24);
        let mark = a.mark();
        let second = a.alloc(8);
        for _ in 0..10_000 {
            assert!(!a.alloc(100).is_null());
        }
        a.release(mark);
        assert_eq!(a.alloc(8), second);
        assert_ne!(first, second);
        assert_eq!(first as usize % 16, 0);
    }

    #[test]
    fn capacity_does_not_depend_on_earlier_allocations() {
        let most = |a: &mut Arena| {
            let mark = a.mark();
            let n = (0..).take_while(|_| !a.alloc(1 << 20).is_null()).count();
            a.release(mark);
            n
        };
        let mut used = Arena::default();
        let mark = used.mark();
        for size in [100, 3 << 20, 70_000, 40 << 20, 8] {
            assert!(!used.alloc(size).is_null());
        }
        used.release(mark);
        assert_eq!((most(&mut used), most(&mut used)), (256, 256));
        assert_eq!(most(&mut Arena::default()), 256);
    }

    #[test]
    fn write_past_the_end_of_a_block_is_detected() {
        let mut a = Arena::default();
        a.alloc(3);
        let mark = a.mark();
        let place = a.alloc(32);
        a.alloc(1);
        assert!(a.is_intact_since(mark) && a.is_intact_since(0));
        // SAFETY: byte 32 after `place` is the first one of the guard, within the chunk, which lives as long as the
        // arena.
        unsafe { place.add(32).write(0) };
        assert!(!a.is_intact_since(mark) && !a.is_intact_since(0));
        a.release(mark);
        assert!(a.is_intact_since(mark) && a.is_intact_since(0));
        // A block of this size is allocated in a separate chunk.
        let place = a.alloc(MIN_CHUNK_BYTES);
        assert!(a.is_intact_since(mark));
        // SAFETY: byte `MIN_CHUNK_BYTES` after `place` is the first one of the guard, within the chunk, which lives as
        // long as the arena.
        unsafe { place.add(MIN_CHUNK_BYTES).write(0) };
        assert!(!a.is_intact_since(mark));
    }

    #[test]
    fn block_above_the_limit_is_refused() {
        assert!(Arena::default().alloc(MAX_ARENA_BYTES + 1).is_null());
    }
}
