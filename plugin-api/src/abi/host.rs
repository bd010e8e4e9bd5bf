//! Section 11 of the header: what the host offers.

use core::ffi::{CStr, c_char, c_void};

use super::{ext::*, frozen::*, types::*};

pub const TATU_KIND_SHAPE: i32 = 0;
pub const TATU_KIND_JOINT: i32 = 1;
pub const TATU_KIND_DUMMY: i32 = 2;
pub const TATU_KIND_SENSOR: i32 = 3;
pub const TATU_KIND_ACTUATOR: i32 = 4;
pub const TATU_KIND_FORCE_SENSOR: i32 = 5;
pub const TATU_KIND_SCRIPT: i32 = 6;
pub const TATU_KIND_CAMERA: i32 = 7;
pub const TATU_KIND_LIGHT: i32 = 8;
pub const TATU_KIND_GRAPH: i32 = 9;
pub const TATU_KIND_PATH: i32 = 10;

pub const TATU_LIST_CHILDREN: u32 = 1;
pub const TATU_LIST_SKIP_BASE: u32 = 2;

pub const TATU_HOST_SCENE: &CStr = c"tatu.host.scene/draft.4";
pub const TATU_HOST_STAND_INS: &CStr = c"tatu.host.stand_ins/draft.4";
pub const TATU_HOST_READINGS: &CStr = c"tatu.host.readings/draft.4";
pub const TATU_HOST_BODIES: &CStr = c"tatu.host.bodies/draft.4";
pub const TATU_HOST_COMMANDS: &CStr = c"tatu.host.commands/draft.4";
pub const TATU_HOST_SCRIPTS: &CStr = c"tatu.host.scripts/draft.4";
pub const TATU_HOST_SIGNALS: &CStr = c"tatu.host.signals/draft.4";
pub const TATU_HOST_EVENTS: &CStr = c"tatu.host.events/draft.4";
pub const TATU_HOST_SESSION: &CStr = c"tatu.host.session/draft.4";
pub const TATU_HOST_STAGE: &CStr = c"tatu.host.stage/draft.4";
pub const TATU_HOST_LOG: &CStr = c"tatu.host.log/draft.4";
pub const TATU_HOST_FILES: &CStr = c"tatu.host.files/draft.4";
pub const TATU_HOST_FIGURES: &CStr = c"tatu.host.figures/draft.4";

