//! Commands that create and remove windows of buttons.

use super::{
    by_handle::{add_window, with_window},
    view_updates,
};
use crate::{
    kit::*,
    state::{
        state,
        windows::{Window, WindowButton, bits},
    },
};

/// Attribute of a window that users can move.
const MOVEABLE: i64 = 4;

/// Adds commands that create and remove windows.
pub(super) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.createUI", "simCreateUI"], MINUS_ONE, |c| {
            let (name, cells) = (c.text(0)?, numbers::<2>(c, 2)?);
            let cells = cells.map(|x| x as i64);
            // Argument 1 only selects buttons in the title, which are not supported. Attributes are set by
            // `sim.setUIProperty`.
            let attributes = bits::VISIBLE | MOVEABLE;
            let handle = add_window(c, Window { name, attributes, cells, ..Default::default() })?;
            view_updates::publish_whole_window(c, handle)?;
            c.ret(handle);
            Ok(())
        })
        .param(Param::string("name"))
        .param(Param::int("menu").text("sim.ui_menu_..."))
        .param(table("cells", "{columns, rows}"))
        .param(Param::any("more").rest().text("size of a cell and buttons: ignored"))
        .returns(Param::int("window"))
        .text("Creates a window of buttons.")
        .partial("The title has no buttons. To add buttons to the window, use `sim.createUIButton`."),
    );
    offer.command(
        both(["sim.createUIButton", "simCreateUIButton"], MINUS_ONE, |c| {
            let (which, at, size, attributes) = (c.i64(0)?, numbers::<2>(c, 1)?, numbers::<2>(c, 2)?, c.i64(3)?);
            let made = with_window(c, which, |w| {
                let handle = w.buttons.iter().map(|b| b.handle).max().unwrap_or(0) + 1;
                let cells = [size[0], size[1], at[0], at[1]].map(|x| x as i64);
                w.buttons.push(WindowButton { handle, attributes, cells, ..Default::default() });
                handle
            })?;
            view_updates::publish_whole_window(c, which)?;
            c.ret(made);
            Ok(())
        })
        .param(Param::int("window"))
        .param(table("position", "{column, row}"))
        .param(table("size", "{columns, rows}"))
        .param(Param::int("bits").text("sim.buttonproperty_..."))
        .returns(Param::int("button"))
        .text("Adds a button to a window."),
    );
    offer.command(
        both(["sim.removeUI", "simRemoveUI"], MINUS_ONE, |c| {
            let which = c.i64(0)?;
            let all = which == HANDLE_ALL;
            let gone: Vec<i64> = {
                let mut state = state(c)?;
                let is_gone = |w: &Window| all || w.handle == which;
                let gone = state.registered.windows.iter().filter(|w| is_gone(w)).map(|w| w.handle).collect();
                state.registered.windows.retain(|w| !is_gone(w));
                gone
            };
            if gone.is_empty() && !all {
                return Err(Fail::missing(format!("there is no window {which}")));
            }
            gone.into_iter().try_for_each(|window| view_updates::publish_removal(c, window))?;
            finish_setter(c)
        })
        .param(Param::int("window").text("a handle, or sim.handle_all"))
        .returns(Param::int("result"))
        .text("Removes a window of buttons."),
    );
}
