//! Memory of a Lua state: a slot of its own, whose addresses have the same low 32 bits in every run.
//!
//! Lua hashes tables, functions and threads by the low 32 bits of their addresses; the order in which `pairs` visits
//! such keys is therefore the same in each run only if these bits are. A slot begins at a multiple of 4 GiB, and what
//! lies where in it depends only on what the script does. The allocator keeps one free list per size class and takes
//! new blocks from the end; blocks are never split or joined. Where the system reserves no address space the system's
//! allocator takes over, and only that order is lost.

use std::{
    alloc::{Layout, alloc, dealloc},
    cell::Cell,
    ffi::c_void,
    ptr::{copy_nonoverlapping, null_mut},
};

use crate::system;

/// Bytes of a slot, and the memory limit of a script that is given none.
pub(crate) const SLOT_BYTES: usize = 256 << 20;
const ALIGN: usize = 4 << 30;
/// Below the size of a huge page, so that a small state does not get one.
const COMMIT: usize = 256 << 10;
const SMALL: usize = 512;
/// From this size on filling a block takes longer than the instruction that asked for it.
const HEAVY: usize = 4096;
/// Bytes of a cache line, and how many places there are to begin at: together as much as half of a second-level cache
/// keeps apart.
const LINE: usize = 64;
const COLOURS: usize = 1024;
const CLASSES: usize = 32 + 4 * 20;

/// A function, and what it is called with.
pub(crate) type Listener = (unsafe fn(*const c_void), *const c_void);

/// The memory of one state. Boxed: Lua keeps its address.
pub(crate) struct Slot {
    /// What was reserved; null: the system's allocator is used.
    mapped: *mut u8,
    base: *mut u8,
    top: Cell<usize>,
    committed: Cell<usize>,
    used: Cell<usize>,
    limit: Cell<usize>,
    /// Bytes of large blocks taken since somebody asked: filling them takes time that no instruction shows.
    heavy: Cell<u64>,
    /// Told when the limit is reached: whom, and what with.
    pub full: Cell<Option<Listener>>,
    free: [Cell<*mut u8>; CLASSES],
    /// Whether free blocks may be out of order, or some of them at the end.
    untidy: Cell<bool>,
}

/// A slot as it was.
pub(crate) struct Backup {
    bytes: Vec<u8>,
    used: usize,
    free: Vec<*mut u8>,
}

/// The class of a size, and the size of its blocks: steps of 16 bytes, then four per doubling.
fn class(bytes: usize) -> (usize, usize) {
    if bytes <= SMALL {
        let c = bytes.div_ceil(16).max(1);
        return (c - 1, c * 16);
    }
    let k = (bytes - 1).ilog2() as usize;
    let quarter = ((bytes - 1) >> (k - 2)) & 3;
    (32 + (k - 9) * 4 + quarter, (1 << k) + ((quarter + 1) << (k - 2)))
}

/// The size of the blocks of a class.
fn size_of_class(c: usize) -> usize {
    match c.checked_sub(32) {
        None => (c + 1) * 16,
        Some(c) => (SMALL << (c / 4)) + ((c % 4 + 1) << (c / 4 + 7)),
    }
}

impl Slot {
    /// A slot whose use begins at a place that follows from `seed`. If all began alike, the busiest blocks of all states
    /// would compete for the same few lines of the processor's caches.
    pub(crate) fn new(seed: u64) -> Box<Slot> {
        let mapped = system::reserve(ALIGN + SLOT_BYTES);
        let pad = mapped.align_offset(ALIGN);
        Box::new(Slot {
            mapped,
            base: mapped.wrapping_add(if mapped.is_null() { 0 } else { pad }),
            top: Cell::new((seed as usize % COLOURS) * LINE),
            committed: Cell::new(0),
            used: Cell::new(0),
            limit: Cell::new(SLOT_BYTES),
            heavy: Cell::new(0),
            full: Cell::new(None),
            free: [const { Cell::new(null_mut()) }; CLASSES],
            untidy: Cell::new(false),
        })
    }
    /// Whether the state can be thrown away without freeing its blocks one by one.
    pub(crate) fn is_mapped(&self) -> bool {
        !self.mapped.is_null()
    }
    /// Whether some bytes are of what was taken from the slot.
    pub(crate) fn holds(&self, at: *const u8, bytes: usize) -> bool {
        let end = (at as usize).saturating_add(bytes);
        self.is_mapped() && at >= self.base.cast_const() && end <= self.base as usize + self.top.get()
    }
    /// Sets the memory limit; 0: the whole slot.
    pub(crate) fn set_limit(&self, bytes: u64) {
        let bytes = usize::try_from(bytes).unwrap_or(SLOT_BYTES);
        self.limit.set(match bytes {
            0 => SLOT_BYTES,
            n => n.min(SLOT_BYTES),
        });
    }
    /// Bytes of large blocks that were taken since the last call.
    pub(crate) fn heavy(&self) -> u64 {
        self.heavy.replace(0)
    }
    /// The limit, bytes.
    pub(crate) fn limit(&self) -> usize {
        self.limit.get()
    }

