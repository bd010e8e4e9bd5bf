//! Takes a snapshot of a world.

use std::sync::Arc;

use tatu_errors::{Error, Result};
use tatu_geometry::{Image, Mesh};
use tatu_scene::{Scene, Shape};

use super::{
    Snapshot, SnapshotHeader, file, fingerprint, hash_of,
    image::{ActuatorImage, CoreImage, DeviceImage},
};
use crate::{
    cell::{InstanceImage, Scripts, WaitCondition, WaitOwner, WorldCell},
    instances::{InstanceRef, UnsavedInstance, save_instance},
    session,
};

/// Captures all state that determines the future of the run, between two steps. The header lists the instances that
/// could not be saved. The run is not affected.
pub(crate) fn take_snapshot(cell: &WorldCell) -> Result<Snapshot> {
    if !cell.running() {
        return Err(Error::new("E503", "a snapshot can be taken only of a running world").help("start the world first"));
    }
    let mut snapshot = Snapshot::new(SnapshotHeader {
        tatu: env!("CARGO_PKG_VERSION").to_owned(),
        document: fingerprint(&cell.model.document),
        plugins: file::plugins(&cell.model.registry),
        step: cell.state.clock.step.get(),
        time: cell.state.clock.time.get(),
        hash: hash_of(cell),
        missed: Vec::new(),
        log: session::file::to_bytes(cell.run.connections.record.log.borrow().records()),
    });
    let mut missed = unsaved_waits(cell);
    snapshot.put("core", &core(cell)?)?;
    snapshot.put("figures", &*cell.devices.figures.borrow())?;
    snapshot.put("sensors", &sensors(cell, &mut missed))?;
    snapshot.put("actuators", &actuators(cell, &mut missed))?;
    snapshot.put("plugins", &plugins(cell, &mut missed))?;
    snapshot.put("services", &services(cell, &mut missed))?;
    snapshot.put("scripts", &Scripts::images(cell, &mut missed))?;
    if cell.run.connections.bus.has_listeners() {
        missed.push(UnsavedInstance {
            object: "the events".into(),
            plugin: String::new(),
            reason: "functions that scripts registered for events cannot be saved".into(),
        });
    }
    snapshot.head.missed = missed;
    Ok(snapshot)
}

/// Returns, for each shape with a mesh, its slot and the index of the mesh in the document. Fails if a mesh or an image
/// does not belong to the document.
fn meshes(cell: &WorldCell, scene: &Scene) -> Result<Vec<(u32, u32)>> {
    let mut out = Vec::new();
    for (slot, o) in scene.slots() {
        let own = |m: &Arc<Mesh>, n: u32| {
            cell.model.document.meshes.get((n as usize).wrapping_sub(1)).is_some_and(|known| Arc::ptr_eq(known, m))
        };
        let foreign = |s: &Shape| s.parts.iter().any(|p| p.mesh.as_ref().is_some_and(|m| !own(m, p.mesh_number)));
        let lost = |s: &Shape| s.textures().any(|t| t.image.as_ref().is_some_and(|i| !owns(cell, i, t.image_number)));
        if o.shape().is_some_and(lost) {
            return Err(Error::new("E503", format!("an image on {} does not belong to the scene", scene.path(slot))));
        }
        if o.shape().is_some_and(foreign) {
            return Err(Error::new("E503", format!("the meshes of {} do not belong to the scene", scene.path(slot))));
        }
        let Some(mesh) = o.shape().and_then(|s| s.mesh.as_ref()) else { continue };
        let number = cell.model.document.meshes.iter().position(|m| Arc::ptr_eq(m, mesh)).ok_or_else(|| {
            Error::new("E503", format!("the mesh of {} does not belong to the scene", scene.path(slot)))
        })?;
        out.push((slot, number as u32));
    }
    Ok(out)
}

/// Returns whether an image is the document's image with this number, counted from 1.
fn owns(cell: &WorldCell, image: &Arc<Image>, number: u32) -> bool {
    let known = cell.model.document.images.get((number as usize).wrapping_sub(1));
    known.is_some_and(|known| Arc::ptr_eq(known, image))
}

fn core(cell: &WorldCell) -> Result<CoreImage> {
    let scene = cell.state.scene.borrow();
    Ok(CoreImage {
        meshes: meshes(cell, &scene)?,
        scene: scene.clone(),
        settings: cell.model.settings.borrow().clone(),
        dynamics: cell.state.dynamics.borrow().snapshot().map_err(|text| Error::new("E501", text))?,
        phase: cell.state.phase.get(),
        clock: (
            cell.state.clock.time.get(),
            cell.state.clock.step.get(),
            cell.state.clock.dt.get(),
            cell.state.clock.pass.get(),
        ),
        requests: cell.state.requests.get(),
        next_instance: cell.devices.next_instance.get(),
        last_wake: cell.run.calls.thread_results.last(),
        signals: {
            let signals = cell.state.signals.borrow();
            signals.iter().map(|((kind, name), s)| (*kind, name.clone(), (&s.value).into(), s.ends_with_run)).collect()
        },
        waits: cell.run.calls.waits.borrow().all(),
        faults: cell.run.faults.borrow().iter().map(Into::into).collect(),
        events: {
            let queue = cell.run.connections.bus.queue.borrow();
            queue.iter().map(|(name, payload)| (name.to_string(), payload.into())).collect()
        },
        touching: cell.run.connections.bus.touching.borrow().clone(),
    })
}

