//! Which objects become bodies and joints of the engine, and how their states come back.
//!
//! The rule (V-REP's): a dynamic shape below a joint or force sensor that is below a shape is tied to that shape, by
//! the joint or rigidly; any other dynamic shape is free, wherever it hangs. A respondable static shape collides; it
//! is pose_writeback along when something above it can move.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_physics::{
    BeforeStep, BodyDesc, BodyId, Drive, Engine, EngineSettings, Gear, JointDesc, JointForm, JointId, JointKind,
    MassProps, MaterialPair, Motion, PairRule, Passive, Push, Rapier, Respond, Surface, Twist,
};

use super::{
    Data, Scene, Shape,
    body_rules::{motion_of, tie_of, top_shape},
    collision_parts, default_inertia, default_mass, is_endless,
    loops::LoopRecord,
    mechanisms,
    pose_writeback::Carried,
};

/// Faster than this hardly anything of a robot is, m/s,
const FAST: f64 = 100.0;
/// and none goes so far, m.
const FAR: f64 = 1000.0;

/// A body and the object it stands for, as that was when the body was made.
#[derive(Serialize, Deserialize)]
struct BodyRecord {
    id: BodyId,
    slot: u32,
    uid: u64,
    version: u64,
    motion: Motion,
    /// Where it was made, world, m.
    start: Vector3<f64>,
    /// Whether it was found far off or very fast.
    stray: bool,
}

/// A joint and the objects that it is made of.
#[derive(Serialize, Deserialize)]
pub(super) struct JointRecord {
    pub id: JointId,
    pub tie: u32,
    child: u32,
    version: u64,
    bodies: (BodyId, BodyId),
    frame_in_a: Isometry3<f64>,
    form: JointForm,
    geared: bool,
    /// Whether its load is measured.
    sensor: bool,
}

/// The engine and what stands for what in it.
pub struct Dynamics {
    pub(super) engine: Box<dyn Engine>,
    /// In order of ids.
    bodies: Vec<BodyRecord>,
    /// Those that are moved by hand or by what carries them, with their slots.
    kinematic: Vec<(BodyId, u32)>,
    /// In order of ids.
    pub(super) joints: Vec<JointRecord>,
    /// Loops that linked dummies close.
    pub(super) loops: Vec<LoopRecord>,
    /// Joints whose drive changed since the last step.
    pub(super) drives: Vec<u32>,
    /// Joints whose position target is under way.
    pub(super) courses: Vec<u32>,
    built: u64,
    moved: Vec<u32>,
    /// Pushes that act in the next engine step alone.
    pushes: Vec<Push>,
    /// Whether an advance is under way, step by step, and scripts are asked in between.
    between: bool,
    /// What poses are copied back to.
    pub(super) pose_writeback: Carried,
    /// Joints that follow others, and whom.
    followers: Vec<(u32, u32)>,
    /// Joints that are geared to others.
    pub(super) geared: Vec<(u32, u32)>,
    /// Force sensors that tie two bodies, with their slots.
    pub(super) force_sensors: Vec<(JointId, u32)>,
    settings: EngineSettings,
    /// Length of an engine step as the engine has it now, s.
    step: f64,
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

