//! Reads the robot in the XML of a URDF file.

use std::collections::BTreeMap;

use nalgebra::Isometry3;
use tatu_importers_robots::{
    Element, FindingKind, Findings, Geometry, Inertial, Joint, JointDynamics, JointKind, JointLimit, Link, LinkShape,
    Mimic, MotorKind, Robot, RobotStructure, Surface, gazebo_color, pose,
};
use tatu_importers_xml::too_large;
use tatu_plugin_api::safe::{Fail, Result};

use crate::xml::{LineIndex, XmlElement, bind_prefixes, parse};

/// Maximum number of links and joints in total.
const MAX_PARTS: usize = 20_000;

/// Version of the format, from the attribute `version` of `<robot>`: major and minor number. Later versions interpret
/// some elements differently.
type UrdfVersion = (u32, u32);
/// The first version with the attribute `quat_xyzw`.
const QUATERNIONS_SINCE: UrdfVersion = (1, 1);
/// The first version in which omitted limits are infinite instead of 0.
const INFINITE_LIMITS_SINCE: UrdfVersion = (1, 2);

/// A material. Without a colour, it refers to the robot's material with the same name.
#[derive(Debug, Clone)]
struct Material {
    name: String,
    /// Red, green, blue and opacity.
    color: Option<[f64; 4]>,
}

/// What a `<gazebo>` element states about a link.
#[derive(Debug, Clone, Default)]
struct GazeboLink {
    /// Friction coefficient: the mean of `mu1` and `mu2`.
    friction: Option<f64>,
    /// Name of a material of Gazebo, such as `Gazebo/Orange`.
    material: Option<String>,
}

/// What is stated outside of links about their looks and surfaces.
#[derive(Default)]
struct SharedStatements {
    /// The materials of visuals, by link and number of the visual.
    of_visuals: BTreeMap<(usize, usize), Material>,
    /// Materials to which visuals refer by name.
    materials: Vec<Material>,
    /// What `<gazebo>` elements state about links, by the names of these.
    gazebo: BTreeMap<String, GazeboLink>,
    /// The names of all other children of `<robot>`, which are ignored, and their numbers of occurrences.
    others: BTreeMap<String, usize>,
}

impl SharedStatements {
    /// Applies the statements to the links, and reports what is ignored.
    fn apply(&self, robot: &mut Robot, findings: &Findings) {
        for (l, link) in robot.links.iter_mut().enumerate() {
            let gazebo = self.gazebo.get(&link.name);
            link.friction = gazebo.and_then(|g| g.friction);
            let of_gazebo = gazebo.and_then(|g| gazebo_color(g.material.as_deref()?));
            let named = |name: &str| self.materials.iter().find(|m| m.name == name).and_then(|m| m.color);
            for (v, visual) in link.visuals.iter_mut().enumerate() {
                // The visual's own colour comes first, then that of the robot's material with the same name.
                let own = self.of_visuals.get(&(l, v));
                visual.color = own.and_then(|m| m.color.or_else(|| named(&m.name))).or(of_gazebo);
            }
        }
        if !self.others.is_empty() {
            let list: Vec<_> = self.others.iter().map(|(n, c)| format!("{c} x <{n}>")).collect();
            findings.note(FindingKind::Unread, 0, format!("elements that are not read: {}", list.join(", ")));
        }
    }
}

/// What a file describes.
pub struct UrdfFile {
    pub robot: Robot,
    /// The sensors in `<gazebo>` elements, with the names of their links.
    pub sensors: Vec<(String, Element)>,
}

