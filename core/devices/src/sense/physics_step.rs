//! Measures with sensors that measure after each physics step. Their inputs, such as accelerations, loads and contacts,
//! are read from the engine, and the plugin is called once for all sensors of a kind that are due.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use tatu_physics::{BodyId, Contact, Engine, JointId};
use tatu_plugin_api::abi::*;
use tatu_plugins::{
    Registry,
    border::ErrorSlot,
    watchdog::{Call, Watch},
};
use tatu_scene::{Data, Dynamics, Scene, pose_to_array};

use super::{
    Device, Sensing,
    batch::{Calls, MeasureFailure, Who, beside_status, complete, hand_over},
    random,
    scratch::{MeasureScratch, Moment},
};
use crate::mount::Mount;

/// The inputs of the sensors during an advance of the engine.
#[derive(Clone, Copy)]
pub struct StepAround<'a> {
    /// The registry of plugins.
    pub registry: &'a Registry,
    /// The watchdog's record of plugin calls.
    pub watch: &'a Watch,
    /// Threads that apply noise to large fields.
    pub pool: &'a rayon::ThreadPool,
    /// The beginning of the advance; `dt` is the duration of a physics step.
    pub moment: Moment,
}

/// The sensors that measure after each physics step, for one advance of the engine.
pub struct StepSensing<'a> {
    sensing: &'a mut Sensing,
    around: StepAround<'a>,
    /// The sensors of each kind.
    kinds: Vec<(usize, Vec<Seat>)>,
    /// Handles of the shapes that bodies represent, in order of bodies; empty if no sensor requires contacts.
    shapes: Vec<(BodyId, tatu_object)>,
    contacts: Vec<Contact>,
    /// For each of the two bodies of a contact, the body and the index of the contact, sorted by body.
    touching: Vec<(BodyId, u32)>,
    /// Sensors that failed.
    pub failed: Vec<MeasureFailure>,
}

/// A sensor, with the joint, the body and the force sensor from which its inputs are read.
struct Seat {
    device: usize,
    sensor: tatu_object,
    mount: Mount,
    /// Pose and velocities of the mount at the end of the previous physics step.
    before: Moving,
    joint: FeltJoint,
    body: Option<BodyId>,
    load: Option<Load>,
}

/// A pose with its velocities, in the world frame.
#[derive(Clone, Copy)]
struct Moving {
    pose: Isometry3<f64>,
    twist: [f64; 6],
}

/// The joint whose state is an input of a sensor.
enum FeltJoint {
    /// A joint that the engine moves.
    Engine(JointId),
    /// The position and velocity of a joint that the engine does not move, or zeros if there is no joint.
    Still([f64; 2]),
}

/// The force sensor whose load is an input of a sensor: its joint in the engine, the body that carries it, and its
/// frame on that body.
struct Load {
    joint: JointId,
    carrier: BodyId,
    frame: Isometry3<f64>,
}

/// Inputs that require the pose and velocities of the mount.
const OF_MOTION: u32 = TATU_IN_POSE | TATU_IN_TWIST | TATU_IN_ACCELERATION | TATU_IN_WRENCH;

