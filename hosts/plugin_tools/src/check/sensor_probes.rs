//! Calls sensors again with the batches of the host: with the same inputs, which must give the same readings, and with
//! extreme ones, which must give finite readings.

use tatu_core::plugins::SensorKind;
use tatu_plugin_api::abi::*;

use super::{
    batch_copy::{BatchCall, BatchInputs, SensorOutput},
    finding::error,
    judge,
};

/// What is done with the batches of the plugin's devices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceProbe {
    /// Nothing.
    None,
    /// The batch is measured again, as a whole and sensor by sensor.
    Again,
    /// The batch is measured with extreme inputs.
    Extremes,
    /// The batch is measured with slightly different inputs, to compare their units with those of the readings.
    Units,
}

/// Maximum number of sensors of a batch that are measured alone.
const MAX_SINGLE: usize = 6;
/// Number of extreme inputs per batch.
const EXTREMES: u64 = 70;
/// Number of elements of a batch's inputs above which fewer extremes are tried.
const MANY_ELEMENTS: usize = 4000;

/// Returns what the host's own call wrote for each sensor.
fn outputs_of_host(call: &BatchCall<'_>) -> Vec<SensorOutput> {
    let (b, n_fields) = (call.batch, call.kind.fields.len());
    let field = |i: usize, k: usize| {
        // SAFETY: the batch has a pointer and a length for each field of each sensor, and the pointers refer to that
        // many elements.
        unsafe {
            let n = *(*b.lengths.add(i)).add(k) as usize * super::batch_copy::element_bytes(call.kind.fields[k].elem);
            std::slice::from_raw_parts((*b.fields.add(i * n_fields + k)).cast::<u8>(), n).to_vec()
        }
    };
    let output = |i: usize| SensorOutput {
        fields: (0..n_fields).map(|k| field(i, k)).collect(),
        state: call.state(i),
        // SAFETY: the batch has a status for each sensor.
        status: unsafe { *b.status.add(i) },
    };
    (0..b.n as usize).map(output).collect()
}

/// Calls the function for the host, and then again as the probe requires. `is_pure`: the state of an instance is in
/// its state block.
pub fn probe(probe: DeviceProbe, is_pure: bool, call: &BatchCall<'_>) -> tatu_status {
    let n = call.batch.n as usize;
    let before: Vec<Vec<u8>> = (0..n).map(|i| call.state(i)).collect();
    let status = (call.run.borrow_mut())(call.batch);
    if status < 0 {
        return status;
    }
    let own = outputs_of_host(call);
    if own.iter().any(|o| o.status < 0) {
        return status;
    }
    // SAFETY: the host's batch conforms to the header.
    let inputs = unsafe { BatchInputs::of(call.kind, call.batch, 0..n) };
    match probe {
        DeviceProbe::None => {}
        DeviceProbe::Again if !is_pure => {}
        DeviceProbe::Again => again(call, &inputs, &before, &own),
        DeviceProbe::Extremes => extremes(call, &inputs),
        DeviceProbe::Units => super::units::sensors(call, &inputs, &before),
    }
    own.iter().enumerate().for_each(|(i, o)| call.set_state(i, &o.state));
    status
}

fn again(call: &BatchCall<'_>, inputs: &BatchInputs, before: &[Vec<u8>], own: &[SensorOutput]) {
    let (n, kind) = (own.len(), call.kind);
    let reset = || before.iter().enumerate().for_each(|(i, s)| call.set_state(i, s));
    reset();
    let Some(whole) = call.call(0..n, inputs) else {
        return error(&call.place(), "it fails when the same batch is measured again from the same state");
    };
    if let Some((i, what)) = first_difference(kind, own, &whole) {
        let text = format!(
            "measured again with the same inputs and the same state, {what} of sensor {i} of the batch differs: it \
             depends on something else, such as memory outside of the state block, a clock, or memory that was not \
             initialised"
        );
        return error(&call.place(), text);
    }
    for i in 0..n.min(MAX_SINGLE) {
        if n == 1 {
            break;
        }
        reset();
        // SAFETY: the host's batch conforms to the header.
        let alone = unsafe { BatchInputs::of(call.kind, call.batch, i..i + 1) };
        let Some(single) = call.call(i..i + 1, &alone) else {
            return error(&call.place(), "it fails when a sensor is measured alone");
        };
        if let Some((_, what)) = first_difference(kind, &own[i..=i], &single) {
            let text = format!(
                "{what} of sensor {i} of a batch of {n} differs from that of the same sensor measured alone: a sensor \
                 must not depend on the other sensors of its batch"
            );
            return error(&call.place(), text);
        }
    }
}

