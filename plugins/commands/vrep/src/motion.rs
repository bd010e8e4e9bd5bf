//! Motions that threads wait for: `sim.moveToConfig`, `sim.moveToPose` and their older kin.
//!
//! Each is a [`Motion`] under a number; in every step the profile goes on, what is moved is set, and a callback is told.

use serde::{Deserialize, Serialize};

use crate::{
    Vrep,
    algebra::{self as al, Pose},
    kit::*,
    profile::{Profile, State},
    profiles::NOTES,
    state::state,
};

/// What a motion moves.
#[derive(Serialize, Deserialize, Clone)]
enum Mover {
    Joints(Vec<tatu_object>),
    /// An object, from pose to pose in a frame (0: the world); 0: only the callback is told.
    Pose {
        object: tatu_object,
        frame: tatu_object,
        from: Pose,
        to: Pose,
    },
    Nothing,
}

/// Who is told of each step.
#[derive(Serialize, Deserialize, Clone)]
enum Listener {
    Nobody,
    Function(tatu_func),
    Named(String),
}

/// What a command gives in the end.
#[derive(Serialize, Deserialize, Clone, Copy, PartialEq)]
enum Answer {
    /// A table with keys.
    Map,
    /// The values one by one, as before 4.7.
    List,
    /// A result, the values, and the time left over, as in 3.x.
    Old,
    /// The time left over.
    Left,
}

#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct Motion {
    profile: Profile,
    mover: Mover,
    listener: Listener,
    answer: Answer,
    /// What the callback gets as its last argument, packed.
    data: Vec<u8>,
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let waits = "Waits in the calling thread; in scripts without one it fails.";
    offer.command(
        modern("moveToConfig", |c| run(c, config))
            .param(Param::any("params").text("a table: joints, targetPos, maxVel, maxAccel, maxJerk, pos, vel, callback, auxData"))
            .param(Param::any("more").rest().text("the form of 4.2 to 4.6: flags, pos, vel, accel, maxVel, maxAccel, maxJerk, targetPos, targetVel, callback, auxData"))
            .returns(Param::any("data").text("where it ended: pos, vel, accel, timeLeft"))
            .text("Moves joints, or what a callback moves, to a configuration.")
            .no_wait(waits)
            .partial(NOTES),
    );
    offer.command(
        modern("moveToPose", |c| run(c, pose))
            .param(Param::any("params").text("a table: object, pose, targetPose, maxVel, maxAccel, maxJerk (4 numbers: x, y, z, angle), relObject, callback, auxData"))
            .param(Param::any("more").rest().text("the form of 4.2 to 4.6: flags, pose, maxVel, maxAccel, maxJerk, targetPose, callback, auxData, metric"))
            .returns(Param::any("data").text("where it ended: pose, timeLeft"))
            .text("Moves an object, or what a callback moves, to a pose.")
            .no_wait(waits)
            .partial(NOTES),
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
            .param(table("maxAccel", "of each joint"))
            .param(table("maxJerk", "of each joint"))
            .param(table("target", "positions"))
            .param(Param::any("targetVelocity").optional().text("ignored: it stops there"))
            .param(Param::any("direction").optional().text("ignored: the shorter way"))
            .returns(Param::int("result").text("0"))
            .returns(Param::floats("position", 0))
            .returns(Param::floats("velocity", 0))
            .returns(Param::floats("acceleration", 0))
            .returns(Param::float("left").unit("s"))
            .text("Moves joints to positions.")
            .no_wait(waits)
            .partial(NOTES),
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
            .param(Param::any("position").optional().text("nil: it stays"))
            .param(Param::any("quaternion").optional().text("nil: it stays"))
            .param(Param::any("targetVelocity").optional().text("ignored"))
            .returns(Param::int("result").text("0"))
            .returns(Param::floats("position", 3))
            .returns(Param::floats("quaternion", 4))
            .returns(Param::floats("velocity", 4))
            .returns(Param::floats("acceleration", 4))
            .returns(Param::float("left").unit("s"))
            .text("Moves an object to a position and orientation.")
            .no_wait(waits)
            .partial(NOTES),
    );
    offer.command(
        both("moveToPosition", NIL, |c| run(c, to_position))
            .param(flagged("object"))
            .param(frame_param())
            .param(Param::any("position").optional())
            .param(Param::any("angles").optional())
            .param(Param::float("velocity").unit("m/s"))
            .param(Param::float("acceleration").default(0.0).optional())
            .param(Param::any("method").optional().text("ignored"))
            .returns(Param::float("left").unit("s"))
            .text("Moves an object to a position and Euler angles.")
            .no_wait(waits)
            .partial(NOTES),
    );
    offer.command(
        both("moveToObject", NIL, |c| run(c, to_object))
            .param(flagged("object"))
            .param(flagged("target"))
            .param(Param::int("what").default(3).optional().text("1: position, 2: orientation, 3: both"))
            .param(Param::float("along").default(0.0).optional().text("ignored: where on a path"))
            .param(Param::float("velocity").default(1.0).optional().text("1/s: of the whole way"))
            .param(Param::float("acceleration").default(0.0).optional())
            .returns(Param::float("left").unit("s"))
            .text("Moves an object to another one.")
            .no_wait(waits)
            .partial(NOTES),
    );
    offer.command(
        both("moveToJointPositions", NIL, |c| run(c, to_joints))
            .param(Param::list("joints"))
            .param(table("positions", "rad or m"))
            .param(Param::any("velocity").text("a number, or a table"))
            .param(Param::any("acceleration").optional())
            .param(Param::any("more").rest().text("ignored"))
            .returns(Param::float("left").unit("s"))
            .text("Moves joints to positions.")
            .no_wait(waits)
            .partial(NOTES),
    );
}

