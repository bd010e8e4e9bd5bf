//! Address space whose addresses have the same low 32 bits in every run.

use crate::system;

const ALIGN: usize = 4 << 30;
/// Address space that is left to the rest of the program: reservations of scripts that took it to the last would make the
/// next ordinary allocation fail, which ends the program. Where there is not so much, scripts share the system's memory.
const LEFT: usize = 1 << 30;

/// Reserved address space that begins at a multiple of 4 GiB. It uses no memory until committed.
pub(super) struct Region {
    mapped: *mut u8,
    bytes: usize,
    pub base: *mut u8,
}

impl Region {
    /// `None` if the system refuses.
    pub fn new(bytes: usize) -> Option<Region> {
        if cfg!(target_pointer_width = "64") {
            let probe = system::reserve(bytes + LEFT);
            if probe.is_null() {
                return None;
            }
            // SAFETY: just reserved, and not used.
            unsafe { system::free(probe, bytes + LEFT) };
        }
        // Where address space is short (`ulimit -v`), 4 GiB more for each script would be too much.
        let base = system::reserve_aligned(bytes, ALIGN);
        if !base.is_null() {
            return Some(Region { mapped: base, bytes, base });
        }
        let (mapped, bytes) = (system::reserve(ALIGN + bytes), ALIGN + bytes);
        (!mapped.is_null()).then(|| Region { mapped, bytes, base: mapped.wrapping_add(mapped.align_offset(ALIGN)) })
    }
}

impl Drop for Region {
    fn drop(&mut self) {
        // SAFETY: the owner has dropped everything inside the region.
        unsafe { system::free(self.mapped, self.bytes) };
    }
}
