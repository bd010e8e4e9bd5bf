//! Writes a document as a scene file, with one `[[object]]` table for each object. Properties that are not set, or that
//! equal a fixed default, are left out. Scripts, meshes and images are written to separate files.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    fs, io,
    path::Path,
};

use nalgebra::UnitQuaternion;
use tatu_errors::{Error, Result};
use tatu_geometry::Mesh;
use tatu_plugin_api::safe::Value;
use tatu_plugins::Registry;

use super::{
    super::{
        Document, DocumentBuilder, KeyTarget, NORMAL_PRIORITY, ObjectSpec, PRIORITIES, WorldSettings,
        reach::AllowedFolders, settings,
    },
    images,
    value_text::{custom_data_text, divided, line, line_in_form, quoted, text},
};
use crate::{
    Scene, from_euler,
    property_table::{FileForm, Property},
    to_euler,
};

/// A scene file and its separate files.
#[derive(Debug, Clone, Default)]
pub struct SceneFiles {
    /// The text of the scene file.
    pub text: String,
    /// The separate files: names relative to the scene file, and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// Properties that cannot be expressed in a file and are left out, each with its object.
    pub left_out: Vec<String>,
}

/// Writes a document. `folder` is the folder of separate files, relative to the scene file.
///
/// Reading the result yields the same scene, with the same bits in every number, except for the properties in
/// [`SceneFiles::left_out`]. The objects of models and imports are written as single objects, with their unique names.
pub fn write(document: &Document, registry: &Registry, folder: &str) -> Result<SceneFiles> {
    // This copy is used only to look up the meaning of keys.
    let mut copy = document.clone();
    let builder = DocumentBuilder::new(registry, &mut copy, AllowedFolders::none());
    let mut writer = SceneFileWriter::new(document, registry, folder, BTreeSet::new());
    writer.out.text = "format = 1\n".into();
    writer.world();
    writer.services();
    writer.languages();
    if let Some(env) = &document.requests.env {
        writer.out.text.push('\n');
        writer.out.text += env.trim();
        writer.out.text.push('\n');
    }
    for (i, spec) in document.objects.iter().enumerate() {
        writer.object(&builder, i, spec, None)?;
    }
    Ok(writer.out)
}

/// Writes single objects of a document.
pub struct ObjectWriter<'a> {
    writer: SceneFileWriter<'a>,
    /// Used only to look up the meaning of keys.
    copy: Document,
}

impl<'a> ObjectWriter<'a> {
    /// Creates a writer for the objects of a document. `taken` contains the names of existing separate files, in lower
    /// case.
    pub fn new(document: &'a Document, registry: &'a Registry, folder: &'a str, taken: BTreeSet<String>) -> Self {
        ObjectWriter { writer: SceneFileWriter::new(document, registry, folder, taken), copy: document.clone() }
    }
    /// Returns the separate files, and the properties that were left out.
    pub fn finish(self) -> SceneFiles {
        self.writer.out
    }
}

/// Returns the table of an object as text. `parent` is the path of its parent.
pub fn object_text(pieces: &mut ObjectWriter<'_>, index: usize, parent: Option<&str>) -> Result<String> {
    let ObjectWriter { writer, copy } = pieces;
    let registry = writer.registry;
    let builder = DocumentBuilder::new(registry, copy, AllowedFolders::none());
    let spec = &writer.document.objects[index];
    writer.object(&builder, index, spec, parent)?;
    Ok(std::mem::take(&mut writer.out.text))
}

/// Returns the folder for the separate files of a scene file, relative to it.
pub fn folder_beside(scene: &Path) -> String {
    let stem = scene.file_stem().map_or("scene".into(), |s| s.to_string_lossy().into_owned());
    format!("{stem}_files")
}

/// Writes the separate files and then the scene file, which therefore never refers to a missing file. `whole` writes a
/// file atomically.
pub fn save(scene: &Path, written: &SceneFiles, whole: &dyn Fn(&Path, &[u8]) -> io::Result<()>) -> Result {
    let above = scene.parent().unwrap_or(Path::new(""));
    let fail = |path: &Path, e: io::Error| Error::new("E105", format!("cannot write {}: {e}", path.display()));
    for (name, bytes) in &written.files {
        let path = above.join(name);
        let folder = path.parent().unwrap_or(above);
        fs::create_dir_all(folder).map_err(|e| fail(folder, e))?;
        whole(&path, bytes).map_err(|e| fail(&path, e))?;
    }
    whole(scene, written.text.as_bytes()).map_err(|e| fail(scene, e))
}

