//! Builds the robot in the scene as a tree in which shapes and joints alternate.
//!
//! The shape of a body has its collision geometry and mass, and its visuals are child shapes. The collision geometry is
//! visible only if the body has no visuals.

use nalgebra::{Isometry3, Vector3};
use tatu_plugin_api::safe::{Builder, Fail, Node, Result, Value};

use crate::{
    collision,
    effort::{assumed_efforts, castors, loads},
    findings::{FindingKind, Findings},
    form::{Defect, MeshCache, PlacedSolid, set_object_pose},
    joint::{add_armature, is_geared, joint, set_motors},
    mass::Mass,
    materials::gazebo_color,
    robot::{Link, LinkShape, Robot, UrdfJointKind, alias},
    settings::ImportSettings,
    tree::{BodyTree, LinkGroup, check_finite, pose},
};

/// A geometry, the alias of its object, and its color and opacity in the file.
struct NamedSolid {
    solid: PlacedSolid,
    alias: String,
    color: Option<[f64; 4]>,
}

/// The data that the functions that build a body share.
struct BodyBuilder<'w, 'b> {
    builder: &'w Builder<'b>,
    robot: &'w Robot,
    settings: &'w ImportSettings,
    findings: &'w Findings,
    meshes: MeshCache,
}

/// Builds the robot, starting with the body of the root link.
pub fn robot(
    builder: &Builder<'_>,
    robot: &Robot,
    tree: &BodyTree,
    settings: &ImportSettings,
    findings: &Findings,
) -> Result {
    let masses: Vec<Mass> = tree.bodies.iter().map(|b| mass(b, robot)).collect::<Result<_>>()?;
    let total: f64 = masses.iter().map(|m| m.mass).sum();
    let mut work = BodyBuilder { builder, robot, settings, findings, meshes: MeshCache::default() };
    let colliding: Vec<Vec<NamedSolid>> =
        tree.bodies.iter().map(|body| work.solids(body, false)).collect::<Result<_>>()?;
    let surface = |solids: &Vec<NamedSolid>| solids.iter().flat_map(|s| s.solid.surface_points()).collect();
    let points: Vec<Vec<Vector3<f64>>> = colliding.iter().map(surface).collect();
    let poses = poses(tree);
    let loads = loads(tree, &masses, &points, &poses);
    let mut nodes: Vec<Node<'_>> = Vec::with_capacity(tree.bodies.len());
    let mut joints = Vec::with_capacity(robot.joints.len());
    let assumed = assumed_efforts(robot, tree, &masses, &loads, settings.fixed_base);
    let castors = castors(robot, tree, &poses);
    let efforts: Vec<Option<f64>> =
        assumed.into_iter().zip(castors).map(|(effort, is_castor)| (!is_castor).then_some(effort)).collect();
    for (i, body) in tree.bodies.iter().enumerate() {
        let mut parent = None;
        let mut rolls_about = None;
        if let Some((j, above, frame)) = &body.joint {
            let source = &robot.joints[*j];
            let made = joint(builder, nodes[*above], (robot, source), frame, findings);
            let made = made.map_err(|e| with_line(e, source.line))?;
            if is_geared(robot, *j) {
                let centre = body.below * nalgebra::Point3::from(masses[i].com);
                let link = (masses[i].mass, centre.coords.xy().norm(), loads[i].lever);
                add_armature(made, source, link, findings)?;
            }
            if source.kind == UrdfJointKind::Continuous {
                rolls_about = collision::rolling_axis(&(poses[*above] * frame), &body.below);
            }
            joints.push((*j, made, efforts[i]));
            parent = Some(made);
        }
        let line = robot.links[body.links[0].0].line;
        let node = work.body(body, parent, (&masses[i], total), &colliding[i], rolls_about);
        nodes.push(node.map_err(|e| with_line(e, line))?);
    }
    set_motors(robot, &joints, settings, findings)?;
    if settings.on_floor {
        let heights =
            poses.iter().zip(&colliding).flat_map(|(pose, solids)| solids.iter().map(|s| s.solid.lowest(pose)));
        let lowest = heights.fold(f64::MAX, f64::min);
        if let Some(root) = nodes.first().filter(|_| lowest < f64::MAX) {
            let raised = nalgebra::Translation3::new(0.0, 0.0, -lowest) * tree.bodies[0].below;
            set_object_pose(*root, &raised)?;
        }
    }
    find_unread(robot, tree, findings);
    Ok(())
}

