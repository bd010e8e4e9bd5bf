//! Translates the plugins of models that have a counterpart: drives and controllers of joints.

use tatu_importers_robots::{Element, FindingKind, Findings, MotorKind, Robot, is_true};
use tatu_plugin_api::safe::{Result, Value};

/// Plugins that need no counterpart: what they do is always done here, or is part of a window, or publishes what clients
/// can read of any object.
const SILENT: [&str; 24] = [
    "Physics",
    "SceneBroadcaster",
    "UserCommands",
    "Sensors",
    "Contact",
    "Imu",
    "AirPressure",
    "Altimeter",
    "Magnetometer",
    "NavSat",
    "ForceTorque",
    "LogicalCamera",
    "JointStatePublisher",
    "PosePublisher",
    "OdometryPublisher",
    "Label",
    "Altitude",
    "libgazebo_ros_joint_state_publisher",
    "libgazebo_ros_imu_sensor",
    "libgazebo_ros_ray_sensor",
    "libgazebo_ros_camera",
    "libgazebo_ros_p3d",
    "libgazebo_ros_factory",
    "libgazebo_ros_init",
];

/// A drive, as the property `object.drive` describes it. Joints are named.
#[derive(Debug, Clone, PartialEq)]
pub struct WheelDrive {
    pub kind: &'static str,
    /// Left and right alternate.
    pub joints: Vec<String>,
    pub steering: Vec<String>,
    pub radius: f64,
    pub track: f64,
    pub wheelbase: Option<f64>,
}

/// The name of a plugin without its namespace, or the library if it has none.
pub fn short_name(tag: &Element) -> &str {
    let name = tag.label();
    let name = name.rsplit("::").next().unwrap_or(name);
    let file = tag.attribute("filename").unwrap_or_default();
    let file = file.rsplit('/').next().unwrap_or(file);
    // Older plugins are named by their library.
    if file.starts_with("libgazebo_ros") || !tag.label().contains("::") {
        return file.strip_suffix(".so").unwrap_or(file);
    }
    name
}

/// Returns the texts of all children with one of these names.
fn texts<'e>(tag: &'e Element, names: &[&str]) -> Vec<&'e str> {
    let is_named = |c: &&Element| names.contains(&c.name.as_str());
    tag.children.iter().filter(is_named).map(|c| c.text.trim()).filter(|text| !text.is_empty()).collect()
}

/// Returns the first number that one of these children states.
fn number(tag: &Element, names: &[&str]) -> Result<Option<f64>> {
    names.iter().find_map(|name| tag.finite(name).transpose()).transpose()
}

/// Applies the plugins of a model to its joints. Returns the drive of the model, if it has one.
pub fn apply(plugins: &[&Element], robot: &mut Robot, findings: &Findings) -> Result<Option<WheelDrive>> {
    let mut drive = None;
    for tag in plugins {
        let name = short_name(tag);
        let own = match name.strip_prefix("gz-sim-").or(name.strip_prefix("ignition-gazebo-")) {
            // A plugin without a name is known by its library: gz-sim-diff-drive-system.
            Some(library) => &*camel_case(library.trim_end_matches("-system")),
            None => name,
        };
        if SILENT.contains(&own) || own == crate::propellers::PLUGIN {
            continue;
        }
        let found = match own {
            "DiffDrive" | "libgazebo_ros_diff_drive" | "libDiffDrivePlugin" => differential(tag)?,
            "AckermannSteering" => ackermann(tag)?,
            "MecanumDrive" => mecanum(tag)?,
            "JointController" | "JointPositionController" | "JointTrajectoryController" | "ApplyJointForce" => {
                control(tag, own, robot, findings)?;
                continue;
            }
            own if is_ros_control(own) => {
                robot.joints.iter_mut().for_each(|joint| joint.motor = MotorKind::ByType);
                let text = "the controllers of ROS are not read: joints hold positions, and continuous ones speeds";
                findings.note(FindingKind::Plugin, tag.line, text.to_owned());
                continue;
            }
            _ => {
                let shown = if tag.label().is_empty() { name } else { tag.label() };
                findings.warn(FindingKind::Plugin, tag.line, format!("the plugin `{shown}` is not run"));
                continue;
            }
        };
        let missing =
            found.joints.iter().chain(&found.steering).find(|name| !robot.joints.iter().any(|j| j.name == **name));
        if let Some(missing) = missing {
            let text = format!("the drive `{own}` is left out: there is no joint `{missing}`");
            findings.warn(FindingKind::Plugin, tag.line, text);
            continue;
        }
        if found.joints.is_empty() {
            findings.warn(FindingKind::Plugin, tag.line, format!("the drive `{own}` is left out: it names no joints"));
            continue;
        }
        for joint in &mut robot.joints {
            if found.joints.contains(&joint.name) {
                joint.motor = MotorKind::Velocity(0.0);
            } else if found.steering.contains(&joint.name) {
                joint.motor = MotorKind::Position(0.0);
            }
        }
        drive = Some(found);
    }
    Ok(drive)
}

/// Returns whether a plugin runs the controllers of ROS.
fn is_ros_control(name: &str) -> bool {
    let names = ["libgazebo_ros_control", "libgazebo_ros2_control", "gz_ros2_control", "ign_ros2_control"];
    names.iter().any(|n| name.contains(n))
        || name == "GazeboSimROS2ControlPlugin"
        || name == "IgnitionROS2ControlPlugin"
}

/// Converts `diff-drive` to `DiffDrive`.
fn camel_case(text: &str) -> String {
    let capital = |word: &str| {
        let mut chars = word.chars();
        chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
    };
    text.split('-').map(capital).collect()
}

