//! Commands that publish and receive images.

use tatu_plugin_api::safe::{Fail, Offer, Param, Value};

use crate::{
    RosCall, RosPlugin as Plugin,
    node::{EndpointRole, ScriptCallback, ScriptEndpoint},
    scripts::{add_command, for_version, handle, ros2_time, time},
    types::RosVersion,
};

/// Adds the commands for images.
pub(crate) fn images(offer: &mut Offer<Plugin>) {
    let image = |c: &mut RosCall<'_>, ros| {
        let endpoint = ScriptEndpoint::new(EndpointRole::Publisher, &c.text(0)?, "sensor_msgs/Image", ros, Vec::new())?;
        let made = c.instance().open(&c.world(), c.caller_script(), endpoint)?;
        c.ret(made);
        Ok(())
    };
    let opened = |ros| {
        for_version(ros, "simROS.imageTransportAdvertise('/eye')", "simROS2.imageTransportCreatePublisher('/eye')")
    };
    add_command(offer, ["imageTransportAdvertise", "imageTransportCreatePublisher"], image, |cmd, ros| {
        cmd.param(Param::string("topic"))
            .param(Param::any("queue").optional())
            .returns(handle())
            .text("Creates a publisher of images.")
            .example(format!("local eye = {}", opened(ros)))
    });
    add_command(
        offer,
        ["imageTransportPublish", "imageTransportPublish"],
        |c, ros| {
            let endpoint = c.instance().endpoint(c.i64(0)?, EndpointRole::Publisher)?;
            let (data, width, height) = (c.bytes(1)?, c.i64(2)?, c.i64(3)?);
            let row = usize::try_from(width).unwrap_or(0) * 3;
            if row == 0 || height < 0 || data.len() != row * height as usize {
                return Err(Fail::argument(format!(
                    "expected the data of {width} x {height} pixels with three bytes each, found {} bytes",
                    data.len()
                )));
            }
            // Images of the simulator start with the bottom row, those of ROS with the top row.
            let flipped: Vec<u8> = data.chunks(row).rev().flatten().copied().collect();
            let stamp = match ros {
                RosVersion::One => Value::Float(time(c, "scene.time")?),
                RosVersion::Two => ros2_time(time(c, "scene.time")?),
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
            let module = for_version(ros, "simROS", "simROS2");
            cmd.param(handle())
                .param(Param::string("data").text("red, green, blue of each pixel, the lowest row first"))
                .param(Param::int("width"))
                .param(Param::int("height"))
                .param(Param::string("frame").optional())
                .text("Publishes an image; its uppermost row comes first in the message.")
                .example(format!("{module}.imageTransportPublish({}, string.rep('\\0', 12), 2, 2)", opened(ros)))
        },
    );
    let listen = |c: &mut RosCall<'_>, ros| {
        let callback = ScriptCallback::read(c, 1)?;
        let mut endpoint =
            ScriptEndpoint::new(EndpointRole::Subscriber, &c.text(0)?, "sensor_msgs/Image", ros, vec![callback])?;
        endpoint.pixels = true;
        let made = c.instance().open(&c.world(), c.caller_script(), endpoint)?;
        c.ret(made);
        Ok(())
    };
    add_command(offer, ["imageTransportSubscribe", "imageTransportCreateSubscription"], listen, |cmd, ros| {
        let module = for_version(ros, "simROS", "simROS2");
        let name = for_version(ros, "imageTransportSubscribe", "imageTransportCreateSubscription");
        cmd.param(Param::string("topic"))
            .param(Param::any("callback").text(
                "a function of the script or its name, called with data, width and height: red, green, blue of each \
                 pixel, the lowest row first",
            ))
            .param(Param::any("queue").optional())
            .returns(handle())
            .text("Subscribes to images.")
            .notes("Encodings are rgb8, bgr8, rgba8, bgra8 and mono8; others are an error.")
            .example(format!(
                "function seen(data, width, height) first, size = data:byte(1), width * height end\n\
                 {module}.{name}('/eye', 'seen')\n\
                 {module}.imageTransportPublish({}, '\\1\\2\\3\\4\\5\\6', 1, 2)\nassert(first == 1 and size == 2)",
                opened(ros)
            ))
    });
    for (names, role, what, open) in [
        (
            ["imageTransportShutdownPublisher"; 2],
            EndpointRole::Publisher,
            "publisher of",
            opened as fn(RosVersion) -> String,
        ),
        (
            ["imageTransportShutdownSubscriber", "imageTransportShutdownSubscription"],
            EndpointRole::Subscriber,
            "listener to",
            |ros| {
                for_version(
                    ros,
                    "simROS.imageTransportSubscribe('/eye', 'f')",
                    "simROS2.imageTransportCreateSubscription('/eye', 'f')",
                )
            },
        ),
    ] {
        let close = move |c: &mut RosCall<'_>, _| c.instance().close(c, c.i64(0)?, role);
        add_command(offer, names, close, |cmd, ros| {
            let name = for_version(ros, &format!("simROS.{}", names[0]), &format!("simROS2.{}", names[1]));
            cmd.param(handle()).text(format!("Shuts down a {what} images.")).example(format!("{name}({})", open(ros)))
        });
    }
}
