//! Builds the robot in the scene as a tree in which shapes and joints alternate.
//!
//! The shape of a body has its collision geometry and mass, and its visuals are child shapes. The collision geometry is
//! visible only if the body has no visuals.

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::merge_pieces;
use tatu_plugin_api::{
    abi::{TATU_REPORT_NOTE, TATU_REPORT_WARNING},
    safe::{Builder, Fail, Node, Params, Result, Value},
};

use crate::{
    form::{MeshCache, PlacedSolid, SolidForm, set_object_pose},
    mass::Mass,
    robot::{Joint, LinkShape, Robot, UrdfJointKind},
    tree::{BodyTree, LinkGroup, check_finite, pose},
};

/// Collision mask of a link. A link collides with everything except other links of the same robot, because these touch
/// at joints.
const COLLISION_MASK: i64 = 0xFF00;

/// The settings that the parameters of the importer specify.
pub struct ImportSettings {
    fixed_base: bool,
    package_root: String,
    motors: String,
    friction: f64,
    wheels_as_balls: bool,
}

impl ImportSettings {
    /// Reads the parameters; if `fixed_base` is missing, it is true if the root link is named `world`.
    pub fn read(params: &Params<'_>, robot: &Robot, tree: &BodyTree) -> Result<Self> {
        let root = &robot.links[tree.bodies[0].links[0].0];
        Ok(ImportSettings {
            fixed_base: params.get("fixed_base")?.as_bool().unwrap_or(root.name == "world"),
            package_root: params.string("package_root")?,
            motors: params.string("motors")?,
            friction: params.f64("link_friction")?,
            wheels_as_balls: params.bool("wheels_as_balls")?,
        })
    }
}

/// A geometry, the alias of its object, and its color and opacity in the file.
type NamedSolid = (PlacedSolid, String, Option<[f64; 4]>);

/// The data that the functions that build a body share.
struct BodyBuilder<'w, 'b> {
    builder: &'w Builder<'b>,
    robot: &'w Robot,
    settings: &'w ImportSettings,
    meshes: MeshCache,
}

/// Builds the robot, starting with the body of the root link.
pub fn robot(builder: &Builder<'_>, robot: &Robot, tree: &BodyTree, settings: &ImportSettings) -> Result {
    let masses: Vec<Mass> = tree.bodies.iter().map(|b| mass(b, robot)).collect::<Result<_>>()?;
    let total: f64 = masses.iter().map(|m| m.mass).sum();
    let mut work = BodyBuilder { builder, robot, settings, meshes: MeshCache::default() };
    let mut nodes: Vec<Node<'_>> = Vec::with_capacity(tree.bodies.len());
    for (i, body) in tree.bodies.iter().enumerate() {
        let mut parent = None;
        if let Some((j, above, frame)) = &body.joint {
            let source = &robot.joints[*j];
            let made = joint(builder, nodes[*above], source, frame, settings);
            let made = made.map_err(|e| with_line(e, source.line))?;
            if is_geared(robot, *j) {
                add_armature(builder, made, source, body, &masses[i])?;
            }
            parent = Some(made);
        }
        let line = robot.links[body.links[0].0].line;
        let node = work.body(body, parent, &masses[i], total);
        nodes.push(node.map_err(|e| with_line(e, line))?);
    }
    report_unsupported(builder, robot, tree);
    Ok(())
}

/// Adds the line number to an error without a position.
fn with_line(e: Fail, line: u64) -> Fail {
    if e.place().is_some() { e } else { e.at("", line) }
}

/// Converts a name to an alias, which must not contain slashes.
fn alias(name: &str) -> String {
    name.replace('/', "_")
}

fn mass(body: &LinkGroup, robot: &Robot) -> Result<Mass> {
    body.links
        .iter()
        .try_fold(Mass::ZERO, |sum, (link, frame)| Ok(sum.combined_with(&Mass::of(&robot.links[*link], frame)?)))
}

