//! The life cycle of all instances: one set of functions, generic over the kind.

use std::ffi::c_void;

use tatu_plugin_api::{abi::*, safe::guarded_quietly};

use crate::{
    SyncTable, guarded,
    plan::{self, MisbehaviourPlan},
    size,
};

/// The data of an instance.
pub struct InstanceData {
    plan: *const MisbehaviourPlan,
    pub world: *mut tatu_world,
    /// The id of the instance, unique in its world.
    pub id: u64,
}

impl InstanceData {
    pub fn plan(&self) -> &MisbehaviourPlan {
        // SAFETY: the plan belongs to the plugin, which outlives its instances.
        unsafe { &*self.plan }
    }
    /// Returns the instance to which `data` points.
    ///
    /// # Safety
    /// `data` must have been created by `create` and not destroyed since.
    pub unsafe fn of<'a>(data: *mut c_void) -> &'a InstanceData {
        // SAFETY: the caller guarantees that `data` points to a live `InstanceData`.
        unsafe { &*data.cast::<InstanceData>() }
    }
}

/// A kind of instance.
pub trait InstanceKind {
    const NAME: &'static str;
}
pub struct WorldLife;
pub struct SensorLife;
pub struct ActuatorLife;
pub struct PartLife;
pub struct ScriptLife;
pub struct ServiceLife;
impl InstanceKind for WorldLife {
    const NAME: &'static str = "world";
}
impl InstanceKind for SensorLife {
    const NAME: &'static str = "sensor";
}
impl InstanceKind for ActuatorLife {
    const NAME: &'static str = "actuator";
}
impl InstanceKind for PartLife {
    const NAME: &'static str = "part";
}
impl InstanceKind for ServiceLife {
    const NAME: &'static str = "service";
}
impl InstanceKind for ScriptLife {
    const NAME: &'static str = "script";
}

fn name<K: InstanceKind>(function: &str) -> String {
    format!("tatu_life.{function}:{}", K::NAME)
}

unsafe extern "C" fn create<K: InstanceKind>(
    me: *mut c_void,
    info: *const tatu_instance,
    data: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; the host passes a valid description and a valid pointer for the result.
        unsafe {
            let status = MisbehaviourPlan::of(me).act(&name::<K>("create"), || Ok(77))?;
            *data =
                Box::into_raw(Box::new(InstanceData { plan: me.cast(), world: (*info).world, id: (*info).id })).cast();
            Ok(status.unwrap_or(TATU_OK))
        }
    })
}

unsafe extern "C" fn destroy<K: InstanceKind>(data: *mut c_void) {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `Box::into_raw` in `create`, and is destroyed once.
        let data = unsafe { Box::from_raw(data.cast::<InstanceData>()) };
        data.plan().act_quietly(&name::<K>("destroy"), plan::change_float_mode);
    });
}

unsafe extern "C" fn configure<K: InstanceKind>(
    data: *mut c_void,
    _: *const tatu_value,
    _: u32,
    _: u64,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe {
        Ok(InstanceData::of(data).plan().act(&name::<K>("configure"), || Ok(77))?.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn save<K: InstanceKind>(
    data: *mut c_void,
    writer: *const tatu_writer,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the writer is valid during the call.
        unsafe {
            let plan = InstanceData::of(data).plan();
            if let Some(write) = (*writer).write {
                write(writer, b"saved".as_ptr().cast(), 5);
            }
            Ok(plan.act(&name::<K>("save"), || Ok(77))?.unwrap_or(TATU_OK))
        }
    })
}

unsafe extern "C" fn load<K: InstanceKind>(
    data: *mut c_void,
    _: tatu_str,
    _: u32,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe {
        Ok(InstanceData::of(data).plan().act(&name::<K>("load"), || Ok(77))?.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn end_run<K: InstanceKind>(
    _: *mut c_void,
    data: *mut c_void,
    _: *mut tatu_world,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe {
        Ok(InstanceData::of(data).plan().act(&name::<K>("end_run"), || Ok(77))?.unwrap_or(TATU_OK))
    })
}

const fn life_table<K: InstanceKind>() -> SyncTable<tatu_life> {
    SyncTable(tatu_life {
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

pub static WORLD: SyncTable<tatu_life> = life_table::<WorldLife>();
pub static SENSOR: SyncTable<tatu_life> = life_table::<SensorLife>();
pub static ACTUATOR: SyncTable<tatu_life> = life_table::<ActuatorLife>();
pub static PART: SyncTable<tatu_life> = life_table::<PartLife>();
pub static SCRIPT: SyncTable<tatu_life> = life_table::<ScriptLife>();
pub static SERVICE: SyncTable<tatu_life> = life_table::<ServiceLife>();
