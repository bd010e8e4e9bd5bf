//! The text of a URDF file, expanded if it is a xacro file.

use std::borrow::Cow;

use tatu_importers_xacro::{Arguments, Expansion, Files, expand};
use tatu_plugin_api::{
    abi::TATU_REPORT_NOTE,
    safe::{Builder, Fail, Result},
};

/// A text, and where its lines come from.
pub struct SourceText<'t> {
    /// The text of the robot.
    pub text: Cow<'t, str>,
    expansion: Option<Expansion>,
}

/// The name of the file itself in errors of its expansion.
const OWN_NAME: &str = "";

/// Gives a file that is being expanded the files that it includes.
struct IncludedFiles<'w, 'b>(&'w Builder<'b>);

impl Files for IncludedFiles<'_, '_> {
    fn read(&mut self, path: &str) -> std::result::Result<Vec<u8>, String> {
        let missing = || format!("`{path}` does not exist, or its package was not found (`--package-path`)");
        self.0.file(path).map(<[u8]>::to_vec).ok_or_else(missing)
    }

    fn list(&mut self, _: &str) -> std::result::Result<Vec<String>, String> {
        Err("names with `*` and `?` cannot be included here".to_owned())
    }
}

impl<'t> SourceText<'t> {
    /// Returns the text of a file. A xacro file is expanded with `arguments`, in the form `name:=value name:=value`.
    pub fn new(text: &'t str, arguments: &str, builder: &Builder<'_>) -> Result<Self> {
        let uses_macros = ["<xacro:", "${", "$("].iter().any(|mark| text.contains(mark));
        if !uses_macros || !text.contains("xacro") {
            return Ok(SourceText { text: text.into(), expansion: None });
        }
        let arguments = parse_arguments(arguments)?;
        let expansion =
            expand(OWN_NAME, text.as_bytes(), &arguments, &mut IncludedFiles(builder)).map_err(|error| {
                let fail = Fail::argument(format!("the xacro file cannot be expanded: {}", error.message));
                match error.place {
                    Some(place) => fail.at(&place.file, u64::from(place.line)),
                    None => fail,
                }
            })?;
        for note in &expansion.notes {
            let place = note.first.as_ref().map_or(String::new(), |p| format!("line {}: ", p.line));
            let others = if note.count > 1 { format!(" ({} times)", note.count) } else { String::new() };
            builder.report(TATU_REPORT_NOTE, None, &format!("{place}{}{others}", note.message));
        }
        Ok(SourceText { text: expansion.text.clone().into(), expansion: Some(expansion) })
    }

    /// Returns the file and line from which a line of the text comes. The name of the file itself is empty.
    pub fn origin(&self, line: u64) -> (&str, u64) {
        let line_ = u32::try_from(line).unwrap_or(0);
        match self.expansion.as_ref().and_then(|expansion| expansion.origin(line_)) {
            Some((file, line)) => (file, u64::from(line)),
            None => (OWN_NAME, line),
        }
    }

    /// Returns an error with the place in the source instead of the place in the expanded text.
    pub fn located(&self, error: Fail) -> Fail {
        let Some(line) = error.place().map(|(_, line)| line) else { return error };
        let (file, line) = self.origin(line);
        error.at(file, line)
    }
}

/// Parses `name:=value name:=value`.
fn parse_arguments(text: &str) -> Result<Arguments> {
    let pair = |word: &str| match word.split_once(":=") {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err(Fail::argument(format!("`arguments`: expected `name:=value`, found `{word}`"))),
    };
    let pairs: Vec<(String, String)> = text.split_whitespace().map(pair).collect::<Result<_>>()?;
    Ok(pairs.into_iter().collect())
}
