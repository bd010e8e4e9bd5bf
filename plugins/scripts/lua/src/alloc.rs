//! Allocator of a Lua state: a slot of reserved address space in which addresses have the same low 32 bits in every
//! run.
//!
//! Lua hashes tables, functions and threads by the low 32 bits of their addresses, so the order in which `pairs` visits
//! such keys is reproducible only if these bits are reproducible. Every slot begins at a multiple of 4 GiB, and the
//! position of blocks in it depends only on the script. There is one free list per size class; new blocks are allocated
//! at the end; blocks are never split or merged. If the system cannot reserve address space, the system's allocator is
//! used, and the order of such keys is not reproducible.

mod region;
#[cfg(test)]
mod tests;

use std::{
    alloc::{Layout, alloc, dealloc},
    cell::Cell,
    ffi::c_void,
    ptr::{copy_nonoverlapping, null_mut},
};

use crate::system;
use region::Region;

/// Size of a slot, and default memory limit of a script.
pub(crate) const SLOT_BYTES: usize = 256 << 20;
/// Number of bytes committed at a time; less than a huge page, so that a small state does not occupy one.
const COMMIT_BYTES: usize = 256 << 10;
const MAX_SMALL_BLOCK_BYTES: usize = 512;
/// Minimum size, in bytes, of blocks of which each byte is charged: filling such a block takes longer than the
/// instruction that allocates it.
const MIN_CHARGED_BLOCK_BYTES: usize = 4096;
/// Number of cache lines at the start of a slot; the first block begins at one of them, chosen by the seed.
const START_LINES: u64 = 4096;
const CACHE_LINE_BYTES: usize = 64;
const SIZE_CLASSES: usize = 32 + 4 * 20;

/// A callback and its argument. The callback also receives the block that could not grow, or null for a new block.
pub(crate) type FullCallback = (unsafe fn(*const c_void, *const u8), *const c_void);

/// The memory of a state. It is boxed because Lua stores its address.
pub(crate) struct MemorySlot {
    /// The reserved address space, or `None` if the system's allocator is used.
    region: Option<Region>,
    /// Offset of the first block.
    first: usize,
    /// Offset of the end of the last block.
    top: Cell<usize>,
    committed: Cell<usize>,
    used: Cell<usize>,
    limit: Cell<usize>,
    /// Whether the system refused memory before the limit was reached.
    refused: Cell<bool>,
    /// Called when an allocation fails, because it would exceed the memory limit or because the system refuses memory.
    pub full: Cell<Option<FullCallback>>,
    free: [Cell<*mut u8>; SIZE_CLASSES],
    /// Whether the free lists may be unsorted, or there may be free blocks at the end.
    unsorted: Cell<bool>,
}

/// A copy of the content of a slot, with its free lists.
pub(crate) struct Backup {
    content: Vec<u8>,
    used: usize,
    free: Vec<*mut u8>,
}

/// Returns the size class for `bytes`, and the block size of that class. Small classes differ by 16 bytes; above
/// `MAX_SMALL_BLOCK_BYTES`, there are four classes per power of two.
fn size_class(bytes: usize) -> (usize, usize) {
    if bytes <= MAX_SMALL_BLOCK_BYTES {
        let c = bytes.div_ceil(16).max(1);
        return (c - 1, c * 16);
    }
    let k = (bytes - 1).ilog2() as usize;
    let quarter = ((bytes - 1) >> (k - 2)) & 3;
    (32 + (k - 9) * 4 + quarter, (1 << k) + ((quarter + 1) << (k - 2)))
}

/// Returns the block size of a class.
fn size_of_class(c: usize) -> usize {
    match c.checked_sub(32) {
        None => (c + 1) * 16,
        Some(c) => (MAX_SMALL_BLOCK_BYTES << (c / 4)) + ((c % 4 + 1) << (c / 4 + 7)),
    }
}

