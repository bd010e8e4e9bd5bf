//! Calls actuators again with the batches of the host: with the same inputs, which must give the same forces; with
//! extreme ones, which must give finite forces; and with other commands, to compare their units with those of the
//! forces.

use std::{cell::RefCell, ffi::c_void, ops::Range};

use tatu_core::plugins::{ActuatorKind, guarded_copy::GuardedCopy};
use tatu_plugin_api::{
    abi::*,
    safe::{Target, Value},
};

use super::{
    finding::error,
    sensor_probes::{DeviceProbe, Numbers},
    units,
};

/// Number of extreme inputs per batch.
const EXTREMES: u64 = 60;
/// Maximum number of actuators of a batch that act alone.
const MAX_SINGLE: usize = 4;
/// Number of elements before and after each output, which must not change.
const MARGIN: usize = 16;
const MARGIN_VALUE: f64 = 6.022_140_76e23;

/// The inputs of actuators, which can be changed.
#[derive(Clone)]
struct ActuatorInputs {
    time: f64,
    dt: f64,
    pose: Vec<[f64; 7]>,
    twist: Vec<[f64; 6]>,
    joint: Vec<[f64; 2]>,
    command: Vec<Vec<f64>>,
    /// Per actuator: its targets, with the object 0 for missing ones, and its contacts with their friction.
    targets: Vec<Vec<Target>>,
    contacts: Vec<Vec<(tatu_contact, [f64; 3])>>,
}

/// What the plugin wrote for one actuator.
#[derive(Clone)]
struct ActuatorOutput {
    wrench: [f64; 6],
    effort: f64,
    /// The wrenches on targets that exist.
    on_targets: Vec<[f64; 6]>,
    state: Vec<u8>,
    status: tatu_status,
}

impl PartialEq for ActuatorOutput {
    fn eq(&self, other: &Self) -> bool {
        let numbers = |o: &Self| o.numbers().map(f64::to_bits).collect::<Vec<u64>>();
        numbers(self) == numbers(other) && self.state == other.state && self.status == other.status
    }
}

impl ActuatorOutput {
    fn numbers(&self) -> impl Iterator<Item = f64> {
        self.wrench.iter().chain([&self.effort]).chain(self.on_targets.iter().flatten()).copied()
    }
    fn is_finite(&self) -> bool {
        self.numbers().all(f64::is_finite)
    }
}

/// Returns the range of the targets or contacts of an actuator, by the array of first indices.
///
/// # Safety
/// The array must be null, for no elements, or have an element for each actuator of the batch, and one more.
unsafe fn span(first: *const u64, i: usize) -> Range<usize> {
    // SAFETY: as required of the caller.
    if first.is_null() { 0..0 } else { unsafe { *first.add(i) as usize..*first.add(i + 1) as usize } }
}

/// Returns the index of the first element of each part, and of the end.
fn firsts<T>(parts: &[Vec<T>]) -> Vec<u64> {
    let mut all = vec![0];
    parts.iter().for_each(|part| all.push(all[all.len() - 1] + part.len() as u64));
    all
}

/// A batch and the function to call with parts of it.
pub struct ActuatorCall<'a> {
    pub kind: &'a ActuatorKind,
    pub batch: &'a tatu_actuator_batch,
    pub run: RefCell<&'a mut dyn FnMut(&tatu_actuator_batch) -> tatu_status>,
}

