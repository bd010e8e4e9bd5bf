//! One sensor: its instance, its last reading, and where the fields of that lie.

use std::{ffi::c_void, rc::Rc};

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{
    FieldInfo, MOST_ELEMENTS, SensorKind,
    state_block::{GUARD, PAST_STATE, StateBlock},
};

use super::{
    noise::{self, Noise},
    plan::BeamPlan,
};
use crate::sense::reading_arena::{ReadingArena, ReadingBuffer};

/// One sensor's instance and its last reading.
///
/// There may be thousands, and each step goes through all: what a reading needs stands in the first line of the
/// processor's cache, what a measure needs in the first two.
#[repr(C, align(64))]
pub struct Device {
    /// The fields one after the other, each 8-byte aligned.
    pub fields: ReadingBuffer,
    /// Shared by sensors that are alike.
    pub layout: Rc<Layout>,
    /// Number of the measure, from 1; 0: none yet.
    pub sequence: u64,
    /// When it was taken, s.
    pub time: f64,
    /// Its slot in the scene.
    pub slot: u32,
    /// Disabled after a fault.
    pub off: bool,
    /// Measures only on request, as the scene declares.
    pub(super) explicit: bool,
    /// Index of its kind in the registry.
    pub kind: usize,
    /// The plugin's own data.
    pub data: *mut c_void,
    /// What is done to its fields after a measure; `None`: nothing.
    pub noise: Option<Box<Noise>>,
    /// From the scene's seed and the sensor: the key of its random numbers.
    pub seed: u64,
    /// How often it has measured since the start, resets or not: what random numbers are drawn by.
    pub drawn: u64,
    /// What the plugin may write of its state.
    pub state: StateBlock,
    /// Which of the scene's objects it sees, as [`Targets`](super::targets::Targets) number such choices; 0: all.
    pub(super) choice: u32,
    /// Hz, as the scene says; 0: it measures in each step.
    pub(super) rate: f64,
    /// Of a sensor with a rate: the period in which it measured last.
    pub period: Option<u64>,
    /// Its number, which its random numbers depend on.
    pub id: u64,
    /// Values of its parameters, in the order of the kind's declaration.
    pub params: Vec<Value>,
}

impl Device {
    /// A sensor without a reading; its beams are not known yet.
    pub fn new(
        kind: usize,
        slot: u32,
        seed: u64,
        (id, data, state): (u64, *mut c_void, StateBlock),
        params: Vec<Value>,
    ) -> Self {
        Device {
            fields: ReadingBuffer::default(),
            layout: Rc::default(),
            sequence: 0,
            time: 0.0,
            slot,
            off: false,
            explicit: false,
            kind,
            data,
            noise: None,
            seed,
            drawn: 0,
            choice: 0,
            rate: 0.0,
            period: None,
            state,
            id,
            params,
        }
    }

    /// Takes beams and fields. Where the fields have other sizes now, the last reading is forgotten.
    pub fn lay_out(&mut self, layout: Rc<Layout>) {
        if self.layout.spans != layout.spans || self.fields.len() != layout.words {
            self.fields = ReadingBuffer::new(layout.words);
            self.forget();
        }
        self.layout = layout;
    }

    /// Puts the reading where those of the sensors made before lie.
    pub(super) fn shelve(&mut self, arena: &mut ReadingArena) {
        let mut words = arena.take(self.fields.len());
        words.copy_from_slice(&self.fields);
        self.fields = words;
    }

    /// After a call of its plugin: whether it kept within its fields and its state block.
    #[inline]
    pub(super) fn kept_within(&self) -> bool {
        let fields = &*self.fields;
        self.layout.ends.iter().all(|end| fields[*end as usize] == GUARD)
            && self.layout.pads.iter().all(|pad| pad.is_empty(fields))
            && self.state.is_whole()
    }

    /// Where it wrote out of bounds.
    #[cold]
    pub(super) fn wrote_too_far(&mut self, kind: &SensorKind) -> String {
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
                self.state.mend();
                PAST_STATE.to_owned()
            }
        }
    }

    /// Discards the reading, and those that are delayed.
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
        if self.rate <= 0.0 {
            return true;
        }
        let now = Some(period(self.rate, time));
        std::mem::replace(&mut self.period, now) != now
    }

    /// Whether it measures by itself in each step, and is seen to at once.
    pub(super) fn is_steady(&self) -> bool {
        !self.off && !self.explicit && self.rate <= 0.0 && !self.is_delayed()
    }

    /// Whether its readings are seen later than they are measured.
    pub(super) fn is_delayed(&self) -> bool {
        self.noise.as_ref().is_some_and(|noise| noise.delays())
    }

    /// Before a measure, if readings are delayed: takes out the reading that is seen, and makes room for another.
    pub(super) fn keep_shown(&mut self) -> Option<noise::HeldReading> {
        let noise = self.noise.as_ref().filter(|n| n.delays())?;
        let newest = noise.newest();
        let fields = std::mem::replace(&mut self.fields, ReadingBuffer::new(self.layout.words));
        let shown = noise::HeldReading { time: self.time, sequence: self.sequence, fields };
        self.sequence = newest.unwrap_or(self.sequence);
        Some(shown)
    }

    /// After a measure: changes the fields as the scene declares.
    pub(super) fn add_noise(&mut self, kind: &SensorKind, pool: &rayon::ThreadPool) {
        let Device { noise: Some(noise), fields, layout, seed, drawn, time, .. } = self else { return };
        // It has been counted already.
        let drawn = drawn.wrapping_sub(1);
        let spans = &layout.spans;
        noise.apply(noise::Measured { kind, seed: *seed, drawn, time: *time, fields, spans }, pool);
    }

    /// After a measure, if readings are delayed: the new one waits, and the newest that is old enough is seen.
    pub(super) fn put_back(&mut self, shown: Option<noise::HeldReading>) {
        let (Some(shown), Some(noise)) = (shown, &mut self.noise) else { return };
        let (now, fields) = (self.time, std::mem::replace(&mut self.fields, shown.fields));
        noise.hold(noise::HeldReading { time: now, sequence: self.sequence, fields });
        (self.time, self.sequence) = (shown.time, shown.sequence);
        self.release(now);
    }

    /// Shows the newest reading that is old enough, if one was under way.
    pub fn release(&mut self, now: f64) {
        if let Some(r) = self.noise.as_mut().and_then(|n| n.release(now)) {
            (self.time, self.sequence, self.fields) = (r.time, r.sequence, r.fields);
        }
    }

    /// A view of one field.
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

    /// The first field that holds a NaN. "Nothing detected" is infinity or zero, never NaN.
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
                    std::slice::from_raw_parts(bytes.cast::<u64>(), n)
                        .iter()
                        .map(|x| i64::from(tatu_slot(*x)))
                        .collect(),
                ),
                _ => Value::Bytes(std::slice::from_raw_parts(bytes.cast::<u8>(), n).to_vec()),
            }
        }
    }
}