fn joint<'a>(
    builder: &Builder<'a>,
    parent: Node<'a>,
    joint: &Joint,
    frame: &Isometry3<f64>,
    settings: &ImportSettings,
) -> Result<Node<'a>> {
    let (limit, line) = (&joint.limit, joint.line);
    let what = format!("limit of the joint `{}`", joint.name);
    if [limit.lower, limit.upper, limit.effort, limit.velocity].iter().any(|x| x.is_nan()) {
        return Err(Fail::argument(format!("{what}: expected numbers, found NaN")).at("", line));
    }
    let slides = joint.kind == UrdfJointKind::Prismatic;
    let node = builder.object("joint", Some(parent), &alias(&joint.name))?;
    let node = set_object_pose(node, frame)?
        .set("joint.type", if slides { "prismatic" } else { "revolute" })?
        .set("joint.mode", "dynamic")?;
    if joint.kind != UrdfJointKind::Continuous && (limit.lower.is_finite() || limit.upper.is_finite()) {
        if limit.lower > limit.upper {
            let text = format!("{what}: `lower` is {}, but `upper` is {}", limit.lower, limit.upper);
            return Err(Fail::argument(text).help("`lower` must not be greater than `upper`").at("", line));
        }
        if limit.lower == limit.upper {
            builder.report(
                TATU_REPORT_WARNING,
                Some(node),
                "the lower and the upper limit of the joint are equal, so it cannot move",
            );
        }
        node.set("joint.limits", [limit.lower.max(-1e6), limit.upper.min(1e6)])?;
    }
    let effort = limit.effort.abs().min(1e9);
    let control = if effort > 0.0 { settings.motors.as_str() } else { "free" };
    node.set("joint.control", control)?.set("joint.max_force", effort)?;
    if limit.velocity > 0.0 {
        node.set("joint.max_velocity", limit.velocity.min(1e6))?;
    }
    if let Some(d) = &joint.dynamics {
        let positive = |x: f64| if x.is_finite() { x.max(0.0) } else { 0.0 };
        node.set("joint.damping", positive(d.damping))?.set("joint.dry_friction", positive(d.friction))?;
    }
    if let Some(mimic) = &joint.mimic {
        let number = |x: Option<f64>, or: f64| x.filter(|x| x.is_finite()).unwrap_or(or);
        node.set("joint.follows", format!(":/{}", alias(&mimic.joint)).as_str())?
            .set("joint.follow_factor", number(mimic.multiplier, 1.0))?
            .set("joint.follow_offset", number(mimic.offset, 0.0))?
            .set("joint.geared", true)?;
    }
    Ok(node)
}

/// Returns whether a joint mimics another joint, or is mimicked by one.
fn is_geared(robot: &Robot, joint: usize) -> bool {
    let name = &robot.joints[joint].name;
    let mimics = |j: &Joint| j.mimic.as_ref().is_some_and(|m| m.joint == *name);
    robot.joints[joint].mimic.is_some() || robot.joints.iter().any(mimics)
}

/// Mass below which a link whose joint is coupled to another joint gets an armature, kg.
const LIGHT_LINK_KG: f64 = 0.1;
/// Point mass at the end of such a link to which the armature is equivalent, kg. It represents the rotor of the motor,
/// which URDF files do not describe. Without it, coupled fingers of 15 g cannot hold 0.2 kg at every closing speed;
/// with it, they can hold 0.5 kg.
const ROTOR_MASS_KG: f64 = 0.05;

fn add_armature(builder: &Builder<'_>, node: Node<'_>, joint: &Joint, body: &LinkGroup, mass: &Mass) -> Result {
    if mass.mass <= 0.0 || mass.mass >= LIGHT_LINK_KG {
        return Ok(());
    }
    let centre = body.below * nalgebra::Point3::from(mass.com);
    // A uniform rod is twice as long as the distance from its end to its centre of mass.
    let length = 2.0 * centre.coords.xy().norm();
    let (armature, unit) = match joint.kind {
        UrdfJointKind::Prismatic => (ROTOR_MASS_KG, "kg"),
        _ => (ROTOR_MASS_KG * length * length, "kg m^2"),
    };
    node.set("joint.armature", armature)?;
    let text = format!(
        "the joint is coupled, and its link weighs only {:.0} g: an armature of {armature:.2e} {unit} is assumed, so \
         that grasps are stable; set `armature_kg` or `armature_kg_m2` to the value of its motor",
        mass.mass * 1e3
    );
    builder.report(TATU_REPORT_NOTE, Some(node), &text);
    Ok(())
}

