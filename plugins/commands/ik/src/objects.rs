//! Commands for frames: dummies and joints, their parents and poses.

use nalgebra::Isometry3;
use tatu_kinematics::{FrameId, JointType};
use tatu_plugin_api::safe::{Command, Fail, Offer, Param, Result, Value, ValueRef};

use crate::{
    arguments::{
        angles, command, frame, frame_or_world, handle_of, handle_or_world, matrix_numbers, orientation, pose,
        pose_numbers, reference,
    },
    constants::{JOINT_PRISMATIC, JOINT_REVOLUTE, JOINT_SPHERICAL},
    environment::{Ctx, Environment, Ik, environment},
};

fn object() -> Param {
    Param::int("object")
}

/// Sets the name of a new frame to the first non-empty string among the arguments from index `first`, if there is one.
fn name_frame(c: &Ctx<'_>, environment: &mut Environment, id: FrameId, first: usize) {
    let name = (first..c.args().len()).find_map(|i| c.arg(i).as_str());
    if let Some(name) = name.filter(|n| !n.is_empty()) {
        environment.names.insert(id, name.into_owned());
    }
}

fn joint_type(number: i64) -> Result<JointType> {
    match number {
        JOINT_REVOLUTE => Ok(JointType::Revolute),
        JOINT_PRISMATIC => Ok(JointType::Prismatic),
        JOINT_SPHERICAL => Ok(JointType::Spherical),
        _ => Err(Fail::argument(format!("expected a joint type such as `simIK.jointtype_revolute`, found {number}"))),
    }
}
fn type_number(kind: JointType) -> i64 {
    match kind {
        JointType::Revolute => JOINT_REVOLUTE,
        JointType::Prismatic => JOINT_PRISMATIC,
        JointType::Spherical => JOINT_SPHERICAL,
    }
}

/// Returns the indices of the arguments that contain a pose and the frame to which it is relative. Up to version 4.5,
/// the frame preceded the pose.
fn pose_and_reference(c: &Ctx<'_>) -> (usize, usize) {
    if c.arg(2).numbers().is_some_and(|n| n.len() > 1) { (2, 3) } else { (3, 2) }
}

fn relative_pose(environment: &Environment, id: FrameId, relative: Option<FrameId>) -> Isometry3<f64> {
    let world = environment.copy.linkage.pose(id);
    relative.map_or(world, |r| environment.copy.linkage.pose(r).inverse() * world)
}
fn set_relative_pose(environment: &mut Environment, id: FrameId, relative: Option<FrameId>, pose: Isometry3<f64>) {
    let world = relative.map_or(pose, |r| environment.copy.linkage.pose(r) * pose);
    environment.copy.linkage.set_pose(id, &world);
}

/// Builds a command that returns the pose of an object; `ret` converts the pose to return values.
fn getter(name: &str, ret: fn(&mut Ctx<'_>, &Isometry3<f64>), returns: Vec<Param>) -> Command<Ik> {
    let run = move |c: &mut Ctx<'_>| {
        let found = {
            let environment = environment(c)?;
            let id = frame(c, &environment, 1)?;
            relative_pose(&environment, id, reference(c, &environment, 2, id)?)
        };
        ret(c, &found);
        Ok(())
    };
    let command = command(name, run).param(object()).param(Param::int("relative_to").optional());
    returns.into_iter().fold(command, Command::returns)
}

/// Builds a command that sets the pose of an object, given as 7 numbers or as a matrix.
fn setter(name: &str) -> Command<Ik> {
    command(name, |c| {
        let mut environment = environment(c)?;
        let id = frame(c, &environment, 1)?;
        let (at, relative) = pose_and_reference(c);
        let relative = reference(c, &environment, relative, id)?;
        set_relative_pose(&mut environment, id, relative, pose(c, at)?);
        Ok(())
    })
    .param(object())
    .param(Param::any("pose"))
    .param(Param::any("relative_to").optional())
    .notes("Until version 4.5, the frame to which the pose is relative came before the pose; both orders are accepted.")
}

pub fn offer(offer: &mut Offer<Ik>) {
    creation(offer);
    listing(offer);
    poses(offer);
}

