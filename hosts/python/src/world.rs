//! The native class behind `tatu_sim.World`.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
    types::{PyBytes, PyDict, PyList},
};
use tatu_core::{
    errors::{Error as Wrong, Result},
    plugins::ParameterSpec,
    state::Snapshot,
};
use tatu_embed::{CameraView, SceneSource, WorldHost, WorldSetup, WorldSlot, search::scene_file};
use tatu_plugin_api::{abi::*, safe::Value};

use crate::{detach::run_detached, error, script::ScriptObjects, table, value};

/// Real time after which stepping is interrupted so that Python can handle signals such as Ctrl-C. It is checked after
/// every 16 steps.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// A world. The public interface is `tatu_sim.World`.
#[pyclass(module = "tatu_sim._native")]
pub struct World {
    /// The host of the world; `None` after the world has been closed.
    host: Mutex<Option<Arc<WorldHost>>>,
    /// Objects of the program that are scripts of the world.
    objects: Arc<ScriptObjects>,
}

impl Drop for World {
    fn drop(&mut self) {
        // Scripts that are objects of the program are called while the world ends, so the lock must be free.
        let host = self.host.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if host.is_some() {
            Python::attach(|py| run_detached(py, || drop(host)));
        }
    }
}

/// A property or field of an object that is read or set in each step; it is looked up only once.
#[pyclass(module = "tatu_sim._native", frozen)]
pub struct Channel {
    channel: tatu_core::Channel,
}

#[pymethods]
impl Channel {
    /// Returns the shape of the channel's values as an array.
    #[getter]
    fn shape(&self) -> Vec<usize> {
        self.channel.shape.clone()
    }
}

/// Arguments from Python, from which a setup is created.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SetupArguments {
    scene: Option<PathBuf>,
    text: Option<String>,
    folder: PathBuf,
    pub seed: Option<u64>,
    pub set: Vec<String>,
    scripts: Vec<String>,
    allow: Vec<String>,
    services: Vec<String>,
    languages: Vec<String>,
    language_defaults: Vec<(String, String, String)>,
    /// Objects that replace the scripts of objects of the scene, with the paths of these.
    objects: Vec<(String, Py<PyAny>)>,
    plugins: Vec<PathBuf>,
    threads: usize,
    files: Option<PathBuf>,
}

impl TryFrom<SetupArguments> for WorldSetup {
    type Error = PyErr;

    fn try_from(a: SetupArguments) -> PyResult<Self> {
        let scene = match a.text {
            Some(text) => SceneSource::Text(text, a.folder),
            None => SceneSource::File(scene_file(&a.scene.unwrap_or_default()).map_err(|e| error::to_exception(&e))?),
        };
        Ok(WorldSetup {
            scene,
            seed: a.seed,
            set: a.set,
            scripts: a.scripts,
            allow: a.allow,
            services: a.services,
            languages: a.languages,
            language_defaults: a.language_defaults,
            plugins: a.plugins,
            threads: a.threads.max(1),
            files: a.files,
            texts: Vec::new(),
        })
    }
}

impl World {
    fn host(&self) -> PyResult<Arc<WorldHost>> {
        let host: MutexGuard<'_, Option<Arc<WorldHost>>> = self.host.lock().unwrap_or_else(PoisonError::into_inner);
        let host = host.clone().ok_or_else(|| PyValueError::new_err("the world is closed"))?;
        // The world's thread would wait for itself.
        if host.is_own_thread() {
            return Err(PyRuntimeError::new_err(
                "a script cannot use its own world, which is calling it: use the commands that the callback receives",
            ));
        }
        Ok(host)
    }

    /// Calls a function with the world on its thread, while the interpreter's lock is released.
    fn with<T: Send>(&self, py: Python<'_>, f: impl FnOnce(&mut WorldSlot) -> Result<T> + Send) -> PyResult<T> {
        let host = self.host()?;
        run_detached(py, || host.with(f)).map_err(|e| error::to_exception(&e))
    }
}

#[pymethods]
impl World {
    #[new]
    fn new(py: Python<'_>, setup: SetupArguments) -> PyResult<Self> {
        let mut setup = setup;
        let (objects, files) = ScriptObjects::register(std::mem::take(&mut setup.objects));
        let mut setup = WorldSetup::try_from(setup)?;
        for file in files {
            setup.scripts.push(format!("{}={}", file.path, file.name));
            setup.texts.push((file.name.into(), file.text));
        }
        let host = run_detached(py, || WorldHost::open(setup)).map_err(|e| error::to_exception(&e))?;
        Ok(World { host: Mutex::new(Some(Arc::new(host))), objects: Arc::new(objects) })
    }

