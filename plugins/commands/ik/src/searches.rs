//! Commands that search for configurations and paths. They change neither the environment nor the scene.

use nalgebra::Isometry3;
use tatu_kinematics::{FrameId, IkTask, JointType, Linkage, SearchSettings, find_configuration, random_configuration};
use tatu_plugin_api::safe::{Fail, Offer, Param, Result, Value, ValueRef};

use crate::{
    arguments::{frame, joints},
    environment::{Ctx, Ik, environment},
    groups::group_command,
};

/// Number of attempts per second of the time that a script allows. A search counts attempts instead of measuring time,
/// so that its results are the same in every run.
const ATTEMPTS_PER_S: f64 = 200.0;
const MIN_ATTEMPTS: u64 = 10;
const MAX_ATTEMPTS: u64 = 1000;
/// Time that a search may take if the script does not specify it, s.
const DEFAULT_TIME_S: f64 = 0.5;
/// Maximum number of configurations that `findConfigs` and `getAlternateConfigs` return.
const MAX_CONFIGURATIONS: usize = 1000;
/// Two configurations are treated as equal if no joint position differs by more than this, rad or m, because a search
/// ends anywhere within the precision of the group.
const SAME: f64 = 0.02;
/// Maximum number of points of a path.
const MAX_POINTS: i64 = 10_000;
const TURN: f64 = 2.0 * std::f64::consts::PI;

/// A search: a copy of the kinematic chain, the tasks to be solved, and the joints whose positions are returned.
struct Search {
    linkage: Linkage,
    tasks: Vec<IkTask>,
    joints: Vec<FrameId>,
    /// Seed of the random numbers of this search.
    seed: u64,
}

impl Search {
    /// Copies the group in argument 2, and the joints in argument 3.
    fn new(c: &Ctx<'_>) -> Result<Self> {
        let mut found = {
            let mut environment = environment(c)?;
            let joints = joints(c, &environment, 2)?;
            let tasks = environment.group(c.i64(1)?)?.group.tasks.clone();
            Search { linkage: environment.copy.linkage.clone(), tasks, joints, seed: 0 }
        };
        if found.tasks.iter().all(|t| !t.enabled) {
            return Err(Fail::argument("argument 2: expected a group with at least one enabled element"));
        }
        let mut state = c.instance().borrow()?;
        state.searches += 1;
        found.seed = state.searches;
        Ok(found)
    }
    fn configuration(&self, linkage: &Linkage) -> Vec<f64> {
        self.joints.iter().map(|j| linkage.position(*j)).collect()
    }
    /// Returns the configuration that attempt `n` finds. Attempt 0 starts from the present configuration, all others
    /// from random ones.
    fn attempt(&self, n: u64) -> Option<Vec<f64>> {
        let mut linkage = self.linkage.clone();
        if n > 0 {
            random_configuration(&mut linkage, &self.tasks, self.seed, n);
        }
        let settings = SearchSettings { max_restarts: 0, ..SearchSettings::default() };
        find_configuration(&mut linkage, &self.tasks, &settings).ok().map(|()| self.configuration(&linkage))
    }
}

/// A function of the script that accepts or rejects configurations, and the value passed to it as the second argument.
struct Check {
    function: CheckFunction,
    data: Value,
}
enum CheckFunction {
    None,
    Function(u64),
    Named(String),
}

impl Check {
    fn new(function: ValueRef<'_>, data: ValueRef<'_>) -> Result<Self> {
        let named = function.as_str().map(|name| name.split('@').next().unwrap_or_default().to_owned());
        let function = match (function.as_func(), named) {
            (Some(function), _) => CheckFunction::Function(function),
            (None, Some(name)) if !name.is_empty() => CheckFunction::Named(name),
            _ => CheckFunction::None,
        };
        Ok(Check { function, data: data.to_value()? })
    }
    fn accepts(&self, c: &mut Ctx<'_>, configuration: &[f64]) -> Result<bool> {
        let arguments = [Value::Floats(configuration.to_vec()), self.data.clone()];
        let results = match &self.function {
            CheckFunction::None => return Ok(true),
            CheckFunction::Function(function) => c.call_func(*function, &arguments)?,
            CheckFunction::Named(name) => c.world().call_function(c.caller_script(), name, &arguments)?,
        };
        Ok(match results.first() {
            None | Some(Value::Nil) => false,
            Some(Value::Bool(valid)) => *valid,
            Some(Value::Int(0)) => false,
            Some(_) => true,
        })
    }
}

