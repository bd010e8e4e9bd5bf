//! Commands that set and return properties of joints.

use nalgebra::UnitQuaternion;
use tatu_kinematics::{Joint, JointRole, JointType};
use tatu_plugin_api::safe::{Command, Fail, Offer, Param};

use crate::{
    arguments::{command, frame, handle_of, joint, number, orientation, pose},
    constants::{MODE_IK, MODE_PASSIVE},
    environment::{Ctx, Ik, environment},
};

/// Builds a command that returns a numeric property of a joint.
fn getter(name: &str, get: fn(&Joint) -> f64) -> Command<Ik> {
    command(name, move |c| {
        let found = get(joint(c, &mut *environment(c)?, 1)?.1);
        c.ret(found);
        Ok(())
    })
    .param(Param::int("joint"))
}
/// Builds a command that sets a numeric property of a joint. `check` returns the reason for which a value is invalid.
fn setter(name: &str, key: &str, set: fn(&mut Joint, f64), check: fn(f64) -> Option<&'static str>) -> Command<Ik> {
    let run = move |c: &mut Ctx<'_>| {
        let x = number(c, 2)?;
        if let Some(wrong) = check(x) {
            return Err(Fail::argument(format!("argument 3: {x} {wrong}")));
        }
        set(joint(c, &mut *environment(c)?, 1)?.1, x);
        Ok(())
    };
    command(name, run).param(Param::int("joint")).param(Param::float(key))
}

fn any(_: f64) -> Option<&'static str> {
    None
}
fn positive(x: f64) -> Option<&'static str> {
    (x < 0.0).then_some("must not be negative")
}

pub fn offer(offer: &mut Offer<Ik>) {
    numbers(offer);
    limits(offer);
    offer.command(
        command("getJointPosition", |c| {
            let found = {
                let environment = environment(c)?;
                environment.copy.linkage.position(frame(c, &environment, 1)?)
            };
            c.ret(found);
            Ok(())
        })
        .param(Param::int("joint"))
        .returns(Param::float("position").text("rad or m"))
        .text("Returns the position of a joint."),
    );
    offer.command(
        command("setJointMode", |c| {
            let mode = match c.i64(2)? {
                MODE_PASSIVE => JointRole::Fixed,
                MODE_IK => JointRole::Moved,
                n => {
                    let text = format!("argument 3: expected a joint mode such as `simIK.jointmode_ik`, found {n}");
                    return Err(Fail::argument(text));
                }
            };
            joint(c, &mut *environment(c)?, 1)?.1.role = mode;
            Ok(())
        })
        .param(Param::int("joint"))
        .param(Param::int("mode"))
        .text("Sets whether inverse kinematics moves a joint."),
    );
    offer.command(
        command("getJointMode", |c| {
            let role = joint(c, &mut *environment(c)?, 1)?.1.role;
            c.ret(if role == JointRole::Moved { MODE_IK } else { MODE_PASSIVE });
            Ok(())
        })
        .param(Param::int("joint"))
        .returns(Param::int("mode"))
        .text("Returns whether inverse kinematics moves a joint."),
    );
    offer.command(
        command("getJointType", |c| {
            let kind = joint(c, &mut *environment(c)?, 1)?.1.kind;
            c.ret(match kind {
                JointType::Revolute => crate::constants::JOINT_REVOLUTE,
                JointType::Prismatic => crate::constants::JOINT_PRISMATIC,
                JointType::Spherical => crate::constants::JOINT_SPHERICAL,
            });
            Ok(())
        })
        .param(Param::int("joint"))
        .returns(Param::int("type"))
        .text("Returns the type of a joint."),
    );
    for name in ["setSphericalJointMatrix", "setSphericalJointRotation"] {
        offer.command(
            command(name, |c| {
                let turned: UnitQuaternion<f64> = match c.arg(2).len() {
                    12 => pose(c, 2)?.rotation,
                    _ => orientation(c.arg(2), 2)?,
                };
                joint(c, &mut *environment(c)?, 1)?.1.rotation = turned;
                Ok(())
            })
            .param(Param::int("joint"))
            .param(Param::any("rotation").text("a matrix of 12 numbers, a quaternion x y z w, or three angles"))
            .text("Sets the rotation of a spherical joint."),
        );
    }
}

