//! What a scene file, a model or an importer describes: nothing here is live.
//!
//! - [`Document`]: objects, scripts, settings;
//! - [`Builder`]: writes one, checking every property against its row;
//! - `plugin_builder`: the same builder for plugins, and models; `import`: files of other formats; `import_files`: what
//!   they read; `live`: a document of a scene that runs;
//! - `names`: paths and unique names; `toml`: scene files; `keys`: their keys, units and values;
//! - `presets`: settings of sensors under a name;
//! - `settings`: the numbers of the world; `scripts`: scripts in scene files;
//! - `services`: services that a scene asks for;
//! - `overrides`: `[set]`, `--set`, `--script`;
//! - [`Sources`]: the files that a document is made of.

mod build;
mod import;
mod import_files;
mod keys;
mod live;
mod names;
mod overrides;
mod plugin_builder;
mod presets;
mod scripts;
mod services;
mod settings;
mod sources;
mod toml;

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use nalgebra::Isometry3;
use tatu_plugin_api::{abi::TATU_REPORT_NOTE, safe::Value};

pub use build::Builder;
pub use import_files::normal;
pub use live::Beside;
pub use overrides::{Override, ScriptOverride};
pub use presets::{Setting, Target, settings as preset_settings};
pub use services::ServiceOverride;
pub use settings::{FRICTION_RULES, FrictionPair, LONGEST, Settings};
pub use sources::Sources;
pub use toml::{Options, Written, folder_beside, load, load_part, plugin_folders, save, write};

use crate::{ActuatorData, Data, Joint, Scene, SensorData, Shape, rows::Row};
use tatu_errors::{Error, Place, Result};
use tatu_geometry::Mesh;

/// The kind of the script that runs the stages of a step itself.
pub const MAIN: &str = "main";
/// The kinds of scripts.
pub const SCRIPT_KINDS: &[&str] = &["child", "customization", MAIN, "threaded"];

/// Priorities of scripts, by name.
pub const PRIORITIES: &[&str] = &["first", "normal", "last"];
/// The priority of scripts that name none, as an index of [`PRIORITIES`].
pub const NORMAL: u8 = 1;

/// A script of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptSpec {
    /// Index of its language.
    pub language: usize,
    /// Its dialect; empty: the scene's, or from the text.
    pub dialect: String,
    /// "child", "threaded", "customization", "main"; of scripts from outside: "addon", "sandbox".
    pub kind: String,
    /// Among scripts of one object, or of siblings: 0 first, 1 (the default), 2 last.
    pub priority: u8,
    /// Its actuation and sensing may run beside those of other scripts.
    pub side_by_side: bool,
    /// For messages: the file it came from, if any.
    pub name: String,
    /// The text.
    pub text: Vec<u8>,
}

impl ScriptSpec {
    /// A script from outside a document, of kind "addon" or "sandbox"; its dialect is found from its text.
    pub fn outside(language: usize, kind: &str, name: String, text: Vec<u8>) -> Self {
        let kind = kind.to_owned();
        ScriptSpec { language, dialect: String::new(), kind, priority: NORMAL, side_by_side: false, name, text }
    }
}

/// A sensor's or actuator's kind, parameters and commands.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceSpec {
    /// Index of the kind, among sensors or actuators.
    pub kind: usize,
    /// Parameters and commands given, by key.
    pub params: Vec<(String, Value)>,
}

/// One object.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSpec {
    /// `TATU_KIND_*`
    pub kind: i32,
    /// Its alias.
    pub alias: String,
    /// Index of the object above.
    pub parent: Option<usize>,
    /// Rows set, in order.
    pub rows: Vec<(Row, Value)>,
    /// Of a sensor or actuator.
    pub device: Option<DeviceSpec>,
    /// Its scripts.
    pub scripts: Vec<ScriptSpec>,
    /// Where a model was placed: composed before the object's own pose.
    pub placement: Isometry3<f64>,
    /// Objects with one number came together and share the suffix of their unique names.
    pub group: usize,
    /// Where it is described.
    pub place: Option<Place>,
}

