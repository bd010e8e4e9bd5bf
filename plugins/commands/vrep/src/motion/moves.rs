//! Motion commands that block the calling thread (`sim.moveToConfig`, `sim.moveToPose` and their older equivalents),
//! and commands with which a script advances such a motion itself.
//!
//! Each motion is a [`ActiveMotion`] stored under a number; a step advances its profile, moves its objects, and calls
//! its callback.

use super::{
    arguments::{config, pose, rml_joints, rml_position, to_joints, to_object, to_position},
    profile::MotionState,
};
use crate::{
    kit::{
        algebra::{self as al, Pose},
        *,
    },
    state::{
        motions::{ActiveMotion, MotionCallback, MovedObjects, ResultForm, check_room, removed_scripts},
        state,
    },
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let waits = "the motion takes several steps, and only a thread can wait for them: call this in a thread";
    offer.command(
        Cmd::new("sim.moveToConfig", |c| run(c, config))
            .param(Param::any("params").text("a table with joints or pos, targetPos, maxVel, maxAccel, maxJerk; and flags (default: on a straight line), vel, accel, targetVel, minVel, minAccel, cyclicJoints, callback, auxData, timeStep"))
            .param(Param::any("more").rest().text("arguments as in 4.2 to 4.6: flags (default: all coordinates arrive together), pos, vel, accel, maxVel, maxAccel, maxJerk, targetPos, targetVel, callback, auxData, cyclicJoints, timeStep"))
            .returns(Param::any("data").text("the final state: pos, vel, accel, timeLeft; before 4.7 as separate values"))
            .text("Moves joints, or whatever a callback controls, to a configuration as fast as these limits allow; those of the joints are not considered, and without limits the motion takes a single step. With a table as argument it returns one step after the target is reached, as since 4.7.")
            .no_wait(waits),
    );
    offer.command(
        Cmd::new("sim.moveToPose", |c| run(c, pose))
            .param(Param::any("params").text("a table with object or pose, targetPose, maxVel, maxAccel, maxJerk (4 numbers: x, y, z, angle; with metric one number); and relObject, metric, flags, callback, auxData, timeStep"))
            .param(Param::any("more").rest().text("arguments as in 4.2 to 4.6: flags, pose, maxVel, maxAccel, maxJerk, targetPose, callback, auxData, metric, timeStep"))
            .returns(Param::any("data").text("the final state: pose, matrix, vel, accel, timeLeft; before 4.7 pose and timeLeft as separate values"))
            .text("Moves an object, or whatever a callback controls, to a pose as fast as the limits allow. With a table as argument it returns one step after the target is reached, as since 4.7.")
            .no_wait(waits),
    );
    steps(offer);
    offer.command(
        Cmd::new("sim.rmlMoveToJointPositions", |c| run(c, rml_joints))
            .old_name("simRMLMoveToJointPositions", NIL)
            .param(Param::list("joints"))
            .param(Param::any("flags"))
            .param(Param::any("velocity"))
            .param(Param::any("acceleration"))
            .param(table("maxVel", "rad/s or m/s"))
            .param(table("maxAccel", "for each joint"))
            .param(table("maxJerk", "for each joint"))
            .param(table("target", "positions"))
            .param(Param::any("targetVelocity").optional().text("velocities at the target, by default 0"))
            .param(Param::any("direction").optional().text(
                "for each cyclic joint 0: the shorter way; n or -n: upwards or downwards, with n - 1 additional turns",
            ))
            .returns(Param::int("result").text("1"))
            .returns(Param::floats("position", 0))
            .returns(Param::floats("velocity", 0))
            .returns(Param::floats("acceleration", 0))
            .returns(Param::float("left").unit("s"))
            .text("Moves joints to positions.")
            .no_wait(waits),
    );
    offer.command(
        Cmd::new("sim.rmlMoveToPosition", |c| run(c, rml_position))
            .old_name("simRMLMoveToPosition", NIL)
            .param(flagged("object"))
            .param(frame_param())
            .param(Param::any("flags"))
            .param(Param::any("velocity"))
            .param(Param::any("acceleration"))
            .param(table("maxVel", "x, y, z and angle"))
            .param(table("maxAccel", "x, y, z and angle"))
            .param(table("maxJerk", "x, y, z and angle"))
            .param(Param::any("position").optional().text("nil: unchanged"))
            .param(Param::any("quaternion").optional().text("nil: unchanged"))
            .param(Param::any("targetVelocity").optional().text("ignored"))
            .returns(Param::int("result").text("1"))
            .returns(Param::floats("position", 3))
            .returns(Param::floats("quaternion", 4))
            .returns(Param::floats("velocity", 4))
            .returns(Param::floats("acceleration", 4))
            .returns(Param::float("left").unit("s"))
            .text("Moves an object to a position and orientation.")
            .no_wait(waits),
    );
    offer.command(
        both(["sim.moveToPosition", "simMoveToPosition"], NIL, |c| run(c, to_position))
            .param(flagged("object"))
            .param(frame_param())
            .param(Param::any("position").optional())
            .param(Param::any("angles").optional())
            .param(Param::float("velocity").unit("m/s"))
            .param(Param::float("acceleration").default(0.0).optional())
            .param(Param::any("method").optional().text("ignored"))
            .returns(Param::float("left").unit("s"))
            .text("Moves an object to a position and Euler angles.")
            .no_wait(waits),
    );
    offer.command(
        both(["sim.moveToObject", "simMoveToObject"], NIL, |c| run(c, to_object))
            .param(flagged("object"))
            .param(flagged("target"))
            .param(Param::int("what").default(3).optional().text("1: position, 2: orientation, 3: both"))
            .param(Param::float("along").default(0.0).optional().text("ignored: position on a path"))
            .param(Param::float("velocity").default(1.0).optional().text("1/s: fraction of the motion per second"))
            .param(Param::float("acceleration").default(0.0).optional())
            .returns(Param::float("left").unit("s"))
            .text("Moves an object to the pose of another one.")
            .no_wait(waits),
    );
    offer.command(
        both(["sim.moveToJointPositions", "simMoveToJointPositions"], NIL, |c| run(c, to_joints))
            .param(Param::list("joints"))
            .param(table("positions", "rad or m"))
            .param(Param::any("velocity").text("a number, or a table"))
            .param(Param::any("acceleration").optional())
            .param(Param::any("more").rest().text("ignored"))
            .returns(Param::float("left").unit("s"))
            .text("Moves joints to positions.")
            .no_wait(waits),
    );
}

