//! Builds motions from the arguments of the motion commands.

use std::f64::consts::PI;

use tatu_trajectories::{State, Synchronization};

use super::profile::{LimitLists, MotionProfile, states, synchronization};
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

/// Returns the target of a cyclic joint that is `direction` from its position: 0 is the shorter way, n and -n are upwards
/// and downwards with n - 1 additional turns.
fn cyclic_target(from: f64, to: f64, direction: f64) -> f64 {
    let turn = 2.0 * PI;
    let short = (to - from) - turn * ((to - from) / turn).round();
    let ahead = match direction {
        d if d > 0.0 && short < 0.0 => short + turn,
        d if d < 0.0 && short > 0.0 => short - turn,
        _ => short,
    };
    let turns = (direction.abs().floor() - 1.0).max(0.0);
    from + ahead + turns * turn * direction.signum()
}

/// Arguments by their keys in the table of 4.7, or by their places before.
struct Arguments<'a> {
    table: Option<ValueRef<'a>>,
    call: &'a Ctx<'a>,
}

impl<'a> Arguments<'a> {
    fn new(c: &'a Ctx<'_>) -> Self {
        let first = c.arg(0);
        Arguments { table: first.map().is_some().then_some(first), call: c }
    }
    fn of(&self, key: &str, place: usize) -> ValueRef<'a> {
        match self.table {
            Some(table) => table.get(key).unwrap_or(ValueRef::NIL),
            None => self.call.arg(place),
        }
    }
    /// Returns an argument that only the table has.
    fn of_table(&self, key: &str) -> ValueRef<'a> {
        self.table.and_then(|table| table.get(key)).unwrap_or(ValueRef::NIL)
    }
    fn object(&self, key: &str) -> Result<tatu_object> {
        match self.of_table(key).as_i64() {
            Some(n) if n > 0 => Ok(self.call.world().look(n as u64 & HANDLE_BITS as u64)?.id),
            _ => Ok(0),
        }
    }
    /// Since 4.7 motions are on a straight line by default; from 4.3 to 4.6 coordinates arrive together.
    fn synchronization(&self) -> Synchronization {
        let default = if self.table.is_some() { Synchronization::Phase } else { Synchronization::Time };
        synchronization(self.of("flags", 0).as_i64().unwrap_or(-1), default)
    }
    fn answer(&self) -> ResultForm {
        if self.table.is_some() { ResultForm::Map } else { ResultForm::List }
    }
    /// Returns a limit of each of `n` coordinates; a number is the limit of all, and without the argument there is none.
    fn limits(&self, key: &str, place: usize, n: usize) -> Result<Vec<f64>> {
        let given = self.of(key, place);
        let all = numbers_or_repeated(given, n);
        let wrong = |what: String| {
            Err(Fail::argument(format!("`{key}` must be a number above 0, or {n} such numbers, but {what}")))
        };
        if given.is_nil() {
            return Ok(all);
        }
        if all.len() < n {
            return wrong(format!("it has {}", all.len()));
        }
        match all.iter().find(|x| x.is_nan() || **x <= 0.0) {
            Some(x) => wrong(format!("one is {x}")),
            None => Ok(all),
        }
    }
    /// Duration of a step of the motion, s; 0: that of the simulation.
    fn time_step(&self, place: usize) -> f64 {
        self.of("timeStep", place).as_f64().filter(|dt| dt.is_finite() && *dt > 0.0).unwrap_or(0.0)
    }
}

