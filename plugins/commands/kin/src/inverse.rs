//! Commands that find positions of joints for poses.

use nalgebra::Isometry3;
use tatu_kinematics::{
    ChainError, Constraints, FrameId, Goal, JointType, Linkage, ReachSettings, ReachSolver, Reached, Refusal,
};
use tatu_kinematics_common::{SceneCopy, pose_of};
use tatu_plugin_api::{
    abi::{TATU_KIND_SHAPE, tatu_object, tatu_slot},
    safe::{Closest, Fail, Offer, Param, Result, Value, ValueRef, World},
};

use crate::{
    mechanism::path,
    plugin::{Cmd, Ctx, Kin, check_options},
    state::pose,
};

/// The options of a call.
const OPTIONS: [&str; 10] =
    ["what", "base", "from", "posture", "max_change", "avoid", "precision", "weights", "restarts", "seed"];
/// Most tips of a call.
const MAX_TIPS: usize = 64;
/// Distance of shapes that counts as a collision, m.
const TOUCHING: f64 = 1e-6;

/// The tips of a call, the joints that move them, and the options.
struct ReachCall {
    copy: SceneCopy,
    solver: ReachSolver,
    goals: Vec<Goal>,
    start: Vec<f64>,
    posture: Option<Vec<f64>>,
    max_change: Option<Vec<f64>>,
    restarts: u32,
    seed: u64,
    avoid: Vec<tatu_object>,
}

fn option<'a>(c: &Ctx<'a>, key: &str) -> ValueRef<'a> {
    c.arg(2).get(key).unwrap_or(ValueRef::NIL)
}

/// Returns a list of values, or the value itself as a list of one.
fn several(value: ValueRef<'_>, is_single: bool) -> Result<Vec<Value>> {
    match value.to_value()? {
        Value::List(all) if !is_single => Ok(all),
        Value::Ints(all) if !is_single => Ok(all.into_iter().map(Value::Int).collect()),
        Value::Floats(all) if !is_single => Ok(all.into_iter().map(Value::Float).collect()),
        single => Ok(vec![single]),
    }
}

fn handle(value: &Value) -> Option<u64> {
    match value {
        Value::Int(i) => Some(*i as u64),
        Value::Float(f) => Some(*f as u64),
        Value::Object(o) => Some(*o),
        _ => None,
    }
}

fn numbers_of(value: &Value) -> Option<Vec<f64>> {
    match value {
        Value::Floats(all) => Some(all.clone()),
        Value::Ints(all) => Some(all.iter().map(|i| *i as f64).collect()),
        Value::List(all) => all
            .iter()
            .map(|v| match v {
                Value::Float(f) => Some(*f),
                Value::Int(i) => Some(*i as f64),
                _ => None,
            })
            .collect(),
        _ => None,
    }
}

/// Returns the constraints that a word stands for.
fn constraints(word: &str) -> Result<Constraints> {
    match word {
        "pose" => Ok(Constraints::POSE),
        "position" => Ok(Constraints::POSITION),
        "axis" => Ok(Constraints::POSITION | Constraints::ALPHA_BETA),
        other => Err(Fail::argument(format!(
            "argument 3: `what` is `{other}`; expected pose, position, or axis (position and direction of z)"
        ))),
    }
}

/// Returns `n` numbers at least 0 in option `key`, one of which stands for all.
fn bounds(c: &Ctx<'_>, key: &str, n: usize) -> Result<Option<Vec<f64>>> {
    let value = option(c, key);
    let all = match value.as_f64() {
        Some(one) => vec![one; n],
        None if value.is_nil() => return Ok(None),
        None => value.numbers().unwrap_or_default(),
    };
    if all.len() != n || !all.iter().all(|x| *x >= 0.0) {
        return Err(Fail::argument(format!("argument 3: `{key}` must be a number of at least 0, or {n} of them")));
    }
    Ok(Some(all))
}

