//! Arguments of host functions as Rust sees them: borrows, where C has pointers.
//!
//! Layouts are those of the header: a reference is a pointer, `Option` of one is a pointer that may be null, and each type
//! here is transparent over the type that the header names. So most functions of the host's tables are safe to call: what a
//! caller must promise is in the types, and the host checks the rest. Lists, which C passes as a pointer and a number, and
//! structures that grow, of which an older caller has less, stay pointers and `unsafe`.

use core::{
    ffi::{CStr, c_char},
    marker::PhantomData,
};

use super::frozen::*;

/// A world that is lent for `'a`, which ends with the plugin's call at the latest: so long live the texts and values that
/// the host gives. The host checks the pointer before it reads anything through it.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct WorldRef<'a>(*mut tatu_world, PhantomData<&'a ()>);

impl WorldRef<'_> {
    /// # Safety
    /// `'a` ends no later than the plugin's call that `world` was given to.
    pub unsafe fn new(world: *mut tatu_world) -> Self {
        WorldRef(world, PhantomData)
    }
    /// The pointer.
    pub fn ptr(self) -> *mut tatu_world {
        self.0
    }
}

/// A text or bytes, lent for `'a`.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Lent<'a>(tatu_str, PhantomData<&'a [u8]>);

impl<'a> Lent<'a> {
    /// No bytes.
    pub const EMPTY: Lent<'static> = Lent(tatu_str { ptr: core::ptr::null(), len: 0 }, PhantomData);

    /// # Safety
    /// `raw` is empty, or points to as many bytes as it states, which live for `'a`.
    pub unsafe fn new(raw: tatu_str) -> Self {
        Lent(raw, PhantomData)
    }
    /// The bytes.
    pub fn bytes(self) -> &'a [u8] {
        if self.0.ptr.is_null() || self.0.len == 0 {
            return &[];
        }
        // SAFETY: the pointer was made of a borrow for 'a, by this type or by who called over the border.
        unsafe { core::slice::from_raw_parts(self.0.ptr.cast(), self.0.len as usize) }
    }
    /// As UTF-8; other bytes are replaced.
    pub fn text(self) -> std::borrow::Cow<'a, str> {
        String::from_utf8_lossy(self.bytes())
    }
    /// The form that tables hold.
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

/// A text that ends with 0, lent for `'a`, or null.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct LentCStr<'a>(*const c_char, PhantomData<&'a CStr>);

impl<'a> LentCStr<'a> {
    /// None.
    pub const NULL: LentCStr<'static> = LentCStr(core::ptr::null(), PhantomData);

    /// The text; `None` for null.
    pub fn get(self) -> Option<&'a CStr> {
        // SAFETY: it was made of a borrow for 'a, by this type or by who called over the border.
        (!self.0.is_null()).then(|| unsafe { CStr::from_ptr(self.0) })
    }
    /// As UTF-8; other bytes are replaced; empty for null.
    pub fn text(self) -> std::borrow::Cow<'a, str> {
        self.get().map_or("".into(), CStr::to_string_lossy)
    }
}

impl<'a> From<&'a CStr> for LentCStr<'a> {
    fn from(text: &'a CStr) -> Self {
        LentCStr(text.as_ptr(), PhantomData)
    }
}

/// A value that is lent for `'a`, with all that it points to.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct ValueRef<'a> {
    raw: tatu_value,
    life: PhantomData<&'a ()>,
}

impl<'a> ValueRef<'a> {
    /// Nothing.
    pub const NIL: ValueRef<'static> =
        ValueRef { raw: tatu_value { tag: TATU_NIL, reserved: 0, u: tatu_payload { i: 0 } }, life: PhantomData };

    /// Wraps a border value.
    ///
    /// # Safety
    /// Whatever `raw` points to must be valid for `'a`.
    pub unsafe fn new(raw: tatu_value) -> Self {
        ValueRef { raw, life: PhantomData }
    }
    /// A slice of border values as views.
    ///
    /// # Safety
    /// `ptr` points to `n` values, valid for `'a` with all they point to; or `n` is 0.
    pub unsafe fn slice(ptr: *const tatu_value, n: usize) -> &'a [ValueRef<'a>] {
        if ptr.is_null() || n == 0 {
            return &[];
        }
        // SAFETY: `ValueRef` is transparent over `tatu_value`.
        unsafe { core::slice::from_raw_parts(ptr.cast(), n) }
    }
    /// The border form.
    pub fn raw(self) -> tatu_value {
        self.raw
    }
}
