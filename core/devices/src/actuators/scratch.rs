//! The actuators of a batch, and buffers for their inputs and outputs.

use std::ffi::c_void;

use tatu_physics::Engine;
use tatu_plugin_api::abi::*;
use tatu_plugins::guarded_array::GuardedArray;

use crate::{
    contacts::{BodyContacts, ContactColumns},
    listed::{EngineTarget, TargetColumns},
    mount::{Mount, MountMotion},
};

/// An actuator in a batch, with its index in [`Actuators::devices`], its mount, its commands and its targets.
pub(super) struct BatchActuator {
    pub device: usize,
    pub mount: Mount,
    pub commands: Vec<f64>,
    /// `None` stands for a missing object.
    pub targets: Vec<Option<EngineTarget>>,
}

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
    pub listed: TargetColumns,
    pub target_wrench: GuardedArray<[f64; 6]>,
    pub contacts: ContactColumns,
}

impl ApplyScratch {
    /// Adds the targets and contacts of the actuators, if their kind requires them. Returns the motions of all targets.
    pub fn add_inputs(
        &mut self,
        seats: &[BatchActuator],
        inputs: u32,
        engine: &dyn Engine,
        contacts: Option<&BodyContacts>,
    ) -> Vec<Option<MountMotion>> {
        let mut motions = Vec::new();
        if inputs & TATU_IN_TARGETS != 0 {
            for seat in seats {
                self.listed.begin();
                for target in &seat.targets {
                    let motion = target.as_ref().map(|t| (t.object, t.motion(engine)));
                    self.listed.push(motion.as_ref().map(|(object, m)| (*object, &m.pose, m.twist)));
                    motions.push(motion.map(|(_, m)| m));
                }
            }
            self.listed.begin();
        }
        if let Some(contacts) = contacts.filter(|_| inputs & TATU_IN_CONTACTS != 0) {
            seats.iter().for_each(|seat| contacts.add(seat.mount.carrier(), &mut self.contacts));
            self.contacts.begin();
        }
        motions
    }

    /// Returns the wrenches of an actuator on its targets.
    pub fn target_wrenches(&self, i: usize) -> &[[f64; 6]] {
        match self.listed.first.get(i..i + 2) {
            Some([first, end]) => &self.target_wrench[*first as usize..*end as usize],
            _ => &[],
        }
    }

    /// Copies all commands to a buffer that plugins may read.
    pub fn copy_commands(&mut self, seats: &[BatchActuator]) {
        self.commands.fill(seats.iter().map(|s| s.commands.len()).sum(), 0.0);
        let first = self.commands.first_mut();
        let mut at = 0;
        for seat in seats {
            self.commands[at..at + seat.commands.len()].copy_from_slice(&seat.commands);
            self.command.push(first.wrapping_add(at));
            at += seat.commands.len();
        }
    }

    /// Describes where a plugin wrote out of bounds, if it did.
    pub fn out_of_bounds_write(&self, seats: &[BatchActuator]) -> Option<&'static str> {
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        match () {
            () if !self.wrench.guards_intact() => Some("outside `wrench` of its batch"),
            () if !self.target_wrench.guards_intact() => Some("outside `target_wrench` of its batch"),
            () if !self.effort.guards_intact() => Some("outside `effort` of its batch"),
            () if !self.status.guards_intact() => Some("outside `status` of its batch"),
            () if !self.commands.guards_intact()
                || !self.commands.iter().zip(seats.iter().flat_map(|s| &s.commands)).all(same) =>
            {
                Some("to `command` of its batch, which is read-only")
            }
            () => None,
        }
    }

    pub fn clear(&mut self) {
        self.data.clear();
        self.state.clear();
        self.actuator.clear();
        self.pose.clear();
        self.twist.clear();
        self.joint.clear();
        self.command.clear();
        self.fields.clear();
        self.lengths.clear();
        self.listed.clear();
        self.contacts.clear();
    }

    pub fn batch(&mut self, n: usize, (time, dt): (f64, f64)) -> tatu_actuator_batch {
        self.wrench.fill(n, [0.0; 6]);
        self.effort.fill(n, 0.0);
        self.status.fill(n, TATU_OK);
        self.target_wrench.fill(self.listed.object.len(), [0.0; 6]);
        // The arrays of inputs that the kind does not declare are null.
        fn some<T>(declared: bool, all: &[T]) -> *const T {
            if declared { all.as_ptr() } else { std::ptr::null() }
        }
        let (lists, touches) = (!self.listed.first.is_empty(), !self.contacts.first_contact.is_empty());
        tatu_actuator_batch {
            size: size_of::<tatu_actuator_batch>() as u32,
            n: n as u32,
            time,
            dt,
            data: self.data.as_ptr(),
            state: self.state.as_ptr(),
            actuator: self.actuator.as_ptr(),
            pose: self.pose.as_ptr().cast(),
            twist: self.twist.as_ptr().cast(),
            joint: self.joint.as_ptr().cast(),
            command: self.command.as_ptr(),
            wrench: self.wrench.first_mut().cast(),
            effort: self.effort.first_mut(),
            status: self.status.first_mut(),
            fields: self.fields.as_ptr(),
            lengths: self.lengths.as_ptr(),
            n_fields: (self.fields.len() / n.max(1)) as u32,
            reserved: 0,
            first_target: some(lists, &self.listed.first),
            target: some(lists, &self.listed.object),
            target_pose: some(lists, &self.listed.pose).cast(),
            target_twist: some(lists, &self.listed.twist).cast(),
            target_wrench: if lists { self.target_wrench.first_mut().cast() } else { std::ptr::null_mut() },
            first_contact: some(touches, &self.contacts.first_contact),
            contact: some(touches, &self.contacts.contact),
            friction: some(touches, &self.contacts.friction).cast(),
        }
    }
}