    /// Brings bodies and joints up to the scene: only what changed is made anew, so that the rest does not notice.
    pub fn settle(&mut self, scene: &mut Scene) {
        scene.settle();
        if self.built == scene.shape_version {
            return;
        }
        self.built = scene.shape_version;
        self.pose_writeback = Carried::default();
        self.followers = super::follow::followers(scene);
        self.geared = super::follow::geared(scene);
        let geared: BTreeSet<u32> = self.geared.iter().flat_map(|(a, b)| [*a, *b]).collect();
        self.engine.set_materials(&materials(scene));
        let twists: BTreeMap<u32, Twist> = self.bodies.iter().map(|b| (b.slot, self.engine.twist(b.id))).collect();
        let kept = |b: &BodyRecord| {
            scene.get(b.slot).is_some_and(|o| o.uid == b.uid && o.version == b.version)
                && motion_of(scene, b.slot) == Some(b.motion)
        };
        let forms = mechanisms::forms(scene);
        let gone: Vec<_> = self.bodies.iter().filter(|b| !kept(b)).map(|b| (b.id, b.slot, b.uid)).collect();
        let dead: BTreeSet<BodyId> = gone.iter().map(|g| g.0).collect();
        let alive = |id: BodyId| !dead.contains(&id);
        let tied = |j: &JointRecord| {
            alive(j.bodies.0)
                && alive(j.bodies.1)
                && scene.get(j.tie).is_some_and(|o| o.version == j.version)
                && tie_of(scene, j.child).is_some_and(|(_, tie)| tie == j.tie)
                && forms.get(&j.child) == Some(&j.form)
                && geared.contains(&j.tie) == j.geared
        };
        let loose: Vec<_> = self.joints.iter().filter(|j| !tied(j)).map(|j| (j.id, j.tie)).collect();
        let cut: BTreeSet<JointId> = loose.iter().map(|j| j.0).collect();
        self.joints.retain(|j| !cut.contains(&j.id));
        for (id, tie) in loose {
            self.engine.remove_joint(id);
            forget(scene, tie);
        }
        self.loosen_loops(scene, &alive);
        self.bodies.retain(|b| !dead.contains(&b.id));
        for (id, slot, uid) in gone {
            self.engine.remove_body(id);
            if scene.get(slot).is_some_and(|o| o.uid == uid) {
                forget(scene, slot);
            }
        }
        // Forms without end come last: in the engine's tree of boxes what comes after them finds no good place.
        let mut endless = Vec::new();
        scene.visit(|scene, slot| match scene.get(slot).and_then(|o| o.shape()).is_some_and(is_endless) {
            true => endless.push(slot),
            false => self.add_body(scene, slot, &twists),
        });
        for slot in endless {
            self.add_body(scene, slot, &twists);
        }
        let tied: BTreeSet<u32> = self.joints.iter().map(|j| j.child).collect();
        scene.visit(|scene, slot| {
            if !tied.contains(&slot) {
                self.add_tie(scene, slot, forms.get(&slot).copied().unwrap_or_default(), &geared);
            }
        });
        self.close_loops(scene);
        self.list_kinematic();
    }

    fn list_kinematic(&mut self) {
        let kinematic = self.bodies.iter().filter(|b| b.motion == Motion::Kinematic);
        self.kinematic = kinematic.map(|b| (b.id, b.slot)).collect();
        self.force_sensors = self.joints.iter().filter(|j| j.sensor).map(|j| (j.id, j.tie)).collect();
    }

    fn add_body(&mut self, scene: &mut Scene, slot: u32, twists: &BTreeMap<u32, Twist>) {
        let Some(motion) = motion_of(scene, slot) else { return };
        let Some(o) = scene.get(slot) else { return };
        let Some(shape) = o.shape().filter(|s| s.body.0.is_none()) else { return };
        let start = Twist { linear: shape.initial_velocity, angular: shape.initial_angular_velocity };
        let twist = twists.get(&slot).copied().unwrap_or(start);
        let desc = BodyDesc {
            pose: scene.world(slot),
            motion,
            mass: mass_props(shape),
            linear_velocity: twist.linear,
            angular_velocity: twist.angular,
            parts: if shape.respondable { collision_parts(shape) } else { Vec::new() },
            friction: shape.friction,
            restitution: shape.restitution,
            bullet: shape.bullet,
            damping: shape.damping,
            surface: surface(scene, shape),
            respond: Respond { mask: if shape.respondable { shape.mask } else { 0 }, tree: top_shape(scene, slot) },
        };
        let id = self.engine.add_body(&desc);
        let start = desc.pose.translation.vector;
        self.bodies.push(BodyRecord { id, slot, uid: o.uid, version: o.version, motion, start, stray: false });
        if let Some(Data::Shape(s)) = scene.get_mut(slot).map(|o| &mut o.data) {
            s.body.0 = Some(id);
        }
    }