/// Returns the index of the first sensor whose outputs differ, and what differs.
fn first_difference(kind: &SensorKind, one: &[SensorOutput], other: &[SensorOutput]) -> Option<(usize, String)> {
    let pairs = one.iter().zip(other).enumerate();
    { pairs }.find(|(_, (a, b))| a != b).map(|(i, (a, b))| {
        let field = a.fields.iter().zip(&b.fields).position(|(a, b)| a != b);
        let what = match field {
            Some(k) => format!("`{}`", kind.fields[k].name),
            None if a.state != b.state => "the state block".to_owned(),
            None => "the status".to_owned(),
        };
        (i, what)
    })
}

/// Numbers for extreme inputs.
pub struct Numbers(u64);

impl Numbers {
    /// Starts a sequence of numbers.
    pub fn new(seed: u64) -> Self {
        Numbers(seed)
    }
    /// Returns a number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    /// Returns 0 or a number of either sign, up to this size, of any order of magnitude.
    pub fn signed(&mut self, most: f64) -> f64 {
        let size = most * libm::pow(10.0, -6.0 * self.unit());
        match (8.0 * self.unit()) as u32 {
            0 => 0.0,
            1..=4 => size,
            _ => -size,
        }
    }
    /// Returns a unit quaternion, often of a rotation by multiples of 45 degrees.
    pub fn rotation(&mut self) -> [f64; 4] {
        let mut q = match self.unit() < 0.5 {
            true => std::array::from_fn(|_| [0.0, 0.5, -0.5, 0.5f64.sqrt()][(4.0 * self.unit()) as usize]),
            false => std::array::from_fn(|_| 2.0 * self.unit() - 1.0),
        };
        let size = q.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
        if size < 1e-3 {
            return [0.0, 0.0, 0.0, 1.0];
        }
        q.iter_mut().for_each(|x| *x /= size);
        q
    }
}

fn extremes(call: &BatchCall<'_>, inputs: &BatchInputs) {
    let kind = call.kind;
    let n = call.batch.n as usize;
    let elements =
        inputs.beams.distance.as_ref().map_or(0, Vec::len) + inputs.pixels.depth.as_ref().map_or(0, Vec::len);
    let count = if elements > MANY_ELEMENTS { EXTREMES / 12 } else { EXTREMES };
    let mut numbers = Numbers::new(inputs.step);
    for v in 0..count {
        let changed = extreme(inputs, v, &mut numbers);
        let Some(outputs) = call.call(0..n, &changed) else {
            return error(&call.place(), "it fails for some inputs, such as other distances, poses or times");
        };
        for o in outputs.iter().filter(|o| o.status >= 0) {
            let values: Vec<Vec<f64>> =
                kind.fields.iter().zip(&o.fields).map(|(f, bytes)| judge::numbers(f.elem, bytes)).collect();
            judge::judge(kind, &values);
        }
    }
}

