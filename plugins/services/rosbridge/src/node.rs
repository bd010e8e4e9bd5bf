//! Endpoints that the scripts of a world have opened: publishers, subscribers, servers and clients. They are stored
//! here, and announced to the service by events.

use std::{
    cell::{RefCell, RefMut},
    collections::{BTreeMap, BTreeSet},
};

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Value, World, keys},
};

use crate::{
    RosCall, convert,
    goals::PendingGoal,
    pixels, rosapi,
    types::{self, RosVersion},
};

/// Name of the event that is published when a script opens or closes an endpoint.
pub(crate) const ENDPOINT_EVENT: &str = "ros.endpoint";
/// Name of the event that is published when a script publishes a message.
pub(crate) const MESSAGE_EVENT: &str = "ros.message";
/// Name of the event that is published when a script calls a service that no script offers.
pub(crate) const REQUEST_EVENT: &str = "ros.request";

/// A callback of a script: the name of a function, or a function value. If it has neither, nothing is called.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct ScriptCallback {
    name: String,
    /// The function value, which cannot be part of a snapshot.
    #[serde(skip)]
    function: Option<tatu_func>,
}

impl ScriptCallback {
    /// Reads a callback from argument `i`.
    pub(crate) fn read(c: &RosCall<'_>, i: usize) -> Result<ScriptCallback> {
        Ok(match c.arg(i).as_func() {
            Some(function) => ScriptCallback { name: String::new(), function: Some(c.keep_func(function)?) },
            None => ScriptCallback { name: c.text(i)?, function: None },
        })
    }
    fn is_none(&self) -> bool {
        self.name.is_empty() && self.function.is_none()
    }
}

/// The part that an endpoint of a script has in a topic, a service or an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum EndpointRole {
    Publisher,
    Subscriber,
    Client,
    Server,
    ActionClient,
    ActionServer,
}

impl EndpointRole {
    /// Returns the name of the role in events and error messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            EndpointRole::Publisher => "publisher",
            EndpointRole::Subscriber => "subscriber",
            EndpointRole::Client => "client",
            EndpointRole::Server => "server",
            EndpointRole::ActionClient => "action client",
            EndpointRole::ActionServer => "action server",
        }
    }
}

/// A publisher, subscriber, server or client of a script.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct ScriptEndpoint {
    pub(crate) role: EndpointRole,
    pub(crate) name: String,
    /// The message type, by its name in ROS 1. The type of a service does not include `Request`, and that of an action
    /// does not include `PendingGoal`.
    pub(crate) kind: String,
    /// Whether the script uses names and times of ROS 2.
    pub(crate) two: bool,
    /// The callbacks: none, one, or those of an action client or server in the order of their parameters.
    callbacks: Vec<ScriptCallback>,
    /// Whether the script receives arrays of bytes as strings.
    pub(crate) bytes_as_text: bool,
    /// Whether the script receives the pixels of images instead of messages.
    pub(crate) pixels: bool,
    /// The script that has opened the endpoint.
    script: tatu_object,
}

impl ScriptEndpoint {
    pub(crate) fn ros(&self) -> RosVersion {
        if self.two { RosVersion::Two } else { RosVersion::One }
    }
}

/// The ROS state of a world, which is saved in snapshots.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct RosState {
    /// The last assigned handle.
    made: i64,
    /// The open endpoints, by handle.
    pub(crate) open: BTreeMap<i64, ScriptEndpoint>,
    /// Parameters that scripts have set.
    pub(crate) params: BTreeMap<String, Json>,
    /// The last number that was assigned to a service call or a waiting thread.
    asked: u64,
    /// The handles of the clients that wait for an answer, by the number of the call.
    waiting: BTreeMap<u64, i64>,
    /// Answers to calls, as JSON, and whether the call succeeded, by the number of the call.
    answers: BTreeMap<u64, (String, bool)>,
    /// Services and actions that clients of `rosbridge` offer.
    pub(crate) offered: ClientOffers,
    /// The goals without a result, by id.
    pub(crate) goals: BTreeMap<String, PendingGoal>,
    /// Number of goals in this run so far.
    pub(crate) given: u64,
    /// Threads that wait until a service or an action is offered, by number.
    pub(crate) waits: BTreeMap<u64, WaitingThread>,
}

