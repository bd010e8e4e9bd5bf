//! Reads arguments.

use std::cell::RefMut;

use tatu_plugin_api::{
    abi::{TATU_KIND_JOINT, TATU_SLOT_BITS, tatu_object},
    safe::{Command, Fail, Object, Param, Result, Value, ValueRef, World},
};

use crate::state::{Callback, Ctx, Planning, Task};

/// The handles of the world and of all objects.
pub const HANDLE_WORLD: i64 = -1;
pub const HANDLE_ALL: i64 = -2;

/// Returns the version for which the calling script was written, or the newest version if there is none.
pub fn version(c: &Ctx<'_>) -> (u32, u32) {
    let text = String::from_utf8_lossy(c.caller_dialect()).into_owned();
    let mut parts = text.split('.').map(|part| part.trim().parse::<u32>().ok());
    match (parts.next().flatten(), parts.next().flatten()) {
        (Some(major), minor) => (major, minor.unwrap_or(0)),
        _ => (4, 9),
    }
}

/// Returns a handle as scripts of the caller's version expect it: a number up to 4.1, a text from 4.2.
pub fn handle_value(c: &Ctx<'_>, kind: &str, handle: i64) -> Value {
    if version(c) < (4, 2) { Value::Int(handle) } else { Value::text(format!("ompl_{kind}_{handle}")) }
}

/// Reads a handle of a task or a state space: a number, or a text that ends with it.
pub fn handle_of(value: ValueRef<'_>) -> Option<i64> {
    if let Some(text) = value.as_str() {
        return text.rsplit('_').next().and_then(|digits| digits.parse().ok());
    }
    value.as_i64()
}

/// Builds a command with its names of 4.2 and of 3.3.
pub fn named(name: &str, run: impl Fn(&mut Ctx<'_>) -> Result + Send + Sync + 'static) -> Command<Planning> {
    let on_error = match name {
        "createTask" | "createStateSpace" => vec![Value::Int(-1)],
        "compute" => vec![Value::Bool(false)],
        _ => vec![Value::Nil],
    };
    Command::new(format!("simOMPL.{name}"), run).old_name(format!("simExtOMPL_{name}"), on_error)
}

/// Builds a command whose first parameter is a task.
pub fn command(name: &str, run: impl Fn(&mut Ctx<'_>) -> Result + Send + Sync + 'static) -> Command<Planning> {
    named(name, run).param(Param::any("task"))
}

/// Borrows the task that argument 1 names.
pub fn task<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, Task>> {
    let wrong = || Fail::argument("argument 1: expected the handle of a planning task");
    let handle = handle_of(c.arg(0)).ok_or_else(wrong)?;
    let missing = || Fail::argument(format!("argument 1: there is no planning task {handle}"));
    RefMut::filter_map(c.instance().borrow()?, |s| s.tasks.get_mut(&handle)).map_err(|_| missing())
}

/// Finishes a command that only has an effect: scripts before 4.2 get 1.
pub fn done(c: &mut Ctx<'_>) -> Result {
    if version(c) < (4, 2) {
        c.ret(1_i64);
    }
    Ok(())
}

/// Returns an object by its handle.
pub fn object_by_handle(world: &World<'_>, what: &str, handle: f64) -> Result<Object> {
    let missing = || Fail::missing(format!("{what}: there is no object {handle}"));
    if !(handle >= 1.0 && handle <= TATU_SLOT_BITS as f64) {
        return Err(missing());
    }
    world.look(handle as u64).map_err(|_| missing())
}

/// Reads an object.
pub fn object(c: &Ctx<'_>, i: usize) -> Result<Object> {
    if let Some(object) = c.arg(i).as_object() {
        return c.world().look(object);
    }
    object_by_handle(&c.world(), &format!("argument {}", i + 1), c.f64(i)?)
}

/// Reads an object, or `None` for the world or a missing argument.
pub fn object_or_world(c: &Ctx<'_>, i: usize) -> Result<Option<tatu_object>> {
    let is_world = !c.has(i) || c.arg(i).as_i64() == Some(HANDLE_WORLD);
    if is_world { Ok(None) } else { object(c, i).map(|o| Some(o.id)) }
}

/// Checks that an object is a joint.
pub fn joint(what: &str, object: Object) -> Result<tatu_object> {
    if object.kind == TATU_KIND_JOINT {
        return Ok(object.id);
    }
    Err(Fail::argument(format!("{what}: object {} is not a joint", object.handle())))
}

/// Checks numbers: finite, and as many as expected.
pub fn checked(what: &str, numbers: Vec<f64>, count: usize) -> Result<Vec<f64>> {
    if numbers.len() != count {
        return Err(Fail::argument(format!("{what}: {} numbers; expected {count}", numbers.len())));
    }
    match numbers.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(Fail::argument(format!("{what}: number {} is {}; expected a finite one", i + 1, numbers[i]))),
        None => Ok(numbers),
    }
}

/// Reads a table of numbers, empty if it is missing.
pub fn numbers(c: &Ctx<'_>, i: usize) -> Result<Vec<f64>> {
    if !c.has(i) {
        return Ok(Vec::new());
    }
    let wrong = || Fail::argument(format!("argument {}: expected a table of numbers", i + 1));
    c.arg(i).as_f64().map(|x| vec![x]).or_else(|| c.arg(i).numbers()).ok_or_else(wrong)
}

/// Reads a state of a task.
pub fn state(c: &Ctx<'_>, i: usize, dimension: usize) -> Result<Vec<f64>> {
    checked(&format!("argument {}, a state", i + 1), numbers(c, i)?, dimension)
}

/// Checks that an argument is a function, the name of one, or nil.
pub fn check_callback(c: &Ctx<'_>, i: usize) -> Result {
    let value = c.arg(i);
    if value.is_nil() || value.as_func().is_some() || value.as_str().is_some() {
        return Ok(());
    }
    Err(Fail::argument(format!("argument {}: expected a function or the name of one", i + 1)))
}

/// Reads a function, or the name of one; `None` for nil or an empty name.
pub fn callback(c: &Ctx<'_>, i: usize) -> Result<Option<Callback>> {
    let value = c.arg(i);
    if let Some(function) = value.as_func() {
        return Ok(Some(Callback::Function(c.keep_func(function)?)));
    }
    check_callback(c, i)?;
    let name = value.as_str().unwrap_or_default();
    let name = name.split('@').next().unwrap_or_default().to_owned();
    Ok((!name.is_empty()).then(|| Callback::Named { script: c.caller_script(), name }))
}

/// Calls a function of a script.
pub fn call(c: &mut Ctx<'_>, callback: &Callback, arguments: &[Value]) -> Result<Vec<Value>> {
    match callback {
        Callback::Function(function) => c.call_func(*function, arguments),
        Callback::Named { script, name } => c.world().call_function(*script, name, arguments),
    }
}

/// Returns whether a value that a script returned means yes.
pub fn is_yes(value: Option<&Value>) -> bool {
    !matches!(value, None | Some(Value::Nil | Value::Bool(false) | Value::Int(0)))
}
