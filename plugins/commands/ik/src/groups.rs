//! Commands that create groups, and set and return their properties.

use tatu_kinematics::{IkGroup, IkMethod};
use tatu_plugin_api::safe::{Command, Fail, Offer, Param, Result};

use crate::{
    arguments::{command, handle_of, number},
    constants::{
        FLAG_AVOID_LIMITS, FLAG_ENABLED, FLAG_IGNORE_MAX_STEPS, FLAG_RESTORE_ON_ANGLE, FLAG_RESTORE_ON_DISTANCE,
        FLAG_STOP_AT_LIMIT,
    },
    environment::{Ctx, Ik, NamedGroup, environment},
    methods::{BUILT_IN_DAMPING, MAX_ITERATIONS, method},
};

/// Builds a command whose parameters begin with an environment and a group.
pub fn group_command(name: &str, run: impl Fn(&mut Ctx<'_>) -> Result + Send + Sync + 'static) -> Command<Ik> {
    command(name, run).param(Param::int("group"))
}

pub fn offer(offer: &mut Offer<Ik>) {
    offer.command(
        command("createGroup", |c| {
            let name = c.has(1).then(|| c.text(1)).transpose()?.unwrap_or_default();
            let made = {
                let mut environment = environment(c)?;
                environment.check_room()?;
                let made = environment.next_handle();
                let group =
                    IkGroup { method: IkMethod::DampedLeastSquares, damping: BUILT_IN_DAMPING, ..IkGroup::default() };
                environment.groups.insert(made, NamedGroup { name, group, ..NamedGroup::default() });
                made
            };
            c.ret(made);
            Ok(())
        })
        .alias("simIK.createIkGroup")
        .param(Param::string("name").optional())
        .returns(Param::int("group"))
        .text("Creates a group without elements: pseudo-inverse with 3 iterations."),
    );
    offer.command(
        command("getGroupHandle", |c| {
            let name = c.text(1)?;
            let found = environment(c)?.groups.iter().find(|(_, g)| g.name == name).map(|(handle, _)| *handle);
            c.ret(found.ok_or_else(|| Fail::argument(format!("there is no group `{name}` in the environment")))?);
            Ok(())
        })
        .alias("simIK.getIkGroupHandle")
        .param(Param::string("name"))
        .returns(Param::int("group"))
        .text("Returns the group with the given name."),
    );
    offer.command(
        command("doesGroupExist", |c| {
            let name = c.arg(1).as_str();
            let exists = {
                let environment = environment(c)?;
                match name {
                    Some(name) => environment.groups.values().any(|g| g.name == name),
                    None => environment.groups.contains_key(&c.i64(1)?),
                }
            };
            c.ret(exists);
            Ok(())
        })
        .alias("simIK.doesIkGroupExist")
        .param(Param::any("group").text("a handle or a name"))
        .returns(Param::bool("exists"))
        .text("Returns whether a group exists."),
    );
    calculation(offer);
    flags(offer);
    offer.command(
        group_command("getGroupJoints", |c| {
            let joints: Vec<i64> = {
                let mut environment = environment(c)?;
                let tasks = environment.group(c.i64(1)?)?.group.tasks.clone();
                let jacobian = tatu_kinematics::group_jacobian(&environment.copy.linkage, &tasks);
                jacobian.columns.iter().map(|column| handle_of(column.joint)).collect()
            };
            c.ret(joints);
            Ok(())
        })
        .returns(Param::ints("joints", 0))
        .text("Returns the joints that a group moves, from base to tip: one entry per degree of freedom."),
    );
    offer.command(
        group_command("getGroupJointLimitHits", |c| {
            let (joints, by): (Vec<i64>, Vec<f64>) = {
                let mut environment = environment(c)?;
                let hits = &environment.group(c.i64(1)?)?.limit_hits;
                hits.iter().map(|hit| (handle_of(hit.joint), hit.excess)).unzip()
            };
            c.ret(joints);
            c.ret(by);
            Ok(())
        })
        .returns(Param::ints("joints", 0))
        .returns(Param::floats("by", 0))
        .text("Returns the joints that the last calculation left at a limit, and by how much they would exceed it."),
    );
}

fn calculation(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("setGroupCalculation", |c| {
            let (number_of_method, damping, iterations) = (c.i64(2)?, number(c, 3)?, c.i64(4)?);
            if !(0..4).contains(&number_of_method) {
                return Err(Fail::argument(format!(
                    "argument 3: expected a method such as `simIK.method_pseudo_inverse`, found {number_of_method}"
                )));
            }
            if damping < 0.0 {
                return Err(Fail::argument(format!("argument 4: expected a damping of at least 0, found {damping}")));
            }
            let iterations = u32::try_from(iterations).ok().filter(|n| *n <= MAX_ITERATIONS);
            let wrong = || Fail::argument(format!("argument 5: expected 0 to {MAX_ITERATIONS} iterations"));
            let mut environment = environment(c)?;
            let group = &mut environment.group(c.i64(1)?)?.group;
            group.max_iterations = iterations.ok_or_else(wrong)?;
            (group.method, group.damping) = method(number_of_method, damping);
            Ok(())
        })
        .alias("simIK.setIkGroupCalculation")
        .param(Param::int("method").text("a constant, such as `simIK.method_damped_least_squares`"))
        .param(Param::float("damping"))
        .param(Param::int("iterations"))
        .text("Sets the solver method of a group; only damped least squares uses the damping."),
    );
    offer.command(
        group_command("getGroupCalculation", |c| {
            let (method, damping, iterations) = {
                let mut environment = environment(c)?;
                let group = &environment.group(c.i64(1)?)?.group;
                (group.method, group.damping, group.max_iterations)
            };
            let is_built_in = method == IkMethod::DampedLeastSquares && damping == BUILT_IN_DAMPING;
            let number = match method {
                _ if is_built_in => 0,
                IkMethod::DampedLeastSquares => 1,
                IkMethod::JacobianTranspose => 2,
                IkMethod::PseudoInverse => 3,
            };
            c.ret(number);
            c.ret(if is_built_in { 0.0 } else { damping });
            c.ret(i64::from(iterations));
            Ok(())
        })
        .alias("simIK.getIkGroupCalculation")
        .returns(Param::int("method"))
        .returns(Param::float("damping"))
        .returns(Param::int("iterations"))
        .text("Returns the solver method of a group, its damping, and its maximum number of iterations."),
    );
}

