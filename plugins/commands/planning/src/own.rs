//! `tatu.plan`: a path for a robot of the scene.

use nalgebra::Isometry3;
use tatu_kinematics::{IkTask, JointRole, SearchSettings, find_configuration, random_configuration};
use tatu_kinematics_common::{SceneCopy, pose_of};
use tatu_planning::{
    Algorithm, Goal, Path, PlanError, Problem, Settings, StateSpace, divide, plan, shorten,
    spheres::{BodyChecker, SphereCache},
};
use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Fail, Offer, Param, Result, Value, ValueRef, World},
};

use crate::{
    arguments::{checked, joint, numbers, object_by_handle},
    mechanism::{ExactTest, Mechanism},
    spaces::{read_state, state_space},
    state::{Ctx, ObjectSpace, Planning, SpaceKind},
    tasks::joint_space,
    test::{all_shapes, pairs_of},
};

const DEFAULT_CHECKS: i64 = 200_000;
const MAX_CHECKS: i64 = 10_000_000;
/// Starts of inverse kinematics for a pose, and the most configurations of it that are goals.
const IK_STARTS: u64 = 60;
const IK_GOALS: usize = 12;
/// Resolution of a motion: a share of the diagonal of the joints' limits.
const RESOLUTION: f64 = 0.004;
const MAX_STATES: i64 = 1_000_000;

/// The options of a call.
struct Options<'a>(ValueRef<'a>);

impl<'a> Options<'a> {
    fn get(&self, key: &str) -> ValueRef<'a> {
        self.0.get(key).unwrap_or(ValueRef::NIL)
    }
    fn int(&self, key: &str, default: i64, low: i64, high: i64) -> Result<i64> {
        let value = self.get(key);
        if value.is_nil() {
            return Ok(default);
        }
        let wrong = || Fail::argument(format!("option {key}: expected a number from {low} to {high}"));
        value.as_i64().filter(|x| (low..=high).contains(x)).ok_or_else(wrong)
    }
    fn objects(&self, world: &World<'_>, key: &str) -> Result<Option<Vec<tatu_object>>> {
        let value = self.get(key);
        if value.is_nil() {
            return Ok(None);
        }
        let wrong = || Fail::argument(format!("option {key}: expected a table of objects"));
        let handles = value.numbers().ok_or_else(wrong)?;
        let objects: Result<_> =
            handles.iter().map(|h| object_by_handle(world, &format!("option {key}"), *h).map(|o| o.id)).collect();
        objects.map(Some)
    }
}

/// Reads the goals: a configuration, a table of configurations, or nil.
fn goals(c: &Ctx<'_>, count: usize) -> Result<Vec<Vec<f64>>> {
    let value = c.arg(1);
    if value.is_nil() || value.is_empty() {
        return Ok(Vec::new());
    }
    if let Some(numbers) = value.numbers() {
        return Ok(vec![checked("argument 2, a configuration", numbers, count)?]);
    }
    let wrong = || Fail::argument("argument 2: expected a configuration, or a table of configurations");
    let each = |(i, v): (usize, &ValueRef<'_>)| {
        checked(&format!("argument 2, configuration {}", i + 1), v.numbers().ok_or_else(wrong)?, count)
    };
    value.list().ok_or_else(wrong)?.iter().enumerate().map(each).collect()
}

