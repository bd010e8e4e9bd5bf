//! Builds the dynamics: overrides by models, friction, drives and springs of joints, coupled joints, closed loops.

use std::collections::{BTreeMap, BTreeSet};

use tatu_plugin_api::safe::{Node, Result};

use crate::{
    read::{
        file::{FileObject, ObjectKind, VrepFile},
        joint::{self, Joint},
        material::Material,
        others::Dummy,
        shape::Shape,
    },
    report::ImportReport,
};

/// The bits of `model_property`, by which a model overrides properties of all its objects.
#[derive(Debug, Clone, Copy, Default)]
pub struct ModelOverrides(i32);

impl ModelOverrides {
    pub fn not_detectable(self) -> bool {
        self.0 & 0x8 != 0
    }
    pub fn not_dynamic(self) -> bool {
        self.0 & 0x20 != 0
    }
    pub fn not_respondable(self) -> bool {
        self.0 & 0x40 != 0
    }
    pub fn not_visible(self) -> bool {
        self.0 & 0x100 != 0
    }
}

/// The object tree of a file. Objects are identified by their handles in the file.
pub struct ObjectTree<'a> {
    objects: BTreeMap<i32, &'a FileObject>,
    overrides: BTreeMap<i32, ModelOverrides>,
    names: BTreeMap<i32, String>,
    /// Handles of the roots of trees that contain closed loops.
    loops: BTreeSet<i32>,
    /// The lowest suffix among the names in a model; -1 for scenes, and if any name has no suffix.
    pub lowest_suffix: i32,
}

impl<'a> ObjectTree<'a> {
    /// Builds the tree; `order` lists indices in the file, parents before children.
    pub fn new(file: &'a VrepFile, order: &[usize]) -> Self {
        let objects: BTreeMap<i32, &FileObject> = file.objects.iter().map(|o| (o.common.id, o)).collect();
        let mut overrides: BTreeMap<i32, ModelOverrides> = BTreeMap::new();
        let mut names = BTreeMap::new();
        // Index of each object among its siblings with the same alias.
        let mut count: BTreeMap<(i32, String), usize> = BTreeMap::new();
        for o in order.iter().map(|i| &file.objects[*i]) {
            let c = &o.common;
            let above = overrides.get(&c.parent).copied().unwrap_or_default();
            let own = if c.model_base { c.flags.model_property } else { 0 };
            overrides.insert(c.id, ModelOverrides(above.0 | own));
            let alias = c.alias().replace('/', "_");
            let n = count.entry((c.parent, alias.clone())).or_default();
            names.insert(c.id, format!("{alias}[{n}]"));
            *n += 1;
        }
        let suffix = |name: &String| name.rsplit_once('#').and_then(|(_, n)| n.parse().ok()).unwrap_or(-1);
        let suffixes = file.objects.iter().filter_map(|o| o.common.name.as_ref()).map(suffix);
        let lowest_suffix = if file.is_model() { suffixes.min().unwrap_or(-1) } else { -1 };
        let mut tree = ObjectTree { objects, overrides, names, loops: BTreeSet::new(), lowest_suffix };
        let closes = |o: &&FileObject| matches!(&o.kind, ObjectKind::Dummy(d) if d.link >= 0 && d.link_type == 0);
        tree.loops = file.objects.iter().filter(closes).map(|o| tree.root(o.common.id)).collect();
        tree
    }

    pub fn overrides(&self, o: &FileObject) -> ModelOverrides {
        self.overrides.get(&o.common.id).copied().unwrap_or_default()
    }

    /// Returns whether the tree to which an object belongs contains a closed loop.
    pub fn has_loop(&self, o: &FileObject) -> bool {
        self.loops.contains(&self.root(o.common.id))
    }

    /// Returns the handle of the root above an object.
    fn root(&self, id: i32) -> i32 {
        self.with_ancestors(id).into_iter().rev().find(|h| self.objects.contains_key(h)).unwrap_or(id)
    }

    /// Returns the handles of an object and all its ancestors, nearest first.
    pub fn with_ancestors(&self, id: i32) -> Vec<i32> {
        let mut out = vec![id];
        let mut at = id;
        while let Some(o) = self.objects.get(&at).filter(|_| out.len() <= self.objects.len()) {
            at = o.common.parent;
            out.push(at);
        }
        out
    }