fn numbers(offer: &mut Offer<Ik>) {
    offer.command(
        setter("setJointPosition", "position", |j, x| j.position = x, any).text("Sets the position of a joint."),
    );
    offer.command(
        getter("getJointWeight", |j| j.weight)
            .alias("simIK.getJointIkWeight")
            .returns(Param::float("weight"))
            .text("Returns the weight of a joint, which determines how much it moves relative to other joints."),
    );
    offer.command(
        setter("setJointWeight", "weight", |j, x| j.weight = x, positive)
            .alias("simIK.setJointIkWeight")
            .text("Sets the weight of a joint, which determines how much it moves relative to other joints."),
    );
    offer.command(
        getter("getJointMaxStepSize", |j| if j.max_step.is_finite() { j.max_step } else { 0.0 })
            .returns(Param::float("step"))
            .text("Returns the largest motion of a joint in an iteration, rad or m; 0: unlimited."),
    );
    offer.command(
        setter("setJointMaxStepSize", "step", |j, x| j.max_step = if x > 0.0 { x } else { f64::INFINITY }, positive)
            .text("Sets the largest motion of a joint in an iteration, rad or m; 0: unlimited."),
    );
    offer.command(
        getter("getJointScrewLead", |j| j.lead)
            .alias("simIK.getJointScrewPitch")
            .returns(Param::float("lead").text("m/rad"))
            .text("Returns the distance along its axis that a revolute joint moves per radian."),
    );
    offer.command(
        setter("setJointScrewLead", "lead", |j, x| j.lead = x, any)
            .alias("simIK.setJointScrewPitch")
            .text("Sets the distance along its axis that a revolute joint moves per radian, m."),
    );
    offer.command(
        command("setJointLimitMargin", |c| {
            let margin = number(c, 2)?;
            let mut environment = environment(c)?;
            let (id, _) = joint(c, &mut environment, 1)?;
            environment.margins.insert(id, margin);
            Ok(())
        })
        .param(Param::int("joint"))
        .param(Param::float("margin").text("rad or m"))
        .text("Sets the distance from a limit within which a group avoids it.")
        .partial("the value is stored, but groups avoid limits only at the limit itself"),
    );
    offer.command(
        command("getJointLimitMargin", |c| {
            let margin = {
                let mut environment = environment(c)?;
                let (id, _) = joint(c, &mut environment, 1)?;
                environment.margins.get(&id).copied().unwrap_or(0.0)
            };
            c.ret(margin);
            Ok(())
        })
        .param(Param::int("joint"))
        .returns(Param::float("margin").text("rad or m"))
        .text("Returns the distance from a limit within which a group avoids it."),
    );
}

fn limits(offer: &mut Offer<Ik>) {
    offer.command(
        command("getJointInterval", |c| {
            let limits = joint(c, &mut *environment(c)?, 1)?.1.limits;
            let [low, high] = limits.unwrap_or([-std::f64::consts::PI, std::f64::consts::PI]);
            c.ret(limits.is_none());
            c.ret([low, high - low]);
            Ok(())
        })
        .param(Param::int("joint"))
        .returns(Param::bool("cyclic"))
        .returns(Param::floats("interval", 2).text("minimum position, and range above it"))
        .text("Returns whether a joint is cyclic (without limits), and its minimum position and range."),
    );
    offer.command(
        command("setJointInterval", |c| {
            let cyclic = c.arg(2).truthy();
            let limits = match c.has(3) {
                true => {
                    let [low, range] = c.array::<2>(3)?;
                    if !low.is_finite() || !range.is_finite() || range < 0.0 {
                        return Err(Fail::argument(
                            "argument 4: expected two finite numbers, the minimum position and a range of at least 0",
                        ));
                    }
                    Some([low, low + range])
                }
                false => None,
            };
            joint(c, &mut *environment(c)?, 1)?.1.limits = limits.filter(|_| !cyclic);
            Ok(())
        })
        .param(Param::int("joint"))
        .param(Param::bool("cyclic"))
        .param(Param::floats("interval", 2).optional().text("minimum position, and range above it"))
        .text("Sets whether a joint is cyclic (without limits), and its minimum position and range."),
    );
    offer.command(
        command("setJointDependency", |c| {
            let mut environment = environment(c)?;
            let id = joint(c, &mut environment, 1)?.0;
            let role = if c.i64(2)? == crate::arguments::HANDLE_WORLD {
                JointRole::Moved
            } else {
                let master = joint(c, &mut environment, 2)?.0;
                let or = |i: usize, default: f64| if c.has(i) { number(c, i) } else { Ok(default) };
                if c.arg(5).as_func().is_some() {
                    return Err(Fail::unsupported("a dependency defined by a callback is not supported")
                        .help("define a linear dependency by an offset and a factor"));
                }
                JointRole::Dependent { master, offset: or(3, 0.0)?, factor: or(4, 1.0)? }
            };
            if let Some(joint) = environment.copy.linkage.joint_mut(id) {
                joint.role = role;
            }
            Ok(())
        })
        .param(Param::int("joint"))
        .param(Param::int("master").text("-1: none"))
        .param(Param::float("offset").default(0.0))
        .param(Param::float("factor").default(1.0))
        .param(Param::any("callback").optional())
        .text("Couples a joint to another joint: its position becomes that of the other joint, multiplied by a factor, plus an offset."),
    );
    offer.command(
        command("getJointDependency", |c| {
            let role = joint(c, &mut *environment(c)?, 1)?.1.role;
            let (master, offset, factor) = match role {
                JointRole::Dependent { master, offset, factor } => (handle_of(master), offset, factor),
                _ => (crate::arguments::HANDLE_WORLD, 0.0, 1.0),
            };
            c.ret(master);
            c.ret(offset);
            c.ret(factor);
            Ok(())
        })
        .param(Param::int("joint"))
        .returns(Param::int("master"))
        .returns(Param::float("offset"))
        .returns(Param::float("factor"))
        .text("Returns the joint on which a joint depends (-1: none), the offset and the factor."),
    );
}
