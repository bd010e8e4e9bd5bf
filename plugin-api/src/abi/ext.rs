//! The tables of everything that plugins offer: `tatu/command.h`, `sensor.h`, `actuator.h`, `model.h`, `importer.h`,
//! `script.h`, `service.h` and `event.h`.

use core::{
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
};

use super::{args::*, frozen::*, types::*};

pub const TATU_COMMAND: &CStr = c"tatu.command/draft.4";
pub const TATU_SENSOR: &CStr = c"tatu.sensor/draft.4";
pub const TATU_ACTUATOR: &CStr = c"tatu.actuator/draft.4";
pub const TATU_MODEL: &CStr = c"tatu.model/draft.4";
pub const TATU_IMPORTER: &CStr = c"tatu.importer/draft.4";
pub const TATU_SCRIPT: &CStr = c"tatu.script/draft.4";
pub const TATU_SERVICE: &CStr = c"tatu.service/draft.4";
pub const TATU_EVENT: &CStr = c"tatu.event/draft.4";

pub const TATU_UNTIL_STEPS: u32 = 1;
pub const TATU_UNTIL_TIME: u32 = 2;
pub const TATU_UNTIL_SIGNAL: u32 = 3;
pub const TATU_UNTIL_POLL: u32 = 4;
pub const TATU_UNTIL_WAKE: u32 = 5;

#[repr(C)]
pub struct tatu_call_api {
    pub size: u32,
    pub reserved: u32,
    pub alloc: Option<unsafe extern "C" fn(*mut tatu_call, u64) -> *mut c_void>,
    pub wait: Option<unsafe extern "C" fn(*mut tatu_call, u32, f64, tatu_str, u64) -> tatu_status>,
    pub ticket: Option<unsafe extern "C" fn(*mut tatu_call, *mut u64) -> tatu_status>,
    pub woken: Option<unsafe extern "C" fn(*mut tatu_call, *mut tatu_str) -> tatu_status>,
}

pub const TATU_CALLER_HOST: u32 = 0;
pub const TATU_CALLER_SCRIPT: u32 = 1;
pub const TATU_CALLER_NATIVE: u32 = 2;
pub const TATU_CALLER_REMOTE: u32 = 3;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_call {
    pub size: u32,
    pub command: u32,
    pub alias: u32,
    pub n_args: u32,
    pub args: *const tatu_value,
    pub results: *mut tatu_value,
    pub results_cap: u32,
    pub n_results: u32,
    pub world: *mut tatu_world,
    pub self_: *mut c_void,
    pub instance: *mut c_void,
    pub state: *mut c_void,
    pub user: *const c_void,
    pub api: *const tatu_call_api,
    pub error: *mut tatu_error,
    pub wait_token: u64,
    pub resume: u64,
    pub caller: u64,
    pub caller_object: tatu_object,
    pub caller_script: tatu_object,
    pub caller_dialect: tatu_str,
    pub caller_kind: u32,
    pub flags: u32,
}

impl tatu_call {
    /// Returns an empty call, whose `size` is 0.
    pub const fn empty() -> tatu_call {
        tatu_call {
            size: 0,
            command: 0,
            alias: 0,
            n_args: 0,
            args: null(),
            results: null_mut(),
            results_cap: 0,
            n_results: 0,
            world: null_mut(),
            self_: null_mut(),
            instance: null_mut(),
            state: null_mut(),
            user: null(),
            api: null(),
            error: null_mut(),
            wait_token: 0,
            resume: 0,
            caller: 0,
            caller_object: 0,
            caller_script: 0,
            caller_dialect: tatu_str { ptr: null(), len: 0 },
            caller_kind: 0,
            flags: 0,
        }
    }
}

pub const TATU_CALL_RAISE: u32 = 1;
pub const TATU_CALL_SIDE_BY_SIDE: u32 = 2;
pub const TATU_COMMAND_RAW: u32 = 1;
pub const TATU_COMMAND_SIDE_BY_SIDE: u32 = 2;
pub const TATU_NAME_OLD_ERRORS: u32 = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_name {
    pub size: u32,
    pub flags: u32,
    pub name: *const c_char,
    pub n_on_error: u32,
    pub reserved: u32,
    pub on_error: *const tatu_value,
    pub on_error_until: *const c_char,
}

