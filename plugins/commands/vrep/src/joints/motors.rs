//! Commands on joints: position, targets, forces, limits, modes.

use std::f64::consts::PI;

use crate::{
    kit::{algebra as al, *},
    state::state,
};

/// Joint modes in which the position of a joint is computed: by inverse kinematics, and from another joint.
const SOLVED_MODES: [i64; 2] = [2, 4];
/// Private tag of the mode that a script has set, which the plugin for inverse kinematics reads too.
const JOINT_MODE_TAG: &str = "joint mode";

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let get = |names: CommandNames, prop: fn(&Props) -> Prop, what: &str, text: &str| {
        let unit = match what {
            "velocity" => "rad/s for a revolute joint, m/s for a prismatic one",
            "force" => "N m for a revolute joint, N for a prismatic one",
            _ => "rad for a revolute joint, m for a prismatic one",
        };
        both_parallel(names, NIL, move |c| {
            let x = read(c, prop(&c.plugin().p))?;
            c.ret(x);
            Ok(())
        })
        .param(flagged("joint"))
        .returns(Param::float(what).text(unit))
        .text(text)
        .example(format!("x = {}(joint)", names[0]))
    };
    offer.command(get(
        ["sim.getJointPosition", "simGetJointPosition"],
        |p| p.joint_position,
        "position",
        "Returns the position of a joint.",
    ));
    offer.command(get(
        ["sim.getJointTargetVelocity", "simGetJointTargetVelocity"],
        |p| p.joint_target_velocity,
        "velocity",
        "Returns the target velocity of a joint's motor.",
    ));
    offer.command(get(
        ["sim.getJointTargetPosition", "simGetJointTargetPosition"],
        |p| p.joint_target_position,
        "position",
        "Returns the target position of a joint's motor.",
    ));
    offer.command(get(
        ["sim.getJointVelocity", "simGetJointVelocity"],
        |p| p.joint_velocity,
        "velocity",
        "Returns the velocity of a joint.",
    ));
    offer.command(
        get(
            ["sim.getJointForce", "simGetJointForce"],
            |p| p.joint_effort,
            "force",
            "Returns the force (N) or torque (N m) that a joint's motor exerts.",
        )
        .old_name("simJointGetForce", NIL),
    );
    offer.command(
        both_parallel(["sim.getJointTargetForce", "simGetJointTargetForce"], NIL, |c| {
            let x = read(c, c.plugin().p.joint_max_force)?;
            let pushes = is_pushed(c)?;
            c.ret(if pushes { x } else { x.abs() });
            Ok(())
        })
        .param(flagged("joint"))
        .returns(Param::float("force").text("N m for a revolute joint, N for a prismatic one"))
        .text("Returns the maximum force or torque of a joint's motor; in force mode, the signed force applied.")
        .example("x = sim.getJointTargetForce(joint)")
        .alias("sim.getJointMaxForce"),
    );

    let set = |names: CommandNames, prop: fn(&Props) -> Prop, what: &str, text: &str| {
        both_parallel(names, MINUS_ONE, move |c| {
            write(c, prop(&c.plugin().p), c.f64(1)?)?;
            c.ret(1_i64);
            Ok(())
        })
        .param(object("joint"))
        .param(Param::float(what))
        .returns(Param::int("done"))
        .text(text)
        .example(format!("{}(joint, 1.5)", names[0]))
    };
    offer.command(
        set(
            ["sim.setJointTargetVelocity", "simSetJointTargetVelocity"],
            |p| p.joint_target_velocity,
            "velocity",
            "Sets the target velocity of a joint's motor (rad/s or m/s), which is used while the motor controls \
             velocity.",
        )
        .param(motion()),
    );
    offer.command(
        set(
            ["sim.setJointTargetPosition", "simSetJointTargetPosition"],
            |p| p.joint_target_position,
            "position",
            "Sets the target position of a joint's motor (rad or m), which is used while the motor controls position.",
        )
        .param(motion()),
    );
    offer.command(
        set(
            ["sim.setJointForce", "simSetJointForce"],
            |p| p.joint_max_force,
            "force",
            "Sets the maximum force (N) or torque (N m) of a joint's motor.",
        )
        .alias("sim.setJointMaxForce"),
    );
    offer.command(
        Cmd::new("sim.setJointTargetForce", |c| {
            let (joint, force, p, w) = (id(c, 0)?, c.f64(1)?, &c.plugin().p, c.world());
            // Only force mode uses the sign, but a script can select this mode later, so the sign is stored in all
            // modes.
            let signed = !c.has(2) || c.arg(2).truthy();
            write(c, p.joint_max_force, if signed { force } else { force.abs() })?;
            if signed {
                let v = w.f64(joint, p.joint_target_velocity)?;
                if v * force < 0.0 {
                    w.set_f64s(joint, p.joint_target_velocity, &[-v])?;
                }
            }
            finish_setter(c)
        })
        .param(object("joint"))
        .param(Param::float("force").text("N or N m"))
        .param(
            Param::any("signed")
                .default(true)
                .optional()
                .text("true: the sign applies in force mode, and reverses the target velocity"),
        )
        .text(
            "Sets the maximum force or torque of a joint's motor, and its direction by the sign. In force mode, it is \
             the force that the motor applies; a negative force acts in the negative direction.",
        )
        .example("sim.setJointTargetForce(joint, -2.5)"),
    );
    offer.command(
        Cmd::new("sim.setJointPosition", |c| {
            let (p, mut x) = (&c.plugin().p, c.f64(1)?);
            if x.is_infinite() {
                let (joint, w) = (id(c, 0)?, c.world());
                let [low, high] = w.f64s(joint, p.joint_limits).map_err(|e| explain(c, joint, TATU_KIND_JOINT, e))?;
                x = x.clamp(low, high);
            }
            // The host clamps the position to the limits.
            write(c, p.joint_position, x)?;
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simSetJointPosition", MINUS_ONE)
        .param(object("joint"))
        .param(Param::float("position").text("rad or m; clamped to the joint's limits"))
        .returns(Param::int("done"))
        .text(
            "Sets the position of a joint immediately, and moves its descendants; intended for joints without physics.",
        )
        .example("sim.setJointPosition(joint, math.pi / 4)"),
    );
    offer.command(
        Cmd::new("sim.getJointInterval", |c| {
            let (joint, p, w) = (of_kind(c, 0, TATU_KIND_JOINT)?, &c.plugin().p, c.world());
            let cyclic = bool_of(c, joint, p.joint_cyclic)?;
            let [low, high] = if cyclic { [-PI, PI] } else { w.f64s(joint, p.joint_limits)? };
            c.ret(cyclic);
            c.ret(&[low, high - low][..]);
            Ok(())
        })
        .old_name("simGetJointInterval", NIL)
        .param(object("joint"))
        .returns(Param::bool("cyclic"))
        .returns(Param::floats("interval", 2).text("minimum position, and range above it"))
        .text("Returns the limits of a joint: whether it is cyclic (without limits), and {minimum, range}.")
        .example("cyclic, interval = sim.getJointInterval(joint)"),
    );
    offer.command(
        Cmd::new("sim.setJointInterval", |c| {
            let (joint, p, w) = (of_kind(c, 0, TATU_KIND_JOINT)?, &c.plugin().p, c.world());
            let [low, range] = numbers::<2>(c, 2)?;
            // A cyclic joint has no limits.
            w.set_f64s(joint, p.joint_limits, &[low, low + range.max(0.0)])?;
            w.set(joint, p.joint_cyclic, &Value::Bool(c.arg(1).truthy()))?;
            finish_setter(c)
        })
        .old_name("simSetJointInterval", MINUS_ONE)
        .param(object("joint"))
        .param(Param::any("cyclic").text("true: the joint has no limits"))
        .param(table("interval", "{lowest, range}"))
        .text("Sets the limits of a joint.")
        .example("sim.setJointInterval(joint, false, {-1, 2})"),
    );
    offer.command(
        Cmd::new("sim.getJointType", |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            c.ret(match text_of(c, joint, c.plugin().p.joint_type)?.as_str() {
                "prismatic" => 11_i64,
                "spherical" => 12,
                _ => 10,
            });
            Ok(())
        })
        .old_name("simGetJointType", MINUS_ONE)
        .param(object("joint"))
        .returns(
            Param::int("type").text(
                "10: sim.joint_revolute_subtype, 11: sim.joint_prismatic_subtype, 12: sim.joint_spherical_subtype",
            ),
        )
        .text("Returns the type of a joint: revolute, prismatic or spherical.")
        .example("turns = sim.getJointType(joint) == sim.joint_revolute_subtype"),
    );
    offer.command(
        Cmd::new("sim.getJointMode", |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let dynamic = text_of(c, joint, c.plugin().p.joint_mode)? == "dynamic";
            let of_file = state(c)?.registered.is_ik_joint(joint).then_some(SOLVED_MODES[0]);
            let number = tags::number(c, joint, JOINT_MODE_TAG)?.map(|x| x as i64).or(of_file);
            let solved = number.filter(|mode| SOLVED_MODES.contains(mode));
            c.ret(solved.unwrap_or(if dynamic { 5 } else { 0 }));
            c.ret(i64::from(solved.is_some() && dynamic));
            Ok(())
        })
        .old_name("simGetJointMode", MINUS_ONE)
        .param(object("joint"))
        .returns(Param::int("mode").text(
            "0: passive or kinematic, 2: moved by inverse kinematics, 4: dependent on another joint, 5: force or dynamic",
        ))
        .returns(Param::int("options").text("1: hybrid: in mode 2 or 4, and moved by physics"))
        .text("Returns what moves a joint.")
        .example("dynamic = sim.getJointMode(joint) == sim.jointmode_dynamic"),
    );
    offer.command(
        Cmd::new("sim.setJointMode", |c| {
            let joint = of_kind(c, 0, TATU_KIND_JOINT)?;
            let number = c.i64(1)?;
            let hybrid = int_or(c, 2, 0)? & 1 != 0;
            let mode = match number {
                0 | 1 => "kinematic",
                n if SOLVED_MODES.contains(&n) => if hybrid { "dynamic" } else { "kinematic" },
                5 => "dynamic",
                n => {
                    return Err(Fail::argument(format!("there is no joint mode {n}")).help(
                        "use 0 (passive, kinematic), 2 (inverse kinematics), 4 (dependent) or 5 (force, dynamic)",
                    ));
                }
            };
            let p = &c.plugin().p;
            // The motor drives a hybrid joint to the position that inverse kinematics finds. It must not jump back.
            if mode == "dynamic" && SOLVED_MODES.contains(&number) {
                let now = c.world().f64(joint, p.joint_position)?;
                c.world().set(joint, p.joint_control, &"position".into())?;
                c.world().set_f64s(joint, p.joint_target_position, &[now])?;
            }
            c.world().set(joint, p.joint_mode, &mode.into())?;
            tags::set_number(c, joint, JOINT_MODE_TAG, number as f64)?;
            finish_setter(c)
        })
        .old_name("simSetJointMode", MINUS_ONE)
        .param(object("joint"))
        .param(Param::int("mode").text(
            "0: passive or kinematic, 2: moved by inverse kinematics, 4: dependent on another joint, 5: force or dynamic",
        ))
        .param(Param::int("options").default(0).optional().text(
            "1: hybrid: in mode 2 or 4, the motor drives the joint to the position that inverse kinematics finds",
        ))
        .text("Sets what moves a joint.")
        .example("sim.setJointMode(joint, sim.jointmode_dynamic, 0)"),
    );
    offer.command(
        Cmd::new("sim.getJointMatrix", |c| {
            let (joint, p) = (of_kind(c, 0, TATU_KIND_JOINT)?, &c.plugin().p);
            let x = c.world().f64(joint, p.joint_position)?;
            let pose = match text_of(c, joint, p.joint_type)?.as_str() {
                "prismatic" => al::pose([0.0, 0.0, x], [0.0, 0.0, 0.0, 1.0]),
                "spherical" => al::pose([0.0; 3], c.world().f64s::<4>(joint, p.joint_rotation)?),
                _ => al::pose([0.0; 3], al::from_euler([0.0, 0.0, x])),
            };
            let m = al::matrix(&pose);
            c.ret(&m[..]);
            Ok(())
        })
        .old_name("simGetJointMatrix", NIL)
        .param(object("joint"))
        .returns(Param::floats("matrix", 12))
        .text("Returns the pose of a joint's moving frame in the joint's own frame, as a matrix.")
        .example("m = sim.getJointMatrix(joint)"),
    );
}

/// Declares the parameter for a motion profile, which newer scripts pass.
fn motion() -> Param {
    Param::any("motionParams").optional().text("ignored: motion is limited only by the motor's force")
}

#[inline]
fn read(c: &SharedCtx<'_>, prop: Prop) -> Result<f64> {
    let joint = id(c, 0)?;
    c.world().f64(joint, prop).map_err(|e| explain(c, joint, TATU_KIND_JOINT, e))
}

/// Returns whether a joint is in force mode, the only mode in which the sign of its force matters.
fn is_pushed(c: &SharedCtx<'_>) -> Result<bool> {
    Ok(text_of(c, id(c, 0)?, c.plugin().p.joint_control)? == "force")
}

#[inline]
fn write(c: &SharedCtx<'_>, prop: Prop, x: f64) -> Result {
    let joint = id(c, 0)?;
    c.world().set_f64s(joint, prop, &[x]).map_err(|e| explain(c, joint, TATU_KIND_JOINT, e))
}
