//! Parts: `tatu/part.h`.

use std::ffi::{CStr, c_char, c_void};

use super::{ext::*, frozen::*, types::*};

pub const TATU_PART: &CStr = c"tatu.part/draft.4";

pub const TATU_PAUSE_BEGINS: u32 = 0;
pub const TATU_PAUSE_LASTS: u32 = 1;
pub const TATU_PAUSE_ENDS: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_part_call {
    pub size: u32,
    pub n_fields: u32,
    pub world: *mut tatu_world,
    pub part: tatu_object,
    pub owner: tatu_object,
    pub time: f64,
    pub dt: f64,
    pub step: u64,
    pub physics_step: u32,
    pub n_physics_steps: u32,
    pub state: *mut c_void,
    pub command: *const f64,
    pub fields: *const *mut c_void,
    pub lengths: *const u64,
}

/// A function of a part that is called in a stage.
pub type PartFn = unsafe extern "C" fn(*mut c_void, *const tatu_part_call, *mut tatu_error) -> tatu_status;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_contact_pair {
    pub size: u32,
    pub touching: u32,
    pub contact: tatu_contact,
    pub collide: u32,
    pub reserved: u32,
    pub friction: f64,
    pub restitution: f64,
    pub surface: [f64; 3],
}

/// The function of a part that decides on contacts.
pub type PartContactFn =
    unsafe extern "C" fn(*mut c_void, *const tatu_part_call, *mut tatu_contact_pair, *mut tatu_error) -> tatu_status;

/// The function of a part that receives events.
pub type PartEventFn = unsafe extern "C" fn(
    *mut c_void,
    *const tatu_part_call,
    tatu_str,
    *const tatu_value,
    *mut tatu_error,
) -> tatu_status;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_part {
    pub size: u32,
    pub flags: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub params: *const *const tatu_param,
    pub commands: *const *const tatu_param,
    pub life: *const tatu_life,
    pub actuate: Option<PartFn>,
    pub physics_step: Option<PartFn>,
    pub sense: Option<PartFn>,
    pub paused: Option<unsafe extern "C" fn(*mut c_void, *const tatu_part_call, u32, *mut tatu_error) -> tatu_status>,
    pub end: Option<PartFn>,
    pub schemas: *const *const c_char,
    pub fields: *const *const tatu_field,
    pub presets: *const *const tatu_preset,
    pub event: Option<PartEventFn>,
    pub events: *const *const c_char,
    pub contact: Option<PartContactFn>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_part {
    pub size: u32,
    pub reserved: u32,
    pub kinds: *const *const tatu_part,
}
