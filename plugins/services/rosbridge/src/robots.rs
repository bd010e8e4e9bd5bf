//! Finds the robots and sensors of a scene, assigns names that are valid in ROS, and computes wheel odometry.

use std::collections::BTreeMap;

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};
use tatu_robots_drivetrain::{Drivetrain, WheelState};

use crate::{
    Props,
    poses::{Pose, planar},
    simple_readings::SimpleReading,
};

/// A robot: an object with a drivetrain, or the base of a model with sensors or joints below it.
pub struct Robot {
    /// The id of the base object.
    pub base: tatu_object,
    /// Name of the robot, unique within the scene.
    pub name: String,
    /// Prefix of the robot's frames; empty if it is the only robot.
    pub prefix: String,
    /// The drivetrain, if the robot declares one.
    pub drivetrain: Option<Drivetrain>,
    /// Joints of the robot and their names, without spherical joints.
    pub joints: Vec<(tatu_object, String)>,
    /// The state of the wheel odometry.
    pub odometry: Odometry,
    /// Simulation time at which the last velocity command expires, s; `None` if the robot need not be stopped.
    pub command_expiry: Option<f64>,
}

/// The pose of a robot relative to its start, and its velocity, computed from the motion of its wheels. The pose drifts
/// from the true one.
#[derive(Debug, Clone, Default)]
pub struct Odometry {
    /// Position of the middle of the axle ahead and to the left of its start, m, and heading, rad.
    pub place: [f64; 3],
    /// Velocity ahead and to the left, m/s, and angular velocity, rad/s.
    pub velocity: [f64; 3],
    /// The last state of the joints, and its simulation time, s.
    previous: Option<(f64, WheelState)>,
}

impl Odometry {
    /// Updates the odometry from the current state of the joints.
    pub fn update(&mut self, train: &Drivetrain, time: f64, now: WheelState) {
        if let Some((then, before)) = &self.previous
            && time > *then
        {
            let [dx, dy, turn] = train.motion(&now.turns_since(before, time - then), &now.steered);
            // The arc is approximated by a straight line of the same length in the direction of its chord.
            let heading = self.place[2] + turn / 2.0;
            let (s, c) = libm::sincos(heading);
            self.place[0] += c * dx - s * dy;
            self.place[1] += s * dx + c * dy;
            self.place[2] += turn;
            self.velocity = [dx, dy, turn].map(|x| x / (time - then));
        }
        self.previous = Some((time, now));
    }

    /// Returns the planar odometry pose: that of the axle's midpoint, relative to where it started.
    pub fn pose(&self) -> Pose {
        let [x, y, heading] = self.place;
        planar(x, y, heading)
    }
}

/// A sensor of the scene.
pub struct SceneSensor {
    /// The object id of the sensor.
    pub id: tatu_object,
    /// Name of the sensor, unique within its robot.
    pub name: String,
    /// The name of the sensor's frame.
    pub frame: String,
    /// Index of the sensor's robot in `RobotScene::robots`, if it belongs to one.
    pub robot: Option<usize>,
    /// Whether the sensor is rigidly attached to its robot's base, or to the world.
    pub fixed: bool,
    /// The axes of the published frame.
    pub axes: FrameAxes,
}

/// The axes of the frame that is published for a sensor. In the sensor's own frame, +z points ahead and +y points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameAxes {
    /// x points ahead, and z up.
    Ahead,
    /// The optical frame of a camera: z points ahead, and y down.
    Optical,
    /// The sensor's own frame, for sensors without a viewing direction.
    Own,
}

/// The robots and sensors of a scene.
#[derive(Default)]
pub struct RobotScene {
    /// The ids of all objects when the scene was read. They are compared with the current ones to detect objects that
    /// were added or removed.
    pub ids: Vec<tatu_object>,
    /// The robots, in the order of their base objects in the scene.
    pub robots: Vec<Robot>,
    /// The sensors, including those that do not belong to a robot.
    pub sensors: Vec<SceneSensor>,
}

/// Converts a name to one that is valid in ROS: characters other than ASCII letters and digits become `_`, and `o` is
/// prepended if the result does not begin with a letter.
pub fn ros_name(name: &str) -> String {
    let mut out: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !out.starts_with(|c: char| c.is_ascii_alphabetic()) {
        out.insert(0, 'o');
    }
    out
}

