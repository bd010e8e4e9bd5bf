//! Commands on windows with buttons, sliders and labels, in scenes before V-REP 3.3. Views show these windows and
//! report user actions.

mod by_handle;
mod creation;
mod properties;
mod view_updates;

use crate::{
    kit::*,
    lookup::registered::by_name,
    state::{
        state,
        windows::{MAX_SLIDER_POSITION, Window},
    },
};

use self::{
    by_handle::{add_window, with_button_argument, with_button_params, with_window},
    view_updates::change_button,
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let window = || Param::int("window");
    offer.command(
        both(["sim.getUIHandle", "simGetUIHandle"], MINUS_ONE, |c| {
            let name = c.text(0)?;
            let all: Vec<(String, i64)> =
                state(c)?.registered.windows.iter().map(|w| (w.name.clone(), w.handle)).collect();
            match by_name(c, &name, all.iter().map(|(n, h)| (n.as_str(), *h)))? {
                Some(found) => c.ret(found),
                None if name.contains("@silentError") => c.ret(-1_i64),
                None if c.world().makes_stand_ins() => {
                    let made = add_window(c, Window { name, ..Default::default() })?;
                    c.ret(made);
                }
                None => return Err(Fail::missing(format!("there is no window `{name}`"))),
            }
            Ok(())
        })
        .param(Param::string("name"))
        .returns(window())
        .text("Finds a window of buttons in the scene."),
    );
    offer.command(
        with_button_params(both(["sim.getUIButtonLabel", "simGetUIButtonLabel"], NIL, |c| {
            let label = with_button_argument(c, |b| b.labels[0].clone())?;
            c.ret(label.as_str());
            Ok(())
        }))
        .returns(Param::string("label"))
        .text("Returns the label of a button."),
    );
    offer.command(
        with_button_params(both(["sim.setUIButtonLabel", "simSetUIButtonLabel"], MINUS_ONE, |c| {
            let text = |i: usize| if c.has(i) { c.text(i).map(Some) } else { Ok(None) };
            let labels = [text(2)?, text(3)?];
            change_button(c, |b| {
                for (label, new) in b.labels.iter_mut().zip(labels) {
                    *label = new.unwrap_or_else(|| std::mem::take(label));
                }
            })
        }))
        .param(Param::string("up").optional().text("its label; nil: unchanged"))
        .param(Param::string("down").optional().text("its label while pressed; nil: unchanged"))
        .returns(Param::int("result"))
        .text("Sets the label of a button."),
    );
    offer.command(
        with_button_params(both(["sim.getUISlider", "simGetUISlider"], MINUS_ONE, |c| {
            let at = with_button_argument(c, |b| b.slider)?;
            c.ret(at.round() as i64);
            Ok(())
        }))
        .returns(Param::int("position").text("0 to 1000"))
        .text("Returns the position of a slider."),
    );
    offer.command(
        with_button_params(both(["sim.setUISlider", "simSetUISlider"], MINUS_ONE, |c| {
            let at = c.f64(2)?.clamp(0.0, MAX_SLIDER_POSITION);
            change_button(c, |b| b.slider = at)
        }))
        .param(Param::float("position").text("0 to 1000"))
        .returns(Param::int("result"))
        .text("Moves a slider."),
    );
    offer.command(
        both(["sim.getUIEventButton", "simGetUIEventButton"], MINUS_ONE, |c| {
            let which = c.i64(0)?;
            let (button, values) = with_window(c, which, |w| w.event.take())?.unwrap_or((-1, [0, 0]));
            c.ret(button);
            c.ret(&values[..]);
            Ok(())
        })
        .param(window())
        .returns(Param::int("button").text("-1: no button was operated"))
        .returns(Param::list("values").text("for a slider, its position; for a button, 1 if it is down; then 0"))
        .text("Returns the button that a user operated last, and clears it, so that it is returned only once.")
        .notes("Only the last button of each window is stored."),
    );
    properties::offer(offer);
    creation::offer(offer);
    view_updates::offer(offer);
}
