//! Tests of contact sensors, force and torque sensors, and batteries against closed forms.

use serde_json::json;

use crate::kit::*;

fn sensor(kind: &str, parent: &str, keys: &str) -> String {
    format!("[[object]]\nkind = \"sensor\"\nalias = \"{kind}\"\nsensor = \"{kind}\"\nparent = \"{parent}\"\n{keys}\n")
}

fn vector<const N: usize>(line: &TraceLine, path: &str, field: &str) -> [f64; N] {
    let value = &line.0["readings"][path][field];
    numbers(value).try_into().unwrap_or_else(|v| panic!("{field}: {v:?} in {}", line.0["readings"]))
}

const BODY: &str = "dynamic = true\nrespondable = true\n";

#[test]
fn a_scale_measures_the_load_on_it() {
    let scale = cuboid("scale", [1.0, 1.0, 0.1], [0.0, 0.0, 0.05], "respondable = true");
    let load = cuboid("load", [0.1, 0.1, 0.2], [0.3, -0.2, 0.2], &format!("{BODY}mass_kg = 2.5"));
    let more = |alias: &str, keys: &str| {
        sensor("contact", "/scale", keys).replace("alias = \"contact\"", &format!("alias = \"{alias}\""))
    };
    let scene = format!(
        "{scale}{load}{}{}{}{}{}",
        sensor("contact", "/scale", ""),
        // The load is in the sector of `ahead` and in the region of `corner`, but not in the sector of `behind`.
        more("ahead", "sector_deg = 90.0"),
        more("behind", "sector_deg = 90.0\ndirection_deg = 180.0"),
        more("corner", "region_m = [0.2, -0.3, 0.0, 0.4, -0.1, 0.1]"),
        more("heavy", "threshold_n = 24.6"),
    );
    let paths = ["contact", "ahead", "behind", "corner", "heavy"].map(|a| format!("/scale/{a}"));
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    let line = TestFolder::scene(&scene).trace(&paths, &["--seconds", "3"]).pop().unwrap();
    let weight = 2.5 * 9.81;
    let [x, y, z] = vector(&line, "/scale/contact", "contact.force");
    assert!((z + weight).abs() < 1e-3 * weight && x.abs() < 1e-3 && y.abs() < 1e-3, "{x} {y} {z}");
    assert!((line.sensor("/scale/contact", "contact.normal_force") - weight).abs() < 1e-3 * weight);
    let [x, y, z] = vector(&line, "/scale/contact", "contact.point");
    assert!((x - 0.3).abs() < 1e-3 && (y + 0.2).abs() < 1e-3 && (z - 0.05).abs() < 1e-3, "{x} {y} {z}");
    for (path, touching) in [("contact", 1.0), ("ahead", 1.0), ("behind", 0.0), ("corner", 1.0), ("heavy", 0.0)] {
        assert_eq!(line.sensor(&format!("/scale/{path}"), "contact.touching"), touching, "{path}");
    }
    assert_eq!(line.sensor("/scale/behind", "contact.count"), 0.0);
    assert!(line.sensor("/scale/heavy", "contact.normal_force") > 24.0, "the force below the threshold is missing");
}

#[test]
fn a_box_that_slides_feels_friction_and_the_incline() {
    // On a slope of 30 degrees with a friction coefficient of 0.4 · 0.5 = 0.2, the box slides.
    let keys = "respondable = true\nfriction = 0.4\norientation_deg = [0.0, 30.0, 0.0]";
    let incline = cuboid("incline", [20.0, 2.0, 0.2], [0.0, 0.0, 0.0], keys);
    // The centre of the box is 0.2 m from the central plane of the incline.
    let at = [0.2 * 0.5 - 5.0 * 0.75_f64.sqrt(), 0.0, 0.2 * 0.75_f64.sqrt() + 5.0 * 0.5];
    let keys = format!("{BODY}mass_kg = 3.0\nfriction = 0.5\norientation_deg = [0.0, 30.0, 0.0]");
    let slider = cuboid("box", [0.4, 0.4, 0.2], at, &keys);
    let scene = format!("{incline}{slider}{}", sensor("contact", "/box", ""));
    let lines = TestFolder::scene(&scene).trace(&["/box/contact", "/box"], &["--seconds", "1"]);
    let normal = 3.0 * 9.81 * 0.75_f64.sqrt();
    for line in &lines[10..] {
        let [vx, _, _]: [f64; 3] = line.object("/box", "linear_velocity");
        assert!(vx > 0.5, "the box does not slide: {vx}");
        let [x, y, z] = vector(line, "/box/contact", "contact.force");
        // The force is given in the frame of the box, which slides along its +x axis.
        assert!((z - normal).abs() < 0.01 * normal, "normal {z}, not {normal}");
        assert!((x + 0.2 * normal).abs() < 0.01 * normal && y.abs() < 1e-3 * normal, "friction {x} {y}");
    }
}

