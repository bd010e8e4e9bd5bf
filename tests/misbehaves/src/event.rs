//! A function that receives events.

use std::{
    ffi::{c_char, c_void},
    ptr::null,
};

use tatu_plugin_api::abi::*;

use crate::{SyncTable, guarded, plan::MisbehaviourPlan, size};

unsafe extern "C" fn heard(
    me: *mut c_void,
    _: *mut c_void,
    _: *mut c_void,
    _: *mut tatu_world,
    _: tatu_str,
    _: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init` and is live.
        let plan = unsafe { MisbehaviourPlan::of(me) };
        Ok(plan.act("tatu_ext_event.heard", || Ok(77))?.unwrap_or(TATU_OK))
    })
}

/// A list of texts for use in statics.
#[repr(transparent)]
struct Texts<const N: usize>([*const c_char; N]);
// SAFETY: the list and everything it points to are constant.
unsafe impl<const N: usize> Sync for Texts<N> {}
static LISTENS: Texts<2> = Texts([c"started".as_ptr(), null()]);

pub static EXTENSION: SyncTable<tatu_ext_event> = SyncTable(tatu_ext_event {
    size: size::<tatu_ext_event>(),
    reserved: 0,
    events: null(),
    heard: Some(heard),
    listens: (&raw const LISTENS.0).cast(),
});