/// Returns inputs that are consistent, but unusual.
fn extreme(inputs: &BatchInputs, v: u64, numbers: &mut Numbers) -> BatchInputs {
    let mut out = inputs.clone();
    // Steps count up, in case something happens in every n-th of them.
    out.step = inputs.step + v;
    out.time = if v % 5 == 4 { 1e7 * numbers.unit() } else { inputs.time + v as f64 * inputs.dt };
    let share = [0.0, 1.0, 0.3][v as usize % 3];
    let n = inputs.beams.distance.as_ref().map_or(0, Vec::len);
    for k in 0..n {
        let misses = numbers.unit() < share;
        let scale = if v.is_multiple_of(2) { 1.0 } else { libm::pow(10.0, -5.0 * numbers.unit()) };
        scale_hit(&mut out, k, scale, misses);
    }
    for k in 0..inputs.pixels.depth.as_ref().map_or(0, Vec::len) {
        if numbers.unit() < share {
            out.pixels.depth.iter_mut().for_each(|d| d[k] = f32::INFINITY);
            out.pixels.pixel_cosine.iter_mut().for_each(|c| c[k] = 0.0);
            out.pixels.pixel_object.iter_mut().for_each(|o| o[k] = 0);
        }
    }
    if !v.is_multiple_of(4) {
        for p in out.motion.pose.iter_mut().flatten() {
            let q = numbers.rotation();
            (0..3).for_each(|i| p[i] = numbers.signed(1e4));
            p[3..].copy_from_slice(&q);
        }
        let six = |all: &mut Option<Vec<[f64; 6]>>, most: f64, numbers: &mut Numbers| {
            all.iter_mut().flatten().flatten().for_each(|x| *x = numbers.signed(most));
        };
        six(&mut out.motion.twist, 50.0, numbers);
        six(&mut out.motion.acceleration, 500.0, numbers);
        six(&mut out.motion.wrench, 1e4, numbers);
        out.motion.joint.iter_mut().flatten().flatten().for_each(|x| *x = numbers.signed(100.0));
    }
    let moved = out.targets.target_pose.iter_mut().flatten().zip(out.targets.target_twist.iter_mut().flatten());
    for (k, (pose, twist)) in moved.enumerate() {
        match (v + k as u64) % 4 {
            0 => {}
            // As if the object had been removed.
            1 => {
                (*pose, *twist) = ([f64::NAN; 7], [f64::NAN; 6]);
                out.targets.target.iter_mut().for_each(|all| all[k] = 0);
            }
            _ => {
                let q = numbers.rotation();
                (0..3).for_each(|i| pose[i] = numbers.signed(1e4));
                pose[3..].copy_from_slice(&q);
                twist.iter_mut().for_each(|x| *x = numbers.signed(50.0));
            }
        }
    }
    if v % 7 == 6 {
        out.gravity = [0.0; 3];
    }
    if v % 11 == 10 {
        out.motion.twist.iter_mut().flatten().for_each(|t| *t = [0.0; 6]);
        out.motion.acceleration.iter_mut().flatten().for_each(|t| *t = [0.0; 6]);
        out.motion.wrench.iter_mut().flatten().for_each(|t| *t = [0.0; 6]);
    }
    if v % 3 == 2 {
        out.contacts.first_contact.fill(0);
        out.contacts.contact.iter_mut().for_each(Vec::clear);
        out.contacts.friction.iter_mut().for_each(Vec::clear);
    }
    out
}

/// Moves the hit of a beam nearer, or removes it.
fn scale_hit(out: &mut BatchInputs, k: usize, scale: f64, misses: bool) {
    out.beams.distance.iter_mut().for_each(|d| d[k] = if misses { f64::INFINITY } else { d[k] * scale });
    out.beams.point.iter_mut().for_each(|p| p[k] = if misses { [0.0; 3] } else { p[k].map(|x| x * scale) });
    if misses {
        out.beams.normal.iter_mut().for_each(|x| x[k] = [0.0; 3]);
        out.beams.object.iter_mut().for_each(|x| x[k] = 0);
        out.beams.color.iter_mut().for_each(|x| x[k] = [0; 3]);
        out.beams.primitive.iter_mut().for_each(|x| x[k] = 0);
        out.beams.hit_twist.iter_mut().for_each(|x| x[k] = [0.0; 6]);
    }
}
