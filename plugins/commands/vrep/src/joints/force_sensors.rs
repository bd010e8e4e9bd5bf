//! Commands that create joints and force sensors, read force sensors, and couple joints.

use crate::kit::{algebra as al, *};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.createJoint", "simCreateJoint"], MINUS_ONE, |c| {
            let (kind, mode) = (c.i64(0)?, c.i64(1)?);
            let (kind, alias) = match kind {
                10 => ("revolute", "Revolute_joint"),
                11 => ("prismatic", "Prismatic_joint"),
                12 => ("spherical", "Spherical_joint"),
                n => {
                    return Err(Fail::unsupported(format!("joint type {n} is not supported")).help(
                        "use sim.joint_revolute_subtype, sim.joint_prismatic_subtype or sim.joint_spherical_subtype",
                    ));
                }
            };
            let (w, p) = (c.world(), &c.plugin().p);
            let joint = w.create("joint", 0, alias)?;
            w.set(joint, p.joint_type, &kind.into())?;
            w.set(joint, p.joint_mode, &(if mode == 5 { "dynamic" } else { "kinematic" }).into())?;
            if kind == "prismatic" {
                w.set_f64s(joint, p.joint_limits, &[-0.5, 0.5])?;
            }
            c.ret(handle(joint));
            Ok(())
        })
        .param(Param::int("type").text("sim.joint_revolute_subtype or another joint subtype"))
        .param(Param::int("mode").text("sim.jointmode_..."))
        .param(Param::int("options").default(0).optional().text("ignored"))
        .param(Param::any("sizes").optional().text("ignored: they only affect the appearance"))
        .param(Param::any("colors").rest().text("ignored"))
        .returns(Param::int("joint"))
        .text("Creates a revolute joint without limits, a prismatic joint from -0.5 to 0.5 m, or a spherical joint."),
    );
    offer.command(
        both(["sim.createForceSensor", "simCreateForceSensor"], MINUS_ONE, |c| {
            let options = c.i64(0)?;
            let (ints, floats) = (numbers_or_empty(c, 1), numbers_or_empty(c, 2));
            let (w, p) = (c.world(), &c.plugin().p);
            let sensor = w.create("force_sensor", 0, "Force_sensor")?;
            let int = |i: usize| ints.get(i).copied().unwrap_or(0.0) as i64;
            w.set(sensor, p.force_filter, &(if int(0) == 1 { "median" } else { "mean" }).into())?;
            w.set(sensor, p.force_samples, &Value::Int(int(1).clamp(1, 1000)))?;
            w.set(sensor, p.break_count, &Value::Int(int(2).max(1)))?;
            let limit = |bit: i64, i: usize| match options & bit {
                0 => 0.0,
                _ => floats.get(i).copied().unwrap_or(0.0).max(0.0),
            };
            w.set(sensor, p.break_force, &Value::Float(limit(1, 1)))?;
            w.set(sensor, p.break_torque, &Value::Float(limit(2, 2)))?;
            c.ret(handle(sensor));
            Ok(())
        })
        .param(Param::int("options").text("1: the sensor can be broken by force, 2: by torque"))
        .param(
            Param::any("intParams")
                .optional()
                .text("filter (0: mean, 1: median), its number of values, consecutive overloads that break the sensor"),
        )
        .param(Param::any("floatParams").optional().text("size (ignored), breaking force (N), breaking torque (N m)"))
        .param(Param::any("colors").rest().text("ignored"))
        .returns(Param::int("sensor"))
        .text(
            "Creates a force sensor, which rigidly connects its children to its parent, and measures the load on this \
             connection.",
        ),
    );
    offer.command(
        both(["sim.readForceSensor", "simReadForceSensor"], MINUS_ONE, |c| {
            let sensor = of_kind(c, 0, TATU_KIND_FORCE_SENSOR)?;
            let (w, p) = (c.world(), &c.plugin().p);
            if w.look(sensor)?.kind != TATU_KIND_FORCE_SENSOR || !bool_of(c, sensor, p.sensed)? {
                // V-REP returns these values if physics has not measured the load yet.
                c.ret(if version(c) >= (4, 2) { 2_i64 } else { 0 });
                c.ret(&[0.0; 3][..]);
                c.ret(&[0.0; 3][..]);
                return Ok(());
            }
            let (force, torque) = (w.f64s::<3>(sensor, p.sensed_force)?, w.f64s::<3>(sensor, p.sensed_torque)?);
            c.ret(if bool_of(c, sensor, p.broken)? { 3_i64 } else { 1 });
            c.ret(&force[..]);
            c.ret(&torque[..]);
            Ok(())
        })
        .param(object("sensor"))
        .returns(Param::int("result").text("1: measured; plus 2: broken"))
        .returns(Param::floats("force", 3).unit("N"))
        .returns(Param::floats("torque", 3).unit("N m"))
        .text("Returns the filtered force and torque that the child of a force sensor exerts on it, in its frame."),
    );
    offer.command(
        both(["sim.breakForceSensor", "simBreakForceSensor"], MINUS_ONE, |c| {
            let sensor = of_kind(c, 0, TATU_KIND_FORCE_SENSOR)?;
            let p = &c.plugin().p;
            c.world().set(sensor, p.broken, &Value::Bool(true))?;
            finish_setter(c)
        })
        .param(object("sensor"))
        .text("Breaks a force sensor: its child detaches, but remains its child in the scene tree."),
    );
    dependencies(offer);
    child_poses(offer);
}

