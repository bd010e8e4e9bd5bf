//! Memory of values in flight: a stack of chunks whose addresses stay.
//!
//! Each block is followed by a guard, which shows that a plugin wrote past the end.
//!
//! How much fits is counted by what is in flight now, not by the chunks that there are: it depends neither on earlier calls nor
//! on whether the world was restored from a snapshot.

use std::{mem::MaybeUninit, ptr::NonNull};

use tatu_plugin_api::safe::Room;
use tatu_plugins::state_block::GUARD;

/// Bytes of a chunk.
const CHUNK: usize = 64 * 1024;
/// Bytes that values in flight may take together, each rounded up to 16 and with 16 more for its guard.
const LIMIT: usize = 256 * 1024 * 1024;
/// So many guards do not count: 256 blocks of 1 MB fit, as the limit promises.
const FREE_GUARDS: usize = 4096;

/// A stack: allocate, and go back to a mark.
#[derive(Default)]
pub struct Arena {
    chunks: Vec<Chunk>,
    /// Chunk in use, and words used in it.
    chunk: usize,
    used: usize,
}

/// 16-byte aligned words, and how many are in flight in the chunks before. A `Vec`, for its pointer is taken without a borrow of
/// the words, which others use.
struct Chunk(Vec<u128>, usize);

impl Arena {
    /// `bytes` bytes, 16-byte aligned; null when values in flight would take too much.
    pub fn alloc(&mut self, bytes: usize) -> *mut u8 {
        let block = bytes.div_ceil(16).max(1);
        let words = block + 1;
        let before = self.chunks.get(self.chunk).map_or(0, |c| c.1) + self.used;
        if bytes > LIMIT || before + words > LIMIT / 16 + FREE_GUARDS {
            return std::ptr::null_mut();
        }
        let fits = |c: Option<&Chunk>, used: usize| c.is_some_and(|c| used + words <= c.0.len());
        if !fits(self.chunks.get(self.chunk), self.used) {
            let next = if self.chunks.is_empty() { 0 } else { self.chunk + 1 };
            if !fits(self.chunks.get(next), 0) {
                // What follows holds nothing, and is too small.
                self.chunks.truncate(next);
                self.chunks.push(Chunk(vec![0; words.max(CHUNK / 16 + 1)], before));
            }
            (self.chunk, self.used) = (next, 0);
            self.chunks[next].1 = before;
        }
        let at = self.used;
        self.used += words;
        let first = self.chunks[self.chunk].0.as_mut_ptr();
        // SAFETY: within the chunk, behind the block.
        unsafe { first.add(at + block).write(guard(block)) };
        first.wrapping_add(at).cast()
    }

    /// Whether nobody has written past the end of a block that was given since the mark, as far as they lie in the chunk in
    /// use: there are more of them only where much was asked for.
    pub fn is_whole_since(&self, mark: u64) -> bool {
        let (chunk, used) = ((mark >> 32) as usize, (mark & 0xFFFF_FFFF) as usize);
        let begin = if chunk == self.chunk { used } else { 0 };
        let mut end = self.used;
        while end > begin {
            let first = self.chunks[self.chunk].0.as_ptr();
            // SAFETY: within what is used of the chunk; read through the pointer, for plugins write to what lies before.
            let word = unsafe { first.add(end - 1).read() };
            let block = (word as u64 ^ GUARD) as usize;
            if word != guard(block) || block >= end {
                return false;
            }
            end -= block + 1;
        }
        true
    }

    /// The place to which a release goes back.
    pub fn mark(&self) -> u64 {
        (self.chunk as u64) << 32 | self.used as u64
    }

    /// Goes back; a mark from the future is ignored.
    pub fn release(&mut self, mark: u64) {
        let (chunk, used) = ((mark >> 32) as usize, (mark & 0xFFFF_FFFF) as usize);
        if (chunk, used) <= (self.chunk, self.used) {
            (self.chunk, self.used) = (chunk, used);
        }
    }
}

/// What stands behind a block of so many words; none of its bytes is likely to be written there by accident.
fn guard(block: usize) -> u128 {
    u128::from(GUARD) << 64 | u128::from(block as u64 ^ GUARD)
}

impl Room for Arena {
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]> {
        let at = NonNull::new(self.alloc(8 * n))?;
        // SAFETY: room for as many words, which nobody else has until a release.
        Some(unsafe { std::slice::from_raw_parts_mut(at.cast().as_ptr(), n) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_stay_and_marks_lead_back() {
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
    fn how_much_fits_does_not_depend_on_what_was_there_before() {
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
    fn a_byte_past_the_end_of_a_block_is_noticed() {
        let mut a = Arena::default();
        a.alloc(3);
        let mark = a.mark();
        let place = a.alloc(32);
        a.alloc(1);
        assert!(a.is_whole_since(mark) && a.is_whole_since(0));
        // SAFETY: within the chunk.
        unsafe { place.add(32).write(0) };
        assert!(!a.is_whole_since(mark) && !a.is_whole_since(0));
        a.release(mark);
        assert!(a.is_whole_since(mark) && a.is_whole_since(0));
        // In a chunk of its own.
        let place = a.alloc(CHUNK);
        assert!(a.is_whole_since(mark));
        // SAFETY: within the chunk.
        unsafe { place.add(CHUNK).write(0) };
        assert!(!a.is_whole_since(mark));
    }

    #[test]
    fn too_much_is_refused() {
        assert!(Arena::default().alloc(LIMIT + 1).is_null());
    }
}
