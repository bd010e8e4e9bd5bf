//! Measures with sensors that measure after each physics step. Their inputs, such as accelerations, loads and contacts,
//! are read from the engine, and the plugin is called once for all sensors of a kind that are due.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use tatu_physics::{BodyId, Engine, JointId};
use tatu_plugin_api::abi::*;
use tatu_plugins::{
    RandomTable, Registry,
    border::ErrorSlot,
    watchdog::{CallWatch, PluginCall},
};
use tatu_scene::{Dynamics, ObjectVariant, Scene, pose_to_array};

use super::{
    Sensing, SensorDevice,
    batch::{BatchSensors, CallContext, MeasureFailure, call_kind, check_status_guards, complete},
    scratch::{MeasureScratch, MeasureTime},
};
use crate::{
    contacts::BodyContacts,
    listed::EngineTarget,
    mount::{Mount, MountMotion},
};

/// The inputs of the sensors during an advance of the engine.
#[derive(Clone, Copy)]
pub struct StepContext<'a> {
    /// The registry of plugins.
    pub registry: &'a Registry,
    /// The watchdog's record of plugin calls.
    pub watch: &'a CallWatch,
    /// Threads that apply noise to large fields.
    pub pool: &'a rayon::ThreadPool,
    /// The beginning of the advance; `dt` is the duration of a physics step.
    pub moment: MeasureTime,
}

/// The sensors that measure after each physics step, for one advance of the engine.
pub struct StepSensing<'a> {
    sensing: &'a mut Sensing,
    context: StepContext<'a>,
    /// The index of each kind, with its sensors.
    kinds: Vec<(usize, Vec<StepSensor>)>,
    /// The contacts of all bodies, if a sensor requires contacts.
    contacts: Option<BodyContacts>,
    /// Sensors that failed.
    pub failed: Vec<MeasureFailure>,
}

/// A sensor, with the joint, the body and the force sensor from which its inputs are read.
struct StepSensor {
    device: usize,
    sensor: tatu_object,
    mount: Mount,
    /// Pose and velocities of the mount at the end of the previous physics step.
    before: PoseAndTwist,
    joint: JointInput,
    body: Option<BodyId>,
    load: Option<LoadInput>,
    /// Its targets; `None` stands for a missing object.
    targets: Vec<Option<StepTarget>>,
}

/// A target, with its motion at the beginning and at the end of the physics step.
struct StepTarget {
    target: EngineTarget,
    before: PoseAndTwist,
    now: PoseAndTwist,
}

/// A pose with its velocities, in the world frame.
#[derive(Clone, Copy)]
struct PoseAndTwist {
    pose: Isometry3<f64>,
    twist: [f64; 6],
}

/// The joint whose state is an input of a sensor.
enum JointInput {
    /// A joint that the engine moves.
    Engine(JointId),
    /// The position and velocity of a joint that the engine does not move, or zeros if there is no joint.
    Static([f64; 2]),
}

/// The force sensor whose load is an input of a sensor: its joint in the engine, the body that carries it, and its
/// frame on that body.
struct LoadInput {
    joint: JointId,
    carrier: BodyId,
    frame: Isometry3<f64>,
}

/// Inputs that require the pose and velocities of the mount.
const MOTION_INPUTS: u32 = TATU_IN_POSE | TATU_IN_TWIST | TATU_IN_ACCELERATION | TATU_IN_WRENCH;

impl<'a> StepSensing<'a> {
    /// Collects the sensors that measure after each physics step; returns `None` if there are none, so that the engine
    /// needs no callback. The engine must be in sync with the scene. `twist` returns the velocity of an object that no
    /// body carries.
    pub fn new(
        sensing: &'a mut Sensing,
        scene: &Scene,
        dynamics: &Dynamics,
        around: StepContext<'a>,
        twist: impl Fn(u32) -> [f64; 6],
    ) -> Option<Self> {
        let mut kinds: Vec<(usize, Vec<StepSensor>)> = Vec::new();
        for (kind, info) in around.registry.sensors.iter().enumerate() {
            if !info.in_physics() {
                continue;
            }
            let own = sensing.devices.iter().enumerate().filter(|(_, d)| d.kind == kind && !d.off);
            let seats: Vec<StepSensor> =
                own.map(|(i, d)| StepSensor::new(i, d, info.raw.inputs, scene, dynamics, &twist)).collect();
            if !seats.is_empty() {
                kinds.push((kind, seats));
            }
        }
        if kinds.is_empty() {
            return None;
        }
        let mut failed = Vec::new();
        for (kind, seats) in &mut kinds {
            seats.retain(|seat| {
                let d = &mut sensing.devices[seat.device];
                let observed = d.layout.plan.observed;
                d.off |= observed != 0 && scene.resolve(observed).is_err();
                if d.off {
                    let text = "the object that it measures does not exist, or has been removed".to_owned();
                    let (call, status) = (PluginCall::Measure, TATU_ERR_GONE);
                    failed.push(MeasureFailure { slot: d.slot, kind: *kind, call, text, status });
                }
                !d.off
            });
        }
        let touches = kinds.iter().any(|(kind, _)| around.registry.sensors[*kind].raw.inputs & TATU_IN_CONTACTS != 0);
        let contacts = touches.then(|| BodyContacts::new(scene, dynamics));
        Some(StepSensing { sensing, context: around, kinds, contacts, failed })
    }

