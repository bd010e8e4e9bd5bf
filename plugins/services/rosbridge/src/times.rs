//! Commands that return and convert times, and one that creates messages with default values.

use serde_json::Value as Json;
use tatu_plugin_api::safe::{Fail, Offer, Param};

use crate::{
    RosPlugin as Plugin, convert,
    scripts::{RosCommand, ros2_time, time},
    types::{self, RosVersion},
};

/// Adds the commands for times, and the one that creates messages.
pub(crate) fn times(offer: &mut Offer<Plugin>) {
    offer.command(
        RosCommand::new("simROS.getTime", |c| {
            let now = time(c, "scene.time")?;
            c.ret(now);
            Ok(())
        })
        .param(Param::any("flag").optional())
        .returns(Param::float("time").unit("s"))
        .text("Returns the simulation time.")
        .subject("ros")
        .example("assert(simROS.getTime() >= 0)"),
    );
    for (name, text) in [
        ("simROS2.getTime", "Returns the simulation time."),
        ("simROS2.getSimulationTime", "Returns the simulation time."),
        (
            "simROS2.getSystemTime",
            "Returns the date and time at the start plus the time elapsed since then. The result is the same in each \
             run that is not in real time.",
        ),
    ] {
        offer.command(
            RosCommand::new(name, move |c| {
                let now = match name {
                    "simROS2.getSystemTime" => {
                        let epoch = c.world().get(0, c.world().host().prop("scene.epoch"))?.as_i64().unwrap_or(0);
                        epoch as f64 + time(c, "scene.clock")?
                    }
                    _ => time(c, "scene.time")?,
                };
                c.ret(ros2_time(now));
                Ok(())
            })
            .param(Param::any("clock").optional())
            .returns(Param::map("time").text("sec, nanosec"))
            .text(text)
            .example(format!("assert({name}().sec >= 0)")),
        );
    }
    offer.command(
        RosCommand::new("simROS2.timeFromFloat", |c| {
            let value = ros2_time(c.f64(0)?);
            c.ret(value);
            Ok(())
        })
        .param(Param::float("seconds").unit("s"))
        .returns(Param::map("time").text("sec, nanosec"))
        .text("Converts seconds to a time.")
        .example("assert(simROS2.timeFromFloat(1.25).nanosec == 250000000)"),
    );
    offer.command(
        RosCommand::new("simROS2.timeToFloat", |c| {
            let part = |key: &str| c.arg(0).get(key).and_then(|v| v.as_f64()).unwrap_or(0.0);
            c.ret(part("sec") + part("nanosec") * 1e-9);
            Ok(())
        })
        .param(Param::map("time").text("sec, nanosec"))
        .returns(Param::float("seconds").unit("s"))
        .text("Converts a time to seconds.")
        .example("assert(simROS2.timeToFloat{sec = 1, nanosec = 250000000} == 1.25)"),
    );
    offer.command(
        RosCommand::new("simROS2.createInterface", |c| {
            let plain = types::ros1_name(&c.text(0)?);
            if types::fields(&plain).is_none() {
                return Err(Fail::missing(format!("the message type `{plain}` is not supported")));
            }
            c.ret(convert::value(&Json::Null, &plain, RosVersion::Two)?);
            Ok(())
        })
        .param(Param::string("type").text("geometry_msgs/msg/Twist"))
        .returns(Param::map("message"))
        .text("Creates a message with the default value of each field.")
        .example("assert(simROS2.createInterface('geometry_msgs/msg/Twist').linear.x == 0)"),
    );
    for (name, why) in [
        ("simROS2.spinSome", "messages are delivered automatically between two steps"),
        ("simROS2.importInterface", "all supported types are always available"),
    ] {
        offer.command(
            RosCommand::new(name, |_| Ok(())).param(Param::any("type").optional()).text("Does nothing.").stub(why),
        );
    }
}
