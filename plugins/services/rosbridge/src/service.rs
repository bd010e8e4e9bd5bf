//! What is done at the barrier: what clients ask, in order of connection; then what the scene tells.

use std::{
    cell::{RefCell, RefMut},
    collections::{BTreeMap, BTreeSet, btree_map::Entry},
    time::Instant,
};

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{self, Fail, Host, Param, Params, Result, Service, Session, Turn, Value, ValueRef},
};
use tatu_services_common::listener::{Listener, Settings};

use crate::{
    Props, Ros as Plugin,
    convert::{self, Node},
    messages::Source,
    node::{ENDPOINT, MESSAGE, REQUEST},
    peers::{Peer, Written},
    protocol::{self, Ask},
    relay::{self, Peers, Relay, SCRIPTS},
    robots::Scene,
    rosapi, scripts,
    topics::{self, Topic, What},
    types::{self, Ros},
};

/// The port of rosbridge.
const PORT: i64 = 9090;
/// Bytes of a message, and messages of one client in one turn.
const MOST_MESSAGE: usize = 64 << 20;
const AT_ONCE: usize = 1000;
/// Services that start and stop the simulation.
const CONTROL: &[(&str, u32)] = &[
    ("/simulation/start", TATU_REQUEST_START),
    ("/simulation/pause", TATU_REQUEST_PAUSE),
    ("/simulation/stop", TATU_REQUEST_STOP),
];

/// The service.
pub struct Rosbridge {
    p: Props,
    state: RefCell<State>,
}

struct State {
    peers: Peers,
    relay: Relay,
    params: BTreeMap<String, String>,
    scene: Scene,
    topics: BTreeMap<String, Topic>,
    /// Of each topic how often what it tells was measured when it was told last.
    told: BTreeMap<String, u64>,
    /// Topics that scripts listen to.
    heard: BTreeSet<String>,
    /// Calls of scripts for services of clients: number, service, arguments.
    requests: Vec<(u64, String, Json)>,
    /// The time for which the scene was told.
    time: f64,
    /// How long a robot goes on after a command, s.
    patience: f64,
    ros: Ros,
    listener: Listener,
}

