//! What the scripts of a world publish, listen to, offer and ask: stored here, and passed to the service by events.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
};

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Value, World, keys},
};

use crate::{
    Ctx, convert,
    types::{self, Ros},
};

/// Told when a script begins or ends to publish, to listen or to serve.
pub(crate) const ENDPOINT: &str = "ros.endpoint";
/// Told when a script publishes.
pub(crate) const MESSAGE: &str = "ros.message";
/// Told when a script calls a service that no script offers.
pub(crate) const REQUEST: &str = "ros.request";

/// What a script gave to be called: a name, or a function.
#[derive(Default)]
pub(crate) struct Callback(pub(crate) String, pub(crate) Option<tatu_func>);

/// What a handle of a script stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Role {
    Publisher,
    Subscriber,
    Client,
    Server,
}

impl Role {
    /// Its name in the event.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Role::Publisher => "publisher",
            Role::Subscriber => "subscriber",
            Role::Client => "client",
            Role::Server => "server",
        }
    }
}

/// One thing that a script does with ROS.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Endpoint {
    pub(crate) role: Role,
    pub(crate) name: String,
    /// The type, with the name of ROS 1; of a service without `Request`.
    pub(crate) kind: String,
    /// Whether the script has names and times of ROS 2.
    pub(crate) two: bool,
    /// The function that is called, by its name,
    pub(crate) callback: String,
    /// or kept; no snapshot has it.
    #[serde(skip)]
    pub(crate) function: Option<tatu_func>,
    /// Whether arrays of bytes are texts for the script.
    pub(crate) bytes_as_text: bool,
    script: tatu_object,
}

impl Endpoint {
    pub(crate) fn ros(&self) -> Ros {
        if self.two { Ros::Two } else { Ros::One }
    }
}

/// What scripts do with ROS.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct All {
    made: i64,
    open: BTreeMap<i64, Endpoint>,
    /// Parameters that scripts set.
    pub(crate) params: BTreeMap<String, Json>,
    asked: u64,
    /// The handles of clients whose calls wait.
    waiting: BTreeMap<u64, i64>,
    answers: BTreeMap<u64, (String, bool)>,
}

/// The node of a world. Commands may enter each other: borrow briefly, never across a call to the host.
#[derive(Default)]
pub struct Node(RefCell<All>);

