//! Documents: descriptions of scenes, built from scene files, models or imported files, or from a live tree.
//!
//! - [`Document`]: objects, scripts, settings;
//! - [`DocumentBuilder`]: builds a document, and checks every property against its declaration;
//! - `plugin_builder`: the builder interface for plugins, and models; `import`: files in other formats;
//!   [`AllowedFolders`]: the files that a document may name; `import_files`: reading them; `live`: the document of a
//!   running scene;
//! - `names`: paths and unique names; `toml`: scene files; `keys`: their keys, units and values;
//! - `presets`: named sets of sensor settings; `rates`: rates that the steps do not reach; `removal`: removal of parts
//!   of models; `replacement_pose`: the pose of an object that is replaced;
//! - `entry`: which table describes which objects; `settings`: settings of the world; `scripts`: scripts in scene
//!   files;
//! - `services`: services that a scene requests; `languages`: settings of script languages;
//! - `overrides`: application of `[set]`, `--set` and `--script`; `change`: their parsed form;
//! - [`SourceFiles`]: the source files of a document.

mod build;
mod change;
mod entry;
mod import;
mod import_files;
mod keys;
mod languages;
mod live;
mod names;
mod overrides;
mod packages;
mod plugin_builder;
mod presets;
mod rates;
mod reach;
mod removal;
mod replacement_pose;
mod scripts;
mod services;
pub(crate) mod settings;
mod sources;
mod toml;

use std::{
    collections::{BTreeMap, BTreeSet},
    ffi::OsString,
    path::{Path, PathBuf},
    sync::Arc,
};

use nalgebra::Isometry3;
use tatu_plugin_api::{
    abi::{TATU_REPORT_NOTE, TATU_REPORT_WARNING},
    safe::Value,
};

pub use build::DocumentBuilder;
pub use change::{PropertyOverride, ScriptOverride};
pub use languages::LanguageOverride;
pub use live::ObjectAttachments;
pub use presets::{KeyTarget, PresetSetting, settings as preset_settings};
pub use reach::{AllowedFile, AllowedFolders};
pub use services::{ServiceOverride, UserSettings};
pub use settings::{FrictionPair, MAX_STEP_S, WorldSettings};
pub use sources::SourceFiles;
pub use toml::{
    EditedScene, LoadOptions, PatchResult, SceneFiles, folder_beside, load, load_part, patch, plugin_folders, save,
    write,
};

use crate::{ObjectKind, ObjectVariant, Scene, Shape, property_table::Property, texture::ShapeTexture};
use tatu_errors::{Error, Result, SourceLocation};
use tatu_geometry::{Image, Mesh};
use tatu_plugins::ParameterSpec;

/// The kind of script that runs the stages of a step itself.
pub const MAIN_KIND: &str = "main";
/// The kinds of scripts that a document can contain.
pub const SCRIPT_KINDS: &[&str] = &["child", "customization", MAIN_KIND, "threaded", REFEREE_KIND];
/// The kind of script that judges a run: other scripts can neither see nor affect it.
pub const REFEREE_KIND: &str = "referee";

/// Names of the priorities of scripts; the index of a name is the priority.
pub const PRIORITIES: &[&str] = &["first", "normal", "last"];
/// The default priority of scripts, as an index into [`PRIORITIES`].
pub const NORMAL_PRIORITY: u8 = 1;

/// A script of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptSpec {
    /// Index of the script's language in the registry.
    pub language: usize,
    /// Dialect of the script; if empty, the scene's dialect, or the one inferred from the source.
    pub dialect: String,
    /// "child", "threaded", "customization", "main" or "referee"; for scripts that are not part of a document, "addon",
    /// "sandbox" or "referee".
    pub kind: String,
    /// Order among the scripts of an object and of its siblings: 0 for first, 1 for the default, 2 for last.
    pub priority: u8,
    /// Whether the script's actuation and sensing can run in parallel with those of other scripts.
    pub side_by_side: bool,
    /// Name for messages: usually the file it was read from, or the alias of its object.
    pub name: String,
    /// Source code of the script.
    pub text: Vec<u8>,
}

