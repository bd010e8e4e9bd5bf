//! The service `rosbridge`. At each barrier, it executes requests from clients in order of connection, then publishes
//! topics of the scene.

use std::{
    cell::{RefCell, RefMut},
    collections::{BTreeMap, BTreeSet, btree_map::Entry},
    time::Instant,
};

use serde_json::Value as Json;
use tatu_plugin_api::{
    abi::*,
    safe::{self, Fail, Host, Param, Params, Result, Service, Session, Turn, ValueRef},
};
use tatu_services_common::listener::{Listener, Settings};

use crate::{
    Props, Ros as Plugin,
    convert::{self, Node},
    description,
    goals::{CANCEL, GOAL, PROGRESS},
    messages::Source,
    node::{ENDPOINT, MESSAGE, Offered, REQUEST},
    peers::{Peer, Written},
    relay::{GoalsOfScripts, Peers, Relay},
    robots::Scene,
    topics::{self, Topic},
    types::Ros,
};

/// The default port of rosbridge.
const PORT: i64 = 9090;
/// The ROS parameter that makes nodes read the time from `/clock`.
const SIM_TIME: &str = "/use_sim_time";
/// Last part of the names of the parameters that contain robot descriptions.
const DESCRIPTION: &str = "robot_description";
/// Maximum size of a message from a client, bytes.
const MOST_MESSAGE: usize = 64 << 20;

/// The service `rosbridge`.
pub struct Rosbridge {
    p: Props,
    state: RefCell<State>,
}

pub(crate) struct State {
    pub(crate) peers: Peers,
    pub(crate) relay: Relay,
    /// Parameters, each as a string that contains JSON.
    pub(crate) params: BTreeMap<String, String>,
    /// Names of the current parameters that contain robot descriptions.
    described: Vec<String>,
    pub(crate) scene: Scene,
    /// Topics that the scene provides, by name.
    pub(crate) topics: BTreeMap<String, Topic>,
    /// The result of `Source::sequence` when a topic was last published, by topic.
    pub(crate) told: BTreeMap<String, u64>,
    /// Topics to which scripts have subscribed.
    pub(crate) heard: BTreeSet<String>,
    /// Service calls of scripts that will be executed at the next barrier: the number of the call, the service, and the
    /// arguments.
    pub(crate) requests: Vec<(u64, String, Json)>,
    /// Goals of scripts that will be forwarded to clients.
    pub(crate) of_scripts: GoalsOfScripts,
    /// The names of services and actions of clients that were last passed to scripts; `None` if they must be passed
    /// again.
    pub(crate) known: Option<Offered>,
    /// The simulation time at which topics were last published, s.
    pub(crate) time: Option<f64>,
    /// Simulation time for which a velocity command is valid, s; 0: without limit.
    pub(crate) patience: f64,
    /// The version of ROS for subscriptions without a type.
    pub(crate) ros: Ros,
    pub(crate) listener: Listener,
}

