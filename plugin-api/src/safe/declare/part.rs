//! Parts: controllers that act with the world in hand.

use std::{cell::RefCell, ffi::c_void, ops::Deref, sync::Arc};

use crate::abi::*;
use crate::safe::{
    Change, Fail, Host, Instance, Param, Params, Plugin, Preset, Result, SharedWorld, ValueRef, World,
    declare::plugin::StartedPlugin,
    entry::{
        life::{self, InstanceInfo, InstanceLife},
        panics,
    },
    value::{fail::bytes_of, field::Field, list_cache::cached_list, sample::Readout, table_arena::TableArena},
};

/// A moment at which a part is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// The stage `actuate` of each step: [`Part::actuate`].
    Actuate,
    /// Before each physics step: [`Part::physics_step`].
    PhysicsStep,
    /// The stage `sense` of each step: [`Part::sense`].
    Sense,
    /// A pause begins, lasts or ends: [`Part::paused`].
    Paused,
    /// The end of a run: [`Part::end`].
    End,
    /// Before each physics step, for pairs of shapes that the part has registered: [`Part::contact`].
    Contact,
}

/// A moment of a pause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pause {
    /// The first pass in which time does not advance.
    Begins,
    /// Each pass until the pause ends.
    Lasts,
    /// Time is about to advance again.
    Ends,
}

/// A call of a part: the world, and the part's commands, state and readings.
pub struct PartCall<'a> {
    raw: &'a tatu_part_call,
    world: World<'a>,
    commands: &'a [f64],
    /// [`Part::STATE`] values that persist between calls; zeroed when the scene is reset, part of snapshots and of the
    /// hash of the world's state.
    pub state: &'a mut [f64],
    /// The buffers of the part's own readings, [`Part::fields`], which keep their values between calls.
    pub report: Readout<'a>,
}

impl<'a> Deref for PartCall<'a> {
    type Target = World<'a>;
    fn deref(&self) -> &World<'a> {
        &self.world
    }
}

impl<'a> PartCall<'a> {
    /// Returns the world.
    pub fn world(&self) -> World<'a> {
        self.world
    }
    /// Returns the part's own object.
    pub fn part(&self) -> tatu_object {
        self.raw.part
    }
    /// Returns the object that the part belongs to; 0 is the world.
    pub fn owner(&self) -> tatu_object {
        self.raw.owner
    }
    /// Returns the simulation time, s; before a physics step, the time at which that step begins.
    pub fn time(&self) -> f64 {
        self.raw.time
    }
    /// Returns the duration of the step, s: of the physics step in [`Part::physics_step`].
    pub fn dt(&self) -> f64 {
        self.raw.dt
    }
    /// Returns the index of the step, from 0.
    pub fn step(&self) -> u64 {
        self.raw.step
    }
    /// Returns the index of the physics step in its step, and the number of physics steps; zeros outside of
    /// [`Part::physics_step`].
    pub fn physics_steps(&self) -> (u32, u32) {
        (self.raw.physics_step, self.raw.n_physics_steps)
    }
    /// Returns the values of the commands, in the order of [`Part::commands`].
    pub fn commands(&self) -> &'a [f64] {
        self.commands
    }
}

