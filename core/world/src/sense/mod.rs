//! Sensors: who is due, their beams, their readings.
//!
//! - [`Sensing`]: the world's devices and their host-owned readings;
//! - `device`: one sensor's instance and its last reading;
//! - `due`: who measures by itself in a step;
//! - `plan`: what a device sends out, as its plugin told;
//! - `reading_arena`: the memory of readings;
//! - `targets`: the scene as beams and images see it;
//! - `aim`: rays that plugins move and turn before they are cast;
//! - `draw`: random numbers that depend on nothing but seed, sensor and count;
//! - `normal`: those of the normal distribution;
//! - `noise`: what a scene declares for the fields of a sensor, done after each measure;
//! - `measure`: batches by kind: beams cast together, one call of the plugin.

mod aim;
mod cast;
mod device;
mod due;
mod image;
mod measure;
mod noise;
mod normal;
mod outline;
mod plan;
mod random;
mod reading_arena;
mod targets;

pub(crate) use cast::Limits;
pub(crate) use device::{Device, Layout};
pub(crate) use due::{Roll, Turn};
pub use measure::{Around, Job, MeasureOptions, Moment, measure};
pub(crate) use noise::{Memory, Noise};
pub use outline::Edge;
pub(crate) use outline::edges;
pub(crate) use plan::BeamPlan;
pub(crate) use reading_arena::ReadingBuffer;
pub use targets::Targets;

use std::rc::Rc;

use tatu_plugins::Registry;
use tatu_scene::{Data, Scene};

/// The sensors of a world.
#[derive(Default)]
pub struct Sensing {
    pub(crate) devices: Vec<Device>,
    /// Index plus one of each slot's device; 0: it has none.
    by_slot: Vec<u32>,
    /// Of each kind.
    rolls: Vec<Rc<Roll>>,
    /// Room for the turn of a sensor that is told to measure.
    alone: Turn,
    pub(crate) targets: Targets,
    /// The version of the scene's settings that all devices have taken up.
    settled: Option<u64>,
    /// Whether `rolls` are of the devices as they are.
    listed: bool,
    arena: reading_arena::ReadingArena,
    scratch: measure::MeasureScratch,
}

impl Sensing {
    /// Adds a device.
    pub(crate) fn add(&mut self, mut device: Device) {
        device.shelve(&mut self.arena);
        self.put(device);
    }
    fn put(&mut self, device: Device) {
        self.note(&device, self.devices.len());
        self.devices.push(device);
        self.unsettle();
    }
    /// Something has changed that is taken up from the scene.
    pub(crate) fn unsettle(&mut self) {
        self.settled = None;
    }
    /// Something has changed by which it depends who measures, or how.
    pub(crate) fn unlist(&mut self) {
        self.listed = false;
    }
    /// The scene is another one: nothing is known of it.
    pub(crate) fn forget_scene(&mut self) {
        (self.targets, self.settled) = (Targets::default(), None);
    }
    /// Lets all devices take up what the scene says of them now: their rates, say, and their noise.
    pub(crate) fn settle(&mut self, scene: &Scene, registry: &Registry) {
        if self.settled.replace(scene.sensor_version) == Some(scene.sensor_version) {
            return;
        }
        for d in &mut self.devices {
            let Some(Data::Sensor(s)) = scene.get(d.slot).map(|o| &o.data) else { continue };
            (d.explicit, d.rate) = (s.explicit, s.rate);
            if d.rate <= 0.0 {
                d.period = None;
            }
            Noise::follow(&mut d.noise, s.noise.as_ref(), &registry.sensors[d.kind]);
        }
        self.unlist();
    }
    fn note(&mut self, device: &Device, index: usize) {
        let slot = device.slot as usize;
        if self.by_slot.len() <= slot {
            self.by_slot.resize(slot + 1, 0);
        }
        self.by_slot[slot] = index as u32 + 1;
    }
    /// The layout of one of the last sensors, if it is the same.
    pub(crate) fn like(&self, layout: &Layout) -> Option<Rc<Layout>> {
        let last = self.devices.iter().rev().take(LOOK_BACK).map(|d| &d.layout);
        last.into_iter().find(|l| ***l == *layout).cloned()
    }
    /// The index of a sensor's device.
    pub(crate) fn index(&self, slot: u32) -> Option<usize> {
        self.by_slot.get(slot as usize).and_then(|i| (*i as usize).checked_sub(1))
    }
    /// The device of a sensor.
    pub(crate) fn device(&self, slot: u32) -> Option<&Device> {
        self.index(slot).map(|i| &self.devices[i])
    }
    /// The instances of sensors that are gone.
    pub(crate) fn take_gone(&mut self, alive: impl Fn(&Device) -> bool) -> Vec<Device> {
        if self.devices.iter().all(&alive) {
            return Vec::new();
        }
        let (keep, gone): (Vec<_>, Vec<_>) = std::mem::take(&mut self.devices).into_iter().partition(alive);
        self.by_slot.clear();
        self.unsettle();
        keep.into_iter().for_each(|d| self.put(d));
        gone
    }
}

/// Among how many sensors before it one views for its like: about a robot's.
const LOOK_BACK: usize = 64;
