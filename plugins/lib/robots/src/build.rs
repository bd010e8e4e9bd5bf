//! Builds a robot in the scene as trees in which shapes and joints alternate.
//!
//! The shape of a body has its collision geometry and mass, and its visuals are child shapes. The collision geometry is
//! visible only if the body has no visuals.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Vector3};
use tatu_importers_common::Mass;
use tatu_plugin_api::safe::{Builder, Fail, Node, Result, Value};

use crate::{
    closure,
    collision::{self, CollidingSolid},
    effort::{assumed_efforts, castors, loads},
    findings::{FindingKind, Findings},
    form::{Defect, MeshCache, PlacedSolid, set_object_pose},
    joint::{add_armature, is_geared, joint, set_motors},
    robot::{JointKind, Link, Robot, Surface, alias},
    settings::BuildSettings,
    tree::{BodyTree, LinkGroup, check_finite},
};

/// A geometry, the alias of its object, its color and opacity in the file, and its surface.
struct NamedSolid {
    solid: PlacedSolid,
    alias: String,
    color: Option<[f64; 4]>,
    surface: Surface,
}

/// An object that stands for a link.
#[derive(Clone)]
pub struct BuiltLink<'b> {
    /// The shape of the link's body, or a dummy.
    pub node: Node<'b>,
    /// Pose of the link in the frame of the object.
    pub pose: Isometry3<f64>,
    /// The shape of the body to which the link belongs.
    pub body: Node<'b>,
}

/// A robot that has been built.
pub struct BuiltRobot<'b> {
    /// The object that stands for the robot.
    pub base: Node<'b>,
    /// The object of each link.
    pub links: Vec<BuiltLink<'b>>,
    /// The object of each joint, and its path below the base; `None` for joints that do not move and that close loops.
    pub joints: Vec<Option<(Node<'b>, String)>>,
}

/// The data that the functions that build a body share.
struct BodyBuilder<'w, 'b> {
    builder: &'w Builder<'b>,
    robot: &'w Robot,
    settings: &'w BuildSettings,
    findings: &'w Findings,
    meshes: MeshCache,
}

/// Where a body is built.
struct BodyPlace<'b> {
    parent: Option<Node<'b>>,
    /// Whether it is the base of the robot, one of its roots, or fixed.
    is_base: bool,
    is_root: bool,
    is_fixed: bool,
    /// The axis about which it rolls, if it does.
    rolls_about: Option<Vector3<f64>>,
    /// Its collision mask.
    mask: i64,
}

