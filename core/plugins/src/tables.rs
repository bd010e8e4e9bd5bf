//! Tables of the ABI, which begin with their size: copies with zeros for missing fields, and required fields.

use tatu_plugin_api::abi::*;

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
    tatu_part,
    tatu_ext_part,
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
    tatu_beams,
    tatu_host_scene,
    tatu_host_stand_ins,
    tatu_host_readings,
    tatu_host_bodies,
    tatu_host_commands,
    tatu_host_scripts,
    tatu_host_events,
    tatu_host_signals,
    tatu_host_session,
    tatu_host_stage,
    tatu_host_log,
    tatu_host_files,
    tatu_host_figures,
    tatu_host_edits
);

/// Copies a plugin's table into a full-size one, with zeros for fields that the plugin's table does not contain.
///
/// # Safety
/// `from` must be null or point to a table of as many bytes as its `size` states.
pub(crate) unsafe fn read<T: Table>(from: *const T) -> Option<T> {
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
