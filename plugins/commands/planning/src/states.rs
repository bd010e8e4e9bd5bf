//! Commands on states: reading and writing them, tests, distances; and commands that draw and print.

use tatu_planning::Validity;
use tatu_plugin_api::{
    abi::TATU_LOG_INFO,
    safe::{Offer, Param, Value},
};

use crate::{
    arguments::{command, done, state, task, version},
    solving::with_test,
    spaces::{read_state, state_space, write_state},
    state::Planning,
};

pub fn offer(offer: &mut Offer<Planning>) {
    let given = || Param::floats("state", 0);
    offer.command(
        command("readState", |c| {
            let spaces = task(c)?.spaces.clone();
            let state = read_state(&c.world(), c.plugin(), &spaces)?;
            c.ret(state);
            Ok(())
        })
        .returns(given())
        .text("Returns the state in which the objects of the scene are."),
    );
    offer.command(
        command("writeState", |c| {
            let spaces = task(c)?.spaces.clone();
            let state = state(c, 1, spaces.iter().map(|s| s.kind.dimension()).sum())?;
            write_state(&c.world(), c.plugin(), &spaces, &state)?;
            done(c)
        })
        .param(given())
        .text("Moves the objects of the scene to a state."),
    );
    offer.command(
        command("isStateValid", |c| {
            let task = task(c)?.clone();
            let state = state(c, 1, task.dimension())?;
            let valid = with_test(c, &task, |test, _, _| Ok(test.is_valid(&state)))?;
            if version(c) < (4, 2) {
                c.ret(i64::from(valid));
            } else {
                c.ret(valid);
            }
            Ok(())
        })
        .param(given())
        .returns(Param::any("valid").text("a boolean; before 4.2: 1 or 0"))
        .text("Returns whether a state is possible.")
        .notes("The scene does not change."),
    );
    offer.command(
        command("isStateWithinBounds", |c| {
            let task = task(c)?.clone();
            let (space, state) = (state_space(&task.spaces)?, state(c, 1, task.dimension())?);
            c.ret(space.is_within(&state));
            Ok(())
        })
        .param(given())
        .returns(Param::bool("within"))
        .text("Returns whether a state is within the bounds."),
    );
    offer.command(
        command("enforceBounds", |c| {
            let task = task(c)?.clone();
            let (space, mut state) = (state_space(&task.spaces)?, state(c, 1, task.dimension())?);
            space.enforce(&mut state);
            c.ret(state);
            Ok(())
        })
        .param(given())
        .returns(given())
        .text("Returns the nearest state within the bounds."),
    );
    offer.command(
        command("stateDistance", |c| {
            let task = task(c)?.clone();
            let space = state_space(&task.spaces)?;
            let (a, b) = (state(c, 1, task.dimension())?, state(c, 2, task.dimension())?);
            c.ret(space.distance(&a, &b));
            Ok(())
        })
        .param(Param::floats("a", 0))
        .param(Param::floats("b", 0))
        .returns(Param::float("distance"))
        .text("Returns the distance of two states: the weighted sum of those of the parts."),
    );
    offer.command(
        command("getStateSpaceDimension", |c| {
            let dimension = task(c)?.dimension();
            c.ret(dimension as i64);
            Ok(())
        })
        .returns(Param::int("dimension"))
        .text("Returns the count of numbers of a state."),
    );
    offer.command(
        command("projectionSize", |c| {
            let size = task(c)?.projection;
            c.ret(size as i64);
            Ok(())
        })
        .returns(Param::int("size"))
        .text("Returns the size that `setProjectionEvaluationCallback` was given, or 0."),
    );
    offer.command(
        command("printTaskInfo", |c| {
            let text = {
                let task = task(c)?;
                let (parts, dimension, goals) = (task.spaces.len(), task.dimension(), task.goals.len());
                format!(
                    "planning task `{}`: {parts} parts, {dimension} numbers of a state, {} pairs, {goals} goal states, {} states of the path",
                    task.name,
                    task.pairs.len(),
                    task.path.len()
                )
            };
            c.world().log(TATU_LOG_INFO, text.as_bytes());
            done(c)
        })
        .text("Writes what a task consists of to the log."),
    );
    for (name, text) in [
        ("setVerboseLevel", "The planners write nothing to the log."),
        ("drawPath", "Nothing is drawn."),
        ("drawPlannerData", "Nothing is drawn."),
        ("removeDrawingObjects", "Nothing is drawn."),
        ("projectStates", "The planners need no projection."),
    ] {
        offer.command(
            command(name, |c| {
                task(c)?;
                c.ret(Value::List(Vec::new()));
                Ok(())
            })
            .param(Param::any("arguments").rest())
            .returns(Param::any("nothing"))
            .text("Does nothing, and returns an empty table.")
            .stub(text),
        );
    }
}
