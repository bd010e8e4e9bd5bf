//! Commands that describe a task: its state space, what may not touch, start and goals.

use tatu_planning::Algorithm;
use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Fail, Offer, Param, Result, ValueRef},
};

use crate::{
    arguments::{
        callback, check_callback, checked, command, done, handle_of, handle_value, joint, named, numbers, object,
        object_by_handle, object_or_world, state, task,
    },
    constants::{DEFAULT_ALGORITHM, algorithm, space_type},
    spaces::state_space,
    state::{Callback, Ctx, DummyGoal, ObjectSpace, Planning, SpaceKind, Task},
};

/// Turning radius of a car unless a script sets it, m.
const DEFAULT_RADIUS: f64 = 0.05;
const DEFAULT_RESOLUTION: f64 = 0.01;

fn weight(what: &str, value: f64) -> Result<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Fail::argument(format!("{what}: the weight is {value}; expected a number above 0")))
}

fn create_state_space(c: &mut Ctx<'_>) -> Result {
    let number = c.i64(1)?;
    let wrong = || {
        Fail::argument(format!("argument 2: {number} is not a type of a state space"))
            .help("use simOMPL.StateSpaceType")
    };
    let kind = SpaceKind::ALL[space_type(number).ok_or_else(wrong)?];
    let found = object(c, 2)?;
    if kind.is_joint() {
        joint("argument 3", found)?;
    }
    let (low, high) = if kind.bounds() == 0 {
        (Vec::new(), Vec::new())
    } else {
        let bounds = |i: usize| checked(&format!("argument {}, bounds", i + 1), numbers(c, i)?, kind.bounds());
        (bounds(3)?, bounds(4)?)
    };
    let space = ObjectSpace {
        kind,
        object: found.id,
        low,
        high,
        weight: weight("argument 7", if c.has(6) { c.f64(6)? } else { 1.0 })?,
        reference: object_or_world(c, 7)?,
        radius: DEFAULT_RADIUS,
        symmetric: false,
    };
    state_space(std::slice::from_ref(&space))?;
    let handle = c.instance().borrow()?.add_space(space)?;
    c.ret(handle_value(c, "space", handle));
    Ok(())
}

/// Returns the elements of a table of handles.
fn elements(value: ValueRef<'_>) -> Option<Vec<i64>> {
    match value.list() {
        Some(list) => list.iter().map(|v| handle_of(*v)).collect(),
        None => value.numbers().map(|all| all.into_iter().map(|x| x as i64).collect()),
    }
}

fn set_state_space(c: &mut Ctx<'_>) -> Result {
    let handles = elements(c.arg(1)).filter(|h| !h.is_empty());
    let handles = handles.ok_or_else(|| Fail::argument("argument 2: expected a table of state spaces"))?;
    let mut spaces = Vec::new();
    {
        let all = c.instance().borrow()?;
        for handle in handles {
            let missing = || Fail::argument(format!("argument 2: there is no state space {handle}"));
            spaces.push(all.spaces.get(&handle).ok_or_else(missing)?.clone());
        }
    }
    use_spaces(c, spaces)
}

/// Gives a task its state space; what depended on another one is forgotten.
fn use_spaces(c: &mut Ctx<'_>, spaces: Vec<ObjectSpace>) -> Result {
    state_space(&spaces)?;
    {
        let mut task = task(c)?;
        let changed = task.dimension() != spaces.iter().map(|s| s.kind.dimension()).sum::<usize>();
        task.spaces = spaces;
        task.path.clear();
        if changed {
            (task.start, task.goals) = (Vec::new(), Vec::new());
        }
    }
    done(c)
}

fn set_state_space_for_joints(c: &mut Ctx<'_>) -> Result {
    let (handles, weights) = (numbers(c, 1)?, numbers(c, 3)?);
    if handles.is_empty() {
        return Err(Fail::argument("argument 2: expected a table of joints"));
    }
    if !weights.is_empty() && weights.len() != handles.len() {
        let (w, j) = (weights.len(), handles.len());
        return Err(Fail::argument(format!("argument 4: {w} weights for {j} joints; expected as many")));
    }
    let mut spaces = Vec::new();
    for (i, handle) in handles.iter().enumerate() {
        let object = joint("argument 2", object_by_handle(&c.world(), "argument 2", *handle)?)?;
        let own = weight("argument 4", weights.get(i).copied().unwrap_or(1.0))?;
        spaces.push(joint_space(c, object, own)?);
    }
    use_spaces(c, spaces)
}

