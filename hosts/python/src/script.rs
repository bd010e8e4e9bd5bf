//! Scripts that are objects of the program that contains the world: classes, instances or functions in Python, which are
//! called on the world's thread, at their place in the step.
//!
//! This module of Python is also a plugin, which offers them as a script language. The text of such a script is the number
//! of its object.

use std::{
    cell::{OnceCell, RefCell},
    collections::BTreeMap,
    mem::MaybeUninit,
    sync::{Mutex, MutexGuard, PoisonError},
};

use pyo3::{
    exceptions::PyRuntimeError,
    prelude::*,
    types::{PyTuple, PyType},
};
use tatu_plugin_api::{abi::*, safe::*};

use crate::{error, value};

/// Suffix of the names of scripts, and the module with helpers in Python.
const SUFFIX: &str = ".python_object";
const HELPERS: &str = "tatu_sim._scripts";

/// The objects in use, by number, and the last number.
static OBJECTS: Mutex<(BTreeMap<u64, Py<PyAny>>, u64)> = Mutex::new((BTreeMap::new(), 0));

fn objects() -> MutexGuard<'static, (BTreeMap<u64, Py<PyAny>>, u64)> {
    OBJECTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Objects that are scripts of a world, and of worlds that are forked from it.
pub struct ScriptObjects(Vec<u64>);

/// The script of an object of the scene: its path, and the name and text of the script.
pub struct ObjectScriptFile {
    pub path: String,
    pub name: String,
    pub text: String,
}

impl ScriptObjects {
    /// Registers objects, each with the path of the object of the scene whose scripts it replaces.
    pub fn register(given: Vec<(String, Py<PyAny>)>) -> (Self, Vec<ObjectScriptFile>) {
        let mut registered = objects();
        let file = |(path, object)| {
            registered.1 += 1;
            let number = registered.1;
            registered.0.insert(number, object);
            (number, ObjectScriptFile { path, name: format!("{number}{SUFFIX}"), text: number.to_string() })
        };
        let (numbers, files) = given.into_iter().map(file).unzip();
        (ScriptObjects(numbers), files)
    }
}

impl Drop for ScriptObjects {
    fn drop(&mut self) {
        // The objects are dropped after the lock is released, since that may run code in Python.
        let _dropped: Vec<_> = {
            let mut registered = objects();
            self.0.iter().filter_map(|number| registered.0.remove(number)).collect()
        };
    }
}

/// A world whose script is being called on this thread.
#[derive(Clone, Copy)]
struct Caller {
    world: *mut tatu_world,
    host: Host,
}

thread_local! {
    static CALLERS: RefCell<Vec<Caller>> = const { RefCell::new(Vec::new()) };
}

/// Calls a command for the script that is being called on this thread.
#[pyfunction]
pub fn script_call<'py>(py: Python<'py>, name: &str, args: Vec<Bound<'py, PyAny>>) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let caller = CALLERS.with_borrow(|callers| callers.last().copied()).ok_or_else(|| {
        PyRuntimeError::new_err(format!("`{name}` can be called only while the simulator calls the script"))
    })?;
    let args = args.iter().map(value::from_python).collect::<PyResult<Vec<_>>>()?;
    // SAFETY: the world calls the script on this thread, so it is alive and may be used until the script has returned.
    let world = unsafe { World::new(caller.world, &caller.host) };
    let results = world.call_command(name, &args).map_err(|fail| error::from_fail(&fail))?;
    results.iter().map(|v| value::to_python(py, v)).collect()
}

/// The plugin.
struct ObjectScripts;

impl Plugin for ObjectScripts {
    fn start(_: &Host) -> Result<Self> {
        Ok(ObjectScripts)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.language::<ObjectScript>();
    }
}

/// A script.
struct ObjectScript {
    caller: Caller,
    target: OnceCell<Py<PyAny>>,
    /// Names of the callbacks and functions that were found, as attributes; empty: the object itself.
    found: RefCell<Vec<String>>,
}

