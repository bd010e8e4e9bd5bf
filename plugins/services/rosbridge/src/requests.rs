//! Executes requests from clients and scripts.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{self, Fail, Result, Turn, Value},
};

use crate::{
    Props, convert,
    protocol::{self, BridgeRequest},
    relay::{self, SCRIPTS},
    rosapi, scripts,
    service::BridgeState,
    topics::{SceneTopic, TopicContent},
    types::{self, RosVersion},
};

/// Maximum number of messages per client that are processed at a barrier.
const MAX_MESSAGES_PER_BARRIER: usize = 1000;

impl BridgeState {
    /// Executes queued messages of all clients, at most `MAX_MESSAGES_PER_BARRIER` of each, and reports errors to their
    /// senders.
    pub(crate) fn handle_requests(&mut self, turn: &Turn<'_>, p: &Props) {
        let numbers: Vec<u64> = self.peers.keys().copied().collect();
        for number in numbers {
            turn.client(number);
            for _ in 0..MAX_MESSAGES_PER_BARRIER {
                let Some(text) = self.peers.get(&number).and_then(|peer| peer.client.next()) else { break };
                let parsed = serde_json::from_str::<Json>(&text);
                let done = parsed
                    .map_err(|e| (None, Fail::argument(format!("the message is not valid JSON: {e}"))))
                    .and_then(|message| {
                        let id = message.get("id").and_then(Json::as_str).map(str::to_owned);
                        self.execute_request(turn, p, number, message).map_err(|fail| (id, fail))
                    });
                if let (Err((id, fail)), Some(peer)) = (done, self.peers.get(&number)) {
                    peer.report_error(id.as_deref(), fail.text());
                }
            }
        }
    }

    /// Executes a message of a client.
    fn execute_request(&mut self, turn: &Turn<'_>, p: &Props, number: u64, message: Json) -> Result {
        let message = match message.get("op").and_then(Json::as_str) {
            Some("fragment") => match self.peers.get_mut(&number).map(|peer| peer.fragments.add(&message)) {
                Some(Ok(Some(whole))) => whole,
                Some(Err(fail)) => return Err(fail),
                _ => return Ok(()),
            },
            _ => message,
        };
        let (id, ask) = protocol::parse_request(&message)?;
        let Some(peer) = self.peers.get_mut(&number) else { return Ok(()) };
        match ask {
            BridgeRequest::Advertise { topic, kind } => {
                let plain = types::ros1_name(&kind);
                if let Some(known) = self.topic_type(&topic).filter(|known| *known != plain) {
                    return Err(Fail::argument(format!("the topic {topic} has the type {known}, not {plain}")));
                }
                self.relay.topics.insert(topic.clone(), plain);
                if let Some(peer) = self.peers.get_mut(&number) {
                    peer.publishes.insert(topic);
                }
            }
            BridgeRequest::Unadvertise { topic } => {
                peer.publishes.remove(&topic);
                self.relay.remove_unpublished_topics(&self.peers);
            }
            BridgeRequest::Publish { topic, msg } => return self.publish_for_client(turn, &topic, &msg),
            BridgeRequest::Subscribe { topic, kind, options: wish } => {
                let ros = RosVersion::of(&kind).unwrap_or(self.ros);
                let plain = types::ros1_name(&kind);
                if let Some(known) = self.topic_type(&topic).filter(|known| !kind.is_empty() && *known != plain) {
                    return Err(Fail::argument(format!("the topic {topic} has the type {known}, not {plain}")));
                }
                if let Some(peer) = self.peers.get_mut(&number) {
                    peer.subscribe(topic.clone(), wish, ros);
                }
                // The next barrier publishes the topic even if the sensor has not measured again since the last
                // message.
                self.published.remove(&topic);
            }
            BridgeRequest::Unsubscribe { topic, id } => peer.unsubscribe(&topic, id.as_deref()),
            BridgeRequest::Level(level) => peer.reports_errors = level != "none",
            BridgeRequest::Call { service, args } => self.call_service(turn, p, number, id, &service, &args)?,
            BridgeRequest::Serve { service, .. } if rosapi::is_own_service(&service) => {
                return Err(Fail::unsupported(format!("{service} is already provided by this server")));
            }
            BridgeRequest::Serve { service, kind } => drop(self.relay.services.insert(service, (number, kind))),
            BridgeRequest::Unserve { service } => {
                self.relay.services.retain(|s, (peer, _)| *s != service || *peer != number)
            }
            BridgeRequest::Answer { id, values, good } => {
                self.relay.forward_answer(&self.peers, number, &id, &values, good)
            }
            BridgeRequest::OfferAction { action, kind } => self.offer_action(number, action, kind)?,
            BridgeRequest::WithdrawAction { action } => self.relay.withdraw_action(&action, number),
            BridgeRequest::Goal { action, message: whole } => self.start_goal(turn, number, id, &action, whole)?,
            BridgeRequest::Cancel { id } => self.cancel_goal(turn, number, &id)?,
            BridgeRequest::Progress { id, values, status, good } => {
                self.relay.forward_progress(&self.peers, number, &id, status, values, good);
            }
        }
        Ok(())
    }