/// Builds the robot below `parent`, starting with the body of the root link. Several roots get a dummy as their base.
pub fn build<'b>(
    builder: &Builder<'b>,
    parent: Option<Node<'b>>,
    robot: &Robot,
    tree: &BodyTree,
    settings: &BuildSettings,
    findings: &Findings,
) -> Result<BuiltRobot<'b>> {
    let masses: Vec<Mass> = tree.bodies.iter().map(|b| mass(b, robot)).collect::<Result<_>>()?;
    let total: f64 = masses.iter().map(|m| m.mass).sum();
    let mut work = BodyBuilder { builder, robot, settings, findings, meshes: MeshCache::default() };
    let colliding: Vec<Vec<NamedSolid>> =
        tree.bodies.iter().map(|body| work.solids(body, false)).collect::<Result<_>>()?;
    let surface = |solids: &Vec<NamedSolid>| solids.iter().flat_map(|s| s.solid.surface_points()).collect();
    let points: Vec<Vec<Vector3<f64>>> = colliding.iter().map(surface).collect();
    let poses = poses(robot, tree);
    let is_fixed = |body: usize| is_fixed(robot, tree, settings, body);
    let loads = loads(tree, &masses, &points, &poses);
    let assumed = assumed_efforts(robot, tree, &masses, &loads, is_fixed(0));
    let castors = castors(robot, tree, &poses);
    let efforts: Vec<Option<f64>> =
        assumed.into_iter().zip(castors).map(|(effort, is_castor)| (!is_castor).then_some(effort)).collect();
    let has_base = tree.bodies.iter().filter(|b| b.joint.is_none()).count() != 1;
    let base = match has_base {
        true => {
            let base = builder.object("dummy", parent, &alias(base_name(robot)))?;
            Some(set_object_pose(base, &robot.pose)?)
        }
        false => None,
    };
    let has_collision: Vec<bool> = colliding.iter().map(|solids| !solids.is_empty()).collect();
    let masks = collision::masks(tree, &has_collision, settings.self_collision, findings);
    let mut nodes: Vec<Node<'b>> = Vec::with_capacity(tree.bodies.len());
    let mut paths: Vec<String> = Vec::with_capacity(tree.bodies.len());
    let mut moved = Vec::with_capacity(robot.joints.len());
    let mut joints: Vec<Option<(Node<'b>, String)>> = robot.joints.iter().map(|_| None).collect();
    let mut links: Vec<Option<BuiltLink<'b>>> = robot.links.iter().map(|_| None).collect();
    for (i, body) in tree.bodies.iter().enumerate() {
        let first = &robot.links[body.links[0].0];
        let mut place = BodyPlace {
            parent: base.or(parent),
            is_base: body.joint.is_none() && !has_base,
            is_root: body.joint.is_none(),
            is_fixed: is_fixed(i),
            rolls_about: None,
            mask: masks[i],
        };
        let mut path = if place.is_base { String::new() } else { format!("/{}", alias(&first.name)) };
        if let Some((j, above, frame)) = &body.joint {
            let source = &robot.joints[*j];
            let made = joint(builder, nodes[*above], (robot, source), frame, findings);
            let made = made.map_err(|e| with_line(e, source.line))?;
            if is_geared(robot, *j) {
                let centre = body.below * Point3::from(masses[i].com);
                let link = (masses[i].mass, centre.coords.xy().norm(), loads[i].lever);
                add_armature(made, source, link, findings)?;
            }
            if source.kind == JointKind::Continuous {
                place.rolls_about = collision::rolling_axis(&(poses[*above] * frame), &body.below);
            }
            if source.kind.has_axis() {
                moved.push((*j, made, efforts[i]));
            }
            let joint_path = format!("{}/{}", paths[*above], alias(&source.name));
            path = format!("{joint_path}{path}");
            joints[*j] = Some((made, joint_path));
            place.parent = Some(made);
        }
        let node = work.body(body, &place, (&masses[i], total), &colliding[i], &mut links);
        nodes.push(node.map_err(|e| with_line(e, first.line))?);
        paths.push(path);
    }
    set_motors(robot, &moved, settings, findings)?;
    closure::close_loops(builder, robot, tree, (&nodes, &paths, &masses), findings)?;
    if settings.on_floor {
        let heights =
            poses.iter().zip(&colliding).flat_map(|(pose, solids)| solids.iter().map(|s| s.solid.lowest(pose)));
        let lowest = heights.fold(f64::MAX, f64::min);
        if let Some(root) = base.or(nodes.first().copied()).filter(|_| lowest < f64::MAX) {
            set_object_pose(root, &(Translation3::new(0.0, 0.0, -lowest) * robot.pose))?;
        }
    }
    find_unread(robot, tree, findings);
    let lost = || Fail::new("a robot without links cannot be built");
    let links = links.into_iter().collect::<Option<_>>().ok_or_else(lost)?;
    let base = base.or(nodes.first().copied()).ok_or_else(lost)?;
    if !robot.data.is_empty() {
        let texts = robot.data.iter().map(|(tag, text)| (Value::text(tag), Value::text(text)));
        base.set("object.data", Value::Map(texts.collect()))?;
    }
    Ok(BuiltRobot { base, links, joints })
}

/// Returns the name of a robot's base.
fn base_name(robot: &Robot) -> &str {
    if robot.name.is_empty() { "robot" } else { &robot.name }
}

/// Returns whether a body is a root that cannot move.
fn is_fixed(robot: &Robot, tree: &BodyTree, settings: &BuildSettings, body: usize) -> bool {
    let group = &tree.bodies[body];
    let is_stated = group.links.iter().any(|(link, _)| robot.links[*link].is_fixed);
    group.joint.is_none() && (is_stated || settings.fixed_base && body == 0)
}

/// Returns the pose of each body where the robot is placed, with all joints at 0.
fn poses(robot: &Robot, tree: &BodyTree) -> Vec<Isometry3<f64>> {
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(tree.bodies.len());
    for body in &tree.bodies {
        let joint = body.joint.as_ref().map_or(robot.pose, |(_, above, frame)| poses[*above] * frame);
        poses.push(joint * body.below);
    }
    poses
}

