//! Commands by which the service passes data of actions to scripts, so that the input log contains it; and events by
//! which scripts pass data to the service.

use tatu_plugin_api::safe::{Event, Fail, Offer, Param};

use crate::{
    RosPlugin as Plugin,
    goals::{self, CANCEL_EVENT, GOAL_EVENT, PROGRESS_EVENT},
    scripts::{RosCommand, parse},
};

// Names of commands that only the service calls.
/// Informs scripts of the services and actions that clients offer.
pub(crate) const SET_OFFERS: &str = "rosbridge.offers";
/// Passes a goal of a client to the script that offers the action.
pub(crate) const SEND_GOAL: &str = "rosbridge.goal";
/// Passes a client's request to cancel a goal to the script that executes the goal.
pub(crate) const CANCEL_GOAL: &str = "rosbridge.cancel";
/// Passes a client's feedback on a goal, or its result, to the script that sent the goal.
pub(crate) const REPORT_GOAL: &str = "rosbridge.report";

pub(crate) fn offer(offer: &mut Offer<Plugin>) {
    let json = |text: &str| Param::string("json").text(text);
    let number = || Param::string("number").text("number of the goal at the service");
    offer.command(
        RosCommand::new(SET_OFFERS, |c| {
            let offered = serde_json::from_slice(c.bytes(0)?);
            let offered = offered
                .map_err(|e| Fail::argument(format!("argument 1: the services and actions are not valid JSON: {e}")))?;
            c.instance().state()?.offered = offered;
            Ok(())
        })
        .param(json("the names of `services` and `actions`, as JSON"))
        .text("Informs scripts about what clients offer.")
        .example(
            "rosbridge.offers('{\"services\": [\"/gong\"], \"actions\": []}')\n\
             assert(simROS2.waitForService(simROS2.createClient('/gong', 'std_srvs/srv/SetBool')))",
        ),
    );
    offer.command(
        RosCommand::new(SEND_GOAL, |c| {
            let (action, number, json) = (c.text(0)?, c.text(1)?, parse(c, 2)?);
            let accepted = c.instance().receive_client_goal(c, &action, &number, &json)?;
            c.ret(accepted);
            Ok(())
        })
        .param(Param::string("action"))
        .param(number())
        .param(json("the goal, as JSON"))
        .returns(Param::bool("accepted"))
        .text("Passes a client's goal to the script that offers the action.")
        .example("assert(not pcall(rosbridge.goal, '/nowhere', 'goal:1', '{}'))"),
    );
    offer.command(
        RosCommand::new(CANCEL_GOAL, |c| match c.instance().client_goal_id(&c.text(0)?)? {
            Some(id) => c.instance().cancel(c, &id).map(drop),
            None => Ok(()),
        })
        .param(number())
        .text("Informs the script that executes a client's goal that the client wants to cancel it.")
        .example("rosbridge.cancel('goal:1')"),
    );
    offer.command(
        RosCommand::new(REPORT_GOAL, |c| {
            let (id, status, json) = (c.text(0)?, c.i64(1)?, parse(c, 2)?);
            let ended = (status >= 0).then(|| goals::code(status));
            c.instance().report(c, &id, ended, &json)
        })
        .param(Param::string("goal"))
        .param(Param::int("status").text("as in action_msgs/GoalStatus; below 0 for feedback"))
        .param(json("the feedback or the result, as JSON"))
        .text("Passes a client's feedback or result to the script that sent the goal.")
        .example("rosbridge.report(string.rep('0', 32), 4, '{}')"),
    );
    offer.event(
        Event::new(GOAL_EVENT)
            .text("A script sends a goal to a client.")
            .field(Param::string("id").text("of the goal"))
            .field(Param::string("action").text("its name"))
            .field(Param::string("type").text("of the action, such as `example_interfaces/Fibonacci`"))
            .field(Param::string("json").text("the goal")),
    );
    offer.event(
        Event::new(CANCEL_EVENT)
            .text("A script requests that a client cancel a goal.")
            .field(Param::string("id").text("of the goal")),
    );
    offer.event(
        Event::new(PROGRESS_EVENT)
            .text("A script reports on a client's goal.")
            .field(Param::string("id").text("the service's number of the goal"))
            .field(Param::string("json").text("the feedback or the result"))
            .field(Param::int("status").text("as in action_msgs/GoalStatus; below 0 for feedback")),
    );
}
