//! Checks of a plugin's declarations when the plugin is loaded. Faulty declarations are reported, but do not prevent
//! the use of the plugin.

use std::collections::BTreeSet;

use tatu_errors::{Error, nearest};
use tatu_plugin_api::{abi::*, safe::Value};

use super::{ParameterSpec, Registry, check_value, schemas};
use crate::{texts, units};

/// Types that a parameter can have. Numeric arrays of any element type are passed as F64S.
const PARAMETER_TYPES: &[u32] =
    &[TATU_BOOL, TATU_I64, TATU_F64, TATU_TEXT, TATU_BYTES, TATU_F64S, TATU_LIST, TATU_MAP, TATU_FUNC, TATU_OBJECT];

/// Returns one message for each error in declarations. `in_files` is set if scene files can contain the keys.
pub fn parameters(all: &[ParameterSpec], in_files: bool) -> Vec<String> {
    let mut out = Vec::new();
    let mut keys = BTreeSet::new();
    for (i, p) in all.iter().enumerate() {
        let name =
            if p.key.is_empty() { format!("its parameter {}", i + 1) } else { format!("its parameter `{}`", p.key) };
        let mut say = |text: String| out.push(format!("{name} {text}"));
        if p.key.is_empty() {
            say("has no key".into());
        } else if let Some(flaw) = texts::flaw(&p.key).filter(|_| !in_files) {
            say(format!("has an invalid key: it {flaw}"));
        } else if !keys.insert(p.key.as_str()) {
            say("is declared twice; the first declaration is used".into());
        }
        let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if in_files && !p.key.is_empty() && !p.key.chars().all(bare) {
            say("cannot be written in a scene file: use only letters, digits, `_` and `-`".into());
        }
        let any = p.flags & TATU_PARAM_ANY != 0;
        if !any && !PARAMETER_TYPES.contains(&p.kind) {
            say(format!("has the unknown type {}; see tatu_param.type", p.kind));
            continue;
        }
        if let Some(unit) = p.unit.as_deref().filter(|_| in_files)
            && let Some(meant) = units::meant(unit)
        {
            say(format!("has the unit `{unit}`, not an SI unit as `core.h` lists them; was `{meant}` meant?"));
        }
        if p.keys_cut {
            say("declares more than 1000 keys, or keys more than 4 tables deep; the remaining keys are not checked"
                .into());
        }
        if p.unreadable_default {
            say("has a default that cannot be read: its type is unknown, or it is nested too deeply".into());
        }
        if p.lowest > p.highest || p.lowest.is_nan() || p.highest.is_nan() {
            say(format!("has an empty range: from {} to {}", p.lowest, p.highest));
        } else if !any
            && p.fallback != Value::Nil
            && let Err(e) = check_value(p, p.fallback.clone())
        {
            match p.choices.is_empty() {
                true => say(format!("has an invalid default: {e}")),
                false => say(format!("has a default that is not one of its choices: {e}")),
            }
        }
        if !p.choices.is_empty() && !any && !matches!(p.kind, TATU_TEXT | TATU_BYTES) {
            say("has choices, but is not a string: the choices are ignored".into());
        }
        let of_keys = parameters(&p.keys, false).into_iter();
        out.extend(of_keys.map(|flaw| format!("{name}: {}", flaw.replacen("its parameter", "its key", 1))));
    }
    out
}

/// Units allowed for commands although they are no SI units.
const COMMAND_UNITS: &[&str] = &["deg", "ms", "min", "h", "C"];

/// Returns a message if the unit of a parameter is misspelt.
fn misspelt_unit(p: &ParameterSpec) -> Option<String> {
    let unit = p.unit.as_deref().filter(|u| !COMMAND_UNITS.contains(u))?;
    units::meant(unit).map(|meant| format!("`{}` has the unit `{unit}`; was `{meant}` meant?", p.key))
}

