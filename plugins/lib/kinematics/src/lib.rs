//! Copies kinematic chains of a scene for inverse kinematics, for use by command plugins. A [`SceneCopy`] contains
//! copies of frames and joints, which inverse kinematics moves, and maps them to the objects of the scene.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};
use tatu_kinematics::{FrameId, IkTask, JointRole, JointType, Linkage, group_jacobian};
use tatu_plugin_api::{
    abi::{TATU_KIND_JOINT, tatu_object},
    safe::{Fail, Host, Prop, Result, World},
};

/// A full turn, rad.
const TURN: f64 = 2.0 * std::f64::consts::PI;

/// Interned keys of the properties that copies read and write.
pub struct SceneProps {
    /// Custom data of the scene.
    pub scene_data: Prop,
    /// Custom data of an object.
    pub object_data: Prop,
    /// Path of the dummy to which a dummy is linked.
    pub dummy_link: Prop,
    parent: Prop,
    joint_type: Prop,
    joint_mode: Prop,
    joint_position: Prop,
    joint_target_position: Prop,
    joint_rotation: Prop,
    joint_limits: Prop,
    joint_cyclic: Prop,
    joint_lead: Prop,
    joint_follows: Prop,
    joint_follow_factor: Prop,
    joint_follow_offset: Prop,
}

impl SceneProps {
    /// Interns the keys.
    pub fn new(host: &Host) -> Self {
        SceneProps {
            scene_data: host.prop("scene.data"),
            object_data: host.prop("object.data"),
            dummy_link: host.prop("dummy.link"),
            parent: host.prop("object.parent"),
            joint_type: host.prop("joint.type"),
            joint_mode: host.prop("joint.mode"),
            joint_position: host.prop("joint.position"),
            joint_target_position: host.prop("joint.target_position"),
            joint_rotation: host.prop("joint.rotation"),
            joint_limits: host.prop("joint.limits"),
            joint_cyclic: host.prop("joint.cyclic"),
            joint_lead: host.prop("joint.lead"),
            joint_follows: host.prop("joint.follows"),
            joint_follow_factor: host.prop("joint.follow_factor"),
            joint_follow_offset: host.prop("joint.follow_offset"),
        }
    }
}

/// Converts a position, m, and a quaternion x y z w to a pose.
pub fn pose_of([x, y, z, qx, qy, qz, qw]: [f64; 7]) -> Isometry3<f64> {
    let turned = UnitQuaternion::try_new(Quaternion::new(qw, qx, qy, qz), 1e-9);
    Isometry3::from_parts(Translation3::new(x, y, z), turned.unwrap_or_else(UnitQuaternion::identity))
}

/// Returns the parent of an object; `None` for the world.
fn parent_of(world: &World<'_>, props: &SceneProps, object: tatu_object) -> Result<Option<tatu_object>> {
    let parent = world.get(object, props.parent)?.as_object().unwrap_or(0);
    if parent == 0 { Ok(None) } else { Ok(Some(world.look(parent)?.id)) }
}

/// Frames and joints, some of which are copies of objects of the scene. Objects are identified by their full ids,
/// because handles of removed objects are reused.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SceneCopy {
    /// The frames and joints.
    pub linkage: Linkage,
    /// For each copied frame, the id of the object in the scene.
    pub objects: BTreeMap<FrameId, tatu_object>,
}

impl SceneCopy {
    /// Returns the copy of an object, or `None` if the object was not copied.
    pub fn copy_of(&self, object: tatu_object) -> Option<FrameId> {
        self.objects.iter().find(|(_, o)| **o == object).map(|(frame, _)| *frame)
    }

    /// Copies the chain of objects from a tip up to a base, or up to the world if `base` is `None`, and returns the
    /// copy of the tip. Existing copies are reused.
    ///
    /// # Errors
    ///
    /// Fails if an object does not exist, or if the base is not above the tip.
    pub fn copy_chain(
        &mut self,
        world: &World<'_>,
        props: &SceneProps,
        base: Option<tatu_object>,
        tip: tatu_object,
    ) -> Result<FrameId> {
        let mut chain = vec![tip];
        loop {
            let above = parent_of(world, props, chain[chain.len() - 1])?;
            match above {
                Some(object) if Some(object) != base => chain.push(object),
                None if base.is_some() => {
                    return Err(Fail::argument("the base is not an ancestor of the tip")
                        .help("pass an ancestor of the tip as the base, or -1 for the world"));
                }
                _ => break,
            }
        }
        let mut parent = base.map(|base| self.copy_frame(world, props, base)).transpose()?;
        for object in chain.iter().rev() {
            let copy = match self.copy_of(*object) {
                Some(copy) => copy,
                None => self.copy_object(world, props, *object, parent)?,
            };
            parent = Some(copy);
        }
        for object in &chain {
            self.copy_dependency(world, props, *object)?;
        }
        parent.ok_or_else(|| Fail::argument("the chain from the base to the tip contains no object"))
    }

    /// Copies a single object as a frame, and attaches it to the copy of its nearest copied ancestor.
    ///
    /// # Errors
    ///
    /// Fails if the object does not exist.
    pub fn copy_frame(&mut self, world: &World<'_>, props: &SceneProps, object: tatu_object) -> Result<FrameId> {
        if let Some(copy) = self.copy_of(object) {
            return Ok(copy);
        }
        let mut above = parent_of(world, props, object)?;
        while let Some(next) = above {
            if let Some(copy) = self.copy_of(next) {
                return self.copy_object(world, props, object, Some(copy));
            }
            above = parent_of(world, props, next)?;
        }
        self.copy_object(world, props, object, None)
    }

