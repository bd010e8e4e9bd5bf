//! Writes joints.

use nalgebra::{Isometry3, Vector3};
use tatu_exporters_common::{
    Export, JointKind, JointProperties, Mechanisms, NameSpace, Tie, XmlWriter, number, numbers,
};

use crate::{
    geometry::write_origin,
    robot::{Link, Robot},
};

/// Largest position of a sliding joint without limits, m: URDF requires limits.
const FAR: f64 = 1e6;

/// Names of joints, by the object of each joint.
pub struct JointNames {
    of_item: std::collections::BTreeMap<usize, String>,
    /// All names.
    pub names: NameSpace,
}

impl JointNames {
    /// Names all joints of a robot.
    pub fn new(all: &Mechanisms, robot: &Robot) -> Self {
        let mut names = NameSpace::default();
        let mut of_item = std::collections::BTreeMap::new();
        for link in &robot.links {
            if let Tie::Joint { item, .. } = all.bodies[link.body].tie {
                of_item.insert(item, names.name(&all.items[item].alias));
            }
        }
        JointNames { of_item, names }
    }
}

/// Returns an axis without what rounding leaves of zeros and ones.
fn clean(axis: Vector3<f64>) -> [f64; 3] {
    let nearest = |x: f64| if (x - x.round()).abs() < 4.0 * f64::EPSILON { x.round() } else { x };
    [axis.x, axis.y, axis.z].map(nearest)
}

/// Writes a fixed joint.
pub fn write_fixed(xml: &mut XmlWriter, name: &str, parent: &str, child: &str, origin: &Isometry3<f64>) {
    xml.begin("joint", &[("name", name.to_owned()), ("type", "fixed".to_owned())]);
    write_origin(xml, origin);
    xml.empty("parent", &[("link", parent.to_owned())]);
    xml.empty("child", &[("link", child.to_owned())]);
    xml.end();
}

/// Writes what connects a link to the one above it.
pub fn write_joint(
    xml: &mut XmlWriter,
    all: &Mechanisms,
    robot: &mut Robot,
    link: usize,
    names: &mut JointNames,
    export: &mut Export<'_>,
) {
    let Link { body, origin, .. } = robot.links[link];
    let name = robot.links[link].name.clone();
    let above = |parent: usize| robot.link_of[parent].map(|above| &robot.links[above]);
    match &all.bodies[body].tie {
        Tie::World | Tie::Free => {}
        Tie::Rigid { parent } => {
            let Some(above) = above(*parent) else { return };
            let joint = names.names.derived(&format!("{name}_fixed"));
            write_fixed(xml, &joint, &above.name, &name, &origin);
        }
        Tie::Joint { parent, item, below, joint, .. } => {
            let Some(above) = above(*parent) else { return };
            let axis = below.rotation.inverse() * Vector3::z();
            let path = &all.items[*item].path;
            let own = names.of_item.get(item).cloned().unwrap_or_default();
            if joint.kind == JointKind::Spherical {
                let above = above.name.clone();
                return write_ball(xml, robot, names, (&own, &above, &name), &origin, export, path);
            }
            let kind = match (joint.kind, joint.limits) {
                (JointKind::Prismatic, _) => "prismatic",
                (_, None) => "continuous",
                _ => "revolute",
            };
            xml.begin("joint", &[("name", own), ("type", kind.to_owned())]);
            write_origin(xml, &origin);
            xml.empty("parent", &[("link", above.name.clone())]);
            xml.empty("child", &[("link", name)]);
            xml.empty("axis", &[("xyz", numbers(clean(axis)))]);
            write_limits(xml, joint, export, path);
            if joint.damping != 0.0 || joint.dry_friction != 0.0 {
                let dynamics = [("damping", number(joint.damping)), ("friction", number(joint.dry_friction))];
                xml.empty("dynamics", &dynamics);
            }
            write_mimic(xml, all, joint, names, export, path);
            xml.end();
            report_joint(joint, export, path);
        }
    }
}

