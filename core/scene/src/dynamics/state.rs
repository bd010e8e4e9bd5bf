//! The engine, and what stands for what in it.

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_physics::{BodyId, Engine, EngineSettings, JointForm, JointId, Motion, Push, Rapier, Twist};

use crate::{object::Shape, tree::Scene};

/// A body and the object it stands for, as that was when the body was made.
#[derive(Serialize, Deserialize)]
pub(super) struct BodyRecord {
    pub(super) id: BodyId,
    pub(super) slot: u32,
    pub(super) uid: u64,
    pub(super) version: u64,
    pub(super) motion: Motion,
    /// Where it was made, world, m.
    pub(super) start: Vector3<f64>,
    /// Whether it was found far off or very fast.
    pub(super) stray: bool,
}

/// A joint and the objects that it is made of.
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
    /// Whether its load is measured.
    pub(super) sensor: bool,
}

/// The engine and what stands for what in it.
pub struct Dynamics {
    pub(super) engine: Box<dyn Engine>,
    /// In order of ids.
    pub(super) bodies: Vec<BodyRecord>,
    /// Those that are moved by hand or by what carries them, with their slots.
    pub(super) kinematic: Vec<(BodyId, u32)>,
    /// In order of ids.
    pub(super) joints: Vec<JointRecord>,
    /// Loops that linked dummies close.
    pub(super) loops: Vec<LoopRecord>,
    /// Joints whose drive changed since the last step.
    pub(super) drives: Vec<u32>,
    /// Joints whose position target is under way.
    pub(super) courses: Vec<u32>,
    pub(super) built: u64,
    pub(super) moved: Vec<u32>,
    /// Pushes that act in the next engine step alone.
    pub(super) pushes: Vec<Push>,
    /// Whether an advance is under way, step by step, and scripts are asked in between.
    pub(super) between: bool,
    /// What poses are copied back to.
    pub(super) pose_writeback: Carried,
    /// Joints that follow others, and whom.
    pub(super) followers: Vec<(u32, u32)>,
    /// Joints that are geared to others.
    pub(super) geared: Vec<(u32, u32)>,
    /// Force sensors that tie two bodies, with their slots.
    pub(super) force_sensors: Vec<(JointId, u32)>,
    pub(super) settings: EngineSettings,
    /// Length of an engine step as the engine has it now, s.
    pub(super) step: f64,
}

/// A loop of the engine.
#[derive(Serialize, Deserialize)]
pub(super) struct LoopRecord {
    pub(super) id: JointId,
    pub(super) dummies: (u32, u32),
    pub(super) versions: (u64, u64),
    pub(super) bodies: (BodyId, BodyId),
}

/// An object that moves with the engine.
pub(super) struct Place {
    pub(super) slot: u32,
    pub(super) parent: u32,
    pub(super) from: From,
}

/// What decides where it is.
pub(super) enum From {
    /// Its body.
    Body(BodyId),
    /// Its frame; its joint has a state too.
    Joint(JointId),
    /// Its frame.
    Frame,
}

/// The objects that move with the engine. All others are where they were put.
#[derive(Default)]
pub(super) struct Carried {
    /// Robot by robot, parents before children, without those that hang.
    pub(super) list: Vec<Place>,
    /// The version of the tree that it was made of; 0: of none.
    pub(super) listed: u64,
    /// The version at which all objects were gone through last: a change of the tree leaves places that do not follow
    /// from those above to the last bit.
    pub(super) whole: u64,
}

impl Carried {
    /// What a snapshot keeps.
    pub fn whole(&self) -> u64 {
        self.whole
    }
    /// After a snapshot.
    pub fn after(whole: u64) -> Self {
        Carried { whole, ..Carried::default() }
    }
}

impl Dynamics {
    /// An empty engine.
    pub fn new(settings: EngineSettings) -> Self {
        Dynamics {
            engine: Box::new(Rapier::new(settings)),
            bodies: Vec::new(),
            kinematic: Vec::new(),
            joints: Vec::new(),
            loops: Vec::new(),
            drives: Vec::new(),
            courses: Vec::new(),
            built: 0,
            moved: Vec::new(),
            pushes: Vec::new(),
            between: false,
            pose_writeback: Carried::default(),
            followers: Vec::new(),
            geared: Vec::new(),
            force_sensors: Vec::new(),
            settings,
            step: settings.step,
        }
    }

    pub(super) fn list_kinematic(&mut self) {
        let kinematic = self.bodies.iter().filter(|b| b.motion == Motion::Kinematic);
        self.kinematic = kinematic.map(|b| (b.id, b.slot)).collect();
        self.force_sensors = self.joints.iter().filter(|j| j.sensor).map(|j| (j.id, j.tie)).collect();
    }

