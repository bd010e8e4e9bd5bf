//! Builds joints. Several joints of one body become a chain with light links in between.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use tatu_plugin_api::safe::Result;

use super::{
    ModelBuilder, Placed,
    forms::{self, LINK_SHARE},
};
use crate::{
    compiler::{quaternion, turn_to},
    drives::{Drive, JointIndex},
    model::{Joint, JointKind},
};

/// Largest magnitude of limits, rad or m.
const MAX_LIMIT: f64 = 1e6;

/// Returns the pose of a joint in the frame of its body: the z axis is the joint's.
fn frame(joint: &Joint) -> Isometry3<f64> {
    let turn = match joint.kind {
        JointKind::Ball => UnitQuaternion::identity(),
        _ => turn_to(&Unit::new_normalize(joint.axis)),
    };
    Isometry3::from_parts(Translation3::from(joint.at), turn)
}

/// Returns the motion of a joint from position 0 to its reference, at which the pose of the file is stated.
fn reference(joint: &Joint) -> Isometry3<f64> {
    match joint.kind {
        JointKind::Hinge => Isometry3::rotation(Vector3::z() * joint.reference),
        JointKind::Slide => Isometry3::translation(0.0, 0.0, joint.reference),
        JointKind::Ball => Isometry3::identity(),
    }
}

impl<'b> ModelBuilder<'_, 'b> {
    /// Builds the joints of a group's first body below the shape of its parent. Returns the last joint, and the pose of
    /// the body below it.
    pub(super) fn chain(&mut self, number: usize, above: Placed<'b>) -> Result<(Placed<'b>, Isometry3<f64>)> {
        let (model, group) = (self.model, &self.groups.all[number]);
        let body = &model.bodies[group.first];
        let (mut parent, mut pose) = (above, group.pose);
        for (j, joint) in body.joints.iter().enumerate() {
            if j > 0 {
                let link = self.object("shape", &parent, &format!("{}_link_{j}", body.name), &pose)?;
                forms::make_empty(link.node)?;
                forms::set_mass(link.node, &forms::moving_mass(group).scaled(LINK_SHARE))?;
                (parent, pose) = (link, Isometry3::identity());
            }
            let placed = self.object("joint", &parent, &joint.name, &(pose * frame(joint)))?;
            self.joint((group.first, j), joint, &placed)?;
            pose = (frame(joint) * reference(joint)).inverse();
            parent = placed.clone();
            self.joints.insert((group.first, j), placed);
        }
        if body.joints.len() > 1 {
            self.links.insert(group.first, body.joints.len() - 1);
        }
        Ok((parent, pose))
    }

    fn joint(&mut self, index: JointIndex, joint: &Joint, placed: &Placed<'b>) -> Result {
        let node = placed.node;
        let kind = match joint.kind {
            JointKind::Hinge => "revolute",
            JointKind::Slide => "prismatic",
            JointKind::Ball => "spherical",
        };
        node.set("joint.type", kind)?.set("joint.mode", "dynamic")?;
        let [q, rest @ ..] = self.start.joints.get(&index).copied().unwrap_or([joint.reference, 0.0, 0.0, 0.0]);
        if joint.kind == JointKind::Ball {
            if joint.range.is_some() || joint.stiffness > 0.0 {
                self.report.warn(&joint.place, "limits and springs of ball joints are omitted");
            }
            let turn = quaternion([q, rest[0], rest[1], rest[2]]).unwrap_or_default().coords;
            node.set("joint.rotation", [turn.x, turn.y, turn.z, turn.w])?.set("joint.damping", joint.damping)?;
            return Ok(());
        }
        let (mut stiffness, mut damping) = (joint.stiffness, joint.damping);
        if let Some([time, ratio]) = joint.spring_damper {
            let inertia = self.groups.inertia_at(index.0, joint);
            (stiffness, damping) = (inertia / (time * time), 2.0 * ratio * inertia / time);
        }
        if let Some(held) = self.couplings.held.get(&index) {
            self.report.note(&joint.place, "joints that an equality constraint holds cannot move");
            node.set("joint.limits", [*held, *held])?;
        } else if let Some([low, high]) = joint.range {
            let (low, high) = (low.max(-MAX_LIMIT), high.min(MAX_LIMIT));
            node.set("joint.limits", [low, high])?;
            if q < low || q > high {
                self.report.warn(&joint.place, "joints that start outside their limits start at the nearest limit");
            }
        }
        let mut rest = joint.rest;
        let driven = self.couplings.drives.get(&index).copied();
        damping += driven.map_or(0.0, |d| d.damping);
        match driven.map_or(Drive::Free, |d| d.drive) {
            Drive::Free => node.set("joint.control", "free")?,
            Drive::Force(force) => node.set("joint.control", "force")?.set("joint.max_force", force)?,
            Drive::Velocity { target, slip, max_force } => node
                .set("joint.control", "velocity")?
                .set("joint.target_velocity", target)?
                .set("joint.slip", slip)?
                .set("joint.max_force", max_force)?,
            Drive::Spring { target, stiffness: of_servo } => {
                (stiffness, rest) = (of_servo, target);
                node.set("joint.control", "spring")?.set("joint.target_position", target)?
            }
            Drive::Position { target, max_force } => node
                .set("joint.control", "position")?
                .set("joint.target_position", target)?
                .set("joint.max_force", max_force)?,
        };
        node.set("joint.stiffness", stiffness)?
            .set("joint.rest_position", rest)?
            .set("joint.damping", damping)?
            .set("joint.dry_friction", joint.friction)?
            .set("joint.armature", joint.armature)?
            .set("joint.position", q)?;
        Ok(())
    }

    /// Lets joints follow those to which they are geared.
    pub(super) fn gears(&mut self) -> Result {
        let top = |(body, _): JointIndex| {
            let groups = self.groups;
            let top = groups.all[groups.of_body[body].0].top;
            // Joints at the top level share an anchor.
            self.anchors.get(&top).map_or_else(|| format!("{top}"), |anchor| anchor.path.clone())
        };
        for (index, gear) in &self.couplings.gears {
            let (Some(own), Some(leader)) = (self.joints.get(index), self.joints.get(&gear.leader)) else { continue };
            if top(*index) != top(gear.leader) {
                let place = &self.model.bodies[index.0].joints[index.1].place;
                self.report.warn(place, "a joint cannot be geared to one of another mechanism");
                continue;
            }
            own.node
                .set("joint.follows", format!(":{}", leader.path).as_str())?
                .set("joint.follow_factor", gear.factor)?
                .set("joint.follow_offset", gear.offset)?
                .set("joint.geared", true)?;
        }
        Ok(())
    }
}
