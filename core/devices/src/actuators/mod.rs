//! Actuators: their instances, their commands, and their effects on bodies and joints; and the instances of parts, which
//! are declared, created and saved as actuators are, but called with the world in hand.
//!
//! - [`Actuators`]: the world's actuators;
//! - `apply`: calls a kind with a batch of its actuators, which computes wrenches and efforts from poses, velocities
//!   and commands; `scratch`: the buffers of a batch; `parts`, `part_record`: what concerns only parts.
//!
//! Actuators act during physics: a kind is called once at the start of each advance of the engine or, on request,
//! before each engine step. The commands of an actuator are stored in its object in the scene.

mod apply;
mod part_record;
mod parts;
mod scratch;

use std::{ffi::c_void, rc::Rc};

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{SensorKind, state_block::StateBlock};

use crate::sense::{FieldLayout, ReadingBuffer, Sensing};

pub use apply::{ActuatorContext, ApplyFailure, PhysicsStepActuators, apply_per_advance};
pub use part_record::PartRecord;

/// The instance of an actuator or of a part.
pub struct Actuator {
    /// Handle of its object; the generation distinguishes it from a later object in the same slot.
    pub object: tatu_object,
    /// Slot of its object in the scene.
    pub slot: u32,
    /// Index of its kind in the registry.
    pub kind: usize,
    /// Pointer to the plugin's data of this instance.
    pub data: *mut c_void,
    /// The state block that the plugin writes to.
    pub state: StateBlock,
    /// Values of its parameters, in the order of the kind's declaration.
    pub params: Vec<Value>,
    /// Whether the actuator is disabled after a fault.
    pub off: bool,
    /// Whether it has been reported that the actuator has no effect or has failed. It is not reported again.
    pub idle_reported: bool,
    /// Its readings, if its kind declares any.
    pub report: Option<ActuatorReading>,
    /// The calls of a part; `None` for an actuator.
    pub part: Option<Box<PartRecord>>,
}

/// The readings that an actuator reports. They are copied to its device in [`Sensing`] after an advance.
pub struct ActuatorReading {
    /// The layout of the fields.
    pub layout: Rc<FieldLayout>,
    /// The contents of the fields after the last call.
    pub fields: ReadingBuffer,
    /// Simulation time of the last call, s; `None` if there was no call since the readings were last published.
    pub time: Option<f64>,
}

impl ActuatorReading {
    /// Creates readings whose values are 0.
    pub fn new(layout: Rc<FieldLayout>) -> Self {
        let mut fields = ReadingBuffer::new(layout.words());
        layout.clear(&mut fields);
        ActuatorReading { layout, fields, time: None }
    }
    /// Sets the values to those of an earlier reading with the same layout.
    pub fn restore(&mut self, fields: &[u64]) {
        if fields.len() == self.fields.len() {
            self.fields.copy_from_slice(fields);
            self.layout.set_guards(&mut self.fields);
        }
    }
    /// Returns an error if the plugin wrote outside its fields, or a value that is not a number.
    pub fn check(&self, kind: &SensorKind) -> Result<(), String> {
        if !self.layout.is_whole(&self.fields) {
            return Err("broke the contract: it wrote outside the fields that it reports".to_owned());
        }
        match self.layout.not_a_number(&self.fields, kind) {
            Some(field) => Err(format!("broke the contract: `{field}` is not a number")),
            None => Ok(()),
        }
    }
}

/// The actuators and parts of a world.
#[derive(Default)]
pub struct Actuators {
    /// All actuators and parts, in the order in which they were created. [`add`](Self::add) appends to it; a device may be
    /// replaced by another one of the same object.
    pub devices: Vec<Actuator>,
    /// Indices of the parts, by [`parts`](Self::parts); `None` if they must be listed again.
    roster: Option<Rc<[usize]>>,
    scratch: scratch::ApplyScratch,
}

impl Actuators {
    /// Adds an actuator or a part.
    pub fn add(&mut self, device: Actuator) {
        self.devices.push(device);
        self.roster = None;
    }
    /// Returns the actuator of an object.
    pub fn device(&self, object: tatu_object) -> Option<&Actuator> {
        self.devices.iter().find(|d| d.object == object)
    }
    /// Returns the index in [`Actuators::devices`] of the actuator of an object.
    pub fn index(&self, object: tatu_object) -> Option<usize> {
        self.devices.iter().position(|d| d.object == object)
    }
    /// Publishes the readings that actuators have reported since the last call, so that they can be read like those of
    /// sensors.
    pub fn publish(&mut self, sensing: &mut Sensing) {
        for d in self.devices.iter_mut() {
            let Some(report) = d.report.as_mut() else { continue };
            if let (Some(time), Some(i)) = (report.time.take(), sensing.index(d.slot)) {
                sensing.devices[i].store_report(time, &report.fields);
            }
        }
    }
    /// Removes and returns the actuators for which `alive` is `false`.
    pub fn remove_dead(&mut self, alive: impl Fn(&Actuator) -> bool) -> Vec<Actuator> {
        if self.devices.iter().all(&alive) {
            return Vec::new();
        }
        self.roster = None;
        let (keep, gone) = std::mem::take(&mut self.devices).into_iter().partition(alive);
        self.devices = keep;
        gone
    }
}
