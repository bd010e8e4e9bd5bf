//! The sensors of a world, and their readings.

use std::rc::Rc;

use tatu_plugin_api::abi::TATU_IN_TARGETS;
use tatu_plugins::{Registry, reading_arena::ReadingArena};
use tatu_scene::{ObjectVariant, Scene, SensorTargets};

use super::{
    device::{ChosenObjects, FieldLayout, SensorDevice},
    noise::SensorNoise,
    roster::{DueSensors, SensorRoster},
    scratch::MeasureScratch,
    targets::Targets,
};
use crate::listed::find_all;

/// The sensors of a world.
#[derive(Default)]
pub struct Sensing {
    /// All sensors; batches refer to them by index.
    pub devices: Vec<SensorDevice>,
    /// For each slot, the index of its device plus one, or 0 if it has no device.
    by_slot: Vec<u32>,
    /// Lists of devices by kind.
    pub(super) rosters: Vec<Rc<SensorRoster>>,
    /// A reusable selection for a sensor that is measured on request.
    pub(super) single_sensor: DueSensors,
    /// The targets of beams and images.
    pub targets: Targets,
    /// The version of the scene's sensor settings that all devices have applied.
    applied_settings: Option<u64>,
    /// The version of the scene's shapes for which the selections of objects were evaluated, if any sensor has one.
    chosen: Option<u64>,
    /// Whether `rosters` is up to date.
    pub(super) rosters_current: bool,
    arena: ReadingArena,
    /// Sizes of the memory that all devices need; see [`FieldLayout::bytes`].
    bytes: [u64; 2],
    pub(super) scratch: MeasureScratch,
}

/// Maximum size of the readings and images of all sensors, bytes. This is an estimate: it suffices for a thousand depth
/// cameras of 640 x 480 pixels with points, and few computers have the memory for larger scenes.
const MAX_BYTES: u64 = 4 << 30;
/// Size up to which it is not checked whether the system can provide the memory, bytes.
const UNCHECKED_BYTES: u64 = 64 << 20;
/// Memory that must remain available for everything else, bytes; an estimate for the program with a typical scene.
const RESERVED_BYTES: u64 = 128 << 20;

