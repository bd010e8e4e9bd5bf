//! Commands on poses and velocities of objects: position, orientation, quaternion, matrix.

use crate::kit::{
    algebra::{self as al, Pose},
    *,
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        getter(["sim.getObjectPosition", "simGetObjectPosition"], |c, p| c.ret(&p[..3]))
            .returns(Param::floats("position", 3).unit("m"))
            .text("Returns the position of an object: {x, y, z}.")
            .example("p = sim.getObjectPosition(robot, -1)"),
    );
    offer.command(
        getter(["sim.getObjectOrientation", "simGetObjectOrientation"], |c, p| {
            let e = al::to_euler(al::rotation(p));
            c.ret(&e[..]);
        })
        .returns(Param::floats("angles", 3).unit("rad"))
        .text(
            "Returns the orientation of an object: rotations {alpha, beta, gamma} about its own x, y and z axes, in \
             this order.",
        )
        .example("heading = sim.getObjectOrientation(robot, -1)[3]"),
    );
    offer.command(
        getter(["sim.getObjectQuaternion", "simGetObjectQuaternion"], |c, p| {
            let flags = c.arg(0).as_i64().unwrap_or(0);
            let [x, y, z, w] = al::rotation(p);
            let q = if flags & WXYZ_FLAG != 0 { [w, x, y, z] } else { [x, y, z, w] };
            c.ret(&q[..]);
        })
        .returns(Param::floats("quaternion", 4))
        .text("Returns the orientation of an object: {x, y, z, w}; with sim.handleflag_wxyzquat {w, x, y, z}.")
        .example("q = sim.getObjectQuaternion(robot, -1)"),
    );
    offer.command(
        getter(["sim.getObjectMatrix", "simGetObjectMatrix"], |c, p| {
            let m = al::matrix(p);
            c.ret(&m[..]);
        })
        .returns(Param::floats("matrix", 12))
        .text("Returns the pose of an object as a matrix: 12 numbers, rows of {x axis, y axis, z axis, position}.")
        .example("m = sim.getObjectMatrix(robot, -1)"),
    );
    offer.command(
        getter(["sim.getObjectPose", "simGetObjectPose"], |c, p| c.ret(&p[..]))
            .returns(Param::floats("pose", 7))
            .text("Returns the position and quaternion of an object: {x, y, z, qx, qy, qz, qw}.")
            .example("pose = sim.getObjectPose(robot)"),
    );
    offer.command(
        setter(["sim.setObjectPosition", "simSetObjectPosition"], "position", |c, v, i, p| {
            let [x, y, z] = numbers_of::<3>(v, i)?;
            let _ = c;
            p[..3].copy_from_slice(&[x, y, z]);
            Ok(())
        })
        .text("Moves an object with its descendants; both orders of the last two arguments are accepted.")
        .example("sim.setObjectPosition(box, {0, 0, 0.5}, -1)"),
    );
    offer.command(
        setter(["sim.setObjectOrientation", "simSetObjectOrientation"], "orientation", |_, v, i, p| {
            let q = al::from_euler(numbers_of::<3>(v, i)?);
            p[3..].copy_from_slice(&q);
            Ok(())
        })
        .text(
            "Sets the orientation of an object by Euler angles {alpha, beta, gamma}, rad; both orders of the last two \
             arguments are accepted.",
        )
        .example("sim.setObjectOrientation(box, {0, 0, math.pi / 2}, -1)"),
    );
    offer.command(
        setter(["sim.setObjectQuaternion", "simSetObjectQuaternion"], "quaternion", |c, v, i, p| {
            let mut q = numbers_of::<4>(v, i)?;
            if c.arg(0).as_i64().unwrap_or(0) & WXYZ_FLAG != 0 {
                q.rotate_left(1);
            }
            p[3..].copy_from_slice(&unit(q, i)?);
            Ok(())
        })
        .text("Sets an object's orientation {x, y, z, w}; both orders of the last two arguments are accepted.")
        .example("sim.setObjectQuaternion(box, {0, 0, 0, 1}, -1)"),
    );
    offer.command(
        setter(["sim.setObjectMatrix", "simSetObjectMatrix"], "matrix", |_, v, i, p| {
            *p = al::of_matrix(&numbers_of::<12>(v, i)?);
            Ok(())
        })
        .text(
            "Sets the pose of an object by a matrix of 12 numbers; both orders of the last two arguments are accepted.",
        )
        .example("sim.setObjectMatrix(box, sim.getObjectMatrix(target, -1), -1)"),
    );
    offer.command(
        setter(["sim.setObjectPose", "simSetObjectPose"], "pose", |_, v, i, p| {
            let given: Pose = numbers_of(v, i)?;
            *p = al::pose(al::position(&given), unit(al::rotation(&given), i)?);
            Ok(())
        })
        .text(
            "Sets the pose of an object by {x, y, z, qx, qy, qz, qw}; both orders of the last two arguments are \
             accepted.",
        )
        .example("sim.setObjectPose(box, {0, 0, 1, 0, 0, 0, 1})"),
    );
    offer.command(
        Cmd::side_by_side("sim.getObjectVelocity", |c| {
            let id = id(c, 0)?;
            let t = frame_velocity(c, id).map_err(|e| explain_any(c, id, e))?;
            c.ret(&t[..3]);
            c.ret(&t[3..]);
            Ok(())
        })
        .old_name("simGetObjectVelocity", NIL)
        .param(flagged("object"))
        .returns(Param::floats("linear", 3).unit("m/s"))
        .returns(Param::floats("angular", 3).unit("rad/s"))
        .text(
            "Returns the linear and angular velocity of an object's frame, in the world frame; that of a shape's centre \
             of mass: `sim.getVelocity`.",
        )
        .example("v, w = sim.getObjectVelocity(robot)"),
    );
}

