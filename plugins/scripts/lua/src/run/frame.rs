//! The frame of a call from a script to the host.

use std::mem::MaybeUninit;

use tatu_plugin_api::abi::*;

/// Maximum number of results, which are stored on the native stack.
pub(super) const MAX_RESULTS: usize = 64;

/// Returns a call frame with space for results; all other fields are zero, to be set by the caller and the host.
#[inline(always)]
pub(super) fn frame(results: &mut MaybeUninit<[tatu_value; MAX_RESULTS]>) -> tatu_call {
    // SAFETY: `tatu_call` consists of numbers, raw pointers and optional function pointers, for which all-zero bytes
    // are valid. (Zeroing is inlined; copying a constant of this size would be a function call.)
    let mut frame: tatu_call = unsafe { std::mem::zeroed() };
    frame.size = size_of::<tatu_call>() as u32;
    frame.results = results.as_mut_ptr().cast();
    frame.results_cap = MAX_RESULTS as u32;
    frame
}