struct SceneFileWriter<'a> {
    document: &'a Document,
    registry: &'a Registry,
    scene: Scene,
    slots: Vec<u32>,
    folder: &'a str,
    out: SceneFiles,
    /// Names of files in use, in lower case.
    names: BTreeSet<String>,
    /// Files of meshes, by number of the mesh.
    meshes: BTreeMap<i64, String>,
    /// Files of images, by number of the image.
    images: BTreeMap<i64, String>,
    /// Number of objects with each alias.
    users: BTreeMap<&'a str, usize>,
}

impl<'a> SceneFileWriter<'a> {
    fn new(document: &'a Document, registry: &'a Registry, folder: &'a str, names: BTreeSet<String>) -> Self {
        let (scene, slots) = document.instantiate();
        let mut users: BTreeMap<&str, usize> = BTreeMap::new();
        for spec in &document.objects {
            *users.entry(&spec.alias).or_default() += 1;
        }
        let (out, meshes, images) = (SceneFiles::default(), BTreeMap::new(), BTreeMap::new());
        SceneFileWriter { document, registry, scene, slots, folder, out, names, meshes, images, users }
    }

    fn put(&mut self, line: &str) {
        self.out.text += line;
        self.out.text.push('\n');
    }

    /// Writes `[scene]` and `[providers]`.
    fn world(&mut self) {
        let mut lines = Vec::new();
        let (ours, usual) = (settings::values(&self.document.settings), settings::values(&WorldSettings::default()));
        for (key, unit, value) in ours {
            if usual.iter().any(|(k, _, v)| *k == key && *v == value) {
                continue;
            }
            match line(key, unit, &value) {
                Some(line) => lines.push(line),
                None => self.out.left_out.push(format!("scene.{key}")),
            }
        }
        let notes = crate::notes_value(&self.document.notes);
        if !self.document.notes.is_empty() {
            match custom_data_text(&notes) {
                Some(text) => lines.push(format!("data = {text}")),
                None => self.out.left_out.push("scene.data".into()),
            }
        }
        if !lines.is_empty() {
            self.put("\n[scene]");
            lines.iter().for_each(|l| self.put(l));
        }
        if !self.document.settings.providers.is_empty() {
            self.put("\n[providers]");
            for (role, id) in &self.document.settings.providers {
                self.put(&format!("{} = {}", quoted(role), quoted(id)));
            }
        }
    }

    fn services(&mut self) {
        for spec in &self.document.requests.services {
            let kind = &self.registry.services[spec.kind];
            self.put("\n[[service]]");
            self.put(&format!("id = {}", quoted(&kind.id)));
            for declared in &kind.params {
                let Some((key, value)) = spec.params.iter().rev().find(|(k, _)| *k == declared.key) else { continue };
                match line(key, declared.unit.as_deref(), value) {
                    Some(line) => self.put(&line),
                    None => self.out.left_out.push(format!("{}: {key}", kind.id)),
                }
            }
        }
    }

    /// Writes the settings of languages that the scene's own file states.
    fn languages(&mut self) {
        for (index, language) in self.registry.scripting.languages.iter().enumerate() {
            let own = self.document.requests.languages.iter().filter(|s| s.language == index && s.is_of_scene);
            let own: Vec<_> = own.collect();
            if !own.is_empty() {
                self.put(&format!("\n[language.{}]", language.id));
            }
            for setting in own {
                let unit = language.params.iter().find(|p| p.key == setting.key).and_then(|p| p.unit.as_deref());
                match line(&setting.key, unit, &setting.value) {
                    Some(line) => self.put(&line),
                    None => self.out.left_out.push(format!("{}: {}", language.id, setting.key)),
                }
            }
        }
    }