    /// Everything as bytes, for [`Dynamics::restore`].
    pub fn snapshot(&self) -> Vec<u8> {
        let Dynamics {
            engine,
            bodies,
            kinematic: _,
            joints,
            loops,
            drives,
            courses,
            built,
            moved,
            pushes,
            between: _,
            pose_writeback,
            followers,
            geared,
            force_sensors: _,
            settings,
            step,
        } = self;
        let all = (
            engine.snapshot(),
            bodies,
            (joints, loops),
            (drives, courses),
            built,
            (moved, pushes),
            pose_writeback.whole(),
            (followers, geared),
            settings,
            step,
        );
        postcard::to_stdvec(&all).unwrap_or_default()
    }

    /// Takes it back. After a failure nothing has changed.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        type Tables = (Vec<BodyRecord>, (Vec<JointRecord>, Vec<LoopRecord>), (Vec<u32>, Vec<u32>));
        type Pairs = Vec<(u32, u32)>;
        type All = (Vec<u8>, Tables, u64, (Vec<u32>, Vec<Push>), u64, (Pairs, Pairs), EngineSettings, f64);
        let (engine, tables, built, (moved, pushes), whole, (followers, geared), settings, step): All =
            postcard::from_bytes(bytes).map_err(|e| format!("the table of bodies: {e}"))?;
        self.engine.restore(&engine)?;
        let (bodies, (joints, loops), (drives, courses)) = tables;
        (self.bodies, self.joints, self.built) = (bodies, joints, built);
        (self.drives, self.courses) = (drives, courses);
        self.loops = loops;
        (self.pushes, self.between) = (pushes, false);
        (self.moved, self.pose_writeback) = (moved, Carried::after(whole));
        (self.followers, self.geared, self.settings, self.step) = (followers, geared, settings, step);
        self.list_kinematic();
        Ok(())
    }

    pub(super) fn object_of(&self, body: BodyId) -> Option<u32> {
        // Bodies are made in ascending order of ids.
        self.bodies.binary_search_by_key(&body, |b| b.id).ok().map(|i| self.bodies[i].slot)
    }

    /// The engine, for looking at bodies and joints.
    pub fn engine(&self) -> &dyn Engine {
        &*self.engine
    }
    /// The bodies above and below a joint of the engine, and its frame in the one above.
    pub fn tie(&self, joint: JointId) -> Option<((BodyId, BodyId), Isometry3<f64>)> {
        // Joints are made in ascending order of ids.
        let i = self.joints.binary_search_by_key(&joint, |j| j.id).ok()?;
        Some((self.joints[i].bodies, self.joints[i].frame_in_a))
    }
    /// Velocity of a shape that has a body.
    pub fn twist(&self, shape: &Shape) -> Option<Twist> {
        shape.body.0.map(|b| self.engine.twist(b))
    }
    /// Sets it.
    pub fn set_twist(&mut self, body: BodyId, twist: &Twist) {
        self.engine.set_twist(body, twist);
    }
    /// Force N and torque N m, world, asked for by a script or a service: for the next advance, or within one for the next
    /// engine step.
    pub fn ask_push(&mut self, body: BodyId, force: nalgebra::Vector3<f64>, torque: nalgebra::Vector3<f64>) {
        match self.between {
            true => self.pushes.push(Push { body, force, torque }),
            false => self.engine.push(body, force, torque),
        }
    }
    /// Force N and torque N m, world, for the next advance, or the rest of the one under way.
    pub fn push(&mut self, body: BodyId, force: nalgebra::Vector3<f64>, torque: nalgebra::Vector3<f64>) {
        self.engine.push(body, force, torque);
    }
    /// Contacts after the last step, as objects. Read from the engine when asked for. Those of objects that were removed
    /// since are left out: their bodies go with the next step.
    pub fn contacts(&self, scene: &Scene) -> impl Iterator<Item = (u32, u32, tatu_physics::Contact)> {
        let mut all = Vec::new();
        self.engine.contacts(&mut all);
        let living = |body| {
            let record = &self.bodies[self.bodies.binary_search_by_key(&body, |b| b.id).ok()?];
            scene.get(record.slot).is_some_and(|o| o.uid == record.uid).then_some(record.slot)
        };
        all.into_iter().filter_map(move |c| Some((living(c.bodies.0)?, living(c.bodies.1)?, c)))
    }
    /// Changes gravity or the length of an engine step.
    pub fn configure(&mut self, settings: EngineSettings) {
        self.settings = settings;
        self.engine.configure(EngineSettings { step: self.step, ..settings });
    }
    /// Velocities of all dynamic bodies with their objects, in order of bodies.
    pub fn twists(&self) -> impl Iterator<Item = (u32, Twist)> + '_ {
        self.bodies.iter().filter(|b| b.motion == Motion::Dynamic).map(|b| (b.slot, self.engine.twist(b.id)))
    }
}