pub type WorldPtr = *mut tatu_world;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_scene {
    pub size: u32,
    pub reserved: u32,
    pub prop: Option<unsafe extern "C" fn(*const tatu_host, *const c_char) -> tatu_prop>,
    pub get: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_prop, *mut tatu_value) -> tatu_status>,
    pub set: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_prop, *const tatu_value) -> tatu_status>,
    pub get_f64: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_prop, *mut f64, u32) -> tatu_status>,
    pub set_f64: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_prop, *const f64, u32) -> tatu_status>,
    pub get_f64_many:
        Option<unsafe extern "C" fn(WorldPtr, *const tatu_object, u32, tatu_prop, *mut f64, u32) -> tatu_status>,
    pub set_f64_many:
        Option<unsafe extern "C" fn(WorldPtr, *const tatu_object, u32, tatu_prop, *const f64, u32) -> tatu_status>,
    pub pose: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_object, *mut f64) -> tatu_status>,
    pub set_pose: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_object, *const f64) -> tatu_status>,
    pub look: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut tatu_object, *mut i32) -> tatu_status>,
    pub find: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_str, *mut tatu_object) -> tatu_status>,
    pub create:
        Option<unsafe extern "C" fn(WorldPtr, *const c_char, tatu_object, tatu_str, *mut tatu_object) -> tatu_status>,
    pub remove: Option<unsafe extern "C" fn(WorldPtr, *const tatu_object, u32) -> tatu_status>,
    pub list:
        Option<unsafe extern "C" fn(WorldPtr, tatu_object, u32, u32, *mut tatu_object, u32, *mut u32) -> tatu_status>,
    pub copy: Option<unsafe extern "C" fn(WorldPtr, *const tatu_object, u32, *mut tatu_object) -> tatu_status>,
    pub load: Option<unsafe extern "C" fn(WorldPtr, tatu_str, tatu_object, *mut tatu_object) -> tatu_status>,
    pub save: Option<unsafe extern "C" fn(WorldPtr, tatu_str, tatu_object) -> tatu_status>,
    pub row: Option<unsafe extern "C" fn(WorldPtr, tatu_object, u32, *mut tatu_value) -> tatu_status>,
    pub model: Option<unsafe extern "C" fn(WorldPtr, u32, *mut tatu_value) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct tatu_look {
    pub size: u32,
    pub flags: u32,
    pub only: tatu_object,
    pub far_m: f64,
    pub max_incidence: f64,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_stand_ins {
    pub size: u32,
    pub reserved: u32,
    pub made: Option<unsafe extern "C" fn(WorldPtr) -> tatu_status>,
    pub object:
        Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_str, *const c_char, *mut tatu_object) -> tatu_status>,
    pub used: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *const c_char) -> tatu_status>,
    pub parent: Option<unsafe extern "C" fn(WorldPtr, tatu_object) -> tatu_status>,
    pub child: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *const c_char) -> tatu_status>,
    pub script: Option<unsafe extern "C" fn(WorldPtr, tatu_object) -> tatu_status>,
    pub value: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_str) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_readings {
    pub size: u32,
    pub reserved: u32,
    pub field: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_prop, *mut tatu_field_view) -> tatu_status>,
    pub sense_now: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_object) -> tatu_status>,
    pub reset: Option<unsafe extern "C" fn(WorldPtr, tatu_object) -> tatu_status>,
    pub list: Option<unsafe extern "C" fn(WorldPtr, *const c_char, *mut tatu_object, u32, *mut u32) -> tatu_status>,
    pub describe: Option<unsafe extern "C" fn(WorldPtr, tatu_object, u32, *mut tatu_field) -> tatu_status>,
    pub look: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *const tatu_look) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_bodies {
    pub size: u32,
    pub reserved: u32,
    pub twist: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut f64) -> tatu_status>,
    pub set_twist: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *const f64) -> tatu_status>,
    pub push: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *const f64, *const f64) -> tatu_status>,
    pub impulse: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *const f64, *const f64) -> tatu_status>,
    pub contacts: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut tatu_contact, u32, *mut u32) -> tatu_status>,
    pub closest: Option<
        unsafe extern "C" fn(
            WorldPtr,
            *const tatu_object,
            u32,
            *const tatu_object,
            u32,
            f64,
            *mut f64,
            *mut tatu_object,
        ) -> tatu_status,
    >,
    pub is_dynamic: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut u32) -> tatu_status>,
    pub frictions: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut f64, u32, *mut u32) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_commands {
    pub size: u32,
    pub reserved: u32,
    pub find: Option<unsafe extern "C" fn(WorldPtr, tatu_str, *mut u32) -> u32>,
    pub is_name_space: Option<unsafe extern "C" fn(WorldPtr, tatu_str) -> u32>,
    pub count: Option<unsafe extern "C" fn(WorldPtr) -> u32>,
    pub describe: Option<unsafe extern "C" fn(WorldPtr, u32) -> *const tatu_command>,
    pub call: Option<unsafe extern "C" fn(WorldPtr, *mut tatu_call) -> tatu_status>,
    pub generation: Option<unsafe extern "C" fn(WorldPtr) -> u64>,
    pub constant: Option<unsafe extern "C" fn(WorldPtr, tatu_str, *mut tatu_value) -> tatu_status>,
    pub prelude:
        Option<unsafe extern "C" fn(WorldPtr, *const c_char, u32, *mut tatu_str, *mut tatu_str) -> tatu_status>,
    pub mark: Option<unsafe extern "C" fn(WorldPtr) -> u64>,
    pub alloc: Option<unsafe extern "C" fn(WorldPtr, u64) -> *mut c_void>,
    pub release: Option<unsafe extern "C" fn(WorldPtr, u64)>,
    pub retain: Option<unsafe extern "C" fn(WorldPtr, tatu_func, *mut tatu_func) -> tatu_status>,
    pub drop: Option<unsafe extern "C" fn(WorldPtr, tatu_func)>,
    pub call_func: Option<unsafe extern "C" fn(WorldPtr, tatu_func, *mut tatu_call) -> tatu_status>,
    pub constant_name: Option<unsafe extern "C" fn(WorldPtr, u32, *mut tatu_str) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_scripts {
    pub size: u32,
    pub reserved: u32,
    pub list: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut tatu_object, u32, *mut u32) -> tatu_status>,
    pub call: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_str, *mut tatu_call) -> tatu_status>,
    pub broadcast: Option<unsafe extern "C" fn(WorldPtr, tatu_str, *const tatu_value, u32, tatu_object) -> tatu_status>,
    pub options: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut tatu_value) -> tatu_status>,
    pub add: Option<
        unsafe extern "C" fn(
            WorldPtr,
            tatu_object,
            tatu_str,
            tatu_str,
            tatu_str,
            tatu_str,
            tatu_str,
            *mut tatu_object,
        ) -> tatu_status,
    >,
    pub call_below:
        Option<unsafe extern "C" fn(WorldPtr, tatu_object, u32, *const tatu_value, u32, *mut u32) -> tatu_status>,
    pub text: Option<unsafe extern "C" fn(WorldPtr, tatu_object, *mut tatu_value) -> tatu_status>,
    pub change: Option<unsafe extern "C" fn(WorldPtr, tatu_object, tatu_str) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_events {
    pub size: u32,
    pub reserved: u32,
    pub publish: Option<unsafe extern "C" fn(WorldPtr, tatu_str, *const tatu_value) -> tatu_status>,
    pub subscribe: Option<unsafe extern "C" fn(WorldPtr, tatu_str, tatu_func, *mut u64) -> tatu_status>,
    pub unsubscribe: Option<unsafe extern "C" fn(WorldPtr, u64) -> tatu_status>,
    pub wanted: Option<unsafe extern "C" fn(WorldPtr, tatu_str) -> u32>,
    pub declared: Option<unsafe extern "C" fn(WorldPtr, u32, *mut tatu_str, *mut tatu_str) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_signals {
    pub size: u32,
    pub reserved: u32,
    pub get: Option<unsafe extern "C" fn(WorldPtr, u32, tatu_str, *mut tatu_value) -> tatu_status>,
    pub set: Option<unsafe extern "C" fn(WorldPtr, u32, tatu_str, *const tatu_value) -> tatu_status>,
    pub clear: Option<unsafe extern "C" fn(WorldPtr, u32, tatu_str) -> u32>,
    pub name: Option<unsafe extern "C" fn(WorldPtr, u32, u32, *mut tatu_str) -> tatu_status>,
}

pub const TATU_REQUEST_STOP: u32 = 1;
pub const TATU_REQUEST_PAUSE: u32 = 2;
pub const TATU_REQUEST_START: u32 = 3;
pub const TATU_REQUEST_QUIT: u32 = 4;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_session {
    pub size: u32,
    pub reserved: u32,
    pub request: Option<unsafe extern "C" fn(WorldPtr, u32) -> tatu_status>,
    pub wake: Option<unsafe extern "C" fn(*mut tatu_session)>,
    pub worlds: Option<unsafe extern "C" fn(*mut tatu_session, *mut WorldPtr, u32, *mut u32) -> tatu_status>,
    pub client: Option<unsafe extern "C" fn(WorldPtr, u64) -> tatu_status>,
    pub state: Option<unsafe extern "C" fn(WorldPtr) -> u32>,
    pub input: Option<unsafe extern "C" fn(WorldPtr, u64, *mut tatu_str, *mut tatu_str) -> tatu_status>,
    pub put_in: Option<unsafe extern "C" fn(WorldPtr, tatu_str, tatu_str) -> tatu_status>,
    pub open: Option<unsafe extern "C" fn(WorldPtr, tatu_str) -> tatu_status>,
    pub observed: Option<unsafe extern "C" fn(WorldPtr, tatu_str, *mut tatu_str) -> tatu_status>,
    pub observe: Option<unsafe extern "C" fn(WorldPtr, tatu_str, tatu_str) -> tatu_status>,
    pub interrupted: Option<unsafe extern "C" fn(WorldPtr) -> u32>,
    pub function: Option<unsafe extern "C" fn(WorldPtr, u32, *mut tatu_func) -> tatu_status>,
}

pub const TATU_STOPPED: u32 = 0;
pub const TATU_RUNNING: u32 = 1;
pub const TATU_PAUSED: u32 = 2;
pub const TATU_PHASE_STOPPED: u32 = 0;
pub const TATU_PHASE_FIRST: u32 = 1;
pub const TATU_PHASE_RUNNING: u32 = 2;
pub const TATU_PHASE_LAST_BEFORE_PAUSE: u32 = 3;
pub const TATU_PHASE_PAUSED: u32 = 4;
pub const TATU_PHASE_FIRST_AFTER_PAUSE: u32 = 5;
pub const TATU_PHASE_STOPPING: u32 = 6;
pub const TATU_PHASE_LAST: u32 = 7;

pub const TATU_STAGE_ACTUATE: u32 = 1;
pub const TATU_STAGE_PHYSICS: u32 = 2;
pub const TATU_STAGE_SENSE: u32 = 3;
pub const TATU_STAGE_REACT: u32 = 4;
pub const TATU_STAGE_CLEAN: u32 = 5;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_stage {
    pub size: u32,
    pub reserved: u32,
    pub run: Option<unsafe extern "C" fn(WorldPtr, u32, f64) -> tatu_status>,
}

pub const TATU_LOG_ERROR: u32 = 1;
pub const TATU_LOG_WARNING: u32 = 2;
pub const TATU_LOG_INFO: u32 = 3;
pub const TATU_LOG_DEBUG: u32 = 4;
pub const TATU_LOG_STATUS: u32 = 5;
pub const TATU_LOG_CLEAR: u32 = 6;
pub const TATU_LOG_CONSOLE: u32 = 7;
pub const TATU_LOG_CONSOLE_CLEAR: u32 = 8;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_log {
    pub size: u32,
    pub reserved: u32,
    pub write: Option<unsafe extern "C" fn(*const tatu_host, WorldPtr, u32, tatu_str)>,
    pub last_error: Option<unsafe extern "C" fn(WorldPtr) -> *const tatu_error>,
}

pub const TATU_FILE_READ: u32 = 1;
pub const TATU_FILE_WRITE: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_files {
    pub size: u32,
    pub reserved: u32,
    pub resolve: Option<unsafe extern "C" fn(WorldPtr, tatu_str, u32, *mut tatu_str) -> tatu_status>,
}

pub const TATU_FIGURE_STREAM: u32 = 1;
pub const TATU_FIGURE_CURVE: u32 = 2;
pub const TATU_FIGURE_COPY: u32 = 3;
pub const TATU_FIGURE_DRAWING: u32 = 4;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_figures {
    pub size: u32,
    pub reserved: u32,
    pub add: Option<unsafe extern "C" fn(WorldPtr, tatu_object, u32, *const tatu_value, *mut i64) -> tatu_status>,
    pub change: Option<unsafe extern "C" fn(WorldPtr, tatu_object, i64, *const tatu_value) -> tatu_status>,
    pub put: Option<unsafe extern "C" fn(WorldPtr, tatu_object, i64, *const f64, u64, *mut u64) -> tatu_status>,
    pub record: Option<unsafe extern "C" fn(WorldPtr, tatu_object, f64) -> tatu_status>,
    pub list: Option<unsafe extern "C" fn(WorldPtr, tatu_object, u32, *mut i64, u32, *mut u32) -> tatu_status>,
    pub get: Option<unsafe extern "C" fn(WorldPtr, tatu_object, i64, u32, *mut tatu_value) -> tatu_status>,
    pub part: Option<unsafe extern "C" fn(WorldPtr, tatu_object, u32, *mut tatu_value) -> tatu_status>,
}