/// Returns the state space of a joint within its limits.
pub fn joint_space(c: &Ctx<'_>, object: tatu_object, weight: f64) -> Result<ObjectSpace> {
    let (world, props) = (c.world(), c.plugin());
    let cyclic = world.get(object, props.joint_cyclic)?.as_bool().unwrap_or(false);
    let limits = world.get(object, props.joint_limits)?.array::<2>();
    let slides = world.get(object, props.joint_type)?.as_str().as_deref() == Some("prismatic");
    let limits = limits.filter(|[low, high]| !cyclic && low.is_finite() && high.is_finite() && low <= high);
    if slides && limits.is_none() {
        let handle = world.look(object)?.handle();
        return Err(Fail::argument(format!(
            "the sliding joint {handle} has no limits; expected limits to search within"
        )));
    }
    let kind = if limits.is_some() { SpaceKind::Joint } else { SpaceKind::CyclicJoint };
    let (low, high) = limits.map_or((Vec::new(), Vec::new()), |[low, high]| (vec![low], vec![high]));
    let (reference, radius, symmetric) = (None, DEFAULT_RADIUS, false);
    Ok(ObjectSpace { kind, object, low, high, weight, reference, radius, symmetric })
}

fn set_goals(c: &mut Ctx<'_>, adds: bool) -> Result {
    let dimension = task(c)?.dimension();
    let goal = state(c, 1, dimension)?;
    {
        let mut task = task(c)?;
        if !adds {
            task.goals.clear();
        }
        task.goals.push(goal);
        (task.dummy_goal, task.goal_callback) = (None, None);
    }
    done(c)
}

fn set_all_goals(c: &mut Ctx<'_>) -> Result {
    let dimension = task(c)?.dimension();
    let wrong = || Fail::argument("argument 2: expected a table of states");
    let list = c.arg(1).list().filter(|list| !list.is_empty()).ok_or_else(wrong)?;
    let goals: Result<Vec<Vec<f64>>> = list
        .iter()
        .enumerate()
        .map(|(i, v)| checked(&format!("argument 2, state {}", i + 1), v.numbers().ok_or_else(wrong)?, dimension))
        .collect();
    let goals = goals?;
    {
        let mut task = task(c)?;
        (task.goals, task.dummy_goal, task.goal_callback) = (goals, None, None);
    }
    done(c)
}

fn set_dummy_goal(c: &mut Ctx<'_>) -> Result {
    let metric = if c.has(4) { checked("argument 5, a metric", numbers(c, 4)?, 4)? } else { vec![1.0, 1.0, 1.0, 0.1] };
    let tolerance = if c.has(3) { c.f64(3)? } else { 0.001 };
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        return Err(Fail::argument(format!(
            "argument 4: the tolerance is {tolerance}; expected a distance of at least 0"
        )));
    }
    let metric = [metric[0], metric[1], metric[2], metric[3]];
    let goal = DummyGoal { moved: object(c, 1)?.id, target: object(c, 2)?.id, tolerance, metric };
    {
        let mut task = task(c)?;
        (task.goals, task.dummy_goal, task.goal_callback) = (Vec::new(), Some(goal), None);
    }
    done(c)
}

/// Replaces a function of a script, of which the old one is released.
fn replace(c: &mut Ctx<'_>, of: fn(&mut Task) -> &mut Option<Callback>) -> Result {
    // A function is retained only for a task that exists.
    task(c)?;
    let new = callback(c, 1)?;
    let old = std::mem::replace(of(&mut *task(c)?), new);
    if let Some(Callback::Function(function)) = old {
        c.drop_func(function);
    }
    done(c)
}