fn creation(offer: &mut Offer<Ik>) {
    offer.command(
        command("createDummy", |c| {
            let made = {
                let mut environment = environment(c)?;
                environment.check_room()?;
                let made = environment.copy.linkage.add_frame(None, Isometry3::identity());
                name_frame(c, &mut environment, made, 1);
                made
            };
            c.ret(handle_of(made));
            Ok(())
        })
        .param(Param::string("name").optional())
        .returns(object())
        .text("Creates a frame at the origin of the world."),
    );
    offer.command(
        command("createJoint", |c| {
            // The type may precede or follow the name.
            let number = (1..c.args().len()).find_map(|i| c.arg(i).as_i64().filter(|_| c.arg(i).as_str().is_none()));
            let kind = joint_type(number.unwrap_or(JOINT_REVOLUTE))?;
            let made = {
                let mut environment = environment(c)?;
                environment.check_room()?;
                let made = environment.copy.linkage.add_joint(None, Isometry3::identity(), kind);
                name_frame(c, &mut environment, made, 1);
                made
            };
            c.ret(handle_of(made));
            Ok(())
        })
        .param(Param::any("type").text("a constant, such as `simIK.jointtype_revolute`"))
        .param(Param::any("name").optional())
        .returns(object())
        .text("Creates a joint at the origin of the world, with its axis along z, that inverse kinematics moves."),
    );
    offer.command(
        command("eraseObject", |c| {
            let mut environment = environment(c)?;
            let id = frame(c, &environment, 1)?;
            environment.copy.linkage.remove(id);
            environment.names.remove(&id);
            environment.copy.objects.remove(&id);
            for group in environment.groups.values_mut() {
                let gone = |t: &tatu_kinematics::IkTask| t.tip == id || t.target == id || t.base == Some(id);
                let kept: Vec<bool> = group.group.tasks.iter().map(|t| !gone(t)).collect();
                let mut keep = kept.iter();
                group.group.tasks.retain(|_| *keep.next().unwrap_or(&true));
                let mut keep = kept.iter();
                group.elements.retain(|_| *keep.next().unwrap_or(&true));
            }
            Ok(())
        })
        .param(object())
        .text("Removes an object and the elements that use it. Its children keep their poses in the world."),
    );
    offer.command(
        command("setObjectParent", |c| {
            let mut environment = environment(c)?;
            let id = frame(c, &environment, 1)?;
            let parent = frame_or_world(c, &environment, 2)?;
            let pose = environment.copy.linkage.pose(id);
            if !environment.copy.linkage.set_parent(id, parent) {
                return Err(Fail::argument(
                    "argument 3: the new parent is the object itself or one of its descendants",
                ));
            }
            if !c.has(3) || c.arg(3).truthy() {
                environment.copy.linkage.set_pose(id, &pose);
            }
            Ok(())
        })
        .param(object())
        .param(Param::int("parent").text("an object, or -1 for the world"))
        .param(Param::bool("keep_in_place").default(true))
        .text("Attaches an object to another object. A child of a joint moves with the joint."),
    );
    offer.command(
        command("getObjectParent", |c| {
            let parent = {
                let environment = environment(c)?;
                environment.copy.linkage.parent(frame(c, &environment, 1)?)
            };
            c.ret(handle_or_world(parent));
            Ok(())
        })
        .param(object())
        .returns(Param::int("parent"))
        .text("Returns the object to which an object is attached; -1: the world."),
    );
}

fn listing(offer: &mut Offer<Ik>) {
    offer.command(
        command("getObjects", |c| {
            let index = usize::try_from(c.i64(1)?).unwrap_or(usize::MAX);
            let found = {
                let environment = environment(c)?;
                let id = environment.copy.linkage.ids().nth(index);
                id.map(|id| {
                    let name = environment.names.get(&id).cloned().unwrap_or_default();
                    (id, name, environment.copy.linkage.joint(id).map(|j| type_number(j.kind)))
                })
            };
            let Some((id, name, kind)) = found else { return Ok(()) };
            c.ret(handle_of(id));
            c.ret(name);
            c.ret(kind.is_some());
            c.ret(kind.unwrap_or(0));
            Ok(())
        })
        .param(Param::int("index").text("from 0"))
        .returns(Param::int("object").optional())
        .returns(Param::string("name").optional())
        .returns(Param::bool("is_joint").optional())
        .returns(Param::int("joint_type").optional())
        .text("Returns an object by its index; no value past the last object."),
    );
    offer.command(
        command("getObjectHandle", |c| {
            let name = c.text(1)?;
            let found = environment(c)?.names.iter().find(|(_, n)| **n == name).map(|(id, _)| *id);
            let found =
                found.ok_or_else(|| Fail::argument(format!("there is no object `{name}` in the environment")))?;
            c.ret(handle_of(found));
            Ok(())
        })
        .param(Param::string("name"))
        .returns(object())
        .text("Returns the object with the given name."),
    );
    offer.command(
        command("doesObjectExist", |c| {
            let exists = {
                let environment = environment(c)?;
                match c.arg(1).as_str() {
                    Some(name) => environment.names.values().any(|n| *n == name),
                    None => frame(c, &environment, 1).is_ok(),
                }
            };
            c.ret(exists);
            Ok(())
        })
        .param(Param::any("object").text("a handle or a name"))
        .returns(Param::bool("exists"))
        .text("Returns whether an object exists."),
    );
}

