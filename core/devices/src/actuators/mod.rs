//! Actuators: their instances and commands, and what they do to bodies and joints.
//!
//! - [`Actuators`]: the world's actuators;
//! - `mount`: the body and the joint that an actuator acts on, and how they move;
//! - `apply`: one batch per kind: motions and commands in, wrenches and efforts out; `scratch`: its buffers.
//!
//! Actuators act as time passes: a kind is called once per advance of the engine, at its start, or, if it asks for it,
//! before each engine step. What an actuator is commanded stands in its object of the scene.

mod apply;
mod mount;
mod scratch;

use std::ffi::c_void;

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::state_block::StateBlock;

pub use apply::{Acts, ApplyFailure, SubSteps, per_step};

/// One actuator's instance.
pub struct Actuator {
    /// Generation and slot: a slot that is used again is another object.
    pub object: tatu_object,
    /// Its slot in the scene.
    pub slot: u32,
    /// Index of its kind in the registry.
    pub kind: usize,
    /// The plugin's own data.
    pub data: *mut c_void,
    /// What the plugin may write of its state.
    pub state: StateBlock,
    /// Values of its parameters, in the order of the kind's declaration.
    pub params: Vec<Value>,
    /// Disabled after a fault.
    pub off: bool,
    /// It has been reported that it has no effect.
    pub idle_told: bool,
}

/// The actuators of a world.
#[derive(Default)]
pub struct Actuators {
    /// In the order in which they were made.
    pub devices: Vec<Actuator>,
    scratch: scratch::ApplyScratch,
}

impl Actuators {
    /// The actuator of an object.
    pub fn device(&self, object: tatu_object) -> Option<&Actuator> {
        self.devices.iter().find(|d| d.object == object)
    }
    /// Its place in the list.
    pub fn index(&self, object: tatu_object) -> Option<usize> {
        self.devices.iter().position(|d| d.object == object)
    }
    /// Removes the instances of removed actuators.
    pub fn take_gone(&mut self, alive: impl Fn(&Actuator) -> bool) -> Vec<Actuator> {
        if self.devices.iter().all(&alive) {
            return Vec::new();
        }
        let (keep, gone) = std::mem::take(&mut self.devices).into_iter().partition(alive);
        self.devices = keep;
        gone
    }
}
