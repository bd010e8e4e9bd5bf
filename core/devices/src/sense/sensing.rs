//! The sensors of a world, and their readings.

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
    /// All sensors; batches refer to them by index.
    pub devices: Vec<Device>,
    /// For each slot, the index of its device plus one, or 0 if it has no device.
    by_slot: Vec<u32>,
    /// Lists of devices by kind.
    pub(super) rolls: Vec<Rc<Roll>>,
    /// A reusable turn for a sensor that is measured on request.
    pub(super) alone: Turn,
    /// The targets of beams and images.
    pub targets: Targets,
    /// The version of the scene's sensor settings that all devices have applied.
    settled: Option<u64>,
    /// The version of the scene's shapes for which the selections of objects were evaluated, if any sensor has one.
    chosen: Option<u64>,
    /// Whether `rolls` is up to date.
    pub(super) listed: bool,
    arena: ReadingArena,
    /// Sizes of the memory that all devices need; see [`Layout::bytes`].
    bytes: [u64; 2],
    pub(super) scratch: MeasureScratch,
}

/// Maximum size of the readings and images of all sensors, bytes. `estimate`: a thousand depth cameras of 640 x 480
/// pixels with points fit; larger scenes fit into the memory of few computers.
const MOST_BYTES: u64 = 4 << 30;
/// Size up to which the system is not asked whether it can provide the memory, bytes.
const SMALL: u64 = 64 << 20;
/// Memory that must remain for everything else, bytes. `estimate`: the program with a typical scene.
const REST: u64 = 128 << 20;

impl Sensing {
    /// Adds a device.
    pub fn add(&mut self, mut device: Device) {
        device.shelve(&mut self.arena);
        self.put(device);
    }
    fn put(&mut self, device: Device) {
        self.bytes = sum(self.bytes, device.layout.bytes());
        self.note(&device, self.devices.len());
        self.devices.push(device);
        self.unsettle();
    }
    /// Checks that there is memory for a sensor with a layout. `old` is the present layout of the sensor, if any. All
    /// images may be rendered at once, so their memory is counted although it is used only meanwhile.
    pub fn check_room(&self, layout: &Layout, old: Option<&Layout>) -> Result<(), String> {
        let own = layout.bytes();
        let known = old.map_or(self.bytes, |old| less(self.bytes, old.bytes()));
        let all = sum(known, own);
        let (own_total, total) = (own[0] + own[1], all[0].saturating_add(all[1]));
        let told = |why: &str| {
            format!(
                "it needs about {} MB, and all sensors together {} MB, {why}; choose fewer pixels or sensors",
                own_total >> 20,
                total >> 20
            )
        };
        if total > MOST_BYTES {
            return Err(told(&format!("but the limit is {} MB", MOST_BYTES >> 20)));
        }
        // The readings of the other sensors have been allocated.
        let missing = own[0] + all[1] + REST;
        let is_there = || usize::try_from(missing).is_ok_and(|n| Vec::<u8>::new().try_reserve_exact(n).is_ok());
        match total > SMALL && !is_there() {
            true => Err(told("which the system cannot provide (`ulimit -v`, or the job's limit)")),
            false => Ok(()),
        }
    }
    /// Changes the layout of the device with this slot and id. Returns the device, or `None` if it does not exist.
    pub fn lay_out(&mut self, slot: u32, id: u64, layout: Rc<Layout>) -> Option<&mut Device> {
        let device = self.devices.iter_mut().find(|d| d.slot == slot && d.id == id)?;
        self.bytes = sum(less(self.bytes, device.layout.bytes()), layout.bytes());
        device.lay_out(layout);
        Some(device)
    }
    /// Marks the sensor settings of the scene as changed.
    pub fn unsettle(&mut self) {
        self.settled = None;
    }
    /// Marks the lists of due sensors as out of date.
    pub fn relist(&mut self) {
        self.listed = false;
    }
    /// Discards all data derived from the scene, which has been replaced.
    pub fn forget_scene(&mut self) {
        (self.targets, self.settled) = (Targets::default(), None);
    }
    /// Applies the scene's current settings, such as rates and noise, to all devices.
    pub fn settle(&mut self, scene: &Scene, registry: &Registry) {
        let settled = self.settled.replace(scene.sensor_version) == Some(scene.sensor_version);
        // Paths may refer to different objects if the tree has changed.
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
    /// Returns a layout that equals `layout` and belongs to one of the most recently added sensors, so that it can be
    /// shared.
    pub fn like(&self, layout: &Layout) -> Option<Rc<Layout>> {
        let last = self.devices.iter().rev().take(LOOK_BACK).map(|d| &d.layout);
        last.into_iter().find(|l| ***l == *layout).cloned()
    }
    /// Returns the index of the device of the object in a slot.
    pub fn index(&self, slot: u32) -> Option<usize> {
        self.by_slot.get(slot as usize).and_then(|i| (*i as usize).checked_sub(1))
    }
    /// Returns whether any sensor measures after each physics step.
    pub fn in_physics(&self, registry: &Registry) -> bool {
        self.devices.iter().any(|d| registry.sensors[d.kind].in_physics() && !d.off)
    }
    /// Returns the devices of a kind.
    pub fn of_kind(&self, kind: usize) -> impl Iterator<Item = &Device> {
        self.devices.iter().filter(move |d| d.kind == kind)
    }
    /// Returns the device of the object in a slot.
    pub fn device(&self, slot: u32) -> Option<&Device> {
        self.index(slot).map(|i| &self.devices[i])
    }
    /// Removes and returns the devices for which `alive` is `false`.
    pub fn take_gone(&mut self, alive: impl Fn(&Device) -> bool) -> Vec<Device> {
        if self.devices.iter().all(&alive) {
            return Vec::new();
        }
        let (keep, gone): (Vec<_>, Vec<_>) = std::mem::take(&mut self.devices).into_iter().partition(alive);
        self.by_slot.clear();
        self.bytes = [0; 2];
        self.unsettle();
        keep.into_iter().for_each(|d| self.put(d));
        gone
    }
}

fn sum(a: [u64; 2], b: [u64; 2]) -> [u64; 2] {
    [a[0].saturating_add(b[0]), a[1].saturating_add(b[1])]
}

fn less(a: [u64; 2], b: [u64; 2]) -> [u64; 2] {
    [a[0].saturating_sub(b[0]), a[1].saturating_sub(b[1])]
}

/// Number of preceding sensors that are searched for an equal layout: about as many as a robot has.
const LOOK_BACK: usize = 64;
