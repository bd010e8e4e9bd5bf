//! What clients offer each other: topics that they publish, services and actions that they serve. Calls go to whoever
//! serves, under a number of ours, and answers back to whoever asked.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};

use crate::peers::Peer;

/// Something that a client waits for.
struct Waiting {
    /// Who asked,
    asker: u64,
    /// under which id,
    id: Option<String>,
    /// what,
    of: String,
    /// and whom.
    server: u64,
}

/// What is offered, and what is under way.
#[derive(Default)]
pub struct Relay {
    /// Types of topics that clients publish, with the names of ROS 1.
    pub topics: BTreeMap<String, String>,
    /// Who serves a service, and its type.
    pub services: BTreeMap<String, (u64, String)>,
    /// Types of topics that scripts publish or listen to.
    pub of_scripts: BTreeMap<String, String>,
    /// Answers for scripts: the number of the call, what came, and whether it went well.
    pub answers: Vec<(String, Json, bool)>,
    actions: BTreeMap<String, (u64, String)>,
    calls: BTreeMap<String, Waiting>,
    goals: BTreeMap<String, Waiting>,
    count: u64,
}

/// The number that scripts have among those who offer and ask; clients count from 1.
pub const SCRIPTS: u64 = 0;

/// All clients, by number.
pub type Peers = BTreeMap<u64, Peer>;

/// The answer to a call.
pub fn answer(id: Option<&str>, service: &str, values: &Json, good: bool) -> Json {
    let mut out = json!({ "op": "service_response", "service": service, "values": values, "result": good });
    if let Some(id) = id {
        out["id"] = json!(id);
    }
    out
}

impl Relay {
    fn number(&mut self, what: &str) -> String {
        self.count += 1;
        format!("{what}:{}", self.count)
    }

    /// Offers an action, or takes it back.
    pub fn offer_action(&mut self, action: String, kind: Option<String>, peer: u64) {
        match kind {
            Some(kind) => drop(self.actions.insert(action, (peer, kind))),
            None => self.actions.retain(|a, (p, _)| *a != action || *p != peer),
        }
    }

    /// Passes a call on to the client that serves it; false: none does.
    pub fn call(&mut self, peers: &Peers, asker: u64, id: Option<String>, service: &str, args: &Json) -> bool {
        let Some((server, _)) = self.services.get(service).cloned() else { return false };
        let Some(peer) = peers.get(&server) else { return false };
        let own = self.number("call");
        peer.send(&json!({ "op": "call_service", "id": own, "service": service, "args": args }));
        self.calls.insert(own, Waiting { asker, id, of: service.to_owned(), server });
        true
    }

    /// Passes an answer back.
    pub fn answered(&mut self, peers: &Peers, server: u64, id: &str, values: &Json, good: bool) {
        if self.calls.get(id).is_some_and(|w| w.server == server)
            && let Some(waiting) = self.calls.remove(id)
        {
            self.give(peers, &waiting, values, good);
        }
    }

    /// An answer for whoever asked.
    fn give(&mut self, peers: &Peers, to: &Waiting, values: &Json, good: bool) {
        if to.asker == SCRIPTS {
            self.answers.extend(to.id.clone().map(|id| (id, values.clone(), good)));
        } else if let Some(asker) = peers.get(&to.asker) {
            asker.send(&answer(to.id.as_deref(), &to.of, values, good));
        }
    }

    /// The scripts have ended, and what they offered with them.
    pub fn scripts_gone(&mut self) {
        self.services.retain(|_, (server, _)| *server != SCRIPTS);
        self.of_scripts.clear();
        self.answers.clear();
        self.calls.retain(|_, w| w.asker != SCRIPTS);
    }

    /// Passes a goal on; false: nobody takes it.
    pub fn goal(&mut self, peers: &Peers, asker: u64, id: Option<String>, action: &str, mut whole: Json) -> bool {
        let Some((server, _)) = self.actions.get(action).cloned() else { return false };
        let Some(peer) = peers.get(&server) else { return false };
        let own = self.number("goal");
        whole["id"] = json!(own);
        peer.send(&whole);
        self.goals.insert(own, Waiting { asker, id, of: action.to_owned(), server });
        true
    }

    /// Passes feedback or the result of a goal back.
    pub fn progress(&mut self, peers: &Peers, server: u64, id: &str, mut whole: Json, last: bool) {
        let Some(waiting) = self.goals.get(id).filter(|w| w.server == server) else { return };
        whole["id"] = json!(waiting.id);
        if let Some(asker) = peers.get(&waiting.asker) {
            asker.send(&whole);
        }
        if last {
            self.goals.remove(id);
        }
    }

    /// Passes on that a goal is taken back.
    pub fn cancel(&mut self, peers: &Peers, asker: u64, id: &str, mut whole: Json) {
        let found = self.goals.iter().find(|(_, w)| w.asker == asker && w.id.as_deref() == Some(id));
        let Some((own, waiting)) = found else { return };
        whole["id"] = json!(own);
        if let Some(server) = peers.get(&waiting.server) {
            server.send(&whole);
        }
    }

    /// A client has disconnected: whoever waits for it gets an error, and what it waited for is dropped.
    pub fn gone(&mut self, peers: &Peers, peer: u64) {
        self.services.retain(|_, (server, _)| *server != peer);
        self.actions.retain(|_, (server, _)| *server != peer);
        let lost = json!("whoever serves it has gone");
        let calls = std::mem::take(&mut self.calls);
        for (own, waiting) in calls {
            if waiting.server == peer {
                self.give(peers, &waiting, &lost, false);
            } else if waiting.asker != peer {
                self.calls.insert(own, waiting);
            }
        }
        let mut over = Vec::new();
        self.goals.retain(|_, w| {
            if w.server == peer {
                // 6: aborted, as `action_msgs/GoalStatus` counts.
                over.push((
                    w.asker,
                    json!({ "op": "action_result", "id": w.id, "action": w.of, "values": lost, "status": 6, "result": false }),
                ));
            }
            w.server != peer && w.asker != peer
        });
        for (asker, message) in over {
            if let Some(asker) = peers.get(&asker) {
                asker.send(&message);
            }
        }
        self.forget(peers);
    }

    /// Topics that no client publishes any more are forgotten.
    pub fn forget(&mut self, peers: &Peers) {
        self.topics.retain(|topic, _| peers.values().any(|p| p.publishes.contains(topic)));
    }
}
