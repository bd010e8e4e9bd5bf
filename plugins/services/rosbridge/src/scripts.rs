//! The commands `simROS` and `simROS2`, for scripts that were written for V-REP's interfaces to ROS.

use serde_json::Value as Json;
use tatu_plugin_api::safe::{Command, Event, Fail, IntoResult, Offer, Outcome, Param, Result, Value};

use crate::{
    RosCall, RosPlugin as Plugin, convert,
    node::{ENDPOINT_EVENT, EndpointRole, MESSAGE_EVENT, REQUEST_EVENT, ScriptCallback, ScriptEndpoint},
    types::RosVersion,
};

pub(crate) type RosCommand = Command<Plugin>;

// Names of commands that only the service calls.
/// Passes a message of a client to the scripts that have subscribed to its topic.
pub(crate) const RECEIVE: &str = "rosbridge.receive";
/// Passes a client's call of a service to the script that offers the service.
pub(crate) const SERVE: &str = "rosbridge.serve";
/// Passes a client's answer to the script that called a service of the client.
pub(crate) const ANSWER: &str = "rosbridge.answer";

const HANDLE_TEXT: &str = "the handle that was returned when it was created";

/// Parses argument `i`, which is JSON.
pub(crate) fn parse(c: &RosCall<'_>, i: usize) -> Result<Json> {
    serde_json::from_slice(c.bytes(i)?).map_err(|e| Fail::argument(format!("argument {}: not valid JSON: {e}", i + 1)))
}

/// Returns the parameter for the handle of an endpoint.
pub(crate) fn handle() -> Param {
    Param::any("handle").text(HANDLE_TEXT)
}

/// Opens an endpoint with the name in argument 0, the type in argument 1, and the callback in argument `callback`.
fn open(c: &mut RosCall<'_>, role: EndpointRole, ros: RosVersion, callback: Option<usize>) -> Result {
    let callbacks = callback.map(|i| ScriptCallback::read(c, i)).transpose()?;
    open_with(c, role, ros, callbacks.into_iter().collect())
}

/// Opens an endpoint with the name in argument 0, the type in argument 1, and the given callbacks.
pub(crate) fn open_with(
    c: &mut RosCall<'_>,
    role: EndpointRole,
    ros: RosVersion,
    callbacks: Vec<ScriptCallback>,
) -> Result {
    let endpoint = ScriptEndpoint::new(role, &c.text(0)?, &c.text(1)?, ros, callbacks)?;
    let made = c.instance().open(&c.world(), c.caller_script(), endpoint)?;
    c.ret(made);
    Ok(())
}

/// Returns the response of a service as the result of the command.
fn response(c: &mut RosCall<'_>, client: &ScriptEndpoint, json: &Json) -> Result<Outcome> {
    let value = convert::value(json, &format!("{}Response", client.kind), client.ros())?;
    c.ret(client.to_script_form(value));
    Ok(Outcome::Done)
}

/// Calls a service. A service of a script is executed immediately; the answer of a client can be obtained only if the
/// calling script can wait.
fn call(c: &mut RosCall<'_>) -> Result<Outcome> {
    if c.resumed() != 0 {
        let number = c.resumed();
        let (handle, answer) = c.instance().take_answer(number)?;
        let client = c.instance().endpoint(handle, EndpointRole::Client)?;
        return match answer {
            Some((text, true)) => response(c, &client, &serde_json::from_str(&text).unwrap_or(Json::Null)),
            Some((text, false)) => {
                let why = serde_json::from_str(&text).unwrap_or(text);
                Err(Fail::new(format!("the service {} failed: {why}", client.name)))
            }
            None => c.wait_poll(number),
        };
    }
    let handle = c.i64(0)?;
    let client = c.instance().endpoint(handle, EndpointRole::Client)?;
    let given = c.arg(1).to_value()?;
    let request = convert::node(&given, &format!("{}Request", client.kind), client.ros())?.json();
    if let Some(json) = c.instance().serve(c, &client.name, &request)? {
        return response(c, &client, &json);
    }
    if !c.world().is_wanted(REQUEST_EVENT) {
        let text = format!(
            "no script offers the service {}; to call services of clients, run the scene with the service `rosbridge`",
            client.name
        );
        return Err(Fail::missing(text));
    }
    if !c.can_wait() {
        let text =
            format!("no script offers the service {}, and the calling script cannot wait for a client", client.name);
        return Err(Fail::unsupported(text).help("call the service in a thread"));
    }
    let number = c.instance().request_service(&c.world(), handle, &client.name, &request)?;
    c.wait_poll(number)
}

