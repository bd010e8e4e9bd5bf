//! Times, images and parameters for scripts.

use serde_json::Value as Json;
use tatu_plugin_api::safe::{Fail, Offer, Param, Value};

use crate::{
    Ctx, Ros as Plugin, convert,
    node::{Callback, Endpoint, Role},
    scripts::{Cmd, add, handle, split, time, words},
    types::{self, Ros},
};

pub(crate) fn times(offer: &mut Offer<Plugin>) {
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

pub(crate) fn images(offer: &mut Offer<Plugin>) {
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

pub(crate) fn params(offer: &mut Offer<Plugin>) {
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
