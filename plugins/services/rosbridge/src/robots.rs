//! The robots and sensors of a scene, under names that ROS takes, and how far wheels have driven.

use std::collections::BTreeMap;

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};
use tatu_robots_drivetrain::{Drivetrain, Stand};

use crate::{
    Props,
    poses::{Pose, planar},
};

/// A robot: what a drive or the base of a model stands for, with sensors or joints below it.
pub struct Robot {
    /// Its base.
    pub base: tatu_object,
    /// Its name.
    pub name: String,
    /// What its frames begin with; empty where it is the only robot.
    pub prefix: String,
    /// Its wheels.
    pub train: Option<Drivetrain>,
    /// Its joints, and their names.
    pub joints: Vec<(tatu_object, String)>,
    /// Where its wheels say that it is.
    pub odometry: Odometry,
    /// When its last command ends, s; none: it has none.
    pub until: Option<f64>,
}

/// Where wheels say that a robot is, since the start: it drifts from where it is.
#[derive(Debug, Clone, Default)]
pub struct Odometry {
    /// Ahead and to the left of where it began, m, and its heading, rad; of the middle of its axle.
    pub place: [f64; 3],
    /// Velocity ahead, to the left, m/s, and of turning, rad/s.
    pub velocity: [f64; 3],
    /// What the joints did.
    before: Option<(f64, Stand)>,
}

impl Odometry {
    /// Takes in what the joints do now.
    pub fn take(&mut self, train: &Drivetrain, time: f64, now: Stand) {
        if let Some((then, before)) = &self.before
            && time > *then
        {
            let [dx, dy, turn] = train.motion(&now.turns_since(before, time - then), &now.steered);
            // Along the chord of the bend.
            let heading = self.place[2] + turn / 2.0;
            let (s, c) = libm::sincos(heading);
            self.place[0] += c * dx - s * dy;
            self.place[1] += s * dx + c * dy;
            self.place[2] += turn;
            self.velocity = [dx, dy, turn].map(|x| x / (time - then));
        }
        self.before = Some((time, now));
    }

    /// Where the base is, from where it was at the start.
    pub fn base(&self, axle: f64) -> Pose {
        let [x, y, heading] = self.place;
        let (s, c) = libm::sincos(heading);
        planar(x + axle - c * axle, y - s * axle, heading)
    }
}

/// A sensor.
pub struct Sensor {
    /// The sensor.
    pub id: tatu_object,
    /// Its name in its robot,
    pub name: String,
    /// and that of its frame.
    pub frame: String,
    /// Its robot.
    pub robot: Option<usize>,
    /// Whether it sees along the z axis of a camera; else its frame is turned, x ahead.
    pub optical: bool,
}

/// What a scene holds.
#[derive(Default)]
pub struct Scene {
    /// All objects, as they were.
    pub ids: Vec<tatu_object>,
    /// Robots.
    pub robots: Vec<Robot>,
    /// Sensors.
    pub sensors: Vec<Sensor>,
}

/// A name as ROS takes it.
pub fn ros_name(name: &str) -> String {
    let mut out: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !out.starts_with(|c: char| c.is_ascii_alphabetic()) {
        out.insert(0, 'o');
    }
    out
}

impl Scene {
    /// Looks at what there is; what was known of robots stays.
    pub fn read(turn: &Turn<'_>, p: &Props, ids: Vec<tatu_object>, before: Scene) -> Result<Scene> {
        let mut scene = Scene { ids, ..Default::default() };
        // Aliases, or where there are several of them in a robot, the unique names that all objects have.
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
            // A joint that is missing leaves the robot without its drive.
            let train = if drive { Drivetrain::of(turn, &p.wheels, id).unwrap_or(None) } else { None };
            scene.robots.push(Robot {
                base: id,
                name: of(id, p.alias)?,
                prefix: String::new(),
                train,
                joints: Vec::new(),
                odometry: Odometry::default(),
                until: None,
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
                let optical = turn.reading(id, p.depth).is_ok();
                let name = of(id, p.alias)?;
                *named.entry((robot, name.clone())).or_default() += 1;
                scene.sensors.push(Sensor { id, name, frame: String::new(), robot, optical });
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
        // What neither moves nor senses is furniture.
        let mut places = Vec::new();
        let mut kept = Vec::new();
        for (robot, has) in scene.robots.into_iter().zip(has) {
            places.push((has || robot.train.is_some()).then_some(kept.len()));
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
            if let Some(known) = before.robots.iter().find(|b| b.base == robot.base && b.train == robot.train) {
                (robot.odometry, robot.until) = (known.odometry.clone(), known.until);
            }
        }
        for sensor in &mut scene.sensors {
            let robot = sensor.robot.and_then(|r| scene.robots.get(r));
            sensor.frame = format!("{}{}", robot.map_or("", |r| &r.prefix), sensor.name);
        }
        Ok(scene)
    }
}

/// The robot that an object belongs to, itself included.
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