/// Puts the joints of the left side and those of the right side in turn.
fn alternating(left: &[&str], right: &[&str]) -> Vec<String> {
    left.iter().zip(right).flat_map(|(l, r)| [(*l).to_owned(), (*r).to_owned()]).collect()
}

fn differential(tag: &Element) -> Result<WheelDrive> {
    let left = texts(tag, &["left_joint", "leftJoint"]);
    let right = texts(tag, &["right_joint", "rightJoint"]);
    let radius = match number(tag, &["wheel_diameter", "wheelDiameter"])? {
        Some(diameter) => diameter / 2.0,
        None => number(tag, &["wheel_radius"])?.unwrap_or(0.2),
    };
    let track = number(tag, &["wheel_separation", "wheelSeparation"])?.unwrap_or(1.0);
    let joints = alternating(&left, &right);
    Ok(WheelDrive { kind: "differential", joints, steering: Vec::new(), radius, track, wheelbase: None })
}

fn ackermann(tag: &Element) -> Result<WheelDrive> {
    let (left, right) = (texts(tag, &["left_joint"]), texts(tag, &["right_joint"]));
    let steering = alternating(&texts(tag, &["left_steering_joint"]), &texts(tag, &["right_steering_joint"]));
    Ok(WheelDrive {
        kind: "ackermann",
        joints: alternating(&left, &right),
        steering,
        radius: number(tag, &["wheel_radius"])?.unwrap_or(0.2),
        track: number(tag, &["wheel_separation"])?.unwrap_or(1.0),
        wheelbase: Some(number(tag, &["wheel_base"])?.unwrap_or(1.0)),
    })
}

fn mecanum(tag: &Element) -> Result<WheelDrive> {
    let names = ["front_left_joint", "front_right_joint", "back_left_joint", "back_right_joint"];
    let joints: Vec<String> = names.iter().filter_map(|name| tag.text_of(name)).map(str::to_owned).collect();
    Ok(WheelDrive {
        kind: "omni",
        joints: if joints.len() == names.len() { joints } else { Vec::new() },
        steering: Vec::new(),
        radius: number(tag, &["wheel_radius"])?.unwrap_or(0.2),
        track: number(tag, &["wheel_separation"])?.unwrap_or(1.0),
        wheelbase: Some(number(tag, &["wheelbase"])?.unwrap_or(1.0)),
    })
}

/// Applies a controller to its joints; one that names none controls all.
fn control(tag: &Element, name: &str, robot: &mut Robot, findings: &Findings) -> Result {
    let names = texts(tag, &["joint_name"]);
    for wanted in &names {
        if !robot.joints.iter().any(|joint| joint.name == *wanted) {
            let text = format!("the plugin `{name}` controls the joint `{wanted}`, which does not exist");
            findings.warn(FindingKind::Plugin, tag.line, text);
        }
    }
    let motor = match name {
        "JointController" if tag.text_of("use_force_commands").is_some_and(is_true) => MotorKind::Force,
        "JointController" => MotorKind::Velocity(number(tag, &["initial_velocity"])?.unwrap_or(0.0)),
        "ApplyJointForce" => MotorKind::Force,
        _ => MotorKind::Position(number(tag, &["initial_position"])?.unwrap_or(0.0)),
    };
    let is_meant = |joint: &str| names.is_empty() || names.contains(&joint);
    robot.joints.iter_mut().filter(|joint| is_meant(&joint.name)).for_each(|joint| joint.motor = motor);
    Ok(())
}

impl WheelDrive {
    /// Returns the value of the property `object.drive`. `path` returns the path of a joint, relative to the base; `axle`
    /// is the distance of the driven wheels ahead of the base.
    pub fn value(&self, path: impl Fn(&str) -> String, axle: f64) -> Value {
        let text = |text: &str| Value::text(text);
        let list = |names: &[String]| Value::List(names.iter().map(|name| text(&path(name))).collect());
        let mut keys = vec![
            (text("type"), text(self.kind)),
            (text("joints"), list(&self.joints)),
            (text("radius"), Value::Float(self.radius)),
            (text("track"), Value::Float(self.track)),
        ];
        if !self.steering.is_empty() {
            keys.push((text("steering"), list(&self.steering)));
        }
        keys.extend(self.wheelbase.map(|base| (text("wheelbase"), Value::Float(base))));
        if axle != 0.0 {
            keys.push((text("axle"), Value::Float(axle)));
        }
        Value::Map(keys)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml::parse;

    #[test]
    fn plugins_are_known_by_class_and_by_library() {
        for (text, name) in [
            ("<plugin filename='gz-sim-diff-drive-system' name='gz::sim::systems::DiffDrive'/>", "DiffDrive"),
            ("<plugin filename='libignition-gazebo-x.so' name='ignition::gazebo::systems::Physics'/>", "Physics"),
            ("<plugin filename='libgazebo_ros_diff_drive.so' name='d'/>", "libgazebo_ros_diff_drive"),
            ("<plugin filename='/a/libmine.so' name='mine'/>", "libmine"),
        ] {
            assert_eq!(short_name(&parse(text, 0).unwrap()), name);
        }
        assert_eq!(camel_case("joint-position-controller"), "JointPositionController");
    }

    #[test]
    fn a_classic_drive_states_a_diameter() {
        let tag = parse(
            "<p><left_joint>l</left_joint><right_joint>r</right_joint><wheel_diameter>.3</wheel_diameter></p>",
            0,
        );
        let drive = differential(&tag.unwrap()).unwrap();
        assert_eq!((drive.radius, drive.track, drive.joints.join(" ")), (0.15, 1.0, "l r".to_owned()));
    }
}
