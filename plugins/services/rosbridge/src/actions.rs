//! Commands for actions of ROS 2: long-running goals with feedback and a result.

use serde_json::Value as Json;
use tatu_plugin_api::safe::{Constant, Fail, IntoResult, Offer, Outcome, Param, Result, Value};

use crate::{
    RosCall, RosPlugin as Plugin, convert,
    goals::{self, GoalStage},
    node::{EndpointRole, ScriptCallback, ScriptEndpoint, WaitingThread},
    scripts::{RosCommand, add_command, handle, open_with, time},
    types::RosVersion,
};

/// Simulation time for which sending a goal waits for a server of the action, s.
const SERVER_TIMEOUT_S: f64 = 5.0;

/// Returns the beginning of an example: a server and a client of the action `name`, and a goal that has been sent.
fn example_start(name: &str) -> String {
    format!(
        "simROS2 = require 'simROS2'\n\
         function take(id, goal) current = id return simROS2.goal_response.accept_and_execute end\n\
         function stop(id, goal) return simROS2.cancel_response.accept end\n\
         function told(id, feedback) heard = feedback.sequence end\n\
         function over(id, code, result) ended, got = code, result.sequence end\n\
         local kind = 'example_interfaces/action/Fibonacci'\n\
         local server = simROS2.createActionServer('/{name}', kind, take, stop)\n\
         local client = simROS2.createActionClient('/{name}', kind, '', 'told', 'over')\n\
         simROS2.sendGoal(client, {{order = 3}})\n"
    )
}

/// Returns an example that consists of the code of [`example_start`] and `text`.
fn example(name: &str, text: &str) -> String {
    example_start(name) + text
}

/// Opens an action client or server with the callbacks in arguments 2 to 4.
fn open(c: &mut RosCall<'_>, role: EndpointRole) -> Result {
    let callbacks = (2..5).map(|i| if c.has(i) { ScriptCallback::read(c, i) } else { Ok(ScriptCallback::default()) });
    let callbacks = callbacks.collect::<Result<Vec<_>>>()?;
    open_with(c, role, RosVersion::Two, callbacks)
}

/// Sends a goal. If no server offers the action, a calling thread waits for one, and any other caller receives an
/// error.
fn send_goal(c: &mut RosCall<'_>) -> Result<Outcome> {
    let nobody = |client: &ScriptEndpoint, how: &str| {
        Fail::missing(format!("no script and no client of `rosbridge` offers the action {}{how}", client.name))
    };
    if c.resumed() != 0 {
        let number = c.resumed();
        let wait = c.instance().state()?.waits.get(&number).cloned();
        let Some(wait) = wait else {
            return Err(Fail::new("the goal cannot be sent, because the record of the waiting call was lost"));
        };
        let client = c.instance().endpoint(wait.handle, EndpointRole::ActionClient);
        let late = time(c, "scene.time")? >= wait.until;
        let done = client.and_then(|client| match c.instance().send_goal(c, wait.handle, &client, &wait.json) {
            Ok(false) if late => Err(nobody(&client, &format!(": waited {SERVER_TIMEOUT_S} s"))),
            other => other,
        });
        if matches!(done, Ok(false)) {
            return c.wait_poll(number);
        }
        c.instance().state()?.waits.remove(&number);
        c.ret(done?);
        return Ok(Outcome::Done);
    }
    let handle = c.i64(0)?;
    let client = c.instance().endpoint(handle, EndpointRole::ActionClient)?;
    let given = c.arg(1).to_value()?;
    let json = convert::node(&given, &format!("{}Goal", client.kind), client.ros())?.json();
    if c.instance().send_goal(c, handle, &client, &json)? {
        c.ret(true);
        return Ok(Outcome::Done);
    }
    if !c.can_wait() {
        return Err(
            nobody(&client, ", and the calling script cannot wait for one").help("send the goal in a thread, or later")
        );
    }
    let wait = WaitingThread { handle, json, until: time(c, "scene.time")? + SERVER_TIMEOUT_S };
    let number = c.instance().register_wait(wait)?;
    c.wait_poll(number)
}