/// Reads the text of a URDF file. Errors contain the line, and the column in their message. What is damaged and does not
/// concern the motion of the robot is left out, and added to `findings`.
pub fn file(text: &str, findings: &Findings) -> Result<UrdfFile> {
    if let Some((at, why)) = too_large(text) {
        let line = text.get(..at).unwrap_or_default().matches('\n').count() as u64 + 1;
        return Err(Fail::argument(why).at("", line));
    }
    let (text, unbound) = bind_prefixes(text);
    if let Some(prefix) = unbound {
        let text = format!("the namespace prefix `{prefix}:` is not declared; elements with it are read without it");
        findings.warn(FindingKind::Namespace, 0, text);
    }
    let text = &*text;
    let lines = LineIndex::new(text);
    let document = parse(&lines)?;
    let root = XmlElement::root(&document, &lines);
    if root.name() != "robot" {
        return Err(Fail::argument(format!("the root element is {root}; expected <robot>"))
            .help("a URDF file contains exactly one <robot>")
            .at("", root.line()));
    }
    let version = version(root.text("version"));
    let mut robot = Robot {
        name: root.text("name").unwrap_or_default().to_owned(),
        pose: Isometry3::identity(),
        links: Vec::new(),
        joints: Vec::new(),
        structure: RobotStructure::Tree,
        data: BTreeMap::new(),
    };
    let mut shared = SharedStatements::default();
    let mut sensors = Vec::new();
    for child in root.children() {
        match child.name() {
            "link" => {
                let (link, materials) = link(child, version, findings).map_err(|e| with_context(e, "link", child))?;
                let number = robot.links.len();
                shared.of_visuals.extend(materials.into_iter().map(|(visual, m)| ((number, visual), m)));
                robot.links.push(link);
            }
            "joint" => robot.joints.push(joint(child, version, findings).map_err(|e| with_context(e, "joint", child))?),
            "material" => shared.materials.extend(material(child, findings)),
            "gazebo" if child.text("reference").is_some() => {
                let link = child.text("reference").unwrap_or_default();
                gazebo(child, shared.gazebo.entry(link.to_owned()).or_default());
                for sensor in child.children().filter(|c| c.name() == "sensor") {
                    sensors.push((link.to_owned(), sensor.copy()?));
                }
            }
            // Controllers and tools read these; the joints have what they say about motion.
            tag @ ("transmission" | "ros2_control") => {
                let text = robot.data.entry(tag.to_owned()).or_default();
                text.push_str(child.source());
                text.push('\n');
            }
            other => *shared.others.entry(other.to_owned()).or_default() += 1,
        }
        if robot.links.len() + robot.joints.len() > MAX_PARTS {
            return Err(child.fail(format!("the file has more than {MAX_PARTS} links and joints")));
        }
    }
    shared.apply(&mut robot, findings);
    Ok(UrdfFile { robot, sensors })
}

/// Adds the name of the link or joint that could not be read to an error.
fn with_context(e: Fail, what: &str, tag: XmlElement<'_, '_>) -> Fail {
    let line = e.place().map_or(tag.line(), |(_, line)| line);
    let name = tag.text("name").map(|n| format!(" `{n}`")).unwrap_or_default();
    Fail::argument(format!("the {what}{name} cannot be read: {}", e.text())).at("", line)
}