/// Publishes transforms on `/tf`.
fn publish_transforms(c: &mut RosCall<'_>, ros: RosVersion, all: Vec<Value>) -> Result {
    let endpoint = ScriptEndpoint::new(EndpointRole::Publisher, "/tf", "tf2_msgs/TFMessage", ros, Vec::new())?;
    let message = Value::Map(vec![(Value::text("transforms"), Value::List(all))]);
    c.instance().publish(c, &endpoint, &message)
}

/// Returns a property of the scene that is a time, s.
pub(crate) fn time(c: &RosCall<'_>, key: &str) -> Result<f64> {
    c.world().f64(0, c.world().host().prop(key))
}

/// Converts seconds to a table with the fields of a ROS 2 time.
pub(crate) fn ros2_time(seconds: f64) -> Value {
    let (whole, part) = (seconds.floor(), seconds - seconds.floor());
    // Rounding can yield a whole second.
    let nanoseconds = (part * 1e9).round() as i64;
    Value::Map(vec![
        (Value::text("sec"), Value::Int(whole as i64 + nanoseconds / 1_000_000_000)),
        (Value::text("nanosec"), Value::Int(nanoseconds % 1_000_000_000)),
    ])
}

/// Adds a command to both interfaces, under its name in `simROS` and that in `simROS2`. If a name is empty, the command
/// is not added to that interface.
pub(crate) fn add_command<T: IntoResult + 'static>(
    offer: &mut Offer<Plugin>,
    names: [&str; 2],
    f: impl Fn(&mut RosCall<'_>, RosVersion) -> Result<T> + Copy + Send + Sync + 'static,
    finish: impl Fn(RosCommand, RosVersion) -> RosCommand,
) {
    for (module, name, ros) in [("simROS", names[0], RosVersion::One), ("simROS2", names[1], RosVersion::Two)] {
        if !name.is_empty() {
            let command = finish(RosCommand::new(format!("{module}.{name}"), move |c| f(c, ros)), ros);
            offer.command(command.subject(for_version(ros, "ros", "ros2").as_str()));
        }
    }
}

/// Returns `one` for ROS 1 and `two` for ROS 2.
pub(crate) fn for_version(ros: RosVersion, one: &str, two: &str) -> String {
    if ros == RosVersion::One { one.to_owned() } else { two.to_owned() }
}

pub(crate) fn offer(offer: &mut Offer<Plugin>) {
    topics(offer);
    services(offer);
}

