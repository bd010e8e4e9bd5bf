//! Builds motions from the arguments of the motion commands.

use super::profile::MotionProfile;
use crate::{
    kit::{
        algebra::{self as al, Pose},
        *,
    },
    state::motions::{ActiveMotion, MotionCallback, MovedObjects, ResultForm},
};

/// Returns the numbers of a table, or a single number repeated `n` times.
fn numbers_or_repeated(v: ValueRef<'_>, n: usize) -> Vec<f64> {
    match v.as_f64() {
        Some(x) => vec![x; n],
        None => v.numbers().unwrap_or_default(),
    }
}

fn listener(c: &Ctx<'_>, v: ValueRef<'_>) -> Result<MotionCallback> {
    Ok(match (v.as_func(), v.as_str()) {
        (Some(f), _) => MotionCallback::Function(c.keep_func(f)?),
        (_, Some(name)) => MotionCallback::Named(name.into_owned()),
        _ => MotionCallback::Nobody,
    })
}

fn packed(v: ValueRef<'_>) -> Vec<u8> {
    if v.is_nil() { Vec::new() } else { v.to_value().and_then(|v| tables::pack(&v)).unwrap_or_default() }
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

pub(super) fn config(c: &Ctx<'_>) -> Result<ActiveMotion> {
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
        return Err(Fail::argument("the parameters contain neither joints nor a start position")
            .help("specify `joints` or `pos`"));
    }
    let target = numbers_or_repeated(of("targetPos", 7), n);
    if target.len() < n {
        return Err(Fail::argument(format!("`targetPos` must have at least {n} numbers, but it has {}", target.len())));
    }
    let limits = [
        numbers_or_repeated(of("maxVel", 4), n),
        numbers_or_repeated(of("maxAccel", 5), n),
        numbers_or_repeated(of("maxJerk", 6), n),
    ];
    Ok(ActiveMotion {
        profile: MotionProfile::to(
            &start,
            &numbers_or_repeated(of("vel", 2), n),
            &target,
            [&limits[0], &limits[1], &limits[2]],
        ),
        mover: if joints.is_empty() { MovedObjects::Nothing } else { MovedObjects::Joints(joints) },
        listener: listener(c, of("callback", 9))?,
        answer: if params.map().is_some() { ResultForm::Map } else { ResultForm::List },
        data: packed(of("auxData", 10)),
    })
}

fn profile_towards(from: Pose, to: Pose, limits: [Vec<f64>; 3]) -> MotionProfile {
    let angle = al::axis_angle(al::compose_rotations(al::rotation(&to), al::conjugate(al::rotation(&from)))).1.abs();
    let (start, target) = ([from[0], from[1], from[2], 0.0], [to[0], to[1], to[2], angle]);
    MotionProfile::to(&start, &[], &target, [&limits[0], &limits[1], &limits[2]])
}

pub(super) fn pose(c: &Ctx<'_>) -> Result<ActiveMotion> {
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
        return Err(Fail::argument("the parameters contain neither an object nor a start pose")
            .help("specify `object` or `pose`"));
    };
    let to = read(of("targetPose", 5), 5)?;
    let limits = [
        numbers_or_repeated(of("maxVel", 2), 4),
        numbers_or_repeated(of("maxAccel", 3), 4),
        numbers_or_repeated(of("maxJerk", 4), 4),
    ];
    Ok(ActiveMotion {
        profile: profile_towards(from, to, limits),
        mover: MovedObjects::Pose { object, frame, from, to },
        listener: listener(c, of("callback", 6))?,
        answer: if map { ResultForm::Map } else { ResultForm::List },
        data: packed(of("auxData", 7)),
    })
}

pub(super) fn rml_joints(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let joints = joints_of(c, c.arg(0))?;
    let (start, n) = (positions(c, &joints)?, joints.len());
    let limits = [4, 5, 6].map(|i| numbers_or_repeated(c.arg(i), n));
    Ok(ActiveMotion {
        profile: MotionProfile::to(
            &start,
            &numbers_or_repeated(c.arg(2), n),
            &numbers_or_repeated(c.arg(7), n),
            [&limits[0], &limits[1], &limits[2]],
        ),
        mover: MovedObjects::Joints(joints),
        listener: MotionCallback::Nobody,
        answer: ResultForm::Old,
        data: Vec::new(),
    })
}