#[test]
fn a_shape_elsewhere_can_be_felt() {
    let foot = cuboid("foot", [0.2; 3], [0.0, 0.0, 0.1], &format!("{BODY}mass_kg = 1.0"));
    let scene = format!("{FLOOR}{foot}{}", sensor("contact", "/foot", "shape = \"/floor\""));
    let line = TestFolder::scene(&scene).trace(&["/foot/contact"], &["--seconds", "2"]).pop().unwrap();
    let [_, _, z] = vector(&line, "/foot/contact", "contact.force");
    assert!((z + 9.81).abs() < 1e-2, "the force on the floor must point down: {z}");
    let place =
        TestFolder::scene(&format!("{FLOOR}{}", sensor("contact", "/floor", "shape = \"..\"\nthreshold_n = -1.0")));
    place.run(&["--steps", "1"]).refused(&["threshold_n"]);
    let other = sensor("imu", "/floor", "");
    let place = TestFolder::scene(&format!("{FLOOR}{other}{}", sensor("contact", "/floor", "shape = \"../imu\"")));
    place.run(&["--steps", "1"]).refused(&["`../imu` is not a shape"]);
}

#[test]
fn a_tool_at_an_arm_weighs_and_tilts() {
    // The arm holds the tool sideways. The sensor is rotated by 90 degrees about the axis of the arm.
    let arm = cuboid("arm", [0.2, 0.1, 0.1], [0.0, 0.0, 1.0], "");
    let wrist =
        "[[object]]\nkind = \"force_sensor\"\nalias = \"wrist\"\nparent = \"/arm\"\nposition_m = [0.1, 0.0, 0.0]\n";
    let keys = "parent = \"/arm/wrist\"\ndynamic = true\nmass_kg = 2.0";
    let tool = cuboid("tool", [0.6, 0.05, 0.05], [0.3, 0.0, 0.0], keys);
    let turned = sensor("force_torque", "/arm", "force_sensor = \"../wrist\"\norientation_deg = [90.0, 0.0, 0.0]")
        .replace("alias = \"force_torque\"", "alias = \"turned\"");
    let script = "function sysCall_init() wrist = sim.getObject('/arm/wrist') end
        function sysCall_sensing()
            local _, f, t = sim.readForceSensor(wrist)
            sim.addStatusbarMessage(string.format('%.17g %.17g', f[3], t[2]))
        end";
    let scene =
        format!("{arm}{wrist}{tool}{}{turned}{}", sensor("force_torque", "/arm/wrist", ""), watcher("reader", script));
    let paths = ["/arm/wrist/force_torque", "/arm/turned"];
    let line = TestFolder::scene(&scene).trace(&paths, &["--seconds", "1"]).pop().unwrap();
    let (weight, moment) = (2.0 * 9.81, 2.0 * 9.81 * 0.3);
    let near = |found: [f64; 3], wanted: [f64; 3]| {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}, not {wanted:?}");
    };
    near(vector(&line, paths[0], "wrench.force"), [0.0, 0.0, -weight]);
    near(vector(&line, paths[0], "wrench.torque"), [0.0, moment, 0.0]);
    // The +y axis of this sensor points up, and its origin is 0.1 m further from the tool.
    near(vector(&line, paths[1], "wrench.force"), [0.0, -weight, 0.0]);
    near(vector(&line, paths[1], "wrench.torque"), [0.0, 0.0, -2.0 * 9.81 * 0.4]);
    // The signs are the same as those of the readings of the force sensor object itself.
    let own: Vec<f64> = line.status()[0].split(' ').map(|x| x.parse().unwrap()).collect();
    assert!((own[0] + weight).abs() < 1e-4 && (own[1] - moment).abs() < 1e-4, "{own:?}");
}

