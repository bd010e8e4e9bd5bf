//! Settings of a world, and the keys of `[scene]` that set them.

use std::{
    collections::BTreeMap,
    f64::consts::{FRAC_PI_2, PI},
};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use tatu_errors::{Error, Result};
use tatu_physics::{EngineSettings, FrictionRule};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::Declared;

use crate::object::JointSolver;

/// Friction rules, as written in scene files.
pub const FRICTION_RULES: [(&str, FrictionRule); 4] = [
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
    fn parse(value: &Value) -> Result<Self> {
        let wrong = || {
            Error::new("E102", "`friction_pairs`: an entry is not a pair of materials")
                .expected("two materials, a friction coefficient, and optionally a restitution coefficient")
                .help("for instance `friction_pairs = [[\"rubber\", \"ice\", 0.1]]`")
        };
        let number = |v: Option<&Value>| match v {
            Some(Value::Float(x)) => Some(*x),
            Some(Value::Int(i)) => Some(*i as f64),
            _ => None,
        };
        let Value::List(items) = value else { return Err(wrong()) };
        let ([Value::Text(a), Value::Text(b)], rest) = items.split_at_checked(2).ok_or_else(wrong)? else {
            return Err(wrong());
        };
        let friction = number(rest.first()).filter(|f| *f >= 0.0).ok_or_else(wrong)?;
        let restitution = number(rest.get(1));
        if rest.len() > 2 || rest.len() == 2 && !restitution.is_some_and(|r| (0.0..=1.0).contains(&r)) {
            return Err(wrong());
        }
        let materials = [a, b].map(|t| String::from_utf8_lossy(t).into_owned());
        Ok(FrictionPair { materials, friction, restitution })
    }
}

/// Settings of a world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
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

impl Default for Settings {
    fn default() -> Self {
        Settings {
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
            dialect: String::new(),
            providers: BTreeMap::new(),
            budget: 50_000_000,
            memory: 256 << 20,
            allow: Vec::new(),
        }
    }
}

/// Maximum length of a step, s.
pub const LONGEST: f64 = 100.0;

/// Maximum number of physics steps in a step: more would take minutes and could not be interrupted.
const MOST_PHYSICS_STEPS: f64 = 100_000.0;

impl Settings {
    /// Checks constraints between several settings.
    pub(super) fn check(&self) -> Result {
        let steps = (self.dt / self.physics_dt).ceil();
        if steps <= MOST_PHYSICS_STEPS {
            return Ok(());
        }
        let text = format!("a step of {} s would have {steps} physics steps of {} s", self.dt, self.physics_dt);
        Err(Error::new("E102", text)
            .expected(format!("at most {MOST_PHYSICS_STEPS}"))
            .help("reduce `dt_s` or increase `physics_dt_s`"))
    }
}

/// Names of the tables in `[scene]` that contain settings.
pub(super) const TABLES: &[&str] = &["budget", "origin"];

/// Returns the declarations of the keys of `[scene]` except `data`. Keys of its tables are prefixed with the table's
/// name.
pub(super) fn keys() -> Vec<(Declared, ())> {
    let of = |key: &str, kind, unit: Option<&str>, lowest: f64, count| Declared {
        key: key.to_owned(),
        kind,
        count,
        flags: 0,
        unit: unit.map(str::to_owned),
        lowest,
        highest: f64::INFINITY,
        fallback: Value::Nil,
        unreadable_default: false,
        choices: Vec::new(),
        keys: Vec::new(),
        keys_cut: false,
        text: String::new(),
    };
    let any = f64::NEG_INFINITY;
    [
        of("text", TATU_TEXT, None, any, 0),
        of("dialect", TATU_TEXT, None, any, 0),
        Declared { highest: LONGEST, ..of("dt", TATU_F64, Some("s"), 1e-6, 0) },
        Declared { highest: LONGEST, ..of("physics_dt", TATU_F64, Some("s"), 1e-6, 0) },
        Declared { highest: 64.0, ..of("physics_substeps", TATU_I64, None, 1.0, 0) },
        of("sleep", TATU_BOOL, None, any, 0),
        Declared {
            choices: FRICTION_RULES.iter().map(|(name, _)| (*name).to_owned()).collect(),
            keys: Vec::new(),
            keys_cut: false,
            ..of("friction_rule", TATU_TEXT, None, any, 0)
        },
        Declared {
            choices: [JointSolver::Auto, JointSolver::Reduced].map(|s| s.name().to_owned()).to_vec(),
            ..of("joint_solver", TATU_TEXT, None, any, 0)
        },
        of("friction_pairs", TATU_LIST, None, any, 0),
        of("lacks", TATU_LIST, None, any, 0),
        Declared { highest: 1e6, ..of("contact_spring", TATU_F64S, None, 1e-3, 2) },
        Declared { highest: 1e6, ..of("gravity", TATU_F64S, Some("m/s^2"), -1e6, 3) },
        of("seed", TATU_I64, None, 0.0, 0),
        of("plugins", TATU_LIST, None, any, 0),
        of("needs", TATU_LIST, None, any, 0),
        of("script_budget", TATU_I64, None, 1.0, 0),
        Declared { highest: FRAC_PI_2, ..of("origin.lat", TATU_F64, Some("rad"), -FRAC_PI_2, 0) },
        Declared { highest: PI, ..of("origin.lon", TATU_F64, Some("rad"), -PI, 0) },
        Declared { highest: 1e8, ..of("origin.alt", TATU_F64, Some("m"), -1e7, 0) },
        of("budget.instructions", TATU_I64, None, 1.0, 0),
        Declared { highest: 256.0, ..of("budget.memory_mb", TATU_I64, None, 1.0, 0) },
    ]
    .into_iter()
    .map(|d| (d, ()))
    .collect()
}

