//! The tables of the host's services in `tatu/host.h`, and of the service in `tatu/vrep.h` that creates stand-ins for
//! missing objects.

use core::ffi::{CStr, c_void};

use super::{args::*, ext::*, frozen::*, types::*};

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
pub const TATU_KIND_PART: i32 = 11;

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
pub const TATU_HOST_EDITS: &CStr = c"tatu.host.edits/draft.4";

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_scene {
    pub size: u32,
    pub reserved: u32,
    pub prop: Option<unsafe extern "C" fn(*const tatu_host, LentCStr<'_>) -> tatu_prop>,
    pub get:
        Option<for<'a> extern "C" fn(WorldRef<'a>, tatu_object, tatu_prop, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub set: Option<extern "C" fn(WorldRef<'_>, tatu_object, tatu_prop, Option<&ValueRef<'_>>) -> tatu_status>,
    pub get_f64: Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, tatu_prop, *mut f64, u32) -> tatu_status>,
    pub set_f64: Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, tatu_prop, *const f64, u32) -> tatu_status>,
    pub get_f64_many:
        Option<unsafe extern "C" fn(WorldRef<'_>, *const tatu_object, u32, tatu_prop, *mut f64, u32) -> tatu_status>,
    pub set_f64_many:
        Option<unsafe extern "C" fn(WorldRef<'_>, *const tatu_object, u32, tatu_prop, *const f64, u32) -> tatu_status>,
    pub pose: Option<extern "C" fn(WorldRef<'_>, tatu_object, tatu_object, Option<&mut [f64; 7]>) -> tatu_status>,
    pub set_pose: Option<extern "C" fn(WorldRef<'_>, tatu_object, tatu_object, Option<&[f64; 7]>) -> tatu_status>,
    pub look:
        Option<extern "C" fn(WorldRef<'_>, tatu_object, Option<&mut tatu_object>, Option<&mut i32>) -> tatu_status>,
    pub find: Option<extern "C" fn(WorldRef<'_>, tatu_object, Lent<'_>, Option<&mut tatu_object>) -> tatu_status>,
    pub create: Option<
        extern "C" fn(WorldRef<'_>, LentCStr<'_>, tatu_object, Lent<'_>, Option<&mut tatu_object>) -> tatu_status,
    >,
    pub remove: Option<unsafe extern "C" fn(WorldRef<'_>, *const tatu_object, u32) -> tatu_status>,
    pub list: Option<
        unsafe extern "C" fn(
            WorldRef<'_>,
            tatu_object,
            u32,
            u32,
            *mut tatu_object,
            u32,
            Option<&mut u32>,
        ) -> tatu_status,
    >,
    pub copy: Option<unsafe extern "C" fn(WorldRef<'_>, *const tatu_object, u32, *mut tatu_object) -> tatu_status>,
    pub load: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, tatu_object, Option<&mut tatu_object>) -> tatu_status>,
    pub save: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, tatu_object) -> tatu_status>,
    pub row: Option<for<'a> extern "C" fn(WorldRef<'a>, tatu_object, u32, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub model: Option<for<'a> extern "C" fn(WorldRef<'a>, u32, Option<&mut ValueRef<'a>>) -> tatu_status>,
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
    pub made: Option<extern "C" fn(WorldRef<'_>) -> tatu_status>,
    pub object: Option<
        extern "C" fn(WorldRef<'_>, tatu_object, Lent<'_>, LentCStr<'_>, Option<&mut tatu_object>) -> tatu_status,
    >,
    pub used: Option<extern "C" fn(WorldRef<'_>, tatu_object, LentCStr<'_>) -> tatu_status>,
    pub parent: Option<extern "C" fn(WorldRef<'_>, tatu_object) -> tatu_status>,
    pub child: Option<extern "C" fn(WorldRef<'_>, tatu_object, LentCStr<'_>) -> tatu_status>,
    pub script: Option<extern "C" fn(WorldRef<'_>, tatu_object) -> tatu_status>,
    pub value: Option<extern "C" fn(WorldRef<'_>, tatu_object, Lent<'_>) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_readings {
    pub size: u32,
    pub reserved: u32,
    pub field: Option<extern "C" fn(WorldRef<'_>, tatu_object, tatu_prop, Option<&mut tatu_field_view>) -> tatu_status>,
    pub sense_now: Option<extern "C" fn(WorldRef<'_>, tatu_object, tatu_object) -> tatu_status>,
    pub reset: Option<extern "C" fn(WorldRef<'_>, tatu_object) -> tatu_status>,
    pub list: Option<
        unsafe extern "C" fn(WorldRef<'_>, LentCStr<'_>, *mut tatu_object, u32, Option<&mut u32>) -> tatu_status,
    >,
    pub describe: Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, u32, *mut tatu_field) -> tatu_status>,
    pub look: Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, *const tatu_look) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_bodies {
    pub size: u32,
    pub reserved: u32,
    pub twist: Option<extern "C" fn(WorldRef<'_>, tatu_object, Option<&mut [f64; 6]>) -> tatu_status>,
    pub set_twist: Option<extern "C" fn(WorldRef<'_>, tatu_object, Option<&[f64; 6]>) -> tatu_status>,
    pub push: Option<extern "C" fn(WorldRef<'_>, tatu_object, Option<&[f64; 3]>, Option<&[f64; 3]>) -> tatu_status>,
    pub impulse: Option<extern "C" fn(WorldRef<'_>, tatu_object, Option<&[f64; 3]>, Option<&[f64; 3]>) -> tatu_status>,
    pub contacts: Option<
        unsafe extern "C" fn(WorldRef<'_>, tatu_object, *mut tatu_contact, u32, Option<&mut u32>) -> tatu_status,
    >,
    pub closest: Option<
        unsafe extern "C" fn(
            WorldRef<'_>,
            *const tatu_object,
            u32,
            *const tatu_object,
            u32,
            f64,
            Option<&mut [f64; 6]>,
            Option<&mut [tatu_object; 2]>,
        ) -> tatu_status,
    >,
    pub is_dynamic: Option<extern "C" fn(WorldRef<'_>, tatu_object, Option<&mut u32>) -> tatu_status>,
    pub frictions:
        Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, *mut f64, u32, Option<&mut u32>) -> tatu_status>,
    pub closest_at: Option<
        unsafe extern "C" fn(
            WorldRef<'_>,
            *const tatu_object,
            *const [f64; 7],
            u32,
            *const tatu_object,
            u32,
            f64,
            Option<&mut [f64; 6]>,
            Option<&mut [tatu_object; 2]>,
        ) -> tatu_status,
    >,
    pub hook: Option<extern "C" fn(WorldRef<'_>, tatu_object, tatu_object, tatu_object, u32) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_commands {
    pub size: u32,
    pub reserved: u32,
    pub find: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, Option<&mut u32>) -> u32>,
    pub is_name_space: Option<extern "C" fn(WorldRef<'_>, Lent<'_>) -> u32>,
    pub count: Option<extern "C" fn(WorldRef<'_>) -> u32>,
    pub describe: Option<extern "C" fn(WorldRef<'_>, u32) -> *const tatu_command>,
    pub call: Option<unsafe extern "C" fn(WorldRef<'_>, *mut tatu_call) -> tatu_status>,
    pub generation: Option<extern "C" fn(WorldRef<'_>) -> u64>,
    pub constant: Option<for<'a> extern "C" fn(WorldRef<'a>, Lent<'_>, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub prelude: Option<
        for<'a> extern "C" fn(
            WorldRef<'a>,
            LentCStr<'_>,
            u32,
            Option<&mut Lent<'a>>,
            Option<&mut Lent<'a>>,
        ) -> tatu_status,
    >,
    pub mark: Option<extern "C" fn(WorldRef<'_>) -> u64>,
    pub alloc: Option<extern "C" fn(WorldRef<'_>, u64) -> *mut c_void>,
    pub release: Option<unsafe extern "C" fn(WorldRef<'_>, u64)>,
    pub retain: Option<extern "C" fn(WorldRef<'_>, tatu_func, Option<&mut tatu_func>) -> tatu_status>,
    pub drop: Option<extern "C" fn(WorldRef<'_>, tatu_func)>,
    pub call_func: Option<unsafe extern "C" fn(WorldRef<'_>, tatu_func, *mut tatu_call) -> tatu_status>,
    pub constant_name: Option<for<'a> extern "C" fn(WorldRef<'a>, u32, Option<&mut Lent<'a>>) -> tatu_status>,
    pub wake: Option<unsafe extern "C" fn(*const tatu_host, u64, Lent<'_>) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_scripts {
    pub size: u32,
    pub reserved: u32,
    pub list:
        Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, *mut tatu_object, u32, Option<&mut u32>) -> tatu_status>,
    pub call: Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, Lent<'_>, *mut tatu_call) -> tatu_status>,
    pub broadcast:
        Option<unsafe extern "C" fn(WorldRef<'_>, Lent<'_>, *const tatu_value, u32, tatu_object) -> tatu_status>,
    pub options: Option<for<'a> extern "C" fn(WorldRef<'a>, tatu_object, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub add: Option<
        extern "C" fn(
            WorldRef<'_>,
            tatu_object,
            Lent<'_>,
            Lent<'_>,
            Lent<'_>,
            Lent<'_>,
            Lent<'_>,
            Option<&mut tatu_object>,
        ) -> tatu_status,
    >,
    pub call_below: Option<
        unsafe extern "C" fn(WorldRef<'_>, tatu_object, u32, *const tatu_value, u32, Option<&mut u32>) -> tatu_status,
    >,
    pub text: Option<for<'a> extern "C" fn(WorldRef<'a>, tatu_object, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub change: Option<extern "C" fn(WorldRef<'_>, tatu_object, Lent<'_>) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_events {
    pub size: u32,
    pub reserved: u32,
    pub publish: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, Option<&ValueRef<'_>>) -> tatu_status>,
    pub subscribe: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, tatu_func, Option<&mut u64>) -> tatu_status>,
    pub unsubscribe: Option<extern "C" fn(WorldRef<'_>, u64) -> tatu_status>,
    pub wanted: Option<extern "C" fn(WorldRef<'_>, Lent<'_>) -> u32>,
    pub declared:
        Option<for<'a> extern "C" fn(WorldRef<'a>, u32, Option<&mut Lent<'a>>, Option<&mut Lent<'a>>) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_signals {
    pub size: u32,
    pub reserved: u32,
    pub get: Option<for<'a> extern "C" fn(WorldRef<'a>, u32, Lent<'_>, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub set: Option<extern "C" fn(WorldRef<'_>, u32, Lent<'_>, Option<&ValueRef<'_>>) -> tatu_status>,
    pub clear: Option<extern "C" fn(WorldRef<'_>, u32, Lent<'_>) -> u32>,
    pub name: Option<for<'a> extern "C" fn(WorldRef<'a>, u32, u32, Option<&mut Lent<'a>>) -> tatu_status>,
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
    pub request: Option<extern "C" fn(WorldRef<'_>, u32) -> tatu_status>,
    pub wake: Option<unsafe extern "C" fn(*mut tatu_session)>,
    pub worlds:
        Option<unsafe extern "C" fn(*mut tatu_session, *mut *mut tatu_world, u32, Option<&mut u32>) -> tatu_status>,
    pub client: Option<extern "C" fn(WorldRef<'_>, u64) -> tatu_status>,
    pub state: Option<extern "C" fn(WorldRef<'_>) -> u32>,
    pub input:
        Option<for<'a> extern "C" fn(WorldRef<'a>, u64, Option<&mut Lent<'a>>, Option<&mut Lent<'a>>) -> tatu_status>,
    pub put_in: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, Lent<'_>) -> tatu_status>,
    pub open: Option<extern "C" fn(WorldRef<'_>, Lent<'_>) -> tatu_status>,
    pub observed: Option<for<'a> extern "C" fn(WorldRef<'a>, Lent<'_>, Option<&mut Lent<'a>>) -> tatu_status>,
    pub observe: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, Lent<'_>) -> tatu_status>,
    pub interrupted: Option<extern "C" fn(WorldRef<'_>) -> u32>,
    pub function: Option<extern "C" fn(WorldRef<'_>, u32, Option<&mut tatu_func>) -> tatu_status>,
    pub stop: Option<unsafe extern "C" fn(*mut tatu_session)>,
    pub must_return: Option<extern "C" fn(WorldRef<'_>) -> u32>,
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
    pub run: Option<extern "C" fn(WorldRef<'_>, u32, f64) -> tatu_status>,
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
    pub write: Option<unsafe extern "C" fn(*const tatu_host, WorldRef<'_>, u32, Lent<'_>)>,
    pub last_error: Option<unsafe extern "C" fn(WorldRef<'_>) -> *const tatu_error>,
}

pub const TATU_FILE_READ: u32 = 1;
pub const TATU_FILE_WRITE: u32 = 2;
pub const TATU_FILE_APPEND: u32 = 4;
pub const TATU_FILE_UPDATE: u32 = 8;
pub const TATU_FILE_NEW: u32 = 16;
pub const TATU_FILE_FOLDERS: u32 = 32;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_files {
    pub size: u32,
    pub reserved: u32,
    pub resolve: Option<for<'a> extern "C" fn(WorldRef<'a>, Lent<'_>, u32, Option<&mut Lent<'a>>) -> tatu_status>,
    pub open: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, u32, Option<&mut i64>) -> tatu_status>,
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
    pub add:
        Option<extern "C" fn(WorldRef<'_>, tatu_object, u32, Option<&ValueRef<'_>>, Option<&mut i64>) -> tatu_status>,
    pub change: Option<extern "C" fn(WorldRef<'_>, tatu_object, i64, Option<&ValueRef<'_>>) -> tatu_status>,
    pub put:
        Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, i64, *const f64, u64, Option<&mut u64>) -> tatu_status>,
    pub record: Option<extern "C" fn(WorldRef<'_>, tatu_object, f64) -> tatu_status>,
    pub list:
        Option<unsafe extern "C" fn(WorldRef<'_>, tatu_object, u32, *mut i64, u32, Option<&mut u32>) -> tatu_status>,
    pub get:
        Option<for<'a> extern "C" fn(WorldRef<'a>, tatu_object, i64, u32, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub part: Option<for<'a> extern "C" fn(WorldRef<'a>, tatu_object, u32, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub image: Option<for<'a> extern "C" fn(WorldRef<'a>, tatu_object, u32, Option<&mut ValueRef<'a>>) -> tatu_status>,
}

pub const TATU_OPEN_FILE: u32 = 0;
pub const TATU_OPEN_NEW: u32 = 1;
pub const TATU_OPEN_RECOVERED: u32 = 2;
pub const TATU_SAVE_OVER: u32 = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_host_edits {
    pub size: u32,
    pub reserved: u32,
    pub begin: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, Lent<'_>) -> tatu_status>,
    pub end: Option<extern "C" fn(WorldRef<'_>, u32) -> tatu_status>,
    pub step_back: Option<for<'a> extern "C" fn(WorldRef<'a>, u32, Option<&mut Lent<'a>>) -> tatu_status>,
    pub state: Option<for<'a> extern "C" fn(WorldRef<'a>, Option<&mut ValueRef<'a>>) -> tatu_status>,
    pub save: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, u32) -> tatu_status>,
    pub copy: Option<extern "C" fn(WorldRef<'_>, u32) -> tatu_status>,
    pub open: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, u32) -> tatu_status>,
    pub add: Option<extern "C" fn(WorldRef<'_>, Lent<'_>, tatu_object, Option<&mut tatu_object>) -> tatu_status>,
    pub kind: Option<for<'a> extern "C" fn(WorldRef<'a>, u32, Option<&mut ValueRef<'a>>) -> tatu_status>,
}