impl ScriptSpec {
    /// Creates the description of a script that is not part of a document, of kind "addon" or "sandbox". Its dialect is
    /// inferred from its source.
    pub fn external(language: usize, kind: &str, name: String, text: Vec<u8>) -> Self {
        let kind = kind.to_owned();
        ScriptSpec {
            language,
            dialect: String::new(),
            kind,
            priority: NORMAL_PRIORITY,
            side_by_side: false,
            name,
            text,
        }
    }
}

/// The kind, parameters and commands of a sensor or actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceSpec {
    /// Index of the kind among sensors or actuators.
    pub kind: usize,
    /// Specified parameters and commands, by key.
    pub params: Vec<(String, Value)>,
}

/// Description of an object, from which live objects are created.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSpec {
    /// Kind of the object.
    pub kind: ObjectKind,
    /// Alias of the object.
    pub alias: String,
    /// Index of the parent; `None` if the object has no parent.
    pub parent: Option<usize>,
    /// Properties that are set, in order; later values override earlier ones.
    pub properties: Vec<(Property, Value)>,
    /// Device of a sensor or actuator.
    pub device: Option<DeviceSpec>,
    /// Scripts of the object, in order.
    pub scripts: Vec<ScriptSpec>,
    /// Placement of a model, applied before the object's own pose.
    pub placement: Isometry3<f64>,
    /// Number of the group of objects that were added together, which share the suffix of their unique names; 0 for
    /// objects of the scene itself.
    pub group: usize,
    /// The location in a file that describes the object.
    pub place: Option<SourceLocation>,
}

impl ObjectSpec {
    /// Returns whether the object is an actuator or a part, whose device is listed among the kinds of actuators.
    pub fn is_actuator(&self) -> bool {
        matches!(self.kind, ObjectKind::Actuator | ObjectKind::Part)
    }

    /// Returns the suffix of the object's unique name, if the object belongs to the scene itself and the file specifies
    /// the name.
    fn specified_suffix(&self) -> Option<i32> {
        let (_, name) = self.properties.iter().rev().find(|(r, _)| *r == Property::NAME).filter(|_| self.group == 0)?;
        let Value::Text(name) = name else { return None };
        names::suffix_of(&String::from_utf8_lossy(name), &self.alias)
    }
}

/// A model or import placed by the document.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelInstance {
    /// Number of the model, in the order in which builds were started. It does not change when other models are
    /// removed.
    pub number: usize,
    /// Index of the model's base object.
    pub base: usize,
    /// Parameters that the model declares.
    pub params: Vec<ParameterSpec>,
}

/// A message of a model or importer about its source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuildReport {
    /// `TATU_REPORT_NOTE` or `TATU_REPORT_WARNING`. An error fails the build instead, and unsupported parts are stored
    /// in the settings.
    pub severity: u32,
    /// The message.
    pub text: String,
}

impl BuildReport {
    /// Creates a note.
    pub fn note(text: String) -> Self {
        BuildReport { severity: TATU_REPORT_NOTE, text }
    }

    /// Creates a warning.
    pub fn warning(text: String) -> Self {
        BuildReport { severity: TATU_REPORT_WARNING, text }
    }
}

/// Description of a complete scene.
#[derive(Debug, Clone, Default)]
pub struct Document {
    /// The file that the document was read from, if any.
    pub file: Option<PathBuf>,
    /// Settings of the world.
    pub settings: WorldSettings,
    /// Objects, parents before children.
    pub objects: Vec<ObjectSpec>,
    /// Meshes; shapes refer to them by number, from 1.
    pub meshes: Vec<Arc<Mesh>>,
    /// Images; textures refer to them by number, from 1.
    pub images: Vec<Arc<Image>>,
    /// Placed models, in order.
    pub models: Vec<ModelInstance>,
    pub(crate) reading: ReadProgress,
    /// Services, permissions and the learning environment.
    pub requests: RunRequests,
    /// Messages of models and importers about their sources.
    pub reports: Vec<BuildReport>,
    /// An importer's description of its file, a map, if requested by [`LoadOptions::describe`].
    pub description: Option<Value>,
    /// Initial custom data of the world, by tag.
    pub notes: BTreeMap<Vec<u8>, Vec<u8>>,
    /// The tree of aliases, by which objects are found.
    pub(crate) names: names::AliasTree,
    group_numbers: GroupNumbers,
    /// The tables of the scene file that describe objects, in order.
    pub(crate) entries: Vec<entry::SceneEntry>,
    /// The source files of the document.
    pub sources: SourceFiles,
    /// Folders with script files that the document names or the user has chosen, each with the suffix of these files.
    /// Files with this suffix in the folder are modules, which scripts may read.
    pub modules: BTreeSet<(PathBuf, OsString)>,
}