    /// Runs up to `n` steps. Returns how many were run, whether the world is still running, and the lines logged. If an
    /// exception is raised, such as by Ctrl-C, the lines logged so far are left for [`lines`](Self::lines).
    fn step(&self, py: Python<'_>, n: u64) -> PyResult<(u64, bool, Vec<TaggedLine>)> {
        let mut done = 0;
        loop {
            // Another thread may have closed the world in the meantime.
            let host = self.host()?;
            let slice = run_detached(py, || {
                host.with(|seat| {
                    let since = Instant::now();
                    let mut stepped = 0;
                    loop {
                        let step = seat.step((n - done - stepped).min(16))?;
                        stepped += step.steps;
                        let last = !step.running || done + stepped >= n;
                        if last || since.elapsed() > SIGNAL_CHECK_INTERVAL {
                            let lines = last.then(|| seat.world().map(tatu_core::World::take_lines)).transpose()?;
                            return Ok((stepped, step.running, lines));
                        }
                    }
                })
            });
            let (stepped, running, lines) = slice.map_err(|e| error::to_exception(&e))?;
            done += stepped;
            if let Some(lines) = lines {
                return Ok((done, running, lines.into_iter().filter_map(tagged_line).collect()));
            }
            py.check_signals()?;
        }
    }

    /// Resets the world, optionally with a new seed and new changes.
    fn reset(&self, py: Python<'_>, seed: Option<u64>, set: Option<Vec<String>>) -> PyResult<()> {
        self.with(py, |seat| seat.reset(seed, set))
    }

    /// Returns a snapshot of the world.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.with(py, |seat| seat.snapshot()?.to_bytes())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Restores the world from a snapshot.
    fn restore(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        let snapshot = Snapshot::from_bytes(bytes).map_err(|e| error::to_exception(&e))?;
        self.with(py, |seat| seat.restore(&snapshot))
    }

    /// Creates another world in the same state.
    fn fork(&self, py: Python<'_>) -> PyResult<Self> {
        let host = self.host()?;
        let fork = run_detached(py, || host.fork()).map_err(|e| error::to_exception(&e))?;
        Ok(World { host: Mutex::new(Some(Arc::new(fork))), objects: self.objects.clone() })
    }