fn attempts(time: f64) -> u64 {
    if time.is_finite() { ((time * ATTEMPTS_PER_S) as u64).clamp(MIN_ATTEMPTS, MAX_ATTEMPTS) } else { MIN_ATTEMPTS }
}

/// Returns at most `count` configurations that a search finds and the script accepts, in the order in which they are
/// found.
fn find(c: &mut Ctx<'_>, search: &Search, check: &Check, time: f64, count: usize) -> Result<Vec<Vec<f64>>> {
    let mut found: Vec<Vec<f64>> = Vec::new();
    for n in 0..attempts(time) {
        if found.len() >= count || c.world().is_interrupted() {
            break;
        }
        let Some(configuration) = search.attempt(n) else { continue };
        let is_same = |known: &Vec<f64>| known.iter().zip(&configuration).all(|(a, b)| (a - b).abs() < SAME);
        if !found.iter().any(is_same) && check.accepts(c, &configuration)? {
            found.push(configuration);
        }
    }
    Ok(found)
}

/// Returns the configurations within the joint limits that differ from `start` only by full turns of joints.
pub fn alternatives(search: &Linkage, joints: &[FrameId], start: &[f64], low: &[f64], ranges: &[f64]) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for (i, (id, position)) in joints.iter().zip(start).enumerate() {
        let joint = search.joint(*id);
        let turns = joint.is_some_and(|j| j.kind == JointType::Revolute && j.lead == 0.0);
        let limits = match (low.get(i), ranges.get(i)) {
            (Some(low), Some(range)) if *range > 0.0 => Some([*low, low + range]),
            (_, Some(range)) if *range < 0.0 => Some([position + 0.5 * range, position - 0.5 * range]),
            _ => joint.and_then(|j| j.limits),
        };
        let choices: Vec<f64> = match limits {
            Some([low, high]) if turns && high - low < 1e3 => {
                let first = ((low - position) / TURN).ceil() as i64;
                let last = ((high - position) / TURN).floor() as i64;
                (first..=last).map(|k| position + TURN * k as f64).collect()
            }
            _ => vec![*position],
        };
        all = choices
            .iter()
            .flat_map(|x| all.iter().map(move |begun| begun.iter().copied().chain([*x]).collect()))
            .take(MAX_CONFIGURATIONS)
            .collect();
    }
    all
}

pub fn offer(offer: &mut Offer<Ik>) {
    configurations(offer);
    offer.command(
        group_command("generatePath", generate_path)
            .param(Param::floats("joints", 0))
            .param(Param::int("tip"))
            .param(Param::int("points").text("at least 2"))
            .param(Param::any("callback").optional().text("returns whether a configuration is accepted"))
            .param(Param::any("data").optional())
            .returns(
                Param::floats("path", 0).text("the positions of all joints, point by point; empty after a failure"),
            )
            .text("Returns the configurations of a straight motion of the tip from its current pose to its target.")
            .notes("The command fails if a point cannot be reached within the limits, or if the callback rejects it."),
    );
    offer.command(
        crate::arguments::command("getAlternateConfigs", |c| {
            let numbers = |i: usize| c.arg(i).numbers().unwrap_or_default();
            let all = {
                let environment = environment(c)?;
                let joints = joints(c, &environment, 1)?;
                let present: Vec<f64> = joints.iter().map(|j| environment.copy.linkage.position(*j)).collect();
                alternatives(&environment.copy.linkage, &joints, &present, &numbers(2), &numbers(3))
            };
            c.ret(all.concat());
            Ok(())
        })
        .param(Param::floats("joints", 0))
        .param(Param::floats("low", 0).optional())
        .param(Param::floats("ranges", 0).optional().text("0: the joint's limits; negative: about the present position"))
        .returns(Param::floats("configurations", 0).text("one after the other, including the current one"))
        .text("Returns the configurations that equal the present one except for full turns of joints, within their limits."),
    );
}

