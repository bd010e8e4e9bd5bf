//! Sensors: who is due, their beams, their readings.
//!
//! - [`Sensing`]: the world's devices and their host-owned readings;
//! - `plan`: what a device sends out, as its plugin told;
//! - `targets`: the scene as beams and images see it;
//! - `aim`: rays that plugins move and turn before they are cast;
//! - `draw`: random numbers that depend on nothing but seed, sensor and count;
//! - `normal`: those of the normal distribution;
//! - `noise`: what a scene declares for the fields of a sensor, done after each measure;
//! - `measure`: batches by kind: beams cast together, one call of the plugin.

mod aim;
mod cast;
mod draw;
mod image;
mod measure;
mod noise;
mod normal;
mod plan;
mod targets;

use std::{ffi::c_void, rc::Rc};

use tatu_plugin_api::{abi::*, safe::Value};

pub(crate) use cast::Limits;
pub use measure::{Around, Ask, Job, Moment, measure};
pub use noise::NoiseSpec;
pub(crate) use noise::{Memory, Noise};
pub(crate) use plan::BeamPlan;
pub use targets::Targets;

use crate::{
    host::{
        FieldInfo, Registry, SensorKind,
        instance::{Made, make},
        watchdog::Call,
    },
    scene::{Data, Scene},
    world::WorldCell,
};

/// One sensor's instance and its last reading.
///
/// There may be thousands, and each step goes through all: what a reading needs stands in the first line of the
/// processor's cache, what a measure needs in the first two.
#[repr(C, align(64))]
pub(crate) struct Device {
    /// The fields one after the other, each 8-byte aligned.
    pub fields: Vec<u64>,
    /// Shared by sensors that are alike.
    pub layout: Rc<Layout>,
    pub sequence: u64,
    pub time: f64,
    pub slot: u32,
    /// Switched off after a fault.
    pub off: bool,
    /// Measures only when it is told to, as the scene says.
    explicit: bool,
    pub kind: usize,
    pub data: *mut c_void,
    /// What is done to its fields after a measure; `None`: nothing.
    pub noise: Option<Box<Noise>>,
    /// From the scene's seed and the sensor: the key of its random numbers.
    pub seed: u64,
    /// How often it has measured since the start, resets or not: what random numbers are drawn by.
    pub drawn: u64,
    /// Hz, as the scene says; 0: it measures in each step.
    rate: f64,
    /// Of a sensor with a rate: the period in which it measured last.
    pub period: Option<u64>,
    pub state: Vec<u64>,
    pub id: u64,
    pub params: Vec<Value>,
}

/// The sensors of a world.
#[derive(Default)]
pub struct Sensing {
    pub(crate) devices: Vec<Device>,
    /// Index plus one of each slot's device; 0: it has none.
    by_slot: Vec<u32>,
    /// Of each kind, the indices of its devices.
    by_kind: Vec<Vec<usize>>,
    pub(crate) targets: Targets,
    /// The version of the scene's settings that all devices have taken up.
    settled: Option<u64>,
    pub(crate) scratch: measure::Scratch,
}

impl Sensing {
    /// Adds a device.
    pub(crate) fn add(&mut self, device: Device) {
        self.note(&device, self.devices.len());
        self.devices.push(device);
        self.settled = None;
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
            Noise::follow(&mut d.noise, s.noise.as_ref(), &registry.sensors[d.kind]);
        }
    }
    fn note(&mut self, device: &Device, index: usize) {
        let (slot, kind) = (device.slot as usize, device.kind);
        if self.by_kind.len() <= kind {
            self.by_kind.resize_with(kind + 1, Vec::new);
        }
        self.by_kind[kind].push(index);
        if self.by_slot.len() <= slot {
            self.by_slot.resize(slot + 1, 0);
        }
        self.by_slot[slot] = index as u32 + 1;
    }
    /// The layout of one of the last sensors, if it is the same.
    fn like(&self, layout: &Layout) -> Option<Rc<Layout>> {
        let last = self.devices.iter().rev().take(LOOK_BACK).map(|d| &d.layout);
        last.into_iter().find(|l| ***l == *layout).cloned()
    }
    /// The index of a sensor's device.
    pub(crate) fn index(&self, slot: u32) -> Option<usize> {
        self.by_slot.get(slot as usize).and_then(|i| (*i as usize).checked_sub(1))
    }
    /// Of the next devices of a kind, from the `from`-th on, those that measure by themselves at this time; how many were
    /// looked at. What they measured before may be seen now, whether they measure now or not.
    ///
    /// `threads`: how many will work on them.
    pub(crate) fn due(&mut self, kind: usize, from: usize, time: f64, threads: usize, due: &mut Vec<usize>) -> usize {
        due.clear();
        let together = if threads > 1 { TOGETHER * FOR_MANY } else { TOGETHER };
        let some = self.by_kind.get(kind).map_or(&[][..], |all| all.get(from..).unwrap_or_default());
        let some = &some[..some.len().min(together)];
        for i in some {
            let d = &mut self.devices[*i];
            if !d.off {
                d.release(time);
            }
            if d.is_due(time) {
                due.push(*i);
            }
        }
        some.len()
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
        self.by_kind.clear();
        keep.into_iter().for_each(|d| self.add(d));
        gone
    }
}

