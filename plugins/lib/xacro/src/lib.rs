//! Expands xacro files, the macro language of ROS for XML, to plain XML: see `README.md` for what is supported.
//!
//! - `error`: errors with places; `limits`: bounds; `notes`: what deserves mention;
//! - `value`: values of expressions; `expression`: expressions; `yaml`: files with parameters;
//! - `template`: texts with `${...}`; `literal`: texts that are numbers; `parameters`: those of macros;
//! - `files`: where included files come from; `source`: elements of files;
//! - `scopes`: properties and macros by name; `expander`: expands elements; `write`: writes them.

mod error;
mod expander;
mod expression;
mod files;
mod limits;
mod literal;
mod notes;
mod parameters;
mod scopes;
mod source;
mod template;
#[cfg(test)]
mod tests;
mod value;
mod write;
mod yaml;

use std::collections::BTreeMap;

pub use error::{Place, XacroError};
pub use files::{Files, NoFiles};
pub use limits::Limits;

use error::{Fault, Origin};
use expander::Expander;
use source::SourceFile;

/// Values of arguments that replace the defaults of a file (`name:=value`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Arguments(BTreeMap<String, String>);

impl Arguments {
    /// No arguments: the defaults of the file apply.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets an argument.
    pub fn set(&mut self, name: impl Into<String>, value: impl Into<String>) {
        self.0.insert(name.into(), value.into());
    }
}

impl<N: Into<String>, V: Into<String>> FromIterator<(N, V)> for Arguments {
    fn from_iter<I: IntoIterator<Item = (N, V)>>(pairs: I) -> Self {
        Arguments(pairs.into_iter().map(|(name, value)| (name.into(), value.into())).collect())
    }
}

/// Something that the user should know about an expanded file. Each kind is mentioned once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// What was noticed, in the first case.
    pub message: String,
    /// The number of cases.
    pub count: usize,
    /// The place of the first case.
    pub first: Option<Place>,
}

/// An expanded file.
#[derive(Clone, Debug)]
pub struct Expansion {
    /// Plain XML, one element per line.
    pub text: String,
    /// What deserves mention.
    pub notes: Vec<Note>,
    /// The arguments that the file declares or uses, with their values.
    pub arguments: Vec<(String, String)>,
    /// The names of the XML files that were read; the first is the file itself.
    pub files: Vec<String>,
    lines: Vec<(u32, u32)>,
}

impl Expansion {
    /// The file and the line, from 1, from which a line of the text comes, also from 1.
    pub fn origin(&self, line: u32) -> Option<(&str, u32)> {
        let (file, line) = *self.lines.get(line.checked_sub(1)? as usize)?;
        Some((self.files.get(file as usize)?, line))
    }
}

/// Expands a file within the usual limits. `name` is its path, to which the names of other files are relative.
///
/// # Errors
/// The file, or one that it includes, has a flaw, or exceeds a limit.
pub fn expand(name: &str, bytes: &[u8], arguments: &Arguments, files: &mut dyn Files) -> Result<Expansion, XacroError> {
    expand_within(Limits::default(), name, bytes, arguments, files)
}

/// Expands a file within given limits.
///
/// # Errors
/// As those of [`expand`].
pub fn expand_within(
    limits: Limits,
    name: &str,
    bytes: &[u8],
    arguments: &Arguments,
    files: &mut dyn Files,
) -> Result<Expansion, XacroError> {
    let mut expander = Expander::new(limits, arguments.0.clone(), files);
    let root = expander.expand_file(name, bytes).map_err(|fault| located(&fault, &expander.sources))?;
    for unused in arguments.0.keys().filter(|name| !expander.known_arguments.contains(*name)) {
        expander.notes.add(unused, &format!("the file has no argument `{unused}`"), None);
    }
    let written = write::write(&root, &expander.sources, expander.budget.limits.result_bytes)
        .map_err(|fault| located(&fault, &expander.sources))?;
    for prefix in &written.undeclared {
        let message = format!("the prefix `{prefix}:` is not declared by xmlns:{prefix}");
        expander.notes.add(&message, &message, Some(root.origin));
    }
    let Expander { sources, notes, mut arguments, known_arguments, .. } = expander;
    arguments.retain(|name, _| known_arguments.contains(name));
    let notes = notes.list.into_iter();
    Ok(Expansion {
        text: written.text,
        notes: notes
            .map(|note| Note {
                first: note.first.and_then(|origin| place(origin, &sources)),
                message: note.message,
                count: note.count,
            })
            .collect(),
        arguments: arguments.into_iter().collect(),
        files: sources.iter().map(|source| source.name.to_string()).collect(),
        lines: written.lines,
    })
}

fn place(origin: Origin, sources: &[SourceFile]) -> Option<Place> {
    Some(sources.get(origin.file as usize)?.place(origin.offset))
}

fn located(fault: &Fault, sources: &[SourceFile]) -> XacroError {
    let trace = fault.trace.iter().filter_map(|(what, origin)| Some((what.clone(), place(*origin, sources)?)));
    XacroError {
        message: fault.message.clone(),
        place: fault.origin.and_then(|origin| place(origin, sources)),
        trace: trace.collect(),
    }
}
