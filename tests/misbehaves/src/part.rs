//! A part with one field, which can be NaN. It registers the contacts of the shape that it belongs to.

use std::{
    ffi::{c_char, c_void},
    ptr::null,
};

use tatu_plugin_api::abi::*;

use crate::{
    PointerList, SyncTable, guarded,
    life::{self, InstanceData},
    sensor, size,
};

/// Runs a function of the part. Its nonsense is a field that is not a number, where it writes one, and an unknown status.
unsafe fn act(function: &str, data: *mut c_void, call: *const tatu_part_call, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the host passes a valid call with one field of one number.
        let (plan, call) = unsafe { (InstanceData::of(data).plan(), &*call) };
        let status = plan.act(function, || {
            // SAFETY: as above.
            unsafe { *(*call.fields).cast::<f64>() = f64::NAN };
            Ok(77)
        })?;
        Ok(status.unwrap_or(TATU_OK))
    })
}

macro_rules! functions {
    ($($name:ident = $text:literal),*) => {$(
        unsafe extern "C" fn $name(
            data: *mut c_void,
            call: *const tatu_part_call,
            error: *mut tatu_error,
        ) -> tatu_status {
            // SAFETY: the host passes what `act` requires.
            unsafe { act($text, data, call, error) }
        }
    )*};
}
functions!(physics_step = "tatu_part.physics_step", sense = "tatu_part.sense", end = "tatu_part.end");

unsafe extern "C" fn actuate(data: *mut c_void, call: *const tatu_part_call, error: *mut tatu_error) -> tatu_status {
    // SAFETY: the host passes what `act` requires. Its table of bodies lives as long as the host.
    unsafe {
        let host = InstanceData::of(data).plan().host;
        let bodies = (*host).service.map(|f| f(host, TATU_HOST_BODIES.as_ptr()).cast::<tatu_host_bodies>());
        let hook = bodies.and_then(|bodies| bodies.as_ref()?.hook).filter(|_| (*call).owner != 0);
        if let Some(hook) = hook {
            hook(WorldRef::new((*call).world), (*call).part, (*call).owner, 0, 1);
        }
        act("tatu_part.actuate", data, call, error)
    }
}

unsafe extern "C" fn event(
    data: *mut c_void,
    call: *const tatu_part_call,
    _: tatu_str,
    _: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host passes what `act` requires.
    unsafe { act("tatu_part.event", data, call, error) }
}

unsafe extern "C" fn contact(
    data: *mut c_void,
    call: *const tatu_part_call,
    _: *mut tatu_contact_pair,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host passes what `act` requires.
    unsafe { act("tatu_part.contact", data, call, error) }
}

/// A list of texts for use in statics.
#[repr(transparent)]
struct Texts<const N: usize>([*const c_char; N]);
// SAFETY: the list and everything it points to are constant.
unsafe impl<const N: usize> Sync for Texts<N> {}
static EVENTS: Texts<2> = Texts([c"started".as_ptr(), null()]);

unsafe extern "C" fn paused(
    data: *mut c_void,
    call: *const tatu_part_call,
    _: u32,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host passes what `act` requires.
    unsafe { act("tatu_part.paused", data, call, error) }
}

static FIELD: SyncTable<tatu_field> = SyncTable(tatu_field {
    size: size::<tatu_field>(),
    elem: TATU_ELEM_F64,
    dims: [1, 1, 1],
    flags: 0,
    name: c"misbehaves.effort".as_ptr(),
    unit: null(),
    text: c"For tests.".as_ptr(),
    valid: null(),
    nothing: null(),
});
static FIELDS: PointerList<tatu_field, 2> = PointerList([&raw const FIELD.0, null()]);

static KIND: SyncTable<tatu_part> = SyncTable(tatu_part {
    size: size::<tatu_part>(),
    flags: 0,
    id: c"misbehaves".as_ptr(),
    text: c"For tests.".as_ptr(),
    params: (&raw const sensor::PARAMS.0).cast(),
    commands: null(),
    life: &raw const life::PART.0,
    actuate: Some(actuate),
    physics_step: Some(physics_step),
    sense: Some(sense),
    paused: Some(paused),
    end: Some(end),
    schemas: null(),
    fields: (&raw const FIELDS.0).cast(),
    presets: null(),
    event: Some(event),
    events: (&raw const EVENTS.0).cast(),
    contact: Some(contact),
});
static KINDS: PointerList<tatu_part, 2> = PointerList([&raw const KIND.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_part> =
    SyncTable(tatu_ext_part { size: size::<tatu_ext_part>(), reserved: 0, kinds: (&raw const KINDS.0).cast() });
