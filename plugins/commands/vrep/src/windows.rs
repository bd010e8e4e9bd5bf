//! Windows with buttons, sliders and labels in scenes before version 3.3. Their content is stored and can be read;
//! buttons can be pressed only in a view that shows them.

use crate::{
    kit::*,
    lookup::registered::by_name,
    state::{
        state,
        windows::{Button, Window},
    },
};

const NOTES: &str = "Its contents are stored and returned; it can be seen and operated only in a view.";

/// First handle of windows that scripts create.
const FIRST: i64 = 2_069_000;

fn of_window<T>(c: &Ctx<'_>, which: i64, change: impl FnOnce(&mut Window) -> T) -> Result<T> {
    let mut state = state(c)?;
    let found = state.registered.windows.iter_mut().find(|w| w.handle == which);
    found.map(change).ok_or_else(|| Fail::missing(format!("there is no window {which}")))
}

/// Applies `change` to the button that the first two arguments name.
fn of_button<T>(c: &Ctx<'_>, change: impl FnOnce(&mut Button) -> T) -> Result<T> {
    let (which, button) = (c.i64(0)?, c.i64(1)?);
    let found = of_window(c, which, |w| w.buttons.iter_mut().find(|b| b.handle == button).map(change))?;
    found.ok_or_else(|| Fail::missing(format!("window {which} has no button {button}")))
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let window = || Param::int("window");
    let button = |command: Cmd| command.param(Param::int("window")).param(Param::int("button"));
    offer.command(
        both(["sim.getUIHandle", "simGetUIHandle"], MINUS, |c| {
            let name = c.text(0)?;
            let all: Vec<(String, i64)> =
                state(c)?.registered.windows.iter().map(|w| (w.name.clone(), w.handle)).collect();
            match by_name(c, &name, all.iter().map(|(n, h)| (n.as_str(), *h)))? {
                Some(found) => c.ret(found),
                None if c.world().makes_stand_ins() || name.contains("@silentError") => c.ret(-1_i64),
                None => return Err(Fail::missing(format!("there is no window `{name}`"))),
            }
            Ok(())
        })
        .param(Param::string("name"))
        .returns(window())
        .text("Finds a window of buttons in the scene.")
        .partial(NOTES),
    );
    offer.command(
        button(both(["sim.getUIButtonLabel", "simGetUIButtonLabel"], NIL, |c| {
            let label = of_button(c, |b| b.labels[0].clone())?;
            c.ret(label.as_str());
            Ok(())
        }))
        .returns(Param::string("label"))
        .text("Returns the label of a button.")
        .partial(NOTES),
    );
    offer.command(
        button(both(["sim.setUIButtonLabel", "simSetUIButtonLabel"], MINUS, |c| {
            let text = |i: usize| if c.has(i) { c.text(i).map(Some) } else { Ok(None) };
            let labels = [text(2)?, text(3)?];
            of_button(c, |b| {
                for (label, new) in b.labels.iter_mut().zip(labels) {
                    *label = new.unwrap_or_else(|| std::mem::take(label));
                }
            })?;
            done(c)
        }))
        .param(Param::string("up").optional().text("nil: as it is"))
        .param(Param::string("down").optional().text("its label while it is pressed; nil: unchanged"))
        .returns(Param::int("result"))
        .text("Sets the label of a button.")
        .partial(NOTES),
    );
    offer.command(
        button(both(["sim.getUISlider", "simGetUISlider"], MINUS, |c| {
            let at = of_button(c, |b| b.slider)?;
            c.ret(at.round() as i64);
            Ok(())
        }))
        .returns(Param::int("position").text("0 to 1000"))
        .text("Returns the position of a slider.")
        .partial(NOTES),
    );
    offer.command(
        button(both(["sim.setUISlider", "simSetUISlider"], MINUS, |c| {
            let at = c.f64(2)?.clamp(0.0, 1000.0);
            of_button(c, |b| b.slider = at)?;
            done(c)
        }))
        .param(Param::float("position").text("0 to 1000"))
        .returns(Param::int("result"))
        .text("Moves a slider.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.getUIEventButton", "simGetUIEventButton"], MINUS, |c| {
            let which = c.i64(0)?;
            of_window(c, which, |_| ())?;
            c.ret(-1_i64);
            c.ret(&[0_i64, 0][..]);
            Ok(())
        })
        .param(window())
        .returns(Param::int("button").text("-1: none was pressed"))
        .returns(Param::list("values"))
        .text("Returns the button that was pressed last.")
        .partial("No view can press buttons yet, so no button is ever pressed."),
    );
    properties(offer);
    making(offer);
}

