//! Buffers for a batch of sensors, and the table of pointers to them that is passed to a plugin.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;
use tatu_plugins::{border::ErrorSlot, guarded_array::GuardedArray};

use super::{
    aim::AimedRays,
    cast::{BeamCasts, SensorView},
    image::BatchImages,
    noise::HeldReading,
    random::RandomKey,
};
use crate::{contacts::ContactColumns, listed::TargetColumns};

/// The time of a measurement.
#[derive(Debug, Clone, Copy)]
pub struct MeasureTime {
    /// Simulation time, s.
    pub time: f64,
    /// Index of the step, counted from 0.
    pub step: u64,
    /// Duration of the step, s.
    pub dt: f64,
    /// Gravity in the world frame, m/s^2.
    pub gravity: [f64; 3],
}

/// Buffers reused by every batch, so that a step does not allocate.
#[derive(Default)]
pub(super) struct MeasureScratch {
    pub casts: BeamCasts,
    pub aims: AimedRays,
    /// For each sensor, its pose and limits; they are needed for aimed rays, which are added later.
    pub views: Vec<SensorView>,
    pub frames: BatchImages,
    pub motion: MotionColumns,
    pub contacts: ContactColumns,
    pub listed: TargetColumns,
    pub instances: InstanceColumns,
    pub fields: Vec<*mut c_void>,
    pub lengths: Vec<*const u64>,
    pub status: GuardedArray<tatu_status>,
    pub keys: Vec<RandomKey>,
    /// For each sensor, the reading that remains visible, if readings are delayed.
    pub shown: Vec<Option<HeldReading>>,
    pub error: Option<ErrorSlot>,
}

/// Motion of the sensors and of what their beams hit, and the states of the joints and force sensors that they observe.
#[derive(Default)]
pub(super) struct MotionColumns {
    pub pose: Vec<[f64; 7]>,
    pub twist: Vec<[f64; 6]>,
    pub acceleration: Vec<[f64; 6]>,
    pub joint: Vec<[f64; 3]>,
    /// The loads of the force sensors that they observe.
    pub wrench: Vec<[f64; 6]>,
    /// For each beam, the velocity of the object that was hit.
    pub hit_twist: Vec<[f64; 6]>,
}

/// The plugin's instances, their state blocks, and their objects.
#[derive(Default)]
pub(super) struct InstanceColumns {
    pub data: Vec<*mut c_void>,
    pub state: Vec<*mut c_void>,
    pub sensor: Vec<tatu_object>,
}

impl MeasureScratch {
    pub fn clear(&mut self) {
        self.casts.clear();
        self.aims.clear();
        self.views.clear();
        self.frames.clear();
        self.motion.pose.clear();
        self.motion.twist.clear();
        self.motion.acceleration.clear();
        self.motion.joint.clear();
        self.motion.hit_twist.clear();
        self.motion.wrench.clear();
        self.contacts.clear();
        self.listed.clear();
        self.instances.data.clear();
        self.instances.state.clear();
        self.instances.sensor.clear();
        self.fields.clear();
        self.lengths.clear();
        self.keys.clear();
        self.shown.clear();
    }

    pub fn batch(&mut self, n: usize, n_fields: usize, moment: &MeasureTime) -> tatu_sensor_batch {
        fn some<T>(v: &[T]) -> *const T {
            if v.is_empty() { std::ptr::null() } else { v.as_ptr() }
        }
        tatu_sensor_batch {
            size: size_of::<tatu_sensor_batch>() as u32,
            n: n as u32,
            n_fields: n_fields as u32,
            reserved: 0,
            time: moment.time,
            step: moment.step,
            data: some(&self.instances.data),
            state: some(&self.instances.state),
            sensor: some(&self.instances.sensor),
            first_beam: some(&self.casts.first),
            distance: some(&self.casts.distance),
            point: some(&self.casts.point).cast(),
            normal: some(&self.casts.normal).cast(),
            object: some(&self.casts.object),
            pose: some(&self.motion.pose).cast(),
            twist: some(&self.motion.twist).cast(),
            fields: some(&self.fields),
            status: self.status.first_mut(),
            color: some(&self.casts.color).cast(),
            primitive: some(&self.casts.primitive),
            first_pixel: some(&self.frames.first),
            depth: some(&self.frames.depth),
            pixel_color: some(&self.frames.color).cast(),
            pixel_cosine: some(&self.frames.cosine),
            pixel_object: some(&self.frames.object),
            random: std::ptr::null(),
            rays: some(&self.aims.places),
            lengths: some(&self.lengths),
            dt: moment.dt,
            gravity: moment.gravity,
            acceleration: some(&self.motion.acceleration).cast(),
            joint: some(&self.motion.joint).cast(),
            first_contact: some(&self.contacts.first_contact),
            contact: some(&self.contacts.contact),
            friction: some(&self.contacts.friction).cast(),
            wrench: some(&self.motion.wrench).cast(),
            hit_twist: some(&self.motion.hit_twist).cast(),
            first_target: some(&self.listed.first),
            target: some(&self.listed.object),
            target_pose: some(&self.listed.pose).cast(),
            target_twist: some(&self.listed.twist).cast(),
        }
    }
}