impl ActuatorCall<'_> {
    fn place(&self) -> String {
        format!("actuator `{}`", self.kind.id)
    }

    fn inputs(&self) -> ActuatorInputs {
        let b = self.batch;
        let n = b.n as usize;
        // SAFETY: the host's batch has arrays of `n` elements, and a buffer of `n_commands` numbers for each actuator.
        unsafe {
            let commands = |i: usize| {
                let first = *b.command.add(i);
                match self.kind.commands.len() {
                    0 => Vec::new(),
                    count => std::slice::from_raw_parts(first, count).to_vec(),
                }
            };
            let target = |k: usize| {
                let (pose, twist) = (b.target_pose.cast::<[f64; 7]>(), b.target_twist.cast::<[f64; 6]>());
                Target { object: *b.target.add(k), pose: *pose.add(k), twist: *twist.add(k) }
            };
            let touch = |k: usize| (*b.contact.add(k), *b.friction.cast::<[f64; 3]>().add(k));
            ActuatorInputs {
                time: b.time,
                dt: b.dt,
                pose: std::slice::from_raw_parts(b.pose.cast(), n).to_vec(),
                twist: std::slice::from_raw_parts(b.twist.cast(), n).to_vec(),
                joint: std::slice::from_raw_parts(b.joint.cast(), n).to_vec(),
                command: (0..n).map(commands).collect(),
                targets: (0..n).map(|i| span(b.first_target, i).map(target).collect()).collect(),
                contacts: (0..n).map(|i| span(b.first_contact, i).map(touch).collect()).collect(),
            }
        }
    }

    /// Returns the state block of an actuator, unless it has none.
    fn state_of(&self, i: usize) -> Option<*mut u8> {
        // SAFETY: the host's batch has a pointer for each actuator.
        let at = unsafe { *self.batch.state.add(i) }.cast::<u8>();
        (!at.is_null()).then_some(at)
    }

    fn state(&self, i: usize) -> Vec<u8> {
        let bytes = self.kind.life.state_bytes as usize;
        // SAFETY: the block has this size, and no other call uses it.
        self.state_of(i).map_or_else(Vec::new, |at| unsafe { std::slice::from_raw_parts(at, bytes) }.to_vec())
    }

    fn set_states(&self, all: &[Vec<u8>]) {
        for (i, bytes) in all.iter().enumerate() {
            if let Some(at) = self.state_of(i) {
                // SAFETY: the block has at least as many bytes as were copied from it, and no other call uses it.
                unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), at, bytes.len()) };
            }
        }
    }

    /// Calls the function for some actuators with these inputs and separate outputs. Returns `None` if it failed.
    fn call(&self, which: Range<usize>, inputs: &ActuatorInputs) -> Option<Vec<ActuatorOutput>> {
        let (n, b) = (which.len(), self.batch);
        let mut pages: Vec<GuardedCopy> = Vec::new();
        fn add<T, U>(pages: &mut Vec<GuardedCopy>, all: &[T], name: &str) -> *const U {
            // SAFETY: the elements are numbers; their bytes are copied.
            let bytes = unsafe { std::slice::from_raw_parts(all.as_ptr().cast::<u8>(), size_of_val(all)) };
            pages.push(GuardedCopy::new(bytes, &format!("the array `{name}` of its batch, which is read-only")));
            pages.last().map_or(std::ptr::null(), |p| p.first().cast())
        }
        let commands: Vec<*const f64> = which.clone().map(|i| add(&mut pages, &inputs.command[i], "command")).collect();
        let margins = |n: usize| vec![MARGIN_VALUE; n + 2 * MARGIN];
        let (mut wrench, mut effort) = (margins(6 * n), margins(n));
        wrench[MARGIN..MARGIN + 6 * n].fill(0.0);
        effort[MARGIN..MARGIN + n].fill(0.0);
        let mut status = vec![TATU_OK; n + 2 * MARGIN];
        // The readings of actuators are written to separate buffers of the same size.
        let n_fields = b.n_fields as usize;
        let mut fields: Vec<Vec<u64>> = Vec::new();
        for i in which.clone() {
            for k in 0..n_fields {
                // SAFETY: the host's batch has a length for each field of each actuator.
                let length = unsafe { *(*b.lengths.add(i)).add(k) };
                fields.push(vec![0; length as usize + 2 * MARGIN]);
            }
        }
        let buffers: Vec<*mut c_void> = fields.iter_mut().map(|f| f[MARGIN..].as_mut_ptr().cast()).collect();
        let at = which.start;
        let (first_target, first_contact) =
            (firsts(&inputs.targets[which.clone()]), firsts(&inputs.contacts[which.clone()]));
        let targets = inputs.targets[which.clone()].concat();
        let contacts = inputs.contacts[which.clone()].concat();
        let mut on_targets = margins(6 * targets.len());
        on_targets[MARGIN..MARGIN + 6 * targets.len()].fill(0.0);
        let poses: Vec<[f64; 7]> = targets.iter().map(|t| t.pose).collect();
        let twists: Vec<[f64; 6]> = targets.iter().map(|t| t.twist).collect();
        let objects: Vec<tatu_object> = targets.iter().map(|t| t.object).collect();
        let touches: Vec<tatu_contact> = contacts.iter().map(|c| c.0).collect();
        let frictions: Vec<[f64; 3]> = contacts.iter().map(|c| c.1).collect();
        // Arrays that the host does not provide remain null.
        let given = |is_given: bool, first: *const f64| if is_given { first } else { std::ptr::null() };
        let (lists, feels) = (!b.first_target.is_null(), !b.first_contact.is_null());
        let table = tatu_actuator_batch {
            size: b.size,
            n: n as u32,
            time: inputs.time,
            dt: inputs.dt,
            data: b.data.wrapping_add(at),
            state: b.state.wrapping_add(at),
            actuator: b.actuator.wrapping_add(at),
            pose: add(&mut pages, &inputs.pose[which.clone()], "pose"),
            twist: add(&mut pages, &inputs.twist[which.clone()], "twist"),
            joint: add(&mut pages, &inputs.joint[which.clone()], "joint"),
            command: commands.as_ptr(),
            wrench: wrench[MARGIN..].as_mut_ptr(),
            effort: effort[MARGIN..].as_mut_ptr(),
            status: status[MARGIN..].as_mut_ptr(),
            fields: buffers.as_ptr(),
            lengths: if b.lengths.is_null() || n_fields == 0 { b.lengths } else { b.lengths.wrapping_add(at) },
            n_fields: b.n_fields,
            reserved: 0,
            first_target: given(lists, add(&mut pages, &first_target, "first_target")).cast(),
            target: given(lists, add(&mut pages, &objects, "target")).cast(),
            target_pose: given(lists, add(&mut pages, &poses, "target_pose")),
            target_twist: given(lists, add(&mut pages, &twists, "target_twist")),
            target_wrench: if lists { on_targets[MARGIN..].as_mut_ptr() } else { std::ptr::null_mut() },
            first_contact: given(feels, add(&mut pages, &first_contact, "first_contact")).cast(),
            contact: given(feels, add(&mut pages, &touches, "contact")).cast(),
            friction: given(feels, add(&mut pages, &frictions, "friction")),
        };
        let answer = (self.run.borrow_mut())(&table);
        let is_whole =
            |all: &[f64], n: usize| all[..MARGIN].iter().chain(&all[MARGIN + n..]).all(|x| *x == MARGIN_VALUE);
        if !is_whole(&wrench, 6 * n) || !is_whole(&effort, n) {
            error(&self.place(), format!("it writes outside of `wrench` or `effort` of a batch of {n}"));
        }
        if !is_whole(&on_targets, 6 * targets.len()) {
            error(&self.place(), format!("it writes outside of `target_wrench` of a batch of {n}"));
        }
        if answer < 0 {
            return None;
        }
        let existing = |j: usize| (first_target[j] as usize..first_target[j + 1] as usize).filter(|k| objects[*k] != 0);
        let output = |j: usize| ActuatorOutput {
            on_targets: existing(j).map(|k| std::array::from_fn(|c| on_targets[MARGIN + 6 * k + c])).collect(),
            wrench: std::array::from_fn(|k| wrench[MARGIN + 6 * j + k]),
            effort: effort[MARGIN + j],
            state: self.state(at + j),
            status: status[MARGIN + j],
        };
        Some((0..n).map(output).collect())
    }
}

