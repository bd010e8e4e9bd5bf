//! Streams, curves and drawings, as plugins see them; keys and sorts stand in the header.

use super::{Result, Value, ValueRef, World, fail::bytes_of, value::Room, world::service};
use crate::abi::*;

/// A map of keys for [`World::add_figure`] and [`World::change_figure`].
pub fn keys<const N: usize>(entries: [(&str, Value); N]) -> Value {
    Value::Map(entries.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}

impl<'a> World<'a> {
    /// Adds a stream, curve, copy or drawing (`TATU_FIGURE_*`); its number.
    pub fn add_figure(&self, graph: tatu_object, what: u32, keys: &Value) -> Result<i64> {
        let (mut room, mut id) = (Room::default(), 0);
        let map = room.raw(keys);
        // SAFETY: a world of this host; `room` lives until after the call.
        self.check(unsafe { service!(self.figures.add)(self.raw(), graph, what, &map, &mut id) })?;
        Ok(id)
    }
    /// Changes keys of a stream.
    pub fn change_figure(&self, graph: tatu_object, id: i64, keys: &Value) -> Result {
        let mut room = Room::default();
        let map = room.raw(keys);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.figures.change)(self.raw(), graph, id, &map) })
    }
    /// Removes a stream, curve or drawing.
    pub fn remove_figure(&self, graph: tatu_object, id: i64) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.figures.change)(self.raw(), graph, id, std::ptr::null()) })
    }
    /// Gives a stream its next number, or a drawing items; none: empties. How many were taken.
    pub fn put_figure(&self, graph: tatu_object, id: i64, numbers: &[f64]) -> Result<u64> {
        let (n, mut taken) = (numbers.len() as u64, 0);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.figures.put)(self.raw(), graph, id, numbers.as_ptr(), n, &mut taken) })?;
        Ok(taken)
    }
    /// A graph takes a sample under a time in s; 0: all that are not told when to.
    pub fn record_graph(&self, graph: tatu_object, time: f64) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.figures.record)(self.raw(), graph, time) })
    }
    /// The numbers of all of one sort.
    pub fn figures(&self, graph: tatu_object, what: u32) -> Result<Vec<i64>> {
        let list = service!(self.figures.list);
        self.fill(|out, cap, n| {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { list(self.raw(), graph, what, out, cap, n) }
        })
    }
    /// One as a map, with what it holds if `numbers`; lives until the call that you are in returns.
    pub fn figure(&self, graph: tatu_object, id: i64, numbers: bool) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the value lives until the plugin's call returns, which 'a does not outlive.
        unsafe {
            self.check(service!(self.figures.get)(self.raw(), graph, id, u32::from(numbers), &mut value))?;
            Ok(ValueRef::new(value))
        }
    }
    /// The `index`-th visible part of a shape, a map: see `tatu_host_figures.part`. `None`: it has no more.
    pub fn part(&self, shape: tatu_object, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        match unsafe { service!(self.figures.part)(self.raw(), shape, index, &mut out) } {
            TATU_ERR_MISSING => Ok(None),
            // SAFETY: the host's value lives until the running call returns, as the world does.
            status => self.check(status).map(|()| Some(unsafe { ValueRef::new(out) })),
        }
    }
    /// The `index`-th property of an object, a map: see `tatu_host_scene.row`. `None`: it has no more.
    pub fn row(&self, object: tatu_object, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        match unsafe { service!(self.scene.row)(self.raw(), object, index, &mut out) } {
            TATU_ERR_MISSING => Ok(None),
            // SAFETY: the host's value lives until the running call returns, as the world does.
            status => self.check(status).map(|()| Some(unsafe { ValueRef::new(out) })),
        }
    }
    /// The `index`-th model that plugins offer, a map of `id` and `text`; `None`: there are no more.
    pub fn model(&self, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        match unsafe { service!(self.scene.model)(self.raw(), index, &mut out) } {
            TATU_ERR_MISSING => Ok(None),
            // SAFETY: the host's value lives until the running call returns, as the world does.
            status => self.check(status).map(|()| Some(unsafe { ValueRef::new(out) })),
        }
    }
    /// The text of a script.
    pub fn script_text(&self, script: tatu_object) -> Result<Vec<u8>> {
        let mut out = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scripts.text)(self.raw(), script, &mut out) })?;
        // SAFETY: the host's value lives until the running call returns.
        Ok(unsafe { ValueRef::new(out) }.as_bytes().unwrap_or_default().to_vec())
    }
    /// Puts another text in the place of a script's.
    pub fn change_script(&self, script: tatu_object, text: &[u8]) -> Result {
        let text = tatu_str { ptr: text.as_ptr().cast(), len: text.len() as u64 };
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scripts.change)(self.raw(), script, text) })
    }
    /// Puts something in as if it came from outside.
    pub fn put_in(&self, kind: &str, what: &str) -> Result {
        let raw = |t: &str| tatu_str { ptr: t.as_ptr().cast(), len: t.len() as u64 };
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.session.put_in)(self.raw(), raw(kind), raw(what)) })
    }
    /// What a look outside gives, in the middle of a step: an input of the run. In a run that is repeated it is what the log has,
    /// and `look` is not called. What is found is text.
    pub fn observe(&self, kind: &str, look: impl FnOnce() -> String) -> Result<String> {
        let raw = |t: &str| tatu_str { ptr: t.as_ptr().cast(), len: t.len() as u64 };
        let mut out = raw("");
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the text is copied at once.
        match unsafe { service!(self.session.observed)(self.raw(), raw(kind), &mut out) } {
            TATU_ERR_MISSING => {}
            status => {
                self.check(status)?;
                // SAFETY: the host's text lives until the running call returns.
                return Ok(String::from_utf8_lossy(unsafe { bytes_of(out) }).into_owned());
            }
        }
        let found = look();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.session.observe)(self.raw(), raw(kind), raw(&found)) })?;
        Ok(found)
    }
    /// Whether the run is to end: who waits for something outside asks every 50 ms.
    pub fn is_interrupted(&self) -> bool {
        // SAFETY: the world is that of the running call.
        self.host().session.and_then(|s| s.interrupted).is_some_and(|f| unsafe { f(self.raw()) } != 0)
    }
    /// Asks the program to go on with another scene; empty: with this one again.
    pub fn open_scene(&self, file: &str) -> Result {
        let raw = tatu_str { ptr: file.as_ptr().cast(), len: file.len() as u64 };
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.session.open)(self.raw(), raw) })
    }
}