/// Returns the pose of each body in the frame of the root, with all joints at 0.
fn poses(tree: &BodyTree) -> Vec<Isometry3<f64>> {
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(tree.bodies.len());
    for body in &tree.bodies {
        let joint = body.joint.as_ref().map_or(Isometry3::identity(), |(_, above, frame)| poses[*above] * frame);
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
        .try_fold(Mass::ZERO, |sum, (link, frame)| Ok(sum.combined_with(&Mass::of(&robot.links[*link], frame)?)))
}

impl<'b> BodyBuilder<'_, 'b> {
    fn body(
        &mut self,
        body: &LinkGroup,
        parent: Option<Node<'b>>,
        (mass, total): (&Mass, f64),
        colliding: &[NamedSolid],
        rolls_about: Option<Vector3<f64>>,
    ) -> Result<Node<'b>> {
        let (builder, robot) = (self.builder, self.robot);
        let root = parent.is_none();
        // The base has the name of the robot. The root link is a child of the base, like every link that is fixed to
        // another link.
        let name = if root { &robot.name } else { &robot.links[body.links[0].0].name };
        let name = if name.is_empty() { "robot" } else { name };
        let node = builder.object("shape", parent, &alias(name))?;
        set_object_pose(node, &body.below)?;
        let seen = self.solids(body, true)?;
        let shown = seen.is_empty() && !colliding.is_empty();
        node.set("object.visible", shown)?.set("shape.detectable", shown)?;
        if !colliding.is_empty() {
            let solids: Vec<&PlacedSolid> = colliding.iter().map(|named| &named.solid).collect();
            let friction = self.friction(body);
            let wheels =
                collision::set_collision_geometry(builder, node, &solids, rolls_about, friction, self.settings)?;
            if wheels > 0 {
                let text = format!("the wheel `{name}` collides as a sphere (parameter `wheels_as_balls`)");
                self.findings.note(FindingKind::Wheel, robot.links[body.links[0].0].line, text);
            }
        }
        if !(root && self.settings.fixed_base) {
            self.set_mass(node, body, mass, total)?;
        }
        for NamedSolid { solid, alias, color } in &seen {
            let look = builder.object("shape", Some(node), alias)?;
            solid.shape(builder, look, *color, &mut self.meshes)?;
        }
        for (link, frame) in body.links.iter().skip(usize::from(!root)) {
            set_object_pose(builder.object("dummy", Some(node), &alias(&robot.links[*link].name))?, frame)?;
        }
        Ok(node)
    }

    /// Returns the friction that the file states for the first link of a body that has one.
    fn friction(&self, body: &LinkGroup) -> f64 {
        let of_link = |link: usize| self.robot.gazebo.get(&self.robot.links[link].name)?.friction;
        body.links.iter().find_map(|(link, _)| of_link(*link)).unwrap_or(self.settings.friction)
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
                let color = self.color(part, &link.name);
                let line = part.line;
                let what = format!("{role} of the link `{}`", link.name);
                let at = frame * pose(&part.origin, &what, line)?;
                let source = (self.builder, self.settings.package_root.as_str());
                match PlacedSolid::read(&part.geometry, at, &what, line, &mut self.meshes, source) {
                    Ok(solid) => {
                        let number = if i == 0 { String::new() } else { format!("_{i}") };
                        out.push(NamedSolid { solid, alias: alias(&format!("{}_{role}{number}", link.name)), color });
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

    /// Returns the visual's own color and opacity, that of the robot's material with the same name, or that which a
    /// `<gazebo>` element states.
    fn color(&self, visual: &LinkShape, link: &str) -> Option<[f64; 4]> {
        let material = visual.material.as_ref();
        let named = |name: &str| self.robot.materials.iter().find(|m| m.name == name).and_then(|m| m.color);
        let of_gazebo = || gazebo_color(self.robot.gazebo.get(link)?.material.as_deref()?);
        let color = material.and_then(|m| m.color.or_else(|| named(&m.name))).or_else(of_gazebo)?;
        let defaults = [0.7, 0.7, 0.7, 1.0];
        Some([0, 1, 2, 3].map(|i| if color[i].is_nan() { defaults[i] } else { color[i].clamp(0.0, 1.0) }))
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

/// Adds the joints and elements of the file that are not supported.
fn find_unread(robot: &Robot, tree: &BodyTree, findings: &Findings) {
    for j in &tree.stiffened {
        let joint = &robot.joints[*j];
        let name = &joint.name;
        let text = match joint.kind {
            UrdfJointKind::Other(kind) => {
                format!("the joint `{name}` has the type {kind}, which is not supported; it is treated as fixed")
            }
            _ => format!("the axis of the joint `{name}` is 0 0 0; it is treated as fixed"),
        };
        findings.warn(FindingKind::Joint, joint.line, text);
    }
    if !robot.others.is_empty() {
        let list: Vec<_> = robot.others.iter().map(|(n, c)| format!("{c} x <{n}>")).collect();
        findings.note(FindingKind::Unread, 0, format!("elements that are not read: {}", list.join(", ")));
    }
}
