//! Lookup of models by name, and models that are described by text.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugins::{Model, parameter_flaws};

use super::{
    super::{DocumentBuilder, reach::AllowedFolders},
    SceneFileReader,
    naming::{describes_model, find_model_file, name_of, stored_model_key, unreadable},
};

/// What the name of a model refers to.
pub(super) enum ModelSource {
    /// The model of a plugin, by index in the registry.
    Plugin(usize),
    /// A model that a plugin has read from text.
    Text(Box<Model>),
    /// A scene file without a table `[model]`.
    Scene(PathBuf),
    /// A file in a different format, which an importer reads.
    File(PathBuf),
}

impl SceneFileReader<'_> {
    /// Resolves the name of a model. A name that ends with `.toml` refers to a file, and any other name to a model of a
    /// plugin or in one of the model folders. Also returns the files that the model may name.
    pub(super) fn resolve_model(&self, b: &DocumentBuilder<'_>, id: &str) -> Result<(ModelSource, AllowedFolders)> {
        let reach = b.reach.clone();
        if id.ends_with(".toml") {
            let file = self.text.file.parent().unwrap_or(Path::new("")).join(id);
            let allowed = b.allow_file(&file, id)?;
            let text = b.document.sources.read_text(&allowed).map_err(|e| unreadable(id, &file, &e))?;
            return match describes_model(&text) {
                true => Ok((ModelSource::Text(Box::new(self.read_model(&name_of(&file), &file, &text)?)), reach)),
                false => Ok((ModelSource::Scene(file), reach)),
            };
        }
        let sources = &b.document.sources;
        let found = find_model_file(id, self.registry, sources);
        let by = found.as_ref().and_then(|file| self.plugin_for(file));
        if let Some(index) = self.registry.model(id, by, &b.document.settings.providers)? {
            return Ok((ModelSource::Plugin(index), reach));
        }
        let Some(file) = found else { return Err(Error::new("E107", format!("there is no model `{id}`"))) };
        let reach = self.reach_of(b, id, &file)?;
        if !sources.are_closed() {
            sources.add_file(&stored_model_key(id), file.to_string_lossy().into_owned().into_bytes());
        }
        if file.extension().is_none_or(|e| e != "toml") {
            return Ok((ModelSource::File(file), reach));
        }
        let allowed = reach.file(&file, id, sources.are_closed())?;
        let text = sources.read_text(&allowed).map_err(|e| unreadable(id, &file, &e))?;
        Ok((ModelSource::Text(Box::new(self.read_model(id, &file, &text)?)), reach))
    }

    /// Returns the files that a model found by its name may name. If it was found in a folder that the user or the
    /// program has chosen, these include those in its own folder. Models beside a scene come with the scene, and may
    /// name what the scene may.
    fn reach_of(&self, b: &DocumentBuilder<'_>, id: &str, file: &Path) -> Result<AllowedFolders> {
        // In a stored document, the path of the model is what the document claims.
        let Some(found) = self.registry.find_model(id).filter(|found| found.file == file) else {
            return Ok(b.reach.clone());
        };
        let own = file.parent().unwrap_or(Path::new(""));
        if !self.registry.search.is_beside_scene(&found.folder) {
            return Ok(b.reach.with_model_folder(own));
        }
        match b.reach.contains(&found.folder) {
            true => Ok(b.reach.clone()),
            // The folder is above that of a model that was opened as a scene.
            false if b.reach.with_model_folder(&found.folder).contains(own) => Ok(b.reach.with_model_folder(own)),
            false => Err(b.reach.outside_error(id)),
        }
    }

    fn read_model(&self, name: &str, file: &Path, text: &str) -> Result<Model> {
        let model = self.registry.read_model(name, file, text)?;
        match parameter_flaws(&model.params, true).into_iter().next() {
            None => Ok(model),
            Some(flaw) => {
                let place = SourceLocation { file: file.to_owned(), ..SourceLocation::default() };
                Err(Error::new("E111", format!("the model `{name}` cannot be read: {flaw}")).at(Some(place)))
            }
        }
    }

    /// Returns the index of the plugin that reads a model from a file: the model reader, or the plugin of an importer.
    pub(super) fn plugin_for(&self, file: &Path) -> Option<usize> {
        let name = file.to_string_lossy();
        if name.ends_with(".toml") {
            // Without a model reader, reading the file fails later with an error about the missing reader, which is
            // more helpful than an unknown model.
            return Some(self.registry.model_reader().unwrap_or(0));
        }
        let importer = self.registry.importers.iter().find(|i| i.suffixes.iter().any(|s| name.ends_with(s.as_str())));
        importer.map(|i| i.plugin)
    }

    /// Builds the model that the current file describes as the whole scene. Its parameters have their default values
    /// unless they are overridden.
    pub(super) fn build_as_scene(&mut self, b: &mut DocumentBuilder<'_>) -> Result {
        let model = self.read_model(&name_of(self.text.file), self.text.file, self.text.text)?;
        let changed = b.document.reading.model_params.iter().filter(|(n, _, _)| *n == 0);
        let params: Vec<_> = changed.map(|(_, k, v)| (k.clone(), v.clone())).collect();
        let reach = b.reach.clone();
        self.build_model(b, (&model, reach), &params, None, Isometry3::identity(), None).map(drop)
    }
}