/// Adds commands that start, advance and end a motion, for scripts that advance it themselves.
fn steps(offer: &mut Offer<Vrep>) {
    for (whole, [begin, step, cleanup], make) in [
        (
            "sim.moveToConfig",
            ["sim.moveToConfig_init", "sim.moveToConfig_step", "sim.moveToConfig_cleanup"],
            config as MotionBuilder,
        ),
        ("sim.moveToPose", ["sim.moveToPose_init", "sim.moveToPose_step", "sim.moveToPose_cleanup"], pose),
    ] {
        let motion = || Param::any("motion").text("the value returned by the `_init` function");
        offer.command(
            Cmd::new(begin, move |c| {
                let motion = make(c)?;
                let number = start_motion(c, motion)?;
                c.ret(Value::Map(vec![(Value::text("motion"), Value::Int(number))]));
                Ok(())
            })
            .param(Param::any("params").text(format!("as for {whole}")))
            .returns(motion())
            .text(format!("Starts the motion of {whole}; the script advances it step by step.")),
        );
        offer.command(
            Cmd::new(step, |c| {
                let number = number_of(c)?;
                let (end, answer) = advance(c, number)?;
                c.ret(match end {
                    None => 0_i64,
                    Some(MotionEnd::Arrived) => 1,
                    Some(MotionEnd::Callback) => 2,
                });
                c.ret(answer);
                Ok(())
            })
            .param(motion())
            .returns(Param::int("result").text("0: in progress, 1: target reached, 2: ended by the callback"))
            .returns(Param::any("data"))
            .text("Advances a motion by one step."),
        );
        offer.command(
            Cmd::new(cleanup, |c| {
                let number = number_of(c)?;
                end_motion(c, number)
            })
            .param(motion())
            .text("Ends a motion."),
        );
    }
}

