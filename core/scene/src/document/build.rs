//! The builder of documents, which checks every property against its declaration.

use std::{collections::BTreeMap, ops::Range, path::Path, sync::Arc};

use nalgebra::{Isometry3, Point3};
use tatu_errors::{Error, Result, SourceLocation, with_article};
use tatu_geometry::{Image, MAX_IMAGE_PIXELS, Mesh};
use tatu_plugin_api::{abi::TATU_PARAM_READ_ONLY, safe::Value};
use tatu_plugins::{ParameterSpec, Registry, SensorKind, texts::label};
use toml_edit::Item;

use super::{
    BuildReport, DeviceSpec, Document, MAIN_KIND, ObjectSpec, ScriptSpec, keys, presets, presets::KeyTarget,
    reach::AllowedFolders,
};
use crate::{
    ObjectVariant, Scene,
    names::{ALIAS_RULE, is_alias},
    noise::NoiseSpec,
    property_table::{FileForm, ObjectKind, Property, properties_of},
};

/// Maximum total size of the images of a scene in bytes, at 4 bytes per pixel.
const MAX_IMAGE_BYTES: usize = 512 << 20;

/// Adds objects, properties, meshes, images and scripts to a document.
pub struct DocumentBuilder<'a> {
    /// The registry of plugins.
    pub registry: &'a Registry,
    /// The document being built.
    pub document: &'a mut Document,
    /// Number of the group of objects being added; see [`ObjectSpec::group`].
    pub group: usize,
    /// The location in a file that describes the objects added next, for error messages.
    pub place: Option<SourceLocation>,
    /// Reads text in the scene format, for plugins that build models from text; `None` if this build cannot read text.
    pub read_text: Option<TextReader>,
    /// The files that the document may name at present.
    pub(super) reach: AllowedFolders,
}