impl MemorySlot {
    /// Creates a slot whose first block is at an offset derived from `seed`. All slots begin at a multiple of 4 GiB, so
    /// without the offset, corresponding blocks of all states would compete for the same cache sets.
    pub(crate) fn new(seed: u64) -> Box<MemorySlot> {
        let first = (seed % START_LINES) as usize * CACHE_LINE_BYTES;
        Box::new(MemorySlot {
            region: Region::new(SLOT_BYTES),
            first,
            top: Cell::new(first),
            committed: Cell::new(0),
            used: Cell::new(0),
            limit: Cell::new(SLOT_BYTES),
            refused: Cell::new(false),
            full: Cell::new(None),
            free: [const { Cell::new(null_mut()) }; SIZE_CLASSES],
            unsorted: Cell::new(false),
        })
    }
    /// Returns whether a state can be discarded without freeing its blocks one by one.
    pub(crate) fn is_mapped(&self) -> bool {
        self.region.is_some()
    }
    fn base(&self) -> *mut u8 {
        self.region.as_ref().map_or(null_mut(), |region| region.base)
    }
    /// Returns the offset of a block in the slot.
    fn offset(&self, block: *const u8) -> usize {
        block.addr() - self.base().addr()
    }
    /// Sets the memory limit; 0, and larger values than the size of the slot, set it to the size of the slot.
    pub(crate) fn set_limit(&self, bytes: u64) {
        let bytes = usize::try_from(bytes).unwrap_or(SLOT_BYTES);
        self.limit.set(match bytes {
            0 => SLOT_BYTES,
            n => n.min(SLOT_BYTES),
        });
    }
    /// Returns whether the system refused memory before the limit was reached, and resets this flag.
    pub(crate) fn take_refused(&self) -> bool {
        self.refused.replace(false)
    }
    /// Returns the number of bytes in use.
    pub(crate) fn used(&self) -> usize {
        self.used.get()
    }
    /// Returns the memory limit, in bytes.
    pub(crate) fn limit(&self) -> usize {
        self.limit.get()
    }

    /// Copies the content of the slot. Returns `None` if the system's allocator is used.
    pub(crate) fn backup(&self) -> Option<Backup> {
        if !self.is_mapped() {
            return None;
        }
        // SAFETY: the slot is mapped, `first <= top`, and `extend` has committed all bytes below `top`; nothing writes
        // to them while the slice exists, because the state is used by one thread only.
        let content = unsafe { std::slice::from_raw_parts(self.base().add(self.first), self.top.get() - self.first) };
        let free = self.free.iter().map(Cell::get).collect();
        Some(Backup { content: content.to_vec(), used: self.used.get(), free })
    }

    /// Restores a backup exactly.
    ///
    /// # Safety
    /// Nothing outside the slot may point to blocks allocated since the backup, and the state must be idle.
    pub(crate) unsafe fn roll_back(&self, backup: &Backup) {
        self.top.set(self.first + backup.content.len());
        self.used.set(backup.used);
        copy_nonoverlapping(backup.content.as_ptr(), self.base().add(self.first), backup.content.len());
        for (list, first) in self.free.iter().zip(&backup.free) {
            list.set(*first);
        }
        self.unsorted.set(true);
    }

    /// Sorts the free lists so that low addresses are reused first, and releases free blocks at the end, so that a
    /// script's memory stays compact.
    pub(crate) fn sort_free_lists(&self) {
        // In scripts without garbage, the lists are already sorted.
        if !self.is_mapped() || !self.unsorted.replace(false) {
            return;
        }
        let mut blocks = Vec::new();
        for (c, list) in self.free.iter().enumerate() {
            let mut block = list.replace(null_mut());
            while !block.is_null() {
                blocks.push((self.offset(block), c));
                // SAFETY: `block` is on a free list, so `free_block` or this function wrote the address of the next
                // block into its first bytes.
                block = unsafe { *block.cast::<*mut u8>() };
            }
        }
        blocks.sort_unstable();
        let mut top = self.top.get();
        while let Some((block, _)) = blocks.pop_if(|(block, c)| *block + size_of_class(*c) == top) {
            top = block;
        }
        self.top.set(top);
        for (block, c) in blocks.into_iter().rev() {
            let block = self.base().wrapping_add(block);
            // SAFETY: the block is free and committed, begins at a multiple of 16, and the smallest class has 16 bytes,
            // so an address fits.
            unsafe { *block.cast::<*mut u8>() = self.free[c].get() };
            self.free[c].set(block);
        }
    }

