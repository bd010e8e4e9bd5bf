//! Address space whose addresses have the same low 32 bits in every run.

use crate::system;

const ALIGN: usize = 4 << 30;

/// Reserved address space that begins at a multiple of 4 GiB. It uses no memory until committed.
pub(super) struct Region {
    mapped: *mut u8,
    bytes: usize,
    pub base: *mut u8,
}

impl Region {
    /// `None` if the system refuses.
    pub fn new(bytes: usize) -> Option<Region> {
        let mapped = system::reserve(ALIGN + bytes);
        (!mapped.is_null()).then(|| Region { mapped, bytes, base: mapped.wrapping_add(mapped.align_offset(ALIGN)) })
    }
}

impl Drop for Region {
    fn drop(&mut self) {
        // SAFETY: the owner has dropped everything inside the region.
        unsafe { system::free(self.mapped, ALIGN + self.bytes) };
    }
}
