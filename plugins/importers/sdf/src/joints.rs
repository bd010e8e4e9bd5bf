//! Reads joints. Those with two axes become two joints with a light link in between.

use nalgebra::{Isometry3, Vector3};
use tatu_importers_robots::{
    Element, FindingKind, Findings, Inertial, Joint, JointDynamics, JointKind, JointLimit, Link, Mimic, MotorKind,
    Robot,
};
use tatu_plugin_api::safe::Result;

use crate::{
    files::FormatVersion,
    frames::{FrameReference, FrameTable, WORLD},
    model::{FileDraft, ModelDraft, PartDraft},
};

/// Limits from this magnitude on mean that there is none.
const UNLIMITED: f64 = 1e15;
/// Share of a link's mass that the link between the two axes of its joint gets, as in importing MJCF files.
const LINK_SHARE: f64 = 1e-4;
/// The name of the link that stands for the world.
const WORLD_LINK: &str = "world";

/// Reads the joints of a model into a robot that has its links.
pub struct JointReader<'w, 'e> {
    pub draft: &'w FileDraft<'e>,
    pub model: &'w ModelDraft<'e>,
    pub findings: &'w Findings,
}

/// The ends of a joint: names of links in the robot, and poses in the model.
struct JointEnds {
    names: [String; 2],
    poses: [Isometry3<f64>; 2],
}

impl JointReader<'_, '_> {
    /// Adds all joints.
    pub fn read(&self, robot: &mut Robot, version: impl Fn(&Element) -> FormatVersion) -> Result {
        for part in &self.model.joints {
            self.joint(part, robot, version(part.tag)).map_err(|e| crate::shapes::with_context(e, part.tag))?;
        }
        Ok(())
    }

    fn frames(&self) -> &FrameTable {
        &self.draft.frames
    }

    /// Returns whether a link states its mass.
    fn has_inertial(&self, name: &str) -> bool {
        let mut links = self.model.links.iter().map(|link| &self.draft.links[*link]);
        links.any(|link| link.name == name && link.tag.child("inertial").is_some())
    }

    /// Returns the end of a joint that a child element names. Adds the link of the world if it is needed.
    fn end(&self, part: &PartDraft<'_>, role: &str, robot: &mut Robot) -> Result<(String, Isometry3<f64>)> {
        let tag = part.tag;
        let name = tag.text_of(role).ok_or_else(|| tag.fail(format!("it has no <{role}>")))?;
        let frame = self.frames().find(&FrameReference::Named(part.scope.clone(), name.to_owned()));
        let Some(frame) = frame else {
            return Err(tag.fail(format!("it refers to the {role} link `{name}`, which does not exist")));
        };
        let Some(link) = self.frames().link(frame)? else {
            match robot.links.iter_mut().find(|l| l.name == WORLD_LINK) {
                // Some files have a link of this name, which is reserved; with a mass, it is meant to move.
                Some(link) => link.is_fixed |= !self.has_inertial(WORLD_LINK),
                None => robot.links.push(world_link(tag.line)),
            }
            return Ok((WORLD_LINK.to_owned(), Isometry3::identity()));
        };
        if !self.model.links.contains(&link) {
            return Err(tag.fail(format!("its {role} `{name}` belongs to another model")));
        }
        let link = &self.draft.links[link];
        Ok((link.name.clone(), self.frames().between(self.model.frame, link.frame)?))
    }

    fn joint(&self, part: &PartDraft<'_>, robot: &mut Robot, version: FormatVersion) -> Result {
        let tag = part.tag;
        let kind = tag.attribute("type").unwrap_or_default().to_ascii_lowercase();
        let (parent, parent_pose) = self.end(part, "parent", robot)?;
        let (child, child_pose) = self.end(part, "child", robot)?;
        if parent == child {
            // Both ends are attached to the same link.
            self.findings.warn(
                FindingKind::Joint,
                tag.line,
                format!("the joint `{}` connects the link `{parent}` to itself, and is left out", part.name),
            );
            return Ok(());
        }
        let pose = self.frames().between(self.model.frame, part.frame)?;
        let ends = JointEnds { names: [parent, child], poses: [parent_pose, child_pose] };
        let single = |kind: JointKind| self.axis(part, "axis", kind, &pose, version);
        let joint = match kind.as_str() {
            "fixed" => plain(tag, JointKind::Fixed),
            "ball" => Joint { dynamics: dynamics(tag.child("axis"))?, ..plain(tag, JointKind::Ball) },
            "revolute" | "continuous" => single(JointKind::Revolute)?,
            "prismatic" => single(JointKind::Prismatic)?,
            "screw" => single(JointKind::Screw(lead(tag)?))?,
            "universal" | "revolute2" => {
                let second = self.axis(part, "axis2", JointKind::Revolute, &pose, version)?;
                return self.two(part, [single(JointKind::Revolute)?, second], &ends, &pose, robot);
            }
            "gearbox" => {
                let text = format!("the gearbox `{}` between two joints is left out", part.name);
                self.findings.warn(FindingKind::Joint, tag.line, text);
                return Ok(());
            }
            _ => {
                let expected = "revolute, continuous, prismatic, fixed, ball, screw, universal, revolute2 or gearbox";
                return Err(tag.fail(format!("its type is `{kind}`; expected {expected}")));
            }
        };
        robot.joints.push(place(joint, part.name.clone(), &ends.names, &ends.poses, &pose));
        Ok(())
    }

