//! Tracks the topics, services and actions that clients and scripts offer. Calls and goals are forwarded to the server
//! with a new id, and the answers are forwarded to the caller with the original id.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};

use crate::{peers::BridgeClient, types::RosVersion};

/// A call or goal that was sent to its server, and whose result has not arrived.
struct RelayedRequest {
    /// Number of the client that sent the call or goal, or `SCRIPTS`.
    sender: u64,
    /// The id that the sender has assigned to the call or goal.
    id: Option<String>,
    /// Name of the service or action.
    target: String,
    /// Number of the client that executes the call or goal, or `SCRIPTS`.
    server: u64,
    /// Whether the sender has requested feedback on the goal; false for calls.
    feedback: bool,
}

/// Feedback on a goal of a script, or its result.
pub struct GoalReport {
    /// The id of the goal.
    pub id: String,
    /// The final status, as in `action_msgs/GoalStatus`; `None` for feedback.
    pub status: Option<i64>,
    /// The feedback or the result.
    pub values: Json,
}

/// Goals of scripts, and requests to cancel them, that will be forwarded to clients at the next barrier.
#[derive(Default)]
pub struct ScriptGoals {
    /// Goals: the id, the action, and the message for the server of the action.
    pub goals: Vec<(String, String, Json)>,
    /// Ids of the goals to be cancelled.
    pub cancelled: Vec<String>,
}

impl ScriptGoals {
    /// Adds a goal of a script; `plain` is the type of the action by its name in ROS 1.
    pub fn add_goal(&mut self, id: String, action: String, plain: &str, args: Json) {
        let kind = RosVersion::Two.name(plain).replace("/msg/", "/action/");
        let message = json!({
            "op": "send_action_goal", "action": action, "action_type": kind, "args": args, "feedback": true,
        });
        self.goals.push((id, action, message));
    }
}

/// Status in `action_msgs/GoalStatus`: unknown, used for goals that were rejected or lost.
pub const UNKNOWN: i64 = 0;
/// Status in `action_msgs/GoalStatus`: aborted.
pub const ABORTED: i64 = 6;

/// The topics, services and actions of clients and scripts, and all pending calls and goals.
#[derive(Default)]
pub struct Relay {
    /// Types (by their names in ROS 1) of topics that clients publish, by topic.
    pub topics: BTreeMap<String, String>,
    /// The number of the server and the type of each service, by name.
    pub services: BTreeMap<String, (u64, String)>,
    /// Types of topics that scripts publish or subscribe to, by topic.
    pub script_topics: BTreeMap<String, String>,
    /// Answers to calls of scripts: the number of the call, the values, and whether the call succeeded.
    pub answers: Vec<(String, Json, bool)>,
    /// Feedback and results for goals of scripts.
    pub reports: Vec<GoalReport>,
    /// The number of the server and the type of each action, by name.
    pub actions: BTreeMap<String, (u64, String)>,
    /// Pending calls, by the id that the relay has assigned.
    calls: BTreeMap<String, RelayedRequest>,
    /// Pending goals, by the id that the relay has assigned.
    goals: BTreeMap<String, RelayedRequest>,
    /// Number of ids that the relay has assigned, from which it builds the next one.
    count: u64,
}

/// The number that represents all scripts as caller or server. Clients have numbers from 1.
pub const SCRIPTS: u64 = 0;

/// The connected clients, by their number.
pub type ClientMap = BTreeMap<u64, BridgeClient>;

/// Builds the answer to a service call.
pub fn service_response(id: Option<&str>, service: &str, values: &Json, good: bool) -> Json {
    let mut out = json!({ "op": "service_response", "service": service, "values": values, "result": good });
    if let Some(id) = id {
        out["id"] = json!(id);
    }
    out
}

impl Relay {
    /// Returns a new id for a call or goal; `what` is its prefix.
    fn new_id(&mut self, what: &str) -> String {
        self.count += 1;
        format!("{what}:{}", self.count)
    }

    /// Removes an action if it is offered by the client with number `peer`, or by scripts if `peer` is `SCRIPTS`.
    pub fn withdraw_action(&mut self, action: &str, peer: u64) {
        self.actions.retain(|a, (p, _)| a != action || *p != peer);
    }

    /// Forwards a call to the client that offers the service. Returns false if there is none.
    pub fn forward_call(
        &mut self,
        peers: &ClientMap,
        asker: u64,
        id: Option<String>,
        service: &str,
        args: &Json,
    ) -> bool {
        let Some((server, _)) = self.services.get(service).cloned() else { return false };
        let Some(peer) = peers.get(&server) else { return false };
        let own = self.new_id("call");
        peer.send(&json!({ "op": "call_service", "id": own, "service": service, "args": args }));
        self.calls
            .insert(own, RelayedRequest { sender: asker, id, target: service.to_owned(), server, feedback: false });
        true
    }

    /// Forwards the answer of a server to the caller.
    pub fn forward_answer(&mut self, peers: &ClientMap, server: u64, id: &str, values: &Json, good: bool) {
        if self.calls.get(id).is_some_and(|w| w.server == server)
            && let Some(waiting) = self.calls.remove(id)
        {
            self.send_answer(peers, &waiting, values, good);
        }
    }