    /// Allocates a block; returns null if it would exceed the limit or the system refuses it. `force` ignores the
    /// limit. `grown` is the block to be replaced, or null for a new one.
    fn allocate(&self, bytes: usize, force: bool, grown: *const u8) -> *mut u8 {
        let (c, size) = size_class(bytes);
        let used = self.used.get() + size;
        if used > self.limit.get() && !force {
            self.report_full(grown);
            return null_mut();
        }
        let block = if !self.is_mapped() {
            // SAFETY: the layout's size is that of a size class, which is never 0.
            Layout::from_size_align(size, 16).map_or(null_mut(), |l| unsafe { alloc(l) })
        } else if c < SIZE_CLASSES && !self.free[c].get().is_null() {
            let block = self.free[c].get();
            // SAFETY: `block` is on a free list, so `free_block` or `sort_free_lists` wrote the address of the next
            // block into its first bytes.
            self.free[c].set(unsafe { *block.cast::<*mut u8>() });
            block
        } else {
            self.extend(size)
        };
        if !block.is_null() {
            self.used.set(used);
            if size >= MIN_CHARGED_BLOCK_BYTES {
                crate::lua_internals::count_here(size as u64);
            }
        } else if !force {
            self.refused.set(self.refused.get() || !self.is_mapped());
            // Free blocks of other size classes cannot be used for this one.
            self.report_full(grown);
        }
        block
    }

    fn report_full(&self, grown: *const u8) {
        if let Some((callback, argument)) = self.full.get() {
            // SAFETY: the state that set the callback owns this slot and is the callback's argument, so it is alive
            // while the slot allocates.
            unsafe { callback(argument, grown) };
        }
    }

    fn extend(&self, size: usize) -> *mut u8 {
        let at = self.top.get();
        let end = at + size;
        if end > SLOT_BYTES {
            return null_mut();
        }
        let committed = self.committed.get();
        if end > committed {
            let more = (end - committed).next_multiple_of(COMMIT_BYTES).min(SLOT_BYTES - committed);
            // SAFETY: `committed` and `more` are multiples of the page size, and their sum is at most SLOT_BYTES, the
            // size of the reserved region.
            if !unsafe { system::commit(self.base().add(committed), more) } {
                self.refused.set(true);
                return null_mut();
            }
            self.committed.set(committed + more);
        }
        self.top.set(end);
        self.base().wrapping_add(at)
    }

    /// # Safety
    /// `block` must have been allocated with this size, and must not be used any more.
    unsafe fn free_block(&self, block: *mut u8, bytes: usize) {
        let (c, size) = size_class(bytes);
        self.used.set(self.used.get() - size);
        if self.is_mapped() {
            let next = self.free[c].get();
            let at = self.offset(block);
            let last = at + size == self.top.get();
            if last || (!next.is_null() && self.offset(next) < at) {
                self.unsorted.set(true);
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
/// `slot` must be the slot of the calling state; `block` must be null or returned by this function for `old` bytes.
pub(crate) unsafe extern "C" fn lua_alloc(
    slot: *mut c_void,
    block: *mut c_void,
    old: usize,
    new: usize,
) -> *mut c_void {
    let slot = &*slot.cast::<MemorySlot>();
    let block = block.cast::<u8>();
    if new == 0 {
        if !block.is_null() {
            slot.free_block(block, old);
        }
        return null_mut();
    }
    if block.is_null() {
        return slot.allocate(new, false, block).cast();
    }
    let (from, to) = (size_class(old), size_class(new));
    if from.0 == to.0 {
        return block.cast();
    }
    let shrinks = new < old;
    let fresh = slot.allocate(new, shrinks, block);
    if fresh.is_null() {
        if !shrinks {
            return null_mut();
        }
        // Lua requires that shrinking succeeds. The block keeps its address and gets the smaller size; its tail is
        // lost.
        if slot.is_mapped() {
            slot.used.set(slot.used.get() - from.1 + to.1);
        }
        return block.cast();
    }
    copy_nonoverlapping(block, fresh, old.min(new));
    slot.free_block(block, old);
    fresh.cast()
}

#[cfg(test)]
impl MemorySlot {
    /// Creates a mapped slot; prints a message and returns `None` if the system cannot reserve address space.
    pub(crate) fn in_test(seed: u64) -> Option<Box<MemorySlot>> {
        let slot = MemorySlot::new(seed);
        if !slot.is_mapped() {
            println!("skipped: this system cannot reserve address space");
        }
        slot.is_mapped().then_some(slot)
    }
}