/// Returns configurations for which an object has a pose in the world.
fn configurations(
    world: &World<'_>,
    props: &Planning,
    spaces: &[ObjectSpace],
    start: &[f64],
    (tip, pose): (tatu_object, &Isometry3<f64>),
    seed: u64,
) -> Result<Vec<Vec<f64>>> {
    let mut copy = SceneCopy::default();
    let tip = copy.copy_chain(world, &props.chains, None, tip)?;
    let target = copy.linkage.add_frame(None, *pose);
    let missing = |o: tatu_object| {
        let handle = world.look(o).map_or(0, |o| o.handle());
        Fail::argument(format!("option tip: joint {handle} does not move it")).help("the tip must be below all joints")
    };
    let joints: Result<Vec<_>> =
        spaces.iter().map(|s| copy.copy_of(s.object).ok_or_else(|| missing(s.object))).collect();
    let joints = joints?;
    for (joint, position) in joints.iter().zip(start) {
        copy.linkage.set_position(*joint, *position);
    }
    let others: Vec<_> = copy.linkage.ids().filter(|id| !joints.contains(id)).collect();
    for id in others {
        if let Some(joint) = copy.linkage.joint_mut(id).filter(|j| !matches!(j.role, JointRole::Dependent { .. })) {
            joint.role = JointRole::Fixed;
        }
    }
    let task = [IkTask::new(tip, target)];
    let mut found: Vec<Vec<f64>> = Vec::new();
    for n in 0..IK_STARTS {
        let mut arm = copy.linkage.clone();
        if n > 0 {
            random_configuration(&mut arm, &task, seed, n);
        }
        let settings = SearchSettings { max_restarts: 0, ..SearchSettings::default() };
        if find_configuration(&mut arm, &task, &settings).is_ok() {
            found.push(joints.iter().map(|j| arm.position(*j)).collect());
        }
        if found.len() >= IK_GOALS {
            break;
        }
    }
    Ok(found)
}

/// Returns a test of what may not touch: the moved shapes and what they carry, the rest of the robot, and obstacles.
fn tester(
    world: &World<'_>,
    props: &Planning,
    spaces: &[ObjectSpace],
    options: &Options<'_>,
    start: &[f64],
    cache: &mut SphereCache,
) -> Result<(BodyChecker<ExactTest>, Vec<tatu_object>)> {
    let mut mechanism = Mechanism::new(*world, props, spaces)?;
    if let (Some(grasped), Some(last)) = (options.objects(world, "grasped")?, spaces.last()) {
        for object in grasped {
            for part in [vec![object], world.list(object, 0, 0)?].concat() {
                mechanism.carry(part, last.object)?;
            }
        }
    }
    let collides = |o: &tatu_object| world.get(*o, props.respondable).is_ok_and(|v| v.as_bool().unwrap_or(false));
    let (mut moved, mut still) = (Vec::new(), Vec::new());
    for shape in all_shapes(world)? {
        if mechanism.frame_of(shape, 0)?.is_some() { moved.push(shape) } else { still.push(shape) }
    }
    // Shapes that are only for the eye collide with nothing, unless there are no others.
    if moved.iter().any(collides) {
        moved.retain(collides);
    }
    let root = root_of(world, props, spaces[0].object)?;
    let own: Vec<tatu_object> =
        still.iter().copied().filter(|o| root_of(world, props, *o).is_ok_and(|r| r == root)).collect();
    let obstacles = match options.objects(world, "avoid")? {
        Some(objects) => objects,
        None => still.iter().copied().filter(|o| collides(o) && !own.contains(o)).collect(),
    };
    let links: Vec<usize> = moved.iter().filter_map(|o| mechanism.body(*o).transpose()).collect::<Result<_>>()?;
    let rest: Vec<usize> =
        own.iter().filter(|o| collides(o)).filter_map(|o| mechanism.body(*o).transpose()).collect::<Result<_>>()?;
    let mut within = Vec::new();
    for (i, a) in links.iter().enumerate() {
        for b in links[i + 1..].iter().chain(&rest) {
            if !mechanism.are_neighbours(mechanism.frame_of_body(*a), mechanism.frame_of_body(*b)) {
                within.push([*a, *b]);
            }
        }
    }
    // Links that touch at the start touch by construction.
    let margin = options.get("margin");
    let margin = if margin.is_nil() { Some(0.0) } else { margin.as_f64().filter(|m| (0.0..=1e3).contains(m)) };
    let margin = margin.ok_or_else(|| Fail::argument("option margin: expected a distance of at least 0"))?;
    let poses = mechanism.frames.poses(start);
    within.retain(|pair| !mechanism.is_touching(*pair, &poses));
    let mut pairs = within;
    for object in obstacles {
        if let Some(obstacle) = mechanism.body(object)? {
            for link in links.iter().filter(|l| **l != obstacle) {
                let pair = [*link, obstacle];
                // What the first link touches at the start is what the robot stands on.
                let frame = mechanism.frame_of_body(*link);
                let mounted = mechanism.are_neighbours(frame, None);
                if !mounted || !mechanism.is_touching(pair, &poses) {
                    pairs.push(pair);
                }
            }
        }
    }
    if let Some(extra) = options.get("pairs").numbers() {
        let extra: Vec<[i64; 2]> = extra.as_chunks::<2>().0.iter().map(|p| p.map(|x| x as i64)).collect();
        pairs.extend(pairs_of(world, &mut mechanism, &extra)?);
    }
    Ok((mechanism.checker(&pairs, (margin, &rest), cache), mechanism.shapes))
}