    /// Returns the path of the object `to` relative to `from`, which remains valid when both are copied together. If
    /// they have no common ancestor, or if `to` is `from` or one of its ancestors, the path is absolute. Returns `None`
    /// if an object on the path does not exist.
    pub fn path(&self, from: i32, to: i32) -> Option<String> {
        let (ups, downs) = (self.with_ancestors(from), self.with_ancestors(to));
        let common = ups.iter().find(|h| **h >= 0 && downs.contains(h));
        let up = ups.iter().position(|h| Some(h) == common);
        let down = downs.iter().position(|h| Some(h) == common);
        let parts = |n: usize| downs[..n].iter().rev().map(|h| self.names.get(h).map(String::as_str)).collect();
        let Some((up, down)) = up.zip(down).filter(|(_, down)| *down > 0) else {
            let all: Option<Vec<&str>> = parts(downs.len().saturating_sub(1));
            return all.map(|names| format!("/{}", names.join("/")));
        };
        let names: Option<Vec<&str>> = parts(down);
        let begin = if up == 0 { ".".to_owned() } else { vec![".."; up].join("/") };
        names.map(|names| format!("{begin}/{}", names.join("/")))
    }
}

/// Sets friction, restitution and damping of a shape.
pub fn material(file: &VrepFile, s: &Shape, dynamic: bool, node: Node<'_>) -> Result {
    let root = s.root.as_ref();
    let listed = || file.materials.iter().find(|m| root.is_some_and(|r| r.material >= 0 && m.id == r.material));
    // Since 3.3.3, the shape's own material is used; earlier versions use the material in the list to which the mesh
    // refers.
    let own = s.material.as_ref().filter(|_| file.header.program >= 30_303);
    let Some(m) = own.or_else(listed).or(root.and_then(|r| r.own_material.as_ref())) else { return Ok(()) };
    let new_bullet = file.settings.engine == Some(0) && file.settings.engine_version == 283;
    let friction = match (is_sticky(m) && file.header.program < 30_301, dynamic) {
        // Materials that were sticky by a special feature of the old engine have this friction in current versions of
        // CoppeliaSim.
        (true, true) => Some(0.25),
        _ => m.bullet.real(if new_bullet { 2 } else { 1 }),
    };
    let known = |x: Option<f64>, low: f64, high: f64| x.filter(|x| x.is_finite()).map(|x| x.clamp(low, high));
    if let Some(friction) = known(friction, 0.0, 1e6) {
        node.set("shape.friction", friction)?;
    }
    if let Some(bounce) = known(m.bullet.real(0), 0.0, 1.0).filter(|x| *x > 0.0) {
        node.set("shape.restitution", bounce)?;
    }
    for (i, key) in [(3, "shape.linear_damping"), (4, "shape.angular_damping")] {
        // The file stores the fraction lost per second. Fractions above 0.999 are ignored: a fraction of 1 would mean
        // infinite damping.
        if let Some(share) = known(m.bullet.real(i), 0.0, 0.999).filter(|x| *x > 0.0) {
            node.set(key, -libm::log1p(-share))?;
        }
    }
    Ok(())
}

fn is_sticky(m: &Material) -> bool {
    m.bullet.int(0).is_some_and(|bits| bits & 1 != 0)
}

/// Default physics step of V-REP, s, with which gains of position control are converted: V-REP defines them per step.
const DEFAULT_STEP_S: f64 = 0.005;