    /// Everything in the slot; `None` where the system's allocator is used.
    pub(crate) fn backup(&self) -> Option<Backup> {
        if !self.is_mapped() {
            return None;
        }
        // SAFETY: all that was taken from the slot so far is committed.
        let bytes = unsafe { std::slice::from_raw_parts(self.base, self.top.get()) }.to_vec();
        let free = self.free.iter().map(Cell::get).collect();
        Some(Backup { bytes, used: self.used.get(), free })
    }

    /// Makes the slot what it was at the time of a backup, bit by bit.
    ///
    /// # Safety
    /// Nothing outside the slot points to what was taken from it since, and the state in it is idle.
    pub(crate) unsafe fn roll_back(&self, backup: &Backup) {
        copy_nonoverlapping(backup.bytes.as_ptr(), self.base, backup.bytes.len());
        self.top.set(backup.bytes.len());
        self.used.set(backup.used);
        for (list, first) in self.free.iter().zip(&backup.free) {
            list.set(*first);
        }
        self.untidy.set(true);
    }

    /// Brings the free blocks into order: those of low addresses are used first, those at the end of what is used are not
    /// used at all. So what a script works with stays close together, and so does what it throws away.
    pub(crate) fn tidy(&self) {
        // A script that makes no garbage gives back what it took, in order.
        if !self.is_mapped() || !self.untidy.replace(false) {
            return;
        }
        let mut blocks = Vec::new();
        for (c, list) in self.free.iter().enumerate() {
            let mut block = list.replace(null_mut());
            while !block.is_null() {
                blocks.push((block, c));
                // SAFETY: a free block holds the address of the next one.
                block = unsafe { *block.cast::<*mut u8>() };
            }
        }
        blocks.sort_unstable();
        // SAFETY: within the slot.
        let mut top = unsafe { self.base.add(self.top.get()) };
        while let Some((block, _)) = blocks.pop_if(|(block, c)| block.wrapping_add(size_of_class(*c)) == top) {
            top = block;
        }
        self.top.set(top as usize - self.base as usize);
        for (block, c) in blocks.into_iter().rev() {
            // SAFETY: free, and large enough for an address.
            unsafe { *block.cast::<*mut u8>() = self.free[c].get() };
            self.free[c].set(block);
        }
    }

    fn take(&self, bytes: usize, force: bool) -> *mut u8 {
        let (c, size) = class(bytes);
        let used = self.used.get() + size;
        if used > self.limit.get() && !force {
            self.tell_full();
            return null_mut();
        }
        let block = if !self.is_mapped() {
            // SAFETY: the size is not 0.
            Layout::from_size_align(size, 16).map_or(null_mut(), |l| unsafe { alloc(l) })
        } else if c < CLASSES && !self.free[c].get().is_null() {
            let block = self.free[c].get();
            // SAFETY: a free block holds the address of the next one.
            self.free[c].set(unsafe { *block.cast::<*mut u8>() });
            block
        } else {
            self.grow(size)
        };
        if !block.is_null() {
            self.used.set(used);
            if size >= HEAVY {
                self.heavy.set(self.heavy.get() + size as u64);
            }
        } else if !force {
            // What free blocks of other sizes hold is lost to this one.
            self.tell_full();
        }
        block
    }

    fn tell_full(&self) {
        if let Some((tell, whom)) = self.full.get() {
            // SAFETY: set by the state whose memory this is, which lives longer.
            unsafe { tell(whom) };
        }
    }

    fn grow(&self, size: usize) -> *mut u8 {
        let at = self.top.get();
        let end = at + size;
        if end > SLOT_BYTES {
            return null_mut();
        }
        let committed = self.committed.get();
        if end > committed {
            let more = (end - committed).next_multiple_of(COMMIT);
            // SAFETY: whole pages of the slot, which is a multiple of COMMIT long.
            if !unsafe { system::commit(self.base.add(committed), more) } {
                return null_mut();
            }
            self.committed.set(committed + more);
        }
        self.top.set(end);
        // SAFETY: within the slot.
        unsafe { self.base.add(at) }
    }

    /// # Safety
    /// `block` was taken with this size and is not used any more.
    unsafe fn give(&self, block: *mut u8, bytes: usize) {
        let (c, size) = class(bytes);
        self.used.set(self.used.get() - size);
        if self.is_mapped() {
            let next = self.free[c].get();
            let last = block.addr() + size == self.base.addr() + self.top.get();
            if last || (!next.is_null() && next < block) {
                self.untidy.set(true);
            }
            *block.cast::<*mut u8>() = next;
            self.free[c].set(block);
        } else {
            dealloc(block, Layout::from_size_align_unchecked(size, 16));
        }
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        if self.is_mapped() {
            // SAFETY: the state that lived here has ended.
            unsafe { system::free(self.mapped, ALIGN + SLOT_BYTES) };
        }
    }
}