/// Services and actions that clients of `rosbridge` offer to scripts, by name.
#[derive(Debug, Default, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ClientOffers {
    pub(crate) services: BTreeSet<String>,
    pub(crate) actions: BTreeSet<String>,
}

/// A thread that waits until a service or an action is offered.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct WaitingThread {
    /// The handle of the client that the thread uses.
    pub(crate) handle: i64,
    /// The message that the thread will send, as JSON.
    pub(crate) json: Json,
    /// Simulation time until which the thread waits at most, s.
    pub(crate) until: f64,
}

/// The ROS node of a world. Commands can call each other, so a borrow must never last across a call to the host.
#[derive(Default)]
pub struct RosNode(RefCell<RosState>);

impl RosNode {
    /// Serializes the state for a snapshot. Fails if an endpoint has a callback that is a function value.
    pub(crate) fn write(&self) -> Result<Vec<u8>> {
        let all = self.state()?;
        if all.open.values().flat_map(|e| &e.callbacks).any(|f| f.function.is_some()) {
            return Err(Fail::unsupported(
                "ROS callbacks that are function values cannot be saved: pass the names of the functions instead",
            ));
        }
        serde_json::to_vec(&*all).map_err(|e| Fail::new(format!("the ROS state of scripts could not be saved: {e}")))
    }
    pub(crate) fn state(&self) -> Result<RefMut<'_, RosState>> {
        self.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the ROS state of scripts is in use"))
    }

    /// Resets the state at the end of a run. Endpoints of scripts that outlive the run remain open and are announced to
    /// the service again, because the service discards all endpoints when the simulation stops.
    pub(crate) fn end_run(&self, world: &World<'_>) -> Result {
        let open = std::mem::take(&mut self.state()?.open);
        let kept: BTreeMap<i64, ScriptEndpoint> =
            open.into_iter().filter(|(_, e)| world.outlives_runs(e.script)).collect();
        for endpoint in kept.values() {
            announce_endpoint(world, endpoint, true)?;
        }
        // The next run must assign the same handles as this one, so the counter continues from the endpoints that
        // remain.
        let made = kept.keys().next_back().copied().unwrap_or(0);
        let mut all = self.state()?;
        let offered = std::mem::take(&mut all.offered);
        *all = RosState { made, open: kept, offered, ..RosState::default() };
        Ok(())
    }

    /// Opens an endpoint of a script, and returns its handle.
    pub(crate) fn open(&self, world: &World<'_>, script: tatu_object, mut endpoint: ScriptEndpoint) -> Result<i64> {
        endpoint.script = script;
        announce_endpoint(world, &endpoint, true)?;
        let mut all = self.state()?;
        all.made += 1;
        let handle = all.made;
        all.open.insert(handle, endpoint);
        Ok(handle)
    }
    /// Closes an endpoint, and announces that to the service if it is the last one with this role and name.
    pub(crate) fn close(&self, c: &RosCall<'_>, handle: i64, role: EndpointRole) -> Result {
        let endpoint = self.endpoint(handle, role)?;
        endpoint.callbacks.iter().filter_map(|f| f.function).for_each(|f| c.drop_func(f));
        let last = {
            let mut all = self.state()?;
            all.open.remove(&handle);
            !all.open.values().any(|e| e.role == role && e.name == endpoint.name)
        };
        if last { announce_endpoint(&c.world(), &endpoint, false) } else { Ok(()) }
    }
    /// Returns the endpoint with a handle. Fails if it does not exist or has another role.
    pub(crate) fn endpoint(&self, handle: i64, role: EndpointRole) -> Result<ScriptEndpoint> {
        let found = self.state()?.open.get(&handle).filter(|e| e.role == role).cloned();
        found.ok_or_else(|| Fail::missing(format!("there is no {} with the handle {handle}", role.name())))
    }
    /// Makes an endpoint pass arrays of bytes to its script as strings.
    pub(crate) fn bytes_as_text(&self, handle: i64, role: EndpointRole) -> Result {
        self.endpoint(handle, role)?;
        if let Some(endpoint) = self.state()?.open.get_mut(&handle) {
            endpoint.bytes_as_text = true;
        }
        Ok(())
    }
    /// Removes the endpoints of scripts that no longer exist. Returns the endpoints with a role and name, with their
    /// handles, in order of creation.
    pub(crate) fn live_endpoints(
        &self,
        world: &World<'_>,
        role: EndpointRole,
        name: &str,
    ) -> Result<Vec<(i64, ScriptEndpoint)>> {
        let mut all = self.state()?;
        all.open.retain(|_, e| world.look(e.script).is_ok());
        let found = all.open.iter().filter(|(_, e)| e.role == role && e.name == name);
        Ok(found.map(|(handle, e)| (*handle, e.clone())).collect())
    }

    /// Publishes a message of a script. Scripts of the world receive it immediately, and clients receive it through the
    /// service.
    pub(crate) fn publish(&self, c: &mut RosCall<'_>, from: &ScriptEndpoint, message: &Value) -> Result {
        let json = convert::node(message, &from.kind, from.ros())?.json();
        c.world().publish_value(
            MESSAGE_EVENT,
            &keys([
                ("topic", Value::text(&from.name)),
                ("type", Value::text(&from.kind)),
                ("json", Value::text(json.to_string())),
            ]),
        )?;
        self.deliver(c, &from.name, &json)
    }
    /// Passes a message to the scripts that have subscribed to its topic.
    pub(crate) fn deliver(&self, c: &mut RosCall<'_>, topic: &str, json: &Json) -> Result {
        for (_, to) in self.live_endpoints(&c.world(), EndpointRole::Subscriber, topic)? {
            let message = convert::value(json, &to.kind, to.ros())?;
            let arguments =
                if to.pixels { pixels::pixels(&message)?.to_vec() } else { vec![to.to_script_form(message)] };
            to.call(c, 0, &arguments)?;
        }
        Ok(())
    }
    /// Calls a service that a script offers, and returns its response. Returns `None` if no script offers it.
    pub(crate) fn serve(&self, c: &mut RosCall<'_>, service: &str, request: &Json) -> Result<Option<Json>> {
        let Some((_, server)) = self.live_endpoints(&c.world(), EndpointRole::Server, service)?.into_iter().next()
        else {
            return Ok(None);
        };
        let request = convert::value(request, &format!("{}Request", server.kind), server.ros())?;
        let results = server.call(c, 0, &[server.to_script_form(request)])?;
        let response = results.first().unwrap_or(&Value::Nil);
        Ok(Some(convert::node(response, &format!("{}Response", server.kind), server.ros())?.json()))
    }

    /// Publishes the event for a call of a service that is not offered by a script, which the service `rosbridge`
    /// executes. Returns the number of the call.
    pub(crate) fn request_service(&self, world: &World<'_>, client: i64, service: &str, request: &Json) -> Result<u64> {
        let number = {
            let mut all = self.state()?;
            all.asked += 1;
            let number = all.asked;
            all.waiting.insert(number, client);
            number
        };
        let payload = keys([
            ("id", Value::Int(number as i64)),
            ("service", Value::text(service)),
            ("json", Value::text(request.to_string())),
        ]);
        world.publish_value(REQUEST_EVENT, &payload)?;
        Ok(number)
    }
    /// Registers a waiting thread, and returns the number assigned to it.
    pub(crate) fn register_wait(&self, wait: WaitingThread) -> Result<u64> {
        let mut all = self.state()?;
        all.asked += 1;
        let number = all.asked;
        all.waits.insert(number, wait);
        Ok(number)
    }
    /// Returns whether a script, a client or the service `rosbridge` itself offers a service.
    pub(crate) fn has_service(&self, world: &World<'_>, name: &str) -> Result<bool> {
        Ok(self.state()?.offered.services.contains(name)
            || !self.live_endpoints(world, EndpointRole::Server, name)?.is_empty()
            || rosapi::is_own_service(name) && world.is_wanted(REQUEST_EVENT))
    }
    /// Stores the answer to a call, as JSON. `good` is whether the call succeeded.
    pub(crate) fn store_answer(&self, number: u64, json: String, good: bool) -> Result {
        self.state()?.answers.insert(number, (json, good));
        Ok(())
    }
    /// Returns the handle of the client that made a call. If the answer has arrived, removes it and returns it as well.
    pub(crate) fn take_answer(&self, number: u64) -> Result<(i64, Option<(String, bool)>)> {
        let mut all = self.state()?;
        let client = all.waiting.get(&number).copied().unwrap_or(0);
        let answer = all.answers.remove(&number);
        if answer.is_some() {
            all.waiting.remove(&number);
        }
        Ok((client, answer))
    }
}

