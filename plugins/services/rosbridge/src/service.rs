//! The barrier: executes requests of clients, in order of connection; then publishes topics of the scene.

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
/// The last part of the names of parameters that contain robot descriptions.
const DESCRIPTION: &str = "robot_description";
/// Maximum size of a message, bytes.
const MOST_MESSAGE: usize = 64 << 20;

/// The service.
pub struct Rosbridge {
    p: Props,
    state: RefCell<State>,
}

pub(crate) struct State {
    pub(crate) peers: Peers,
    pub(crate) relay: Relay,
    pub(crate) params: BTreeMap<String, String>,
    /// Names of the parameters that contain robot descriptions.
    described: Vec<String>,
    pub(crate) scene: Scene,
    pub(crate) topics: BTreeMap<String, Topic>,
    /// For each topic, the measurement count at which it was last published.
    pub(crate) told: BTreeMap<String, u64>,
    /// Topics that scripts subscribe to.
    pub(crate) heard: BTreeSet<String>,
    /// Calls of scripts to services of clients: number, service, arguments.
    pub(crate) requests: Vec<(u64, String, Json)>,
    /// Goals that scripts send to clients.
    pub(crate) of_scripts: GoalsOfScripts,
    /// The offers of clients that were last reported to scripts; `None`: they must be reported again.
    pub(crate) known: Option<Offered>,
    /// The time for which the scene was last published.
    pub(crate) time: Option<f64>,
    /// How long a velocity command is valid, s.
    pub(crate) patience: f64,
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
                .text("port of 127.0.0.1 to listen on; 0: any free one"),
            Param::int("ros").range(1.0, 2.0).default(1).text(
                "version of ROS whose type names and times are used if a subscription names no type; otherwise those \
                 of its type are used",
            ),
            Param::float("timeout")
                .unit("s")
                .range(0.0, 1e9)
                .default(0.5)
                .text("simulation time after which a robot stops if it receives no further velocity command; 0: never"),
            Param::bool("token").default(false).text(
                "whether clients must pass the token, which is printed at the start, in the address: \
                 ws://127.0.0.1:9090/?token=...",
            ),
            Param::string("origins").default("").text(
                "origins of other servers whose pages may connect, separated by spaces: http://localhost:8080. \
                 Programs may always connect",
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
        };
        let listener = Listener::open(settings).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`; 0 means any free port")
        })?;
        session.log(TATU_LOG_INFO, &format!("rosbridge: listening on {}", listener.address));
        if token {
            // Printed alone on a line, for programs to read; the token must not appear in logs.
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
                // Odometry begins at the start of the run.
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
    /// Handles clients that have connected or disconnected.
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

    /// Updates robots and sensors if the objects of the scene have changed.
    fn look(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let ids = turn.list(0, 0, 0)?;
        if ids != self.scene.ids {
            self.scene = Scene::read(turn, p, ids, std::mem::take(&mut self.scene))?;
            self.topics = topics::of(turn, p, &self.scene);
            self.describe(turn, p)?;
        }
        Ok(())
    }

    /// Stores the descriptions of the robots as parameters: `/robot_description` if there is only one robot, otherwise
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

    /// Sends a message to all subscriptions for which one is due.
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

    /// Updates odometry after a step, stops robots whose commands have expired, and publishes topics.
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
            // Errors are ignored: a robot that can no longer be driven need not be stopped.
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
                // Nothing is published if the sensor has not been measured yet, or not since the last time.
                if sequence == Some(0) || sequence.is_some() && self.told.get(&name) == sequence.as_ref() {
                    continue;
                }
                self.told.extend(sequence.map(|n| (name.clone(), n)));
                // A sensor that lacks a field of the message publishes nothing.
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
