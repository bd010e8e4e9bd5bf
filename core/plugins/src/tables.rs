//! Reading tables that another party filled: the fields that they have, the rest zero.

use std::ffi::{CStr, c_char};

use tatu_plugin_api::abi::*;

use crate::texts;

/// A table of the ABI: begins with its size, and is valid when all zero.
///
/// # Safety
/// `repr(C)`, first field `size: u32`, all-zero is a valid value, and `BOUNDS` holds the end of every field.
pub unsafe trait Table: Copy {}

macro_rules! table {
    ($($t:ty),*) => {
        $(
            // SAFETY: a mirrored table of the header, see the test of sizes and offsets.
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

/// Copies a foreign table into a full-size one of ours: fields that it does not have are zero.
///
/// # Safety
/// `from` is null or points to a table of as many bytes as its `size` says.
pub unsafe fn read<T: Table>(from: *const T) -> Option<T> {
    if from.is_null() {
        return None;
    }
    // SAFETY: all-zero is valid for tables; at most `size` bytes are read, and no more than fit. Fields are 8 bytes, or
    // 4-byte fields in pairs: rounding down never leaves half of a pointer.
    unsafe {
        let size = (*from.cast::<u32>()) as usize;
        let mut to: T = std::mem::zeroed();
        let take = size.min(size_of::<T>()) & !7;
        std::ptr::copy_nonoverlapping(from.cast::<u8>(), (&raw mut to).cast::<u8>(), take);
        // The size that the table states is kept, for messages.
        *(&raw mut to).cast::<u32>() = size as u32;
        Some(to)
    }
}

/// A pointer or function that a table must have: name, whether it is there, where it ends.
pub type Required = (&'static str, bool, usize);

/// The fields of a copied table that must not be null.
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

/// Whether all bytes of a pointer or function are zero: null.
pub fn is_zero<T: Copy>(field: &T) -> bool {
    const { assert!(size_of::<T>() == size_of::<usize>()) };
    // SAFETY: as large as a pointer, and every pattern of bits is a number.
    unsafe { std::mem::transmute_copy::<T, usize>(field) == 0 }
}

/// The hint for a missing field.
pub const HELP: &str = "set `size` to sizeof, and fill what is required";

/// The first required field that is missing, in words; `size` is what the table states.
pub fn lacking(size: u32, required: &[Required]) -> Option<String> {
    let (name, _, end) = required.iter().find(|(_, there, _)| !there)?;
    Some(match (size as usize) < *end {
        true => {
            format!("is too short: its `size` is {size} bytes, and `{name}`, which is required, ends at byte {end}")
        }
        false => format!("has no `{name}`, which is required"),
    })
}

/// The tables of a null-terminated list.
///
/// # Safety
/// `list` is null or a null-terminated array of pointers to tables.
pub unsafe fn list<T: Table>(list: *const *const T) -> Vec<(*const T, T)> {
    // SAFETY: the caller promises it.
    unsafe { pointers(list).into_iter().filter_map(|p| read(p).map(|t| (p, t))).collect() }
}

/// The pointers of a null-terminated list; at most 65536, so that a missing end is not an endless walk.
///
/// # Safety
/// `list` is null or a null-terminated array.
pub unsafe fn pointers<T>(list: *const *const T) -> Vec<*const T> {
    let mut out = Vec::new();
    if list.is_null() {
        return out;
    }
    for i in 0..65536 {
        // SAFETY: within the array, whose end is the first null.
        let p = unsafe { *list.add(i) };
        if p.is_null() {
            break;
        }
        out.push(p);
    }
    out
}

/// A NUL-terminated text for display, copied: control characters are escaped.
///
/// # Safety
/// `s` is null or NUL-terminated.
pub unsafe fn text(s: *const c_char) -> Option<String> {
    // SAFETY: the caller promises it.
    (!s.is_null()).then(|| texts::clean(&unsafe { CStr::from_ptr(s) }.to_string_lossy()).into_owned())
}

/// A NUL-terminated name, copied as [`texts::label`] shows it: `names` checks whether it is valid.
///
/// # Safety
/// `s` is null or NUL-terminated.
pub unsafe fn label(s: *const c_char) -> Option<String> {
    // SAFETY: the caller promises it.
    (!s.is_null()).then(|| texts::label(unsafe { CStr::from_ptr(s) }.to_bytes()))
}