    fn add_tie(&mut self, scene: &mut Scene, slot: u32, form: JointForm, geared: &BTreeSet<u32>) {
        let Some((above, tie)) = tie_of(scene, slot) else { return };
        let body = |s: u32| scene.get(s).and_then(|o| o.shape()).and_then(|s| s.body.0);
        let (Some(a), Some(b), Some(joint)) = (body(above), body(slot), scene.get(tie)) else { return };
        let (kind, limits, passive) = match &joint.data {
            Data::Joint(j) => {
                let kind = match j.kind {
                    super::JointType::Revolute if j.lead != 0.0 => JointKind::Screw(j.lead_per_radian()),
                    super::JointType::Revolute => JointKind::Revolute,
                    super::JointType::Prismatic => JointKind::Prismatic,
                    super::JointType::Spherical => JointKind::Spherical,
                };
                (kind, j.limits, j.passive)
            }
            _ => (JointKind::Fixed, None, Passive::default()),
        };
        let desc = JointDesc {
            a,
            b,
            frame_in_a: scene.world(above).inverse() * scene.world(tie),
            // The child hangs on the moved frame: at position 0 that frame is the joint's own.
            frame_in_b: scene.world(slot).inverse() * scene.frame(tie),
            kind,
            limits,
            form,
            passive,
            geared: geared.contains(&tie),
        };
        let sensor = matches!(joint.data, Data::ForceSensor(_));
        let Some(id) = self.engine.add_joint(&desc) else { return };
        self.joints.push(JointRecord {
            id,
            tie,
            child: slot,
            version: joint.version,
            bodies: (a, b),
            frame_in_a: desc.frame_in_a,
            form,
            geared: desc.geared,
            sensor,
        });
        match scene.get_mut(tie).map(|o| &mut o.data) {
            Some(Data::Joint(j)) => {
                j.id = Some(id);
                self.drives.push(tie);
            }
            Some(Data::ForceSensor(f)) => {
                f.id = Some(id);
                self.engine.measure(id);
            }
            _ => {}
        }
    }

    /// A joint's drive changed: told to the engine before the next step.
    pub fn drive_changed(&mut self, slot: u32) {
        self.drives.push(slot);
    }

    /// An object was placed by hand: it, and the bodies below it, are put there before the next step.
    pub fn moved(&mut self, slot: u32) {
        // A script that scans turns the same joint hundreds of times.
        if self.moved.last() != Some(&slot) {
            self.moved.push(slot);
        }
    }

    fn apply_changes(&mut self, scene: &Scene) {
        for slot in std::mem::take(&mut self.moved) {
            for s in scene.tree(slot) {
                let Some(o) = scene.get(s) else { continue };
                if let Some(id) = o.shape().and_then(|s| s.body.0) {
                    self.engine.set_pose(id, &scene.world(s));
                }
            }
        }
        self.apply_gears(scene);
        for (id, slot) in &self.kinematic {
            if scene.get(*slot).is_some() {
                self.engine.set_pose(*id, &scene.world(*slot));
            }
        }
    }

    /// Tells the engine what was set by hand since the last step, so that both are at one.
    pub fn prepare(&mut self, scene: &mut Scene) {
        self.settle(scene);
        super::follow::update(scene, &self.followers, &mut self.drives);
        self.apply_changes(scene);
    }

    /// Gears by joints of the engine; cheap where nothing changed.
    fn apply_gears(&mut self, scene: &Scene) {
        let gears = self.geared.iter().filter_map(|(slot, leader)| {
            let joint = scene.get(*slot)?.joint()?;
            let leader = scene.get(*leader)?.joint()?.id?;
            Some(Gear { joint: joint.id?, leader, ratio: joint.follow.factor, offset: joint.follow.offset })
        });
        let gears: Vec<Gear> = gears.collect();
        self.engine.set_gears(&gears);
    }

    /// In how many engine steps of equal length `dt` passes, none longer than the scene's.
    pub fn engine_steps(&self, dt: f64) -> u32 {
        if dt > 0.0 { (dt / self.settings.step - 1e-9).ceil().max(1.0) as u32 } else { 0 }
    }

    /// Lets `dt` pass in engine steps, then copies poses and joint states back. Objects whose bodies were lost.
    /// `before`, if there is one, is asked before each engine step for pushes that act in it.
    pub fn advance(&mut self, scene: &mut Scene, dt: f64, mut before: Option<&mut BeforeStep<'_>>) -> Vec<u32> {
        super::follow::update(scene, &self.followers, &mut self.drives);
        self.apply_changes(scene);
        let steps = self.engine_steps(dt);
        if steps > 0 {
            self.set_step(dt / f64::from(steps));
            self.plot_courses(scene, steps);
            for part in 0..steps {
                self.apply_drives(scene, part, steps);
                self.step_engine(part, steps, before.as_deref_mut());
                self.sample(scene);
            }
        }
        self.look(scene)
    }

    /// One of the engine steps in which `dt` passes, counted from 0, with the same bits as in [`Dynamics::advance`]. What
    /// was moved by hand between two of them is only seen by the first step of the next advance.
    pub fn advance_part(
        &mut self,
        scene: &mut Scene,
        dt: f64,
        part: u32,
        before: Option<&mut BeforeStep<'_>>,
    ) -> Vec<u32> {
        let steps = self.engine_steps(dt);
        if part == 0 {
            self.apply_changes(scene);
            self.set_step(dt / f64::from(steps.max(1)));
            self.plot_courses(scene, steps);
        }
        if part < steps {
            self.apply_drives(scene, part, steps);
            self.step_engine(part, steps, before);
            self.sample(scene);
        }
        self.look(scene)
    }

