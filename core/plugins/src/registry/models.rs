//! Models: those in plugins' tables, and those in folders, either as text or as files that importers read.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugin_api::{
    abi::*,
    safe::{MAX_FILE_BYTES, read_plain_text},
};

use super::{AttachmentSlot, ListedModel, Model, ModelNumber, Registry};
use crate::{
    ParameterSpec,
    border::{ErrorSlot, raw},
    declared::Declared,
    tables,
    watchdog::PluginCall,
};

/// The file in the folder of a model that describes it.
pub const MODEL_FILE: &str = "model.toml";

/// A model in one of the model folders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundModel {
    /// Id of the model in scene files, which is the name of its folder or file.
    pub id: String,
    /// The folder of models that contains it.
    pub folder: PathBuf,
    /// The file that describes the model.
    pub file: PathBuf,
    /// Index of the importer that reads the file; `None` for a [`MODEL_FILE`].
    pub importer: Option<usize>,
}

/// Reads the declaration of a model from its table.
pub(super) fn read_declaration(plugin: usize, id: String, raw: &Declared<'_, tatu_model>) -> Model {
    let infos: Vec<AttachmentSlot> = raw.slot_infos().iter().map(slot).collect();
    let slots = raw.slots().into_iter().map(|alias| {
        let info = infos.iter().find(|s| s.alias == alias).cloned();
        info.unwrap_or(AttachmentSlot { alias, ..AttachmentSlot::default() })
    });
    let number = |n: &Declared<'_, tatu_model_number>| ModelNumber {
        name: n.name().unwrap_or_default(),
        value: n.value().to_value().unwrap_or_default(),
        unit: n.unit().unwrap_or_default(),
        source: n.source().unwrap_or_default(),
    };
    Model {
        plugin,
        id,
        text: raw.text().unwrap_or_default(),
        params: ParameterSpec::read_list(&raw.params()),
        category: raw.category().unwrap_or_default(),
        licence: raw.licence().unwrap_or_default(),
        mounts: raw.mounts(),
        slots: slots.collect(),
        numbers: raw.numbers().iter().map(number).collect(),
        file: None,
        given: raw.given(),
        raw: **raw,
    }
}

fn slot(s: &Declared<'_, tatu_model_slot>) -> AttachmentSlot {
    AttachmentSlot {
        alias: s.alias().unwrap_or_default(),
        mount: s.mount().unwrap_or_default(),
        text: s.text().unwrap_or_default(),
        payload: s.payload,
    }
}

impl Registry {
    /// Returns whether a plugin reads models from text.
    pub fn reads_models(&self, plugin: usize) -> bool {
        self.model_offers.model_readers.iter().any(|(p, _)| *p == plugin)
    }

    /// Returns the index of the first plugin that reads models from text, or `None` if there is none.
    pub fn model_reader(&self) -> Option<usize> {
        self.model_offers.model_readers.first().map(|(plugin, _)| *plugin)
    }

