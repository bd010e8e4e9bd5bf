//! Records the memory that the plugin under test has allocated and not released.

use std::{
    collections::BTreeMap,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

use libc::{c_char, c_int, c_void};

use super::rules::{report_allocation, running_call};

/// Sizes of the blocks that are in use, by address; empty unless [`record_allocations`] was called.
static BLOCKS: Mutex<BTreeMap<usize, usize>> = Mutex::new(BTreeMap::new());
static IS_RECORDING: AtomicBool = AtomicBool::new(false);
/// Size of a single allocation above which it is reported: files that state such sizes are malformed.
const HUGE_BYTES: usize = 1 << 30;

/// Begins to record which memory is in use.
pub fn record_allocations() {
    IS_RECORDING.store(true, Relaxed);
}

/// Returns the size of the memory that is in use, bytes.
pub fn allocated_bytes() -> i64 {
    BLOCKS.lock().unwrap_or_else(PoisonError::into_inner).values().sum::<usize>() as i64
}

/// The functions that replace those of the C library, by name.
pub fn doubles() -> [(&'static str, *const c_void); 8] {
    [
        ("malloc", malloc as *const c_void),
        ("calloc", calloc as *const c_void),
        ("realloc", realloc as *const c_void),
        ("free", free as *const c_void),
        ("posix_memalign", posix_memalign as *const c_void),
        ("aligned_alloc", aligned_alloc as *const c_void),
        ("strdup", strdup as *const c_void),
        ("strndup", strndup as *const c_void),
    ]
}

fn add(block: *mut c_void, bytes: usize) -> *mut c_void {
    if IS_RECORDING.load(Relaxed) && !block.is_null() {
        BLOCKS.lock().unwrap_or_else(PoisonError::into_inner).insert(block.addr(), bytes);
    }
    block
}

fn remove(block: *mut c_void) {
    if IS_RECORDING.load(Relaxed) && !block.is_null() {
        BLOCKS.lock().unwrap_or_else(PoisonError::into_inner).remove(&block.addr());
    }
}

fn report_huge(name: &str, bytes: usize) {
    if bytes >= HUGE_BYTES && running_call().is_some() {
        report_allocation(name, bytes);
    }
}

// SAFETY, for all functions below: the arguments are those that the plugin passes to the function of this name, and are
// passed on unchanged.
extern "C" fn malloc(bytes: usize) -> *mut c_void {
    report_huge("malloc", bytes);
    // SAFETY: see above.
    add(unsafe { libc::malloc(bytes) }, bytes)
}
extern "C" fn calloc(n: usize, each: usize) -> *mut c_void {
    report_huge("calloc", n.saturating_mul(each));
    // SAFETY: see above.
    add(unsafe { libc::calloc(n, each) }, n.saturating_mul(each))
}
extern "C" fn realloc(block: *mut c_void, bytes: usize) -> *mut c_void {
    report_huge("realloc", bytes);
    // Another thread may get the old address as soon as it is free.
    remove(block);
    // SAFETY: see above.
    let moved = unsafe { libc::realloc(block, bytes) };
    if moved.is_null() && bytes > 0 {
        add(block, 0);
    }
    add(moved, bytes)
}
extern "C" fn free(block: *mut c_void) {
    remove(block);
    // SAFETY: see above.
    unsafe { libc::free(block) };
}
extern "C" fn posix_memalign(out: *mut *mut c_void, align: usize, bytes: usize) -> c_int {
    report_huge("posix_memalign", bytes);
    // SAFETY: see above; the block is read only if the function has stored it.
    unsafe {
        let status = libc::posix_memalign(out, align, bytes);
        if status == 0 {
            add(*out, bytes);
        }
        status
    }
}
extern "C" fn aligned_alloc(align: usize, bytes: usize) -> *mut c_void {
    report_huge("aligned_alloc", bytes);
    // SAFETY: see above.
    add(unsafe { libc::aligned_alloc(align, bytes) }, bytes)
}
extern "C" fn strdup(text: *const c_char) -> *mut c_void {
    // SAFETY: see above; the copy ends with a NUL.
    unsafe {
        let copy = libc::strdup(text);
        add(copy.cast(), if copy.is_null() { 0 } else { libc::strlen(copy) + 1 })
    }
}
extern "C" fn strndup(text: *const c_char, n: usize) -> *mut c_void {
    // SAFETY: see above; the copy ends with a NUL.
    unsafe {
        let copy = libc::strndup(text, n);
        add(copy.cast(), if copy.is_null() { 0 } else { libc::strlen(copy) + 1 })
    }
}
