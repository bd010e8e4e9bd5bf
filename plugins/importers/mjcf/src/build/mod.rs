//! Builds the model in the scene.
//!
//! - this module: the order of objects, and bodies that are fixed, free or moved by joints;
//! - `joints`: joints and the links between several joints of one body;
//! - `shapes`: shapes of bodies; `masks`: which of them collide with each other; `forms`: forms, colours and masses;
//! - `parts`: sites with sensors, cameras and lights;
//! - `loops`: constraints between bodies.

mod forms;
mod joints;
mod loops;
mod masks;
mod parts;
mod shapes;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Translation3};
use tatu_plugin_api::safe::{Builder, Node, Params, Result, Value};

use crate::{
    compiler::quaternion,
    drives::{Couplings, JointIndex},
    groups::{Attachment, BodyGroups},
    model::{Body, JointKind, Keyframe, Model, Sensor},
    report::ImportReport,
};

/// The settings that the parameters of the importer specify.
pub struct ImportSettings {
    pub keyframe: String,
    pub servos_hold: bool,
    pub self_collision: bool,
}

impl ImportSettings {
    pub fn read(params: &Params<'_>) -> Result<Self> {
        Ok(ImportSettings {
            keyframe: params.string("keyframe")?,
            servos_hold: params.string("servos")? == "hold",
            self_collision: params.bool("self_collision")?,
        })
    }
}

/// The state in which the model starts.
struct InitialState {
    /// Position of each joint: one number, or a quaternion w x y z.
    joints: BTreeMap<JointIndex, [f64; 4]>,
    /// Pose of each free body.
    free: BTreeMap<usize, Isometry3<f64>>,
}

/// An object of the scene and its path below the base.
#[derive(Clone)]
struct Placed<'b> {
    node: Node<'b>,
    path: String,
}

/// The names of objects.
struct NameTable {
    /// How often names are in use below a parent, which is given by its number.
    counts: BTreeMap<(u32, String), usize>,
    /// Names of bodies and joints.
    reserved: BTreeSet<String>,
}

impl NameTable {
    /// Returns a name that no other object below the parent has.
    fn free(&mut self, parent: u32, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        let first = self.counts.entry((parent, name.clone())).or_insert(0);
        *first += 1;
        let mut n = *first;
        while n > 1 {
            name = format!("{wanted}_{n}");
            let other = self.counts.entry((parent, name.clone())).or_insert(0);
            *other += 1;
            if *other == 1 {
                break;
            }
            n += 1;
        }
        name
    }
}

/// A build in progress.
struct ModelBuilder<'w, 'b> {
    builder: &'w Builder<'b>,
    model: &'w Model,
    groups: &'w BodyGroups,
    settings: &'w ImportSettings,
    report: &'w mut ImportReport,
    couplings: Couplings,
    start: InitialState,
    shapes: forms::ShapeMaker,
    /// The object of each body.
    bodies: Vec<Option<Placed<'b>>>,
    joints: BTreeMap<JointIndex, Placed<'b>>,
    /// Fixed shapes that carry the joints of bodies at the top level, by group.
    anchors: BTreeMap<usize, Placed<'b>>,
    names: NameTable,
    /// Sensors by the name of their site.
    sensors: BTreeMap<&'w str, Vec<&'w Sensor>>,
    /// The low byte of the mask of each group: see `masks`.
    low_masks: Vec<u8>,
    /// For groups at the top level that gears connect to others: the lowest of them.
    geared: BTreeMap<usize, usize>,
    /// Links between several joints of one body, by body: their number.
    links: BTreeMap<usize, usize>,
}