type MotionBuilder = fn(&Ctx<'_>) -> Result<ActiveMotion>;

fn number_of(c: &Ctx<'_>) -> Result<i64> {
    let number = c.arg(0).get("motion").and_then(|v| v.as_i64());
    number.ok_or_else(|| Fail::argument("argument 1: expected the result of the motion's `_init` function"))
}

fn start_motion(c: &Ctx<'_>, motion: ActiveMotion) -> Result<i64> {
    let scripts = state(c)?.motion.motions.values().map(|m| m.script).collect();
    let removed = removed_scripts(c, scripts);
    let mut state = state(c)?;
    state.motion.motions.retain(|_, m| !removed.contains(&m.script));
    check_room(state.motion.motions.values().map(ActiveMotion::size), motion.size())?;
    state.motion.moved += 1;
    let number = state.motion.moved;
    state.motion.motions.insert(number, motion);
    Ok(number)
}

fn missing_motion(number: i64) -> Fail {
    Fail::missing(format!("there is no motion {number} of this script"))
}

fn end_motion(c: &Ctx<'_>, number: i64) -> Result {
    let script = c.caller_script();
    let mut state = state(c)?;
    if state.motion.motions.get(&number).is_some_and(|m| m.script != script) {
        return Err(missing_motion(number));
    }
    let motion = state.motion.motions.remove(&number);
    drop(state);
    if let Some(ActiveMotion { listener: MotionCallback::Function(f), .. }) = motion {
        c.drop_func(f);
    }
    Ok(())
}

/// Starts a motion, and advances it each time the waiting thread resumes.
fn run(c: &mut Ctx<'_>, make: MotionBuilder) -> Result<Outcome> {
    let number = match c.resumed() {
        0 => {
            if !c.can_wait() {
                return Err(Fail::unsupported(
                    "the motion takes several steps, but the calling script is not threaded",
                )
                .help("call it from a threaded script, or from sysCall_thread or a coroutine"));
            }
            start_motion(c, make(c)?)?
        }
        word => word as i64,
    };
    let (end, answer) = match advance(c, number) {
        Ok(done) => done,
        Err(e) => {
            end_motion(c, number)?;
            return Err(e);
        }
    };
    if end.is_none() {
        return c.wait_steps(1, number as u64);
    }
    // The form with a table returns in the step after the last one.
    let mut ended = state(c)?;
    if let Some(motion) = ended.motion.motions.get_mut(&number).filter(|m| m.answer == ResultForm::Map && !m.has_ended)
    {
        motion.has_ended = true;
        drop(ended);
        return c.wait_steps(1, number as u64);
    }
    drop(ended);
    end_motion(c, number)?;
    match answer {
        Value::List(values) => values.into_iter().for_each(|v| c.ret(v)),
        v => c.ret(v),
    }
    Ok(Outcome::Done)
}

/// Why a motion has ended.
enum MotionEnd {
    Arrived,
    Callback,
}

/// Advances a motion by one step. Returns why it has ended, or `None` while it goes on, and the result for the script.
fn advance(c: &mut Ctx<'_>, number: i64) -> Result<(Option<MotionEnd>, Value)> {
    let step = c.world().f64(0, c.plugin().p.dt)?;
    let script = c.caller_script();
    let (motion, arrived) = {
        let mut state = state(c)?;
        let motion = state.motion.motions.get_mut(&number).filter(|m| m.script == script);
        let motion = motion.ok_or_else(|| missing_motion(number))?;
        let dt = if motion.time_step > 0.0 { motion.time_step } else { step };
        let arrived = if motion.has_ended { true } else { motion.profile.advance(dt) };
        (motion.clone(), arrived)
    };
    let (now, unused) = (motion.profile.state(), (-motion.profile.left()).max(0.0));
    let end = arrived.then_some(MotionEnd::Arrived);
    if motion.has_ended {
        let at = position(&motion.mover, &now)?;
        return Ok((end, motion_result(&motion, &now, &at, unused)));
    }
    let at = apply(c, &motion.mover, &now)?;
    let callback_args: Vec<Value> = match &motion.mover {
        MovedObjects::Pose { .. } => vec![at.clone(), Value::Floats(now[1].clone()), Value::Floats(now[2].clone())],
        _ => now.iter().map(|v| Value::Floats(v.clone())).collect(),
    };
    let stopped = match &motion.listener {
        MotionCallback::Nobody => false,
        listener => {
            let map = motion.answer == ResultForm::Map;
            let mut args = if map { vec![motion_result(&motion, &now, &at, unused)] } else { callback_args };
            if !map && !motion.data.is_empty() {
                args.push(tables::unpack(&motion.data)?);
            }
            let results = match listener {
                MotionCallback::Function(f) => c.call_func(*f, &args)?,
                MotionCallback::Named(name) => c.world().call_function(c.caller_script(), name, &args)?,
                MotionCallback::Nobody => Vec::new(),
            };
            matches!(results.first(), Some(v) if !matches!(v, Value::Nil | Value::Bool(false)))
        }
    };
    let end = if stopped { Some(MotionEnd::Callback) } else { end };
    Ok((end, motion_result(&motion, &now, &at, unused)))
}

fn motion_result(motion: &ActiveMotion, now: &MotionState, at: &Value, left: f64) -> Value {
    let [pos, vel, accel] = now.each_ref().map(|v| Value::Floats(v.clone()));
    let pose = matches!(motion.mover, MovedObjects::Pose { .. });
    match motion.answer {
        ResultForm::Left => Value::List(vec![Value::Float(left)]),
        ResultForm::Map => {
            let mut map = vec![(Value::text(if pose { "pose" } else { "pos" }), at.clone())];
            map.extend([("vel", vel), ("accel", accel)].map(|(k, v)| (Value::text(k), v)));
            if let (true, Value::Floats(p)) = (pose, at)
                && let Ok(p) = Pose::try_from(p.as_slice())
            {
                map.push((Value::text("matrix"), Value::Floats(al::matrix(&p).to_vec())));
            }
            map.push((Value::text("timeLeft"), Value::Float(left)));
            if let Ok(data @ (Value::List(_) | Value::Map(_) | Value::Text(_) | Value::Int(_) | Value::Float(_))) =
                tables::unpack(&motion.data)
            {
                map.push((Value::text("auxData"), data));
            }
            Value::Map(map)
        }
        ResultForm::List if pose => Value::List(vec![at.clone(), Value::Float(left)]),
        ResultForm::List => Value::List(vec![pos, vel, accel, Value::Float(left)]),
        ResultForm::Old => {
            let mut out = vec![Value::Int(1)];
            match at {
                Value::Floats(p) if pose && p.len() == 7 => {
                    out.extend([Value::Floats(p[..3].to_vec()), Value::Floats(p[3..].to_vec())]);
                }
                _ => out.push(pos),
            }
            out.extend([vel, accel, Value::Float(left)]);
            Value::List(out)
        }
    }
}

/// Moves the objects of a motion to the state `now` of its profile, and returns their position in the form that
/// callbacks receive.
fn apply(c: &Ctx<'_>, mover: &MovedObjects, now: &MotionState) -> Result<Value> {
    let (w, p) = (c.world(), &c.plugin().p);
    let at = position(mover, now)?;
    match (mover, &at) {
        (MovedObjects::Joints(joints), _) => {
            for (joint, x) in joints.iter().zip(&now[0]) {
                let driven = text_of(c, *joint, p.joint_mode)? == "dynamic";
                let prop = if driven { p.joint_target_position } else { p.joint_position };
                w.set_f64s(*joint, prop, &[*x])?;
            }
        }
        (MovedObjects::Pose { object, frame, .. }, Value::Floats(pose)) if *object != 0 => {
            w.set_pose(*object, *frame, &numbers_in(pose)?)?;
        }
        _ => {}
    }
    Ok(at)
}

fn numbers_in(pose: &[f64]) -> Result<Pose> {
    Pose::try_from(pose).map_err(|_| Fail::new("a pose must have seven numbers"))
}

/// Returns the position of what a motion moves, in the form that callbacks receive.
fn position(mover: &MovedObjects, now: &MotionState) -> Result<Value> {
    let MovedObjects::Pose { from, to, length, .. } = mover else { return Ok(Value::Floats(now[0].clone())) };
    if let Some(length) = length {
        let covered = now[0].first().copied().unwrap_or(0.0);
        let t = if *length > MIN_LENGTH { (covered / length).clamp(0.0, 1.0) } else { 1.0 };
        return Ok(Value::Floats(al::interpolate(from, to, t).to_vec()));
    }
    let angle = al::axis_angle(al::compose_rotations(al::rotation(to), al::conjugate(al::rotation(from)))).1.abs();
    // The four coordinates are x, y, z and the angle rotated so far.
    let [x, y, z, turned] = <[f64; 4]>::try_from(now[0].as_slice())
        .map_err(|_| Fail::new("a motion to a pose must have four coordinates"))?;
    let t = if angle > 1e-12 { (turned / angle).clamp(0.0, 1.0) } else { 1.0 };
    let q = al::rotation(&al::interpolate(from, to, t));
    Ok(Value::Floats(al::pose([x, y, z], q).to_vec()))
}

/// A way of this length or less is covered at once.
const MIN_LENGTH: f64 = 1e-6;
