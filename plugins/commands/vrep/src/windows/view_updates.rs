//! Publishes changes of windows of buttons to views, and performs the user actions that views report.

use super::by_handle::{with_button, with_button_argument, with_window};
use crate::{
    kit::*,
    state::{
        state,
        window_views::{ACTION_COMMAND, button_values, publish, publish_window},
        windows::{MAX_SLIDER_POSITION, WindowButton, bits},
    },
};

/// Publishes a whole window, new or changed.
pub(super) fn publish_whole_window(c: &Ctx<'_>, window: i64) -> Result {
    let of = with_window(c, window, |w| w.clone())?;
    let object = state(c)?.registered.object(of.object);
    publish_window(c, &of, object)
}

/// Publishes a changed button.
pub(super) fn publish_button(c: &Ctx<'_>, window: i64, button: i64) -> Result {
    let found = with_window(c, window, |w| {
        let n = w.buttons.iter().position(|b| b.handle == button)?;
        Some((n, button_values(w, n)))
    })?;
    let Some((n, values)) = found else { return Ok(()) };
    publish(c, window, [("n", Value::Int(n as i64 + 1)), ("set", values)])
}

/// Publishes the removal of a window.
pub(super) fn publish_removal(c: &Ctx<'_>, window: i64) -> Result {
    publish(c, window, [("closed", Value::Bool(true))])
}

/// Applies `change` to the button that the first two arguments identify, and publishes the button.
pub(super) fn change_button(c: &mut Ctx<'_>, change: impl FnOnce(&mut WindowButton)) -> Result {
    with_button_argument(c, change)?;
    publish_button(c, c.i64(0)?, c.i64(1)?)?;
    finish_setter(c)
}

/// Performs a user's action on a button.
fn perform_action(c: &mut Ctx<'_>) -> Result {
    let (window, n, what) = (c.i64(0)?, c.i64(1)?, c.text(2)?);
    let button = with_window(c, window, |w| {
        let at = n.checked_sub(1).and_then(|n| usize::try_from(n).ok())?;
        w.buttons.get(at).map(|b| b.handle)
    })?;
    let button = button.ok_or_else(|| Fail::missing(format!("window {window} has no button with index {n}")))?;
    let given = c.arg(3);
    let number = given.as_f64().filter(|x| x.is_finite());
    let text = given.as_str().map(|t| t.into_owned());
    let attributes = with_button(c, window, button, |b| {
        if !b.is_active() {
            return Err(Fail::argument("the button is disabled or ignores the mouse"));
        }
        let down = |b: &WindowButton| i64::from(b.has(bits::IS_DOWN));
        let first = match (what.as_str(), b.kind()) {
            ("click", bits::BUTTON) if b.has(bits::STAYS_DOWN) => {
                b.attributes ^= bits::IS_DOWN;
                down(b)
            }
            ("click", bits::BUTTON) => 0,
            ("press" | "release", bits::BUTTON) if b.has(bits::DOWN_AND_UP) => {
                b.attributes &= !bits::IS_DOWN;
                b.attributes |= if what == "press" { bits::IS_DOWN } else { 0 };
                down(b)
            }
            ("change", bits::SLIDER) => {
                let at = number.ok_or_else(|| Fail::argument("argument 4: expected a finite number"))?;
                b.slider = at.clamp(0.0, MAX_SLIDER_POSITION).round();
                b.slider as i64
            }
            ("change", bits::EDIT) => {
                b.labels[0] = text.ok_or_else(|| Fail::argument("argument 4: expected a string"))?;
                0
            }
            _ => return Err(Fail::argument(format!("the button does not support the action `{what}`"))),
        };
        Ok((b.attributes, first))
    })?;
    let (attributes, first) = attributes?;
    with_window(c, window, |w| {
        w.event = Some((button, [first, 0]));
        if what == "click" && attributes & bits::ROLLS_UP != 0 {
            w.attributes ^= bits::ROLLED_UP;
        }
        if what == "click" && attributes & bits::CLOSES != 0 {
            w.attributes &= !bits::VISIBLE;
        }
    })?;
    if attributes & (bits::ROLLS_UP | bits::CLOSES) != 0 {
        publish_whole_window(c, window)
    } else {
        publish_button(c, window, button)
    }
}

pub(super) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new(ACTION_COMMAND, perform_action)
            .param(Param::int("window"))
            .param(Param::int("n").text("index of the button in its window, from 1"))
            .param(Param::string("what").choices(&["click", "press", "release", "change"]))
            .param(Param::any("value").optional().text("change: position of a slider, text of an edit field"))
            .text("Performs a user's action on a window of buttons; `sim.getUIEventButton` then returns the button.")
            .notes("Called by views. The event `ui.window` lists the buttons in this order."),
    );
}
