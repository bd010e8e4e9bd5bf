//! Address space from the system: the only code here that differs between systems.

/// Reserves address space that costs no memory until it is committed. Null: this system, or its limits, give none.
#[cfg(unix)]
pub(crate) fn reserve(bytes: usize) -> *mut u8 {
    #[cfg(any(target_os = "linux", target_os = "android", target_os = "macos"))]
    const FLAGS: i32 = libc::MAP_PRIVATE | libc::MAP_ANON | libc::MAP_NORESERVE;
    #[cfg(not(any(target_os = "linux", target_os = "android", target_os = "macos")))]
    const FLAGS: i32 = libc::MAP_PRIVATE | libc::MAP_ANON;
    // SAFETY: a new mapping, anywhere.
    let at = unsafe { libc::mmap(std::ptr::null_mut(), bytes, libc::PROT_NONE, FLAGS, -1, 0) };
    if at == libc::MAP_FAILED {
        return std::ptr::null_mut();
    }
    at.cast()
}

/// Makes pages of a reservation usable; they read zero.
///
/// # Safety
/// The range lies, whole pages, in a reservation.
#[cfg(unix)]
pub(crate) unsafe fn commit(at: *mut u8, bytes: usize) -> bool {
    libc::mprotect(at.cast(), bytes, libc::PROT_READ | libc::PROT_WRITE) == 0
}

/// Gives a reservation back.
///
/// # Safety
/// What `reserve` gave, once, and nothing points into it any more.
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