    /// Measures after the physics step with this index in the advance.
    pub fn measure_after_step(&mut self, engine: &dyn Engine, part: u32) {
        if let Some(contacts) = &mut self.contacts {
            contacts.read(engine);
        }
        let mut kinds = std::mem::take(&mut self.kinds);
        for (kind, seats) in &mut kinds {
            self.measure_kind(engine, part, *kind, seats);
            let devices = &self.sensing.devices;
            seats.retain(|s| !devices[s.device].off);
        }
        self.kinds = kinds;
    }

    /// Measures with those sensors of a kind that are due.
    fn measure_kind(&mut self, engine: &dyn Engine, part: u32, kind: usize, seats: &mut [StepSensor]) {
        let StepContext { registry, watch, pool, moment: begin } = self.context;
        let info = &registry.sensors[kind];
        let end = begin.time + f64::from(part + 1) * begin.dt;
        let moment = MeasureTime { time: end - 0.5 * begin.dt, ..begin };
        let moves = info.raw.inputs & MOTION_INPUTS != 0;
        let Sensing { devices: all, scratch: s, .. } = &mut *self.sensing;
        s.clear();
        let mut devices = Vec::with_capacity(seats.len());
        for seat in seats {
            let now = if moves { seat.motion(engine) } else { seat.before };
            let before = std::mem::replace(&mut seat.before, now);
            seat.targets.iter_mut().flatten().for_each(|target| target.advance(engine));
            let d = &mut all[seat.device];
            d.release(end);
            if !d.is_due_after(end - begin.dt) {
                continue;
            }
            devices.push(seat.device);
            d.prepare(s, seat.sensor, moment.time);
            seat.add_inputs(engine, (before, now), begin.dt, info.raw.inputs, s);
            if let Some(contacts) = self.contacts.as_ref().filter(|_| info.raw.inputs & TATU_IN_CONTACTS != 0) {
                contacts.add(seat.body, &mut s.contacts);
            }
            if info.raw.inputs & TATU_IN_TARGETS != 0 {
                s.listed.begin();
                for target in &seat.targets {
                    let middle = target.as_ref().map(|t| (t.target.object, t.middle()));
                    s.listed.push(middle.as_ref().map(|(object, m)| (*object, &m.pose, m.twist)));
                }
            }
        }
        if devices.is_empty() {
            return;
        }
        if info.raw.inputs & TATU_IN_CONTACTS != 0 {
            s.contacts.begin();
        }
        if info.raw.inputs & TATU_IN_TARGETS != 0 {
            s.listed.begin();
        }
        s.status.fill(devices.len(), TATU_OK);
        let keys = std::mem::take(&mut s.keys);
        let random = RandomTable::new(&keys);
        let mut error = s.error.take().unwrap_or_else(ErrorSlot::new);
        let mut batch = s.batch(devices.len(), info.fields.len(), &moment);
        batch.random = random.raw();
        let (calls, who) = (CallContext { registry, watch }, BatchSensors { kind, devices: &devices });
        let mut failed = call_kind(PluginCall::Measure, &mut batch, &mut s.status, all, who, calls, &mut error);
        failed.extend(check_status_guards(PluginCall::Measure, s, all, who));
        failed.extend(complete(s, all, who, calls, pool, &mut batch, &mut error));
        (s.error, s.keys) = (Some(error), keys);
        for f in &failed {
            all.iter_mut().filter(|d| d.slot == f.slot).for_each(|d| d.off = true);
        }
        self.failed.extend(failed);
    }
}

