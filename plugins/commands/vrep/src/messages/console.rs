//! Commands that write text for the user: to the status bar, the log, and auxiliary consoles.
//!
//! Consoles have no windows. Text that a script prints to a console is buffered until a line is complete; the line is
//! then logged with the console's title as prefix.

use crate::{
    kit::*,
    state::{
        consoles::{Consoles, LineCallback},
        state,
    },
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::side_by_side("sim.addStatusbarMessage", |c| {
            log_argument(c, TATU_LOG_STATUS, 0)?;
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simAddStatusbarMessage", MINUS_ONE)
        .param(Param::string("text").optional().text("nil: clears the status bar"))
        .returns(Param::int("done"))
        .text("Writes a line to the status bar.")
        .example("sim.addStatusbarMessage('ready')"),
    );
    offer.command(
        Cmd::side_by_side("sim.addLog", |c| {
            let level = c.i64(0)? & 0xFFF;
            log_argument(c, log_level(level), 1)?;
            if level == SCRIPT_ERROR && c.has(1) {
                return Err(Fail::with_code(TATU_ERR_SCRIPT, c.text(1)?));
            }
            Ok(())
        })
        .param(Param::int("verbosity").text("sim.verbosity_...; sim.verbosity_scripterrors also raises an error"))
        .param(Param::string("text").optional().text("nil: clears the status bar"))
        .text("Writes a line to the log.")
        .example("sim.addLog(sim.verbosity_scriptinfos, 'ready')"),
    );
    offer.command(
        Cmd::new("sim.auxiliaryConsoleOpen", |c| {
            let title = c.bytes(0)?.to_vec();
            let console = state(c)?.channels.consoles.open(title);
            c.ret(console);
            Ok(())
        })
        .old_name("simAuxiliaryConsoleOpen", MINUS_ONE)
        .param(Param::string("title"))
        .param(Param::int("maxLines").default(100).optional().text("ignored"))
        .param(
            Param::int("mode")
                .default(0)
                .optional()
                .text("ignored: scripts' consoles are closed at the end of the simulation"),
        )
        .param(Param::any("position").optional().text("ignored"))
        .param(Param::any("size").optional().text("ignored"))
        .param(Param::any("textColor").optional().text("ignored"))
        .param(Param::any("backgroundColor").optional().text("ignored"))
        .returns(Param::int("console"))
        .text("Opens a console, whose lines are written to the log.")
        .example("console = sim.auxiliaryConsoleOpen('Sensors', 1000, 0)"),
    );
    offer.command(
        Cmd::new("sim.auxiliaryConsolePrint", |c| {
            let console = c.i64(0)?;
            let text = c.has(1).then(|| c.bytes(1)).transpose()?;
            if let Some(title) = state(c)?.channels.consoles.title(console) {
                match text {
                    Some(text) => c.world().log(TATU_LOG_CONSOLE, &[title.as_slice(), b"\0", text].concat()),
                    None => c.world().log(TATU_LOG_CONSOLE_CLEAR, &title),
                }
            }
            change_consoles(c, |consoles, tell| consoles.print(console, text, tell))
        })
        .old_name("simAuxiliaryConsolePrint", MINUS_ONE)
        .param(Param::int("console"))
        .param(Param::string("text").optional().text("nil: clears the console"))
        .returns(Param::int("done").text("1; 0: the console no longer exists"))
        .text("Prints text to a console, without adding a line feed.")
        .example("sim.auxiliaryConsolePrint(console, 'distance ' .. d .. '\\n')"),
    );
    offer.command(
        Cmd::new("sim.auxiliaryConsoleShow", |c| {
            let console = c.i64(0)?;
            let there = state(c)?.channels.consoles.has(console);
            c.ret(i64::from(there));
            Ok(())
        })
        .old_name("simAuxiliaryConsoleShow", MINUS_ONE)
        .param(Param::int("console"))
        .param(Param::any("show").default(true).optional().text("ignored: consoles have no window"))
        .returns(Param::int("done").text("1; 0: the console no longer exists"))
        .text("Shows or hides a console.")
        .example("sim.auxiliaryConsoleShow(console, true)"),
    );
    offer.command(
        Cmd::new("sim.auxiliaryConsoleClose", |c| {
            let console = c.i64(0)?;
            change_consoles(c, |consoles, tell| consoles.close(console, tell))
        })
        .old_name("simAuxiliaryConsoleClose", MINUS_ONE)
        .param(Param::int("console"))
        .returns(Param::int("done").text("1; 0: the console no longer exists"))
        .text("Closes a console; an incomplete line is logged.")
        .example("sim.auxiliaryConsoleClose(console)"),
    );
}

const SCRIPT_ERROR: i64 = 420;

/// Converts a verbosity to a log level.
fn log_level(verbosity: i64) -> u32 {
    match verbosity {
        200 | SCRIPT_ERROR => TATU_LOG_ERROR,
        300 | 430 => TATU_LOG_WARNING,
        600.. => TATU_LOG_DEBUG,
        _ => TATU_LOG_STATUS,
    }
}

/// Logs argument `i`, or clears the status bar if the argument is missing.
fn log_argument(c: &SharedCtx<'_>, level: u32, i: usize) -> Result {
    if c.has(i) {
        c.world().log(level, c.bytes(i)?);
    } else {
        c.world().log(TATU_LOG_CLEAR, b"");
    }
    Ok(())
}

/// Applies `work` to the consoles, and logs the lines that it completes. Returns 1 to the script if the console exists,
/// otherwise 0.
fn change_consoles(c: &mut Ctx<'_>, work: impl FnOnce(&mut Consoles, LineCallback<'_>) -> bool) -> Result {
    let mut lines = Vec::new();
    let there = work(&mut state(c)?.channels.consoles, &mut |line| lines.push(line.to_vec()));
    for line in lines {
        c.world().log(TATU_LOG_INFO, &line);
    }
    c.ret(i64::from(there));
    Ok(())
}
