//! Creates a registry in which a plugin is replaced by a different version of it. Worlds, documents and scripts contain
//! indices into the registry, so every item keeps its index. New items are appended, and a new version that lacks an
//! item of the old one is rejected. Only commands may be missing; calling one by its old id returns an error.

use std::sync::Arc;

use tatu_errors::{Error, Result};
use tatu_plugin_api::abi::*;

use super::{ActuatorKind, CommandEntry, CommandName, Plugin, Registry};
use crate::{border::ErrorObject, load::LoadRemarks};

unsafe extern "C" fn removed_command(frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the host calls this as it calls any command, with a frame that lives during the call and points to its
    // own live error object.
    let error = unsafe { ErrorObject::at((*frame).error) };
    let text = "the plugin was reloaded, and its new version has no such command";
    error.map_or(TATU_ERR_GONE, |mut error| error.set(TATU_ERR_GONE, text))
}

/// Sorts a new list in the order of the old one, with new entries at the end. Fails with an entry of the old list that
/// is missing in the new one.
fn in_order<T>(old: &[T], new: Vec<T>, same: impl Fn(&T, &T) -> bool) -> Result<Vec<T>, &T> {
    let mut new: Vec<Option<T>> = new.into_iter().map(Some).collect();
    let mut out = Vec::with_capacity(new.len());
    for o in old {
        let found = new.iter_mut().find(|n| n.as_ref().is_some_and(|n| same(o, n)));
        out.push(found.and_then(Option::take).ok_or(o)?);
    }
    out.extend(new.into_iter().flatten());
    Ok(out)
}

impl Registry {
    /// Returns a registry in which a plugin has been reloaded from its file; the other plugins are shared with this
    /// registry. Remarks on the new version are in `refused` and `notes` of the new registry.
    pub fn with_reloaded_plugin(&self, plugin: usize) -> Result<Registry> {
        let old = &self.plugins[plugin];
        let mut remarks = LoadRemarks::default();
        let new = Plugin::open(&old.path, &self.search, &self.host, &self.call_watches.setup_watch, &mut remarks)?;
        let file = old.path.display();
        if new.id != old.id {
            let text = format!("the plugin {file} has changed its id to `{}`; it was `{}`", new.id, old.id);
            return Err(Error::new("E305", text).help("restore its id, or restart the run"));
        }
        let mut plugins = self.plugins.clone();
        plugins[plugin] = Arc::new(new);
        let (search, watches) = (self.search.clone(), self.call_watches.watches.clone());
        let mut registry = Self::of(plugins, search, self.call_watches.setup_watch.clone(), watches, self.host.clone());
        registry.inspector.clone_from(&self.inspector);
        registry.read();
        // A faulty declaration does not prevent the rest of the plugin from working.
        let new = registry.load_report.refused.iter().filter(|e| !self.load_report.known_errors.contains(&e.text));
        let (flaws, refused): (Vec<_>, Vec<_>) = new.cloned().partition(|e| e.code == "E310");
        if let Some(why) = refused.into_iter().next() {
            return Err(why);
        }
        registry.reuse_indices(self).map_err(|lost| {
            Error::new("E305", format!("the new version of {file} no longer offers {lost}"))
                .expected("a new version that offers everything that the old one did; only commands may be removed")
                .help("restart the run to continue without it")
        })?;
        registry.generation = self.generation + 1;
        registry.name_commands();
        remarks.warnings.extend(flaws);
        (registry.load_report.refused, registry.load_report.notes) = (remarks.warnings, remarks.notes);
        Ok(registry)
    }

