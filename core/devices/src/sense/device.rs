//! The instance of a sensor, its last reading, and the layout of its fields.

use std::{ffi::c_void, rc::Rc};

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{
    FieldSpec, MAX_ELEMENTS, SensorKind,
    reading_arena::{ReadingArena, ReadingBuffer},
    state_block::{GUARD, PAST_STATE, StateBlock},
};

use super::{
    noise::{self, SensorNoise},
    numbers::elements,
    plan::BeamPlan,
};

/// A sensor's instance and its last reading.
///
/// There can be thousands of sensors, and each step iterates over all of them. The data for reading the fields is
/// therefore in the first cache line, and the data for a measurement in the first two.
#[repr(C, align(64))]
pub struct SensorDevice {
    /// The contents of the fields, each 8-byte aligned.
    pub fields: ReadingBuffer,
    /// The layout of the fields; sensors with equal layouts share it.
    pub layout: Rc<FieldLayout>,
    /// Sequence number of the measurement, counted from 1; 0 if there is no reading yet.
    pub sequence: u64,
    /// Simulation time of the measurement, s.
    pub time: f64,
    /// Slot of its object in the scene.
    pub slot: u32,
    /// Whether the sensor is disabled after a fault.
    pub off: bool,
    /// When the sensor measures.
    pub schedule: SensorSchedule,
    /// Index of its kind in the registry.
    pub kind: usize,
    /// Pointer to the plugin's data of this instance.
    pub data: *mut c_void,
    /// Noise that is applied to the fields after each measurement.
    pub noise: Option<Box<SensorNoise>>,
    /// Seed of the sensor's random numbers, derived from the scene's seed and the object's name.
    pub seed: u64,
    /// Number of measurements since the start, including those before a reset; the sensor's random numbers depend on
    /// it.
    pub drawn: u64,
    /// The state block that the plugin writes to.
    pub state: StateBlock,
    /// The objects that the scene lists for the sensor.
    pub(super) chosen: ChosenObjects,
    /// Id of the plugin's instance.
    pub id: u64,
    /// Values of its parameters, in the order of the kind's declaration.
    pub params: Vec<Value>,
}

/// The objects that the scene lists for a sensor.
#[derive(Default)]
pub(super) struct ChosenObjects {
    /// Number of the selection of objects that the sensor can detect, in [`Targets`](super::targets::Targets); 0 for
    /// all objects.
    pub choice: u32,
    /// Its targets, if its kind takes targets; 0 stands for a missing object.
    pub targets: Vec<tatu_object>,
}

/// When a sensor measures.
pub struct SensorSchedule {
    /// Whether the sensor measures only on request, as declared in the scene.
    pub(super) explicit: bool,
    /// Rate declared in the scene, Hz, or 0 if the sensor measures in every step.
    pub(super) rate: f64,
    /// Index of the period in which the sensor last measured, if it has a rate.
    pub period: Option<u64>,
}

impl SensorDevice {
    /// Creates a sensor without a reading and without beams, which [`set_layout`](Self::set_layout) sets.
    pub fn new(
        kind: usize,
        slot: u32,
        seed: u64,
        (id, data, state): (u64, *mut c_void, StateBlock),
        params: Vec<Value>,
    ) -> Self {
        SensorDevice {
            fields: ReadingBuffer::default(),
            layout: Rc::default(),
            sequence: 0,
            time: 0.0,
            slot,
            off: false,
            schedule: SensorSchedule { explicit: false, rate: 0.0, period: None },
            kind,
            data,
            noise: None,
            seed,
            drawn: 0,
            chosen: ChosenObjects::default(),
            state,
            id,
            params,
        }
    }

    /// Sets the beams and the layout of the fields. If the sizes of the fields have changed, the last reading is
    /// discarded.
    pub fn set_layout(&mut self, layout: Rc<FieldLayout>) {
        if self.layout.spans != layout.spans || self.fields.len() != layout.words {
            self.fields = ReadingBuffer::new(layout.words);
            self.discard_reading();
        }
        self.layout = layout;
    }

    /// Moves the reading in memory, next to the reading of the sensor that was added before this one.
    pub(super) fn move_to_arena(&mut self, arena: &mut ReadingArena) {
        if ReadingArena::is_large(self.fields.len()) {
            return;
        }
        let mut words = arena.allocate(self.fields.len());
        words.copy_from_slice(&self.fields);
        self.fields = words;
    }

