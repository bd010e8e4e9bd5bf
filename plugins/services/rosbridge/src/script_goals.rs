//! Handles goals that scripts send or execute.

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Result, Value, keys};

use crate::{
    RosCall, convert,
    goals::{
        self, ABORTED, ACCEPT_AND_DEFER, ACCEPT_AND_EXECUTE, ACCEPT_CANCEL, CANCEL_EVENT, GOAL_EVENT, GoalSender,
        GoalStage, PROGRESS_EVENT, PendingGoal,
    },
    node::{EndpointRole, RosNode, ScriptEndpoint},
};

// Indices of the callbacks of an action server.
const HANDLE_GOAL: usize = 0;
const HANDLE_CANCEL: usize = 1;
const HANDLE_ACCEPTED: usize = 2;
// Indices of the callbacks of an action client.
const GOAL_RESPONSE: usize = 0;
const FEEDBACK: usize = 1;
const RESULT: usize = 2;

impl RosNode {
    /// Stores a new goal, and returns its id.
    fn add_goal(&self, server: Option<i64>, asker: GoalSender, json: &Json) -> Result<String> {
        let mut all = self.state()?;
        all.given += 1;
        let (number, id) = (all.given, goals::goal_id(all.given));
        all.goals
            .insert(id.clone(), PendingGoal { number, server, asker, stage: GoalStage::Executing, json: json.clone() });
        Ok(id)
    }

    /// Returns a goal of an action server.
    pub(crate) fn server_goal(&self, server: i64, id: &str) -> Result<PendingGoal> {
        let found = self.state()?.goals.get(id).filter(|g| g.server == Some(server)).cloned();
        found.ok_or_else(|| {
            Fail::missing(format!(
                "action server {server} has no goal '{id}': the goal was never accepted, or it has ended"
            ))
        })
    }
    /// Sets the stage of a goal, if it still exists.
    pub(crate) fn set_stage(&self, id: &str, stage: GoalStage) -> Result {
        if let Some(goal) = self.state()?.goals.get_mut(id) {
            goal.stage = stage;
        }
        Ok(())
    }

    /// Calls the goal callback of a script's action server. Returns the id of the goal, or `None` if the server rejects
    /// it.
    fn ask_server(
        &self,
        c: &mut RosCall<'_>,
        server: &(i64, ScriptEndpoint),
        asker: GoalSender,
        json: &Json,
    ) -> Result<Option<String>> {
        let (handle, of) = server;
        let given = of.to_script_form(convert::value(json, &format!("{}Goal", of.kind), of.ros())?);
        let id = self.add_goal(Some(*handle), asker, json)?;
        let asked = of.call(c, HANDLE_GOAL, &[Value::text(&id), given]);
        let answer = match asked.map(|all| all.into_iter().next()) {
            Ok(Some(Value::Int(answer))) => answer,
            // A callback that returns nothing accepts the goal.
            Ok(None | Some(Value::Nil)) => ACCEPT_AND_EXECUTE,
            other => {
                self.state()?.goals.remove(&id);
                let text = format!(
                    "the goal callback of {} returned an invalid value: expected simROS2.goal_response.reject, \
                     accept_and_execute or accept_and_defer",
                    of.name
                );
                return other.and(Err(Fail::argument(text)));
            }
        };
        match answer {
            ACCEPT_AND_EXECUTE => {}
            ACCEPT_AND_DEFER => self.set_stage(&id, GoalStage::Deferred)?,
            _ => {
                self.state()?.goals.remove(&id);
                return Ok(None);
            }
        }
        Ok(Some(id))
    }
    /// Calls the callback of a script's action server for a goal that it has accepted.
    fn call_accepted(&self, c: &mut RosCall<'_>, of: &ScriptEndpoint, id: &str, json: &Json) -> Result {
        let given = of.to_script_form(convert::value(json, &format!("{}Goal", of.kind), of.ros())?);
        of.call(c, HANDLE_ACCEPTED, &[Value::text(id), given]).map(drop)
    }

    /// Sends a goal of a script: directly if a script offers the action, or through the service if a client offers it.
    /// Returns false if the action is not offered.
    pub(crate) fn send_goal(
        &self,
        c: &mut RosCall<'_>,
        handle: i64,
        client: &ScriptEndpoint,
        json: &Json,
    ) -> Result<bool> {
        let asker = GoalSender::Script(handle);
        if let Some(server) =
            self.live_endpoints(&c.world(), EndpointRole::ActionServer, &client.name)?.into_iter().next()
        {
            let id = self.ask_server(c, &server, asker, json)?;
            let answer = [Value::text(id.as_deref().unwrap_or("")), Value::Bool(id.is_some())];
            // The client is notified before the goal is started, because the goal may end immediately, and its result
            // must follow its acceptance.
            client.call(c, GOAL_RESPONSE, &answer)?;
            if let Some(id) = id {
                self.call_accepted(c, &server.1, &id, json)?;
            }
            return Ok(true);
        }
        if !self.state()?.offered.actions.contains(&client.name) {
            return Ok(false);
        }
        let id = self.add_goal(None, asker, json)?;
        let payload = keys([
            ("id", Value::text(&id)),
            ("action", Value::text(&client.name)),
            ("type", Value::text(&client.kind)),
            ("json", Value::text(json.to_string())),
        ]);
        c.world().publish_value(GOAL_EVENT, &payload)?;
        // In the rosbridge protocol, a client cannot reject a goal, so the goal is reported as accepted.
        client.call(c, GOAL_RESPONSE, &[Value::text(&id), Value::Bool(true)])?;
        Ok(true)
    }