    /// Adds a joint with two axes.
    fn two(
        &self,
        part: &PartDraft<'_>,
        [first, second]: [Joint; 2],
        JointEnds { names: [parent, child], poses: [parent_pose, child_pose] }: &JointEnds,
        pose: &Isometry3<f64>,
        robot: &mut Robot,
    ) -> Result {
        let name = &part.name;
        let lower_name = self.second_name(part);
        let middle = free_name(format!("{name}_link"), |name| robot.links.iter().any(|link| link.name == name));
        let inertial = match robot.links.iter_mut().find(|l| l.name == *child) {
            Some(link) => {
                let whole = link.inertial.clone();
                let scaled = |share: f64| (whole.mass * share, whole.inertia.map(|i| i * share));
                (link.inertial.mass, link.inertial.inertia) = scaled(1.0 - LINK_SHARE);
                let (mass, inertia) = scaled(LINK_SHARE);
                // The link between the axes has the place of the joint.
                Inertial { pose: pose.inverse() * child_pose * whole.pose, mass, inertia }
            }
            None => Inertial::default(),
        };
        robot.links.push(Link { inertial, name: middle.clone(), is_fixed: false, ..world_link(part.tag.line) });
        let upper = [parent.clone(), middle.clone()];
        robot.joints.push(place(first, name.clone(), &upper, &[*parent_pose, *pose], pose));
        let lower = [middle, child.clone()];
        robot.joints.push(place(second, lower_name.clone(), &lower, &[*pose, *child_pose], pose));
        let text = format!(
            "the joint `{name}` with two axes becomes two joints, `{name}` and `{lower_name}`, with a link of \
             1/10,000 of the mass of `{child}` in between"
        );
        self.findings.note(FindingKind::TwoAxes, part.tag.line, text);
        Ok(())
    }

    /// Reads an axis with its limits.
    fn axis(
        &self,
        part: &PartDraft<'_>,
        which: &str,
        kind: JointKind,
        pose: &Isometry3<f64>,
        version: FormatVersion,
    ) -> Result<Joint> {
        let tag = part.tag;
        let empty = Element { line: tag.line, ..Element::default() };
        let axis = tag.child(which).unwrap_or(&empty);
        let xyz = Vector3::from(axis.numbers("xyz")?.unwrap_or([0.0, 0.0, 1.0]));
        let xyz = self.expressed(part, axis, pose, version)? * xyz;
        let limit = limit(axis.child("limit").unwrap_or(&empty))?;
        let kind = match kind {
            JointKind::Revolute if !limit.lower.is_finite() && !limit.upper.is_finite() => JointKind::Continuous,
            kind => kind,
        };
        Ok(Joint {
            axis: xyz.into(),
            limit,
            dynamics: dynamics(Some(axis))?,
            mimic: axis.child("mimic").map(|mimic| self.mimic(mimic, part)).transpose()?,
            ..plain(tag, kind)
        })
    }

    /// Returns the rotation from the frame in which an axis is stated to that of the joint.
    fn expressed(
        &self,
        part: &PartDraft<'_>,
        axis: &Element,
        pose: &Isometry3<f64>,
        version: FormatVersion,
    ) -> Result<nalgebra::UnitQuaternion<f64>> {
        let in_model = version <= (1, 4) || axis.flag("use_parent_model_frame") == Some(true);
        let named = axis.child("xyz").and_then(|xyz| xyz.attribute("expressed_in")).filter(|name| !name.is_empty());
        let frame = match named {
            Some(name) => {
                let frame = self.frames().find(&FrameReference::Named(part.scope.clone(), name.to_owned()));
                frame
                    .ok_or_else(|| axis.fail(format!("its axis refers to the frame `{name}`, which does not exist")))?
            }
            None if in_model => part.scope.model,
            None => return Ok(nalgebra::UnitQuaternion::identity()),
        };
        let own = if frame == WORLD {
            self.frames().world(self.model.frame)?.inverse()
        } else {
            self.frames().between(self.model.frame, frame)?
        };
        Ok(pose.rotation.inverse() * own.rotation)
    }

