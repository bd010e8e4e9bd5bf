//! Address space whose addresses have the same low 32 bits in every run.

use crate::system;

const ALIGN: usize = 4 << 30;

/// Address space that begins at a multiple of 4 GiB, until it is dropped. It costs no memory until it is committed.
pub(super) struct Region {
    mapped: *mut u8,
    bytes: usize,
    pub base: *mut u8,
}

impl Region {
    /// `None` where the system reserves none.
    pub fn new(bytes: usize) -> Option<Region> {
        let mapped = system::reserve(ALIGN + bytes);
        (!mapped.is_null()).then(|| Region { mapped, bytes, base: mapped.wrapping_add(mapped.align_offset(ALIGN)) })
    }
}

impl Drop for Region {
    fn drop(&mut self) {
        // SAFETY: who holds the region has nothing in it any more.
        unsafe { system::free(self.mapped, ALIGN + self.bytes) };
    }
}
