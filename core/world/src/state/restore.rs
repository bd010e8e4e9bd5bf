//! Restores a world from a snapshot. If this is not possible, the run can be replayed from the recorded inputs instead.

use std::collections::BTreeSet;

use tatu_devices::{actuators::Actuator, sense::SensorNoise};
use tatu_errors::{Error, Result};
use tatu_plugin_api::{abi::TATU_LOG_WARNING, safe::Value};
use tatu_scene::ObjectVariant;

use super::{
    Snapshot,
    file::damaged,
    hash_of,
    image::{ActuatorImage, CoreImage, DeviceImage},
};
use crate::{
    cell::{InputRecord, InstanceImage, Scripts, Signal, WorldCell, restore_inputs},
    instances::{InstanceRef, end_actuator, end_sensor, load_instance, saved_state_block},
    scripts::ScriptImage,
    session,
};
fn refused(what: impl std::fmt::Display, why: impl std::fmt::Display) -> Error {
    Error::new("E503", format!("{what} cannot be restored: {why}"))
        .help("replay the run up to that step, in a new world with the same scene")
}

/// Checks that a snapshot belongs to the world's scene and plugins, that the world is new, and, unless `allow_partial`
/// is set, that the snapshot is complete.
pub(crate) fn check(cell: &WorldCell, snapshot: &Snapshot, allow_partial: bool) -> Result {
    snapshot.check(&cell.model.document, &cell.model.registry)?;
    if let Some(first) = snapshot.head.missed.first().filter(|_| !allow_partial) {
        let error = Error::new("E503", format!("the snapshot is not complete: {first}"));
        return Err(error.help("replay the run up to that step instead"));
    }
    if cell.running() || cell.state.clock.step.get() != 0 {
        return Err(
            Error::new("E503", "a world that has run cannot be restored from a snapshot").help("create a new world")
        );
    }
    Ok(())
}

/// Restores the snapshot in a world that has just been started silently.
pub(crate) fn restore_world(cell: &WorldCell, snapshot: &Snapshot) -> Result {
    let image: CoreImage = snapshot.get("core")?;
    let mut dropped = Vec::new();
    scripts(cell, snapshot.get("scripts")?, &image)?;
    sensors(cell, snapshot.get("sensors")?, &mut dropped)?;
    actuators(cell, snapshot.get("actuators")?, &mut dropped)?;
    core(cell, image)?;
    *cell.devices.figures.borrow_mut() = snapshot.get("figures")?;
    plugins(cell, snapshot.get("plugins")?, &mut dropped)?;
    *cell.run.connections.saved_services.borrow_mut() = snapshot.get("services")?;
    services(cell)?;
    Scripts::load(cell, snapshot.get("scripts")?, &mut dropped)?;
    restore_inputs(cell, records(snapshot)?);
    let hash = hash_of(cell);
    if hash != snapshot.head.hash {
        return Err(refused("the world", format!("its hash is {hash:016x} instead of {:016x}", snapshot.head.hash)));
    }
    for (what, why) in dropped {
        cell.log(TATU_LOG_WARNING, &format!("{what} starts over: {why}"));
    }
    Ok(())
}

/// Returns the external inputs recorded up to the snapshot.
pub(crate) fn records(snapshot: &Snapshot) -> Result<Vec<InputRecord>> {
    session::file::from_bytes(&snapshot.head.log).ok_or_else(|| damaged("the recorded inputs cannot be read"))
}

/// Ends the scripts that had ended before the snapshot. All scripts of the snapshot must exist in the world.
fn scripts(cell: &WorldCell, images: Vec<ScriptImage>, core: &CoreImage) -> Result {
    let there: Vec<u32> = images.iter().map(|i| i.slot).collect();
    let known = |slot: u32| cell.run.scripts.borrow().by_slot(slot).is_some();
    if let Some(slot) = there.iter().find(|s| !known(**s)) {
        return Err(refused(format!("the script {}", core.scene.path(*slot)), "it was created during the run"));
    }
    Scripts::end_others(cell, &there);
    Ok(())
}

/// Owners of state blocks that were dropped, each with the reason.
type DroppedStates = Vec<(String, String)>;

