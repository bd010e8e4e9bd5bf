//! Read-only copies of bytes that end at a guard page: a plugin that reads past the end of a copy, or writes to it,
//! crashes at that access, and [`blame`] identifies the copy.

use std::ffi::c_void;

/// A read-only copy that ends at an inaccessible page; it is unmapped on drop.
#[derive(Debug)]
pub struct GuardedCopy {
    first: *const u8,
    len: usize,
    #[cfg(unix)]
    _mapping: mapped::GuardedMapping,
    #[cfg(not(unix))]
    _bytes: Vec<u8>,
}

impl GuardedCopy {
    /// Copies `bytes`. [`blame`] reports `label` for this copy. The copy is aligned to the largest power of 2, at most
    /// a page, that divides its length.
    pub fn new(bytes: &[u8], label: &str) -> Self {
        #[cfg(unix)]
        {
            let (mapping, first) = mapped::GuardedMapping::new(bytes, label);
            GuardedCopy { first, len: bytes.len(), _mapping: mapping }
        }
        #[cfg(not(unix))]
        {
            let _ = label;
            let copy = bytes.to_vec();
            GuardedCopy { first: copy.as_ptr(), len: copy.len(), _bytes: copy }
        }
    }
    /// Returns the copied bytes.
    pub fn bytes(&self) -> &[u8] {
        // SAFETY: the copy has `len` readable bytes, which live as long as `self` and never change.
        unsafe { std::slice::from_raw_parts(self.first, self.len) }
    }
    /// Returns a pointer to the first byte.
    pub fn first(&self) -> *const u8 {
        self.first
    }
}

/// Creates a copy like [`GuardedCopy`] that remains mapped until the process ends.
pub fn leak_before_guard(bytes: &[u8], label: &str) -> *const c_void {
    let guarded = GuardedCopy::new(bytes, label);
    let first = guarded.first.cast();
    std::mem::forget(guarded);
    first
}

/// Size of a label, in bytes.
const LABEL_BYTES: usize = 120;

/// The label of a copy, truncated to a fixed size.
pub struct CopyLabel([u8; LABEL_BYTES]);

impl CopyLabel {
    /// Returns the label without its padding.
    pub fn bytes(&self) -> &[u8] {
        self.0.split(|b| *b == 0).next().unwrap_or_default()
    }
}

/// Returns the kind of access that `address` implies, and the label of the copy, or `None` if the address belongs to no
/// copy. Signal handlers may call this.
pub fn blame(address: usize) -> Option<(&'static str, CopyLabel)> {
    #[cfg(unix)]
    return mapped::blame(address);
    #[cfg(not(unix))]
    {
        let _ = address;
        None
    }
}

#[cfg(unix)]
mod mapped {
    use std::{
        ptr,
        sync::atomic::{
            AtomicU8, AtomicUsize,
            Ordering::{Acquire, Relaxed, Release},
        },
    };

    use super::{CopyLabel, LABEL_BYTES};

    /// Maximum number of copies that can have a label at the same time; further copies have none.
    const MAX_COPIES: usize = 4096;

    /// The data of a copy for signal handlers: the start of its mapping (0 if the slot is free), start and end of its
    /// guard page, and its label.
    struct CopySlot {
        begin: AtomicUsize,
        guard: AtomicUsize,
        end: AtomicUsize,
        label: [AtomicU8; LABEL_BYTES],
    }
    static SLOTS: [CopySlot; MAX_COPIES] = [const {
        CopySlot {
            begin: AtomicUsize::new(0),
            guard: AtomicUsize::new(0),
            end: AtomicUsize::new(0),
            label: [const { AtomicU8::new(0) }; LABEL_BYTES],
        }
    }; MAX_COPIES];

    #[derive(Debug)]
    pub struct GuardedMapping {
        begin: *mut libc::c_void,
        bytes: usize,
        slot: Option<usize>,
    }

    impl GuardedMapping {
        pub fn new(bytes: &[u8], label: &str) -> (Self, *const u8) {
            // SAFETY: `sysconf` has no pointer arguments and no preconditions.
            let page = usize::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).unwrap_or(4096);
            let data = bytes.len().div_ceil(page).max(1) * page;
            // SAFETY: without an address and a file, `mmap` creates a new mapping, which no other code uses.
            let begin = unsafe {
                let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
                libc::mmap(ptr::null_mut(), data + page, libc::PROT_READ | libc::PROT_WRITE, flags, -1, 0)
            };
            assert!(begin != libc::MAP_FAILED, "no memory for guard pages");
            let first = begin.cast::<u8>().wrapping_add(data - bytes.len());
            // SAFETY: the mapping has `data` writable bytes, of which the last `bytes.len()` are filled from `bytes`;
            // both stay valid during the calls. The ranges whose protection is set are inside the mapping.
            unsafe {
                ptr::copy_nonoverlapping(bytes.as_ptr(), first, bytes.len());
                libc::mprotect(begin, data, libc::PROT_READ);
                libc::mprotect(begin.cast::<u8>().add(data).cast(), page, libc::PROT_NONE);
            }
            let slot = take_slot(begin.addr(), begin.addr() + data, begin.addr() + data + page, label);
            (GuardedMapping { begin, bytes: data + page, slot }, first)
        }
    }

    impl Drop for GuardedMapping {
        fn drop(&mut self) {
            if let Some(slot) = self.slot {
                SLOTS[slot].end.store(0, Release);
                SLOTS[slot].begin.store(0, Release);
            }
            // SAFETY: `begin` and `bytes` are those of this mapping, which is unmapped only here.
            unsafe { libc::munmap(self.begin, self.bytes) };
        }
    }

    fn take_slot(begin: usize, guard: usize, end: usize, label: &str) -> Option<usize> {
        let free = |slot: &CopySlot| slot.begin.compare_exchange(0, begin, Release, Acquire).is_ok();
        let index = SLOTS.iter().position(free)?;
        let slot = &SLOTS[index];
        // The slot is not visible to `blame` until `end` is stored.
        let bytes = label.bytes().take(LABEL_BYTES - 1).chain(std::iter::repeat(0));
        slot.label.iter().zip(bytes).for_each(|(place, byte)| place.store(byte, Relaxed));
        slot.guard.store(guard, Release);
        slot.end.store(end, Release);
        Some(index)
    }

    pub fn blame(address: usize) -> Option<(&'static str, CopyLabel)> {
        let holds = |s: &&CopySlot| {
            let begin = s.begin.load(Acquire);
            begin != 0 && begin <= address && address < s.end.load(Acquire)
        };
        let slot = SLOTS.iter().find(holds)?;
        // The label was written before `end` was stored, which `holds` has read.
        let label = std::array::from_fn(|i| slot.label[i].load(Relaxed));
        let what = if address < slot.guard.load(Acquire) { "a write to" } else { "an access past the end of" };
        Some((what, CopyLabel(label)))
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn faulting_address_is_attributed_to_its_copy() {
        let guarded = GuardedCopy::new(b"abc", "argument `name`");
        let first = guarded.first().addr();
        let said = |address| blame(address).map(|(what, label)| format!("{what} {}", label.bytes().escape_ascii()));
        assert_eq!(said(first + 3).as_deref(), Some("an access past the end of argument `name`"));
        assert_eq!(said(first).as_deref(), Some("a write to argument `name`"));
        // SAFETY: `first` points to the three bytes of the copy, which lives until the end of the test.
        assert_eq!(unsafe { std::slice::from_raw_parts(guarded.first(), 3) }, b"abc");
        drop(guarded);
        assert_eq!(said(first), None);
    }
}