/// Data that is needed only while a document is read.
#[derive(Debug, Clone, Default)]
pub(crate) struct ReadProgress {
    next_model: usize,
    /// Folders of packages in which a file was missing, which is reported once for each.
    incomplete_packages: BTreeSet<PathBuf>,
    /// Parameters of models, by model number, that override the values in the files.
    model_params: Arc<[(usize, String, Value)]>,
    /// Properties that the files set, which are applied when all objects exist.
    overrides: Vec<PropertyOverride>,
    /// Files that are being read, outermost first, to detect a model that contains itself.
    open_files: Vec<PathBuf>,
    /// Whether importers should describe their files; see [`LoadOptions::describe`].
    pub(crate) describe: bool,
    /// Number of models and scenes that have been read from files so far.
    included_scenes: usize,
    /// Original aliases of the objects whose alias was overridden, by object.
    pub(crate) replaced_aliases: BTreeMap<usize, String>,
}

/// The groups of objects that have a common suffix.
#[derive(Debug, Clone, Default)]
pub(crate) struct GroupNumbers {
    /// The last group number; see [`ObjectSpec::group`].
    groups: usize,
    /// Suffixes of the unique names of groups, where the file specifies them, by group number.
    group_suffixes: BTreeMap<usize, i32>,
}

/// A setting of a script language.
#[derive(Debug, Clone, PartialEq)]
pub struct LanguageSetting {
    /// Index of the language in the registry.
    pub language: usize,
    /// Key of the parameter.
    pub key: String,
    /// Value of the parameter.
    pub value: Value,
    /// Whether the scene's file states it.
    pub is_of_scene: bool,
}

/// The requests of a document to the program that runs it.
#[derive(Debug, Clone, Default)]
pub struct RunRequests {
    /// Services to start alongside the world.
    pub services: Vec<ServiceSpec>,
    /// Settings of script languages; later ones take precedence over earlier ones.
    pub languages: Vec<LanguageSetting>,
    /// Permissions that the scene requests, in the form of `--allow`; only the user who runs it can grant them.
    pub requested_permissions: Vec<String>,
    /// The table `[env]` of the scene file, as TOML: the observations and actions of a learning environment. The core
    /// stores it without interpreting it.
    pub env: Option<String>,
}

impl Document {
    /// Returns a new group number; see [`ObjectSpec::group`].
    fn new_group(&mut self) -> usize {
        self.group_numbers.groups += 1;
        self.group_numbers.groups
    }

    /// Lets scripts read the modules beside a script file.
    fn add_modules(&mut self, script: &Path) {
        if let (Some(folder), Some(suffix)) = (script.parent(), script.extension()) {
            self.modules.insert((folder.to_owned(), suffix.to_owned()));
        }
    }