fn sensors(cell: &WorldCell, images: Vec<DeviceImage>, dropped: &mut DroppedStates) -> Result {
    let there: BTreeSet<(u32, u64)> = images.iter().map(|i| (i.slot, i.id)).collect();
    let gone = cell.devices.sensing.borrow_mut().remove_dead(|d| there.contains(&(d.slot, d.id)));
    for d in gone {
        end_sensor(cell, d);
    }
    for image in images {
        let path = cell.state.scene.borrow().path(image.slot);
        let what = format!("the sensor {path}");
        let index = cell
            .devices
            .sensing
            .borrow()
            .index(image.slot)
            .ok_or_else(|| refused(&what, "it was created during the run"))?;
        let (kind, data) = {
            let sensing = cell.devices.sensing.borrow();
            let d = &sensing.devices[index];
            let params: Vec<Value> = image.params.into_iter().map(Into::into).collect();
            if d.kind != image.kind as usize || d.params != params {
                return Err(refused(&what, "its parameters were changed during the run"));
            }
            if d.fields.len() != image.fields.len() {
                return Err(damaged(format!("{what} has fields of a different size")));
            }
            (d.kind, d.data)
        };
        let life = &cell.model.registry.sensors[kind].life;
        {
            let mut sensing = cell.devices.sensing.borrow_mut();
            let d = &mut sensing.devices[index];
            let (block, lost) = saved_state_block(life, &image.instance);
            // Plugins store the address of the block, so its contents are replaced, but not the block itself.
            d.state.copy_from_slice(&block);
            dropped.extend(lost.map(|why| (what.clone(), why)));
            d.fields.copy_from_slice(&image.fields);
            (d.sequence, d.time, d.drawn, d.off) = (image.sequence, image.time, image.drawn, image.off);
            // The next measurement applies the sensor settings of the scene.
            (d.schedule.period, d.noise) = (image.period, image.noise.map(|m| Box::new(SensorNoise::from_state(m))));
            sensing.invalidate_settings();
        }
        if !image.instance.missed {
            let of = InstanceRef { plugin: cell.model.registry.sensors[kind].plugin, slot: image.slot, data };
            load_instance(cell, &of, life, &image.instance).map_err(|e| refused(&what, e))?;
        }
    }
    Ok(())
}

fn actuators(cell: &WorldCell, images: Vec<ActuatorImage>, dropped: &mut DroppedStates) -> Result {
    let is_there = |d: &Actuator| images.iter().any(|i| i.object == d.object);
    let gone = cell.devices.actuators.borrow_mut().remove_dead(is_there);
    for d in gone {
        end_actuator(cell, d);
    }
    for image in images {
        let path = cell.state.scene.borrow().path(image.slot);
        let what = format!("the actuator {path}");
        let (life, of) = {
            let mut actuators = cell.devices.actuators.borrow_mut();
            let found = actuators.devices.iter_mut().find(|d| d.object == image.object);
            let d = found.ok_or_else(|| refused(&what, "it was created during the run"))?;
            let params: Vec<Value> = image.params.into_iter().map(Into::into).collect();
            if d.kind != image.kind as usize || d.params != params {
                return Err(refused(&what, "its parameters were changed during the run"));
            }
            let kind = &cell.model.registry.actuators[d.kind];
            // Plugins store the address of the block, so its contents are replaced, but not the block itself.
            let (block, lost) = saved_state_block(&kind.life, &image.instance);
            d.state.copy_from_slice(&block);
            dropped.extend(lost.map(|why| (what.clone(), why)));
            (d.off, d.idle_reported) = (image.off, image.idle_told);
            // A part's readings keep their values between calls.
            let sensing = cell.devices.sensing.borrow();
            if let (Some(report), Some(i)) = (d.report.as_mut().filter(|_| d.part.is_some()), sensing.index(d.slot)) {
                report.restore(&sensing.devices[i].fields);
            }
            drop(sensing);
            if let Some(record) = d.part.as_deref_mut() {
                (record.calls, record.hooks, record.rules) = (image.calls, image.hooks, image.rules);
            }
            (&kind.life, InstanceRef { plugin: kind.plugin, slot: d.slot, data: d.data })
        };
        if !image.instance.missed {
            load_instance(cell, &of, life, &image.instance).map_err(|e| refused(&what, e))?;
        }
    }
    Ok(())
}

