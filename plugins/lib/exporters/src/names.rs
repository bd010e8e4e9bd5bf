//! Names that are valid and unique in a file.

use std::collections::{BTreeMap, BTreeSet};

/// The names of one kind of element, which must differ.
#[derive(Default)]
pub struct NameSpace {
    taken: BTreeSet<String>,
    /// The last number that was appended to a name.
    last: BTreeMap<String, u64>,
    /// Names that were changed: the wanted one and the one in the file.
    changed: Vec<(String, String)>,
}

impl NameSpace {
    /// Returns a name for an object: its own, without control characters and slashes, with a number if it is taken.
    pub fn name(&mut self, wanted: &str) -> String {
        let clean: String = wanted.trim().chars().map(|c| if c.is_control() || c == '/' { '_' } else { c }).collect();
        let clean = if clean.is_empty() { "unnamed".to_owned() } else { clean };
        let name = self.free(&clean);
        if name != wanted {
            self.changed.push((wanted.to_owned(), name.clone()));
        }
        name
    }

    /// Returns a name for an element that is no object of its own, which may get a number.
    pub fn derived(&mut self, wanted: &str) -> String {
        self.free(wanted)
    }

    fn free(&mut self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        if self.taken.contains(wanted) {
            let last = self.last.entry(wanted.to_owned()).or_insert(1);
            while self.taken.contains(&name) {
                *last += 1;
                name = format!("{wanted}_{last}");
            }
        }
        self.taken.insert(name.clone());
        name
    }

    /// Returns the names that were changed, as texts such as "`arm` is `arm_2`".
    pub fn changes(&self) -> impl Iterator<Item = String> {
        self.changed.iter().map(|(wanted, name)| format!("`{wanted}` is `{name}`"))
    }
}

/// Returns a name of a file: letters, digits, `-` and `_` of a name, others replaced.
pub fn file_name(name: &str) -> String {
    let part = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_') { c } else { '_' };
    let name: String = name.chars().take(80).map(part).collect();
    if name.is_empty() { "mesh".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_changes_are_listed() {
        let mut names = NameSpace::default();
        let all = ["arm", "arm", "a/b", "", "arm_2", "Süß \"<&>\""].map(|n| names.name(n));
        assert_eq!(all, ["arm", "arm_2", "a_b", "unnamed", "arm_2_2", "Süß \"<&>\""]);
        let changes: Vec<String> = names.changes().collect();
        assert_eq!(changes, ["`arm` is `arm_2`", "`a/b` is `a_b`", "`` is `unnamed`", "`arm_2` is `arm_2_2`"]);
    }

    #[test]
    fn file_names_hold_plain_characters_only() {
        assert_eq!(file_name("../a b"), "___a_b");
        assert_eq!(file_name(""), "mesh");
    }
}
