//! What the scripts of a world publish, listen to, offer and ask: stored here, and passed to the service by events.

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
    Ctx, convert,
    goals::Goal,
    pixels, rosapi,
    types::{self, Ros},
};

/// Told when a script begins or ends to publish, to listen or to serve.
pub(crate) const ENDPOINT: &str = "ros.endpoint";
/// Told when a script publishes.
pub(crate) const MESSAGE: &str = "ros.message";
/// Told when a script calls a service that no script offers.
pub(crate) const REQUEST: &str = "ros.request";

/// What a script gave to be called: a function of it by its name, or kept. With neither nothing is called.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Callback {
    name: String,
    /// No snapshot has it.
    #[serde(skip)]
    function: Option<tatu_func>,
}

impl Callback {
    /// What argument `i` of a call says.
    pub(crate) fn read(c: &Ctx<'_>, i: usize) -> Result<Callback> {
        Ok(match c.arg(i).as_func() {
            Some(function) => Callback { name: String::new(), function: Some(c.keep_func(function)?) },
            None => Callback { name: c.text(i)?, function: None },
        })
    }
    fn is_none(&self) -> bool {
        self.name.is_empty() && self.function.is_none()
    }
}

/// What a handle of a script stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Role {
    Publisher,
    Subscriber,
    Client,
    Server,
    ActionClient,
    ActionServer,
}

impl Role {
    /// Its name in the event.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Role::Publisher => "publisher",
            Role::Subscriber => "subscriber",
            Role::Client => "client",
            Role::Server => "server",
            Role::ActionClient => "action client",
            Role::ActionServer => "action server",
        }
    }
}

/// One thing that a script does with ROS.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Endpoint {
    pub(crate) role: Role,
    pub(crate) name: String,
    /// The type, with the name of ROS 1; of a service without `Request`, of an action without `Goal`.
    pub(crate) kind: String,
    /// Whether the script has names and times of ROS 2.
    pub(crate) two: bool,
    /// What is called: one function, or those of an action in the order in which they were given.
    callbacks: Vec<Callback>,
    /// Whether arrays of bytes are texts for the script.
    pub(crate) bytes_as_text: bool,
    /// Whether the script gets the pixels of images, not messages.
    pub(crate) pixels: bool,
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
    pub(crate) open: BTreeMap<i64, Endpoint>,
    /// Parameters that scripts set.
    pub(crate) params: BTreeMap<String, Json>,
    asked: u64,
    /// The handles of clients whose calls wait.
    waiting: BTreeMap<u64, i64>,
    answers: BTreeMap<u64, (String, bool)>,
    /// What clients of the service offer.
    pub(crate) offered: Offered,
    /// Goals that have no result yet, by their ids.
    pub(crate) goals: BTreeMap<String, Goal>,
    /// Goals that were ever given, counted.
    pub(crate) given: u64,
    /// Threads that wait until somebody offers something, by number.
    pub(crate) waits: BTreeMap<u64, Wait>,
}

/// What clients of rosbridge offer scripts.
#[derive(Debug, Default, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Offered {
    pub(crate) services: BTreeSet<String>,
    pub(crate) actions: BTreeSet<String>,
}

/// A thread that waits until somebody offers what it asks.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Wait {
    /// The handle by which it asks.
    pub(crate) handle: i64,
    /// What it will send.
    pub(crate) json: Json,
    /// Simulation time at which it gives up, s.
    pub(crate) until: f64,
}

/// The node of a world. Commands may enter each other: borrow briefly, never across a call to the host.
#[derive(Default)]
pub struct Node(RefCell<All>);

impl Node {
    /// As bytes, for snapshots; an error: functions cannot be written.
    pub(crate) fn write(&self) -> Result<Vec<u8>> {
        let all = self.all()?;
        if all.open.values().flat_map(|e| &e.callbacks).any(|f| f.function.is_some()) {
            return Err(Fail::unsupported("callbacks given as functions cannot be saved: use names of functions"));
        }
        serde_json::to_vec(&*all).map_err(|e| Fail::new(format!("the ROS state of scripts cannot be written: {e}")))
    }
    pub(crate) fn all(&self) -> Result<RefMut<'_, All>> {
        self.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the ROS state of scripts is in use"))
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
        let mut all = self.all()?;
        let offered = std::mem::take(&mut all.offered);
        *all = All { made, open: kept, offered, ..All::default() };
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
        endpoint.callbacks.iter().filter_map(|f| f.function).for_each(|f| c.drop_func(f));
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
    /// Those of a role and a name whose script is still there, in order of their making, with their handles.
    pub(crate) fn alive(&self, world: &World<'_>, role: Role, name: &str) -> Result<Vec<(i64, Endpoint)>> {
        let mut all = self.all()?;
        all.open.retain(|_, e| world.look(e.script).is_ok());
        let found = all.open.iter().filter(|(_, e)| e.role == role && e.name == name);
        Ok(found.map(|(handle, e)| (*handle, e.clone())).collect())
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
        for (_, to) in self.alive(&c.world(), Role::Subscriber, topic)? {
            let message = convert::value(json, &to.kind, to.ros())?;
            let arguments = if to.pixels { pixels::pixels(&message)?.to_vec() } else { vec![to.given(message)] };
            to.call(c, 0, &arguments)?;
        }
        Ok(())
    }
    /// Calls a service that a script offers; `None`: none does.
    pub(crate) fn serve(&self, c: &mut Ctx<'_>, service: &str, request: &Json) -> Result<Option<Json>> {
        let Some((_, server)) = self.alive(&c.world(), Role::Server, service)?.into_iter().next() else {
            return Ok(None);
        };
        let request = convert::value(request, &format!("{}Request", server.kind), server.ros())?;
        let results = server.call(c, 0, &[server.given(request)])?;
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
    /// A thread waits; its number.
    pub(crate) fn wait(&self, wait: Wait) -> Result<u64> {
        let mut all = self.all()?;
        all.asked += 1;
        let number = all.asked;
        all.waits.insert(number, wait);
        Ok(number)
    }
    /// Whether a script or a client offers a service.
    pub(crate) fn has_service(&self, world: &World<'_>, name: &str) -> Result<bool> {
        Ok(self.all()?.offered.services.contains(name)
            || !self.alive(world, Role::Server, name)?.is_empty()
            || rosapi::is_own(name) && world.is_wanted(REQUEST))
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
    /// Calls the script's function of a number; without one there is no result.
    pub(crate) fn call(&self, c: &mut Ctx<'_>, n: usize, arguments: &[Value]) -> Result<Vec<Value>> {
        let Some(callback) = self.callbacks.get(n).filter(|f| !f.is_none()) else { return Ok(Vec::new()) };
        match callback.function {
            Some(function) => c.call_func(function, arguments),
            None => c.world().call_function(self.script, &callback.name, arguments),
        }
    }
    /// A message as the script gets it.
    pub(crate) fn given(&self, message: Value) -> Value {
        for_script(message, self.bytes_as_text)
    }
    /// One that is to be opened.
    pub(crate) fn new(role: Role, name: &str, kind: &str, ros: Ros, callbacks: Vec<Callback>) -> Result<Endpoint> {
        if name.is_empty() || kind.is_empty() {
            return Err(Fail::argument("a name and a type are needed: '/cmd_vel', 'geometry_msgs/Twist'"));
        }
        Ok(Endpoint {
            role,
            // As ROS takes them: from the root.
            name: format!("/{}", name.trim_start_matches('/')),
            kind: types::plain(kind),
            two: ros == Ros::Two,
            callbacks,
            bytes_as_text: false,
            pixels: false,
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
