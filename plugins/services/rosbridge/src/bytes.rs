//! Commands by which scripts choose to receive arrays of bytes as strings instead of tables, and a command that returns
//! the named constants of a message type.

use tatu_plugin_api::safe::{Fail, Offer, Param, Value};

use crate::{
    RosCall, RosPlugin as Plugin,
    node::EndpointRole,
    scripts::{RosCommand, add_command, for_version, handle},
    types,
};

/// Named constants of message types, from the public definitions of ROS.
const CONSTANTS: &[(&str, &[(&str, i64)])] = &[
    (
        "sensor_msgs/PointField",
        &[
            ("INT8", 1),
            ("UINT8", 2),
            ("INT16", 3),
            ("UINT16", 4),
            ("INT32", 5),
            ("UINT32", 6),
            ("FLOAT32", 7),
            ("FLOAT64", 8),
        ],
    ),
    ("sensor_msgs/Range", &[("ULTRASOUND", 0), ("INFRARED", 1)]),
    (
        "sensor_msgs/NavSatStatus",
        &[
            ("STATUS_NO_FIX", -1),
            ("STATUS_FIX", 0),
            ("STATUS_SBAS_FIX", 1),
            ("STATUS_GBAS_FIX", 2),
            ("SERVICE_GPS", 1),
            ("SERVICE_GLONASS", 2),
            ("SERVICE_COMPASS", 4),
            ("SERVICE_GALILEO", 8),
        ],
    ),
    (
        "sensor_msgs/NavSatFix",
        &[
            ("COVARIANCE_TYPE_UNKNOWN", 0),
            ("COVARIANCE_TYPE_APPROXIMATED", 1),
            ("COVARIANCE_TYPE_DIAGONAL_KNOWN", 2),
            ("COVARIANCE_TYPE_KNOWN", 3),
        ],
    ),
];

/// For each role: the names of the commands added here, in `simROS` and in `simROS2`, and calls that open an endpoint
/// of the role, for the examples.
const BYTES_AS_TEXT_COMMANDS: &[(EndpointRole, [&str; 2], [&str; 2])] = &[
    (
        EndpointRole::Publisher,
        ["publisherTreatUInt8ArrayAsString"; 2],
        ["advertise('/a', 'sensor_msgs/Image')", "createPublisher('/a', 'sensor_msgs/msg/Image')"],
    ),
    (
        EndpointRole::Subscriber,
        ["subscriberTreatUInt8ArrayAsString", "subscriptionTreatUInt8ArrayAsString"],
        ["subscribe('/a', 'sensor_msgs/Image', 'f')", "createSubscription('/a', 'sensor_msgs/msg/Image', 'f')"],
    ),
    (
        EndpointRole::Client,
        ["serviceClientTreatUInt8ArrayAsString", "clientTreatUInt8ArrayAsString"],
        ["serviceClient('/a', 'std_srvs/Empty')", "createClient('/a', 'std_srvs/srv/Empty')"],
    ),
    (
        EndpointRole::Server,
        ["serviceServerTreatUInt8ArrayAsString", "serviceTreatUInt8ArrayAsString"],
        ["advertiseService('/a', 'std_srvs/Empty', 'f')", "createService('/a', 'std_srvs/srv/Empty', 'f')"],
    ),
    (
        EndpointRole::ActionClient,
        ["", "actionClientTreatUInt8ArrayAsString"],
        ["", "createActionClient('/a', 'example_interfaces/action/Fibonacci')"],
    ),
    (
        EndpointRole::ActionServer,
        ["", "actionServerTreatUInt8ArrayAsString"],
        ["", "createActionServer('/b', 'example_interfaces/action/Fibonacci')"],
    ),
];

pub(crate) fn offer(offer: &mut Offer<Plugin>) {
    for (role, names, opens) in BYTES_AS_TEXT_COMMANDS {
        let set = move |c: &mut RosCall<'_>, _| c.instance().bytes_as_text(c.i64(0)?, *role);
        add_command(offer, *names, set, |cmd, ros| {
            let one = format!("simROS.{}(simROS.{})", names[0], opens[0]);
            let two = format!("simROS2.{}(simROS2.{})", names[1], opens[1]);
            cmd.param(handle())
                .text(
                    "Arrays of bytes are received as strings instead of tables of numbers from now on; published ones \
                     may be either.",
                )
                .example(for_version(ros, &one, &two))
        });
    }
    offer.command(
        RosCommand::new("simROS2.getInterfaceConstants", |c| {
            let plain = types::ros1_name(&c.text(0)?);
            if types::fields(&plain).is_none() {
                return Err(Fail::missing(format!("the message type `{plain}` is not supported")));
            }
            let of = CONSTANTS.iter().find(|(name, _)| *name == plain).map_or(&[][..], |(_, of)| of);
            c.ret(Value::Map(of.iter().map(|(name, value)| (Value::text(*name), Value::Int(*value))).collect()));
            Ok(())
        })
        .param(Param::string("type").text("sensor_msgs/msg/PointField"))
        .returns(Param::map("constants"))
        .text("Returns the named constants of a message type.")
        .example("assert(simROS2.getInterfaceConstants('sensor_msgs/msg/PointField').FLOAT32 == 7)"),
    );
}
