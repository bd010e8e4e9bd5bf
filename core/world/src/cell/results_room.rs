//! Memory for the results of a command: always the host's own, with a guard on each side. A command that writes out of
//! bounds is blamed itself, and does not damage what its caller keeps beside its own array.

use std::ptr::null_mut;

use tatu_plugin_api::abi::*;
use tatu_plugins::state_block::GUARD;

/// Results that a command has room for at most, if its caller has as much.
const MOST: usize = 64;
/// Values on each side: enough for mistaking the room for one twice as large.
const FRONT: usize = 2;
const BACK: usize = MOST + 8;

/// Of one call. A `Vec`, for its pointer stays when it is moved. Nobody borrows it while the command writes.
pub(crate) struct ResultsRoom(Vec<tatu_value>);

/// The array of a caller, put aside while the command writes to the host's.
pub(crate) struct CallersRoom {
    results: *mut tatu_value,
    cap: u32,
    /// The command's; null: it writes to the caller's.
    own: *mut tatu_value,
}

const GUARDS: tatu_value =
    tatu_value { tag: GUARD as u32, reserved: (GUARD >> 32) as u32, u: tatu_payload { u: GUARD } };

impl ResultsRoom {
    pub fn new() -> Self {
        ResultsRoom(vec![GUARDS; FRONT + MOST + BACK])
    }
    /// The first result.
    pub fn first(&mut self) -> *mut tatu_value {
        self.0.as_mut_ptr().wrapping_add(FRONT)
    }
}

impl CallersRoom {
    /// Provides room for the frame's command in `own`, as much as its caller has. A caller with room for more gets no
    /// guards.
    #[inline]
    pub fn put_aside(f: &mut tatu_call, own: *mut tatu_value) -> CallersRoom {
        let fits = f.results_cap as usize <= MOST;
        let room = CallersRoom { results: f.results, cap: f.results_cap, own: if fits { own } else { null_mut() } };
        if fits {
            f.results = own;
            // SAFETY: within the room or its guards.
            unsafe { own.add(room.cap as usize).write(GUARDS) };
        }
        room
    }

    /// Restores the caller's array, with the results in it; returns whether the command kept within its room.
    #[inline]
    #[must_use]
    pub fn give_back(self, f: &mut tatu_call) -> bool {
        (f.results, f.results_cap) = (self.results, self.cap);
        if self.own.is_null() {
            return true;
        }
        // SAFETY: the host's room with its guards; the caller's array has room for `cap`, and is another one.
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
            // What a later command counts as a result and does not write is of no type, not what this one left.
            for i in 0..n {
                self.own.add(i).write(GUARDS);
            }
            whole
        }
    }
}

/// # Safety
/// A value of the room.
#[inline]
unsafe fn is_guard(at: *const tatu_value) -> bool {
    // SAFETY: the caller promises it; the payload is read as the number that any bits are.
    unsafe { (*at).tag == GUARDS.tag && (*at).reserved == GUARDS.reserved && (*at).u.u == GUARD }
}
