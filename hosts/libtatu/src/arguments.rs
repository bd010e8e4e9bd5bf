//! Reads the arguments that callers pass, and writes results through their pointers.
//!
//! Strings and places for single results have types that are pointers in C, so that functions with only such arguments
//! need no `unsafe`; arrays, which C passes as a pointer and a count, are converted here.

use std::mem::MaybeUninit;

use tatu_plugin_api::{
    abi::{LentCStr, tatu_value},
    safe::{Value, ValueRef},
};

use crate::answer::CallError;

/// The place of a result, or null. It need not be initialised.
pub type Out<'a, T> = Option<&'a mut MaybeUninit<T>>;

/// Returns a C string that the caller passes. Fails if it is null or not UTF-8; the message refers to it as `what`.
pub fn text<'a>(text: LentCStr<'a>, what: &str) -> Result<&'a str, CallError> {
    let text = text.get().ok_or_else(|| CallError::argument(format!("{what} is null")))?;
    text.to_str().map_err(|_| CallError::argument(format!("{what} is not UTF-8")))
}

/// Writes a result to `out`, unless `out` is null.
pub fn write_out<T>(out: Out<'_, T>, value: T) {
    if let Some(out) = out {
        out.write(value);
    }
}

/// Copies as many results as fit into an array of the caller, unless it is null.
///
/// # Safety
/// `out` must be null or have room for `cap` elements.
pub unsafe fn write_all<T: Copy>(out: *mut T, cap: usize, results: &[T]) {
    if !out.is_null() {
        // SAFETY: the caller guarantees room for `cap` elements. They cannot overlap `results`, which the library owns.
        unsafe { out.copy_from_nonoverlapping(results.as_ptr(), results.len().min(cap)) };
    }
}

/// Copies values that the caller passes; error messages refer to them as `name`.
///
/// # Safety
/// `values` must be null or point to `n` values that live through the call.
pub unsafe fn values(values: *const tatu_value, n: u32, name: &str) -> Result<Vec<Value>, CallError> {
    // SAFETY: the caller guarantees `n` values that live through the call.
    let values = unsafe { ValueRef::slice(values, n as usize) };
    values.iter().map(|v| copied(*v, name)).collect()
}

/// Copies a value that the caller passes; an error message refers to it as `name`.
pub fn copied(value: ValueRef<'_>, name: &str) -> Result<Value, CallError> {
    value.to_value().map_err(|e| CallError::argument(format!("{name}: {}", e.text())))
}
