//! `tatu/core.h`: status codes, errors, plugin and host, parameters and instances.

use core::ffi::{c_char, c_void};

use super::frozen::*;

pub const TATU_ABI_MAJOR: u16 = 0;
pub const TATU_ABI_MINOR: u16 = 9;

pub type tatu_status = i32;
pub const TATU_OK: tatu_status = 0;
pub const TATU_WAIT: tatu_status = 1;
pub const TATU_ERR: tatu_status = -1;
pub const TATU_ERR_ARGUMENT: tatu_status = -2;
pub const TATU_ERR_MISSING: tatu_status = -3;
pub const TATU_ERR_GONE: tatu_status = -4;
pub const TATU_ERR_UNSUPPORTED: tatu_status = -5;
pub const TATU_ERR_UNKNOWN: tatu_status = -6;
pub const TATU_ERR_SCRIPT: tatu_status = -7;
pub const TATU_ERR_BUDGET: tatu_status = -8;
pub const TATU_ERR_PANIC: tatu_status = -9;
pub const TATU_ERR_BUSY: tatu_status = -10;
pub const TATU_ERR_SPACE: tatu_status = -11;
pub const TATU_ERR_PHYSICS: tatu_status = -12;
pub const TATU_ERR_MEMORY: tatu_status = -13;

#[repr(C)]
pub struct tatu_error {
    pub size: u32,
    pub code: i32,
    pub ctx: *mut c_void,
    pub say: Option<unsafe extern "C" fn(*mut tatu_error, tatu_status, tatu_str)>,
    pub add: Option<unsafe extern "C" fn(*mut tatu_error, u32, tatu_str, u64)>,
    pub text: tatu_str,
    pub help: tatu_str,
    pub file: tatu_str,
    pub traceback: tatu_str,
    pub line: u64,
}
pub const TATU_PART_HELP: u32 = 1;
pub const TATU_PART_FILE: u32 = 2;
pub const TATU_PART_TRACEBACK: u32 = 3;

#[repr(C)]
pub struct tatu_host {
    pub size: u32,
    pub abi_minor: u32,
    pub ctx: *mut c_void,
    pub service: Option<unsafe extern "C" fn(*const tatu_host, *const c_char) -> *const c_void>,
    pub assets: *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_need {
    pub size: u32,
    pub optional: u32,
    pub id: *const c_char,
    pub bytes: u32,
    pub minor: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_plugin_t {
    pub size: u32,
    pub abi_major: u16,
    pub abi_minor: u16,
    pub id: *const c_char,
    pub name: *const c_char,
    pub version: *const c_char,
    pub licence: *const c_char,
    pub needs: *const *const tatu_need,
    pub init: Option<unsafe extern "C" fn(*const tatu_host, *mut *mut c_void, *mut tatu_error) -> tatu_status>,
    pub shutdown: Option<unsafe extern "C" fn(*mut c_void)>,
    pub extension: Option<unsafe extern "C" fn(*mut c_void, *const c_char) -> *const c_void>,
}

pub const TATU_PARAM_REBUILDS: u32 = 1;
pub const TATU_PARAM_READ_ONLY: u32 = 2;
pub const TATU_PARAM_OPTIONAL: u32 = 4;
pub const TATU_PARAM_REST: u32 = 8;
pub const TATU_PARAM_ANY: u32 = 16;
pub const TATU_PARAM_PROGRAM: u32 = 32;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_param {
    pub size: u32,
    pub type_: u32,
    pub count: u32,
    pub flags: u32,
    pub key: *const c_char,
    pub unit: *const c_char,
    pub lowest: f64,
    pub highest: f64,
    pub fallback: tatu_value,
    pub choices: *const *const c_char,
    pub text: *const c_char,
    pub keys: *const *const tatu_param,
}

#[repr(C)]
pub struct tatu_instance {
    pub size: u32,
    pub n_params: u32,
    pub world: *mut tatu_world,
    pub owner: tatu_object,
    pub id: u64,
    pub seed: u64,
    pub params: *const tatu_value,
    pub state: *mut c_void,
    pub session: *mut tatu_session,
}

#[repr(C)]
pub struct tatu_writer {
    pub size: u32,
    pub reserved: u32,
    pub ctx: *mut c_void,
    pub write: Option<unsafe extern "C" fn(*const tatu_writer, *const c_void, u64)>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_life {
    pub size: u32,
    pub state_bytes: u32,
    pub create: Option<
        unsafe extern "C" fn(*mut c_void, *const tatu_instance, *mut *mut c_void, *mut tatu_error) -> tatu_status,
    >,
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
    pub configure:
        Option<unsafe extern "C" fn(*mut c_void, *const tatu_value, u32, u64, *mut tatu_error) -> tatu_status>,
    pub save: Option<unsafe extern "C" fn(*mut c_void, *const tatu_writer, *mut tatu_error) -> tatu_status>,
    pub load: Option<unsafe extern "C" fn(*mut c_void, tatu_str, u32, *mut tatu_error) -> tatu_status>,
    pub version: u32,
    pub reserved: u32,
    pub end_run:
        Option<unsafe extern "C" fn(*mut c_void, *mut c_void, *mut tatu_world, *mut tatu_error) -> tatu_status>,
}
