//! Tests that sensors do not affect the simulation: a world with sensors is bit-identical to one without.

use crate::kit::*;

/// Returns a Pioneer that avoids obstacles by its sonars and by random numbers, among boxes that it pushes.
fn scene() -> String {
    let script = "
        function sysCall_init()
            left, right = sim.getObjectHandle('Pioneer_p3dx_leftMotor'), sim.getObjectHandle('Pioneer_p3dx_rightMotor')
            sonar = sim.getObjectHandle('Pioneer_p3dx_ultrasonicSensor5')
        end
        function sysCall_actuation()
            local seen, d = sim.readProximitySensor(sonar)
            sim.setJointTargetVelocity(left, 2 + math.random())
            sim.setJointTargetVelocity(right, seen > 0 and d or 2)
        end";
    let boxes = [
        cuboid("wall", [0.1, 4.0, 0.5], [1.0, 0.0, 0.25], "respondable = true"),
        cuboid("crate", [0.2, 0.2, 0.2], [0.5, 0.1, 0.1], "respondable = true\ndynamic = true\nmass_kg = 1.0"),
    ];
    format!("seed = 3\n{FLOOR}{}{}", boxes.concat(), pioneer(script, ""))
}

fn sensor(kind: &str, more: &str) -> String {
    format!(
        "[[object]]\nkind = \"sensor\"\nsensor = \"{kind}\"\nalias = \"added_{kind}\"\nparent = \"/Pioneer_p3dx\"\n\
         position_m = [0.1, 0.0, 0.2]\norientation_deg = [0.0, 90.0, 0.0]\n{more}\n"
    )
}

/// Runs a scene and returns the lines of its trace with the hashes of all objects.
fn ran(text: &str, threads: &str) -> Vec<TraceLine> {
    TestFolder::scene(text).trace(&[], &["--seconds", "4", "--hashes", "--threads", threads])
}

#[test]
fn a_world_with_sensors_added_has_the_same_hash() {
    let plain = ran(&scene(), "1");
    assert_eq!(plain.len(), 80);
    assert!(plain.windows(2).all(|w| w[0].hash() != w[1].hash()), "the robot does not move");
    let added = [
        sensor("proximity", "volume = \"cone\"\nrange_m = 2.0"),
        sensor("laser", "preset = \"hokuyo_urg_04lx\""),
        sensor("gps", "preset = \"ublox_m8\""),
    ];
    for threads in ["1", "2"] {
        let watched = ran(&format!("{}{}", scene(), added.concat()), threads);
        for (a, b) in plain.iter().zip(&watched) {
            assert_eq!(a.hash(), b.hash(), "with {threads} threads, at {} s", a.time());
        }
    }
}

#[test]
fn a_world_with_devices_added_has_the_same_objects_beside_them() {
    // Devices contain objects, which have their own entries in the hashes.
    let plain = ran(&scene(), "1");
    let models = ["laser_scanner_2d", "hokuyo", "gps"]
        .map(|m| format!("[[model]]\nmodel = \"{m}\"\nparent = \"/Pioneer_p3dx\"\nposition_m = [0.1, 0.0, 0.15]\n"));
    let with = ran(&format!("{}{}", scene(), models.concat()), "2");
    for (a, b) in plain.iter().zip(&with) {
        let (all, more) = (a.0["hashes"].as_object().unwrap(), b.0["hashes"].as_object().unwrap());
        assert!(all.len() > 10 && more.len() == all.len() + 8, "{} and {} objects", all.len(), more.len());
        for (path, hash) in all {
            assert_eq!(*hash, more[path], "{path} at {} s", a.time());
        }
    }
}
