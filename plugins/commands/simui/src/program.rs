//! Commands that open, close and change whole windows.

use serde_json::json;
use tatu_plugin_api::safe::{Offer, Param, Result};

use crate::{
    plugin::{Ctx, MINUS_ONE, NIL, SimUi, both},
    svg,
    window::{Window, borrow_windows, get, publish_in_call, publish_window, set, window},
    xml,
};

/// Start of the examples, which opens a window.
const WINDOW_EXAMPLE: &str = "local ui = simUI.create('<ui title=\"Drive\"><label id=\"1\" text=\"slow\"/></ui>')\n";

fn window_param() -> Param {
    Param::int("window")
}

fn return_success(c: &mut Ctx<'_>) -> Result {
    c.ret(1_i64);
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    offer.command(
        both("simUI.create", MINUS_ONE, |c| {
            let mut nodes = xml::read(&c.text(0)?)?;
            svg::load(c, &mut nodes);
            let script = c.caller_script();
            let made = borrow_windows(c)?.add(Window { script, nodes })?;
            publish_window(c, made)?;
            c.ret(made);
            Ok(())
        })
        .param(Param::string("xml").text("an element <ui> that contains the widgets"))
        .returns(window_param())
        .text("Opens a window described in XML. Views show it, and its callbacks are functions of the calling script.")
        .notes(
            "Elements: ui, label, group, button, hslider, vslider, checkbox, radiobutton, spinbox, edit, progressbar, \
             combobox, tabs and tab, table, tree, image, svg, plot, text-browser, br, stretch.",
        )
        .example("local ui = simUI.create('<ui><button id=\"1\" text=\"Go\" on-click=\"go\"/></ui>')\nassert(ui > 0)"),
    );
    offer.command(
        both("simUI.destroy", MINUS_ONE, |c| {
            let which = window(c)?;
            borrow_windows(c)?.window_mut(which)?;
            borrow_windows(c)?.open.remove(&which);
            publish_in_call(c, json!({ "window": which, "closed": true }))?;
            return_success(c)
        })
        .param(window_param())
        .returns(Param::int("done"))
        .text("Closes and removes a window.")
        .example(format!("{WINDOW_EXAMPLE}simUI.destroy(ui)\nassert(not pcall(simUI.destroy, ui))")),
    );
    for (name, shown) in [("simUI.show", true), ("simUI.hide", false)] {
        offer.command(
            both(name, MINUS_ONE, move |c| {
                set(c, (window(c)?, 0), &[("visible", json!(shown))])?;
                return_success(c)
            })
            .param(window_param())
            .returns(Param::int("done"))
            .text(if shown { "Shows a window that was hidden." } else { "Hides a window." })
            .example(format!("{WINDOW_EXAMPLE}{name}(ui)\nassert(simUI.isVisible(ui) == {shown})")),
        );
    }
    offer.command(
        both("simUI.isVisible", NIL, |c| {
            let hidden = get(c, (window(c)?, 0), "visible")? == json!(false);
            c.ret(!hidden);
            Ok(())
        })
        .param(window_param())
        .returns(Param::bool("visible"))
        .text("Returns whether a window is shown.")
        .example(format!("{WINDOW_EXAMPLE}assert(simUI.isVisible(ui))")),
    );
    offer.command(
        both("simUI.setTitle", MINUS_ONE, |c| {
            set(c, (window(c)?, 0), &[("title", json!(c.text(1)?))])?;
            return_success(c)
        })
        .param(window_param())
        .param(Param::string("title"))
        .param(Param::any("suppressEvents").optional().text("ignored"))
        .returns(Param::int("done"))
        .text("Sets the title of a window.")
        .example(format!("{WINDOW_EXAMPLE}simUI.setTitle(ui, 'Arm')\nassert(simUI.getTitle(ui) == 'Arm')")),
    );
    offer.command(
        both("simUI.getTitle", NIL, |c| {
            let title = get(c, (window(c)?, 0), "title")?;
            c.ret(title.as_str().unwrap_or(""));
            Ok(())
        })
        .param(window_param())
        .returns(Param::string("title"))
        .text("Returns the title of a window.")
        .example(format!("{WINDOW_EXAMPLE}assert(simUI.getTitle(ui) == 'Drive')")),
    );
    offer.command(
        both("simUI.setWindowEnabled", MINUS_ONE, |c| {
            set(c, (window(c)?, 0), &[("enabled", json!(c.arg(1).truthy()))])?;
            return_success(c)
        })
        .param(window_param())
        .param(Param::any("enabled"))
        .returns(Param::int("done"))
        .text("Enables or disables a window.")
        .example(format!("{WINDOW_EXAMPLE}simUI.setWindowEnabled(ui, false)")),
    );
    for (set_name, get_name, keys, what, from) in [
        (
            "simUI.setPosition",
            "simUI.getPosition",
            ["x", "y"],
            "position",
            ", relative to the upper left corner of the view",
        ),
        ("simUI.setSize", "simUI.getSize", ["width", "height"], "size", ""),
    ] {
        offer.command(
            both(set_name, MINUS_ONE, move |c| {
                let (a, b) = (c.i64(1)?, c.i64(2)?);
                set(c, (window(c)?, 0), &[(keys[0], json!(a)), (keys[1], json!(b))])?;
                return_success(c)
            })
            .param(window_param())
            .param(Param::int(keys[0]).unit("px"))
            .param(Param::int(keys[1]).unit("px"))
            .returns(Param::int("done"))
            .text(format!("Sets the {what} of a window{from}."))
            .example(format!(
                "{WINDOW_EXAMPLE}{set_name}(ui, 40, 60)\nlocal a, b = {get_name}(ui)\nassert(a == 40 and b == 60)"
            )),
        );
        offer.command(
            both(get_name, NIL, move |c| {
                for key in keys {
                    let x = get(c, (window(c)?, 0), key)?;
                    c.ret(x.as_f64().unwrap_or(0.0) as i64);
                }
                Ok(())
            })
            .param(window_param())
            .returns(Param::int(keys[0]).unit("px"))
            .returns(Param::int(keys[1]).unit("px"))
            .text(format!("Returns the {what} that a script has set for a window; 0 if it was not set."))
            .example(format!("{WINDOW_EXAMPLE}local a, b = {get_name}(ui)\nassert(a == 0 and b == 0)")),
        );
    }
}
