//! Settings common to all commands, and their examples, which are Lua files in `examples/`, each example below a line
//! `--- sim.name`.

use std::collections::BTreeMap;

use crate::kit::*;

/// The version from which flat names raise errors as all other commands do.
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

/// Adds the examples and the common settings to all commands.
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
