//! The frame of a call, which commands and scripts share: arguments, results, and the functions of the call.

use std::{mem::MaybeUninit, ops::Deref, ptr::null_mut};

use crate::abi::*;
use crate::safe::{
    Fail, ValueRef,
    value::{
        fail::bytes_of,
        owned::{Room, given},
    },
};

/// The frame of a call that runs for `'a`, with what it points to.
pub(crate) struct CallFrame<'a> {
    raw: &'a mut tatu_call,
    /// The world in which the call runs.
    pub world: WorldRef<'a>,
    /// The arguments.
    pub args: &'a [ValueRef<'a>],
    /// The caller's dialect, which is empty if it has none.
    pub dialect: &'a [u8],
}

impl Deref for CallFrame<'_> {
    type Target = tatu_call;
    fn deref(&self) -> &tatu_call {
        self.raw
    }
}

impl<'a> CallFrame<'a> {
    /// Wraps the frame that the host passed to a command or script.
    ///
    /// # Safety
    /// `raw` must point to the frame of a call by the host that lasts at least for `'a`; nothing else may use the frame
    /// within `'a`, except the functions to which it is passed.
    pub unsafe fn at(raw: *mut tatu_call) -> Self {
        // SAFETY: the caller guarantees a frame of the host, which keeps the world, the arguments and the dialect valid
        // during the call.
        unsafe {
            let raw = &mut *raw;
            let args = ValueRef::slice(raw.args, raw.n_args as usize);
            CallFrame { world: WorldRef::new(raw.world), args, dialect: bytes_of(raw.caller_dialect), raw }
        }
    }
    /// Returns the frame in the form of the ABI.
    pub fn ptr(&mut self) -> *mut tatu_call {
        self.raw
    }
    /// Returns the functions of the call.
    pub fn api(&self) -> Option<&'a tatu_call_api> {
        // SAFETY: the frame points to a table that lives as long as the call, or is null.
        unsafe { self.raw.api.as_ref() }
    }
    /// Returns the error that a function of the call has stored.
    pub fn fail(&self, status: tatu_status) -> Fail {
        // SAFETY: the frame's error is null or the host's error object of this call.
        unsafe { Fail::read(status, self.raw.error) }
    }
    /// Adds a result; returns whether there was room for it.
    ///
    /// # Safety
    /// Everything that `value` points to must stay valid until the caller has read it.
    #[inline]
    pub unsafe fn push(&mut self, value: tatu_value) -> bool {
        let fits = self.raw.n_results < self.raw.results_cap;
        if fits {
            // SAFETY: `results` points to an array of `results_cap` values that lives during the call, and `n_results`
            // is below that.
            unsafe { *self.raw.results.add(self.raw.n_results as usize) = value };
            self.raw.n_results += 1;
        }
        fits
    }
    /// Allocates memory for results, aligned to 8 bytes and valid until the results have been read. Returns null if
    /// there is not enough memory.
    pub fn alloc(&mut self, bytes: usize) -> *mut u8 {
        let Some(alloc) = self.api().and_then(|api| api.alloc) else { return null_mut() };
        // SAFETY: the function is that of this call, whose frame is passed to it.
        unsafe { alloc(self.raw, bytes as u64) }.cast()
    }
}

impl Room for CallFrame<'_> {
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]> {
        // SAFETY: `alloc` returns null or a pointer to 8-byte aligned memory of this size, which belongs to this call
        // alone and lives until its results have been read.
        unsafe { given(self.alloc(8 * n), n) }
    }
}