/// The three parts of a motion, for scripts that wait themselves.
fn steps(offer: &mut Offer<Vrep>) {
    for (name, make) in [("Config", config as Make), ("Pose", pose)] {
        let motion = || Param::any("motion").text("what the first part gave");
        offer.command(
            modern(&format!("moveTo{name}_init"), move |c| {
                let motion = make(c)?;
                let number = keep(c, motion)?;
                c.ret::<Value>(Value::Map(vec![(Value::text("motion"), Value::Int(number))]));
                Ok(())
            })
            .param(Param::any("params").text(format!("as of sim.moveTo{name}")))
            .returns(motion())
            .text(format!("Begins what sim.moveTo{name} does, for scripts that go on by themselves."))
            .partial(NOTES),
        );
        offer.command(
            modern(&format!("moveTo{name}_step"), |c| {
                let number = number_of(c)?;
                let (arrived, answer) = advance(c, number)?;
                c.ret(i64::from(arrived));
                c.ret::<Value>(answer);
                Ok(())
            })
            .param(motion())
            .returns(Param::int("result").text("0: under way, 1: arrived"))
            .returns(Param::any("data"))
            .text("Goes on with it by one step.")
            .partial(NOTES),
        );
        offer.command(
            modern(&format!("moveTo{name}_cleanup"), |c| {
                let number = number_of(c)?;
                finish(c, number)
            })
            .param(motion())
            .text("Ends it."),
        );
    }
}

