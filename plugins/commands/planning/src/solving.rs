//! Commands that solve a task, and commands on the path that was found.

use std::cell::RefCell;

use tatu_planning::{Path, PlanError, Problem, Settings, StateSpace, divide, divide_by_resolution, plan, shorten};
use tatu_plugin_api::{
    abi::TATU_LOG_WARNING,
    safe::{Fail, Offer, Param, Result, Value},
};

use crate::{
    arguments::{command, done, numbers, task, version},
    spaces::state_space,
    state::{Ctx, Planning, Task},
    tasks::planner,
    test::{ScriptTest, StateTest, body_test, goal_of},
};

/// Tests per second of the time that a script allows, of bodies and by functions of the script: work is counted instead
/// of time, so that results are the same in every run.
const CHECKS_PER_S: f64 = 50_000.0;
const CALLS_PER_S: f64 = 2000.0;
const MIN_CHECKS: u64 = 1000;
const MAX_CHECKS: u64 = 2_000_000;
/// Tests for shortening if the script sets no time.
const SHORTENING_CHECKS: u64 = 50_000;
const SHORTENING_CALLS: u64 = 5000;
/// Maximum count of states of a path.
const MAX_STATES: i64 = 1_000_000;

/// Returns the budget for a time, s.
fn budget(task: &Task, time: f64) -> u64 {
    let rate = if task.validation.is_some() { CALLS_PER_S } else { CHECKS_PER_S };
    ((time.max(0.0) * rate) as u64).clamp(MIN_CHECKS, MAX_CHECKS)
}

/// Reads a time, s, or `None` if it is missing or negative.
fn time(c: &Ctx<'_>, i: usize) -> Result<Option<f64>> {
    if !c.has(i) {
        return Ok(None);
    }
    let time = c.f64(i)?;
    if time.is_nan() {
        return Err(Fail::argument(format!("argument {}: the time is not a number; expected seconds", i + 1)));
    }
    Ok((time >= 0.0).then_some(time))
}

/// Runs work with the test of a task, and with the script's test of goals.
pub fn with_test<R>(
    c: &mut Ctx<'_>,
    task: &Task,
    work: impl FnOnce(&mut StateTest<'_, '_, '_>, Option<&ScriptTest<'_, '_, '_>>, &dyn Fn() -> bool) -> Result<R>,
) -> Result<R> {
    let (world, props) = (c.world(), c.plugin());
    let bodies = if task.validation.is_some() {
        StateTest::Anything
    } else {
        let mut cache = std::mem::take(&mut c.instance().borrow()?.spheres);
        let bodies = body_test(&world, props, task, &mut cache);
        c.instance().borrow()?.spheres = cache;
        bodies?
    };
    let (call, error) = (RefCell::new(c), RefCell::new(None));
    let script =
        |callback: &Option<_>| callback.clone().map(|callback| ScriptTest { call: &call, callback, error: &error });
    let (validation, goal) = (script(&task.validation), script(&task.goal_callback));
    let mut test = validation.as_ref().map_or(bodies, StateTest::Script);
    let goes_on = || !world.must_return() && error.borrow().is_none();
    let result = work(&mut test, goal.as_ref(), &goes_on);
    let error = error.borrow_mut().take();
    error.map_or(result, Err)
}

fn settings(task: &Task, seed: u64, max_checks: u64) -> Settings {
    Settings { algorithm: planner(task), seed, max_checks, resolution: task.resolution, ..Settings::default() }
}