fn frame_of(c: &Ctx<'_>, object: tatu_object, i: usize) -> Result<tatu_object> {
    match int_or(c, i, -1)? {
        -1 => Ok(0),
        HANDLE_PARENT => parent(c, object),
        _ => Ok(existing_object(c, i)?.id),
    }
}

fn move_object(
    c: &Ctx<'_>,
    to: impl Fn(Pose) -> Result<Pose>,
    limits: [Vec<f64>; 3],
    answer: ResultForm,
) -> Result<ActiveMotion> {
    let object = existing_object(c, 0)?.id;
    let frame = if answer == ResultForm::Left && c.arg(1).as_i64().is_none() { 0 } else { frame_of(c, object, 1)? };
    let from = c.world().pose(object, frame)?;
    let to = to(from)?;
    let mover = MovedObjects::Pose { object, frame, from, to };
    Ok(ActiveMotion {
        profile: profile_towards(from, to, limits),
        mover,
        listener: MotionCallback::Nobody,
        answer,
        data: Vec::new(),
    })
}

pub(super) fn rml_position(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let to = |mut at: Pose| {
        if c.has(8) {
            at[..3].copy_from_slice(&numbers::<3>(c, 8)?);
        }
        if c.has(9) {
            at[3..].copy_from_slice(&unit(numbers(c, 9)?, 9)?);
        }
        Ok(at)
    };
    move_object(c, to, [5, 6, 7].map(|i| numbers_or_repeated(c.arg(i), 4)), ResultForm::Old)
}

/// Returns limits of velocity and acceleration that are equal for the four coordinates of a pose, and no jerk limit.
fn equal_limits(v: f64, a: f64) -> [Vec<f64>; 3] {
    [vec![v; 4], vec![if a > 0.0 { a } else { 0.0 }; 4], Vec::new()]
}

pub(super) fn to_position(c: &Ctx<'_>) -> Result<ActiveMotion> {
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
    move_object(c, to, equal_limits(c.f64(4)?, accel), ResultForm::Left)
}

pub(super) fn to_object(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let (object, target, what) = (existing_object(c, 0)?.id, existing_object(c, 1)?.id, int_or(c, 2, 3)?);
    let from = c.world().pose(object, 0)?;
    let goal = c.world().pose(target, 0)?;
    let p = if what & 1 != 0 { al::position(&goal) } else { al::position(&from) };
    let q = if what & 2 != 0 { al::rotation(&goal) } else { al::rotation(&from) };
    let to = al::pose(p, q);
    // The velocity is a fraction of the motion per second.
    let v = if c.has(4) { c.f64(4)?.abs().max(1e-6) } else { 1.0 };
    let angle = al::axis_angle(al::compose_rotations(q, al::conjugate(al::rotation(&from)))).1.abs();
    let way = al::length(al::sub(p, al::position(&from))).max(1e-9);
    let accel = if c.has(5) { c.f64(5)?.max(0.0) } else { 0.0 };
    let by = |x: f64| vec![way * x, way * x, way * x, angle.max(1e-9) * x];
    let mover = MovedObjects::Pose { object, frame: 0, from, to };
    let profile = profile_towards(from, to, [by(v), by(accel), Vec::new()]);
    Ok(ActiveMotion { profile, mover, listener: MotionCallback::Nobody, answer: ResultForm::Left, data: Vec::new() })
}

pub(super) fn to_joints(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let joints = joints_of(c, c.arg(0))?;
    let (start, n) = (positions(c, &joints)?, joints.len());
    let (v, a) = (numbers_or_repeated(c.arg(2), n), numbers_or_repeated(c.arg(3), n));
    let profile = MotionProfile::to(&start, &[], &numbers_or_repeated(c.arg(1), n), [&v, &a, &[]]);
    Ok(ActiveMotion {
        profile,
        mover: MovedObjects::Joints(joints),
        listener: MotionCallback::Nobody,
        answer: ResultForm::Left,
        data: Vec::new(),
    })
}