/// Adds commands on flags of windows and buttons, colours and positions.
fn properties(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.getUIProperty", "simGetUIProperty"], MINUS, |c| {
            let which = c.i64(0)?;
            let bits = of_window(c, which, |w| w.attributes)?;
            c.ret(bits);
            Ok(())
        })
        .param(Param::int("window"))
        .returns(Param::int("bits").text("sim.ui_property_..."))
        .text("Returns the properties of a window.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.setUIProperty", "simSetUIProperty"], MINUS, |c| {
            let (which, bits) = (c.i64(0)?, c.i64(1)?);
            of_window(c, which, |w| w.attributes = bits)?;
            done(c)
        })
        .param(Param::int("window"))
        .param(Param::int("bits").text("sim.ui_property_..."))
        .returns(Param::int("result"))
        .text("Sets the properties of a window.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.getUIButtonProperty", "simGetUIButtonProperty"], MINUS, |c| {
            let bits = of_button(c, |b| b.attributes)?;
            c.ret(bits);
            Ok(())
        })
        .param(Param::int("window"))
        .param(Param::int("button"))
        .returns(Param::int("bits").text("sim.buttonproperty_..."))
        .text("Returns the type and appearance of a button.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.setUIButtonProperty", "simSetUIButtonProperty"], MINUS, |c| {
            let bits = c.i64(2)?;
            of_button(c, |b| b.attributes = bits)?;
            done(c)
        })
        .param(Param::int("window"))
        .param(Param::int("button"))
        .param(Param::int("bits").text("sim.buttonproperty_..."))
        .returns(Param::int("result"))
        .text("Sets the type and appearance of a button.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.setUIButtonColor", "simSetUIButtonColor"], MINUS, |c| {
            of_button(c, |_| ())?;
            done(c)
        })
        .param(Param::int("window"))
        .param(Param::int("button"))
        .param(Param::any("colors").rest().text("pressed, not pressed, of the label"))
        .returns(Param::int("result"))
        .text("Colours a button.")
        .stub("colours are not kept"),
    );
    offer.command(
        both(["sim.getUIPosition", "simGetUIPosition"], NIL, |c| {
            let which = c.i64(0)?;
            let at = of_window(c, which, |w| w.position)?;
            c.ret(&at[..]);
            Ok(())
        })
        .param(Param::int("window"))
        .returns(Param::list("position").text("pixels"))
        .text("Returns the position of a window.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.setUIPosition", "simSetUIPosition"], MINUS, |c| {
            let (which, at) = (c.i64(0)?, numbers::<2>(c, 1)?);
            of_window(c, which, |w| w.position = at.map(|x| x as i64))?;
            done(c)
        })
        .param(Param::int("window"))
        .param(table("position", "{x, y}, pixels"))
        .returns(Param::int("result"))
        .text("Moves a window.")
        .partial(NOTES),
    );
}

/// Adds commands that create and remove windows.
fn making(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.createUI", "simCreateUI"], MINUS, |c| {
            let (name, attributes, cells) = (c.text(0)?, c.i64(1)?, numbers::<2>(c, 2)?);
            let mut state = state(c)?;
            let taken = state.registered.windows.iter().map(|w| w.handle).max().unwrap_or(0);
            let handle = FIRST.max(taken + 1);
            let cells = cells.map(|x| x as i64);
            state.registered.windows.push(Window { name, handle, object: -1, attributes, cells, ..Default::default() });
            drop(state);
            c.ret(handle);
            Ok(())
        })
        .param(Param::string("name"))
        .param(Param::int("menu").text("sim.ui_menu_..."))
        .param(table("cells", "{columns, rows}"))
        .param(Param::any("more").rest().text("size of a cell and buttons: ignored"))
        .returns(Param::int("window"))
        .text("Creates a window of buttons.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.createUIButton", "simCreateUIButton"], MINUS, |c| {
            let (which, at, size, attributes) = (c.i64(0)?, numbers::<2>(c, 1)?, numbers::<2>(c, 2)?, c.i64(3)?);
            let made = of_window(c, which, |w| {
                let handle = w.buttons.iter().map(|b| b.handle).max().unwrap_or(0) + 1;
                let cells = [size[0], size[1], at[0], at[1]].map(|x| x as i64);
                w.buttons.push(Button { handle, attributes, cells, ..Default::default() });
                handle
            })?;
            c.ret(made);
            Ok(())
        })
        .param(Param::int("window"))
        .param(table("position", "{column, row}"))
        .param(table("size", "{columns, rows}"))
        .param(Param::int("bits").text("sim.buttonproperty_..."))
        .returns(Param::int("button"))
        .text("Adds a button to a window.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.removeUI", "simRemoveUI"], MINUS, |c| {
            let which = c.i64(0)?;
            let all = which == HANDLE_ALL;
            let mut state = state(c)?;
            let before = state.registered.windows.len();
            state.registered.windows.retain(|w| !all && w.handle != which);
            let gone = before - state.registered.windows.len();
            drop(state);
            if gone == 0 && !all {
                return Err(Fail::missing(format!("there is no window {which}")));
            }
            done(c)
        })
        .param(Param::int("window").text("or sim.handle_all"))
        .returns(Param::int("result"))
        .text("Removes a window of buttons."),
    );
}
