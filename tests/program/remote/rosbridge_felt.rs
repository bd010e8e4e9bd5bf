//! Tests of rosbridge's topics of inertial units, magnetometers, force sensors, batteries and barometers.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::{
    kit::{served::Served, *},
    remote::rosbridge::{hear, say, socket},
};

/// A tool that hangs at a wall by a force sensor, and what is on the wall.
fn scene() -> String {
    let sensor = |kind: &str, parent: &str, keys: &str| {
        format!(
            "[[object]]\nkind = \"sensor\"\nalias = \"{kind}\"\nsensor = \"{kind}\"\nparent = \"{parent}\"\n{keys}\n"
        )
    };
    let wall = cuboid("wall", [0.1, 1.0, 1.0], [0.0, 0.0, 1.0], "");
    let wrist =
        "[[object]]\nkind = \"force_sensor\"\nalias = \"wrist\"\nparent = \"/wall\"\nposition_m = [0.1, 0.0, 0.0]\n";
    let tool = cuboid("tool", [0.2; 3], [0.1, 0.0, 0.0], "parent = \"/wall/wrist\"\ndynamic = true\nmass_kg = 2.0");
    [
        wall,
        wrist.to_owned(),
        tool,
        sensor("force_torque", "/wall/wrist", ""),
        sensor("imu", "/wall/wrist/tool", "position_m = [0.0, 0.5, 0.0]\norientation_deg = [0.0, 0.0, 90.0]"),
        sensor("compass", "/wall", "strength_t = 4e-5\ninclination_deg = 0.0"),
        sensor("battery", "/wall", "voltages_v = [12.0]\nresistance_ohm = 0.5\nidle_current_a = 2.0\ncharge = 0.5"),
        sensor("barometer", "/wall", "sea_level_pressure_pa = 100000.0"),
    ]
    .concat()
}

fn near(found: &Value, keys: &[&str], wanted: &[f64]) {
    for (key, wanted) in keys.iter().zip(wanted) {
        let x = found[*key].as_f64().unwrap_or_else(|| panic!("{key} of {found}"));
        assert!((x - wanted).abs() < 1e-3 * (1.0 + wanted.abs()), "{key} of {found}, not {wanted}");
    }
}

const XYZ: &[&str] = &["x", "y", "z"];

#[test]
fn what_is_felt_is_published_in_the_types_of_ros() {
    let place = Place::scene(&scene());
    let file = place.path().join("scene.toml");
    let served = Served::with("rosbridge", file.to_str().unwrap(), &["--realtime"]);
    let mut client = socket(&served);
    let topics = [
        ("/imu", "sensor_msgs/msg/Imu"),
        ("/magnetic_field", "sensor_msgs/msg/MagneticField"),
        ("/wrench", "geometry_msgs/msg/WrenchStamped"),
        ("/battery", "sensor_msgs/msg/BatteryState"),
        ("/fluid_pressure", "sensor_msgs/msg/FluidPressure"),
        ("/tf", "tf2_msgs/msg/TFMessage"),
    ];
    for (topic, kind) in topics {
        say(&mut client, &json!({ "op": "subscribe", "topic": topic, "type": kind }));
    }
    say(&mut client, &json!({ "op": "call_service", "id": "start", "service": "/simulation/start" }));
    // Some time has passed when each has told something ten times.
    let (mut last, mut counts) = (BTreeMap::new(), BTreeMap::new());
    while counts.len() < topics.len() || counts.values().any(|n| *n < 10) {
        let message = hear(&mut client);
        assert_ne!(message["op"], "status", "{message}");
        if message["op"] == "publish" {
            let topic = message["topic"].as_str().unwrap().to_owned();
            *counts.entry(topic.clone()).or_insert(0) += 1;
            last.insert(topic, message["msg"].clone());
        }
    }
    near(&last["/imu"]["linear_acceleration"], XYZ, &[0.0, 0.0, 9.81]);
    near(&last["/imu"]["angular_velocity"], XYZ, &[0.0; 3]);
    near(&last["/imu"]["orientation"], &["z", "w"], &[0.5_f64.sqrt(), 0.5_f64.sqrt()]);
    assert!((last["/magnetic_field"]["magnetic_field"]["y"].as_f64().unwrap() - 4e-5).abs() < 1e-9);
    near(&last["/wrench"]["wrench"]["force"], XYZ, &[0.0, 0.0, -19.62]);
    near(&last["/wrench"]["wrench"]["torque"], XYZ, &[0.0, 1.962, 0.0]);
    near(&last["/battery"], &["voltage", "current", "power_supply_status"], &[11.0, -2.0, 2.0]);
    assert!((last["/battery"]["percentage"].as_f64().unwrap() - 0.5).abs() < 1e-2);
    assert_eq!(last["/battery"]["capacity"], Value::Null, "not known");
    assert!((last["/fluid_pressure"]["fluid_pressure"].as_f64().unwrap() - (100_000.0 - 11.9)).abs() < 0.2);
    // Its frame is the sensor's own, turned about the vertical.
    let frame = last["/imu"]["header"]["frame_id"].as_str().unwrap();
    let frames = last["/tf"]["transforms"].as_array().unwrap();
    let imu = frames.iter().find(|f| f["child_frame_id"] == frame).unwrap();
    near(&imu["transform"]["rotation"], &["x", "y", "z", "w"], &[0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()]);
}