pub const TATU_COMMAND_FULL: u32 = 0;
pub const TATU_COMMAND_PARTIAL: u32 = 1;
pub const TATU_COMMAND_STUB: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_command {
    pub size: u32,
    pub flags: u32,
    pub names: *const *const tatu_name,
    pub params: *const *const tatu_param,
    pub returns: *const *const tatu_param,
    pub text: *const c_char,
    pub example: *const c_char,
    pub no_wait: *const c_char,
    pub user: *const c_void,
    pub call: Option<unsafe extern "C" fn(*mut tatu_call) -> tatu_status>,
    pub status: u32,
    pub reserved: u32,
    pub notes: *const c_char,
    pub subject: *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_constant {
    pub size: u32,
    pub reserved: u32,
    pub name: *const c_char,
    pub value: tatu_value,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_prelude {
    pub size: u32,
    pub reserved: u32,
    pub language: *const c_char,
    pub module: *const c_char,
    pub text: tatu_str,
}

pub const TATU_MARK_LAST_LINE: u32 = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_kind_mark {
    pub size: u32,
    pub flags: u32,
    pub language: *const c_char,
    pub kind: *const c_char,
    pub word: *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_command {
    pub size: u32,
    pub reserved: u32,
    pub commands: *const *const tatu_command,
    pub constants: *const *const tatu_constant,
    pub preludes: *const *const tatu_prelude,
    pub per_world: *const tatu_life,
    pub kind_marks: *const *const tatu_kind_mark,
}

pub const TATU_BEAMS_NONE: u32 = 0;
pub const TATU_BEAMS_RAYS: u32 = 1;
pub const TATU_BEAMS_GRID: u32 = 2;
pub const TATU_BEAMS_CONE: u32 = 3;
pub const TATU_BEAMS_PYRAMID: u32 = 4;
pub const TATU_BEAMS_CYLINDER: u32 = 5;
pub const TATU_BEAMS_DISC: u32 = 6;
pub const TATU_BEAMS_PARALLEL: u32 = 7;

pub const TATU_BEAMS_NO_FRONT: u32 = 1;
pub const TATU_BEAMS_NO_BACK: u32 = 2;
pub const TATU_BEAMS_SKIP_MODEL: u32 = 4;
pub const TATU_BEAMS_VISIBLE: u32 = 8;
pub const TATU_BEAMS_OCCLUDE: u32 = 16;
pub const TATU_BEAMS_AIMED: u32 = 32;

pub const TATU_WAVES_ULTRASONIC: u32 = 16;
pub const TATU_WAVES_INFRARED: u32 = 32;
pub const TATU_WAVES_LASER: u32 = 64;
pub const TATU_WAVES_INDUCTIVE: u32 = 128;
pub const TATU_WAVES_CAPACITIVE: u32 = 256;
pub const TATU_WAVES_ALL: u32 = 65535;

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct tatu_beams {
    pub size: u32,
    pub form: u32,
    pub count: [u32; 2],
    pub near_m: f64,
    pub far_m: f64,
    pub dims: [f64; 6],
    pub max_incidence: f64,
    pub directions: *const f64,
    pub flags: u32,
    pub reserved: u32,
    pub waves: u32,
    pub reserved2: u32,
    pub own: [u32; 4],
    pub without: u32,
    pub reserved3: u32,
    pub origins: *const f64,
    pub observed: tatu_object,
    pub n_targets: u32,
    pub reserved4: u32,
}

pub const TATU_IN_DISTANCE: u32 = 1;
pub const TATU_IN_POINT: u32 = 2;
pub const TATU_IN_NORMAL: u32 = 4;
pub const TATU_IN_OBJECT: u32 = 8;
pub const TATU_IN_POSE: u32 = 16;
pub const TATU_IN_TWIST: u32 = 32;
pub const TATU_IN_COLOR: u32 = 64;
pub const TATU_IN_COSINE: u32 = 128;
pub const TATU_IN_PRIMITIVE: u32 = 256;
pub const TATU_IN_ACCELERATION: u32 = 512;
pub const TATU_IN_JOINT: u32 = 1024;
pub const TATU_IN_CONTACTS: u32 = 2048;
pub const TATU_IN_WRENCH: u32 = 4096;
pub const TATU_IN_HIT_TWIST: u32 = 8192;
pub const TATU_IN_TARGETS: u32 = 16384;

pub const TATU_SENSOR_EVERY_PHYSICS_STEP: u32 = 1;

pub const TATU_DIM_ROWS: u32 = 4294967295;
pub const TATU_DIM_COLUMNS: u32 = 4294967294;
pub const TATU_DIM_OWN: u32 = 4294967280;
pub const TATU_DIM_TARGETS: u32 = 4294967293;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_field {
    pub size: u32,
    pub elem: u32,
    pub dims: [u32; 3],
    pub flags: u32,
    pub name: *const c_char,
    pub unit: *const c_char,
    pub text: *const c_char,
    pub valid: *const c_char,
    pub nothing: *const c_char,
}

impl tatu_field {
    /// Returns an empty field, whose `size` is 0.
    pub const fn empty() -> tatu_field {
        tatu_field {
            size: 0,
            elem: 0,
            dims: [0; 3],
            flags: 0,
            name: null(),
            unit: null(),
            text: null(),
            valid: null(),
            nothing: null(),
        }
    }
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_random {
    pub size: u32,
    pub reserved: u32,
    pub ctx: *mut c_void,
    pub uniform: Option<unsafe extern "C" fn(*const tatu_random, u32, u64, u64, *mut f64)>,
    pub normal: Option<unsafe extern "C" fn(*const tatu_random, u32, u64, u64, *mut f64)>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_sensor_batch {
    pub size: u32,
    pub n: u32,
    pub n_fields: u32,
    pub reserved: u32,
    pub time: f64,
    pub step: u64,
    pub data: *const *mut c_void,
    pub state: *const *mut c_void,
    pub sensor: *const tatu_object,
    pub first_beam: *const u64,
    pub distance: *const f64,
    pub point: *const f64,
    pub normal: *const f64,
    pub object: *const tatu_object,
    pub pose: *const f64,
    pub twist: *const f64,
    pub fields: *const *mut c_void,
    pub status: *mut tatu_status,
    pub color: *const u8,
    pub primitive: *const u32,
    pub first_pixel: *const u64,
    pub depth: *const f32,
    pub pixel_color: *const u8,
    pub pixel_cosine: *const f32,
    pub pixel_object: *const tatu_object,
    pub random: *const tatu_random,
    pub rays: *const *mut f64,
    pub lengths: *const *const u64,
    pub dt: f64,
    pub gravity: [f64; 3],
    pub acceleration: *const f64,
    pub joint: *const f64,
    pub first_contact: *const u64,
    pub contact: *const tatu_contact,
    pub friction: *const f64,
    pub wrench: *const f64,
    pub hit_twist: *const f64,
    pub first_target: *const u64,
    pub target: *const tatu_object,
    pub target_pose: *const f64,
    pub target_twist: *const f64,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_preset {
    pub size: u32,
    pub reserved: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub settings: *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_sensor {
    pub size: u32,
    pub inputs: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub schemas: *const *const c_char,
    pub params: *const *const tatu_param,
    pub fields: *const *const tatu_field,
    pub life: *const tatu_life,
    pub beams: Option<unsafe extern "C" fn(*mut c_void, *mut tatu_beams, *mut tatu_error) -> tatu_status>,
    pub measure: Option<unsafe extern "C" fn(*mut c_void, *const tatu_sensor_batch, *mut tatu_error) -> tatu_status>,
    pub presets: *const *const tatu_preset,
    pub finish: Option<unsafe extern "C" fn(*mut c_void, *const tatu_sensor_batch, *mut tatu_error) -> tatu_status>,
    pub aim: Option<unsafe extern "C" fn(*mut c_void, *const tatu_sensor_batch, *mut tatu_error) -> tatu_status>,
    pub flags: u32,
    pub reserved: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_sensor {
    pub size: u32,
    pub reserved: u32,
    pub kinds: *const *const tatu_sensor,
}

pub const TATU_ACTUATOR_EVERY_SUBSTEP: u32 = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_actuator_batch {
    pub size: u32,
    pub n: u32,
    pub time: f64,
    pub dt: f64,
    pub data: *const *mut c_void,
    pub state: *const *mut c_void,
    pub actuator: *const tatu_object,
    pub pose: *const f64,
    pub twist: *const f64,
    pub joint: *const f64,
    pub command: *const *const f64,
    pub wrench: *mut f64,
    pub effort: *mut f64,
    pub status: *mut tatu_status,
    pub fields: *const *mut c_void,
    pub lengths: *const *const u64,
    pub n_fields: u32,
    pub reserved: u32,
    pub first_target: *const u64,
    pub target: *const tatu_object,
    pub target_pose: *const f64,
    pub target_twist: *const f64,
    pub target_wrench: *mut f64,
    pub first_contact: *const u64,
    pub contact: *const tatu_contact,
    pub friction: *const f64,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_actuator {
    pub size: u32,
    pub flags: u32,
    pub n_commands: u32,
    pub reserved: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub params: *const *const tatu_param,
    pub commands: *const *const tatu_param,
    pub life: *const tatu_life,
    pub apply: Option<unsafe extern "C" fn(*mut c_void, *const tatu_actuator_batch, *mut tatu_error) -> tatu_status>,
    pub schemas: *const *const c_char,
    pub fields: *const *const tatu_field,
    pub inputs: u32,
    pub reserved2: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_actuator {
    pub size: u32,
    pub reserved: u32,
    pub kinds: *const *const tatu_actuator,
}

pub const TATU_REPORT_NOTE: u32 = 0;
pub const TATU_REPORT_WARNING: u32 = 1;
pub const TATU_REPORT_ERROR: u32 = 2;
pub const TATU_REPORT_LACK: u32 = 3;

#[repr(C)]
pub struct tatu_builder {
    pub size: u32,
    pub reserved: u32,
    pub ctx: *mut c_void,
    pub object: Option<extern "C" fn(Option<&tatu_builder>, LentCStr<'_>, u32, Lent<'_>) -> u32>,
    pub set: Option<extern "C" fn(Option<&tatu_builder>, u32, LentCStr<'_>, Option<&ValueRef<'_>>) -> tatu_status>,
    pub mesh: Option<unsafe extern "C" fn(Option<&tatu_builder>, *const f64, u64, *const u32, u64) -> u64>,
    pub image: Option<unsafe extern "C" fn(Option<&tatu_builder>, *const u8, u32, u32) -> u64>,
    pub script: Option<
        extern "C" fn(Option<&tatu_builder>, u32, LentCStr<'_>, LentCStr<'_>, LentCStr<'_>, Lent<'_>, Lent<'_>) -> u32,
    >,
    pub device: Option<extern "C" fn(Option<&tatu_builder>, u32, LentCStr<'_>) -> tatu_status>,
    pub report: Option<extern "C" fn(Option<&tatu_builder>, u32, u32, Lent<'_>)>,
    pub file: Option<for<'a> extern "C" fn(Option<&'a tatu_builder>, Lent<'_>, Option<&mut Lent<'a>>) -> tatu_status>,
    pub describe: Option<extern "C" fn(Option<&tatu_builder>, Option<&ValueRef<'_>>) -> tatu_status>,
    pub model: *const tatu_model,
    pub scene: Option<extern "C" fn(Option<&tatu_builder>, u32, Lent<'_>, Lent<'_>) -> tatu_status>,
    pub textured_mesh:
        Option<unsafe extern "C" fn(Option<&tatu_builder>, *const f64, *const f32, u64, *const u32, u64) -> u64>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_model_slot {
    pub size: u32,
    pub reserved: u32,
    pub alias: *const c_char,
    pub mount: *const c_char,
    pub text: *const c_char,
    pub payload: f64,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_model_number {
    pub size: u32,
    pub reserved: u32,
    pub name: *const c_char,
    pub value: tatu_value,
    pub unit: *const c_char,
    pub source: *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_model {
    pub size: u32,
    pub flags: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub params: *const *const tatu_param,
    pub slots: *const *const c_char,
    pub build: Option<
        unsafe extern "C" fn(*mut c_void, *const tatu_builder, *const tatu_value, *mut tatu_error) -> tatu_status,
    >,
    pub category: *const c_char,
    pub licence: *const c_char,
    pub mounts: *const *const c_char,
    pub slot_infos: *const *const tatu_model_slot,
    pub numbers: *const *const tatu_model_number,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_model {
    pub size: u32,
    pub reserved: u32,
    pub models: *const *const tatu_model,
    pub read: Option<
        unsafe extern "C" fn(*mut c_void, tatu_str, tatu_str, *mut *const tatu_model, *mut tatu_error) -> tatu_status,
    >,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_importer {
    pub size: u32,
    pub reserved: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub suffixes: *const *const c_char,
    pub params: *const *const tatu_param,
    pub sniff: Option<unsafe extern "C" fn(*mut c_void, tatu_str) -> u32>,
    pub load: Option<
        unsafe extern "C" fn(
            *mut c_void,
            tatu_str,
            *const tatu_builder,
            *const tatu_value,
            *mut tatu_error,
        ) -> tatu_status,
    >,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_importer {
    pub size: u32,
    pub reserved: u32,
    pub importers: *const *const tatu_importer,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct tatu_budget {
    pub size: u32,
    pub reserved: u32,
    pub instructions: u64,
    pub memory: u64,
}

pub const TATU_SCRIPT_SILENT: u32 = 1;
pub const TATU_SCRIPT_MODERN: u32 = 2;
pub const TATU_SCRIPT_THREADED: u32 = 4;
pub const TATU_LANGUAGE_SIDE_BY_SIDE: u32 = 1;
pub const TATU_ORDER_PARENTS_FIRST: u32 = 1;
pub const TATU_ORDER_BY_KIND: u32 = 2;
pub const TATU_ORDER_DEEPEST_FIRST: u32 = 3;
pub const TATU_FIND_CALLBACK: u32 = 0;
pub const TATU_FIND_FUNCTION: u32 = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_language {
    pub size: u32,
    pub flags: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub suffixes: *const *const c_char,
    pub life: *const tatu_life,
    pub load: Option<
        unsafe extern "C" fn(*mut c_void, tatu_str, tatu_str, tatu_str, *mut tatu_str, *mut tatu_error) -> tatu_status,
    >,
    pub find: Option<unsafe extern "C" fn(*mut c_void, u32, tatu_str) -> u32>,
    pub call: Option<
        unsafe extern "C" fn(
            *mut c_void,
            u32,
            *mut tatu_call,
            *const tatu_budget,
            *mut u64,
            *mut tatu_error,
        ) -> tatu_status,
    >,
    pub resume: Option<
        unsafe extern "C" fn(
            *mut c_void,
            u64,
            tatu_status,
            *mut tatu_call,
            *const tatu_budget,
            *mut u64,
            *mut tatu_error,
        ) -> tatu_status,
    >,
    pub keep_func: Option<unsafe extern "C" fn(*mut c_void, u32) -> u32>,
    pub drop_func: Option<unsafe extern "C" fn(*mut c_void, u32)>,
    pub call_func: Option<
        unsafe extern "C" fn(
            *mut c_void,
            u32,
            *mut tatu_call,
            *const tatu_budget,
            *mut u64,
            *mut tatu_error,
        ) -> tatu_status,
    >,
    pub knows_dialect: Option<unsafe extern "C" fn(*mut c_void, tatu_str, *mut tatu_error) -> tatu_status>,
    pub traits: Option<unsafe extern "C" fn(*mut c_void) -> u32>,
    pub order: Option<unsafe extern "C" fn(*mut c_void, tatu_str, u32) -> u32>,
    pub place: Option<unsafe extern "C" fn(*mut c_void, *mut tatu_error)>,
    pub permission: *const c_char,
    pub params: *const *const tatu_param,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_script {
    pub size: u32,
    pub reserved: u32,
    pub languages: *const *const tatu_language,
}

pub const TATU_GO: tatu_status = 0;
pub const TATU_HOLD: tatu_status = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_service {
    pub size: u32,
    pub flags: u32,
    pub id: *const c_char,
    pub text: *const c_char,
    pub params: *const *const tatu_param,
    pub life: *const tatu_life,
    pub barrier: Option<unsafe extern "C" fn(*mut c_void, *mut tatu_world, u64, *mut tatu_error) -> tatu_status>,
    pub event: Option<
        unsafe extern "C" fn(*mut c_void, *mut tatu_world, tatu_str, *const tatu_value, *mut tatu_error) -> tatu_status,
    >,
    pub resume: Option<
        unsafe extern "C" fn(
            *mut c_void,
            *mut tatu_world,
            u64,
            tatu_status,
            *const tatu_call,
            *mut tatu_error,
        ) -> tatu_status,
    >,
    pub events: *const *const c_char,
    pub call_func: Option<unsafe extern "C" fn(*mut c_void, *mut tatu_world, u32, *mut tatu_call) -> tatu_status>,
    pub last: Option<unsafe extern "C" fn(*mut c_void, *mut tatu_world, *mut tatu_error) -> tatu_status>,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_service {
    pub size: u32,
    pub reserved: u32,
    pub services: *const *const tatu_service,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_event {
    pub size: u32,
    pub reserved: u32,
    pub name: *const c_char,
    pub text: *const c_char,
    pub fields: *const *const tatu_param,
}

/// The function of a plugin that receives events.
pub type HeardFn = unsafe extern "C" fn(
    *mut c_void,
    *mut c_void,
    *mut c_void,
    *mut tatu_world,
    tatu_str,
    *const tatu_value,
    *mut tatu_error,
) -> tatu_status;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct tatu_ext_event {
    pub size: u32,
    pub reserved: u32,
    pub events: *const *const tatu_event,
    pub heard: Option<HeardFn>,
    pub listens: *const *const c_char,
}
