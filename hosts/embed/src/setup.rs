//! The inputs from which a world is built: a scene, plugins, and changes.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError, Weak},
};

use tatu_core::{
    document::{
        self, Document, LanguageOverride, LoadOptions, PropertyOverride, ScriptOverride, ServiceOverride, SourceFiles,
    },
    errors::{Error, Result},
    host_tables,
    plugins::{FolderOrigin, Registry, SearchPath, protected_state::share_process},
};

use crate::{
    exercise,
    search::{self, SearchFolders, search_folders, user_settings},
};

/// The source of a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum SceneSource {
    /// A file: a scene file, or one that an importer reads.
    File(PathBuf),
    /// The text of a scene file, and the folder to which its paths are relative.
    Text(String, PathBuf),
}

/// The inputs from which a world is built. The fields correspond to the options of the command line.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldSetup {
    /// The scene.
    pub scene: SceneSource,
    /// Seed of all random numbers; if `None`, the scene's own seed is used.
    pub seed: Option<u64>,
    /// Changes to properties, such as `/Robot/leftMotor.max_force_nm=2`.
    pub set: Vec<String>,
    /// Scripts that replace the scripts of objects, in the form `/Robot=FILE`.
    pub scripts: Vec<String>,
    /// Permissions of scripts: `exec`, `native`, `net=HOST:PORT`. In addition, `plugins` allows the plugins in the
    /// scene's own folders.
    pub allow: Vec<String>,
    /// Services to start, in the form `ID:KEY=VALUE`. Services that only the scene declares are not started.
    pub services: Vec<String>,
    /// Settings of script languages, in the form `ID:KEY=VALUE`.
    pub languages: Vec<String>,
    /// Defaults for settings of script languages, as language, key and text. They apply where neither the scene nor the
    /// user has set anything.
    pub language_defaults: Vec<(String, String, String)>,
    /// Plugin libraries, or folders that contain plugin libraries; searched before all others.
    pub plugins: Vec<PathBuf>,
    /// Number of threads that each world uses; it does not affect the results.
    pub threads: usize,
    /// The folder in which scripts open files; if `None`, the working folder.
    pub files: Option<PathBuf>,
    /// Files that need not exist, and their texts.
    pub texts: Vec<(PathBuf, String)>,
}

impl WorldSetup {
    /// Creates the setup of a scene without changes.
    pub fn new(scene: SceneSource) -> Self {
        WorldSetup {
            scene,
            seed: None,
            set: Vec::new(),
            scripts: Vec::new(),
            allow: Vec::new(),
            services: Vec::new(),
            languages: Vec::new(),
            language_defaults: Vec::new(),
            plugins: Vec::new(),
            threads: 1,
            files: None,
            texts: Vec::new(),
        }
    }

    /// Returns the path under which the scene is read. For the text of a scene, this is the path of a fictitious file
    /// in the text's folder.
    pub fn file(&self) -> PathBuf {
        match &self.scene {
            SceneSource::File(file) => file.clone(),
            SceneSource::Text(_, folder) => folder.join("scene-from-text.toml"),
        }
    }

    fn sources(&self) -> SourceFiles {
        let sources = SourceFiles::default();
        if let SceneSource::Text(text, _) = &self.scene {
            sources.add_file(&self.file(), text.as_bytes().to_vec());
        }
        for (file, text) in &self.texts {
            sources.add_file(file, text.as_bytes().to_vec());
        }
        sources
    }

    /// Returns the changes as options of the core.
    ///
    /// # Errors
    /// A change cannot be parsed, or the user's settings cannot be read.
    pub fn options(&self) -> Result<LoadOptions> {
        let mut user_settings = user_settings()?;
        for (language, key, text) in &self.language_defaults {
            user_settings.add_language_default(language, key, text);
        }
        Ok(LoadOptions {
            seed: self.seed,
            set: self.set.iter().map(|s| PropertyOverride::parse(s)).collect::<Result<_>>()?,
            scripts: self.scripts.iter().map(|s| ScriptOverride::parse(s)).collect::<Result<_>>()?,
            // `plugins` is not a permission of scripts; it has been checked when the plugins were loaded.
            allow: self.allow.iter().filter(|a| *a != "plugins").cloned().collect(),
            services: self.services.iter().map(|s| ServiceOverride::parse(s)).collect::<Result<_>>()?,
            languages: self.languages.iter().map(|s| LanguageOverride::parse(s)).collect::<Result<_>>()?,
            user_settings,
            sources: self.sources(),
            ..LoadOptions::default()
        })
    }
}