impl ReachCall {
    fn read(c: &Ctx<'_>) -> Result<Self> {
        check_options(c.arg(2), 3, &OPTIONS)?;
        let (world, props) = (c.world(), &c.plugin().scene);
        let single = c.arg(0).as_i64().is_some();
        let handles = several(c.arg(0), single)?;
        if handles.is_empty() || handles.len() > MAX_TIPS {
            return Err(Fail::argument(format!(
                "argument 1: expected the handle of a tip, or from 1 to {MAX_TIPS} of them"
            )));
        }
        let no_handle = || Fail::argument("argument 1: expected the handle of a tip, or a list of handles");
        let base = match option(c, "base").as_i64() {
            // Negative: the world.
            Some(base) if base >= 0 => Some(world.look(base as u64)?.id),
            _ => None,
        };
        let (mut copy, mut tips) = (SceneCopy::default(), Vec::new());
        for value in &handles {
            let tip = world.look(handle(value).ok_or_else(no_handle)?)?.id;
            tips.push(copy.copy_chain(&world, props, base, tip)?);
        }
        let solver = ReachSolver::new(&copy.linkage, &tips).map_err(|e| chain_error(c, &copy, e))?;
        let goals = goals(c, &tips, single)?;
        let joints = solver.joints();
        let n = joints.len();
        if n == 0 {
            return Err(Fail::argument("no joint moves the tip").help("pass an object that is attached to a joint"));
        }
        let present: Vec<f64> = joints.iter().map(|j| copy.linkage.position(*j)).collect();
        let positions = |key: &str| {
            crate::plugin::numbers(
                option(c, key),
                &format!("argument 3: `{key}`"),
                n,
                "one for each joint above the tip",
            )
        };
        let start = positions("from")?.unwrap_or(present);
        let (posture, max_change) = (positions("posture")?, bounds(c, "max_change", n)?);
        let number = |key: &str, usual: i64| match option(c, key) {
            value if value.is_nil() => Ok(usual),
            value => value
                .as_i64()
                .filter(|x| *x >= 0)
                .ok_or_else(|| Fail::argument(format!("argument 3: `{key}` must be an integer of at least 0"))),
        };
        let (restarts, seed) = (number("restarts", 10)?, number("seed", 1)?);
        let avoid = match option(c, "avoid") {
            value if value.is_nil() => Vec::new(),
            value => several(value, value.as_i64().is_some())?
                .iter()
                .map(|v| {
                    Ok(world
                        .look(
                            handle(v).ok_or_else(|| Fail::argument("argument 3: `avoid` must be a list of handles"))?,
                        )?
                        .id)
                })
                .collect::<Result<Vec<_>>>()?,
        };
        let restarts = u32::try_from(restarts).unwrap_or(u32::MAX);
        Ok(ReachCall { copy, solver, goals, start, posture, max_change, restarts, seed: seed as u64, avoid })
    }

    /// Returns the unit of a joint's position.
    fn unit(&self, joint: FrameId) -> &'static str {
        let is_prismatic = self.copy.linkage.joint(joint).is_some_and(|j| j.kind == JointType::Prismatic);
        if is_prismatic { "m" } else { "rad" }
    }

    fn object(&self, joint: FrameId) -> tatu_object {
        self.copy.objects.get(&joint).copied().unwrap_or(0)
    }

    fn solve(&mut self, c: &Ctx<'_>) -> Result<std::result::Result<Reached, Refusal>> {
        let world = c.world();
        let mut check = CollisionCheck::read(c, self)?;
        let joints = self.solver.joints().to_vec();
        let settings = ReachSettings {
            start: &self.start,
            posture: self.posture.as_deref(),
            max_change: self.max_change.as_deref(),
            restarts: self.restarts,
            seed: self.seed,
            iterations: 200,
        };
        let mut failure = None;
        let mut blocked = |q: &[f64]| match check.as_mut()?.touched(&world, &joints, q) {
            Ok(found) => found,
            Err(error) => {
                failure = Some(error);
                Some(0)
            }
        };
        let result = self.solver.solve(&self.goals, &settings, &mut blocked);
        match failure {
            Some(error) => Err(error),
            None => Ok(result),
        }
    }
}

fn chain_error(c: &Ctx<'_>, copy: &SceneCopy, error: ChainError) -> Fail {
    match error {
        ChainError::Spherical(joint) => {
            let object = copy.objects.get(&joint).copied().unwrap_or(0);
            let path = path(&c.world(), &c.plugin().props, object);
            Fail::unsupported(format!("joint `{path}` is spherical"))
                .help("use three revolute joints, or `base` to leave it out of the chain")
        }
        other => Fail::argument(format!("the joints above the tip cannot be solved: {other}")),
    }
}