    /// Returns whether the plugin wrote only to the fields and the state block in its last call.
    #[inline]
    pub(super) fn is_within_bounds(&self) -> bool {
        self.layout.is_whole(&self.fields) && self.state.guards_intact()
    }

    /// Returns the sensor's targets, as many as its fields have elements for; 0 stands for a missing object.
    pub(super) fn targets(&self) -> impl Iterator<Item = tatu_object> {
        (0..self.layout.targets as usize).map(|k| self.chosen.targets.get(k).copied().unwrap_or_default())
    }

    /// Stores the fields that an actuator reported at `time`, s, as the reading.
    pub(crate) fn store_report(&mut self, time: f64, fields: &[u64]) {
        if self.fields.len() == fields.len() {
            self.fields.copy_from_slice(fields);
            (self.time, self.sequence) = (time, self.sequence + 1);
        }
    }

    /// Describes where the plugin wrote out of bounds.
    #[cold]
    pub(super) fn out_of_bounds_text(&mut self, kind: &SensorKind) -> String {
        let past = self.layout.ends.iter().position(|end| self.fields[*end as usize] != GUARD);
        let pad = || self.layout.pads.iter().find(|pad| !pad.is_empty(&self.fields)).map(|pad| pad.field + 1);
        match past.or_else(pad) {
            Some(0) => {
                let name = kind.fields.first().map_or("", |f| &f.name);
                format!("broke the contract: it wrote before the beginning of the field `{name}`")
            }
            Some(guard) => {
                let name = &kind.fields[guard - 1].name;
                format!("broke the contract: it wrote past the end of the field `{name}`")
            }
            None => {
                self.state.restore_guards();
                PAST_STATE.to_owned()
            }
        }
    }

    /// Discards the reading, and all delayed readings.
    pub fn discard_reading(&mut self) {
        self.sequence = 0;
        self.noise.iter_mut().for_each(|n| n.discard_held());
    }

    /// Returns whether the sensor is due at `time`, s, which is the case at most once per period of its rate. Periods
    /// are counted from time 0, so they do not drift.
    pub fn is_due(&mut self, time: f64) -> bool {
        !self.schedule.explicit && self.is_due_after(time)
    }

    /// Like [`SensorDevice::is_due`], for the physics step that begins at `time`. A sensor that otherwise measures only
    /// on request can be due as well.
    pub(super) fn is_due_after(&mut self, time: f64) -> bool {
        if self.off {
            return false;
        }
        if self.schedule.rate <= 0.0 || self.schedule.rate > MAX_RATE_HZ {
            return true;
        }
        let now = Some(period(self.schedule.rate, time));
        std::mem::replace(&mut self.schedule.period, now) != now
    }

    /// Returns whether the sensor measures in every step and its readings are visible immediately.
    pub(super) fn is_steady(&self) -> bool {
        !self.off && !self.schedule.explicit && self.schedule.rate <= 0.0 && !self.is_delayed()
    }

    /// Returns whether the sensor's readings become visible later than they are measured.
    pub(super) fn is_delayed(&self) -> bool {
        self.noise.as_ref().is_some_and(|noise| noise.delays())
    }

    /// If readings are delayed, removes and returns the visible reading before a measurement, so that the measurement
    /// does not overwrite it.
    pub(super) fn take_shown(&mut self) -> Option<noise::HeldReading> {
        let noise = self.noise.as_ref().filter(|n| n.delays())?;
        let newest = noise.newest();
        let fields = std::mem::replace(&mut self.fields, ReadingBuffer::new(self.layout.words));
        let shown = noise::HeldReading { time: self.time, sequence: self.sequence, fields };
        self.sequence = newest.unwrap_or(self.sequence);
        Some(shown)
    }

    /// Applies noise to the fields after a measurement. `dt` is the duration of a step, s, which is the sensor's period
    /// if it has no rate.
    pub(super) fn add_noise(&mut self, kind: &SensorKind, dt: f64, pool: &rayon::ThreadPool) {
        let period = if self.schedule.rate > 0.0 { 1.0 / self.schedule.rate } else { dt };
        let SensorDevice { noise: Some(noise), fields, layout, seed, drawn, time, .. } = self else { return };
        // `drawn` already includes this measurement.
        let drawn = drawn.wrapping_sub(1);
        let spans = &layout.spans;
        let measured = noise::RawMeasurement { kind, seed: *seed, drawn, time: *time, period, fields, spans };
        noise.apply(measured, pool);
    }

