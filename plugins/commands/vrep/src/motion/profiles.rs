//! Commands on motion profiles, which are identified by handles: `sim.ruckigPos`, `sim.ruckigVel`, `sim.ruckigStep`,
//! `sim.ruckigRemove`, and the older `simRMLPos` family.

use super::profile::MotionProfile;
use crate::{kit::*, state::state};

/// Differences from V-REP's documented profiles.
pub(crate) const NOTES: &str = "All coordinates move together in a straight line and arrive at the same time; an \
                                initial velocity is reduced to 0 first, and the final velocity is always 0.";

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let flags = || Param::int("flags").text("ignored: all coordinates arrive together");
    let common = |command: Cmd| {
        command
            .param(Param::int("count").text("number of coordinates"))
            .param(Param::float("smallestStep").unit("s").text("ignored"))
            .param(flags())
            .param(table("current", "current positions, velocities and accelerations"))
    };
    for (name, older, flat, position) in
        [("sim.ruckigPos", "sim.rmlPos", "simRMLPos", true), ("sim.ruckigVel", "sim.rmlVel", "simRMLVel", false)]
    {
        let limits =
            if position { "maximum velocities, accelerations and jerks" } else { "maximum accelerations and jerks" };
        let target = if position { "positions and velocities" } else { "velocities" };
        let command = Cmd::new(name, move |c| {
            let n = usize::try_from(c.i64(0)?).ok().filter(|n| (1..=1000).contains(n));
            let n = n.ok_or_else(|| Fail::argument("argument 1: expected a number of coordinates, 1 to 1000"))?;
            let part = |i: usize, k: usize| -> Result<Vec<f64>> {
                (k * n..(k + 1) * n)
                    .map(|j| c.arg(i).number(j).filter(|x| x.is_finite()).ok_or(j))
                    .collect::<std::result::Result<_, _>>()
                    .map_err(|j| {
                        Fail::argument(format!("argument {}: element {} is not a finite number", i + 1, j + 1))
                    })
            };
            let (start, velocity) = (part(3, 0)?, part(3, 1)?);
            let mut target = part(6, 0)?;
            for (i, x) in target.iter_mut().enumerate() {
                // A coordinate that is not selected must not move.
                if c.arg(5).number(i) == Some(0.0) {
                    *x = start[i];
                }
            }
            let profile = if position {
                MotionProfile::to(&start, &velocity, &target, [&part(4, 0)?, &part(4, 1)?, &part(4, 2)?])
            } else {
                MotionProfile::to_velocity(&start, &velocity, &target, &part(4, 0)?, &part(4, 1)?)
            };
            let mut state = state(c)?;
            state.profiles.made += 1;
            let made = state.profiles.made;
            state.profiles.all.insert(made, profile);
            drop(state);
            c.ret(made);
            Ok(())
        })
        .alias(older)
        .old_name(flat, MINUS_ONE);
        offer.command(
            common(command)
                .param(table("limits", limits))
                .param(Param::any("selection").text("a table that states for each coordinate whether it moves"))
                .param(table("target", target))
                .returns(Param::int("profile"))
                .text(format!("Creates a motion profile to target {target}, within limits."))
                .partial(NOTES),
        );
    }
    offer.command(
        Cmd::new("sim.ruckigStep", |c| {
            let (which, dt) = (c.i64(0)?, c.f64(1)?.max(0.0));
            let stepped = state(c)?.profiles.all.get_mut(&which).map(|p| p.step(dt));
            let (arrived, [at, v, a], over) = stepped.ok_or_else(|| missing_profile(which))?;
            c.ret(i64::from(arrived));
            c.ret(&[at, v, a].concat()[..]);
            c.ret(over);
            Ok(())
        })
        .alias("sim.rmlStep")
        .old_name("simRMLStep", MINUS_ONE)
        .param(Param::int("profile"))
        .param(Param::float("dt").unit("s"))
        .returns(Param::int("result").text("0: in progress, 1: target reached"))
        .returns(Param::list("state").text("positions, velocities and accelerations"))
        .returns(Param::float("left").unit("s").text("the unused part of the step"))
        .text("Advances a motion profile.")
        .partial(NOTES),
    );
    offer.command(
        Cmd::new("sim.ruckigRemove", |c| {
            let which = c.i64(0)?;
            state(c)?.profiles.all.remove(&which).ok_or_else(|| missing_profile(which))?;
            finish_setter(c)
        })
        .alias("sim.rmlRemove")
        .old_name("simRMLRemove", MINUS_ONE)
        .param(Param::int("profile"))
        .text("Removes a motion profile."),
    );
}

fn missing_profile(which: i64) -> Fail {
    Fail::missing(format!("there is no motion profile {which}"))
}
