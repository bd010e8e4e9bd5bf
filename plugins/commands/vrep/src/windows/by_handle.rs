//! Finds windows and buttons by their handles, and adds new windows.

use crate::{
    kit::*,
    state::{
        state,
        windows::{Window, WindowButton},
    },
};

/// First handle of a window that a script creates, or that replaces a missing one in a run without a scene.
const FIRST_HANDLE: i64 = 2_069_000;

pub(super) fn with_window<T>(c: &Ctx<'_>, which: i64, change: impl FnOnce(&mut Window) -> T) -> Result<T> {
    let mut state = state(c)?;
    let found = state.registered.windows.iter_mut().find(|w| w.handle == which);
    found.map(change).ok_or_else(|| Fail::missing(format!("there is no window {which}")))
}

/// Applies `change` to a button. In a run without a scene, a missing button is added to the window.
pub(super) fn with_button<T>(
    c: &Ctx<'_>,
    which: i64,
    button: i64,
    change: impl FnOnce(&mut WindowButton) -> T,
) -> Result<T> {
    let stand_in = c.world().makes_stand_ins();
    let found = with_window(c, which, |w| {
        if stand_in && !w.buttons.iter().any(|b| b.handle == button) {
            w.buttons.push(WindowButton { handle: button, ..Default::default() });
        }
        w.buttons.iter_mut().find(|b| b.handle == button).map(change)
    })?;
    found.ok_or_else(|| Fail::missing(format!("window {which} has no button {button}")))
}

/// Applies `change` to the button that the first two arguments identify.
pub(super) fn with_button_argument<T>(c: &Ctx<'_>, change: impl FnOnce(&mut WindowButton) -> T) -> Result<T> {
    with_button(c, c.i64(0)?, c.i64(1)?, change)
}

/// Adds a window, and returns its handle.
pub(super) fn add_window(c: &Ctx<'_>, window: Window) -> Result<i64> {
    let mut state = state(c)?;
    let taken = state.registered.windows.iter().map(|w| w.handle).max().unwrap_or(0);
    let handle = FIRST_HANDLE.max(taken + 1);
    state.registered.windows.push(Window { handle, object: -1, ..window });
    Ok(handle)
}

pub(super) fn with_button_params(command: Cmd) -> Cmd {
    command.param(Param::int("window")).param(Param::int("button"))
}