pub fn offer(offer: &mut Offer<Planning>) {
    spaces(offer);
    goals(offer);
    offer.command(
        named("createTask", |c| {
            let name = if c.has(0) { c.text(0)? } else { String::new() };
            let task = Task { name, algorithm: DEFAULT_ALGORITHM, resolution: DEFAULT_RESOLUTION, ..Task::default() };
            let handle = c.instance().borrow()?.add_task(task)?;
            c.ret(handle_value(c, "task", handle));
            Ok(())
        })
        .param(Param::string("name").optional())
        .returns(Param::any("task").text("a number for scripts before 4.2, a text since"))
        .text("Creates a planning task."),
    );
    offer.command(
        command("destroyTask", |c| {
            task(c)?;
            let handle = handle_of(c.arg(0)).unwrap_or(0);
            let old = c.instance().borrow()?.tasks.remove(&handle);
            for callback in old.into_iter().flat_map(|t| [t.validation, t.goal_callback]).flatten() {
                if let Callback::Function(function) = callback {
                    c.drop_func(function);
                }
            }
            done(c)
        })
        .text("Removes a planning task."),
    );
    offer.command(
        command("setAlgorithm", |c| {
            let number = c.i64(1)?;
            let unknown = || Fail::argument(format!("argument 2: {number} is not an algorithm")).help("use simOMPL.Algorithm");
            match algorithm(number).ok_or_else(unknown)? {
                Ok(_) => task(c)?.algorithm = number,
                Err(name) => return Err(Fail::unsupported(format!("argument 2: the algorithm {name} is not supported"))),
            }
            done(c)
        })
        .param(Param::int("algorithm").text("of `simOMPL.Algorithm`"))
        .text("Chooses the algorithm of a task; default: KPIECE1.")
        .partial("RRTConnect, RRT, RRTstar, PRM and PRMstar are what they say. BiTRRT and those of KPIECE and SBL are solved by RRTConnect; EST, LazyRRT, PDST, STRIDE, TRRT by RRT; BITstar, CForest, FMT, LBTRRT by RRTstar; LazyPRM and SPARS by PRM; LazyPRMstar by PRMstar."),
    );
    offer.command(
        command("setCollisionPairs", |c| {
            let handles: Vec<i64> = numbers(c, 1)?.into_iter().map(|x| x as i64).collect();
            let pairs = handles.as_chunks::<2>().0.iter().copied().filter(|p| p[0] >= 0).collect();
            task(c)?.pairs = pairs;
            done(c)
        })
        .param(Param::floats("pairs", 0).text("handles of objects or collections, two for each pair; the second may be sim.handle_all"))
        .text("Sets which entities may not touch. Without pairs, every state is possible.")
        .notes("A collection paired with itself: its objects may not touch each other, except neighbours in a chain. Pairs whose first handle is negative are left out."),
    );
    offer.command(
        command("setStateValidityCheckingResolution", |c| {
            let resolution = c.f64(1)?;
            if !(resolution > 0.0 && resolution <= 1.0) {
                return Err(Fail::argument(format!(
                    "argument 2: the resolution is {resolution}; expected a share from 0 to 1"
                )));
            }
            task(c)?.resolution = resolution;
            done(c)
        })
        .param(Param::float("resolution").default(DEFAULT_RESOLUTION))
        .text("Sets the largest motion between two tests, as a share of the extent of the state space."),
    );
    offer.command(
        command("setStateValidationCallback", |c| replace(c, |t| &mut t.validation))
            .param(Param::any("callback").text("a function of a state that returns whether it is possible, or its name; nil: the collision pairs decide"))
            .text("Sets the function that tests states, instead of the collision pairs."),
    );
    offer.command(
        command("setProjectionEvaluationCallback", |c| {
            check_callback(c, 1)?;
            task(c)?.projection = c.i64(2)?.clamp(0, 1000) as usize;
            done(c)
        })
        .param(Param::any("callback"))
        .param(Param::int("size"))
        .text("Accepts a projection of states.")
        .partial("The planners need no projection; the function is not called."),
    );
    offer.command(
        command("setValidStateSamplerCallback", |c| {
            task(c)?;
            check_callback(c, 1)?;
            check_callback(c, 2)?;
            done(c)
        })
        .param(Param::any("sampler"))
        .param(Param::any("near").optional())
        .text("Accepts functions that return possible states.")
        .partial("The planners sample uniformly; the functions are not called."),
    );
}