/// Returns the numbers in table argument `i`, or an empty vector if the argument is missing.
fn numbers_or_empty(c: &Ctx<'_>, i: usize) -> Vec<f64> {
    let table = c.arg(i);
    (0..table.len()).map_while(|k| table.number(k)).collect()
}

fn dependencies(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.getJointDependency", "simGetJointDependency"], NIL, |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let (w, p) = (c.world(), &c.plugin().p);
            let path = text_of(c, joint, p.joint_follows)?;
            let master = if path.is_empty() { -1 } else { handle(w.find(joint, &path).unwrap_or(0)) };
            let (offset, factor) = (w.f64(joint, p.joint_follow_offset)?, w.f64(joint, p.joint_follow_factor)?);
            c.ret(master);
            c.ret(offset);
            c.ret(factor);
            Ok(())
        })
        .param(object("joint"))
        .returns(Param::int("master").text("-1: none"))
        .returns(Param::float("offset"))
        .returns(Param::float("factor"))
        .text("Returns the joint that a joint follows."),
    );
    offer.command(
        both(["sim.setJointDependency", "simSetJointDependency"], MINUS_ONE, |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let (w, p) = (c.world(), &c.plugin().p);
            let path = match c.i64(1)? {
                ..0 => String::new(),
                _ => {
                    let master = of_kind(c, 1, TATU_KIND_JOINT)?;
                    refuse_cycle(c, joint, master)?;
                    text_of(c, master, p.path)?
                }
            };
            w.set(joint, p.joint_follows, &path.as_str().into())?;
            w.set_f64s(joint, p.joint_follow_offset, &[c.f64(2)?])?;
            w.set_f64s(joint, p.joint_follow_factor, &[c.f64(3)?])?;
            finish_setter(c)
        })
        .param(object("joint"))
        .param(Param::int("master").text("-1: none"))
        .param(Param::float("offset"))
        .param(Param::float("factor"))
        .text(
            "Sets the joint that a joint follows. The position of a kinematic joint, or the target position of a \
             dynamic one, depends on the position of that joint.",
        ),
    );
    offer.command(
        both(["sim.setSphericalJointMatrix", "simSetSphericalJointMatrix"], MINUS_ONE, |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let rotation = al::rotation(&al::of_matrix(&numbers(c, 1)?));
            let p = &c.plugin().p;
            c.world().set_f64s(joint, p.joint_rotation, &rotation)?;
            finish_setter(c)
        })
        .param(object("joint"))
        .param(table("matrix", "12 numbers"))
        .text("Rotates the child of a spherical joint that physics does not move."),
    );
}

/// Most joints of a chain of dependent joints.
const MAX_DEPENDENT_JOINTS: usize = 1000;

/// Returns an error if a joint would follow itself, directly or by other joints.
fn refuse_cycle(c: &Ctx<'_>, joint: tatu_object, mut master: tatu_object) -> Result {
    for _ in 0..MAX_DEPENDENT_JOINTS {
        if master == joint {
            return Err(Fail::argument("argument 2: a joint cannot follow itself, directly or by other joints"));
        }
        let follows = text_of(c, master, c.plugin().p.joint_follows)?;
        match c.world().find(master, &follows) {
            Ok(next) if !follows.is_empty() => master = next,
            _ => return Ok(()),
        }
    }
    Err(Fail::argument(format!("argument 2: more than {MAX_DEPENDENT_JOINTS} joints follow each other")))
}

/// Adds commands for the pose of a joint's moving part. For other objects, the getter returns the identity, and the
/// setter fails.
fn child_poses(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getObjectChildPose", |c| {
            let o = existing_object(c, 0)?;
            let pose = match o.kind {
                TATU_KIND_JOINT => {
                    let (w, p) = (c.world(), &c.plugin().p);
                    let x = w.f64(o.id, p.joint_position)?;
                    match text_of(c, o.id, p.joint_type)?.as_str() {
                        "prismatic" => al::pose([0.0, 0.0, x], [0.0, 0.0, 0.0, 1.0]),
                        "spherical" => al::pose([0.0; 3], w.f64s::<4>(o.id, p.joint_rotation)?),
                        _ => al::pose([0.0; 3], al::from_euler([0.0, 0.0, x])),
                    }
                }
                _ => al::IDENTITY,
            };
            c.ret(&pose[..]);
            Ok(())
        })
        .param(object("object"))
        .returns(Param::floats("pose", 7))
        .text("Returns the pose of the moving part of a joint in the joint's frame."),
    );
    offer.command(
        Cmd::new("sim.setObjectChildPose", |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let pose: al::Pose = numbers(c, 1)?;
            let p = &c.plugin().p;
            let x = match text_of(c, joint, p.joint_type)?.as_str() {
                "spherical" => return c.world().set_f64s(joint, p.joint_rotation, &al::rotation(&pose)),
                "prismatic" => pose[2],
                _ => al::to_euler(al::rotation(&pose))[2],
            };
            c.world().set_f64s(joint, p.joint_position, &[x])
        })
        .param(object("joint"))
        .param(table("pose", "{x, y, z, qx, qy, qz, qw}"))
        .text("Sets the pose of the moving part of a joint.")
        .partial("Only the free components of the joint have an effect."),
    );
}