/// Calls the function for the host, and then again as the probe requires. `is_pure`: the state of an instance is in
/// its state block.
pub fn probe(probe: DeviceProbe, is_pure: bool, call: &ActuatorCall<'_>) -> tatu_status {
    let n = call.batch.n as usize;
    let before: Vec<Vec<u8>> = (0..n).map(|i| call.state(i)).collect();
    let status = (call.run.borrow_mut())(call.batch);
    if status < 0 {
        return status;
    }
    // SAFETY: the host's batch has arrays of `n` elements.
    let own: Vec<ActuatorOutput> = unsafe {
        let b = call.batch;
        let output = |i: usize| ActuatorOutput {
            wrench: *b.wrench.cast::<[f64; 6]>().add(i),
            effort: *b.effort.add(i),
            on_targets: span(b.first_target, i)
                .filter(|k| *b.target.add(*k) != 0)
                .map(|k| *b.target_wrench.cast::<[f64; 6]>().add(k))
                .collect(),
            state: call.state(i),
            status: *b.status.add(i),
        };
        (0..n).map(output).collect()
    };
    if own.iter().any(|o| o.status < 0) {
        return status;
    }
    let inputs = call.inputs();
    match probe {
        DeviceProbe::None => {}
        DeviceProbe::Again if !is_pure => {}
        DeviceProbe::Again => again(call, &inputs, &before, &own),
        DeviceProbe::Extremes => extremes(call, &inputs),
        DeviceProbe::Units => compare_units(call, &inputs, &before),
    }
    call.set_states(&own.into_iter().map(|o| o.state).collect::<Vec<_>>());
    status
}

fn again(call: &ActuatorCall<'_>, inputs: &ActuatorInputs, before: &[Vec<u8>], own: &[ActuatorOutput]) {
    let n = own.len();
    call.set_states(before);
    match call.call(0..n, inputs) {
        Some(whole) if whole == own => {}
        _ => {
            let text = "called again with the same inputs and the same state, `apply` returns other forces: it depends \
                        on something else, such as memory outside of the state block or a clock";
            return error(&call.place(), text);
        }
    }
    for i in (0..n.min(MAX_SINGLE)).filter(|_| n > 1) {
        call.set_states(before);
        if call.call(i..i + 1, inputs).is_none_or(|single| single != own[i..=i]) {
            let text = format!(
                "the force of actuator {i} of a batch of {n} differs from that of the same actuator alone: an actuator \
                 must not depend on the others of its batch"
            );
            return error(&call.place(), text);
        }
    }
}

