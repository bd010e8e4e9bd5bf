//! Space for the results of a command, in memory of the host, with guards on both sides. A command that writes just
//! outside the space is detected, and does not damage the memory next to the caller's array.

use std::ptr::null_mut;

use tatu_plugin_api::abi::*;
use tatu_plugins::state_block::GUARD;

/// Maximum number of results for which there is guarded space. A command has less space if its caller provides less.
const MOST: usize = 64;
/// Number of guard values before the results.
const FRONT: usize = 2;
/// Number of guard values after the results. They suffice if a command assumes that the space is twice as large.
const BACK: usize = MOST + 8;

/// The space for the results of one call. It is a `Vec` because the address of the buffer does not change when the
/// `Vec` is moved. No reference to the buffer exists while the command writes.
pub(crate) struct ResultsRoom(Vec<tatu_value>);

/// The caller's array, which is set aside while the command writes to the host's space.
pub(crate) struct CallersRoom {
    results: *mut tatu_value,
    cap: u32,
    /// The host's space, or null if the command writes to the caller's array.
    own: *mut tatu_value,
}

const GUARDS: tatu_value =
    tatu_value { tag: GUARD as u32, reserved: (GUARD >> 32) as u32, u: tatu_payload { u: GUARD } };

impl ResultsRoom {
    pub fn new() -> Self {
        ResultsRoom(vec![GUARDS; FRONT + MOST + BACK])
    }
    /// Returns a pointer to the first result.
    pub fn first(&mut self) -> *mut tatu_value {
        self.0.as_mut_ptr().wrapping_add(FRONT)
    }
}

impl CallersRoom {
    /// Redirects the frame's results to `own`, with the capacity that the caller provides. If the capacity exceeds
    /// `MOST`, the caller's array is used directly, without guards.
    #[inline]
    pub fn put_aside(f: &mut tatu_call, own: *mut tatu_value) -> CallersRoom {
        let fits = f.results_cap as usize <= MOST;
        let room = CallersRoom { results: f.results, cap: f.results_cap, own: if fits { own } else { null_mut() } };
        if fits {
            f.results = own;
            // SAFETY: `own` points to `MOST + BACK` values that live during the call, and `cap <= MOST`.
            unsafe { own.add(room.cap as usize).write(GUARDS) };
        }
        room
    }

    /// Restores the caller's array and copies the results into it. Returns whether the command stayed within the space
    /// for its results.
    #[inline]
    #[must_use]
    pub fn give_back(self, f: &mut tatu_call) -> bool {
        (f.results, f.results_cap) = (self.results, self.cap);
        if self.own.is_null() {
            return true;
        }
        // SAFETY: `own` points to the first result of a space with `FRONT` guards before it and `MOST + BACK` values
        // after it, which live as long as the world. The caller's array has room for `cap` values, lives during the
        // call, and does not overlap that space.
        unsafe {
            let whole = is_guard(self.own.sub(1)) && is_guard(self.own.add(self.cap as usize));
            if !whole {
                self.own.sub(FRONT).copy_from_nonoverlapping([GUARDS; FRONT].as_ptr(), FRONT);
                self.own.add(MOST).copy_from_nonoverlapping([GUARDS; BACK].as_ptr(), BACK);
            }
            let n = f.n_results.min(self.cap) as usize;
            if n > 0 {
                self.results.copy_from_nonoverlapping(self.own, n);
            }
            // A later command may count a result without writing it. It must not return a result of this command in
            // that case.
            for i in 0..n {
                self.own.add(i).write(GUARDS);
            }
            whole
        }
    }
}

/// # Safety
/// `at` must point to an initialised value.
#[inline]
unsafe fn is_guard(at: *const tatu_value) -> bool {
    // SAFETY: the caller guarantees that `at` points to an initialised value; all members of the payload union are
    // plain data, and every bit pattern is a valid `u64`.
    unsafe { (*at).tag == GUARDS.tag && (*at).reserved == GUARDS.reserved && (*at).u.u == GUARD }
}
