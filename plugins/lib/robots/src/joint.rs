//! Builds joints and their motors.

use nalgebra::Isometry3;
use tatu_plugin_api::safe::{Builder, Fail, Node, Result};

use crate::{
    findings::{FindingKind, Findings},
    form::set_object_pose,
    robot::{Joint, JointKind, JointLimit, Mimic, MotorKind, Robot, alias},
    settings::BuildSettings,
};

/// Creates a joint below the shape of a body; its motor is set later, by [`set_motor`].
pub fn joint<'a>(
    builder: &Builder<'a>,
    parent: Node<'a>,
    (robot, joint): (&Robot, &Joint),
    frame: &Isometry3<f64>,
    findings: &Findings,
) -> Result<Node<'a>> {
    let line = joint.line;
    let limit = joint.limit;
    let what = format!("limit of the joint `{}`", joint.name);
    if [limit.lower, limit.upper, limit.velocity].iter().any(|x| x.is_nan()) {
        return Err(Fail::argument(format!("{what}: expected numbers, found NaN")).at("", line));
    }
    let kind = match joint.kind {
        JointKind::Prismatic => "prismatic",
        JointKind::Ball => "spherical",
        _ => "revolute",
    };
    let node = builder.object("joint", Some(parent), &alias(&joint.name))?;
    let node = set_object_pose(node, frame)?.set("joint.type", kind)?.set("joint.mode", "dynamic")?;
    let positive = |x: f64| if x.is_finite() { x.max(0.0) } else { 0.0 };
    if joint.kind == JointKind::Ball {
        return node.set("joint.damping", joint.dynamics.map_or(0.0, |d| positive(d.damping)));
    }
    if let JointKind::Screw(lead) = joint.kind {
        node.set("joint.lead", lead)?;
    }
    if joint.kind != JointKind::Continuous && (limit.lower.is_finite() || limit.upper.is_finite()) {
        let (mut lower, mut upper) = (limit.lower, limit.upper);
        if lower > upper {
            findings.warn(
                FindingKind::Limits,
                line,
                format!("{what}: `lower` {lower} exceeds `upper` {upper}: swapped"),
            );
            (lower, upper) = (upper, lower);
        }
        if lower == upper {
            let text = match limit == JointLimit::default() {
                true => format!("the joint `{}` states no limits, which are 0 then: it cannot move", joint.name),
                false => format!("{what}: lower and upper are both {lower}, so the joint cannot move"),
            };
            findings.warn(FindingKind::Immovable, line, text);
        }
        let (lower, upper) = (lower.max(-1e6), upper.min(1e6));
        node.set("joint.limits", [lower, upper])?;
        if (lower > 0.0 || upper < 0.0) && !mimics(robot, joint) {
            let text =
                format!("the limits of the joint `{}` exclude 0: it starts at {}", joint.name, start(robot, joint, 0));
            findings.note(FindingKind::StartsAtLimit, line, text);
        }
    }
    let start = start(robot, joint, 0);
    if start != 0.0 {
        node.set("joint.position", start)?.set("joint.target_position", start)?;
    }
    if limit.velocity > 0.0 {
        node.set("joint.max_velocity", limit.velocity.min(1e6))?;
    }
    if let Some(d) = &joint.dynamics {
        node.set("joint.damping", positive(d.damping))?.set("joint.dry_friction", positive(d.friction))?;
        let [stiffness, rest] = d.spring;
        if stiffness > 0.0 && stiffness.is_finite() && rest.is_finite() {
            node.set("joint.stiffness", stiffness)?.set("joint.rest_position", rest)?;
        }
    }
    if let Some(mimic) = &joint.mimic
        && !robot.joints.iter().any(|other| other.name == mimic.joint)
    {
        let text =
            format!("the joint `{}` mimics `{}`, which does not exist: it moves by itself", joint.name, mimic.joint);
        findings.warn(FindingKind::Mimic, line, text);
    } else if let Some(mimic) = &joint.mimic {
        let [factor, offset] = mimic_law(mimic);
        node.set("joint.follows", format!(":/{}", alias(&mimic.joint)).as_str())?
            .set("joint.follow_factor", factor)?
            .set("joint.follow_offset", offset)?
            .set("joint.geared", true)?;
    }
    Ok(node)
}

