//! Types for arguments of host functions in Rust: borrows where C has pointers.
//!
//! Layouts are those of the header: a reference is a pointer, an `Option` of a reference is a pointer that may be null,
//! and each type here is transparent over the type in the header. Most functions of the host's tables are therefore
//! safe to call: the types express what a caller must guarantee, and the host checks the rest. Lists, which C passes as
//! a pointer and a count, and tables that grow, of which older callers pass a shorter version, remain raw pointers, so
//! functions that accept them are `unsafe`.

use core::{
    ffi::{CStr, c_char},
    marker::PhantomData,
};

use super::frozen::*;

/// A world lent for `'a`, which ends with the plugin's call at the latest. Texts and values from the host are also
/// valid for `'a`. The host validates the pointer before it dereferences it.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct WorldRef<'a>(*mut tatu_world, PhantomData<&'a ()>);

impl WorldRef<'_> {
    /// Wraps the pointer that the host passed in a call to the plugin.
    ///
    /// # Safety
    /// `'a` must end no later than the call in which `world` was passed.
    pub unsafe fn new(world: *mut tatu_world) -> Self {
        WorldRef(world, PhantomData)
    }
    /// Returns the pointer.
    pub fn ptr(self) -> *mut tatu_world {
        self.0
    }
}

/// Text or bytes, lent for `'a`.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Lent<'a>(tatu_str, PhantomData<&'a [u8]>);

impl<'a> Lent<'a> {
    /// The empty text.
    pub const EMPTY: Lent<'static> = Lent(tatu_str { ptr: core::ptr::null(), len: 0 }, PhantomData);

    /// Wraps a text or bytes of the ABI.
    ///
    /// # Safety
    /// `raw` must be empty, or point to the number of bytes that it states, which live for `'a`.
    pub unsafe fn new(raw: tatu_str) -> Self {
        Lent(raw, PhantomData)
    }
    /// Returns the bytes.
    pub fn bytes(self) -> &'a [u8] {
        if self.0.ptr.is_null() || self.0.len == 0 {
            return &[];
        }
        // SAFETY: `self.0` was created from a borrow for `'a`, or the caller of `new` guaranteed that its bytes live
        // for `'a`; null and empty were handled above.
        unsafe { core::slice::from_raw_parts(self.0.ptr.cast(), self.0.len as usize) }
    }
    /// Returns the text as UTF-8; invalid bytes are replaced.
    pub fn text(self) -> std::borrow::Cow<'a, str> {
        String::from_utf8_lossy(self.bytes())
    }
    /// Returns the text in the form of the ABI, for fields of tables.
    pub fn raw(self) -> tatu_str {
        self.0
    }
}

impl<'a> From<&'a [u8]> for Lent<'a> {
    fn from(bytes: &'a [u8]) -> Self {
        Lent(tatu_str { ptr: bytes.as_ptr().cast(), len: bytes.len() as u64 }, PhantomData)
    }
}

impl<'a> From<&'a str> for Lent<'a> {
    fn from(text: &'a str) -> Self {
        text.as_bytes().into()
    }
}

/// A NUL-terminated text lent for `'a`, or null.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct LentCStr<'a>(*const c_char, PhantomData<&'a CStr>);

impl<'a> LentCStr<'a> {
    /// The null pointer: no text.
    pub const NULL: LentCStr<'static> = LentCStr(core::ptr::null(), PhantomData);

    /// Returns the text, or `None` for null.
    pub fn get(self) -> Option<&'a CStr> {
        // SAFETY: a pointer that is not null was created from a `CStr` borrowed for `'a`, or was passed over the ABI,
        // which guarantees that it is NUL-terminated and valid for `'a`.
        (!self.0.is_null()).then(|| unsafe { CStr::from_ptr(self.0) })
    }
    /// Returns the text as UTF-8, with invalid bytes replaced; it is empty for null.
    pub fn text(self) -> std::borrow::Cow<'a, str> {
        self.get().map_or("".into(), CStr::to_string_lossy)
    }
}

impl<'a> From<&'a CStr> for LentCStr<'a> {
    fn from(text: &'a CStr) -> Self {
        LentCStr(text.as_ptr(), PhantomData)
    }
}

/// A value lent for `'a`, including everything that it points to.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct ValueRef<'a> {
    raw: tatu_value,
    life: PhantomData<&'a ()>,
}

impl<'a> ValueRef<'a> {
    /// The value nil.
    pub const NIL: ValueRef<'static> =
        ValueRef { raw: tatu_value { tag: TATU_NIL, reserved: 0, u: tatu_payload { i: 0 } }, life: PhantomData };

    /// Wraps a raw value of the ABI.
    ///
    /// # Safety
    /// Everything that `raw` points to must be valid for `'a`.
    pub unsafe fn new(raw: tatu_value) -> Self {
        ValueRef { raw, life: PhantomData }
    }
    /// Converts an array of raw values, without copying it, to a slice.
    ///
    /// # Safety
    /// `ptr` must point to `n` values that, with everything that they point to, are valid for `'a`, unless `n` is 0.
    pub unsafe fn slice(ptr: *const tatu_value, n: usize) -> &'a [ValueRef<'a>] {
        if ptr.is_null() || n == 0 {
            return &[];
        }
        // SAFETY: `ValueRef` is transparent over `tatu_value`; the caller guarantees `n` valid values for `'a`, and
        // null was handled above.
        unsafe { core::slice::from_raw_parts(ptr.cast(), n) }
    }
    /// Returns the value in the form of the ABI.
    pub fn raw(self) -> tatu_value {
        self.raw
    }
}
