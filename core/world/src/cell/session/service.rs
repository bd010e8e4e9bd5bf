//! A running service: its start, its end and its capabilities.

use std::{
    cell::{Cell, RefCell},
    ffi::c_void,
};

use tatu_errors::{Error, Result};
use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value},
};
use tatu_plugins::{
    Registry, ServiceKind,
    border::ErrorSlot,
    events::covers,
    state_block::{PAST_STATE, StateBlock},
    watchdog::PluginCall,
};
use tatu_scene::document::ServiceSpec;

/// A service that has been started.
pub(crate) struct RunningService {
    /// Index of its kind in the registry.
    pub kind: usize,
    /// Its number in the session, counted from 1.
    pub number: u32,
    pub data: *mut c_void,
    /// Its state block.
    pub state: RefCell<StateBlock>,
    /// Description in messages: "the service `ID`".
    pub subject: String,
    /// Whether it has failed and is no longer called. Such a service cannot hold the session.
    pub off: Cell<bool>,
    /// Whether it has been reported that the service has held the session for a long time.
    pub hold_reported: Cell<bool>,
}

/// Values in ABI form, with the memory of their spans.
pub(in crate::cell) struct RawValues(pub Vec<tatu_value>, #[allow(dead_code, reason = "keeps the spans alive")] Owned);

pub(in crate::cell) fn to_raw_values<'v>(values: impl IntoIterator<Item = &'v Value>) -> RawValues {
    let mut owned = Owned::default();
    let raw = values.into_iter().map(|v| owned.raw(v)).collect();
    RawValues(raw, owned)
}

impl RunningService {
    /// Starts a service.
    pub fn start(registry: &Registry, session: *mut tatu_session, spec: &ServiceSpec, number: u32) -> Result<Self> {
        let kind = &registry.services[spec.kind];
        let lacking = |p: &&tatu_plugins::ParameterSpec| !p.optional() && !spec.params.iter().any(|(k, _)| *k == p.key);
        if let Some(p) = kind.params.iter().find(lacking) {
            return Err(Error::new(
                "E104",
                format!("the service `{}` lacks the required parameter `{}`", kind.id, p.key),
            )
            .expected(p.expectation())
            .at(spec.place.clone()));
        }
        let given = kind
            .params
            .iter()
            .map(|p| spec.params.iter().rev().find(|(k, _)| *k == p.key).map_or(&p.fallback, |(_, v)| v));
        let params = to_raw_values(given);
        let plugin = &registry.plugins[kind.plugin];
        let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
        let state = StateBlock::new(kind.life.state_bytes);
        let info = tatu_instance {
            size: size_of::<tatu_instance>() as u32,
            n_params: params.0.len() as u32,
            world: std::ptr::null_mut(),
            owner: 0,
            id: number.into(),
            seed: 0,
            params: params.0.as_ptr(),
            state: state.data_ptr(),
            session,
        };
        // SAFETY: `f` is the `create` function of a plugin that is never unloaded. `info`, the data that it points to,
        // `data` and `error` live until the call has returned.
        let run = || unsafe { kind.life.create.map_or(TATU_OK, |f| f(plugin.me, &info, &mut data, error.raw())) };
        let subject = format!("the service `{}`", kind.id);
        let status = registry
            .call_plugin(kind.plugin, PluginCall::Start, &subject, run)
            .map_err(|e| e.at(spec.place.clone()))?;
        if error.check_status(status, false) < 0 {
            let why = format!("plugin `{}`: {} [{}]", plugin.id, error.text(), PluginCall::Start.text());
            let text = format!("{subject} cannot be started: {why}");
            return Err(Error::new("E404", text).at(spec.place.clone()));
        }
        if !state.guards_intact() {
            let text = format!("{subject} cannot be started: plugin `{}`: {PAST_STATE}", plugin.id);
            return Err(Error::new("E404", text).at(spec.place.clone()));
        }
        let (off, hold_told) = (Cell::new(false), Cell::new(false));
        Ok(RunningService {
            kind: spec.kind,
            number,
            data,
            state: state.into(),
            subject,
            off,
            hold_reported: hold_told,
        })
    }

    /// Ends the service. The contract requires its threads to have ended when this function returns.
    pub fn stop(&self, registry: &Registry) -> Result {
        let kind = self.info(registry);
        let Some(stop) = kind.life.destroy else { return Ok(()) };
        // SAFETY: `self.data` was created by the `create` function of the same kind, and is not used after this single
        // call.
        let run = || unsafe { stop(self.data) };
        let done = registry.call_plugin(kind.plugin, PluginCall::Stop, &self.subject, run);
        done.map_err(|e| if e.code == "E111" { Error { code: "E323", ..e } } else { e })
    }

    pub fn info<'r>(&self, registry: &'r Registry) -> &'r ServiceKind {
        &registry.services[self.kind]
    }

    /// Returns a description of the service for messages, with its plugin.
    pub fn name(&self, registry: &Registry) -> String {
        format!("{} (plugin `{}`)", self.subject, registry.plugins[self.info(registry).plugin].id)
    }

    /// Returns whether commands that the service calls may wait.
    pub fn can_wait(&self, registry: &Registry) -> bool {
        !self.off.get() && self.info(registry).raw.resume.is_some()
    }

    /// Returns whether the service can pass functions of its clients to commands.
    pub fn supports_client_functions(&self, registry: &Registry) -> bool {
        !self.off.get() && self.info(registry).raw.call_func.is_some()
    }

    /// Returns whether the service subscribes to an event.
    pub fn subscribes_to(&self, registry: &Registry, name: &str) -> bool {
        self.info(registry).events.iter().any(|wanted| covers(wanted, name))
    }
}
