//! Commands that main scripts call to run the stages of a step, under the names that they have in V-REP.
//!
//! | command | stage |
//! |---|---|
//! | `sim.handleChildScripts(sim.syscb_actuation)` | actuate |
//! | `sim.handleDynamics(dt)` | physics |
//! | `sim.handleProximitySensor(sim.handle_all_except_explicit)` | sense (see `proximity`) |
//! | `sim.handleChildScripts(sim.syscb_sensing)` | react |
//! | `sim.handleChildScripts(sim.syscb_cleanup)` | clean |

use crate::{kit::*, lookup::registered::is_stand_in};

/// The call type of the clean-up, which is the same in all dialects.
const CLEANUP_CALL: i64 = 1;

/// Returns the call types of actuation and sensing in the caller's dialect. The numbers must agree with `prelude.lua`.
fn call_types(c: &Ctx<'_>) -> [i64; 2] {
    match version(c) {
        v if v < (3, 5) => [2, 3],
        v if v < (4, 2) => [5, 6],
        _ => [6, 7],
    }
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.handleChildScripts", |c| {
            let count = call_scripts(c)?;
            c.ret(count);
            Ok(())
        })
        .alias("sim.handleSimulationScripts")
        .alias("sim.handleEmbeddedScripts")
        .old_name("simHandleChildScripts", MINUS_ONE)
        .old_name("simHandleChildScript", MINUS_ONE)
        .param(Param::any("callType").optional().text("sim.syscb_actuation or sim.syscb_sensing"))
        .param(Param::any("arguments").rest())
        .returns(Param::int("count").text("number of scripts that were called"))
        .text(
            "In a main script: calls all child and customization scripts for actuation or sensing. In a child script: \
             calls the scripts of its object's descendants that have not been called in this part of the step, with \
             the given arguments; they are not called again automatically. Other call types have no effect.",
        )
        .example("sim.handleChildScripts(sim.syscb_actuation)"),
    );
    offer.command(
        Cmd::new("sim.handleDynamics", |c| {
            let step = c.world().f64(0, c.plugin().p.dt)?;
            // Scripts for versions before 4.5 pass the step as a 32-bit float, which must be treated as the exact step.
            let dt = c.f64(0)?;
            let dt = if dt as f32 == step as f32 { step } else { dt };
            if !is_main(c)? {
                return Err(Fail::unsupported("only a main script can advance physics")
                    .help("declare the script as kind `main`, or leave physics to the host"));
            }
            c.world().run_stage(TATU_STAGE_PHYSICS, dt)?;
            let longest = c.world().f64(0, c.plugin().p.physics_dt)?;
            c.ret((dt / longest - 1e-9).ceil().max(0.0) as i64);
            Ok(())
        })
        .old_name("simHandleDynamics", MINUS_ONE)
        .param(Param::float("dt").unit("s").range(0.0, f64::INFINITY))
        .returns(Param::int("count").text("number of physics steps"))
        .text("In a main script: advances physics. At the end of the step, time advances by the same amount.")
        .example("sim.handleDynamics(sim.getSimulationTimeStep())"),
    );
    for (names, what, of_objects) in COMMANDS_WITHOUT_EFFECT {
        offer.command(
            both(*names, MINUS_ONE, move |c| {
                // Handling a set of objects is not an error, because the set is empty; a single object of these kinds
                // cannot exist.
                match c.arg(0).as_i64() {
                    Some(n) if *of_objects && n > 0 && !is_stand_in(c, n) => {
                        Err(Fail::missing(format!("object {n} does not exist: {what}")))
                    }
                    _ => {
                        c.ret(0_i64);
                        Ok(())
                    }
                }
            })
            .param(Param::any("arguments").rest())
            .returns(Param::int("count").text("0"))
            .text(format!("For main scripts, which call it in each step: {what}."))
            .stub(*what),
        );
    }
    for (names, what) in AUTOMATIC_COMMANDS {
        offer.command(
            both(*names, MINUS_ONE, |c| {
                c.ret(0_i64);
                Ok(())
            })
            .param(Param::any("arguments").rest())
            .returns(Param::int("count").text("0"))
            .text(format!("For main scripts, which call it in each step: {what}."))
            .partial("The command has no effect, and the count is 0."),
        );
    }
}

