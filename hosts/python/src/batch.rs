//! The native class behind `tatu_sim.Batch`.

use std::sync::{Mutex, PoisonError};

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict},
};
use tatu_core::{Channel, errors::Error as Wrong, state::Snapshot};
use tatu_embed::{WorldSetup, WorldSlot};

use crate::{
    detach::run_detached,
    error, table, value,
    world::{SetupArguments, tag_of_line, view},
};

/// The state that is stored for each world of a batch.
#[derive(Default)]
struct WorldBuffers {
    observation_channels: Vec<Channel>,
    action_channels: Vec<Channel>,
    /// Values of all observed channels, consecutively.
    observation: Vec<f64>,
    action: Vec<f64>,
    /// Whether the world was stopped.
    stopped: bool,
    /// Whether the world has log lines that have not been retrieved.
    has_lines: bool,
    steps: u64,
}

/// Worlds that are stepped together. The public interface is `tatu_sim.Batch`.
#[pyclass(module = "tatu_sim._native")]
pub struct Batch {
    inside: Mutex<Option<OpenBatch>>,
}

struct OpenBatch {
    batch: tatu_embed::WorldBatch,
    buffers: Vec<WorldBuffers>,
    observations: Vec<(String, String)>,
    actions: Vec<(String, String)>,
}

/// Seed and changes for the reset of a world; `None` retains the current ones.
type ResetOptions = (Option<u64>, Option<Vec<String>>);

fn closed() -> PyErr {
    PyValueError::new_err("the batch is closed")
}

impl Batch {
    /// Calls a function with the batch, while the interpreter's lock is released.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        f: impl FnOnce(&mut OpenBatch) -> tatu_core::errors::Result<T> + Send,
    ) -> PyResult<T> {
        run_detached(py, || {
            let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
            inside.as_mut().map(f)
        })
        .ok_or_else(closed)?
        .map_err(|e| error::to_exception(&e))
    }
}

/// Looks up channels in a world, given as pairs of path and name.
fn find_channels(seat: &WorldSlot, names: &[(String, String)]) -> tatu_core::errors::Result<Vec<Channel>> {
    let world = seat.world()?;
    let one = |(path, name): &(String, String)| world.channel(path, name).map_err(|r| error::refusal_error(&r));
    names.iter().map(one).collect()
}

fn total_size(channels: &[Channel]) -> usize {
    channels.iter().map(|c| c.shape.iter().product::<usize>()).sum()
}

impl WorldBuffers {
    fn bind(
        &mut self,
        seat: &WorldSlot,
        observed: &[(String, String)],
        acted: &[(String, String)],
    ) -> tatu_core::errors::Result {
        (self.observation_channels, self.action_channels) =
            (find_channels(seat, observed)?, find_channels(seat, acted)?);
        self.observation.resize(total_size(&self.observation_channels), 0.0);
        self.action.resize(total_size(&self.action_channels), 0.0);
        self.observe(seat)
    }

    /// Finds the channels again in a world that was reset; they must have the same shapes as before.
    fn rebind(
        &mut self,
        seat: &WorldSlot,
        observed: &[(String, String)],
        acted: &[(String, String)],
    ) -> tatu_core::errors::Result {
        let (new, new_acted) = (find_channels(seat, observed)?, find_channels(seat, acted)?);
        let same = |a: &[Channel], b: &[Channel]| a.iter().map(|c| &c.shape).eq(b.iter().map(|c| &c.shape));
        if !same(&new, &self.observation_channels) || !same(&new_acted, &self.action_channels) {
            let text = "the observations or actions of the world have different shapes than before";
            return Err(Wrong::new("E102", text)
                .expected("changes that preserve the shapes, or a call to `bind` after the reset"));
        }
        (self.observation_channels, self.action_channels) = (new, new_acted);
        self.observe(seat)
    }