impl Service for Rosbridge {
    type Plugin = Plugin;
    const ID: &'static str = "rosbridge";
    const TEXT: &'static str = "rosbridge: clients of ROS read sensors as topics and steer robots by velocities.";
    const EVENTS: &'static [&'static str] = &["started", "stopped", ENDPOINT, MESSAGE, REQUEST];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65535.0).default(PORT).text("of 127.0.0.1 to listen on; 0: any that is free"),
            Param::int("ros").range(1.0, 2.0).default(1).text(
                "whose names and times messages have, where a subscription names no type; else they are those of its type",
            ),
            Param::float("timeout")
                .unit("s")
                .range(0.0, 1e9)
                .default(0.5)
                .text("simulation time after which a robot stops that gets no further velocity; 0: it never does"),
            Param::string("origins").default("").text(
                "pages of other servers that may connect, with blanks between: http://localhost:8080. Programs always may",
            ),
        ]
    }

    fn start(plugin: &Plugin, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let port = params.i64("port")? as u16;
        let settings = Settings {
            port,
            path: "/",
            token: false,
            origins: params.string("origins")?.split_whitespace().map(str::to_owned).collect(),
            most_message: MOST_MESSAGE,
            files: |_| None,
            wake: Box::new(move || session.wake()),
        };
        let listener = Listener::open(settings).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}")).help("choose another `port`; 0 takes any")
        })?;
        session.log(TATU_LOG_INFO, &format!("rosbridge: listening on {}", listener.address));
        let state = State {
            peers: Peers::new(),
            relay: Relay::default(),
            params: BTreeMap::new(),
            scene: Scene::default(),
            topics: BTreeMap::new(),
            told: BTreeMap::new(),
            heard: BTreeSet::new(),
            requests: Vec::new(),
            time: -1.0,
            patience: params.f64("timeout")?,
            ros: if params.i64("ros")? == 2 { Ros::Two } else { Ros::One },
            listener,
        };
        Ok(Rosbridge { p: plugin.p, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, _: u64) -> Result<safe::Answer> {
        // One world is served: the first one of its session.
        if turn.worlds().0 == 0 {
            let state = &mut *self.state()?;
            state.come();
            if !state.peers.is_empty()
                || state.scene.robots.iter().any(|r| r.train.is_some())
                || state.time < 0.0
                || !state.requests.is_empty()
            {
                state.look(turn, &self.p)?;
                state.hear(turn, &self.p);
                state.asked_by_scripts(turn)?;
                state.tell(turn, &self.p)?;
            }
        }
        Ok(safe::Answer::Go)
    }

    fn event(&self, _: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        let text = |key: &str| payload.get(key).and_then(|v| v.as_str()).unwrap_or_default().into_owned();
        match name {
            ENDPOINT => {
                let open = payload.get("open").is_some_and(|v| v.truthy());
                state.of_scripts(&text("role"), text("name"), text("type"), open);
            }
            MESSAGE => {
                let (topic, plain) = (text("topic"), text("type"));
                let value = serde_json::from_str(&text("json")).map_err(|e| Fail::new(e.to_string()));
                if let Ok(value) = value.and_then(|json: Json| convert::value(&json, &plain, Ros::One)) {
                    state.spread(&topic, &|ros| convert::node(&value, &plain, ros));
                }
            }
            REQUEST => {
                let id = payload.get("id").and_then(|v| v.as_i64()).unwrap_or(0) as u64;
                state.requests.push((id, text("service"), serde_json::from_str(&text("json")).unwrap_or_default()));
            }
            _ => {
                // What wheels have driven is counted from the start.
                state.scene = Scene::default();
                state.told.clear();
                state.time = -1.0;
                if name == "stopped" {
                    state.relay.scripts_gone();
                }
            }
        }
    }
}

impl Rosbridge {
    fn state(&self) -> Result<RefMut<'_, State>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

impl State {
    /// Who has come and who has gone.
    fn come(&mut self) {
        for client in self.listener.take_new() {
            self.peers.insert(client.number, Peer::new(client));
        }
        let gone: Vec<u64> = self.peers.iter().filter(|(_, p)| p.client.is_gone()).map(|(n, _)| *n).collect();
        for number in gone {
            self.peers.remove(&number);
            self.relay.gone(&self.peers, number);
        }
    }

    /// What the scene holds now.
    fn look(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let ids = turn.list(0, 0, 0)?;
        if self.time < 0.0 || ids != self.scene.ids {
            self.scene = Scene::read(turn, p, ids, std::mem::take(&mut self.scene))?;
            self.topics = topics::of(turn, p, &self.scene);
        }
        Ok(())
    }

    /// Does what clients sent.
    fn hear(&mut self, turn: &Turn<'_>, p: &Props) {
        let numbers: Vec<u64> = self.peers.keys().copied().collect();
        for number in numbers {
            turn.client(number);
            for _ in 0..AT_ONCE {
                let Some(text) = self.peers.get(&number).and_then(|peer| peer.client.next()) else { break };
                let parsed = serde_json::from_str::<Json>(&text);
                let done = parsed.map_err(|e| (None, Fail::argument(format!("no JSON: {e}")))).and_then(|message| {
                    let id = message.get("id").and_then(Json::as_str).map(str::to_owned);
                    self.act(turn, p, number, message).map_err(|fail| (id, fail))
                });
                if let (Err((id, fail)), Some(peer)) = (done, self.peers.get(&number)) {
                    peer.status(id.as_deref(), fail.text());
                }
            }
        }
    }