impl Sensing {
    /// Adds a device.
    pub fn add(&mut self, mut device: SensorDevice) {
        device.move_to_arena(&mut self.arena);
        self.insert(device);
    }
    fn insert(&mut self, device: SensorDevice) {
        self.bytes = sum(self.bytes, device.layout.memory_bytes());
        self.index_device(&device, self.devices.len());
        self.devices.push(device);
        self.invalidate_settings();
    }
    /// Checks that there is memory for a sensor with a layout. `old` is the present layout of the sensor, if any. All
    /// images may be rendered at once, so their memory is counted although it is used only during rendering.
    pub fn check_memory(&self, layout: &FieldLayout, old: Option<&FieldLayout>) -> Result<(), String> {
        let own = layout.memory_bytes();
        let known = old.map_or(self.bytes, |old| less(self.bytes, old.memory_bytes()));
        let all = sum(known, own);
        let (own_total, total) = (own[0] + own[1], all[0].saturating_add(all[1]));
        let told = |why: &str| {
            format!(
                "the sensor needs about {} MB, and all sensors together {} MB, {why}; use fewer pixels or sensors",
                own_total >> 20,
                total >> 20
            )
        };
        if total > MAX_BYTES {
            return Err(told(&format!("but the limit is {} MB", MAX_BYTES >> 20)));
        }
        // The readings of the other sensors have been allocated.
        let missing = own[0] + all[1] + RESERVED_BYTES;
        let is_there = || usize::try_from(missing).is_ok_and(|n| Vec::<u8>::new().try_reserve_exact(n).is_ok());
        match total > UNCHECKED_BYTES && !is_there() {
            true => Err(told("which the system cannot provide (`ulimit -v`, or the job's limit)")),
            false => Ok(()),
        }
    }
    /// Changes the layout of the device with this slot and id. Returns the device, or `None` if it does not exist.
    pub fn set_layout(&mut self, slot: u32, id: u64, layout: Rc<FieldLayout>) -> Option<&mut SensorDevice> {
        let device = self.devices.iter_mut().find(|d| d.slot == slot && d.id == id)?;
        self.bytes = sum(less(self.bytes, device.layout.memory_bytes()), layout.memory_bytes());
        device.set_layout(layout);
        Some(device)
    }
    /// Marks the sensor settings of the scene as changed.
    pub fn invalidate_settings(&mut self) {
        self.applied_settings = None;
    }
    /// Marks the lists of due sensors as out of date.
    pub fn invalidate_rosters(&mut self) {
        self.rosters_current = false;
    }
    /// Discards all data derived from the scene, which has been replaced.
    pub fn discard_scene(&mut self) {
        (self.targets, self.applied_settings) = (Targets::default(), None);
    }
    /// Applies the scene's current settings, such as rates and noise, to all devices.
    pub fn apply_settings(&mut self, scene: &Scene, registry: &Registry) {
        let settled = self.applied_settings.replace(scene.versions.sensor) == Some(scene.versions.sensor);
        // Paths may refer to different objects if the tree has changed.
        if settled && (self.chosen.is_none() || self.chosen == Some(scene.versions.shape)) {
            return;
        }
        self.targets.discard_choices();
        self.chosen = None;
        for d in &mut self.devices {
            let Some(ObjectVariant::Sensor(s)) = scene.get(d.slot).map(|o| &o.data) else { continue };
            (d.schedule.explicit, d.schedule.rate) = (s.explicit, s.rate);
            let takes_targets = registry.sensors[d.kind].raw.inputs & TATU_IN_TARGETS != 0;
            d.chosen = match s.view.as_deref() {
                None => ChosenObjects::default(),
                Some(view) if !takes_targets => {
                    ChosenObjects { choice: self.targets.choice(scene, d.slot, view), targets: Vec::new() }
                }
                Some(SensorTargets { targets, ignored }) => {
                    let beams = SensorTargets { targets: Vec::new(), ignored: ignored.clone() };
                    let choice = if ignored.is_empty() { 0 } else { self.targets.choice(scene, d.slot, &beams) };
                    ChosenObjects { choice, targets: find_all(scene, d.slot, targets).collect() }
                }
            };
            if s.view.is_some() {
                self.chosen = Some(scene.versions.shape);
            }
            if d.schedule.rate <= 0.0 {
                d.schedule.period = None;
            }
            SensorNoise::update(&mut d.noise, s.noise.as_ref(), &registry.sensors[d.kind]);
        }
        self.invalidate_rosters();
    }
    fn index_device(&mut self, device: &SensorDevice, index: usize) {
        let slot = device.slot as usize;
        if self.by_slot.len() <= slot {
            self.by_slot.resize(slot + 1, 0);
        }
        self.by_slot[slot] = index as u32 + 1;
    }
    /// Returns a layout that equals `layout` and belongs to one of the most recently added sensors, so that it can be
    /// shared.
    pub fn shared_layout(&self, layout: &FieldLayout) -> Option<Rc<FieldLayout>> {
        let last = self.devices.iter().rev().take(MAX_LAYOUT_COMPARISONS).map(|d| &d.layout);
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
    pub fn of_kind(&self, kind: usize) -> impl Iterator<Item = &SensorDevice> {
        self.devices.iter().filter(move |d| d.kind == kind)
    }
    /// Returns the device of the object in a slot.
    pub fn device(&self, slot: u32) -> Option<&SensorDevice> {
        self.index(slot).map(|i| &self.devices[i])
    }
    /// Removes and returns the devices for which `alive` is `false`.
    pub fn remove_dead(&mut self, alive: impl Fn(&SensorDevice) -> bool) -> Vec<SensorDevice> {
        if self.devices.iter().all(&alive) {
            return Vec::new();
        }
        let (keep, gone): (Vec<_>, Vec<_>) = std::mem::take(&mut self.devices).into_iter().partition(alive);
        self.by_slot.clear();
        self.bytes = [0; 2];
        self.invalidate_settings();
        keep.into_iter().for_each(|d| self.insert(d));
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
const MAX_LAYOUT_COMPARISONS: usize = 64;
