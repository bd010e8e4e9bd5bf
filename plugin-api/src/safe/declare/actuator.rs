//! Actuator kinds, which compute a wrench and an effort from motion and commands.

use std::{cell::RefCell, ffi::c_void, sync::Arc};

use crate::abi::*;
use crate::safe::{
    Change, Fail, Instance, Param, Params, Plugin, Result, SharedWorld, ValueRef,
    declare::plugin::StartedPlugin,
    entry::{
        life::{self, InstanceInfo, InstanceLife},
        panics,
    },
    value::{
        field::Field,
        list_cache::cached_list,
        sample::Readout,
        table_arena::TableArena,
        target::{Target, TargetArrays},
    },
};

/// The input of one actuator of a batch: the motion of its mount, and its commands.
pub struct Drive<'a> {
    batch: &'a tatu_actuator_batch,
    commands: &'a [f64],
    i: usize,
}

impl<'a> Drive<'a> {
    /// Creates the input of instance `i` of a batch. For hosts, and for tests without a host.
    ///
    /// # Safety
    /// The batch must be valid for `'a`, as described in `tatu/actuator.h`, and `i` must be less than its `n`.
    pub unsafe fn new(batch: &'a tatu_actuator_batch, commands: &'a [f64], i: usize) -> Self {
        Drive { batch, commands, i }
    }
    /// Returns this instance's element of an array with one element per instance.
    fn own<T: Copy>(&self, array: *const T) -> T {
        // SAFETY: `array` is one of the host's arrays, which are valid during the call and have one element for each of
        // the batch's `n` instances; `i` is below `n`.
        unsafe { *array.add(self.i) }
    }
    /// Returns the simulation time, s.
    pub fn time(&self) -> f64 {
        self.batch.time
    }
    /// Returns the time until the next call, s, during which the output acts.
    pub fn dt(&self) -> f64 {
        self.batch.dt
    }
    /// Returns the actuator's object.
    pub fn actuator(&self) -> tatu_object {
        self.own(self.batch.actuator)
    }
    /// Returns the mount's pose in the world frame: x y z, quaternion x y z w.
    pub fn pose(&self) -> [f64; 7] {
        self.own(self.batch.pose.cast())
    }
    /// Rotates a direction from the mount's frame to the world frame.
    pub fn to_world(&self, v: [f64; 3]) -> [f64; 3] {
        let [_, _, _, x, y, z, w] = self.pose();
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let t = cross([x, y, z], v).map(|c| 2.0 * c);
        let u = cross([x, y, z], t);
        [v[0] + w * t[0] + u[0], v[1] + w * t[1] + u[1], v[2] + w * t[2] + u[2]]
    }
    /// Returns the mount's twist in the world frame: linear (m/s), then angular velocity (rad/s).
    pub fn twist(&self) -> [f64; 6] {
        self.own(self.batch.twist.cast())
    }
    /// Returns position (rad or m) and velocity of the joint that the actuator acts on; both are 0 without a joint.
    pub fn joint(&self) -> [f64; 2] {
        self.own(self.batch.joint.cast())
    }
    /// Returns the values of its commands, in the order of [`Actuator::commands`].
    pub fn commands(&self) -> &'a [f64] {
        self.commands
    }
    fn target_arrays(&self) -> TargetArrays {
        let b = self.batch;
        TargetArrays { first: b.first_target, object: b.target, pose: b.target_pose, twist: b.target_twist }
    }
    /// Returns the targets that the scene lists for the actuator, in the order of the list; `None` stands for an object
    /// that does not exist, for instance because it has been removed. Requires `TATU_IN_TARGETS`.
    pub fn targets(&self) -> impl ExactSizeIterator<Item = Option<Target>> + use<'a> {
        // SAFETY: the arrays are those of a batch that is valid for `'a`, and `i` is below its `n`.
        unsafe { self.target_arrays().of::<'a>(self.i) }
    }
    /// Returns this instance's part of an array with one element per contact.
    fn per_contact<T>(&self, array: *const T) -> &'a [T] {
        let ends = self.batch.first_contact;
        if ends.is_null() || array.is_null() {
            return &[];
        }
        // SAFETY: `ends` has n + 1 entries, and `array` contains all contacts of the batch, so the range is within it.
        unsafe {
            let (from, to) = (*ends.add(self.i) as usize, *ends.add(self.i + 1) as usize);
            std::slice::from_raw_parts(array.add(from), to - from)
        }
    }
    /// Returns the contacts of the shape on which the wrench acts, after the last physics step; this shape is the second
    /// one of each. Requires `TATU_IN_CONTACTS`.
    pub fn contacts(&self) -> &'a [tatu_contact] {
        self.per_contact(self.batch.contact)
    }
    /// Returns for each contact the friction on that shape, world frame, N. Requires `TATU_IN_CONTACTS`.
    pub fn frictions(&self) -> &'a [[f64; 3]] {
        self.per_contact(self.batch.friction.cast())
    }
}