/// Adds the commands for topics.
fn topics(offer: &mut Offer<Plugin>) {
    let topic = || Param::string("topic");
    let kind = |ros: RosVersion| Param::string("type").text(ros.name("geometry_msgs/Twist"));
    let rest = |name| Param::any(name).optional().text("ignored: messages are never queued for longer than a step");
    add_command(
        offer,
        ["advertise", "createPublisher"],
        |c, ros| open(c, EndpointRole::Publisher, ros, None),
        |cmd, ros| {
            cmd.param(topic())
            .param(kind(ros))
            .param(rest("queue"))
            .param(rest("latch"))
            .param(rest("qos"))
            .returns(handle())
            .text("Creates a publisher for a topic, for scripts of this world, and for clients if the service \
                   `rosbridge` is started.")
            .example(for_version(
                ros,
                "local p = simROS.advertise('/chatter', 'std_msgs/String')\nsimROS.publish(p, {data = 'hello'})",
                "local p = simROS2.createPublisher('/chatter', 'std_msgs/msg/String')\nsimROS2.publish(p, {data = 'hello'})",
            ))
        },
    );
    add_command(
        offer,
        ["publish", "publish"],
        |c, _| {
            let endpoint = c.instance().endpoint(c.i64(0)?, EndpointRole::Publisher)?;
            let message = c.arg(1).to_value()?;
            c.instance().publish(c, &endpoint, &message)
        },
        |cmd, ros| {
            cmd.param(handle())
                .param(
                    Param::any("message")
                        .text("a table with the fields of the type; missing fields have their defaults"),
                )
                .text("Publishes a message. Fields that the type does not have are an error.")
                .example(for_version(
                    ros,
                    "local p = simROS.advertise('/go', 'geometry_msgs/Twist')\n\
                     assert(not pcall(simROS.publish, p, {linaer = {x = 1}}))",
                    "local p = simROS2.createPublisher('/go', 'geometry_msgs/msg/Twist')\n\
                     assert(not pcall(simROS2.publish, p, {linaer = {x = 1}}))",
                ))
        },
    );
    add_command(
        offer,
        ["subscribe", "createSubscription"],
        |c, ros| open(c, EndpointRole::Subscriber, ros, Some(2)),
        |cmd, ros| {
            cmd.param(topic())
            .param(kind(ros))
            .param(Param::any("callback").text("a function of the script or its name, called with a table per message"))
            .param(rest("queue"))
            .param(rest("hints"))
            .returns(handle())
            .text("Subscribes to a topic. Messages of clients arrive between two steps, those of scripts immediately.")
            .notes("Times are seconds in `simROS`, tables of sec and nanosec in `simROS2`.")
            .example(for_version(
                ros,
                "function heard(m) text = m.data end\nsimROS.subscribe('/chatter', 'std_msgs/String', 'heard')\n\
                 simROS.publish(simROS.advertise('/chatter', 'std_msgs/String'), {data = 'a'})\nassert(text == 'a')",
                "function heard(m) text = m.data end\nsimROS2.createSubscription('/chatter', 'std_msgs/msg/String', 'heard')\n\
                 simROS2.publish(simROS2.createPublisher('/chatter', 'std_msgs/msg/String'), {data = 'a'})\nassert(text == 'a')",
            ))
        },
    );
    for (names, role, one, two) in [
        (
            ["shutdownPublisher", "shutdownPublisher"],
            EndpointRole::Publisher,
            "advertise('/a', 'std_msgs/Empty')",
            "createPublisher('/a', 'std_msgs/msg/Empty')",
        ),
        (
            ["shutdownSubscriber", "shutdownSubscription"],
            EndpointRole::Subscriber,
            "subscribe('/a', 'std_msgs/Empty', 'f')",
            "createSubscription('/a', 'std_msgs/msg/Empty', 'f')",
        ),
        (
            ["shutdownServiceClient", "shutdownClient"],
            EndpointRole::Client,
            "serviceClient('/a', 'std_srvs/Empty')",
            "createClient('/a', 'std_srvs/srv/Empty')",
        ),
        (
            ["shutdownServiceServer", "shutdownService"],
            EndpointRole::Server,
            "advertiseService('/a', 'std_srvs/Empty', 'f')",
            "createService('/a', 'std_srvs/srv/Empty', 'f')",
        ),
    ] {
        let close = move |c: &mut RosCall<'_>, _| c.instance().close(c, c.i64(0)?, role);
        add_command(offer, names, close, |cmd, ros| {
            let text = format!("Shuts down a {}.", role.name());
            cmd.param(handle()).text(text).example(for_version(
                ros,
                &format!("simROS.{}(simROS.{one})", names[0]),
                &format!("simROS2.{}(simROS2.{two})", names[1]),
            ))
        });
    }
    let one = "{child_frame_id = 'a', header = {frame_id = 'map'}}";
    add_command(
        offer,
        ["sendTransform", "sendTransform"],
        |c, ros| publish_transforms(c, ros, vec![c.arg(0).to_value()?]),
        |cmd, ros| {
            cmd.param(Param::any("transform").text("a table as geometry_msgs/TransformStamped"))
                .text("Publishes a frame on /tf.")
                .example(for_version(
                    ros,
                    &format!("simROS.sendTransform({one})"),
                    &format!("simROS2.sendTransform({one})"),
                ))
        },
    );
    add_command(
        offer,
        ["sendTransforms", "sendTransforms"],
        |c, ros| match c.arg(0).to_value()? {
            Value::List(all) => publish_transforms(c, ros, all),
            _ => Err(Fail::argument("argument 1: expected a list of transforms")),
        },
        |cmd, ros| {
            cmd.param(Param::any("transforms").text("a list of tables as geometry_msgs/TransformStamped"))
                .text("Publishes frames on /tf.")
                .example(for_version(
                    ros,
                    &format!("simROS.sendTransforms({{{one}}})"),
                    &format!("simROS2.sendTransforms({{{one}}})"),
                ))
        },
    );
}

