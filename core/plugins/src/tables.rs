//! Reading of tables that plugins have filled, with zeros for missing fields.

use std::ffi::{CStr, c_char};

use tatu_plugin_api::abi::*;

use crate::texts;

/// A table of the ABI, which begins with its size and is valid if all bytes are zero.
///
/// # Safety
/// The type must be `repr(C)` with a first field `size: u32`, and be valid if all bytes are zero.
pub unsafe trait Table: Copy {}

macro_rules! table {
    ($($t:ty),*) => {
        $(
            // SAFETY: the type mirrors a table in the header, which begins with its size; a test compares sizes and
            // offsets.
            unsafe impl Table for $t {}
        )*
    };
}
table!(
    tatu_plugin_t,
    tatu_need,
    tatu_param,
    tatu_life,
    tatu_name,
    tatu_command,
    tatu_constant,
    tatu_prelude,
    tatu_kind_mark,
    tatu_ext_command,
    tatu_field,
    tatu_sensor,
    tatu_preset,
    tatu_ext_sensor,
    tatu_actuator,
    tatu_ext_actuator,
    tatu_model,
    tatu_model_slot,
    tatu_model_number,
    tatu_ext_model,
    tatu_importer,
    tatu_ext_importer,
    tatu_language,
    tatu_ext_script,
    tatu_service,
    tatu_ext_service,
    tatu_event,
    tatu_ext_event,
    tatu_beams
);

/// Copies a plugin's table into a full-size one, with zeros for fields that the plugin's table does not contain.
///
/// # Safety
/// `from` must be null or point to a table of as many bytes as its `size` states.
pub unsafe fn read<T: Table>(from: *const T) -> Option<T> {
    if from.is_null() {
        return None;
    }
    // SAFETY: the caller guarantees that the table has `size` bytes; at most that many are copied, and zeros are valid
    // for the rest. Fields have 8 bytes or are pairs of 4-byte fields, so rounding down never splits a pointer.
    unsafe {
        let size = (*from.cast::<u32>()) as usize;
        let mut to: T = std::mem::zeroed();
        let take = size.min(size_of::<T>()) & !7;
        std::ptr::copy_nonoverlapping(from.cast::<u8>(), (&raw mut to).cast::<u8>(), take);
        // The stated size is preserved, for messages.
        *(&raw mut to).cast::<u32>() = size as u32;
        Some(to)
    }
}

/// A required pointer or function of a table: its name, whether it is set, and the offset of its end in bytes.
pub type RequiredField = (&'static str, bool, usize);

/// Lists the fields of a copied table that must not be null.
macro_rules! required {
    ($table:expr, $type:ty: $($field:ident),+) => {
        [$((
            stringify!($field),
            !crate::tables::is_zero(&$table.$field),
            core::mem::offset_of!($type, $field) + size_of_val(&$table.$field),
        )),+]
    };
}
pub(super) use required;

/// Returns whether a pointer or function is null.
pub fn is_zero<T: Copy>(field: &T) -> bool {
    const { assert!(size_of::<T>() == size_of::<usize>()) };
    // SAFETY: `T` has the size of a `usize`, for which every bit pattern is valid.
    unsafe { std::mem::transmute_copy::<T, usize>(field) == 0 }
}

/// The hint for a missing field.
pub const HELP: &str = "set `size` to the sizeof of the type, and set all required fields";

/// Describes the first required field that is not set, if any; `size` is the size that the table states.
pub fn lacking(size: u32, required: &[RequiredField]) -> Option<String> {
    let (name, _, end) = required.iter().find(|(_, there, _)| !there)?;
    Some(match (size as usize) < *end {
        true => {
            format!("is too short: its `size` is {size} bytes, and `{name}`, which is required, ends at byte {end}")
        }
        false => format!("has no `{name}`, which is required"),
    })
}

/// Copies the tables of a null-terminated list.
///
/// # Safety
/// `list` must be null or a null-terminated array of pointers to tables that are valid for [`read`].
pub unsafe fn list<T: Table>(list: *const *const T) -> Vec<(*const T, T)> {
    // SAFETY: the caller guarantees that the list and its tables are valid during this call; the tables are copied.
    unsafe { pointers(list).into_iter().filter_map(|p| read(p).map(|t| (p, t))).collect() }
}

/// Returns the pointers of a null-terminated list, but at most 65536, in case the terminator is missing.
///
/// # Safety
/// `list` must be null or a null-terminated array.
pub unsafe fn pointers<T>(list: *const *const T) -> Vec<*const T> {
    let mut out = Vec::new();
    if list.is_null() {
        return out;
    }
    for i in 0..65536 {
        // SAFETY: no null pointer was found before index `i`, so the element is within the array, which the caller
        // guarantees to be valid during this call.
        let p = unsafe { *list.add(i) };
        if p.is_null() {
            break;
        }
        out.push(p);
    }
    out
}

/// Copies a NUL-terminated string, with control characters escaped for display.
///
/// # Safety
/// `s` must be null or NUL-terminated.
pub unsafe fn text(s: *const c_char) -> Option<String> {
    // SAFETY: `s` is not null, and the caller guarantees that it is NUL-terminated and valid during this call.
    (!s.is_null()).then(|| texts::clean(&unsafe { CStr::from_ptr(s) }.to_string_lossy()).into_owned())
}

/// Copies a NUL-terminated name in the form of [`texts::label`]; `names` checks whether it is valid.
///
/// # Safety
/// `s` must be null or NUL-terminated.
pub unsafe fn label(s: *const c_char) -> Option<String> {
    // SAFETY: `s` is not null, and the caller guarantees that it is NUL-terminated and valid during this call.
    (!s.is_null()).then(|| texts::label(unsafe { CStr::from_ptr(s) }.to_bytes()))
}

/// Returns the names of a null-terminated list, in the form that `texts::flaw` expects.
///
/// # Safety
/// As for [`pointers`].
pub unsafe fn labels(list: *const *const c_char) -> Vec<String> {
    // SAFETY: the caller guarantees that the list is valid.
    unsafe { pointers(list).into_iter().filter_map(|s| label(s)).collect() }
}