/// Sets the properties of a joint: type, limits, motor, spring, and dependency on another joint.
pub fn joint(
    file: &VrepFile,
    tree: &ObjectTree<'_>,
    j: &Joint,
    o: &FileObject,
    node: Node<'_>,
    report: &mut ImportReport,
) -> Result {
    let kind = match j.kind {
        joint::PRISMATIC => "prismatic",
        joint::SPHERICAL => "spherical",
        _ => "revolute",
    };
    let hybrid = is_hybrid(j);
    let dynamic = (j.mode == 5 || hybrid) && !tree.overrides(o).not_dynamic();
    node.set("joint.type", kind)?.set("joint.mode", if dynamic { "dynamic" } else { "kinematic" })?;
    let sound = |x: f64| if x.is_finite() { x } else { 0.0 };
    if j.kind == joint::SPHERICAL {
        let [w, x, y, z] = j.rotation;
        let turned = j.rotation.iter().all(|x| x.is_finite()) && j.rotation.iter().any(|x| *x != 0.0);
        if turned && j.rotation != [1.0, 0.0, 0.0, 0.0] {
            node.set("joint.rotation", [x, y, z, w])?;
        }
        return Ok(());
    }
    let [low, range] = j.limits.map(sound);
    if !j.cyclic {
        node.set("joint.limits", [low, low + range.max(0.0)])?;
    }
    if j.pitch != 0.0 && j.pitch.is_finite() && j.kind == joint::REVOLUTE {
        node.set("joint.lead", j.pitch * std::f64::consts::TAU)?;
    }
    let control = if hybrid && dynamic { "position" } else { control(j) };
    // In hybrid operation, the joint's position is copied to its target before each step of physics.
    let target = if hybrid { j.position } else { j.drive.target_position };
    // `max_force` is not negative, because the reader has transferred its sign to the velocity.
    node.set("joint.position", sound(j.position))?
        .set("joint.target_velocity", sound(j.drive.target_velocity))?
        .set("joint.target_position", sound(target))?
        .set("joint.max_force", sound(j.drive.max_force))?
        .set("joint.control", control)?;
    // V-REP applies targets without smoothing.
    node.set("joint.smooth_target", false)?;
    let fastest = j.max_motion.map(|m| m[0]).or(j.old_max_velocity).filter(|x| x.is_finite() && *x > 0.0);
    if let Some(fastest) = fastest {
        node.set("joint.max_velocity", fastest)?;
    }
    match control {
        "position" => {
            let step = if file.settings.is_present { file.settings.physics_step().max(1e-5) } else { DEFAULT_STEP_S };
            let [p, i, d] = j.drive.pid.map(sound);
            // V-REP's gains determine the motion per physics step; division by the length of the step yields a
            // velocity.
            if p > 0.0 || i > 0.0 {
                node.set("joint.gains", [p / step, i / step, d / step])?;
            }
        }
        "spring" => {
            let [k, c] = j.drive.spring.map(|x| sound(x).max(0.0));
            node.set("joint.stiffness", k)?.set("joint.damping", c)?;
        }
        _ => {}
    }
    if matches!(j.mode, 3 | 4) {
        let (master, [factor, offset]) = (j.master.0, j.master.1.map(sound));
        match Some(master).filter(|m| *m >= 0).and_then(|m| tree.path(o.common.id, m)) {
            Some(path) => {
                node.set("joint.follows", path.as_str())?
                    .set("joint.follow_factor", factor)?
                    .set("joint.follow_offset", offset)?;
            }
            None => report.add(
                "without",
                "the joint on which the object depends is not in the file, so the dependency is ignored",
                o,
            ),
        }
    }
    Ok(())
}

/// Returns whether inverse kinematics sets the joint's position, which its motor then follows in physics.
fn is_hybrid(j: &Joint) -> bool {
    const INVERSE_KINEMATICS: i32 = 2;
    j.mode == INVERSE_KINEMATICS && j.drive.motor & 64 != 0 && j.kind != joint::SPHERICAL
}

/// Returns the control mode. The newer field takes precedence. In the older fields, position control requires that the
/// motor is enabled, and the spring requires position control.
fn control(j: &Joint) -> &'static str {
    match j.control {
        Some(1) => "force",
        Some(4) => "velocity",
        Some(8 | 9) => "position",
        Some(12 | 13) => "spring",
        Some(16) => "callback",
        Some(_) => "free",
        None if j.drive.motor & 16 == 0 => "free",
        None if j.drive.motor & 32 == 0 => "velocity",
        None if j.drive.motor & 128 != 0 => "spring",
        None => "position",
    }
}

/// Builds a dummy that closes a loop with another dummy. Both dummies store the link; that of the dummy with the lower
/// handle is used.
pub fn link(tree: &ObjectTree<'_>, d: &Dummy, o: &FileObject, node: Node<'_>, report: &mut ImportReport) -> Result {
    if d.link < 0 || d.link_type != 0 {
        return Ok(());
    }
    let back =
        tree.objects.get(&d.link).and_then(|o| if let ObjectKind::Dummy(d) = &o.kind { Some(d.link) } else { None });
    match back {
        Some(back) if back == o.common.id && d.link < o.common.id => Ok(()),
        Some(_) => match tree.path(o.common.id, d.link) {
            Some(path) => node.set("dummy.link", path.as_str()).map(drop),
            None => Ok(()),
        },
        None => {
            report.add(
                "without",
                "the dummy to which the object is linked is not in the file, so the link is ignored",
                o,
            );
            Ok(())
        }
    }
}
