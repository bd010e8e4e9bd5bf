//! Names of models, and the files that they refer to.

use std::path::{Path, PathBuf};

use tatu_errors::Error;
use tatu_plugins::{MODEL_FILE, Registry};
use toml_edit::Item;

use super::super::sources::SourceFiles;

/// Returns the key under which the sources of a document store the path of a model's file, by which the model is found
/// when the document is rebuilt without the disk. It is not the path of an actual file.
pub(super) fn stored_model_key(id: &str) -> PathBuf {
    Path::new("<models>").join(id)
}

/// Returns whether a scene file describes a model with parameters.
pub(super) fn describes_model(text: &str) -> bool {
    text.contains("[model")
        && toml_edit::Document::parse(text).is_ok_and(|doc| matches!(doc.get("model"), Some(Item::Table(_))))
}

/// Returns the file of a model by name: the stored path if the sources are closed, otherwise the file in the model
/// folders.
pub(super) fn find_model_file(id: &str, registry: &Registry, sources: &SourceFiles) -> Option<PathBuf> {
    match sources.are_closed() {
        true => Some(PathBuf::from(String::from_utf8(sources.cached(&stored_model_key(id))?.to_vec()).ok()?)),
        false => registry.find_model(id).map(|f| f.file),
    }
}

/// Returns the error for the file of a model that cannot be read.
pub(super) fn unreadable(id: &str, file: &Path, why: &std::io::Error) -> Error {
    Error::new("E105", format!("cannot read the model `{id}`: {why}")).expected(format!("a file {}", file.display()))
}

/// Returns the name of the model in a file: the name of its folder if the file has the standard name, or that of the
/// file.
pub(super) fn name_of(file: &Path) -> String {
    let folder = file.parent().and_then(Path::file_name);
    let named = if file.file_name().is_some_and(|n| n == MODEL_FILE) { folder } else { None };
    named.or(file.file_stem()).map_or("model".into(), |s| s.to_string_lossy().into_owned())
}