/// Adds the commands for services.
fn services(offer: &mut Offer<Plugin>) {
    let kind = |ros| Param::string("type").text(for_version(ros, "std_srvs/SetBool", "std_srvs/srv/SetBool"));
    add_command(
        offer,
        ["serviceClient", "createClient"],
        |c, ros| open(c, EndpointRole::Client, ros, None),
        |cmd, ros| {
            cmd.param(Param::string("service"))
                .param(kind(ros))
                .returns(handle())
                .text("Creates a client for a service.")
                .example(for_version(
                    ros,
                    "local client = simROS.serviceClient('/lamp', 'std_srvs/SetBool')",
                    "local client = simROS2.createClient('/lamp', 'std_srvs/srv/SetBool')",
                ))
        },
    );
    add_command(
        offer,
        ["advertiseService", "createService"],
        |c, ros| open(c, EndpointRole::Server, ros, Some(2)),
        |cmd, ros| {
            cmd.param(Param::string("service"))
            .param(kind(ros))
            .param(Param::any("callback").text("a function of the script or its name: maps a request to a response"))
            .returns(handle())
            .text("Offers a service, to scripts of this world and to clients.")
            .example(for_version(
                ros,
                "function lamp(r) return {success = r.data} end\nsimROS.advertiseService('/lamp', 'std_srvs/SetBool', 'lamp')\n\
                 assert(simROS.call(simROS.serviceClient('/lamp', 'std_srvs/SetBool'), {data = true}).success)",
                "function lamp(r) return {success = r.data} end\nsimROS2.createService('/lamp', 'std_srvs/srv/SetBool', 'lamp')\n\
                 assert(simROS2.call(simROS2.createClient('/lamp', 'std_srvs/srv/SetBool'), {data = true}).success)",
            ))
        },
    );
    add_command(
        offer,
        ["call", "call"],
        |c, _| call(c),
        |cmd, ros| {
            cmd.param(handle())
            .param(Param::any("request").optional())
            .returns(Param::any("response"))
            .text("Calls a service that a script or a client offers.")
            .no_wait("a client offers this service, and only a thread can wait for its answer: call this in a thread")
            .example(for_version(
                ros,
                "function add(r) return {sum = r.a + r.b} end\nsimROS.advertiseService('/add', 'example_interfaces/AddTwoInts', 'add')\n\
                 assert(simROS.call(simROS.serviceClient('/add', 'example_interfaces/AddTwoInts'), {a = 2, b = 3}).sum == 5)",
                "function add(r) return {sum = r.a + r.b} end\nsimROS2.createService('/add', 'example_interfaces/srv/AddTwoInts', 'add')\n\
                 assert(simROS2.call(simROS2.createClient('/add', 'example_interfaces/srv/AddTwoInts'), {a = 2, b = 3}).sum == 5)",
            ))
        },
    );
}

/// Adds the commands by which the service passes data to scripts, so that the input log contains it, and the events by
/// which scripts pass data to the service.
pub(crate) fn offer_service_commands(offer: &mut Offer<Plugin>) {
    let json = || Param::string("json").text("the message, as JSON");
    offer.command(
        RosCommand::new(RECEIVE, |c| {
            let (topic, json) = (c.text(0)?, parse(c, 1)?);
            c.instance().deliver(c, &topic, &json)
        })
        .param(Param::string("topic"))
        .param(json())
        .text("Passes a client's message to the scripts that listen to its topic.")
        .example(
            "function heard(m) text = m.data end\nsimROS.subscribe('/chatter', 'std_msgs/String', 'heard')\n\
                 rosbridge.receive('/chatter', '{\"data\": \"a\"}')\nassert(text == 'a')",
        ),
    );
    offer.command(
        RosCommand::new(SERVE, |c| {
            let (service, request) = (c.text(0)?, parse(c, 1)?);
            let response = c.instance().serve(c, &service, &request)?;
            let response = response.ok_or_else(|| Fail::missing(format!("there is no service {service}")))?;
            c.ret(Value::text(response.to_string()));
            Ok(())
        })
        .param(Param::string("service"))
        .param(json())
        .returns(json())
        .text("Calls a service that a script offers, for a client.")
        .example("assert(not pcall(rosbridge.serve, '/nowhere', '{}'))"),
    );
    offer.command(
        RosCommand::new(ANSWER, |c| c.instance().store_answer(c.i64(0)? as u64, c.text(1)?, c.arg(2).truthy()))
            .param(Param::int("number"))
            .param(json())
            .param(Param::bool("good"))
            .text("Passes a client's answer to the script that waits for it.")
            .example("rosbridge.answer(1000000, '{}', true)"),
    );
    offer.prelude("lua", "", "return { api = { 'simROS.', 'simROS2.', 'rosbridge.' } }");
    offer.event(
        Event::new(ENDPOINT_EVENT)
            .text("A script starts or stops publishing, listening, calling or serving.")
            .field(Param::string("role").text("publisher, subscriber, client, server, action client, action server"))
            .field(Param::string("name").text("of the topic, service or action"))
            .field(Param::string("type").text("of its messages, such as `std_msgs/String`"))
            .field(Param::bool("open").text("true: the endpoint was opened; false: it was closed")),
    );
    offer.event(
        Event::new(MESSAGE_EVENT)
            .text("A script published a message.")
            .field(Param::string("topic").text("its name"))
            .field(Param::string("type").text("of the message, such as `std_msgs/String`"))
            .field(Param::string("json").text("the message")),
    );
    offer.event(
        Event::new(REQUEST_EVENT)
            .text("A script calls a service that no script offers.")
            .field(Param::int("id").text("of the call, for `rosbridge.answer`"))
            .field(Param::string("service").text("its name"))
            .field(Param::string("json").text("the request")),
    );
}