impl ObjectSpec {
    /// The suffix of its unique name, where it is an object of the scene itself and was given such a name.
    fn told_suffix(&self) -> Option<i32> {
        let (_, name) = self.rows.iter().rev().find(|(r, _)| *r == Row::Name).filter(|_| self.group == 0)?;
        let Value::Text(name) = name else { return None };
        names::suffix_of(&String::from_utf8_lossy(name), &self.alias)
    }
}

/// Who built a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Made {
    /// The model of this index.
    Model(usize),
    /// The importer of this index.
    Import(usize),
}

/// A model or import that the document placed.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelInstance {
    /// Who built it.
    pub made: Made,
    /// Its base, by object.
    pub base: usize,
}

/// What a builder says of its source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// `TATU_REPORT_NOTE` or `_WARNING`: an error fails the build, and what is lacking is a setting.
    pub severity: u32,
    /// For people.
    pub text: String,
}

impl Report {
    /// A note.
    pub fn note(text: String) -> Self {
        Report { severity: TATU_REPORT_NOTE, text }
    }
}

/// A whole scene, described.
#[derive(Debug, Clone, Default)]
pub struct Document {
    /// The file it came from.
    pub file: Option<PathBuf>,
    /// Numbers of the world.
    pub settings: Settings,
    /// Objects; parents before children.
    pub objects: Vec<ObjectSpec>,
    /// Meshes, by the numbers (from 1) that shapes use.
    pub meshes: Vec<Arc<Mesh>>,
    /// Models placed, in order.
    pub models: Vec<ModelInstance>,
    /// Services to start beside the world.
    pub services: Vec<ServiceSpec>,
    /// Messages of builders.
    pub reports: Vec<Report>,
    /// What the scene asks for beyond the run, as `--allow` takes it; only who runs it can grant it.
    pub asks: Vec<String>,
    /// What an importer says that its file holds, if [`Options::describe`] asks for it; a map.
    pub description: Option<Value>,
    /// Free data of the world at its start, by tag.
    pub notes: BTreeMap<Vec<u8>, Vec<u8>>,
    /// Whether importers are asked to describe their files.
    pub(crate) describe: bool,
    /// The objects by aliases.
    pub(crate) names: names::Names,
    /// Groups of objects that came together, so far.
    groups: usize,
    /// Scenes read as models, so far.
    scenes_within: usize,
    /// The files that it is made of.
    pub sources: Sources,
}

impl Document {
    /// A number for objects that come together; see [`ObjectSpec::group`].
    fn new_group(&mut self) -> usize {
        self.groups += 1;
        self.groups
    }

