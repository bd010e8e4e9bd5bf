//! Stores the open windows of scripts for clients that connect later.

use std::collections::BTreeMap;

use serde_json::Value as Json;
use tatu_services_common::outbox::OutgoingMessage;

use crate::protocol::ToPage;

/// The name of the event that reports changes of windows.
pub const WINDOW_EVENT: &str = "ui.window";
/// Maximum number of stored windows; further ones are not stored.
const MAX_WINDOWS: usize = 500;

/// The open windows of scripts.
#[derive(Default)]
pub struct ScriptWindows {
    /// The event that opened each window, with later changes applied, by the command that acts on the window and the
    /// number of the window.
    open: BTreeMap<(String, i64), Json>,
    /// Commands and numbers of dialogs that were opened since the last call of `asking`.
    new_dialogs: Vec<(String, i64)>,
}

impl ScriptWindows {
    /// Opens, changes or closes a window according to the payload of an event.
    pub fn apply_event(&mut self, payload: &Json) {
        let act = payload["act"].as_str().unwrap_or("").to_owned();
        let key = (act, payload["window"].as_i64().unwrap_or(0));
        if payload["widgets"].is_array() {
            if self.open.len() < MAX_WINDOWS {
                if payload["asks"] == true {
                    self.new_dialogs.push(key.clone());
                }
                self.open.insert(key, payload.clone());
            }
        } else if payload["closed"] == true {
            self.open.remove(&key);
        } else if let Some(window) = self.open.get_mut(&key) {
            let n = payload["n"].as_u64().unwrap_or(0) as usize;
            if let (Some(Json::Object(values)), Some(set)) =
                (window["widgets"].get_mut(n).and_then(|w| w.get_mut("values")), payload["set"].as_object())
            {
                values.extend(set.iter().map(|(k, v)| (k.clone(), v.clone())));
            }
        }
    }
    /// Returns messages that open all windows in their current state.
    pub fn messages(&self) -> impl Iterator<Item = OutgoingMessage> + '_ {
        self.open.values().map(|w| ToPage::Event { name: WINDOW_EVENT.to_owned(), payload: w.clone() }.message())
    }
    /// Returns the commands and numbers of the dialogs that were opened since the last call.
    pub fn take_new_dialogs(&mut self) -> Vec<(String, i64)> {
        std::mem::take(&mut self.new_dialogs)
    }
    /// Removes all windows, because the simulation has stopped.
    pub fn clear(&mut self) {
        self.open.clear();
        self.new_dialogs.clear();
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn late_client_receives_current_window_state() {
        let mut windows = ScriptWindows::default();
        let one = |rest: Json| {
            let mut all = json!({ "window": 1, "act": "tatu.actOnWindow" });
            all.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
            all
        };
        windows.apply_event(&one(json!({ "widgets": [{ "element": "ui", "values": { "title": "A" } }] })));
        windows.apply_event(&one(json!({ "n": 0, "set": { "title": "B" } })));
        windows.apply_event(&one(json!({ "n": 7, "set": { "title": "C" } })));
        let told: Vec<String> = windows.messages().map(|m| format!("{m:?}")).collect();
        assert!(told.len() == 1 && told[0].contains("title") && told[0].contains('B'), "{told:?}");
        windows.apply_event(&one(json!({ "closed": true })));
        assert_eq!(windows.messages().count(), 0);
    }
}
