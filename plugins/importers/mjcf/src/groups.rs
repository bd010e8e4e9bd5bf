//! Bodies that are fixed to each other form a group, which becomes one body of the scene.

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::Mass;

use crate::model::{Joint, JointKind, Model};

/// How the first body of a group is attached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Attachment {
    Fixed,
    Free,
    Joints,
}

/// A group: its first body, and all bodies with their poses in it.
pub struct BodyGroup {
    pub first: usize,
    pub attachment: Attachment,
    pub bodies: Vec<(usize, Isometry3<f64>)>,
    /// The mass of all bodies in the frame of the first one.
    pub mass: Mass,
    /// The group of the parent; 0 is the world.
    pub parent: usize,
    /// Pose in the frame of the parent's group.
    pub pose: Isometry3<f64>,
    /// The group at the top level from which this one descends.
    pub top: usize,
    /// Whether other groups have this one as their parent.
    pub carries: bool,
}

/// All groups; the first one is the world.
pub struct BodyGroups {
    pub all: Vec<BodyGroup>,
    /// Group of each body, and pose in it.
    pub of_body: Vec<(usize, Isometry3<f64>)>,
    /// Pose of each body in the world, as in the file.
    pub world: Vec<Isometry3<f64>>,
    /// Inertia of everything that the joints of a body carry, in the world frame.
    carried: Vec<Mass>,
}

impl BodyGroups {
    pub fn new(model: &Model) -> Self {
        let mut all: Vec<BodyGroup> = Vec::new();
        let mut of_body: Vec<(usize, Isometry3<f64>)> = Vec::new();
        let mut world: Vec<Isometry3<f64>> = Vec::new();
        for (i, body) in model.bodies.iter().enumerate() {
            if i == 0 {
                world.push(Isometry3::identity());
                of_body.push((0, Isometry3::identity()));
                all.push(BodyGroup {
                    first: 0,
                    attachment: Attachment::Fixed,
                    bodies: vec![(0, Isometry3::identity())],
                    mass: Mass::ZERO,
                    parent: 0,
                    pose: Isometry3::identity(),
                    top: 0,
                    carries: false,
                });
                continue;
            }
            world.push(world[body.parent] * body.pose);
            let (above, in_above) = of_body[body.parent];
            let pose = in_above * body.pose;
            let attachment = match () {
                () if body.is_free => Attachment::Free,
                () if !body.joints.is_empty() => Attachment::Joints,
                () => Attachment::Fixed,
            };
            if attachment == Attachment::Fixed && above != 0 {
                of_body.push((above, pose));
                all[above].bodies.push((i, pose));
                continue;
            }
            let number = all.len();
            let top = if above == 0 { number } else { all[above].top };
            all[above].carries = true;
            of_body.push((number, Isometry3::identity()));
            all.push(BodyGroup {
                first: i,
                attachment,
                bodies: vec![(i, Isometry3::identity())],
                mass: Mass::ZERO,
                parent: above,
                pose,
                top,
                carries: false,
            });
        }
        for group in &mut all {
            let masses: Vec<Mass> = group.bodies.iter().map(|(b, pose)| model.bodies[*b].mass.moved(pose)).collect();
            group.mass = Mass::sum(&masses);
        }
        let mut carried: Vec<Mass> =
            model.bodies.iter().zip(&world).map(|(body, pose)| body.mass.moved(pose)).collect();
        for i in (1..model.bodies.len()).rev() {
            let parent = model.bodies[i].parent;
            carried[parent] = Mass::sum(&[carried[parent], carried[i]]);
        }
        BodyGroups { all, of_body, world, carried }
    }

    /// Returns the inertia that a joint of a body moves in the pose of the file, with its armature.
    pub fn inertia_at(&self, body: usize, joint: &Joint) -> f64 {
        let (pose, carried) = (&self.world[body], &self.carried[body]);
        let about = match joint.kind {
            JointKind::Slide => carried.mass,
            JointKind::Hinge => {
                let axis: Vector3<f64> = pose.rotation * joint.axis;
                let at = pose.transform_point(&joint.at.into()).coords;
                axis.dot(&(carried.inertia_about(at) * axis))
            }
            JointKind::Ball => 0.0,
        };
        about + joint.armature
    }
}
