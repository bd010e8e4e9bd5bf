//! The sensors of a world and their host-owned readings.

use std::rc::Rc;

use tatu_plugins::Registry;
use tatu_scene::{Data, Scene};

use super::{
    device::{Device, Layout},
    noise::Noise,
    reading_arena::ReadingArena,
    scratch::MeasureScratch,
    targets::Targets,
    turn::{Roll, Turn},
};

/// The sensors of a world.
#[derive(Default)]
pub struct Sensing {
    /// All of them; a batch names them by index.
    pub devices: Vec<Device>,
    /// Index plus one of each slot's device; 0: it has none.
    by_slot: Vec<u32>,
    /// Of each kind.
    pub(super) rolls: Vec<Rc<Roll>>,
    /// The turn of a sensor that is measured on request.
    pub(super) alone: Turn,
    /// The scene as beams and images find it.
    pub targets: Targets,
    /// The version of the scene's settings that all devices have taken up.
    settled: Option<u64>,
    /// The version of the scene's shapes that choices of what sensors see are of.
    chosen: Option<u64>,
    /// Whether `rolls` are of the devices as they are.
    pub(super) listed: bool,
    arena: ReadingArena,
    pub(super) scratch: MeasureScratch,
}

impl Sensing {
    /// Adds a device.
    pub fn add(&mut self, mut device: Device) {
        device.shelve(&mut self.arena);
        self.put(device);
    }
    fn put(&mut self, device: Device) {
        self.note(&device, self.devices.len());
        self.devices.push(device);
        self.unsettle();
    }
    /// Marks that settings of the scene have changed.
    pub fn unsettle(&mut self) {
        self.settled = None;
    }
    /// Marks that the lists of due sensors are out of date.
    pub fn relist(&mut self) {
        self.listed = false;
    }
    /// Discards what was derived from the scene, which has been replaced.
    pub fn forget_scene(&mut self) {
        (self.targets, self.settled) = (Targets::default(), None);
    }
    /// Lets all devices take up what the scene says of them now: their rates, say, and their noise.
    pub fn settle(&mut self, scene: &Scene, registry: &Registry) {
        let settled = self.settled.replace(scene.sensor_version) == Some(scene.sensor_version);
        // Paths may lead elsewhere in a changed tree.
        if settled && (self.chosen.is_none() || self.chosen == Some(scene.shape_version)) {
            return;
        }
        self.targets.forget_choices();
        self.chosen = None;
        for d in &mut self.devices {
            let Some(Data::Sensor(s)) = scene.get(d.slot).map(|o| &o.data) else { continue };
            (d.explicit, d.rate) = (s.explicit, s.rate);
            d.choice = s.view.as_ref().map_or(0, |view| self.targets.choice(scene, d.slot, view));
            if s.view.is_some() {
                self.chosen = Some(scene.shape_version);
            }
            if d.rate <= 0.0 {
                d.period = None;
            }
            Noise::follow(&mut d.noise, s.noise.as_ref(), &registry.sensors[d.kind]);
        }
        self.relist();
    }
    fn note(&mut self, device: &Device, index: usize) {
        let slot = device.slot as usize;
        if self.by_slot.len() <= slot {
            self.by_slot.resize(slot + 1, 0);
        }
        self.by_slot[slot] = index as u32 + 1;
    }
    /// The layout of one of the last sensors, if it is the same.
    pub fn like(&self, layout: &Layout) -> Option<Rc<Layout>> {
        let last = self.devices.iter().rev().take(LOOK_BACK).map(|d| &d.layout);
        last.into_iter().find(|l| ***l == *layout).cloned()
    }
    /// The index of a sensor's device.
    pub fn index(&self, slot: u32) -> Option<usize> {
        self.by_slot.get(slot as usize).and_then(|i| (*i as usize).checked_sub(1))
    }
    /// The device of a sensor.
    pub fn device(&self, slot: u32) -> Option<&Device> {
        self.index(slot).map(|i| &self.devices[i])
    }
    /// Removes the instances of removed sensors.
    pub fn take_gone(&mut self, alive: impl Fn(&Device) -> bool) -> Vec<Device> {
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

/// How many preceding sensors to search for an equal layout: about as many as a robot has.
const LOOK_BACK: usize = 64;
