//! The life cycle of all instances: one set of functions, generic over the kind.

use std::ffi::c_void;

use tatu_plugin_api::{abi::*, safe::guarded_quietly};

use crate::{
    Shared, guarded,
    plan::{self, Plan},
    size,
};

/// The data of an instance.
pub struct Data {
    plan: *const Plan,
    pub world: *mut tatu_world,
    /// The id of the instance, unique in its world.
    pub id: u64,
}

impl Data {
    pub fn plan(&self) -> &Plan {
        // SAFETY: the plan belongs to the plugin, which outlives its instances.
        unsafe { &*self.plan }
    }
    /// # Safety
    /// `data` was made by `create` and has not been destroyed.
    pub unsafe fn of<'a>(data: *mut c_void) -> &'a Data {
        // SAFETY: the caller guarantees that `data` points to a live `Data`.
        unsafe { &*data.cast::<Data>() }
    }
}

/// A kind of instance.
pub trait Kind {
    const NAME: &'static str;
}
pub struct World;
pub struct Sensor;
pub struct Actuator;
pub struct Script;
pub struct Service;
impl Kind for World {
    const NAME: &'static str = "world";
}
impl Kind for Sensor {
    const NAME: &'static str = "sensor";
}
impl Kind for Actuator {
    const NAME: &'static str = "actuator";
}
impl Kind for Service {
    const NAME: &'static str = "service";
}
impl Kind for Script {
    const NAME: &'static str = "script";
}

fn name<K: Kind>(function: &str) -> String {
    format!("tatu_life.{function}:{}", K::NAME)
}

unsafe extern "C" fn create<K: Kind>(
    me: *mut c_void,
    info: *const tatu_instance,
    data: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; the host passes a valid description and a valid pointer for the result.
        unsafe {
            let status = Plan::of(me).act(&name::<K>("create"), || Ok(77))?;
            *data = Box::into_raw(Box::new(Data { plan: me.cast(), world: (*info).world, id: (*info).id })).cast();
            Ok(status.unwrap_or(TATU_OK))
        }
    })
}

unsafe extern "C" fn destroy<K: Kind>(data: *mut c_void) {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `Box::into_raw` in `create`, and is destroyed once.
        let data = unsafe { Box::from_raw(data.cast::<Data>()) };
        data.plan().act_quietly(&name::<K>("destroy"), plan::other_mode);
    });
}

unsafe extern "C" fn configure<K: Kind>(
    data: *mut c_void,
    _: *const tatu_value,
    _: u32,
    _: u64,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe { Ok(Data::of(data).plan().act(&name::<K>("configure"), || Ok(77))?.unwrap_or(TATU_OK)) })
}

unsafe extern "C" fn save<K: Kind>(
    data: *mut c_void,
    writer: *const tatu_writer,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the writer is valid during the call.
        unsafe {
            let plan = Data::of(data).plan();
            if let Some(write) = (*writer).write {
                write(writer, b"saved".as_ptr().cast(), 5);
            }
            Ok(plan.act(&name::<K>("save"), || Ok(77))?.unwrap_or(TATU_OK))
        }
    })
}

unsafe extern "C" fn load<K: Kind>(data: *mut c_void, _: tatu_str, _: u32, error: *mut tatu_error) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe { Ok(Data::of(data).plan().act(&name::<K>("load"), || Ok(77))?.unwrap_or(TATU_OK)) })
}

unsafe extern "C" fn end_run<K: Kind>(
    _: *mut c_void,
    data: *mut c_void,
    _: *mut tatu_world,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe { Ok(Data::of(data).plan().act(&name::<K>("end_run"), || Ok(77))?.unwrap_or(TATU_OK)) })
}

const fn of<K: Kind>() -> Shared<tatu_life> {
    Shared(tatu_life {
        size: size::<tatu_life>(),
        state_bytes: 8,
        create: Some(create::<K>),
        destroy: Some(destroy::<K>),
        configure: Some(configure::<K>),
        save: Some(save::<K>),
        load: Some(load::<K>),
        version: 1,
        reserved: 0,
        end_run: Some(end_run::<K>),
    })
}

pub static WORLD: Shared<tatu_life> = of::<World>();
pub static SENSOR: Shared<tatu_life> = of::<Sensor>();
pub static ACTUATOR: Shared<tatu_life> = of::<Actuator>();
pub static SCRIPT: Shared<tatu_life> = of::<Script>();
pub static SERVICE: Shared<tatu_life> = of::<Service>();