    fn reuse_indices(&mut self, old: &Registry) -> Result<(), String> {
        macro_rules! place {
            ($($list:ident).+, $what:literal, $same:expr) => {
                let new = std::mem::take(&mut self.$($list).+);
                self.$($list).+ =
                    in_order(&old.$($list).+, new, $same).map_err(|lost| format!(concat!($what, " `{}`"), lost.id))?;
            };
        }
        place!(sensors, "the sensor", |a, b| {
            a.plugin == b.plugin && a.id == b.id && a.of_actuator == b.of_actuator
        });
        // The readings of an actuator precede those of a part with the same id, as the actuator precedes the part.
        let place = |(i, a): (usize, &ActuatorKind)| {
            a.readings?;
            let same = |other: &&ActuatorKind| other.plugin == a.plugin && other.id == a.id && other.readings.is_some();
            let before = self.actuators[..i].iter().filter(same).count();
            let mut own = self.sensors.iter().enumerate();
            own.by_ref()
                .filter(|(_, s)| s.of_actuator && s.plugin == a.plugin && s.id == a.id)
                .nth(before)
                .map(|(at, _)| at)
        };
        let places: Vec<_> = self.actuators.iter().enumerate().map(place).collect();
        self.actuators.iter_mut().zip(places).for_each(|(a, place)| a.readings = place);
        place!(actuators, "the actuator or part", |a, b| {
            a.plugin == b.plugin && a.id == b.id && a.part.is_some() == b.part.is_some()
        });
        place!(model_offers.models, "the model", |a, b| a.plugin == b.plugin && a.id == b.id);
        place!(importers, "the importer", |a, b| a.plugin == b.plugin && a.id == b.id);
        place!(scripting.languages, "the language", |a, b| a.plugin == b.plugin && a.id == b.id);
        place!(services, "the service", |a, b| a.plugin == b.plugin && a.id == b.id);
        self.reuse_command_ids(old);
        Ok(())
    }

    fn reuse_command_ids(&mut self, old: &Registry) {
        let mut new: Vec<Option<CommandEntry>> =
            std::mem::take(&mut self.command_offers.commands).into_iter().map(Some).collect();
        // The new id of each command, in the order in which the commands were read.
        let mut numbers = vec![0; new.len()];
        let mut gone = Vec::new();
        for (i, o) in old.command_offers.commands.iter().enumerate() {
            let same = |n: &CommandEntry| n.plugin == o.plugin && n.names[0].name == o.names[0].name;
            match new.iter().position(|n| n.as_ref().is_some_and(same)) {
                Some(at) => {
                    numbers[at] = i as u32 + 1;
                    self.command_offers.commands.extend(new[at].take());
                }
                None => {
                    gone.push(i);
                    self.command_offers.commands.push(tombstone(o));
                }
            }
        }
        for (at, entry) in new.into_iter().enumerate() {
            let Some(entry) = entry else { continue };
            self.command_offers.commands.push(entry);
            numbers[at] = self.command_offers.commands.len() as u32;
        }
        for (number, _) in self.command_offers.names.values_mut() {
            *number = numbers[*number as usize - 1];
        }
        for i in gone {
            for (alias, n) in self.command_offers.commands[i].names.iter().enumerate() {
                self.command_offers.names.entry(n.name.clone()).or_insert((i as u32 + 1, alias as u32));
            }
        }
    }
}

/// Returns a placeholder for a command that no longer exists, with its id and names.
fn tombstone(old: &CommandEntry) -> CommandEntry {
    let names = old.names.iter().map(|n| CommandName {
        name: n.name.clone(),
        on_error: n.on_error.clone(),
        until: n.until.clone(),
    });
    CommandEntry {
        plugin: old.plugin,
        names: names.collect(),
        params: Vec::new(),
        returns: Vec::new(),
        text: old.text.clone(),
        example: String::new(),
        status: old.status,
        notes: String::new(),
        subject: old.subject.clone(),
        no_wait: None,
        raw_args: true,
        side_by_side: false,
        raw: tatu_command { call: Some(removed_command), ..old.raw },
    }
}

#[cfg(test)]
mod tests {
    use super::in_order;

    #[test]
    fn existing_items_precede_new_ones_in_old_order() {
        let same = |a: &&str, b: &&str| a == b;
        assert_eq!(in_order(&["c", "a"], vec!["a", "b", "c"], same), Ok(vec!["c", "a", "b"]));
        assert_eq!(in_order(&["c", "x"], vec!["a", "b", "c"], same), Err(&"x"));
    }
}
