//! Processes the answers of callbacks, and ends scripts that request it or fail.
//!
//! An answer is a map that a callback returns. Its key `cmd` is a request: "cleanup" ends the script, and "restart"
//! ends it and starts it again in the next stage. Requests are carried out only when no call into the script is
//! running, because calls into a script can be nested.

use std::rc::Rc;

use tatu_plugin_api::{
    abi::*,
    safe::{Value, ValueRef},
};

use crate::cell::{Callback, ExitRequest, Script, WorldCell};

/// Returns the value of a key in a map.
pub(crate) fn map_entry<'v>(map: &'v Value, key: &str) -> Option<&'v Value> {
    let Value::Map(entries) = map else { return None };
    let is_key = |k: &Value| matches!(k, Value::Text(t) | Value::Bytes(t) if t == key.as_bytes());
    entries.iter().find(|(k, _)| is_key(k)).map(|(_, v)| v)
}

impl Script {
    pub(super) fn request_exit(&self, ask: ExitRequest) {
        self.progress.exit_request.set(self.progress.exit_request.get().max(ask));
    }

    /// Reads the answer of a callback and records its request. Returns the answer if it is a map.
    pub(super) fn read_answer(&self, frame: &tatu_call) -> Option<Value> {
        if frame.n_results == 0 {
            return None;
        }
        // SAFETY: `frame.results` points to `n_results` values that the call, which has just returned, has written and
        // the host has checked; they stay in the frame's array until the next call.
        let first = unsafe { ValueRef::slice(frame.results, frame.n_results as usize) }.first()?;
        let answer = first.to_value().ok().filter(|v| matches!(v, Value::Map(_)))?;
        match map_entry(&answer, "cmd") {
            Some(Value::Text(t)) if t == b"cleanup" => self.request_exit(ExitRequest::End),
            Some(Value::Text(t)) if t == b"restart" => self.request_exit(ExitRequest::Restart),
            _ => {}
        }
        Some(answer)
    }

    /// Carries out the script's request, unless a call into the script is still running.
    pub(super) fn carry_out_request(self: &Rc<Self>, world: &WorldCell) {
        if self.progress.exit_request.get() == ExitRequest::Nothing || self.depth.get() > 0 {
            return;
        }
        let asked = self.progress.exit_request.replace(ExitRequest::Nothing);
        self.clean_up(world);
        // Requests made by the clean-up itself are ignored.
        self.progress.exit_request.set(ExitRequest::Nothing);
        match asked {
            ExitRequest::Nothing => {}
            ExitRequest::Silence => self.progress.dead.set(true),
            ExitRequest::End | ExitRequest::Restart => {
                self.end(world);
                self.progress.ended.set(true);
                if asked == ExitRequest::Restart {
                    self.begin(world);
                }
            }
        }
    }

    /// Calls the `cleanup` callback of a script that has begun, unless it has already been called.
    pub(super) fn clean_up(self: &Rc<Self>, world: &WorldCell) {
        if self.progress.initialised.get() && self.is_live(world) && !self.progress.cleaned.replace(true) {
            let number = self.find(world, TATU_FIND_CALLBACK, b"cleanup");
            self.query_callback(world, number, &[]);
        }
    }

    /// Calls a callback if the script has begun and defines it.
    pub(super) fn run_if_begun(self: &Rc<Self>, world: &WorldCell, callback: Callback, args: &[tatu_value]) {
        let number = self.number(callback);
        if number != 0 && self.progress.initialised.get() && !self.progress.cleaned.get() && self.is_live(world) {
            self.run_callback(world, number, args);
        }
    }
}