#[test]
fn a_load_beyond_the_range_saturates() {
    let arm = cuboid("arm", [0.1; 3], [0.0, 0.0, 1.0], "");
    let wrist = "[[object]]\nkind = \"force_sensor\"\nalias = \"wrist\"\nparent = \"/arm\"\n";
    let tool = cuboid("tool", [0.1; 3], [0.0, 0.0, -0.2], "parent = \"/arm/wrist\"\ndynamic = true\nmass_kg = 40.0");
    let transducer = sensor("force_torque", "/arm/wrist", "preset = \"robotiq_ft300\"");
    let scene = format!("{arm}{wrist}{tool}{transducer}");
    let line = TestFolder::scene(&scene).trace(&["/arm/wrist/force_torque"], &["--seconds", "1"]).pop().unwrap();
    assert_eq!(line.0["readings"]["/arm/wrist/force_torque"]["wrench.force"][2], json!(-300.0));
}

#[test]
fn a_battery_is_drained_by_a_lift() {
    // The winch lifts 2 kg at 0.5 m/s with an efficiency of 0.5: 9.81 W / 0.5. The battery has two such motors.
    let stand = cuboid("stand", [0.1; 3], [0.0, 0.0, 0.0], "");
    let winch = "[[object]]\nkind = \"joint\"\nalias = \"winch\"\nparent = \"/stand\"\ntype = \"prismatic\"\n\
        control = \"velocity\"\ntarget_velocity_m_s = 0.5\nmax_force_n = 1000.0\n";
    let load = cuboid("load", [0.1; 3], [0.0, 0.0, 0.5], "parent = \"/stand/winch\"\ndynamic = true\nmass_kg = 2.0");
    let keys = "joint = \"../winch\"\nmotors = 2\ncapacity_ah = 0.02\nvoltages_v = [12.0]\nresistance_ohm = 0.5\n\
        idle_current_a = 0.25\nefficiency = 0.5\ncharge = 0.9";
    let scene = format!("{stand}{winch}{load}{}", sensor("battery", "/stand", keys));
    let lines = TestFolder::scene(&scene).trace(&["/stand/battery"], &["--seconds", "10"]);
    let of = |line: &TraceLine, field: &str| line.sensor("/stand/battery", &format!("battery.{field}"));
    // (12 - 0.5 (i + 0.25)) i = 2 · 9.81 / 0.5
    let left = 12.0 - 0.5 * 0.25;
    let current = 0.25 + (left - f64::sqrt(left * left - 4.0 * 0.5 * 39.24)) / (2.0 * 0.5);
    let first = &lines[5];
    for line in &lines[5..] {
        assert!((of(line, "current") - current).abs() < 1e-3 * current, "{} A, not {current}", of(line, "current"));
        assert!((of(line, "voltage") - (12.0 - 0.5 * current)).abs() < 2e-3, "{}", of(line, "voltage"));
        let wanted = of(first, "charge") - current * (line.time() - first.time()) / 72.0;
        assert!((of(line, "charge") - wanted).abs() < 1e-3 * (1.0 - wanted), "{} not {wanted}", of(line, "charge"));
    }
    assert!(of(first, "charge") < 0.9 && of(first, "charge") > 0.85);
}

#[test]
fn an_empty_battery_has_no_voltage_and_no_current() {
    let keys = "capacity_ah = 0.001\nvoltages_v = [3.0, 4.0]\nidle_current_a = 3.6";
    let scene = format!("{}{}", cuboid("lamp", [0.1; 3], [0.0; 3], ""), sensor("battery", "/lamp", keys));
    let lines = TestFolder::scene(&scene).trace(&["/lamp/battery"], &["--seconds", "2"]);
    // A charge of 3.6 C at 3.6 A lasts for one second.
    for line in &lines {
        let lasts = line.time() < 1.001;
        let [voltage, current, charge] =
            ["voltage", "current", "charge"].map(|f| line.sensor("/lamp/battery", &format!("battery.{f}")));
        assert_eq!((voltage > 0.0, current > 0.0, charge > 0.0), (lasts, lasts, lasts), "{} s", line.time());
    }
}

