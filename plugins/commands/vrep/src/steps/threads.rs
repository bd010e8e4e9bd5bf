//! Commands that wait. Threaded scripts and coroutines call them to let the simulation advance.

use crate::{kit::*, signals::values::SIGNAL_KINDS, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.wait", |c| {
            let now = c.world().f64(0, c.plugin().p.time)?;
            // When the thread resumes, the command is called again with the end time as resume word.
            let until = match c.resumed() {
                0 => now + c.f64(0)?.max(0.0),
                word => f64::from_bits(word),
            };
            if c.resumed() == 0 && until > now && c.can_wait() {
                return c.wait_until(until, until.to_bits());
            }
            c.ret((now - until).max(0.0));
            Ok(Outcome::Done)
        })
        .old_name("simWait", NIL)
        .param(Param::float("duration").unit("s"))
        .param(Param::any("simulationTime").optional().text("ignored: the time is always simulation time"))
        .returns(Param::float("late").unit("s").text("excess of the wait over the requested time"))
        .text("Waits for the given time, if the calling script can wait.")
        .example("sim.wait(1.5)"),
    );
    offer.command(
        Cmd::new("sim.switchThread", |c| {
            if c.resumed() == 0 && c.can_wait() {
                return c.wait_steps(1, 1);
            }
            let waited = c.resumed() != 0;
            if old_era(c) {
                c.ret(i64::from(waited));
            }
            Ok(Outcome::Done)
        })
        .old_name("simSwitchThread", MINUS_ONE)
        .returns(Param::int("waited").text("1; 0: the caller cannot wait"))
        .text("Resumes in the next step, if the calling script can wait.")
        .example("sim.switchThread()"),
    );
    offer.command(
        Cmd::new("sim.step", |c| {
            if c.resumed() == 0 && c.can_wait() {
                return c.wait_steps(1, 1);
            }
            Ok(Outcome::Done)
        })
        .alias("sim.yield")
        .text("Resumes in the next step, if the calling script can wait.")
        .example("sim.step()"),
    );
    slices(offer);
    offer.command(
        Cmd::new("sim.waitForSignal", wait_for_signal)
            .old_name("simWaitForSignal", NIL)
            .param(Param::string("name"))
            .returns(Param::any("value").text("no value if the signal is not set and the caller cannot wait"))
            .text("Waits until a signal of any kind is set, and returns its value.")
            .example("value = sim.waitForSignal('start')"),
    );
}

