//! One call of a part.

use std::{ffi::c_void, time::Instant};

use tatu_devices::actuators::Actuator;
use tatu_plugin_api::abi::*;
use tatu_plugins::{state_block::PAST_STATE, watchdog::PluginCall};

use crate::cell::{
    Caller, WorldCell,
    calls::errors::{check_status, error_object, read_error},
    instance_fault,
};

/// The physics step before which parts are called.
#[derive(Clone, Copy)]
pub(crate) struct PhysicsMoment {
    /// Index of the physics step in its advance, from 0.
    pub index: u32,
    /// Number of physics steps in the advance.
    pub count: u32,
    /// Duration of the physics step, s.
    pub dt: f64,
}

/// A moment at which parts are called.
#[derive(Clone, Copy)]
pub(crate) enum Moment {
    Actuate,
    PhysicsStep(PhysicsMoment),
    Sense,
    /// A pause begins, lasts or ends: one of `TATU_PAUSE_*`.
    Paused(u32),
    End,
    /// An event is delivered: its name and its payload, which are valid during the call.
    Event(tatu_str, *const tatu_value),
    /// A part decides on a pair of shapes, before a physics step.
    Contact(PhysicsMoment, *mut tatu_contact_pair),
}

impl Moment {
    fn call(self) -> PluginCall {
        match self {
            Moment::Actuate => PluginCall::PartActuate,
            Moment::PhysicsStep(_) => PluginCall::PartPhysicsStep,
            Moment::Sense => PluginCall::PartSense,
            Moment::Paused(_) => PluginCall::PartPaused,
            Moment::End => PluginCall::PartEnd,
            Moment::Event(..) => PluginCall::PartEvent,
            Moment::Contact(..) => PluginCall::PartContact,
        }
    }

    fn function(self, part: &tatu_part) -> Option<PartFunction> {
        match self {
            Moment::Actuate => part.actuate.map(PartFunction::Plain),
            Moment::PhysicsStep(_) => part.physics_step.map(PartFunction::Plain),
            Moment::Sense => part.sense.map(PartFunction::Plain),
            Moment::Paused(moment) => part.paused.map(|f| PartFunction::Paused(f, moment)),
            Moment::End => part.end.map(PartFunction::Plain),
            Moment::Event(name, payload) => part.event.map(|f| PartFunction::Event(f, name, payload)),
            Moment::Contact(_, pair) => part.contact.map(|f| PartFunction::Contact(f, pair)),
        }
    }

    /// Returns whether this is the last moment of a step at which a part of this kind is called. Its readings are
    /// published then, so a step adds one reading.
    fn is_last(self, part: &tatu_part) -> bool {
        match self {
            Moment::Sense => true,
            Moment::PhysicsStep(at) => part.sense.is_none() && at.index + 1 == at.count,
            Moment::Actuate => part.sense.is_none() && part.physics_step.is_none(),
            Moment::Paused(_) | Moment::End | Moment::Event(..) | Moment::Contact(..) => false,
        }
    }
}

#[derive(Clone, Copy)]
enum PartFunction {
    Plain(PartFn),
    Paused(unsafe extern "C" fn(*mut c_void, *const tatu_part_call, u32, *mut tatu_error) -> tatu_status, u32),
    Event(PartEventFn, tatu_str, *const tatu_value),
    Contact(PartContactFn, *mut tatu_contact_pair),
}

/// Commands and fields that fit on the stack; more are allocated.
const MAX_INLINE: usize = 16;

/// A list on the stack or, if it is long, on the heap.
struct ShortList<T> {
    inline: [T; MAX_INLINE],
    spilled: Vec<T>,
}

impl<T: Copy> ShortList<T> {
    fn new(blank: T, elements: impl ExactSizeIterator<Item = T>) -> Self {
        let mut list = ShortList { inline: [blank; MAX_INLINE], spilled: Vec::new() };
        if elements.len() > MAX_INLINE {
            list.spilled.extend(elements);
        } else {
            list.inline.iter_mut().zip(elements).for_each(|(place, x)| *place = x);
        }
        list
    }
    fn first(&self) -> *const T {
        if self.spilled.is_empty() { self.inline.as_ptr() } else { self.spilled.as_ptr() }
    }
}

/// What a call passes to a part, besides the moment.
struct PartArguments {
    kind: usize,
    slot: u32,
    data: *mut c_void,
    part: tatu_object,
    owner: tatu_object,
    state: *mut c_void,
    fields: ShortList<*mut c_void>,
    n_fields: usize,
    lengths: *const u64,
}