/// Returns the topmost object above an object.
fn root_of(world: &World<'_>, props: &Planning, object: tatu_object) -> Result<tatu_object> {
    let mut at = object;
    loop {
        let parent = world.get(at, props.parent)?.as_object().unwrap_or(0);
        if parent == 0 {
            return Ok(world.look(at)?.id);
        }
        at = world.look(parent)?.id;
    }
}

/// What a call asks for.
struct Request<'a> {
    spaces: Vec<ObjectSpace>,
    space: StateSpace,
    start: Vec<f64>,
    goals: Vec<Vec<f64>>,
    settings: Settings,
    options: Options<'a>,
}

impl<'a> Request<'a> {
    fn new(c: &Ctx<'a>) -> Result<Self> {
        let (world, props, options) = (c.world(), c.plugin(), Options(c.arg(2)));
        let handles = numbers(c, 0)?;
        if handles.is_empty() {
            return Err(Fail::argument("argument 1: expected a table of joints"));
        }
        let mut spaces: Vec<ObjectSpace> = Vec::new();
        for handle in &handles {
            let object = joint("argument 1", object_by_handle(&world, "argument 1", *handle)?)?;
            if spaces.iter().any(|s| s.object == object) {
                return Err(Fail::argument(format!("argument 1: joint {handle} is named twice")));
            }
            spaces.push(joint_space(c, object, 1.0)?);
        }
        // One space for all joints, whose distance is Euclidean, if all have limits.
        let bounded = spaces.iter().all(|s| s.kind == SpaceKind::Joint);
        let space = if bounded {
            let bound = |of: fn(&ObjectSpace) -> &Vec<f64>| spaces.iter().map(|s| of(s)[0]).collect::<Vec<f64>>();
            StateSpace::reals(&bound(|s| &s.low), &bound(|s| &s.high)).map_err(|e| Fail::argument(e.0))?
        } else {
            state_space(&spaces)?
        };
        let start = match options.get("start") {
            v if v.is_nil() => read_state(&world, props, &spaces)?,
            v => checked("option start", v.numbers().unwrap_or_default(), spaces.len())?,
        };
        let mut goals = goals(c, spaces.len())?;
        let seed = options.int("seed", 1, 0, i64::MAX)? as u64;
        let tip = options.objects(&world, "tip").or_else(|_| {
            let handle = options.get("tip").as_f64().ok_or_else(|| Fail::argument("option tip: expected an object"))?;
            object_by_handle(&world, "option tip", handle).map(|o| Some(vec![o.id]))
        })?;
        let pose = options.get("pose");
        match (pose.is_nil(), tip.and_then(|t| t.first().copied())) {
            (true, _) => {}
            (false, None) => return Err(Fail::argument("a pose needs the option tip: the object that shall reach it")),
            (false, Some(tip)) => {
                let numbers = checked("option pose", pose.numbers().unwrap_or_default(), 7)?;
                let pose = pose_of(std::array::from_fn(|i| numbers[i]));
                goals.extend(configurations(&world, props, &spaces, &start, (tip, &pose), seed)?);
            }
        }
        if goals.is_empty() && pose.is_nil() {
            return Err(Fail::argument("there is no goal").help("pass a configuration, or the options tip and pose"));
        }
        // The nearest goal is tried first.
        goals.sort_by(|a, b| space.distance(&start, a).total_cmp(&space.distance(&start, b)));
        let max_checks = options.int("checks", DEFAULT_CHECKS, 1, MAX_CHECKS)? as u64;
        let settings = Settings {
            algorithm: Algorithm::RrtConnect,
            seed,
            max_checks,
            resolution: RESOLUTION,
            ..Settings::default()
        };
        Ok(Request { spaces, space, start, goals, settings, options })
    }
}