    fn step_engine(&mut self, part: u32, steps: u32, before: Option<&mut BeforeStep<'_>>) {
        if self.pushes.is_empty() {
            return self.engine.advance_part(part, steps, before);
        }
        let (mut pushes, mut before) = (std::mem::take(&mut self.pushes), before);
        let mut ask = |engine: &dyn Engine, step, out: &mut Vec<Push>| {
            out.append(&mut pushes);
            if let Some(before) = before.as_deref_mut() {
                let mut more = Vec::new();
                before(engine, step, &mut more);
                out.append(&mut more);
            }
        };
        self.engine.advance_part(part, steps, Some(&mut ask));
    }

    /// Whether scripts are asked between the engine steps of an advance from now on: what they push with acts in one step.
    pub fn set_between(&mut self, between: bool) {
        self.between = between;
    }

    /// Whatever an advance takes, exactly that passes.
    fn set_step(&mut self, step: f64) {
        if (step - self.step).abs() > 1e-12 {
            self.step = step;
            self.engine.configure(EngineSettings { step, ..self.settings });
        }
    }

    fn look(&mut self, scene: &mut Scene) -> Vec<u32> {
        let lost = self.engine.quarantined();
        self.copy_back(scene);
        self.sum_efforts(scene);
        lost.iter().filter_map(|b| self.object_of(*b)).collect()
    }

    /// How two shapes meet from the next engine step on.
    pub fn set_pair(&mut self, a: &Shape, b: &Shape, rule: Option<PairRule>) {
        if let (Some(a), Some(b)) = (a.body.0, b.body.0) {
            self.engine.set_pair(a, b, rule);
        }
    }

    /// What drives a joint in the next engine step, other than its own properties say.
    pub fn drive(&mut self, joint: &super::Joint, drive: Drive) {
        if let Some(id) = joint.id {
            self.engine.drive(id, drive);
        }
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

    /// Bodies that have become faster than 100 m/s or have come farther than 1 km from where they were made, each told
    /// once: slot, m/s, m.
    pub fn strays(&mut self, scene: &Scene) -> Vec<(u32, f64, f64)> {
        let mut found = Vec::new();
        for b in self.bodies.iter_mut().filter(|b| b.motion == Motion::Dynamic && !b.stray) {
            let way = (scene.world(b.slot).translation.vector - b.start).norm();
            let speed = self.engine.twist(b.id).linear.norm();
            if way > FAR || speed > FAST {
                b.stray = true;
                found.push((b.slot, speed, way));
            }
        }
        found
    }

    fn object_of(&self, body: BodyId) -> Option<u32> {
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

fn forget(scene: &mut Scene, slot: u32) {
    match scene.get_mut(slot).map(|o| &mut o.data) {
        Some(Data::Shape(s)) => s.body.0 = None,
        Some(Data::Joint(j)) => (j.id, j.course) = (None, None),
        Some(Data::ForceSensor(f)) => f.id = None,
        _ => {}
    }
}

/// The materials of the scene's friction pairs, in order; the engine knows them by their numbers, from 1.
fn material_names(scene: &Scene) -> BTreeSet<&str> {
    scene.friction_pairs.iter().flat_map(|p| p.materials.iter().map(String::as_str)).collect()
}

fn material(scene: &Scene, name: &str) -> u32 {
    material_names(scene).iter().position(|n| *n == name).map_or(0, |i| i as u32 + 1)
}

fn materials(scene: &Scene) -> Vec<MaterialPair> {
    let number = |name: &str| material(scene, name);
    let pair = |p: &super::FrictionPair| MaterialPair {
        materials: (number(&p.materials[0]), number(&p.materials[1])),
        friction: p.friction,
        restitution: p.restitution,
    };
    scene.friction_pairs.iter().map(pair).collect()
}

pub(super) fn surface(scene: &Scene, shape: &Shape) -> Surface {
    Surface { material: material(scene, &shape.material), ..shape.surface }
}

/// Mass properties of a shape, defaults filled in.
pub fn mass_props(shape: &Shape) -> MassProps {
    let mass = shape.mass.unwrap_or_else(|| default_mass(shape));
    let inertia = shape.inertia.map_or_else(|| default_inertia(shape, mass), |i| Matrix3::from_row_slice(&i));
    MassProps { mass, com: Point3::from(shape.com), inertia }
}
