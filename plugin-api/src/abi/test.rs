//! `tatu/test.h`: the host's interface to tests, and the tables with which a library exports its tests.

use core::ffi::{c_char, c_void};

use super::{frozen::*, types::tatu_status};

/// Opaque type of a world that a test has opened.
#[repr(C)]
pub struct tatu_test_world {
    _opaque: [u8; 0],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_test_setup {
    pub size: u32,
    pub reserved: u32,
    pub scene: tatu_str,
    pub folder: *const c_char,
    pub plugins: *const *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_test_host {
    pub size: u32,
    pub reserved: u32,
    pub open: Option<unsafe extern "C" fn(*const tatu_test_setup) -> *mut tatu_test_world>,
    pub close: Option<unsafe extern "C" fn(*mut tatu_test_world) -> tatu_status>,
    pub step: Option<unsafe extern "C" fn(*mut tatu_test_world, u64) -> tatu_status>,
    pub time: Option<unsafe extern "C" fn(*mut tatu_test_world) -> f64>,
    pub field: Option<
        unsafe extern "C" fn(*mut tatu_test_world, *const c_char, *const c_char, *mut tatu_value) -> tatu_status,
    >,
    pub reading: Option<unsafe extern "C" fn(*mut tatu_test_world, *const c_char, *mut tatu_value) -> tatu_status>,
    pub get: Option<
        unsafe extern "C" fn(*mut tatu_test_world, *const c_char, *const c_char, *mut tatu_value) -> tatu_status,
    >,
    pub set: Option<
        unsafe extern "C" fn(*mut tatu_test_world, *const c_char, *const c_char, *const tatu_value) -> tatu_status,
    >,
    pub call: Option<
        unsafe extern "C" fn(
            *mut tatu_test_world,
            *const c_char,
            *const tatu_value,
            u32,
            *mut tatu_value,
            u32,
            *mut u32,
        ) -> tatu_status,
    >,
    pub lines: Option<unsafe extern "C" fn(*mut tatu_test_world) -> tatu_str>,
    pub faults: Option<unsafe extern "C" fn(*mut tatu_test_world) -> tatu_str>,
    pub last_error: Option<unsafe extern "C" fn() -> tatu_str>,
}

/// The type of `tatu_test_host_get`, the only function that the library `tatuhost` exports.
pub type tatu_test_host_get_t = unsafe extern "C" fn() -> *const tatu_test_host;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_test {
    pub size: u32,
    pub failures: u32,
    pub host: *const tatu_test_host,
    pub folder: *const c_char,
    pub plugins: *const *const c_char,
    pub world: *mut tatu_test_world,
    pub leave: *mut c_void,
    pub ctx: *mut c_void,
    pub report: Option<unsafe extern "C" fn(*mut tatu_test, *const c_char, u32, *const c_char)>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_test_case {
    pub size: u32,
    pub line: u32,
    pub name: *const c_char,
    pub file: *const c_char,
    pub run: Option<unsafe extern "C" fn(*mut tatu_test)>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_test_list {
    pub size: u32,
    pub abi_major: u16,
    pub abi_minor: u16,
    pub cases: *const *const tatu_test_case,
}