impl Device {
    /// Makes the instance of a sensor and asks for its beams. Must be called without any borrow of the world.
    pub fn create(
        world: &WorldCell,
        kind_index: usize,
        slot: u32,
        instance: tatu_instance,
        params: Vec<Value>,
    ) -> Result<Self, String> {
        let kind = &world.registry.sensors[kind_index];
        let seed = instance.seed;
        let Made { id, data, state } = make(world, kind.plugin, &kind.life, slot, instance, &params)?;
        let mut device = Device {
            fields: Vec::new(),
            layout: Rc::default(),
            sequence: 0,
            time: 0.0,
            slot,
            off: false,
            explicit: false,
            kind: kind_index,
            data,
            noise: None,
            seed,
            drawn: 0,
            rate: 0.0,
            period: None,
            state,
            id,
            params,
        };
        match Layout::ask(world, kind_index, slot, data) {
            Ok(layout) => device.lay_out(layout),
            Err(text) => {
                device.destroy(world);
                return Err(text);
            }
        }
        Ok(device)
    }

    /// Takes beams and fields. Where the fields have other sizes now, the last reading is forgotten.
    pub fn lay_out(&mut self, layout: Rc<Layout>) {
        if self.layout.spans != layout.spans {
            self.fields = vec![0; layout.words];
            self.forget();
        }
        self.layout = layout;
    }

    /// There is no reading any more, nor one under way.
    pub fn forget(&mut self) {
        self.sequence = 0;
        self.noise.iter_mut().for_each(|n| n.drop_held());
    }

    /// Whether it measures by itself at this time: not more than once in a period of its rate. Periods are counted from
    /// time 0, so that they do not drift.
    pub fn is_due(&mut self, time: f64) -> bool {
        if self.off || self.explicit {
            return false;
        }
        let now = (self.rate > 0.0).then(|| period(self.rate, time));
        std::mem::replace(&mut self.period, now) != now || now.is_none()
    }

    /// Before a measure, if readings are delayed: takes out the reading that is seen, and makes room for another.
    fn keep_shown(&mut self) -> Option<noise::Reading> {
        let noise = self.noise.as_ref().filter(|n| n.delays())?;
        let newest = noise.newest();
        let fields = std::mem::replace(&mut self.fields, vec![0; self.layout.words]);
        let shown = noise::Reading { time: self.time, sequence: self.sequence, fields };
        self.sequence = newest.unwrap_or(self.sequence);
        Some(shown)
    }

    /// After a measure: changes the fields as the scene declares.
    fn add_noise(&mut self, kind: &SensorKind, pool: &rayon::ThreadPool) {
        let Device { noise: Some(noise), fields, layout, seed, drawn, time, .. } = self else { return };
        // It has been counted already.
        let drawn = drawn.wrapping_sub(1);
        let spans = &layout.spans;
        noise.apply(noise::Measured { kind, seed: *seed, drawn, time: *time, fields, spans }, pool);
    }

    /// After a measure, if readings are delayed: the new one waits, and the newest that is old enough is seen.
    fn put_back(&mut self, shown: Option<noise::Reading>) {
        let (Some(shown), Some(noise)) = (shown, &mut self.noise) else { return };
        let (now, fields) = (self.time, std::mem::replace(&mut self.fields, shown.fields));
        noise.hold(noise::Reading { time: now, sequence: self.sequence, fields });
        (self.time, self.sequence) = (shown.time, shown.sequence);
        self.release(now);
    }

    /// Shows the newest reading that is old enough, if one was under way.
    pub fn release(&mut self, now: f64) {
        if let Some(r) = self.noise.as_mut().and_then(|n| n.release(now)) {
            (self.time, self.sequence, self.fields) = (r.time, r.sequence, r.fields);
        }
    }

    /// Ends the instance. Must be called without any borrow of the world.
    pub fn destroy(self, world: &WorldCell) {
        let kind = &world.registry.sensors[self.kind];
        if let Some(destroy) = kind.life.destroy {
            // SAFETY: made by `create`, given back once.
            world.cross_quietly(kind.plugin, Call::Destroy, self.slot, || unsafe { destroy(self.data) });
        }
    }

    /// A look at one field.
    pub fn view(&self, kind: &SensorKind, field: usize) -> tatu_field_view {
        let info = &kind.fields[field];
        let (first, n) = self.layout.spans[field];
        tatu_field_view {
            ptr: self.fields[first..].as_ptr().cast(),
            len: n as u64,
            elem: info.elem,
            dims: self.layout.plan.shape(info.dims),
            time: self.time,
            sequence: self.sequence,
        }
    }