fn plan_path(c: &mut Ctx<'_>) -> Result {
    let request = Request::new(c)?;
    let count = request.options.int("states", 0, 0, MAX_STATES)?;
    let found = if request.goals.is_empty() {
        Err("no configuration reaches the pose within the limits".to_owned())
    } else {
        let mut cache = std::mem::take(&mut c.instance().borrow()?.spheres);
        let found = search(&c.world(), c.plugin(), &request, count as usize, &mut cache);
        c.instance().borrow()?.spheres = cache;
        found?
    };
    match found {
        Ok(path) => c.ret(Value::List(path.states.into_iter().map(Value::Floats).collect())),
        Err(reason) => {
            c.ret(Value::Nil);
            c.ret(reason);
        }
    }
    Ok(())
}

/// Searches a path; the inner error is the reason why there is none.
fn search(
    world: &World<'_>,
    props: &Planning,
    request: &Request<'_>,
    count: usize,
    cache: &mut SphereCache,
) -> Result<std::result::Result<Path, String>> {
    let (mut test, shapes) = tester(world, props, &request.spaces, &request.options, &request.start, cache)?;
    let goes_on = || !world.must_return();
    let problem = Problem { space: &request.space, start: &request.start, goal: Goal::States(request.goals.clone()) };
    let mut path = match plan(problem, &request.settings, &mut test, &mut |_| goes_on()) {
        Ok(solution) => solution.path,
        Err(PlanError::Argument(text)) => return Err(Fail::argument(text)),
        Err(reason) => return Ok(Err(explained(world, props, &reason, request, (&mut test, &shapes)))),
    };
    // An interrupted shortening leaves a path that is possible.
    let _ = shorten(&mut path, &request.space, &request.settings, &mut test, &mut |_| goes_on());
    Ok(Ok(divide(&path, &request.space, count)))
}

/// Returns the reason, with the shapes that touch.
fn explained(
    world: &World<'_>,
    props: &Planning,
    reason: &PlanError,
    request: &Request<'_>,
    (test, shapes): (&mut BodyChecker<ExactTest>, &[tatu_object]),
) -> String {
    let (what, state) = match reason {
        PlanError::StartInvalid => ("the start", &request.start),
        PlanError::GoalInvalid => ("the goal", &request.goals[0]),
        _ => return reason.to_string(),
    };
    if !request.space.is_within(state) {
        return format!("{what} is not valid: a joint is beyond its limits");
    }
    let name = |body: usize| {
        let path = shapes.get(body).and_then(|o| world.get(*o, props.path).ok()).and_then(|v| v.as_str());
        path.unwrap_or_default().into_owned()
    };
    match test.touching(state) {
        Some([a, b]) => {
            let how = if request.options.get("margin").is_nil() { "touches" } else { "touches or is too near to" };
            format!("{what} is not valid: `{}` {how} `{}`", name(a), name(b))
        }
        None => reason.to_string(),
    }
}

pub fn offer(offer: &mut Offer<Planning>) {
    offer.command(
        tatu_plugin_api::safe::Command::new("tatu.plan", plan_path)
            .param(Param::floats("joints", 0).text("the joints that may move"))
            .param(Param::any("goals").optional().text("a configuration, or a table of several; nil with a pose"))
            .param(Param::map("options").optional().text("see below"))
            .returns(Param::any("path").text("configurations from the start to a goal, or nil"))
            .returns(Param::string("reason").text("why there is no path"))
            .text("Searches a path of a robot's joints along which its shapes, and what they carry, touch nothing.")
            .notes("Options: `tip` and `pose` (7 numbers, in the world): an object, and where it shall be; `start`: a configuration instead of the present one; `grasped`: objects that move with the last joint; `avoid`: the obstacles instead of all respondable shapes; `pairs`: further pairs as in `simOMPL.setCollisionPairs`; `margin`: the least distance from what stays, m; `states`: least count of configurations; `checks`: the most tests, 200 000; `seed`. Shapes of the robot may not touch each other, except neighbours and those that touch at the start; its first link may touch what it touches at the start. The scene does not change, and the same arguments give the same path."),
    );
}
