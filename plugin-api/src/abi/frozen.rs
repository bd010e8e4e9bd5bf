//! The frozen types of `tatu/core.h`, which never change within an ABI major version, and the check of their layouts.
//!
//! Only this file uses `abi_stable`, and only for these types, because `abi_stable` would reject a table that has
//! grown, and thus older plugins in newer hosts.

use core::ffi::{CStr, c_char, c_void};

#[cfg(feature = "layout-check")]
use abi_stable::{StableAbi, type_layout::TypeLayout};

/// Text or bytes with a length.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "layout-check", derive(StableAbi))]
pub struct tatu_str {
    pub ptr: *const c_char,
    pub len: u64,
}

pub type tatu_object = u64;

/// Mask of the lowest 20 bits of a [`tatu_object`]: its slot, which scripts use as the handle.
pub const TATU_SLOT_BITS: tatu_object = 1048575;

/// Returns the slot of an object, without its generation: the handle that scripts use, or 0 for no object.
pub const fn tatu_slot(object: tatu_object) -> u32 {
    (object & TATU_SLOT_BITS) as u32
}
pub type tatu_func = u64;
pub type tatu_prop = u32;

pub const TATU_NIL: u32 = 0;
pub const TATU_BOOL: u32 = 1;
pub const TATU_I64: u32 = 2;
pub const TATU_F64: u32 = 3;
pub const TATU_TEXT: u32 = 4;
pub const TATU_BYTES: u32 = 5;
pub const TATU_F64S: u32 = 6;
pub const TATU_F32S: u32 = 7;
pub const TATU_I64S: u32 = 8;
pub const TATU_I32S: u32 = 9;
pub const TATU_U8S: u32 = 10;
pub const TATU_LIST: u32 = 11;
pub const TATU_MAP: u32 = 12;
pub const TATU_FUNC: u32 = 13;
pub const TATU_OBJECT: u32 = 14;

/// The elements of a value of variable length: a pointer to the first one, and their number.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "layout-check", derive(StableAbi))]
pub struct tatu_span_t {
    pub ptr: *const c_void,
    pub len: u64,
}

/// The content of a value; the value's tag selects the member.
#[repr(C)]
#[derive(Clone, Copy)]
#[cfg_attr(feature = "layout-check", derive(StableAbi))]
pub union tatu_payload {
    pub i: i64,
    pub f: f64,
    pub u: u64,
    pub s: tatu_span_t,
}

/// A value of any of the types in `tatu_tag`.
#[repr(C)]
#[derive(Clone, Copy)]
#[cfg_attr(feature = "layout-check", derive(StableAbi))]
pub struct tatu_value {
    pub tag: u32,
    pub reserved: u32,
    pub u: tatu_payload,
}

/// One entry of a map.
#[repr(C)]
#[derive(Clone, Copy)]
#[cfg_attr(feature = "layout-check", derive(StableAbi))]
pub struct tatu_pair {
    pub key: tatu_value,
    pub value: tatu_value,
}

pub const TATU_ELEM_F64: u32 = 1;
pub const TATU_ELEM_F32: u32 = 2;
pub const TATU_ELEM_I32: u32 = 3;
pub const TATU_ELEM_U16: u32 = 4;
pub const TATU_ELEM_U8: u32 = 5;
pub const TATU_ELEM_OBJECT: u32 = 6;

/// One field of a reading, borrowed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "layout-check", derive(StableAbi))]
pub struct tatu_field_view {
    pub ptr: *const c_void,
    pub len: u64,
    pub elem: u32,
    pub dims: [u32; 3],
    pub time: f64,
    pub sequence: u64,
}

/// A contact between two shapes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "layout-check", derive(StableAbi))]
pub struct tatu_contact {
    pub shape: [tatu_object; 2],
    pub point: [f64; 3],
    pub normal: [f64; 3],
    pub force: f64,
}

/// Opaque type of a world.
#[repr(C)]
pub struct tatu_world {
    _private: [u8; 0],
}
/// Opaque type of a session.
#[repr(C)]
pub struct tatu_session {
    _private: [u8; 0],
}

/// Id of the extension with which a host and a plugin that are both written in Rust compare the layouts of the frozen
/// types.
pub const TATU_RUST_LAYOUT: &CStr = c"tatu.rust.layout/1";

