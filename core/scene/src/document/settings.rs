//! Settings of a world, and the keys of `[scene]` that set them.

use std::{
    collections::BTreeMap,
    f64::consts::{FRAC_PI_2, PI},
};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use tatu_errors::{Error, Result};
use tatu_physics::{EngineSettings, FrictionRule};
use tatu_plugin_api::safe::Value;
use tatu_plugins::ParameterSpec;

use crate::{
    object::JointSolver,
    property::{PropertySpec, StoredValue, numbers_of, properties, text_of, unexpected},
};

/// Friction rules, as written in scene files.
const FRICTION_RULES: [(&str, FrictionRule); 4] = [
    ("product", FrictionRule::Product),
    ("mean", FrictionRule::Mean),
    ("least", FrictionRule::Least),
    ("greatest", FrictionRule::Greatest),
];

/// Friction and restitution of a pair of materials in contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrictionPair {
    /// Names of the materials, in any order.
    pub materials: [String; 2],
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Restitution coefficient, 0 to 1; if `None`, it is computed from the coefficients of the shapes.
    pub restitution: Option<f64>,
}

impl FrictionPair {
    /// Returns the pair as a list value.
    pub fn to_value(&self) -> Value {
        let [a, b] = &self.materials;
        let mut items = vec![Value::text(a), Value::text(b), Value::Float(self.friction)];
        items.extend(self.restitution.map(Value::Float));
        Value::List(items)
    }
    /// Parses the form used in scene files: `["rubber", "ice", 0.1]`, optionally followed by a restitution.
    fn parse(value: &Value) -> Option<Self> {
        let number = |v: &Value| match v {
            Value::Float(x) => Some(*x),
            Value::Int(i) => Some(*i as f64),
            _ => None,
        };
        let Value::List(items) = value else { return None };
        let (a, b, friction, restitution) = match items.as_slice() {
            [Value::Text(a), Value::Text(b), friction] => (a, b, number(friction)?, None),
            [Value::Text(a), Value::Text(b), friction, rest] => (a, b, number(friction)?, Some(number(rest)?)),
            _ => return None,
        };
        let holds = friction >= 0.0 && restitution.is_none_or(|r| (0.0..=1.0).contains(&r));
        let materials = [a, b].map(|t| String::from_utf8_lossy(t).into_owned());
        holds.then_some(FrictionPair { materials, friction, restitution })
    }
}

/// What `friction_pairs` must contain, for messages.
const FRICTION_PAIRS_FORM: &str = "expected, for each pair, two materials, a friction coefficient, and optionally a restitution \
                     coefficient, for instance `friction_pairs = [[\"rubber\", \"ice\", 0.1]]`";

/// Settings of a world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorldSettings {
    /// Length of a step, s.
    pub dt: f64,
    /// Maximum length of a physics step, s. Each step is divided evenly.
    pub physics_dt: f64,
    /// Number of sub-steps of a physics step in which velocities are solved.
    pub physics_substeps: u32,
    /// Whether bodies at rest can sleep.
    pub sleep: bool,
    /// The rule that combines the friction of two shapes.
    pub friction_rule: FrictionRule,
    /// The solver of mechanisms whose own solver is [`JointSolver::Auto`].
    pub joint_solver: JointSolver,
    /// Friction and restitution by pairs of materials.
    pub friction_pairs: Vec<FrictionPair>,
    /// Messages about unsupported parts of the scene's source files, which each run reports.
    pub lacks: Vec<String>,
    /// Natural frequency (Hz) and damping ratio of contacts; if `None`, contacts are as stiff as the length of a
    /// sub-step permits.
    pub contact_spring: Option<[f64; 2]>,
    /// Gravity, m/s^2.
    pub gravity: Vector3<f64>,
    /// Location of the world's origin on Earth: latitude and longitude in rad (WGS 84), height above the ellipsoid in
    /// m. There, the world's x axis points east and its y axis north.
    pub origin: [f64; 3],
    /// Seed of all random numbers of the world.
    pub seed: u64,
    /// Simulated time after which a run ends if no length is given, s; 0 if the scene does not state it.
    pub duration: f64,
    /// Default dialect of scripts; if empty, inferred from their source.
    pub dialect: String,
    /// Ids of the chosen providers, by schema, language or id of what they provide.
    pub providers: BTreeMap<String, String>,
    /// Maximum number of instructions in one call of a script.
    pub budget: u64,
    /// Maximum memory of the state of a script, bytes.
    pub memory: u64,
    /// Permissions of scripts to access resources outside the run: "exec" (other programs), "native" (libraries),
    /// "net=HOST:PORT" (sockets).
    pub allow: Vec<String>,
}

