//! The life cycle of instances: the functions that the host calls, generic over the kinds of instances.

use std::ffi::c_void;

use crate::abi::*;
use crate::safe::{
    Change, Fail, Instance, PerWorld, Plugin, Result, ValueRef, World,
    declare::plugin::StartedPlugin,
    entry::panics::{quiet, run},
    value::fail::bytes_of,
};

/// The type of the `data` that the host stores for an instance: of a world, sensor, actuator, part, script or service. Only
/// one thread at a time calls an instance, but calls may nest.
pub(crate) trait InstanceLife: Sized + 'static {
    /// The plugin to which the instance belongs.
    type Plugin: Plugin;
    /// Version of the state block and of the data that `save` writes.
    const STATE_VERSION: u32 = 0;

    fn create(started: &StartedPlugin<Self::Plugin>, info: &InstanceInfo<'_>) -> Result<Self>;
    fn configure(&self, params: &[ValueRef<'_>], changed: u64) -> Result<Change> {
        let _ = (params, changed);
        Ok(Change::Rebuild)
    }
    /// Whether `end_run` is called at the end of a run; otherwise the instance is recreated.
    const OUTLIVES_RUNS: bool = false;
    fn end_run(&self, plugin: &Self::Plugin, world: &World<'_>) -> Result {
        let _ = (plugin, world);
        Ok(())
    }
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("this instance cannot restore a saved state")) }
    }
}

/// Data with which an instance is created.
pub(crate) struct InstanceInfo<'a> {
    pub world: World<'a>,
    pub instance: Instance,
    pub params: &'a [ValueRef<'a>],
    pub session: *mut tatu_session,
}

/// Builds the function table of a kind of instance, for which the host stores a state block of `state_bytes`.
pub(crate) fn table<L: InstanceLife>(state_bytes: usize) -> tatu_life {
    tatu_life {
        size: size_of::<tatu_life>() as u32,
        state_bytes: state_bytes as u32,
        create: Some(create::<L>),
        destroy: Some(destroy::<L>),
        configure: Some(configure::<L>),
        save: Some(save::<L>),
        load: Some(load::<L>),
        version: L::STATE_VERSION,
        reserved: 0,
        end_run: if L::OUTLIVES_RUNS { Some(end_run::<L>) } else { None },
    }
}

/// Returns the instance that `data` points to.
///
/// # Safety
/// `data` must have been created by `create` of this type, and must not be destroyed within `'a`.
pub(crate) unsafe fn instance_at<'a, L: InstanceLife>(data: *mut c_void) -> &'a L {
    // SAFETY: the caller guarantees that `data` points to a live `L`.
    unsafe { &*data.cast::<L>() }
}

unsafe extern "C" fn create<L: InstanceLife>(
    me: *mut c_void,
    info: *const tatu_instance,
    data: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `me` was created by `init` and lives until shutdown. The host passes a description that is valid
        // during the call, with the stated number of values, and `data` is valid for a write.
        let (started, info, data) = unsafe {
            let (started, raw) = (&*me.cast::<StartedPlugin<L::Plugin>>(), &*info);
            let info = InstanceInfo {
                world: World::new(raw.world, &started.host),
                instance: Instance { owner: raw.owner, id: raw.id, seed: raw.seed },
                params: ValueRef::slice(raw.params, raw.n_params as usize),
                session: raw.session,
            };
            (started, info, &mut *data)
        };
        *data = Box::into_raw(Box::new(L::create(started, &info)?)).cast();
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn destroy<L: InstanceLife>(data: *mut c_void) {
    quiet(|| {
        // SAFETY: `data` was created by `Box::into_raw` in `create`, and the host destroys it only once.
        drop(unsafe { Box::from_raw(data.cast::<L>()) });
    });
}

unsafe extern "C" fn configure<L: InstanceLife>(
    data: *mut c_void,
    params: *const tatu_value,
    n: u32,
    changed: u64,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `data` was created by `create` and is live; `params` points to `n` values, valid during the call.
        let (data, params) = unsafe { (instance_at::<L>(data), ValueRef::slice(params, n as usize)) };
        Ok(match data.configure(params, changed)? {
            Change::Taken => TATU_OK,
            Change::Rebuild => TATU_ERR_UNSUPPORTED,
        })
    })
}

unsafe extern "C" fn save<L: InstanceLife>(
    data: *mut c_void,
    writer: *const tatu_writer,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `data` was created by `create` and is live; the host passes null or a valid writer.
        let (data, write) = unsafe { (instance_at::<L>(data), writer.as_ref().and_then(|w| w.write)) };
        let write = write.ok_or_else(|| Fail::new("the host passed no writer"))?;
        let bytes = data.save()?;
        // SAFETY: `write` belongs to `writer`, and copies the bytes before it returns.
        unsafe { write(writer, bytes.as_ptr().cast(), bytes.len() as u64) };
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn load<L: InstanceLife>(
    data: *mut c_void,
    bytes: tatu_str,
    version: u32,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `data` was created by `create` and is live; the bytes are valid during the call.
        let (data, bytes) = unsafe { (instance_at::<L>(data), bytes_of(bytes)) };
        data.load(bytes, version)?;
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn end_run<L: InstanceLife>(
    me: *mut c_void,
    data: *mut c_void,
    world: *mut tatu_world,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `me` was created by `init` and `data` by `create`, and both are live; the world is valid during the
        // call.
        let (started, data, world) = unsafe {
            let started = &*me.cast::<StartedPlugin<L::Plugin>>();
            (started, instance_at::<L>(data), World::new(world, &started.host))
        };
        data.end_run(&started.plugin, &world)?;
        Ok(TATU_OK)
    })
}

/// A plugin's state for a world.
pub(crate) struct WorldState<P: PerWorld>(pub(crate) P::World);

impl<P: PerWorld> InstanceLife for WorldState<P> {
    type Plugin = P;
    const STATE_VERSION: u32 = P::STATE_VERSION;
    const OUTLIVES_RUNS: bool = P::OUTLIVES_RUNS;

    fn create(started: &StartedPlugin<P>, info: &InstanceInfo<'_>) -> Result<Self> {
        started.plugin.world(&info.world).map(WorldState)
    }
    fn end_run(&self, plugin: &P, world: &World<'_>) -> Result {
        plugin.end_run(&self.0, world)
    }
    fn save(&self) -> Result<Vec<u8>> {
        P::save(&self.0)
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        P::load(&self.0, bytes, version)
    }
}
