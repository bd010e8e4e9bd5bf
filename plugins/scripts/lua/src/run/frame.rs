//! The frame of a call from a script to the host.

use std::mem::MaybeUninit;

use tatu_plugin_api::abi::*;

/// Number of results that fit on the native stack.
pub(super) const RESULTS: usize = 64;

/// A call frame with space for results; the host fills the other fields.
#[inline(always)]
pub(super) fn frame(results: &mut MaybeUninit<[tatu_value; RESULTS]>) -> tatu_call {
    // SAFETY: numbers and pointers, for which zero is a valid value. Copying a constant of this size would be a call.
    let mut frame: tatu_call = unsafe { std::mem::zeroed() };
    frame.size = size_of::<tatu_call>() as u32;
    frame.results = results.as_mut_ptr().cast();
    frame.results_cap = RESULTS as u32;
    frame
}