impl Default for WorldSettings {
    fn default() -> Self {
        WorldSettings {
            dt: 0.05,
            physics_dt: 0.005,
            physics_substeps: EngineSettings::default().substeps,
            sleep: true,
            friction_rule: FrictionRule::Product,
            joint_solver: JointSolver::Auto,
            friction_pairs: Vec::new(),
            lacks: Vec::new(),
            contact_spring: None,
            gravity: Vector3::new(0.0, 0.0, -9.81),
            origin: [0.0; 3],
            seed: 0,
            duration: 0.0,
            dialect: String::new(),
            providers: BTreeMap::new(),
            budget: 50_000_000,
            memory: 256 << 20,
            allow: Vec::new(),
        }
    }
}

/// Maximum length of a step, s.
pub const MAX_STEP_S: f64 = 100.0;

/// Maximum number of physics steps in a step: more would take minutes and could not be interrupted.
const MAX_PHYSICS_STEPS: f64 = 100_000.0;

impl WorldSettings {
    /// Checks constraints between several settings.
    pub(super) fn check(&self) -> Result {
        let steps = (self.dt / self.physics_dt).ceil();
        if steps <= MAX_PHYSICS_STEPS {
            return Ok(());
        }
        let text = format!("a step of {} s would have {steps} physics steps of {} s", self.dt, self.physics_dt);
        Err(Error::new("E102", text)
            .expected(format!("at most {MAX_PHYSICS_STEPS}"))
            .help("reduce `dt_s` or increase `physics_dt_s`"))
    }
}

/// Names of the tables in `[scene]` that contain settings.
pub(super) const TABLES: &[&str] = &["budget", "origin"];

/// Keys of `[scene]`, in the order in which they are written. Keys of its tables are prefixed with the table's name.
const KEYS: &[&str] = &[
    "dt",
    "physics_dt",
    "physics_substeps",
    "sleep",
    "friction_rule",
    "joint_solver",
    "friction_pairs",
    "lacks",
    "gravity",
    "origin.lat",
    "origin.lon",
    "origin.alt",
    "seed",
    "duration",
    "dialect",
    "budget.instructions",
    "budget.memory_mb",
    "contact_spring",
    "script_budget",
    "text",
    "plugins",
    "needs",
];

/// Returns the declarations of the keys of `[scene]` except `data`.
fn key_specs() -> impl Iterator<Item = (&'static str, &'static PropertySpec)> {
    let all = || PROPERTIES.iter().map(|row| (row.short_key(), row)).chain(IN_FILES.iter().map(|row| (row.key, row)));
    KEYS.iter().filter_map(move |key| all().find(|(k, _)| k == key))
}

/// Returns the keys of `[scene]` that set a property of the world, as scene files write them.
#[cfg(test)]
pub(crate) fn written_keys(property: &str) -> Vec<String> {
    let own = key_specs()
        .filter(|(key, _)| *key == property || key.strip_prefix(property).is_some_and(|k| k.starts_with('.')));
    let written = own.map(|(key, row)| format!("`{}`", tatu_plugins::units::key_with_unit(key, row.unit)));
    written.chain((property == "data").then(|| "`data`".to_owned())).collect()
}

