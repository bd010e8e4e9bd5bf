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
use tatu_services_common::listener::{ListenerSettings, WebSocketListener};

use crate::{
    Props, RosPlugin as Plugin,
    convert::{self, MessageNode},
    description,
    goals::{CANCEL_EVENT, GOAL_EVENT, PROGRESS_EVENT},
    joint_trajectories::JointMotions,
    messages::MessageBuilder,
    node::{ClientOffers, ENDPOINT_EVENT, MESSAGE_EVENT, REQUEST_EVENT},
    peers::{BridgeClient, EncodedMessage},
    relay::{ClientMap, Relay, ScriptGoals},
    robots::RobotScene,
    topics::{self, SceneTopic},
    types::RosVersion,
};

/// The default port of rosbridge.
const DEFAULT_PORT: i64 = 9090;
/// The ROS parameter that makes nodes read the time from `/clock`.
const SIM_TIME_PARAM: &str = "/use_sim_time";
/// Last part of the names of the parameters that contain robot descriptions.
const DESCRIPTION_PARAM: &str = "robot_description";
/// Maximum size of a message from a client, bytes.
const MAX_MESSAGE_BYTES: usize = 64 << 20;

/// The service `rosbridge`, which connects ROS clients to the sensors, robots and scripts of a world.
pub struct RosbridgeService {
    p: Props,
    state: RefCell<BridgeState>,
}

pub(crate) struct BridgeState {
    pub(crate) peers: ClientMap,
    pub(crate) relay: Relay,
    /// Parameters, each as a string that contains JSON.
    pub(crate) params: BTreeMap<String, String>,
    /// Names of the current parameters that contain robot descriptions.
    description_params: Vec<String>,
    pub(crate) scene: RobotScene,
    pub(crate) joint_motions: JointMotions,
    /// Topics that the scene provides, by name.
    pub(crate) topics: BTreeMap<String, SceneTopic>,
    /// The result of `MessageBuilder::sequence` when a topic was last published, by topic.
    pub(crate) published: BTreeMap<String, u64>,
    /// Topics to which scripts have subscribed.
    pub(crate) script_subscriptions: BTreeSet<String>,
    /// Service calls of scripts that will be executed at the next barrier: the number of the call, the service, and the
    /// arguments.
    pub(crate) requests: Vec<(u64, String, Json)>,
    /// Goals of scripts that will be forwarded to clients.
    pub(crate) script_goals: ScriptGoals,
    /// The names of services and actions of clients that were last passed to scripts; `None` if they must be passed
    /// again.
    pub(crate) sent_offers: Option<ClientOffers>,
    /// The simulation time at which topics were last published, s.
    pub(crate) time: Option<f64>,
    /// Simulation time for which a velocity command is valid, s; 0: without limit.
    pub(crate) command_timeout_s: f64,
    /// The version of ROS for subscriptions without a type.
    pub(crate) ros: RosVersion,
    pub(crate) listener: WebSocketListener,
}