    /// Ends the world; all further calls fail.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        if self.host.lock().unwrap_or_else(PoisonError::into_inner).is_some() {
            self.host()?;
        }
        let host = self.host.lock().unwrap_or_else(PoisonError::into_inner).take();
        run_detached(py, || drop(host));
        Ok(())
    }

    /// Returns the hash of the world's state.
    fn hash(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |seat| Ok(seat.world()?.hash().total))
    }

    /// Returns the simulation time, s, the number of steps run, and the length of a step, s.
    fn clock(&self, py: Python<'_>) -> PyResult<(f64, u64, f64)> {
        self.with(py, |seat| {
            let world = seat.world()?;
            Ok((world.time(), world.steps(), world.dt()))
        })
    }

    /// Returns a property of an object.
    fn get<'py>(&self, py: Python<'py>, path: &str, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let got = self.with(py, |seat| seat.world()?.get(path, key).map_err(|r| error::refusal_error(&r)))?;
        value::to_python(py, &got)
    }

    /// Sets a property of an object.
    fn set(&self, py: Python<'_>, path: &str, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = value::from_python(value)?;
        self.with(py, |seat| seat.world()?.set(path, key, &value).map_err(|r| error::refusal_error(&r)))
    }

    /// Calls a command; returns the list of its results.
    fn call<'py>(&self, py: Python<'py>, name: &str, args: Vec<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyList>> {
        let args = args.iter().map(value::from_python).collect::<PyResult<Vec<_>>>()?;
        let results = self.with(py, |seat| seat.world()?.call(name, &args).map_err(|f| error::fault_error(&f)))?;
        let results = results.iter().map(|v| value::to_python(py, v)).collect::<PyResult<Vec<_>>>()?;
        PyList::new(py, results)
    }

    /// Returns the last reading of a sensor.
    fn reading<'py>(&self, py: Python<'py>, path: &str) -> PyResult<Bound<'py, PyDict>> {
        let reading = self.with(py, |seat| {
            let world = seat.world()?;
            world.reading(path).ok_or_else(|| {
                if world.get(path, "object.path").is_ok() {
                    return Wrong::new("E110", format!("`{path}` is not a sensor, so it has no readings"));
                }
                let e = Wrong::new("E110", format!("there is no sensor `{path}`"));
                match world.nearest_sensor(path) {
                    Some(near) => e.help(format!("did you mean `{near}`?")),
                    None => e,
                }
            })
        })?;
        let out = PyDict::new(py);
        out.set_item("path", &reading.path)?;
        out.set_item("kind", &reading.kind)?;
        out.set_item("time", reading.time)?;
        out.set_item("sequence", reading.sequence)?;
        let fields = PyDict::new(py);
        for field in &reading.fields {
            fields.set_item(&field.name, to_array(py, &field.value, field.dims)?)?;
        }
        out.set_item("fields", fields)?;
        Ok(out)
    }

    /// Returns the path and kind of each object, in order of the tree.
    fn objects(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        self.with(py, |seat| {
            Ok(seat.world()?.with_scene(|scene, _| {
                let mut paths = scene.paths();
                let all =
                    scene.slots().filter_map(|(slot, o)| Some((paths.remove(&slot)?, o.kind().name().to_owned())));
                all.collect()
            }))
        })
    }

    /// Returns the paths of all sensors.
    fn sensors(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |seat| Ok(seat.world()?.sensors()))
    }

    /// Looks up a property or field of an object.
    fn channel(&self, py: Python<'_>, path: &str, name: &str) -> PyResult<Channel> {
        let channel = self.with(py, |seat| seat.world()?.channel(path, name).map_err(|r| error::refusal_error(&r)))?;
        Ok(Channel { channel })
    }

    /// Reads channels into an array, consecutively.
    fn read_into(
        &self,
        py: Python<'_>,
        channels: Vec<PyRef<'_, Channel>>,
        out: &Bound<'_, PyArray1<f64>>,
    ) -> PyResult<()> {
        let channels: Vec<tatu_core::Channel> = channels.iter().map(|c| c.channel.clone()).collect();
        let wanted = channels.iter().map(|c| c.shape.iter().product::<usize>()).sum::<usize>();
        if out.len() != wanted {
            return Err(PyValueError::new_err(format!(
                "expected an array of {wanted} values, found an array of {}",
                out.len()
            )));
        }
        let read = self.with(py, |seat| {
            let world = seat.world()?;
            let mut all = vec![0.0; wanted];
            let mut rest = all.as_mut_slice();
            for channel in &channels {
                let part;
                (part, rest) = rest.split_at_mut(channel.shape.iter().product());
                world.read_channel(channel, part).map_err(|r| error::refusal_error(&r))?;
            }
            Ok(all)
        })?;
        out.try_readwrite()?.as_slice_mut()?.copy_from_slice(&read);
        Ok(())
    }

    /// Sets the values of a channel.
    fn write(&self, py: Python<'_>, channel: &Channel, numbers: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let numbers: Vec<f64> = numbers.as_array().iter().copied().collect();
        let channel = channel.channel.clone();
        self.with(py, |seat| seat.world()?.write_channel(&channel, &numbers).map_err(|r| error::refusal_error(&r)))
    }

    /// Renders a picture, as an array of rows, columns and RGB.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: Option<String>,
        points: Option<([f64; 3], [f64; 3])>,
        columns: u32,
        rows: u32,
        fov: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let view = view(camera, points);
        let picture = self.with(py, |seat| tatu_embed::picture(seat.world()?, &view, [columns, rows], fov))?;
        PyArray1::from_vec(py, picture.rgb).reshape([rows as usize, columns as usize, 3])
    }

    /// Returns the log lines since the last call: level, code and text.
    fn lines(&self, py: Python<'_>) -> PyResult<Vec<TaggedLine>> {
        let lines = self.with(py, |seat| Ok(seat.world()?.take_lines()))?;
        Ok(lines.into_iter().filter_map(tagged_line).collect())
    }

    /// Ends the services of the world, so that they write their files.
    fn end_services(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |seat| seat.end_services())
    }

    /// Returns the warnings about plugins and the scene.
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |seat| Ok(seat.template().warnings.clone()))
    }

    /// Returns the distinct errors that the run has reported so far, each with its number of occurrences.
    fn faults<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let faults = self.with(py, |seat| Ok(seat.world()?.faults()))?;
        let one = |f: tatu_core::errors::Fault| {
            let out = PyDict::new(py);
            out.set_item("code", f.code)?;
            out.set_item("text", f.message)?;
            out.set_item("help", f.help)?;
            out.set_item("plugin", f.plugin)?;
            out.set_item("script", f.script)?;
            out.set_item("object", f.object)?;
            out.set_item("file", f.file)?;
            out.set_item("line", f.line)?;
            out.set_item("traceback", f.traceback)?;
            out.set_item("count", f.count)?;
            Ok(out)
        };
        faults.into_iter().map(one).collect()
    }

    /// Returns the id and version of each plugin.
    fn plugins(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        self.with(py, |seat| {
            Ok(seat.template().registry.plugins.iter().map(|p| (p.id.clone(), p.version.clone())).collect())
        })
    }

    /// Returns the names of all commands, with their declarations.
    fn commands<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let registry = self.with(py, |seat| Ok(seat.template().registry.clone()))?;
        let declared = |all: &[ParameterSpec]| -> PyResult<Vec<_>> {
            let one = |p: &ParameterSpec| {
                let out = PyDict::new(py);
                out.set_item("name", &p.key)?;
                out.set_item("type", tatu_cli::python_type(p))?;
                out.set_item("unit", &p.unit)?;
                out.set_item("optional", p.optional())?;
                out.set_item("rest", p.flags & TATU_PARAM_REST != 0)?;
                out.set_item("text", &p.text)?;
                Ok(out)
            };
            all.iter().map(one).collect()
        };
        let one = |c: &tatu_core::plugins::CommandEntry| {
            let out = PyDict::new(py);
            out.set_item("names", c.names.iter().map(|n| n.name.clone()).collect::<Vec<_>>())?;
            out.set_item("text", &c.text)?;
            out.set_item("notes", &c.notes)?;
            out.set_item("parameters", declared(&c.params)?)?;
            out.set_item("returns", declared(&c.returns)?)?;
            Ok(out)
        };
        let done = registry.command_offers.commands.iter().map(one).collect();
        // If the world was closed in the meantime, this drops the last reference to the registry, which ends the
        // plugins in an orderly way.
        self.with(py, |_| {
            drop(registry);
            Ok(())
        })?;
        done
    }

    /// Returns the table `[env]` of the scene, if there is one.
    fn env<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let text = self.with(py, |seat| Ok(seat.template().document.requests.env.clone()))?;
        table::env(py, text.as_deref())
    }
}

