//! `simROS` and `simROS2`: what scripts written for V-REP's interfaces to ROS call.

use serde_json::Value as Json;
use tatu_plugin_api::safe::{Command, Event, Fail, IntoResult, Offer, Outcome, Param, Result, Value};

use crate::{
    Ctx, Ros as Plugin, convert,
    node::{Callback, ENDPOINT, Endpoint, MESSAGE, REQUEST, Role},
    types::{self, Ros},
};

type Cmd = Command<Plugin>;

/// Between scripts and the service; no script calls these.
pub(crate) const RECEIVE: &str = "rosbridge.receive";
pub(crate) const SERVE: &str = "rosbridge.serve";
pub(crate) const ANSWER: &str = "rosbridge.answer";

const HANDLE: &str = "what opening it gave";

fn parse(c: &Ctx<'_>, i: usize) -> Result<Json> {
    serde_json::from_slice(c.bytes(i)?).map_err(|e| Fail::argument(format!("no JSON: {e}")))
}

fn handle() -> Param {
    Param::any("handle").text(HANDLE)
}

/// Opens an endpoint by argument 0, its name, and 1, its type.
fn open(c: &mut Ctx<'_>, role: Role, ros: Ros, callback: Option<usize>) -> Result {
    let callback = match callback {
        None => Callback::default(),
        Some(i) => match c.arg(i).as_func() {
            Some(function) => Callback(String::new(), Some(c.keep_func(function)?)),
            None => Callback(c.text(i)?, None),
        },
    };
    let endpoint = Endpoint::new(role, &c.text(0)?, &c.text(1)?, ros, callback)?;
    let made = c.instance().open(&c.world(), c.caller_script(), endpoint)?;
    c.ret(made);
    Ok(())
}

/// What a service answered, as its caller gets it.
fn response(c: &mut Ctx<'_>, client: &Endpoint, json: &Json) -> Result<Outcome> {
    let value = convert::value(json, &format!("{}Response", client.kind), client.ros())?;
    c.ret::<Value>(value);
    Ok(Outcome::Done)
}