impl Service for RosbridgeService {
    type Plugin = Plugin;
    const ID: &'static str = "rosbridge";
    const TEXT: &'static str = "rosbridge: ROS clients read sensors as topics and drive robots by velocity commands.";
    const EVENTS: &'static [&'static str] =
        &["started", "stopped", ENDPOINT_EVENT, MESSAGE_EVENT, REQUEST_EVENT, GOAL_EVENT, CANCEL_EVENT, PROGRESS_EVENT];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port")
                .range(0.0, 65535.0)
                .default(DEFAULT_PORT)
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
        let settings = ListenerSettings {
            service: Self::ID,
            port,
            path: "/",
            token,
            origins: params.string("origins")?.split_whitespace().map(str::to_owned).collect(),
            max_message_bytes: MAX_MESSAGE_BYTES,
            files: |_| None,
            wake: Box::new({
                let session = session.clone();
                move || session.wake()
            }),
            on_message: Box::new(|_| ()),
        };
        let listener = WebSocketListener::open(settings).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        session.log(TATU_LOG_INFO, &format!("rosbridge: listening on {}", listener.address));
        if token {
            // The address is printed alone on a line of stderr, so that programs can read it. It is not logged, because
            // logs must not contain the token.
            eprintln!("ws://{}/?token={}", listener.address, listener.token);
        }
        let state = BridgeState {
            peers: ClientMap::new(),
            relay: Relay::default(),
            params: BTreeMap::from([(SIM_TIME_PARAM.to_owned(), "true".to_owned())]),
            description_params: Vec::new(),
            scene: RobotScene::default(),
            joint_motions: JointMotions::default(),
            topics: BTreeMap::new(),
            published: BTreeMap::new(),
            script_subscriptions: BTreeSet::new(),
            requests: Vec::new(),
            script_goals: ScriptGoals::default(),
            sent_offers: Some(ClientOffers::default()),
            time: None,
            command_timeout_s: params.f64("timeout")?,
            ros: if params.i64("ros")? == 2 { RosVersion::Two } else { RosVersion::One },
            listener,
        };
        Ok(RosbridgeService { p: plugin.p, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, _: u64) -> Result<safe::Answer> {
        // Only the first world of the session is served.
        if turn.worlds().0 == 0 {
            let state = &mut *self.state()?;
            state.accept_clients();
            state.refresh_scene(turn, &self.p)?;
            state.handle_requests(turn, &self.p);
            state.send_offers(turn)?;
            state.answer_script_calls(turn, &self.p)?;
            state.exchange_script_goals(turn);
            state.publish_topics(turn, &self.p)?;
        }
        Ok(safe::Answer::Go)
    }

    fn event(&self, _: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        let text = |key: &str| payload.get(key).and_then(|v| v.as_str()).unwrap_or_default().into_owned();
        match name {
            ENDPOINT_EVENT => {
                let open = payload.get("open").is_some_and(|v| v.truthy());
                state.update_script_endpoint(&text("role"), text("name"), text("type"), open);
            }
            MESSAGE_EVENT => {
                let (topic, plain) = (text("topic"), text("type"));
                let value = serde_json::from_str(&text("json")).map_err(|e| Fail::new(e.to_string()));
                if let Ok(value) = value.and_then(|json: Json| convert::value(&json, &plain, RosVersion::One)) {
                    state.publish_to_clients(&topic, &|ros| convert::node(&value, &plain, ros));
                }
            }
            REQUEST_EVENT => {
                let id = payload.get("id").and_then(|v| v.as_i64()).unwrap_or(0) as u64;
                state.requests.push((id, text("service"), serde_json::from_str(&text("json")).unwrap_or_default()));
            }
            GOAL_EVENT => {
                let args = serde_json::from_str(&text("json")).unwrap_or_default();
                state.script_goals.add_goal(text("id"), text("action"), &text("type"), args);
            }
            CANCEL_EVENT => state.script_goals.cancelled.push(text("id")),
            PROGRESS_EVENT => {
                let status = payload.get("status").and_then(|v| v.as_i64()).filter(|status| *status >= 0);
                state.forward_report(&text("id"), status, serde_json::from_str(&text("json")).unwrap_or_default());
            }
            _ => {
                // The simulation was started or stopped. The robots are read again, because odometry is relative to the
                // start of the run.
                state.scene = RobotScene::default();
                state.published.clear();
                state.time = None;
                state.sent_offers.take_if(|known| *known != ClientOffers::default());
                state.joint_motions.clear();
                if name == "stopped" {
                    state.script_subscriptions.clear();
                    state.script_goals = ScriptGoals::default();
                    let BridgeState { relay, peers, .. } = &mut *state;
                    relay.remove_scripts(peers);
                }
            }
        }
    }
}

impl RosbridgeService {
    fn state(&self) -> Result<RefMut<'_, BridgeState>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

impl BridgeState {
    /// Adds clients that have connected, and removes those that have disconnected.
    fn accept_clients(&mut self) {
        for client in self.listener.take_new() {
            self.peers.insert(client.number, BridgeClient::new(client));
        }
        let gone: Vec<u64> = self.peers.iter().filter(|(_, p)| p.client.is_gone()).map(|(n, _)| *n).collect();
        for number in gone {
            self.peers.remove(&number);
            self.relay.remove_client(&self.peers, number);
        }
    }

