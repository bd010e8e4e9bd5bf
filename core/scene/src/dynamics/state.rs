//! The engine, and the mapping between its bodies and joints and the scene's objects.

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_physics::{BodyId, BodyWrench, Engine, EngineSettings, JointForm, JointId, MotionType, Rapier, Twist};

use crate::{notices::NoticeQueue, object::Shape, tree::Scene};

/// A body, with the object that it represents and the state of that object when the body was created.
#[derive(Serialize, Deserialize)]
pub(super) struct BodyRecord {
    pub(super) id: BodyId,
    pub(super) slot: u32,
    pub(super) uid: u64,
    pub(super) version: u64,
    pub(super) motion: MotionType,
    /// Initial position in the world frame, m.
    pub(super) start: Vector3<f64>,
    /// Whether the body has been reported as too far away or too fast.
    pub(super) stray: bool,
}

/// A joint of the engine, with the object that it represents, `tie`, and the shape below that object, `child`.
#[derive(Serialize, Deserialize)]
pub(super) struct JointRecord {
    pub(super) id: JointId,
    pub(super) tie: u32,
    pub(super) child: u32,
    pub(super) version: u64,
    pub(super) bodies: (BodyId, BodyId),
    pub(super) frame_in_a: Isometry3<f64>,
    pub(super) form: JointForm,
    pub(super) geared: bool,
    /// Whether the joint represents a force sensor, whose load is measured.
    pub(super) sensor: bool,
}

/// The engine, and the mapping between its bodies and joints and the scene's objects.
pub struct Dynamics {
    pub(super) engine: Box<dyn Engine>,
    /// Bodies, in ascending order of ids.
    pub(super) bodies: Vec<BodyRecord>,
    /// Kinematic bodies, which are moved by scripts or by their parents, with the slots of their shapes.
    pub(super) kinematic: Vec<(BodyId, u32)>,
    /// Joints, in ascending order of ids.
    pub(super) joints: Vec<JointRecord>,
    pub(super) couplings: JointCouplings,
    /// Slots of joints whose drive, and of shapes whose surface, has changed since the last step.
    pub(super) drives: Vec<u32>,
    /// Slots of joints whose position target is still moving.
    pub(super) moving_targets: Vec<u32>,
    pub(super) built_version: u64,
    pub(super) moved: Vec<u32>,
    /// Pushes that act in the next engine step only.
    pub(super) pushes: Vec<BodyWrench>,
    /// Whether an advance is in progress that calls scripts between engine steps.
    pub(super) scripts_between_steps: bool,
    /// The objects whose poses are copied back from the engine.
    pub(super) pose_writeback: WritebackList,
    /// Joints that represent force sensors, with the slots of the sensors.
    pub(super) force_sensors: Vec<(JointId, u32)>,
    pub(super) settings: EngineSettings,
    /// Current length of an engine step, s.
    pub(super) step: f64,
    /// Warnings about the scene; not part of snapshots.
    pub(super) notices: NoticeQueue,
}

/// Relations between joints other than those of parent and child.
pub(super) struct JointCouplings {
    /// Loops closed by linked dummies.
    pub(super) loops: Vec<LoopRecord>,
    /// Joints that follow other joints, with their leaders, as pairs of slots.
    pub(super) followers: Vec<(u32, u32)>,
    /// Joints that are geared to other joints, with their leaders, as pairs of slots.
    pub(super) geared: Vec<(u32, u32)>,
}

/// A loop that is closed in the engine.
#[derive(Serialize, Deserialize)]
pub(super) struct LoopRecord {
    pub(super) id: JointId,
    pub(super) dummies: (u32, u32),
    pub(super) versions: (u64, u64),
    pub(super) bodies: (BodyId, BodyId),
    /// Slots of the shapes that the bodies represent; 0 for an anchor, which belongs to the loop.
    pub(super) carriers: (u32, u32),
}

/// An object whose pose depends on the engine's state.
pub(super) struct PoseUpdate {
    pub(super) slot: u32,
    pub(super) parent: u32,
    pub(super) from: PoseSource,
}