impl Service for Rosbridge {
    type Plugin = Plugin;
    const ID: &'static str = "rosbridge";
    const TEXT: &'static str = "rosbridge: ROS clients read sensors as topics and drive robots by velocity commands.";
    const EVENTS: &'static [&'static str] = &["started", "stopped", ENDPOINT, MESSAGE, REQUEST, GOAL, CANCEL, PROGRESS];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port")
                .range(0.0, 65535.0)
                .default(PORT)
                .text("port on 127.0.0.1 to listen on; 0: any free port"),
            Param::int("ros").range(1.0, 2.0).default(1).text(
                "version of ROS that determines type names and times for subscriptions without a type; otherwise, the \
                 form of the type name does",
            ),
            Param::float("timeout")
                .unit("s")
                .range(0.0, 1e9)
                .default(0.5)
                .text("simulation time after which a robot stops if it receives no further velocity command; 0: never"),
            Param::bool("token").default(false).text(
                "whether clients must pass a token in the address, as in ws://127.0.0.1:9090/?token=...; the token is \
                 printed at the start",
            ),
            Param::string("origins").default("").text(
                "further origins from which pages may connect, such as http://localhost:8080, separated by spaces. \
                 Programs other than browsers may always connect",
            ),
        ]
    }

    fn start(plugin: &Plugin, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let port = params.i64("port")? as u16;
        let token = params.bool("token")?;
        let settings = Settings {
            service: Self::ID,
            port,
            path: "/",
            token,
            origins: params.string("origins")?.split_whitespace().map(str::to_owned).collect(),
            most_message: MOST_MESSAGE,
            files: |_| None,
            wake: Box::new({
                let session = session.clone();
                move || session.wake()
            }),
            heard: Box::new(|_| ()),
        };
        let listener = Listener::open(settings).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        session.log(TATU_LOG_INFO, &format!("rosbridge: listening on {}", listener.address));
        if token {
            // The address is printed alone on a line of stderr, so that programs can read it. It is not logged, because
            // logs must not contain the token.
            eprintln!("ws://{}/?token={}", listener.address, listener.token);
        }
        let state = State {
            peers: Peers::new(),
            relay: Relay::default(),
            params: BTreeMap::from([(SIM_TIME.to_owned(), "true".to_owned())]),
            described: Vec::new(),
            scene: Scene::default(),
            topics: BTreeMap::new(),
            told: BTreeMap::new(),
            heard: BTreeSet::new(),
            requests: Vec::new(),
            of_scripts: GoalsOfScripts::default(),
            known: Some(Offered::default()),
            time: None,
            patience: params.f64("timeout")?,
            ros: if params.i64("ros")? == 2 { Ros::Two } else { Ros::One },
            listener,
        };
        Ok(Rosbridge { p: plugin.p, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, _: u64) -> Result<safe::Answer> {
        // Only the first world of the session is served.
        if turn.worlds().0 == 0 {
            let state = &mut *self.state()?;
            state.come();
            state.look(turn, &self.p)?;
            state.hear(turn, &self.p);
            state.tell_offers(turn)?;
            state.asked_by_scripts(turn, &self.p)?;
            state.goals_of_scripts(turn);
            state.tell(turn, &self.p)?;
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
            GOAL => {
                let args = serde_json::from_str(&text("json")).unwrap_or_default();
                state.of_scripts.give(text("id"), text("action"), &text("type"), args);
            }
            CANCEL => state.of_scripts.taken_back.push(text("id")),
            PROGRESS => {
                let status = payload.get("status").and_then(|v| v.as_i64()).filter(|status| *status >= 0);
                state.reported(&text("id"), status, serde_json::from_str(&text("json")).unwrap_or_default());
            }
            _ => {
                // The simulation was started or stopped. The robots are read again, because odometry is relative to the
                // start of the run.
                state.scene = Scene::default();
                state.told.clear();
                state.time = None;
                state.known.take_if(|known| *known != Offered::default());
                if name == "stopped" {
                    state.heard.clear();
                    state.of_scripts = GoalsOfScripts::default();
                    let State { relay, peers, .. } = &mut *state;
                    relay.scripts_gone(peers);
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
    /// Adds clients that have connected, and removes those that have disconnected.
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

    /// Reads the robots and sensors again if objects have been added or removed.
    fn look(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let ids = turn.list(0, 0, 0)?;
        if ids != self.scene.ids {
            self.scene = Scene::read(turn, p, ids, std::mem::take(&mut self.scene))?;
            self.topics = topics::of(turn, p, &self.scene);
            self.describe(turn, p)?;
        }
        Ok(())
    }

    /// Stores the descriptions of all robots as parameters: `/robot_description` for a single robot, otherwise
    /// `/NAME/robot_description`.
    fn describe(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        for name in std::mem::take(&mut self.described) {
            self.params.remove(&name);
        }
        for robot in &self.scene.robots {
            let name = format!("/{}{DESCRIPTION}", robot.prefix);
            let urdf = description::urdf(turn, p, &self.scene, robot)?;
            self.params.insert(name.clone(), serde_json::Value::String(urdf).to_string());
            self.described.push(name);
        }
        Ok(())
    }

    /// Queues a message of a topic for all subscriptions for which one is due. `node` converts the message for a
    /// version of ROS; it is called at most once per version and encoding.
    pub(crate) fn spread(&mut self, topic: &str, node: &dyn Fn(Ros) -> Result<Node>) {
        let now = Instant::now();
        let mut written: BTreeMap<(Ros, bool), Written> = BTreeMap::new();
        for peer in self.peers.values_mut() {
            let due: Vec<_> = peer.due(topic, now).collect();
            for (n, ros, cbor) in due {
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

    /// After a step, updates odometry, stops robots with expired velocity commands, and publishes topics.
    fn tell(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let time = turn.f64(0, p.time)?;
        if turn.state() != TATU_RUNNING || self.time == Some(time) {
            return Ok(());
        }
        self.time = Some(time);
        for robot in &mut self.scene.robots {
            if let Some(train) = &robot.train {
                robot.odometry.take(train, time, train.read(turn, &p.wheels)?);
            }
        }
        let silent = |r: &crate::robots::Robot| r.until.is_some_and(|until| time >= until - 1e-9);
        let over: Vec<usize> = (0..self.scene.robots.len()).filter(|i| silent(&self.scene.robots[*i])).collect();
        for robot in over {
            // Errors are ignored, because a robot that can no longer be driven need not be stopped.
            let _ = self.drive(turn, robot, [0.0; 3]);
        }
        let now = Instant::now();
        let wanted: BTreeSet<&str> = self.peers.values().flat_map(|peer| peer.wants(now)).collect();
        let wanted: Vec<String> = wanted.into_iter().map(str::to_owned).collect();
        let dt = turn.f64(0, p.dt)?;
        for name in wanted {
            let Some(topic) = self.topics.get(&name).cloned() else { continue };
            let value = {
                let source = Source { turn, p, scene: &self.scene, time, dt };
                let sequence = source.sequence(topic.what);
                // The topic is skipped if the sensor has not measured yet, or not since the topic was last published.
                if sequence == Some(0) || sequence.is_some() && self.told.get(&name) == sequence.as_ref() {
                    continue;
                }
                self.told.extend(sequence.map(|n| (name.clone(), n)));
                // If a sensor lacks a field of the message, nothing is published.
                source.message(topic.what).unwrap_or(None)
            };
            if let Some(value) = value {
                self.spread(&name, &|ros| convert::node(&value, topic.kind, ros));
            }
        }
        Ok(())
    }
}

impl Drop for State {
    fn drop(&mut self) {
        self.peers.values().for_each(|p| p.client.out.cut());
    }
}