impl Registry {
    /// Iterates over the items of plugins that must have a description, as plugin, kind of item, id and description.
    fn described_items(&self) -> impl Iterator<Item = (usize, &str, &str, &str)> {
        macro_rules! all {
            ($($list:ident).+, $what:literal) => {
                self.$($list).+.iter().map(|k| (k.plugin, $what, k.id.as_str(), k.text.as_str()))
            };
        }
        let commands = self.command_offers.commands.iter().map(|c| (c.plugin, "command", c.name(), c.text.as_str()));
        self.sensor_kinds()
            .map(|(_, k)| (k.plugin, "sensor", k.id.as_str(), k.text.as_str()))
            .chain(all!(actuators, "actuator"))
            .chain(all!(services, "service"))
            .chain(all!(model_offers.models, "model"))
            .chain(all!(importers, "importer"))
            .chain(commands)
    }
    /// Reports the faulty declarations of all plugins.
    pub(super) fn check_declarations(&mut self) {
        let mut all: Vec<(usize, String)> = Vec::new();
        let mut add = |plugin: usize, what: String, wrong: Vec<String>| {
            all.extend(wrong.into_iter().map(|w| (plugin, format!("{what}: {w}"))));
        };
        for s in &self.sensors {
            let what = if s.of_actuator { "actuator" } else { "sensor" };
            add(s.plugin, format!("the {what} `{}`", s.id), parameters(&s.params, true));
            let lacks = schemas::schema_differences(s).into_iter().map(|l| format!("it {l}")).collect();
            add(s.plugin, format!("the {what} `{}`", s.id), lacks);
        }
        for a in &self.actuators {
            let all: Vec<ParameterSpec> = a.params.iter().chain(&a.commands).cloned().collect();
            add(a.plugin, format!("the actuator `{}`", a.id), parameters(&all, true));
        }
        for s in &self.services {
            add(s.plugin, format!("the service `{}`", s.id), parameters(&s.params, true));
        }
        for l in &self.scripting.languages {
            add(l.plugin, format!("the language `{}`", l.id), parameters(&l.params, true));
            let required = l.params.iter().filter(|p| !p.optional());
            let required = required.map(|p| format!("its parameter `{}` has no default, and is not optional", p.key));
            add(l.plugin, format!("the language `{}`", l.id), required.collect());
        }
        for m in &self.model_offers.models {
            add(m.plugin, format!("the model `{}`", m.id), parameters(&m.params, true));
        }
        for i in &self.importers {
            add(i.plugin, format!("the importer `{}`", i.id), parameters(&i.params, true));
        }
        for c in &self.command_offers.commands {
            let name = c.name();
            add(c.plugin, format!("the command `{name}`"), parameters(&c.params, false));
            let values = c.params.iter().chain(&c.returns);
            add(c.plugin, format!("the command `{name}`"), values.filter_map(misspelt_unit).collect());
        }
        for (plugin, what, id, text) in self.described_items() {
            if text.is_empty() {
                add(plugin, format!("the {what} `{id}`"), vec!["it has no description (`text`)".to_owned()]);
            }
        }
        for (e, plugin) in self.events.iter().filter_map(|e| Some((e, e.plugin?))) {
            add(plugin, format!("the event `{}`", e.name), parameters(&e.fields, false));
        }
        for listener in &self.listeners {
            let unknown = listener.names.iter().filter(|name| !self.is_event(name)).map(|name| {
                let near = nearest(name, self.events.iter().map(|e| e.name.as_str()));
                let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                format!("it listens to the event `{name}`, which does not exist{near}")
            });
            all.extend(unknown.map(|text| (listener.plugin, text)));
        }
        for (plugin, text) in all {
            let p = &self.plugins[plugin];
            let text = format!("plugin `{}` ({}): {text}", p.id, p.path.display());
            self.load_report
                .refused
                .push(Error::new("E310", text).help("the rest of the plugin works; report this to its authors"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn param(key: &str) -> ParameterSpec {
        ParameterSpec {
            key: key.into(),
            kind: TATU_F64,
            count: 0,
            flags: 0,
            unit: None,
            lowest: f64::NEG_INFINITY,
            highest: f64::INFINITY,
            fallback: Value::Nil,
            unreadable_default: false,
            choices: Vec::new(),
            keys: Vec::new(),
            keys_cut: false,
            text: String::new(),
        }
    }

    #[test]
    fn each_faulty_declaration_is_reported_once() {
        let good = || param("range");
        let cases: Vec<(ParameterSpec, &str)> = vec![
            (ParameterSpec { lowest: 2.0, highest: 1.0, ..good() }, "from 2 to 1"),
            (ParameterSpec { lowest: 0.0, highest: 1.0, fallback: Value::Float(2.0), ..good() }, "default"),
            (ParameterSpec { kind: TATU_I64, fallback: Value::Float(2.5), ..good() }, "default"),
            (
                ParameterSpec { kind: TATU_TEXT, choices: vec!["a".into()], fallback: Value::text("b"), ..good() },
                "expected one of \"a\"",
            ),
            (ParameterSpec { kind: TATU_F64S, count: 3, fallback: Value::Floats(vec![1.0]), ..good() }, "default"),
            (ParameterSpec { kind: 77, ..good() }, "unknown type 77"),
            (ParameterSpec { kind: TATU_NIL, ..good() }, "unknown type 0"),
            (ParameterSpec { unreadable_default: true, ..good() }, "a default that cannot be read"),
            (
                ParameterSpec {
                    kind: TATU_BYTES,
                    choices: vec!["a".into()],
                    fallback: Value::Bytes(vec![1]),
                    ..good()
                },
                "expected one of",
            ),
            (ParameterSpec { kind: TATU_U8S, ..good() }, "unknown type 10"),
            (ParameterSpec { unit: Some("mm".into()), ..good() }, "was `m` meant?"),
            (ParameterSpec { choices: vec!["a".into()], ..good() }, "choices"),
            (param(""), "its parameter 1 has no key"),
            (param("a b"), "cannot be written"),
            (param("größe"), "cannot be written"),
        ];
        for (p, word) in cases {
            let found = parameters(std::slice::from_ref(&p), true);
            assert_eq!(found.len(), 1, "{p:?}: {found:?}");
            assert!(found[0].contains(word), "{found:?} lacks {word}");
        }
        assert_eq!(parameters(&[good(), good()], true).len(), 1);
        let rest = ParameterSpec { flags: TATU_PARAM_ANY, kind: TATU_NIL, ..good() };
        let whole =
            ParameterSpec { unit: Some("m".into()), lowest: 0.0, highest: 5.0, fallback: Value::Int(1), ..param("b") };
        let with_unit = |key: &str, unit: &str| ParameterSpec { unit: Some(unit.into()), ..param(key) };
        let right = [rest, whole, with_unit("c", "1"), with_unit("of_another_field", "furlong")];
        assert_eq!(parameters(&right, true), [""; 0]);
        assert_eq!(parameters(&[param("größe")], false), [""; 0], "commands are not written in scene files");
        assert_eq!(parameters(&[param("a b"), param("a\\n")], false).len(), 2);
    }
}