    /// Returns the type of a topic, or `None` if the topic is not known.
    fn topic_type(&self, topic: &str) -> Option<String> {
        let own = self.topics.get(topic).map(|t| t.kind.to_string());
        own.or_else(|| self.relay.script_topics.get(topic).or_else(|| self.relay.topics.get(topic)).cloned())
    }

    /// Executes a message published by a client: drives a robot if it is a velocity command or a joint trajectory,
    /// otherwise forwards it to the clients and scripts that have subscribed to the topic.
    fn publish_for_client(&mut self, turn: &Turn<'_>, topic: &str, msg: &Json) -> Result {
        let plain = self.topic_type(topic).unwrap_or_default();
        let value = convert::value(msg, &plain, RosVersion::One)?;
        if let Some(SceneTopic { content: TopicContent::Command(robot), .. }) = self.topics.get(topic) {
            let number =
                |of: &str, key: &str| msg.get(of).and_then(|v| v.get(key)).and_then(Json::as_f64).unwrap_or(0.0);
            return self.drive(turn, *robot, [number("linear", "x"), number("linear", "y"), number("angular", "z")]);
        }
        if let Some(SceneTopic { content: TopicContent::JointTrajectory(robot), .. }) = self.topics.get(topic) {
            let Some(robot) = self.scene.robots.get(*robot) else { return Ok(()) };
            return self.joint_motions.follow(turn, robot, self.time.unwrap_or(0.0), msg);
        }
        if let Some(known) = self.topics.get(topic) {
            return Err(Fail::unsupported(format!(
                "{topic} ({}) is published by the scene; clients cannot publish it",
                known.kind
            )));
        }
        self.publish_to_clients(topic, &|ros| convert::node(&value, &plain, ros));
        if self.script_subscriptions.contains(topic) {
            turn.call(scripts::RECEIVE, &[Value::text(topic), Value::text(msg.to_string())], 0)?;
        }
        Ok(())
    }

    /// Records that a script has opened or closed an endpoint.
    pub(crate) fn update_script_endpoint(&mut self, role: &str, name: String, kind: String, open: bool) {
        match (role, open) {
            ("subscriber", false) => drop(self.script_subscriptions.remove(&name)),
            ("subscriber" | "publisher", true) => {
                if role == "subscriber" {
                    self.script_subscriptions.insert(name.clone());
                }
                self.relay.script_topics.insert(name, kind);
            }
            ("server", true) => drop(self.relay.services.insert(name, (SCRIPTS, kind))),
            ("server", false) => self.relay.services.retain(|s, (server, _)| *s != name || *server != SCRIPTS),
            ("action server", true) => drop(self.relay.actions.insert(name, (SCRIPTS, kind))),
            ("action server", false) => self.relay.withdraw_action(&name, SCRIPTS),
            _ => {}
        }
    }

    /// Forwards service calls of scripts to the clients that offer the services, executes calls of this server's own
    /// services, and passes the answers to the scripts.
    pub(crate) fn answer_script_calls(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        for (number, service, args) in std::mem::take(&mut self.requests) {
            if !self.relay.forward_call(&self.peers, SCRIPTS, Some(number.to_string()), &service, &args) {
                let (values, good) = match self.call_own_service(turn, p, &service, &args) {
                    Ok(values) => (values, true),
                    Err(fail) => (json!(fail.text()), false),
                };
                self.relay.answers.push((number.to_string(), values, good));
            }
        }
        for (number, values, good) in std::mem::take(&mut self.relay.answers) {
            let number = Value::Int(number.parse().unwrap_or(0));
            turn.call(scripts::ANSWER, &[number, Value::text(values.to_string()), Value::Bool(good)], 0)?;
        }
        Ok(())
    }