fn goals(c: &Ctx<'_>, tips: &[FrameId], single: bool) -> Result<Vec<Goal>> {
    let given = several(c.arg(1), single)?;
    if given.len() != tips.len() {
        return Err(Fail::argument(format!("argument 2: {} poses for {} tips", given.len(), tips.len())));
    }
    let word = match option(c, "what") {
        value if value.is_nil() => None,
        value => Some(constraints(&value.as_str().unwrap_or_default())?),
    };
    let pair = |key: &str, usual: f64| match option(c, key).numbers() {
        Some(n) if n.len() == 2 && n.iter().all(|x| x.is_finite() && *x > 0.0) => Ok([n[0], n[1]]),
        None if option(c, key).is_nil() => Ok([usual; 2]),
        _ => Err(Fail::argument(format!("argument 3: `{key}` must be two numbers above 0: for position and angle"))),
    };
    let (precision, weights) = (pair("precision", 1e-6)?, pair("weights", 1.0)?);
    let world = c.world();
    let mut goals = Vec::new();
    for (i, value) in given.iter().enumerate() {
        let expected = || {
            Fail::argument(format!(
                "argument 2: expected the handle of an object, a pose (x y z and a quaternion x y z w) or a position (x \
                 y z) for tip {}",
                i + 1
            ))
        };
        let (at, positional): (Isometry3<f64>, bool) = match (handle(value), numbers_of(value)) {
            (Some(object), _) => (pose_of(world.pose(world.look(object)?.id, 0)?), false),
            (_, Some(n)) => (pose(&n).ok_or_else(expected)?, n.len() == 3),
            _ => return Err(expected()),
        };
        let usual = if positional { Constraints::POSITION } else { Constraints::POSE };
        let mut goal = Goal { precision, weights, ..Goal::new(at) };
        goal.constraints = word.unwrap_or(usual);
        goals.push(goal);
    }
    Ok(goals)
}

/// The shapes that the joints of a call move, and those that they shall not touch.
struct CollisionCheck {
    /// A copy of the joints, which is moved, and for each moved shape the frame of its copy.
    linkage: Linkage,
    frames: Vec<FrameId>,
    shapes: Vec<tatu_object>,
    avoid: Vec<tatu_object>,
}

impl CollisionCheck {
    fn read(c: &Ctx<'_>, call: &ReachCall) -> Result<Option<Self>> {
        let Some(first) = call.solver.joints().first().filter(|_| !call.avoid.is_empty()) else { return Ok(None) };
        let (world, props) = (c.world(), &c.plugin().scene);
        let (mut copy, mut frames, mut shapes) = (call.copy.clone(), Vec::new(), Vec::new());
        for shape in world.list(call.object(*first), 1 << TATU_KIND_SHAPE, 0)? {
            if !call.avoid.contains(&shape) {
                frames.push(copy.copy_frame(&world, props, shape)?);
                shapes.push(shape);
            }
        }
        Ok(Some(CollisionCheck { linkage: copy.linkage, frames, shapes, avoid: call.avoid.clone() }))
    }

    /// Returns the first object to avoid that the moved shapes touch at some positions.
    fn touched(&mut self, world: &World<'_>, joints: &[FrameId], q: &[f64]) -> Result<Option<u64>> {
        for (joint, q) in joints.iter().zip(q) {
            self.linkage.set_position(*joint, *q);
        }
        let pose = |frame: &FrameId| {
            let pose = self.linkage.pose(*frame);
            let (t, r) = (pose.translation, pose.rotation);
            [t.x, t.y, t.z, r.i, r.j, r.k, r.w]
        };
        let poses: Vec<[f64; 7]> = self.frames.iter().map(pose).collect();
        let found = world.closest_at(&self.shapes, &poses, &self.avoid, TOUCHING)?;
        let distance = |c: &Closest| c.from.iter().zip(c.to).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        Ok(found.filter(|c| distance(c) <= TOUCHING * TOUCHING).map(|c| c.pair[1]))
    }
}

/// Returns the word for a reason, its sentence, and its values.
fn reason(c: &Ctx<'_>, call: &ReachCall, refusal: &Refusal) -> (&'static str, String, Vec<(Value, Value)>) {
    let (world, p) = (c.world(), &c.plugin().props);
    let name = |o: tatu_object| path(&world, p, o);
    let entry = |key: &str, value: Value| (Value::text(key), value);
    let handle = |o: tatu_object| Value::Int(i64::from(tatu_slot(o)));
    match *refusal {
        Refusal::Invalid(what) => ("invalid", what.to_owned(), Vec::new()),
        Refusal::OutOfReach { by, inside, oriented } => {
            let place = if inside { "inside the region that the arm cannot reach" } else { "too far away" };
            let turned = if oriented { " with this orientation" } else { "" };
            let text = format!("the goal is out of reach by {by:.6} m{turned}: it is {place}");
            let values = vec![
                entry("by", Value::Float(by)),
                entry("inside", Value::Bool(inside)),
                entry("oriented", Value::Bool(oriented)),
            ];
            ("out of reach", text, values)
        }
        Refusal::Orientation { by } => {
            let text = format!("the position can be reached, but the orientation is missed by {by:.6} rad");
            ("orientation", text, vec![entry("by", Value::Float(by))])
        }
        Refusal::Limit { joint, by } => {
            let object = call.object(joint);
            let side = if by < 0.0 { "lower" } else { "upper" };
            let (by_how_much, unit) = (by.abs(), call.unit(joint));
            let text =
                format!("joint `{}` would have to exceed its {side} limit by {by_how_much:.6} {unit}", name(object));
            ("limit", text, vec![entry("by", Value::Float(by)), entry("joint", handle(object))])
        }
        Refusal::Change { joint, by } => {
            let object = call.object(joint);
            let (by_how_much, unit) = (by.abs(), call.unit(joint));
            let text =
                format!("joint `{}` would have to move {by_how_much:.6} {unit} more than `max_change`", name(object));
            ("change", text, vec![entry("by", Value::Float(by)), entry("joint", handle(object))])
        }
        Refusal::Singular { direction } => {
            let numbers: Vec<String> = direction.iter().map(|x| format!("{x:.3}")).collect();
            let text = format!(
                "from here, no joint moves the tip in the direction of the goal ({}); start elsewhere",
                numbers.join(" ")
            );
            ("singular", text, vec![entry("direction", Value::Floats(direction.to_vec()))])
        }
        Refusal::Collision(object) => {
            ("collision", format!("it would collide with `{}`", name(object)), vec![entry("object", handle(object))])
        }
        Refusal::NotFound(d) => {
            let text = format!(
                "no positions were found; the nearest miss the goal by {:.6} m and {:.6} rad",
                d.distance, d.angle
            );
            (
                "not found",
                text,
                vec![entry("distance", Value::Float(d.distance)), entry("angle", Value::Float(d.angle))],
            )
        }
    }
}