/// A kind of part. There is one value per part in a world, on the thread of that world.
pub trait Part: Sized + 'static {
    /// The plugin that offers this kind of part.
    type Plugin: Plugin;
    /// Id of the kind in scene files, such as "braitenberg".
    const ID: &'static str;
    /// Description for documentation and lists, one sentence.
    const TEXT: &'static str;
    /// The moments at which the part is called. The functions for all others are never called.
    const MOMENTS: &'static [Moment];
    /// Number of values in [`PartCall::state`].
    const STATE: usize = 0;
    /// Version of these values and of the data that [`Part::save`] writes; increase it when their meaning changes.
    const STATE_VERSION: u32 = 0;
    /// Names of the events that [`event`](Self::event) receives; `*` means all except "collision", "separation" and
    /// "contact".
    const EVENTS: &'static [&'static str] = &[];
    /// Schemas that its own readings fill.
    const SCHEMAS: &'static [&'static str] = &[];
    /// Named settings, with parameters and commands.
    const PRESETS: &'static [Preset] = &[];

    /// Declares the parameters of this kind of part.
    fn params() -> Vec<Param>;
    /// Declares the commands, which must be floats. Scenes set them like parameters; scripts, clients and other parts
    /// can set them at any time.
    fn commands() -> Vec<Param> {
        Vec::new()
    }
    /// Declares the fields of its own readings, which are read like those of a sensor.
    fn fields() -> Vec<Field> {
        Vec::new()
    }
    /// Creates an instance. `world` is read-only; all objects exist, but a sensor or part that is declared later may not
    /// have been created yet.
    fn create(plugin: &Self::Plugin, world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self>;
    /// Applies new values of parameters to a live instance, as for an [`Actuator`](crate::safe::Actuator).
    fn configure(&mut self, params: &Params<'_>, changed: u64) -> Result<Change> {
        let _ = (params, changed);
        Ok(Change::Rebuild)
    }
    /// Saves, for a snapshot, all data other than parameters, commands and [`Part::STATE`] that affects what it does.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    /// Restores data that version `version` of `save` wrote, in a part created with the same parameters.
    fn load(&mut self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("this part cannot restore a saved state")) }
    }
    /// Called in the stage `actuate` of each step, after the scripts.
    fn actuate(&mut self, call: &mut PartCall<'_>) -> Result {
        let _ = call;
        Ok(())
    }
    /// Called before each physics step.
    fn physics_step(&mut self, call: &mut PartCall<'_>) -> Result {
        let _ = call;
        Ok(())
    }
    /// Called in the stage `sense` of each step, after the sensors.
    fn sense(&mut self, call: &mut PartCall<'_>) -> Result {
        let _ = call;
        Ok(())
    }
    /// Called when a pause begins, in each pass while it lasts, and when it ends.
    fn paused(&mut self, call: &mut PartCall<'_>, moment: Pause) -> Result {
        let _ = (call, moment);
        Ok(())
    }
    /// Decides on a pair of shapes that was registered with [`World::hook`]: changes the answer in `pair`.
    fn contact(&mut self, call: &mut PartCall<'_>, pair: &mut tatu_contact_pair) -> Result {
        let _ = (call, pair);
        Ok(())
    }
    /// Receives an event, one of [`EVENTS`](Self::EVENTS); the payload is a map.
    fn event(&mut self, call: &mut PartCall<'_>, name: &str, payload: ValueRef<'_>) -> Result {
        let _ = (call, name, payload);
        Ok(())
    }
    /// Called once, at the end of a run or after the part's object has been removed.
    fn end(&mut self, call: &mut PartCall<'_>) -> Result {
        let _ = call;
        Ok(())
    }
}

pub(crate) fn table<A: Part>(keep: &mut TableArena) -> *const tatu_part {
    let params = params_of::<A>().iter().map(|p| p.to_table(keep)).collect();
    let commands: Vec<_> = commands_of::<A>().iter().map(|p| p.to_table(keep)).collect();
    let fields = fields_of::<A>().iter().map(|f| f.to_table(keep)).collect();
    let presets = A::PRESETS.iter().map(|p| p.to_table(keep)).collect();
    let at = |moment, function: PartFn| A::MOMENTS.contains(&moment).then_some(function);
    let raw = tatu_part {
        size: size_of::<tatu_part>() as u32,
        flags: 0,
        id: keep.text(A::ID),
        text: keep.text(A::TEXT),
        params: keep.list(params),
        commands: keep.list(commands),
        life: keep.table(life::table::<PartInstance<A>>(A::STATE * size_of::<f64>())),
        actuate: at(Moment::Actuate, actuate::<A>),
        physics_step: at(Moment::PhysicsStep, physics_step::<A>),
        sense: at(Moment::Sense, sense::<A>),
        paused: if A::MOMENTS.contains(&Moment::Paused) { Some(paused::<A>) } else { None },
        end: at(Moment::End, end::<A>),
        schemas: keep.texts(A::SCHEMAS),
        fields: keep.list(fields),
        presets: keep.list(presets),
        event: if A::EVENTS.is_empty() { None } else { Some(event::<A>) },
        contact: if A::MOMENTS.contains(&Moment::Contact) { Some(contact::<A>) } else { None },
        events: if A::EVENTS.is_empty() { std::ptr::null() } else { keep.texts(A::EVENTS) },
    };
    keep.table(raw)
}

/// The `data` that the host stores for an instance.
struct PartInstance<A> {
    /// The part, with a buffer for its state. It is in a cell because a command that it calls may configure it.
    part: RefCell<(A, Vec<f64>)>,
    host: Host,
    /// Number of commands that were declared to the host.
    n_commands: usize,
    /// The fields that were declared to the host.
    fields: Arc<[Field]>,
}

struct PartParams<A>(A);
struct PartCommands<A>(A);
struct PartFields<A>(A);

fn params_of<A: Part>() -> Arc<[Param]> {
    cached_list::<PartParams<A>, _>(A::params)
}
fn commands_of<A: Part>() -> Arc<[Param]> {
    cached_list::<PartCommands<A>, _>(A::commands)
}
fn fields_of<A: Part>() -> Arc<[Field]> {
    cached_list::<PartFields<A>, _>(A::fields)
}

#[cold]
fn in_use() -> Fail {
    Fail::with_code(TATU_ERR_BUSY, "the part is being called")
}

