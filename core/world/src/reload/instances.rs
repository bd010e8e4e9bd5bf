//! Replaces the instances of a plugin with those of a different version of it.

use std::{rc::Rc, sync::Arc};

use tatu_devices::{actuators::Actuator, sense::SensorDevice};
use tatu_errors::{Error, Result};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{ParameterSpec, Registry};

use super::ReloadReport;
use crate::{
    cell::{CommandInstance, Script, Scripts, WorldCell},
    instances::{
        InstanceRef, create_actuator, create_sensor, end_actuator, end_sensor, load_instance, params_with_defaults,
        save_instance, saved_state_block,
    },
    run::World,
    scripts::{SaveResult, StateTransfer},
};
/// A device that is being replaced: its object, the state that the old instance saved, and the parameters of the new
/// instance.
struct DeviceReplacement {
    slot: u32,
    kind: usize,
    id: u64,
    params: Vec<Value>,
    /// Keys of parameters that no longer exist.
    dropped: Vec<String>,
    image: SaveResult,
}

/// Instances that are put into use or destroyed together: those that the new version has created, or those that they
/// replace.
#[derive(Default)]
struct InstanceSet {
    sensors: Vec<SensorDevice>,
    actuators: Vec<Actuator>,
    instance: Option<CommandInstance>,
    scripts: Vec<Rc<Script>>,
}

impl InstanceSet {
    fn end_all(self, cell: &WorldCell, plugin: usize) {
        self.scripts.into_iter().for_each(|s| s.end_replaced(cell));
        self.sensors.into_iter().for_each(|d| end_sensor(cell, d));
        self.actuators.into_iter().for_each(|d| end_actuator(cell, d));
        if let Some(i) = self.instance {
            i.end(cell, plugin);
        }
    }
}

/// Passes the saved state of the old instance to a new one, and its state block to `block`. On failure, returns the
/// reason why the new instance starts from scratch.
fn transfer_state(
    cell: &WorldCell,
    of: &InstanceRef,
    life: &tatu_life,
    image: &SaveResult,
    block: &mut dyn FnMut(&[u64]),
) -> Result<(), String> {
    let image = image.as_ref().map_err(Clone::clone)?;
    let (state, dropped) = saved_state_block(life, image);
    block(&state);
    load_instance(cell, of, life, image)?;
    dropped.map_or(Ok(()), Err)
}

fn params_by_key(declared: &[ParameterSpec], params: &[Value]) -> Vec<(String, Value)> {
    declared.iter().map(|d| d.key.clone()).zip(params.iter().cloned()).collect()
}

/// Returns the values of the parameters that the new version declares, and the keys of parameters that no longer exist.
fn carry_over_params(old: &[ParameterSpec], new: &[ParameterSpec], params: &[Value]) -> (Vec<Value>, Vec<String>) {
    let given: Vec<_> = params_by_key(old, params).into_iter().filter(|(_, v)| *v != Value::Nil).collect();
    let lost = old.iter().filter(|o| !new.iter().any(|n| n.key == o.key)).map(|o| o.key.clone()).collect();
    (params_with_defaults(new, &given), lost)
}

fn path_of(cell: &WorldCell, slot: u32) -> String {
    cell.state.scene.borrow().path(slot)
}

/// Returns the description passed to the replacement of an instance.
fn replacement_info(cell: &WorldCell, slot: u32, id: u64) -> tatu_instance {
    let (owner, name) = {
        let scene = cell.state.scene.borrow();
        (scene.id(slot), scene.get(slot).map_or(String::new(), |o| o.name()))
    };
    cell.instance_info_with_id(owner, &name, id)
}