fn spaces(offer: &mut Offer<Planning>) {
    offer.command(
        named("createStateSpace", create_state_space)
            .param(Param::string("name"))
            .param(Param::int("type").text("of `simOMPL.StateSpaceType`"))
            .param(Param::int("object").text("the object or joint that a state moves"))
            .param(Param::floats("low", 0).text("bounds of the position, m or rad; none for a cyclic joint"))
            .param(Param::floats("high", 0))
            .param(Param::any("useForProjection").optional())
            .param(Param::float("weight").default(1.0))
            .param(Param::int("reference").default(-1_i64).text("the object relative to which poses are; -1: the world"))
            .returns(Param::any("space").text("a number for scripts before 4.2, a text since"))
            .text("Creates a part of a state space.")
            .notes("Numbers of a state: position2d x y; pose2d and dubins x y yaw; position3d x y z; pose3d x y z qx qy qz qw; joint 1. What a state does not contain stays."),
    );
    offer.command(
        named("destroyStateSpace", |c| {
            let handle = handle_of(c.arg(0)).unwrap_or(0);
            let old = c.instance().borrow()?.spaces.remove(&handle);
            old.ok_or_else(|| Fail::argument(format!("argument 1: there is no state space {handle}")))?;
            done(c)
        })
        .param(Param::any("space"))
        .text("Removes a part of a state space; tasks that use it are not affected."),
    );
    offer.command(
        named("setDubinsParams", |c| {
            let handle = handle_of(c.arg(0)).unwrap_or(0);
            let (radius, symmetric) = (c.f64(1)?, c.arg(2).truthy());
            if !(radius.is_finite() && radius > 0.0) {
                return Err(Fail::argument(format!(
                    "argument 2: the turning radius is {radius}; expected a length above 0"
                )));
            }
            {
                let mut all = c.instance().borrow()?;
                let missing = || Fail::argument(format!("argument 1: there is no state space {handle}"));
                let space = all.spaces.get_mut(&handle).ok_or_else(missing)?;
                (space.radius, space.symmetric) = (radius, symmetric);
            }
            done(c)
        })
        .param(Param::any("space"))
        .param(Param::float("radius").unit("m").default(DEFAULT_RADIUS))
        .param(Param::bool("symmetric").text("whether it may also drive backward"))
        .text("Sets the turning radius of a car, before its space is given to a task."),
    );
    offer.command(
        command("setStateSpace", set_state_space)
            .param(Param::list("spaces"))
            .text("Sets the parts of a task's state space. Their numbers follow one another in states."),
    );
    offer.command(
        command("setStateSpaceForJoints", set_state_space_for_joints)
            .param(Param::floats("joints", 0))
            .param(Param::any("useForProjection").optional())
            .param(Param::floats("weights", 0).optional())
            .text("Sets the state space of a task to the positions of joints, within their limits."),
    );
}

fn goals(offer: &mut Offer<Planning>) {
    offer.command(
        command("setStartState", |c| {
            let dimension = task(c)?.dimension();
            let start = state(c, 1, dimension)?;
            task(c)?.start = start;
            done(c)
        })
        .param(Param::floats("state", 0))
        .text("Sets where the path begins."),
    );
    offer.command(
        command("setGoalState", |c| set_goals(c, false))
            .param(Param::floats("state", 0))
            .text("Sets where the path ends; other goals are removed."),
    );
    offer.command(
        command("addGoalState", |c| set_goals(c, true))
            .param(Param::floats("state", 0))
            .text("Adds a state where the path may end."),
    );
    offer.command(
        command("setGoalStates", set_all_goals)
            .param(Param::list("states"))
            .text("Sets several states where the path may end."),
    );
    offer.command(
        command("setGoal", set_dummy_goal)
            .param(Param::int("robotDummy"))
            .param(Param::int("goalDummy"))
            .param(Param::float("tolerance").default(0.001))
            .param(Param::floats("metric", 4).optional().text("weights of x, y, z and the angle; default 1 1 1 0.1"))
            .param(Param::int("reference").optional())
            .text("Sets the goal: states for which two dummies are near each other.")
            .notes("A single tree (RRT) searches such goals."),
    );
    offer.command(
        command("setGoalCallback", |c| replace(c, |t| &mut t.goal_callback))
            .param(
                Param::any("callback")
                    .text("a function of a state that returns whether it is a goal, and the distance"),
            )
            .text("Sets the function that recognizes goals.")
            .notes("A single tree (RRT) searches such goals."),
    );
}

/// Returns the planner of a task.
pub fn planner(task: &Task) -> Algorithm {
    algorithm(task.algorithm).and_then(std::result::Result::ok).unwrap_or_default()
}