impl<'a> StepSensing<'a> {
    /// Collects the sensors that measure after each physics step; returns `None` if there are none, so that the engine
    /// needs no callback. The engine must be in sync with the scene. `twist` returns the velocity of an object that no
    /// body carries.
    pub fn new(
        sensing: &'a mut Sensing,
        scene: &Scene,
        dynamics: &Dynamics,
        around: StepAround<'a>,
        twist: impl Fn(u32) -> [f64; 6],
    ) -> Option<Self> {
        let mut kinds: Vec<(usize, Vec<Seat>)> = Vec::new();
        for (kind, info) in around.registry.sensors.iter().enumerate() {
            if !info.in_physics() {
                continue;
            }
            let own = sensing.devices.iter().enumerate().filter(|(_, d)| d.kind == kind && !d.off);
            let seats: Vec<Seat> =
                own.map(|(i, d)| Seat::new(i, d, info.raw.inputs, scene, dynamics, &twist)).collect();
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
                    let (call, status) = (Call::Measure, TATU_ERR_GONE);
                    failed.push(MeasureFailure { slot: d.slot, kind: *kind, call, text, status });
                }
                !d.off
            });
        }
        let touches = kinds.iter().any(|(kind, _)| around.registry.sensors[*kind].raw.inputs & TATU_IN_CONTACTS != 0);
        let shapes = if touches { dynamics.shapes().map(|(b, s)| (b, scene.id(s))).collect() } else { Vec::new() };
        let (contacts, touching) = Default::default();
        Some(StepSensing { sensing, around, kinds, shapes, contacts, touching, failed })
    }

    /// Measures after the physics step with this index in the advance.
    pub fn after(&mut self, engine: &dyn Engine, part: u32) {
        if !self.shapes.is_empty() {
            engine.contacts(&mut self.contacts);
            let ends = (0..).zip(&self.contacts).flat_map(|(i, c)| [(c.bodies.0, i), (c.bodies.1, i)]);
            self.touching.clear();
            self.touching.extend(ends);
            self.touching.sort_unstable();
        }
        let mut kinds = std::mem::take(&mut self.kinds);
        for (kind, seats) in &mut kinds {
            self.measure(engine, part, *kind, seats);
            let devices = &self.sensing.devices;
            seats.retain(|s| !devices[s.device].off);
        }
        self.kinds = kinds;
    }

    /// Measures with those sensors of a kind that are due.
    fn measure(&mut self, engine: &dyn Engine, part: u32, kind: usize, seats: &mut [Seat]) {
        let StepAround { registry, watch, pool, moment: begin } = self.around;
        let info = &registry.sensors[kind];
        let end = begin.time + f64::from(part + 1) * begin.dt;
        let moment = Moment { time: end - 0.5 * begin.dt, ..begin };
        let moves = info.raw.inputs & OF_MOTION != 0;
        let Sensing { devices: all, scratch: s, .. } = &mut *self.sensing;
        s.clear();
        let mut devices = Vec::with_capacity(seats.len());
        for seat in seats {
            let now = if moves { seat.motion(engine) } else { seat.before };
            let before = std::mem::replace(&mut seat.before, now);
            let d = &mut all[seat.device];
            d.release(end);
            if !d.is_due_after(end - begin.dt) {
                continue;
            }
            devices.push(seat.device);
            d.prepare(s, seat.sensor, moment.time);
            seat.feel(engine, (before, now), begin.dt, info.raw.inputs, s);
            if info.raw.inputs & TATU_IN_CONTACTS != 0 {
                let felt = Felt { contacts: &self.contacts, touching: &self.touching, shapes: &self.shapes };
                felt.add(seat.body, s);
            }
        }
        if devices.is_empty() {
            return;
        }
        if info.raw.inputs & TATU_IN_CONTACTS != 0 {
            s.first_contact.push(s.contact.len() as u64);
        }
        s.status.fill(devices.len(), TATU_OK);
        let random = random::table(&s.keys);
        let mut error = s.error.take().unwrap_or_else(ErrorSlot::new);
        let mut batch = s.batch(devices.len(), info.fields.len(), &moment);
        batch.random = &random;
        let (calls, who) = (Calls { registry, watch }, Who { kind, devices: &devices });
        let mut failed = hand_over(Call::Measure, &batch, all, who, calls, &mut error);
        failed.extend(beside_status(Call::Measure, s, all, who));
        failed.extend(complete(s, all, who, calls, pool, &batch, &mut error));
        s.error = Some(error);
        for f in &failed {
            all.iter_mut().filter(|d| d.slot == f.slot).for_each(|d| d.off = true);
        }
        self.failed.extend(failed);
    }
}

impl Seat {
    fn new(
        device: usize,
        d: &Device,
        inputs: u32,
        scene: &Scene,
        dynamics: &Dynamics,
        twist: impl Fn(u32) -> [f64; 6],
    ) -> Self {
        let mount = Mount::of(scene, dynamics, d.slot, twist);
        let motion = mount.motion(dynamics.engine());
        // The search starts at the observed object or, if there is none, at the sensor, which never matches.
        let first = match d.layout.plan.observed {
            0 => Some(d.slot),
            observed => scene.resolve(observed).ok(),
        };
        let find = |fits: &dyn Fn(&Data) -> bool, asked: u32| {
            let mut at = first.filter(|_| inputs & asked != 0);
            while let Some(slot) = at.filter(|s| scene.get(*s).is_some_and(|o| !fits(&o.data))) {
                at = scene.get(slot).map(|o| o.parent).filter(|p| *p != 0);
            }
            at.and_then(|slot| scene.get(slot))
        };
        let joint = match find(&|data| matches!(data, Data::Joint(_)), TATU_IN_JOINT).and_then(|o| o.joint()) {
            Some(j) => j.id.map_or(FeltJoint::Still([j.position, j.velocity]), FeltJoint::Engine),
            None => FeltJoint::Still([0.0; 2]),
        };
        let has_body = |data: &Data| matches!(data, Data::Shape(s) if s.body.0.is_some());
        let body = find(&has_body, TATU_IN_CONTACTS).and_then(|o| o.shape()).and_then(|s| s.body.0);
        let load = match find(&|data| matches!(data, Data::ForceSensor(_)), TATU_IN_WRENCH).map(|o| &o.data) {
            Some(Data::ForceSensor(f)) => f.id,
            _ => None,
        };
        let load = load.and_then(|joint| {
            let ((carrier, _), frame) = dynamics.tie(joint)?;
            Some(Load { joint, carrier, frame })
        });
        let before = Moving { pose: motion.pose, twist: motion.twist };
        Seat { device, sensor: scene.id(d.slot), mount, before, joint, body, load }
    }