    /// Returns the name of the joint for the second axis of a joint with two.
    fn second_name(&self, part: &PartDraft<'_>) -> String {
        let is_taken = |name: &str| self.model.joints.iter().any(|joint| joint.name == name);
        free_name(format!("{}_axis2", part.name), is_taken)
    }

    fn mimic(&self, tag: &Element, part: &PartDraft<'_>) -> Result<Mimic> {
        // Names in nested models have those of the models in front.
        let inside = part.name.strip_suffix(part.tag.label()).unwrap_or_default();
        let mut leader = format!("{inside}{}", tag.attribute("joint").unwrap_or_default());
        if tag.attribute("axis") == Some("axis2")
            && let Some(two) = self.model.joints.iter().find(|joint| joint.name == leader)
        {
            leader = self.second_name(two);
        }
        let multiplier = tag.finite("multiplier")?.unwrap_or(1.0);
        let offset = tag.finite("offset")?.unwrap_or(0.0) - multiplier * tag.finite("reference")?.unwrap_or(0.0);
        Ok(Mimic { joint: leader, multiplier: Some(multiplier), offset: Some(offset) })
    }
}

/// Returns a name that is not taken: the given one, or with a number.
fn free_name(name: String, is_taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2..).map(|n| format!("{name}_{n}"));
    let found = std::iter::once(name.clone()).chain(numbered).find(|name| !is_taken(name));
    found.unwrap_or(name)
}

/// Returns a joint without limits, at no place.
fn plain(tag: &Element, kind: JointKind) -> Joint {
    Joint {
        line: tag.line,
        name: String::new(),
        kind,
        pose: Isometry3::identity(),
        child_pose: Isometry3::identity(),
        parent: String::new(),
        child: String::new(),
        axis: [0.0, 0.0, 1.0],
        limit: JointLimit::default(),
        dynamics: None,
        mimic: None,
        motor: MotorKind::Off,
    }
}

/// Connects a joint; all poses are those in the model.
fn place(
    joint: Joint,
    name: String,
    [parent, child]: &[String; 2],
    [parent_pose, child_pose]: &[Isometry3<f64>; 2],
    pose: &Isometry3<f64>,
) -> Joint {
    Joint {
        name,
        parent: parent.clone(),
        child: child.clone(),
        pose: parent_pose.inverse() * pose,
        child_pose: pose.inverse() * child_pose,
        ..joint
    }
}

/// Returns a link that is fixed to the world, without a mass.
fn world_link(line: u64) -> Link {
    Link {
        line,
        name: WORLD_LINK.to_owned(),
        pose: Isometry3::identity(),
        is_fixed: true,
        inertial: Inertial::default(),
        visuals: Vec::new(),
        collisions: Vec::new(),
        friction: None,
    }
}

/// Reads limits; those that are missing are infinite, and a speed that is not limited is 0.
fn limit(tag: &Element) -> Result<JointLimit> {
    let number = |name: &str, default: f64| match tag.number(name)? {
        Some(x) if x.is_nan() => Err(tag.fail(format!("<{name}> is not a number"))),
        Some(x) if x.abs() >= UNLIMITED => Ok(f64::INFINITY.copysign(x)),
        x => Ok(x.unwrap_or(default)),
    };
    let stated = |x: f64| Some(x).filter(|x| x.is_finite() && *x > 0.0);
    Ok(JointLimit {
        lower: number("lower", f64::NEG_INFINITY)?,
        upper: number("upper", f64::INFINITY)?,
        // Before 1.10, a negative one means that there is no limit.
        effort: stated(number("effort", -1.0)?),
        velocity: stated(number("velocity", -1.0)?).unwrap_or(0.0),
    })
}

fn dynamics(axis: Option<&Element>) -> Result<Option<JointDynamics>> {
    let Some(tag) = axis.and_then(|axis| axis.child("dynamics")) else { return Ok(None) };
    let number = |name: &str| Ok(tag.finite(name)?.unwrap_or(0.0));
    let spring = [number("spring_stiffness")?, number("spring_reference")?];
    Ok(Some(JointDynamics { damping: number("damping")?, friction: number("friction")?, spring }))
}

/// Distance per turn of a screw that states none, m.
const DEFAULT_LEAD: f64 = 1.0;

/// Returns the distance per turn of a screw.
fn lead(tag: &Element) -> Result<f64> {
    if let Some(pitch) = tag.finite("screw_thread_pitch")? {
        return Ok(pitch);
    }
    // The older element states radians per metre, of a left-handed thread.
    let Some(pitch) = tag.finite("thread_pitch")? else { return Ok(DEFAULT_LEAD) };
    let lead = -std::f64::consts::TAU / pitch;
    if lead.is_finite() { Ok(lead) } else { Err(tag.fail("its <thread_pitch> is 0")) }
}