/// Returns the declarations of the keys of `[scene]` except `data`.
pub(super) fn keys() -> Vec<(ParameterSpec, ())> {
    key_specs().map(|(key, row)| (ParameterSpec { key: key.to_owned(), flags: 0, ..row.as_parameter() }, ())).collect()
}

/// Returns the keys of `[scene]` whose values are stored in [`WorldSettings`], with their units and current values. The
/// key `contact_spring` is included only if it is set.
pub(super) fn values(settings: &WorldSettings) -> Vec<(&'static str, Option<&'static str>, Value)> {
    let value = |row: &PropertySpec| (row.access.get)(settings).filter(|v| *v != Value::Floats(Vec::new()));
    key_specs().filter_map(|(key, row)| Some((key, row.unit, value(row)?))).collect()
}

/// Applies a setting whose value has been checked against its declaration.
pub(super) fn apply(settings: &mut WorldSettings, key: &str, value: &Value) -> Result {
    let Some((_, row)) = key_specs().find(|(k, _)| *k == key) else { return Ok(()) };
    match (row.access.set)(settings, value) {
        Some(Err(text)) => Err(Error::new("E102", format!("`{key}`: {text}"))),
        _ => Ok(()),
    }
}

fn rule_name(rule: FrictionRule) -> &'static str {
    FRICTION_RULES.iter().find(|(_, r)| *r == rule).map_or("product", |(name, _)| name)
}

fn set_rule(s: &mut WorldSettings, value: &Value) -> Result<bool, String> {
    let name = text_of(value)?;
    let found = FRICTION_RULES.iter().find(|(n, _)| *n == name);
    s.friction_rule = found.map_or(FrictionRule::Product, |(_, rule)| *rule);
    Ok(true)
}

fn set_pairs(s: &mut WorldSettings, value: &Value) -> Result<bool, String> {
    let Value::List(pairs) = value else { return unexpected(value) };
    s.friction_pairs = pairs.iter().map(FrictionPair::parse).collect::<Option<_>>().ok_or(FRICTION_PAIRS_FORM)?;
    Ok(true)
}

fn set_lacks(s: &mut WorldSettings, value: &Value) -> Result<bool, String> {
    let Value::List(all) = value else { return unexpected(value) };
    s.lacks = all
        .iter()
        .map(text_of)
        .collect::<Result<_, _>>()
        .map_err(|found| format!("expected a list of strings, {found} in it"))?;
    Ok(true)
}

// The keys of `[scene]` that are not properties of the running world.
properties! { IN_FILES: WorldSettings, PropertyOwner::World =>
    "text" text, None _: "Text for people.";
    "duration" number in "s" from 0.0 to 1e9 = 0.0, None duration: "Simulated time after which a run or test ends if no length is given; 0: 10 s.";
    "dialect" text, None dialect: "Dialect of scripts.";
    "lacks" list, None { get |s: &WorldSettings| Value::List(s.lacks.iter().map(Value::text).collect()), set set_lacks }: "Parts of the scene's source that are not supported.";
    "plugins" list, None _: "Folders with plugins.";
    "needs" list, None _: "Plugins that the scene needs.";
    "script_budget" int from 1.0, None { set |s: &mut WorldSettings, v| s.budget.store(v) }: "Maximum number of instructions in one call of a script.";
    "origin.lat" number in "rad" from (-FRAC_PI_2) to FRAC_PI_2, None (origin[0]): "Latitude of the world's origin.";
    "origin.lon" number in "rad" from (-PI) to PI, None (origin[1]): "Longitude of the world's origin.";
    "origin.alt" number in "m" from (-1e7) to 1e8, None (origin[2]): "Height of the world's origin.";
    "budget.instructions" int from 1.0, None budget: "Maximum number of instructions in one call of a script.";
    "budget.memory_mb" int from 1.0 to 256.0, None { get |s: &WorldSettings| Value::Int((s.memory >> 20) as i64), set |s: &mut WorldSettings, v| { s.memory.store(v)?; s.memory <<= 20; Ok(true) } }: "Maximum memory of the state of a script, MB.";
}

