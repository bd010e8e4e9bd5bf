//! Advances physics with calls of scripts and parts before and after each step of the engine. They are called between two steps
//! of the engine, never from inside its solver.
//!
//! ```text
//! dyn       after = false
//! joint     for each joint whose control is `callback`; the first answer of a script drives the joint in this step
//! parts     `physics_step` of each part, then `contact` for each pair that parts have registered
//! (the engine's step)
//! contact   for each pair of shapes that began to touch in the step, last script first; the first answer applies from
//!           the next step on
//! dyn       after = true
//! ```

use std::collections::BTreeSet;

use tatu_physics::{JointDrive, PairRule};
use tatu_plugin_api::safe::Value;
use tatu_scene::{ControlMode, Joint, JointType, ObjectVariant};

use super::engine_advance::{self, AdvanceResult};
use crate::{
    cell::{Callback, Scripts, WorldCell},
    parts::{self, Moment, PhysicsMoment},
    scripts::map_entry,
};

/// Returns whether any script has one of these callbacks.
pub(super) fn any_callback(world: &WorldCell) -> bool {
    [Callback::Dyn, Callback::Joint, Callback::Contact].into_iter().any(|c| Scripts::any_has(world, c))
}

/// One of the engine's steps that make up an advance.
#[derive(Clone, Copy)]
struct PhysicsStep {
    /// Index of the engine step, from 0.
    index: u32,
    /// Number of engine steps in the advance.
    count: u32,
    /// Duration of all steps together, s.
    total_dt: f64,
}

impl PhysicsStep {
    fn dt(self) -> f64 {
        self.total_dt / f64::from(self.count)
    }
    /// Returns the fields that are passed to every callback.
    fn entries(self) -> Vec<(Value, Value)> {
        vec![
            key_value("step", Value::Int(i64::from(self.index) + 1)),
            key_value("steps", Value::Int(self.count.into())),
            key_value("dt", Value::Float(self.dt())),
        ]
    }
}

fn key_value(key: &str, value: Value) -> (Value, Value) {
    (Value::text(key), value)
}

fn number(map: &Value, keys: &[&str]) -> Option<f64> {
    keys.iter().find_map(|k| match map_entry(map, k) {
        Some(Value::Float(x)) if x.is_finite() => Some(*x),
        Some(Value::Int(i)) => Some(*i as f64),
        _ => None,
    })
}

/// Advances physics by `dt`.
pub(super) fn advance(world: &WorldCell, dt: f64) -> AdvanceResult {
    let mut all = AdvanceResult::default();
    let count = {
        let (mut scene, mut dynamics) = (world.state.scene.borrow_mut(), world.state.dynamics.borrow_mut());
        dynamics.prepare(&mut scene);
        dynamics.set_scripts_between_steps(true);
        dynamics.engine_steps(dt)
    };
    // Without a callback, nothing is gathered for it.
    let drives = any_callback(world);
    let hears = Scripts::any_has(world, Callback::Contact);
    let mut touching = if hears { touching_pairs(world) } else { BTreeSet::new() };
    for n in 0..count {
        let part = PhysicsStep { index: n, count, total_dt: dt };
        call_dyn_callbacks(world, part, false);
        if drives {
            drive_joints(world, part);
        }
        let moment = PhysicsMoment { index: n, count, dt: part.dt() };
        parts::call_all(world, Moment::PhysicsStep(moment));
        parts::ask_for_contacts(world, moment);
        let AdvanceResult { lost, actuators, sensors } = engine_advance::advance(world, dt, Some(n));
        all.lost.extend(lost);
        all.actuators.extend(actuators);
        all.sensors.extend(sensors);
        let now = if hears { touching_pairs(world) } else { BTreeSet::new() };
        for (a, b) in now.difference(&touching) {
            // A callback may have removed one of the shapes.
            let there = |slot: &u32| world.state.scene.borrow().get(*slot).is_some_and(|o| o.shape().is_some());
            if there(a) && there(b) {
                call_contact_callbacks(world, (*a, *b));
            }
        }
        touching = now;
        call_dyn_callbacks(world, part, true);
    }
    world.state.dynamics.borrow_mut().set_scripts_between_steps(false);
    all
}

