//! Chooses the add-ons that run, and attaches them to a world.

use std::{path::Path, sync::Arc};

use tatu_core::{
    World,
    document::{AllowedFile, Document, ScriptSpec, SourceFiles},
    errors::{Error, Result},
    plugins::Registry,
    session::file::AddonEntry,
};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, Value, read_plain};

use super::{AddOn, AddonFlags, CallStyle, StartMode, find, request::AddonRequest};
use tatu_terminal::report;

/// The add-ons of a run, in the order in which they are started.
#[derive(Default)]
pub struct StartedAddons(Vec<(AddOn, Vec<(String, String)>)>);

/// Chooses the add-ons that run: those that start automatically, and those named on the command line. Their files are
/// read through the document's sources, so that an input log contains them.
pub fn choose_addons(flags: &AddonFlags, document: &Document, registry: &Arc<Registry>) -> Result<StartedAddons> {
    let wanted: Vec<AddonRequest> = flags.addons.iter().map(|text| AddonRequest::parse(text)).collect::<Result<_>>()?;
    if flags.no_addons && wanted.is_empty() && flags.without.is_empty() {
        return Ok(StartedAddons::default());
    }
    // Files that are only inspected are not recorded as files of the run.
    let (found, wrong) = find::find(registry, &SourceFiles::default());
    wrong.iter().for_each(report::warning);
    let without = flags.without.iter().map(|name| AddonRequest { name: name.clone(), options: Vec::new() });
    let without: Vec<AddonRequest> = without.collect();
    if let Some(nobody) = without.iter().find(|w| !found.iter().any(|addon| matches_request(w, addon))) {
        return Err(unknown(nobody, &found));
    }
    let mut taken = vec![false; wanted.len()];
    let mut started = Vec::new();
    for addon in found.iter() {
        let mut options = None;
        for (w, taken) in wanted.iter().zip(&mut taken).filter(|(w, _)| matches_request(w, addon)) {
            *taken = true;
            options.get_or_insert_with(Vec::new).extend(w.options.clone());
        }
        let left_out = flags.no_addons || without.iter().any(|w| matches_request(w, addon));
        if options.is_none() && !left_out && starts_by_itself(addon, registry) {
            report::note(&format!(
                "the add-on {0} is started ({1}); to prevent that: `--no-addon {0}`",
                addon.name,
                addon.file.display()
            ));
            options = Some(Vec::new());
        }
        started.extend(options.map(|o| (addon.clone(), o)));
    }
    for (w, _) in wanted.iter().zip(&taken).filter(|(_, taken)| !**taken) {
        let place = Path::new(&w.name);
        if !place.exists() {
            return Err(unknown(w, &found));
        }
        started.push((find::read(place, registry, &SourceFiles::default())?, w.options.clone()));
    }
    for (addon, _) in &started {
        let text = read_plain(&addon.file, MAX_FILE_BYTES).map_err(|e| unreadable(&addon.file, &e))?;
        document.sources.add_file(&addon.file, text);
    }
    Ok(StartedAddons(started))
}

/// Returns the add-ons that the input log of a replayed run lists.
pub fn replayed_addons(entries: &[AddonEntry], document: &Document, registry: &Registry) -> Result<StartedAddons> {
    let all = entries.iter().map(|e| {
        let addon = find::read(&e.file, registry, &document.sources)?;
        Ok((AddOn { name: e.name.clone(), dialect: e.dialect.clone(), ..addon }, e.options.clone()))
    });
    Ok(StartedAddons(all.collect::<Result<_>>()?))
}

fn matches_request(w: &AddonRequest, addon: &AddOn) -> bool {
    w.name == addon.name || addon.file.file_stem().is_some_and(|stem| *stem == *w.name)
}

fn unknown(w: &AddonRequest, found: &[AddOn]) -> Error {
    let known: Vec<&str> = found.iter().map(|a| a.name.as_str()).collect();
    let list = if known.is_empty() { "none was found".to_owned() } else { known.join(", ") };
    Error::new("E600", format!("there is no add-on `{}`, and no such file", w.name))
        .expected(format!("an add-on that `tatu list addons` lists ({list}), or the file of one"))
        .nearest(&w.name, known)
}

fn unreadable(file: &Path, e: &std::io::Error) -> Error {
    Error::new("E105", format!("cannot read the add-on {}: {e}", file.display()))
}

/// Returns whether an add-on starts automatically. If neither its name nor its manifest specifies this, its function
/// `info` is called in a temporary world. If that call fails or does not return `autoStart`, the add-on is started, so
/// that its errors are reported.
pub fn starts_by_itself(addon: &AddOn, registry: &Arc<Registry>) -> bool {
    match addon.start {
        StartMode::Automatic => true,
        StartMode::OnRequest => false,
        StartMode::ScriptDecides => ask_auto_start(addon, registry).unwrap_or(true),
    }
}

fn ask_auto_start(addon: &AddOn, registry: &Arc<Registry>) -> Option<bool> {
    let text = read_plain(&addon.file, MAX_FILE_BYTES).ok()?;
    let world = World::new(Arc::new(Document::default()), registry.clone()).ok()?;
    let slot = world.attach(&script_spec(addon, text)).ok()?;
    let Value::Map(info) = world.query_script(slot, "info")? else { return None };
    info.iter().find_map(|(k, v)| match (k, v) {
        (Value::Text(k), Value::Bool(on)) if k == b"autoStart" => Some(*on),
        _ => None,
    })
}

fn script_spec(addon: &AddOn, text: Vec<u8>) -> ScriptSpec {
    ScriptSpec {
        side_by_side: false,
        dialect: addon.dialect.clone(),
        ..ScriptSpec::external(addon.language, "addon", addon.file.display().to_string(), text)
    }
}

impl StartedAddons {
    /// Attaches all add-ons to a world that has not been started.
    pub fn attach(&self, world: &World) -> Result {
        for (addon, options) in &self.0 {
            let text = world
                .document()
                .sources
                .read(&AllowedFile::chosen(&addon.file))
                .map_err(|e| unreadable(&addon.file, &e))?;
            let slot = world.attach(&script_spec(addon, text))?;
            world.set_script_options(slot, options);
            if addon.style == CallStyle::Function {
                world.run_once(slot);
            }
        }
        Ok(())
    }

    /// Returns the entries for the input log.
    pub fn entries(&self) -> Vec<AddonEntry> {
        let entry = |(a, options): &(AddOn, Vec<(String, String)>)| AddonEntry {
            name: a.name.clone(),
            file: a.file.clone(),
            dialect: a.dialect.clone(),
            options: options.clone(),
        };
        self.0.iter().map(entry).collect()
    }
}