impl Robot {
    /// Returns the pose of `base_link` in the frame of the base object. Its origin is the middle of the driven axle,
    /// about which the robot rotates, if the robot has a drivetrain.
    pub fn base_link_pose(&self) -> Pose {
        let ahead = self.drivetrain.as_ref().map_or(0.0, |train| train.axle);
        [ahead, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    }
}

impl RobotScene {
    /// Finds the robots and sensors among the objects `ids`. Robots that exist in `before` with the same drivetrain
    /// keep their odometry and the expiry time of their velocity command.
    pub fn read(turn: &Turn<'_>, p: &Props, ids: Vec<tatu_object>, before: RobotScene) -> Result<RobotScene> {
        let mut scene = RobotScene { ids, ..Default::default() };
        // Names are aliases, or unique names if several joints and sensors of a robot have the same alias.
        let of = |id, prop| -> Result<String> {
            Ok(ros_name(&turn.get(id, prop)?.as_str().map(|s| s.into_owned()).unwrap_or_default()))
        };
        let mut named: BTreeMap<(Option<usize>, String), u32> = BTreeMap::new();
        for &id in &scene.ids {
            let drive = !turn.get(id, p.wheels.drive)?.is_empty();
            let above = robot_of(turn, p, &scene.robots, id)?;
            if !drive && (above.is_some() || !turn.get(id, p.model_base)?.truthy()) {
                continue;
            }
            // If a joint of the drivetrain is missing, the robot is treated as one without a drivetrain.
            let train = if drive { Drivetrain::of(turn, &p.wheels, id).unwrap_or(None) } else { None };
            scene.robots.push(Robot {
                base: id,
                name: of(id, p.alias)?,
                prefix: String::new(),
                drivetrain: train,
                joints: Vec::new(),
                odometry: Odometry::default(),
                command_expiry: None,
            });
        }
        let mut has = vec![false; scene.robots.len()];
        for &id in &scene.ids {
            let kind = turn.look(id)?.kind;
            if kind != TATU_KIND_JOINT && kind != TATU_KIND_SENSOR {
                continue;
            }
            let robot = robot_of(turn, p, &scene.robots, id)?;
            if let Some(r) = robot {
                has[r] = true;
            }
            if kind == TATU_KIND_SENSOR {
                let axes = if turn.reading(id, p.depth).is_ok() {
                    FrameAxes::Optical
                } else if SimpleReading::ALL.iter().any(|f| turn.reading(id, f.field(p)).is_ok()) {
                    FrameAxes::Own
                } else {
                    FrameAxes::Ahead
                };
                let name = of(id, p.alias)?;
                *named.entry((robot, name.clone())).or_default() += 1;
                let fixed = is_fixed(turn, p, &scene.robots, id)?;
                scene.sensors.push(SceneSensor { id, name, frame: String::new(), robot, fixed, axes });
            } else if let Some(r) = robot
                && turn.get(id, p.joint_type)?.as_str().as_deref() != Some("spherical")
            {
                let name = of(id, p.alias)?;
                *named.entry((robot, name.clone())).or_default() += 1;
                scene.robots[r].joints.push((id, name));
            }
        }
        let several = |robot: Option<usize>, name: &str| named.get(&(robot, name.to_owned())).is_some_and(|n| *n > 1);
        for sensor in scene.sensors.iter_mut().filter(|s| several(s.robot, &s.name)) {
            sensor.name = of(sensor.id, p.name)?;
        }
        for (r, robot) in scene.robots.iter_mut().enumerate() {
            for (id, name) in robot.joints.iter_mut().filter(|(_, name)| several(Some(r), name)) {
                *name = of(*id, p.name)?;
            }
        }
        // Candidates that have neither a drivetrain nor joints nor sensors are not robots.
        let mut places = Vec::new();
        let mut kept = Vec::new();
        for (robot, has) in scene.robots.into_iter().zip(has) {
            places.push((has || robot.drivetrain.is_some()).then_some(kept.len()));
            if places.last().is_some_and(Option::is_some) {
                kept.push(robot);
            }
        }
        scene.robots = kept;
        for sensor in &mut scene.sensors {
            sensor.robot = sensor.robot.and_then(|r| places[r]);
        }
        let aliases: Vec<String> = scene.robots.iter().map(|r| r.name.clone()).collect();
        for robot in &mut scene.robots {
            if aliases.iter().filter(|a| **a == robot.name).count() > 1 {
                robot.name = of(robot.base, p.name)?;
            }
        }
        let alone = scene.robots.len() == 1;
        for robot in &mut scene.robots {
            robot.prefix = if alone { String::new() } else { format!("{}/", robot.name) };
            if let Some(known) = before.robots.iter().find(|b| b.base == robot.base && b.drivetrain == robot.drivetrain)
            {
                (robot.odometry, robot.command_expiry) = (known.odometry.clone(), known.command_expiry);
            }
        }
        for sensor in &mut scene.sensors {
            let robot = sensor.robot.and_then(|r| scene.robots.get(r));
            sensor.frame = format!("{}{}", robot.map_or("", |r| &r.prefix), sensor.name);
        }
        Ok(scene)
    }
}

/// Returns whether an object is rigidly attached to the base of its robot, or to the world: there is neither a joint
/// nor a dynamic shape between them.
fn is_fixed(turn: &Turn<'_>, p: &Props, robots: &[Robot], of: tatu_object) -> Result<bool> {
    let mut id = turn.get(of, p.parent)?.as_object().unwrap_or(0);
    while id != 0 && !robots.iter().any(|r| r.base == id) {
        let moves = match turn.look(id)?.kind {
            TATU_KIND_JOINT => true,
            TATU_KIND_SHAPE => turn.get(id, p.dynamic)?.truthy(),
            _ => false,
        };
        if moves {
            return Ok(false);
        }
        id = turn.get(id, p.parent)?.as_object().unwrap_or(0);
    }
    Ok(true)
}

/// Returns the index of the robot that an object is the base of, or belongs to.
fn robot_of(turn: &Turn<'_>, p: &Props, robots: &[Robot], of: tatu_object) -> Result<Option<usize>> {
    let mut id = of;
    while id != 0 {
        if let Some(found) = robots.iter().position(|r| r.base == id) {
            return Ok(Some(found));
        }
        id = turn.get(id, p.parent)?.as_object().unwrap_or(0);
    }
    Ok(None)
}