/// Waits until a service is offered, at most for the time in argument 1. Returns whether the service is offered.
fn wait_for_service(c: &mut RosCall<'_>) -> Result<Outcome> {
    let now = time(c, "scene.time")?;
    let (number, wait) = match c.resumed() {
        0 => {
            let seconds = if c.has(1) { c.f64(1)? } else { 0.0 };
            (0, WaitingThread { handle: c.i64(0)?, json: Json::Null, until: now + seconds })
        }
        number => {
            let wait = c.instance().state()?.waits.get(&number).cloned();
            (
                number,
                wait.ok_or_else(|| {
                    Fail::new(
                        "the wait for the service cannot continue, because the record of the waiting call was lost",
                    )
                })?,
            )
        }
    };
    let client = c.instance().endpoint(wait.handle, EndpointRole::Client)?;
    let there = c.instance().has_service(&c.world(), &client.name)?;
    if there || now >= wait.until || !c.can_wait() {
        c.instance().state()?.waits.remove(&number);
        c.ret(there);
        return Ok(Outcome::Done);
    }
    let number = if number == 0 { c.instance().register_wait(wait)? } else { number };
    c.wait_poll(number)
}

/// Returns the action server in argument 0, and the id in argument 1 with the goal that it identifies.
fn find_server_goal(c: &RosCall<'_>) -> Result<(ScriptEndpoint, String, goals::PendingGoal)> {
    let (handle, id) = (c.i64(0)?, c.text(1)?);
    let server = c.instance().endpoint(handle, EndpointRole::ActionServer)?;
    let goal = c.instance().server_goal(handle, &id)?;
    Ok((server, id, goal))
}

/// Sends argument 2 to the sender of a goal: as its result if `ended` is a result code, otherwise as feedback.
fn report(c: &mut RosCall<'_>, ended: Option<i64>) -> Result {
    let (server, id, goal) = find_server_goal(c)?;
    let refused = match (goal.stage, ended) {
        (GoalStage::Deferred, _) => {
            "the goal was deferred, so it must be started with simROS2.actionServerExecute first"
        }
        (GoalStage::Executing, Some(goals::CANCELED)) => {
            "the sender has not requested a cancellation; end the goal as aborted instead"
        }
        _ => "",
    };
    if !refused.is_empty() {
        return Err(Fail::unsupported(format!("goal '{id}' of {}: {refused}", server.name)));
    }
    let part = if ended.is_some() { "Result" } else { "Feedback" };
    let json = convert::node(&c.arg(2).to_value()?, &format!("{}{part}", server.kind), server.ros())?.json();
    c.instance().report(c, &id, ended, &json)
}

pub(crate) fn offer(offer: &mut Offer<Plugin>) {
    let named = |pairs: &[(&str, i64)]| {
        Value::Map(pairs.iter().map(|(name, value)| (Value::text(*name), Value::Int(*value))).collect())
    };
    for (name, value) in [
        (
            "action_result_code",
            named(&[
                ("succeeded", goals::SUCCEEDED),
                ("aborted", goals::ABORTED),
                ("canceled", goals::CANCELED),
                ("unknown", goals::UNKNOWN),
            ]),
        ),
        (
            "goal_response",
            named(&[
                ("reject", goals::REJECT_GOAL),
                ("accept_and_execute", goals::ACCEPT_AND_EXECUTE),
                ("accept_and_defer", goals::ACCEPT_AND_DEFER),
            ]),
        ),
        ("cancel_response", named(&[("reject", goals::REJECT_CANCEL), ("accept", goals::ACCEPT_CANCEL)])),
        ("clock_type", named(&[("ros", 4872), ("system", 4873), ("steady", 4874)])),
        ("qos_history_policy", named(&[("system_default", 12300), ("keep_last", 12301), ("keep_all", 12302)])),
        ("qos_reliability_policy", named(&[("system_default", 12400), ("reliable", 12401), ("best_effort", 12402)])),
        ("qos_durability_policy", named(&[("system_default", 12500), ("transient_local", 12501), ("volatile", 12502)])),
        (
            "qos_liveliness_policy",
            named(&[("system_default", 12600), ("automatic", 12601), ("manual_by_topic", 12602)]),
        ),
    ] {
        offer.constant(Constant::new(format!("simROS2.{name}"), value));
    }
    clients(offer);
    servers(offer);
    goals_of_servers(offer);
}

/// Returns the optional parameter for a callback.
fn callback(name: &str, text: &str) -> Param {
    Param::any(name).optional().text(format!("a function of the script or its name: {text}"))
}

