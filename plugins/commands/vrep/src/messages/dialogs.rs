//! Commands on dialogs. A view that shows a dialog reports the user's answer. Without such a view, the dialog is
//! answered automatically in the next step, with yes or ok and its initial text.

use crate::{
    kit::*,
    state::{dialogs::Dialog, state},
};

/// The event that publishes windows to views.
const WINDOW_EVENT: &str = "ui.window";
/// The command with which views answer dialogs.
const ANSWER_COMMAND: &str = "tatu.answerDialog";

/// Returns the texts and results of the buttons of a dialog style.
fn buttons(style: i64) -> &'static [(&'static str, i64)] {
    match style {
        1 | 2 => &[("OK", 1)],
        3 => &[("OK", 1), ("Cancel", 2)],
        4 => &[("Yes", 3), ("No", 4)],
        _ => &[],
    }
}

fn map<const N: usize>(entries: [(&str, Value); N]) -> Value {
    Value::Map(entries.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}

/// Publishes a dialog with its text, input field and buttons.
fn show(c: &Ctx<'_>, made: i64, title: &str, text: &str, dialog: &Dialog) -> Result {
    let widget = |element: &str, above: Value, values: Value| {
        map([("element", Value::text(element)), ("above", above), ("values", values)])
    };
    let text = map([("text", Value::text(text.replace("&&n", "\n")))]);
    let mut widgets = vec![
        widget("ui", Value::Nil, map([("title", Value::text(title))])),
        widget("label", Value::Int(0), text),
        widget("group", Value::Int(0), map([("layout", Value::text("hbox")), ("flat", Value::Bool(true))])),
    ];
    let answers = buttons(dialog.style);
    widgets.extend(answers.iter().map(|(t, _)| widget("button", Value::Int(2), map([("text", Value::text(t))]))));
    if dialog.style == 1 {
        widgets.push(widget("edit", Value::Int(0), map([("value", Value::Text(dialog.text.clone()))])));
    }
    let asks = Value::Bool(!answers.is_empty());
    c.world().publish_value(
        WINDOW_EVENT,
        &map([
            ("window", Value::Int(made)),
            ("act", Value::text(ANSWER_COMMAND)),
            ("asks", asks),
            ("widgets", Value::List(widgets)),
        ]),
    )
}

fn hide(c: &Ctx<'_>, made: i64) -> Result {
    let closed =
        map([("window", Value::Int(made)), ("act", Value::text(ANSWER_COMMAND)), ("closed", Value::Bool(true))]);
    c.world().publish_value(WINDOW_EVENT, &closed)
}

/// Performs a user's action on a dialog.
fn answer(c: &mut Ctx<'_>) -> Result {
    let (made, n, what) = (c.i64(0)?, c.i64(1)?, c.text(2)?);
    let over = {
        let mut state = state(c)?;
        let dialog = state.dialogs.open.get_mut(&made);
        let dialog = dialog.ok_or_else(|| Fail::missing(format!("there is no dialog {made}")))?;
        match what.as_str() {
            "attend" => dialog.attended = true,
            "change" => dialog.text = c.bytes(3)?.to_vec(),
            "click" => {
                let at = usize::try_from(n - 3).ok().and_then(|i| buttons(dialog.style).get(i));
                dialog.result = at.ok_or_else(|| Fail::argument(format!("widget {n} is not a button")))?.1;
            }
            other => return Err(Fail::argument(format!("a dialog does not support the action `{other}`"))),
        }
        dialog.result != 0
    };
    if over { hide(c, made) } else { Ok(()) }
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let which = || Param::int("dialog");
    offer.command(
        both(["sim.displayDialog", "simDisplayDialog"], NIL, |c| {
            let (title, text) = (c.text(0)?, c.text(1)?);
            let style = c.i64(2)? & 31;
            let initial = if c.has(4) { c.bytes(4)?.to_vec() } else { Vec::new() };
            let opened = int_of(c, 0, c.plugin().p.step)?;
            let mut state = state(c)?;
            state.dialogs.made += 1;
            let made = state.dialogs.made;
            let dialog = Dialog { style, text: initial, opened, attended: false, result: 0 };
            state.dialogs.open.insert(made, dialog.clone());
            drop(state);
            show(c, made, &title, &text, &dialog)?;
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
        .returns(Param::int("ui").text("-1: the dialog has no window"))
        .text(
            "Opens a dialog, whose text is also logged; the dialog remains open until a view answers it or the script \
             closes it.",
        )
        .notes(
            "Without a view, a dialog is answered automatically in the next step: ok or yes, with the initial text as \
             input. A dialog without buttons remains open. The command never blocks the script.",
        ),
    );
    offer.command(
        both(["sim.getDialogResult", "simGetDialogResult"], MINUS_ONE, |c| {
            let step = int_of(c, 0, c.plugin().p.step)?;
            let dialog = find(c)?;
            c.ret(match dialog.style {
                _ if dialog.attended => dialog.result,
                _ if step <= dialog.opened => 0_i64,
                0 => 0,
                4 => 3,
                _ => 1,
            });
            Ok(())
        })
        .param(which())
        .returns(Param::int("result").text("0: still open, 1: ok, 2: cancel, 3: yes, 4: no"))
        .text("Returns the answer to a dialog."),
    );
    offer.command(
        both(["sim.getDialogInput", "simGetDialogInput"], NIL, |c| {
            let dialog = find(c)?;
            c.ret(dialog.text.as_slice());
            Ok(())
        })
        .param(which())
        .returns(Param::string("text"))
        .text("Returns the content of a dialog's text field."),
    );
    offer.command(
        both(["sim.endDialog", "simEndDialog"], MINUS_ONE, |c| {
            find(c)?;
            let which = c.i64(0)?;
            state(c)?.dialogs.open.remove(&which);
            hide(c, which)?;
            c.ret(1_i64);
            Ok(())
        })
        .param(which())
        .returns(Param::int("done"))
        .text("Closes a dialog."),
    );
    offer.command(
        Cmd::new(ANSWER_COMMAND, answer)
            .param(Param::int("dialog").text("its number"))
            .param(Param::int("n").text("the index of its widget: 3 for the first button"))
            .param(Param::string("what").choices(&["attend", "click", "change"]))
            .param(Param::any("text").optional().text("for change: the text of its text field"))
            .text("Performs a user's action on a dialog. Called by views; `attend` makes the dialog wait for answers.")
            .example(
                "local dialog = sim.displayDialog('Go', 'Shall it go on?', 4, false)\n\
                 tatu.answerDialog(dialog, 0, 'attend')\n\
                 assert(sim.getDialogResult(dialog) == 0)\n\
                 tatu.answerDialog(dialog, 4, 'click')\n\
                 assert(sim.getDialogResult(dialog) == 4)",
            ),
    );
    offer.command(
        both(["sim.msgBox", "simMsgBox"], MINUS_ONE, |c| {
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
        both(["sim.fileDialog", "simFileDialog"], NIL, |c| {
            c.ret(Value::Nil);
            Ok(())
        })
        .param(Param::any("arguments").rest())
        .returns(Param::string("file").text("nil"))
        .text("Returns nil: no file can be chosen, because there is no window.")
        .stub("without a window, no file can be chosen"),
    );
}

fn find(c: &Ctx<'_>) -> Result<Dialog> {
    let which = c.i64(0)?;
    let found = state(c)?.dialogs.open.get(&which).cloned();
    found.ok_or_else(|| Fail::missing(format!("there is no dialog {which}")))
}
