//! Meshes that a scene refers to by file name.

use std::path::Path;

use nalgebra::Isometry3;
use tatu_errors::{Error, Result};
use tatu_geometry::{Form, Mesh};
use tatu_plugin_api::safe::Value;

use super::{
    super::{Document, DocumentBuilder, KeyTarget, import},
    SceneFileReader,
};
use crate::{forms::visible_parts, property_table::FileForm};

impl SceneFileReader<'_> {
    /// Replaces the file names of meshes and images in a value by their numbers.
    pub(super) fn with_files(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        target: &KeyTarget,
        value: Value,
    ) -> Result<Value> {
        let form = if let KeyTarget::Property(row) = target { row.spec().file_form } else { FileForm::Plain };
        match (form, value) {
            (FileForm::Mesh, Value::Text(name)) => self.mesh(b, &name),
            (FileForm::Parts, Value::List(mut parts)) => {
                let entries = parts.iter_mut().filter_map(|p| if let Value::Map(m) = p { Some(m) } else { None });
                for (key, value) in entries.flatten() {
                    match value {
                        Value::Text(name) if *key == Value::text("mesh") => *value = self.mesh(b, name)?,
                        texture if *key == Value::text("texture") => self.with_image(b, texture)?,
                        _ => {}
                    }
                }
                Ok(Value::List(parts))
            }
            (FileForm::Texture, mut texture) => {
                self.with_image(b, &mut texture)?;
                Ok(texture)
            }
            (_, value) => Ok(value),
        }
    }

    /// Returns the number of the mesh in a file, which the document must be permitted to name.
    fn mesh(&mut self, b: &mut DocumentBuilder<'_>, name: &[u8]) -> Result<Value> {
        let name = String::from_utf8_lossy(name).into_owned();
        let folder = self.text.file.parent().unwrap_or(Path::new(""));
        let file = folder.join(&name);
        if let Some(number) = self.meshes.get(&file) {
            return Ok(Value::Int(*number));
        }
        let lacks = || {
            Error::new("E105", format!("cannot read the mesh `{name}`"))
                .expected(format!("a mesh file {}", file.display()))
        };
        let bytes = b.read_named_file(folder, &name)?.ok_or_else(lacks)?;
        let choice = self.registry.importer_of(&file, &bytes, &b.document.settings.providers)?;
        let choice = choice.ok_or_else(|| self.registry.no_importer(Path::new(&name)))?;
        // The file is imported to a separate document, of which only the mesh is used.
        let mut alone = Document { sources: b.document.sources.clone(), ..Default::default() };
        let mut inner = DocumentBuilder::new(self.registry, &mut alone, b.reach.clone());
        (inner.place, inner.read_text) = (b.place.clone(), b.read_text);
        let import = import::ImportRequest { file: &file, bytes: &bytes, choice, params: &[], is_scene: false };
        inner.import(import, None, Isometry3::identity())?;
        let Some(mesh) = only_mesh(&alone) else {
            return Err(Error::new("E120", format!("`{name}` contains {} meshes", alone.meshes.len()))
                .expected("one mesh, or one shape that consists of meshes")
                .help("use `[[import]]` to place its meshes"));
        };
        let number = b.mesh(mesh)? as i64;
        self.meshes.insert(file, number);
        Ok(Value::Int(number))
    }
}

/// Returns the only mesh of a document, or the joined meshes of its only shape, because importers split meshes by
/// material.
fn only_mesh(document: &Document) -> Option<Mesh> {
    if let [mesh] = document.meshes.as_slice() {
        return Some((**mesh).clone());
    }
    let (scene, slots) = document.instantiate();
    let [slot] = slots.as_slice() else { return None };
    let mut joined = Mesh::default();
    for part in visible_parts(scene.get(*slot)?.shape()?) {
        let Form::Mesh { mesh, .. } = part.form else { return None };
        let first = joined.vertices.len();
        joined.vertices.extend(mesh.vertices.iter().map(|v| part.pose * v));
        joined.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first as u32)));
        if joined.coordinates.len() == first {
            joined.coordinates.extend_from_slice(&mesh.coordinates);
        }
    }
    if joined.coordinates.len() != joined.vertices.len() {
        joined.coordinates.clear();
    }
    (!joined.triangles.is_empty()).then_some(joined)
}