/// Searches a path for the task that argument 1 names, and stores it. Returns whether there is one, at least to a state
/// nearer to the goal.
fn solve(c: &mut Ctx<'_>, seconds: f64) -> Result<bool> {
    let task = task(c)?.clone();
    let space = state_space(&task.spaces)?;
    let missing = |what: &str, help: &str| Err(Fail::argument(format!("the task has no {what}")).help(help));
    if task.start.is_empty() {
        return missing("start state", "call simOMPL.setStartState first");
    }
    if task.goals.is_empty() && task.dummy_goal.is_none() && task.goal_callback.is_none() {
        return missing("goal", "call simOMPL.setGoalState first");
    }
    let seed = {
        let mut state = c.instance().borrow()?;
        state.searches += 1;
        state.searches
    };
    let settings = settings(&task, seed, budget(&task, seconds));
    let (world, props) = (c.world(), c.plugin());
    let found = with_test(c, &task, |test, goal, goes_on| {
        let goal = goal_of(&world, props, &task, goal)?;
        let problem = Problem { space: &space, start: &task.start, goal };
        Ok(plan(problem, &settings, test, &mut |_| goes_on()))
    })?;
    let (path, exact, distance) = match found {
        Ok(solution) => (solution.path, true, 0.0),
        Err(PlanError::NotFound { nearest: Some((path, distance)), .. }) => (path, false, distance),
        Err(PlanError::Argument(text)) => return Err(Fail::argument(text)),
        Err(reason) => {
            world.log(TATU_LOG_WARNING, format!("planning task `{}`: {reason}", task.name).as_bytes());
            (Path::default(), false, -1.0)
        }
    };
    let mut task = self::task(c)?;
    // The start alone is no path.
    task.path = if exact || path.states.len() > 1 { path.states } else { Vec::new() };
    (task.exact, task.distance) = (exact, distance);
    Ok(!task.path.is_empty())
}

/// Shortens the path of a task; `None`: as far as it goes.
fn simplify(c: &mut Ctx<'_>, seconds: Option<f64>) -> Result {
    let task = task(c)?.clone();
    let space = state_space(&task.spaces)?;
    let all = if task.validation.is_some() { SHORTENING_CALLS } else { SHORTENING_CHECKS };
    let settings = settings(&task, 1, seconds.map_or(all, |s| budget(&task, s)));
    let mut path = Path { states: task.path.clone() };
    with_test(c, &task, |test, _, goes_on| {
        // A path that was shortened in part is possible, too.
        shorten(&mut path, &space, &settings, test, &mut |_| goes_on()).or(Ok(0))
    })?;
    self::task(c)?.path = path.states;
    Ok(())
}

/// Divides the path of a task: 0: by the resolution.
fn interpolate(c: &mut Ctx<'_>, count: i64) -> Result {
    if count > MAX_STATES {
        return Err(Fail::argument(format!("{count} states; expected at most {MAX_STATES}")));
    }
    let mut task = task(c)?;
    if task.path.is_empty() {
        return Ok(());
    }
    let space: StateSpace = state_space(&task.spaces)?;
    let path = Path { states: std::mem::take(&mut task.path) };
    let divided = match usize::try_from(count) {
        Ok(count) if count > 0 => divide(&path, &space, count),
        _ => divide_by_resolution(&path, &space, task.resolution),
    };
    task.path = divided.states;
    Ok(())
}

fn count(c: &Ctx<'_>, i: usize) -> Result<i64> {
    if c.has(i) { c.i64(i) } else { Ok(0) }
}

fn compute(c: &mut Ctx<'_>) -> Result {
    let (seconds, simplification, states) = (time(c, 1)?.unwrap_or(0.0), time(c, 2)?, count(c, 3)?);
    let solved = solve(c, seconds)?;
    if solved {
        simplify(c, simplification)?;
        interpolate(c, states)?;
    }
    if version(c) < (3, 5) {
        c.ret(i64::from(solved));
    } else {
        c.ret(solved);
    }
    let path = task(c)?.path.concat();
    c.ret(path);
    Ok(())
}

/// Reads a flat path of a task: its states one after another.
fn flat_path(c: &Ctx<'_>, i: usize, dimension: usize) -> Result<Vec<f64>> {
    let path = numbers(c, i)?;
    if dimension == 0 || !path.len().is_multiple_of(dimension) {
        let text =
            format!("argument {}: {} numbers; expected a multiple of {dimension}, those of a state", i + 1, path.len());
        return Err(Fail::argument(text));
    }
    Ok(path)
}

