//! Saves and loads the state of plugin instances.

use std::ffi::c_void;

use serde::{Deserialize, Serialize};
use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::abi::*;
use tatu_plugins::{
    border::{ErrorSlot, raw},
    watchdog::PluginCall,
};

use super::InstanceRef;
use crate::cell::{InstanceImage, WorldCell};

/// An instance whose state could not be saved.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnsavedInstance {
    /// Description of its owner, such as "the script of /Robot"; empty for the world.
    pub object: String,
    /// Id of its plugin.
    pub plugin: String,
    /// The reason why the state could not be saved.
    pub reason: String,
}

impl std::fmt::Display for UnsavedInstance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.object.as_str() {
            "" => write!(f, "plugin `{}`: {}", self.plugin, self.reason),
            object => write!(f, "{object}: {}", self.reason),
        }
    }
}

unsafe extern "C" fn write(writer: *const tatu_writer, bytes: *const c_void, n: u64) {
    // SAFETY: the contract requires `writer` to point to the table that `save_instance` made; its vector lives until
    // the plugin's call has returned, and nothing else uses it meanwhile.
    let out = unsafe { &mut *(*writer).ctx.cast::<Vec<u8>>() };
    if !bytes.is_null() {
        // SAFETY: the contract requires `bytes` to point to `n` bytes that are valid during this call; they are copied.
        out.extend_from_slice(unsafe { std::slice::from_raw_parts(bytes.cast(), n as usize) });
    }
}

/// Saves the state of an instance, or returns the reason why that is not possible. The reason is reported as a fault
/// only if the plugin panicked or broke the contract. No part of the world may be borrowed.
pub(crate) fn save_instance(
    world: &WorldCell,
    of: &InstanceRef,
    life: &tatu_life,
    state: &[u64],
) -> Result<InstanceImage, String> {
    let mut image = InstanceImage { state: state.to_vec(), saved: Vec::new(), version: life.version, missed: false };
    let Some(save) = life.save else {
        // If an instance has no data, its state block is its whole state.
        let why = "the plugin stores data of this instance, but does not support saving it";
        return if of.data.is_null() { Ok(image) } else { Err(why.to_owned()) };
    };
    let writer = tatu_writer {
        size: size_of::<tatu_writer>() as u32,
        reserved: 0,
        ctx: (&raw mut image.saved).cast(),
        write: Some(write),
    };
    let mut error = ErrorSlot::new();
    // SAFETY: `of.data` points to a live instance of the plugin, which is never unloaded; the writer and its vector
    // live until the call has returned.
    let status =
        world.call_plugin(of.plugin, PluginCall::Save, of.slot, || unsafe { save(of.data, &writer, error.raw()) });
    if error.check_status(status, false) == TATU_OK {
        if let Some(inspector) = &world.model.registry.inspector {
            inspector.after_save(of.plugin, &image.saved);
        }
        return Ok(image);
    }
    if status == TATU_ERR_PANIC || !(TATU_ERR_MEMORY..0).contains(&status) {
        let plugin = &world.model.registry.plugins[of.plugin].id;
        let text = format!("plugin `{plugin}` {} [{}]", error.text(), PluginCall::Save.text());
        let mut fault = Fault::new(FaultKind::Plugin, text);
        fault.plugin = Some(plugin.clone());
        fault.object = world.monitor.watch.name_of(of.slot);
        world.report(fault);
    }
    Err(error.text())
}

/// Restores the saved state of an instance. No part of the world may be borrowed.
pub(crate) fn load_instance(
    world: &WorldCell,
    of: &InstanceRef,
    life: &tatu_life,
    image: &InstanceImage,
) -> Result<(), String> {
    let Some(load) = life.load else {
        return if image.saved.is_empty() {
            Ok(())
        } else {
            Err("the plugin no longer supports restoring a saved state".to_owned())
        };
    };
    let (mut saved, mut version) = (std::borrow::Cow::Borrowed(&image.saved), image.version);
    if let Some(inspector) = &world.model.registry.inspector {
        inspector.before_load(of.plugin, saved.to_mut(), &mut version);
    }
    let mut error = ErrorSlot::new();
    // SAFETY: `of.data` points to a live instance of the plugin, which is never unloaded; the bytes and the error
    // object live until the call has returned.
    let run = |error| unsafe { load(of.data, raw(&saved), version, error) };
    if world.call_plugin_checked((of.plugin, PluginCall::Restore, of.slot), &mut error, run) < 0 {
        let plugin = &world.model.registry.plugins[of.plugin].id;
        return Err(format!("{} [{} of `{plugin}`]", error.text(), PluginCall::Restore.text()));
    }
    Ok(())
}

/// Returns the state block of an image if its version and size match those of `life`, otherwise zeros. In the latter
/// case, also returns the reason if state is lost: `load` cannot restore it, because `save` wrote nothing else.
pub(crate) fn saved_state_block(life: &tatu_life, image: &InstanceImage) -> (Vec<u64>, Option<String>) {
    let words = (life.state_bytes as usize).div_ceil(8);
    if image.version == life.version && image.state.len() == words {
        return (image.state.clone(), None);
    }
    let lost = !image.state.is_empty() && image.saved.is_empty();
    let why = || match image.version == life.version {
        true => format!("its saved state has {} bytes, but the plugin declares {}", 8 * image.state.len(), 8 * words),
        false => format!("its saved state has version {}, but the plugin declares {}", image.version, life.version),
    };
    (vec![0; words], lost.then(why))
}