fn write_limits(xml: &mut XmlWriter, joint: &JointProperties, export: &mut Export<'_>, path: &str) {
    let mut limits = joint.limits;
    if limits.is_none() && joint.kind == JointKind::Prismatic {
        export.report.lost(format!("sliding joints without limits have limits of {FAR} m"), path);
        limits = Some([-FAR, FAR]);
    }
    let mut attributes = Vec::new();
    if let Some([lower, upper]) = limits {
        attributes.extend([("lower", number(lower)), ("upper", number(upper))]);
    }
    let effort = if joint.is_dynamic { joint.max_force.abs() } else { 0.0 };
    attributes.extend([("effort", number(effort)), ("velocity", number(joint.max_velocity))]);
    xml.empty("limit", &attributes);
}

fn write_mimic(
    xml: &mut XmlWriter,
    all: &Mechanisms,
    joint: &JointProperties,
    names: &JointNames,
    export: &mut Export<'_>,
    path: &str,
) {
    let Some(follow) = joint.follow else { return };
    let Some(leader) = all.item_of(follow.leader).and_then(|item| names.of_item.get(&item)) else {
        return export.report.lost("joints that follow a joint outside the robot move by themselves", path);
    };
    if !follow.is_geared {
        export.report.lost("joints whose motor follows another joint are coupled to it (`mimic`)", path);
    }
    let law = [("multiplier", number(follow.factor)), ("offset", number(follow.offset))];
    let mut attributes = vec![("joint", leader.clone())];
    attributes.extend(law);
    xml.empty("mimic", &attributes);
}

/// Writes a ball joint as three joints about x, y and z, with links without mass in between.
fn write_ball(
    xml: &mut XmlWriter,
    robot: &mut Robot,
    names: &mut JointNames,
    (own, above, below): (&str, &str, &str),
    origin: &Isometry3<f64>,
    export: &mut Export<'_>,
    path: &str,
) {
    export.report.lost("URDF has no ball joints: each is three joints, with two links without mass", path);
    let mut parent = above.to_owned();
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        let child = match i {
            2 => below.to_owned(),
            _ => robot.names.derived(&format!("{below}_{axis}")),
        };
        if i < 2 {
            xml.empty("link", &[("name", child.clone())]);
        }
        let name = if i == 0 { own.to_owned() } else { names.names.derived(&format!("{own}_{axis}")) };
        xml.begin("joint", &[("name", name), ("type", "continuous".to_owned())]);
        if i == 0 {
            write_origin(xml, origin);
        }
        xml.empty("parent", &[("link", parent)]);
        xml.empty("child", &[("link", child.clone())]);
        let unit = [0, 1, 2].map(|k| if k == i { "1" } else { "0" });
        xml.empty("axis", &[("xyz", unit.join(" "))]);
        xml.end();
        parent = child;
    }
}

/// Reports what URDF does not hold of a joint.
fn report_joint(joint: &JointProperties, export: &mut Export<'_>, path: &str) {
    let report = &mut export.report;
    if joint.stiffness != 0.0 {
        report.lost("URDF has no springs: those of joints are left out", path);
    }
    if joint.armature != 0.0 {
        report.lost("URDF has no rotor inertia: that of joints (`armature`) is left out", path);
    }
    let start = joint.limits.map_or(0.0, |[low, high]| 0.0f64.clamp(low, high));
    if joint.follow.is_none() && (joint.position - start).abs() > 1e-12 {
        report.lost("URDF has no start positions: joints start at 0, or at the nearest limit", path);
    }
    if !joint.has_motor() && joint.follow.is_none() {
        report.note("joints without a motor have an effort of 0, for which some programs assume a motor", path);
    }
    if joint.has_motor() {
        report.note("URDF has no control modes: of motors, it holds effort and speed", path);
    }
}