    /// Writes an object. `parent` is the path of its parent; if `None`, the unique name of the parent is written.
    fn object(
        &mut self,
        builder: &DocumentBuilder<'_>,
        index: usize,
        spec: &ObjectSpec,
        parent: Option<&str>,
    ) -> Result {
        let slot = self.slots[index];
        let own = self.name_of(slot);
        self.put("\n[[object]]");
        self.put(&format!("kind = {}", quoted(spec.kind.name())));
        self.put(&format!("alias = {}", quoted(&spec.alias)));
        // If an alias is unique, it is also the object's unique name.
        if own != spec.alias || self.users.get(spec.alias.as_str()).is_some_and(|n| *n > 1) {
            self.put(&format!("name = {}", quoted(&own)));
        }
        let by_name = spec.parent.map(|p| self.name_of(self.slots[p]));
        if let Some(parent) = parent.or(by_name.as_deref()) {
            self.put(&format!("parent = {}", quoted(parent)));
        }
        if let Some(d) = &spec.device {
            let key = spec.kind.name();
            let kind = self.registry.device(spec.is_actuator(), d.kind);
            self.put(&format!("{key} = {}", quoted(kind.id)));
        }
        self.pose(slot);
        let declared = builder.declarations(index);
        for (row, value) in last_of_each(&spec.properties) {
            let placed = matches!(
                row,
                Property::POSITION
                    | Property::QUATERNION
                    | Property::ORIENTATION
                    | Property::POSE
                    | Property::WORLD_POSE
            );
            if placed || row == Property::NAME || is_omitted_default(row, value) {
                continue;
            }
            let info = declared.iter().find(|(_, t)| matches!(t, KeyTarget::Property(r) if *r == row));
            let Some((d, _)) = info else { continue };
            let form = row.spec().file_form;
            let value = match form {
                FileForm::Texture => &self.with_image(value, &spec.alias),
                FileForm::Mesh | FileForm::Parts => &self.with_files(value, &spec.alias),
                _ => value,
            };
            match line_in_form(form, &d.key, d.unit.as_deref(), value) {
                Some(line) => self.put(&line),
                None => self.out.left_out.push(format!("{own}: {}", d.key)),
            }
        }
        for (key, value) in spec.device.iter().flat_map(|d| last_of_each(&d.params)) {
            let param = declared.iter().find(|(d, t)| matches!(t, KeyTarget::Param(_)) && d.key == key);
            let Some((d, _)) = param else { continue };
            match line(&d.key, d.unit.as_deref(), value) {
                Some(line) => self.put(&line),
                None => self.out.left_out.push(format!("{own}: {key}")),
            }
        }
        self.scripts(spec)
    }

    fn name_of(&self, slot: u32) -> String {
        self.scene.get(slot).map_or_else(String::new, crate::Object::name)
    }

    /// Writes the pose in the frame of the parent.
    fn pose(&mut self, slot: u32) {
        let local = self.scene.local(slot);
        let place: Vec<f64> = local.translation.vector.iter().copied().collect();
        if place.iter().any(|x| *x != 0.0) {
            let value = text(&Value::Floats(place), 1.0).unwrap_or_default();
            self.put(&format!("position_m = {value}"));
        }
        let line = orientation_line(&local.rotation);
        if !line.is_empty() {
            self.put(&line);
        }
    }

    /// Replaces the numbers of meshes and images in a value of `mesh` or `parts` by file names.
    fn with_files(&mut self, value: &Value, alias: &str) -> Value {
        match value {
            Value::Int(number) => Value::text(self.mesh(*number, alias)),
            Value::List(parts) => Value::List(
                parts
                    .iter()
                    .map(|part| {
                        let Value::Map(entries) = part else { return part.clone() };
                        let entry = |(k, v): &(Value, Value)| match v {
                            Value::Int(_) if *k == Value::text("mesh") => (k.clone(), self.with_files(v, alias)),
                            Value::Map(_) if *k == Value::text("texture") => (k.clone(), self.with_image(v, alias)),
                            _ => (k.clone(), v.clone()),
                        };
                        Value::Map(entries.iter().map(entry).collect())
                    })
                    .collect(),
            ),
            other => other.clone(),
        }
    }

    /// Replaces the number of the image in a texture by a file name.
    fn with_image(&mut self, value: &Value, alias: &str) -> Value {
        let Value::Map(entries) = value else { return value.clone() };
        let entry = |(k, v): &(Value, Value)| match v {
            Value::Int(number) if *k == Value::text("image") => (k.clone(), Value::text(self.image(*number, alias))),
            _ => (k.clone(), v.clone()),
        };
        Value::Map(entries.iter().map(entry).collect())
    }

    /// Returns the file of an image, adding the file when the image is first used.
    fn image(&mut self, number: i64, alias: &str) -> String {
        if let Some(file) = self.images.get(&number) {
            return file.clone();
        }
        let file = self.file(alias, ".png");
        let image = usize::try_from(number - 1).ok().and_then(|n| self.document.images.get(n));
        self.out.files.push((file.clone(), image.map_or_else(Vec::new, |i| images::encode_png(i))));
        self.images.insert(number, file.clone());
        file
    }

    /// Returns the file of a mesh, adding the file when the mesh is first used.
    fn mesh(&mut self, number: i64, alias: &str) -> String {
        if let Some(file) = self.meshes.get(&number) {
            return file.clone();
        }
        let file = self.file(alias, ".ply");
        let mesh = usize::try_from(number - 1).ok().and_then(|n| self.document.meshes.get(n));
        self.out.files.push((file.clone(), mesh.map_or_else(Vec::new, |m| ply(m))));
        self.meshes.insert(number, file.clone());
        file
    }