properties! { PROPERTIES: WorldSettings, PropertyOwner::World =>
    "scene.time" number in "s", ReadOnly _: "Simulation time.";
    "scene.dt" number in "s" from 1e-6 to MAX_STEP_S = 0.05, ReadOnly dt: "Length of a step.";
    "scene.physics_dt" number in "s" from 1e-6 to MAX_STEP_S = 0.005, ReadOnly physics_dt: "Maximum length of a physics step; a step is divided evenly.";
    "scene.physics_substeps" int from 1.0 to 64.0 = 4, ReadOnly physics_substeps: "Sub-steps of a physics step in which velocities are solved.";
    "scene.sleep" bool = true, ReadOnly sleep: "Whether bodies at rest can sleep until they are touched.";
    "scene.friction_rule" text of (&["product", "mean", "least", "greatest"]) = "product", ReadOnly { get |s: &WorldSettings| Value::text(rule_name(s.friction_rule)), set set_rule }: "How the friction of a pair is computed from both shapes' coefficients: their product, mean, or the least or greatest of the two.";
    "scene.joint_solver" text of (&["auto", "reduced"]) = "auto", ReadOnly joint_solver: "The solver of mechanisms whose own `joint_solver` is `auto`: with `reduced`, those that `auto` would solve as trees of links use reduced form.";
    "scene.friction_pairs" list = none, ReadOnly { get |s: &WorldSettings| Value::List(s.friction_pairs.iter().map(FrictionPair::to_value).collect()), set set_pairs }: "Friction by material, in place of the shapes' own: lists of two materials, friction, and optionally restitution.";
    "scene.contact_spring" numbers 2 from 1e-3 to 1e6, ReadOnly { get |s: &WorldSettings| Value::Floats(s.contact_spring.map_or(Vec::new(), |v| v.to_vec())), set |s: &mut WorldSettings, v| { s.contact_spring = numbers_of(v)?.try_into().ok(); Ok(true) } }: "Natural frequency, Hz, and damping ratio of contacts, at most what a sub-step can resolve (0.15 of its rate, 0.3 with objects that do not move); default 120 Hz (240 Hz) and 5.";
    "scene.step" int, ReadOnly _: "Index of the step, from 0.";
    "scene.gravity" numbers 3 in "m/s^2" from (-1e6) to 1e6 = [0.0, 0.0, -9.81], None gravity: "Gravity.";
    "scene.origin" numbers 3 = [0.0, 0.0, 0.0], ReadOnly origin: "Position of the world's origin on Earth: latitude and longitude in rad (WGS 84), height above the ellipsoid in m; x points east, y north.";
    "scene.seed" int from 0.0 = 0, ReadOnly seed: "The seed of all random numbers.";
    "scene.allow" text, ReadOnly { get |s: &WorldSettings| Value::text(s.allow.join(",")) }: "What scripts may access outside the run, separated by commas: `exec` other programs, `native` libraries, `net=HOST:PORT` sockets; a `*` means any host or port.";
    "scene.file" text, ReadOnly _: "The file of the scene.";
    "scene.notes" list, ReadOnly _: "Notes about the reading of the scene, such as parts that an importer left out: a list of strings.";
    "scene.data" data = none, None _: "Custom data of the world: strings by tag, as in `object.data`.";
    "scene.running" bool, ReadOnly _: "Whether the world has been started.";
    "scene.clock" number in "s", ReadOnly _: "Time that clocks show, from the start: simulation time, or in a real-time run the real time up to this step.";
    "scene.epoch" int in "s", ReadOnly _: "Date of the start, in seconds since the beginning of 1970: the first second of 2015, or in a real-time run the real date.";
    "scene.stopping" bool, ReadOnly _: "Whether the run is in one of its last two passes.";
    "scene.phase" int, ReadOnly _: "0 stopped, 1 first pass, 2 running, 3 last before a pause, 4 paused, 5 first after a pause, 6 stopping, 7 last pass.";
}