    /// Creates the live tree that the document describes; also returns the slot of each object.
    pub fn instantiate(&self) -> (Scene, Vec<u32>) {
        let mut scene = Scene::default();
        scene.friction_pairs.clone_from(&self.settings.friction_pairs);
        scene.joint_solver = self.settings.joint_solver;
        let slots = self.add_to_scene(&mut scene, 0);
        // Names are assigned in file order, so the first of several equal aliases becomes a unique name without a
        // suffix. Objects of the scene itself are named one at a time, those of models one group at a time.
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, spec) in self.objects.iter().enumerate().filter(|(_, o)| o.group > 0) {
            members.entry(spec.group).or_default().push(i);
        }
        let mut taken = crate::name_index::NameIndex::default();
        let mut named = vec![false; self.objects.len()];
        for (i, spec) in self.objects.iter().enumerate() {
            let free = |n: &i32| taken.objects_named(&spec.alias, *n).next().is_none();
            let Some(suffix) = spec.specified_suffix().filter(free) else { continue };
            taken.add(&spec.alias, suffix, slots[i]);
            named[i] = true;
            scene.set_name(slots[i], &spec.alias, suffix);
        }
        for (i, spec) in self.objects.iter().enumerate().filter(|(i, _)| !named[*i]) {
            let together = if spec.group == 0 { vec![i] } else { members.remove(&spec.group).unwrap_or_default() };
            if together.is_empty() {
                continue;
            }
            let all = || together.iter().map(|i| self.objects[*i].alias.as_str());
            let told = self.group_numbers.group_suffixes.get(&spec.group).copied();
            let is_free = |n: &i32| all().all(|alias| taken.objects_named(alias, *n).next().is_none());
            let suffix = told.filter(is_free).unwrap_or_else(|| taken.free_suffix(all()));
            for i in together {
                taken.add(&self.objects[i].alias, suffix, slots[i]);
                scene.set_name(slots[i], &self.objects[i].alias, suffix);
            }
        }
        scene.notes.clone_from(&self.notes);
        scene.refresh(0);
        (scene, slots)
    }

    /// Returns the mass of an object, kg; 0 if the object is not dynamic.
    fn mass(&self, spec: &ObjectSpec) -> f64 {
        let last = |row: Property| spec.properties.iter().rev().find(|(r, _)| *r == row).map(|(_, v)| v);
        if !matches!(last(Property::DYNAMIC), Some(Value::Bool(true))) {
            return 0.0;
        }
        match last(Property::MASS) {
            Some(Value::Float(mass)) => *mass,
            _ => crate::mass(&self.shape(spec)),
        }
    }

    /// Adds the objects to a tree below `above` (0 for the world), without suffixes in their names. Returns the slot of
    /// each object, or 0 for an object that does not fit in the tree.
    pub fn add_to_scene(&self, scene: &mut Scene, above: u32) -> Vec<u32> {
        let mut slots = Vec::with_capacity(self.objects.len());
        for spec in &self.objects {
            let data = match spec.kind {
                ObjectKind::Shape => ObjectVariant::Shape(Box::new(self.shape(spec))),
                kind => ObjectVariant::of_kind(kind, spec.device.as_ref().map_or(usize::MAX, |d| d.kind)),
            };
            let parent = spec.parent.and_then(|p| slots.get(p).copied()).unwrap_or(above);
            let slot = scene.add(parent, &spec.alias, Isometry3::identity(), data).unwrap_or(0);
            slots.push(slot);
            // The caller assigns names to all objects together, and the mesh is part of the new shape.
            for (row, value) in spec.properties.iter().filter(|(r, _)| !matches!(*r, Property::NAME | Property::MESH)) {
                // This cannot fail, because the value was checked when the document was built.
                let _ = crate::set(scene, slot, *row, value);
            }
            self.fill_parts(scene, slot);
            let placed = scene.get(slot).map(|_| spec.placement * scene.local(slot));
            if let Some(local) = placed.filter(|_| spec.placement != Isometry3::identity()) {
                scene.set_local(slot, local);
            }
        }
        slots
    }

    /// Returns the number of a missing image that a value of `shape.texture` or `shape.parts` refers to, if any.
    pub fn missing_image(&self, row: Property, value: &Value) -> Option<u32> {
        let images = match row {
            Property::PARTS => crate::part_images(value),
            Property::TEXTURE => {
                ShapeTexture::from_value(value).ok().flatten().map(|t| t.image_number).into_iter().collect()
            }
            _ => Vec::new(),
        };
        images.into_iter().find(|n| *n as usize > self.images.len())
    }

    /// Assigns the image with the texture's number to the texture of a shape, unless it already has an image.
    pub fn fill_texture(&self, scene: &mut Scene, slot: u32) {
        let Some(ObjectVariant::Shape(shape)) = scene.get_mut(slot).map(|o| &mut o.data) else { return };
        if let Some(texture) = shape.texture.as_mut().filter(|t| t.image.is_none()) {
            texture.image = self.images.get((texture.image_number as usize).wrapping_sub(1)).cloned();
        }
    }

    /// Assigns the meshes and images with the stored numbers to the parts and textures of a shape.
    pub fn fill_parts(&self, scene: &mut Scene, slot: u32) {
        let Some(ObjectVariant::Shape(shape)) = scene.get_mut(slot).map(|o| &mut o.data) else { return };
        shape.derived = crate::DerivedGeometry::default();
        for part in shape.parts.iter_mut().filter(|p| p.mesh_number > 0) {
            part.mesh = self.meshes.get(part.mesh_number as usize - 1).cloned();
        }
        for texture in shape.textures_mut() {
            texture.image = self.images.get((texture.image_number as usize).wrapping_sub(1)).cloned();
        }
    }

    /// Checks constraints that involve several properties: of settings, of shapes that require a mesh or parts, and of
    /// graphs. A mesh that its shape does not use is reported.
    fn check(&mut self) -> Result {
        self.settings.check()?;
        let sensors = self.objects.iter().filter(|o| o.kind == ObjectKind::Sensor);
        let rated =
            sensors.map(|o| rates::RatedSensor { alias: &o.alias, place: o.place.as_ref(), properties: &o.properties });
        self.reports.extend(rates::unreached(self.settings.dt, rated).map(BuildReport::note));
        let mut unused = Vec::new();
        for spec in self.objects.iter().filter(|o| o.kind == ObjectKind::Shape) {
            let last = |row: Property| spec.properties.iter().rev().find(|(r, _)| *r == row).map(|(_, v)| v);
            let primitive = last(Property::PRIMITIVE);
            if last(Property::MESH).is_some() && !matches!(primitive, Some(Value::Text(t)) if t == b"mesh") {
                let at =
                    spec.place.as_ref().map(|at| format!("{}:{}: ", at.file.display(), at.line)).unwrap_or_default();
                let text = format!("the mesh of the shape `{}` is not used: set `primitive = \"mesh\"`", spec.alias);
                unused.push(BuildReport::warning(at + &text));
            }
            let lacks = match primitive {
                Some(Value::Text(t)) if t == b"mesh" && last(Property::MESH).is_none() => "mesh: set `mesh`",
                Some(Value::Text(t)) if t == b"compound" && last(Property::PARTS).is_none() => "parts: set `parts`",
                _ => continue,
            };
            let text = format!("the shape `{}` has no {lacks}", spec.alias);
            return Err(Error::new("E104", text).at(spec.place.clone()));
        }
        self.reports.append(&mut unused);
        if !self.objects.iter().any(|o| o.kind == ObjectKind::Graph) {
            return Ok(());
        }
        let (scene, slots) = self.instantiate();
        for (spec, slot) in self.objects.iter().zip(slots) {
            if let Some(ObjectVariant::Graph(graph)) = scene.get(slot).map(|o| &o.data) {
                crate::graph::Graph::try_new(graph, spec.alias.clone()).map_err(|e| {
                    Error::new("E102", format!("the graph `{}`: {}", spec.alias, e.1)).at(spec.place.clone())
                })?;
            }
        }
        Ok(())
    }

    fn shape(&self, spec: &ObjectSpec) -> Shape {
        let number = spec.properties.iter().rev().find_map(|(r, v)| match (*r, v) {
            (Property::MESH, Value::Int(i)) => usize::try_from(*i).ok(),
            _ => None,
        });
        Shape { mesh: number.and_then(|n| self.meshes.get(n.wrapping_sub(1)).cloned()), ..Default::default() }
    }
}

/// A service to start alongside the world.
#[derive(Debug, Clone, PartialEq)]
pub struct ServiceSpec {
    /// Index of the service kind in the registry.
    pub kind: usize,
    /// Specified parameters, by key, in SI units; later ones override earlier ones.
    pub params: Vec<(String, Value)>,
    /// The source location of the request; `None` if the command line requests the service.
    pub place: Option<SourceLocation>,
}