/// The output of one actuator, which acts until the next call and is initially 0, and its state.
pub struct Output<'a> {
    /// Force on the mount's origin, world frame, N.
    pub force: [f64; 3],
    /// Torque on the mount, world frame, N m.
    pub torque: [f64; 3],
    /// Torque (N m) or force (N) added to that of the joint that the actuator acts on.
    pub effort: f64,
    /// [`Actuator::STATE`] values that persist between calls; zeroed when the scene is reset.
    pub state: &'a mut [f64],
    /// For each target, the force (N) at its origin and the torque (N m) on its body, world frame, which are initially 0.
    /// Empty without `TATU_IN_TARGETS`.
    pub target_wrenches: &'a mut [[f64; 6]],
    /// The buffers of the actuator's own readings, [`Actuator::fields`], which are initially 0.
    pub report: Readout<'a>,
}

/// A kind of actuator. There is one value per actuator in a world.
pub trait Actuator: Sized + Send + Sync + 'static {
    /// The plugin that offers this kind of actuator.
    type Plugin: Plugin;
    /// Id of the kind of actuator in scene files, such as "thruster".
    const ID: &'static str;
    /// Description for documentation and lists, one sentence.
    const TEXT: &'static str;
    /// Whether `apply` is called before each physics step, instead of once per step of the world.
    const EVERY_SUBSTEP: bool = false;
    /// Inputs beyond the motion of the mount: a bitwise OR of `TATU_IN_TARGETS` and `TATU_IN_CONTACTS`.
    const INPUTS: u32 = 0;
    /// Number of values in [`Output::state`], which persist between calls to an instance. The host stores them, so they
    /// are part of snapshots and survive a reload.
    const STATE: usize = 0;
    /// Version of these values and of the data that [`Actuator::save`] writes; increase it when their meaning changes.
    const STATE_VERSION: u32 = 0;

    /// Schemas that its own readings fill, such as "encoder/1".
    const SCHEMAS: &'static [&'static str] = &[];

    /// Declares the parameters of this kind of actuator.
    fn params() -> Vec<Param>;
    /// Declares the fields of its own readings, such as its speed and current, which are read like those of a sensor.
    /// By default there are none.
    fn fields() -> Vec<Field> {
        Vec::new()
    }
    /// Declares the commands of this kind of actuator, which must be floats. Scenes set them like parameters; scripts
    /// can set them at any time.
    fn commands() -> Vec<Param>;
    /// Creates an instance. `world` is read-only.
    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self>;
    /// Applies new values of parameters to a live instance; `changed` has a bit for each of the first 64 parameters, in
    /// the order of declaration. The state is retained. If this fails, the old values remain in effect. Not called for
    /// parameters with [`Param::rebuilds`].
    fn configure(&mut self, params: &Params<'_>, changed: u64) -> Result<Change> {
        let _ = (params, changed);
        Ok(Change::Rebuild)
    }
    /// Saves, for a snapshot, all data other than parameters, commands and [`Actuator::STATE`] that affects the output.
    /// Most actuators have no such data.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    /// Restores data that version `version` of `save` wrote, in an actuator created with the same parameters.
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("this actuator cannot restore a saved state")) }
    }
    /// Computes forces from the commands. Must not block. Different instances may be called on different threads at
    /// once.
    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result;
}

pub(crate) fn table<A: Actuator>(keep: &mut TableArena) -> *const tatu_actuator {
    let params = params_of::<A>().iter().map(|p| p.to_table(keep)).collect();
    let commands: Vec<_> = commands_of::<A>().iter().map(|p| p.to_table(keep)).collect();
    let fields = fields_of::<A>().iter().map(|f| f.to_table(keep)).collect();
    let raw = tatu_actuator {
        size: size_of::<tatu_actuator>() as u32,
        flags: if A::EVERY_SUBSTEP { TATU_ACTUATOR_EVERY_SUBSTEP } else { 0 },
        n_commands: commands.len() as u32,
        reserved: 0,
        id: keep.text(A::ID),
        text: keep.text(A::TEXT),
        params: keep.list(params),
        commands: keep.list(commands),
        life: keep.table(life::table::<ActuatorInstance<A>>(A::STATE * size_of::<f64>())),
        apply: Some(apply::<A>),
        schemas: keep.texts(A::SCHEMAS),
        fields: keep.list(fields),
        inputs: A::INPUTS,
        reserved2: 0,
    };
    keep.table(raw)
}