/// Adds a command that exists only for ROS 2, on a separate page of the reference.
fn add_action<T: IntoResult + 'static>(
    offer: &mut Offer<Plugin>,
    name: &str,
    f: impl Fn(&mut RosCall<'_>) -> Result<T> + Send + Sync + 'static,
    finish: impl Fn(RosCommand) -> RosCommand,
) {
    offer.command(finish(RosCommand::new(format!("simROS2.{name}"), f)).subject("actions"));
}

/// Adds the commands of action clients.
fn clients(offer: &mut Offer<Plugin>) {
    let kind = || Param::string("type").text("example_interfaces/action/Fibonacci");
    add_action(
        offer,
        "createActionClient",
        |c| open(c, EndpointRole::ActionClient),
        |cmd| {
            cmd.param(Param::string("action"))
                .param(kind())
                .param(callback("goalResponse", "(goal id, whether it is accepted)"))
                .param(callback("feedback", "(goal id, table)"))
                .param(callback("result", "(goal id, simROS2.action_result_code..., table)"))
                .returns(handle())
                .text("Creates a client for an action that a script of this world or a client of `rosbridge` offers.")
                .example(example(
                    "client",
                    "simROS2.actionServerActionSucceed(server, current, {sequence = {0, 1, 1, 2}})\n\
                     assert(ended == simROS2.action_result_code.succeeded and got[4] == 2)",
                ))
        },
    );
    add_action(offer, "sendGoal", send_goal, |cmd| {
        cmd.param(handle())
            .param(Param::any("goal").optional().text("a table with the fields of the goal"))
            .returns(Param::bool("answered"))
            .text(
                "Sends a goal. Returns true once it is answered, even if it is rejected: goalResponse reports which. A \
                 thread waits up to 5 s of simulation time for the action to be offered; then an error is raised.",
            )
            .no_wait(
                "no script or client offers the action yet, and only a thread can wait for one: call this in a thread",
            )
            .example(example("sent", "assert(#current == 32)"))
    });
    add_action(
        offer,
        "cancelLastGoal",
        |c| {
            let handle = c.i64(0)?;
            c.instance().endpoint(handle, EndpointRole::ActionClient)?;
            let asked = match c.instance().last_goal(handle)? {
                Some(id) => c.instance().cancel(c, &id)?,
                None => false,
            };
            c.ret(asked);
            Ok(())
        },
        |cmd| {
            cmd.param(handle())
                .returns(Param::bool("answered").text("false: there is no goal without a result"))
                .text(
                    "Requests that the last goal be cancelled. Its server decides, and the result reports the \
                       outcome.",
                )
                .example(example(
                    "wanted_back",
                    "assert(simROS2.cancelLastGoal(client))\n\
                     assert(simROS2.actionServerIsCanceling(server, current))",
                ))
        },
    );
    add_action(
        offer,
        "shutdownActionClient",
        |c| c.instance().close(c, c.i64(0)?, EndpointRole::ActionClient),
        |cmd| {
            cmd.param(handle())
                .text("Shuts down an action client: it gets no more reports about its goals.")
                .example(example("given_up", "simROS2.shutdownActionClient(client)"))
        },
    );
    add_command(
        offer,
        ["", "waitForService"],
        |c, _| wait_for_service(c),
        |cmd, _| {
            cmd.param(handle())
                .param(Param::float("timeout").unit("s").optional().text("simulation time that a thread waits"))
                .returns(Param::bool("there"))
                .text("Returns whether a script or a client offers the service of a client, and waits until one does.")
                .no_wait("only a thread can wait for a service: call this in a thread")
                .example(
                    "local client = simROS2.createClient('/bell', 'std_srvs/srv/SetBool')\n\
                     assert(not simROS2.waitForService(client, 0))\n\
                     simROS2.createService('/bell', 'std_srvs/srv/SetBool', function(r) return {success = r.data} end)\n\
                     assert(simROS2.waitForService(client, 0))",
                )
        },
    );
}

