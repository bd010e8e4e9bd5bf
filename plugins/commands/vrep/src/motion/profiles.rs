//! Commands on motion profiles, which are identified by handles: `sim.ruckigPos`, `sim.ruckigVel`, `sim.ruckigStep`,
//! `sim.ruckigRemove`, and the older `simRMLPos` family.

use std::collections::btree_map::Entry;

use tatu_trajectories::Synchronization;

use super::profile::{LimitLists, MotionProfile, states, synchronization};
use crate::{
    kit::*,
    state::{
        motions::{check_room, removed_scripts},
        profiles::ScriptProfile,
        state,
    },
};

/// Flags: the limits also contain minimum velocities, and minimum accelerations.
const MIN_VELOCITIES: i64 = 256;
const MIN_ACCELERATIONS: i64 = 512;

/// Result of a step whose duration is not a multiple of the cycle.
const NO_MULTIPLE: i64 = -3;

/// Most coordinates of a profile.
const MAX_COORDINATES: usize = 1000;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (name, flat, position) in [
        ("sim.ruckigPos", None, true),
        ("sim.ruckigVel", None, false),
        ("sim.rmlPos", Some("simRMLPos"), true),
        ("sim.rmlVel", Some("simRMLVel"), false),
    ] {
        let limits = if position {
            "maximum velocities, accelerations and jerks; with sim.ruckig_minvel or sim.ruckig_minaccel, minimum \
             velocities and accelerations"
        } else {
            "maximum accelerations and jerks; with sim.ruckig_minaccel, minimum accelerations"
        };
        let target = if position { "positions and velocities" } else { "velocities" };
        let command = Cmd::new(name, move |c| create(c, position, flat.is_some()));
        let command = flat.into_iter().fold(command, |command, flat| command.old_name(flat, MINUS_ONE));
        offer.command(
            command
                .param(Param::int("count").text("number of coordinates"))
                .param(Param::float("smallestStep").unit("s").text("steps are multiples of it, usually 0.0001"))
                .param(Param::int("flags").text(
                    "sim.ruckig_timesync: all coordinates arrive together; sim.ruckig_phasesync: on a straight line if \
                     possible; sim.ruckig_nosync; -1: the default",
                ))
                .param(table("current", "current positions, velocities and accelerations"))
                .param(table("limits", limits))
                .param(Param::any("selection").text("a table that states for each coordinate whether it moves"))
                .param(table("target", target))
                .returns(Param::int("profile"))
                .text(format!("Creates the fastest motion to target {target} within limits.")),
        );
    }
    offer.command(
        Cmd::new("sim.ruckigStep", |c| {
            let (which, dt) = (c.i64(0)?, c.f64(1)?.max(0.0));
            let script = c.caller_script();
            let mut state = state(c)?;
            let ScriptProfile { profile, cycle, velocities, .. } = state
                .profiles
                .all
                .get_mut(&which)
                .filter(|profile| profile.script == script)
                .ok_or_else(|| missing_profile(which))?;
            let cycles = dt / *cycle;
            let uneven = (cycles - cycles.round()).abs() > CYCLE_TOLERANCE;
            let arrived = !uneven && profile.advance_in_cycles(dt, *cycle);
            let now = if *velocities { profile.continued_state() } else { profile.state() };
            let left = profile.left();
            drop(state);
            c.ret(if uneven { NO_MULTIPLE } else { i64::from(arrived) });
            c.ret(&now.concat()[..]);
            c.ret(left);
            Ok(())
        })
        .alias("sim.rmlStep")
        .old_name("simRMLStep", MINUS_ONE)
        .param(Param::int("profile"))
        .param(Param::float("dt").unit("s"))
        .returns(Param::int("result").text("0: in progress, 1: target reached, -3: dt is not a multiple of the cycle"))
        .returns(Param::list("state").text("positions, velocities and accelerations"))
        .returns(Param::float("left").unit("s").text("time until the target is reached; negative afterwards"))
        .text("Advances a motion profile."),
    );
    offer.command(
        Cmd::new("sim.ruckigRemove", |c| {
            let (which, script) = (c.i64(0)?, c.caller_script());
            let mut state = state(c)?;
            match state.profiles.all.entry(which) {
                Entry::Occupied(profile) if profile.get().script == script => drop(profile.remove()),
                _ => return Err(missing_profile(which)),
            }
            drop(state);
            finish_setter(c)
        })
        .alias("sim.rmlRemove")
        .old_name("simRMLRemove", MINUS_ONE)
        .param(Param::int("profile"))
        .text("Removes a motion profile."),
    );
}

/// Share of the cycle by which the duration of a step may differ from a multiple of it.
const CYCLE_TOLERANCE: f64 = 1e-3;