/// The `data` that the host stores for an instance.
struct ActuatorInstance<A> {
    /// The actuator, in a cell because it must not be used while it is being configured, not even by a nested call.
    /// Only one thread at a time uses an instance.
    actuator: RefCell<A>,
    /// Number of commands that were declared to the host.
    n_commands: usize,
    /// The fields that were declared to the host.
    fields: Arc<[Field]>,
}

struct ActuatorParams<A>(A);
struct ActuatorCommands<A>(A);
struct ActuatorFields<A>(A);

fn params_of<A: Actuator>() -> Arc<[Param]> {
    cached_list::<ActuatorParams<A>, _>(A::params)
}
fn commands_of<A: Actuator>() -> Arc<[Param]> {
    cached_list::<ActuatorCommands<A>, _>(A::commands)
}
fn fields_of<A: Actuator>() -> Arc<[Field]> {
    cached_list::<ActuatorFields<A>, _>(A::fields)
}

#[cold]
fn in_use() -> Fail {
    Fail::with_code(TATU_ERR_BUSY, "the actuator is being configured")
}

impl<A: Actuator> InstanceLife for ActuatorInstance<A> {
    type Plugin = A::Plugin;
    const STATE_VERSION: u32 = A::STATE_VERSION;

    fn create(_: &StartedPlugin<A::Plugin>, info: &InstanceInfo<'_>) -> Result<Self> {
        let actuator = A::create(&info.world, info.instance, &Params::new(info.params, &params_of::<A>()))?;
        Ok(ActuatorInstance {
            actuator: actuator.into(),
            n_commands: commands_of::<A>().len(),
            fields: fields_of::<A>(),
        })
    }
    fn configure(&self, params: &[ValueRef<'_>], changed: u64) -> Result<Change> {
        let mut actuator = self.actuator.try_borrow_mut().map_err(|_| in_use())?;
        actuator.configure(&Params::new(params, &params_of::<A>()), changed)
    }
    fn save(&self) -> Result<Vec<u8>> {
        self.actuator.try_borrow().map_err(|_| in_use())?.save()
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        self.actuator.try_borrow().map_err(|_| in_use())?.load(bytes, version)
    }
}

unsafe extern "C" fn apply<A: Actuator>(
    _: *mut c_void,
    batch: *const tatu_actuator_batch,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: the host passes null or a batch that is valid during the call, and no other thread uses its
        // instances.
        let batch = unsafe { batch.as_ref() }.ok_or_else(|| Fail::new("the host passed no batch"))?;
        // The state is copied to a local buffer and back, because the host owns the state block.
        let mut state = vec![0.0; A::STATE];
        for i in 0..batch.n as usize {
            // SAFETY: the arrays are valid during the call and have one entry per instance, and `i` is below `n`.
            // `data` was created by `create`; `command` has the declared number of values; the state block has the
            // declared size and is 8-byte aligned.
            unsafe {
                let data = life::instance_at::<ActuatorInstance<A>>(*batch.data.add(i));
                // The pointer is null if the instance has no state.
                let block = (*batch.state.add(i)).cast::<f64>();
                if A::STATE > 0 {
                    std::ptr::copy_nonoverlapping(block, state.as_mut_ptr(), A::STATE);
                }
                let commands = match data.n_commands {
                    0 => &[],
                    n => std::slice::from_raw_parts(*batch.command.add(i), n),
                };
                let report = Readout::at((batch.fields, batch.lengths, batch.n_fields), i, &data.fields, &mut []);
                let drive = Drive::new(batch, commands, i);
                let targets = drive.target_arrays().range(i);
                let target_wrenches = match targets.len() {
                    0 => &mut [],
                    n => std::slice::from_raw_parts_mut(batch.target_wrench.cast::<[f64; 6]>().add(targets.start), n),
                };
                let (force, torque, state) = ([0.0; 3], [0.0; 3], &mut state[..]);
                let mut out = Output { force, torque, effort: 0.0, state, target_wrenches, report };
                let actuator = data.actuator.try_borrow().map_err(|_| in_use());
                if let Err(fail) = actuator.and_then(|a| a.apply(&drive, &mut out)) {
                    *batch.status.add(i) = fail.write(error);
                    continue;
                }
                let wrench = batch.wrench.cast::<[[f64; 3]; 2]>().add(i);
                *wrench = [out.force, out.torque];
                *batch.effort.add(i) = out.effort;
                if A::STATE > 0 {
                    std::ptr::copy_nonoverlapping(state.as_ptr(), block, A::STATE);
                }
            }
        }
        Ok(TATU_OK)
    })
}
