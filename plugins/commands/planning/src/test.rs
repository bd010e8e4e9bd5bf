//! Tests of the states of a task.

use std::cell::RefCell;

use tatu_planning::{
    Goal, Validity,
    spheres::{BodyChecker, SphereCache},
};
use tatu_plugin_api::{
    abi::{TATU_KIND_SHAPE, TATU_SLOT_BITS, tatu_object},
    safe::{Fail, Result, Value, World},
};

use crate::{
    arguments::{HANDLE_ALL, call, is_yes, object_by_handle},
    mechanism::{ExactTest, Mechanism},
    spaces::weighted_distance,
    state::{Callback, Ctx, Planning, Task},
};

/// Returns the objects of an entity: an object itself, or those of a collection; `None` for all.
fn entity(world: &World<'_>, handle: i64) -> Result<Option<Vec<tatu_object>>> {
    if handle == HANDLE_ALL {
        return Ok(None);
    }
    if handle as u64 <= TATU_SLOT_BITS && handle > 0 {
        return object_by_handle(world, "a collision pair", handle as f64).map(|o| Some(vec![o.id]));
    }
    let found = world.call_command("sim.getCollectionObjects", &[Value::Int(handle)])?;
    let handles: Vec<f64> = match found.first() {
        Some(Value::Ints(all)) => all.iter().map(|i| *i as f64).collect(),
        Some(Value::Floats(all)) => all.clone(),
        _ => Vec::new(),
    };
    let objects: Result<Vec<tatu_object>> =
        handles.iter().map(|h| object_by_handle(world, "a collection", *h).map(|o| o.id)).collect();
    objects.map(Some)
}

/// Returns all shapes of the scene.
pub fn all_shapes(world: &World<'_>) -> Result<Vec<tatu_object>> {
    let all = world.list(0, 0, 0)?;
    Ok(all.into_iter().filter(|o| world.look(*o).is_ok_and(|o| o.kind == TATU_KIND_SHAPE)).collect())
}

/// Returns the pairs of bodies of pairs of entities.
pub fn pairs_of(world: &World<'_>, mechanism: &mut Mechanism<'_>, pairs: &[[i64; 2]]) -> Result<Vec<[usize; 2]>> {
    let mut found = Vec::new();
    for [a, b] in pairs {
        let Some(first) = entity(world, *a)? else {
            return Err(Fail::argument("a collision pair begins with all objects; only its second part may be all"));
        };
        let other = match entity(world, *b)? {
            Some(objects) => objects,
            None => all_shapes(world)?.into_iter().filter(|o| !first.contains(o)).collect(),
        };
        let within = a == b;
        for (i, x) in first.iter().enumerate() {
            let Some(x) = mechanism.body(*x)? else { continue };
            for y in other.iter().skip(if within { i + 1 } else { 0 }) {
                let Some(y) = mechanism.body(*y)?.filter(|y| *y != x) else { continue };
                // Neighbours in a chain always touch at their joint.
                let (fx, fy) = (mechanism.frame_of_body(x), mechanism.frame_of_body(y));
                if !(within && mechanism.are_neighbours(fx, fy)) {
                    found.push([x, y]);
                }
            }
        }
    }
    Ok(found)
}

/// A test of the states of a task.
pub enum StateTest<'t, 'm, 'c> {
    /// No pairs and no callback: all are possible.
    Anything,
    Bodies(Box<BodyChecker<ExactTest>>),
    Script(&'t ScriptTest<'t, 'm, 'c>),
}

/// A test by a function of the script; its first error ends the search.
pub struct ScriptTest<'t, 'm, 'c> {
    pub call: &'t RefCell<&'m mut Ctx<'c>>,
    pub callback: Callback,
    pub error: &'t RefCell<Option<Fail>>,
}

impl ScriptTest<'_, '_, '_> {
    /// Calls the function; nothing after an error.
    pub fn results(&self, state: &[f64]) -> Vec<Value> {
        if self.error.borrow().is_some() {
            return Vec::new();
        }
        let answer = match self.call.try_borrow_mut() {
            Ok(mut c) => call(&mut c, &self.callback, &[Value::Floats(state.to_vec())]),
            Err(_) => Err(Fail::new("a callback of a planning task called the planner again")),
        };
        answer.unwrap_or_else(|error| {
            *self.error.borrow_mut() = Some(error);
            Vec::new()
        })
    }
}

impl Validity for StateTest<'_, '_, '_> {
    fn is_valid(&mut self, state: &[f64]) -> bool {
        match self {
            StateTest::Anything => true,
            StateTest::Bodies(checker) => checker.is_valid(state),
            StateTest::Script(test) => is_yes(test.results(state).first()),
        }
    }
    fn are_valid(&mut self, states: &[f64], dimension: usize) -> bool {
        match self {
            StateTest::Bodies(checker) => checker.are_valid(states, dimension),
            _ => states.chunks_exact(dimension).all(|state| self.is_valid(state)),
        }
    }
    fn lanes(&self) -> usize {
        if let StateTest::Bodies(checker) = self { checker.lanes() } else { 1 }
    }
}

/// Returns the test of a task's collision pairs.
pub fn body_test<'t, 'm, 'c>(
    world: &World<'_>,
    props: &Planning,
    task: &Task,
    cache: &mut SphereCache,
) -> Result<StateTest<'t, 'm, 'c>> {
    if task.pairs.is_empty() {
        return Ok(StateTest::Anything);
    }
    let mut mechanism = Mechanism::new(*world, props, &task.spaces)?;
    let pairs = pairs_of(world, &mut mechanism, &task.pairs)?;
    Ok(StateTest::Bodies(Box::new(mechanism.checker(&pairs, (0.0, &[]), cache))))
}

/// Returns the goal of a task.
pub fn goal_of<'t>(
    world: &World<'_>,
    props: &Planning,
    task: &Task,
    script: Option<&'t ScriptTest<'_, '_, '_>>,
) -> Result<Goal<'t>> {
    if let Some(script) = script {
        let distance = move |state: &[f64]| {
            let results = script.results(state);
            let far = match results.get(1) {
                Some(Value::Float(x)) if x.is_finite() => x.max(1e-9),
                Some(Value::Int(x)) => (*x as f64).max(1e-9),
                _ => 1.0,
            };
            if is_yes(results.first()) { 0.0 } else { far }
        };
        return Ok(Goal::Region(Box::new(distance)));
    }
    let Some(dummies) = &task.dummy_goal else { return Ok(Goal::States(task.goals.clone())) };
    let mut mechanism = Mechanism::new(*world, props, &task.spaces)?;
    let (frame, own) = mechanism.attachment(dummies.moved)?;
    let (target_frame, target) = mechanism.attachment(dummies.target)?;
    let (frames, metric, tolerance) = (mechanism.frames.clone(), dummies.metric, dummies.tolerance);
    Ok(Goal::Region(Box::new(move |state: &[f64]| {
        let poses = frames.poses(state);
        let a = frame.and_then(|f| poses.get(f)).map_or(own, |p| p * own);
        let b = target_frame.and_then(|f| poses.get(f)).map_or(target, |p| p * target);
        weighted_distance(&a, &b, &metric) - tolerance
    })))
}
