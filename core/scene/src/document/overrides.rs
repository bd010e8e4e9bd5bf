//! Overrides by path: `[set]` in scenes, `--set` and `--script` on the command line.

use tatu_errors::{Error, Result, with_article};
use tatu_plugin_api::safe::Value;
use tatu_plugins::{Importer, ParameterSpec, Registry};

use super::{
    Document, DocumentBuilder, KeyTarget, ScriptSpec,
    change::{IMPORTED_FILE, PropertyOverride, ScriptOverride},
    keys,
    reach::{AllowedFile, AllowedFolders},
    scripts, settings,
};
use crate::property_table::Property;

/// Returns the index of the object with a path. Relative paths start at the object `from`, or at the world if it is
/// `None`.
pub fn find_object(document: &Document, from: Option<usize>, path: &str) -> Result<usize> {
    if let Some(object) = document.names.find(from, path) {
        return Ok(object);
    }
    if from.is_none() && !path.starts_with(['/', '.', ':']) {
        if let Some(told) = document.names.find_specified(path) {
            return Ok(told);
        }
        // An alias that only one object has is that object's unique name, if the object is not part of a group.
        if let Some(one) = document.names.only(path).filter(|i| document.objects.get(*i).is_some_and(|o| o.group == 0))
        {
            return Ok(one);
        }
    }
    // Within a model, the model's alias refers to its base.
    if let Some(base) = from
        && let Some(rest) = path.strip_prefix(document.objects[base].alias.as_str())
    {
        match rest.strip_prefix('/') {
            None if rest.is_empty() => return Ok(base),
            Some(rest) if document.names.find(from, path).is_none() => return find_object(document, from, rest),
            _ => {}
        }
    }
    let (scene, slots) = document.instantiate();
    let base = from.and_then(|f| slots.get(f).copied()).unwrap_or(0);
    // Below a model, a plain name refers to one of its parts.
    let plain = !path.starts_with(['/', '.', ':']);
    let found = match (plain, base) {
        (true, b) if b != 0 => scene.find(b, &format!("./{path}")).or_else(|| scene.find(b, path)),
        _ => scene.find(base, path),
    };
    let index = found.and_then(|slot| slots.iter().position(|s| *s == slot));
    index.ok_or_else(|| {
        let error = Error::new("E110", format!("there is no object `{path}`"));
        match scene.nearest(path) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error,
        }
    })
}

/// Applies overrides in order. All paths are resolved before the first override is applied. If an override sets a
/// parameter of a model to a value that is not in `known`, the model must be rebuilt: returns the parameter, as the
/// number of the model, key and value, without applying the remaining overrides.
pub(super) fn apply(
    document: &mut Document,
    registry: &Registry,
    all: &[PropertyOverride],
    known: &[(usize, String, Value)],
    reach: &AllowedFolders,
) -> Result<Option<(usize, String, Value)>> {
    let objects: Vec<Option<(usize, bool)>> = all
        .iter()
        .map(|o| match o.path.as_str() {
            "scene" | IMPORTED_FILE => Ok(None),
            _ => resolve_override(document, o).map(Some).map_err(|e| e.at(o.place.clone())),
        })
        .collect::<Result<_>>()?;
    for (o, object) in all.iter().zip(objects) {
        let at = |e: Error| e.at(o.place.clone());
        let Some((object, is_property)) = object else {
            // These were applied when the file was imported.
            if o.path == IMPORTED_FILE {
                continue;
            }
            let declared = settings::keys();
            let (entry, factor) = keys::find(&o.key, &declared, "scene").map_err(at)?;
            let value = keys::to_value(&o.item, factor).map_err(at)?;
            let value = keys::check(&entry.0, &o.key, value).map_err(at)?;
            if let ("dialect", Value::Text(t)) = (entry.0.key.as_str(), &value) {
                registry.check_dialect(None, &String::from_utf8_lossy(t)).map_err(at)?;
            }
            settings::apply(&mut document.settings, &entry.0.key, &value).map_err(at)?;
            continue;
        };
        if matches!(o.key.as_str(), "script" | "scripts") {
            let kept = std::mem::take(&mut document.objects[object].scripts);
            let mut builder = DocumentBuilder::new(registry, document, o.reach.as_ref().unwrap_or(reach).clone());
            let read = scripts::read_item(&mut builder, object, &o.item, o.place.clone());
            if read.is_err() {
                document.objects[object].scripts = kept;
            }
            read?;
            continue;
        }
        if !is_property && let Some((number, key, value)) = model_param(document, object, o).map_err(at)? {
            if known.iter().any(|(n, k, v)| (*n, k, v) == (number, &key, &value)) {
                continue;
            }
            return Ok(Some((number, key, value)));
        }
        // The key may be a misspelt parameter of the model.
        let meant = params_of(document, object)
            .and_then(|(_, params)| keys::find(&o.key, &params, &format!("the model `{}`", o.path)).err());
        let mut builder = DocumentBuilder::new(registry, document, reach.clone());
        let declared = builder.declarations(object);
        let owner = format!("`{}`, {}", o.path, with_article(builder.document.objects[object].kind.name()));
        let ((declared, target), factor) = keys::find(&o.key, &declared, &owner)
            .map_err(|e| if e.help.is_none() { meant.filter(|m| m.help.is_some()).unwrap_or(e) } else { e })
            .map_err(at)?;
        if matches!(target, KeyTarget::Property(Property::ALIAS)) {
            let alias = builder.document.objects[object].alias.clone();
            builder.document.reading.replaced_aliases.entry(object).or_insert(alias);
        }
        let value = builder.value_of(object, target, &o.item, factor).map_err(|(e, _)| at(e))?;
        builder.set_declared(object, declared, target, value).map_err(at)?;
    }
    Ok(None)
}

