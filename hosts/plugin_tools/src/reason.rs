//! Why a plugin is not loaded, and what to do.

use std::{fmt, path::Path};

use serde_json::{Value, json};

/// What is wrong with a file, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RejectReason {
    /// A stable identifier for programs, such as `missing-library`.
    pub kind: &'static str,
    /// Description of the problem; the file is referred to as "it".
    pub text: String,
    /// What the user can do about the problem.
    pub help: String,
}

impl RejectReason {
    pub fn new(kind: &'static str, text: impl Into<String>, help: impl Into<String>) -> Self {
        RejectReason { kind, text: text.into(), help: help.into() }
    }

    pub fn json(&self) -> Value {
        json!({ "kind": self.kind, "text": self.text, "help": self.help })
    }

    /// Replaces the file's path in the texts, for a file that was examined under a different name.
    pub fn renamed(mut self, from: &Path, to: &Path) -> Self {
        let [from, to] = [from, to].map(|p| p.display().to_string());
        self.text = self.text.replace(&from, &to);
        self.help = self.help.replace(&from, &to);
        self
    }
}

impl fmt::Display for RejectReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\nhelp: {}", self.text, self.help)
    }
}

/// Formats names for a sentence: "`a`, `b` and 3 more".
pub fn list_some(names: &[impl AsRef<str>], most: usize) -> String {
    let shown: Vec<String> = names.iter().take(most).map(|n| format!("`{}`", n.as_ref())).collect();
    match (shown.split_last(), names.len().saturating_sub(most)) {
        (None, _) => String::new(),
        (Some(_), left @ 1..) => format!("{} and {left} more", shown.join(", ")),
        (Some((last, [])), 0) => last.clone(),
        (Some((last, rest)), 0) => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_list_ends_with_count_of_omitted_ones() {
        assert_eq!(list_some(&["a"], 3), "`a`");
        assert_eq!(list_some(&["a", "b"], 3), "`a` and `b`");
        assert_eq!(list_some(&["a", "b", "c"], 3), "`a`, `b` and `c`");
        assert_eq!(list_some(&["a", "b", "c", "d", "e"], 3), "`a`, `b`, `c` and 2 more");
        assert_eq!(list_some(&[] as &[&str], 3), "");
    }
}
