//! `tatu.host.session` and `tatu.host.stage`: requests, and stages for drivers.

use tatu_plugin_api::abi::*;

use super::{on, passed};
use crate::{
    step::{self, Stage},
    world::WorldCell,
};

pub static TABLE: tatu_host_session = tatu_host_session {
    size: size_of::<tatu_host_session>() as u32,
    reserved: 0,
    request: Some(request),
    // Sessions come with services; until then a plugin finds null here, which means "not offered".
    wake: None,
    worlds: None,
    client: None,
    state: None,
};

pub static STAGE: tatu_host_stage =
    tatu_host_stage { size: size_of::<tatu_host_stage>() as u32, reserved: 0, run: Some(run) };

unsafe extern "C" fn request(w: *mut tatu_world, what: u32) -> tatu_status {
    // SAFETY: by the contract.
    unsafe {
        on(w, |world| match what {
            TATU_REQUEST_STOP | TATU_REQUEST_QUIT => {
                world.requests.set(world.requests.get() | 1 << what);
                Ok(())
            }
            // A running world is started already.
            TATU_REQUEST_START if world.running.get() => Ok(()),
            TATU_REQUEST_PAUSE | TATU_REQUEST_START => {
                Err(world.calls.refuse(TATU_ERR_UNSUPPORTED, "this run cannot pause: nobody could lift the pause"))
            }
            _ => Err(world.calls.refuse(TATU_ERR_ARGUMENT, &format!("there is no request {what}"))),
        })
    }
}

unsafe extern "C" fn run(w: *mut tatu_world, stage: u32, dt: f64) -> tatu_status {
    // SAFETY: by the contract.
    unsafe { on(w, |world| passed(run_stage(world, stage, dt))) }
}

fn run_stage(world: &WorldCell, stage: u32, dt: f64) -> tatu_status {
    let Some(stage) = Stage::of(stage) else {
        return world.calls.refuse(TATU_ERR_ARGUMENT, &format!("there is no stage {stage}"));
    };
    if !(dt.is_finite() && dt >= 0.0) {
        return world.calls.refuse(TATU_ERR_ARGUMENT, &format!("a stage takes a finite time, not {dt} s"));
    }
    match step::run(world, stage, dt, world.caller_name()) {
        Ok(()) => TATU_OK,
        Err(text) => world.calls.refuse(TATU_ERR_BUSY, &text),
    }
}