    fn observe(&mut self, seat: &WorldSlot) -> tatu_core::errors::Result {
        let world = seat.world()?;
        let mut rest = self.observation.as_mut_slice();
        for channel in &self.observation_channels {
            let part;
            (part, rest) = rest.split_at_mut(channel.shape.iter().product());
            world.read_channel(channel, part).map_err(|r| error::refusal_error(&r))?;
        }
        Ok(())
    }

    fn act(&self, seat: &WorldSlot) -> tatu_core::errors::Result {
        let world = seat.world()?;
        let mut rest = self.action.as_slice();
        for channel in &self.action_channels {
            let part;
            (part, rest) = rest.split_at(channel.shape.iter().product());
            world.write_channel(channel, part).map_err(|r| error::refusal_error(&r))?;
        }
        Ok(())
    }
}

#[pymethods]
impl Batch {
    #[new]
    fn new(py: Python<'_>, setups: Vec<SetupArguments>, threads: usize) -> PyResult<Self> {
        let setups: Vec<WorldSetup> = setups.into_iter().map(WorldSetup::try_from).collect::<PyResult<_>>()?;
        let batch =
            run_detached(py, || tatu_embed::WorldBatch::open(setups, threads)).map_err(|e| error::to_exception(&e))?;
        let buffers = (0..batch.count()).map(|_| WorldBuffers::default()).collect();
        let inside = OpenBatch { batch, buffers, observations: Vec::new(), actions: Vec::new() };
        Ok(Batch { inside: Mutex::new(Some(inside)) })
    }

    /// Sets the observations and actions, as pairs of path and name. Returns the shapes of both.
    #[allow(clippy::type_complexity, reason = "shapes of two lists")]
    fn bind(
        &self,
        py: Python<'_>,
        observed: Vec<(String, String)>,
        acted: Vec<(String, String)>,
    ) -> PyResult<(Vec<Vec<usize>>, Vec<Vec<usize>>)> {
        self.with(py, |inside| {
            inside.batch.for_each(&mut inside.buffers, |_, seat, kept| kept.bind(seat, &observed, &acted))?;
            let first = &inside.buffers[0];
            let shapes = |channels: &[Channel]| channels.iter().map(|c| c.shape.clone()).collect::<Vec<_>>();
            let both = (shapes(&first.observation_channels), shapes(&first.action_channels));
            let differs = |k: &WorldBuffers| (shapes(&k.observation_channels), shapes(&k.action_channels)) != both;
            if let Some(n) = inside.buffers.iter().position(differs) {
                let text =
                    format!("the observations or actions of world {n} have different shapes than those of world 0");
                return Err(Wrong::new("E102", text).expected("the same shapes in all worlds of a batch"));
            }
            (inside.observations, inside.actions) = (observed, acted);
            Ok(both)
        })
    }

    /// Returns the lowest and the highest value of the numbers of each action, as their properties declare them.
    fn bounds(&self, py: Python<'_>) -> PyResult<Vec<(Option<f64>, Option<f64>)>> {
        self.with(py, |inside| Ok(inside.buffers[0].action_channels.iter().map(|c| c.bounds.into()).collect()))
    }

