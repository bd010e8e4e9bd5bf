//! Replaces a running script with one that has a new source, or a different version of its language.

use std::rc::Rc;

use tatu_errors::{Error, Result, SourceLocation};
use tatu_scene::document::ScriptSpec;

use crate::{
    cell::{InstanceImage, Script, ScriptKind, Scripts, WorldCell},
    instances::{InstanceRef, load_instance, saved_state_block},
};

/// The state that an instance saved, or the reason why it could not be saved.
pub(crate) type SaveResult = Result<InstanceImage, String>;

/// The outcome for a script's state when the script is replaced.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum StateTransfer {
    /// The new script continues with the state of the old one.
    Continued,
    /// The new script starts from scratch, because there was no state to pass on.
    Fresh,
    /// The new script starts from scratch, for this reason.
    Reset(String),
}

impl Scripts {
    /// Returns the scripts whose language belongs to a plugin, each with its saved state, or `None` for a script that
    /// has not begun or has failed.
    pub fn save_of_plugin(world: &WorldCell, plugin: usize) -> Vec<(Rc<Script>, Option<SaveResult>)> {
        let all = world.run.scripts.borrow().list.clone();
        let of_plugin = all.into_iter().filter(|s| s.plugin(world) == plugin);
        of_plugin.map(|s| (s.clone(), s.save_for_replacement(world))).collect()
    }

    /// Returns the scripts that are not part of the document.
    pub fn outside_document(world: &WorldCell) -> Vec<Rc<Script>> {
        world.run.scripts.borrow().list.iter().filter(|s| s.kind >= ScriptKind::Addon).cloned().collect()
    }

    /// Replaces a script with a new one, and passes on its state. The caller must [end](Script::end_replaced) the old
    /// script afterwards.
    pub fn replace(world: &WorldCell, old: &Rc<Script>, new: &Rc<Script>, image: Option<SaveResult>) -> StateTransfer {
        if let Some(place) = world.run.scripts.borrow_mut().list.iter_mut().find(|s| Rc::ptr_eq(s, old)) {
            *place = new.clone();
        }
        world.run.scripts.borrow_mut().sorted_at = 0;
        new.counters.calls.set(old.counters.calls.get());
        new.counters.instructions.set(old.counters.instructions.get());
        match image {
            None => StateTransfer::Fresh,
            Some(Err(why)) => StateTransfer::Reset(why),
            Some(Ok(image)) => new.restore_state(world, &image),
        }
    }
}

/// Returns the byte range of a line, counted from 1; empty at 0 if there is no such line.
fn line_of(text: &[u8], line: usize) -> std::ops::Range<usize> {
    let mut start = 0;
    for (i, l) in text.split(|b| *b == b'\n').enumerate() {
        if i + 1 == line {
            return start..start + l.len();
        }
        start += l.len() + 1;
    }
    0..0
}

impl Script {
    /// Returns the script's description, with the given source.
    pub fn spec(&self, text: Vec<u8>) -> ScriptSpec {
        ScriptSpec {
            side_by_side: self.side_by_side,
            language: self.language,
            dialect: self.wanted_dialect.clone(),
            kind: self.kind_name.clone(),
            priority: self.priority,
            name: self.name.clone(),
            text,
        }
    }

    /// Saves the script's state, or returns `None` if the script has no state.
    pub fn save_for_replacement(&self, world: &WorldCell) -> Option<SaveResult> {
        let lives = self.progress.initialised.get() && !self.progress.dead.get() && !self.instance.data.get().is_null();
        // Event handlers belong to the state that registered them.
        let listens = world.run.connections.bus.has_subscription_of(self.instance.id.get());
        let why = || Err("functions that it registered for events are not carried over".to_owned());
        lives.then(|| if listens { why() } else { self.save(world) })
    }

    /// Creates a script to replace this one, and loads its source if this script has been loaded. The new script is not
    /// in the list of scripts yet. If its source cannot be loaded, returns an error and changes nothing.
    pub fn create_replacement(&self, world: &WorldCell, spec: Option<&ScriptSpec>) -> Result<Rc<Script>> {
        let default = world.model.settings.borrow().dialect.clone();
        let own = self.spec(self.text.to_vec());
        let new = Rc::new(Script::new(self.slot, self.kind, spec.unwrap_or(&own), default));
        // The id is from a separate range, so that the ids of later instances do not change.
        if let Err((status, mut error)) = new.try_begin(world, world.devices.next_replacement_id()) {
            let fault = new.fault(world, status, error.raw());
            new.destroy(world);
            let text = format!("the new source of {} cannot be loaded: {}", new.name, fault.message);
            let place = fault.line.map(|line| SourceLocation {
                file: fault.file.unwrap_or_default().into(),
                line: line as usize,
                column: 1,
                span: line_of(&new.text, line as usize),
            });
            return Err(Error::new("E306", text)
                .at(place)
                .help("correct the file; until then, the old version remains in use"));
        }
        if self.instance.data.get().is_null() {
            // The script was loaded only to check its source. It begins when this script would have begun.
            new.destroy(world);
        }
        Ok(new)
    }

    /// Loads the state without calling `init`, which the language accepts if the sources are equivalent. Otherwise,
    /// calls `init` and lets the language restore the parts of the state that fit.
    fn restore_state(self: &Rc<Self>, world: &WorldCell, image: &InstanceImage) -> StateTransfer {
        let load = || {
            let life = &world.model.registry.scripting.languages[self.language].life;
            let of = InstanceRef { plugin: self.plugin(world), slot: self.slot, data: self.instance.data.get() };
            let (block, dropped) = saved_state_block(life, image);
            self.instance.state.borrow_mut().copy_from_slice(&block);
            load_instance(world, &of, life, image)?;
            dropped.map_or(Ok(()), Err)
        };
        if load().is_ok() {
            self.progress.initialised.set(true);
            self.find_callbacks(world);
            return StateTransfer::Continued;
        }
        // A failed load may have changed a part of the state.
        self.destroy(world);
        if let Err((status, mut error)) = self.try_begin(world, world.devices.next_replacement_id()) {
            self.fail(world, status, error.raw());
            return StateTransfer::Reset("it could not be started a second time".into());
        }
        let mut handed = StateTransfer::Continued;
        self.initialise_and(world, || {
            if let Err(why) = load() {
                handed = StateTransfer::Reset(why);
            }
        });
        handed
    }

    /// Ends a script that has been replaced.
    pub fn end_replaced(&self, world: &WorldCell) {
        self.end(world);
    }

    /// Returns the path of the script's owner.
    pub fn owner(&self, world: &WorldCell) -> String {
        self.owner_path(world)
    }
}
