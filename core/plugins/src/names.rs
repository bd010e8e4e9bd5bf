//! Checks of the names that plugins declare, and of their name spaces.

use std::collections::BTreeMap;

use tatu_errors::Error;

use super::{
    Registry,
    texts::{HELP, flaw},
};

/// Maximum number of names of a command, because the numbers of the command and of its name share one word.
pub(super) const MAX_NAMES: usize = 255;

/// Name spaces of commands that extend the program, such as writers of files, to which all plugins may add.
const SHARED_NAME_SPACES: [&str; 3] = ["export", "message", "subcommand"];
const NAME_SPACE_HELP: &str = "give it a separate name space, such as `mine.name`";

impl Registry {
    /// Returns the index of the plugin that owns a command or constant, `usize::MAX` for the command whose names are
    /// being read, or `None` for an unknown name.
    fn owner(&self, name: &str) -> Option<usize> {
        let command =
            self.command_offers.names.get(name).map(|(id, _)| self.command_offers.commands.get(*id as usize - 1));
        let command = command.map(|c| c.map_or(usize::MAX, |c| c.plugin));
        command.or_else(|| self.scripting.constants.get(name).map(|c| c.plugin))
    }

    /// Returns the names of commands, then those of constants, that begin with a prefix.
    fn names_with_prefix<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = &'a str> {
        let names = self.command_offers.names.range(prefix.to_owned()..).map(|(n, _)| n.as_str());
        let constants = self.scripting.constants.range(prefix.to_owned()..).map(|(n, _)| n.as_str());
        let here = move |n: &&str| n.starts_with(prefix);
        names.take_while(here).chain(constants.take_while(here))
    }

    /// Returns why a command cannot have this name, and a hint.
    pub(super) fn command_name_flaw(&self, plugin: usize, name: &str) -> Option<(String, &'static str)> {
        if let Some(flaw) = flaw(name) {
            return Some((format!("its command `{name}` has an invalid name: it {flaw}"), HELP));
        }
        if let Some(owner) = self.owner(name) {
            return Some(match self.plugins.get(owner).filter(|_| owner != plugin) {
                None => (
                    format!("it offers the command `{name}` twice; the first one is used"),
                    "give each a different name",
                ),
                Some(other) => (format!("its command `{name}` is already offered by `{}`", other.id), NAME_SPACE_HELP),
            });
        }
        self.name_conflict(plugin, name).map(|why| (format!("its command `{name}` {why}"), NAME_SPACE_HELP))
    }

    /// Returns why a constant cannot have this name, and a hint. Duplicate names within a plugin are permitted.
    pub(super) fn constant_name_flaw(&self, plugin: usize, name: &str) -> Option<(String, &'static str)> {
        if let Some(flaw) = flaw(name) {
            return Some((format!("its constant `{name}` has an invalid name: it {flaw}"), HELP));
        }
        if let Some(owner) = self.owner(name) {
            let other = &self.plugins.get(owner).filter(|_| owner != plugin)?.id;
            return Some((format!("its constant `{name}` is already offered by `{other}`"), NAME_SPACE_HELP));
        }
        self.name_conflict(plugin, name).map(|why| (format!("its constant `{name}` {why}"), NAME_SPACE_HELP))
    }

    /// Returns why a name conflicts with the existing ones, if it does. For example, `reg` and `reg.b` cannot both
    /// exist, because `reg` would be both a value and a name space.
    fn name_conflict(&self, plugin: usize, name: &str) -> Option<String> {
        let of = |other: &str| match self.owner(other) {
            Some(owner) if owner != plugin && owner < self.plugins.len() => {
                format!("`{other}` of `{}`", self.plugins[owner].id)
            }
            _ => format!("`{other}` of the same plugin"),
        };
        if let Some(other) = self.names_with_prefix(&format!("{name}.")).next() {
            return Some(format!("is also the name space of {}, which it would hide", of(other)));
        }
        let mut above = name.match_indices('.').map(|(at, _)| &name[..at]);
        let other =
            above.find(|n| self.command_offers.names.contains_key(*n) || self.scripting.constants.contains_key(*n))?;
        Some(format!("could not be reached: {} is not a name space", of(other)))
    }

    /// Reports, once per name space, that a plugin which does not come with the program adds names to another plugin's
    /// name space. This may be intended.
    pub(super) fn report_foreign_names(&mut self, plugin: usize) {
        if self.is_of_program(plugin) {
            return;
        }
        let mine = |name: &str| self.owner(name) == Some(plugin);
        let mut found: BTreeMap<&str, (Vec<&str>, usize)> = BTreeMap::new();
        for name in self.command_offers.names.keys().chain(self.scripting.constants.keys()).filter(|n| mine(n)) {
            let Some((space, _)) = name.split_once('.').filter(|(space, _)| !SHARED_NAME_SPACES.contains(space)) else {
                continue;
            };
            if let Some((names, _)) = found.get_mut(space) {
                names.push(name);
                continue;
            }
            let prefix = format!("{space}.");
            let other = self.names_with_prefix(&prefix).filter_map(|n| self.owner(n)).find(|owner| *owner != plugin);
            if let Some(other) = other {
                found.insert(space, (vec![name], other));
            }
        }
        let p = &self.plugins[plugin];
        let tell = |(space, (names, other)): (&str, (Vec<&str>, usize))| {
            let more = match names.len() {
                1 => String::new(),
                n => format!(" and {} more", n - 1),
            };
            let text = format!(
                "plugin `{}` ({}): its `{}`{more} is in the name space `{space}` of `{}`",
                p.id,
                p.path.display(),
                names[0],
                self.plugins[other].id
            );
            Error::new("E310", text)
                .help("do nothing if this is intended; otherwise give it a separate name space, such as `mine.name`")
        };
        let told: Vec<Error> = found.into_iter().map(tell).collect();
        self.load_report.refused.extend(told);
    }
}

/// Returns whether a language can require this permission: a word that users can write after `--allow` and that has no
/// other meaning there.
pub(super) fn is_permission(word: &str) -> bool {
    let plain = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_';
    word.starts_with(|c: char| c.is_ascii_lowercase()) && word.bytes().all(plain) && !matches!(word, "net" | "plugins")
}

#[cfg(test)]
mod tests {
    use super::flaw;

    #[test]
    fn names_with_invisible_characters_are_refused() {
        for good in ["mine.getObject", "smell/1", "a-b", "größe", "_"] {
            assert_eq!(flaw(good), None, "{good}");
        }
        for (bad, why) in
            [("", "empty"), ("a b", "space"), ("a\u{a0}b", "space"), ("a\\n", "control"), ("\\xff", "UTF-8")]
        {
            assert!(flaw(bad).is_some_and(|f| f.contains(why)), "{bad}");
        }
    }
}
