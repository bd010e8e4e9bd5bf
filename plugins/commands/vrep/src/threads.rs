//! Waiting: what threaded scripts and coroutines use to let the simulation go on.

use crate::{Vrep, kit::*, signals::KINDS, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.wait", |c| {
            let now = c.world().f64(0, c.plugin().p.time)?;
            // Called again when the time has come: the word is that time.
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
        .param(Param::any("simulationTime").optional().text("ignored: simulation time is the only one"))
        .returns(Param::float("late").unit("s").text("by how much it waited too long"))
        .text("Waits for a while, where the calling script can wait.")
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
        .old_name("simSwitchThread", MINUS)
        .returns(Param::int("waited").text("1; 0: the caller cannot wait"))
        .text("Goes on in the next step, where the calling script can wait.")
        .example("sim.switchThread()"),
    );
    offer.command(
        Cmd::new("sim.step", |c| {
            if c.resumed() == 0 && c.can_wait() {
                return c.wait_steps(1, 1);
            }
            Ok(Outcome::Done)
        })
        .text("Goes on in the next step, where the calling script can wait.")
        .example("sim.step()"),
    );
    offer.command(
        Cmd::new("sim.waitForSignal", wait_for_signal)
            .old_name("simWaitForSignal", NIL)
            .param(Param::string("name"))
            .returns(Param::any("value").text("nothing if it is not set and the caller cannot wait"))
            .text("Waits until a signal of any kind is set, and gives its value.")
            .example("value = sim.waitForSignal('start')"),
    );
}

fn wait_for_signal(c: &mut Ctx<'_>) -> Result<Outcome> {
    // Called again without arguments: the word leads to the name.
    let name = match c.resumed() {
        0 => c.bytes(0)?.to_vec(),
        word => state(c)?.waits.remove(&word).unwrap_or_default(),
    };
    for kind in KINDS {
        let v = c.world().signal(kind, &name)?;
        if !v.is_nil() {
            c.ret::<ValueRef<'_>>(v);
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
