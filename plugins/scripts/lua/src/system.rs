//! Virtual memory of the operating system.

/// Reserves address space, which does not use memory until it is committed. Returns null if the system refuses the
/// reservation, or does not support reservations.
#[cfg(unix)]
pub(crate) fn reserve(bytes: usize) -> *mut u8 {
    reserve_near(std::ptr::null_mut(), bytes)
}

#[cfg(any(target_os = "linux", target_os = "android", target_os = "macos"))]
const FLAGS: i32 = libc::MAP_PRIVATE | libc::MAP_ANON | libc::MAP_NORESERVE;
#[cfg(all(unix, not(any(target_os = "linux", target_os = "android", target_os = "macos"))))]
const FLAGS: i32 = libc::MAP_PRIVATE | libc::MAP_ANON;

/// Reserves address space at `wish`, or elsewhere if that range is in use.
#[cfg(unix)]
fn reserve_near(wish: *mut u8, bytes: usize) -> *mut u8 {
    // SAFETY: without MAP_FIXED, the address is only a hint, so the new mapping does not replace an existing one.
    let at = unsafe { libc::mmap(wish.cast(), bytes, libc::PROT_NONE, FLAGS, -1, 0) };
    if at == libc::MAP_FAILED { std::ptr::null_mut() } else { at.cast() }
}

/// Reserves address space that begins at a multiple of `align`, without padding. Returns null if none of the addresses
/// tried is free.
#[cfg(all(unix, target_pointer_width = "64"))]
pub(crate) fn reserve_aligned(bytes: usize, align: usize) -> *mut u8 {
    use std::sync::atomic::{AtomicUsize, Ordering};
    /// A range of addresses in which systems with at least 47 address bits place neither programs nor their libraries,
    /// heaps and stacks.
    const ADDRESS_RANGE: std::ops::Range<usize> = 0x1000_0000_0000..0x5000_0000_0000;
    const MAX_TRIES: usize = 32;
    static NEXT_INDEX: AtomicUsize = AtomicUsize::new(0);
    for _ in 0..MAX_TRIES {
        let number = NEXT_INDEX.fetch_add(1, Ordering::Relaxed) % (ADDRESS_RANGE.len() / align);
        let wish = (ADDRESS_RANGE.start + number * align) as *mut u8;
        let at = reserve_near(wish, bytes);
        if at.is_null() || at == wish {
            return at;
        }
        // SAFETY: the range was reserved just above with this size, and nothing refers to it.
        unsafe { free(at, bytes) };
    }
    std::ptr::null_mut()
}
#[cfg(not(all(unix, target_pointer_width = "64")))]
pub(crate) fn reserve_aligned(_: usize, _: usize) -> *mut u8 {
    std::ptr::null_mut()
}

/// Makes reserved pages, which are filled with zeros, readable and writable. Returns whether the system did so.
///
/// # Safety
/// The range must consist of whole pages of a single reservation.
#[cfg(unix)]
pub(crate) unsafe fn commit(at: *mut u8, bytes: usize) -> bool {
    libc::mprotect(at.cast(), bytes, libc::PROT_READ | libc::PROT_WRITE) == 0
}

/// Releases a reservation.
///
/// # Safety
/// `at` and `bytes` must be those of a reservation, and nothing may refer to the range any more.
#[cfg(unix)]
pub(crate) unsafe fn free(at: *mut u8, bytes: usize) {
    libc::munmap(at.cast(), bytes);
}

#[cfg(not(unix))]
pub(crate) fn reserve(_: usize) -> *mut u8 {
    std::ptr::null_mut()
}
#[cfg(not(unix))]
pub(crate) unsafe fn commit(_: *mut u8, _: usize) -> bool {
    false
}
#[cfg(not(unix))]
pub(crate) unsafe fn free(_: *mut u8, _: usize) {}