    /// Reads a model from the text of a file, with the first plugin that supports its format. `name` is the id of the
    /// model. Errors include the line if the plugin reports one.
    pub fn read_model(&self, name: &str, file: &Path, text: &str) -> Result<Model> {
        for (plugin, read) in self.model_offers.model_readers.iter().copied() {
            let (mut slot, mut out) = (ErrorSlot::new(), std::ptr::null());
            let (loaded, subject) = (&self.plugins[plugin], format!("the model {}", file.display()));
            // SAFETY: `read` is from a plugin that is never unloaded, and `me` is its own pointer. The texts, `out` and
            // the error object live until the call has returned.
            let status = self.call_plugin(plugin, PluginCall::ReadModel, &subject, || unsafe {
                read(loaded.me, raw(name.as_bytes()), raw(text.as_bytes()), &raw mut out, slot.raw())
            })?;
            if status == TATU_ERR_UNSUPPORTED {
                continue;
            }
            let who = format!("[{} of `{}`]", PluginCall::ReadModel.text(), self.plugins[plugin].id);
            if slot.check_status(status, false) < 0 {
                let said = slot.contents();
                let why = said.text.unwrap_or_else(|| "its plugin gave no reason".to_owned());
                // An error without a line may be the plugin's own.
                let who = if said.line > 0 { String::new() } else { format!(" {who}") };
                let error = Error::new("E111", format!("the model `{name}` cannot be read: {why}{who}"));
                let error = match said.help {
                    Some(help) => error.help(help),
                    None => error,
                };
                return Err(error.at(Some(SourceLocation::of_line(
                    file.to_owned(),
                    text.as_bytes(),
                    said.line as usize,
                ))));
            }
            // SAFETY: the contract requires the model to be null or a table that is valid until the plugin is shut down.
            let Some(table) = (unsafe { Declared::at(out) }) else {
                let text = format!("the model `{name}` cannot be read: its plugin returned no model {who}");
                return Err(Error::new("E111", text));
            };
            let needed = tables::required!(table, tatu_model: id, build);
            if let Some(lack) = tables::lacking(table.size, &needed) {
                let text = format!("the model `{name}` {lack} {who}");
                return Err(Error::new("E111", text).help(tables::HELP));
            }
            let model = read_declaration(plugin, name.to_owned(), &table);
            return Ok(Model { file: Some(file.to_owned()), ..model });
        }
        let text = format!("no plugin reads the model {}", file.display());
        Err(Error::new("E111", text)
            .expected("a file with a table [model]")
            .help("`tatu list plugins` shows what is loaded"))
    }

    /// Finds a model by name in the model folders. The first folder that contains the model takes precedence.
    pub fn find_model(&self, id: &str) -> Option<FoundModel> {
        if id.is_empty() || id.starts_with('.') || id.contains(['/', '\\', ':']) {
            return None;
        }
        self.search.models.iter().find_map(|folder| {
            let file = folder.join(id).join(MODEL_FILE);
            // A file that cannot be read is also found, because the reason is reported when the model is read.
            if file.symlink_metadata().is_ok() {
                return Some(FoundModel { id: id.to_owned(), folder: folder.clone(), file, importer: None });
            }
            let importers = self.importers.iter().enumerate();
            let mut suffixes = importers.flat_map(|(i, info)| info.suffixes.iter().map(move |s| (i, s)));
            suffixes.find_map(|(importer, suffix)| {
                let name = format!("{id}{suffix}");
                let file = [folder.join(&name), folder.join(id).join(&name)].into_iter().find(|f| f.is_file())?;
                Some(FoundModel { id: id.to_owned(), folder: folder.clone(), file, importer: Some(importer) })
            })
        })
    }

    /// Returns the model with an index in the list of all models. Models of plugins come first, followed by those in
    /// folders, which are read when the first of them is requested. Models that cannot be read are omitted.
    pub fn model_at(&self, index: usize) -> Option<ListedModel> {
        if let Some(model) = self.model_offers.models.get(index) {
            return Some(ListedModel::of(model));
        }
        let found = self.model_offers.folder_models.get_or_init(|| {
            let described = |f: FoundModel| match f.importer.and_then(|i| self.importers.get(i)) {
                Some(importer) => Some(ListedModel { id: f.id, text: importer.text.clone(), category: String::new() }),
                None => {
                    let text = read_plain_text(&f.file, MAX_FILE_BYTES).ok()?;
                    self.read_model(&f.id, &f.file, &text).ok().map(|m| ListedModel::of(&m))
                }
            };
            // A model that a plugin also offers is already in the list.
            let new = self.found_models().into_iter().filter(|f| self.model_offers.models.iter().all(|m| m.id != f.id));
            new.filter_map(described).collect()
        });
        found.get(index - self.model_offers.models.len()).cloned()
    }

    /// Returns the models in all model folders, in ascending order of their names.
    pub fn found_models(&self) -> Vec<FoundModel> {
        let mut ids = BTreeSet::new();
        for entry in self.search.models.iter().filter_map(|f| std::fs::read_dir(f).ok()).flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let suffixes = self.importers.iter().flat_map(|i| &i.suffixes);
            ids.extend(suffixes.filter_map(|s| name.strip_suffix(s.as_str())).map(str::to_owned));
            ids.insert(name);
        }
        ids.iter().filter_map(|id| self.find_model(id)).collect()
    }
}