    fn scripts(&mut self, spec: &ObjectSpec) -> Result {
        let mut all = Vec::new();
        for script in &spec.scripts {
            let language = &self.registry.scripting.languages[script.language];
            let suffix = language.suffixes.first().map_or(".txt", String::as_str);
            let file = self.file(&spec.alias, suffix);
            let mut entry = format!("file = {}", quoted(&file));
            let by_suffix = self.registry.language(&file, &self.document.settings.providers);
            if by_suffix.ok() != Some(script.language) {
                let _ = write!(entry, ", language = {}", quoted(&language.id));
            }
            if !script.dialect.is_empty() {
                let _ = write!(entry, ", dialect = {}", quoted(&script.dialect));
            }
            if script.kind != "child" {
                let _ = write!(entry, ", kind = {}", quoted(&script.kind));
            }
            if script.priority != NORMAL_PRIORITY {
                let _ = write!(entry, ", priority = {}", quoted(PRIORITIES[usize::from(script.priority)]));
            }
            if script.side_by_side {
                entry += ", side_by_side = true";
            }
            self.out.files.push((file, script.text.clone()));
            all.push(format!("{{ {entry} }}"));
        }
        match all.as_slice() {
            [] => {}
            [one] => self.put(&format!("script = {one}")),
            _ => {
                let list: String = all.iter().map(|s| format!("    {s},\n")).collect();
                self.put(&format!("scripts = [\n{list}]"));
            }
        }
        Ok(())
    }

    /// Returns a unique name for a separate file, based on the alias of the object that uses it.
    fn file(&mut self, alias: &str, suffix: &str) -> String {
        let keep = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
        let stem: String = alias.chars().map(|c| if keep(c) { c } else { '_' }).take(60).collect();
        let mut name = format!("{}/{stem}{suffix}", self.folder);
        for n in 2.. {
            // Some file systems are case-insensitive.
            if self.names.insert(name.to_lowercase()) {
                break;
            }
            name = format!("{}/{stem}_{n}{suffix}", self.folder);
        }
        name
    }
}

/// Properties that are not written if they have their default.
#[rustfmt::skip]
const OMITTED_IF_DEFAULT: [Property; 15] = [
    Property::MODEL_BASE, Property::DYNAMIC, Property::RESPONDABLE, Property::BULLET, Property::ASLEEP, Property::CONVEX, Property::VISIBLE, Property::LAYER,
    Property::RESPONDABLE_MASK, Property::DETECTABLE_MASK, Property::JOINT_POSITION, Property::TARGET_POSITION, Property::TARGET_VELOCITY,
    Property::MAX_FORCE, Property::JOINT_MODE,
];

/// Returns whether a value is the default of a property that is then left out.
fn is_omitted_default(row: Property, value: &Value) -> bool {
    OMITTED_IF_DEFAULT.contains(&row) && *value == row.spec().default()
}

/// Returns the last value of each key, in the order in which these values were set.
fn last_of_each<K: PartialEq + Clone, V>(all: &[(K, V)]) -> impl Iterator<Item = (K, &V)> {
    let kept = all.iter().enumerate().filter(|(i, (k, _))| !all[i + 1..].iter().any(|(later, _)| later == k));
    kept.map(|(_, (k, v))| (k.clone(), v))
}

/// Formats an orientation as a line of a table: angles if they reproduce all bits, otherwise a quaternion. The identity
/// yields an empty string.
fn orientation_line(q: &UnitQuaternion<f64>) -> String {
    const RAD_PER_DEGREE: f64 = std::f64::consts::PI / 180.0;
    // The quaternions 1 and -1 are the same orientation, but differ in their bits.
    if q.coords == UnitQuaternion::identity().coords {
        return String::new();
    }
    let near = to_euler(q).map(|x| format!("{:.9}", x / RAD_PER_DEGREE).parse::<f64>().unwrap_or(0.0));
    let short = from_euler(near.map(|d| d * RAD_PER_DEGREE));
    if short.coords == q.coords && near.iter().all(|d| divided(d * RAD_PER_DEGREE, RAD_PER_DEGREE).is_some()) {
        return format!("orientation_deg = {}", text(&Value::Floats(near.to_vec()), 1.0).unwrap_or_default());
    }
    let value = Value::Floats(q.coords.iter().copied().collect());
    format!("quaternion = {}", text(&value, 1.0).unwrap_or_default())
}

/// Encodes a mesh as a PLY file, with full precision.
fn ply(mesh: &Mesh) -> Vec<u8> {
    let places = if mesh.coordinates.is_empty() { "" } else { "property float s\nproperty float t\n" };
    let mut out = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n{places}\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    );
    for (i, v) in mesh.vertices.iter().enumerate() {
        let _ = write!(out, "{:?} {:?} {:?}", v.x, v.y, v.z);
        let _ = match mesh.coordinates.get(i) {
            Some([s, t]) => writeln!(out, " {s:?} {t:?}"),
            None => writeln!(out),
        };
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(out, "3 {a} {b} {c}");
    }
    out.into_bytes()
}