fn flags(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("setGroupFlags", |c| {
            let flags = c.i64(2)?;
            let has = |flag: i64| flags & flag != 0;
            let mut environment = environment(c)?;
            let group = &mut environment.group(c.i64(1)?)?.group;
            group.enabled = has(FLAG_ENABLED);
            group.ignores_max_steps = has(FLAG_IGNORE_MAX_STEPS);
            group.restores = [has(FLAG_RESTORE_ON_DISTANCE), has(FLAG_RESTORE_ON_ANGLE)];
            group.stops_at_limits = has(FLAG_STOP_AT_LIMIT);
            group.keeps_limits = has(FLAG_AVOID_LIMITS);
            Ok(())
        })
        .alias("simIK.setIkGroupFlags")
        .param(Param::int("flags").text("a sum of constants, such as `simIK.group_enabled`"))
        .text("Sets whether a group is enabled, ignores the largest steps of joints, restores joints after a failure, stops at limits and avoids them."),
    );
    offer.command(
        group_command("getGroupFlags", |c| {
            let flags: i64 = {
                let mut environment = environment(c)?;
                let group = &environment.group(c.i64(1)?)?.group;
                let all = [
                    (group.enabled, FLAG_ENABLED),
                    (group.ignores_max_steps, FLAG_IGNORE_MAX_STEPS),
                    (group.restores[0], FLAG_RESTORE_ON_DISTANCE),
                    (group.restores[1], FLAG_RESTORE_ON_ANGLE),
                    (group.stops_at_limits, FLAG_STOP_AT_LIMIT),
                    (group.keeps_limits, FLAG_AVOID_LIMITS),
                ];
                all.iter().filter(|(is_set, _)| *is_set).map(|(_, flag)| flag).sum()
            };
            c.ret(flags);
            Ok(())
        })
        .alias("simIK.getIkGroupFlags")
        .returns(Param::int("flags"))
        .text("Returns the flags of a group."),
    );
}