pub(super) fn config(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let arguments = Arguments::new(c);
    let joints = if arguments.table.is_some() { joints_of(c, arguments.of_table("joints"))? } else { Vec::new() };
    let start = match arguments.of("pos", 1).numbers() {
        Some(p) if !p.is_empty() => p,
        _ => positions(c, &joints)?,
    };
    let n = start.len();
    if n == 0 {
        return Err(Fail::argument("the parameters contain neither joints nor a start position")
            .help("specify `joints` or `pos`"));
    }
    let list = |key: &str, place: usize| numbers_or_repeated(arguments.of(key, place), n);
    if arguments.of("targetPos", 7).is_nil() {
        return Err(Fail::argument(format!("`targetPos` is missing: expected {n} numbers")));
    }
    let mut target = list("targetPos", 7);
    if target.len() < n {
        return Err(Fail::argument(format!("`targetPos` must have at least {n} numbers, but it has {}", target.len())));
    }
    let cyclic = arguments.of("cyclicJoints", 11);
    let is_cyclic = |k: usize| match cyclic.list() {
        Some(list) => list.get(k).is_some_and(|v| v.truthy()),
        None => cyclic.number(k).is_some_and(|x| x != 0.0),
    };
    for (k, target) in target.iter_mut().enumerate().take(n) {
        if is_cyclic(k) {
            *target = cyclic_target(start[k], *target, 0.0);
        }
    }
    let limits = LimitLists {
        min_velocity: numbers_or_repeated(arguments.of_table("minVel"), n),
        min_acceleration: numbers_or_repeated(arguments.of_table("minAccel"), n),
        ..LimitLists::symmetric(
            arguments.limits("maxVel", 4, n)?,
            arguments.limits("maxAccel", 5, n)?,
            arguments.limits("maxJerk", 6, n)?,
        )
    };
    let starts = states(n, [&start, &list("vel", 2), &list("accel", 3)]);
    let targets = states(n, [&target, &list("targetVel", 8), &[]]);
    Ok(ActiveMotion {
        script: c.caller_script(),
        profile: MotionProfile::to(&starts, &targets, &limits, arguments.synchronization())?,
        mover: if joints.is_empty() { MovedObjects::Nothing } else { MovedObjects::Joints(joints) },
        listener: listener(c, arguments.of("callback", 9))?,
        answer: arguments.answer(),
        data: packed(arguments.of("auxData", 10)),
        time_step: arguments.time_step(12),
        has_ended: false,
    })
}

/// The way of an object between two poses.
struct Way {
    object: tatu_object,
    frame: tatu_object,
    from: Pose,
    to: Pose,
}

impl Way {
    fn angle(&self) -> f64 {
        let turn = al::compose_rotations(al::rotation(&self.to), al::conjugate(al::rotation(&self.from)));
        al::axis_angle(turn).1.abs()
    }

    /// Returns a motion of the coordinates x, y, z and angle.
    fn by_coordinates(
        self,
        limits: &LimitLists,
        synchronization: Synchronization,
    ) -> Result<(MotionProfile, MovedObjects)> {
        let rest = |p: &Pose, angle: f64| [p[0], p[1], p[2], angle].map(State::at);
        let (starts, targets) = (rest(&self.from, 0.0), rest(&self.to, self.angle()));
        let profile = MotionProfile::to(&starts, &targets, limits, synchronization)?;
        let Way { object, frame, from, to } = self;
        Ok((profile, MovedObjects::Pose { object, frame, from, to, length: None }))
    }

    /// Returns a motion of one coordinate, the length of the way: the root of the sum of the squares of the differences in
    /// x, y, z and angle, each times its metric.
    fn by_length(self, metric: [f64; 4], limits: &LimitLists) -> Result<(MotionProfile, MovedObjects)> {
        let differences = [0, 1, 2].map(|k| self.to[k] - self.from[k]);
        let angle = self.angle();
        let squares = differences.iter().chain([&angle]).zip(metric).map(|(d, m)| (d * m) * (d * m));
        let length = squares.sum::<f64>().sqrt();
        let profile = MotionProfile::to(&[State::at(0.0)], &[State::at(length)], limits, Synchronization::Time)?;
        let Way { object, frame, from, to } = self;
        Ok((profile, MovedObjects::Pose { object, frame, from, to, length: Some(length) }))
    }
}

