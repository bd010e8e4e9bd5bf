//! Runs a script without its scene. Objects that the script looks up by name are created, with kinds that fit its
//! calls.
//!
//! The kind of an object can be inferred only when the script uses the object. Therefore the script is run in trials,
//! each with the objects found so far, until it requests nothing new; the actual run follows.

use std::{
    collections::BTreeMap,
    fmt::Write,
    path::{Path, PathBuf},
    sync::Arc,
};

use clap::ValueEnum;
use serde_json::{Value, json};
use tatu_core::{
    OptionalObject, StandIn, World,
    document::{LanguageOverride, LoadOptions, PropertyOverride, SCRIPT_KINDS, ServiceOverride, SourceFiles},
    errors::{Error, Fault, FaultKind},
    plugins::Registry,
    scene::ObjectKind,
};
use tatu_embed::search;
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};

use super::keys::KeyPresses;
use crate::args::{RunArgs, ScriptKind};

/// Maximum number of trials.
const MAX_TRIALS: usize = 10;
/// Maximum number of steps of a trial.
const MAX_TRIAL_STEPS: u64 = 1000;
/// Aliases of the script's object and of its parent, and the number of objects that exist before the script requests
/// any: these two and the floor.
const SCRIPT_OBJECT: &str = "model";
const PARENT_OBJECT: &str = "above";
const OWN_OBJECTS: usize = 3;

/// Returns the options from the command line, except for the script itself.
pub fn options(args: &RunArgs) -> Result<LoadOptions, Error> {
    let c = &args.changes;
    Ok(LoadOptions {
        seed: c.seed,
        set: c.set.iter().map(|s| PropertyOverride::parse(s)).collect::<Result<_, _>>()?,
        services: args.services.iter().map(|s| ServiceOverride::parse(s)).collect::<Result<_, _>>()?,
        languages: c.languages.iter().map(|s| LanguageOverride::parse(s)).collect::<Result<_, _>>()?,
        user_settings: search::user_settings()?,
        ..Default::default()
    })
}

/// The scene of stand-ins that the trials have determined.
pub struct TrialResult {
    /// The path of the scene, which exists only in `sources`.
    pub scene: PathBuf,
    /// The files of the scene.
    pub sources: SourceFiles,
    /// Names of values, such as signals, for which the world supplies substitutes.
    pub values: Vec<String>,
}

/// Runs trials until the script requests nothing new.
pub fn run_trials(args: &RunArgs, options: &LoadOptions, registry: &Arc<Registry>) -> Result<TrialResult, Error> {
    let script = GeneratedScene::read(args, registry)?;
    let steps = args.length.steps.unwrap_or(MAX_TRIAL_STEPS).min(MAX_TRIAL_STEPS);
    let mut known = SceneNeeds::default();
    let mut tried = script.sources(&known, registry);
    let mut best: Option<(usize, SourceFiles, Vec<String>)> = None;
    for round in 1..=MAX_TRIALS {
        let options = LoadOptions { sources: tried.clone(), services: Vec::new(), set: Vec::new(), ..options.clone() };
        let document = tatu_core::document::load(&script.scene, registry, &options)?;
        let world = World::with_threads(Arc::new(document), registry.clone(), args.threads.into())?;
        if let Some(folder) = &args.files {
            world.set_file_folder(folder)?;
        }
        world.enable_stand_ins(&known.values);
        world.start();
        let mut keys = args.pace.keys.as_deref().map(KeyPresses::read).transpose()?.unwrap_or_default();
        while world.steps() < steps {
            while let Some(key) = keys.due(world.time()) {
                world.put_in("key", &key);
            }
            if !world.step() {
                break;
            }
            world.take_lines();
        }
        world.stop();
        // Once objects that were missing exist, a script may get further and look up more objects.
        let beyond = |f: &&Fault| matches!(f.kind, FaultKind::UnknownFunction | FaultKind::Unsupported);
        let faults = world.faults().iter().filter(beyond).count();
        if best.as_ref().is_none_or(|(least, ..)| faults <= *least) {
            best = Some((faults, tried.clone(), known.values.clone()));
        }
        let learned = known.merged_with(&world);
        if learned == known {
            break;
        }
        known = learned;
        tried = script.sources(&known, registry);
        if round == MAX_TRIALS {
            // The sources found last have not been tried yet; the actual run will try them.
            best = None;
        }
    }
    let (_, sources, values) = best.unwrap_or((0, tried, known.values));
    Ok(TrialResult { scene: script.scene, sources, values })
}

