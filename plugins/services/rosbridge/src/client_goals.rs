//! Handles goals that clients send or execute, on the side of the service; `exchange_script_goals` handles goals on the
//! side of scripts.

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Called, Fail, Result, Turn, Value},
};

use crate::{
    node::ClientOffers,
    relay::{GoalReport, SCRIPTS, ScriptGoals, UNKNOWN},
    service::BridgeState,
    service_commands,
};

impl BridgeState {
    /// Registers a client as the server of an action. Fails if a script offers the action.
    pub(crate) fn offer_action(&mut self, number: u64, action: String, kind: String) -> Result {
        if self.relay.actions.get(&action).is_some_and(|(server, _)| *server == SCRIPTS) {
            return Err(Fail::unsupported(format!("a script already offers the action {action}")));
        }
        self.relay.actions.insert(action, (number, kind));
        Ok(())
    }

    /// Forwards a goal of a client to the script or client that offers the action.
    pub(crate) fn start_goal(
        &mut self,
        turn: &Turn<'_>,
        number: u64,
        id: Option<String>,
        action: &str,
        whole: Json,
    ) -> Result {
        let server = self.relay.actions.get(action).map(|(server, _)| *server);
        if server != Some(SCRIPTS) {
            return match self.relay.forward_goal(&self.peers, number, id, action, whole) {
                true => Ok(()),
                false => Err(Fail::missing(format!("no script and no client offers the action {action}"))),
            };
        }
        let feedback = whole.get("feedback").and_then(Json::as_bool).unwrap_or(false);
        let args = whole.get("args").cloned().unwrap_or_else(|| json!({}));
        let own = self.relay.record_goal(number, id, action, SCRIPTS, feedback);
        let asked = [Value::text(action), Value::text(&own), Value::text(args.to_string())];
        let why = match turn.call(service_commands::SEND_GOAL, &asked, 0) {
            Ok(Called::Done(answer)) if answer.first() == Some(&Value::Bool(true)) => return Ok(()),
            Ok(_) => "the goal was rejected".to_owned(),
            Err(fail) => fail.text().to_owned(),
        };
        self.relay.forward_progress(&self.peers, SCRIPTS, &own, Some(UNKNOWN), json!(why), false);
        Ok(())
    }

    /// Forwards a client's request to cancel a goal to the server of the goal.
    pub(crate) fn cancel_goal(&mut self, turn: &Turn<'_>, number: u64, id: &str) -> Result {
        match self.relay.forward_cancel(&self.peers, number, id) {
            Some(own) => turn.call(service_commands::CANCEL_GOAL, &[Value::text(own)], 0).map(drop),
            None => Ok(()),
        }
    }

    /// Forwards feedback of a script on a client's goal, or its result if `status` is given.
    pub(crate) fn forward_report(&mut self, own: &str, status: Option<i64>, values: Json) {
        self.relay.forward_progress(&self.peers, SCRIPTS, own, status, values, true);
    }

    /// Informs scripts of the services and actions that clients offer, if these have changed.
    pub(crate) fn send_offers(&mut self, turn: &Turn<'_>) -> Result {
        let names = |all: &std::collections::BTreeMap<String, (u64, String)>| {
            all.iter().filter(|(_, (server, _))| *server != SCRIPTS).map(|(name, _)| name.clone()).collect()
        };
        let now = ClientOffers { services: names(&self.relay.services), actions: names(&self.relay.actions) };
        if self.sent_offers.as_ref() != Some(&now) {
            let text = json!({ "services": now.services, "actions": now.actions }).to_string();
            turn.call(service_commands::SET_OFFERS, &[Value::text(text)], 0)?;
            self.sent_offers = Some(now);
        }
        Ok(())
    }

    /// Forwards goals of scripts to clients, and feedback and results of clients to scripts.
    pub(crate) fn exchange_script_goals(&mut self, turn: &Turn<'_>) {
        let ScriptGoals { goals: given, cancelled: taken_back } = std::mem::take(&mut self.script_goals);
        for (id, action, message) in given {
            if !self.relay.forward_goal(&self.peers, SCRIPTS, Some(id.clone()), &action, message) {
                // The client that offered the action has disconnected in the meantime.
                self.relay.reports.push(GoalReport { id, status: Some(UNKNOWN), values: json!({}) });
            }
        }
        for id in taken_back {
            self.relay.forward_cancel(&self.peers, SCRIPTS, &id);
        }
        for GoalReport { id, status, values } in std::mem::take(&mut self.relay.reports) {
            // Values that are not a message, such as the text of an error, are replaced by a message without fields.
            let values = if values.is_object() { values } else { json!({}) };
            let report = [Value::text(&id), Value::Int(status.unwrap_or(-1)), Value::text(values.to_string())];
            if let Err(fail) = turn.call(service_commands::REPORT_GOAL, &report, 0) {
                turn.host().log(
                    TATU_LOG_WARNING,
                    &format!("rosbridge: a report on the goal {id} could not be passed to its script: {}", fail.text()),
                );
            }
        }
    }
}