    /// Reads the robots and sensors again if objects have been added or removed.
    fn refresh_scene(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let ids = turn.list(0, 0, 0)?;
        if ids != self.scene.ids {
            self.scene = RobotScene::read(turn, p, ids, std::mem::take(&mut self.scene))?;
            self.topics = topics::scene_topics(turn, p, &self.scene);
            self.store_descriptions(turn, p)?;
        }
        Ok(())
    }

    /// Stores the descriptions of all robots as parameters: `/robot_description` for a single robot, otherwise
    /// `/NAME/robot_description`.
    fn store_descriptions(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        for name in std::mem::take(&mut self.description_params) {
            self.params.remove(&name);
        }
        for robot in &self.scene.robots {
            let name = format!("/{}{DESCRIPTION_PARAM}", robot.prefix);
            let urdf = description::urdf(turn, p, &self.scene, robot)?;
            self.params.insert(name.clone(), serde_json::Value::String(urdf).to_string());
            self.description_params.push(name);
        }
        Ok(())
    }

    /// Queues a message of a topic for all subscriptions for which one is due. `node` converts the message for a
    /// version of ROS; it is called at most once per version and encoding.
    pub(crate) fn publish_to_clients(&mut self, topic: &str, node: &dyn Fn(RosVersion) -> Result<MessageNode>) {
        let now = Instant::now();
        let mut written: BTreeMap<(RosVersion, bool), EncodedMessage> = BTreeMap::new();
        for peer in self.peers.values_mut() {
            let due: Vec<_> = peer.due_subscriptions(topic, now).collect();
            for (n, ros, cbor) in due {
                let message = match written.entry((ros, cbor)) {
                    Entry::Occupied(there) => there.into_mut(),
                    Entry::Vacant(place) => {
                        let Ok(node) = node(ros) else { continue };
                        place.insert(EncodedMessage::new(topic, &node, cbor))
                    }
                };
                peer.publish(topic, n, message, now);
            }
        }
    }

    /// After a step, updates odometry, stops robots with expired velocity commands, and publishes topics.
    fn publish_topics(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let time = turn.f64(0, p.time)?;
        if turn.state() != TATU_RUNNING || self.time == Some(time) {
            return Ok(());
        }
        self.time = Some(time);
        for robot in &mut self.scene.robots {
            if let Some(train) = &robot.drivetrain {
                robot.odometry.update(train, time, train.read(turn, &p.wheels)?);
            }
        }
        let silent = |r: &crate::robots::Robot| r.command_expiry.is_some_and(|until| time >= until - 1e-9);
        let over: Vec<usize> = (0..self.scene.robots.len()).filter(|i| silent(&self.scene.robots[*i])).collect();
        for robot in over {
            // Errors are ignored, because a robot that can no longer be driven need not be stopped.
            let _ = self.drive(turn, robot, [0.0; 3]);
        }
        let dt = turn.f64(0, p.dt)?;
        self.joint_motions.advance(turn, time, dt);
        let now = Instant::now();
        let wanted: BTreeSet<&str> = self.peers.values().flat_map(|peer| peer.due_topics(now)).collect();
        let wanted: Vec<String> = wanted.into_iter().map(str::to_owned).collect();
        for name in wanted {
            let Some(topic) = self.topics.get(&name).cloned() else { continue };
            let value = {
                let source = MessageBuilder { turn, p, scene: &self.scene, time, dt };
                let sequence = source.sequence(topic.content);
                // The topic is skipped if the sensor has not measured yet, or not since the topic was last published.
                if sequence == Some(0) || sequence.is_some() && self.published.get(&name) == sequence.as_ref() {
                    continue;
                }
                self.published.extend(sequence.map(|n| (name.clone(), n)));
                // If a sensor lacks a field of the message, nothing is published.
                source.message(topic.content).unwrap_or(None)
            };
            if let Some(value) = value {
                self.publish_to_clients(&name, &|ros| convert::node(&value, &topic.kind, ros));
            }
        }
        Ok(())
    }
}

impl Drop for BridgeState {
    fn drop(&mut self) {
        self.peers.values().for_each(|p| p.client.out.disconnect());
    }
}