fn touching_pairs(world: &WorldCell) -> BTreeSet<(u32, u32)> {
    let scene = world.state.scene.borrow();
    world.state.dynamics.borrow().contacts(&scene).map(|(a, b, _)| (a.min(b), a.max(b))).collect()
}

fn call_dyn_callbacks(world: &WorldCell, part: PhysicsStep, after: bool) {
    let mut map = part.entries();
    map.push(key_value("after", Value::Bool(after)));
    Scripts::call_with_payload(world, Callback::Dyn, &Value::Map(map));
}

/// Calls the joint callback for all joints that scripts control, and sets their drives according to the answers.
fn drive_joints(world: &WorldCell, part: PhysicsStep) {
    let joints: Vec<u32> = {
        let scene = world.state.scene.borrow();
        let controlled = |j: &Joint| j.control == ControlMode::Callback && j.id.is_some();
        scene.slots().filter(|(_, o)| o.joint().is_some_and(controlled)).map(|(s, _)| s).collect()
    };
    for slot in joints {
        let Some(question) = joint_payload(world, slot, part) else { continue };
        let answer = Scripts::first_answer(world, Callback::Joint, &question, false);
        let (scene, mut dynamics) = (world.state.scene.borrow(), world.state.dynamics.borrow_mut());
        let Some(joint) = scene.get(slot).and_then(|o| o.joint()) else { continue };
        let drive =
            answer.map_or(JointDrive::Free, |a| match (number(&a, &["vel", "velocity"]), number(&a, &["force"])) {
                (Some(target), force) => {
                    let max_force = force.unwrap_or(joint.max_force).abs();
                    JointDrive::Velocity { target, max_force, slip: joint.slip }
                }
                (None, Some(force)) => JointDrive::Force(force),
                (None, None) => JointDrive::Free,
            });
        dynamics.drive(joint, drive);
    }
}

/// Builds the argument of a script's joint callback.
fn joint_payload(world: &WorldCell, slot: u32, part: PhysicsStep) -> Option<Value> {
    let mut scene = world.state.scene.borrow_mut();
    let Some(ObjectVariant::Joint(j)) = scene.get_mut(slot).map(|o| &mut o.data) else { return None };
    let first = !std::mem::replace(&mut j.callback_called, true);
    let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let mut way = j.target_position - j.position;
    if j.limits.is_none() && j.kind == JointType::Revolute {
        // Take the shorter way around.
        way = tatu_geometry::wrap_angle(way);
    }
    let mut map = part.entries();
    map.extend([
        // 5 is the value of this field for joints that physics moves.
        key_value("mode", Value::Int(5)),
        key_value("first", Value::Bool(first)),
        key_value("handle", Value::Int(slot.into())),
        key_value("revolute", Value::Bool(j.kind == JointType::Revolute)),
        key_value("cyclic", Value::Bool(j.limits.is_none() && j.kind == JointType::Revolute)),
        key_value("lowLimit", Value::Float(low)),
        key_value("highLimit", Value::Float(high)),
        key_value("pos", Value::Float(j.position)),
        key_value("vel", Value::Float(j.velocity)),
        key_value("targetPos", Value::Float(j.target_position)),
        key_value("targetVel", Value::Float(j.target_velocity)),
        key_value("error", Value::Float(way)),
        key_value("maxVel", Value::Float(j.max_velocity)),
        key_value("force", Value::Float(j.max_force)),
        key_value("effort", Value::Float(j.effort)),
    ]);
    Some(Value::Map(map))
}

/// Calls the contact callback for two shapes that have begun to touch, and applies the answer to the pair.
fn call_contact_callbacks(world: &WorldCell, (a, b): (u32, u32)) {
    let map = [("shape1", i64::from(a)), ("shape2", i64::from(b)), ("engine", 0)];
    let map = Value::Map(map.map(|(k, v)| key_value(k, Value::Int(v))).to_vec());
    let Some(answer) = Scripts::first_answer(world, Callback::Contact, &map, true) else { return };
    let own = map_entry(&answer, "material");
    let factor = |key| own.and_then(|m| number(m, &[key])).filter(|x| *x >= 0.0);
    let rule = PairRule {
        responds: map_entry(&answer, "respond") != Some(&Value::Bool(false)),
        friction: factor("friction"),
        restitution: factor("restitution"),
        ..PairRule::default()
    };
    parts::apply_rule(world, (a, b), Some(rule));
}