/// Lua's allocation function.
///
/// # Safety
/// `slot` is the state's; `block` and `old` are what Lua got from here.
pub(crate) unsafe extern "C" fn lua_alloc(
    slot: *mut c_void,
    block: *mut c_void,
    old: usize,
    new: usize,
) -> *mut c_void {
    let slot = &*slot.cast::<Slot>();
    let block = block.cast::<u8>();
    if new == 0 {
        if !block.is_null() {
            slot.give(block, old);
        }
        return null_mut();
    }
    if block.is_null() {
        return slot.take(new, false).cast();
    }
    let (from, to) = (class(old), class(new));
    if from.0 == to.0 {
        return block.cast();
    }
    let shrinks = new < old;
    let fresh = slot.take(new, shrinks);
    if fresh.is_null() {
        if !shrinks {
            return null_mut();
        }
        // Lua relies on shrinking: the block goes on as a smaller one, its tail is lost until the state ends.
        if slot.is_mapped() {
            slot.used.set(slot.used.get() - from.1 + to.1);
        }
        return block.cast();
    }
    copy_nonoverlapping(block, fresh, old.min(new));
    slot.give(block, old);
    fresh.cast()
}

#[cfg(test)]
impl Slot {
    /// A slot with addresses of its own; `None`, and it is said, where there are none.
    pub(crate) fn in_test(seed: u64) -> Option<Box<Slot>> {
        let slot = Slot::new(seed);
        if !slot.is_mapped() {
            println!("skipped: this system reserves no address space");
        }
        slot.is_mapped().then_some(slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_hold_their_sizes() {
        let mut last = (0, 16);
        for bytes in 1..200_000 {
            let (c, size) = class(bytes);
            assert!(size >= bytes && size % 16 == 0 && size <= bytes * 5 / 4 + 16);
            assert_eq!(size, size_of_class(c));
            assert!((c, size) == last || (c == last.0 + 1 && size > last.1));
            last = (c, size);
        }
        assert!(class(SLOT_BYTES).0 < CLASSES);
    }

    #[test]
    fn addresses_repeat_and_the_limit_holds() {
        let run = || {
            let slot = Slot::new(7);
            let ud = (&raw const *slot).cast_mut().cast();
            slot.set_limit(1 << 20);
            let mut seen = Vec::new();
            // SAFETY: blocks are handed back with the sizes they have.
            unsafe {
                let a = lua_alloc(ud, null_mut(), 0, 100);
                let b = lua_alloc(ud, null_mut(), 0, 3000);
                let a = lua_alloc(ud, a, 100, 900);
                let c = lua_alloc(ud, null_mut(), 0, 100);
                seen.extend([a, b, c].map(|p| p as usize as u32));
                assert!(lua_alloc(ud, null_mut(), 0, 2 << 20).is_null());
                assert!(!lua_alloc(ud, b, 3000, 30).is_null());
            }
            (slot.is_mapped(), seen)
        };
        let (mapped, first) = run();
        if mapped {
            assert_eq!(first, run().1);
        } else {
            println!("skipped: this system reserves no address space");
        }
    }

    #[test]
    fn what_needs_no_tidying_is_left_alone() {
        let Some(slot) = Slot::in_test(5) else { return };
        let free = || slot.free.each_ref().map(Cell::get);
        // SAFETY: blocks are handed back with the sizes they have.
        unsafe {
            let all: Vec<_> = (0..6).map(|_| slot.take(100, false)).collect();
            assert!(!slot.untidy.get());
            // In order, and not at the end.
            slot.give(all[2], 100);
            slot.give(all[1], 100);
            assert!(!slot.untidy.get());
            let before = (free(), slot.top.get());
            slot.untidy.set(true);
            slot.tidy();
            assert_eq!((free(), slot.top.get()), before);
            slot.give(all[3], 100);
            assert!(slot.untidy.get(), "a higher one before a lower one");
            slot.tidy();
            assert_eq!([slot.take(100, false), slot.take(100, false), slot.take(100, false)], [all[1], all[2], all[3]]);
            assert!(!slot.untidy.get());
            slot.give(all[5], 100);
            assert!(slot.untidy.get(), "the last one");
        }
    }

    #[test]
    fn tidying_gives_the_end_back_and_low_addresses_first() {
        let Some(slot) = Slot::in_test(0) else { return };
        // SAFETY: blocks are handed back with the sizes they have.
        unsafe {
            let all: Vec<_> = (0..6).map(|_| slot.take(100, false)).collect();
            let end = slot.top.get();
            for i in [1, 0, 5, 4] {
                slot.give(all[i], 100);
            }
            slot.tidy();
            assert_eq!(slot.top.get(), end - 2 * class(100).1);
            assert_eq!([slot.take(100, false), slot.take(100, false), slot.take(100, false)], [all[0], all[1], all[4]]);
            assert_eq!(slot.used.get(), 5 * class(100).1);
        }
    }
}