    fn act(&mut self, turn: &Turn<'_>, p: &Props, number: u64, message: Json) -> Result {
        let message = match message.get("op").and_then(Json::as_str) {
            Some("fragment") => match self.peers.get_mut(&number).map(|peer| peer.fragments.take(&message)) {
                Some(Ok(Some(whole))) => whole,
                Some(Err(fail)) => return Err(fail),
                _ => return Ok(()),
            },
            _ => message,
        };
        let (id, ask) = protocol::read(&message)?;
        let Some(peer) = self.peers.get_mut(&number) else { return Ok(()) };
        match ask {
            Ask::Advertise { topic, kind } => {
                let plain = types::plain(&kind);
                if let Some(known) = self.kind(&topic).filter(|known| *known != plain) {
                    return Err(Fail::argument(format!("the topic {topic} has the type {known}, not {plain}")));
                }
                self.relay.topics.insert(topic.clone(), plain);
                if let Some(peer) = self.peers.get_mut(&number) {
                    peer.publishes.insert(topic);
                }
            }
            Ask::Unadvertise { topic } => drop(peer.publishes.remove(&topic)),
            Ask::Publish { topic, msg } => return self.published(turn, &topic, &msg),
            Ask::Subscribe { topic, kind, wish } => {
                let ros = Ros::of(&kind).unwrap_or(self.ros);
                let plain = types::plain(&kind);
                peer.subscribe(topic.clone(), wish, ros);
                if let Some(known) = self.kind(&topic).filter(|known| !kind.is_empty() && *known != plain) {
                    return Err(Fail::argument(format!("the topic {topic} has the type {known}, not {plain}")));
                }
                // What is known already is told at once, to whoever has just come as well.
                self.told.remove(&topic);
            }
            Ask::Unsubscribe { topic, id } => peer.unsubscribe(&topic, id.as_deref()),
            Ask::Level(level) => peer.told = level != "none",
            Ask::Call { service, args } => self.call(turn, p, number, id, &service, &args)?,
            Ask::Serve { service, kind } => drop(self.relay.services.insert(service, (number, kind))),
            Ask::Unserve { service } => self.relay.services.retain(|s, (peer, _)| *s != service || *peer != number),
            Ask::Answer { id, values, good } => self.relay.answered(&self.peers, number, &id, &values, good),
            Ask::OfferAction { action, kind } => self.relay.offer_action(action, Some(kind), number),
            Ask::WithdrawAction { action } => self.relay.offer_action(action, None, number),
            Ask::Goal { action, whole } => {
                if !self.relay.goal(&self.peers, number, id, &action, whole) {
                    return Err(Fail::missing(format!("nobody offers the action {action}")));
                }
            }
            Ask::Cancel { id, whole } => self.relay.cancel(&self.peers, number, &id, whole),
            Ask::Progress { id, whole, last } => self.relay.progress(&self.peers, number, &id, whole, last),
        }
        Ok(())
    }

    /// The type of a topic, if it is known.
    fn kind(&self, topic: &str) -> Option<String> {
        let own = self.topics.get(topic).map(|t| t.kind.to_owned());
        own.or_else(|| self.relay.of_scripts.get(topic).or_else(|| self.relay.topics.get(topic)).cloned())
    }

    /// A client published something: a robot's velocity, or what others listen to.
    fn published(&mut self, turn: &Turn<'_>, topic: &str, msg: &Json) -> Result {
        let plain = self.kind(topic).unwrap_or_default();
        let value = convert::value(msg, &plain, Ros::One)?;
        if let Some(Topic { what: What::Command(robot), .. }) = self.topics.get(topic) {
            let number =
                |of: &str, key: &str| msg.get(of).and_then(|v| v.get(key)).and_then(Json::as_f64).unwrap_or(0.0);
            return self.drive(turn, *robot, [number("linear", "x"), number("linear", "y"), number("angular", "z")]);
        }
        if let Some(known) = self.topics.get(topic) {
            return Err(Fail::unsupported(format!(
                "{topic} ({}) is what the scene tells: nobody else publishes it",
                known.kind
            )));
        }
        self.spread(topic, &|ros| convert::node(&value, &plain, ros));
        if self.heard.contains(topic) {
            turn.call(scripts::RECEIVE, &[Value::text(topic), Value::text(msg.to_string())], 0)?;
        }
        Ok(())
    }

