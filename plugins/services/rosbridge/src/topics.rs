//! The topics that a scene provides. The last part of a name describes the content of the topic; the parts before it
//! are the names of the robot and the sensor.

use std::{borrow::Cow, collections::BTreeMap};

use tatu_plugin_api::{abi::tatu_object, safe::Turn};

use crate::{Props, declared_messages::DeclaredMessage, robots::RobotScene, simple_readings::SimpleReading};

/// The content of a topic. The numbers in variants are indices in `RobotScene::robots` or `RobotScene::sensors`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TopicContent {
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
    /// Trajectories for the joints of a robot, which clients publish.
    JointTrajectory(usize),
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
    CameraInfo(usize),
    /// The points of a depth camera, or of a scanner with layers.
    Points(usize),
    /// A reading with few components, such as that of an IMU.
    Simple(usize, SimpleReading),
    /// A message that the plugin of a sensor builds.
    Declared(usize),
}

/// A topic that the scene provides.
#[derive(Debug, Clone)]
pub struct SceneTopic {
    /// The content of the topic.
    pub content: TopicContent,
    /// The type of its messages, by its name in ROS 1.
    pub kind: Cow<'static, str>,
}

/// Returns the topics of a scene by name. A topic also has shorter names if these are unambiguous.
pub fn scene_topics(turn: &Turn<'_>, p: &Props, scene: &RobotScene) -> BTreeMap<String, SceneTopic> {
    let mut out = BTreeMap::new();
    out.insert("/clock".to_owned(), SceneTopic { content: TopicContent::Clock, kind: "rosgraph_msgs/Clock".into() });
    out.insert("/tf".to_owned(), SceneTopic { content: TopicContent::Frames, kind: "tf2_msgs/TFMessage".into() });
    out.insert(
        "/tf_static".to_owned(),
        SceneTopic { content: TopicContent::StaticFrames, kind: "tf2_msgs/TFMessage".into() },
    );
    // For each topic: the robot, the name of the sensor, and the last part of the topic's name.
    let mut all: Vec<(Option<usize>, String, Cow<'static, str>, SceneTopic)> = Vec::new();
    for (i, robot) in scene.robots.iter().enumerate() {
        let mut add = |last: &'static str, content, kind: &'static str| {
            all.push((Some(i), String::new(), last.into(), SceneTopic { content, kind: kind.into() }));
        };
        add("pose", TopicContent::Pose(i), "geometry_msgs/PoseStamped");
        add("robot_description", TopicContent::Description(i), "std_msgs/String");
        if !robot.joints.is_empty() {
            add("joint_states", TopicContent::Joints(i), "sensor_msgs/JointState");
            add("joint_trajectory", TopicContent::JointTrajectory(i), "trajectory_msgs/JointTrajectory");
        }
        if robot.drivetrain.is_some() {
            add("odom", TopicContent::Odometry(i), "nav_msgs/Odometry");
            add("cmd_vel", TopicContent::Command(i), "geometry_msgs/Twist");
        }
    }
    for (i, sensor) in scene.sensors.iter().enumerate() {
        for (last, what, kind) in sensor_topics(turn, p, i, sensor.id) {
            all.push((sensor.robot, sensor.name.clone(), last.into(), SceneTopic { content: what, kind: kind.into() }));
        }
        if let Some((last, kind)) = DeclaredMessage::topic(turn, p, sensor.id) {
            let topic = SceneTopic { content: TopicContent::Declared(i), kind: kind.into() };
            all.push((sensor.robot, sensor.name.clone(), last.into(), topic));
        }
    }
    let count = |robot: Option<usize>, last: &str, everywhere: bool| {
        all.iter().filter(|(r, _, l, _)| l == last && (everywhere || *r == robot)).count()
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
fn sensor_topics(
    turn: &Turn<'_>,
    p: &Props,
    i: usize,
    id: tatu_object,
) -> Vec<(&'static str, TopicContent, &'static str)> {
    let has = |prop| turn.reading(id, prop).is_ok();
    let mut out = Vec::new();
    if has(p.scan_distance) {
        let layers = turn.reading(id, p.scan_elevation).is_ok_and(|r| r.f64s().iter().any(|e| *e != 0.0));
        match layers {
            true => out.push(("points", TopicContent::Points(i), "sensor_msgs/PointCloud2")),
            false => out.push(("scan", TopicContent::Scan(i), "sensor_msgs/LaserScan")),
        }
    }
    if has(p.detected) {
        out.push(("range", TopicContent::Range(i), "sensor_msgs/Range"));
    }
    if has(p.latitude) {
        out.push(("fix", TopicContent::Fix(i), "sensor_msgs/NavSatFix"));
    }
    if has(p.rgb) {
        out.push(("image", TopicContent::Image(i), "sensor_msgs/Image"));
    }
    if has(p.depth) {
        out.push(("depth", TopicContent::Depth(i), "sensor_msgs/Image"));
        out.push(("points", TopicContent::Points(i), "sensor_msgs/PointCloud2"));
    }
    if has(p.intrinsics) {
        out.push(("camera_info", TopicContent::CameraInfo(i), "sensor_msgs/CameraInfo"));
    }
    for felt in SimpleReading::ALL.into_iter().filter(|f| has(f.field(p))) {
        let (last, kind) = felt.topic();
        out.push((last, TopicContent::Simple(i, felt), kind));
    }
    out
}
