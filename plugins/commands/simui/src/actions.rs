//! User actions on windows, and the script functions called for them.

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Offer, Param, Result, Value};

use crate::{
    plugin::{Cmd, Ctx, SimUi},
    window::{borrow_windows, get, set, value},
};

/// The actions that `tatu.actOnWindow` accepts.
const ACTIONS: &[&str] = &["click", "change", "close", "link", "select"];

/// Calls the script function that a widget declares for an event, if any. The first arguments of the function are the
/// number of the window and, unless the event concerns the window itself, the id of the widget.
fn call(c: &Ctx<'_>, (window, n): (i64, usize), event: &str, rest: &[Json]) -> Result {
    let (script, id, function) = {
        let mut all = borrow_windows(c)?;
        let of = all.window_mut(window)?;
        let node = &of.nodes[n];
        let Some(name) = node.values.get(event).and_then(Json::as_str).filter(|f| !f.is_empty()) else { return Ok(()) };
        (of.script, node.id.clone(), name.to_owned())
    };
    if script == 0 {
        return Ok(());
    }
    let mut args = vec![Value::Int(window)];
    if n != 0 {
        args.push(id.parse().map_or_else(|_| Value::text(&id), Value::Int));
    }
    args.extend(rest.iter().map(value));
    c.world().call_function(script, &function, &args).map(|_| ())
}

/// Calls the script function that a widget declares in `on-change`.
pub(crate) fn call_back(c: &Ctx<'_>, at: (i64, usize), rest: &[Json]) -> Result {
    call(c, at, "on-change", rest)
}

fn perform_action(c: &mut Ctx<'_>) -> Result {
    let (window, n, what) = (c.i64(0)?, c.i64(1)?, c.text(2)?);
    let given = c.arg(3);
    let element = {
        let mut all = borrow_windows(c)?;
        let of = all.window_mut(window)?;
        let found = usize::try_from(n).ok().filter(|n| *n < of.nodes.len());
        let n = found.ok_or_else(|| Fail::missing(format!("the window has no widget with the index {n}")))?;
        let mut at = Some(n);
        while let Some(n) = at {
            if of.nodes[n].values.get("enabled") == Some(&json!(false)) {
                return Err(Fail::argument("the widget is disabled, or is inside a disabled widget"));
            }
            at = of.nodes[n].above;
        }
        of.nodes[n].element.clone()
    };
    let at = (window, n as usize);
    match (what.as_str(), element.as_str()) {
        ("click", "button") => {
            if get(c, at, "checkable")? == json!(true) {
                let pressed = get(c, at, "checked")? == json!(true);
                set(c, at, &[("checked", json!(!pressed))])?;
            }
            call(c, at, "on-click", &[])
        }
        ("click", "radiobutton") => {
            let others: Vec<usize> = {
                let mut all = borrow_windows(c)?;
                let nodes = &all.window_mut(window)?.nodes;
                let beside = nodes[at.1].above.map(|a| nodes[a].below.clone()).unwrap_or_default();
                beside.into_iter().filter(|b| *b != at.1 && nodes[*b].element == "radiobutton").collect()
            };
            for other in others {
                set(c, (window, other), &[("checked", json!(0))])?;
            }
            set(c, at, &[("checked", json!(1))])?;
            call(c, at, "on-click", &[])
        }
        ("change", "hslider" | "vslider" | "spinbox") => {
            let x = given
                .as_f64()
                .filter(|x| x.is_finite())
                .ok_or_else(|| Fail::argument("argument 4: expected a finite number"))?;
            let limit = |key: &str, or: f64| Ok::<f64, Fail>(get(c, at, key)?.as_f64().unwrap_or(or));
            let x = x.max(limit("minimum", f64::MIN)?).min(limit("maximum", f64::MAX)?);
            let whole = element != "spinbox" || get(c, at, "float")? != json!(true);
            let x = if whole { json!(x.round() as i64) } else { json!(x) };
            set(c, at, &[("value", x.clone())])?;
            call(c, at, "on-change", &[x])
        }
        ("change", "checkbox") => {
            let x = json!(if given.truthy() && given.as_i64() != Some(0) { 2 } else { 0 });
            set(c, at, &[("checked", x.clone())])?;
            call(c, at, "on-change", &[x])
        }
        ("change", "edit") => {
            let x = json!(given.as_str().ok_or_else(|| Fail::argument("argument 4: expected a string"))?);
            set(c, at, &[("value", x.clone())])?;
            call(c, at, "on-change", std::slice::from_ref(&x))?;
            call(c, at, "on-editing-finished", &[x])
        }
        ("change", "combobox" | "tabs") => {
            let x = json!(given.as_i64().ok_or_else(|| Fail::argument("argument 4: expected an index"))?);
            set(c, at, &[(if element == "tabs" { "current" } else { "index" }, x.clone())])?;
            call(c, at, "on-change", &[x])
        }
        ("select", "tree") => {
            let x = json!(given.as_i64().ok_or_else(|| Fail::argument("argument 4: expected the index of a row"))?);
            set(c, at, &[("selected", x.clone())])?;
            call(c, at, "on-selection-change", &[x])
        }
        ("link", "label") => {
            let link = json!(given.as_str().ok_or_else(|| Fail::argument("argument 4: expected a string"))?);
            call(c, at, "on-link-activated", &[link])
        }
        ("close", "ui") => {
            if get(c, at, "closeable")? != json!(true) {
                return Err(Fail::argument("users cannot close this window: its attribute `closeable` is not true"));
            }
            set(c, at, &[("visible", json!(false))])?;
            call(c, at, "on-close", &[])
        }
        _ => Err(Fail::argument(format!("a widget <{element}> does not support the action `{what}`"))),
    }
}

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    offer.command(
        Cmd::new("tatu.actOnWindow", perform_action)
            .param(Param::int("window").text("its number"))
            .param(Param::int("n").text("the index of the widget; 0: the window itself"))
            .param(Param::string("what").choices(ACTIONS))
            .param(Param::any("value").optional().text("change: the new value; link: its target; select: the row"))
            .text("Performs a user's action on a window of a script, and calls the script's callback.")
            .notes("Called by views. The widgets' indices are those in the event `ui.window` and in `tatu.windows`.")
            .example(
                "function moved(ui, id, x) seen = {id, x} end\n\
                 local ui = simUI.create('<ui><hslider id=\"7\" maximum=\"10\" on-change=\"moved\"/></ui>')\n\
                 function sysCall_sensing()\n  \
                   tatu.actOnWindow(window, 1, 'change', 4)\n  \
                   assert(seen[1] == 7 and seen[2] == 4)\n\
                 end"
                .replace("local ui =", "window ="),
            ),
    );
    offer.command(
        Cmd::new("tatu.windows", |c| {
            let trees: Vec<Json> = {
                let all = borrow_windows(c)?;
                let one = |(window, of): (&i64, &crate::window::Window)| {
                    json!({ "window": window, "act": "tatu.actOnWindow", "widgets": of.widgets() })
                };
                all.open.iter().map(one).collect()
            };
            c.ret(value(&Json::Array(trees)));
            Ok(())
        })
        .returns(Param::any("windows").text("a table per window: window, act, widgets, as in the event `ui.window`"))
        .text("Lists the windows that scripts opened.")
        .example("simUI.create('<ui title=\"A\"/>')\nassert(#tatu.windows() > 0)"),
    );
}