/// Adds the commands of action servers.
fn servers(offer: &mut Offer<Plugin>) {
    add_action(
        offer,
        "createActionServer",
        |c| open(c, EndpointRole::ActionServer),
        |cmd| {
            cmd.param(Param::string("action"))
                .param(Param::string("type").text("example_interfaces/action/Fibonacci"))
                .param(callback("handleGoal", "(goal id, goal); returns simROS2.goal_response..."))
                .param(callback("handleCancel", "(goal id, goal); returns simROS2.cancel_response..."))
                .param(callback("handleAccepted", "(goal id, goal), and must return immediately"))
                .returns(handle())
                .text("Offers an action, to scripts of this world and to clients of `rosbridge`.")
                .example(example("served", "assert(simROS2.actionServerIsActive(server, current))"))
        },
    );
    add_action(
        offer,
        "shutdownActionServer",
        |c| {
            let handle = c.i64(0)?;
            c.instance().endpoint(handle, EndpointRole::ActionServer)?;
            c.instance().abort_all(c, handle)?;
            c.instance().close(c, handle, EndpointRole::ActionServer)
        },
        |cmd| {
            cmd.param(handle()).text("Stops offering an action; goals in progress end as aborted.").example(example(
                "closed",
                "simROS2.shutdownActionServer(server)\nassert(ended == simROS2.action_result_code.aborted)",
            ))
        },
    );
}

/// Adds the commands by which action servers process goals.
fn goals_of_servers(offer: &mut Offer<Plugin>) {
    let goal = || Param::string("goal").text("its id");
    let list = "{sequence = {0, 1}}";
    for (name, ended, text, example) in [
        (
            "PublishFeedback",
            None,
            "Sends feedback on a goal to its client.",
            format!("simROS2.actionServerPublishFeedback(server, current, {list})\nassert(heard[2] == 1)"),
        ),
        (
            "ActionSucceed",
            Some(goals::SUCCEEDED),
            "Ends a goal as succeeded.",
            format!("simROS2.actionServerActionSucceed(server, current, {list})\nassert(got[2] == 1)"),
        ),
        (
            "ActionAbort",
            Some(goals::ABORTED),
            "Ends a goal as aborted.",
            "simROS2.actionServerActionAbort(server, current, {})\nassert(ended == simROS2.action_result_code.aborted)"
                .to_owned(),
        ),
        (
            "ActionCanceled",
            Some(goals::CANCELED),
            "Ends a goal as cancelled, after its client requested this.",
            "simROS2.cancelLastGoal(client)\nsimROS2.actionServerActionCanceled(server, current, {})\n\
             assert(ended == simROS2.action_result_code.canceled)"
                .to_owned(),
        ),
    ] {
        let run = move |c: &mut RosCall<'_>| report(c, ended);
        add_action(offer, &format!("actionServer{name}"), run, |cmd| {
            let what = if ended.is_some() { "result" } else { "feedback" };
            cmd.param(handle())
                .param(goal())
                .param(Param::any(what).optional().text(format!("a table with the fields of the {what}")))
                .text(text)
                .example(self::example(name, &example))
        });
    }
    add_action(
        offer,
        "actionServerExecute",
        |c| {
            let (server, id, goal) = find_server_goal(c)?;
            if goal.stage != GoalStage::Deferred {
                let text = format!(
                    "goal '{id}' of {} is already being executed; only a deferred goal can be started",
                    server.name
                );
                return Err(Fail::unsupported(text));
            }
            c.instance().set_stage(&id, GoalStage::Executing)
        },
        |cmd| {
            let begin = example_start("deferred").replace("accept_and_execute", "accept_and_defer");
            cmd.param(handle()).param(goal()).text("Starts a goal that was deferred.").example(format!(
                "{begin}assert(not simROS2.actionServerIsExecuting(server, current))\n\
                 simROS2.actionServerExecute(server, current)\n\
                 assert(simROS2.actionServerIsExecuting(server, current))"
            ))
        },
    );
    for (name, stage, text) in [
        ("IsActive", None, "Returns whether a goal has no result yet."),
        (
            "IsExecuting",
            Some(GoalStage::Executing),
            "Returns whether a goal is active and no cancellation was requested.",
        ),
        ("IsCanceling", Some(GoalStage::Canceling), "Returns whether a cancellation of the goal was accepted."),
    ] {
        let run = move |c: &mut RosCall<'_>| {
            let (_, _, goal) = find_server_goal(c)?;
            c.ret(stage.is_none_or(|s| s == goal.stage));
            Ok(())
        };
        add_action(offer, &format!("actionServer{name}"), run, |cmd| {
            let not = if stage == Some(GoalStage::Canceling) { "not " } else { "" };
            cmd.param(handle())
                .param(goal())
                .returns(Param::bool("so"))
                .text(text)
                .notes("For a goal that has ended, this is an error.")
                .example(example(name, &format!("assert({not}simROS2.actionServer{name}(server, current))")))
        });
    }
}