/// Returns the keys of `[scene]` whose values are stored in [`Settings`], with their current values. The key
/// `contact_spring` is included only if it is set.
pub(super) fn values(settings: &Settings) -> Vec<(&'static str, Value)> {
    let rule = FRICTION_RULES.iter().find(|(_, r)| *r == settings.friction_rule).map_or("product", |(name, _)| name);
    let mut all = vec![
        ("dt", Value::Float(settings.dt)),
        ("physics_dt", Value::Float(settings.physics_dt)),
        ("physics_substeps", Value::Int(settings.physics_substeps.into())),
        ("sleep", Value::Bool(settings.sleep)),
        ("friction_rule", Value::text(rule)),
        ("joint_solver", Value::text(settings.joint_solver.name())),
        ("friction_pairs", Value::List(settings.friction_pairs.iter().map(FrictionPair::to_value).collect())),
        ("lacks", Value::List(settings.lacks.iter().map(Value::text).collect())),
        ("gravity", Value::Floats(settings.gravity.iter().copied().collect())),
        ("origin.lat", Value::Float(settings.origin[0])),
        ("origin.lon", Value::Float(settings.origin[1])),
        ("origin.alt", Value::Float(settings.origin[2])),
        ("seed", Value::Int(settings.seed as i64)),
        ("dialect", Value::text(&settings.dialect)),
        ("budget.instructions", Value::Int(settings.budget as i64)),
        ("budget.memory_mb", Value::Int((settings.memory >> 20) as i64)),
    ];
    all.extend(settings.contact_spring.map(|s| ("contact_spring", Value::Floats(s.to_vec()))));
    all
}

/// Applies a setting whose value has been checked against its declaration.
pub(super) fn apply(settings: &mut Settings, key: &str, value: &Value) -> Result {
    match (key, value) {
        ("dialect", Value::Text(t)) => settings.dialect = String::from_utf8_lossy(t).into_owned(),
        ("dt", Value::Float(x)) => settings.dt = *x,
        ("physics_dt", Value::Float(x)) => settings.physics_dt = *x,
        ("sleep", Value::Bool(b)) => settings.sleep = *b,
        ("friction_rule", Value::Text(t)) => {
            let found = FRICTION_RULES.iter().find(|(name, _)| name.as_bytes() == t.as_slice());
            settings.friction_rule = found.map_or(FrictionRule::Product, |(_, rule)| *rule);
        }
        ("joint_solver", Value::Text(t)) => settings.joint_solver = JointSolver::parse(&String::from_utf8_lossy(t)),
        ("contact_spring", Value::Floats(v)) => settings.contact_spring = Some([v[0], v[1]]),
        ("friction_pairs", Value::List(pairs)) => {
            settings.friction_pairs = pairs.iter().map(FrictionPair::parse).collect::<Result<_>>()?;
        }
        ("lacks", Value::List(all)) => {
            let text = |v: &Value| match v {
                Value::Text(t) => Ok(String::from_utf8_lossy(t).into_owned()),
                _ => Err(Error::new("E102", "`lacks`: an entry is not a string").expected("a list of strings")),
            };
            settings.lacks = all.iter().map(text).collect::<Result<_>>()?;
        }
        ("physics_substeps", Value::Int(i)) => settings.physics_substeps = *i as u32,
        ("gravity", Value::Floats(v)) => settings.gravity = Vector3::new(v[0], v[1], v[2]),
        ("origin.lat", Value::Float(x)) => settings.origin[0] = *x,
        ("origin.lon", Value::Float(x)) => settings.origin[1] = *x,
        ("origin.alt", Value::Float(x)) => settings.origin[2] = *x,
        ("seed", Value::Int(i)) => settings.seed = *i as u64,
        ("script_budget" | "budget.instructions", Value::Int(i)) => settings.budget = *i as u64,
        ("budget.memory_mb", Value::Int(i)) => settings.memory = (*i as u64) << 20,
        _ => {}
    }
    Ok(())
}
