//! Edits of a scene, which can be undone and saved.

use crate::abi::*;
use crate::safe::{Result, ValueRef, World, call::shared_world::service};

impl<'a> World<'a> {
    /// Runs `f` as one edit: all its changes can be undone in a single step, labelled `label` ("Move cup"). If `f`
    /// fails, its changes are reverted. Consecutive edits with the same label and the same `merge` become one edit,
    /// unless `merge` is empty.
    pub fn edit<T>(&self, label: &str, merge: &str, f: impl FnOnce() -> Result<T>) -> Result<T> {
        let end = service!(self.edits.end);
        self.check(service!(self.edits.begin)(self.raw(), label.into(), merge.into()))?;
        let done = f();
        let ended = self.check(end(self.raw(), u32::from(done.is_ok())));
        let done = done?;
        ended.map(|()| done)
    }
    /// Undoes the last edit or, if `redo` is set, redoes the last edit that was undone. Returns the label of the edit,
    /// or `None` if there is no edit to undo or redo.
    pub fn step_back(&self, redo: bool) -> Result<Option<String>> {
        let mut label = Lent::EMPTY;
        let status = service!(self.edits.step_back)(self.raw(), u32::from(redo), Some(&mut label));
        if status == TATU_ERR_MISSING {
            return Ok(None);
        }
        self.check(status)?;
        Ok(Some(label.text().into_owned()))
    }
    /// Returns the state of the edits as a map, valid until the current call returns; its keys are documented at
    /// `tatu_host_edits.state`.
    pub fn edits(&self) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL;
        self.check(service!(self.edits.state)(self.raw(), Some(&mut value)))?;
        Ok(value)
    }
    /// Saves the scene to its own file if `file` is empty, otherwise to `file`, a path that [`World::file`] returned.
    /// If `over` is set, a file that has changed on disk is overwritten.
    pub fn save_edits(&self, file: &[u8], over: bool) -> Result {
        let flags = if over { TATU_SAVE_OVER } else { 0 };
        self.check(service!(self.edits.save)(self.raw(), file.into(), flags))
    }
    /// Writes a recovery copy if there are edits since the last one.
    pub fn copy_edits(&self) -> Result {
        self.check(service!(self.edits.copy)(self.raw(), 0))
    }
    /// Removes the recovery copy that [`World::copy_edits`] wrote.
    pub fn discard_copy(&self) -> Result {
        self.check(service!(self.edits.copy)(self.raw(), 1))
    }
    /// Adds the objects that a text in the format of scene files describes, below `parent` or, if that is 0, at the top
    /// level. Returns the first object.
    pub fn add_text(&self, text: &[u8], parent: tatu_object) -> Result<tatu_object> {
        let mut out = 0;
        self.check(service!(self.edits.add)(self.raw(), text.into(), parent, Some(&mut out)))?;
        Ok(out)
    }
    /// Returns the `index`-th kind of device that plugins offer, from 0, as a map of `object`, `id` and `text`, or
    /// `None` past the last one.
    pub fn kind(&self, index: u32) -> Result<Option<ValueRef<'a>>> {
        let mut out = ValueRef::NIL;
        let status = service!(self.edits.kind)(self.raw(), index, Some(&mut out));
        self.found(status, out)
    }
    /// Requests that the program open a scene; `how` is one of `TATU_OPEN_*`.
    pub fn open_as(&self, file: &[u8], how: u32) -> Result {
        self.check(service!(self.edits.open)(self.raw(), file.into(), how))
    }
}