type Make = fn(&Ctx<'_>) -> Result<Motion>;

fn number_of(c: &Ctx<'_>) -> Result<i64> {
    let number = c.arg(0).get("motion").and_then(|v| v.as_i64());
    number.ok_or_else(|| Fail::argument("argument 1: expected what the first part of the motion gave"))
}

fn keep(c: &Ctx<'_>, motion: Motion) -> Result<i64> {
    let mut state = state(c)?;
    state.moved += 1;
    let number = state.moved;
    state.motions.insert(number, motion);
    Ok(number)
}

fn finish(c: &Ctx<'_>, number: i64) -> Result {
    let motion = state(c)?.motions.remove(&number);
    if let Some(Motion { listener: Listener::Function(f), .. }) = motion {
        c.drop_func(f);
    }
    Ok(())
}

/// Makes the motion, and goes on with it in each step.
fn run(c: &mut Ctx<'_>, make: Make) -> Result<Outcome> {
    let number = match c.resumed() {
        0 => {
            if !c.can_wait() {
                return Err(Fail::unsupported("this motion takes time, and the calling script has no thread")
                    .help("call it from a threaded script, or from sysCall_thread or a coroutine"));
            }
            keep(c, make(c)?)?
        }
        word => word as i64,
    };
    let (arrived, answer) = match advance(c, number) {
        Ok(done) => done,
        Err(e) => {
            finish(c, number)?;
            return Err(e);
        }
    };
    if !arrived {
        return c.wait_steps(1, number as u64);
    }
    finish(c, number)?;
    match answer {
        Value::List(values) => values.into_iter().for_each(|v| c.ret::<Value>(v)),
        v => c.ret::<Value>(v),
    }
    Ok(Outcome::Done)
}

/// One step: whether it has arrived (or the callback said enough), and what is answered.
fn advance(c: &mut Ctx<'_>, number: i64) -> Result<(bool, Value)> {
    let dt = c.world().f64(0, c.plugin().p.dt)?;
    let (motion, (mut arrived, now, left)) = {
        let mut state = state(c)?;
        let motion = state.motions.get_mut(&number);
        let motion = motion.ok_or_else(|| Fail::missing(format!("there is no motion {number}")))?;
        let stepped = motion.profile.step(dt);
        (motion.clone(), stepped)
    };
    let at = apply(c, &motion.mover, &now)?;
    let told: Vec<Value> = match &motion.mover {
        Mover::Pose { .. } => vec![at.clone(), Value::Floats(now[1].clone()), Value::Floats(now[2].clone())],
        _ => now.iter().map(|v| Value::Floats(v.clone())).collect(),
    };
    let enough = match &motion.listener {
        Listener::Nobody => false,
        listener => {
            let map = motion.answer == Answer::Map;
            let mut args = if map { vec![answer(&motion, &now, &at, left)] } else { told };
            if !map && !motion.data.is_empty() {
                args.push(crate::tables::unpack(&motion.data)?);
            }
            let results = match listener {
                Listener::Function(f) => c.call_func(*f, &args)?,
                Listener::Named(name) => crate::scripts::call_named(c, c.caller_script(), name, &args)?,
                Listener::Nobody => Vec::new(),
            };
            matches!(results.first(), Some(v) if !matches!(v, Value::Nil | Value::Bool(false)))
        }
    };
    arrived |= enough;
    Ok((arrived, answer(&motion, &now, &at, left)))
}

fn answer(motion: &Motion, now: &State, at: &Value, left: f64) -> Value {
    let [pos, vel, accel] = now.each_ref().map(|v| Value::Floats(v.clone()));
    let pose = matches!(motion.mover, Mover::Pose { .. });
    match motion.answer {
        Answer::Left => Value::List(vec![Value::Float(left)]),
        Answer::Map => {
            let mut map = vec![(Value::text(if pose { "pose" } else { "pos" }), at.clone())];
            map.extend([("vel", vel), ("accel", accel)].map(|(k, v)| (Value::text(k), v)));
            map.push((Value::text("timeLeft"), Value::Float(left)));
            if let Ok(data @ (Value::List(_) | Value::Map(_) | Value::Text(_) | Value::Int(_) | Value::Float(_))) =
                crate::tables::unpack(&motion.data)
            {
                map.push((Value::text("auxData"), data));
            }
            Value::Map(map)
        }
        Answer::List if pose => Value::List(vec![at.clone(), Value::Float(left)]),
        Answer::List => Value::List(vec![pos, vel, accel, Value::Float(left)]),
        Answer::Old => {
            let mut out = vec![Value::Int(0)];
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

/// Sets what is moved; where it is.
fn apply(c: &Ctx<'_>, mover: &Mover, now: &State) -> Result<Value> {
    let (w, p) = (c.world(), &c.plugin().p);
    match mover {
        Mover::Nothing => {}
        Mover::Joints(joints) => {
            for (joint, x) in joints.iter().zip(&now[0]) {
                let driven = text_of(c, *joint, p.joint_mode)? == "dynamic";
                let prop = if driven { p.joint_target_position } else { p.joint_position };
                w.set_f64s(*joint, prop, &[*x])?;
            }
        }
        Mover::Pose { object, frame, from, to } => {
            let angle = al::axis_angle(al::turn(al::rotation(to), al::conjugate(al::rotation(from)))).1.abs();
            // The four coordinates are x, y, z and the angle that was turned.
            let [x, y, z, turned] =
                <[f64; 4]>::try_from(now[0].as_slice()).map_err(|_| Fail::new("a pose has four coordinates"))?;
            let t = if angle > 1e-12 { (turned / angle).clamp(0.0, 1.0) } else { 1.0 };
            let q = al::rotation(&al::interpolate(from, to, t));
            let at = al::pose([x, y, z], q);
            if *object != 0 {
                w.set_pose(*object, *frame, &at)?;
            }
            return Ok(Value::Floats(at.to_vec()));
        }
    }
    Ok(Value::Floats(now[0].clone()))
}

/// Numbers of a value: a table, or one number for all.
fn several(v: ValueRef<'_>, n: usize) -> Vec<f64> {
    match v.as_f64() {
        Some(x) => vec![x; n],
        None => v.numbers().unwrap_or_default(),
    }
}

fn listener(c: &Ctx<'_>, v: ValueRef<'_>) -> Result<Listener> {
    Ok(match (v.as_func(), v.as_str()) {
        (Some(f), _) => Listener::Function(c.keep_func(f)?),
        (_, Some(name)) => Listener::Named(name.into_owned()),
        _ => Listener::Nobody,
    })
}

fn packed(v: ValueRef<'_>) -> Vec<u8> {
    if v.is_nil() { Vec::new() } else { v.to_value().and_then(|v| crate::tables::pack(&v)).unwrap_or_default() }
}

fn joints_of(c: &Ctx<'_>, v: ValueRef<'_>) -> Result<Vec<tatu_object>> {
    let all = v.numbers().unwrap_or_default();
    all.iter()
        .map(|n| {
            let id = *n as u64 & HANDLE_BITS as u64;
            let o = c.world().look(id).map_err(|_| Fail::missing(format!("there is no object {n}")))?;
            if o.kind == TATU_KIND_JOINT || c.world().used_as(o.id, "joint") {
                Ok(o.id)
            } else {
                Err(Fail::argument(format!("object {n} is not a joint")))
            }
        })
        .collect()
}

fn positions(c: &Ctx<'_>, joints: &[tatu_object]) -> Result<Vec<f64>> {
    joints.iter().map(|j| c.world().f64(*j, c.plugin().p.joint_position)).collect()
}

fn config(c: &Ctx<'_>) -> Result<Motion> {
    let nil = ValueRef::NIL;
    let params = c.arg(0);
    let of = |key: &str, i: usize| if params.map().is_some() { params.get(key).unwrap_or(nil) } else { c.arg(i) };
    let joints = if params.map().is_some() { joints_of(c, of("joints", 0))? } else { Vec::new() };
    let start = match of("pos", 1).numbers() {
        Some(p) if !p.is_empty() => p,
        _ => positions(c, &joints)?,
    };
    let n = start.len();
    if n == 0 {
        return Err(Fail::argument("it tells neither joints nor where it begins").help("give `joints`, or `pos`"));
    }
    let target = several(of("targetPos", 7), n);
    if target.len() < n {
        return Err(Fail::argument(format!("targetPos has {} numbers where {n} are needed", target.len())));
    }
    let limits = [several(of("maxVel", 4), n), several(of("maxAccel", 5), n), several(of("maxJerk", 6), n)];
    Ok(Motion {
        profile: Profile::to(&start, &several(of("vel", 2), n), &target, [&limits[0], &limits[1], &limits[2]]),
        mover: if joints.is_empty() { Mover::Nothing } else { Mover::Joints(joints) },
        listener: listener(c, of("callback", 9))?,
        answer: if params.map().is_some() { Answer::Map } else { Answer::List },
        data: packed(of("auxData", 10)),
    })
}

fn towards(from: Pose, to: Pose, limits: [Vec<f64>; 3]) -> Profile {
    let angle = al::axis_angle(al::turn(al::rotation(&to), al::conjugate(al::rotation(&from)))).1.abs();
    let (start, target) = ([from[0], from[1], from[2], 0.0], [to[0], to[1], to[2], angle]);
    Profile::to(&start, &[], &target, [&limits[0], &limits[1], &limits[2]])
}

fn pose(c: &Ctx<'_>) -> Result<Motion> {
    let params = c.arg(0);
    let map = params.map().is_some();
    let of = |key: &str, i: usize| if map { params.get(key).unwrap_or(ValueRef::NIL) } else { c.arg(i) };
    let handle_of = |key: &str| -> Result<tatu_object> {
        match params.get(key).and_then(|v| v.as_i64()) {
            Some(n) if n > 0 => Ok(c.world().look(n as u64 & HANDLE_BITS as u64)?.id),
            _ => Ok(0),
        }
    };
    let (object, frame) = if map { (handle_of("object")?, handle_of("relObject")?) } else { (0, 0) };
    let read = |v: ValueRef<'_>, i: usize| -> Result<Pose> {
        if v.len() >= 12 { Ok(al::of_matrix(&numbers_of(v, i)?)) } else { numbers_of(v, i) }
    };
    let start = of("pose", 1);
    let from = if is_table(start) {
        read(start, 1)?
    } else if object != 0 {
        c.world().pose(object, frame)?
    } else {
        return Err(Fail::argument("it tells neither an object nor where it begins").help("give `object`, or `pose`"));
    };
    let to = read(of("targetPose", 5), 5)?;
    let limits = [several(of("maxVel", 2), 4), several(of("maxAccel", 3), 4), several(of("maxJerk", 4), 4)];
    Ok(Motion {
        profile: towards(from, to, limits),
        mover: Mover::Pose { object, frame, from, to },
        listener: listener(c, of("callback", 6))?,
        answer: if map { Answer::Map } else { Answer::List },
        data: packed(of("auxData", 7)),
    })
}

fn rml_joints(c: &Ctx<'_>) -> Result<Motion> {
    let joints = joints_of(c, c.arg(0))?;
    let (start, n) = (positions(c, &joints)?, joints.len());
    let limits = [4, 5, 6].map(|i| several(c.arg(i), n));
    Ok(Motion {
        profile: Profile::to(
            &start,
            &several(c.arg(2), n),
            &several(c.arg(7), n),
            [&limits[0], &limits[1], &limits[2]],
        ),
        mover: Mover::Joints(joints),
        listener: Listener::Nobody,
        answer: Answer::Old,
        data: Vec::new(),
    })
}

fn frame_of(c: &Ctx<'_>, object: tatu_object, i: usize) -> Result<tatu_object> {
    match int_or(c, i, -1)? {
        -1 => Ok(0),
        HANDLE_PARENT => parent(c, object),
        _ => Ok(living(c, i)?.id),
    }
}

fn move_object(
    c: &Ctx<'_>,
    to: impl Fn(Pose) -> Result<Pose>,
    limits: [Vec<f64>; 3],
    answer: Answer,
) -> Result<Motion> {
    let object = living(c, 0)?.id;
    let frame = if answer == Answer::Left && c.arg(1).as_i64().is_none() { 0 } else { frame_of(c, object, 1)? };
    let from = c.world().pose(object, frame)?;
    let to = to(from)?;
    let mover = Mover::Pose { object, frame, from, to };
    Ok(Motion { profile: towards(from, to, limits), mover, listener: Listener::Nobody, answer, data: Vec::new() })
}

fn rml_position(c: &Ctx<'_>) -> Result<Motion> {
    let to = |mut at: Pose| {
        if c.has(8) {
            at[..3].copy_from_slice(&numbers::<3>(c, 8)?);
        }
        if c.has(9) {
            at[3..].copy_from_slice(&crate::poses::unit(numbers(c, 9)?, 9)?);
        }
        Ok(at)
    };
    move_object(c, to, [5, 6, 7].map(|i| several(c.arg(i), 4)), Answer::Old)
}

/// Limits of velocity and acceleration that hold for the whole way.
fn even(v: f64, a: f64) -> [Vec<f64>; 3] {
    [vec![v; 4], vec![if a > 0.0 { a } else { 0.0 }; 4], Vec::new()]
}

fn to_position(c: &Ctx<'_>) -> Result<Motion> {
    let to = |mut at: Pose| {
        if c.has(2) {
            at[..3].copy_from_slice(&numbers::<3>(c, 2)?);
        }
        if c.has(3) {
            at[3..].copy_from_slice(&al::from_euler(numbers(c, 3)?));
        }
        Ok(at)
    };
    let accel = if c.has(5) { c.f64(5)? } else { 0.0 };
    move_object(c, to, even(c.f64(4)?, accel), Answer::Left)
}

fn to_object(c: &Ctx<'_>) -> Result<Motion> {
    let (object, target, what) = (living(c, 0)?.id, living(c, 1)?.id, int_or(c, 2, 3)?);
    let from = c.world().pose(object, 0)?;
    let goal = c.world().pose(target, 0)?;
    let p = if what & 1 != 0 { al::position(&goal) } else { al::position(&from) };
    let q = if what & 2 != 0 { al::rotation(&goal) } else { al::rotation(&from) };
    let to = al::pose(p, q);
    // The velocity is that of the whole way.
    let v = if c.has(4) { c.f64(4)?.abs().max(1e-6) } else { 1.0 };
    let angle = al::axis_angle(al::turn(q, al::conjugate(al::rotation(&from)))).1.abs();
    let way = al::length(al::sub(p, al::position(&from))).max(1e-9);
    let accel = if c.has(5) { c.f64(5)?.max(0.0) } else { 0.0 };
    let by = |x: f64| vec![way * x, way * x, way * x, angle.max(1e-9) * x];
    let mover = Mover::Pose { object, frame: 0, from, to };
    let profile = towards(from, to, [by(v), by(accel), Vec::new()]);
    Ok(Motion { profile, mover, listener: Listener::Nobody, answer: Answer::Left, data: Vec::new() })
}

fn to_joints(c: &Ctx<'_>) -> Result<Motion> {
    let joints = joints_of(c, c.arg(0))?;
    let (start, n) = (positions(c, &joints)?, joints.len());
    let (v, a) = (several(c.arg(2), n), several(c.arg(3), n));
    let profile = Profile::to(&start, &[], &several(c.arg(1), n), [&v, &a, &[]]);
    Ok(Motion {
        profile,
        mover: Mover::Joints(joints),
        listener: Listener::Nobody,
        answer: Answer::Left,
        data: Vec::new(),
    })
}