pub(super) fn pose(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let arguments = Arguments::new(c);
    let (object, frame) = (arguments.object("object")?, arguments.object("relObject")?);
    if object != 0 && is_below(c, frame, object)? {
        return Err(
            Fail::argument("`relObject` is the moved object itself or below it").help("specify an object that stays")
        );
    }
    let read = |v: ValueRef<'_>, i: usize| -> Result<Pose> {
        if v.len() >= 12 {
            return Ok(al::of_matrix(&numbers_of(v, i)?));
        }
        let pose: Pose = numbers_of(v, i)?;
        Ok(al::pose(al::position(&pose), unit(al::rotation(&pose), i)?))
    };
    let start = arguments.of("pose", 1);
    let from = if is_table(start) {
        read(start, 1)?
    } else if object != 0 {
        c.world().pose(object, frame)?
    } else {
        return Err(Fail::argument("the parameters contain neither an object nor a start pose")
            .help("specify `object` or `pose`"));
    };
    let to = read(arguments.of("targetPose", 5), 5)?;
    let metric = arguments.of("metric", 8);
    let n = if is_table(metric) { 1 } else { 4 };
    let limits = LimitLists::symmetric(
        arguments.limits("maxVel", 2, n)?,
        arguments.limits("maxAccel", 3, n)?,
        arguments.limits("maxJerk", 4, n)?,
    );
    let way = Way { object, frame, from, to };
    let (profile, mover) = if is_table(metric) {
        way.by_length(numbers_of(metric, 8)?, &limits)?
    } else {
        way.by_coordinates(&limits, arguments.synchronization())?
    };
    Ok(ActiveMotion {
        script: c.caller_script(),
        profile,
        mover,
        listener: listener(c, arguments.of("callback", 6))?,
        answer: arguments.answer(),
        data: packed(arguments.of("auxData", 7)),
        time_step: arguments.time_step(9),
        has_ended: false,
    })
}

/// Returns whether an object is another one or below it.
fn is_below(c: &Ctx<'_>, mut object: tatu_object, other: tatu_object) -> Result<bool> {
    while object != 0 {
        if object == other {
            return Ok(true);
        }
        object = parent(c, object)?;
    }
    Ok(false)
}

/// Returns a motion that calls no function.
fn silent(c: &Ctx<'_>, (profile, mover): (MotionProfile, MovedObjects), answer: ResultForm) -> ActiveMotion {
    ActiveMotion {
        script: c.caller_script(),
        profile,
        mover,
        listener: MotionCallback::Nobody,
        answer,
        data: Vec::new(),
        time_step: 0.0,
        has_ended: false,
    }
}

pub(super) fn rml_joints(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let joints = joints_of(c, c.arg(0))?;
    let (start, n) = (positions(c, &joints)?, joints.len());
    let list = |i: usize| numbers_or_repeated(c.arg(i), n);
    let mut target = list(7);
    if target.len() < n {
        return Err(Fail::argument(format!(
            "argument 8: expected {n} positions, one for each joint, but got {}",
            target.len()
        )));
    }
    for (k, joint) in joints.iter().enumerate() {
        if bool_of(c, *joint, c.plugin().p.joint_cyclic)? {
            target[k] = cyclic_target(start[k], target[k], c.arg(9).number(k).unwrap_or(0.0));
        }
    }
    let limits = LimitLists::symmetric(required_limits(c, 4, n)?, required_limits(c, 5, n)?, list(6));
    let starts = states(n, [&start, &list(2), &list(3)]);
    let targets = states(n, [&target, &list(8), &[]]);
    let flags = c.arg(1).as_i64().unwrap_or(-1);
    let profile = MotionProfile::to(&starts, &targets, &limits, synchronization(flags, Synchronization::Phase))?;
    Ok(silent(c, (profile, MovedObjects::Joints(joints)), ResultForm::Old))
}

fn frame_of(c: &Ctx<'_>, object: tatu_object, i: usize) -> Result<tatu_object> {
    match int_or(c, i, -1)? {
        -1 => Ok(0),
        HANDLE_PARENT => parent(c, object),
        _ => Ok(existing_object(c, i)?.id),
    }
}

/// Returns the way of the first argument's object to a pose.
fn way(c: &Ctx<'_>, without_frame: bool, to: impl Fn(Pose) -> Result<Pose>) -> Result<Way> {
    let object = existing_object(c, 0)?.id;
    let frame = if without_frame { 0 } else { frame_of(c, object, 1)? };
    let from = c.world().pose(object, frame)?;
    Ok(Way { object, frame, from, to: to(from)? })
}

pub(super) fn rml_position(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let way = way(c, false, |mut at: Pose| {
        if c.has(8) {
            at[..3].copy_from_slice(&numbers::<3>(c, 8)?);
        }
        if c.has(9) {
            at[3..].copy_from_slice(&unit(numbers(c, 9)?, 9)?);
        }
        Ok(at)
    })?;
    let limits =
        LimitLists::symmetric(required_limits(c, 5, 4)?, required_limits(c, 6, 4)?, numbers_or_repeated(c.arg(7), 4));
    let synchronization = synchronization(c.arg(2).as_i64().unwrap_or(-1), Synchronization::Phase);
    Ok(silent(c, way.by_coordinates(&limits, synchronization)?, ResultForm::Old))
}