/// Returns the object of an override, and whether the override specifies the kind of the property, as in
/// `/robot.shape.color`. Without the kind, a parameter of a model takes precedence over a property of its base with the
/// same key.
fn resolve_override(document: &Document, o: &PropertyOverride) -> Result<(usize, bool)> {
    let plain = find_object(document, o.from, &o.path);
    let qualified = || {
        let (path, kind) = o.path.rsplit_once('.')?;
        let object = find_object(document, o.from, path).ok()?;
        let own = document.objects[object].kind.name();
        (kind == "object" || kind == own).then_some(object)
    };
    match plain {
        Err(e) => qualified().map(|object| (object, true)).ok_or(e),
        Ok(object) => Ok((object, false)),
    }
}

/// Returns the number and the parameters of the model with this base object.
fn params_of(document: &Document, object: usize) -> Option<(usize, Vec<(ParameterSpec, ())>)> {
    let model = document.models.iter().find(|m| m.base == object)?;
    Some((model.number, model.params.iter().map(|p| (p.clone(), ())).collect()))
}

/// Returns the parameters of an importer that overrides set, by key.
pub(super) fn import_params(importer: &Importer, all: &[PropertyOverride]) -> Result<Vec<(String, Value)>> {
    let declared: Vec<_> = importer.params.iter().map(|p| (p.clone(), ())).collect();
    let of_file = all.iter().filter(|o| o.path == IMPORTED_FILE);
    of_file
        .map(|o| {
            let (entry, factor) = keys::find(&o.key, &declared, &format!("the importer `{}`", importer.id))?;
            let value = keys::check(&entry.0, &o.key, keys::to_value(&o.item, factor)?)?;
            Ok((entry.0.key.clone(), value))
        })
        .collect()
}

/// Returns the override as a parameter of the model with this base object, if it is one.
fn model_param(document: &Document, object: usize, o: &PropertyOverride) -> Result<Option<(usize, String, Value)>> {
    let Some((number, declared)) = params_of(document, object) else { return Ok(None) };
    let Ok((entry, factor)) = keys::find(&o.key, &declared, "") else { return Ok(None) };
    let value = keys::to_value(&o.item, factor)?;
    let value = keys::check(&entry.0, &o.key, value)?;
    Ok(Some((number, entry.0.key.clone(), value)))
}

/// Replaces all scripts of each object that an override refers to.
pub(super) fn replace_scripts(
    document: &mut Document,
    registry: &Registry,
    all: &[ScriptOverride],
    reach: &AllowedFolders,
) -> Result {
    for o in all {
        let object = find_object(document, None, &o.path)?;
        let text = document
            .sources
            .read(&AllowedFile::chosen(&o.file))
            .map_err(|e| Error::new("E105", format!("cannot read the script {}: {e}", o.file.display())))?;
        // In a stored document, the overrides do not come from the user.
        if !document.sources.are_closed() || reach.contains(&o.file) {
            document.add_modules(&o.file);
        }
        let name = o.file.display().to_string();
        let language = registry.language(&name, &document.settings.providers)?;
        // The new script has the kind of the first script that it replaces: a main script remains a main script.
        let kind = document.objects[object].scripts.first().map_or("child".into(), |s| s.kind.clone());
        let priority = crate::document::NORMAL_PRIORITY;
        let spec = ScriptSpec { language, dialect: String::new(), kind, priority, side_by_side: false, name, text };
        document.objects[object].scripts = vec![spec];
    }
    Ok(())
}
