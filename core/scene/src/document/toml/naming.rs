//! Names of models, and the files that they lead to.

use std::path::{Path, PathBuf};

use tatu_errors::Error;
use tatu_plugins::{MODEL_FILE, Registry};
use toml_edit::Item;

use super::super::sources::Sources;

/// The name under which a document remembers where a model was found, so that it finds the same one again without the
/// disk. No file has it.
pub(super) fn remembered(id: &str) -> PathBuf {
    Path::new("<models>").join(id)
}

/// Returns whether a scene file describes a model with parameters.
pub(super) fn describes_model(text: &str) -> bool {
    text.contains("[model")
        && toml_edit::Document::parse(text).is_ok_and(|doc| matches!(doc.get("model"), Some(Item::Table(_))))
}

/// Finds a model by its name in the folders for models, or where it was found the first time; returns its file.
pub(super) fn find(id: &str, registry: &Registry, sources: &Sources) -> Option<PathBuf> {
    match sources.are_kept() {
        true => sources.read_text(&remembered(id)).ok().map(PathBuf::from),
        false => registry.find_model(id).map(|f| f.file),
    }
}

/// Returns the error for the file of a model that cannot be read.
pub(super) fn unreadable(id: &str, file: &Path, why: &std::io::Error) -> Error {
    Error::new("E105", format!("cannot read the model `{id}`: {why}")).expected(format!("a file {}", file.display()))
}

/// Returns the name of the model in a file: that of its folder, or of the file.
pub(super) fn name_of(file: &Path) -> String {
    let folder = file.parent().and_then(Path::file_name);
    let named = if file.file_name().is_some_and(|n| n == MODEL_FILE) { folder } else { None };
    named.or(file.file_stem()).map_or("model".into(), |s| s.to_string_lossy().into_owned())
}
