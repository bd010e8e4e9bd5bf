//! Creates joints and force sensors; readings of force sensors; joints that follow others.

use crate::{Vrep, algebra as al, kit::*, tags};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both("sim.createJoint", MINUS, |c| {
            let (kind, mode) = (c.i64(0)?, c.i64(1)?);
            let kind = match kind {
                10 => "revolute",
                11 => "prismatic",
                n => {
                    return Err(Fail::unsupported(format!("there are no joints of type {n}"))
                        .help("sim.joint_revolute_subtype and sim.joint_prismatic_subtype are known"));
                }
            };
            let (w, p) = (c.world(), &c.plugin().p);
            let joint = w.create("joint", 0, if kind == "revolute" { "Revolute_joint" } else { "Prismatic_joint" })?;
            w.set(joint, p.joint_type, &kind.into())?;
            w.set(joint, p.joint_mode, &(if mode == 5 { "dynamic" } else { "kinematic" }).into())?;
            if kind == "prismatic" {
                w.set_f64s(joint, p.joint_limits, &[-0.5, 0.5])?;
            }
            c.ret(handle(joint));
            Ok(())
        })
        .param(Param::int("type").text("sim.joint_revolute_subtype or sim.joint_prismatic_subtype"))
        .param(Param::int("mode").text("sim.jointmode_..."))
        .param(Param::int("options").default(0).optional().text("ignored"))
        .param(Param::any("sizes").optional().text("ignored: they are for looks"))
        .param(Param::any("colors").rest().text("ignored"))
        .returns(Param::int("joint"))
        .text("Makes a joint that turns without end, or slides by half a metre to both sides.")
        .partial("There are no spherical joints."),
    );
    offer.command(
        both("sim.createForceSensor", MINUS, |c| {
            let sensor = c.world().create("force_sensor", 0, "Force_sensor")?;
            c.ret(handle(sensor));
            Ok(())
        })
        .param(Param::any("options").text("ignored: it does not break"))
        .param(Param::any("arguments").rest().text("ignored"))
        .returns(Param::int("sensor"))
        .text("Makes a force sensor, which ties what is below it rigidly to what is above.")
        .partial("It ties, and measures nothing."),
    );
    offer.command(
        both("sim.readForceSensor", MINUS, |c| {
            of_kind(c, 0, TATU_KIND_FORCE_SENSOR)?;
            // The original, asked before physics has anything to tell, answers so too.
            c.ret(if version(c) >= (4, 2) { 2_i64 } else { 0 });
            c.ret::<[f64]>(&[0.0; 3][..]);
            c.ret::<[f64]>(&[0.0; 3][..]);
            Ok(())
        })
        .param(object("sensor"))
        .returns(Param::int("result").text("nothing measured"))
        .returns(Param::floats("force", 3).unit("N"))
        .returns(Param::floats("torque", 3).unit("N m"))
        .text("Gives force and torque of a force sensor: always zero.")
        .stub("force sensors tie objects together and measure nothing"),
    );
    offer.command(
        both("sim.breakForceSensor", MINUS, |c| {
            let sensor = of_kind(c, 0, TATU_KIND_FORCE_SENSOR)?;
            let (w, p) = (c.world(), &c.plugin().p);
            for child in w.list(sensor, 0, TATU_LIST_CHILDREN | TATU_LIST_SKIP_BASE)? {
                let pose = w.pose(child, 0)?;
                w.set(child, p.parent, &Value::Object(0))?;
                w.set_pose(child, 0, &pose)?;
            }
            done(c)
        })
        .param(object("sensor"))
        .text("Breaks a force sensor: what hangs below it falls off."),
    );
    dependencies(offer);
    child_poses(offer);
}

fn dependencies(offer: &mut Offer<Vrep>) {
    offer.command(
        both("sim.getJointDependency", NIL, |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let number = |name: &str, or: f64| Ok::<_, Fail>(tags::number(c, joint, name)?.unwrap_or(or));
            let (master, offset, factor) =
                (number("follows", -1.0)?, number("follows offset", 0.0)?, number("follows factor", 1.0)?);
            c.ret(master as i64);
            c.ret(offset);
            c.ret(factor);
            Ok(())
        })
        .param(object("joint"))
        .returns(Param::int("master").text("-1: none"))
        .returns(Param::float("offset"))
        .returns(Param::float("factor"))
        .text("Gives which joint a joint follows."),
    );
    offer.command(
        both("sim.setJointDependency", MINUS, |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let master = if c.i64(1)? < 0 { -1.0 } else { handle(of_kind(c, 1, TATU_KIND_JOINT)?) as f64 };
            tags::set_number(c, joint, "follows", master)?;
            tags::set_number(c, joint, "follows offset", c.f64(2)?)?;
            tags::set_number(c, joint, "follows factor", c.f64(3)?)?;
            done(c)
        })
        .param(object("joint"))
        .param(Param::int("master").text("-1: none"))
        .param(Param::float("offset"))
        .param(Param::float("factor"))
        .text("Chooses which joint a joint follows.")
        .partial("It is kept; the joint moves only when a script sets it."),
    );
    offer.command(
        both("sim.setSphericalJointMatrix", MINUS, |c| {
            of_kind(c, 0, TATU_KIND_JOINT)?;
            done(c)
        })
        .param(object("joint"))
        .param(table("matrix", "12 numbers"))
        .text("Turns a spherical joint: there are none.")
        .stub("there are no spherical joints"),
    );
}

/// The moved part of a joint; of other objects their own frame.
fn child_poses(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getObjectChildPose", |c| {
            let o = living(c, 0)?;
            let pose = match o.kind {
                TATU_KIND_JOINT => {
                    let (w, p) = (c.world(), &c.plugin().p);
                    let x = w.f64(o.id, p.joint_position)?;
                    match text_of(c, o.id, p.joint_type)?.as_str() {
                        "prismatic" => al::pose([0.0, 0.0, x], [0.0, 0.0, 0.0, 1.0]),
                        _ => al::pose([0.0; 3], al::from_euler([0.0, 0.0, x])),
                    }
                }
                _ => al::IDENTITY,
            };
            c.ret::<[f64]>(&pose[..]);
            Ok(())
        })
        .param(object("object"))
        .returns(Param::floats("pose", 7))
        .text("Gives where the moved part of a joint stands in the joint's frame."),
    );
    offer.command(
        Cmd::new("sim.setObjectChildPose", |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let pose: al::Pose = numbers(c, 1)?;
            let p = &c.plugin().p;
            let x = match text_of(c, joint, p.joint_type)?.as_str() {
                "prismatic" => pose[2],
                _ => al::to_euler(al::rotation(&pose))[2],
            };
            c.world().set_f64s(joint, p.joint_position, &[x])
        })
        .param(object("joint"))
        .param(table("pose", "{x, y, z, qx, qy, qz, qw}"))
        .text("Moves the moved part of a joint.")
        .partial("What a joint that turns or slides can follow counts; there are no spherical joints."),
    );
}