/// The number of the period of a rate that a time lies in. Times are sums of steps: one that lacks but their rounding
/// is in the period that it begins.
fn period(rate: f64, time: f64) -> u64 {
    (time * rate * (1.0 + 1e-12) + 1e-9).floor() as u64
}

/// What follows from a sensor's parameters: its beams, and where its fields lie.
#[derive(Debug, PartialEq)]
pub struct Layout {
    /// What it sends out.
    pub plan: BeamPlan,
    /// Of each field: the word at which it begins, and how many elements it has.
    pub spans: Vec<(usize, usize)>,
    /// Of each field, its shape.
    dims: Vec<[u32; 3]>,
    words: usize,
    /// Of each field, how many elements it has, as it crosses the border.
    pub lengths: Vec<u64>,
    /// The word before all fields, and of each the one behind it: guards.
    ends: Vec<u32>,
    /// The bytes between the end of a field and its guard, where there are any.
    pads: Vec<Pad>,
}

/// Bytes behind the last element of a field, in the word that holds it. They are 0 unless the plugin writes there.
#[derive(Debug, PartialEq)]
struct Pad {
    field: usize,
    word: u32,
    /// The bits of the word that belong to no element.
    mask: u64,
}

impl Pad {
    /// Behind `bytes` bytes of a field that begins at a word; `None`: they fill their words.
    fn new(field: usize, first: usize, bytes: usize) -> Option<Self> {
        let used = bytes % 8;
        if used == 0 && bytes > 0 {
            return None;
        }
        let mut mask = [0xff; 8];
        mask[..used].fill(0);
        Some(Pad { field, word: (first + bytes / 8) as u32, mask: u64::from_ne_bytes(mask) })
    }
    fn is_empty(&self, fields: &[u64]) -> bool {
        fields[self.word as usize] & self.mask == 0
    }
}

impl Default for Layout {
    fn default() -> Self {
        Layout {
            plan: BeamPlan::NONE,
            spans: Vec::new(),
            dims: Vec::new(),
            words: 0,
            lengths: Vec::new(),
            ends: Vec::new(),
            pads: Vec::new(),
        }
    }
}

impl Layout {
    /// Where the fields of a reading lie, for what an instance sends out.
    pub fn new(plan: BeamPlan, kind: &SensorKind) -> Result<Self, String> {
        let dims: Vec<_> = kind.fields.iter().map(|f| plan.shape(f.dims)).collect();
        // One guard word before them and behind each, to detect writes out of bounds.
        let (mut spans, mut pads, mut words) = (Vec::new(), Vec::new(), 1);
        for (f, dims) in kind.fields.iter().zip(&dims) {
            let elements = length(f, dims)?;
            let bytes = elements * element_size(f.elem);
            pads.extend(Pad::new(spans.len(), words, bytes));
            spans.push((words, elements));
            words += bytes.div_ceil(8).max(1) + 1;
        }
        let begins = spans.iter().skip(1).map(|(first, _)| *first).chain((!spans.is_empty()).then_some(words));
        let ends = std::iter::once(0).chain(begins.map(|next| (next - 1) as u32)).collect();
        let lengths = spans.iter().map(|(_, n)| *n as u64).collect();
        Ok(Layout { plan, spans, dims, words, lengths, ends, pads })
    }

    /// Empties the fields of a reading for a measure.
    #[inline]
    pub(super) fn clear(&self, fields: &mut [u64]) {
        fields.fill(0);
        for end in &self.ends {
            fields[*end as usize] = GUARD;
        }
    }
}

/// Elements of a field; an error where no memory could hold them.
fn length(field: &FieldInfo, dims: &[u32; 3]) -> Result<usize, String> {
    let n = dims.iter().try_fold(1usize, |n, d| n.checked_mul(*d as usize)).filter(|n| *n as u64 <= MOST_ELEMENTS);
    n.ok_or_else(|| format!("its field `{}` of {dims:?} elements is too large", field.name))
}

fn element_size(elem: u32) -> usize {
    match elem {
        TATU_ELEM_F64 | TATU_ELEM_OBJECT => 8,
        TATU_ELEM_F32 | TATU_ELEM_I32 => 4,
        TATU_ELEM_U16 => 2,
        _ => 1,
    }
}