/// The table of that extension. Layouts can be compared only if both sides use the same version of `abi_stable`.
#[repr(C)]
pub struct tatu_rust_layout {
    pub size: u32,
    pub n_layouts: u32,
    /// Version of the crate `abi_stable`, NUL-terminated.
    pub abi_stable: *const c_char,
    /// The `TypeLayout` of `tatu_str`, `tatu_value`, `tatu_pair`, `tatu_field_view` and `tatu_contact`, in this order.
    pub layouts: *const *const c_void,
}

#[cfg(feature = "layout-check")]
mod layouts {
    use abi_stable::abi_stability::abi_checking::{AbiInstability, check_layout_compatibility};

    use super::*;

    /// All frozen types that are stored in arrays or passed by value.
    static FROZEN: [&TypeLayout; 5] = [
        <tatu_str as StableAbi>::LAYOUT,
        <tatu_value as StableAbi>::LAYOUT,
        <tatu_pair as StableAbi>::LAYOUT,
        <tatu_field_view as StableAbi>::LAYOUT,
        <tatu_contact as StableAbi>::LAYOUT,
    ];

    struct LayoutTable(tatu_rust_layout);
    // SAFETY: all pointers in the table point to statics that are never modified, so sharing it between threads is
    // sound.
    unsafe impl Sync for LayoutTable {}

    static TABLE: LayoutTable = LayoutTable(tatu_rust_layout {
        size: size_of::<tatu_rust_layout>() as u32,
        n_layouts: FROZEN.len() as u32,
        abi_stable: c"0.11.3".as_ptr(),
        layouts: &raw const FROZEN as *const *const c_void,
    });

    /// Returns the table of this side's layouts.
    pub fn table() -> *const tatu_rust_layout {
        &raw const TABLE.0
    }

    /// Compares this side's layouts with those of the other side. Returns `Ok(false)` if they cannot be compared
    /// because the versions of `abi_stable` or the numbers of layouts differ, and an error that identifies the first
    /// type whose layouts differ.
    ///
    /// # Safety
    /// `other` must point to a table that [`table`] returned, in any build of this crate.
    pub unsafe fn compare(other: *const tatu_rust_layout) -> Result<bool, String> {
        // SAFETY: the caller guarantees that `other` is a valid table, whose version is NUL-terminated.
        let (theirs, version) = unsafe { (&*other, CStr::from_ptr((*other).abi_stable)) };
        if version != c"0.11.3" || theirs.n_layouts as usize != FROZEN.len() {
            return Ok(false);
        }
        for (i, mine) in FROZEN.iter().enumerate() {
            // SAFETY: both sides use the same version of `abi_stable`, so `TypeLayout` is the same type; `i` is below
            // `n_layouts`, which was checked to be equal.
            let other = unsafe { &*(*theirs.layouts.add(i) as *const TypeLayout) };
            // Frozen types are the same in every version of this crate, so a difference of versions is ignored.
            let differs = |e: &AbiInstability| !matches!(e, AbiInstability::PackageVersion(_));
            if let Err(found) = check_layout_compatibility(mine, other)
                && found.errors.iter().flat_map(|e| e.errs.iter()).any(differs)
            {
                return Err(format!("its `{}` differs from the host's", mine.name()));
            }
        }
        Ok(true)
    }
}

#[cfg(feature = "layout-check")]
pub use layouts::{compare as compare_layouts, table as layout_table};

#[cfg(all(test, feature = "layout-check"))]
mod tests {
    use super::*;

    #[test]
    fn layouts_match_themselves_and_differ_from_a_foreign_table() {
        // SAFETY: both arguments point to tables that come from `layout_table`, or to copies of it with valid pointers;
        // they live until the end of the test.
        unsafe {
            assert_eq!(compare_layouts(layout_table()), Ok(true));
            let stranger = tatu_rust_layout { abi_stable: c"0.0.1".as_ptr(), ..std::ptr::read(layout_table()) };
            assert_eq!(compare_layouts(&stranger), Ok(false), "another abi_stable cannot be compared");
            let mut swapped: Vec<*const c_void> =
                (0..(*layout_table()).n_layouts as usize).map(|i| *(*layout_table()).layouts.add(i)).collect();
            swapped.swap(0, 1);
            let wrong = tatu_rust_layout { layouts: swapped.as_ptr(), ..std::ptr::read(layout_table()) };
            assert!(compare_layouts(&wrong).is_err_and(|e| e.contains("tatu_str")));
        }
    }
}