#[test]
fn a_battery_preserves_its_charge_when_its_load_changes_and_can_be_recharged() {
    let script = "function sysCall_init() battery, n = sim.getObject('/lamp/battery'), 0 end
        function sysCall_sensing()
            n = n + 1
            if n == 10 then tatu.set(battery, 'battery.idle_current', 1) end
            if n == 20 then tatu.set(battery, 'battery.charge', 0.75) end
        end";
    let keys = "capacity_ah = 0.01\nidle_current_a = 3.0";
    let scene = format!(
        "{}{}{}",
        cuboid("lamp", [0.1; 3], [0.0; 3], ""),
        sensor("battery", "/lamp", keys),
        watcher("w", script)
    );
    let lines = TestFolder::scene(&scene).trace(&["/lamp/battery"], &["--steps", "25"]);
    let charge = |step: usize| lines[step - 1].sensor("/lamp/battery", "battery.charge");
    // The charge of 36 C is discharged with 3 A for 50 ms, and then with 1 A. The current of a physics step flows from
    // the middle of that step to the middle of the next.
    let of_current = |current: f64| current * 0.05 / 36.0;
    assert!((charge(10) - charge(9) + of_current(3.0)).abs() < 1e-12);
    let change = charge(11) - charge(10);
    assert!(change < -of_current(1.0) && change > -of_current(3.0), "{change}");
    assert!((charge(12) - charge(11) + of_current(1.0)).abs() < 1e-12);
    assert!((charge(21) - 0.75).abs() < 2.0 * of_current(1.0), "{}", charge(21));
}

#[test]
fn a_sensor_whose_object_is_removed_is_switched_off_and_named() {
    let pad = cuboid("pad", [0.2; 3], [1.0, 0.0, 0.1], "dynamic = true\nrespondable = true\nmass_kg = 1.0");
    let body = cuboid("box", [0.2; 3], [0.0, 0.0, 0.1], "dynamic = true\nrespondable = true\nmass_kg = 5.0");
    let script = "function sysCall_actuation()
            n = (n or 0) + 1
            if n == 5 then sim.removeObject(sim.getObject('/pad')) end
        end";
    let feeler = sensor("contact", "/box", "shape = \"/pad\"");
    let place = TestFolder::scene(&format!("{FLOOR}{pad}{body}{feeler}{}", watcher("remover", script)));
    let done = place.run(&["--steps", "10", "--trace", "t.jsonl", "--watch", "/box/contact"]);
    done.reports(&["/box/contact", "the object that it measures does not exist, or has been removed"]);
    assert_eq!(done.err.matches("the object that it measures").count(), 1, "{}", done.err);
    let forces: Vec<f64> =
        place.lines("t.jsonl").iter().map(|line| line.sensor("/box/contact", "contact.normal_force")).collect();
    assert!((forces[2] - 9.81).abs() < 0.1, "{forces:?}");
    // After the removal, the sensor does not measure the force of the box, which is five times as high.
    assert!(forces[4..].iter().all(|f| *f == 0.0), "{forces:?}");
}

#[test]
fn noise_of_a_field_that_is_called_like_its_schema() {
    let barometer = sensor("barometer", "/box", "noise = { pressure = { sigma = 30.0 } }");
    let scene = format!("{}{barometer}", cuboid("box", [0.2; 3], [0.0, 0.0, 0.1], "dynamic = true"));
    let lines = TestFolder::scene(&scene).trace(&["/box/barometer"], &["--steps", "3"]);
    let values: Vec<f64> = lines.iter().map(|line| line.sensor("/box/barometer", "pressure.pressure")).collect();
    assert!(values.windows(2).all(|v| (v[0] - v[1]).abs() > 0.5), "{values:?}");
}