/// What the script is known to require of its scene.
#[derive(Default, PartialEq)]
struct SceneNeeds {
    /// Whether the script's object has a parent.
    has_parent: bool,
    objects: Vec<StandIn>,
    /// Names of values, such as signals, that the script reads although nothing has set them.
    values: Vec<String>,
}

impl SceneNeeds {
    /// Returns these requirements together with those found in a trial.
    fn merged_with(&self, world: &World) -> Self {
        let mut all = world.stand_ins();
        let mut above = self.has_parent;
        // The script used the handle -1, so it did not merely check for the top of the tree.
        let nothing = |f: &Fault| {
            matches!(f.kind, FaultKind::MissingObject | FaultKind::BadArgument)
                && ["object -1", "found -1", "found nil"].iter().any(|n| f.message.contains(n))
        };
        let faults = world.faults();
        let mut values = self.values.clone();
        if faults.iter().any(nothing) {
            for (i, optional) in world.optional_objects() {
                match optional {
                    OptionalObject::Parent => above |= all[i].alias == SCRIPT_OBJECT,
                    OptionalObject::Child(kind) => {
                        let alias = String::from("child");
                        let kind = if kind.is_empty() { "dummy".into() } else { kind };
                        let suffix = all.iter().filter(|s| s.alias == alias).count() as i32 - 1;
                        all.push(StandIn { parent: Some(i), alias, suffix, kind, script: false });
                    }
                    OptionalObject::Script => all[i].script = true,
                }
            }
        }
        let objects = unify_kinds(all.split_off(OWN_OBJECTS.min(all.len())));
        let lacks = [FaultKind::Runtime, FaultKind::BadArgument, FaultKind::MissingObject];
        // Values are added only once the set of objects no longer changes.
        let settled = above == self.has_parent && objects == self.objects;
        if settled && faults.iter().any(|f| lacks.contains(&f.kind)) {
            values.extend(world.missing_values());
        }
        SceneNeeds { has_parent: above, values, objects }
    }
}

/// Returns the stand-ins for the summary, without the objects that every generated scene contains.
pub fn summarize(world: &World) -> Vec<Value> {
    let all = world.stand_ins();
    let summary = |s: &StandIn| match s.kind.contains('/') {
        true => json!({ "name": s.name(), "kind": "sensor", "sensor": s.kind }),
        false => json!({ "name": s.name(), "kind": s.kind }),
    };
    all.iter().skip(OWN_OBJECTS).map(summary).collect()
}

/// The script, and the path of the scene that is generated for it.
struct GeneratedScene {
    /// The scene's path. It is in the script's folder, because modules are searched in the folder of the scene.
    scene: PathBuf,
    file: PathBuf,
    text: Vec<u8>,
    kind: ScriptKind,
}

impl GeneratedScene {
    fn read(args: &RunArgs, registry: &Registry) -> Result<Self, Error> {
        let wrong = |what: String| Error::new("E102", what).expected("--script FILE --stand-ins, with one script");
        let [name] = args.changes.scripts.as_slice() else {
            return Err(wrong(format!("{} scripts were given", args.changes.scripts.len())));
        };
        let file = PathBuf::from(name);
        if name.starts_with('/') && name.contains('=') && !file.exists() {
            return Err(wrong(format!("`{name}` names an object, but there is no scene")));
        }
        let text = read_plain(&file, MAX_FILE_BYTES)
            .map_err(|e| Error::new("E105", format!("cannot read the script {}: {e}", file.display())))?;
        let language = registry.language(name, &BTreeMap::new())?;
        let shown = || ScriptKind::from_str(registry.kind_of_script(language, &text)?, false).ok();
        let kind = args.stand_in_script.kind.or_else(shown).unwrap_or(ScriptKind::Child);
        let scene = file.parent().unwrap_or(Path::new("")).join("stand-ins.toml");
        Ok(GeneratedScene { scene, file, text, kind })
    }