/// Adds the objects that a text in the scene format describes, below a parent. The path is that of the file that
/// contains the text; error locations and relative file names refer to it.
pub type TextReader = fn(&mut DocumentBuilder<'_>, &Path, &str, Option<usize>) -> Result;

/// Maximum number of objects in a document.
const MAX_OBJECTS: usize = 1_000_000;

impl<'a> DocumentBuilder<'a> {
    /// Creates a builder of a document that may name the files in `reach`, without a location, and which cannot read
    /// text.
    pub(super) fn new(registry: &'a Registry, document: &'a mut Document, reach: AllowedFolders) -> Self {
        DocumentBuilder { registry, document, group: 0, place: None, read_text: None, reach }
    }

    /// Adds an object and returns its index. If the alias is empty, it defaults to the name of the kind.
    pub fn object(&mut self, kind: &str, parent: Option<usize>, alias: &str) -> Result<usize> {
        let Some(of_kind) = ObjectKind::parse(kind) else {
            let known = ObjectKind::names();
            return Err(Error::new("E102", format!("unknown object kind `{kind}`"))
                .expected(format!("one of {}", known.join(", ")))
                .nearest(kind, known));
        };
        if parent.is_some_and(|p| p >= self.document.objects.len()) {
            return Err(Error::new("E110", format!("the parent of `{alias}` does not exist")));
        }
        let alias = if alias.is_empty() { kind } else { alias };
        if !is_alias(alias) {
            return Err(
                Error::new("E102", format!("`{}` cannot be an alias", label(alias.as_bytes()))).expected(ALIAS_RULE)
            );
        }
        if self.document.objects.len() >= MAX_OBJECTS {
            return Err(Error::new("E124", format!("the scene has more than {MAX_OBJECTS} objects")));
        }
        self.document.names.add(parent, alias);
        self.document.objects.push(ObjectSpec {
            kind: of_kind,
            alias: alias.to_owned(),
            parent,
            properties: Vec::new(),
            device: None,
            scripts: Vec::new(),
            placement: Isometry3::identity(),
            group: self.group,
            place: self.place.clone(),
        });
        Ok(self.document.objects.len() - 1)
    }

    /// Returns the declarations of the keys that an object can have: the core's properties, then its device's
    /// parameters.
    pub fn declarations(&self, object: usize) -> Vec<(ParameterSpec, KeyTarget)> {
        let spec = &self.document.objects[object];
        // The parent is set by `parent`, and the unique name follows from the alias.
        let rows = properties_of(Some(spec.kind)).map(|r| (r.declaration().clone(), KeyTarget::Property(r)));
        let rows =
            rows.filter(|(_, t)| !matches!(t, KeyTarget::Property(Property::PARENT | Property::NAME))).map(|(p, t)| {
                match t {
                    // The key `position_m` already means the position of the joint object in its parent's frame.
                    KeyTarget::Property(Property::JOINT_POSITION) => {
                        (ParameterSpec { key: "joint_position".into(), ..p }, t)
                    }
                    _ => (p, t),
                }
            });
        // The unit depends on whether the joint is revolute or prismatic.
        let slides = spec
            .properties
            .iter()
            .rev()
            .find(|(r, _)| *r == Property::JOINT_TYPE)
            .is_some_and(|(_, v)| *v == "prismatic".into());
        let rows = rows.map(move |(p, t)| {
            let unit = p
                .unit
                .as_deref()
                .and_then(|u| u.split_once('|'))
                .map(|(turn, slide)| if slides { slide } else { turn });
            match unit.map(str::to_owned) {
                Some(unit) => (ParameterSpec { unit: Some(unit), ..p }, t),
                None => (p, t),
            }
        });
        let params = spec.device.iter().flat_map(|d| self.registry.device(spec.is_actuator(), d.kind).all_params());
        rows.chain(params.enumerate().map(|(i, p)| (p.clone(), KeyTarget::Param(i)))).collect()
    }

    /// Sets a property by its key, with or without the prefix of the object's kind. The value is in SI units.
    pub fn set(&mut self, object: usize, key: &str, value: Value) -> Result {
        let Some(spec) = self.document.objects.get(object) else {
            return Err(Error::new("E110", "the object number does not refer to an object of this build"));
        };
        if matches!(key, "object.name" | "name") {
            return self.set_unique_name(object, &value);
        }
        let kind = spec.kind.name();
        let short = match key.split_once('.') {
            Some(("joint", "position")) => "joint_position",
            Some((prefix, short)) if prefix == kind || prefix == "object" => short,
            Some((prefix, short))
                if spec
                    .device
                    .as_ref()
                    .is_some_and(|d| self.registry.device(spec.is_actuator(), d.kind).id == prefix) =>
            {
                short
            }
            Some(_) => "",
            None => key,
        };
        let declared = self.declarations(object);
        let Some((declared, target)) = declared.iter().find(|(d, _)| d.key == short) else {
            let known: Vec<_> = declared.iter().map(|(d, _)| d.key.as_str()).collect();
            return Err(Error::new("E101", format!("an object of kind `{kind}` has no property `{key}`"))
                .expected(known.join(", "))
                .nearest(short, known.iter().copied()));
        };
        self.set_declared(object, declared, target, value)
    }

    /// Sets the unique name of a model's base. All parts of the model share the number in this name.
    pub(super) fn set_group_name(&mut self, base: usize, name: &str) -> Result {
        let spec = &self.document.objects[base];
        let Some(suffix) = super::names::suffix_of(name, &spec.alias) else {
            let text = format!("`{}` cannot be the unique name of `{}`", label(name.as_bytes()), spec.alias);
            return Err(Error::new("E102", text).expected("the alias, or the alias with `#` and a number"));
        };
        let group = spec.group;
        self.document.group_numbers.group_suffixes.insert(group, suffix);
        Ok(())
    }

    /// Sets the unique name of an object of the scene itself: its alias, or its alias with `#n`. The name has no effect
    /// in models, imports and scenes used as models, which can be placed several times; their objects share a number.
    fn set_unique_name(&mut self, object: usize, value: &Value) -> Result {
        let spec = &mut self.document.objects[object];
        let name = if let Value::Text(t) = value { String::from_utf8_lossy(t).into_owned() } else { String::new() };
        let Some(suffix) = super::names::suffix_of(&name, &spec.alias) else {
            return Err(Error::new("E102", format!("`{name}` cannot be a unique name of `{}`", spec.alias))
                .expected("the alias, or the alias with `#` and a number"));
        };
        spec.properties.push((Property::NAME, Value::text(name)));
        if spec.group == 0 {
            self.document.names.specify_name(object, &spec.alias, suffix);
        }
        Ok(())
    }

    /// Changes a setting of the world, such as `scene.dt`, in SI units, or its custom data, `scene.data`. The value is
    /// always checked, but takes effect only if `whole` is set, which means that the scene itself is being built.
    pub(super) fn apply_setting(&mut self, key: &str, value: Value, whole: bool) -> Result {
        let short = key.strip_prefix("scene.").unwrap_or(key);
        if short == "data" {
            let notes = crate::notes(&value).map_err(|e| Error::new("E102", format!("`{key}`: {}", e.1)))?;
            if whole {
                self.document.notes = notes;
            }
            return Ok(());
        }
        let declared = super::settings::keys();
        let Some((declared, ())) = declared.iter().find(|(d, ())| d.key == short) else {
            let known: Vec<_> = declared.iter().map(|(d, ())| d.key.as_str()).collect();
            return Err(Error::new("E101", format!("a scene has no setting `{key}`"))
                .expected(known.join(", "))
                .nearest(short, known.iter().copied()));
        };
        let value = keys::check(declared, key, value)?;
        if let ("dialect", Value::Text(t)) = (short, &value) {
            self.registry.check_dialect(None, &String::from_utf8_lossy(t))?;
        }
        if whole {
            super::settings::apply(&mut self.document.settings, short, &value)?;
        }
        Ok(())
    }

    /// Changes the alias of an object.
    pub fn rename(&mut self, object: usize, alias: &str) {
        alias.clone_into(&mut self.document.objects[object].alias);
        self.document.names.rename(object, alias);
    }

    /// Sets a property, given its declaration and its target.
    pub fn set_declared(
        &mut self,
        object: usize,
        declared: &ParameterSpec,
        target: &KeyTarget,
        value: Value,
    ) -> Result {
        if declared.flags & TATU_PARAM_READ_ONLY != 0 {
            return Err(Error::new("E102", format!("`{}` is read-only", declared.key)));
        }
        // The message is the same as for a change in a running world.
        let name = if let KeyTarget::Property(row) = target { row.key() } else { &declared.key };
        let value = keys::check(declared, name, value)?;
        let spec = &mut self.document.objects[object];
        match target {
            KeyTarget::Property(Property::ALIAS) => {
                if let Value::Text(t) = &value {
                    let alias = String::from_utf8_lossy(t).into_owned();
                    self.rename(object, &alias);
                }
            }
            KeyTarget::Property(Property::PRESET) => self.apply_preset(object, value)?,
            KeyTarget::Property(row) => {
                let value = match (*row, &value) {
                    (Property::NOISE, Value::Text(t)) => self.resolve_noise(object, &String::from_utf8_lossy(t))?,
                    _ => value,
                };
                self.check_on_blank_object(object, *row, &value)?;
                self.document.objects[object].properties.push((*row, value));
            }
            KeyTarget::Param(_) => {
                if let Some(d) = &mut spec.device {
                    d.params.push((declared.key.clone(), value));
                }
            }
        }
        Ok(())
    }

    /// Returns the kind of a sensor, or `None` if the object is not a sensor or its kind is not set yet.
    pub(super) fn sensor_kind(&self, object: usize) -> Option<&'a SensorKind> {
        let spec = self.document.objects.get(object).filter(|o| o.kind == ObjectKind::Sensor)?;
        self.registry.sensors.get(spec.device.as_ref()?.kind)
    }

    /// Applies a preset, which later settings override. An empty name sets no properties.
    fn apply_preset(&mut self, object: usize, value: Value) -> Result {
        let id = if let Value::Text(t) = &value { String::from_utf8_lossy(t).into_owned() } else { String::new() };
        if !id.is_empty() {
            let lacks =
                || Error::new("E104", "a preset must not precede the sensor's kind").help("call `device` first");
            let kind = self.sensor_kind(object).ok_or_else(lacks)?;
            for setting in presets::settings(self.registry, kind, &id)? {
                self.set_declared(object, &setting.declared, &setting.target, setting.value).map_err(|e| {
                    let text = format!("the preset `{id}` of the sensor kind `{}`: {}", kind.id, e.text);
                    Error { text, ..e }
                })?;
            }
        }
        self.document.objects[object].properties.push((Property::PRESET, value));
        Ok(())
    }

    /// Applies a preset to a part, which later settings override. The device must be set already.
    pub(super) fn apply_part_preset(&mut self, object: usize, id: &str) -> Result {
        let device = self.document.objects.get(object).and_then(|o| o.device.as_ref());
        let Some(kind) = device.and_then(|d| self.registry.actuators.get(d.kind)) else { return Ok(()) };
        for setting in presets::part_settings(self.registry, kind, id)? {
            self.set_declared(object, &setting.declared, &setting.target, setting.value)?;
        }
        Ok(())
    }

    /// Checks a noise declaration against the sensor's fields, and returns it with full field names.
    fn resolve_noise(&self, object: usize, text: &str) -> Result<Value> {
        let lacks = || Error::new("E104", "noise must not precede the sensor's kind").help("call `device` first");
        let kind = self.sensor_kind(object).ok_or_else(lacks)?;
        let read = NoiseSpec::parse(text, Some(kind)).map_err(|w| w.with_line(text))?;
        Ok(Value::text(read.to_toml()))
    }

    /// Converts a value of a scene file according to the meaning of its key. An error includes its position within the
    /// item.
    pub(super) fn value_of(
        &self,
        object: usize,
        target: &KeyTarget,
        item: &Item,
        factor: f64,
    ) -> Result<Value, (Error, Option<Range<usize>>)> {
        match target {
            KeyTarget::Property(row) if row.spec().file_form == FileForm::Noise => {
                presets::noise_value(item, self.sensor_kind(object))
            }
            KeyTarget::Property(row) => keys::read(row.spec().file_form, item, factor).map_err(|e| (e, None)),
            KeyTarget::Param(_) => keys::to_value(item, factor).map_err(|e| (e, None)),
        }
    }

    /// Checks a value by setting it on a blank object of the same kind, because live objects must accept it later.
    /// Numbers of meshes and images must exist in the document.
    fn check_on_blank_object(&self, object: usize, row: Property, value: &Value) -> Result {
        if row == Property::MESH {
            let there = matches!(value, Value::Int(i) if *i >= 1 && *i as usize <= self.document.meshes.len());
            return if there {
                Ok(())
            } else {
                Err(Error::new("E102", "`mesh` is not the number of an existing mesh"))
            };
        }
        if row == Property::PARTS {
            let last = self.document.meshes.len();
            let lost = crate::part_meshes(value).into_iter().find(|n| *n as usize > last);
            if let Some(n) = lost {
                return Err(Error::new("E102", format!("a part refers to mesh {n}, but the last mesh is {last}")));
            }
        }
        if let Some(n) = self.document.missing_image(row, value) {
            let last = self.document.images.len();
            return Err(Error::new("E102", format!("a texture refers to image {n}, but the last image is {last}")));
        }
        let mut scene = Scene::default();
        let blank = ObjectVariant::of_kind(self.document.objects[object].kind, usize::MAX);
        let slot = scene.add(0, "blank", Isometry3::identity(), blank).unwrap_or(0);
        crate::set(&mut scene, slot, row, value).map(drop).map_err(|e| Error::new("E102", e.1))
    }

    /// Sets the kind of a sensor, actuator or part by id. For a sensor, the id may also be a schema, which selects its
    /// provider.
    pub fn device(&mut self, object: usize, kind_or_schema: &str) -> Result {
        let providers: &BTreeMap<_, _> = &self.document.settings.providers;
        let Some(spec) = self.document.objects.get_mut(object) else {
            return Err(Error::new("E110", "the object number does not refer to an object of this build"));
        };
        let kind = match spec.kind {
            ObjectKind::Sensor => self.registry.sensor(kind_or_schema, providers)?,
            ObjectKind::Actuator => self.registry.actuator(kind_or_schema, providers)?,
            ObjectKind::Part => self.registry.part(kind_or_schema, providers)?,
            other => {
                let text =
                    format!("`{}` is {}, not a sensor, actuator or part", spec.alias, with_article(other.name()));
                return Err(Error::new("E102", text));
            }
        };
        spec.device = Some(DeviceSpec { kind, params: Vec::new() });
        Ok(())
    }

    /// Adds a mesh and returns its number. Equal meshes are stored once.
    pub fn mesh(&mut self, mesh: Mesh) -> Result<usize> {
        let n = mesh.vertices.len();
        if mesh.triangles.iter().flatten().any(|i| *i as usize >= n) {
            return Err(Error::new("E102", "a triangle of a mesh refers to a point that does not exist"));
        }
        if mesh.vertices.iter().any(|v: &Point3<f64>| !v.coords.iter().all(|x| x.is_finite())) {
            return Err(Error::new("E102", "a point of a mesh is not finite"));
        }
        let coordinates = &mesh.coordinates;
        if !coordinates.is_empty() && (coordinates.len() != n || !coordinates.iter().flatten().all(|x| x.is_finite())) {
            let text = format!("a mesh has {} texture coordinates for {n} points", coordinates.len());
            return Err(Error::new("E102", text).expected("two finite numbers for each point, or no coordinates"));
        }
        if let Some(i) = self.document.meshes.iter().position(|m| **m == mesh) {
            return Ok(i + 1);
        }
        self.document.meshes.push(Arc::new(mesh));
        Ok(self.document.meshes.len())
    }

    /// Adds an image of 4 bytes per pixel, top row first, and returns its number. Equal images are stored once.
    pub fn image(&mut self, columns: u32, rows: u32, rgba: Vec<u8>) -> Result<usize> {
        let found = rgba.len();
        let Some(image) = Image::new(columns, rows, rgba) else {
            let text = format!("an image of {columns} x {rows} pixels cannot consist of {found} bytes");
            return Err(
                Error::new("E102", text).expected(format!("4 bytes for each of 1 to {MAX_IMAGE_PIXELS} pixels"))
            );
        };
        if let Some(i) = self.document.images.iter().position(|known| **known == image) {
            return Ok(i + 1);
        }
        let all = self.document.images.iter().map(|known| known.rgba().len()).sum::<usize>() + found;
        if all > MAX_IMAGE_BYTES {
            return Err(Error::new("E102", format!("the images of the scene occupy {} MB", all >> 20))
                .expected(format!("at most {} MB in total, at 4 bytes per pixel", MAX_IMAGE_BYTES >> 20))
                .help("reduce the size of the images, or share images between surfaces"));
        }
        self.document.images.push(Arc::new(image));
        Ok(self.document.images.len())
    }

    /// Adds a script to an object.
    pub fn script(&mut self, object: usize, script: ScriptSpec) -> Result {
        if script.kind == MAIN_KIND && self.group != 0 {
            let text =
                format!("the main script `{}` of a model is ignored: only the scene itself can have one", script.name);
            self.document.reports.push(BuildReport::note(text));
            return Ok(());
        }
        if script.kind == MAIN_KIND
            && let Some(o) = self.document.objects.iter().find(|o| o.scripts.iter().any(|s| s.kind == MAIN_KIND))
        {
            return Err(Error::new("E118", format!("the scene already has a main script, on `{}`", o.alias))
                .expected("at most one script of kind `main` in a scene: it alone runs the stages of a step")
                .help("make one of them `child`"));
        }
        match self.document.objects.get_mut(object) {
            Some(o) => {
                o.scripts.push(script);
                Ok(())
            }
            None => Err(Error::new("E110", "the object number does not refer to an object of this build")),
        }
    }

    /// Records that the next object is the base of a model with these parameters. Models within it have higher numbers.
    pub(super) fn record_model(&mut self, params: &[ParameterSpec]) {
        let (number, base) = (self.document.reading.next_model, self.document.objects.len());
        self.document.reading.next_model += 1;
        self.document.models.push(super::ModelInstance { number, base, params: params.to_vec() });
    }

    /// Makes the objects from index `first` on a model with the pose `placement`. Returns the base of the model, or
    /// `None` if there are no objects.
    pub(super) fn place_model(&mut self, first: usize, placement: Isometry3<f64>) -> Option<usize> {
        let base = self.document.objects.get_mut(first)?;
        // The base of a model can also be the base of a model nested in it.
        base.placement = placement * base.placement;
        if !base.properties.iter().any(|(r, _)| *r == Property::MODEL_BASE) {
            base.properties.push((Property::MODEL_BASE, Value::Bool(true)));
        }
        Some(first)
    }
}