impl<A: Part> InstanceLife for PartInstance<A> {
    type Plugin = A::Plugin;
    const STATE_VERSION: u32 = A::STATE_VERSION;

    fn create(started: &StartedPlugin<A::Plugin>, info: &InstanceInfo<'_>) -> Result<Self> {
        let params = params_of::<A>();
        let part = A::create(&started.plugin, &info.world, info.instance, &Params::new(info.params, &params))?;
        Ok(PartInstance {
            part: RefCell::new((part, vec![0.0; A::STATE])),
            host: started.host,
            n_commands: commands_of::<A>().len(),
            fields: fields_of::<A>(),
        })
    }
    fn configure(&self, params: &[ValueRef<'_>], changed: u64) -> Result<Change> {
        let mut part = self.part.try_borrow_mut().map_err(|_| in_use())?;
        part.0.configure(&Params::new(params, &params_of::<A>()), changed)
    }
    fn save(&self) -> Result<Vec<u8>> {
        self.part.try_borrow().map_err(|_| in_use())?.0.save()
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        self.part.try_borrow_mut().map_err(|_| in_use())?.0.load(bytes, version)
    }
}

unsafe extern "C" fn actuate<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host passes an instance of this kind and a call that is valid meanwhile.
    unsafe { run::<A>(data, call, error, A::actuate) }
}
unsafe extern "C" fn physics_step<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: as for `actuate`.
    unsafe { run::<A>(data, call, error, A::physics_step) }
}
unsafe extern "C" fn sense<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: as for `actuate`.
    unsafe { run::<A>(data, call, error, A::sense) }
}
unsafe extern "C" fn end<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: as for `actuate`.
    unsafe { run::<A>(data, call, error, A::end) }
}
unsafe extern "C" fn paused<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    moment: u32,
    error: *mut tatu_error,
) -> tatu_status {
    let moment = match moment {
        TATU_PAUSE_BEGINS => Pause::Begins,
        TATU_PAUSE_ENDS => Pause::Ends,
        _ => Pause::Lasts,
    };
    // SAFETY: as for `actuate`.
    unsafe { run::<A>(data, call, error, |part, call| part.paused(call, moment)) }
}

unsafe extern "C" fn contact<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    pair: *mut tatu_contact_pair,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: as for `actuate`; nothing else uses the pair during the call.
    unsafe {
        run::<A>(data, call, error, |part, call| match pair.as_mut() {
            Some(pair) => part.contact(call, pair),
            None => Err(Fail::new("the host passed no pair")),
        })
    }
}
unsafe extern "C" fn event<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    name: tatu_str,
    payload: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: as for `actuate`; the name and the payload are valid during the call as well.
    unsafe {
        let name = String::from_utf8_lossy(bytes_of(name));
        let payload = ValueRef::slice(payload, 1).first().copied().unwrap_or(ValueRef::NIL);
        run::<A>(data, call, error, |part, call| part.event(call, &name, payload))
    }
}

/// Calls a function of a part.
///
/// # Safety
/// `data` must point to a live instance of this kind, `call` must be valid during this call, as described in
/// `tatu/part.h`, and `error` must be null or an error object of the host.
unsafe fn run<A: Part>(
    data: *mut c_void,
    call: *const tatu_part_call,
    error: *mut tatu_error,
    f: impl FnOnce(&mut A, &mut PartCall<'_>) -> Result,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: the caller guarantees that `data` is a live instance and that `call` is null or valid.
        let (data, call) = unsafe { (life::instance_at::<PartInstance<A>>(data), call.as_ref()) };
        let call = call.ok_or_else(|| Fail::new("the host passed no call"))?;
        let mut part = data.part.try_borrow_mut().map_err(|_| in_use())?;
        let (part, state) = &mut *part;
        let block = call.state.cast::<f64>();
        // SAFETY: the state block has the declared size and is 8-byte aligned. It is copied to a buffer and back, because
        // the host owns it and may read it while the part calls host functions. The commands have the declared number,
        // and nothing else writes the fields meanwhile.
        unsafe {
            if A::STATE > 0 {
                std::ptr::copy_nonoverlapping(block, state.as_mut_ptr(), A::STATE);
            }
            let commands = match data.n_commands {
                0 => &[],
                n => std::slice::from_raw_parts(call.command, n),
            };
            let report = Readout::at((call.fields, &raw const call.lengths, call.n_fields), 0, &data.fields, &mut []);
            let world = World::new(call.world, &data.host);
            f(part, &mut PartCall { raw: call, world, commands, state: &mut state[..], report })?;
            if A::STATE > 0 {
                std::ptr::copy_nonoverlapping(state.as_ptr(), block, A::STATE);
            }
        }
        Ok(TATU_OK)
    })
}
