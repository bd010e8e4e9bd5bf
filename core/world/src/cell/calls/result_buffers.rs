//! Space for the results of a command, in memory of the host, with guards on both sides. A command that writes just
//! outside the space is detected, and does not damage the memory next to the caller's array.

use std::ptr::null_mut;

use tatu_plugin_api::abi::*;
use tatu_plugins::state_block::GUARD;

/// Maximum number of results for which there is guarded space. A command has less space if its caller provides less.
const MAX_GUARDED_RESULTS: usize = 64;
/// Number of guard values before the results.
const GUARDS_BEFORE: usize = 2;
/// Number of guard values after the results. They suffice if a command assumes that the space is twice as large.
const GUARDS_AFTER: usize = MAX_GUARDED_RESULTS + 8;

/// The space for the results of one call. It is a `Vec` because the address of the buffer does not change when the
/// `Vec` is moved. No reference to the buffer exists while the command writes.
pub(crate) struct GuardedResultBuffer(Vec<tatu_value>);

/// The caller's array, which is set aside while the command writes to the host's space.
pub(crate) struct CallerResultBuffer {
    results: *mut tatu_value,
    cap: u32,
    /// The host's space, or null if the command writes to the caller's array.
    own: *mut tatu_value,
}

const GUARD_VALUE: tatu_value =
    tatu_value { tag: GUARD as u32, reserved: (GUARD >> 32) as u32, u: tatu_payload { u: GUARD } };

impl GuardedResultBuffer {
    pub fn new() -> Self {
        GuardedResultBuffer(vec![GUARD_VALUE; GUARDS_BEFORE + MAX_GUARDED_RESULTS + GUARDS_AFTER])
    }
    /// Returns a pointer to the first result.
    pub fn first(&mut self) -> *mut tatu_value {
        self.0.as_mut_ptr().wrapping_add(GUARDS_BEFORE)
    }
}

impl CallerResultBuffer {
    /// Redirects the frame's results to `own`, with the capacity that the caller provides. If the capacity exceeds
    /// `MAX_GUARDED_RESULTS`, the caller's array is used directly, without guards.
    #[inline]
    pub fn redirect(f: &mut tatu_call, own: *mut tatu_value) -> CallerResultBuffer {
        let fits = f.results_cap as usize <= MAX_GUARDED_RESULTS;
        let room =
            CallerResultBuffer { results: f.results, cap: f.results_cap, own: if fits { own } else { null_mut() } };
        if fits {
            f.results = own;
            // SAFETY: `own` points to `MAX_GUARDED_RESULTS + GUARDS_AFTER` values that live during the call, and `cap
            // <= MAX_GUARDED_RESULTS`.
            unsafe { own.add(room.cap as usize).write(GUARD_VALUE) };
        }
        room
    }

    /// Restores the caller's array and copies the results into it. Returns whether the command stayed within the space
    /// for its results.
    #[inline]
    #[must_use]
    pub fn restore(self, f: &mut tatu_call) -> bool {
        (f.results, f.results_cap) = (self.results, self.cap);
        if self.own.is_null() {
            return true;
        }
        // SAFETY: `own` points to the first result of a space with `GUARDS_BEFORE` guards before it and
        // `MAX_GUARDED_RESULTS + GUARDS_AFTER` values after it, which live as long as the world. The caller's array has
        // room for `cap` values, lives during the call, and does not overlap that space.
        unsafe {
            let whole = is_guard(self.own.sub(1)) && is_guard(self.own.add(self.cap as usize));
            if !whole {
                self.own
                    .sub(GUARDS_BEFORE)
                    .copy_from_nonoverlapping([GUARD_VALUE; GUARDS_BEFORE].as_ptr(), GUARDS_BEFORE);
                self.own
                    .add(MAX_GUARDED_RESULTS)
                    .copy_from_nonoverlapping([GUARD_VALUE; GUARDS_AFTER].as_ptr(), GUARDS_AFTER);
            }
            let n = f.n_results.min(self.cap) as usize;
            if n > 0 {
                self.results.copy_from_nonoverlapping(self.own, n);
            }
            // A later command may count a result without writing it. It must not return a result of this command in
            // that case.
            for i in 0..n {
                self.own.add(i).write(GUARD_VALUE);
            }
            whole
        }
    }
}

/// Returns whether the value at `at` is an intact guard.
///
/// # Safety
/// `at` must point to an initialised value.
#[inline]
unsafe fn is_guard(at: *const tatu_value) -> bool {
    // SAFETY: the caller guarantees that `at` points to an initialised value; all members of the payload union are
    // plain data, and every bit pattern is a valid `u64`.
    unsafe { (*at).tag == GUARD_VALUE.tag && (*at).reserved == GUARD_VALUE.reserved && (*at).u.u == GUARD }
}