/// Adds commands on the scheduling of threads. Script languages replace those on time slices with their own functions
/// (`prelude.lua`), so the commands here serve callers that are not threads: they have no effect, and return fixed
/// values such as 0. Only `sim.getThreadId` distinguishes threads.
fn slices(offer: &mut Offer<Vrep>) {
    let zero = |c: &mut Ctx<'_>| {
        c.ret(0_i64);
        Ok(())
    };
    offer.command(
        Cmd::new("sim.setThreadSwitchTiming", zero)
            .old_name("simSetThreadSwitchTiming", MINUS_ONE)
            .param(Param::float("milliseconds").text("0 to 200; 1 ms is 20,000 instructions; initially 2"))
            .returns(Param::int("threaded").text("1; 0: the caller is not a thread"))
            .text("Sets how long a thread may run in a step before it is switched out.")
            .example("sim.setThreadSwitchTiming(20)"),
    );
    offer.command(
        Cmd::new("sim.setThreadAutomaticSwitch", zero)
            .old_name("simSetThreadAutomaticSwitch", MINUS_ONE)
            .param(Param::any("on").text("since 4.2, each `false` must be undone by one `true`"))
            .returns(Param::int("threaded").text("1; 0: the caller is not a thread"))
            .text("Sets whether a thread that does not yield is switched out.")
            .example("sim.setThreadAutomaticSwitch(false)"),
    );
    offer.command(
        Cmd::new("sim.setStepping", zero)
            .param(Param::any("on").text("each `true` must be undone by one `false`; a number sets the level"))
            .returns(Param::int("before").text("the level before"))
            .text("Sets stepping mode, in which a thread is not switched out, but yields by calling sim.step().")
            .example("sim.setStepping(true)"),
    );
    offer.command(
        Cmd::new("sim.setAutoYieldDelay", |_| Ok(()))
            .param(Param::float("delay").unit("s").text("1 ms is 20,000 instructions; initially 0.002"))
            .text("Sets how long a thread may run in a step before it is switched out.")
            .example("sim.setAutoYieldDelay(0.02)"),
    );
    offer.command(
        Cmd::new("sim.getAutoYieldDelay", |c| {
            c.ret(0.002);
            Ok(())
        })
        .returns(Param::float("delay").unit("s"))
        .text("Returns how long a thread may run in a step before it is switched out.")
        .example("delay = sim.getAutoYieldDelay()"),
    );
    for (name, text) in [
        ("sim.acquireLock", "Prevents the calling thread from being switched out until a matching sim.releaseLock()."),
        ("sim.releaseLock", "Undoes one sim.acquireLock()."),
    ] {
        offer.command(Cmd::new(name, |_| Ok(())).text(text).example(format!("{name}()")));
    }
    offer.command(
        Cmd::new("sim.setThreadIsFree", zero)
            .old_name("simSetThreadIsFree", MINUS_ONE)
            .param(Param::any("free"))
            .returns(Param::int("result").text("0"))
            .text(
                "In V-REP, lets a thread run in parallel with the simulation. Has no effect here, because \
                   threads never do.",
            )
            .example("sim.setThreadIsFree(true)"),
    );
    offer.command(
        Cmd::new("sim.setThreadResumeLocation", |c| {
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simSetThreadResumeLocation", MINUS_ONE)
        .param(Param::int("location").text("sim.scriptthreadresume_..."))
        .param(Param::int("order").optional())
        .returns(Param::int("result").text("1"))
        .text(
            "In V-REP, sets where in a step a thread resumes. Has no effect here: a thread always resumes \
               immediately before its script's actuation.",
        )
        .example("sim.setThreadResumeLocation(sim.scriptthreadresume_default, 1)"),
    );
    offer.command(
        Cmd::new("sim.getThreadId", |c| {
            let id = if c.can_wait() { 2_i64 } else { 1 };
            c.ret(id);
            Ok(())
        })
        .old_name("simGetThreadId", MINUS_ONE)
        .returns(Param::int("id").text("1: the simulation's; 2: a thread"))
        .text("Returns whether the caller is a thread.")
        .example("id = sim.getThreadId()"),
    );
    offer.command(
        Cmd::new("sim.delegateChildScriptExecution", zero)
            .old_name("simDelegateChildScriptExecution", MINUS_ONE)
            .returns(Param::int("result").text("0"))
            .text(
                "In V-REP, runs child scripts in the caller's thread. Has no effect here, because each script \
                   is called separately.",
            )
            .example("sim.delegateChildScriptExecution()"),
    );
}

fn wait_for_signal(c: &mut Ctx<'_>) -> Result<Outcome> {
    // When the thread resumes and the command is called again, its arguments are no longer available; the resume word
    // is the key of the stored name.
    let name = match c.resumed() {
        0 => c.bytes(0)?.to_vec(),
        word => state(c)?.waits.remove(&word).unwrap_or_default(),
    };
    for kind in SIGNAL_KINDS {
        let v = c.world().signal(kind, &name)?;
        if !v.is_nil() {
            c.ret(v);
            return Ok(Outcome::Done);
        }
    }
    if !c.can_wait() || c.resumed() != 0 {
        return Ok(Outcome::Done);
    }
    let word = {
        let mut state = state(c)?;
        let word = state.waits.last_key_value().map_or(1, |(last, _)| last + 1);
        state.waits.insert(word, name.clone());
        word
    };
    c.wait_signal(&String::from_utf8_lossy(&name), word)
}
