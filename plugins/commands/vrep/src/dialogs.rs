//! Dialogs: nobody is there to answer, so they answer themselves, in the next step: yes or ok, with the text they had.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{Vrep, kit::*, state::state};

#[derive(Serialize, Deserialize, Clone)]
struct Dialog {
    style: i64,
    text: Vec<u8>,
    opened: i64,
}

/// All dialogs of a world, by handle.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Dialogs {
    open: BTreeMap<i64, Dialog>,
    made: i64,
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let which = || Param::int("dialog");
    offer.command(
        both("sim.displayDialog", NIL, |c| {
            let (title, text) = (c.text(0)?, c.text(1)?);
            let style = c.i64(2)? & 31;
            let initial = if c.has(4) { c.bytes(4)?.to_vec() } else { Vec::new() };
            let opened = int_of(c, 0, c.plugin().p.step)?;
            let mut state = state(c)?;
            state.dialogs.made += 1;
            let made = state.dialogs.made;
            state.dialogs.open.insert(made, Dialog { style, text: initial, opened });
            drop(state);
            c.world().log(TATU_LOG_INFO, format!("[{title}] {}", text.replace("&&n", "\n")).as_bytes());
            c.ret(made);
            c.ret(-1_i64);
            Ok(())
        })
        .param(Param::string("title"))
        .param(Param::string("text").text("`&&n` breaks the line"))
        .param(Param::int("style").text("sim.dlgstyle_..."))
        .param(Param::any("modal").optional().text("ignored"))
        .param(Param::string("initialText").optional())
        .param(Param::any("titleColors").optional().text("ignored"))
        .param(Param::any("dialogColors").optional().text("ignored"))
        .returns(which())
        .returns(Param::int("ui").text("-1: there is no window"))
        .text("Writes a message to the log; a dialog with buttons or a text field answers itself in the next step.")
        .notes("Ok or yes is the answer, and the initial text the input; a dialog without buttons stays open."),
    );
    offer.command(
        both("sim.getDialogResult", MINUS, |c| {
            let step = int_of(c, 0, c.plugin().p.step)?;
            let dialog = find(c)?;
            c.ret(match dialog.style {
                _ if step <= dialog.opened => 0_i64,
                0 => 0,
                4 => 3,
                _ => 1,
            });
            Ok(())
        })
        .param(which())
        .returns(Param::int("result").text("0: still open, 1: ok, 3: yes"))
        .text("Gives how a dialog was answered."),
    );
    offer.command(
        both("sim.getDialogInput", NIL, |c| {
            let dialog = find(c)?;
            c.ret::<[u8]>(dialog.text.as_slice());
            Ok(())
        })
        .param(which())
        .returns(Param::string("text"))
        .text("Gives the text of a dialog's text field: the one that it began with."),
    );
    offer.command(
        both("sim.endDialog", MINUS, |c| {
            find(c)?;
            let which = c.i64(0)?;
            state(c)?.dialogs.open.remove(&which);
            c.ret(1_i64);
            Ok(())
        })
        .param(which())
        .returns(Param::int("done"))
        .text("Closes a dialog."),
    );
    offer.command(
        both("sim.msgBox", MINUS, |c| {
            let (buttons, title, text) = (c.i64(1)?, c.text(2)?, c.text(3)?);
            c.world().log(TATU_LOG_INFO, format!("[{title}] {text}").as_bytes());
            c.ret(if matches!(buttons, 1 | 2) { 2_i64 } else { 3 });
            Ok(())
        })
        .param(Param::int("type").text("sim.msgbox_type_..., ignored"))
        .param(Param::int("buttons").text("sim.msgbox_buttons_..."))
        .param(Param::string("title"))
        .param(Param::string("text"))
        .returns(Param::int("answer").text("2: yes, 3: ok"))
        .text("Writes a message to the log; the answer is yes or ok."),
    );
    offer.command(
        both("sim.fileDialog", NIL, |c| {
            c.ret::<Value>(Value::Nil);
            Ok(())
        })
        .param(Param::any("arguments").rest())
        .returns(Param::string("file").text("nil"))
        .text("Asks for a file: none is chosen, since there is no window.")
        .stub("there is no window to choose a file in: nil"),
    );
}

fn find(c: &Ctx<'_>) -> Result<Dialog> {
    let which = c.i64(0)?;
    let found = state(c)?.dialogs.open.get(&which).cloned();
    found.ok_or_else(|| Fail::missing(format!("there is no dialog {which}")))
}
