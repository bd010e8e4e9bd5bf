//! The plugin type, and what all commands need: the mechanism of a call, and arrays of numbers.

use tatu_kinematics_common::SceneProps;
use tatu_mechanisms::{Dynamics, Tree, TreeState};
use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Call, Command, Fail, Host, Param, Result, Value, ValueRef},
};

use crate::{
    mechanism::{Mechanism, MechanismProps},
    state,
};

/// Most velocities of a mechanism whose matrices are returned: 8 MB for each million elements.
const MAX_MATRIX_VELOCITIES: usize = 200;

/// The plugin; it has no state.
pub struct Kin {
    pub props: MechanismProps,
    pub scene: SceneProps,
}

impl Kin {
    pub fn new(host: &Host) -> Self {
        Kin { props: MechanismProps::new(host), scene: SceneProps::new(host) }
    }
}

/// A call of one of this plugin's commands.
pub type Ctx<'a> = Call<'a, Kin>;
/// A command of this plugin.
pub type Cmd = Command<Kin>;

/// The mechanism of a call, with the state for which it is computed.
pub struct CallMechanism {
    pub mechanism: Mechanism,
    pub tree: Tree,
    pub state: TreeState,
    /// The links whose joints move no mass: see [`Mechanism::tree`].
    pub massless: Vec<usize>,
}

impl CallMechanism {
    /// Reads the mechanism below the object in argument 1, in its present state.
    pub fn read(c: &Ctx<'_>) -> Result<Self> {
        let (world, p) = (c.world(), &c.plugin().props);
        let model = object(c, 0)?;
        let mechanism = Mechanism::read(&world, p, model)?;
        let (tree, massless) = mechanism.tree()?;
        let state = state::read(&world, p, &mechanism, &tree)?;
        Ok(CallMechanism { mechanism, tree, state, massless })
    }

    /// Sets the positions to those in argument `i`, if it was passed.
    pub fn take_q(&mut self, c: &Ctx<'_>, i: usize) -> Result {
        if let Some(q) = numbers(c.arg(i), &format!("argument {}: `q`", i + 1), self.tree.positions(), POSITIONS)? {
            self.set_q(q, &format!("argument {}: `q`", i + 1))?;
        }
        Ok(())
    }
    /// Sets the velocities to those in argument `i`, if it was passed.
    pub fn take_qd(&mut self, c: &Ctx<'_>, i: usize) -> Result {
        if let Some(v) = self.velocities(c, i, "qd")? {
            self.state.v = v;
        }
        Ok(())
    }
    /// Sets the positions to those of a script.
    pub fn set_q(&mut self, mut q: Vec<f64>, what: &str) -> Result {
        state::convert(&self.mechanism, &self.tree, &mut q, false);
        for (i, link) in self.mechanism.links.iter().enumerate() {
            let n = link.joint.positions();
            if let (4 | 7, Some((first, _))) = (n, self.tree.offsets(i)) {
                let quaternion = &mut q[first + n - 4..first + n];
                let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
                if !(0.9..1.1).contains(&norm) {
                    return Err(Fail::argument(format!(
                        "{what}: numbers {} to {} must be a unit quaternion x y z w, but have the length {norm}",
                        first + n - 3,
                        first + n
                    )));
                }
                quaternion.iter_mut().for_each(|x| *x /= norm);
            }
        }
        self.state.q = q;
        Ok(())
    }
    /// Returns the numbers in argument `i`, one for each velocity, if it was passed.
    pub fn velocities(&self, c: &Ctx<'_>, i: usize, name: &str) -> Result<Option<Vec<f64>>> {
        numbers(c.arg(i), &format!("argument {}: `{name}`", i + 1), self.tree.velocities(), VELOCITIES)
    }
    /// Returns the dynamics at the state.
    pub fn dynamics(&self) -> Result<Dynamics> {
        let mut dynamics = Dynamics::new(&self.tree);
        dynamics.update(&self.tree, &self.state).map_err(wrong)?;
        Ok(dynamics)
    }
    /// Returns the velocities of the joints that move no mass, whose armature of 1 must be subtracted.
    pub fn massless_velocities(&self) -> Vec<usize> {
        let range = |link: &usize| {
            let first = self.tree.offsets(*link).map_or(0, |(_, v)| v);
            first..first + self.mechanism.links[*link].joint.velocities()
        };
        self.massless.iter().flat_map(range).collect()
    }
    /// Returns an error if the mechanism is too large for a matrix with a row and a column for each velocity.
    pub fn refuse_large(&self) -> Result {
        match self.tree.velocities() {
            n if n > MAX_MATRIX_VELOCITIES => Err(Fail::unsupported(format!(
                "the mechanism has {n} velocities; a matrix is returned for at most {MAX_MATRIX_VELOCITIES}"
            ))
            .help("pass an object with fewer joints below it")),
            _ => Ok(()),
        }
    }
    /// Returns an error if a joint moves no mass.
    pub fn refuse_massless(&self, c: &Ctx<'_>) -> Result {
        self.mechanism.refuse_massless(&c.world(), &c.plugin().props, &self.massless)
    }
    /// Returns the positions in the layout of scripts.
    pub fn q(&self) -> Vec<f64> {
        let mut q = self.state.q.clone();
        state::convert(&self.mechanism, &self.tree, &mut q, true);
        q
    }
}

