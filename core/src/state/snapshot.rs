//! Out of a world.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;

use super::{
    Head, Missed, Snapshot, file, fingerprint,
    image::{CoreImage, DeviceImage, InstanceImage},
};
use crate::{
    calls::ErrorSlot,
    error::{Error, Result},
    scene::Scene,
    scripts::Scripts,
    world::{World, WorldCell},
};

unsafe extern "C" fn write(writer: *const tatu_writer, bytes: *const c_void, n: u64) {
    // SAFETY: a writer of `save_instance`, whose vector lives through the call.
    let out = unsafe { &mut *(*writer).ctx.cast::<Vec<u8>>() };
    if !bytes.is_null() {
        // SAFETY: by the contract.
        out.extend_from_slice(unsafe { std::slice::from_raw_parts(bytes.cast(), n as usize) });
    }
}

/// What an instance writes of itself; or why it cannot. Must be called without any borrow of the world.
pub(crate) fn save_instance(life: &tatu_life, data: *mut c_void, state: &[u64]) -> Result<InstanceImage, String> {
    let mut image = InstanceImage { state: state.to_vec(), saved: Vec::new(), version: life.version, missed: false };
    let Some(save) = life.save else {
        // Without data of its own there is nothing but the state block.
        let why = "its plugin keeps data for it, and offers no way to write them";
        return if data.is_null() { Ok(image) } else { Err(why.to_owned()) };
    };
    let writer = tatu_writer {
        size: size_of::<tatu_writer>() as u32,
        reserved: 0,
        ctx: (&raw mut image.saved).cast(),
        write: Some(write),
    };
    let mut error = ErrorSlot::new();
    // SAFETY: by the contract; the writer lives through the call.
    let status = unsafe { save(data, &writer, error.raw()) };
    if status < 0 { Err(error.text()) } else { Ok(image) }
}

impl World {
    /// Everything that decides the future, at the boundary between two steps; what could not be captured is named in
    /// the head. The run that goes on does not notice.
    pub fn snapshot(&self) -> Result<Snapshot> {
        let cell = self.cell();
        if !cell.running.get() {
            return Err(Error::new("E503", "a world that does not run has no state to write").help("start it first"));
        }
        let mut snapshot = Snapshot::new(Head {
            tatu: env!("CARGO_PKG_VERSION").to_owned(),
            document: fingerprint(&cell.document),
            plugins: file::plugins(&cell.registry),
            step: self.steps(),
            time: self.time(),
            hash: self.hash().total,
            missed: Vec::new(),
            log: Vec::new(),
        });
        let mut missed = Vec::new();
        snapshot.put("core", &core(cell)?)?;
        snapshot.put("sensors", &sensors(cell, &mut missed))?;
        snapshot.put("plugins", &plugins(cell, &mut missed))?;
        snapshot.put("scripts", &Scripts::images(cell, &mut missed))?;
        snapshot.head.missed = missed;
        Ok(snapshot)
    }
}

/// The meshes that shapes use, by their number in the document.
fn meshes(cell: &WorldCell, scene: &Scene) -> Result<Vec<(u32, u32)>> {
    let mut out = Vec::new();
    for (slot, o) in scene.slots() {
        let Some(mesh) = o.shape().and_then(|s| s.mesh.as_ref()) else { continue };
        let number =
            cell.document.meshes.iter().position(|m| std::sync::Arc::ptr_eq(m, mesh)).ok_or_else(|| {
                Error::new("E503", format!("the mesh of {} is not one of the scene's", scene.path(slot)))
            })?;
        out.push((slot, number as u32));
    }
    Ok(out)
}

fn core(cell: &WorldCell) -> Result<CoreImage> {
    let scene = cell.scene.borrow();
    Ok(CoreImage {
        meshes: meshes(cell, &scene)?,
        scene: scene.clone(),
        settings: cell.settings.borrow().clone(),
        dynamics: cell.dynamics.borrow().snapshot(),
        clock: (cell.clock.time.get(), cell.clock.step.get(), cell.clock.dt.get()),
        requests: cell.requests.get(),
        next_instance: cell.next_instance.get(),
        before: cell.before.borrow().iter().map(|(slot, pose)| (*slot, *pose)).collect(),
        signals: cell.signals.borrow().iter().map(|((kind, name), v)| (*kind, name.clone(), v.into())).collect(),
        waits: cell.calls.waits.borrow().all(),
        faults: cell.faults.borrow().iter().map(Into::into).collect(),
    })
}

fn sensors(cell: &WorldCell, missed: &mut Vec<Missed>) -> Vec<DeviceImage> {
    let n = cell.sensing.borrow().devices.len();
    let mut out = Vec::with_capacity(n);
    for i in 0..n {
        let (kind, slot, data, state) = {
            let sensing = cell.sensing.borrow();
            let d = &sensing.devices[i];
            (d.kind, d.slot, d.data, d.state.clone())
        };
        let entry = &cell.registry.sensors[kind];
        let instance = save_instance(&entry.life, data, &state).unwrap_or_else(|reason| {
            let plugin = cell.registry.plugins[entry.plugin].id.clone();
            missed.push(Missed { object: cell.scene.borrow().path(slot), plugin, reason });
            InstanceImage { state, version: entry.life.version, missed: true, ..Default::default() }
        });
        let sensing = cell.sensing.borrow();
        let d = &sensing.devices[i];
        out.push(DeviceImage {
            slot,
            kind: kind as u32,
            id: d.id,
            params: d.params.iter().map(Into::into).collect(),
            instance,
            fields: d.fields.clone(),
            sequence: d.sequence,
            time: d.time,
            off: d.off,
        });
    }
    out
}

/// What command plugins keep for the world, by plugin.
fn plugins(cell: &WorldCell, missed: &mut Vec<Missed>) -> Vec<(String, InstanceImage)> {
    let mut out = Vec::new();
    for (plugin, life) in &cell.registry.world_lives {
        let id = cell.registry.plugins[*plugin].id.clone();
        let state = cell.instances.borrow()[*plugin].as_ref().map(|i| i.state.clone()).unwrap_or_default();
        match save_instance(life, cell.instance(*plugin), &state) {
            Ok(image) => out.push((id, image)),
            Err(reason) => missed.push(Missed { object: String::new(), plugin: id, reason }),
        }
    }
    out
}
