//! A world.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict, PyList},
};
use tatu_core::{
    errors::{Error as Wrong, Result},
    plugins::Declared,
    scene::rows::KINDS,
    state::Snapshot,
};
use tatu_embed::{Host, Scene, Seat, Setup, View};
use tatu_plugin_api::{abi::*, safe::Value};

use crate::{error, table, value};

/// How long steps run before Python may handle signals, such as Ctrl-C.
const SLICE: Duration = Duration::from_millis(50);

/// A world. See `tatu_sim.World`, which users see.
#[pyclass(module = "tatu_sim._native")]
pub struct World {
    /// `None` once it has been closed.
    host: Mutex<Option<Arc<Host>>>,
}

/// Numbers of an object that are read or set in each step, found once.
#[pyclass(module = "tatu_sim._native", frozen)]
pub struct Channel {
    channel: tatu_core::Channel,
}

#[pymethods]
impl Channel {
    /// The shape of its numbers, as of an array.
    #[getter]
    fn shape(&self) -> Vec<usize> {
        self.channel.shape.clone()
    }
}

/// Makes a setup of arguments from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Arguments {
    scene: Option<PathBuf>,
    text: Option<String>,
    folder: PathBuf,
    pub seed: Option<u64>,
    pub set: Vec<String>,
    scripts: Vec<String>,
    allow: Vec<String>,
    services: Vec<String>,
    plugins: Vec<PathBuf>,
    threads: usize,
    files: Option<PathBuf>,
}

impl From<Arguments> for Setup {
    fn from(a: Arguments) -> Self {
        let scene = match a.text {
            Some(text) => Scene::Text(text, a.folder),
            None => Scene::File(tatu_embed::search::scene_file(&a.scene.unwrap_or_default())),
        };
        Setup {
            scene,
            seed: a.seed,
            set: a.set,
            scripts: a.scripts,
            allow: a.allow,
            services: a.services,
            plugins: a.plugins,
            threads: a.threads.max(1),
            files: a.files,
        }
    }
}

impl World {
    fn host(&self) -> PyResult<Arc<Host>> {
        let host: MutexGuard<'_, Option<Arc<Host>>> = self.host.lock().unwrap_or_else(PoisonError::into_inner);
        host.clone().ok_or_else(|| PyValueError::new_err("the world is closed"))
    }

    /// Does something with the world on its thread, without the interpreter's lock.
    fn with<T: Send>(&self, py: Python<'_>, f: impl FnOnce(&mut Seat) -> Result<T> + Send) -> PyResult<T> {
        let host = self.host()?;
        py.detach(|| host.with(f)).map_err(|e| error::of(&e))
    }
}

#[pymethods]
impl World {
    #[new]
    fn new(py: Python<'_>, setup: Arguments) -> PyResult<Self> {
        let setup = Setup::from(setup);
        let host = py.detach(|| Host::open(setup)).map_err(|e| error::of(&e))?;
        Ok(World { host: Mutex::new(Some(Arc::new(host))) })
    }

    /// Does up to `n` steps; returns how many, whether the world still runs, and what has been logged.
    fn step(&self, py: Python<'_>, n: u64) -> PyResult<(u64, bool, Vec<Line>)> {
        let mut done = 0;
        let mut lines = Vec::new();
        loop {
            // Another thread may have closed the world meanwhile.
            let host = self.host()?;
            let some = py.detach(|| {
                host.with(|seat| {
                    let since = Instant::now();
                    let mut stepped = 0;
                    loop {
                        let step = seat.step((n - done - stepped).min(16))?;
                        stepped += step.steps;
                        if !step.running || done + stepped >= n || since.elapsed() > SLICE {
                            return Ok((stepped, step.running, seat.world()?.take_lines()));
                        }
                    }
                })
            });
            let (stepped, running, told) = some.map_err(|e| error::of(&e))?;
            done += stepped;
            lines.extend(told.into_iter().filter_map(line));
            if !running || done >= n {
                return Ok((done, running, lines));
            }
            py.check_signals()?;
        }
    }

    /// Makes the world anew.
    fn reset(&self, py: Python<'_>, seed: Option<u64>, set: Option<Vec<String>>) -> PyResult<()> {
        self.with(py, |seat| seat.reset(seed, set))
    }

    /// The state of the world.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.with(py, |seat| seat.snapshot()?.to_bytes())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Returns to a state.
    fn restore(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        let snapshot = Snapshot::from_bytes(bytes).map_err(|e| error::of(&e))?;
        self.with(py, |seat| seat.restore(&snapshot))
    }

    /// Another world in the same state.
    fn fork(&self, py: Python<'_>) -> PyResult<Self> {
        let host = self.host()?;
        let fork = py.detach(|| host.fork()).map_err(|e| error::of(&e))?;
        Ok(World { host: Mutex::new(Some(Arc::new(fork))) })
    }

    /// Ends the world.
    fn close(&self, py: Python<'_>) {
        let host = self.host.lock().unwrap_or_else(PoisonError::into_inner).take();
        py.detach(|| drop(host));
    }

