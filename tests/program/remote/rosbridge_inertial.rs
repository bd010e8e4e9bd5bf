//! Tests of rosbridge's topics of inertial units, magnetometers, force sensors, batteries and barometers.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::{
    kit::{served_scene::ServedScene, *},
    remote::rosbridge::{receive_message, send_message, socket},
};

/// A tool that is attached to a wall by a force sensor, and further sensors on the wall.
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
fn inertial_and_force_readings_are_published_in_the_types_of_ros() {
    let place = TestFolder::scene(&scene());
    let file = place.path().join("scene.toml");
    let served = ServedScene::with("rosbridge", file.to_str().unwrap(), &["--realtime"]);
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
        send_message(&mut client, &json!({ "op": "subscribe", "topic": topic, "type": kind }));
    }
    send_message(&mut client, &json!({ "op": "call_service", "id": "start", "service": "/simulation/start" }));
    // Waits until each topic has been published ten times.
    let (mut last, mut counts) = (BTreeMap::new(), BTreeMap::new());
    while counts.len() < topics.len() || counts.values().any(|n| *n < 10) {
        let message = receive_message(&mut client);
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
    assert_eq!(last["/battery"]["capacity"], Value::Null, "the capacity is unknown");
    assert!((last["/fluid_pressure"]["fluid_pressure"].as_f64().unwrap() - (100_000.0 - 11.9)).abs() < 0.2);
    // The frame of the message is that of the sensor, which is rotated about the vertical.
    let frame = last["/imu"]["header"]["frame_id"].as_str().unwrap();
    let frames = last["/tf"]["transforms"].as_array().unwrap();
    let imu = frames.iter().find(|f| f["child_frame_id"] == frame).unwrap();
    near(&imu["transform"]["rotation"], &["x", "y", "z", "w"], &[0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()]);
}

/// A robot with a wheel, a slide and a mesh, and a noisy GPS receiver and inertial unit.
const ROBOT: &str = "[[object]]\nkind = \"shape\"\nalias = \"cart\"\nsize_m = [0.4, 0.3, 0.1]\nposition_m = [1.0, 2.0, 0.3]\n\
    model_base = true\ndynamic = true\nmass_kg = 3.0\ncolor = [1.0, 0.0, 0.0]\nrespondable = true\n\
    [[object]]\nkind = \"joint\"\nalias = \"axle\"\nparent = \"/cart\"\ntype = \"revolute\"\nposition_m = [0.1, 0.2, 0.0]\n\
    orientation_deg = [-90.0, 0.0, 0.0]\n\
    [[object]]\nkind = \"shape\"\nalias = \"wheel\"\nparent = \"/cart/axle\"\nprimitive = \"cylinder\"\n\
    size_m = [0.2, 0.2, 0.05]\ndynamic = true\nmass_kg = 0.5\n\
    [[object]]\nkind = \"dummy\"\nalias = \"base_link\"\nparent = \"/cart\"\n\
    [[object]]\nkind = \"joint\"\nalias = \"lift\"\nparent = \"/cart\"\ntype = \"prismatic\"\nlimits_m = [0.0, 0.25]\n\
    [[object]]\nkind = \"shape\"\nalias = \"plate\"\nparent = \"/cart/lift\"\nprimitive = \"sphere\"\n\
    size_m = [0.1, 0.1, 0.1]\nposition_m = [0.0, 0.0, 0.1]\ndynamic = true\nmass_kg = 0.25\n\
    [[object]]\nkind = \"sensor\"\nsensor = \"gps\"\nalias = \"gps\"\nparent = \"/cart\"\n\
    [object.noise.position]\nsigma = [[0.5], [0.5], [1.5]]\n\
    [[object]]\nkind = \"sensor\"\nsensor = \"imu\"\nalias = \"imu\"\nparent = \"/cart\"\n[object.noise.acceleration]\n\
    uniform = 0.3\n";