/// Calls a service: a script's at once; a client's where the caller can wait for it.
fn call(c: &mut Ctx<'_>) -> Result<Outcome> {
    if c.resumed() != 0 {
        let number = c.resumed();
        let (handle, answer) = c.instance().take(number)?;
        let client = c.instance().of(handle, Role::Client)?;
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
    let client = c.instance().of(handle, Role::Client)?;
    let given = c.arg(1).to_value()?;
    let request = convert::node(&given, &format!("{}Request", client.kind), client.ros())?.json();
    if let Some(json) = c.instance().serve(c, &client.name, &request)? {
        return response(c, &client, &json);
    }
    if !c.world().is_wanted(REQUEST) {
        let text = format!("no script offers {}, and no client can: start the service `rosbridge`", client.name);
        return Err(Fail::missing(text));
    }
    if !c.can_wait() {
        let text = format!("no script offers {}, and this one cannot wait for a client", client.name);
        return Err(Fail::unsupported(text).help("call it in a thread"));
    }
    let number = c.instance().ask(&c.world(), handle, &client.name, &request)?;
    c.wait_poll(number)
}

fn transforms(c: &mut Ctx<'_>, ros: Ros, all: Vec<Value>) -> Result {
    let endpoint = Endpoint::new(Role::Publisher, "/tf", "tf2_msgs/TFMessage", ros, Callback::default())?;
    let message = Value::Map(vec![(Value::text("transforms"), Value::List(all))]);
    c.instance().publish(c, &endpoint, &message)
}

fn time(c: &Ctx<'_>, key: &str) -> Result<f64> {
    c.world().f64(0, c.world().host().prop(key))
}

/// Seconds as ROS 2 has them.
fn split(seconds: f64) -> Value {
    let (whole, part) = (seconds.floor(), seconds - seconds.floor());
    Value::Map(vec![
        (Value::text("sec"), Value::Int(whole as i64)),
        (Value::text("nanosec"), Value::Int((part * 1e9).round() as i64)),
    ])
}

/// A command of both interfaces, whose names differ.
fn add<T: IntoResult + 'static>(
    offer: &mut Offer<Plugin>,
    names: [&str; 2],
    f: impl Fn(&mut Ctx<'_>, Ros) -> Result<T> + Copy + 'static,
    finish: impl Fn(Cmd, Ros) -> Cmd,
) {
    for (module, name, ros) in [("simROS", names[0], Ros::One), ("simROS2", names[1], Ros::Two)] {
        if !name.is_empty() {
            let command = finish(Cmd::new(format!("{module}.{name}"), move |c| f(c, ros)), ros);
            offer.command(command.subject(words(ros, "ros", "ros2").as_str()));
        }
    }
}

/// An example in the words of one of the interfaces.
fn words(ros: Ros, one: &str, two: &str) -> String {
    if ros == Ros::One { one.to_owned() } else { two.to_owned() }
}

pub(crate) fn offer(offer: &mut Offer<Plugin>) {
    topics(offer);
    services(offer);
    images(offer);
    params(offer);
    times(offer);
    offer.subject("ros2");
    between(offer);
    offer.subject("rosbridge");
}

fn topics(offer: &mut Offer<Plugin>) {
    let topic = || Param::string("topic");
    let kind = |ros: Ros| Param::string("type").text(ros.name("geometry_msgs/Twist"));
    let rest = |name| Param::any(name).optional().text("not needed: nothing waits longer than a step");
    add(
        offer,
        ["advertise", "createPublisher"],
        |c, ros| open(c, Role::Publisher, ros, None),
        |cmd, ros| {
            cmd.param(topic())
            .param(kind(ros))
            .param(rest("queue"))
            .param(rest("latch"))
            .param(rest("qos"))
            .returns(handle())
            .text("Will publish on a topic, for scripts of this world, and for clients where the service `rosbridge` is started.")
            .example(words(
                ros,
                "local p = simROS.advertise('/chatter', 'std_msgs/String')\nsimROS.publish(p, {data = 'hello'})",
                "local p = simROS2.createPublisher('/chatter', 'std_msgs/msg/String')\nsimROS2.publish(p, {data = 'hello'})",
            ))
        },
    );
    add(
        offer,
        ["publish", "publish"],
        |c, _| {
            let endpoint = c.instance().of(c.i64(0)?, Role::Publisher)?;
            let message = c.arg(1).to_value()?;
            c.instance().publish(c, &endpoint, &message)
        },
        |cmd, ros| {
            cmd.param(handle())
                .param(
                    Param::any("message").text("a table with the fields of the type; what is missing has its default"),
                )
                .text("Publishes a message. Fields that the type does not have are an error.")
                .example(words(
                    ros,
                    "local p = simROS.advertise('/go', 'geometry_msgs/Twist')\n\
                     assert(not pcall(simROS.publish, p, {linaer = {x = 1}}))",
                    "local p = simROS2.createPublisher('/go', 'geometry_msgs/msg/Twist')\n\
                     assert(not pcall(simROS2.publish, p, {linaer = {x = 1}}))",
                ))
        },
    );
    add(
        offer,
        ["subscribe", "createSubscription"],
        |c, ros| open(c, Role::Subscriber, ros, Some(2)),
        |cmd, ros| {
            cmd.param(topic())
            .param(kind(ros))
            .param(Param::any("callback").text("a function of the script or its name, called with a table for each message"))
            .param(rest("queue"))
            .param(rest("hints"))
            .returns(handle())
            .text("Listens to a topic. Messages of clients come between two steps, those of scripts at once.")
            .notes("Times are seconds in `simROS`, tables of sec and nanosec in `simROS2`.")
            .example(words(
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
            Role::Publisher,
            "advertise('/a', 'std_msgs/Empty')",
            "createPublisher('/a', 'std_msgs/msg/Empty')",
        ),
        (
            ["shutdownSubscriber", "shutdownSubscription"],
            Role::Subscriber,
            "subscribe('/a', 'std_msgs/Empty', 'f')",
            "createSubscription('/a', 'std_msgs/msg/Empty', 'f')",
        ),
        (
            ["shutdownServiceClient", "shutdownClient"],
            Role::Client,
            "serviceClient('/a', 'std_srvs/Empty')",
            "createClient('/a', 'std_srvs/srv/Empty')",
        ),
        (
            ["shutdownServiceServer", "shutdownService"],
            Role::Server,
            "advertiseService('/a', 'std_srvs/Empty', 'f')",
            "createService('/a', 'std_srvs/srv/Empty', 'f')",
        ),
    ] {
        let close = move |c: &mut Ctx<'_>, _| c.instance().close(c, c.i64(0)?, role);
        add(offer, names, close, |cmd, ros| {
            let text = format!("Gives a {} up.", role.name());
            cmd.param(handle()).text(text).example(words(
                ros,
                &format!("simROS.{}(simROS.{one})", names[0]),
                &format!("simROS2.{}(simROS2.{two})", names[1]),
            ))
        });
    }
    for (names, role, one, two) in [
        (
            ["publisherTreatUInt8ArrayAsString"; 2],
            Role::Publisher,
            "advertise('/a', 'sensor_msgs/Image')",
            "createPublisher('/a', 'sensor_msgs/msg/Image')",
        ),
        (
            ["subscriberTreatUInt8ArrayAsString", "subscriptionTreatUInt8ArrayAsString"],
            Role::Subscriber,
            "subscribe('/a', 'sensor_msgs/Image', 'f')",
            "createSubscription('/a', 'sensor_msgs/msg/Image', 'f')",
        ),
    ] {
        let set = move |c: &mut Ctx<'_>, _| c.instance().bytes_as_text(c.i64(0)?, role);
        add(offer, names, set, |cmd, ros| {
            cmd.param(handle()).text("Arrays of bytes are texts from now on, in place of tables of numbers; published they may be either.").example(
                words(ros, &format!("simROS.{}(simROS.{one})", names[0]), &format!("simROS2.{}(simROS2.{two})", names[1])),
            )
        });
    }
    let one = "{child_frame_id = 'a', header = {frame_id = 'map'}}";
    add(
        offer,
        ["sendTransform", "sendTransform"],
        |c, ros| transforms(c, ros, vec![c.arg(0).to_value()?]),
        |cmd, ros| {
            cmd.param(Param::any("transform").text("a table as geometry_msgs/TransformStamped"))
                .text("Publishes a frame on /tf.")
                .example(words(ros, &format!("simROS.sendTransform({one})"), &format!("simROS2.sendTransform({one})")))
        },
    );
    add(
        offer,
        ["sendTransforms", "sendTransforms"],
        |c, ros| match c.arg(0).to_value()? {
            Value::List(all) => transforms(c, ros, all),
            _ => Err(Fail::argument("argument 1: expected a list of transforms")),
        },
        |cmd, ros| {
            cmd.param(Param::any("transforms").text("a list of tables as geometry_msgs/TransformStamped"))
                .text("Publishes frames on /tf.")
                .example(words(
                    ros,
                    &format!("simROS.sendTransforms({{{one}}})"),
                    &format!("simROS2.sendTransforms({{{one}}})"),
                ))
        },
    );
}

fn services(offer: &mut Offer<Plugin>) {
    let kind = |ros| Param::string("type").text(words(ros, "std_srvs/SetBool", "std_srvs/srv/SetBool"));
    add(
        offer,
        ["serviceClient", "createClient"],
        |c, ros| open(c, Role::Client, ros, None),
        |cmd, ros| {
            cmd.param(Param::string("service")).param(kind(ros)).returns(handle()).text("Will call a service.").example(
                words(
                    ros,
                    "local client = simROS.serviceClient('/lamp', 'std_srvs/SetBool')",
                    "local client = simROS2.createClient('/lamp', 'std_srvs/srv/SetBool')",
                ),
            )
        },
    );
    add(
        offer,
        ["advertiseService", "createService"],
        |c, ros| open(c, Role::Server, ros, Some(2)),
        |cmd, ros| {
            cmd.param(Param::string("service"))
            .param(kind(ros))
            .param(Param::any("callback").text("a function of the script or its name: it has the request, and returns the response"))
            .returns(handle())
            .text("Offers a service, to scripts of this world and to clients.")
            .example(words(
                ros,
                "function lamp(r) return {success = r.data} end\nsimROS.advertiseService('/lamp', 'std_srvs/SetBool', 'lamp')\n\
                 assert(simROS.call(simROS.serviceClient('/lamp', 'std_srvs/SetBool'), {data = true}).success)",
                "function lamp(r) return {success = r.data} end\nsimROS2.createService('/lamp', 'std_srvs/srv/SetBool', 'lamp')\n\
                 assert(simROS2.call(simROS2.createClient('/lamp', 'std_srvs/srv/SetBool'), {data = true}).success)",
            ))
        },
    );
    add(
        offer,
        ["call", "call"],
        |c, _| call(c),
        |cmd, ros| {
            cmd.param(handle())
            .param(Param::any("request").optional())
            .returns(Param::any("response"))
            .text("Calls a service that a script or a client offers.")
            .no_wait("what a script offers is called; a client's service is an error")
            .example(words(
                ros,
                "function add(r) return {sum = r.a + r.b} end\nsimROS.advertiseService('/add', 'example_interfaces/AddTwoInts', 'add')\n\
                 assert(simROS.call(simROS.serviceClient('/add', 'example_interfaces/AddTwoInts'), {a = 2, b = 3}).sum == 5)",
                "function add(r) return {sum = r.a + r.b} end\nsimROS2.createService('/add', 'example_interfaces/srv/AddTwoInts', 'add')\n\
                 assert(simROS2.call(simROS2.createClient('/add', 'example_interfaces/srv/AddTwoInts'), {a = 2, b = 3}).sum == 5)",
            ))
        },
    );
}

fn times(offer: &mut Offer<Plugin>) {
    offer.command(
        Cmd::new("simROS.getTime", |c| {
            let now = time(c, "scene.time")?;
            c.ret(now);
            Ok(())
        })
        .param(Param::any("flag").optional())
        .returns(Param::float("time").unit("s"))
        .text("Gives simulation time.")
        .subject("ros")
        .example("assert(simROS.getTime() >= 0)"),
    );
    for (name, text) in [
        ("simROS2.getTime", "Gives simulation time."),
        ("simROS2.getSimulationTime", "Gives simulation time."),
        (
            "simROS2.getSystemTime",
            "Gives the date of the start and what clocks show since: the same in each run that is not in real time.",
        ),
    ] {
        offer.command(
            Cmd::new(name, move |c| {
                let now = match name {
                    "simROS2.getSystemTime" => {
                        let epoch = c.world().get(0, c.world().host().prop("scene.epoch"))?.as_i64().unwrap_or(0);
                        epoch as f64 + time(c, "scene.clock")?
                    }
                    _ => time(c, "scene.time")?,
                };
                c.ret::<Value>(split(now));
                Ok(())
            })
            .param(Param::any("clock").optional())
            .returns(Param::map("time").text("sec, nanosec"))
            .text(text)
            .example(format!("assert({name}().sec >= 0)")),
        );
    }
    offer.command(
        Cmd::new("simROS2.timeFromFloat", |c| {
            let value = split(c.f64(0)?);
            c.ret::<Value>(value);
            Ok(())
        })
        .param(Param::float("seconds").unit("s"))
        .returns(Param::map("time").text("sec, nanosec"))
        .text("Splits seconds.")
        .example("assert(simROS2.timeFromFloat(1.25).nanosec == 250000000)"),
    );
    offer.command(
        Cmd::new("simROS2.timeToFloat", |c| {
            let part = |key: &str| c.arg(0).get(key).and_then(|v| v.as_f64()).unwrap_or(0.0);
            c.ret(part("sec") + part("nanosec") * 1e-9);
            Ok(())
        })
        .param(Param::map("time").text("sec, nanosec"))
        .returns(Param::float("seconds").unit("s"))
        .text("Puts a time together.")
        .example("assert(simROS2.timeToFloat{sec = 1, nanosec = 250000000} == 1.25)"),
    );
    offer.command(
        Cmd::new("simROS2.createInterface", |c| {
            let plain = types::plain(&c.text(0)?);
            if types::fields(&plain).is_none() {
                return Err(Fail::missing(format!("the type `{plain}` is not known")));
            }
            c.ret::<Value>(convert::value(&Json::Null, &plain, Ros::Two)?);
            Ok(())
        })
        .param(Param::string("type").text("geometry_msgs/msg/Twist"))
        .returns(Param::map("message"))
        .text("Makes a message with the default of each field.")
        .example("assert(simROS2.createInterface('geometry_msgs/msg/Twist').linear.x == 0)"),
    );
    for (name, why) in [
        ("simROS2.spinSome", "messages come by themselves between two steps"),
        ("simROS2.importInterface", "the types that are there are known already"),
    ] {
        offer.command(Cmd::new(name, |_| Ok(())).param(Param::any("type").optional()).text("Does nothing.").stub(why));
    }
    offer.command(
        Cmd::new("simROS2.waitForService", |c| {
            c.ret(true);
            Ok(())
        })
        .param(handle())
        .param(Param::any("timeout").optional())
        .returns(Param::bool("there"))
        .text("Tells that a service is there.")
        .stub("nothing is waited for: a call tells whether it is there"),
    );
}

fn images(offer: &mut Offer<Plugin>) {
    let image = |c: &mut Ctx<'_>, ros| {
        let endpoint = Endpoint::new(Role::Publisher, &c.text(0)?, "sensor_msgs/Image", ros, Callback::default())?;
        let made = c.instance().open(&c.world(), c.caller_script(), endpoint)?;
        c.ret(made);
        Ok(())
    };
    let opened =
        |ros| words(ros, "simROS.imageTransportAdvertise('/eye')", "simROS2.imageTransportCreatePublisher('/eye')");
    add(offer, ["imageTransportAdvertise", "imageTransportCreatePublisher"], image, |cmd, ros| {
        cmd.param(Param::string("topic"))
            .param(Param::any("queue").optional())
            .returns(handle())
            .text("Will publish images.")
            .example(format!("local eye = {}", opened(ros)))
    });
    add(
        offer,
        ["imageTransportPublish", "imageTransportPublish"],
        |c, ros| {
            let endpoint = c.instance().of(c.i64(0)?, Role::Publisher)?;
            let (data, width, height) = (c.bytes(1)?, c.i64(2)?, c.i64(3)?);
            let row = usize::try_from(width).unwrap_or(0) * 3;
            if row == 0 || height < 0 || data.len() != row * height as usize {
                return Err(Fail::argument(format!(
                    "{width} x {height} pixels of three bytes are not {} bytes",
                    data.len()
                )));
            }
            // The simulator's lowest row comes first, that of ROS last.
            let flipped: Vec<u8> = data.chunks(row).rev().flatten().copied().collect();
            let stamp = match ros {
                Ros::One => Value::Float(time(c, "scene.time")?),
                Ros::Two => split(time(c, "scene.time")?),
            };
            let frame = if c.has(4) { c.text(4)? } else { String::new() };
            let pair = |key: &str, value: Value| (Value::text(key), value);
            let message = Value::Map(vec![
                pair("header", Value::Map(vec![pair("stamp", stamp), pair("frame_id", Value::text(frame))])),
                pair("width", Value::Int(width)),
                pair("height", Value::Int(height)),
                pair("encoding", Value::text("rgb8")),
                pair("step", Value::Int(row as i64)),
                pair("data", Value::Bytes(flipped)),
            ]);
            c.instance().publish(c, &endpoint, &message)
        },
        |cmd, ros| {
            let module = words(ros, "simROS", "simROS2");
            cmd.param(handle())
                .param(Param::string("data").text("red, green, blue of each pixel, the lowest row first"))
                .param(Param::int("width"))
                .param(Param::int("height"))
                .param(Param::string("frame").optional())
                .text("Publishes an image; its uppermost row comes first in the message.")
                .example(format!("{module}.imageTransportPublish({}, string.rep('\\0', 12), 2, 2)", opened(ros)))
        },
    );
    let close = |c: &mut Ctx<'_>, _| c.instance().close(c, c.i64(0)?, Role::Publisher);
    add(offer, ["imageTransportShutdownPublisher"; 2], close, |cmd, ros| {
        let module = words(ros, "simROS", "simROS2");
        cmd.param(handle())
            .text("Gives a publisher of images up.")
            .example(format!("{module}.imageTransportShutdownPublisher({})", opened(ros)))
    });
}

fn params(offer: &mut Offer<Plugin>) {
    for kind in ["String", "Int", "Double", "Bool"] {
        add(
            offer,
            [&format!("getParam{kind}"); 2],
            |c, _| {
                let name = c.text(0)?;
                let found = c.instance().all()?.params.get(&name).cloned();
                c.ret(found.is_some());
                match found {
                    Some(value) => c.ret::<Value>(tatu_services_common::json::read(&value)?),
                    None => c.ret::<Value>(c.arg(1).to_value()?),
                }
                Ok(())
            },
            |cmd, ros| {
                let module = words(ros, "simROS", "simROS2");
                cmd.param(Param::string("name"))
                    .param(Param::any("default").optional())
                    .returns(Param::bool("exists"))
                    .returns(Param::any("value"))
                    .text("Gives a parameter that a script of this world set.")
                    .example(format!(
                        "local exists, value = {module}.getParam{kind}('nowhere', 7)\nassert(not exists and value == 7)"
                    ))
            },
        );
        add(
            offer,
            [&format!("setParam{kind}"); 2],
            |c, _| {
                let value = tatu_services_common::json::write(&c.arg(1).to_value()?);
                let name = c.text(0)?;
                c.instance().all()?.params.insert(name, value);
                Ok(())
            },
            |cmd, ros| {
                let module = words(ros, "simROS", "simROS2");
                cmd.param(Param::string("name"))
                    .param(Param::any("value"))
                    .text("Sets a parameter, for scripts of this world.")
                    .example(format!(
                        "{module}.setParam{kind}('gain', 2)\nassert(select(2, {module}.getParam{kind}('gain')) == 2)"
                    ))
            },
        );
    }
    add(
        offer,
        ["hasParam"; 2],
        |c, _| {
            let name = c.text(0)?;
            let has = c.instance().all()?.params.contains_key(&name);
            c.ret(has);
            Ok(())
        },
        |cmd, ros| {
            let module = words(ros, "simROS", "simROS2");
            cmd.param(Param::string("name"))
                .returns(Param::bool("exists"))
                .text("Tells whether a script set a parameter.")
                .example(format!("assert(not {module}.hasParam('nowhere'))"))
        },
    );
    add(
        offer,
        ["deleteParam"; 2],
        |c, _| {
            let name = c.text(0)?;
            c.instance().all()?.params.remove(&name);
            Ok(())
        },
        |cmd, ros| {
            let module = words(ros, "simROS", "simROS2");
            cmd.param(Param::string("name"))
                .text("Removes a parameter.")
                .example(format!("{module}.deleteParam('nowhere')"))
        },
    );
}

/// What the service calls, so that it stands in the log of inputs.
fn between(offer: &mut Offer<Plugin>) {
    let json = || Param::string("json").text("the message, as JSON");
    offer.command(
        Cmd::new(RECEIVE, |c| {
            let (topic, json) = (c.text(0)?, parse(c, 1)?);
            c.instance().deliver(c, &topic, &json)
        })
        .param(Param::string("topic"))
        .param(json())
        .text("Gives a client's message to the scripts that listen to its topic.")
        .example(
            "function heard(m) text = m.data end\nsimROS.subscribe('/chatter', 'std_msgs/String', 'heard')\n\
                 rosbridge.receive('/chatter', '{\"data\": \"a\"}')\nassert(text == 'a')",
        ),
    );
    offer.command(
        Cmd::new(SERVE, |c| {
            let (service, request) = (c.text(0)?, parse(c, 1)?);
            let response = c.instance().serve(c, &service, &request)?;
            let response = response.ok_or_else(|| Fail::missing(format!("there is no service {service}")))?;
            c.ret::<Value>(Value::text(response.to_string()));
            Ok(())
        })
        .param(Param::string("service"))
        .param(json())
        .returns(json())
        .text("Calls a service that a script offers, for a client.")
        .example("assert(not pcall(rosbridge.serve, '/nowhere', '{}'))"),
    );
    offer.command(
        Cmd::new(ANSWER, |c| c.instance().answered(c.i64(0)? as u64, c.text(1)?, c.arg(2).truthy()))
            .param(Param::int("number"))
            .param(json())
            .param(Param::bool("good"))
            .text("Gives a client's answer to the script that waits for it.")
            .example("rosbridge.answer(1000000, '{}', true)"),
    );
    offer.prelude("lua", "", "return { api = { 'simROS.', 'simROS2.', 'rosbridge.' } }");
    offer.event(
        Event::new(ENDPOINT)
            .text("A script begins or ends to publish, to listen, to call or to serve.")
            .field(Param::string("role").text("publisher, subscriber, client, server"))
            .field(Param::string("name"))
            .field(Param::string("type"))
            .field(Param::bool("open")),
    );
    offer.event(
        Event::new(MESSAGE)
            .text("A script published a message.")
            .field(Param::string("topic"))
            .field(Param::string("type"))
            .field(Param::string("json")),
    );
    offer.event(
        Event::new(REQUEST)
            .text("A script calls a service that no script offers.")
            .field(Param::int("id"))
            .field(Param::string("service"))
            .field(Param::string("json")),
    );
}