/// Adds the line number to an error without a position.
fn with_line(e: Fail, line: u64) -> Fail {
    if e.place().is_some() { e } else { e.at("", line) }
}

fn mass(body: &LinkGroup, robot: &Robot) -> Result<Mass> {
    body.links
        .iter()
        .try_fold(Mass::ZERO, |sum, (link, frame)| Ok(sum.combined_with(&mass_of(&robot.links[*link], frame)?)))
}

/// Returns the mass of a link whose frame in the body is `frame`.
fn mass_of(link: &Link, frame: &Isometry3<f64>) -> Result<Mass> {
    let what = format!("inertial of the link `{}`", link.name);
    let (line, mass) = (link.line, link.inertial.mass);
    let [xx, xy, xz, yy, yz, zz] = link.inertial.inertia;
    check_finite(&[mass, xx, xy, xz, yy, yz, zz], &what, line)?;
    if mass < 0.0 {
        return Err(Fail::argument(format!("{what}: the mass {mass} kg is negative")).at("", line));
    }
    let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    Ok(Mass { mass, com: Vector3::zeros(), inertia }.moved(&(frame * link.inertial.pose)))
}

impl<'b> BodyBuilder<'_, 'b> {
    fn body(
        &mut self,
        body: &LinkGroup,
        place: &BodyPlace<'b>,
        (mass, total): (&Mass, f64),
        colliding: &[NamedSolid],
        links: &mut [Option<BuiltLink<'b>>],
    ) -> Result<Node<'b>> {
        let (builder, robot) = (self.builder, self.robot);
        // The base has the name of the robot. The root link is a child of the base, like every link that is fixed to
        // another link.
        let name = if place.is_base { base_name(robot) } else { &robot.links[body.links[0].0].name };
        let node = builder.object("shape", place.parent, &alias(name))?;
        let pose = if place.is_base { robot.pose * body.below } else { body.below };
        set_object_pose(node, &pose)?;
        let seen = self.solids(body, true)?;
        let shown = seen.is_empty() && !colliding.is_empty();
        let (planes, compact): (Vec<_>, Vec<_>) = colliding.iter().partition(|named| named.solid.is_plane());
        let is_visible = shown && !compact.is_empty();
        node.set("object.visible", is_visible)?.set("shape.detectable", is_visible)?;
        let friction = self.friction(body);
        if !compact.is_empty() {
            self.collision_geometry(node, name, body, &compact, place)?;
        }
        for NamedSolid { solid, alias, color, surface } in planes {
            // A plane is not convex, and cannot be a part of a compound.
            let plane = builder.object("shape", Some(node), alias)?;
            solid.shape(builder, plane, *color, &mut self.meshes)?;
            plane
                .set("shape.respondable", true)?
                .set("shape.friction", surface.friction.unwrap_or(friction))?
                .set("object.visible", shown)?;
        }
        if !(place.is_root && place.is_fixed) {
            self.set_mass(node, body, mass, total)?;
        }
        for NamedSolid { solid, alias, color, .. } in &seen {
            let look = builder.object("shape", Some(node), alias)?;
            solid.shape(builder, look, *color, &mut self.meshes)?;
        }
        for (n, (link, frame)) in body.links.iter().enumerate() {
            links[*link] = Some(if n == 0 && !place.is_base {
                BuiltLink { node, pose: *frame, body: node }
            } else {
                let dummy = builder.object("dummy", Some(node), &alias(&robot.links[*link].name))?;
                BuiltLink { node: set_object_pose(dummy, frame)?, pose: Isometry3::identity(), body: node }
            });
        }
        Ok(node)
    }

    /// Gives a body its collision geometry.
    fn collision_geometry(
        &mut self,
        node: Node<'b>,
        name: &str,
        body: &LinkGroup,
        colliding: &[&NamedSolid],
        place: &BodyPlace<'b>,
    ) -> Result {
        let solids: Vec<CollidingSolid<'_>> =
            colliding.iter().map(|named| CollidingSolid { solid: &named.solid, surface: &named.surface }).collect();
        // What stands still can have any form.
        let settings = &BuildSettings {
            concave: self.settings.concave || self.robot.links[body.links[0].0].is_fixed && place.is_fixed,
            ..self.settings.clone()
        };
        let friction = self.friction(body);
        node.set("shape.respondable", true)?.set("shape.respondable_mask", place.mask)?;
        let wheels =
            collision::set_collision_geometry(self.builder, node, &solids, place.rolls_about, friction, settings)?;
        let line = self.robot.links[body.links[0].0].line;
        if wheels > 0 {
            let text = format!("the wheel `{name}` collides as a sphere (parameter `wheels_as_balls`)");
            self.findings.note(FindingKind::Wheel, line, text);
        }
        if collision::set_friction_axis(node, &solids)? {
            let text =
                format!("the forms of `{name}` have different directions of friction; the first one applies to all");
            self.findings.warn(FindingKind::FrictionAxis, line, text);
        }
        Ok(())
    }

    /// Returns the friction that the file states for the first link of a body that has one.
    fn friction(&self, body: &LinkGroup) -> f64 {
        body.links.iter().find_map(|(link, _)| self.robot.links[*link].friction).unwrap_or(self.settings.friction)
    }

    /// Returns the collision geometry of a body, or its visuals if `seen` is set, each with a name and its color in the
    /// file. What cannot be read is left out.
    fn solids(&mut self, body: &LinkGroup, seen: bool) -> Result<Vec<NamedSolid>> {
        let mut out = Vec::new();
        for (link, frame) in &body.links {
            let link = &self.robot.links[*link];
            let (role, parts, kind) = match seen {
                true => ("visual", &link.visuals, FindingKind::Visual),
                false => ("collision", &link.collisions, FindingKind::Collision),
            };
            for (i, part) in parts.iter().enumerate() {
                let color = part.color.map(drawable);
                let line = part.line;
                let what = format!("{role} of the link `{}`", link.name);
                let source = (self.builder, self.settings.package_root.as_str());
                match PlacedSolid::read(&part.geometry, frame * part.pose, &what, line, &mut self.meshes, source) {
                    Ok(solid) => {
                        let number = if i == 0 { String::new() } else { format!("_{i}") };
                        let alias = alias(&format!("{}_{role}{number}", link.name));
                        // Directions are those of the link; the body's frame can be turned.
                        let mut surface = part.surface.clone();
                        if let Some((axis, _)) = &mut surface.axis {
                            *axis = (frame * Vector3::from(*axis)).into();
                        }
                        out.push(NamedSolid { solid, alias, color, surface });
                    }
                    Err(Defect::Mesh(why)) => self.findings.warn(FindingKind::Mesh, line, why),
                    Err(Defect::Form(why)) => self.findings.warn(kind, line, format!("{why}: it is left out")),
                }
                for note in self.meshes.notes.drain(..) {
                    self.findings.warn(FindingKind::MeshPart, line, note);
                }
            }
        }
        Ok(out)
    }

    fn set_mass(&self, node: Node<'b>, body: &LinkGroup, mass: &Mass, total: f64) -> Result {
        let Link { line, name, .. } = &self.robot.links[body.links[0].0];
        let line = *line;
        node.set("shape.dynamic", true)?;
        if mass.mass <= 0.0 {
            // Physics cannot move a body without mass. A hundredth of the robot's mass has little effect, and is large
            // enough for the solver.
            let m = (total * 0.01).max(0.001);
            let text = format!(
                "the link `{name}` can move but has no mass: {m:.3} kg is assumed; add an <inertial> with its mass"
            );
            self.findings.warn(FindingKind::Mass, line, text);
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
            let text = format!(
                "the inertia of the link `{name}` is physically impossible; that of its geometry is used instead"
            );
            self.findings.warn(FindingKind::Inertia, line, text);
        }
        Ok(())
    }
}

/// Returns a color and opacity between 0 and 1; numbers that are missing are those of a light grey.
fn drawable(color: [f64; 4]) -> [f64; 4] {
    let defaults = [0.7, 0.7, 0.7, 1.0];
    [0, 1, 2, 3].map(|i| if color[i].is_nan() { defaults[i] } else { color[i].clamp(0.0, 1.0) })
}

/// Adds the joints of the file that are not supported.
fn find_unread(robot: &Robot, tree: &BodyTree, findings: &Findings) {
    for j in &tree.stiffened {
        let joint = &robot.joints[*j];
        let name = &joint.name;
        let text = match joint.kind {
            JointKind::Other(kind) => {
                format!("the joint `{name}` has the type {kind}, which is not supported; it is treated as fixed")
            }
            _ => format!("the axis of the joint `{name}` is 0 0 0; it is treated as fixed"),
        };
        findings.warn(FindingKind::Joint, joint.line, text);
    }
}