    /// Passes a goal of a client to the script that offers the action. Returns whether the goal was accepted.
    pub(crate) fn receive_client_goal(
        &self,
        c: &mut RosCall<'_>,
        action: &str,
        number: &str,
        json: &Json,
    ) -> Result<bool> {
        let server = self.live_endpoints(&c.world(), EndpointRole::ActionServer, action)?.into_iter().next();
        let server = server.ok_or_else(|| Fail::missing(format!("no script offers the action {action}")))?;
        let id = self.ask_server(c, &server, GoalSender::Outside(number.to_owned()), json)?;
        if let Some(id) = &id {
            self.call_accepted(c, &server.1, id, json)?;
        }
        Ok(id.is_some())
    }

    /// Passes the request of a goal's sender to cancel the goal to its server. Returns false if the goal does not
    /// exist.
    pub(crate) fn cancel(&self, c: &mut RosCall<'_>, id: &str) -> Result<bool> {
        let goal = self.state()?.goals.get(id).cloned();
        let Some(goal) = goal else { return Ok(false) };
        let Some(handle) = goal.server else {
            c.world().publish_value(CANCEL_EVENT, &keys([("id", Value::text(id))]))?;
            return Ok(true);
        };
        let server = self.endpoint(handle, EndpointRole::ActionServer)?;
        let given = server.to_script_form(convert::value(&goal.json, &format!("{}Goal", server.kind), server.ros())?);
        let answer = server.call(c, HANDLE_CANCEL, &[Value::text(id), given])?;
        if answer.first() == Some(&Value::Int(ACCEPT_CANCEL)) {
            self.set_stage(id, GoalStage::Canceling)?;
        }
        Ok(true)
    }
    /// Returns the id of the last goal of a script's action client that has no result yet.
    pub(crate) fn last_goal(&self, client: i64) -> Result<Option<String>> {
        let all = self.state()?;
        let own = all.goals.iter().filter(|(_, g)| matches!(g.asker, GoalSender::Script(handle) if handle == client));
        Ok(own.max_by_key(|(_, g)| g.number).map(|(id, _)| id.clone()))
    }
    /// Returns the id of the goal that a client has sent, given the id that the service has assigned to it.
    pub(crate) fn client_goal_id(&self, number: &str) -> Result<Option<String>> {
        let all = self.state()?;
        let found = all.goals.iter().find(|(_, g)| matches!(&g.asker, GoalSender::Outside(n) if n == number));
        Ok(found.map(|(id, _)| id.clone()))
    }

    /// Sends feedback on a goal to its sender, or its result if `ended` is a result code. A goal with a result is
    /// removed.
    pub(crate) fn report(&self, c: &mut RosCall<'_>, id: &str, ended: Option<i64>, json: &Json) -> Result {
        let goal = self.state()?.goals.get(id).cloned();
        let Some(goal) = goal else { return Ok(()) };
        if ended.is_some() {
            self.state()?.goals.remove(id);
        }
        match goal.asker {
            GoalSender::Outside(number) => c.world().publish_value(
                PROGRESS_EVENT,
                &keys([
                    ("id", Value::text(number)),
                    ("json", Value::text(json.to_string())),
                    // A negative status marks feedback.
                    ("status", Value::Int(ended.map_or(-1, goals::status))),
                ]),
            ),
            GoalSender::Script(handle) => {
                // The action client may have been closed, or its script may have been removed.
                let Ok(client) = self.endpoint(handle, EndpointRole::ActionClient) else { return Ok(()) };
                if !self
                    .live_endpoints(&c.world(), EndpointRole::ActionClient, &client.name)?
                    .iter()
                    .any(|(h, _)| *h == handle)
                {
                    return Ok(());
                }
                let part = if ended.is_some() { "Result" } else { "Feedback" };
                let message =
                    client.to_script_form(convert::value(json, &format!("{}{part}", client.kind), client.ros())?);
                match ended {
                    None => client.call(c, FEEDBACK, &[Value::text(id), message]),
                    Some(code) => client.call(c, RESULT, &[Value::text(id), Value::Int(code), message]),
                }
                .map(drop)
            }
        }
    }

    /// Aborts all unfinished goals of an action server.
    pub(crate) fn abort_all(&self, c: &mut RosCall<'_>, server: i64) -> Result {
        let left: Vec<String> = {
            let all = self.state()?;
            all.goals.iter().filter(|(_, g)| g.server == Some(server)).map(|(id, _)| id.clone()).collect()
        };
        for id in left {
            self.report(c, &id, Some(ABORTED), &json!({}))?;
        }
        Ok(())
    }
}