    /// Sends the answer to a pending call to its caller.
    fn send_answer(&mut self, peers: &ClientMap, to: &RelayedRequest, values: &Json, good: bool) {
        if to.sender == SCRIPTS {
            self.answers.extend(to.id.clone().map(|id| (id, values.clone(), good)));
        } else if let Some(asker) = peers.get(&to.sender) {
            asker.send(&service_response(to.id.as_deref(), &to.target, values, good));
        }
    }

    /// Removes everything that scripts have offered or requested, after the simulation has stopped.
    pub fn remove_scripts(&mut self, peers: &ClientMap) {
        self.services.retain(|_, (server, _)| *server != SCRIPTS);
        self.actions.retain(|_, (server, _)| *server != SCRIPTS);
        self.end_goals(peers, SCRIPTS, &json!("the simulation has stopped"));
        self.reports.clear();
        self.script_topics.clear();
        self.answers.clear();
        self.calls.retain(|_, w| w.sender != SCRIPTS);
    }

    /// Records a goal, and returns the id that the relay has assigned to it.
    pub fn record_goal(&mut self, asker: u64, id: Option<String>, action: &str, server: u64, feedback: bool) -> String {
        let own = self.new_id("goal");
        self.goals
            .insert(own.clone(), RelayedRequest { sender: asker, id, target: action.to_owned(), server, feedback });
        own
    }

    /// Forwards a goal to the client that offers the action. Returns false if there is none.
    pub fn forward_goal(
        &mut self,
        peers: &ClientMap,
        asker: u64,
        id: Option<String>,
        action: &str,
        mut whole: Json,
    ) -> bool {
        let Some((server, _)) = self.actions.get(action).cloned() else { return false };
        let Some(peer) = peers.get(&server) else { return false };
        let feedback = whole.get("feedback").and_then(Json::as_bool).unwrap_or(false);
        whole["id"] = json!(self.record_goal(asker, id, action, server, feedback));
        peer.send(&whole);
        true
    }

    /// Forwards feedback on a goal to its sender, or its result if `status` is given.
    pub fn forward_progress(
        &mut self,
        peers: &ClientMap,
        server: u64,
        own: &str,
        status: Option<i64>,
        values: Json,
        good: bool,
    ) {
        let Some(waiting) = self.goals.get(own).filter(|w| w.server == server) else { return };
        if waiting.sender == SCRIPTS {
            self.reports.extend(waiting.id.clone().map(|id| GoalReport { id, status, values }));
        } else if let Some(asker) = peers.get(&waiting.sender)
            && (status.is_some() || waiting.feedback)
        {
            let op = if status.is_some() { "action_result" } else { "action_feedback" };
            let mut message = json!({ "op": op, "action": waiting.target, "values": values });
            if let Some(id) = &waiting.id {
                message["id"] = json!(id);
            }
            if let Some(status) = status {
                message["status"] = json!(status);
                message["result"] = json!(good);
            }
            asker.send(&message);
        }
        if status.is_some() {
            self.goals.remove(own);
        }
    }

    /// Forwards a request to cancel a goal to the client that executes it. If a script executes it, returns the id that
    /// the relay has assigned to the goal instead.
    pub fn forward_cancel(&mut self, peers: &ClientMap, asker: u64, id: &str) -> Option<String> {
        let (own, waiting) = self.goals.iter().find(|(_, w)| w.sender == asker && w.id.as_deref() == Some(id))?;
        if waiting.server == SCRIPTS {
            return Some(own.clone());
        }
        if let Some(server) = peers.get(&waiting.server) {
            server.send(&json!({ "op": "cancel_action_goal", "id": own, "action": waiting.target }));
        }
        None
    }

    /// Aborts all goals that `of` executes, and drops those that it has sent.
    fn end_goals(&mut self, peers: &ClientMap, of: u64, why: &Json) {
        self.goals.retain(|_, w| w.sender != of);
        let over: Vec<String> = self.goals.iter().filter(|(_, w)| w.server == of).map(|(own, _)| own.clone()).collect();
        for own in over {
            self.forward_progress(peers, of, &own, Some(ABORTED), why.clone(), false);
        }
    }

    /// Removes a client that has disconnected. Callers that wait for its answers receive an error; its own requests are
    /// dropped.
    pub fn remove_client(&mut self, peers: &ClientMap, peer: u64) {
        self.services.retain(|_, (server, _)| *server != peer);
        self.actions.retain(|_, (server, _)| *server != peer);
        let lost = json!("the client that offers it has disconnected");
        let calls = std::mem::take(&mut self.calls);
        for (own, waiting) in calls {
            if waiting.server == peer {
                self.send_answer(peers, &waiting, &lost, false);
            } else if waiting.sender != peer {
                self.calls.insert(own, waiting);
            }
        }
        self.end_goals(peers, peer, &lost);
        self.remove_unpublished_topics(peers);
    }

    /// Removes topics that no client publishes.
    pub fn remove_unpublished_topics(&mut self, peers: &ClientMap) {
        self.topics.retain(|topic, _| peers.values().any(|p| p.publishes.contains(topic)));
    }
}
