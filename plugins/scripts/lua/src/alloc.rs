//! Memory of a Lua state: a slot of its own, whose addresses have the same low 32 bits in every run.
//!
//! Lua hashes tables, functions and threads by the low 32 bits of their addresses; the order in which `pairs` visits
//! such keys is therefore the same in each run only if these bits are. A slot has two parts: a place beside those of other
//! states (`near`) and, for what does not fit in there, address space that begins at a multiple of 4 GiB. What lies where
//! depends only on the script and on what it does. The allocator keeps one free list per size class and takes new blocks
//! from the end; blocks are never split or joined. Where the system reserves no address space the system's allocator takes
//! over, and only that order is lost.

mod near;
mod region;
#[cfg(test)]
mod tests;

use std::{
    alloc::{Layout, alloc, dealloc},
    cell::{Cell, OnceCell},
    ffi::c_void,
    ops::Range,
    ptr::{copy_nonoverlapping, null_mut},
};

use crate::system;
use near::{PLACE, Place};
use region::Region;

/// Bytes of a slot, and the memory limit of a script that is given none.
pub(crate) const SLOT_BYTES: usize = 256 << 20;
/// Below the size of a huge page, so that a small state does not get one.
const COMMIT: usize = 256 << 10;
const SMALL: usize = 512;
/// From this size on filling a block takes longer than the instruction that asked for it.
const HEAVY: usize = 4096;
/// Bytes of a cache line, and at how many lines a slot may begin.
const LINE: usize = 64;
const COLOURS: u64 = 64;
const CLASSES: usize = 32 + 4 * 20;

/// A function, and what it is called with.
pub(crate) type Listener = (unsafe fn(*const c_void), *const c_void);

/// The memory of one state. Boxed: Lua keeps its address.
pub(crate) struct Slot {
    /// Where its first bytes are; none: the system's allocator is used.
    near: Option<Place>,
    /// The rest, once it is needed; what would lie in its first bytes lies in the place.
    far: OnceCell<Region>,
    /// Bytes that are in use, of both parts.
    top: Cell<usize>,
    /// Those of the first part, once it was too small.
    near_top: Cell<usize>,
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
    near: Vec<u8>,
    far: Vec<u8>,
    near_top: usize,
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
        // By other bits of the seed than its place.
        let colour = (seed >> 32) % COLOURS;
        Box::new(Slot {
            near: Place::take(seed),
            far: OnceCell::new(),
            top: Cell::new(colour as usize * LINE),
            near_top: Cell::new(0),
            committed: Cell::new(PLACE),
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
        self.near.is_some()
    }
    /// Whether some bytes are of what was taken from the slot.
    pub(crate) fn holds(&self, at: *const u8, bytes: usize) -> bool {
        let from = self.offset(at);
        let end = if from < PLACE { self.top.get().min(PLACE) } else { self.top.get() };
        self.is_mapped() && from.checked_add(bytes).is_some_and(|e| e <= end)
    }
    /// How far into the slot an address is; beyond its end if it is elsewhere.
    fn offset(&self, at: *const u8) -> usize {
        let from = |base: *mut u8| at.addr().wrapping_sub(base.addr());
        let near = self.near.as_ref().map_or(usize::MAX, |near| from(near.base));
        let far = from(self.far_base());
        match near < PLACE {
            true => near,
            false if far >= PLACE => far,
            false => usize::MAX,
        }
    }
    /// The address of a byte of the slot.
    fn address(&self, offset: usize) -> *mut u8 {
        let base = match &self.near {
            Some(near) if offset < PLACE => near.base,
            _ => self.far_base(),
        };
        base.wrapping_add(offset)
    }
    /// Null while there is no second part.
    fn far_base(&self) -> *mut u8 {
        self.far.get().map_or(null_mut(), |far| far.base)
    }
    /// What is in use of the first part and of the other.
    fn parts(&self) -> [Range<usize>; 2] {
        let top = self.top.get();
        [0..top.min(PLACE), PLACE..top.max(PLACE)]
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
        let copy = |part: Range<usize>| match part.len() {
            0 => Vec::new(),
            // SAFETY: all that was taken from the slot so far is committed.
            n => unsafe { std::slice::from_raw_parts(self.address(part.start), n) }.to_vec(),
        };
        let [near, far] = self.parts().map(copy);
        let free = self.free.iter().map(Cell::get).collect();
        Some(Backup { near, far, near_top: self.near_top.get(), used: self.used.get(), free })
    }

    /// Makes the slot what it was at the time of a backup, bit by bit.
    ///
    /// # Safety
    /// Nothing outside the slot points to what was taken from it since, and the state in it is idle.
    pub(crate) unsafe fn roll_back(&self, backup: &Backup) {
        self.top.set(backup.near.len() + backup.far.len());
        self.near_top.set(backup.near_top);
        self.used.set(backup.used);
        for (part, bytes) in self.parts().into_iter().zip([&backup.near, &backup.far]) {
            if !bytes.is_empty() {
                copy_nonoverlapping(bytes.as_ptr(), self.address(part.start), bytes.len());
            }
        }
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
                blocks.push((self.offset(block), c));
                // SAFETY: a free block holds the address of the next one.
                block = unsafe { *block.cast::<*mut u8>() };
            }
        }
        blocks.sort_unstable();
        let mut top = self.top.get();
        while let Some((block, _)) = blocks.pop_if(|(block, c)| *block + size_of_class(*c) == top) {
            // What the first part could not take is free again.
            top = if block == PLACE { self.near_top.get() } else { block };
        }
        self.top.set(top);
        for (block, c) in blocks.into_iter().rev() {
            let block = self.address(block);
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
        let mut at = self.top.get();
        if at <= PLACE && at + size > PLACE {
            if !self.has_far() {
                return null_mut();
            }
            self.near_top.set(at);
            at = PLACE;
        }
        let end = at + size;
        if end > SLOT_BYTES {
            return null_mut();
        }
        let committed = self.committed.get();
        if end > committed {
            let more = (end - committed).next_multiple_of(COMMIT).min(SLOT_BYTES - committed);
            // SAFETY: whole pages of the slot.
            if !unsafe { system::commit(self.far_base().add(committed), more) } {
                return null_mut();
            }
            self.committed.set(committed + more);
        }
        self.top.set(end);
        self.address(at)
    }

    /// Gets address space for what the first part cannot take; whether there is some.
    #[cold]
    fn has_far(&self) -> bool {
        self.far.get().is_some() || Region::new(SLOT_BYTES).is_some_and(|new| self.far.set(new).is_ok())
    }

    /// # Safety
    /// `block` was taken with this size and is not used any more.
    unsafe fn give(&self, block: *mut u8, bytes: usize) {
        let (c, size) = class(bytes);
        self.used.set(self.used.get() - size);
        if self.is_mapped() {
            let next = self.free[c].get();
            let at = self.offset(block);
            let last = at + size == self.top.get();
            if last || (!next.is_null() && self.offset(next) < at) {
                self.untidy.set(true);
            }
            *block.cast::<*mut u8>() = next;
            self.free[c].set(block);
        } else {
            dealloc(block, Layout::from_size_align_unchecked(size, 16));
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
