//! Address space whose addresses have the same low 32 bits in every run.

use crate::system;

const REGION_ALIGN: usize = 4 << 30;
/// Number of bytes of address space that must remain free for the rest of the program. If scripts reserved all address
/// space, the next ordinary allocation would fail and abort the program. If less is free, scripts use the system's
/// allocator.
const MIN_FREE_BYTES: usize = 1 << 30;

/// Reserved address space that begins at a multiple of 4 GiB, and does not use memory until committed.
pub(super) struct Region {
    mapped: *mut u8,
    bytes: usize,
    pub base: *mut u8,
}

impl Region {
    /// Reserves `bytes` of address space; returns `None` if the system refuses.
    pub fn new(bytes: usize) -> Option<Region> {
        if cfg!(target_pointer_width = "64") {
            let probe = system::reserve(bytes + MIN_FREE_BYTES);
            if probe.is_null() {
                return None;
            }
            // SAFETY: `probe` was reserved above with the same size, and nothing refers to it.
            unsafe { system::free(probe, bytes + MIN_FREE_BYTES) };
        }
        // Try without padding first, because 4 GiB of padding per script could exceed a limit of the address space
        // (`ulimit -v`).
        let base = system::reserve_aligned(bytes, REGION_ALIGN);
        if !base.is_null() {
            return Some(Region { mapped: base, bytes, base });
        }
        let (mapped, bytes) = (system::reserve(REGION_ALIGN + bytes), REGION_ALIGN + bytes);
        (!mapped.is_null()).then(|| Region {
            mapped,
            bytes,
            base: mapped.wrapping_add(mapped.align_offset(REGION_ALIGN)),
        })
    }
}

impl Drop for Region {
    fn drop(&mut self) {
        // SAFETY: `mapped` and `bytes` are those of the reservation. The region belongs to a `MemorySlot`, which is
        // dropped after the state that uses its blocks has been closed.
        unsafe { system::free(self.mapped, self.bytes) };
    }
}