    /// Sets actions, if there are any, runs `n` steps in each chosen world, and writes the observations of all worlds.
    ///
    /// Returns for each world whether it is still running, and whether anything was logged.
    fn step(
        &self,
        py: Python<'_>,
        actions: Option<PyReadonlyArray2<'_, f64>>,
        n: u64,
        chosen: Option<PyReadonlyArray1<'_, bool>>,
        out: &Bound<'_, PyArray2<f64>>,
    ) -> PyResult<(Vec<bool>, bool)> {
        let actions: Option<Vec<f64>> = actions.map(|a| a.as_array().iter().copied().collect());
        let chosen: Option<Vec<bool>> = chosen.map(|c| c.as_array().iter().copied().collect());
        let running = self.with(py, |inside| {
            if let Some(actions) = &actions {
                let wanted: usize = inside.buffers.iter().map(|k| k.action.len()).sum();
                if actions.len() != wanted {
                    let text = format!("the actions have {} values", actions.len());
                    return Err(Wrong::new("E102", text).expected(format!("{wanted} values, for all worlds together")));
                }
                let mut rest = actions.as_slice();
                for kept in &mut inside.buffers {
                    let part;
                    (part, rest) = rest.split_at(kept.action.len());
                    kept.action.copy_from_slice(part);
                }
            }
            let is_chosen = |n: usize| chosen.as_ref().is_none_or(|c| c.get(n).copied().unwrap_or(false));
            inside.batch.for_each(&mut inside.buffers, |world, seat, kept| {
                if !is_chosen(world) || kept.stopped {
                    return Ok(());
                }
                if actions.is_some() {
                    kept.act(seat)?;
                }
                let stepped = seat.step(n)?;
                kept.steps += stepped.steps;
                kept.stopped = !stepped.running;
                kept.has_lines = seat.world()?.has_lines();
                kept.observe(seat)
            })?;
            let told = inside.buffers.iter().any(|k| k.has_lines);
            Ok((inside.buffers.iter().map(|k| !k.stopped).collect::<Vec<bool>>(), told))
        })?;
        self.observe(py, out)?;
        Ok(running)
    }

    /// Writes the last observations of all worlds to `out`.
    fn observe(&self, py: Python<'_>, out: &Bound<'_, PyArray2<f64>>) -> PyResult<()> {
        let _ = py;
        let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        let inside = inside.as_mut().ok_or_else(closed)?;
        let (worlds, each) = (inside.buffers.len(), inside.buffers[0].observation.len());
        if out.shape() != [worlds, each] {
            return Err(PyValueError::new_err(format!("expected an array of shape ({worlds}, {each})")));
        }
        let mut out = out.try_readwrite()?;
        let out = out.as_slice_mut()?;
        for (row, kept) in out.chunks_mut(each.max(1)).zip(&inside.buffers) {
            row.copy_from_slice(&kept.observation);
        }
        Ok(())
    }

    /// Resets the worlds with these indices, each with its own seed and changes.
    fn reset(
        &self,
        py: Python<'_>,
        worlds: Vec<usize>,
        seeds: Vec<Option<u64>>,
        sets: Vec<Option<Vec<String>>>,
    ) -> PyResult<()> {
        self.with(py, |inside| {
            let count = inside.batch.count();
            let mut wanted: Vec<Option<ResetOptions>> = vec![None; count];
            for ((world, seed), set) in worlds.into_iter().zip(seeds).zip(sets) {
                let place = wanted.get_mut(world).ok_or_else(|| {
                    let e = Wrong::new("E102", format!("there is no world {world}"));
                    e.expected(format!("an index from 0 to {}", count - 1))
                })?;
                *place = Some((seed, set));
            }
            let OpenBatch { batch, buffers, observations, actions } = inside;
            batch.for_each(buffers, |world, seat, buffers| {
                let Some((seed, set)) = &wanted[world] else { return Ok(()) };
                seat.reset(*seed, set.clone())?;
                (buffers.stopped, buffers.steps) = (false, 0);
                buffers.rebind(seat, observations, actions)
            })
        })
    }

