//! Sensors: who is due, their beams, their readings.
//!
//! - [`Sensing`]: the world's devices and their host-owned readings;
//! - `targets`: the scene as beams see it;
//! - `measure`: one batch per kind: beams cast together, one call of the plugin.

mod measure;
mod targets;

use std::{ffi::c_void, rc::Rc};

use nalgebra::{UnitQuaternion, Vector3};
use tatu_plugin_api::{abi::*, safe::Value};

pub use measure::{Around, Job, Moment, measure};
pub use targets::Targets;

use crate::{
    beams::{Faces, Volume},
    calls::{ErrorSlot, answer},
    host::{
        FieldInfo, SensorKind,
        instance::{Made, make},
        watchdog::Call,
    },
    world::WorldCell,
};

/// What a device sends out.
#[derive(Debug, PartialEq)]
pub(crate) struct BeamPlan {
    pub volume: Volume,
    /// Ray directions in the sensor's frame; one entry (its +z) for a volume, none for a sensor without beams.
    pub directions: Vec<[f64; 3]>,
    /// For each direction, the turn that makes +z look along it.
    pub turns: Vec<UnitQuaternion<f64>>,
    pub near: f64,
    pub far: f64,
    pub max_incidence: f64,
    pub faces: Faces,
    pub skip_model: bool,
}

/// One sensor's instance and its last reading.
pub(crate) struct Device {
    pub slot: u32,
    pub kind: usize,
    pub id: u64,
    pub data: *mut c_void,
    pub state: Vec<u64>,
    pub params: Vec<Value>,
    /// Shared by sensors that are alike: there may be thousands, and each step goes through all.
    pub layout: Rc<Layout>,
    /// The fields one after the other, each 8-byte aligned.
    pub fields: Vec<u64>,
    pub sequence: u64,
    pub time: f64,
    /// Switched off after a fault.
    pub off: bool,
}

/// The sensors of a world.
#[derive(Default)]
pub struct Sensing {
    pub(crate) devices: Vec<Device>,
    /// Index plus one of each slot's device; 0: it has none.
    by_slot: Vec<u32>,
    pub(crate) targets: Targets,
    pub(crate) scratch: measure::Scratch,
}

impl Sensing {
    /// Adds a device.
    pub(crate) fn add(&mut self, device: Device) {
        self.note(device.slot, self.devices.len());
        self.devices.push(device);
    }
    fn note(&mut self, slot: u32, index: usize) {
        let slot = slot as usize;
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
        self.devices = keep;
        self.by_slot.clear();
        for i in 0..self.devices.len() {
            self.note(self.devices[i].slot, i);
        }
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
        let Made { id, data, state } = make(world, kind.plugin, &kind.life, slot, instance, &params)?;
        let mut device = Device {
            slot,
            kind: kind_index,
            id,
            data,
            state,
            params,
            layout: Rc::default(),
            fields: Vec::new(),
            sequence: 0,
            time: 0.0,
            off: false,
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
            (self.fields, self.sequence) = (vec![0; layout.words], 0);
        }
        self.layout = layout;
    }