/// The registries in use, by search path. Worlds with the same search path share a registry.
static SHARED_REGISTRIES: Mutex<Vec<(Vec<PathBuf>, Weak<Registry>)>> = Mutex::new(Vec::new());

/// The plugins of a setup and the document of its scene, from which any number of worlds can be created.
#[derive(Clone)]
pub struct WorldTemplate {
    /// The plugins that worlds use.
    pub registry: Arc<Registry>,
    /// The document of the scene.
    pub document: Arc<Document>,
    /// The reasons why plugins were refused, and the warnings about the scene.
    pub warnings: Vec<String>,
}

impl WorldTemplate {
    /// Loads the plugins and the scene of a setup.
    ///
    /// # Errors
    /// A file or a change is invalid, or the scene has plugin folders that are not allowed.
    pub fn load(setup: &WorldSetup) -> Result<Self> {
        share_process();
        let registry = shared_registry(setup, false)?;
        let mut warnings: Vec<String> = registry.load_report.refused.iter().map(ToString::to_string).collect();
        let mut document = match document::load(&setup.file(), &registry, &setup.options()?) {
            Ok(document) => document,
            Err(e) => {
                release_registry(registry);
                return Err(e);
            }
        };
        exercise::appoint_referees(&mut document);
        warnings.extend(document.reports.iter().map(|r| r.text.clone()));
        Ok(WorldTemplate { registry, document: Arc::new(document), warnings })
    }

    /// Loads the scene again from the same files, with other changes and the same plugins.
    ///
    /// # Errors
    /// A file or a change is invalid.
    pub fn reload(&self, setup: &WorldSetup) -> Result<Self> {
        // The contents that were read first are used, even if the files have changed since.
        let options = LoadOptions { sources: self.document.sources.clone(), ..setup.options()? };
        let mut document = document::load(&setup.file(), &self.registry, &options)?;
        exercise::appoint_referees(&mut document);
        Ok(WorldTemplate { document: Arc::new(document), ..self.clone() })
    }

    /// Ends the plugins, if nothing else uses them.
    pub(crate) fn end(self) {
        let WorldTemplate { registry, document, .. } = self;
        drop(document);
        release_registry(registry);
    }
}

/// Returns a registry for a setup, shared with worlds that have the same search path. If `bundled` is true, the scene
/// file is not read, so the scene's own plugin folders are not searched.
pub(crate) fn shared_registry(setup: &WorldSetup, bundled: bool) -> Result<Arc<Registry>> {
    let mut search = search_of(setup, bundled)?;
    let given: Vec<PathBuf> = setup.plugins.iter().filter(|p| p.is_file()).cloned().collect();
    search.files.splice(0..0, given);
    let key: Vec<PathBuf> = {
        let folders = search.folders.iter().map(|(f, _)| f).chain(&search.files);
        folders.chain(&search.models).chain(&search.models_of_scene).cloned().collect()
    };
    let mut shared = SHARED_REGISTRIES.lock().unwrap_or_else(PoisonError::into_inner);
    shared.retain(|(_, registry)| registry.strong_count() > 0);
    if let Some(registry) = shared.iter().find(|(k, _)| *k == key).and_then(|(_, r)| r.upgrade()) {
        return Ok(registry);
    }
    let registry = Arc::new(Registry::load(search, host_tables()));
    shared.push((key, Arc::downgrade(&registry)));
    Ok(registry)
}

fn search_of(setup: &WorldSetup, bundled: bool) -> Result<SearchPath> {
    let file = setup.file();
    let scene = (!bundled).then_some(file.as_path());
    let SearchFolders { mut search, untrusted } = search_folders(scene, &setup.sources(), &setup.allow)?;
    if let Some(folder) = untrusted.first() {
        let help = "if you trust the folder, allow `plugins` for this run, or trust it in all runs by setting \
                    the environment variable TATU_TRUST=/absolute/folder";
        return Err(search::untrusted_plugins_error(&file, folder).help(help));
    }
    for path in setup.plugins.iter().rev() {
        if path.is_dir() {
            search.folders.insert(0, (path.clone(), FolderOrigin::Environment));
        } else if !path.is_file() {
            let error = Error::new("E311", format!("there is no plugin at {}", path.display()));
            return Err(error.expected("a compiled plugin library, or a folder that contains plugin libraries"));
        }
    }
    Ok(search)
}

/// Ends the plugins of a registry, if this is the last reference to it.
pub(crate) fn release_registry(registry: Arc<Registry>) {
    if let Some(registry) = Arc::into_inner(registry) {
        for e in registry.shut_down() {
            tatu_core::record_breach(e.to_string());
        }
    }
}