    /// Returns a property of an object in each world.
    fn get<'py>(&self, py: Python<'py>, path: &str, key: &str) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let all = self.with(py, |inside| {
            let mut all = vec![None; inside.batch.count()];
            inside.batch.for_each(&mut all, |_, seat, out| {
                *out = Some(seat.world()?.get(path, key).map_err(|r| error::refusal_error(&r))?);
                Ok(())
            })?;
            Ok(all)
        })?;
        all.iter().flatten().map(|v| value::to_python(py, v)).collect()
    }

    /// Sets a property of an object in each world.
    fn set(&self, py: Python<'_>, path: &str, key: &str, values: Vec<Bound<'_, PyAny>>) -> PyResult<()> {
        let values = values.iter().map(value::from_python).collect::<PyResult<Vec<_>>>()?;
        self.with(py, |inside| {
            if values.len() != inside.batch.count() {
                let text = format!("{} values were given for {} worlds", values.len(), inside.batch.count());
                return Err(Wrong::new("E102", text).expected("one for each world"));
            }
            let mut none = vec![(); inside.batch.count()];
            inside.batch.for_each(&mut none, |world, seat, ()| {
                seat.world()?.set(path, key, &values[world]).map_err(|r| error::refusal_error(&r))
            })
        })
    }

    /// Returns a snapshot of a world.
    fn snapshot<'py>(&self, py: Python<'py>, world: usize) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.with(py, |inside| inside.batch.with_world(world, |seat| seat.snapshot()?.to_bytes()))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Restores each of the given worlds from the same snapshot.
    fn restore(&self, py: Python<'_>, worlds: Vec<usize>, bytes: &[u8]) -> PyResult<()> {
        let snapshot = Snapshot::from_bytes(bytes).map_err(|e| error::to_exception(&e))?;
        self.with(py, |inside| {
            let OpenBatch { batch, buffers, observations, actions } = inside;
            batch.for_each(buffers, |world, seat, buffers| {
                if !worlds.contains(&world) {
                    return Ok(());
                }
                seat.restore(&snapshot)?;
                buffers.stopped = false;
                buffers.rebind(seat, observations, actions)
            })
        })
    }

    /// Returns the state hash of each world.
    fn hashes(&self, py: Python<'_>) -> PyResult<Vec<u64>> {
        self.with(py, |inside| {
            let mut all = vec![0; inside.batch.count()];
            inside.batch.for_each(&mut all, |_, seat, out| {
                *out = seat.world()?.hash().total;
                Ok(())
            })?;
            Ok(all)
        })
    }

    /// Returns the simulation time of each world, s.
    fn times(&self, py: Python<'_>) -> PyResult<Vec<f64>> {
        self.with(py, |inside| {
            let mut all = vec![0.0; inside.batch.count()];
            inside.batch.for_each(&mut all, |_, seat, out| {
                *out = seat.world()?.time();
                Ok(())
            })?;
            Ok(all)
        })
    }

    /// Returns the table `[env]` of the scene, if there is one.
    fn env<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let text = self
            .with(py, |inside| inside.batch.with_world(0, |seat| Ok(seat.template().document.requests.env.clone())))?;
        table::env(py, text.as_deref())
    }

    /// Returns the length of a step, s.
    fn dt(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |inside| inside.batch.with_world(0, |seat| Ok(seat.world()?.dt())))
    }

    /// Returns the log lines since the last call, each with the index of its world, level, code and text.
    #[allow(clippy::type_complexity, reason = "tuples of Python")]
    fn lines(&self, py: Python<'_>) -> PyResult<Vec<(usize, &'static str, Option<&'static str>, String)>> {
        let all = self.with(py, |inside| {
            let mut all = vec![Vec::new(); inside.batch.count()];
            inside.batch.for_each(&mut all, |_, seat, out| {
                *out = seat.world()?.take_lines();
                Ok(())
            })?;
            Ok(all)
        })?;
        let all = all.into_iter().enumerate().flat_map(|(world, lines)| lines.into_iter().map(move |l| (world, l)));
        Ok(all.filter_map(|(world, l)| Some((world, tag_of_line(l.level)?, l.code, l.text))).collect())
    }

    /// Renders a picture of a world, as an array of rows, columns and RGB.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        world: usize,
        camera: Option<String>,
        points: Option<([f64; 3], [f64; 3])>,
        columns: u32,
        rows: u32,
        fov: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let view = view(camera, points);
        let picture = self.with(py, |inside| {
            inside.batch.with_world(world, |seat| tatu_embed::picture(seat.world()?, &view, [columns, rows], fov))
        })?;
        PyArray1::from_vec(py, picture.rgb).reshape([rows as usize, columns as usize, 3])
    }

    /// Ends all worlds; all further calls fail.
    fn close(&self, py: Python<'_>) {
        run_detached(py, || drop(self.inside.lock().unwrap_or_else(PoisonError::into_inner).take()));
    }
}