    fn ask_beams(data: *mut c_void, kind: &SensorKind) -> Result<BeamPlan, String> {
        let Some(ask) = kind.raw.beams else { return Ok(NO_BEAMS) };
        let mut raw = tatu_beams {
            size: size_of::<tatu_beams>() as u32,
            form: TATU_BEAMS_NONE,
            count: [0, 0],
            near_m: 0.0,
            far_m: f64::INFINITY,
            dims: [0.0; 6],
            max_incidence: std::f64::consts::FRAC_PI_2,
            directions: std::ptr::null(),
            flags: 0,
            reserved: 0,
        };
        let mut error = ErrorSlot::new();
        // SAFETY: by the contract; `[setup]`.
        if unsafe { answer(ask(data, &mut raw, error.raw()), false, error.raw()) } < 0 {
            return Err(error.text());
        }
        let (volume, directions) = match raw.form {
            TATU_BEAMS_NONE => (Volume::Ray, Vec::new()),
            TATU_BEAMS_CONE if (0.0..=std::f64::consts::PI).contains(&raw.dims[0]) => {
                (Volume::Cone { half_angle: raw.dims[0] }, vec![[0.0, 0.0, 1.0]])
            }
            TATU_BEAMS_CONE => return Err(format!("a half angle of {} rad; expected 0 to pi", raw.dims[0])),
            TATU_BEAMS_RAYS if raw.count[0] > MAX_RAYS => {
                return Err(format!("{} rays; expected at most {MAX_RAYS}", raw.count[0]));
            }
            TATU_BEAMS_RAYS if !raw.directions.is_null() => {
                // SAFETY: 3 numbers per ray, by the contract.
                let all = unsafe { std::slice::from_raw_parts(raw.directions.cast(), raw.count[0] as usize) };
                let unit = |d: &[f64; 3]| (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1.0).abs() < 1e-6;
                if let Some(i) = all.iter().position(|d| !unit(d)) {
                    return Err(format!("the direction of ray {i} is {:?}; expected a unit vector", all[i]));
                }
                (Volume::Ray, all.to_vec())
            }
            TATU_BEAMS_RAYS => return Err("rays without directions".into()),
            form => return Err(format!("beams of form {form} are not cast by this host yet; expected rays or a cone")),
        };
        if !(raw.near_m >= 0.0 && raw.far_m >= raw.near_m) {
            return Err(format!("beams from {} m to {} m", raw.near_m, raw.far_m));
        }
        if !(0.0..=std::f64::consts::PI).contains(&raw.max_incidence) {
            return Err(format!("a greatest incidence of {} rad; expected 0 to pi", raw.max_incidence));
        }
        Ok(BeamPlan {
            volume,
            turns: directions.iter().map(|d| look_along(*d)).collect(),
            directions,
            near: raw.near_m,
            far: raw.far_m,
            max_incidence: raw.max_incidence,
            faces: Faces { front: raw.flags & TATU_BEAMS_NO_FRONT == 0, back: raw.flags & TATU_BEAMS_NO_BACK == 0 },
            skip_model: raw.flags & TATU_BEAMS_SKIP_MODEL != 0,
        })
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
        let beams = self.layout.plan.directions.len() as u32;
        let (first, n) = self.layout.spans[field];
        tatu_field_view {
            ptr: self.fields[first..].as_ptr().cast(),
            len: n as u64,
            elem: info.elem,
            dims: info.dims.map(|d| if d == 0 { beams } else { d }),
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
        Layout { plan: NO_BEAMS, spans: Vec::new(), words: 0 }
    }
}

impl Layout {
    /// Asks an instance for its beams. Must be called without any borrow of the world.
    pub fn ask(world: &WorldCell, kind: usize, slot: u32, data: *mut c_void) -> Result<Rc<Self>, String> {
        let kind = &world.registry.sensors[kind];
        let asked = world.cross(kind.plugin, Call::Beams, slot, || Device::ask_beams(data, kind));
        let plan = asked.map_err(|text| format!("{text} [{}]", Call::Beams.text()))?;
        let (mut spans, mut words) = (Vec::new(), 0);
        for f in &kind.fields {
            let elements = length(f, plan.directions.len())?;
            spans.push((words, elements));
            words += (elements * element_size(f.elem)).div_ceil(8).max(1);
        }
        let layout = Layout { plan, spans, words };
        let like_it = world.sensing.try_borrow().ok().and_then(|s| s.like(&layout));
        Ok(like_it.unwrap_or_else(|| Rc::new(layout)))
    }
}

/// Elements of a field; an error where no memory could hold them.
fn length(field: &FieldInfo, beams: usize) -> Result<usize, String> {
    let dims = field.dims.map(|d| if d == 0 { beams } else { d as usize });
    let n = dims.iter().try_fold(1usize, |n, d| n.checked_mul(*d)).filter(|n| *n <= MAX_ELEMENTS);
    n.ok_or_else(|| format!("its field `{}` of {dims:?} elements is too large", field.name))
}

/// Among how many sensors before it one looks for its like: about a robot's.
const LOOK_BACK: usize = 64;

/// Rays that one sensor may have: more is a mistake, and would be read beyond the plugin's memory.
const MAX_RAYS: u32 = 1 << 24;

/// Elements that one field of a reading may have.
const MAX_ELEMENTS: usize = 1 << 28;

const NO_BEAMS: BeamPlan = BeamPlan {
    volume: Volume::Ray,
    directions: Vec::new(),
    turns: Vec::new(),
    near: 0.0,
    far: 0.0,
    max_incidence: std::f64::consts::FRAC_PI_2,
    faces: Faces::BOTH,
    skip_model: false,
};

/// The turn that makes +z look along a direction, with the least twist.
fn look_along(d: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::from(d))
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}

fn element_size(elem: u32) -> usize {
    match elem {
        TATU_ELEM_F64 | TATU_ELEM_OBJECT => 8,
        TATU_ELEM_F32 | TATU_ELEM_I32 => 4,
        TATU_ELEM_U16 => 2,
        _ => 1,
    }
}