    fn motion(&self, engine: &dyn Engine) -> Moving {
        if !self.mount.is_carried() {
            return self.before;
        }
        let motion = self.mount.motion(engine);
        Moving { pose: motion.pose, twist: motion.twist }
    }

    /// Adds the sensor's inputs for a physics step to those of its batch, except for contacts.
    fn feel(&self, engine: &dyn Engine, (before, now): (Moving, Moving), dt: f64, inputs: u32, s: &mut MeasureScratch) {
        let pose = halfway(&before.pose, &now.pose);
        let each = |f: &dyn Fn(f64, f64) -> f64| std::array::from_fn(|i| f(before.twist[i], now.twist[i]));
        if inputs & TATU_IN_POSE != 0 {
            s.pose.push(pose_to_array(&pose));
        }
        if inputs & TATU_IN_TWIST != 0 {
            s.twist.push(each(&|a, b| 0.5 * (a + b)));
        }
        if inputs & TATU_IN_ACCELERATION != 0 {
            s.acceleration.push(each(&|a, b| (b - a) / dt));
        }
        if inputs & TATU_IN_JOINT != 0 {
            s.joint.push(match self.joint {
                FeltJoint::Engine(id) => {
                    let state = engine.joint_state(id);
                    [state.position, state.velocity, state.effort]
                }
                FeltJoint::Still([position, velocity]) => [position, velocity, 0.0],
            });
        }
        if inputs & TATU_IN_WRENCH != 0 {
            let load = self.load.as_ref().and_then(|l| Some((engine.wrench(l.joint)?, l)));
            s.wrench.push(load.map_or([0.0; 6], |(w, l)| {
                let at = (engine.pose(l.carrier) * l.frame).translation.vector;
                let torque = w.torque + (at - now.pose.translation.vector).cross(&w.force);
                let turn = now.pose.rotation.inverse();
                let (f, t) = (turn * w.force, turn * torque);
                [f.x, f.y, f.z, t.x, t.y, t.z]
            }));
        }
    }
}

/// Returns the pose in the middle between two poses that differ by less than half a turn.
fn halfway(a: &Isometry3<f64>, b: &Isometry3<f64>) -> Isometry3<f64> {
    let (p, q) = (a.rotation.coords, b.rotation.coords);
    let sum = if p.dot(&q) < 0.0 { p - q } else { p + q };
    let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::from_vector(sum));
    let place: Vector3<f64> = 0.5 * (a.translation.vector + b.translation.vector);
    Isometry3::from_parts(place.into(), rotation)
}

/// The contacts of a physics step.
struct Felt<'a> {
    contacts: &'a [Contact],
    touching: &'a [(BodyId, u32)],
    shapes: &'a [(BodyId, tatu_object)],
}

impl Felt<'_> {
    fn shape(&self, body: BodyId) -> tatu_object {
        self.shapes.binary_search_by_key(&body, |(b, _)| *b).map_or(0, |i| self.shapes[i].1)
    }

    /// Adds the contacts of a sensor's body to the inputs of its batch.
    fn add(&self, body: Option<BodyId>, s: &mut MeasureScratch) {
        s.first_contact.push(s.contact.len() as u64);
        let Some(body) = body else { return };
        let from = self.touching.partition_point(|(b, _)| *b < body);
        for (_, i) in self.touching[from..].iter().take_while(|(b, _)| *b == body) {
            let c = &self.contacts[*i as usize];
            let (other, side) = if c.bodies.1 == body { (c.bodies.0, 1.0) } else { (c.bodies.1, -1.0) };
            s.contact.push(tatu_contact {
                shape: [self.shape(other), self.shape(body)],
                point: c.point.coords.into(),
                normal: (side * c.normal).into(),
                force: c.force,
            });
            s.friction.push((side * c.friction).into());
        }
    }
}