impl StepSensor {
    fn new(
        device: usize,
        d: &SensorDevice,
        inputs: u32,
        scene: &Scene,
        dynamics: &Dynamics,
        twist: impl Fn(u32) -> [f64; 6],
    ) -> Self {
        let mount = Mount::of(scene, dynamics, d.slot, &twist);
        let motion = mount.motion(dynamics.engine());
        // The search starts at the observed object or, if there is none, at the sensor, which never matches.
        let first = match d.layout.plan.observed {
            0 => Some(d.slot),
            observed => scene.resolve(observed).ok(),
        };
        let find = |fits: &dyn Fn(&ObjectVariant) -> bool, asked: u32| {
            let mut at = first.filter(|_| inputs & asked != 0);
            while let Some(slot) = at.filter(|s| scene.get(*s).is_some_and(|o| !fits(&o.data))) {
                at = scene.get(slot).map(|o| o.parent).filter(|p| *p != 0);
            }
            at.and_then(|slot| scene.get(slot))
        };
        let joint = match find(&|data| matches!(data, ObjectVariant::Joint(_)), TATU_IN_JOINT).and_then(|o| o.joint()) {
            Some(j) => j.id.map_or(JointInput::Static([j.position, j.velocity]), JointInput::Engine),
            None => JointInput::Static([0.0; 2]),
        };
        let has_body = |data: &ObjectVariant| matches!(data, ObjectVariant::Shape(s) if s.body.0.is_some());
        let body = find(&has_body, TATU_IN_CONTACTS).and_then(|o| o.shape()).and_then(|s| s.body.0);
        let load = match find(&|data| matches!(data, ObjectVariant::ForceSensor(_)), TATU_IN_WRENCH).map(|o| &o.data) {
            Some(ObjectVariant::ForceSensor(f)) => f.id,
            _ => None,
        };
        let load = load.and_then(|joint| {
            let ((carrier, _), frame) = dynamics.bodies_of_joint(joint)?;
            Some(LoadInput { joint, carrier, frame })
        });
        let before = PoseAndTwist::from(motion);
        let targets = match inputs & TATU_IN_TARGETS {
            0 => Vec::new(),
            _ => d.targets().map(|object| StepTarget::new(scene, dynamics, object, &twist)).collect(),
        };
        StepSensor { device, sensor: scene.id(d.slot), mount, before, joint, body, load, targets }
    }

    fn motion(&self, engine: &dyn Engine) -> PoseAndTwist {
        if self.mount.carrier().is_none() {
            return self.before;
        }
        self.mount.motion(engine).into()
    }

    /// Adds the sensor's inputs for a physics step to those of its batch, except for contacts.
    fn add_inputs(
        &self,
        engine: &dyn Engine,
        (before, now): (PoseAndTwist, PoseAndTwist),
        dt: f64,
        inputs: u32,
        s: &mut MeasureScratch,
    ) {
        let middle = before.middle(&now);
        if inputs & TATU_IN_POSE != 0 {
            s.motion.pose.push(pose_to_array(&middle.pose));
        }
        if inputs & TATU_IN_TWIST != 0 {
            s.motion.twist.push(middle.twist);
        }
        if inputs & TATU_IN_ACCELERATION != 0 {
            s.motion.acceleration.push(std::array::from_fn(|i| (now.twist[i] - before.twist[i]) / dt));
        }
        if inputs & TATU_IN_JOINT != 0 {
            s.motion.joint.push(match self.joint {
                JointInput::Engine(id) => {
                    let state = engine.joint_state(id);
                    [state.position, state.velocity, state.effort]
                }
                JointInput::Static([position, velocity]) => [position, velocity, 0.0],
            });
        }
        if inputs & TATU_IN_WRENCH != 0 {
            let load = self.load.as_ref().and_then(|l| Some((engine.wrench(l.joint)?, l)));
            s.motion.wrench.push(load.map_or([0.0; 6], |(w, l)| {
                let at = (engine.pose(l.carrier) * l.frame).translation.vector;
                let torque = w.torque + (at - now.pose.translation.vector).cross(&w.force);
                let turn = now.pose.rotation.inverse();
                let (f, t) = (turn * w.force, turn * torque);
                [f.x, f.y, f.z, t.x, t.y, t.z]
            }));
        }
    }
}

impl StepTarget {
    fn new(
        scene: &Scene,
        dynamics: &Dynamics,
        object: tatu_object,
        twist: impl Fn(u32) -> [f64; 6],
    ) -> Option<StepTarget> {
        let target = EngineTarget::new(scene, dynamics, object, twist)?;
        let now = target.motion(dynamics.engine()).into();
        Some(StepTarget { target, before: now, now })
    }
    /// Follows the target through a physics step.
    fn advance(&mut self, engine: &dyn Engine) {
        self.before = self.now;
        if self.target.mount().carrier().is_some() {
            self.now = self.target.motion(engine).into();
        }
    }
    fn middle(&self) -> PoseAndTwist {
        self.before.middle(&self.now)
    }
}

impl From<MountMotion> for PoseAndTwist {
    fn from(motion: MountMotion) -> Self {
        PoseAndTwist { pose: motion.pose, twist: motion.twist }
    }
}

impl PoseAndTwist {
    /// Returns the pose and the mean twist in the middle of a physics step that ends with `end`.
    fn middle(&self, end: &Self) -> Self {
        let twist = std::array::from_fn(|i| 0.5 * (self.twist[i] + end.twist[i]));
        PoseAndTwist { pose: middle_pose(&self.pose, &end.pose), twist }
    }
}

/// Returns the pose in the middle between two poses that differ by less than half a turn.
fn middle_pose(a: &Isometry3<f64>, b: &Isometry3<f64>) -> Isometry3<f64> {
    let (p, q) = (a.rotation.coords, b.rotation.coords);
    let sum = if p.dot(&q) < 0.0 { p - q } else { p + q };
    let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::from_vector(sum));
    let place: Vector3<f64> = 0.5 * (a.translation.vector + b.translation.vector);
    Isometry3::from_parts(place.into(), rotation)
}
