//! Streams, curves and drawings, whose keys and types are documented in `tatu/host.h`, and further functions of a world
//! for viewers and editors.

use crate::abi::*;
use crate::safe::{Result, Value, ValueRef, World, call::shared_world::service, value::owned::Owned};

/// Builds the map of keys and their values that [`World::add_figure`] and [`World::change_figure`] require.
pub fn keys<const N: usize>(entries: [(&str, Value); N]) -> Value {
    Value::Map(entries.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}

impl<'a> World<'a> {
    /// Adds a stream, curve, copy or drawing (`TATU_FIGURE_*`); returns its id.
    pub fn add_figure(&self, graph: tatu_object, what: u32, keys: &Value) -> Result<i64> {
        let (mut owned, mut id) = (Owned::default(), 0);
        let map = owned.value(keys);
        self.check(service!(self.figures.add)(self.raw(), graph, what, Some(&map), Some(&mut id)))?;
        Ok(id)
    }
    /// Changes the given keys of a stream.
    pub fn change_figure(&self, graph: tatu_object, id: i64, keys: &Value) -> Result {
        let mut owned = Owned::default();
        let map = owned.value(keys);
        self.check(service!(self.figures.change)(self.raw(), graph, id, Some(&map)))
    }
    /// Removes a stream, curve or drawing.
    pub fn remove_figure(&self, graph: tatu_object, id: i64) -> Result {
        self.check(service!(self.figures.change)(self.raw(), graph, id, None))
    }
    /// Appends a sample to a stream, or adds items to a drawing, which is cleared if `numbers` is empty. Returns the
    /// number of samples or items that were accepted.
    pub fn put_figure(&self, graph: tatu_object, id: i64, numbers: &[f64]) -> Result<u64> {
        let (n, mut taken) = (numbers.len() as u64, 0);
        let put = service!(self.figures.put);
        // SAFETY: the pointer and the count are those of the slice `numbers`.
        self.check(unsafe { put(self.raw(), graph, id, numbers.as_ptr(), n, Some(&mut taken)) })?;
        Ok(taken)
    }
    /// Samples all streams of a graph, at `time` in s, or, if `graph` is 0, of all graphs that record automatically.
    pub fn record_graph(&self, graph: tatu_object, time: f64) -> Result {
        self.check(service!(self.figures.record)(self.raw(), graph, time))
    }
    /// Returns the ids of all figures of one type: `TATU_FIGURE_STREAM`, `_CURVE` or `_DRAWING`.
    pub fn figures(&self, graph: tatu_object, what: u32) -> Result<Vec<i64>> {
        let list = service!(self.figures.list);
        // SAFETY: `fill` passes a buffer with room for `cap` elements.
        self.fill(|out, cap, n| unsafe { list(self.raw(), graph, what, out, cap, n) })
    }
    /// Returns a figure as a map, with its data if `numbers` is set; the map is valid until the current call returns.
    pub fn figure(&self, graph: tatu_object, id: i64, numbers: bool) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL;
        self.check(service!(self.figures.get)(self.raw(), graph, id, u32::from(numbers), Some(&mut value)))?;
        Ok(value)
    }
    /// Returns the `index`-th visible part of a shape, from 0, as a map (see `tatu_host_figures.part`), or `None` past
    /// the last one.
    pub fn part(&self, shape: tatu_object, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL;
        let status = service!(self.figures.part)(self.raw(), shape, index, Some(&mut out));
        self.found(status, out)
    }
    /// Returns the image on the `index`-th visible part of a shape as a map (see `tatu_host_figures.image`), or `None`
    /// if the part has no image.
    pub fn part_image(&self, shape: tatu_object, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL;
        let status = service!(self.figures.image)(self.raw(), shape, index, Some(&mut out));
        self.found(status, out)
    }
    /// Returns the declaration of the `index`-th property of an object, from 0, as a map (see `tatu_host_scene.row`),
    /// or `None` past the last one.
    pub fn row(&self, object: tatu_object, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL;
        let status = service!(self.scene.row)(self.raw(), object, index, Some(&mut out));
        self.found(status, out)
    }
    /// Returns the `index`-th model that plugins offer, from 0, as a map of `id`, `text` and `category`, or `None` past
    /// the last one.
    pub fn model(&self, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL;
        let status = service!(self.scene.model)(self.raw(), index, Some(&mut out));
        self.found(status, out)
    }
    /// Returns the source of a script.
    pub fn script_text(&self, script: tatu_object) -> Result<Vec<u8>> {
        let mut out = ValueRef::NIL;
        self.check(service!(self.scripts.text)(self.raw(), script, Some(&mut out)))?;
        Ok(out.as_bytes().unwrap_or_default().to_vec())
    }
    /// Replaces the source of a script.
    pub fn change_script(&self, script: tatu_object, text: &[u8]) -> Result {
        self.check(service!(self.scripts.change)(self.raw(), script, text.into()))
    }
    /// Adds an external input, such as a key press, with a kind ("key") and a text.
    pub fn put_in(&self, kind: &str, what: &str) -> Result {
        self.check(service!(self.session.put_in)(self.raw(), kind.into(), what.into()))
    }
    /// Reads something external to the simulation during a step by calling `look`, and records the text as an input. In
    /// a replay, returns the recorded text without calling `look`.
    pub fn observe(&self, kind: &str, look: impl FnOnce() -> String) -> Result<String> {
        let mut out = Lent::EMPTY;
        let status = service!(self.session.observed)(self.raw(), kind.into(), Some(&mut out));
        if self.found(status, ())?.is_some() {
            return Ok(out.text().into_owned());
        }
        let found = look();
        self.check(service!(self.session.observe)(self.raw(), kind.into(), found.as_str().into()))?;
        Ok(found)
    }
    /// Returns whether the run must end. Poll this every 50 ms while waiting for something external, and give up once
    /// it is true.
    pub fn is_interrupted(&self) -> bool {
        self.host().session.and_then(|s| s.interrupted).is_some_and(|f| f(self.raw()) != 0)
    }
    /// Returns whether the running script must return, because it has not done so within a second after a stop was
    /// requested. Script languages ask this every few milliseconds.
    pub fn must_return(&self) -> bool {
        self.host().session.and_then(|s| s.must_return).is_some_and(|f| f(self.raw()) != 0)
    }
    /// Requests that the program open a different scene, or the current one again if `file` is empty.
    pub fn open_scene(&self, file: &str) -> Result {
        self.check(service!(self.session.open)(self.raw(), file.into()))
    }
}