pub fn offer(offer: &mut Offer<Planning>) {
    offer.command(
        command("setup", |c| {
            let task = task(c)?.clone();
            state_space(&task.spaces)?;
            done(c)
        })
        .text("Checks that a task has a state space.")
        .notes("A task that has not been set up is set up when it is solved."),
    );
    offer.command(
        command("compute", compute)
            .param(Param::float("time").unit("s"))
            .param(Param::float("simplification").unit("s").default(-1.0).text("-1: as far as it goes"))
            .param(Param::int("states").default(0_i64).text("least count of states; 0: by the resolution"))
            .returns(Param::any("solved").text("a boolean; before 3.5: 1 or 0"))
            .returns(Param::floats("states", 0).text("from the start to the goal, one after another; empty if there is none"))
            .text("Solves a task, simplifies and divides the path, and returns it.")
            .notes("Solved is also a path to the state nearest to the goal: see `hasExactSolution`. Work is counted instead of time, so that every run finds the same: 50 000 tests per second, or 2000 calls of the script's function. The scene does not change."),
    );
    offer.command(
        command("solve", |c| {
            let seconds = time(c, 1)?.unwrap_or(0.0);
            let solved = solve(c, seconds)?;
            c.ret(solved);
            Ok(())
        })
        .param(Param::float("time").unit("s"))
        .returns(Param::bool("solved"))
        .text("Searches a path."),
    );
    offer.command(
        command("simplifyPath", |c| {
            let seconds = time(c, 1)?;
            simplify(c, seconds)?;
            done(c)
        })
        .param(Param::float("time").unit("s").default(-1.0).text("-1: as far as it goes"))
        .text("Shortens the path that was found."),
    );
    offer.command(
        command("interpolatePath", |c| {
            let states = count(c, 1)?;
            interpolate(c, states)?;
            done(c)
        })
        .param(Param::int("states").default(0_i64).text("least count of states; 0: by the resolution"))
        .text("Divides the path that was found."),
    );
    offer.command(
        command("getPath", |c| {
            let path = task(c)?.path.concat();
            c.ret(path);
            Ok(())
        })
        .returns(Param::floats("states", 0))
        .text("Returns the path that was found: its states one after another."),
    );
    offer.command(
        command("hasExactSolution", |c| {
            let exact = task(c)?.exact;
            c.ret(exact);
            Ok(())
        })
        .returns(Param::bool("exact"))
        .text("Returns whether the path reaches the goal."),
    );
    offer.command(
        command("hasApproximateSolution", |c| {
            let approximate = {
                let task = task(c)?;
                !task.exact && !task.path.is_empty()
            };
            c.ret(approximate);
            Ok(())
        })
        .returns(Param::bool("approximate"))
        .text("Returns whether the path ends at a state that is only near the goal."),
    );
    offer.command(
        command("getGoalDistance", |c| {
            let distance = {
                let task = task(c)?;
                if task.path.is_empty() { -1.0 } else { task.distance }
            };
            c.ret(distance);
            Ok(())
        })
        .returns(Param::float("distance"))
        .text("Returns the distance of the path's end from the goal; -1 without a path."),
    );
    offer.command(
        command("getPathStateCount", |c| {
            let dimension = task(c)?.dimension();
            let path = flat_path(c, 1, dimension)?;
            c.ret((path.len() / dimension) as i64);
            Ok(())
        })
        .param(Param::floats("path", 0))
        .returns(Param::int("count"))
        .text("Returns the count of states of a path."),
    );
    offer.command(
        command("getPathState", |c| {
            let dimension = task(c)?.dimension();
            let (path, index) = (flat_path(c, 1, dimension)?, c.i64(2)?);
            let count = (path.len() / dimension) as i64;
            let at = if index < 0 { count.saturating_add(index) } else { index - 1 };
            let wrong = || Fail::argument(format!("argument 3: there is no state {index}; the path has {count}"));
            let at = usize::try_from(at).ok().filter(|at| (*at as i64) < count).ok_or_else(wrong)?;
            c.ret(&path[at * dimension..(at + 1) * dimension]);
            Ok(())
        })
        .param(Param::floats("path", 0))
        .param(Param::int("index").text("from 1; negative: from the end"))
        .returns(Param::floats("state", 0))
        .text("Returns a state of a path."),
    );
    offer.command(
        command("getReversedPath", |c| {
            let dimension = task(c)?.dimension();
            let path = flat_path(c, 1, dimension)?;
            c.ret(path.chunks(dimension).rev().flatten().copied().collect::<Vec<f64>>());
            Ok(())
        })
        .param(Param::floats("path", 0))
        .returns(Param::floats("reversed", 0))
        .text("Returns a path from its end to its start."),
    );
    offer.command(
        command("getPlannerData", |c| {
            task(c)?;
            c.ret(Value::List(Vec::new()));
            Ok(())
        })
        .returns(Param::any("states"))
        .text("Returns nothing.")
        .stub("The trees of a search are not stored."),
    );
}