    /// If readings are delayed, holds the new reading back after a measurement, restores the visible one, and then
    /// releases the newest reading that is old enough.
    pub(super) fn restore_shown(&mut self, shown: Option<noise::HeldReading>) {
        let (Some(shown), Some(noise)) = (shown, &mut self.noise) else { return };
        let (now, fields) = (self.time, std::mem::replace(&mut self.fields, shown.fields));
        noise.hold(noise::HeldReading { time: now, sequence: self.sequence, fields });
        (self.time, self.sequence) = (shown.time, shown.sequence);
        self.release(now);
    }

    /// Makes the newest held reading that is old enough visible, if any.
    pub fn release(&mut self, now: f64) {
        if let Some(r) = self.noise.as_mut().and_then(|n| n.release(now)) {
            (self.time, self.sequence, self.fields) = (r.time, r.sequence, r.fields);
        }
    }

    /// Returns a view of a field, for plugins.
    pub fn view(&self, kind: &SensorKind, field: usize) -> tatu_field_view {
        let info = &kind.fields[field];
        let (first, n) = self.layout.spans[field];
        tatu_field_view {
            ptr: self.fields[first..].as_ptr().cast(),
            len: n as u64,
            elem: info.elem,
            dims: self.layout.dims[field],
            time: self.time,
            sequence: self.sequence,
        }
    }

    /// Returns the name of the first field that contains a NaN, if any does. Plugins must report "nothing detected" as
    /// infinity or zero.
    pub fn not_a_number<'k>(&self, kind: &'k SensorKind) -> Option<&'k str> {
        self.layout.not_a_number(&self.fields, kind)
    }

    /// Returns the contents of a field as a value. Objects are converted to their slots.
    pub fn value(&self, kind: &SensorKind, field: usize) -> Value {
        let (first, n) = self.layout.spans[field];
        let words = &self.fields[first..];
        match kind.fields[field].elem {
            TATU_ELEM_F64 => Value::Floats(elements(words, n).to_vec()),
            TATU_ELEM_F32 => Value::Floats(elements::<f32>(words, n).iter().map(|x| f64::from(*x)).collect()),
            TATU_ELEM_I32 => Value::Ints(elements::<i32>(words, n).iter().map(|x| i64::from(*x)).collect()),
            TATU_ELEM_U16 => Value::Ints(elements::<u16>(words, n).iter().map(|x| i64::from(*x)).collect()),
            TATU_ELEM_OBJECT => Value::Ints(words[..n].iter().map(|x| i64::from(tatu_slot(*x))).collect()),
            _ => Value::Bytes(elements(words, n).to_vec()),
        }
    }
}

/// Rate above which a sensor measures in every step, Hz. No step is that short, and periods of lower rates can be
/// counted.
const MAX_RATE_HZ: f64 = 1e9;

/// Returns the index of the period of a rate, Hz, that contains `time`, s. Times are sums of steps, so a time that is
/// before the start of a period only by rounding errors belongs to that period.
fn period(rate: f64, time: f64) -> u64 {
    (time * rate * (1.0 + 1e-12) + 1e-9).floor() as u64
}

/// The properties of a sensor that its parameters determine: its beams, and the layout of its fields.
#[derive(Debug, PartialEq)]
pub struct FieldLayout {
    /// The beams of the sensor.
    pub plan: BeamPlan,
    /// Number of targets, for which `TATU_DIM_TARGETS` stands in the shape of a field.
    pub targets: u32,
    /// For each field, the index of its first word and its number of elements.
    pub spans: Vec<(usize, usize)>,
    /// For each field, its shape.
    dims: Vec<[u32; 3]>,
    words: usize,
    /// For each field, its number of elements, as passed to plugins.
    pub lengths: Vec<u64>,
    /// Indices of the guard words: the word before all fields, and the word after each field.
    ends: Vec<u32>,
    /// The padding between the end of a field and its guard, for fields that have padding.
    pads: Vec<FieldPadding>,
}

/// The bytes after the last element of a field, in the word that contains it. They are 0 unless the plugin writes
/// there.
#[derive(Debug, PartialEq)]
struct FieldPadding {
    field: usize,
    word: u32,
    /// The bits of the word that do not belong to an element.
    mask: u64,
}

impl FieldPadding {
    /// Returns the padding after a field of `bytes` bytes that begins at a word, or `None` if the field fills its
    /// words.
    fn new(field: usize, first: usize, bytes: usize) -> Option<Self> {
        let used = bytes % 8;
        if used == 0 && bytes > 0 {
            return None;
        }
        let mut mask = [0xff; 8];
        mask[..used].fill(0);
        Some(FieldPadding { field, word: (first + bytes / 8) as u32, mask: u64::from_ne_bytes(mask) })
    }
    fn is_empty(&self, fields: &[u64]) -> bool {
        fields[self.word as usize] & self.mask == 0
    }
}

