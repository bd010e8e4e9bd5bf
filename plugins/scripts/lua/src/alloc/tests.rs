//! Tests of slots: addresses, size classes, order of reuse.

use super::*;

#[test]
fn size_classes_fit_their_blocks() {
    let mut last = (0, 16);
    for bytes in 1..200_000 {
        let (c, size) = size_class(bytes);
        assert!(size >= bytes && size % 16 == 0 && size <= bytes * 5 / 4 + 16);
        assert_eq!(size, size_of_class(c));
        assert!((c, size) == last || (c == last.0 + 1 && size > last.1));
        last = (c, size);
    }
    assert!(size_class(SLOT_BYTES).0 < SIZE_CLASSES);
}

#[test]
fn addresses_repeat_and_the_limit_is_enforced() {
    let run = || {
        let slot = MemorySlot::new(7);
        let ud = (&raw const *slot).cast_mut().cast();
        slot.set_limit(1 << 20);
        let mut seen = Vec::new();
        // SAFETY: `ud` points to `slot`, which outlives the block; each block is passed back with the size it was
        // allocated with.
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
        println!("skipped: this system cannot reserve address space");
    }
}

#[test]
fn sorted_free_lists_are_not_sorted_again() {
    let Some(slot) = MemorySlot::in_test(5) else { return };
    let free = || slot.free.each_ref().map(Cell::get);
    // SAFETY: each block is freed once, with the size it was allocated with, and not used afterwards.
    unsafe {
        let all: Vec<_> = (0..6).map(|_| slot.allocate(100, false, std::ptr::null())).collect();
        assert!(!slot.unsorted.get());
        // Free blocks out of order, but not at the end.
        slot.free_block(all[2], 100);
        slot.free_block(all[1], 100);
        assert!(!slot.unsorted.get());
        let before = (free(), slot.top.get());
        slot.unsorted.set(true);
        slot.sort_free_lists();
        assert_eq!((free(), slot.top.get()), before);
        slot.free_block(all[3], 100);
        assert!(slot.unsorted.get(), "a block was freed before one with a lower address");
        slot.sort_free_lists();
        assert_eq!(
            [
                slot.allocate(100, false, std::ptr::null()),
                slot.allocate(100, false, std::ptr::null()),
                slot.allocate(100, false, std::ptr::null())
            ],
            [all[1], all[2], all[3]]
        );
        assert!(!slot.unsorted.get());
        slot.free_block(all[5], 100);
        assert!(slot.unsorted.get(), "the last block was freed");
    }
}

#[test]
fn sorting_releases_the_end_and_reuses_low_addresses_first() {
    let Some(slot) = MemorySlot::in_test(0) else { return };
    // SAFETY: each block is freed once, with the size it was allocated with, and not used afterwards.
    unsafe {
        let all: Vec<_> = (0..6).map(|_| slot.allocate(100, false, std::ptr::null())).collect();
        let end = slot.top.get();
        for i in [1, 0, 5, 4] {
            slot.free_block(all[i], 100);
        }
        slot.sort_free_lists();
        assert_eq!(slot.top.get(), end - 2 * size_class(100).1);
        assert_eq!(
            [
                slot.allocate(100, false, std::ptr::null()),
                slot.allocate(100, false, std::ptr::null()),
                slot.allocate(100, false, std::ptr::null())
            ],
            [all[0], all[1], all[4]]
        );
        assert_eq!(slot.used.get(), 5 * size_class(100).1);
    }
}

#[test]
fn backup_restores_content_and_free_list_order() {
    let Some(slot) = MemorySlot::in_test(9) else { return };
    // SAFETY: blocks are written within their size and freed once with it; no state uses the slot during `roll_back`.
    unsafe {
        let all: Vec<_> = (0..50).map(|_| slot.allocate(3000, false, std::ptr::null())).collect();
        for (i, block) in all.iter().enumerate() {
            block.write_bytes(i as u8, 3000);
        }
        let backup = slot.backup();
        let top = slot.top.get();
        for (block, i) in all.iter().zip(0..) {
            block.write_bytes(0xAA, 3000);
            // Do not free the first three blocks.
            if i >= 3 {
                slot.free_block(*block, 3000);
            }
        }
        slot.sort_free_lists();
        assert_eq!(slot.top.get(), slot.offset(all[3]));
        // Roll back twice, to check that a rollback does not depend on the blocks' history.
        for _ in 0..2 {
            slot.roll_back(backup.as_ref().unwrap());
            assert_eq!(slot.top.get(), top);
            for (i, block) in all.iter().enumerate() {
                assert!(std::slice::from_raw_parts(*block, 3000).iter().all(|b| *b == i as u8));
            }
            let more = slot.allocate(3000, false, std::ptr::null());
            assert_eq!(slot.offset(more), top);
            slot.free_block(more, 3000);
        }
    }
}