fn ik(c: &mut Ctx<'_>) -> Result {
    let mut call = ReachCall::read(c)?;
    let result = call.solve(c)?;
    let joints: Vec<i64> = call.solver.joints().iter().map(|j| i64::from(tatu_slot(call.object(*j)))).collect();
    let found = Value::Floats(call.solver.positions().to_vec());
    match result {
        Ok(_) => {
            c.ret(found);
            c.ret(joints);
            c.ret(Value::Nil);
        }
        Err(Refusal::Invalid(what)) => return Err(Fail::argument(what)),
        Err(refusal) => {
            let (kind, text, mut values) = reason(c, &call, &refusal);
            values.push((Value::text("kind"), Value::text(kind)));
            values.push((Value::text("text"), Value::text(text)));
            values.push((Value::text("nearest"), found));
            c.ret(Value::Nil);
            c.ret(joints);
            c.ret(Value::Map(values));
        }
    }
    Ok(())
}

fn reach(c: &mut Ctx<'_>) -> Result {
    let mut call = ReachCall::read(c)?;
    match call.solve(c)? {
        Ok(_) => {
            c.ret(true);
            c.ret("");
        }
        Err(Refusal::Invalid(what)) => return Err(Fail::argument(what)),
        Err(refusal) => {
            let text = reason(c, &call, &refusal).1;
            c.ret(false);
            c.ret(text);
        }
    }
    Ok(())
}

/// Adds the parameters of both commands.
fn with_params(command: Cmd) -> Cmd {
    command
        .param(Param::any("tip").text("the handle of the object that shall move, or a list of handles"))
        .param(Param::any("goal").text(
            "where it shall be, in the world: the handle of an object, a pose (x y z, m, and a quaternion x y z w) or a position (x y z); \
             for several tips, a list",
        ))
        .param(Param::map("options").optional().text(
            "`what`: pose, position or axis; `base`: handle of the object to which the chain of joints reaches; `from`: \
             positions to start from; `posture`: positions for joints that the goal leaves free; `max_change`: from the \
             start, without restarts; `avoid`: handles of objects not to touch; `precision`: {1e-6, 1e-6}, m and rad; `weights`: {1, 1}; \
             `restarts`: how often to start anew from random positions at most, 10; `seed`: 1",
        ))
}

pub fn offer(offer: &mut Offer<Kin>) {
    offer.command(
        with_params(Cmd::new("tatu.kin.ik", ik))
            .returns(Param::floats("positions", 0).optional().text("rad or m: nil if there are none"))
            .returns(Param::ints("joints", 0).text("the handles of the joints, in the same order: from base to tip"))
            .returns(Param::map("reason").optional().text(
                "after a failure: `kind` (out of reach, orientation, limit, change, singular, collision, not found), \
                 `text`, `nearest` positions, and what belongs to the kind: `by`, `joint`, `inside`, `oriented`, \
                 `direction`, `object`, `distance`, `angle`",
            ))
            .text("Returns positions of joints, within their limits, that bring objects to poses. Nothing moves.")
            .notes("Equal arguments give equal results on all machines."),
    );
    offer.command(
        with_params(Cmd::new("tatu.kin.reach", reach))
            .returns(Param::bool("reachable"))
            .returns(Param::string("text").text("why not, in a sentence"))
            .text("Returns whether joints can bring objects to poses, and otherwise why not. Nothing moves."),
    );
}