    /// Returns the files of a scene that contains these stand-ins and the script.
    fn sources(&self, known: &SceneNeeds, registry: &Registry) -> SourceFiles {
        let text = self.scene(known, registry);
        SourceFiles::of([(self.scene.clone(), text.into_bytes()), (self.file.clone(), self.text.clone())])
    }

    fn scene(&self, known: &SceneNeeds, registry: &Registry) -> String {
        // Choose the most similar kind that a scene supports; threaded scripts are recognized by their source.
        let kinds: &[&str] = match self.kind {
            ScriptKind::Main => &["main"],
            ScriptKind::AddOn => &["addon", "customization"],
            ScriptKind::Customization => &["customization"],
            ScriptKind::Threaded => &["threaded", "child"],
            ScriptKind::Child | ScriptKind::Module => &["child"],
        };
        let kind = kinds.iter().find(|k| SCRIPT_KINDS.contains(k)).unwrap_or(&"child");
        let file = self.file.file_name().unwrap_or_default().to_string_lossy();
        let mut out = String::from("format = 1\n");
        out += "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";
        out += &format!("[[object]]\nkind = \"dummy\"\nalias = \"{PARENT_OBJECT}\"\n");
        out += &format!("[[object]]\nkind = \"dummy\"\nalias = \"{SCRIPT_OBJECT}\"\nmodel_base = true\n");
        if known.has_parent {
            out += &format!("parent = \"{PARENT_OBJECT}\"\n");
        }
        out += &format!("[object.script]\nfile = {}\nkind = \"{kind}\"\n", quoted(&file));
        for (i, s) in known.objects.iter().enumerate() {
            object(&mut out, i, s, &known.objects, registry);
        }
        out
    }
}

/// Writes an object of the scene.
fn object(out: &mut String, i: usize, s: &StandIn, known: &[StandIn], registry: &Registry) {
    let parent = match s.parent {
        Some(p) if p >= OWN_OBJECTS => known.get(p - OWN_OBJECTS).map(StandIn::name),
        Some(1) => Some(PARENT_OBJECT.into()),
        Some(2) => Some(SCRIPT_OBJECT.into()),
        _ => None,
    };
    let (column, line) = (i % 10, i / 10);
    let at = [0.3 + 0.2 * column as f64, 0.2 * line as f64, 0.05];
    let kind = match s.kind.as_str() {
        schema if schema.contains('/') && registry.sensor(schema, &BTreeMap::new()).is_ok() => "sensor",
        // The exact kind of sensor, actuator or part is unknown, so a dummy takes its place.
        "sensor" | "actuator" | "part" => "dummy",
        kind if ObjectKind::parse(kind).is_some() => kind,
        _ => "dummy",
    };
    let _ = writeln!(out, "[[object]]\nkind = \"{kind}\"\nalias = {}\nposition_m = {at:?}", quoted(&s.alias));
    if let Some(parent) = parent {
        let _ = writeln!(out, "parent = {}", quoted(&parent));
    }
    out.push_str(match kind {
        "shape" => "dynamic = true\nrespondable = true\n",
        "joint" => "control = \"velocity\"\nmax_force_nm = 10.0\n",
        _ => "",
    });
    if kind == "sensor" {
        let _ = writeln!(out, "sensor = {}", quoted(&s.kind));
    }
    // With an old dialect, this script does not change the order in which the other scripts are called.
    if s.script {
        out.push_str("[object.script]\ntext = \"\"\nlanguage = \"lua\"\ndialect = \"3.2\"\n");
    }
}

/// Gives the same kind to objects whose names differ only by digits.
fn unify_kinds(mut all: Vec<StandIn>) -> Vec<StandIn> {
    let stem = |s: &StandIn| s.alias.chars().filter(|c| !c.is_ascii_digit()).collect::<String>();
    let mut kinds = BTreeMap::new();
    for s in all.iter().filter(|s| s.kind != "dummy") {
        kinds.entry(stem(s)).or_insert_with(|| s.kind.clone());
    }
    for s in all.iter_mut().filter(|s| s.kind == "dummy") {
        if let Some(kind) = kinds.get(&stem(s)) {
            s.kind.clone_from(kind);
        }
    }
    all
}

/// Formats a string so that it is valid in both TOML and JSON.
fn quoted(text: &str) -> String {
    json!(text).to_string()
}