/// Creates a profile to positions or velocities; `is_rml` is whether the command is of the older family.
fn create(c: &mut Ctx<'_>, position: bool, is_rml: bool) -> Result<()> {
    let n = usize::try_from(c.i64(0)?).ok().filter(|n| (1..=MAX_COORDINATES).contains(n));
    let n = n.ok_or_else(|| {
        Fail::argument(format!("argument 1: expected a number of coordinates from 1 to {MAX_COORDINATES}"))
    })?;
    let cycle = c.f64(1)?;
    if cycle.is_nan() || cycle <= 0.0 {
        return Err(Fail::argument(format!("argument 2: the smallest step must be above 0 s, but it is {cycle}"))
            .help("0.0001 is usual"));
    }
    let flags = int_or(c, 2, -1)?;
    let part = |i: usize, k: usize| -> Result<Vec<f64>> {
        if c.arg(i).len() < (k + 1) * n {
            return Err(Fail::argument(format!(
                "argument {} needs at least {} numbers for {n} coordinates, but it has {}",
                i + 1,
                (k + 1) * n,
                c.arg(i).len()
            )));
        }
        let number = |j: usize| c.arg(i).number(j).filter(|x| x.is_finite()).ok_or(j);
        (k * n..(k + 1) * n).map(number).collect::<std::result::Result<_, _>>().map_err(|j| {
            Fail::argument(format!("argument {}: element {} must be a finite number, but it is not", i + 1, j + 1))
        })
    };
    let mut starts = states(n, [&part(3, 0)?, &part(3, 1)?, &part(3, 2)?]);
    // Limits of velocity come first, if there are any.
    let kinds = if position { 3 } else { 2 };
    let with = |flag: i64| flags > 0 && flags & flag != 0;
    let mut extra = kinds;
    let mut minimum = |given: bool| -> Result<Vec<f64>> {
        extra += usize::from(given);
        if given { part(4, extra - 1) } else { Ok(Vec::new()) }
    };
    let limits = LimitLists {
        min_velocity: minimum(position && with(MIN_VELOCITIES))?,
        min_acceleration: minimum(with(MIN_ACCELERATIONS))?,
        velocity: if position { part(4, 0)? } else { Vec::new() },
        acceleration: part(4, kinds - 2)?,
        jerk: part(4, kinds - 1)?,
    };
    let selected = |k: usize| c.arg(5).number(k) != Some(0.0);
    // V-REP ignored limits of jerk from 3.4 to 4.2, so scripts for its older commands may state 0.
    let jerk = if is_rml { &[] } else { limits.jerk.as_slice() };
    for (what, list) in
        [("velocity", limits.velocity.as_slice()), ("acceleration", &limits.acceleration), ("jerk", jerk)]
    {
        if let Some(k) = (0..list.len()).find(|k| selected(*k) && list[*k] <= 0.0) {
            return Err(Fail::argument(format!(
                "argument 5: the limit of {what} of coordinate {} is {}; expected a number above 0",
                k + 1,
                list[k]
            )));
        }
    }
    for (k, start) in starts.iter_mut().enumerate() {
        if !selected(k) {
            *start = tatu_trajectories::State::at(start.position);
        }
    }
    let default = if is_rml { Synchronization::Phase } else { Synchronization::Time };
    let synchronization = synchronization(flags, default);
    let profile = if position {
        let velocities = if c.arg(6).len() >= 2 * n { part(6, 1)? } else { Vec::new() };
        let mut targets = states(n, [&part(6, 0)?, &velocities, &[]]);
        (0..n).filter(|k| !selected(*k)).for_each(|k| targets[k] = starts[k]);
        MotionProfile::to(&starts, &targets, &limits, synchronization)?
    } else {
        let mut velocities = part(6, 0)?;
        (0..n).filter(|k| !selected(*k)).for_each(|k| velocities[k] = 0.0);
        MotionProfile::to_velocities(&starts, &velocities, &limits, synchronization)?
    };
    let script = c.caller_script();
    let scripts = state(c)?.profiles.all.values().map(|p| p.script).collect();
    let removed = removed_scripts(c, scripts);
    let mut state = state(c)?;
    state.profiles.all.retain(|_, p| !removed.contains(&p.script));
    check_room(state.profiles.all.values().map(|p| p.profile.size()), profile.size())?;
    state.profiles.made += 1;
    let made = state.profiles.made;
    state.profiles.all.insert(made, ScriptProfile { script, profile, cycle, velocities: !position });
    drop(state);
    c.ret(made);
    Ok(())
}

fn missing_profile(which: i64) -> Fail {
    Fail::missing(format!("there is no motion profile {which}")).help("create one with sim.ruckigPos or sim.ruckigVel")
}
