//! Builds the messages that a scene publishes, as values with the field names in `types`. Omitted fields have their
//! default value.

use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Prop, Reading, Result, Turn, Value, keys},
};

use crate::{
    Props, covariance,
    declared_messages::DeclaredMessage,
    description,
    poses::{
        IDENTITY, OPTICAL_AXES, Pose, ROS_AXES, compose, pose, project_to_floor, relative_pose, transform, vector,
    },
    robots::{FrameAxes, Robot, RobotScene, SceneSensor},
    topics::TopicContent,
};

/// Value of `datatype` in `sensor_msgs/PointField`: 32-bit floats.
const FLOAT32: i64 = 7;
/// Value of `radiation_type` in `sensor_msgs/Range`: ultrasound.
const ULTRASOUND: i64 = 0;
/// Value of `radiation_type` in `sensor_msgs/Range`: infrared.
const INFRARED: i64 = 1;
/// Value of `position_covariance_type` in `sensor_msgs/NavSatFix`: the diagonal of the covariance is known.
const DIAGONAL_KNOWN: i64 = 2;

/// The data from which messages are built.
pub struct MessageBuilder<'a> {
    /// Access to the world.
    pub turn: &'a Turn<'a>,
    /// Interned property keys.
    pub p: &'a Props,
    /// The robots and sensors of the scene.
    pub scene: &'a RobotScene,
    /// Simulation time, s.
    pub time: f64,
    /// Length of a step, s.
    pub dt: f64,
}

fn text(t: &str) -> Value {
    Value::text(t)
}

