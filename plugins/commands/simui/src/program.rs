//! Commands that open, close and change whole windows.

use serde_json::json;
use tatu_plugin_api::safe::{Offer, Param, Result};

use crate::{
    plugin::{Ctx, MINUS, NIL, SimUi, both},
    svg,
    window::{Window, all, get, opened, set, tell, window},
    xml,
};

/// Start of the examples, which opens a window.
const MADE: &str = "local ui = simUI.create('<ui title=\"Drive\"><label id=\"1\" text=\"slow\"/></ui>')\n";

fn which() -> Param {
    Param::int("window")
}

fn done(c: &mut Ctx<'_>) -> Result {
    c.ret(1_i64);
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    offer.command(
        both("simUI.create", MINUS, |c| {
            let mut nodes = xml::read(&c.text(0)?)?;
            svg::load(c, &mut nodes);
            let script = c.caller_script();
            let made = all(c)?.add(Window { script, nodes })?;
            opened(c, made)?;
            c.ret(made);
            Ok(())
        })
        .param(Param::string("xml").text("an element <ui> that contains the widgets"))
        .returns(which())
        .text("Opens a window described in XML. Views show it, and its callbacks are functions of the calling script.")
        .notes(
            "Elements: ui, label, group, button, hslider, vslider, checkbox, radiobutton, spinbox, edit, progressbar, \
             combobox, tabs and tab, table, tree, image, svg, plot, text-browser, br, stretch.",
        )
        .example("local ui = simUI.create('<ui><button id=\"1\" text=\"Go\" on-click=\"go\"/></ui>')\nassert(ui > 0)"),
    );
    offer.command(
        both("simUI.destroy", MINUS, |c| {
            let which = window(c)?;
            all(c)?.of(which)?;
            all(c)?.open.remove(&which);
            tell(c, json!({ "window": which, "closed": true }))?;
            done(c)
        })
        .param(which())
        .returns(Param::int("done"))
        .text("Closes and removes a window.")
        .example(format!("{MADE}simUI.destroy(ui)\nassert(not pcall(simUI.destroy, ui))")),
    );
    for (name, shown) in [("simUI.show", true), ("simUI.hide", false)] {
        offer.command(
            both(name, MINUS, move |c| {
                set(c, (window(c)?, 0), &[("visible", json!(shown))])?;
                done(c)
            })
            .param(which())
            .returns(Param::int("done"))
            .text(if shown { "Shows a window that was hidden." } else { "Hides a window." })
            .example(format!("{MADE}{name}(ui)\nassert(simUI.isVisible(ui) == {shown})")),
        );
    }
    offer.command(
        both("simUI.isVisible", NIL, |c| {
            let hidden = get(c, (window(c)?, 0), "visible")? == json!(false);
            c.ret(!hidden);
            Ok(())
        })
        .param(which())
        .returns(Param::bool("visible"))
        .text("Returns whether a window is shown.")
        .example(format!("{MADE}assert(simUI.isVisible(ui))")),
    );
    offer.command(
        both("simUI.setTitle", MINUS, |c| {
            set(c, (window(c)?, 0), &[("title", json!(c.text(1)?))])?;
            done(c)
        })
        .param(which())
        .param(Param::string("title"))
        .param(Param::any("suppressEvents").optional().text("ignored"))
        .returns(Param::int("done"))
        .text("Sets the title of a window.")
        .example(format!("{MADE}simUI.setTitle(ui, 'Arm')\nassert(simUI.getTitle(ui) == 'Arm')")),
    );
    offer.command(
        both("simUI.getTitle", NIL, |c| {
            let title = get(c, (window(c)?, 0), "title")?;
            c.ret(title.as_str().unwrap_or(""));
            Ok(())
        })
        .param(which())
        .returns(Param::string("title"))
        .text("Returns the title of a window.")
        .example(format!("{MADE}assert(simUI.getTitle(ui) == 'Drive')")),
    );
    offer.command(
        both("simUI.setWindowEnabled", MINUS, |c| {
            set(c, (window(c)?, 0), &[("enabled", json!(c.arg(1).truthy()))])?;
            done(c)
        })
        .param(which())
        .param(Param::any("enabled"))
        .returns(Param::int("done"))
        .text("Enables or disables a window.")
        .example(format!("{MADE}simUI.setWindowEnabled(ui, false)")),
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
            both(set_name, MINUS, move |c| {
                let (a, b) = (c.i64(1)?, c.i64(2)?);
                set(c, (window(c)?, 0), &[(keys[0], json!(a)), (keys[1], json!(b))])?;
                done(c)
            })
            .param(which())
            .param(Param::int(keys[0]).unit("px"))
            .param(Param::int(keys[1]).unit("px"))
            .returns(Param::int("done"))
            .text(format!("Sets the {what} of a window{from}."))
            .example(format!("{MADE}{set_name}(ui, 40, 60)\nlocal a, b = {get_name}(ui)\nassert(a == 40 and b == 60)")),
        );
        offer.command(
            both(get_name, NIL, move |c| {
                for key in keys {
                    let x = get(c, (window(c)?, 0), key)?;
                    c.ret(x.as_f64().unwrap_or(0.0) as i64);
                }
                Ok(())
            })
            .param(which())
            .returns(Param::int(keys[0]).unit("px"))
            .returns(Param::int(keys[1]).unit("px"))
            .text(format!("Returns the {what} that a script has set for a window; 0 if it was not set."))
            .example(format!("{MADE}local a, b = {get_name}(ui)\nassert(a == 0 and b == 0)")),
        );
    }
}