impl PartArguments {
    /// Reads the arguments from a device. The pointers are valid until the device is ended.
    fn of(d: &mut Actuator, owner: tatu_object) -> Self {
        let null = std::ptr::null_mut();
        let (fields, n_fields, lengths) = match &mut d.report {
            None => (ShortList::new(null, std::iter::empty::<*mut c_void>()), 0, std::ptr::null()),
            Some(report) => {
                let (first, spans) = (report.fields.as_mut_ptr(), &report.layout.spans);
                let places = spans.iter().map(|(at, _)| first.wrapping_add(*at).cast::<c_void>());
                (ShortList::new(null, places), spans.len(), report.layout.lengths.as_ptr())
            }
        };
        let state = d.state.data_ptr();
        PartArguments {
            kind: d.kind,
            slot: d.slot,
            data: d.data,
            part: d.object,
            owner,
            state,
            fields,
            n_fields,
            lengths,
        }
    }
}

/// Calls the part at this index of the devices, if it has a function for the moment and is neither switched off nor being
/// called. Returns whether it has new readings to publish.
pub(super) fn call_at(world: &WorldCell, at: usize, moment: Moment) -> bool {
    let (arguments, function, commands, is_last) = {
        let (Ok(mut actuators), Ok(scene)) = (world.devices.actuators.try_borrow_mut(), world.state.scene.try_borrow())
        else {
            return false;
        };
        let Some(d) = actuators.devices.get_mut(at).filter(|d| !d.off) else { return false };
        let Some(table) = &world.model.registry.actuators[d.kind].part else { return false };
        let Some(function) = moment.function(table) else { return false };
        let Some(object) = scene.get(d.slot).filter(|_| scene.id(d.slot) == d.object) else { return false };
        let Some(record) = d.part.as_deref_mut().filter(|p| !p.running && !p.ended) else { return false };
        record.running = true;
        record.calls += 1;
        record.ended = matches!(moment, Moment::End);
        let commands = object.data.actuator_or_part().map_or(&[][..], |a| &a.commands);
        let commands = ShortList::new(0.0, commands.iter().copied());
        let owner = if object.parent == 0 { 0 } else { scene.id(object.parent) };
        (PartArguments::of(d, owner), function, commands, moment.is_last(table))
    };
    let began = Instant::now();
    let done = call(world, &arguments, function, moment, &commands);
    let spent = began.elapsed();
    let time = world.state.clock.time.get();
    let done = {
        let Ok(mut actuators) = world.devices.actuators.try_borrow_mut() else { return false };
        let devices = actuators.devices.get_mut(at);
        let Some(d) = devices.filter(|d| d.object == arguments.part && d.data == arguments.data) else { return false };
        if let Some(record) = d.part.as_deref_mut() {
            record.running = false;
            record.time += spent;
        }
        let done = done.and_then(|()| check_output(world, d));
        if done.is_err() {
            d.off = true;
        }
        if let Some(report) = d.report.as_mut().filter(|_| is_last && done.is_ok()) {
            report.time = Some(time);
        }
        done
    };
    match done {
        Ok(()) => is_last && arguments.n_fields > 0,
        Err((status, text)) => {
            report_failure(world, &arguments, moment, status, &text);
            false
        }
    }
}

/// Calls `end` of a part that has been taken from the devices because its object no longer exists.
pub(super) fn call_removed(world: &WorldCell, d: &mut Actuator) {
    let registry = world.model.registry.shared();
    let kind = &registry.actuators[d.kind];
    let is_over = d.off || d.part.as_deref().is_none_or(|p| p.ended || p.calls == 0);
    let Some(end) = kind.part.as_ref().and_then(|p| p.end).filter(|_| !is_over) else { return };
    let arguments = PartArguments::of(d, 0);
    let commands = ShortList::new(0.0, vec![0.0; kind.commands.len()].into_iter());
    let done = call(world, &arguments, PartFunction::Plain(end), Moment::End, &commands);
    if let Err((status, text)) = done.and_then(|()| check_output(world, d)) {
        report_failure(world, &arguments, Moment::End, status, &text);
    }
}