impl World {
    /// Reloads the file of a plugin between two steps. All its instances are replaced with instances of the new
    /// version, which take over the old state if the new version can restore it. If the new version is rejected,
    /// returns an error and changes nothing.
    ///
    /// A plugin with a running service cannot be reloaded, because the service refers to addresses within the plugin.
    pub fn reload_plugin(&self, plugin: usize) -> Result<ReloadReport> {
        let cell: &WorldCell = self.cell();
        let old = cell.model.registry.shared();
        let file = old.plugins[plugin].path.display().to_string();
        if let Some(id) = cell.run.connections.session().and_then(|s| s.service_id_of(plugin)) {
            let text = format!("the plugin {file} cannot be replaced while its service `{id}` runs");
            return Err(Error::new("E305", text).help("restart the run to use the new version"));
        }
        let new = Arc::new(old.with_reloaded_plugin(plugin)?);
        let mut told = ReloadReport::default();
        told.warnings.extend(new.load_report.refused.iter().cloned());
        told.notes.extend(new.load_report.notes.iter().cloned());
        let name = &new.plugins[plugin];
        let version = format!("{} {}", name.id, name.version);
        let resets = replace_instances(cell, plugin, &old, &new).map_err(|mut e| {
            e.text = format!("the new version of {file} is refused: {}", e.text);
            e
        })?;
        cell.restore_process_state("the exchange of a plugin");
        told.applied = 1;
        told.notes.push(format!("reloaded the plugin {version} from {file}"));
        let lost = |text| Error::new("E305", text).help("restart the run for a state of the new version alone");
        told.warnings.extend(resets.into_iter().map(lost));
        Ok(told)
    }

    /// Recreates the instance of a sensor or actuator with different parameters, and passes the old state to the new
    /// instance. If the state could not be passed on, returns the reason.
    pub(super) fn recreate_device(&self, slot: u32, params: Vec<Value>) -> Result<Option<String>, String> {
        let cell: &WorldCell = self.cell();
        let object = cell.state.scene.borrow().id(slot);
        let sensor = cell.devices.sensing.borrow().index(slot);
        if let Some(i) = sensor {
            let mut moving = save_sensor(cell, i);
            moving.params = params;
            let made =
                create_sensor(cell, moving.kind, slot, replacement_info(cell, slot, moving.id), moving.params.clone())?;
            let (gone, why) = install_sensor(cell, made, &moving, false);
            gone.into_iter().for_each(|d| end_sensor(cell, d));
            return Ok(why);
        }
        let actuator = cell.devices.actuators.borrow().index(object);
        let Some(i) = actuator else { return Err("it has no instance".into()) };
        let mut moving = save_actuator(cell, i);
        moving.params = params;
        let made =
            create_actuator(cell, moving.kind, slot, replacement_info(cell, slot, moving.id), moving.params.clone())?;
        let (gone, why) = install_actuator(cell, made, &moving);
        gone.into_iter().for_each(|d| end_actuator(cell, d));
        Ok(why)
    }
}

