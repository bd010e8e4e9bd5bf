//! The content of windows, and the event that publishes it to views.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
};

use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Value, World},
};

use crate::{
    node::{WidgetNode, WidgetValues},
    plugin::Ctx,
};

/// Name of the event that is published when a window is opened, changed or closed.
pub(crate) const WINDOW_EVENT: &str = "ui.window";
/// Maximum number of open windows.
const MAX_WINDOWS: usize = 200;

/// An open window, shown or hidden.
#[derive(Serialize, Deserialize)]
pub(crate) struct Window {
    /// The script that opened the window and contains its callbacks; 0 if no script did.
    pub(crate) script: tatu_object,
    pub(crate) nodes: Vec<WidgetNode>,
}

/// All windows of a world.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct OpenWindows {
    pub(crate) open: BTreeMap<i64, Window>,
    made: i64,
}

/// The windows of a world. Commands can call each other, so a borrow must not be held across a call to the host.
#[derive(Default)]
pub struct Windows(pub(crate) RefCell<OpenWindows>);

impl Window {
    /// Returns the index of the widget with this id.
    pub(crate) fn find(&self, id: &str) -> Result<usize> {
        let found = (0..self.nodes.len()).find(|n| self.nodes[*n].id == id && !id.is_empty());
        found.ok_or_else(|| Fail::missing(format!("the window has no widget with the id {id}")))
    }
    /// Returns the widgets in the form that views receive.
    pub(crate) fn widgets(&self) -> Json {
        let one = |node: &WidgetNode| json!({ "element": node.element, "above": node.above, "values": node.values });
        self.nodes.iter().map(one).collect()
    }
}

impl OpenWindows {
    pub(crate) fn add(&mut self, window: Window) -> Result<i64> {
        if self.open.len() >= MAX_WINDOWS {
            return Err(Fail::new(format!("at most {MAX_WINDOWS} windows can be open; close some of them first")));
        }
        self.made += 1;
        self.open.insert(self.made, window);
        Ok(self.made)
    }
    pub(crate) fn window_mut(&mut self, window: i64) -> Result<&mut Window> {
        self.open.get_mut(&window).ok_or_else(|| Fail::missing(format!("there is no window {window}")))
    }
}

impl Windows {
    fn borrow(&self) -> Result<RefMut<'_, OpenWindows>> {
        self.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "another command is using the windows"))
    }
    /// Closes all windows at the end of a run, except those whose script outlives the run.
    pub(crate) fn end_run(&self, world: &World<'_>) -> Result {
        let scripts: Vec<_> = self.borrow()?.open.iter().map(|(window, of)| (*window, of.script)).collect();
        for (window, _) in scripts.iter().filter(|(_, script)| !world.outlives_runs(*script)) {
            self.borrow()?.open.remove(window);
            publish(world, json!({ "window": window, "closed": true }))?;
        }
        // Restart the numbering, so that the next run assigns the same numbers as this one.
        let mut all = self.borrow()?;
        all.made = all.open.keys().next_back().copied().unwrap_or(0);
        Ok(())
    }
}

/// Borrows all windows of the caller's world.
pub(crate) fn borrow_windows<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, OpenWindows>> {
    c.instance().borrow()
}

/// Returns the window number in argument 0.
pub(crate) fn window(c: &Ctx<'_>) -> Result<i64> {
    c.i64(0)
}

/// Returns the window number in argument 0, and the index of the widget whose id is argument 1.
pub(crate) fn widget(c: &Ctx<'_>) -> Result<(i64, usize)> {
    let window = c.i64(0)?;
    let id = match c.arg(1).as_str() {
        Some(text) => text.into_owned(),
        None => c.i64(1)?.to_string(),
    };
    let n = borrow_windows(c)?.window_mut(window)?.find(&id)?;
    Ok((window, n))
}

/// Returns the value that a widget stores under a key, or null if it has none.
pub(crate) fn get(c: &Ctx<'_>, (window, n): (i64, usize), key: &str) -> Result<Json> {
    Ok(borrow_windows(c)?.window_mut(window)?.nodes[n].values.get(key).cloned().unwrap_or_default())
}

/// Sets values of a widget, and publishes those that changed.
pub(crate) fn set(c: &Ctx<'_>, (window, n): (i64, usize), entries: &[(&str, Json)]) -> Result {
    let mut changed = WidgetValues::new();
    {
        let mut all = borrow_windows(c)?;
        let values = &mut all.window_mut(window)?.nodes[n].values;
        for (key, value) in entries {
            if values.get(*key) != Some(value) {
                values.insert((*key).to_owned(), value.clone());
                changed.insert((*key).to_owned(), value.clone());
            }
        }
    }
    if changed.is_empty() { Ok(()) } else { publish_in_call(c, json!({ "window": window, "n": n, "set": changed })) }
}

/// Publishes `payload` to views in the event `ui.window`.
pub(crate) fn publish_in_call(c: &Ctx<'_>, payload: Json) -> Result {
    publish(&c.world(), payload)
}

fn publish(world: &World<'_>, mut payload: Json) -> Result {
    payload["act"] = json!("tatu.actOnWindow");
    world.publish_value(WINDOW_EVENT, &value(&payload))
}

/// Publishes the content of a whole window.
pub(crate) fn publish_window(c: &Ctx<'_>, window: i64) -> Result {
    let widgets = borrow_windows(c)?.window_mut(window)?.widgets();
    publish_in_call(c, json!({ "window": window, "widgets": widgets }))
}

/// Converts JSON to a value for events and scripts.
pub(crate) fn value(json: &Json) -> Value {
    match json {
        Json::Null => Value::Nil,
        Json::Bool(b) => Value::Bool(*b),
        Json::Number(n) => n.as_i64().map_or_else(|| Value::Float(n.as_f64().unwrap_or(0.0)), Value::Int),
        Json::String(s) => Value::text(s),
        Json::Array(a) => Value::List(a.iter().map(value).collect()),
        Json::Object(o) => Value::Map(o.iter().map(|(k, v)| (Value::text(k), value(v))).collect()),
    }
}