/// Parses a version of the form `MAJOR.MINOR`. A missing or invalid version is treated as 1.0.
fn version(text: Option<&str>) -> UrdfVersion {
    let numbers = |text: &str| {
        let (major, minor) = text.trim().split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    text.and_then(numbers).unwrap_or((1, 0))
}

/// Reads a link, and the materials of its visuals by their numbers.
fn link(
    tag: XmlElement<'_, '_>,
    version: UrdfVersion,
    findings: &Findings,
) -> Result<(Link, BTreeMap<usize, Material>)> {
    let name = tag.required("name")?;
    let mut materials = BTreeMap::new();
    let parts = |role: &str, kind: FindingKind, materials: &mut BTreeMap<usize, Material>| -> Vec<LinkShape> {
        let mut shapes = Vec::new();
        for child in tag.children().filter(|c| c.name() == role) {
            match part(child, version, findings) {
                Ok((shape, material)) => {
                    materials.extend(material.map(|material| (shapes.len(), material)));
                    shapes.push(shape);
                }
                Err(e) => left_out(&e, child, (role, &name), (kind, findings)),
            }
        }
        shapes
    };
    let inertial = tag.child("inertial")?.map_or(Ok(Inertial::default()), |t| inertial(t, version, findings))?;
    let visuals = parts("visual", FindingKind::Visual, &mut materials);
    // Only visuals have materials.
    let collisions = parts("collision", FindingKind::Collision, &mut BTreeMap::new());
    let (line, pose) = (tag.line(), Isometry3::identity());
    Ok((Link { line, name, pose, is_fixed: false, inertial, visuals, collisions, friction: None }, materials))
}

/// Adds that a visual or a collision of a link is left out because of an error.
fn left_out(e: &Fail, tag: XmlElement<'_, '_>, (role, link): (&str, &str), (kind, findings): (FindingKind, &Findings)) {
    let line = e.place().map_or(tag.line(), |(_, line)| line);
    findings.warn(kind, line, format!("a {role} of the link `{link}` is left out: {}", e.text()));
}

fn inertial(tag: XmlElement<'_, '_>, version: UrdfVersion, findings: &Findings) -> Result<Inertial> {
    let moments = tag.required_child("inertia")?;
    let mut inertia = [0.0; 6];
    for (value, name) in inertia.iter_mut().zip(["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]) {
        let is_product = name[1..2] != name[2..3];
        match moments.number(name)? {
            Some(number) => *value = number,
            None if is_product => {
                let text = format!("an inertia states no `{name}`; 0 is assumed");
                findings.note(FindingKind::Products, moments.line(), text);
            }
            None => return Err(moments.invalid(name, "a number")),
        }
    }
    Ok(Inertial { pose: origin(tag, version)?, mass: tag.required_child("mass")?.required_number("value")?, inertia })
}

/// Reads the child `<origin>`. The pose is the identity if the child is missing, as is each part whose attribute is
/// missing.
fn origin(tag: XmlElement<'_, '_>, version: UrdfVersion) -> Result<Isometry3<f64>> {
    let Some(tag) = tag.child("origin")? else { return Ok(Isometry3::identity()) };
    let (xyz, mut rpy) = (tag.numbers("xyz")?.unwrap_or_default(), tag.numbers("rpy")?.unwrap_or_default());
    if let Some(text) = tag.text("quat_xyzw").filter(|_| version >= QUATERNIONS_SINCE) {
        if tag.text("rpy").is_some() {
            return Err(tag.fail("<origin> has both `rpy` and `quat_xyzw`; expected one of them".to_owned()));
        }
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let numbers = numbers.ok().and_then(|n| n.try_into().ok());
        rpy = angles(numbers.ok_or_else(|| tag.invalid("quat_xyzw", "4 numbers"))?);
    }
    pose(xyz, rpy, "<origin>", tag.line())
}

/// Returns roll, pitch and yaw, rad, of a quaternion x, y, z, w, which need not be normalized.
fn angles(quaternion: [f64; 4]) -> [f64; 3] {
    let length = libm::sqrt(quaternion.iter().map(|q| q * q).sum());
    let [x, y, z, w] = if length > 0.0 { quaternion.map(|q| q / length) } else { [0.0, 0.0, 0.0, 1.0] };
    let pitch = 2.0 * (w * y - x * z);
    // Gimbal lock: at a pitch of 90 degrees, roll and yaw have the same axis, so the whole rotation is assigned to yaw.
    if pitch.abs() >= 0.99999 {
        let sign = pitch.signum();
        return [0.0, sign * std::f64::consts::FRAC_PI_2, 2.0 * libm::atan2(-sign * x, sign * y)];
    }
    [
        libm::atan2(2.0 * (y * z + w * x), w * w - x * x - y * y + z * z),
        libm::asin(pitch),
        libm::atan2(2.0 * (x * y + w * z), w * w + x * x - y * y - z * z),
    ]
}

/// Reads a `<visual>` or `<collision>`, and its material.
fn part(tag: XmlElement<'_, '_>, version: UrdfVersion, findings: &Findings) -> Result<(LinkShape, Option<Material>)> {
    let material = match tag.name() {
        "visual" => first_of(tag, "material", findings).and_then(|m| material(m, findings)),
        _ => None,
    };
    let geometry = geometry(tag.required_child("geometry")?)?;
    let (line, pose) = (tag.line(), origin(tag, version)?);
    Ok((LinkShape { line, pose, geometry, color: None, surface: Surface::default() }, material))
}

/// Returns the first child with a name, and adds a finding if there are several.
fn first_of<'a, 't>(tag: XmlElement<'a, 't>, name: &str, findings: &Findings) -> Option<XmlElement<'a, 't>> {
    if let Err(e) = tag.child(name) {
        let line = e.place().map_or(tag.line(), |(_, line)| line);
        findings.warn(FindingKind::Doubled, line, format!("{}; the first is used", e.text()));
    }
    tag.first_child(name)
}

/// Reads what a `<gazebo>` element states about its link.
fn gazebo(tag: XmlElement<'_, '_>, link: &mut GazeboLink) {
    let text = |name: &str| tag.first_child(name).and_then(|c| c.content());
    let number = |name: &str| text(name).and_then(|t| t.trim().parse::<f64>().ok()).filter(|x| *x >= 0.0);
    if let Some(first) = number("mu1").or_else(|| number("mu2")) {
        // Gazebo's directions of friction are the world's or those of the shape; Tatu has one coefficient.
        link.friction = Some(((first + number("mu2").unwrap_or(first)) / 2.0).min(100.0));
    }
    link.material = text("material").map(|t| t.trim().to_owned()).or_else(|| link.material.take());
}

fn geometry(tag: XmlElement<'_, '_>) -> Result<Geometry> {
    const EXPECTED: &str = "expected one of <box>, <cylinder>, <capsule>, <sphere> and <mesh>";
    let mut children = tag.children();
    let form = children.next().ok_or_else(|| tag.fail(format!("{tag} is empty; {EXPECTED}")))?;
    if let Some(second) = children.next() {
        return Err(second.fail(format!("{tag} contains {form} and {second}; {EXPECTED}")));
    }
    Ok(match form.name() {
        "box" => Geometry::Box { size: form.required_numbers("size")? },
        "sphere" => Geometry::Sphere { radius: form.required_number("radius")? },
        "cylinder" => {
            Geometry::Cylinder { radius: form.required_number("radius")?, length: form.required_number("length")? }
        }
        "capsule" => {
            Geometry::Capsule { radius: form.required_number("radius")?, length: form.required_number("length")? }
        }
        "mesh" => Geometry::Mesh { filename: form.required("filename")?, scale: form.numbers("scale")? },
        _ => return Err(form.fail(format!("{tag} contains {form}; {EXPECTED}"))),
    })
}

/// Reads a material; a damaged one is left out.
fn material(tag: XmlElement<'_, '_>, findings: &Findings) -> Option<Material> {
    let color = first_of(tag, "color", findings).map(|c| c.required_numbers("rgba")).transpose();
    let color = color.map_err(|e| {
        let line = e.place().map_or(tag.line(), |(_, line)| line);
        findings.warn(FindingKind::Material, line, format!("a colour is left out: {}", e.text()));
    });
    Some(Material { name: tag.text("name").unwrap_or_default().to_owned(), color: color.ok()? })
}

fn joint(tag: XmlElement<'_, '_>, version: UrdfVersion, findings: &Findings) -> Result<Joint> {
    let kind = match tag.required("type")?.trim().to_ascii_lowercase().as_str() {
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        "fixed" => JointKind::Fixed,
        "floating" => JointKind::Other("floating"),
        "planar" => JointKind::Other("planar"),
        "spherical" => JointKind::Other("spherical"),
        _ => {
            let expected = "one of revolute, continuous, prismatic, fixed, floating, planar and spherical";
            return Err(tag.invalid("type", expected));
        }
    };
    let dynamics = |t: XmlElement<'_, '_>| -> Result<JointDynamics> {
        let number = |name: &str| Ok(t.number(name)?.unwrap_or(0.0));
        Ok(JointDynamics { damping: number("damping")?, friction: number("friction")?, spring: [0.0; 2] })
    };
    let mimic = |t: XmlElement<'_, '_>| -> Result<Mimic> {
        Ok(Mimic { joint: t.required("joint")?, multiplier: t.number("multiplier")?, offset: t.number("offset")? })
    };
    // Nothing but its place matters of a joint that cannot move.
    let moves = !matches!(kind, JointKind::Fixed | JointKind::Other(_));
    let child = |name: &str| first_of(tag, name, findings).filter(|_| moves);
    let axis = tag.child("axis").and_then(|t| t.map_or(Ok([1.0, 0.0, 0.0]), |t| t.required_numbers("xyz")));
    let axis = match axis {
        Err(e) if !moves => {
            let line = e.place().map_or(tag.line(), |(_, line)| line);
            let text = format!("the axis of a joint that cannot move is ignored: {}", e.text());
            findings.warn(FindingKind::Axis, line, text);
            [1.0, 0.0, 0.0]
        }
        axis => axis?,
    };
    Ok(Joint {
        line: tag.line(),
        name: tag.required("name")?,
        kind,
        pose: origin(tag, version)?,
        child_pose: Isometry3::identity(),
        parent: tag.required_child("parent")?.required("link")?,
        child: tag.required_child("child")?.required("link")?,
        axis,
        limit: child("limit").map_or(Ok(JointLimit::default()), |t| limit(t, version, findings))?,
        dynamics: child("dynamics").map(dynamics).transpose()?,
        mimic: child("mimic").map(mimic).transpose()?,
        motor: MotorKind::ByType,
    })
}

fn limit(tag: XmlElement<'_, '_>, version: UrdfVersion, findings: &Findings) -> Result<JointLimit> {
    let stated = |effort: f64| Some(effort).filter(|effort| *effort > 0.0 || effort.is_nan());
    if version < INFINITE_LIMITS_SINCE {
        let velocity = tag.number("velocity")?;
        if velocity.is_none() {
            let text = "a limit states no `velocity`; 10 rad/s (or m/s) is assumed".to_owned();
            findings.note(FindingKind::Velocity, tag.line(), text);
        }
        return Ok(JointLimit {
            lower: tag.number("lower")?.unwrap_or(0.0),
            upper: tag.number("upper")?.unwrap_or(0.0),
            effort: tag.number("effort")?.and_then(stated),
            velocity: velocity.unwrap_or(0.0),
        });
    }
    let number = |name: &str| match tag.number(name)? {
        Some(x) if x.is_nan() => Err(tag.invalid(name, "a number")),
        x => Ok(x),
    };
    let (lower, upper) = (number("lower")?, number("upper")?);
    if let (Some(lower), Some(upper)) = (lower, upper)
        && upper < lower
    {
        return Err(tag.fail(format!("`upper` of <limit> is {upper}, which is less than `lower`, {lower}")));
    }
    for name in ["effort", "velocity", "acceleration", "deceleration", "jerk"] {
        if number(name)?.is_some_and(|x| x < 0.0) {
            return Err(tag.invalid(name, "a number of at least 0"));
        }
    }
    Ok(JointLimit {
        lower: lower.unwrap_or(f64::NEG_INFINITY),
        upper: upper.unwrap_or(f64::INFINITY),
        effort: number("effort")?.and_then(stated),
        velocity: number("velocity")?.unwrap_or(f64::INFINITY),
    })
}
