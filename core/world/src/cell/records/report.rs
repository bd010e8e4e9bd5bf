//! Reports of a world: log lines, faults, and the caller to which they refer.

use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::Scene;

use crate::cell::{
    WorldCell,
    records::events::payload,
    records::lines::{LogLine, MAX_LINES},
    scripts::list::Script,
    scripts::worker_view::DeferredEffect,
};

impl WorldCell {
    /// Returns the path of the calling object, or "the host" if no object is calling, for messages.
    pub fn caller_name(&self) -> String {
        let caller = self.run.calls.caller.get();
        match self.borrow_part(|w| &w.state.scene) {
            Some(scene) if caller.object != 0 => scene.path(tatu_slot(caller.object)),
            _ => "the host".into(),
        }
    }
    /// Adds the calling object and script to a fault.
    pub fn add_caller_to_fault(&self, fault: &mut Fault) {
        let caller = self.run.calls.caller.get();
        if let (Some(scene), true) = (self.borrow_part(|w| &w.state.scene), caller.object != 0) {
            fault.object = Some(scene.path(tatu_slot(caller.object)));
        }
        self.with_caller(|script| fault.script = Some(script.name.clone()));
    }
    /// Calls `f` with the calling script, if a script is calling.
    pub fn with_caller(&self, f: impl FnOnce(&Script)) {
        let instance = self.run.calls.caller.get().instance;
        let script = self.borrow_part(|w| &w.run.scripts).and_then(|s| s.by_id(instance));
        if let Some(script) = script {
            f(&script);
        }
    }
    /// Records a fault. The first occurrence in each run is reported; repetitions are only counted.
    pub fn report(&self, fault: Fault) {
        if let Some(worker) = &self.worker {
            return worker.note(DeferredEffect::Fault(Box::new(fault)));
        }
        let Ok(mut faults) = self.run.faults.try_borrow_mut() else { return };
        let known = faults.iter().position(|f| f.same_as(&fault));
        if let Some(i) = known {
            faults[i].count += fault.count;
        }
        if !self.run.reported.borrow_mut().insert(known.unwrap_or(faults.len())) {
            return;
        }
        let mut text = fault.message.clone();
        if let (Some(file), Some(line)) = (&fault.file, fault.line) {
            text = format!("{file}:{line}: {text}");
        }
        if let Some(object) = &fault.object {
            text += &format!(" [{object}]");
        }
        if let Some(help) = &fault.help {
            text += &format!(" ({help})");
        }
        let code = Some(fault.code);
        self.run.connections.publish_fault(&fault);
        self.publish_line(TATU_LOG_ERROR, &text);
        if known.is_none() {
            faults.push(fault);
        }
        drop(faults);
        self.run.lines.lock().push(LogLine { level: TATU_LOG_ERROR, code, text });
    }
    /// Stores a log line until `take_lines` is called. Lines beyond the limits on their size and number are dropped
    /// with a warning.
    pub fn log(&self, level: u32, text: &str) {
        if let Some(worker) = &self.worker {
            return worker.note(DeferredEffect::Line(level, text.to_owned()));
        }
        self.publish_line(level, text);
        let mut lines = self.run.lines.lock();
        if lines.is_empty() {
            self.run.line_bytes.set(0);
        }
        let bytes = self.run.line_bytes.get().saturating_add(text.len() as u64);
        if bytes > self.store_limit() {
            if self.run.line_bytes.replace(u64::MAX) != u64::MAX {
                let text = format!(
                    "the log lines of one step exceed {} MB, the memory limit of scripts: the rest are omitted",
                    self.store_limit() >> 20
                );
                lines.push(LogLine { level: TATU_LOG_WARNING, code: None, text });
            }
            return;
        }
        self.run.line_bytes.set(bytes);
        match lines.len() {
            0..MAX_LINES => lines.push(LogLine { level, code: None, text: text.to_owned() }),
            MAX_LINES => lines.push(LogLine {
                level: TATU_LOG_WARNING,
                code: None,
                text: format!("more than {MAX_LINES} log lines in one step: the rest are omitted"),
            }),
            _ => {}
        }
    }
    /// Publishes a log line as an event, if something subscribes to it.
    fn publish_line(&self, level: u32, text: &str) {
        let level = match level {
            TATU_LOG_ERROR => "error",
            TATU_LOG_WARNING => "warning",
            TATU_LOG_INFO => "info",
            TATU_LOG_DEBUG => "debug",
            TATU_LOG_STATUS => "status",
            TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => {
                let (title, text) = text.split_once('\0').unwrap_or((text, ""));
                let clear = Value::Bool(level == TATU_LOG_CONSOLE_CLEAR);
                let told = || payload([("title", Value::text(title)), ("text", Value::text(text)), ("clear", clear)]);
                return self.run.connections.publish("console", told);
            }
            _ => return,
        };
        self.run
            .connections
            .publish("message", || payload([("level", Value::text(level)), ("text", Value::text(text))]));
    }
    /// Publishes an event that reports that an object was added or removed.
    pub fn publish_object_event(&self, event: &str, scene: &Scene, slot: u32) {
        self.run.connections.publish(event, || {
            let kind = scene.get(slot).map_or("", |o| o.kind().name());
            let path = Value::text(scene.path(slot));
            payload([("object", Value::Int(slot.into())), ("path", path), ("kind", Value::text(kind))])
        });
    }
}

/// Returns the fault for the failure of a plugin's instance, which is then switched off.
pub(crate) fn instance_fault(cell: &WorldCell, plugin: usize, slot: u32, status: tatu_status, text: &str) -> Fault {
    let id = &cell.model.registry.plugins[plugin].id;
    let path = cell.state.scene.try_borrow().map(|s| s.path(slot)).unwrap_or_default();
    let what =
        cell.state.scene.try_borrow().ok().and_then(|s| s.get(slot).map(|o| o.kind().name())).unwrap_or("sensor");
    // Messages of the host begin with a verb, so "failed" is not added.
    let how = if status == TATU_ERR_PANIC || text.starts_with("broke the contract") { "" } else { "failed: " };
    let mut fault =
        Fault::new(FaultKind::Plugin, format!("plugin `{id}` {how}{text}; the {what} {path} is switched off"));
    fault.plugin = Some(id.clone());
    fault.object = Some(path);
    fault
}
