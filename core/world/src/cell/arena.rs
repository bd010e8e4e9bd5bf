//! Memory of values in flight: a stack of chunks whose addresses stay.

/// Bytes of a chunk.
const CHUNK: usize = 64 * 1024;
/// Bytes that values in flight may take together.
const LIMIT: usize = 256 * 1024 * 1024;

/// A stack: allocate, and go back to a mark.
#[derive(Default)]
pub struct Arena {
    /// 16-byte aligned words.
    chunks: Vec<Box<[u128]>>,
    /// Chunk in use, and words used in it.
    chunk: usize,
    used: usize,
    total: usize,
}

impl Arena {
    /// `bytes` bytes, 16-byte aligned; null when values in flight would take too much.
    pub fn alloc(&mut self, bytes: usize) -> *mut u8 {
        if bytes > LIMIT {
            return std::ptr::null_mut();
        }
        let words = bytes.div_ceil(16).max(1);
        while self.chunk < self.chunks.len() {
            if self.used + words <= self.chunks[self.chunk].len() {
                let at = self.used;
                self.used += words;
                return self.chunks[self.chunk][at..].as_mut_ptr().cast();
            }
            self.chunk += 1;
            self.used = 0;
        }
        let size = words.max(CHUNK / 16);
        if self.total + size * 16 > LIMIT {
            return std::ptr::null_mut();
        }
        self.total += size * 16;
        self.chunks.push(vec![0u128; size].into_boxed_slice());
        self.used = words;
        self.chunks[self.chunk].as_mut_ptr().cast()
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
    fn too_much_is_refused() {
        assert!(Arena::default().alloc(LIMIT + 1).is_null());
    }
}