    /// A script begins or ends something.
    fn of_scripts(&mut self, role: &str, name: String, kind: String, open: bool) {
        match (role, open) {
            ("subscriber", false) => drop(self.heard.remove(&name)),
            ("subscriber" | "publisher", true) => {
                if role == "subscriber" {
                    self.heard.insert(name.clone());
                }
                self.relay.of_scripts.insert(name, kind);
            }
            ("server", true) => drop(self.relay.services.insert(name, (SCRIPTS, kind))),
            ("server", false) => self.relay.services.retain(|s, (server, _)| *s != name || *server != SCRIPTS),
            _ => {}
        }
    }

    /// Passes calls of scripts on to clients, and what came back to scripts.
    fn asked_by_scripts(&mut self, turn: &Turn<'_>) -> Result {
        for (number, service, args) in std::mem::take(&mut self.requests) {
            if !self.relay.call(&self.peers, SCRIPTS, Some(number.to_string()), &service, &args) {
                let text = format!("there is no service {service}");
                self.relay.answers.push((number.to_string(), Json::String(text), false));
            }
        }
        for (number, values, good) in std::mem::take(&mut self.relay.answers) {
            let number = Value::Int(number.parse().unwrap_or(0));
            turn.call(scripts::ANSWER, &[number, Value::text(values.to_string()), Value::Bool(good)], 0)?;
        }
        Ok(())
    }

    /// Sends a message to all who listen and for whom one is due.
    fn spread(&mut self, topic: &str, node: &dyn Fn(Ros) -> Result<Node>) {
        let now = Instant::now();
        let mut written: BTreeMap<(Ros, bool), Written> = BTreeMap::new();
        for peer in self.peers.values_mut() {
            for (n, ros, cbor) in peer.due(topic, now) {
                let message = match written.entry((ros, cbor)) {
                    Entry::Occupied(there) => there.into_mut(),
                    Entry::Vacant(place) => {
                        let Ok(node) = node(ros) else { continue };
                        place.insert(Written::new(topic, &node, cbor))
                    }
                };
                peer.publish(topic, n, message, now);
            }
        }
    }

    /// Sets the velocity of a robot, by the command that stands in the log of inputs.
    fn drive(&mut self, turn: &Turn<'_>, robot: usize, twist: [f64; 3]) -> Result {
        let Some(robot) = self.scene.robots.get_mut(robot) else { return Ok(()) };
        let stands = twist == [0.0; 3];
        robot.until = (!stands && self.patience > 0.0).then_some(self.time.max(0.0) + self.patience);
        let handle = Value::Int((robot.base & 0xF_FFFF) as i64);
        let [x, y, z] = twist.map(Value::Float);
        turn.call("tatu.drive", &[handle, x, y, z], 0).map(drop)
    }

    fn call(
        &mut self,
        turn: &Turn<'_>,
        p: &Props,
        asker: u64,
        id: Option<String>,
        service: &str,
        args: &Json,
    ) -> Result {
        if self.relay.call(&self.peers, asker, id.clone(), service, args) {
            return Ok(());
        }
        let done = match self.relay.services.get(service) {
            Some((SCRIPTS, _)) => script(turn, service, args),
            _ => self.own(turn, p, service, args),
        };
        let (values, good) = match done {
            Ok(values) => (values, true),
            Err(fail) => (json!(fail.text()), false),
        };
        if let Some(peer) = self.peers.get(&asker) {
            peer.send(&relay::answer(id.as_deref(), service, &values, good));
        }
        Ok(())
    }

