//! Samples the values that a client watches in each step, such as those that it plots: properties and fields of
//! readings.

use tatu_plugin_api::{
    abi::*,
    safe::{Prop, Result, Turn},
};

use crate::{
    frames::object_id,
    protocol::{ToPage, WatchSample, WatchedValue},
    readings,
};

/// Maximum number of values that a client can watch; further ones are ignored.
const MAX_VALUES: usize = 64;
/// Maximum number of elements per value that are sent.
const MAX_ELEMENTS: usize = 16;
/// Maximum number of samples that are stored until they are sent; the oldest are dropped.
const MAX_PENDING_SAMPLES: usize = 2000;

/// The values that a client watches, and the samples that have not been sent yet.
#[derive(Default)]
pub struct ValueWatch {
    /// Number of the client's request, which is repeated in each message.
    request: u32,
    /// The object and key of each value. The key is `None` if the object does not have such a property or field.
    values: Vec<(tatu_object, Option<Prop>)>,
    samples: Vec<WatchSample>,
    /// Simulation time of the last sample, s.
    last: Option<f64>,
}

impl ValueWatch {
    /// Creates a watch for the requested values, at most `MAX_VALUES`.
    pub fn new(turn: &Turn<'_>, of: u32, wanted: &[WatchedValue]) -> Self {
        let values = wanted.iter().take(MAX_VALUES).map(|w| {
            let id = object_id(w.object);
            (id, has_key(turn, id, &w.key).unwrap_or(false).then(|| turn.host().prop(&w.key)))
        });
        ValueWatch { request: of, values: values.collect(), ..ValueWatch::default() }
    }

    /// Samples the values unless the simulation time is still that of the last sample.
    pub fn sample(&mut self, turn: &Turn<'_>, time: f64) {
        if self.values.is_empty() || self.last == Some(time) {
            return;
        }
        self.last = Some(time);
        if self.samples.len() == MAX_PENDING_SAMPLES {
            self.samples.remove(0);
        }
        let values = self.values.iter().map(|(id, prop)| prop.and_then(|p| numbers(turn, *id, p)).unwrap_or_default());
        let values = values.map(|numbers| readings::finite_or_none(numbers.into_iter().take(MAX_ELEMENTS))).collect();
        self.samples.push(WatchSample { time, values });
    }

    /// Returns the message with all samples since the last message, or `None` if there are none.
    pub fn take_message(&mut self) -> Option<ToPage> {
        let samples = std::mem::take(&mut self.samples);
        (!samples.is_empty()).then_some(ToPage::Values { of: self.request, samples })
    }
}

/// Returns whether an object has a property or a field of readings with this key, without interning the key. Interned
/// keys are never freed, so clients must not be able to intern arbitrary strings.
fn has_key(turn: &Turn<'_>, id: tatu_object, key: &str) -> Result<bool> {
    if (0..).map_while(|i| turn.field_of(id, i)).any(|(name, _)| name == key) {
        return Ok(true);
    }
    let mut index = 0;
    while let Some(row) = turn.row(id, index)? {
        if row.get("key").and_then(|v| v.as_bytes()) == Some(key.as_bytes()) {
            return Ok(true);
        }
        index += 1;
    }
    Ok(false)
}

/// Returns the elements of a property or of a field of the last reading, or `None` if they cannot be read as numbers.
fn numbers(turn: &Turn<'_>, id: tatu_object, prop: Prop) -> Option<Vec<f64>> {
    if let Ok(field) = turn.reading(id, prop) {
        return (field.sequence() != 0).then(|| readings::short_field(&field)).flatten();
    }
    let value = turn.get(id, prop).ok()?;
    match value.tag() {
        TATU_BOOL => Some(vec![f64::from(u8::from(value.truthy()))]),
        TATU_I64 | TATU_F64 => value.as_f64().map(|x| vec![x]),
        _ => value.numbers(),
    }
}
