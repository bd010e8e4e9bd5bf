//! Buffers for a batch of actuators.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;
use tatu_plugins::guarded_array::GuardedArray;

/// Buffers reused by every batch, so that a step does not allocate.
#[derive(Default)]
pub(super) struct ApplyScratch {
    pub data: Vec<*mut c_void>,
    pub state: Vec<*mut c_void>,
    pub actuator: Vec<tatu_object>,
    pub pose: Vec<[f64; 7]>,
    pub twist: Vec<[f64; 6]>,
    pub joint: Vec<[f64; 2]>,
    pub command: Vec<*const f64>,
    /// The commands of all actuators of the batch, concatenated.
    pub commands: GuardedArray<f64>,
    pub fields: Vec<*mut c_void>,
    pub lengths: Vec<*const u64>,
    pub wrench: GuardedArray<[f64; 6]>,
    pub effort: GuardedArray<f64>,
    pub status: GuardedArray<tatu_status>,
}