/// Replaces all instances of a plugin. Returns a sentence for each new instance that starts from scratch.
fn replace_instances(cell: &WorldCell, plugin: usize, old: &Arc<Registry>, new: &Arc<Registry>) -> Result<Vec<String>> {
    let (sensors, actuators, instance) = save_instances(cell, plugin, old, new);
    let scripts = Scripts::save_of_plugin(cell, plugin);
    cell.model.registry.set(new.clone());
    let made = match create_instances(cell, plugin, &sensors, &actuators, &scripts) {
        Ok(made) => made,
        Err(failed) => {
            let (e, made) = *failed;
            made.end_all(cell, plugin);
            cell.model.registry.set(old.clone());
            return Err(e);
        }
    };
    let mut resets = Vec::new();
    let mut reset = |what: String, why: Option<String>| {
        resets.extend(why.map(|why| format!("{what} starts over: {why}")));
    };
    let instance_gone = cell.devices.instances.borrow_mut().get_mut(plugin).and_then(Option::take);
    let mut gone = InstanceSet { instance: instance_gone, ..InstanceSet::default() };
    if let Some(i) = made.instance {
        let data = i.data;
        cell.devices.instances.borrow_mut()[plugin] = Some(i);
        if let (Some((_, life)), Some(image)) =
            (new.command_offers.world_lives.iter().find(|(p, _)| *p == plugin), &instance)
        {
            let mut block = |state: &[u64]| {
                if let Some(Some(i)) = cell.devices.instances.borrow_mut().get_mut(plugin) {
                    i.state.copy_from_slice(state);
                }
            };
            let done = transfer_state(cell, &InstanceRef { plugin, slot: 0, data }, life, image, &mut block);
            if done.is_err() && image.is_ok() {
                // The failed load may have changed a part of its state.
                let fresh = CommandInstance::create(cell, plugin, life, cell.devices.next_replacement_id()).ok();
                let half = fresh.and_then(|f| cell.devices.instances.borrow_mut()[plugin].replace(f));
                half.into_iter().for_each(|i| i.end(cell, plugin));
            }
            reset("the state of its commands".into(), done.err());
        }
    }
    for (device, moving) in made.sensors.into_iter().zip(&sensors) {
        let fields = |r: &Registry| format!("{:?}", r.sensors[moving.kind].fields);
        let (was, why) = install_sensor(cell, device, moving, fields(old) == fields(new));
        gone.sensors.extend(was);
        reset(format!("the sensor {}", path_of(cell, moving.slot)), why);
    }
    for (device, moving) in made.actuators.into_iter().zip(&actuators) {
        carry_over_commands(cell, moving, old, new);
        let (was, why) = install_actuator(cell, device, moving);
        gone.actuators.extend(was);
        reset(format!("the actuator {}", path_of(cell, moving.slot)), why);
    }
    for (script, (was, image)) in made.scripts.iter().zip(scripts) {
        let handed = Scripts::replace(cell, &was, script, image);
        let why = if let StateTransfer::Reset(why) = handed { Some(why) } else { None };
        reset(format!("the script of {}", script.owner(cell)), why);
        gone.scripts.push(was);
    }
    for m in sensors.iter().chain(&actuators).filter(|m| !m.dropped.is_empty()) {
        let keys = m.dropped.join("`, `");
        resets.push(format!("{} no longer has the parameter `{keys}`", path_of(cell, m.slot)));
    }
    // Instances must be destroyed by the version that created them.
    cell.model.registry.set(old.clone());
    gone.end_all(cell, plugin);
    cell.model.registry.set(new.clone());
    Ok(resets)
}

fn save_sensor(cell: &WorldCell, i: usize) -> DeviceReplacement {
    let (slot, kind, id, data, state, params) = {
        let sensing = cell.devices.sensing.borrow();
        let d = &sensing.devices[i];
        (d.slot, d.kind, d.id, d.data, d.state.to_vec(), d.params.clone())
    };
    let entry = &cell.model.registry.sensors[kind];
    let image = save_instance(cell, &InstanceRef { plugin: entry.plugin, slot, data }, &entry.life, &state);
    DeviceReplacement { slot, kind, id, params, dropped: Vec::new(), image }
}

fn save_actuator(cell: &WorldCell, i: usize) -> DeviceReplacement {
    let (slot, kind, data, state, params) = {
        let actuators = cell.devices.actuators.borrow();
        let d = &actuators.devices[i];
        (d.slot, d.kind, d.data, d.state.to_vec(), d.params.clone())
    };
    let entry = &cell.model.registry.actuators[kind];
    let image = save_instance(cell, &InstanceRef { plugin: entry.plugin, slot, data }, &entry.life, &state);
    DeviceReplacement { slot, kind, id: cell.devices.next_replacement_id(), params, dropped: Vec::new(), image }
}