    /// The first field that holds something that is no number. Nothing to be seen is infinity or zero, never this.
    pub fn not_a_number<'k>(&self, kind: &'k SensorKind) -> Option<&'k str> {
        let is_bad = |i: usize| {
            let (first, n) = self.layout.spans[i];
            let at = self.fields[first..].as_ptr();
            // SAFETY: the buffer has `n` elements of the declared type.
            unsafe {
                match kind.fields[i].elem {
                    TATU_ELEM_F64 => std::slice::from_raw_parts(at.cast::<f64>(), n).iter().any(|x| x.is_nan()),
                    TATU_ELEM_F32 => std::slice::from_raw_parts(at.cast::<f32>(), n).iter().any(|x| x.is_nan()),
                    _ => false,
                }
            }
        };
        (0..kind.fields.len()).find(|i| is_bad(*i)).map(|i| kind.fields[i].name.as_str())
    }

    /// A field's content as a value, for traces.
    pub fn value(&self, kind: &SensorKind, field: usize) -> Value {
        let (first, n) = self.layout.spans[field];
        let bytes = self.fields[first..].as_ptr();
        // SAFETY: the buffer has `n` elements of the declared type.
        unsafe {
            match kind.fields[field].elem {
                TATU_ELEM_F64 => Value::Floats(std::slice::from_raw_parts(bytes.cast(), n).to_vec()),
                TATU_ELEM_F32 => Value::Floats(
                    std::slice::from_raw_parts(bytes.cast::<f32>(), n).iter().map(|x| f64::from(*x)).collect(),
                ),
                TATU_ELEM_I32 => Value::Ints(
                    std::slice::from_raw_parts(bytes.cast::<i32>(), n).iter().map(|x| i64::from(*x)).collect(),
                ),
                TATU_ELEM_U16 => Value::Ints(
                    std::slice::from_raw_parts(bytes.cast::<u16>(), n).iter().map(|x| i64::from(*x)).collect(),
                ),
                TATU_ELEM_OBJECT => Value::Ints(
                    std::slice::from_raw_parts(bytes.cast::<u64>(), n).iter().map(|x| (x & 0xF_FFFF) as i64).collect(),
                ),
                _ => Value::Bytes(std::slice::from_raw_parts(bytes.cast::<u8>(), n).to_vec()),
            }
        }
    }
}

/// So many sensors measure together: what is noted of them stays in the processor's caches from the first look at whether
/// they are due to the last one at what they measured.
const TOGETHER: usize = 256;

/// With several threads so many times as many, or waking them up would take longer than what they do.
const FOR_MANY: usize = 8;

/// The number of the period of a rate that a time lies in. Times are sums of steps: one that lacks but their rounding is in
/// the period that it begins.
fn period(rate: f64, time: f64) -> u64 {
    (time * rate * (1.0 + 1e-12) + 1e-9).floor() as u64
}

/// What follows from a sensor's parameters: its beams, and where its fields lie.
#[derive(Debug, PartialEq)]
pub(crate) struct Layout {
    pub plan: BeamPlan,
    /// Of each field: the word at which it begins, and how many elements it has.
    pub spans: Vec<(usize, usize)>,
    words: usize,
}

impl Default for Layout {
    fn default() -> Self {
        Layout { plan: BeamPlan::NONE, spans: Vec::new(), words: 0 }
    }
}

impl Layout {
    /// Asks an instance for its beams. Must be called without any borrow of the world.
    pub fn ask(world: &WorldCell, kind: usize, slot: u32, data: *mut c_void) -> Result<Rc<Self>, String> {
        let kind = &world.registry.sensors[kind];
        let asked = world.cross(kind.plugin, Call::Beams, slot, || BeamPlan::ask(data, kind));
        let plan = asked.map_err(|text| format!("{text} [{}]", Call::Beams.text()))?;
        let (mut spans, mut words) = (Vec::new(), 0);
        for f in &kind.fields {
            let elements = length(f, &plan)?;
            spans.push((words, elements));
            words += (elements * element_size(f.elem)).div_ceil(8).max(1);
        }
        let layout = Layout { plan, spans, words };
        let like_it = world.sensing.try_borrow().ok().and_then(|s| s.like(&layout));
        Ok(like_it.unwrap_or_else(|| Rc::new(layout)))
    }
}

/// Elements of a field; an error where no memory could hold them.
fn length(field: &FieldInfo, plan: &BeamPlan) -> Result<usize, String> {
    let dims = plan.shape(field.dims);
    let n = dims.iter().try_fold(1usize, |n, d| n.checked_mul(*d as usize)).filter(|n| *n <= MAX_ELEMENTS);
    n.ok_or_else(|| format!("its field `{}` of {dims:?} elements is too large", field.name))
}

/// Among how many sensors before it one looks for its like: about a robot's.
const LOOK_BACK: usize = 64;

/// Elements that one field of a reading may have.
const MAX_ELEMENTS: usize = 1 << 28;

fn element_size(elem: u32) -> usize {
    match elem {
        TATU_ELEM_F64 | TATU_ELEM_OBJECT => 8,
        TATU_ELEM_F32 | TATU_ELEM_I32 => 4,
        TATU_ELEM_U16 => 2,
        _ => 1,
    }
}