fn poses(offer: &mut Offer<Ik>) {
    offer.command(
        getter("getObjectPose", |c, p| c.ret(pose_numbers(p)), vec![Param::floats("pose", 7)])
            .text("Returns the pose of an object, x y z and quaternion x y z w, without the motion of its own joint."),
    );
    offer.command(
        getter("getObjectMatrix", |c, p| c.ret(matrix_numbers(p)), vec![Param::floats("matrix", 12)])
            .text("Returns the pose of an object as a matrix, row by row."),
    );
    let transformation = |c: &mut Ctx<'_>, p: &Isometry3<f64>| {
        let [x, y, z, quaternion @ ..] = pose_numbers(p);
        c.ret([x, y, z]);
        c.ret(quaternion);
        c.ret(angles(&p.rotation));
    };
    offer.command(
        getter(
            "getObjectTransformation",
            transformation,
            vec![Param::floats("position", 3), Param::floats("quaternion", 4), Param::floats("angles", 3)],
        )
        .text("Returns the position of an object, its orientation as quaternion x y z w, and as angles in rad."),
    );
    offer.command(setter("setObjectPose").text("Moves an object, with all objects attached to it, to a pose."));
    offer.command(setter("setObjectMatrix").text("Moves an object, with all objects attached to it, to a pose."));
    offer.command(
        command("setObjectTransformation", |c| {
            let mut environment = environment(c)?;
            let id = frame(c, &environment, 1)?;
            let is_list = |v: ValueRef<'_>| v.numbers().is_some_and(|n| n.len() == 3);
            let (at, relative) = if is_list(c.arg(2)) { (2, 4) } else { (3, 2) };
            let relative = reference(c, &environment, relative, id)?;
            let [x, y, z] = c.array::<3>(at)?;
            let turned = orientation(c.arg(at + 1), at + 1)?;
            let pose = Isometry3::from_parts(nalgebra::Translation3::new(x, y, z), turned);
            set_relative_pose(&mut environment, id, relative, pose);
            Ok(())
        })
        .param(object())
        .param(Param::any("position"))
        .param(Param::any("orientation").text("a quaternion x y z w, or three angles"))
        .param(Param::any("relative_to").optional())
        .text("Moves an object, with all objects attached to it, to a position and an orientation.")
        .notes("Until version 4.5, the frame to which the pose is relative came first; both orders are accepted."),
    );
    let local = |name: &str, form: fn(&Isometry3<f64>) -> Vec<Value>| {
        command(name, move |c| {
            let motion = {
                let environment = environment(c)?;
                let id = frame(c, &environment, 1)?;
                environment.copy.linkage.motion(id)
            };
            for value in form(&motion) {
                c.ret(value);
            }
            Ok(())
        })
        .param(Param::int("joint"))
    };
    offer.command(
        local("getJointMatrix", |m| vec![Value::Floats(matrix_numbers(m).to_vec())])
            .returns(Param::floats("matrix", 12))
            .text("Returns the motion of a joint as a matrix, row by row."),
    );
    offer.command(
        local("getJointTransformation", |m| {
            let [x, y, z, quaternion @ ..] = pose_numbers(m);
            [vec![x, y, z], quaternion.to_vec(), angles(&m.rotation).to_vec()].map(Value::Floats).into()
        })
        .returns(Param::floats("position", 3))
        .returns(Param::floats("quaternion", 4))
        .returns(Param::floats("angles", 3))
        .text("Returns the motion of a joint: a position, a quaternion x y z w, and angles in rad."),
    );
}
