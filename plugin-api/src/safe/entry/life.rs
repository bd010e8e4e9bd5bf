//! The life cycle of instances: the functions that the host calls, generic over kinds of instances.

use std::ffi::c_void;

use crate::abi::*;
use crate::safe::{
    Change, Fail, Instance, PerWorld, Plugin, Result, ValueRef, World,
    declare::plugin::Started,
    entry::guard::{quiet, run},
    value::fail::bytes_of,
};

/// What the host keeps as the `data` of an instance: of a world, sensor, actuator, script or service. It is called on
/// one thread at a time; calls may nest.
pub(crate) trait Life: Sized + 'static {
    /// The plugin that offers it.
    type Plugin: Plugin;
    /// Version of the state block and of what `save` writes.
    const STATE_VERSION: u32 = 0;

    fn create(started: &Started<Self::Plugin>, info: &Info<'_>) -> Result<Self>;
    fn configure(&self, params: &[ValueRef<'_>], changed: u64) -> Result<Change> {
        let _ = (params, changed);
        Ok(Change::Rebuild)
    }
    /// Whether `end_run` is called; else the end of a run recreates the instance.
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
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("it does not restore state")) }
    }
}

/// What an instance is created with.
pub(crate) struct Info<'a> {
    pub world: World<'a>,
    pub instance: Instance,
    pub params: &'a [ValueRef<'a>],
    pub session: *mut tatu_session,
}

/// The functions of a kind of instance, with that many bytes of state stored by the host.
pub(crate) fn table<L: Life>(state_bytes: usize) -> tatu_life {
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

/// The instance of a call.
///
/// # Safety
/// `data` is what `create` of this type made, and it is not destroyed within `'a`.
pub(crate) unsafe fn of<'a, L: Life>(data: *mut c_void) -> &'a L {
    // SAFETY: the caller promises it.
    unsafe { &*data.cast::<L>() }
}

unsafe extern "C" fn create<L: Life>(
    me: *mut c_void,
    info: *const tatu_instance,
    data: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `me` was made by `init`; the host gives a valid description, as many values as it states, and a place
        // for the pointer.
        let (started, info, data) = unsafe {
            let (started, raw) = (&*me.cast::<Started<L::Plugin>>(), &*info);
            let info = Info {
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

unsafe extern "C" fn destroy<L: Life>(data: *mut c_void) {
    quiet(|| {
        // SAFETY: made by `create`, given back once.
        drop(unsafe { Box::from_raw(data.cast::<L>()) });
    });
}

unsafe extern "C" fn configure<L: Life>(
    data: *mut c_void,
    params: *const tatu_value,
    n: u32,
    changed: u64,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: made by `create`; the host gives as many values as it states.
        let (data, params) = unsafe { (of::<L>(data), ValueRef::slice(params, n as usize)) };
        Ok(match data.configure(params, changed)? {
            Change::Taken => TATU_OK,
            Change::Rebuild => TATU_ERR_UNSUPPORTED,
        })
    })
}

unsafe extern "C" fn save<L: Life>(
    data: *mut c_void,
    writer: *const tatu_writer,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: made by `create`; the host gives a valid writer.
        let (data, write) = unsafe { (of::<L>(data), writer.as_ref().and_then(|w| w.write)) };
        let write = write.ok_or_else(|| Fail::new("the host passed no writer"))?;
        let bytes = data.save()?;
        // SAFETY: the host's function with its writer; the bytes are copied.
        unsafe { write(writer, bytes.as_ptr().cast(), bytes.len() as u64) };
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn load<L: Life>(
    data: *mut c_void,
    bytes: tatu_str,
    version: u32,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: made by `create`; the bytes are valid during the call.
        let (data, bytes) = unsafe { (of::<L>(data), bytes_of(bytes)) };
        data.load(bytes, version)?;
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn end_run<L: Life>(
    me: *mut c_void,
    data: *mut c_void,
    world: *mut tatu_world,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `me` was made by `init`, `data` by `create`; the host gives a world that exists.
        let (started, data, world) = unsafe {
            let started = &*me.cast::<Started<L::Plugin>>();
            (started, of::<L>(data), World::new(world, &started.host))
        };
        data.end_run(&started.plugin, &world)?;
        Ok(TATU_OK)
    })
}

/// A plugin's state of a world.
pub(crate) struct Kept<P: PerWorld>(pub(crate) P::World);

impl<P: PerWorld> Life for Kept<P> {
    type Plugin = P;
    const STATE_VERSION: u32 = P::STATE_VERSION;
    const OUTLIVES_RUNS: bool = P::OUTLIVES_RUNS;

    fn create(started: &Started<P>, info: &Info<'_>) -> Result<Self> {
        started.plugin.world(&info.world).map(Kept)
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
