//! The topics that a scene provides. The last part of a name describes the content of the topic; the parts before it
//! are the names of the robot and the sensor.

use std::collections::BTreeMap;

use tatu_plugin_api::{abi::tatu_object, safe::Turn};

use crate::{Props, felt::Felt, robots::Scene};

/// The content of a topic. The numbers in variants are indices in `Scene::robots` or `Scene::sensors`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The simulation time.
    Clock,
    /// All coordinate frames.
    Frames,
    /// The coordinate frames that do not move relative to their parent frame.
    StaticFrames,
    /// The wheel odometry of a robot.
    Odometry(usize),
    /// The true pose of a robot in the world frame.
    Pose(usize),
    /// The joint states of a robot.
    Joints(usize),
    /// The URDF description of a robot.
    Description(usize),
    /// The velocity commands for a robot, which clients publish.
    Command(usize),
    /// A planar scan of distances.
    Scan(usize),
    /// The distance measured by a proximity sensor.
    Range(usize),
    /// A position on Earth: latitude, longitude and altitude.
    Fix(usize),
    /// The colour image of a camera.
    Image(usize),
    /// The depth image of a camera.
    Depth(usize),
    /// The intrinsics of a camera.
    Optics(usize),
    /// The points of a depth camera, or of a scanner with layers.
    Points(usize),
    /// A reading with few components, such as that of an IMU.
    Felt(usize, Felt),
}

/// A topic that the scene provides.
#[derive(Debug, Clone)]
pub struct Topic {
    /// The content of the topic.
    pub what: What,
    /// The type of its messages, by its name in ROS 1.
    pub kind: &'static str,
}

/// Returns the topics of a scene by name. A topic also has shorter names if these are unambiguous.
pub fn of(turn: &Turn<'_>, p: &Props, scene: &Scene) -> BTreeMap<String, Topic> {
    let mut out = BTreeMap::new();
    out.insert("/clock".to_owned(), Topic { what: What::Clock, kind: "rosgraph_msgs/Clock" });
    out.insert("/tf".to_owned(), Topic { what: What::Frames, kind: "tf2_msgs/TFMessage" });
    out.insert("/tf_static".to_owned(), Topic { what: What::StaticFrames, kind: "tf2_msgs/TFMessage" });
    // For each topic: the robot, the name of the sensor, and the last part of the topic's name.
    let mut all: Vec<(Option<usize>, String, &str, Topic)> = Vec::new();
    for (i, robot) in scene.robots.iter().enumerate() {
        let mut add = |last, what, kind| all.push((Some(i), String::new(), last, Topic { what, kind }));
        add("pose", What::Pose(i), "geometry_msgs/PoseStamped");
        add("robot_description", What::Description(i), "std_msgs/String");
        if !robot.joints.is_empty() {
            add("joint_states", What::Joints(i), "sensor_msgs/JointState");
        }
        if robot.train.is_some() {
            add("odom", What::Odometry(i), "nav_msgs/Odometry");
            add("cmd_vel", What::Command(i), "geometry_msgs/Twist");
        }
    }
    for (i, sensor) in scene.sensors.iter().enumerate() {
        for (last, what, kind) in what_of(turn, p, i, sensor.id) {
            all.push((sensor.robot, sensor.name.clone(), last, Topic { what, kind }));
        }
    }
    let count = |robot: Option<usize>, last: &str, everywhere: bool| {
        all.iter().filter(|(r, _, l, _)| *l == last && (everywhere || *r == robot)).count()
    };
    for (robot, sensor, last, topic) in &all {
        let above = robot.and_then(|r| scene.robots.get(r)).map_or(String::new(), |r| format!("/{}", r.name));
        let own = if sensor.is_empty() { String::new() } else { format!("/{sensor}") };
        out.insert(format!("{above}{own}/{last}"), topic.clone());
        if count(*robot, last, false) == 1 && robot.is_some() {
            out.insert(format!("{above}/{last}"), topic.clone());
        }
        if count(None, last, true) == 1 {
            out.insert(format!("/{last}"), topic.clone());
        }
    }
    out
}

/// Returns the topics of a sensor, which depend on the fields of its readings: the last part of the name, the content,
/// and the message type.
fn what_of(turn: &Turn<'_>, p: &Props, i: usize, id: tatu_object) -> Vec<(&'static str, What, &'static str)> {
    let has = |prop| turn.reading(id, prop).is_ok();
    let mut out = Vec::new();
    if has(p.scan_distance) {
        let layers = turn.reading(id, p.scan_elevation).is_ok_and(|r| r.f64s().iter().any(|e| *e != 0.0));
        match layers {
            true => out.push(("points", What::Points(i), "sensor_msgs/PointCloud2")),
            false => out.push(("scan", What::Scan(i), "sensor_msgs/LaserScan")),
        }
    }
    if has(p.detected) {
        out.push(("range", What::Range(i), "sensor_msgs/Range"));
    }
    if has(p.latitude) {
        out.push(("fix", What::Fix(i), "sensor_msgs/NavSatFix"));
    }
    if has(p.rgb) {
        out.push(("image", What::Image(i), "sensor_msgs/Image"));
    }
    if has(p.depth) {
        out.push(("depth", What::Depth(i), "sensor_msgs/Image"));
        out.push(("points", What::Points(i), "sensor_msgs/PointCloud2"));
    }
    if has(p.intrinsics) {
        out.push(("camera_info", What::Optics(i), "sensor_msgs/CameraInfo"));
    }
    for felt in Felt::ALL.into_iter().filter(|f| has(f.field(p))) {
        let (last, kind) = felt.topic();
        out.push((last, What::Felt(i, felt), kind));
    }
    out
}
