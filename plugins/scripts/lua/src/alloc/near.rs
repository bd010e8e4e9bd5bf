//! Places for small states, side by side in large pages of memory.
//!
//! A call touches some twenty pages of a state. Where a thousand states have pages of their own, the processor looks up
//! nearly each of them anew in each step, and each call begins with a wait. Fourteen states fill one large page.
//! Which of its places a state gets follows from the state alone, so that the low bits of addresses are the same in every
//! run; which page it is does not matter, since all begin at a multiple of 4 GiB.

use std::sync::{Mutex, PoisonError};

use super::region::Region;
use crate::system;

/// Bytes of a place: what a state with a small script needs (128 KiB), and some more.
pub(super) const PLACE: usize = 144 << 10;
const PAGE: usize = 2 << 20;
const PLACES: usize = PAGE / PLACE;
/// A page that so many states share is worth its memory.
const SHARED: u32 = 10;

/// A page, and which of its places are taken.
struct Page {
    region: Region,
    taken: u32,
}

static PAGES: Mutex<Vec<Page>> = Mutex::new(Vec::new());

/// A place, until it is dropped.
pub(super) struct Place {
    page: *mut u8,
    bit: u32,
    pub base: *mut u8,
}

impl Place {
    /// The place for a seed; `None` where the system reserves no address space.
    pub fn take(seed: u64) -> Option<Place> {
        let place = (seed % PLACES as u64) as usize;
        let bit = 1 << place;
        let mut pages = PAGES.lock().unwrap_or_else(PoisonError::into_inner);
        let at = match pages.iter().position(|page| page.taken & bit == 0) {
            Some(at) => at,
            None => {
                pages.push(Page::new()?);
                pages.len() - 1
            }
        };
        let page = &mut pages[at];
        page.taken |= bit;
        if page.taken.count_ones() == SHARED {
            // SAFETY: a page of ours. Where it is refused the states have small pages.
            unsafe { system::make_large(page.region.base, PAGE) };
        }
        let page = page.region.base;
        Some(Place { page, bit, base: page.wrapping_add(place * PLACE) })
    }
}

impl Page {
    fn new() -> Option<Page> {
        let region = Region::new(PAGE)?;
        // SAFETY: whole pages of the region.
        unsafe { system::commit(region.base, PAGE) }.then_some(Page { region, taken: 0 })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut pages = PAGES.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(at) = pages.iter().position(|page| page.region.base == self.page) else { return };
        pages[at].taken &= !self.bit;
        if pages[at].taken == 0 {
            pages.remove(at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_one_seed_differ_in_their_pages_alone() {
        let (Some(a), Some(b), Some(c)) = (Place::take(3), Place::take(3), Place::take(4)) else {
            println!("skipped: this system reserves no address space");
            return;
        };
        let low = |place: &Place| place.base as usize as u32;
        assert_ne!(a.base, b.base);
        assert_eq!(low(&a), low(&b));
        assert_eq!(low(&c), low(&a) + PLACE as u32);
        assert_eq!(low(&a) as usize, 3 * PLACE);
    }

    #[test]
    fn what_lies_in_a_page_stays_when_it_is_made_large_and_when_others_go() {
        let places: Vec<_> = (0..3 * PLACES as u64).map_while(Place::take).collect();
        if places.is_empty() {
            println!("skipped: this system reserves no address space");
            return;
        }
        assert_eq!(places.len(), 3 * PLACES);
        // SAFETY: within places.
        let write = |place: &Place, n: u8| unsafe { place.base.write_bytes(n, PLACE) };
        places.iter().zip(1..).for_each(|(place, n)| write(place, n));
        let more: Vec<_> = (0..2 * PLACES as u64).map_while(Place::take).collect();
        more.iter().for_each(|place| write(place, 0xEE));
        drop(more);
        for (place, n) in places.iter().zip(1..) {
            // SAFETY: as above.
            let bytes = unsafe { std::slice::from_raw_parts(place.base, PLACE) };
            assert!(bytes.iter().all(|b| *b == n));
        }
    }
}