impl ScriptEndpoint {
    /// Calls the callback with index `n`, and returns its results. Returns no results if there is no such callback.
    pub(crate) fn call(&self, c: &mut RosCall<'_>, n: usize, arguments: &[Value]) -> Result<Vec<Value>> {
        let Some(callback) = self.callbacks.get(n).filter(|f| !f.is_none()) else { return Ok(Vec::new()) };
        match callback.function {
            Some(function) => c.call_func(function, arguments),
            None => c.world().call_function(self.script, &callback.name, arguments),
        }
    }
    /// Converts a message to the form that the script receives.
    pub(crate) fn to_script_form(&self, message: Value) -> Value {
        for_script(message, self.bytes_as_text)
    }
    /// Creates an endpoint without opening it.
    pub(crate) fn new(
        role: EndpointRole,
        name: &str,
        kind: &str,
        ros: RosVersion,
        callbacks: Vec<ScriptCallback>,
    ) -> Result<ScriptEndpoint> {
        if name.is_empty() || kind.is_empty() {
            return Err(Fail::argument(
                "the name or the type is empty: expected, for example, '/cmd_vel' and 'geometry_msgs/Twist'",
            ));
        }
        Ok(ScriptEndpoint {
            role,
            // Names without a leading slash are relative to the root namespace.
            name: format!("/{}", name.trim_start_matches('/')),
            kind: types::ros1_name(kind),
            two: ros == RosVersion::Two,
            callbacks,
            bytes_as_text: false,
            pixels: false,
            script: 0,
        })
    }
}

/// Converts arrays of bytes to the form that a script receives: a string, or a table of integers.
fn for_script(value: Value, as_text: bool) -> Value {
    match value {
        Value::Bytes(b) if as_text => Value::Text(b),
        Value::Bytes(b) => Value::Ints(b.into_iter().map(i64::from).collect()),
        Value::Map(entries) => Value::Map(entries.into_iter().map(|(k, v)| (k, for_script(v, as_text))).collect()),
        Value::List(all) => Value::List(all.into_iter().map(|v| for_script(v, as_text)).collect()),
        other => other,
    }
}

/// Announces to the service that an endpoint was opened or closed.
fn announce_endpoint(world: &World<'_>, of: &ScriptEndpoint, open: bool) -> Result {
    let payload = keys([
        ("role", Value::text(of.role.name())),
        ("name", Value::text(&of.name)),
        ("type", Value::text(&of.kind)),
        ("open", Value::Bool(open)),
    ]);
    world.publish_value(ENDPOINT_EVENT, &payload)
}