/// Returns the linear velocity of an object's frame, m/s, and its angular velocity, rad/s, in the world frame. The host
/// returns the velocity of the centre of mass for dynamic shapes.
pub(crate) fn frame_velocity(c: &SharedCtx<'_>, id: tatu_object) -> Result<[f64; 6]> {
    let (w, p) = (c.world(), &c.plugin().p);
    let mut t = w.twist(id)?;
    let turn = [t[3], t[4], t[5]];
    if turn != [0.0; 3] && w.look(id)?.kind == TATU_KIND_SHAPE && bool_of(c, id, p.dynamic)? {
        let arm = al::rotate(al::rotation(&w.pose(id, 0)?), w.f64s::<3>(id, p.com)?);
        let around = al::cross(turn, arm);
        t.iter_mut().zip(around).for_each(|(v, x)| *v -= x);
    }
    Ok(t)
}

const WXYZ_FLAG: i64 = 0x100_0000;
const JOINT_BASE_FLAG: i64 = 0x40_0000;

/// The frame relative to which a pose is read or set.
enum ReferenceFrame {
    /// The frame of an object (0 is the world); for a joint, its moving frame.
    Of(tatu_object),
    /// The fixed frame of a joint.
    Base(tatu_object),
}

fn getter(names: CommandNames, give: impl Fn(&mut SharedCtx<'_>, &Pose) + Send + Sync + 'static) -> Cmd {
    both_parallel(names, NIL, move |c| {
        let id = id(c, 0)?;
        let frame = frame(c, c.arg(1), 1, id)?;
        let pose = pose(c, id, &frame)?;
        give(c, &pose);
        Ok(())
    })
    .param(flagged("object"))
    .param(frame_param())
}

/// Builds a setter; `put` applies the value, which is argument `i`, to the object's current pose.
fn setter(
    names: CommandNames,
    value: &str,
    put: impl Fn(&Ctx<'_>, ValueRef<'_>, usize, &mut Pose) -> Result + Send + Sync + 'static,
) -> Cmd {
    both(names, MINUS_ONE, move |c| {
        let id = id(c, 0)?;
        // In the newer argument order, the value precedes the frame.
        let (value, relative) = if is_table(c.arg(1)) { (1, 2) } else { (2, 1) };
        let frame = frame(c, c.arg(relative), relative, id)?;
        let mut to = pose(c, id, &frame)?;
        put(c, c.arg(value), value, &mut to)?;
        let w = c.world();
        match frame {
            ReferenceFrame::Of(f) => w.set_pose(id, f, &to),
            ReferenceFrame::Base(j) => w.set_pose(id, 0, &al::compose(&w.pose(j, 0)?, &to)),
        }
        .map_err(|e| explain_any(c, id, e))?;
        finish_setter(c)
    })
    .param(flagged("object"))
    .param(Param::any(value).text("a table; old scripts pass the frame here, and the table last"))
    .param(
        Param::any("relativeTo").optional().text("-1 or nil: the world, sim.handle_parent: its parent, or an object"),
    )
}

/// Resolves a value that selects the reference frame for a pose of the object `of`; `i` is its argument index for
/// messages.
fn frame(c: &SharedCtx<'_>, v: ValueRef<'_>, i: usize, of: tatu_object) -> Result<ReferenceFrame> {
    match v.as_i64() {
        None if v.is_nil() => Ok(ReferenceFrame::Of(0)),
        Some(-1) => Ok(ReferenceFrame::Of(0)),
        Some(HANDLE_PARENT) => Ok(ReferenceFrame::Of(parent(c, of)?)),
        Some(n) if n > 0 && n & JOINT_BASE_FLAG != 0 => Ok(ReferenceFrame::Base(id_of(v, i)?)),
        _ => Ok(ReferenceFrame::Of(id_of(v, i)?)),
    }
}

fn pose(c: &SharedCtx<'_>, id: tatu_object, frame: &ReferenceFrame) -> Result<Pose> {
    let w = c.world();
    match *frame {
        ReferenceFrame::Of(f) => w.pose(id, f).map_err(|e| {
            let e = explain_any(c, id, e);
            if f == 0 { e } else { explain_any(c, f, e) }
        }),
        ReferenceFrame::Base(j) => {
            let base = w.pose(j, 0).map_err(|e| explain_any(c, j, e))?;
            let own = w.pose(id, 0).map_err(|e| explain_any(c, id, e))?;
            Ok(al::compose(&al::inverse(&base), &own))
        }
    }
}
