//! Records the results of network access as inputs of the run.

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Result, Value};
use tatu_services_common::json;

use crate::{
    errors::Errno,
    world::{Ctx, WorldState, state},
};

/// Kind of this plugin's entries in the input log.
const KIND: &str = "zmq";

/// The outcome of a network access.
pub enum SocketOutcome {
    /// The call succeeded with these return values.
    Values(Vec<Value>),
    /// The call failed.
    Failed(Errno),
    /// The call has no result yet and must be repeated in a later step.
    Waits,
    /// The run is not permitted to make this access. The values are the error message and advice.
    Denied(String, String),
}

impl From<Errno> for SocketOutcome {
    fn from(errno: Errno) -> Self {
        SocketOutcome::Failed(errno)
    }
}

/// Runs `look` and records its result in the input log. In a replay, returns the recorded result instead.
pub fn observe(
    c: &Ctx<'_>,
    name: &str,
    look: impl FnOnce(&Ctx<'_>, &mut WorldState) -> Result<SocketOutcome>,
) -> Result<SocketOutcome> {
    let mut failed = None;
    let found = c.world().observe(KIND, || {
        let found = state(c).and_then(|mut world| look(c, &mut world));
        let found = found.unwrap_or_else(|fail| {
            failed = Some(fail);
            SocketOutcome::Failed(Errno::INVALID)
        });
        json!([name, write(&found)]).to_string()
    })?;
    if let Some(fail) = failed {
        return Err(fail);
    }
    let read = |text: &str| -> Option<SocketOutcome> {
        let (then, found): (String, Json) = serde_json::from_str(text).ok()?;
        (then == name).then(|| read(&found))?
    };
    read(&found).ok_or_else(|| {
        Fail::new(format!(
            "the recorded run made a different call of simZMQ here: {found}; replay it with the scene it was recorded \
             with"
        ))
    })
}

fn write(found: &SocketOutcome) -> Json {
    match found {
        SocketOutcome::Values(values) => values.iter().map(json::write).collect(),
        SocketOutcome::Failed(errno) => json!({ "errno": errno.0 }),
        SocketOutcome::Waits => Json::Null,
        SocketOutcome::Denied(text, help) => json!({ "denied": text, "help": help }),
    }
}

fn read(json: &Json) -> Option<SocketOutcome> {
    Some(match json {
        Json::Array(values) => SocketOutcome::Values(values.iter().map(json::read).collect::<Result<_>>().ok()?),
        Json::Null => SocketOutcome::Waits,
        _ => match json.get("errno") {
            Some(errno) => SocketOutcome::Failed(Errno(errno.as_i64()?)),
            None => SocketOutcome::Denied(json.get("denied")?.as_str()?.into(), json.get("help")?.as_str()?.into()),
        },
    })
}

/// Builds the error for an access that the run is not permitted to make.
pub fn denial(text: String, help: String) -> Fail {
    Fail::new(text).help(help)
}
