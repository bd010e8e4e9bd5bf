//! Import of files in other formats, by importers that use the builder.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugin_api::safe::Value;
use tatu_plugins::{BuildFunction, ImporterChoice, border::ErrorContents, watchdog::PluginCall};

use super::{
    BuildReport, DocumentBuilder,
    import_files::BuildSource,
    plugin_builder::{BuildCall, BuildFailure, run_build},
};

/// A file to import.
pub(super) struct ImportRequest<'a> {
    /// Path of the file.
    pub file: &'a Path,
    /// Contents of the file.
    pub bytes: &'a [u8],
    /// The chosen importer.
    pub choice: ImporterChoice,
    /// Specified parameters of the importer, by key.
    pub params: &'a [(String, Value)],
    /// Whether the file is the scene itself rather than a part of it. If so, its settings and its main script apply,
    /// and its objects belong to the scene.
    pub is_scene: bool,
}

/// Reads a file to import. `name` is the name of the file as written in the scene, for error messages.
pub(super) fn read_import_file(b: &DocumentBuilder<'_>, file: &Path, name: &str) -> Result<Vec<u8>> {
    b.document.sources.read(&b.allow_file(file, name)?).map_err(|e| {
        Error::new("E105", format!("cannot read the import `{name}`: {e}"))
            .expected(format!("a file {}", file.display()))
    })
}

impl DocumentBuilder<'_> {
    /// Imports a file; returns the index of the first object, which is the base. The importer can read the files that
    /// the document may name.
    pub(super) fn import(
        &mut self,
        import: ImportRequest<'_>,
        parent: Option<usize>,
        placement: Isometry3<f64>,
    ) -> Result<usize> {
        let registry = self.registry;
        let info = &registry.importers[import.choice.importer];
        let folder = import.file.parent().map(PathBuf::from).unwrap_or_default();
        let shown = import.file.display().to_string();
        self.document
            .reports
            .extend(import.choice.notes.iter().map(|note| BuildReport::note(format!("{shown}: {note}"))));
        let first = self.document.objects.len();
        let group = match import.is_scene {
            true => 0,
            false => self.document.new_group(),
        };
        let outer = std::mem::replace(&mut self.group, group);
        self.record_model(&info.params);
        let from = BuildSource { name: Some(shown.clone()), folder: Some(folder), is_scene: import.is_scene };
        let (function, subject) = (BuildFunction::Importer(info, import.bytes), format!("the import of {shown}"));
        let asked = BuildCall { function, call: PluginCall::Import, subject: &subject };
        let done = run_build(self, asked, from, (&info.params, import.params), parent);
        self.group = outer;
        let who = format!("{} of `{}`", PluginCall::Import.text(), registry.plugins[info.plugin].id);
        done.map_err(|failed| import_error((&info.id, &who), import.file, import.bytes, self.place.as_ref(), failed))?;
        let nothing =
            || Error::new("E120", format!("cannot import {shown}: the importer `{}` found nothing in it", info.id));
        self.place_model(first, placement).ok_or_else(nothing)
    }
}

/// Returns the error of a failed import: the host's refusal or the plugin's message, located at the file and line that
/// the plugin reported. If it reported no file name, the location is in the imported file itself.
fn import_error(
    (id, who): (&str, &str),
    file: &Path,
    bytes: &[u8],
    from: Option<&SourceLocation>,
    failed: BuildFailure,
) -> Error {
    let (refused, slot) = match failed {
        BuildFailure::ContractBreach(e) => return e,
        BuildFailure::HostError(e) => (Some(e), None),
        BuildFailure::PluginError(slot) => (None, Some(slot)),
    };
    let said = slot.as_ref().map(|s| s.contents());
    let (named, line) = said.as_ref().map_or_else(Default::default, |s| (s.file.clone(), s.line as usize));
    let (text, help) = match (&refused, said) {
        (Some(e), _) => {
            (e.text.clone(), e.help.clone().or_else(|| e.expected.clone().map(|x| format!("expected {x}"))))
        }
        (None, Some(ErrorContents { text: Some(text), help, .. })) => (text, help),
        _ => (format!("`{id}` gave no reason"), None),
    };
    let place = match named {
        None => SourceLocation::of_line(file.to_owned(), bytes, line),
        // The contents of other files are not available here, so the location has no byte range.
        Some(named) => SourceLocation::of_line(file.with_file_name(named), &[], line),
    };
    // An error without a line may be a fault of the plugin, so the message names the plugin.
    let (line, who) = if line > 0 { (format!(":{line}"), String::new()) } else { (String::new(), format!(" [{who}]")) };
    let error = Error::new("E120", format!("cannot import {}{line}: {text}{who}", place.file.display()));
    let wanted = from.filter(|p| p.line > 0).map(|p| format!("imported in {}:{}", p.file.display(), p.line));
    let error = match [help, wanted].into_iter().flatten().collect::<Vec<_>>() {
        parts if parts.is_empty() => error,
        parts => error.help(parts.join("; ")),
    };
    error.at(Some(place))
}