    /// The hash of its state.
    fn hash(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |seat| Ok(seat.world()?.hash().total))
    }

    /// Time, s; steps done; length of a step, s.
    fn clock(&self, py: Python<'_>) -> PyResult<(f64, u64, f64)> {
        self.with(py, |seat| {
            let world = seat.world()?;
            Ok((world.time(), world.steps(), world.dt()))
        })
    }

    /// A property of an object.
    fn get<'py>(&self, py: Python<'py>, path: &str, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let got = self.with(py, |seat| seat.world()?.get(path, key).map_err(|r| error::refused(&r)))?;
        value::to_python(py, &got)
    }

    /// Sets a property of an object.
    fn set(&self, py: Python<'_>, path: &str, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = value::from_python(value)?;
        self.with(py, |seat| seat.world()?.set(path, key, &value).map_err(|r| error::refused(&r)))
    }

    /// Calls a command; the list of its results.
    fn call<'py>(&self, py: Python<'py>, name: &str, args: Vec<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyList>> {
        let args = args.iter().map(value::from_python).collect::<PyResult<Vec<_>>>()?;
        let results = self.with(py, |seat| seat.world()?.call(name, &args).map_err(|f| error::fault(&f)))?;
        let results = results.iter().map(|v| value::to_python(py, v)).collect::<PyResult<Vec<_>>>()?;
        PyList::new(py, results)
    }

    /// The last reading of a sensor.
    fn reading<'py>(&self, py: Python<'py>, path: &str) -> PyResult<Bound<'py, PyDict>> {
        let reading = self.with(py, |seat| {
            let world = seat.world()?;
            world.reading(path).ok_or_else(|| {
                let e = Wrong::new("E110", format!("there is no sensor `{path}`"));
                match world.nearest(path) {
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
            fields.set_item(&field.name, shaped(py, &field.value, field.dims)?)?;
        }
        out.set_item("fields", fields)?;
        Ok(out)
    }

    /// Path and kind of every object, in order.
    fn objects(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        let kind = |kind: i32| KINDS.iter().find(|(_, k)| *k == kind).map_or("script", |(name, _)| *name).to_owned();
        self.with(py, |seat| {
            Ok(seat.world()?.look_at(|scene, _| {
                let mut paths = scene.paths();
                let all = scene.slots().filter_map(|(slot, o)| Some((paths.remove(&slot)?, kind(o.kind()))));
                all.collect()
            }))
        })
    }

    /// Paths of all sensors.
    fn sensors(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |seat| Ok(seat.world()?.sensors()))
    }

    /// Finds numbers of an object.
    fn channel(&self, py: Python<'_>, path: &str, name: &str) -> PyResult<Channel> {
        let channel = self.with(py, |seat| seat.world()?.channel(path, name).map_err(|r| error::refused(&r)))?;
        Ok(Channel { channel })
    }

    /// Reads channels into an array, one after the other.
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
                "an array of {wanted} numbers is expected, not of {}",
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
                world.read_channel(channel, part).map_err(|r| error::refused(&r))?;
            }
            Ok(all)
        })?;
        out.try_readwrite()?.as_slice_mut()?.copy_from_slice(&read);
        Ok(())
    }

    /// Sets a channel.
    fn write(&self, py: Python<'_>, channel: &Channel, numbers: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let numbers: Vec<f64> = numbers.as_array().iter().copied().collect();
        let channel = channel.channel.clone();
        self.with(py, |seat| seat.world()?.write_channel(&channel, &numbers).map_err(|r| error::refused(&r)))
    }

    /// A picture, as an array of rows, columns and colours.
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

    /// What has been logged since the last call: level, code and text.
    fn lines(&self, py: Python<'_>) -> PyResult<Vec<Line>> {
        let lines = self.with(py, |seat| Ok(seat.world()?.take_lines()))?;
        Ok(lines.into_iter().filter_map(line).collect())
    }

    /// Ends the services of the world, which write their files.
    fn end_services(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |seat| seat.end_services())
    }

    /// Warnings of plugins and scene.
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |seat| Ok(seat.engine().warnings.clone()))
    }

    /// Errors so far.
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

    /// Id and version of every plugin.
    fn plugins(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        self.with(py, |seat| {
            Ok(seat.engine().registry.plugins.iter().map(|p| (p.id.clone(), p.version.clone())).collect())
        })
    }

    /// Names of all commands, with declarations.
    fn commands<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let registry = self.with(py, |seat| Ok(seat.engine().registry.clone()))?;
        let declared = |all: &[Declared]| -> PyResult<Vec<_>> {
            let one = |p: &Declared| {
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
        let done = registry.commands.iter().map(one).collect();
        // The world may have been closed meanwhile: then this is the last owner, which ends the plugins in order.
        self.with(py, |_| {
            drop(registry);
            Ok(())
        })?;
        done
    }

    /// The table `[env]` of the scene.
    fn env<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let text = self.with(py, |seat| Ok(seat.engine().document.env.clone()))?;
        table::env(py, text.as_deref())
    }
}

/// A line of the log: level, code and text.
type Line = (&'static str, Option<&'static str>, String);

fn line(l: tatu_core::LogLine) -> Option<Line> {
    Some((tag_of_line(l.level)?, l.code, l.text))
}

/// From where a picture is taken.
pub fn view(camera: Option<String>, points: Option<([f64; 3], [f64; 3])>) -> View {
    match (camera, points) {
        (Some(camera), _) => View::Camera(camera),
        (None, Some((from, to))) => View::Points(from, to),
        (None, None) => View::Own,
    }
}

/// Name of a level of the log; `None`: what windows of scripts show.
pub fn tag_of_line(level: u32) -> Option<&'static str> {
    match level {
        TATU_LOG_ERROR => Some("error"),
        TATU_LOG_WARNING => Some("warning"),
        TATU_LOG_DEBUG => Some("debug"),
        TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => None,
        _ => Some("print"),
    }
}

/// A field of a reading, in the shape that it has.
fn shaped<'py>(py: Python<'py>, value: &Value, dims: [u32; 3]) -> PyResult<Bound<'py, PyAny>> {
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