/// Builds the model.
pub fn model(builder: &Builder<'_>, model: &Model, settings: &ImportSettings, report: &mut ImportReport) -> Result {
    let groups = BodyGroups::new(model);
    let key = keyframe(model, settings, report);
    let start = initial_state(model, key, report);
    let controls = key.and_then(|k| k.controls.clone()).unwrap_or_default();
    let couplings = Couplings::new(model, &groups, &controls, settings.servos_hold, report);
    set_world(builder, model, report)?;
    let name = alias(&model.name, "model");
    let base = builder.object("dummy", None, &name)?.set("object.model_base", true)?;
    let mut work = ModelBuilder {
        builder,
        model,
        groups: &groups,
        settings,
        report,
        couplings,
        start,
        shapes: forms::ShapeMaker::default(),
        bodies: vec![None; model.bodies.len()],
        joints: BTreeMap::new(),
        anchors: BTreeMap::new(),
        names: NameTable { counts: BTreeMap::new(), reserved: model.bodies.iter().flat_map(names_of).collect() },
        sensors: BTreeMap::new(),
        low_masks: vec![0; groups.all.len()],
        geared: BTreeMap::new(),
        links: BTreeMap::new(),
    };
    for sensor in &model.sensors {
        work.sensors.entry(&sensor.site).or_default().push(sensor);
    }
    work.connect_tops();
    if settings.self_collision {
        work.choose_masks();
    }
    let base = Placed { node: base, path: String::new() };
    work.bodies[0] = Some(base.clone());
    work.world(&base)?;
    for group in 1..groups.all.len() {
        work.group(group, &base)?;
    }
    work.gears()?;
    work.loops(&base)?;
    work.summary();
    if builder.is_asked() {
        let text = |t: &str| Value::text(t);
        let bodies = work.describe();
        let map =
            vec![(text("bodies"), bodies), (text("joints"), work.describe_joints()), (text("report"), report.value())];
        builder.describe(&Value::Map(map))?;
    }
    Ok(())
}

/// Returns the aliases of a body and its joints.
fn names_of(body: &Body) -> impl Iterator<Item = String> {
    std::iter::once(&body.name).chain(body.joints.iter().map(|j| &j.name)).map(|name| alias(name, ""))
}

/// Sets what applies to the whole scene if the file is opened as one.
fn set_world(builder: &Builder<'_>, model: &Model, report: &mut ImportReport) -> Result {
    // The greater friction of a pair applies in MuJoCo.
    builder.setting("scene.friction_rule", "greatest")?;
    if let Some(gravity) = model.gravity {
        builder.setting("scene.gravity", gravity)?;
    }
    if let Some(step) = model.timestep.filter(|dt| *dt >= 1e-4 && *dt < 0.005) {
        builder.setting("scene.physics_dt", step)?;
    }
    report.note_file(
        "the friction of a pair is the greater one in MuJoCo: set `friction_rule = \"greatest\"` where the file is imported \
         into another scene, and its gravity and time step",
    );
    Ok(())
}

/// Returns the keyframe in which the model starts.
fn keyframe<'m>(model: &'m Model, settings: &ImportSettings, report: &mut ImportReport) -> Option<&'m Keyframe> {
    let found = model.keyframes.iter().find(|k| k.name == settings.keyframe && !k.name.is_empty());
    for key in &model.keyframes {
        match found {
            Some(found) if std::ptr::eq(found, key) => {}
            _ => report.note(&key.place, "keyframes other than the one in which the model starts are omitted"),
        }
    }
    let is_stated = !settings.keyframe.is_empty() && settings.keyframe != DEFAULT_KEYFRAME;
    if found.is_none() && is_stated {
        let names: Vec<&str> = model.keyframes.iter().map(|k| k.name.as_str()).collect();
        let text = format!("there is no keyframe `{}`; the file has: {}", settings.keyframe, names.join(", "));
        report.warn_file(text);
    }
    found
}

/// The keyframe in which models start if they have it.
pub const DEFAULT_KEYFRAME: &str = "home";