/// Calls the function, and returns its error, which is empty if the plugin gave no reason. No part of the world may be
/// borrowed.
fn call(
    world: &WorldCell,
    arguments: &PartArguments,
    function: PartFunction,
    moment: Moment,
    commands: &ShortList<f64>,
) -> Result<(), (tatu_status, String)> {
    let calls = &world.run.calls;
    let Some(level) = calls.enter() else {
        return Err((TATU_ERR_BUSY, "its call would be nested too deeply".to_owned()));
    };
    let (clock, plugin) = (&world.state.clock, world.model.registry.actuators[arguments.kind].plugin);
    let in_physics = if let Moment::PhysicsStep(at) | Moment::Contact(at, _) = moment { Some(at) } else { None };
    let begun = clock.time.get() + clock.elapsed_in_step();
    let frame = tatu_part_call {
        size: size_of::<tatu_part_call>() as u32,
        n_fields: arguments.n_fields as u32,
        world: world.raw(),
        part: arguments.part,
        owner: arguments.owner,
        time: in_physics.map_or(clock.time.get(), |p| begun + f64::from(p.index) * p.dt),
        dt: in_physics.map_or(clock.dt.get(), |p| p.dt),
        step: clock.step.get(),
        physics_step: in_physics.map_or(0, |p| p.index),
        n_physics_steps: in_physics.map_or(0, |p| p.count),
        state: arguments.state,
        command: commands.first(),
        fields: arguments.fields.first(),
        lengths: arguments.lengths,
    };
    let error = calls.error_at(level.depth);
    calls.last_refusal.borrow_mut().reset();
    calls.caller.set(Caller { object: arguments.owner, ..Caller::HOST });
    let mark = calls.arena.borrow().mark();
    // SAFETY: the function is from a plugin that is never unloaded, and `data` points to the instance that it created,
    // which is not destroyed while `running` is set. The frame, what it points to and the error object live until the
    // call has returned, and no borrow of the world is active.
    let run = || unsafe {
        match function {
            PartFunction::Plain(f) => f(arguments.data, &frame, error),
            PartFunction::Paused(f, moment) => f(arguments.data, &frame, moment, error),
            PartFunction::Event(f, name, payload) => f(arguments.data, &frame, name, payload, error),
            PartFunction::Contact(f, pair) => f(arguments.data, &frame, pair, error),
        }
    };
    let status = check_status(error, world.call_plugin(plugin, moment.call(), arguments.slot, run), false);
    let is_intact = {
        let mut arena = calls.arena.borrow_mut();
        let is_intact = arena.is_intact_since(mark);
        arena.release(mark);
        is_intact
    };
    drop(level);
    if !is_intact {
        let text = "broke the contract: it wrote past the end of memory that the host gave it (`alloc`)";
        return Err((TATU_ERR, text.to_owned()));
    }
    if status >= 0 {
        return Ok(());
    }
    // A plugin that passes on the status of a host function need not repeat its message.
    if let Some(mut own) = error_object(error).filter(|own| own.code() == TATU_OK) {
        let mut last = calls.last_refusal.borrow_mut();
        if last.code() == status {
            own.copy_from(&last.object());
        }
    }
    let text = read_error(error).text.filter(|text| !text.is_empty());
    Err((status, text.unwrap_or_else(|| "without giving a reason".to_owned())))
}

/// Checks what the part wrote to.
fn check_output(world: &WorldCell, d: &mut Actuator) -> Result<(), (tatu_status, String)> {
    if !d.state.guards_intact() {
        d.state.restore_guards();
        return Err((TATU_ERR, PAST_STATE.to_owned()));
    }
    let Some(report) = &d.report else { return Ok(()) };
    let kind = world.model.registry.actuators[d.kind].readings.map(|k| &world.model.registry.sensors[k]);
    kind.map_or(Ok(()), |kind| report.check(kind)).map_err(|text| (TATU_ERR, text))
}

/// Reports a failed part, which has been switched off, and discards its readings.
#[cold]
fn report_failure(world: &WorldCell, arguments: &PartArguments, moment: Moment, status: tatu_status, text: &str) {
    if arguments.n_fields > 0
        && let Ok(mut sensing) = world.devices.sensing.try_borrow_mut()
        && let Some(i) = sensing.index(arguments.slot)
    {
        sensing.devices[i].discard_reading();
        sensing.devices[i].fields.fill(0);
    }
    report(world, (arguments.kind, arguments.slot), moment, status, text);
}

/// Reports a part, given its kind and slot, that has been switched off.
#[cold]
pub(super) fn report(world: &WorldCell, (kind, slot): (usize, u32), moment: Moment, status: tatu_status, text: &str) {
    let plugin = world.model.registry.actuators[kind].plugin;
    let text = format!("{text} [{}]", moment.call().text());
    world.report(instance_fault(world, plugin, slot, status, &text));
}