/// Sets the motors of all joints: each with its stated effort or, without one, with the effort that is assumed, which is
/// reported. A joint that mimics another one is moved by it, and has a motor only if its effort is stated; so has a joint
/// for which no effort is assumed. `joints` has the number, the object and the assumed effort of each.
pub fn set_motors<'a>(
    robot: &Robot,
    joints: &[(usize, Node<'a>, Option<f64>)],
    settings: &BuildSettings,
    findings: &Findings,
) -> Result {
    let (mut least, mut most, mut assumed) = (f64::MAX, 0.0f64, 0);
    // The kinds of joints, which determine the unit of efforts.
    let (mut slide, mut turn) = (false, false);
    let mut unpowered = 0;
    for (j, node, effort) in joints {
        let joint = &robot.joints[*j];
        let is_off = settings.motors == "auto" && joint.motor == MotorKind::Off;
        let stated = joint.limit.effort.filter(|e| !e.is_nan());
        let effort = match stated {
            Some(stated) => stated.min(1e9),
            None if mimics(robot, joint) => 0.0,
            // A script that switches the motor on finds it strong enough.
            None if is_off => effort.map_or(0.0, |effort| settings.default_effort.unwrap_or(effort)),
            None => effort.map_or(0.0, |effort| {
                let effort = settings.default_effort.unwrap_or(effort);
                (least, most, assumed) = (least.min(effort), most.max(effort), assumed + 1);
                effort
            }),
        };
        unpowered += usize::from(is_off && !mimics(robot, joint));
        let control = match (settings.motors.as_str(), joint.motor) {
            _ if effort <= 0.0 => "free",
            ("auto", MotorKind::Off) => "free",
            ("auto", MotorKind::Velocity(_)) => "velocity",
            ("auto", MotorKind::Position(_)) => "position",
            ("auto", MotorKind::Force) => "force",
            ("auto", MotorKind::ByType) if joint.kind == JointKind::Continuous => "velocity",
            ("auto", MotorKind::ByType) => "position",
            (mode, _) => mode,
        };
        // In force control, the greatest force is the one that acts.
        node.set("joint.control", control)?.set("joint.max_force", if control == "force" { 0.0 } else { effort })?;
        match joint.motor {
            MotorKind::Velocity(target) if control == "velocity" && target != 0.0 => {
                node.set("joint.target_velocity", target)?;
            }
            MotorKind::Position(target) if control == "position" && target != 0.0 => {
                node.set("joint.target_position", target)?;
            }
            _ => {}
        }
        match joint.kind {
            JointKind::Prismatic => slide = true,
            _ => turn = true,
        }
    }
    if assumed > 0 {
        let unit = match (turn, slide) {
            (true, true) => "N m or N",
            (false, true) => "N",
            _ => "N m",
        };
        let motors = match most {
            0.0 => "no motor".to_owned(),
            most if most == least => format!("motors of {most} {unit} are assumed"),
            most => format!("motors of {least} to {most} {unit} are assumed"),
        };
        let n = joints.len();
        let text = format!("{assumed} of {n} joints without a stated effort: {motors} (parameter `default_effort`)");
        findings.note(FindingKind::Effort, 0, text);
    }
    if unpowered > 0 {
        let n = joints.len();
        let text =
            format!("{unpowered} of {n} joints have no controller in the file and move freely (parameter `motors`)");
        findings.note(FindingKind::Motor, 0, text);
    }
    Ok(())
}

/// Largest multiplier and offset of a joint that mimics another one.
const MAX_MIMIC: f64 = 1e6;

/// Returns multiplier and offset; those that are not finite are the defaults.
fn mimic_law(mimic: &Mimic) -> [f64; 2] {
    let number = |x: Option<f64>, or: f64| x.filter(|x| x.is_finite()).unwrap_or(or).clamp(-MAX_MIMIC, MAX_MIMIC);
    [number(mimic.multiplier, 1.0), number(mimic.offset, 0.0)]
}

/// Returns the position at which a joint starts: 0 or the limit that is nearest to it; for a joint that mimics another
/// one, that which follows from the start of the other. `depth` is the number of joints that led here.
fn start(robot: &Robot, joint: &Joint, depth: usize) -> f64 {
    let leader = joint.mimic.as_ref().and_then(|m| Some((m, robot.joints.iter().find(|j| j.name == m.joint)?)));
    if let Some((mimic, leader)) = leader
        && depth < MAX_CHAIN
    {
        let [factor, offset] = mimic_law(mimic);
        return factor * start(robot, leader, depth + 1) + offset;
    }
    let JointLimit { lower, upper, .. } = joint.limit;
    match joint.kind {
        JointKind::Continuous => 0.0,
        _ if lower.is_nan() || upper.is_nan() => 0.0,
        _ => 0.0f64.clamp(lower.min(upper).max(-1e6), upper.max(lower).min(1e6)),
    }
}

/// Maximum number of joints that mimic each other in a chain.
const MAX_CHAIN: usize = 64;

/// Returns whether a joint mimics a joint that exists.
fn mimics(robot: &Robot, joint: &Joint) -> bool {
    joint.mimic.as_ref().is_some_and(|mimic| robot.joints.iter().any(|other| other.name == mimic.joint))
}

/// Returns whether a joint mimics another joint, or is mimicked by one.
pub fn is_geared(robot: &Robot, joint: usize) -> bool {
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
/// Smallest length of such a link that is assumed, m.
const MIN_LENGTH: f64 = 0.01;

/// Gives a coupled joint that moves a light link an armature. `radius` is the distance of the link's centre of mass from
/// the axis, `lever` that of its farthest point, m; `mass` is that of the link, kg.
pub fn add_armature(
    node: Node<'_>,
    joint: &Joint,
    (mass, radius, lever): (f64, f64, f64),
    findings: &Findings,
) -> Result {
    if mass >= LIGHT_LINK_KG {
        return Ok(());
    }
    // A uniform rod is twice as long as the distance from its end to its centre of mass. If that is on the axis, the
    // form tells the length.
    let length = if radius > 1e-4 { 2.0 * radius } else { lever.max(MIN_LENGTH) };
    let (armature, unit) = match joint.kind {
        JointKind::Prismatic => (ROTOR_MASS_KG, "kg"),
        _ => (ROTOR_MASS_KG * length * length, "kg m^2"),
    };
    node.set("joint.armature", armature)?;
    let text = format!(
        "the joint `{}` is coupled, and its link weighs only {:.0} g: an armature of {armature:.2e} {unit} is assumed, \
         so that grasps are stable; set `armature_kg` or `armature_kg_m2` to the value of its motor",
        joint.name,
        mass * 1e3
    );
    findings.note(FindingKind::Armature, joint.line, text);
    Ok(())
}