/// What arrays of positions and velocities contain, for messages.
const POSITIONS: &str = "one for each joint, 4 for a spherical one and 7 for a base that is not fixed";
const VELOCITIES: &str = "one for each joint, 3 for a spherical one and 6 for a base that is not fixed";

/// Converts an error of the dynamics to one of a command.
pub fn wrong(error: tatu_mechanisms::DynamicsError) -> Fail {
    Fail::argument(error.to_string())
}

/// Returns `n` finite numbers, or `None` for nil.
pub fn numbers(value: ValueRef<'_>, what: &str, n: usize, contents: &str) -> Result<Option<Vec<f64>>> {
    if value.is_nil() {
        return Ok(None);
    }
    let found = value.numbers().ok_or_else(|| Fail::argument(format!("{what}: expected a list of {n} numbers")))?;
    if found.len() != n {
        let text = format!("{what} has {} numbers; this mechanism needs {n}: {contents}", found.len());
        return Err(Fail::argument(text).help("`tatu.kin.joints` lists the joints in the order of the numbers"));
    }
    match found.iter().position(|x| !x.is_finite()) {
        Some(k) => Err(Fail::argument(format!("{what}: number {} is {}; expected a finite number", k + 1, found[k]))),
        None => Ok(Some(found)),
    }
}

/// Returns the object whose handle is argument `i`.
pub fn object(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    let number = c.i64(i)?;
    let handle = u64::try_from(number).map_err(|_| Fail::missing(format!("there is no object {number}")))?;
    Ok(c.world().look(handle)?.id)
}

/// Returns the gravity of the scene, m/s².
pub fn gravity(c: &Ctx<'_>) -> Result<nalgebra::Vector3<f64>> {
    Ok(c.world().f64s::<3>(0, c.plugin().props.gravity)?.into())
}

/// Returns a matrix as a list of rows.
pub fn rows(numbers: &[f64], columns: usize) -> Value {
    if columns == 0 {
        return Value::List(Vec::new());
    }
    Value::List(numbers.chunks(columns).map(|row| Value::Floats(row.to_vec())).collect())
}

/// Parameters that several commands share.
/// Returns an error if a map of options has a key that is not one of `known`; `argument` is its number for messages.
pub fn check_options(options: ValueRef<'_>, argument: usize, known: &[&str]) -> Result {
    for [key, _] in options.map().unwrap_or_default() {
        let key = key.as_str().unwrap_or_default();
        if !known.contains(&key.as_ref()) {
            return Err(Fail::argument(format!(
                "argument {argument}: there is no option `{key}`: expected one of {}",
                known.join(", ")
            )));
        }
    }
    Ok(())
}

pub fn model() -> Param {
    Param::int("model").text("the handle of an object above all joints of the mechanism, such as a model's base")
}
pub fn q() -> Param {
    Param::floats("q", 0).optional().text("rad or m: positions, in the order of `tatu.kin.joints`; omitted: present")
}
pub fn qd() -> Param {
    Param::floats("qd", 0).optional().text("rad/s or m/s: velocities; omitted: present")
}