fn initial_state(model: &Model, key: Option<&Keyframe>, report: &mut ImportReport) -> InitialState {
    let mut state = InitialState { joints: BTreeMap::new(), free: BTreeMap::new() };
    let width = |kind: JointKind| if kind == JointKind::Ball { 4 } else { 1 };
    let count: usize =
        model.bodies.iter().map(|b| if b.is_free { 7 } else { b.joints.iter().map(|j| width(j.kind)).sum() }).sum();
    let positions = key.and_then(|k| Some((k.positions.as_ref()?, &k.place)));
    let positions = positions.filter(|(numbers, place)| {
        if numbers.len() != count {
            report.warn(place, format!("`qpos` has {} numbers instead of {count}, and is omitted", numbers.len()));
        }
        numbers.len() == count
    });
    let mut rest = positions.map_or(&[][..], |(numbers, _)| numbers.as_slice());
    let mut take = |n: usize| {
        let (taken, left) = rest.split_at_checked(n)?;
        rest = left;
        Some(taken)
    };
    for (b, body) in model.bodies.iter().enumerate() {
        if body.is_free {
            if let Some([x, y, z, q @ ..]) = take(7).and_then(|n| <[f64; 7]>::try_from(n).ok()) {
                let turn = quaternion(q).unwrap_or_default();
                state.free.insert(b, Isometry3::from_parts(Translation3::new(x, y, z), turn));
            }
            continue;
        }
        for (j, joint) in body.joints.iter().enumerate() {
            let taken = take(width(joint.kind));
            let start = match (joint.kind, taken) {
                (JointKind::Ball, Some(q)) => <[f64; 4]>::try_from(q).unwrap_or([1.0, 0.0, 0.0, 0.0]),
                (JointKind::Ball, None) => [1.0, 0.0, 0.0, 0.0],
                (_, Some(q)) => [q[0], 0.0, 0.0, 0.0],
                (_, None) => [joint.reference, 0.0, 0.0, 0.0],
            };
            state.joints.insert((b, j), start);
        }
    }
    state
}

/// Converts a name to an alias, which must not be empty or contain slashes.
fn alias(name: &str, default: &str) -> String {
    let clean: String = name.chars().map(|c| if c == '/' || c.is_control() { '_' } else { c }).collect();
    if clean.is_empty() { default.to_owned() } else { clean }
}

/// Sets the pose of an object relative to its parent.
fn set_pose<'a>(node: Node<'a>, pose: &Isometry3<f64>) -> Result<Node<'a>> {
    let q = pose.rotation.coords;
    node.set("object.position", <[f64; 3]>::from(pose.translation.vector))?
        .set("object.quaternion", [q.x, q.y, q.z, q.w])
}