/// Commands of main scripts whose task is performed in a different part of the step, or automatically.
const AUTOMATIC_COMMANDS: &[(CommandNames, &str)] = &[
    (["sim.handleSimulationStart", "simHandleSimulationStart"], "the run is prepared before its first step"),
    (
        ["sim.handleSensingStart", "simHandleSensingStart"],
        "distances and colours of sensors are reset in the sensing stage",
    ),
    (["sim.openModule", "simOpenModule"], "plugins are notified of a start automatically"),
    (["sim.handleModule", "simHandleModule"], "plugins are notified of each step automatically"),
    (["sim.closeModule", "simCloseModule"], "plugins are notified of a stop automatically"),
    (["sim.resumeThreads", "simResumeThreads"], "threads resume in the actuation stage, with the child scripts"),
    (
        ["sim.launchThreadedChildScripts", "simLaunchThreadedChildScripts"],
        "threads start in the actuation stage, with the child scripts",
    ),
    (
        ["sim.handleCustomizationScripts", "simHandleCustomizationScripts"],
        "customization scripts are called together with the child scripts",
    ),
    (["sim.handleAddOnScripts", "simHandleAddOnScripts"], "add-ons are called by the host in each step"),
    (["sim.handleVarious", "simHandleVarious"], "its functions are performed by other parts of the step"),
];

/// Commands of default main scripts that have no effect: their names, the reason, and whether the first argument can
/// identify a single object, of a kind that does not exist in Tatu.
const COMMANDS_WITHOUT_EFFECT: &[(CommandNames, &str, bool)] = &[
    (["sim.handleSandboxScript", "simHandleSandboxScript"], "there is no sandbox", false),
    (["sim.handleJoint", "simHandleJoint"], "joints only move in physics", false),
    (["sim.handleJointMotion", "simHandleJointMotion"], "joints only move in physics", false),
    (["sim.handlePath", "simHandlePath"], "there are no paths", true),
    (["sim.handleMechanism", "simHandleMechanism"], "there are no mechanisms", true),
    (["sim.handleMill", "simHandleMill"], "there are no mills", true),
    (["sim.resetMill", "simResetMill"], "there are no mills", true),
    (["sim.resetMilling", "simResetMilling"], "there are no mills", false),
];

/// Runs the stage for a call type; returns the number of scripts called.
fn call_scripts(c: &Ctx<'_>) -> Result<i64> {
    let [actuation, sensing] = call_types(c);
    if !is_main(c)? {
        return call_descendants(c, actuation, sensing);
    }
    // In the oldest form, the first argument selects all scripts, and the call type can be missing.
    let kind = match (c.arg(0).as_i64(), c.arg(1).as_i64()) {
        (None, _) => actuation,
        (Some(n), None) if n < 0 => actuation,
        (Some(n), Some(kind)) if n < 0 => kind,
        (Some(kind), _) => kind,
    };
    let stage = match kind {
        n if n == actuation => TATU_STAGE_ACTUATE,
        n if n == sensing => TATU_STAGE_REACT,
        CLEANUP_CALL => TATU_STAGE_CLEAN,
        _ => return Ok(0),
    };
    c.world().run_stage(stage, c.world().f64(0, c.plugin().p.dt)?)?;
    let main = c.caller_script();
    Ok(c.world().scripts(0)?.iter().filter(|s| **s != main).count() as i64)
}

/// Calls the scripts of the descendants of the caller's object, and returns the number of these scripts.
fn call_descendants(c: &Ctx<'_>, actuation: i64, sensing: i64) -> Result<i64> {
    let stage_of = |n: i64| match n {
        n if n == actuation => Some(TATU_STAGE_ACTUATE),
        n if n == sensing => Some(TATU_STAGE_REACT),
        _ => None,
    };
    // In the oldest form, the first argument selects all scripts, and the call type can be missing; scripts that use
    // this form run once per step, in actuation.
    let (stage, first) = match (c.arg(0).as_i64(), c.arg(1).as_i64().and_then(stage_of)) {
        (Some(n), Some(stage)) if n < 0 => (stage, 2),
        (Some(n), None) if n < 0 => (TATU_STAGE_ACTUATE, 1),
        (Some(n), _) => match stage_of(n) {
            Some(stage) => (stage, 1),
            None => return Ok(0),
        },
        (None, _) => (TATU_STAGE_ACTUATE, 1),
    };
    if c.caller_object() == 0 {
        return Ok(0);
    }
    let args = c.args().get(first..).unwrap_or_default();
    c.world().call_below(c.caller_object(), stage, args).map(i64::from)
}