/// The source of an object's pose.
pub(super) enum PoseSource {
    /// The object's body.
    Body(BodyId),
    /// The parent's frame; the object is a joint whose state is copied as well.
    Joint(JointId),
    /// The parent's frame.
    Frame,
}

/// The objects whose poses depend on the engine's state. The poses of all other objects do not change in a step.
#[derive(Default)]
pub(super) struct WritebackList {
    /// The objects in depth-first order, without those whose world pose is computed on demand.
    pub(super) list: Vec<PoseUpdate>,
    /// The version of the tree for which the list was built; 0 if it was not built.
    pub(super) listed_version: u64,
    /// The version of the tree for which all objects were last visited. This is necessary after each change of the
    /// tree, when stored poses can differ in the last bits from those computed from the poses of the parents.
    pub(super) visited_version: u64,
}

impl WritebackList {
    /// Returns the version in `visited_version`, the only part that a snapshot contains.
    pub fn visited_version(&self) -> u64 {
        self.visited_version
    }
    /// Creates the value for a version of the tree for which all objects have been visited, such as that in a snapshot.
    pub fn visited_at(whole: u64) -> Self {
        WritebackList { visited_version: whole, ..WritebackList::default() }
    }
}

impl Dynamics {
    /// Creates the mapping with an empty engine.
    pub fn new(settings: EngineSettings) -> Self {
        Dynamics {
            engine: Box::new(Rapier::new(settings)),
            bodies: Vec::new(),
            kinematic: Vec::new(),
            joints: Vec::new(),
            couplings: JointCouplings { loops: Vec::new(), followers: Vec::new(), geared: Vec::new() },
            drives: Vec::new(),
            moving_targets: Vec::new(),
            built_version: 0,
            moved: Vec::new(),
            pushes: Vec::new(),
            scripts_between_steps: false,
            pose_writeback: WritebackList::default(),
            force_sensors: Vec::new(),
            settings,
            step: settings.step,
            notices: NoticeQueue::default(),
        }
    }

    pub(super) fn list_kinematic(&mut self) {
        let kinematic = self.bodies.iter().filter(|b| b.motion == MotionType::Kinematic);
        self.kinematic = kinematic.map(|b| (b.id, b.slot)).collect();
        self.force_sensors = self.joints.iter().filter(|j| j.sensor).map(|j| (j.id, j.tie)).collect();
    }

    /// Returns the complete state as bytes, for [`Dynamics::restore`].
    pub fn snapshot(&self) -> Result<Vec<u8>, String> {
        let Dynamics {
            engine,
            bodies,
            kinematic: _,
            joints,
            couplings: JointCouplings { loops, followers, geared },
            drives,
            moving_targets: courses,
            built_version: built,
            moved,
            pushes,
            scripts_between_steps: _,
            pose_writeback,
            force_sensors: _,
            settings,
            step,
            notices: _,
        } = self;
        let all = (
            engine.snapshot(),
            bodies,
            (joints, loops),
            (drives, courses),
            built,
            (moved, pushes),
            pose_writeback.visited_version(),
            (followers, geared),
            settings,
            step,
        );
        postcard::to_stdvec(&all).map_err(|e| format!("cannot write the table of bodies: {e}"))
    }

