//! Publishes contact events: compares the touching shapes with those of the previous physics stage.

use std::collections::BTreeSet;

use tatu_physics::BodyContact;
use tatu_plugin_api::safe::Value;
use tatu_plugins::events::OPT_IN_EVENTS;
use tatu_scene::Scene;

use crate::cell::{WorldCell, payload};

/// Publishes the pairs that touch, begin to touch or cease to touch, after a physics stage. Queries the engine only if
/// there is a subscriber. If there was no subscriber before, all touching pairs are treated as new.
pub(crate) fn compare(world: &WorldCell) {
    let outside = &world.run.connections;
    let [collision, separation, contact] = [0, 1, 2].map(|i| outside.has_subscriber(OPT_IN_EVENTS[i]));
    if !(collision || separation || contact) {
        if !outside.bus.touching.borrow().is_empty() {
            outside.bus.touching.borrow_mut().clear();
        }
        return;
    }
    let (Ok(scene), Ok(dynamics)) = (world.state.scene.try_borrow(), world.state.dynamics.try_borrow()) else { return };
    // The strongest contact of each pair, with the lower slot first.
    let mut pairs: Vec<(u32, u32, BodyContact)> = Vec::new();
    for (a, b, c) in dynamics.contacts(&scene) {
        let (a, b, c) = if a <= b { (a, b, c) } else { (b, a, BodyContact { normal: -c.normal, ..c }) };
        match pairs.iter_mut().find(|(x, y, _)| (*x, *y) == (a, b)) {
            Some((_, _, strongest)) if strongest.force >= c.force => {}
            Some((_, _, strongest)) => *strongest = c,
            None => pairs.push((a, b, c)),
        }
    }
    pairs.sort_by_key(|(a, b, _)| (*a, *b));
    let now: BTreeSet<(u32, u32)> = pairs.iter().map(|(a, b, _)| (*a, *b)).collect();
    let before = outside.bus.touching.replace(now);
    let now = outside.bus.touching.borrow();
    if separation {
        for (a, b) in before.difference(&now) {
            outside.publish("separation", || payload(pair_entries(&scene, *a, *b)));
        }
    }
    for (a, b, c) in &pairs {
        let all = || {
            let [a, b, a_path, b_path] = pair_entries(&scene, *a, *b);
            let point = ("point", Value::Floats(c.point.coords.iter().copied().collect()));
            let normal = ("normal", Value::Floats(c.normal.iter().copied().collect()));
            payload([a, b, a_path, b_path, point, normal, ("force", Value::Float(c.force))])
        };
        if collision && !before.contains(&(*a, *b)) {
            outside.publish("collision", all);
        }
        if contact {
            outside.publish("contact", all);
        }
    }
}

fn pair_entries(scene: &Scene, a: u32, b: u32) -> [(&'static str, Value); 4] {
    [
        ("a", Value::Object(scene.id(a))),
        ("b", Value::Object(scene.id(b))),
        ("a_path", Value::text(scene.path(a))),
        ("b_path", Value::text(scene.path(b))),
    ]
}
