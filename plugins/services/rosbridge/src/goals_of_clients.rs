//! Handles goals that clients send or execute, on the side of the service; `goals_of_scripts` handles goals on the side
//! of scripts.

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Called, Fail, Result, Turn, Value},
};

use crate::{
    between,
    node::Offered,
    relay::{GoalsOfScripts, Report, SCRIPTS, UNKNOWN},
    service::State,
};

impl State {
    /// Registers a client as the server of an action. Fails if a script offers the action.
    pub(crate) fn offer_action(&mut self, number: u64, action: String, kind: String) -> Result {
        if self.relay.actions.get(&action).is_some_and(|(server, _)| *server == SCRIPTS) {
            return Err(Fail::unsupported(format!("a script already offers the action {action}")));
        }
        self.relay.actions.insert(action, (number, kind));
        Ok(())
    }

    /// Forwards a goal of a client to the script or client that offers the action.
    pub(crate) fn goal(
        &mut self,
        turn: &Turn<'_>,
        number: u64,
        id: Option<String>,
        action: &str,
        whole: Json,
    ) -> Result {
        let server = self.relay.actions.get(action).map(|(server, _)| *server);
        if server != Some(SCRIPTS) {
            return match self.relay.goal(&self.peers, number, id, action, whole) {
                true => Ok(()),
                false => Err(Fail::missing(format!("no script and no client offers the action {action}"))),
            };
        }
        let feedback = whole.get("feedback").and_then(Json::as_bool).unwrap_or(false);
        let args = whole.get("args").cloned().unwrap_or_else(|| json!({}));
        let own = self.relay.note_goal(number, id, action, SCRIPTS, feedback);
        let asked = [Value::text(action), Value::text(&own), Value::text(args.to_string())];
        let why = match turn.call(between::ASK_GOAL, &asked, 0) {
            Ok(Called::Done(answer)) if answer.first() == Some(&Value::Bool(true)) => return Ok(()),
            Ok(_) => "the goal was rejected".to_owned(),
            Err(fail) => fail.text().to_owned(),
        };
        self.relay.progress(&self.peers, SCRIPTS, &own, Some(UNKNOWN), json!(why), false);
        Ok(())
    }

    /// Forwards a client's request to cancel a goal to the server of the goal.
    pub(crate) fn cancel(&mut self, turn: &Turn<'_>, number: u64, id: &str) -> Result {
        match self.relay.cancel(&self.peers, number, id) {
            Some(own) => turn.call(between::TAKE_BACK, &[Value::text(own)], 0).map(drop),
            None => Ok(()),
        }
    }

    /// Forwards feedback of a script on a client's goal, or its result if `status` is given.
    pub(crate) fn reported(&mut self, own: &str, status: Option<i64>, values: Json) {
        self.relay.progress(&self.peers, SCRIPTS, own, status, values, true);
    }

    /// Informs scripts of the services and actions that clients offer, if these have changed.
    pub(crate) fn tell_offers(&mut self, turn: &Turn<'_>) -> Result {
        let names = |all: &std::collections::BTreeMap<String, (u64, String)>| {
            all.iter().filter(|(_, (server, _))| *server != SCRIPTS).map(|(name, _)| name.clone()).collect()
        };
        let now = Offered { services: names(&self.relay.services), actions: names(&self.relay.actions) };
        if self.known.as_ref() != Some(&now) {
            let text = json!({ "services": now.services, "actions": now.actions }).to_string();
            turn.call(between::OFFERS, &[Value::text(text)], 0)?;
            self.known = Some(now);
        }
        Ok(())
    }

    /// Forwards goals of scripts to clients, and feedback and results of clients to scripts.
    pub(crate) fn goals_of_scripts(&mut self, turn: &Turn<'_>) {
        let GoalsOfScripts { given, taken_back } = std::mem::take(&mut self.of_scripts);
        for (id, action, message) in given {
            if !self.relay.goal(&self.peers, SCRIPTS, Some(id.clone()), &action, message) {
                // The client that offered the action has disconnected in the meantime.
                self.relay.reports.push(Report { id, status: Some(UNKNOWN), values: json!({}) });
            }
        }
        for id in taken_back {
            self.relay.cancel(&self.peers, SCRIPTS, &id);
        }
        for Report { id, status, values } in std::mem::take(&mut self.relay.reports) {
            // Values that are not a message, such as the text of an error, are replaced by a message without fields.
            let values = if values.is_object() { values } else { json!({}) };
            let report = [Value::text(&id), Value::Int(status.unwrap_or(-1)), Value::text(values.to_string())];
            if let Err(fail) = turn.call(between::REPORT, &report, 0) {
                turn.host().log(
                    TATU_LOG_WARNING,
                    &format!("rosbridge: a report on the goal {id} could not be passed to its script: {}", fail.text()),
                );
            }
        }
    }
}