    /// Restores a state from [`Dynamics::snapshot`]. On failure, nothing is changed.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        type RecordTables = (Vec<BodyRecord>, (Vec<JointRecord>, Vec<LoopRecord>), (Vec<u32>, Vec<u32>));
        type SlotPairs = Vec<(u32, u32)>;
        type SnapshotParts =
            (Vec<u8>, RecordTables, u64, (Vec<u32>, Vec<BodyWrench>), u64, (SlotPairs, SlotPairs), EngineSettings, f64);
        let (engine, tables, built, (moved, pushes), whole, (followers, geared), settings, step): SnapshotParts =
            postcard::from_bytes(bytes).map_err(|e| format!("cannot read the table of bodies: {e}"))?;
        self.engine.restore(&engine)?;
        let (bodies, (joints, loops), (drives, courses)) = tables;
        (self.bodies, self.joints, self.built_version) = (bodies, joints, built);
        (self.drives, self.moving_targets) = (drives, courses);
        self.couplings.loops = loops;
        (self.pushes, self.scripts_between_steps) = (pushes, false);
        (self.moved, self.pose_writeback) = (moved, WritebackList::visited_at(whole));
        (self.couplings.followers, self.couplings.geared, self.settings, self.step) =
            (followers, geared, settings, step);
        self.list_kinematic();
        Ok(())
    }

    pub(super) fn object_of(&self, body: BodyId) -> Option<u32> {
        // Bodies are created in ascending order of ids.
        self.bodies.binary_search_by_key(&body, |b| b.id).ok().map(|i| self.bodies[i].slot)
    }

    /// Returns the engine, for queries about bodies and joints.
    pub fn engine(&self) -> &dyn Engine {
        &*self.engine
    }
    /// Returns the bodies above and below a joint of the engine, and the joint's frame in the upper body.
    pub fn bodies_of_joint(&self, joint: JointId) -> Option<((BodyId, BodyId), Isometry3<f64>)> {
        // Joints are created in ascending order of ids.
        let i = self.joints.binary_search_by_key(&joint, |j| j.id).ok()?;
        Some((self.joints[i].bodies, self.joints[i].frame_in_a))
    }
    /// Returns the velocity of a shape, or `None` if the shape has no body.
    pub fn twist(&self, shape: &Shape) -> Option<Twist> {
        shape.body.0.map(|b| self.engine.twist(b))
    }
    /// Sets the velocity of a body.
    pub fn set_twist(&mut self, body: BodyId, twist: &Twist) {
        self.engine.set_twist(body, twist);
    }
    /// Adds a force (N) and a torque (N m) in the world frame, requested by a script or a service. They act during the
    /// next advance or, if one is running, during the next engine step.
    pub fn push_from_script(&mut self, body: BodyId, force: nalgebra::Vector3<f64>, torque: nalgebra::Vector3<f64>) {
        match self.scripts_between_steps {
            true => self.pushes.push(BodyWrench { body, force, torque }),
            false => self.engine.push(body, force, torque),
        }
    }
    /// Adds a force (N) and a torque (N m) in the world frame for the next advance, or for the rest of the current one.
    pub fn push(&mut self, body: BodyId, force: nalgebra::Vector3<f64>, torque: nalgebra::Vector3<f64>) {
        self.engine.push(body, force, torque);
    }
    /// Returns all bodies with the slots of their objects, in ascending order of ids.
    pub fn shapes(&self) -> impl Iterator<Item = (BodyId, u32)> + '_ {
        self.bodies.iter().map(|b| (b.id, b.slot))
    }
    /// Returns the contacts after the last step, with the slots of both objects. Contacts of objects that have been
    /// removed since then are left out, although their bodies still exist until the next step.
    pub fn contacts(&self, scene: &Scene) -> impl Iterator<Item = (u32, u32, tatu_physics::BodyContact)> {
        let mut all = Vec::new();
        self.engine.contacts(&mut all);
        let living = |body| {
            let record = &self.bodies[self.bodies.binary_search_by_key(&body, |b| b.id).ok()?];
            scene.get(record.slot).is_some_and(|o| o.uid == record.uid).then_some(record.slot)
        };
        all.into_iter().filter_map(move |c| Some((living(c.bodies.0)?, living(c.bodies.1)?, c)))
    }
    /// Returns the engine's settings.
    pub fn settings(&self) -> &EngineSettings {
        &self.settings
    }
    /// Replaces the engine's settings, with effect from the next engine step. The length of an engine step, however,
    /// changes only with the next advance.
    pub fn configure(&mut self, settings: EngineSettings) {
        self.settings = settings;
        self.engine.configure(EngineSettings { step: self.step, ..settings });
    }
    /// Returns the slots and velocities of all dynamic bodies, in ascending order of ids.
    pub fn twists(&self) -> impl Iterator<Item = (u32, Twist)> + '_ {
        self.bodies.iter().filter(|b| b.motion == MotionType::Dynamic).map(|b| (b.slot, self.engine.twist(b.id)))
    }
}