#[test]
fn robots_are_described_as_urdf_and_noise_as_covariance() {
    let place = TestFolder::scene(ROBOT);
    let file = place.path().join("scene.toml");
    let served = ServedScene::with("rosbridge", file.to_str().unwrap(), &["--realtime"]);
    let mut client = socket(&served);
    let topics = [
        ("/robot_description", "std_msgs/msg/String"),
        ("/fix", "sensor_msgs/msg/NavSatFix"),
        ("/imu", "sensor_msgs/msg/Imu"),
    ];
    for (topic, kind) in topics {
        send_message(&mut client, &json!({ "op": "subscribe", "topic": topic, "type": kind }));
    }
    send_message(&mut client, &json!({ "op": "call_service", "id": "start", "service": "/simulation/start" }));
    let ask = json!({ "op": "call_service", "id": "ask", "service": "/rosapi/get_param",
                      "args": { "name": "/robot_description", "default": "" } });
    send_message(&mut client, &ask);
    let (mut last, mut param) = (BTreeMap::new(), Value::Null);
    while last.len() < topics.len() || param.is_null() {
        let message = receive_message(&mut client);
        assert_ne!(message["op"], "status", "{message}");
        if message["op"] == "publish" {
            last.insert(message["topic"].as_str().unwrap().to_owned(), message["msg"].clone());
        } else if message["id"] == "ask" {
            param = message["values"]["value"].clone();
        }
    }
    let diagonal = |covariance: &Value, wanted: [f64; 3]| {
        let numbers: Vec<f64> = covariance.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let expected = [wanted[0], 0.0, 0.0, 0.0, wanted[1], 0.0, 0.0, 0.0, wanted[2]];
        assert!(numbers.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{covariance}");
    };
    diagonal(&last["/fix"]["position_covariance"], [0.25, 0.25, 2.25]);
    assert_eq!(last["/fix"]["position_covariance_type"], 2);
    diagonal(&last["/imu"]["linear_acceleration_covariance"], [0.03; 3]);
    diagonal(&last["/imu"]["angular_velocity_covariance"], [0.0; 3]);

    // The parameter and the topic have the same description, from which the URDF importer builds the same robot.
    let urdf = last["/robot_description"]["data"].as_str().unwrap();
    assert_eq!(serde_json::from_str::<String>(param.as_str().unwrap()).unwrap(), urdf);
    std::fs::write(place.path().join("cart.urdf"), urdf).unwrap();
    let scene = "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"probe\"\nscript = { text = \"\"\"\nfunction sysCall_init()\n\
        for _, path in ipairs({'axle', 'lift'}) do\n local j = nil\n for _, o in ipairs(tatu.list('joint')) do\n \
        if tatu.get(o, 'object.alias') == path then j = o end end\n \
        local p = sim.getObjectPosition(j, -1)\n local l = tatu.get(j, 'joint.limits')\n \
        print(string.format('%s %s %.3f %.3f %.3f %.2f', path, tatu.get(j, 'joint.type'), p[1], p[2], p[3], \
        tatu.get(j, 'joint.cyclic') and 9 or l[2]))\n end\n \
        local mass = 0\n for _, o in ipairs(tatu.list('shape')) do if tatu.get(o, 'shape.dynamic') then \
        mass = mass + tatu.get(o, 'shape.mass') end end\n \
        print(string.format('mass %.3f', mass))\nend\"\"\" }\n[[import]]\nfile = \"cart.urdf\"\n";
    std::fs::write(place.path().join("again.toml"), scene).unwrap();
    let run = ["run", "again.toml", "--seconds", "0.05"];
    let out =
        std::process::Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(place.path()).args(run).output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    for wanted in ["axle revolute 0.100 0.200 0.000 9.00", "lift prismatic 0.000 0.000 0.000 0.25", "mass 3.750"] {
        assert!(text.contains(wanted), "{wanted}: {text}\n{urdf}");
    }
}
