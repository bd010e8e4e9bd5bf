//! Virtual memory of the operating system.

/// Reserves address space that uses no memory until committed. Null: not supported, or refused.
#[cfg(unix)]
pub(crate) fn reserve(bytes: usize) -> *mut u8 {
    #[cfg(any(target_os = "linux", target_os = "android", target_os = "macos"))]
    const FLAGS: i32 = libc::MAP_PRIVATE | libc::MAP_ANON | libc::MAP_NORESERVE;
    #[cfg(not(any(target_os = "linux", target_os = "android", target_os = "macos")))]
    const FLAGS: i32 = libc::MAP_PRIVATE | libc::MAP_ANON;
    // SAFETY: creates a new mapping at an address chosen by the system.
    let at = unsafe { libc::mmap(std::ptr::null_mut(), bytes, libc::PROT_NONE, FLAGS, -1, 0) };
    if at == libc::MAP_FAILED {
        return std::ptr::null_mut();
    }
    at.cast()
}

/// Makes reserved pages usable; they read zero.
///
/// # Safety
/// The range consists of whole pages of a reservation.
#[cfg(unix)]
pub(crate) unsafe fn commit(at: *mut u8, bytes: usize) -> bool {
    libc::mprotect(at.cast(), bytes, libc::PROT_READ | libc::PROT_WRITE) == 0
}

/// Releases a reservation.
///
/// # Safety
/// `at` and `bytes` come from `reserve`, and nothing points into the range any more.
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