    /// The live tree that it describes, and the slot of each object.
    pub fn instantiate(&self) -> (Scene, Vec<u32>) {
        let mut scene = Scene::default();
        scene.friction_pairs.clone_from(&self.settings.friction_pairs);
        let slots = self.plant(&mut scene, 0);
        // Names are given in the order of the file, so that the first of equal ones keeps its plain name. Objects of
        // the scene itself come one by one, those of a model together.
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, spec) in self.objects.iter().enumerate().filter(|(_, o)| o.group > 0) {
            members.entry(spec.group).or_default().push(i);
        }
        let mut taken = crate::name_index::NameIndex::default();
        let mut named = vec![false; self.objects.len()];
        for (i, spec) in self.objects.iter().enumerate() {
            let free = |n: &i32| taken.named(&spec.alias, *n).next().is_none();
            let Some(suffix) = spec.told_suffix().filter(free) else { continue };
            taken.add(&spec.alias, suffix, slots[i]);
            named[i] = true;
            scene.set_name(slots[i], &spec.alias, suffix);
        }
        for (i, spec) in self.objects.iter().enumerate().filter(|(i, _)| !named[*i]) {
            let together = if spec.group == 0 { vec![i] } else { members.remove(&spec.group).unwrap_or_default() };
            if together.is_empty() {
                continue;
            }
            let suffix = taken.free(together.iter().map(|i| self.objects[*i].alias.as_str()));
            for i in together {
                taken.add(&self.objects[i].alias, suffix, slots[i]);
                scene.set_name(slots[i], &self.objects[i].alias, suffix);
            }
        }
        scene.notes.clone_from(&self.notes);
        scene.refresh(0);
        (scene, slots)
    }

    /// Adds the objects to a tree, below `above` (0: the world), with nothing but their aliases for names; the slot of
    /// each, 0 where the tree is full.
    pub fn plant(&self, scene: &mut Scene, above: u32) -> Vec<u32> {
        let mut slots = Vec::with_capacity(self.objects.len());
        for spec in &self.objects {
            use tatu_plugin_api::abi::*;
            let data = match spec.kind {
                TATU_KIND_SHAPE => Data::Shape(Box::new(self.shape(spec))),
                TATU_KIND_JOINT => Data::Joint(Box::<Joint>::default()),
                TATU_KIND_SENSOR => Data::Sensor(SensorData::new(spec.device.as_ref().map_or(usize::MAX, |d| d.kind))),
                TATU_KIND_ACTUATOR => Data::Actuator(ActuatorData {
                    kind: spec.device.as_ref().map_or(usize::MAX, |d| d.kind),
                    // Filled when its device is made.
                    commands: Vec::new(),
                }),
                TATU_KIND_FORCE_SENSOR => Data::ForceSensor(Box::default()),
                TATU_KIND_GRAPH => Data::Graph(Box::default()),
                TATU_KIND_CAMERA => Data::Camera(Box::default()),
                TATU_KIND_LIGHT => Data::Light(Box::default()),
                TATU_KIND_PATH => Data::Path(Box::default()),
                _ => Data::Dummy(None),
            };
            let parent = spec.parent.and_then(|p| slots.get(p).copied()).unwrap_or(above);
            let slot = scene.add(parent, &spec.alias, Isometry3::identity(), data).unwrap_or(0);
            slots.push(slot);
            // Names are given below, all together.
            for (row, value) in spec.rows.iter().filter(|(r, _)| *r != Row::Name) {
                // Checked when the document was written.
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

    /// Assigns the parts of a shape their meshes, by number.
    pub fn fill_parts(&self, scene: &mut Scene, slot: u32) {
        let Some(Data::Shape(shape)) = scene.get_mut(slot).map(|o| &mut o.data) else { return };
        for part in shape.parts.iter_mut().filter(|p| p.mesh_number > 0) {
            part.mesh = self.meshes.get(part.mesh_number as usize - 1).cloned();
        }
    }

    /// Errors that no single property shows: shapes that lack what their form needs.
    fn check(&self) -> Result {
        self.settings.check()?;
        for spec in self.objects.iter().filter(|o| o.kind == tatu_plugin_api::abi::TATU_KIND_SHAPE) {
            let last = |row: Row| spec.rows.iter().rev().find(|(r, _)| *r == row).map(|(_, v)| v);
            let lacks = match last(Row::Primitive) {
                Some(Value::Text(t)) if t == b"mesh" && last(Row::Mesh).is_none() => "a mesh: set `mesh`",
                Some(Value::Text(t)) if t == b"compound" && last(Row::Parts).is_none() => "parts: set `parts`",
                _ => continue,
            };
            let text = format!("the shape `{}` has no {lacks}", spec.alias);
            return Err(Error::new("E104", text).at(spec.place.clone()));
        }
        if !self.objects.iter().any(|o| o.kind == tatu_plugin_api::abi::TATU_KIND_GRAPH) {
            return Ok(());
        }
        let (scene, slots) = self.instantiate();
        for (spec, slot) in self.objects.iter().zip(slots) {
            if let Some(Data::Graph(graph)) = scene.get(slot).map(|o| &o.data) {
                crate::graph::Graph::try_new(graph, spec.alias.clone()).map_err(|e| {
                    Error::new("E102", format!("the graph `{}`: {}", spec.alias, e.1)).at(spec.place.clone())
                })?;
            }
        }
        Ok(())
    }

    fn shape(&self, spec: &ObjectSpec) -> Shape {
        let number = spec.rows.iter().rev().find_map(|(r, v)| match (r, v) {
            (Row::Mesh, Value::Int(i)) => usize::try_from(*i).ok(),
            _ => None,
        });
        Shape { mesh: number.and_then(|n| self.meshes.get(n.wrapping_sub(1)).cloned()), ..Default::default() }
    }
}

/// A service to start beside the world.
#[derive(Debug, Clone, PartialEq)]
pub struct ServiceSpec {
    /// Index of its kind.
    pub kind: usize,
    /// Parameters given, by key, SI units; later ones win.
    pub params: Vec<(String, Value)>,
    /// Where it is asked for.
    pub place: Option<Place>,
}
