//! Adds examples to the commands, and declares since which version their flat names raise errors. The examples are in
//! Lua files in `examples/`, each below a line `--- sim.name`.

use std::collections::BTreeMap;

use crate::kit::*;

/// The V-REP version since which commands called by flat names raise errors instead of returning -1 or nil.
const FLAT_NAMES_RAISE: &str = "4.2";

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        const FILES: &[&str] = &[$(include_str!(concat!("../examples/", $name, ".lua"))),*];
    };
}
files!(
    "basics",
    "copying",
    "custom_data",
    "dialogs",
    "distances",
    "flags",
    "graphs",
    "lights",
    "making",
    "math",
    "meshes",
    "motion",
    "objects",
    "paths",
    "physics",
    "program",
    "script_more",
    "selection",
    "vision",
    "windows",
);

/// Adds the examples, and the version since which flat names raise errors, to all commands offered so far.
pub(crate) fn complete(offer: &mut Offer<Vrep>) {
    let mut examples: BTreeMap<&str, &str> = BTreeMap::new();
    for part in FILES.iter().flat_map(|f| f.split("--- ").skip(1)) {
        if let Some((name, text)) = part.split_once('\n') {
            examples.insert(name.trim(), text.trim_end());
        }
    }
    offer.each_command(|c| {
        let c = match examples.get(c.name()) {
            Some(text) => c.example(*text),
            None => c,
        };
        c.old_names_until(FLAT_NAMES_RAISE)
    });
}