fn core(cell: &WorldCell, image: CoreImage) -> Result {
    let CoreImage { mut scene, meshes, settings, dynamics, clock, phase, requests, next_instance, last_wake, .. } =
        image;
    for (slot, number) in meshes {
        let mesh = cell.model.document.meshes.get(number as usize);
        match (scene.get_mut(slot).map(|o| &mut o.data), mesh) {
            (Some(ObjectVariant::Shape(s)), Some(mesh)) => s.mesh = Some(mesh.clone()),
            _ => return Err(damaged("it refers to a mesh that the scene does not contain")),
        }
    }
    let shapes: Vec<u32> = scene.slots().filter(|(_, o)| o.shape().is_some()).map(|(slot, _)| slot).collect();
    shapes.into_iter().for_each(|slot| cell.model.document.fill_parts(&mut scene, slot));
    scene.index_names();
    cell.state.dynamics.borrow_mut().restore(&dynamics).map_err(damaged)?;
    *cell.state.scene.borrow_mut() = scene;
    cell.devices.swept_version.set(0);
    *cell.model.settings.borrow_mut() = settings;
    let (time, step, dt, pass) = clock;
    cell.state.clock.pass.set(pass);
    cell.state.phase.set(phase);
    cell.state.clock.time.set(time);
    cell.state.clock.step.set(step);
    cell.state.clock.dt.set(dt);
    cell.state.requests.set(requests);
    cell.devices.next_instance.set(next_instance);
    cell.run.calls.thread_results.restore(last_wake);
    *cell.state.signals.borrow_mut() = image
        .signals
        .into_iter()
        .map(|(kind, name, v, of_run)| ((kind, name), Signal { value: v.into(), ends_with_run: of_run }))
        .collect();
    cell.run.calls.waits.borrow_mut().restore(image.waits);
    // The start of this process is not an event of the run.
    let events = image.events.into_iter().map(|(name, payload)| (name.into(), payload.into()));
    *cell.run.connections.bus.queue.borrow_mut() = events.collect();
    *cell.run.connections.bus.touching.borrow_mut() = image.touching;
    *cell.run.reported.borrow_mut() = (0..image.faults.len()).collect();
    *cell.run.faults.borrow_mut() = image.faults.into_iter().map(Into::into).collect();
    // The run that wrote the snapshot has already reported the log lines of the start.
    cell.run.lines.lock().clear();
    // The targets of beams are rebuilt from the restored scene.
    cell.devices.sensing.borrow_mut().discard_scene();
    Ok(())
}

fn plugins(cell: &WorldCell, images: Vec<(String, InstanceImage)>, dropped: &mut DroppedStates) -> Result {
    for (id, image) in images {
        let found = cell
            .model
            .registry
            .command_offers
            .world_lives
            .iter()
            .find(|(p, _)| cell.model.registry.plugins[*p].id == id);
        let (plugin, life) = found.ok_or_else(|| damaged(format!("plugin `{id}` stores no state")))?;
        if let Some(Some(instance)) = cell.devices.instances.borrow_mut().get_mut(*plugin) {
            let (block, lost) = saved_state_block(life, &image);
            instance.state.copy_from_slice(&block);
            dropped.extend(lost.map(|why| (format!("the state of the commands of `{id}`"), why)));
        }
        let of = InstanceRef { plugin: *plugin, slot: 0, data: cell.instance(*plugin).0 };
        load_instance(cell, &of, life, &image).map_err(|e| refused(format!("plugin `{id}`"), e))?;
    }
    Ok(())
}

/// Restores the states of services. The states of services that are not running are discarded. A world that is not in a
/// session retains the states until it joins one.
pub(crate) fn services(cell: &WorldCell) -> Result {
    let Some(session) = cell.run.connections.session() else { return Ok(()) };
    for (id, image) in std::mem::take(&mut *cell.run.connections.saved_services.borrow_mut()) {
        let mut running = (0..).map_while(|i| session.nth(i));
        let Some(service) = running.find(|s| cell.model.registry.services[s.kind].id == id && !s.off.get()) else {
            continue;
        };
        let kind = &cell.model.registry.services[service.kind];
        let (block, lost) = saved_state_block(&kind.life, &image);
        if let Some(why) = lost {
            cell.log(TATU_LOG_WARNING, &format!("the service `{id}` starts over: {why}"));
        }
        let mut state = service.state.borrow_mut();
        if state.len() == block.len() {
            state.copy_from_slice(&block);
        }
        drop(state);
        let of = InstanceRef { plugin: kind.plugin, slot: 0, data: service.data };
        let load = || load_instance(cell, &of, &kind.life, &image);
        service.call_with_subject(cell, load).map_err(|e| refused(format!("the service `{id}`"), e))?;
    }
    Ok(())
}