impl<'b> ModelBuilder<'_, 'b> {
    /// Adds an object below another. Siblings get different names, and what is attached to bodies does not get the name
    /// of a body or joint, so that paths are unambiguous.
    fn object(&mut self, kind: &str, parent: &Placed<'b>, name: &str, pose: &Isometry3<f64>) -> Result<Placed<'b>> {
        let name = self.names.free(parent.node.id(), &alias(name, kind));
        let node = set_pose(self.builder.object(kind, Some(parent.node), &name)?, pose)?;
        Ok(Placed { node, path: format!("{}/{name}", parent.path) })
    }

    /// As `object`, for something that is attached to a body.
    fn attached(&mut self, kind: &str, parent: &Placed<'b>, name: &str, pose: &Isometry3<f64>) -> Result<Placed<'b>> {
        let is_taken = self.names.reserved.contains(&alias(name, kind));
        let name = if is_taken { format!("{name}_{kind}") } else { name.to_owned() };
        self.object(kind, parent, &name, pose)
    }

    /// Builds what is fixed to the world itself: one shape for each geom.
    fn world(&mut self, base: &Placed<'b>) -> Result {
        let world = &self.model.bodies[0];
        for (i, geom) in world.geoms.iter().enumerate() {
            let name = if geom.name.is_empty() { format!("geom_{i}") } else { geom.name.clone() };
            if !self.collides(geom) && !geom.is_shown() {
                continue;
            }
            let shape = self.attached("shape", base, &name, &geom.pose)?;
            self.single(shape.node, geom, 0)?;
        }
        self.parts(0, base, &Isometry3::identity())
    }

    /// Builds a group of bodies.
    fn group(&mut self, number: usize, base: &Placed<'b>) -> Result {
        let group = &self.groups.all[number];
        let body = &self.model.bodies[group.first];
        let (parent, pose) = match group.attachment {
            Attachment::Fixed => (base.clone(), group.pose),
            Attachment::Free => (base.clone(), self.start.free.get(&group.first).copied().unwrap_or(group.pose)),
            Attachment::Joints => {
                let above = match group.parent {
                    0 => self.anchor(number, base)?,
                    parent => self.bodies[self.groups.all[parent].first].clone().unwrap_or_else(|| base.clone()),
                };
                self.chain(number, above)?
            }
        };
        let shape = self.object("shape", &parent, &body.name, &pose)?;
        self.bodies[group.first] = Some(shape.clone());
        self.body_shape(number, &shape)?;
        for (other, pose) in group.bodies.iter().skip(1) {
            let dummy = self.object("dummy", &shape, &self.model.bodies[*other].name, pose)?;
            self.bodies[*other] = Some(dummy);
        }
        for (other, pose) in &group.bodies {
            self.parts(*other, &shape, pose)?;
        }
        Ok(())
    }

    /// Returns the fixed shape that carries the joints of a group at the top level. Groups that gears connect share one,
    /// because geared joints must belong to one mechanism.
    fn anchor(&mut self, number: usize, base: &Placed<'b>) -> Result<Placed<'b>> {
        let shared = self.geared.get(&number).copied().unwrap_or(number);
        if let Some(known) = self.anchors.get(&shared) {
            let known = known.clone();
            self.anchors.insert(number, known.clone());
            return Ok(known);
        }
        let name = format!("{}_base", self.model.bodies[self.groups.all[number].first].name);
        let anchor = self.object("shape", base, &name, &Isometry3::identity())?;
        forms::make_empty(anchor.node)?;
        self.anchors.insert(number, anchor.clone());
        self.anchors.insert(shared, anchor.clone());
        Ok(anchor)
    }

    /// Finds the groups at the top level that gears connect.
    fn connect_tops(&mut self) {
        let top = |(body, _): JointIndex| self.groups.all[self.groups.of_body[body].0].top;
        let mut lowest: BTreeMap<usize, usize> = BTreeMap::new();
        let find = |lowest: &BTreeMap<usize, usize>, mut at: usize| {
            while let Some(next) = lowest.get(&at).filter(|next| **next != at) {
                at = *next;
            }
            at
        };
        for (joint, gear) in &self.couplings.gears {
            let (a, b) = (find(&lowest, top(*joint)), find(&lowest, top(gear.leader)));
            if a != b {
                lowest.insert(a.max(b), a.min(b));
            }
        }
        self.geared = lowest.keys().map(|at| (*at, find(&lowest, *at))).collect();
    }

    /// Notes on how the whole model was translated.
    fn summary(&mut self) {
        if !self.settings.self_collision && !self.joints.is_empty() {
            self.report.note_file(
                "bodies of one mechanism do not collide with each other: see the parameter `self_collision`",
            );
        }
        let count = self.links.len();
        if count > 0 {
            self.report.note_file(format!(
                "{count} bodies have several joints: links of 1/10,000 of their mass were added between these, and \
                 the mass of the bodies was reduced accordingly"
            ));
        }
    }

    /// Describes all bodies in the order of MuJoCo's numbers.
    fn describe(&self) -> Value {
        let text = |t: &str| Value::text(t);
        let each = |(i, body): (usize, &Body)| {
            let (group, _) = self.groups.of_body[i];
            let path = |b: usize| self.bodies[b].as_ref().map(|p| p.path.clone()).unwrap_or_default();
            Value::Map(vec![
                (text("name"), text(&body.name)),
                (text("path"), text(&path(i))),
                (text("fixed_to"), text(&path(self.groups.all[group].first))),
                (text("links"), Value::Int(self.links.get(&i).copied().unwrap_or(0) as i64)),
            ])
        };
        Value::List(self.model.bodies.iter().enumerate().map(each).collect())
    }

    fn describe_joints(&self) -> Value {
        let text = |t: &str| Value::text(t);
        let each = |((body, joint), placed): (&JointIndex, &Placed<'_>)| {
            Value::Map(vec![
                (text("name"), text(&self.model.bodies[*body].joints[*joint].name)),
                (text("path"), text(&placed.path)),
                (text("body"), Value::Int(*body as i64)),
            ])
        };
        Value::List(self.joints.iter().map(each).collect())
    }
}
