//! Commands that solve groups, and copy joint positions between an environment and the scene.

use tatu_kinematics::{FrameId, IkGroup, IkOutcome, IkResult, solve};
use tatu_plugin_api::safe::{Fail, Offer, Param, Result, Value};

use crate::{
    arguments::command,
    constants::{CALC_LIMIT_HIT, CALC_NOT_PERFORMED, CALC_NOT_WITHIN_TOLERANCE, CALC_STEPS_TOO_BIG},
    environment::{Ctx, Environment, Ik, environment},
    methods::result_number,
};

/// Handle that stands for all groups.
const HANDLE_ALL: i64 = -2;

/// Returns the handles of the groups in argument 2: a handle, a table of handles, or [`HANDLE_ALL`].
fn groups(c: &Ctx<'_>, environment: &mut Environment) -> Result<Vec<i64>> {
    let handles: Vec<i64> = match c.arg(1).as_i64() {
        Some(HANDLE_ALL) => environment.groups.keys().copied().collect(),
        Some(handle) => vec![handle],
        None => {
            let wrong = || Fail::argument("argument 2: expected a group, a table of groups, or `simIK.handle_all`");
            c.arg(1).numbers().ok_or_else(wrong)?.into_iter().map(|x| x as i64).collect()
        }
    };
    for handle in &handles {
        environment.group(*handle)?;
    }
    Ok(handles)
}

/// Returns the joints that groups move, and all joints that depend on them.
fn joints_of(environment: &Environment, groups: &[i64]) -> Vec<FrameId> {
    let tasks = groups.iter().filter_map(|g| environment.groups.get(g)).flat_map(|g| g.group.tasks.clone());
    environment.copy.joints_of(&tasks.collect::<Vec<_>>())
}

/// Copies joint positions, and the poses of bases and targets, from the scene to the environment.
fn take(c: &Ctx<'_>, environment: &mut Environment) -> Result {
    let tasks = environment.groups.values().flat_map(|g| &g.group.tasks);
    let targets: Vec<FrameId> = tasks.map(|t| t.target).collect();
    environment.copy.take_from_scene(&c.world(), &c.plugin().props, &targets)
}

/// Moves the joints of groups in the scene to their positions in the environment.
fn give(c: &Ctx<'_>, environment: &Environment, groups: &[i64]) -> Result {
    environment.copy.give_to_scene(&c.world(), &c.plugin().props, &joints_of(environment, groups))
}

/// Solves groups in order of priority, and stores the joints that reached a limit.
fn solve_groups(environment: &mut Environment, handles: &[i64]) -> IkOutcome {
    let groups: Vec<IkGroup> =
        handles.iter().filter_map(|handle| environment.groups.get(handle)).map(|g| g.group.clone()).collect();
    let outcome = solve(&mut environment.copy.linkage, &groups.iter().collect::<Vec<_>>());
    for handle in handles {
        if let Some(group) = environment.groups.get_mut(handle) {
            group.limit_hits.clone_from(&outcome.limit_hits);
        }
    }
    outcome
}

fn flags(outcome: &IkOutcome) -> i64 {
    let all = [
        (outcome.result == IkResult::NotPerformed, CALC_NOT_PERFORMED),
        (outcome.result == IkResult::Fail, CALC_NOT_WITHIN_TOLERANCE),
        (outcome.was_shortened, CALC_STEPS_TOO_BIG),
        (!outcome.limit_hits.is_empty(), CALC_LIMIT_HIT),
    ];
    all.iter().filter(|(is_set, _)| *is_set).map(|(_, flag)| flag).sum()
}

/// Solves the groups in argument 2. With the option `syncWorlds`, positions are copied from the scene before, and to
/// the scene afterwards.
fn handle(c: &mut Ctx<'_>) -> Result {
    let options = c.arg(2);
    let has = |key: &str| options.get(key).is_some_and(|v| v.truthy());
    if has("callback") {
        return Err(Fail::unsupported("simIK.handleGroups does not support the option `callback`")
            .help("compute the step from `simIK.computeGroupJacobian`"));
    }
    let outcome = {
        let mut environment = environment(c)?;
        let handles = groups(c, &mut environment)?;
        if has("syncWorlds") {
            take(c, &mut environment)?;
        }
        let outcome = solve_groups(&mut environment, &handles);
        if has("syncWorlds") && (outcome.result == IkResult::Success || has("allowError")) {
            give(c, &environment, &handles)?;
        }
        outcome
    };
    c.ret(result_number(outcome.result));
    c.ret(flags(&outcome));
    c.ret(outcome.precision);
    Ok(())
}

pub fn offer(offer: &mut Offer<Ik>) {
    let results = |command: tatu_plugin_api::safe::Command<Ik>| {
        command
            .param(Param::map("options").optional().text("`syncWorlds`, `allowError`"))
            .returns(Param::int("result").text("a constant, such as `simIK.result_success`"))
            .returns(Param::int("flags").text("a sum of constants, such as `simIK.calc_limithit`"))
            .returns(Param::floats("precision", 2).text("the largest distance, m, and angle, rad"))
            .notes(
                "With `syncWorlds`, positions are taken from the scene before, and given to it after a success, or in \
                 any case with `allowError`.",
            )
    };
    offer.command(
        results(command("handleGroup", handle).alias("simIK.handleIkGroup").param(Param::any("group")))
            .text("Moves the joints of a group until its tips reach their targets or the maximum number of iterations is reached."),
    );
    offer.command(
        results(command("handleGroups", handle).param(Param::any("groups").text("in order of priority")))
            .text("Solves several groups: later ones use only motions that do not disturb earlier ones."),
    );
    offer.command(
        command("syncFromSim", |c| {
            let mut environment = environment(c)?;
            if c.has(1) {
                groups(c, &mut environment)?;
            }
            take(c, &mut environment)
        })
        .alias("simIK.applySceneToIkEnvironment")
        .param(Param::any("groups").optional())
        .text("Copies the positions of joints, and the poses of bases and targets, from the scene."),
    );
    offer.command(
        command("syncToSim", |c| {
            let mut environment = environment(c)?;
            let handles = groups(c, &mut environment)?;
            give(c, &environment, &handles)
        })
        .param(Param::any("groups"))
        .text(
            "Moves the joints of the scene to the positions of their copies: dynamic ones by their target positions.",
        ),
    );
    offer.command(
        command("applyIkEnvironmentToScene", |c| {
            let outcome = {
                let mut environment = environment(c)?;
                let handles = groups(c, &mut environment)?;
                take(c, &mut environment)?;
                let outcome = solve_groups(&mut environment, &handles);
                if outcome.result == IkResult::Success || !c.arg(2).truthy() {
                    give(c, &environment, &handles)?;
                }
                outcome
            };
            c.ret(Value::Int(result_number(outcome.result)));
            Ok(())
        })
        .param(Param::any("group"))
        .param(Param::bool("only_after_success").default(false))
        .returns(Param::int("result"))
        .text("Copies positions from the scene, solves a group, and moves the joints of the scene."),
    );
}
