//! The values of a world that a stream can record.

use tatu_plugin_api::{
    abi::{TATU_LOG_WARNING, tatu_slot},
    safe::Value,
};
use tatu_scene::{self, Scene, property_table::Property};

use crate::cell::WorldCell;

/// Short names of the most commonly recorded values.
const SHORT_NAMES: &[(&str, &str)] =
    &[("x", "object.world_pose[0]"), ("y", "object.world_pose[1]"), ("z", "object.world_pose[2]")];

/// Warns of streams whose object does not exist at the start, or whose value no kind of object has.
pub(crate) fn warn_of_invalid_streams(world: &WorldCell) {
    let (scene, figures) = (world.state.scene.borrow(), world.devices.figures.borrow());
    for (object, graph) in &figures.graphs {
        for spec in graph.streams.iter().map(|s| &s.spec).filter(|s| !s.of.is_empty()) {
            let why = if scene.find(tatu_slot(*object), &spec.of).is_none() {
                format!("there is no object `{}`", spec.of)
            } else if !is_known(world, &spec.data) {
                format!("no kind of object has a numeric property or field `{}`", spec.data)
            } else {
                continue;
            };
            world.log(TATU_LOG_WARNING, &format!("the stream `{}` of {} remains empty: {why}", spec.name, graph.name));
        }
    }
}

/// Returns whether any kind of object can have a numeric value with this name.
fn is_known(world: &WorldCell, data: &str) -> bool {
    let key = data.split_once('[').map_or(data, |(key, _)| key);
    ["x", "y", "z", "alpha", "beta", "gamma", "speed", "turning"].contains(&data)
        || Property::by_key(key).is_some()
        || world.model.registry.sensors.iter().flat_map(|s| &s.fields).any(|f| f.name == key)
}

/// Returns the current value `data` of the object `of`, a path that is resolved from the graph. Returns `None` if the
/// object does not exist or has no such value, or is a sensor that has not been measured yet.
pub fn number(world: &WorldCell, scene: &Scene, graph: u32, of: &str, data: &str) -> Option<f64> {
    let slot = scene.find(graph, of)?;
    match data {
        "alpha" | "beta" | "gamma" => {
            let turns = tatu_scene::to_euler(&scene.world(slot).rotation);
            return turns.get(["alpha", "beta", "gamma"].iter().position(|n| *n == data)?).copied();
        }
        "speed" | "turning" => {
            let t = world.state.frame_twist(scene, &*world.state.dynamics.try_borrow().ok()?, slot);
            let [x, y, z] = if data == "speed" { [t[0], t[1], t[2]] } else { [t[3], t[4], t[5]] };
            return Some((x * x + y * y + z * z).sqrt());
        }
        _ => {}
    }
    let data = SHORT_NAMES.iter().find(|(short, _)| *short == data).map_or(data, |(_, long)| long);
    let (key, index) = match data.strip_suffix(']').and_then(|d| d.split_once('[')) {
        Some((key, index)) => (key, index.parse().ok()?),
        None => (data, 0),
    };
    let value = match Property::by_key(key) {
        Some(row) => tatu_scene::get(scene, slot, row).ok()?,
        None => {
            let sensing = world.devices.sensing.try_borrow().ok()?;
            let device = sensing.device(slot).filter(|d| d.sequence > 0)?;
            let kind = &world.model.registry.sensors[device.kind];
            device.value(kind, kind.fields.iter().position(|f| f.name == key)?)
        }
    };
    match value {
        Value::Float(x) if index == 0 => Some(x),
        Value::Int(i) if index == 0 => Some(i as f64),
        Value::Bool(b) if index == 0 => Some(f64::from(u8::from(b))),
        Value::Floats(v) => v.get(index).copied(),
        Value::Ints(v) => v.get(index).map(|i| *i as f64),
        _ => None,
    }
}