// SAFETY: the world's pointer is used only on the thread that calls the script; everything else may be sent.
unsafe impl Send for ObjectScript {}

/// Runs `f` with the interpreter's lock. If the interpreter is exiting, the script is not called any more.
fn attached<T: Default>(f: impl FnOnce(Python<'_>) -> PyResult<T>) -> Result<T> {
    let result = Python::try_attach(|py| f(py).map_err(|e| to_fail(py, &e)));
    result.unwrap_or_else(|| Ok(T::default()))
}

/// Converts an exception to an error with its place in the program.
fn to_fail(py: Python<'_>, e: &PyErr) -> Fail {
    let told = py.import(HELPERS).and_then(|m| m.call_method1("describe", (e.value(py), e.traceback(py))));
    let told = told.and_then(|t| t.extract::<(String, String, u64, String)>());
    let Ok((text, file, line, traceback)) = told else {
        return Fail::with_code(TATU_ERR_SCRIPT, e.to_string());
    };
    let fail = Fail::with_code(TATU_ERR_SCRIPT, text).traceback(traceback);
    if line > 0 { fail.at(file, line) } else { fail }
}

impl ObjectScript {
    /// Calls a function in Python, which may call commands.
    fn enter<T: Default>(&self, f: impl FnOnce(Python<'_>, &Bound<'_, PyAny>) -> PyResult<T>) -> Result<T> {
        CALLERS.with_borrow_mut(|callers| callers.push(self.caller));
        let result = attached(|py| match self.target.get() {
            Some(target) => f(py, target.bind(py)),
            None => Ok(T::default()),
        });
        CALLERS.with_borrow_mut(Vec::pop);
        result
    }

    /// Returns the attribute that is the callback or function; empty: the object itself.
    fn attribute(target: &Bound<'_, PyAny>, how: u32, name: &str) -> PyResult<Option<String>> {
        let attribute = if how == TATU_FIND_CALLBACK { format!("sysCall_{name}") } else { name.to_owned() };
        if let Some(found) = target.getattr_opt(attribute.as_str())? {
            return Ok(found.is_callable().then_some(attribute));
        }
        let is_function = target.is_callable() && (how, name) == (TATU_FIND_CALLBACK, "actuation");
        Ok(is_function.then(String::new))
    }
}

impl Language for ObjectScript {
    type Plugin = ObjectScripts;
    const ID: &'static str = "python_object";
    const TEXT: &'static str = "Objects of the program in Python that contains the world.";
    const SUFFIXES: &'static [&'static str] = &[SUFFIX];

    fn create(world: &World<'_>, _: Instance) -> Result<Self> {
        let caller = Caller { world: world.raw().ptr(), host: *world.host() };
        Ok(ObjectScript { caller, target: OnceCell::new(), found: RefCell::default() })
    }
    fn load(&self, text: &[u8], _: &str, dialect: &str) -> Result<String> {
        let number = std::str::from_utf8(text).ok().and_then(|t| t.trim().parse::<u64>().ok());
        attached(|py| {
            let object = number.and_then(|n| objects().0.get(&n).map(|o| o.clone_ref(py)));
            let Some(object) = object else {
                return Err(PyRuntimeError::new_err("the object of this script does not exist in this program"));
            };
            // Each script has an instance of its own.
            let target = if object.bind(py).is_instance_of::<PyType>() { object.call0(py)? } else { object };
            if target.bind(py).hasattr("sysCall_thread")? {
                return Err(PyRuntimeError::new_err(
                    "an object of the program cannot have `sysCall_thread`, which only scripts in files can have",
                ));
            }
            let _ = self.target.set(target);
            Ok(())
        })?;
        Ok(dialect.to_owned())
    }
    fn traits(&self) -> u32 {
        TATU_SCRIPT_SILENT | TATU_SCRIPT_MODERN
    }
    fn find(&self, how: u32, name: &[u8]) -> u32 {
        let Ok(name) = std::str::from_utf8(name) else { return 0 };
        let Ok(Some(attribute)) = self.enter(|_, target| Self::attribute(target, how, name)) else { return 0 };
        let mut found = self.found.borrow_mut();
        let at = found.iter().position(|known| *known == attribute).unwrap_or_else(|| {
            found.push(attribute);
            found.len() - 1
        });
        at as u32 + 1
    }
    fn call(&self, callable: u32, frame: &mut Frame<'_>, _: Budget, used: &mut u64) -> Result<Flow> {
        let attribute = self.found.borrow().get((callable as usize).wrapping_sub(1)).cloned();
        let attribute = attribute.ok_or_else(|| Fail::with_code(TATU_ERR_GONE, "the script has no such callable"))?;
        let given = frame.args().iter().map(|v| v.to_value()).collect::<Result<Vec<_>>>()?;
        *used += 1;
        let results = self.enter(|py, target| {
            let function = if attribute.is_empty() { target.clone() } else { target.getattr(attribute.as_str())? };
            let mut args = vec![py.import(HELPERS)?.getattr("script")?];
            for value in &given {
                args.push(value::to_python(py, value)?);
            }
            let result = function.call1(PyTuple::new(py, args)?)?;
            match result.cast::<PyTuple>() {
                _ if result.is_none() => Ok(Vec::new()),
                Ok(several) => several.iter().map(|one| value::from_python(&one)).collect(),
                Err(_) => Ok(vec![value::from_python(&result)?]),
            }
        })?;
        for value in &results {
            let raw = value.to_raw(&mut FrameRoom(frame)).ok_or_else(|| {
                Fail::with_code(TATU_ERR_SPACE, "the result exceeds the world's memory for the values of a single call")
            })?;
            // SAFETY: the value's data is in memory of the frame, which is valid until the caller has read the results.
            unsafe { frame.push(raw) }?;
        }
        Ok(Flow::Done)
    }
    fn resume(&self, _: u64, _: Option<Fail>, _: &mut Frame<'_>, _: Budget, _: &mut u64) -> Result<Flow> {
        Err(Fail::unsupported("a script that is an object of the program does not wait"))
    }
    const STATE_VERSION: u32 = 1;
    /// Saves the names of the callables that the host knows by number, and the state of the object.
    fn save(&self) -> Result<Vec<u8>> {
        let found = self.found.borrow().clone();
        self.enter(|py, target| py.import(HELPERS)?.call_method1("save", (target, found))?.extract())
    }
    fn restore(&self, bytes: &[u8], _: u32) -> Result<()> {
        let found: Vec<String> =
            self.enter(|py, target| py.import(HELPERS)?.call_method1("restore", (target, bytes))?.extract())?;
        let mut known = self.found.borrow_mut();
        if known.is_empty() {
            *known = found;
        }
        Ok(())
    }
    fn keep_func(&self, _: u32) -> u32 {
        0
    }
    fn drop_func(&self, _: u32) {}
    fn call_func(&self, _: u32, _: &mut Frame<'_>, _: Budget, _: &mut u64) -> Result<Flow> {
        Err(Fail::with_code(TATU_ERR_GONE, "the function no longer exists"))
    }
}

impl Drop for ObjectScript {
    fn drop(&mut self) {
        // Dropping an object may run code in Python.
        if let Some(target) = self.target.take() {
            let mut target = Some(target);
            if Python::try_attach(|_| drop(target.take())).is_none() {
                // The interpreter is exiting, and frees nothing any more.
                std::mem::forget(target);
            }
        }
    }
}

/// Memory for results, from the frame of the call.
struct FrameRoom<'f, 'a>(&'f mut Frame<'a>);

impl Room for FrameRoom<'_, '_> {
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]> {
        let memory = self.0.alloc(n.checked_mul(8)?);
        // SAFETY: `alloc` returns null or memory of this size, aligned to 8 bytes, that nothing else uses.
        (!memory.is_null()).then(|| unsafe { std::slice::from_raw_parts_mut(memory.cast(), n) })
    }
}

tatu_plugin_api::tatu_plugin! {
    plugin: ObjectScripts,
    id: "tatu.python_object",
    name: "Objects of the program as scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