/// A line of the log: level, code and text.
type TaggedLine = (&'static str, Option<&'static str>, String);

fn tagged_line(l: tatu_core::LogLine) -> Option<TaggedLine> {
    Some((tag_of_line(l.level)?, l.code, l.text))
}

/// Converts arguments to the viewpoint of a picture.
pub fn view(camera: Option<String>, points: Option<([f64; 3], [f64; 3])>) -> CameraView {
    match (camera, points) {
        (Some(camera), _) => CameraView::Camera(camera),
        (None, Some((from, to))) => CameraView::Points(from, to),
        (None, None) => CameraView::SceneCamera,
    }
}

/// Returns the name of a log level, or `None` for output that scripts write to windows.
pub fn tag_of_line(level: u32) -> Option<&'static str> {
    match level {
        TATU_LOG_ERROR => Some("error"),
        TATU_LOG_WARNING => Some("warning"),
        TATU_LOG_DEBUG => Some("debug"),
        TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => None,
        _ => Some("print"),
    }
}

/// Converts a field of a reading to an array with its shape.
fn to_array<'py>(py: Python<'py>, value: &Value, dims: [u32; 3]) -> PyResult<Bound<'py, PyAny>> {
    let mut shape: Vec<usize> = dims.iter().map(|d| *d as usize).collect();
    while shape.len() > 1 && shape.last() == Some(&1) {
        shape.pop();
    }
    let whole = |n: usize| shape.iter().product::<usize>() == n;
    match value {
        Value::Floats(v) if whole(v.len()) => Ok(PyArray1::from_slice(py, v).reshape(shape)?.into_any()),
        Value::Ints(v) if whole(v.len()) => Ok(PyArray1::from_slice(py, v).reshape(shape)?.into_any()),
        Value::Bytes(v) if whole(v.len()) => Ok(PyArray1::from_slice(py, v).reshape(shape)?.into_any()),
        Value::Bytes(v) => Ok(PyArray1::from_slice(py, v).into_any()),
        other => value::to_python(py, other),
    }
}
