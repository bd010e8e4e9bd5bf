//! Reads the robot in the XML of a URDF file.

use tatu_plugin_api::safe::{Fail, Result};

use crate::{
    robot::{
        Geometry, Inertial, Joint, JointDynamics, JointLimit, Link, LinkShape, Material, Mimic, Robot, UrdfJointKind,
        UrdfPose,
    },
    xml::{LineIndex, XmlElement, parse},
};

/// Maximum number of links and joints in total.
const MAX_PARTS: usize = 20_000;

/// Version of the format, from the attribute `version` of `<robot>`: major and minor number. Later versions interpret
/// some elements differently.
type UrdfVersion = (u32, u32);
/// The first version with the attribute `quat_xyzw`.
const QUATERNIONS_SINCE: UrdfVersion = (1, 1);
/// The first version in which omitted limits are infinite instead of 0.
const INFINITE_LIMITS_SINCE: UrdfVersion = (1, 2);

/// Reads the text of a URDF file. Errors contain the line, and the column in their message.
pub fn robot(text: &str) -> Result<Robot> {
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
        links: Vec::new(),
        joints: Vec::new(),
        materials: Vec::new(),
        others: Default::default(),
    };
    for child in root.children() {
        match child.name() {
            "link" => robot.links.push(link(child, version).map_err(|e| with_context(e, "link", child))?),
            "joint" => robot.joints.push(joint(child, version).map_err(|e| with_context(e, "joint", child))?),
            "material" => robot.materials.push(material(child)?),
            other => *robot.others.entry(other.to_owned()).or_default() += 1,
        }
        if robot.links.len() + robot.joints.len() > MAX_PARTS {
            return Err(child.fail(format!("the file has more than {MAX_PARTS} links and joints")));
        }
    }
    Ok(robot)
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

fn link(tag: XmlElement<'_, '_>, version: UrdfVersion) -> Result<Link> {
    let parts = |role: &str| -> Result<Vec<LinkShape>> {
        tag.children().filter(|c| c.name() == role).map(|c| part(c, version)).collect()
    };
    Ok(Link {
        line: tag.line(),
        name: tag.required("name")?,
        inertial: tag.child("inertial")?.map_or(Ok(Inertial::default()), |t| inertial(t, version))?,
        visuals: parts("visual")?,
        collisions: parts("collision")?,
    })
}

fn inertial(tag: XmlElement<'_, '_>, version: UrdfVersion) -> Result<Inertial> {
    let moments = tag.required_child("inertia")?;
    let mut inertia = [0.0; 6];
    for (value, name) in inertia.iter_mut().zip(["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]) {
        *value = moments.required_number(name)?;
    }
    Ok(Inertial { origin: origin(tag, version)?, mass: tag.required_child("mass")?.required_number("value")?, inertia })
}

/// Reads the child `<origin>`. The pose is the identity if the child is missing, as is each part whose attribute is
/// missing.
fn origin(tag: XmlElement<'_, '_>, version: UrdfVersion) -> Result<UrdfPose> {
    let Some(tag) = tag.child("origin")? else { return Ok(UrdfPose::default()) };
    let mut pose =
        UrdfPose { xyz: tag.numbers("xyz")?.unwrap_or_default(), rpy: tag.numbers("rpy")?.unwrap_or_default() };
    if let Some(text) = tag.text("quat_xyzw").filter(|_| version >= QUATERNIONS_SINCE) {
        if tag.text("rpy").is_some() {
            return Err(tag.fail("<origin> has both `rpy` and `quat_xyzw`; expected one of them".to_owned()));
        }
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let numbers = numbers.ok().and_then(|n| n.try_into().ok());
        pose.rpy = angles(numbers.ok_or_else(|| tag.invalid("quat_xyzw", "4 numbers"))?);
    }
    Ok(pose)
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

/// Reads a `<visual>` or `<collision>`.
fn part(tag: XmlElement<'_, '_>, version: UrdfVersion) -> Result<LinkShape> {
    let material = match tag.name() {
        "visual" => tag.child("material")?.map(material).transpose()?,
        _ => None,
    };
    Ok(LinkShape { origin: origin(tag, version)?, geometry: geometry(tag.required_child("geometry")?)?, material })
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

fn material(tag: XmlElement<'_, '_>) -> Result<Material> {
    if let Some(texture) = tag.child("texture")? {
        texture.required("filename")?;
    }
    let color = tag.child("color")?.map(|c| c.required_numbers("rgba")).transpose()?;
    Ok(Material { name: tag.required("name")?, color })
}

fn joint(tag: XmlElement<'_, '_>, version: UrdfVersion) -> Result<Joint> {
    let kind = match tag.required("type")?.as_str() {
        "revolute" => UrdfJointKind::Revolute,
        "continuous" => UrdfJointKind::Continuous,
        "prismatic" => UrdfJointKind::Prismatic,
        "fixed" => UrdfJointKind::Fixed,
        "floating" => UrdfJointKind::Other("floating"),
        "planar" => UrdfJointKind::Other("planar"),
        "spherical" => UrdfJointKind::Other("spherical"),
        _ => {
            let expected = "one of revolute, continuous, prismatic, fixed, floating, planar and spherical";
            return Err(tag.invalid("type", expected));
        }
    };
    for (name, required, optional) in [
        ("safety_controller", &["k_velocity"][..], &["soft_lower_limit", "soft_upper_limit", "k_position"][..]),
        ("calibration", &[], &["rising", "falling"]),
    ] {
        // These elements are not used, but they are read in order to detect damaged files.
        if let Some(unused) = tag.child(name)? {
            required.iter().try_for_each(|a| unused.required_number(a).map(drop))?;
            optional.iter().try_for_each(|a| unused.number(a).map(drop))?;
        }
    }
    let dynamics = |t: XmlElement<'_, '_>| -> Result<JointDynamics> {
        let number = |name: &str| Ok(t.number(name)?.unwrap_or(0.0));
        Ok(JointDynamics { damping: number("damping")?, friction: number("friction")? })
    };
    let mimic = |t: XmlElement<'_, '_>| -> Result<Mimic> {
        Ok(Mimic { joint: t.required("joint")?, multiplier: t.number("multiplier")?, offset: t.number("offset")? })
    };
    Ok(Joint {
        line: tag.line(),
        name: tag.required("name")?,
        kind,
        origin: origin(tag, version)?,
        parent: tag.required_child("parent")?.required("link")?,
        child: tag.required_child("child")?.required("link")?,
        axis: tag.child("axis")?.map_or(Ok([1.0, 0.0, 0.0]), |t| t.required_numbers("xyz"))?,
        limit: tag.child("limit")?.map_or(Ok(JointLimit::default()), |t| limit(t, version))?,
        dynamics: tag.child("dynamics")?.map(dynamics).transpose()?,
        mimic: tag.child("mimic")?.map(mimic).transpose()?,
    })
}

fn limit(tag: XmlElement<'_, '_>, version: UrdfVersion) -> Result<JointLimit> {
    if version < INFINITE_LIMITS_SINCE {
        return Ok(JointLimit {
            lower: tag.number("lower")?.unwrap_or(0.0),
            upper: tag.number("upper")?.unwrap_or(0.0),
            effort: tag.number("effort")?.unwrap_or(0.0),
            velocity: tag.required_number("velocity")?,
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
        effort: number("effort")?.unwrap_or(f64::INFINITY),
        velocity: number("velocity")?.unwrap_or(f64::INFINITY),
    })
}
