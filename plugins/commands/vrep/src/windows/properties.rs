//! Commands on the flags, colours and positions of windows of buttons.

use super::{
    by_handle::{with_button_argument, with_window},
    view_updates::{self, change_button},
};
use crate::kit::*;

/// Adds commands on flags of windows and buttons, colours and positions.
pub(super) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.getUIProperty", "simGetUIProperty"], MINUS_ONE, |c| {
            let which = c.i64(0)?;
            let bits = with_window(c, which, |w| w.attributes)?;
            c.ret(bits);
            Ok(())
        })
        .param(Param::int("window"))
        .returns(Param::int("bits").text("sim.ui_property_..."))
        .text("Returns the properties of a window."),
    );
    offer.command(
        both(["sim.setUIProperty", "simSetUIProperty"], MINUS_ONE, |c| {
            let (which, bits) = (c.i64(0)?, c.i64(1)?);
            with_window(c, which, |w| w.attributes = bits)?;
            view_updates::publish_whole_window(c, which)?;
            finish_setter(c)
        })
        .param(Param::int("window"))
        .param(Param::int("bits").text("sim.ui_property_..."))
        .returns(Param::int("result"))
        .text("Sets the properties of a window."),
    );
    offer.command(
        both(["sim.getUIButtonProperty", "simGetUIButtonProperty"], MINUS_ONE, |c| {
            let bits = with_button_argument(c, |b| b.attributes)?;
            c.ret(bits);
            Ok(())
        })
        .param(Param::int("window"))
        .param(Param::int("button"))
        .returns(Param::int("bits").text("sim.buttonproperty_..."))
        .text("Returns the type and appearance of a button."),
    );
    offer.command(
        both(["sim.setUIButtonProperty", "simSetUIButtonProperty"], MINUS_ONE, |c| {
            let bits = c.i64(2)?;
            change_button(c, |b| b.attributes = bits)
        })
        .param(Param::int("window"))
        .param(Param::int("button"))
        .param(Param::int("bits").text("sim.buttonproperty_..."))
        .returns(Param::int("result"))
        .text("Sets the type and appearance of a button."),
    );
    offer.command(
        both(["sim.setUIButtonColor", "simSetUIButtonColor"], MINUS_ONE, |c| {
            let color = |i: usize| if c.has(i) { numbers::<3>(c, i).map(Some) } else { Ok(None) };
            let colors = [color(2)?, color(3)?, color(4)?];
            change_button(c, |b| {
                for (old, new) in b.colors.iter_mut().zip(colors) {
                    *old = new.or(*old);
                }
            })
        })
        .param(Param::int("window"))
        .param(Param::int("button"))
        .param(Param::list("up").optional().text("{red, green, blue}, 0 to 1; nil: unchanged"))
        .param(Param::list("down").optional().text("the colour while pressed"))
        .param(Param::list("label").optional())
        .returns(Param::int("result"))
        .text("Sets the colours of a button."),
    );
    offer.command(
        both(["sim.getUIPosition", "simGetUIPosition"], NIL, |c| {
            let which = c.i64(0)?;
            let at = with_window(c, which, |w| w.position)?;
            c.ret(&at[..]);
            Ok(())
        })
        .param(Param::int("window"))
        .returns(Param::list("position").text("pixels"))
        .text("Returns the position of a window."),
    );
    offer.command(
        both(["sim.setUIPosition", "simSetUIPosition"], MINUS_ONE, |c| {
            let (which, at) = (c.i64(0)?, numbers::<2>(c, 1)?);
            with_window(c, which, |w| w.position = at.map(|x| x as i64))?;
            finish_setter(c)
        })
        .param(Param::int("window"))
        .param(table("position", "{x, y}, pixels"))
        .returns(Param::int("result"))
        .text("Moves a window."),
    );
}