fn configurations(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("findConfigs", |c| {
            let search = Search::new(c)?;
            let params = c.arg(3);
            let of = |key: &str| params.get(key).unwrap_or(ValueRef::NIL);
            let check = Check::new(of("cb"), of("auxData"))?;
            let time = of("maxTime").as_f64().unwrap_or(DEFAULT_TIME_S);
            let count = if of("findMultiple").truthy() { MAX_CONFIGURATIONS } else { 1 };
            let metric = of("cMetric").numbers().unwrap_or_default();
            let mut found = find(c, &search, &check, time, count)?;
            if of("findAlt").truthy() {
                let each = |q: &Vec<f64>| alternatives(&search.linkage, &search.joints, q, &[], &[]);
                found = found.iter().flat_map(each).take(MAX_CONFIGURATIONS).collect();
            }
            let present = search.configuration(&search.linkage);
            let distance = |q: &Vec<f64>| -> f64 {
                let weight = |i: usize| metric.get(i).copied().unwrap_or(1.0);
                q.iter().zip(&present).enumerate().map(|(i, (a, b))| (weight(i) * (a - b)).powi(2)).sum()
            };
            found.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
            c.ret(Value::List(found.into_iter().map(Value::Floats).collect()));
            Ok(())
        })
        .param(Param::floats("joints", 0))
        .param(Param::map("params").optional().text("`maxTime`, `findMultiple`, `findAlt`, `cMetric`, `cb`, `auxData`"))
        .param(Param::any("known").optional())
        .returns(Param::list("configurations"))
        .text("Returns configurations of joints for which the tips of a group are at their targets, within all limits: the nearest to the present one first.")
        .notes("The search is random but the same in every run: `maxTime` is converted to a number of attempts."),
    );
    for name in ["findConfig", "getConfigForTipPose"] {
        offer.command(
            group_command(name, |c| {
                let search = Search::new(c)?;
                let time = if c.has(4) { c.f64(4)? } else { DEFAULT_TIME_S };
                let check = Check::new(c.arg(6), c.arg(7))?;
                match find(c, &search, &check, time, 1)?.into_iter().next() {
                    Some(found) => c.ret(found),
                    None => c.ret(Value::Nil),
                }
                Ok(())
            })
            .param(Param::floats("joints", 0))
            .param(Param::float("threshold").default(0.1))
            .param(Param::float("time").default(DEFAULT_TIME_S))
            .param(Param::floats("metric", 0).optional())
            .param(Param::any("callback").optional().text("returns whether a configuration is accepted"))
            .param(Param::any("data").optional())
            .param(Param::any("others").rest())
            .returns(Param::floats("configuration", 0).optional())
            .text("Returns a configuration of joints for which the tips of a group are at their targets, within all limits, or nil.")
            .notes("The search is random but the same in every run: the time is converted to a number of attempts. Threshold and metric are accepted and not needed."),
        );
    }
}

fn generate_path(c: &mut Ctx<'_>) -> Result {
    let search = Search::new(c)?;
    let points = c.i64(4)?;
    if !(2..=MAX_POINTS).contains(&points) {
        return Err(Fail::argument(format!("argument 5: expected 2 to {MAX_POINTS} points, found {points}")));
    }
    let tip = frame(c, &*environment(c)?, 3)?;
    let check = Check::new(c.arg(5), c.arg(6))?;
    let mut linkage = search.linkage.clone();
    let task = search.tasks.iter().find(|t| t.tip == tip);
    let target = task
        .map(|t| t.target)
        .ok_or_else(|| Fail::argument("argument 4: expected the tip of an element of the group"))?;
    let (from, to) = (linkage.pose(tip), linkage.pose(target));
    let settings = SearchSettings { max_restarts: 0, ..SearchSettings::default() };
    let mut path = Vec::new();
    for i in 0..points {
        let t = i as f64 / (points - 1) as f64;
        linkage.set_pose(target, &between(&from, &to, t));
        let reached = find_configuration(&mut linkage, &search.tasks, &settings).is_ok();
        let configuration = search.configuration(&linkage);
        if !reached || !check.accepts(c, &configuration)? {
            c.ret(Value::Floats(Vec::new()));
            return Ok(());
        }
        path.extend(configuration);
    }
    c.ret(path);
    Ok(())
}

/// Returns the pose at a fraction `t`, 0 to 1, of a straight motion between two poses.
pub fn between(from: &Isometry3<f64>, to: &Isometry3<f64>, t: f64) -> Isometry3<f64> {
    let place = from.translation.vector.lerp(&to.translation.vector, t);
    let turned =
        from.rotation.try_slerp(&to.rotation, t, 1e-9).unwrap_or(if t < 0.5 { from.rotation } else { to.rotation });
    Isometry3::from_parts(place.into(), turned)
}