/// Saves the states of the old version's instances: sensors, actuators, and the instance of command plugins.
fn save_instances(
    cell: &WorldCell,
    plugin: usize,
    old: &Registry,
    new: &Registry,
) -> (Vec<DeviceReplacement>, Vec<DeviceReplacement>, Option<SaveResult>) {
    let sensors: Vec<usize> = {
        let sensing = cell.devices.sensing.borrow();
        (0..sensing.devices.len()).filter(|i| old.sensors[sensing.devices[*i].kind].plugin == plugin).collect()
    };
    let actuators: Vec<usize> = {
        let actuators = cell.devices.actuators.borrow();
        (0..actuators.devices.len()).filter(|i| old.actuators[actuators.devices[*i].kind].plugin == plugin).collect()
    };
    let moved = |mut m: DeviceReplacement, declared: &dyn Fn(&Registry) -> Vec<ParameterSpec>| {
        (m.params, m.dropped) = carry_over_params(&declared(old), &declared(new), &m.params);
        m
    };
    let sensors = sensors.into_iter().map(|i| {
        let m = save_sensor(cell, i);
        let kind = m.kind;
        moved(m, &|r| r.sensors[kind].params.clone())
    });
    let actuators = actuators.into_iter().map(|i| {
        let m = save_actuator(cell, i);
        let kind = m.kind;
        moved(m, &|r| r.actuators[kind].params.clone())
    });
    let (sensors, actuators) = (sensors.collect(), actuators.collect());
    let life = old.command_offers.world_lives.iter().find(|(p, _)| *p == plugin).map(|(_, life)| life);
    let instance = life.filter(|_| cell.devices.instances.borrow()[plugin].is_some()).map(|life| {
        let state = cell.devices.instances.borrow()[plugin].as_ref().map(|i| i.state.to_vec()).unwrap_or_default();
        save_instance(cell, &InstanceRef { plugin, slot: 0, data: cell.instance(plugin).0 }, life, &state)
    });
    (sensors, actuators, instance)
}

/// Creates all instances with the new version. If one cannot be created, returns the error and the instances created
/// before it.
fn create_instances(
    cell: &WorldCell,
    plugin: usize,
    sensors: &[DeviceReplacement],
    actuators: &[DeviceReplacement],
    scripts: &[(Rc<Script>, Option<SaveResult>)],
) -> Result<InstanceSet, Box<(Error, InstanceSet)>> {
    let mut made = InstanceSet::default();
    let refused = |m: &DeviceReplacement, why: String| {
        Error::new("E402", format!("{} cannot be created: {why}", path_of(cell, m.slot)))
    };
    let lacking = |m: &DeviceReplacement, declared: &[ParameterSpec]| {
        let lack = declared.iter().zip(&m.params).find(|(d, v)| **v == Value::Nil && !d.optional());
        lack.map(|(d, _)| refused(m, format!("its required parameter `{}` is missing", d.key)))
    };
    if let Some((_, life)) = cell.model.registry.command_offers.world_lives.iter().find(|(p, _)| *p == plugin) {
        match CommandInstance::create(cell, plugin, life, cell.devices.next_replacement_id()) {
            Ok(i) => made.instance = Some(i),
            Err(e) => return Err(Box::new((e, made))),
        }
    }
    for m in sensors {
        if let Some(e) = lacking(m, &cell.model.registry.sensors[m.kind].params) {
            return Err(Box::new((e, made)));
        }
        match create_sensor(cell, m.kind, m.slot, replacement_info(cell, m.slot, m.id), m.params.clone()) {
            Ok(d) => made.sensors.push(d),
            Err(why) => return Err(Box::new((refused(m, why), made))),
        }
    }
    for m in actuators {
        if let Some(e) = lacking(m, &cell.model.registry.actuators[m.kind].params) {
            return Err(Box::new((e, made)));
        }
        match create_actuator(cell, m.kind, m.slot, replacement_info(cell, m.slot, m.id), m.params.clone()) {
            Ok(d) => made.actuators.push(d),
            Err(why) => return Err(Box::new((refused(m, why), made))),
        }
    }
    for (script, _) in scripts {
        match script.create_replacement(cell, None) {
            Ok(s) => made.scripts.push(s),
            Err(e) => return Err(Box::new((e, made))),
        }
    }
    Ok(made)
}

