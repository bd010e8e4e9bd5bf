//! Advances physics with script callbacks before and after each step of the engine. They are called between two steps
//! of the engine, never from inside its solver.
//!
//! ```text
//! dyn       after = false
//! joint     for each joint whose control is `callback`; the first answer of a script drives the joint in this step
//! (the engine's step)
//! contact   for each pair of shapes that began to touch in the step, last script first; the first answer applies from
//!           the next step on
//! dyn       after = true
//! ```

use std::collections::BTreeSet;

use tatu_physics::{Drive, PairRule};
use tatu_plugin_api::safe::Value;
use tatu_scene::{Control, Joint, JointType};

use super::actuated::{self, Advanced};
use crate::{
    cell::{Callback, Phase, Scripts, WorldCell},
    scripts::entry,
};

/// Returns whether any script has one of these callbacks.
pub(super) fn wanted(world: &WorldCell) -> bool {
    [Callback::Dyn, Callback::Joint, Callback::Contact].into_iter().any(|c| Scripts::any_has(world, c))
}

/// One of the engine's steps that make up an advance.
#[derive(Clone, Copy)]
struct Part {
    /// Index of the engine step, from 0.
    number: u32,
    /// Number of engine steps in the advance.
    count: u32,
    /// Duration of all steps together, s.
    whole: f64,
}

impl Part {
    fn dt(self) -> f64 {
        self.whole / f64::from(self.count)
    }
    /// Returns the fields that are passed to every callback.
    fn entries(self) -> Vec<(Value, Value)> {
        vec![
            of("step", Value::Int(i64::from(self.number) + 1)),
            of("steps", Value::Int(self.count.into())),
            of("dt", Value::Float(self.dt())),
        ]
    }
}

fn of(key: &str, value: Value) -> (Value, Value) {
    (Value::text(key), value)
}

fn number(map: &Value, keys: &[&str]) -> Option<f64> {
    keys.iter().find_map(|k| match entry(map, k) {
        Some(Value::Float(x)) if x.is_finite() => Some(*x),
        Some(Value::Int(i)) => Some(*i as f64),
        _ => None,
    })
}

/// Advances physics by `dt`.
pub(super) fn advance(world: &WorldCell, dt: f64) -> Advanced {
    let mut all = Advanced::default();
    let count = {
        let (mut scene, mut dynamics) = (world.state.scene.borrow_mut(), world.state.dynamics.borrow_mut());
        dynamics.prepare(&mut scene);
        dynamics.set_between(true);
        dynamics.engine_steps(dt)
    };
    let mut touching = pairs(world);
    for n in 0..count {
        let part = Part { number: n, count, whole: dt };
        tell(world, part, false);
        drive_joints(world, part);
        let Advanced { lost, actuators, sensors } = actuated::advance(world, dt, Some(n));
        all.lost.extend(lost);
        all.actuators.extend(actuators);
        all.sensors.extend(sensors);
        let now = pairs(world);
        for (a, b) in now.difference(&touching) {
            // A callback may have removed one of the shapes.
            let there = |slot: &u32| world.state.scene.borrow().get(*slot).is_some_and(|o| o.shape().is_some());
            if there(a) && there(b) {
                tell_contact(world, (*a, *b));
            }
        }
        touching = now;
        tell(world, part, true);
    }
    world.state.dynamics.borrow_mut().set_between(false);
    all
}

/// Returns the pairs of shapes that touch.
fn pairs(world: &WorldCell) -> BTreeSet<(u32, u32)> {
    let scene = world.state.scene.borrow();
    world.state.dynamics.borrow().contacts(&scene).map(|(a, b, _)| (a.min(b), a.max(b))).collect()
}

fn tell(world: &WorldCell, part: Part, after: bool) {
    let mut map = part.entries();
    map.push(of("after", Value::Bool(after)));
    Scripts::tell(world, Callback::Dyn, &Value::Map(map));
}

/// Calls the joint callback for all joints that scripts control, and sets their drives according to the answers.
fn drive_joints(world: &WorldCell, part: Part) {
    let joints: Vec<u32> = {
        let scene = world.state.scene.borrow();
        let controlled = |j: &Joint| j.control == Control::Callback && j.id.is_some();
        scene.slots().filter(|(_, o)| o.joint().is_some_and(controlled)).map(|(s, _)| s).collect()
    };
    for slot in joints {
        let Some(question) = question(world, slot, part) else { continue };
        let answer = Scripts::ask(world, Callback::Joint, &question, false);
        let (scene, mut dynamics) = (world.state.scene.borrow(), world.state.dynamics.borrow_mut());
        let Some(joint) = scene.get(slot).and_then(|o| o.joint()) else { continue };
        let drive = answer.map_or(Drive::Free, |a| match (number(&a, &["vel", "velocity"]), number(&a, &["force"])) {
            (Some(target), force) => {
                let max_force = force.unwrap_or(joint.max_force).abs();
                Drive::Velocity { target, max_force, slip: joint.slip }
            }
            (None, Some(force)) => Drive::Force(force),
            (None, None) => Drive::Free,
        });
        dynamics.drive(joint, drive);
    }
}

/// Builds the argument of a script's joint callback.
fn question(world: &WorldCell, slot: u32, part: Part) -> Option<Value> {
    let scene = world.state.scene.borrow();
    let j = scene.get(slot)?.joint()?;
    let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let mut way = j.target_position - j.position;
    if j.limits.is_none() && j.kind == JointType::Revolute {
        // Take the shorter way around.
        way = tatu_geometry::wrap_angle(way);
    }
    let first = part.number == 0 && world.state.phase.get() == Phase::First;
    let mut map = part.entries();
    map.extend([
        // 5 is the value of this field for joints that physics moves.
        of("mode", Value::Int(5)),
        of("first", Value::Bool(first)),
        of("handle", Value::Int(slot.into())),
        of("revolute", Value::Bool(j.kind == JointType::Revolute)),
        of("cyclic", Value::Bool(j.limits.is_none() && j.kind == JointType::Revolute)),
        of("lowLimit", Value::Float(low)),
        of("highLimit", Value::Float(high)),
        of("pos", Value::Float(j.position)),
        of("vel", Value::Float(j.velocity)),
        of("targetPos", Value::Float(j.target_position)),
        of("targetVel", Value::Float(j.target_velocity)),
        of("error", Value::Float(way)),
        of("maxVel", Value::Float(j.max_velocity)),
        of("force", Value::Float(j.max_force)),
        of("effort", Value::Float(j.effort)),
    ]);
    Some(Value::Map(map))
}

/// Calls the contact callback for two shapes that have begun to touch, and applies the answer to the pair.
fn tell_contact(world: &WorldCell, (a, b): (u32, u32)) {
    let map = [("shape1", i64::from(a)), ("shape2", i64::from(b)), ("engine", 0)];
    let map = Value::Map(map.map(|(k, v)| of(k, Value::Int(v))).to_vec());
    let Some(answer) = Scripts::ask(world, Callback::Contact, &map, true) else { return };
    let own = entry(&answer, "material");
    let factor = |key| own.and_then(|m| number(m, &[key])).filter(|x| *x >= 0.0);
    let rule = PairRule {
        responds: entry(&answer, "respond") != Some(&Value::Bool(false)),
        friction: factor("friction"),
        restitution: factor("restitution"),
    };
    let (scene, mut dynamics) = (world.state.scene.borrow(), world.state.dynamics.borrow_mut());
    if let (Some(a), Some(b)) = (scene.get(a).and_then(|o| o.shape()), scene.get(b).and_then(|o| o.shape())) {
        dynamics.set_pair(a, b, Some(rule));
    }
}