impl<'b> BodyBuilder<'_, 'b> {
    fn body(&mut self, body: &LinkGroup, parent: Option<Node<'b>>, mass: &Mass, total: f64) -> Result<Node<'b>> {
        let (builder, robot) = (self.builder, self.robot);
        let root = parent.is_none();
        // The base has the name of the robot. The root link is a child of the base, like every link that is fixed to
        // another link.
        let name = if root { &robot.name } else { &robot.links[body.links[0].0].name };
        let name = if name.is_empty() { "robot" } else { name };
        let node = builder.object("shape", parent, &alias(name))?;
        set_object_pose(node, &body.below)?;
        let colliding = self.solids(body, node, false)?;
        let seen = self.solids(body, node, true)?;
        let shown = seen.is_empty() && !colliding.is_empty();
        node.set("object.visible", shown)?.set("shape.detectable", shown)?;
        if !colliding.is_empty() {
            self.set_collision_geometry(body, node, &colliding)?;
        }
        if !(root && self.settings.fixed_base) {
            self.set_mass(node, name, mass, total)?;
        }
        for (solid, alias_, color) in &seen {
            let look = builder.object("shape", Some(node), alias_)?;
            solid.shape(builder, look, *color, &mut self.meshes)?;
        }
        for (link, frame) in body.links.iter().skip(usize::from(!root)) {
            set_object_pose(builder.object("dummy", Some(node), &alias(&robot.links[*link].name))?, frame)?;
        }
        Ok(node)
    }

    /// Returns the collision geometry of a body, or its visuals if `seen` is set, each with a name and its color in the
    /// file.
    fn solids(&mut self, body: &LinkGroup, node: Node<'b>, seen: bool) -> Result<Vec<NamedSolid>> {
        let mut out = Vec::new();
        for (link, frame) in &body.links {
            let link = &self.robot.links[*link];
            let line = link.line;
            let (role, parts) = if seen { ("visual", &link.visuals) } else { ("collision", &link.collisions) };
            for (i, part) in parts.iter().enumerate() {
                let color = self.color(part);
                let what = format!("{role} of the link `{}`", link.name);
                let at = frame * pose(&part.origin, &what, line)?;
                let source = (self.builder, self.settings.package_root.as_str());
                match PlacedSolid::read(&part.geometry, at, &what, line, &mut self.meshes, source)? {
                    Ok(solid) => {
                        let number = if i == 0 { String::new() } else { format!("_{i}") };
                        out.push((solid, alias(&format!("{}_{role}{number}", link.name)), color));
                    }
                    Err(why) => self.builder.report(TATU_REPORT_WARNING, Some(node), &format!("{what}: {why}")),
                }
                for note in self.meshes.notes.drain(..) {
                    self.builder.report(TATU_REPORT_WARNING, Some(node), &note);
                }
            }
        }
        Ok(out)
    }

    /// Returns the visual's own color and opacity, or that of the robot's material with the same name.
    fn color(&self, visual: &LinkShape) -> Option<[f64; 4]> {
        let material = visual.material.as_ref()?;
        let named = || self.robot.materials.iter().find(|m| m.name == material.name).and_then(|m| m.color);
        let color = material.color.or_else(named)?;
        let defaults = [0.7, 0.7, 0.7, 1.0];
        Some([0, 1, 2, 3].map(|i| if color[i].is_nan() { defaults[i] } else { color[i].clamp(0.0, 1.0) }))
    }

    fn set_collision_geometry(&self, body: &LinkGroup, node: Node<'b>, solids: &[NamedSolid]) -> Result {
        node.set("shape.respondable", true)?
            .set("shape.respondable_mask", COLLISION_MASK)?
            .set("shape.friction", self.settings.friction)?;
        if let [(PlacedSolid { pose, form: SolidForm::Mesh(pieces) }, ..)] = solids {
            // A mesh that is the only collision geometry is replaced by its convex hull, because a hollow mesh has no
            // inside from which bodies are pushed out.
            let (points, triangles) = merge_pieces(&pieces.iter().map(|p| p.moved([1.0; 3], pose)).collect::<Vec<_>>());
            let number = self.builder.mesh(&points, &triangles)?;
            node.set("shape.primitive", "mesh")?.set("shape.mesh", number)?.set("shape.convex", true)?;
            return Ok(());
        }
        if solids.iter().any(|(s, ..)| matches!(s.form, SolidForm::Mesh(_))) {
            let text = "a collision mesh in a link with other collision geometry is replaced by its bounding box";
            self.builder.report(TATU_REPORT_WARNING, Some(node), text);
        }
        let rolls = body.joint.as_ref().is_some_and(|(j, ..)| self.robot.joints[*j].kind == UrdfJointKind::Continuous);
        let part = |solid: &PlacedSolid| match self
            .sphere_for_wheel(body, solid)
            .filter(|_| rolls && self.settings.wheels_as_balls)
        {
            Some(ball) => ball.part(),
            None => solid.part(),
        };
        let parts: Vec<Value> = solids.iter().map(|(s, ..)| part(s)).collect();
        node.set("shape.primitive", "compound")?.set("shape.parts", Value::List(parts))?;
        Ok(())
    }

    /// Returns the sphere that replaces a cylinder coaxial with the joint above, or `None` for other geometries. A
    /// cylinder touches the floor along a line, which slows the rotation of a robot.
    fn sphere_for_wheel(&self, body: &LinkGroup, solid: &PlacedSolid) -> Option<PlacedSolid> {
        let SolidForm::Primitive("cylinder", [d, _, length]) = solid.form else { return None };
        let axis = body.below.inverse() * Vector3::z();
        let own = solid.pose * Vector3::z();
        let at = solid.pose.translation.vector;
        // The tolerance allows for quarter turns rounded to 1.57.
        let centred = (at - axis * at.dot(&axis)).norm() < 1e-6;
        (centred && own.cross(&axis).norm() < 1e-3 && length <= d)
            .then_some(PlacedSolid { pose: solid.pose, form: SolidForm::Primitive("sphere", [d; 3]) })
    }

    fn set_mass(&self, node: Node<'b>, name: &str, mass: &Mass, total: f64) -> Result {
        node.set("shape.dynamic", true)?;
        if mass.mass <= 0.0 {
            // Physics cannot move a body without mass. A hundredth of the robot's mass has little effect, and is large
            // enough for the solver.
            let m = (total * 0.01).max(0.001);
            let text =
                format!("the link can move but has no mass: {m:.3} kg is assumed; add an <inertial> with its mass");
            self.builder.report(TATU_REPORT_WARNING, Some(node), &text);
            let i = 0.4 * m * 0.05 * 0.05;
            node.set("shape.mass", m)?.set("shape.inertia", [i; 3])?;
            return Ok(());
        }
        check_finite(mass.com.as_slice(), &format!("centre of mass of `{name}`"), 0)?;
        node.set("shape.mass", mass.mass)?.set("shape.com", <[f64; 3]>::from(mass.com))?;
        if mass.is_possible() {
            let i = mass.inertia.transpose();
            node.set("shape.inertia", Value::Floats(i.as_slice().to_vec()))?;
        } else {
            let text = "the inertia of the link is physically impossible; that of its geometry is used instead";
            self.builder.report(TATU_REPORT_WARNING, Some(node), text);
        }
        Ok(())
    }
}

/// Reports the joints and elements of the file that are not supported.
fn report_unsupported(builder: &Builder<'_>, robot: &Robot, tree: &BodyTree) {
    let warn = |text: String| builder.report(TATU_REPORT_WARNING, None, &text);
    for j in &tree.stiffened {
        let joint = &robot.joints[*j];
        if let UrdfJointKind::Other(kind) = joint.kind {
            warn(format!(
                "line {}: the joint `{}` has the type {kind}, which is not supported; it is treated as fixed",
                joint.line, joint.name
            ));
        }
    }
    if !robot.others.is_empty() {
        let list: Vec<_> = robot.others.iter().map(|(n, c)| format!("{c} x <{n}>")).collect();
        warn(format!("elements that are not supported are ignored: {}", list.join(", ")));
    }
}