impl Node {
    /// As bytes, for snapshots; an error: functions cannot be written.
    pub(crate) fn write(&self) -> Result<Vec<u8>> {
        let all = self.all()?;
        if all.open.values().any(|e| e.function.is_some()) {
            return Err(Fail::unsupported("callbacks given as functions cannot be saved: give names of functions"));
        }
        serde_json::to_vec(&*all).map_err(|e| Fail::new(format!("what scripts have open cannot be written: {e}")))
    }
    pub(crate) fn all(&self) -> Result<RefMut<'_, All>> {
        self.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "what scripts do with ROS is in use"))
    }

    /// The run has ended: what scripts that outlive it have open stays, and the service, which forgets all at a stop,
    /// hears of it again.
    pub(crate) fn end_run(&self, world: &World<'_>) -> Result {
        let open = std::mem::take(&mut self.all()?.open);
        let kept: BTreeMap<i64, Endpoint> = open.into_iter().filter(|(_, e)| world.outlives_runs(e.script)).collect();
        for endpoint in kept.values() {
            tell(world, endpoint, true)?;
        }
        // The next run numbers its own as this one did.
        let made = kept.keys().next_back().copied().unwrap_or(0);
        *self.all()? = All { made, open: kept, ..All::default() };
        Ok(())
    }

    /// Opens an endpoint; its handle.
    pub(crate) fn open(&self, world: &World<'_>, script: tatu_object, mut endpoint: Endpoint) -> Result<i64> {
        endpoint.script = script;
        tell(world, &endpoint, true)?;
        let mut all = self.all()?;
        all.made += 1;
        let handle = all.made;
        all.open.insert(handle, endpoint);
        Ok(handle)
    }
    /// Closes one.
    pub(crate) fn close(&self, c: &Ctx<'_>, handle: i64, role: Role) -> Result {
        let endpoint = self.of(handle, role)?;
        endpoint.function.into_iter().for_each(|f| c.drop_func(f));
        let last = {
            let mut all = self.all()?;
            all.open.remove(&handle);
            !all.open.values().any(|e| e.role == role && e.name == endpoint.name)
        };
        if last { tell(&c.world(), &endpoint, false) } else { Ok(()) }
    }
    /// The endpoint of a handle.
    pub(crate) fn of(&self, handle: i64, role: Role) -> Result<Endpoint> {
        let found = self.all()?.open.get(&handle).filter(|e| e.role == role).cloned();
        found.ok_or_else(|| Fail::missing(format!("there is no {} {handle}", role.name())))
    }
    /// Arrays of bytes are texts from now on.
    pub(crate) fn bytes_as_text(&self, handle: i64, role: Role) -> Result {
        self.of(handle, role)?;
        if let Some(endpoint) = self.all()?.open.get_mut(&handle) {
            endpoint.bytes_as_text = true;
        }
        Ok(())
    }
    /// Those of a role and a name whose script is still there, in order of their making.
    fn alive(&self, world: &World<'_>, role: Role, name: &str) -> Result<Vec<Endpoint>> {
        let mut all = self.all()?;
        all.open.retain(|_, e| world.look(e.script).is_ok());
        Ok(all.open.values().filter(|e| e.role == role && e.name == name).cloned().collect())
    }

    /// A script publishes: other scripts of the world get it at once, clients by the service.
    pub(crate) fn publish(&self, c: &mut Ctx<'_>, from: &Endpoint, message: &Value) -> Result {
        let json = convert::node(message, &from.kind, from.ros())?.json();
        c.world().publish_value(
            MESSAGE,
            &keys([
                ("topic", Value::text(&from.name)),
                ("type", Value::text(&from.kind)),
                ("json", Value::text(json.to_string())),
            ]),
        )?;
        self.deliver(c, &from.name, &json)
    }
    /// Scripts that listen get a message.
    pub(crate) fn deliver(&self, c: &mut Ctx<'_>, topic: &str, json: &Json) -> Result {
        for to in self.alive(&c.world(), Role::Subscriber, topic)? {
            let message = for_script(convert::value(json, &to.kind, to.ros())?, to.bytes_as_text);
            to.call(c, message)?;
        }
        Ok(())
    }
    /// Calls a service that a script offers; `None`: none does.
    pub(crate) fn serve(&self, c: &mut Ctx<'_>, service: &str, request: &Json) -> Result<Option<Json>> {
        let Some(server) = self.alive(&c.world(), Role::Server, service)?.into_iter().next() else { return Ok(None) };
        let request = convert::value(request, &format!("{}Request", server.kind), server.ros())?;
        let request = for_script(request, server.bytes_as_text);
        let results = server.call(c, request)?;
        let response = results.first().unwrap_or(&Value::Nil);
        Ok(Some(convert::node(response, &format!("{}Response", server.kind), server.ros())?.json()))
    }

    /// Asks a client that offers a service; the number of the call.
    pub(crate) fn ask(&self, world: &World<'_>, client: i64, service: &str, request: &Json) -> Result<u64> {
        let number = {
            let mut all = self.all()?;
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
        world.publish_value(REQUEST, &payload)?;
        Ok(number)
    }
    /// An answer came.
    pub(crate) fn answered(&self, number: u64, json: String, good: bool) -> Result {
        self.all()?.answers.insert(number, (json, good));
        Ok(())
    }
    /// Takes the answer to a call, if it is there; and the handle that called.
    pub(crate) fn take(&self, number: u64) -> Result<(i64, Option<(String, bool)>)> {
        let mut all = self.all()?;
        let client = all.waiting.get(&number).copied().unwrap_or(0);
        let answer = all.answers.remove(&number);
        if answer.is_some() {
            all.waiting.remove(&number);
        }
        Ok((client, answer))
    }
}

impl Endpoint {
    /// Calls the script's function.
    fn call(&self, c: &mut Ctx<'_>, argument: Value) -> Result<Vec<Value>> {
        match self.function {
            Some(function) => c.call_func(function, &[argument]),
            None => c.world().call_function(self.script, &self.callback, &[argument]),
        }
    }
    /// One that is to be opened.
    pub(crate) fn new(role: Role, name: &str, kind: &str, ros: Ros, callback: Callback) -> Result<Endpoint> {
        if name.is_empty() || kind.is_empty() {
            return Err(Fail::argument("a name and a type are needed: '/cmd_vel', 'geometry_msgs/Twist'"));
        }
        Ok(Endpoint {
            role,
            // As ROS takes them: from the root.
            name: format!("/{}", name.trim_start_matches('/')),
            kind: types::plain(kind),
            two: ros == Ros::Two,
            callback: callback.0,
            function: callback.1,
            bytes_as_text: false,
            script: 0,
        })
    }
}

/// Arrays of bytes as a script gets them: a text, or a table of numbers.
fn for_script(value: Value, as_text: bool) -> Value {
    match value {
        Value::Bytes(b) if as_text => Value::Text(b),
        Value::Bytes(b) => Value::Ints(b.into_iter().map(i64::from).collect()),
        Value::Map(entries) => Value::Map(entries.into_iter().map(|(k, v)| (k, for_script(v, as_text))).collect()),
        Value::List(all) => Value::List(all.into_iter().map(|v| for_script(v, as_text)).collect()),
        other => other,
    }
}

fn tell(world: &World<'_>, of: &Endpoint, open: bool) -> Result {
    let payload = keys([
        ("role", Value::text(of.role.name())),
        ("name", Value::text(&of.name)),
        ("type", Value::text(&of.kind)),
        ("open", Value::Bool(open)),
    ]);
    world.publish_value(ENDPOINT, &payload)
}