impl Default for FieldLayout {
    fn default() -> Self {
        FieldLayout {
            plan: BeamPlan::NONE,
            targets: 0,
            spans: Vec::new(),
            dims: Vec::new(),
            words: 0,
            lengths: Vec::new(),
            ends: Vec::new(),
            pads: Vec::new(),
        }
    }
}

impl FieldLayout {
    /// Computes the layout of the fields for a plan of beams and a number of targets.
    pub fn new(plan: BeamPlan, targets: u32, kind: &SensorKind) -> Result<Self, String> {
        let shape = |f: &FieldSpec| plan.shape(f.dims).map(|d| if d == TATU_DIM_TARGETS { targets } else { d });
        let dims: Vec<_> = kind.fields.iter().map(shape).collect();
        // A guard word before the fields and after each one reveals writes out of bounds.
        let (mut spans, mut pads, mut words) = (Vec::new(), Vec::new(), 1);
        for (f, dims) in kind.fields.iter().zip(&dims) {
            let elements = length(f, dims)?;
            let bytes = elements * element_size(f.elem);
            pads.extend(FieldPadding::new(spans.len(), words, bytes));
            spans.push((words, elements));
            words += bytes.div_ceil(8).max(1) + 1;
        }
        let begins = spans.iter().skip(1).map(|(first, _)| *first).chain((!spans.is_empty()).then_some(words));
        let ends = std::iter::once(0).chain(begins.map(|next| (next - 1) as u32)).collect();
        let lengths = spans.iter().map(|(_, n)| *n as u64).collect();
        Ok(FieldLayout { plan, targets, spans, dims, words, lengths, ends, pads })
    }

    /// Returns the name of the first field that contains a NaN.
    pub(crate) fn not_a_number<'k>(&self, fields: &[u64], kind: &'k SensorKind) -> Option<&'k str> {
        let is_bad = |i: usize| {
            let (first, n) = self.spans[i];
            let words = &fields[first..];
            match kind.fields[i].elem {
                TATU_ELEM_F64 => elements::<f64>(words, n).iter().any(|x| x.is_nan()),
                TATU_ELEM_F32 => elements::<f32>(words, n).iter().any(|x| x.is_nan()),
                _ => false,
            }
        };
        (0..kind.fields.len()).find(|i| is_bad(*i)).map(|i| kind.fields[i].name.as_str())
    }

    /// Returns whether the guards around the fields are unchanged.
    #[inline]
    pub(crate) fn is_whole(&self, fields: &[u64]) -> bool {
        self.ends.iter().all(|end| fields[*end as usize] == GUARD) && self.pads.iter().all(|pad| pad.is_empty(fields))
    }

    /// Returns the number of words that the fields occupy, with their guards.
    pub fn words(&self) -> usize {
        self.words
    }

    /// Returns the sizes of the memory that a sensor needs, bytes: for its reading, and while its image is rendered.
    pub(super) fn memory_bytes(&self) -> [u64; 2] {
        [8 * self.words as u64, self.plan.image_bytes()]
    }

    /// Clears the fields for a measurement, and sets the guards.
    #[inline]
    pub(crate) fn clear(&self, fields: &mut [u64]) {
        fields.fill(0);
        self.set_guards(fields);
    }

    /// Sets the guards around the fields.
    #[inline]
    pub(crate) fn set_guards(&self, fields: &mut [u64]) {
        for end in &self.ends {
            fields[*end as usize] = GUARD;
        }
    }
}

/// Returns the number of elements of a field, or an error if they exceed the limit.
fn length(field: &FieldSpec, dims: &[u32; 3]) -> Result<usize, String> {
    let n = dims.iter().try_fold(1usize, |n, d| n.checked_mul(*d as usize)).filter(|n| *n as u64 <= MAX_ELEMENTS);
    n.ok_or_else(|| {
        format!("its field `{}` has {dims:?} elements; expected at most {MAX_ELEMENTS} in total", field.name)
    })
}

fn element_size(elem: u32) -> usize {
    match elem {
        TATU_ELEM_F64 | TATU_ELEM_OBJECT => 8,
        TATU_ELEM_F32 | TATU_ELEM_I32 => 4,
        TATU_ELEM_U16 => 2,
        _ => 1,
    }
}