impl MessageBuilder<'_> {
    /// Returns a `std_msgs/Header`.
    fn header(&self, frame: &str, time: f64) -> Value {
        keys([("stamp", Value::Float(time)), ("frame_id", text(frame))])
    }

    /// Returns a number that changes whenever a topic has a new message, such as the number of measurements of its
    /// sensor; 0 if the sensor has not measured yet. Returns `None` if the topic has a new message in each step.
    pub fn sequence(&self, what: TopicContent) -> Option<u64> {
        let of = |i: usize, prop: Prop| {
            let id = self.scene.sensors.get(i)?.id;
            Some(self.turn.reading(id, prop).map_or(0, |r| r.sequence()))
        };
        let p = self.p;
        match what {
            TopicContent::Scan(i) => of(i, p.scan_distance),
            TopicContent::Range(i) => of(i, p.detected),
            TopicContent::Fix(i) => of(i, p.latitude),
            TopicContent::Image(i) => of(i, p.rgb),
            TopicContent::Depth(i) | TopicContent::CameraInfo(i) => of(i, p.depth),
            TopicContent::Simple(i, felt) => of(i, felt.field(p)),
            TopicContent::Declared(i) => {
                let id = self.scene.sensors.get(i)?.id;
                Some(self.turn.f64(id, p.measured).map_or(0, |n| n as u64))
            }
            // These topics are published once a second, for clients that subscribe later.
            TopicContent::StaticFrames | TopicContent::Description(_) => Some(self.time as u64 + 1),
            TopicContent::Points(i) => of(i, p.depth).filter(|n| *n > 0).or_else(|| of(i, p.scan_distance)),
            _ => None,
        }
    }

    /// Returns the current message of a topic, or `None` if the topic has no messages.
    pub fn message(&self, what: TopicContent) -> Result<Option<Value>> {
        Ok(match what {
            TopicContent::Clock => Some(keys([("clock", Value::Float(self.time))])),
            TopicContent::Frames => Some(keys([("transforms", Value::List(self.frames()?))])),
            TopicContent::StaticFrames => Some(keys([("transforms", Value::List(self.static_frames()?))])),
            TopicContent::Odometry(i) => self.robot(i, |r| self.odometry(r))?,
            TopicContent::Pose(i) => self.robot(i, |r| self.pose(r))?,
            TopicContent::Joints(i) => self.robot(i, |r| self.joints(r))?,
            TopicContent::Description(i) => self.robot(i, |r| {
                Ok(keys([("data", Value::text(description::urdf(self.turn, self.p, self.scene, r)?))]))
            })?,
            TopicContent::Command(_) | TopicContent::JointTrajectory(_) => None,
            TopicContent::Scan(i) => self.sensor(i, |s| self.scan(s))?,
            TopicContent::Range(i) => self.sensor(i, |s| self.range(s))?,
            TopicContent::Fix(i) => self.sensor(i, |s| self.fix(s))?,
            TopicContent::Image(i) => self.sensor(i, |s| self.image(s))?,
            TopicContent::Depth(i) => self.sensor(i, |s| self.depth(s))?,
            TopicContent::CameraInfo(i) => self.sensor(i, |s| self.camera_info(s))?,
            TopicContent::Points(i) => self.sensor(i, |s| self.points(s))?,
            TopicContent::Simple(i, felt) => {
                self.sensor(i, |s| felt.message(self.turn, self.p, s.id, |time| self.header(&s.frame, time)))?
            }
            TopicContent::Declared(i) => {
                let Some(s) = self.scene.sensors.get(i) else { return Ok(None) };
                let time = self.turn.field_of(s.id, 0).map(|(name, _)| self.turn.host().prop(name));
                let time =
                    time.and_then(|field| Some(self.turn.reading(s.id, field).ok()?.time())).unwrap_or(self.time);
                let built = DeclaredMessage::of(self.turn, self.p, s.id)?;
                built.map(|m| m.message(self.header(&s.frame, time)))
            }
        })
    }

    /// Builds a message for the robot with index `i`.
    fn robot(&self, i: usize, f: impl Fn(&Robot) -> Result<Value>) -> Result<Option<Value>> {
        self.scene.robots.get(i).map(f).transpose()
    }
    /// Builds a message for the sensor with index `i`.
    fn sensor(&self, i: usize, f: impl Fn(&SceneSensor) -> Result<Value>) -> Result<Option<Value>> {
        self.scene.sensors.get(i).map(f).transpose()
    }
    /// Returns a numeric property, or `None` if the object does not have it.
    fn number(&self, id: tatu_object, key: &str) -> Option<f64> {
        self.turn.f64(id, self.turn.host().prop(key)).ok()
    }

    /// Returns the pose of a robot's `base_link` in its odometry frame, computed from the motion of its wheels; `None`
    /// if it has no drivetrain.
    fn odometry_pose(&self, robot: &Robot) -> Option<Pose> {
        robot.drivetrain.as_ref().map(|_| robot.odometry.pose())
    }

    /// Returns the true pose of a robot's `base_link` in the world frame.
    fn true_pose(&self, robot: &Robot) -> Result<Pose> {
        Ok(compose(&self.turn.pose(robot.base, 0)?, &robot.base_link_pose()))
    }

    /// Returns a `geometry_msgs/TransformStamped`.
    fn frame(&self, parent: &str, child: &str, at: &Pose) -> Value {
        keys([
            ("header", self.header(parent, self.time)),
            ("child_frame_id", text(child)),
            ("transform", transform(at)),
        ])
    }

    /// Returns all frames: map > odom > base_link > sensors, without odom for robots that have no drivetrain. The
    /// transform from map to odom, both on the floor, is the odometry error, as with a localization node. The transform
    /// from odom to base_link includes the height and tilt of the robot.
    fn frames(&self) -> Result<Vec<Value>> {
        let mut out = Vec::new();
        for robot in &self.scene.robots {
            let (base, odom) = (format!("{}base_link", robot.prefix), format!("{}odom", robot.prefix));
            let real = self.true_pose(robot)?;
            match self.odometry_pose(robot) {
                Some(driven) => {
                    let start = compose(&project_to_floor(&real), &relative_pose(&driven, &IDENTITY));
                    out.push(self.frame("map", &odom, &start));
                    out.push(self.frame(&odom, &base, &relative_pose(&start, &real)));
                }
                None => out.push(self.frame("map", &base, &real)),
            }
        }
        for sensor in &self.scene.sensors {
            out.push(self.sensor_frame(sensor)?);
        }
        Ok(out)
    }

    /// Returns the frames of sensors that are rigidly attached to their robot or to the world. These frames are in
    /// `/tf` as well, because many clients of rosbridge read only that topic.
    fn static_frames(&self) -> Result<Vec<Value>> {
        let fixed = |s: &&SceneSensor| s.fixed;
        self.scene.sensors.iter().filter(fixed).map(|s| self.sensor_frame(s)).collect()
    }

    /// Returns the frame of a sensor, relative to its robot or to the map.
    fn sensor_frame(&self, sensor: &SceneSensor) -> Result<Value> {
        let turn = match sensor.axes {
            FrameAxes::Optical => &OPTICAL_AXES,
            FrameAxes::Ahead => &ROS_AXES,
            FrameAxes::Own => &IDENTITY,
        };
        let (parent, at) = match sensor.robot.and_then(|r| self.scene.robots.get(r)) {
            Some(robot) => {
                let in_base = self.turn.pose(sensor.id, robot.base)?;
                (format!("{}base_link", robot.prefix), relative_pose(&robot.base_link_pose(), &in_base))
            }
            None => ("map".to_owned(), self.turn.pose(sensor.id, 0)?),
        };
        Ok(self.frame(&parent, &sensor.frame, &compose(&at, turn)))
    }

    fn odometry(&self, robot: &Robot) -> Result<Value> {
        let at = self.odometry_pose(robot).unwrap_or(IDENTITY);
        let [vx, vy, wz] = robot.odometry.velocity;
        let twist = keys([("linear", vector([vx, vy, 0.0])), ("angular", vector([0.0, 0.0, wz]))]);
        Ok(keys([
            ("header", self.header(&format!("{}odom", robot.prefix), self.time)),
            ("child_frame_id", text(&format!("{}base_link", robot.prefix))),
            ("pose", keys([("pose", pose(&at))])),
            ("twist", keys([("twist", twist)])),
        ]))
    }

    fn pose(&self, robot: &Robot) -> Result<Value> {
        Ok(keys([("header", self.header("map", self.time)), ("pose", pose(&self.true_pose(robot)?))]))
    }

    fn joints(&self, robot: &Robot) -> Result<Value> {
        let all = |prop| -> Result<Value> {
            let one = |(id, _): &(tatu_object, String)| self.turn.f64(*id, prop);
            Ok(Value::Floats(robot.joints.iter().map(one).collect::<Result<_>>()?))
        };
        Ok(keys([
            ("header", self.header("", self.time)),
            ("name", Value::List(robot.joints.iter().map(|(_, name)| text(name)).collect())),
            ("position", all(self.p.wheels.position)?),
            ("velocity", all(self.p.wheels.velocity)?),
            ("effort", all(self.p.effort)?),
        ]))
    }

    fn scan(&self, s: &SceneSensor) -> Result<Value> {
        let distance = self.turn.reading(s.id, self.p.scan_distance)?;
        let (angle, limits) =
            (self.turn.reading(s.id, self.p.scan_angle)?, self.turn.reading(s.id, self.p.scan_limits)?);
        let (angle, limits) = (angle.f64s(), limits.f64s());
        let intensity = self.turn.reading(s.id, self.p.scan_intensity);
        let (first, last) = (angle.first().copied().unwrap_or(0.0), angle.last().copied().unwrap_or(0.0));
        let step = (last - first) / (angle.len().max(2) - 1) as f64;
        let rate = self.turn.f64(s.id, self.p.rate).unwrap_or(0.0);
        Ok(keys([
            ("header", self.header(&s.frame, distance.time())),
            ("angle_min", Value::Float(first)),
            ("angle_max", Value::Float(last)),
            ("angle_increment", Value::Float(step)),
            ("scan_time", Value::Float(if rate > 0.0 { 1.0 / rate } else { self.dt })),
            ("range_min", Value::Float(limits.first().copied().unwrap_or(0.0))),
            ("range_max", Value::Float(limits.get(1).copied().unwrap_or(f64::INFINITY))),
            ("ranges", Value::Floats(distance.f64s().to_vec())),
            ("intensities", Value::Floats(intensity.map_or(Vec::new(), |r| r.f64s().to_vec()))),
        ]))
    }

    fn range(&self, s: &SceneSensor) -> Result<Value> {
        let detected = self.turn.reading(s.id, self.p.detected)?;
        let distance = self.turn.reading(s.id, self.p.distance)?.f64s().first().copied();
        let seen = detected.i32s().first() == Some(&1);
        // The keys of a sensor's parameters start with the kind of the sensor.
        let kind = self.turn.get(s.id, self.p.sensor_kind)?.as_str().unwrap_or_default().into_owned();
        let of = |name: &str| self.number(s.id, &format!("{kind}.{name}"));
        let waves = self.turn.get(s.id, self.turn.host().prop(&format!("{kind}.waves")));
        let light = waves.is_ok_and(|w| matches!(w.as_str().as_deref(), Some("infrared" | "laser")));
        Ok(keys([
            ("header", self.header(&s.frame, detected.time())),
            ("radiation_type", Value::Int(if light { INFRARED } else { ULTRASOUND })),
            ("field_of_view", Value::Float(of("angle").unwrap_or(0.0))),
            ("min_range", Value::Float(of("min_range").unwrap_or(0.0))),
            ("max_range", Value::Float(of("range").unwrap_or(f64::INFINITY))),
            ("range", Value::Float(distance.filter(|_| seen).unwrap_or(f64::INFINITY))),
            ("variance", Value::Float(covariance::variances(self.turn, self.p, s.id, "proximity.distance")[0])),
        ]))
    }

    fn fix(&self, s: &SceneSensor) -> Result<Value> {
        let one = |prop| -> Result<f64> { Ok(self.turn.reading(s.id, prop)?.f64s().first().copied().unwrap_or(0.0)) };
        let valid = self.turn.reading(s.id, self.p.fix_valid)?;
        // STATUS_FIX is 0, and STATUS_NO_FIX is -1.
        let found = if valid.i32s().first() == Some(&1) { 0 } else { -1 };
        Ok(keys([
            ("header", self.header(&s.frame, valid.time())),
            ("status", keys([("status", Value::Int(found)), ("service", Value::Int(1))])),
            ("latitude", Value::Float(one(self.p.latitude)?.to_degrees())),
            ("longitude", Value::Float(one(self.p.longitude)?.to_degrees())),
            ("altitude", Value::Float(one(self.p.altitude)?)),
            ("position_covariance", covariance::matrix(self.turn, self.p, s.id, "gps.position")),
            ("position_covariance_type", Value::Int(DIAGONAL_KNOWN)),
        ]))
    }

    /// Returns a `sensor_msgs/Image`; `pixel` is the number of bytes per pixel.
    fn picture(&self, s: &SceneSensor, of: &Reading, encoding: &str, pixel: usize, data: Vec<u8>) -> Value {
        let [rows, columns, _] = of.dims();
        keys([
            ("header", self.header(&s.frame, of.time())),
            ("height", Value::Int(rows.into())),
            ("width", Value::Int(columns.into())),
            ("encoding", text(encoding)),
            ("step", Value::Int(i64::from(columns) * pixel as i64)),
            ("data", Value::Bytes(data)),
        ])
    }

    fn image(&self, s: &SceneSensor) -> Result<Value> {
        let rgb = self.turn.reading(s.id, self.p.rgb)?;
        // ROS images start with the top row, those of the simulator with the bottom row.
        let row = rgb.dims()[1] as usize * 3;
        let rows: Vec<&[u8]> = rgb.u8s().chunks(row.max(1)).rev().collect();
        let data = rows.concat();
        Ok(self.picture(s, &rgb, "rgb8", 3, data))
    }

    fn depth(&self, s: &SceneSensor) -> Result<Value> {
        let depth = self.turn.reading(s.id, self.p.depth)?;
        let told = |x: &f32| if *x == 0.0 { f32::NAN } else { *x };
        let rows = depth.f32s().chunks((depth.dims()[1] as usize).max(1)).rev();
        let data = rows.flatten().flat_map(|x| told(x).to_le_bytes()).collect();
        Ok(self.picture(s, &depth, "32FC1", 4, data))
    }

    /// Returns fx, fy, cx and cy of a camera, pixels, with rows counted from the bottom.
    fn intrinsics(&self, s: &SceneSensor) -> Result<[f64; 4]> {
        let all = self.turn.reading(s.id, self.p.intrinsics)?;
        Ok(all.f64s().first_chunk::<4>().copied().unwrap_or([1.0, 1.0, 0.0, 0.0]))
    }

    fn camera_info(&self, s: &SceneSensor) -> Result<Value> {
        let depth = self.turn.reading(s.id, self.p.depth)?;
        let [rows, columns, _] = depth.dims();
        let [fx, fy, cx, cy] = self.intrinsics(s)?;
        // ROS counts rows from the top.
        let cy = f64::from(rows) - 1.0 - cy;
        Ok(keys([
            ("header", self.header(&s.frame, depth.time())),
            ("height", Value::Int(rows.into())),
            ("width", Value::Int(columns.into())),
            ("distortion_model", text("plumb_bob")),
            ("D", Value::Floats(vec![0.0; 5])),
            ("K", Value::Floats(vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0])),
            ("R", Value::Floats(vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])),
            ("P", Value::Floats(vec![fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0])),
        ]))
    }

    /// Returns the points of a depth camera in its optical frame, row by row from the top, or those of a scanner with
    /// layers.
    fn points(&self, s: &SceneSensor) -> Result<Value> {
        if s.axes != FrameAxes::Optical {
            return self.layers(s);
        }
        let depth = self.turn.reading(s.id, self.p.depth)?;
        let [rows, columns, _] = depth.dims();
        let [fx, fy, cx, cy] = self.intrinsics(s)?;
        let parallel = self.turn.reading(s.id, self.p.parallel).is_ok_and(|r| r.i32s().first() == Some(&1));
        let mut data = Vec::with_capacity(depth.f32s().len() * 12);
        for (row, line) in depth.f32s().chunks((columns as usize).max(1)).enumerate().rev() {
            for (column, z) in line.iter().enumerate() {
                let z = if *z == 0.0 || !z.is_finite() { f64::NAN } else { f64::from(*z) };
                let away = if parallel { if z.is_nan() { z } else { 1.0 } } else { z };
                // The x axis points right, and the y axis down.
                let (x, y) = ((column as f64 - cx) * away / fx, -(row as f64 - cy) * away / fy);
                [x, y, z].iter().for_each(|v| data.extend_from_slice(&(*v as f32).to_le_bytes()));
            }
        }
        Ok(self.cloud(s, depth.time(), [rows, columns], data))
    }

    /// Returns the points of a scanner with layers, in a single row. The coordinates are NaN for beams that hit
    /// nothing.
    fn layers(&self, s: &SceneSensor) -> Result<Value> {
        let distance = self.turn.reading(s.id, self.p.scan_distance)?;
        let angle = self.turn.reading(s.id, self.p.scan_angle)?;
        let elevation = self.turn.reading(s.id, self.p.scan_elevation)?;
        let mut data = Vec::with_capacity(distance.f64s().len() * 12);
        for ((r, a), e) in distance.f64s().iter().zip(angle.f64s()).zip(elevation.f64s()) {
            let r = if r.is_finite() { *r } else { f64::NAN };
            let ((sa, ca), (se, ce)) = (libm::sincos(*a), libm::sincos(*e));
            [r * ca * ce, r * sa * ce, r * se].iter().for_each(|v| data.extend_from_slice(&(*v as f32).to_le_bytes()));
        }
        Ok(self.cloud(s, distance.time(), [1, distance.f64s().len() as u32], data))
    }

    /// Returns a `sensor_msgs/PointCloud2`; `data` contains x, y and z of each point as 32-bit floats.
    fn cloud(&self, s: &SceneSensor, time: f64, [rows, columns]: [u32; 2], data: Vec<u8>) -> Value {
        let field = |(i, name): (i64, &str)| {
            keys([
                ("name", text(name)),
                ("offset", Value::Int(4 * i)),
                ("datatype", Value::Int(FLOAT32)),
                ("count", Value::Int(1)),
            ])
        };
        keys([
            ("header", self.header(&s.frame, time)),
            ("height", Value::Int(rows.into())),
            ("width", Value::Int(columns.into())),
            ("fields", Value::List([(0, "x"), (1, "y"), (2, "z")].map(field).to_vec())),
            ("point_step", Value::Int(12)),
            ("row_step", Value::Int(12 * i64::from(columns))),
            ("data", Value::Bytes(data)),
        ])
    }
}