/// Returns argument `i` as limits of `n` coordinates, which must be above 0.
fn required_limits(c: &Ctx<'_>, i: usize, n: usize) -> Result<Vec<f64>> {
    let all = numbers_or_repeated(c.arg(i), n);
    if all.len() < n || !all.iter().take(n).all(|x| *x > 0.0) {
        return Err(Fail::argument(format!("argument {}: expected {n} limits above 0", i + 1)));
    }
    Ok(all)
}

/// Returns argument `i` as a velocity, which must be above 0.
fn velocity(c: &Ctx<'_>, i: usize) -> Result<f64> {
    let v = c.f64(i)?;
    if v > 0.0 {
        Ok(v)
    } else {
        Err(Fail::argument(format!("argument {}: expected a velocity above 0, found {v}", i + 1)))
    }
}

/// Returns limits of velocity and acceleration that are equal for the four coordinates of a pose, and no jerk limit.
fn equal_limits(v: f64, a: f64) -> LimitLists {
    LimitLists::symmetric(vec![v; 4], vec![if a > 0.0 { a } else { 0.0 }; 4], Vec::new())
}

pub(super) fn to_position(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let way = way(c, c.arg(1).as_i64().is_none(), |mut at: Pose| {
        if c.has(2) {
            at[..3].copy_from_slice(&numbers::<3>(c, 2)?);
        }
        if c.has(3) {
            at[3..].copy_from_slice(&al::from_euler(numbers(c, 3)?));
        }
        Ok(at)
    })?;
    let accel = if c.has(5) { c.f64(5)? } else { 0.0 };
    let limits = equal_limits(velocity(c, 4)?, accel);
    Ok(silent(c, way.by_coordinates(&limits, Synchronization::Phase)?, ResultForm::Left))
}

pub(super) fn to_object(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let (object, target, what) = (existing_object(c, 0)?.id, existing_object(c, 1)?.id, int_or(c, 2, 3)?);
    let from = c.world().pose(object, 0)?;
    let goal = c.world().pose(target, 0)?;
    let p = if what & 1 != 0 { al::position(&goal) } else { al::position(&from) };
    let q = if what & 2 != 0 { al::rotation(&goal) } else { al::rotation(&from) };
    let way = Way { object, frame: 0, from, to: al::pose(p, q) };
    // The velocity is a fraction of the motion per second.
    let v = if c.has(4) { c.f64(4)?.abs().max(1e-6) } else { 1.0 };
    let accel = if c.has(5) { c.f64(5)?.max(0.0) } else { 0.0 };
    let length = al::length(al::sub(p, al::position(&from))).max(1e-9);
    let angle = way.angle().max(1e-9);
    let by = |x: f64| vec![length * x, length * x, length * x, angle * x];
    let limits = LimitLists::symmetric(by(v), by(accel), Vec::new());
    Ok(silent(c, way.by_coordinates(&limits, Synchronization::Phase)?, ResultForm::Left))
}

pub(super) fn to_joints(c: &Ctx<'_>) -> Result<ActiveMotion> {
    let joints = joints_of(c, c.arg(0))?;
    let (start, n) = (positions(c, &joints)?, joints.len());
    let list = |i: usize| numbers_or_repeated(c.arg(i), n);
    let target = list(1);
    if target.len() < n {
        return Err(Fail::argument(format!(
            "argument 2: expected {n} positions, one for each joint, but got {}",
            target.len()
        )));
    }
    let limits = LimitLists::symmetric(required_limits(c, 2, n)?, list(3), Vec::new());
    let targets = states(n, [&target, &[], &[]]);
    let profile = MotionProfile::to(&states(n, [&start, &[], &[]]), &targets, &limits, Synchronization::Phase)?;
    Ok(silent(c, (profile, MovedObjects::Joints(joints)), ResultForm::Left))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cyclic_joints_turn_the_shorter_way_or_the_given_one() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(cyclic_target(3.0, -3.0, 0.0), 2.0 * PI - 3.0);
        close(cyclic_target(0.0, 1.0, 1.0), 1.0);
        close(cyclic_target(0.0, 1.0, -1.0), 1.0 - 2.0 * PI);
        close(cyclic_target(0.0, 1.0, 3.0), 1.0 + 4.0 * PI);
        close(cyclic_target(0.0, 1.0, -2.0), 1.0 - 4.0 * PI);
    }
}