    /// The services that are there by themselves.
    fn own(&mut self, turn: &Turn<'_>, p: &Props, service: &str, args: &Json) -> Result<Json> {
        if let Some((_, request)) = CONTROL.iter().find(|(name, _)| *name == service) {
            turn.request(*request)?;
            return Ok(json!({ "success": true, "message": "" }));
        }
        let mut kinds: BTreeMap<String, String> =
            self.topics.iter().map(|(name, t)| (name.clone(), t.kind.to_owned())).collect();
        let listens = |t: &Topic| matches!(t.what, What::Command(_));
        let names =
            |taken: bool| self.topics.iter().filter(|(_, t)| listens(t) == taken).map(|(n, _)| n.clone()).collect();
        let (publishes, listened): (Vec<String>, Vec<String>) = (names(false), names(true));
        kinds.extend(self.relay.topics.clone());
        kinds.extend(self.relay.of_scripts.clone());
        let mut services: BTreeMap<String, String> =
            rosapi::SERVICES.iter().map(|(s, k)| ((*s).to_owned(), (*k).to_owned())).collect();
        services.extend(CONTROL.iter().map(|(s, _)| ((*s).to_owned(), "std_srvs/Trigger".to_owned())));
        services.extend(self.relay.services.iter().map(|(s, (_, kind))| (s.clone(), kind.clone())));
        let graph = rosapi::Graph {
            topics: &kinds,
            publishes: &publishes,
            listens: &listened,
            services: &services,
            time: turn.f64(0, p.time)?,
            ros: self.ros,
        };
        rosapi::call(&graph, &mut self.params, service, args)
            .unwrap_or_else(|| Err(Fail::missing(format!("there is no service {service}"))))
    }

    /// What the scene tells after a step: wheels are counted, robots that hear nothing more stop, topics are published.
    fn tell(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let time = turn.f64(0, p.time)?;
        if turn.state() != TATU_RUNNING || time == self.time {
            return Ok(());
        }
        self.time = time;
        for robot in &mut self.scene.robots {
            if let Some(train) = &robot.train {
                robot.odometry.take(train, time, train.read(turn, &p.wheels)?);
            }
        }
        let silent = |r: &crate::robots::Robot| r.until.is_some_and(|until| time >= until - 1e-9);
        let over: Vec<usize> = (0..self.scene.robots.len()).filter(|i| silent(&self.scene.robots[*i])).collect();
        for robot in over {
            self.drive(turn, robot, [0.0; 3])?;
        }
        let now = Instant::now();
        let topics: Vec<(String, Topic)> = self.topics.iter().map(|(n, t)| (n.clone(), t.clone())).collect();
        for (name, topic) in topics {
            if self.peers.values().all(|peer| peer.due(&name, now).is_empty()) {
                continue;
            }
            let value = {
                let dt = turn.f64(0, p.dt)?;
                let source = Source { turn, p, scene: &self.scene, time, dt };
                let sequence = source.sequence(topic.what);
                // What has not measured yet, or nothing new, tells nothing.
                if sequence == Some(0) || sequence.is_some() && self.told.get(&name) == sequence.as_ref() {
                    continue;
                }
                self.told.extend(sequence.map(|n| (name.clone(), n)));
                source.message(topic.what)?
            };
            if let Some(value) = value {
                self.spread(&name, &|ros| convert::node(&value, topic.kind, ros));
            }
        }
        Ok(())
    }
}

/// Calls a service that a script offers.
fn script(turn: &Turn<'_>, service: &str, args: &Json) -> Result<Json> {
    let done = turn.call(scripts::SERVE, &[Value::text(service), Value::text(args.to_string())], 0)?;
    let safe::Called::Done(values) = done else { return Err(Fail::unsupported("its script waits")) };
    let Some(Value::Text(text)) = values.first() else { return Ok(Json::Null) };
    serde_json::from_slice(text).map_err(|e| Fail::new(e.to_string()))
}

impl Drop for State {
    fn drop(&mut self) {
        self.peers.values().for_each(|p| p.client.out.cut());
    }
}