fn sensors(cell: &WorldCell, missed: &mut Vec<UnsavedInstance>) -> Vec<DeviceImage> {
    let n = cell.devices.sensing.borrow().devices.len();
    let mut out = Vec::with_capacity(n);
    for i in 0..n {
        let (kind, slot, data, state) = {
            let sensing = cell.devices.sensing.borrow();
            let d = &sensing.devices[i];
            (d.kind, d.slot, d.data, d.state.to_vec())
        };
        let entry = &cell.model.registry.sensors[kind];
        let of = InstanceRef { plugin: entry.plugin, slot, data };
        let instance = save_instance(cell, &of, &entry.life, &state).unwrap_or_else(|reason| {
            let plugin = cell.model.registry.plugins[entry.plugin].id.clone();
            missed.push(UnsavedInstance { object: cell.state.scene.borrow().path(slot), plugin, reason });
            InstanceImage { state, version: entry.life.version, missed: true, ..Default::default() }
        });
        let sensing = cell.devices.sensing.borrow();
        let d = &sensing.devices[i];
        out.push(DeviceImage {
            slot,
            kind: kind as u32,
            id: d.id,
            params: d.params.iter().map(Into::into).collect(),
            instance,
            fields: d.fields.to_vec(),
            sequence: d.sequence,
            time: d.time,
            drawn: d.drawn,
            period: d.schedule.period,
            noise: d.noise.as_ref().map(|n| n.state().clone()),
            off: d.off,
        });
    }
    out
}

fn actuators(cell: &WorldCell, missed: &mut Vec<UnsavedInstance>) -> Vec<ActuatorImage> {
    let n = cell.devices.actuators.borrow().devices.len();
    let mut out = Vec::with_capacity(n);
    for i in 0..n {
        let (mut image, state, data) = {
            let actuators = cell.devices.actuators.borrow();
            let d = &actuators.devices[i];
            let image = ActuatorImage {
                slot: d.slot,
                kind: d.kind as u32,
                object: d.object,
                params: d.params.iter().map(Into::into).collect(),
                instance: InstanceImage::default(),
                off: d.off,
                idle_told: d.idle_reported,
                calls: d.part.as_deref().map_or(0, |p| p.calls),
                hooks: d.part.as_deref().map_or_else(Default::default, |p| p.hooks.clone()),
                rules: d.part.as_deref().map_or_else(Default::default, |p| p.rules.clone()),
            };
            (image, d.state.to_vec(), d.data)
        };
        let entry = &cell.model.registry.actuators[image.kind as usize];
        let of = InstanceRef { plugin: entry.plugin, slot: image.slot, data };
        image.instance = save_instance(cell, &of, &entry.life, &state).unwrap_or_else(|reason| {
            let plugin = cell.model.registry.plugins[entry.plugin].id.clone();
            missed.push(UnsavedInstance { object: cell.state.scene.borrow().path(image.slot), plugin, reason });
            InstanceImage { state, version: entry.life.version, missed: true, ..Default::default() }
        });
        out.push(image);
    }
    out
}

/// Returns the commands that wait on behalf of a service's client or for a thread of a plugin. They cannot be saved,
/// because the client and the thread do not exist in another process.
fn unsaved_waits(cell: &WorldCell) -> Vec<UnsavedInstance> {
    let waits = cell.run.calls.waits.borrow().all();
    let waits = waits
        .into_iter()
        .filter(|w| matches!(w.owner, WaitOwner::Service(_)) || matches!(w.due, WaitCondition::Wake(_)));
    let command = |n: u32| cell.model.registry.command_offers.commands.get((n as usize).wrapping_sub(1));
    waits
        .map(|w| UnsavedInstance {
            object: String::new(),
            plugin: command(w.command).map_or(String::new(), |c| cell.model.registry.plugins[c.plugin].id.clone()),
            reason: match w.due {
                WaitCondition::Wake(_) => "one of its commands waits for a thread".into(),
                _ => "one of its commands waits for a client of a service".into(),
            },
        })
        .collect()
}

/// Saves the instances of command plugins, by the id of the plugin.
fn plugins(cell: &WorldCell, missed: &mut Vec<UnsavedInstance>) -> Vec<(String, InstanceImage)> {
    let mut out = Vec::new();
    for (plugin, life) in &cell.model.registry.command_offers.world_lives {
        let id = cell.model.registry.plugins[*plugin].id.clone();
        let state = cell.devices.instances.borrow()[*plugin].as_ref().map(|i| i.state.to_vec()).unwrap_or_default();
        let of = InstanceRef { plugin: *plugin, slot: 0, data: cell.instance(*plugin).0 };
        match save_instance(cell, &of, life, &state) {
            Ok(image) => out.push((id, image)),
            Err(reason) => missed.push(UnsavedInstance { object: String::new(), plugin: id, reason }),
        }
    }
    out
}

/// Saves the states of services, by the id of the service. Services without state, or that have been switched off, are
/// omitted.
fn services(cell: &WorldCell, missed: &mut Vec<UnsavedInstance>) -> Vec<(String, InstanceImage)> {
    let Some(session) = cell.run.connections.session() else { return Vec::new() };
    let (mut out, mut i) = (Vec::new(), 0);
    while let Some(service) = session.nth(i) {
        i += 1;
        let kind = &cell.model.registry.services[service.kind];
        let state = service.state.borrow().to_vec();
        if service.off.get() || kind.life.save.is_none() && state.is_empty() {
            continue;
        }
        let of = InstanceRef { plugin: kind.plugin, slot: 0, data: service.data };
        match service.call_with_subject(cell, || save_instance(cell, &of, &kind.life, &state)) {
            Ok(image) if image.saved.is_empty() && image.state.is_empty() => {}
            Ok(image) => out.push((kind.id.clone(), image)),
            Err(reason) => {
                let plugin = cell.model.registry.plugins[kind.plugin].id.clone();
                missed.push(UnsavedInstance { object: format!("the service `{}`", kind.id), plugin, reason });
            }
        }
    }
    out
}