/// Installs a sensor's new instance. Returns the old instance, and the reason if the new one starts from scratch.
fn install_sensor(
    cell: &WorldCell,
    mut new: SensorDevice,
    m: &DeviceReplacement,
    same_fields: bool,
) -> (Option<SensorDevice>, Option<String>) {
    let kind = &cell.model.registry.sensors[m.kind];
    let of = InstanceRef { plugin: kind.plugin, slot: m.slot, data: new.data };
    let old = {
        let mut sensing = cell.devices.sensing.borrow_mut();
        // The settings in the scene, such as the rate, the noise and the targets, must be applied to the new instance.
        sensing.invalidate_settings();
        sensing.index(m.slot).map(|i| {
            let place = &mut sensing.devices[i];
            // Its random numbers continue.
            (new.drawn, new.schedule.period) = (place.drawn, place.schedule.period);
            if same_fields {
                new.noise = place.noise.take();
            }
            if same_fields && place.fields.len() == new.fields.len() {
                new.fields.copy_from_slice(&place.fields);
                (new.sequence, new.time) = (place.sequence, place.time);
            }
            std::mem::replace(place, new)
        })
    };
    let mut block = |state: &[u64]| {
        let mut sensing = cell.devices.sensing.borrow_mut();
        if let Some(i) = sensing.index(m.slot) {
            sensing.devices[i].state.copy_from_slice(state);
        }
    };
    let why = transfer_state(cell, &of, &kind.life, &m.image, &mut block).err();
    if why.is_some() && m.image.is_ok() {
        // The failed load may have changed a part of its state.
        let fresh = create_sensor(cell, m.kind, m.slot, replacement_info(cell, m.slot, m.id), m.params.clone());
        let half = fresh.ok().and_then(|fresh| {
            let mut sensing = cell.devices.sensing.borrow_mut();
            sensing.invalidate_settings();
            sensing.index(m.slot).map(|i| std::mem::replace(&mut sensing.devices[i], fresh))
        });
        half.into_iter().for_each(|d| end_sensor(cell, d));
    }
    (old, why)
}

fn install_actuator(cell: &WorldCell, new: Actuator, m: &DeviceReplacement) -> (Option<Actuator>, Option<String>) {
    let kind = &cell.model.registry.actuators[m.kind];
    let (object, of) = (new.object, InstanceRef { plugin: kind.plugin, slot: m.slot, data: new.data });
    let old = {
        let mut actuators = cell.devices.actuators.borrow_mut();
        actuators.index(object).map(|i| {
            let mut old = std::mem::replace(&mut actuators.devices[i], new);
            if let (Some(old), Some(new)) = (old.part.as_deref_mut(), actuators.devices[i].part.as_deref_mut()) {
                // The engine still has the rules for these contacts.
                (new.hooks, new.rules) = (std::mem::take(&mut old.hooks), std::mem::take(&mut old.rules));
            }
            old
        })
    };
    let mut block = |state: &[u64]| {
        let mut actuators = cell.devices.actuators.borrow_mut();
        if let Some(i) = actuators.index(object) {
            actuators.devices[i].state.copy_from_slice(state);
        }
    };
    let why = transfer_state(cell, &of, &kind.life, &m.image, &mut block).err();
    if why.is_some() && m.image.is_ok() {
        let fresh = create_actuator(cell, m.kind, m.slot, replacement_info(cell, m.slot, m.id), m.params.clone());
        let half = fresh.ok().and_then(|fresh| {
            let mut actuators = cell.devices.actuators.borrow_mut();
            actuators.index(object).map(|i| std::mem::replace(&mut actuators.devices[i], fresh))
        });
        half.into_iter().for_each(|d| end_actuator(cell, d));
    }
    (old, why)
}

/// Carries the values of an actuator's commands over to the commands of the new version.
fn carry_over_commands(cell: &WorldCell, m: &DeviceReplacement, old: &Registry, new: &Registry) {
    let mut scene = cell.state.scene.borrow_mut();
    let Some(a) = scene.get_mut(m.slot).and_then(|o| o.data.actuator_or_part_mut()) else { return };
    let values: Vec<Value> = a.commands.iter().map(|x| Value::Float(*x)).collect();
    let given = params_by_key(&old.actuators[m.kind].commands, &values);
    let number = |v: Value| if let Value::Float(x) = v { x } else { 0.0 };
    a.commands = params_with_defaults(&new.actuators[m.kind].commands, &given).into_iter().map(number).collect();
}