    /// Sets the velocity of a robot (ahead and left in m/s, angular in rad/s) by calling a command, so that the input
    /// log records it.
    pub(crate) fn drive(&mut self, turn: &Turn<'_>, robot: usize, twist: [f64; 3]) -> Result {
        let Some(robot) = self.scene.robots.get_mut(robot) else { return Ok(()) };
        let stands = twist == [0.0; 3];
        robot.command_expiry =
            (!stands && self.command_timeout_s > 0.0).then_some(self.time.unwrap_or(0.0) + self.command_timeout_s);
        let handle = Value::Int(i64::from(tatu_slot(robot.base)));
        let [x, y, z] = twist.map(Value::Float);
        turn.call("tatu.drive", &[handle, x, y, z], 0).map(drop)
    }

    /// Calls a service for a client. Another client, a script or this server may offer the service.
    fn call_service(
        &mut self,
        turn: &Turn<'_>,
        p: &Props,
        asker: u64,
        id: Option<String>,
        service: &str,
        args: &Json,
    ) -> Result {
        if self.relay.forward_call(&self.peers, asker, id.clone(), service, args) {
            return Ok(());
        }
        let done = match self.relay.services.get(service) {
            Some((SCRIPTS, _)) => call_script_service(turn, service, args),
            _ => self.call_own_service(turn, p, service, args),
        };
        let (values, good) = match done {
            Ok(values) => (values, true),
            Err(fail) => (json!(fail.text()), false),
        };
        if let Some(peer) = self.peers.get(&asker) {
            peer.send(&relay::service_response(id.as_deref(), service, &values, good));
        }
        Ok(())
    }

    /// Executes a service that this server provides, and returns its response.
    fn call_own_service(&mut self, turn: &Turn<'_>, p: &Props, service: &str, args: &Json) -> Result<Json> {
        if let Some((_, request)) = rosapi::CONTROL_SERVICES.iter().find(|(name, _)| *name == service) {
            turn.request(*request)?;
            return Ok(json!({ "success": true, "message": "" }));
        }
        let mut kinds: BTreeMap<String, String> =
            self.topics.iter().map(|(name, t)| (name.clone(), t.kind.to_string())).collect();
        let listens = |t: &SceneTopic| matches!(t.content, TopicContent::Command(_) | TopicContent::JointTrajectory(_));
        let names =
            |taken: bool| self.topics.iter().filter(|(_, t)| listens(t) == taken).map(|(n, _)| n.clone()).collect();
        let (publishes, listened): (Vec<String>, Vec<String>) = (names(false), names(true));
        kinds.extend(self.relay.topics.clone());
        kinds.extend(self.relay.script_topics.clone());
        let mut services: BTreeMap<String, String> =
            rosapi::SERVICES.iter().map(|(s, k)| ((*s).to_owned(), (*k).to_owned())).collect();
        services.extend(rosapi::CONTROL_SERVICES.iter().map(|(s, _)| ((*s).to_owned(), "std_srvs/Trigger".to_owned())));
        services.extend(self.relay.services.iter().map(|(s, (_, kind))| (s.clone(), kind.clone())));
        let graph = rosapi::RosGraph {
            topics: &kinds,
            publishes: &publishes,
            subscribes: &listened,
            services: &services,
            time: turn.f64(0, p.time)?,
            ros: self.ros,
        };
        rosapi::call(&graph, &mut self.params, service, args)
            .unwrap_or_else(|| Err(Fail::missing(format!("there is no service {service}"))))
    }
}

/// Calls a service that a script offers, and returns its response.
fn call_script_service(turn: &Turn<'_>, service: &str, args: &Json) -> Result<Json> {
    let done = turn.call(scripts::SERVE, &[Value::text(service), Value::text(args.to_string())], 0)?;
    let safe::Called::Done(values) = done else {
        return Err(Fail::unsupported(format!(
            "the script function of the service `{service}` waits for the simulation, which is not possible in a call \
             from a client"
        )));
    };
    let Some(Value::Text(text)) = values.first() else { return Ok(Json::Null) };
    serde_json::from_slice(text).map_err(|e| Fail::new(e.to_string()))
}
