//! Commands on the simulation: its time and state, starting and stopping it.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::side_by_side("sim.getSimulationTime", |c| {
            let t = c.world().f64(0, c.plugin().p.time)?;
            c.ret(t);
            Ok(())
        })
        .old_name("simGetSimulationTime", NIL)
        .returns(Param::float("time").unit("s"))
        .text("Returns the simulation time: 0 in the first step.")
        .example("t = sim.getSimulationTime()"),
    );
    offer.command(
        Cmd::side_by_side("sim.getSimulationTimeStep", |c| {
            let dt = c.world().f64(0, c.plugin().p.dt)?;
            c.ret(dt);
            Ok(())
        })
        .old_name("simGetSimulationTimeStep", NIL)
        .returns(Param::float("dt").unit("s"))
        .text("Returns the time step of the simulation.")
        .example("dt = sim.getSimulationTimeStep()"),
    );
    offer.command(
        Cmd::side_by_side("sim.getSimulationState", |c| {
            let state = state_now(c)?;
            c.ret(state);
            Ok(())
        })
        .old_name("simGetSimulationState", MINUS_ONE)
        .returns(Param::int("state").text("sim.simulation_..."))
        .text(
            "Returns whether the simulation is stopped (0), in its first step (16), running (17), in the last step \
             before a pause (19), paused (8), in the first step after one (20), about to stop (21) or in its last step \
             (22).",
        )
        .example("if sim.getSimulationState() == sim.simulation_advancing_running then end"),
    );
    offer.command(
        Cmd::side_by_side("sim.getSimulationStopping", |c| {
            let p = &c.plugin().p;
            let stopping = bool_of(c, 0, p.stopping)? || !bool_of(c, 0, p.running)?;
            c.ret(stopping);
            Ok(())
        })
        .returns(Param::bool("stopping"))
        .text("Returns whether the simulation is about to stop or has stopped.")
        .example("while not sim.getSimulationStopping() do sim.step() end"),
    );
    offer.command(
        Cmd::new("sim.getRealTimeSimulation", |c| {
            c.ret(0_i64);
            Ok(())
        })
        .old_name("simGetRealTimeSimulation", MINUS_ONE)
        .returns(Param::int("on").text("0"))
        .text("Returns 0: real-time simulation is hidden from scripts, so that runs are reproducible.")
        .example("on = sim.getRealTimeSimulation()"),
    );
    for (names, what, text) in [
        (
            ["sim.startSimulation", "simStartSimulation"],
            TATU_REQUEST_START,
            "Requests that the simulation start, or resume after a pause.",
        ),
        (
            ["sim.pauseSimulation", "simPauseSimulation"],
            TATU_REQUEST_PAUSE,
            "Requests that the simulation pause after the next step.",
        ),
        (
            ["sim.stopSimulation", "simStopSimulation"],
            TATU_REQUEST_STOP,
            "Requests that the simulation stop: two more steps follow, in which scripts can detect it.",
        ),
        (["sim.quitSimulator", "simQuitSimulator"], TATU_REQUEST_QUIT, "Requests that the program exit."),
    ] {
        offer.command(
            both(names, MINUS_ONE, move |c| {
                c.world().request(what)?;
                finish_setter(c)
            })
            .param(Param::any("unused").optional())
            .text(text)
            .example(format!("{}()", names[0])),
        );
    }
    offer.command(
        Cmd::new("sim.getModuleName", |_| Ok(()))
            .alias("sim.getPluginName")
            .old_name("simGetModuleName", NIL)
            .param(Param::int("index").text("from 0"))
            .returns(Param::string("name").text("no value past the end"))
            .text("Returns the name of a loaded V-REP plugin; no such plugins exist.")
            .partial("V-REP plugins are not supported, so the list is empty."),
    );
    offer.command(
        Cmd::new("sim.getSystemTime", |c| {
            let t = c.world().f64(0, c.plugin().p.clock)?;
            c.ret(t);
            Ok(())
        })
        .old_name("simGetSystemTime", NIL)
        .returns(Param::float("time").unit("s"))
        .text(
            "Returns the simulation time instead of the clock's time, so that runs are reproducible; in real time, \
             returns the clock's time.",
        )
        .example("t = sim.getSystemTime()"),
    );
    offer.command(
        Cmd::new("sim.getSystemTimeInMs", |c| {
            let t = c.world().f64(0, c.plugin().p.clock)?;
            let ms = (t * 1000.0).round() as i64;
            let since = int_or(c, 0, -1)?;
            c.ret(if since >= 0 { ms - since } else { ms });
            Ok(())
        })
        .old_name("simGetSystemTimeInMs", MINUS_ONE)
        .old_name("simGetSystemTimeInMilliseconds", MINUS_ONE)
        .param(Param::int("since").default(-1).optional().text("an earlier time; -1 or -2: no such time"))
        .returns(Param::int("time").text("ms"))
        .text("Returns the simulation time in milliseconds instead of a clock's, or the time elapsed since `since`.")
        .example("elapsed = sim.getSystemTimeInMs(before)"),
    );
}

/// Converts the phase of the world to V-REP's simulation state.
pub(crate) fn state_now(c: &SharedCtx<'_>) -> Result<i64> {
    Ok(match int_of(c, 0, c.plugin().p.phase)? as u32 {
        TATU_PHASE_FIRST => 16,
        TATU_PHASE_RUNNING => 17,
        TATU_PHASE_LAST_BEFORE_PAUSE => 19,
        TATU_PHASE_PAUSED => 8,
        TATU_PHASE_FIRST_AFTER_PAUSE => 20,
        TATU_PHASE_STOPPING => 21,
        TATU_PHASE_LAST => 22,
        _ => 0,
    })
}