fn extremes(call: &ActuatorCall<'_>, inputs: &ActuatorInputs) {
    let n = inputs.pose.len();
    let mut numbers = Numbers::new(inputs.time.to_bits());
    for v in 0..EXTREMES {
        let mut changed = inputs.clone();
        changed.time = inputs.time + v as f64 * inputs.dt;
        for (i, commands) in changed.command.iter_mut().enumerate() {
            let _ = i;
            for (x, declared) in commands.iter_mut().zip(&call.kind.commands) {
                let most = declared.highest.abs().max(declared.lowest.abs()).min(1e6);
                *x = numbers.signed(if most > 0.0 { most } else { 1e6 }).clamp(declared.lowest, declared.highest);
            }
        }
        if v % 3 > 0 {
            for p in &mut changed.pose {
                let q = numbers.rotation();
                (0..3).for_each(|k| p[k] = numbers.signed(1e3));
                p[3..].copy_from_slice(&q);
            }
            changed.twist.iter_mut().flatten().for_each(|x| *x = numbers.signed(30.0));
            changed.joint.iter_mut().flatten().for_each(|x| *x = numbers.signed(50.0));
        }
        for (k, Target { object, pose, twist }) in changed.targets.iter_mut().flatten().enumerate() {
            match (v + k as u64) % 4 {
                0 => {}
                // As if the object had been removed.
                1 => (*object, *pose, *twist) = (0, [f64::NAN; 7], [f64::NAN; 6]),
                _ => {
                    let q = numbers.rotation();
                    (0..3).for_each(|i| pose[i] = numbers.signed(1e3));
                    pose[3..].copy_from_slice(&q);
                    twist.iter_mut().for_each(|x| *x = numbers.signed(30.0));
                }
            }
        }
        if v % 7 == 6 {
            changed.twist.iter_mut().for_each(|t| *t = [0.0; 6]);
        }
        let Some(outputs) = call.call(0..n, &changed) else {
            return error(&call.place(), "`apply` fails for some commands, poses or velocities");
        };
        if outputs.iter().any(|o| o.status >= 0 && !o.is_finite()) {
            let text = "its force is not finite for some commands, poses or velocities";
            return error(&call.place(), text);
        }
    }
}

/// The sizes of the outputs with the units of forces: force, torque, and the effort, which has either.
fn outputs_in(unit: &str, o: &ActuatorOutput) -> Option<Vec<f64>> {
    let w = o.wrench;
    match unit {
        "N" => Some(vec![w[0], w[1], w[2], o.effort]),
        "N m" => Some(vec![w[3], w[4], w[5], o.effort]),
        _ => None,
    }
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Compares the units of commands, and of parameters that limit forces, with those of the forces.
fn compare_units(call: &ActuatorCall<'_>, inputs: &ActuatorInputs, before: &[Vec<u8>]) {
    let n = inputs.pose.len();
    let act = |changed: &ActuatorInputs| {
        call.set_states(before);
        call.call(0..n, changed)
    };
    for (c, declared) in call.kind.commands.iter().enumerate() {
        let Some(unit) = declared.unit.as_deref().filter(|u| ["N", "N m"].contains(u)) else { continue };
        let with = |x: f64| {
            let mut changed = inputs.clone();
            changed.command.iter_mut().for_each(|all| all[c] = x.clamp(declared.lowest, declared.highest));
            act(&changed)
        };
        let (Some(zero), Some(small), Some(large), Some(most)) = (with(0.0), with(1e-3), with(1.7e-3), with(1e9))
        else {
            continue;
        };
        let size = |a: &[ActuatorOutput], b: &[ActuatorOutput]| {
            Some(difference(&outputs_in(unit, &a[0])?, &outputs_in(unit, &b[0])?))
        };
        let (Some(one), Some(two)) = (size(&zero, &small), size(&zero, &large)) else { continue };
        let (one, two) = (one / 1e-3, two / 1.7e-3);
        if let (Some(text), Some(_)) = (units::confused(one), units::confused(two)) {
            let text = format!(
                "its command `{}` is declared in {unit}, but its force changes by {one:.6} {unit} per {unit}, a factor \
                 of {text}",
                declared.key
            );
            error(&call.place(), text);
        }
        // A limit on the force that is declared as a parameter.
        let limit = size(&zero, &most).unwrap_or(0.0);
        for p in call.kind.params.iter().filter(|p| p.unit.as_deref() == Some(unit)) {
            let Value::Float(declared) = p.fallback else { continue };
            if declared > 0.0
                && let Some(text) = units::confused(limit / declared)
            {
                let text = format!(
                    "its greatest force is {limit:.4} {unit}, but its parameter `{}` is {declared} {unit}, a factor of \
                     {text}",
                    p.key
                );
                error(&call.place(), text);
            }
        }
    }
}