    fn copy_object(
        &mut self,
        world: &World<'_>,
        props: &SceneProps,
        object: tatu_object,
        parent: Option<FrameId>,
    ) -> Result<FrameId> {
        let found = world.look(object)?;
        let pose = pose_of(world.pose(found.id, 0)?);
        let copy = if found.kind == TATU_KIND_JOINT {
            let kind = match world.get(found.id, props.joint_type)?.as_str().as_deref() {
                Some("prismatic") => JointType::Prismatic,
                Some("spherical") => JointType::Spherical,
                _ => JointType::Revolute,
            };
            let copy = self.linkage.add_joint(parent, Isometry3::identity(), kind);
            let cyclic = world.get(found.id, props.joint_cyclic)?.as_bool().unwrap_or(false);
            let limits = world.get(found.id, props.joint_limits)?.array::<2>();
            let lead = world.f64(found.id, props.joint_lead).unwrap_or(0.0) / TURN;
            if let Some(joint) = self.linkage.joint_mut(copy) {
                (joint.limits, joint.lead) = (limits.filter(|[low, high]| !cyclic && low <= high), lead);
            }
            self.copy_position(world, props, copy, object)?;
            copy
        } else {
            self.linkage.add_frame(parent, Isometry3::identity())
        };
        self.linkage.set_pose(copy, &pose);
        self.objects.insert(copy, object);
        Ok(copy)
    }

    /// If a joint follows another joint in the scene, makes its copy follow the copy of that joint.
    fn copy_dependency(&mut self, world: &World<'_>, props: &SceneProps, object: tatu_object) -> Result {
        let found = world.look(object)?;
        let Some(copy) = self.copy_of(object).filter(|_| found.kind == TATU_KIND_JOINT) else { return Ok(()) };
        let path = world.get(found.id, props.joint_follows)?.as_str().unwrap_or_default().into_owned();
        if path.is_empty() {
            return Ok(());
        }
        let master = world.look(world.find(found.id, &path)?)?.id;
        let master = self.copy_frame(world, props, master)?;
        let factor = world.f64(found.id, props.joint_follow_factor)?;
        let offset = world.f64(found.id, props.joint_follow_offset)?;
        if let Some(joint) = self.linkage.joint_mut(copy) {
            joint.role = JointRole::Dependent { master, factor, offset };
        }
        Ok(())
    }

    /// Sets the position of a copied joint to that of the joint in the scene.
    fn copy_position(&mut self, world: &World<'_>, props: &SceneProps, copy: FrameId, object: tatu_object) -> Result {
        let Some(joint) = self.linkage.joint_mut(copy) else { return Ok(()) };
        if joint.kind == JointType::Spherical {
            let [x, y, z, w] = world.f64s::<4>(object, props.joint_rotation)?;
            joint.rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        } else {
            joint.position = world.f64(object, props.joint_position)?;
        }
        Ok(())
    }

    /// Copies the positions of all joints, and the poses of bases and targets, from the scene. Objects that were
    /// removed from the scene are skipped.
    ///
    /// # Errors
    ///
    /// Fails if a property cannot be read.
    pub fn take_from_scene(&mut self, world: &World<'_>, props: &SceneProps, targets: &[FrameId]) -> Result {
        let exists = |object: tatu_object| world.look(object).is_ok();
        let copies: Vec<(FrameId, tatu_object)> =
            self.objects.iter().map(|(f, o)| (*f, *o)).filter(|(_, o)| exists(*o)).collect();
        for (copy, object) in &copies {
            self.copy_position(world, props, *copy, *object)?;
        }
        for (copy, object) in &copies {
            if self.linkage.parent(*copy).is_none() || targets.contains(copy) {
                let pose = pose_of(world.pose(*object, 0)?);
                self.linkage.set_pose(*copy, &pose);
            }
        }
        Ok(())
    }

    /// Moves joints of the scene to the positions of their copies. For dynamic joints, sets the target position
    /// instead.
    ///
    /// # Errors
    ///
    /// Fails if a property cannot be set.
    pub fn give_to_scene(&self, world: &World<'_>, props: &SceneProps, joints: &[FrameId]) -> Result {
        for copy in joints {
            let Some(object) = self.objects.get(copy).copied().filter(|o| world.look(*o).is_ok()) else { continue };
            let Some(joint) = self.linkage.joint(*copy).filter(|j| j.role != JointRole::Fixed) else { continue };
            let driven = world.get(object, props.joint_mode)?.as_str().as_deref() == Some("dynamic");
            if joint.kind == JointType::Spherical {
                let q = joint.rotation.coords;
                world.set_f64s(object, props.joint_rotation, &[q.x, q.y, q.z, q.w])?;
            } else {
                let prop = if driven { props.joint_target_position } else { props.joint_position };
                world.set_f64s(object, prop, &[self.linkage.position(*copy)])?;
            }
        }
        Ok(())
    }

    /// Returns the joints that tasks move, and all joints that depend on them.
    pub fn joints_of(&self, tasks: &[IkTask]) -> Vec<FrameId> {
        let columns = group_jacobian(&self.linkage, tasks).columns;
        let moved: Vec<FrameId> = columns.iter().map(|column| column.joint).collect();
        let depends = |id: &FrameId| {
            let role = self.linkage.joint(*id).map(|j| j.role);
            matches!(role, Some(JointRole::Dependent { master, .. }) if moved.contains(&master))
        };
        self.linkage.ids().filter(|id| moved.contains(id) || depends(id)).collect()
    }
}
