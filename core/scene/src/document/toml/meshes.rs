//! Meshes that a scene refers to by file name.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::Value;

use super::{
    super::{Builder, Document, Target, import, import_files::Source},
    Reader,
};
use crate::rows::Row;

impl Reader<'_> {
    /// Replaces the file names of meshes and images in a value by their numbers.
    pub(super) fn with_files(&mut self, b: &mut Builder<'_>, target: &Target, value: Value) -> Result<Value> {
        match (target, value) {
            (Target::Row(Row::Mesh), Value::Text(name)) => self.mesh(b, &name),
            (Target::Row(Row::Parts), Value::List(mut parts)) => {
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
            (Target::Row(Row::Texture), mut texture) => {
                self.with_image(b, &mut texture)?;
                Ok(texture)
            }
            (_, value) => Ok(value),
        }
    }

    /// Returns the number of the mesh in a file, which must be in the scene's folder or below.
    fn mesh(&mut self, b: &mut Builder<'_>, name: &[u8]) -> Result<Value> {
        let name = String::from_utf8_lossy(name).into_owned();
        let folder = self.text.file.parent().unwrap_or(Path::new("")).to_owned();
        let file = folder.join(&name);
        if let Some(number) = self.meshes.get(&file) {
            return Ok(Value::Int(*number));
        }
        let from = Source { name: None, folder: Some(folder.clone()), roots: roots(b, folder), whole: false };
        let lacks = || {
            Error::new("E105", format!("cannot read the mesh `{name}`"))
                .expected(format!("a mesh file {}", file.display()))
        };
        let bytes = from.read(&name, &b.document.sources)?.ok_or_else(lacks)?;
        let choice = self.registry.importer_of(&file, &bytes, &b.document.settings.providers)?;
        let choice = choice.ok_or_else(|| self.registry.no_importer(Path::new(&name)))?;
        // All other contents of the file go to a separate document, which is discarded.
        let mut alone = Document { sources: b.document.sources.clone(), ..Default::default() };
        let mut inner =
            Builder { registry: self.registry, document: &mut alone, group: 0, place: b.place.clone(), texts: b.texts };
        let import = import::Import { file: &file, bytes: &bytes, choice, params: &[], whole: false };
        inner.import(import, None, Isometry3::identity())?;
        let [mesh] = alone.meshes.as_slice() else {
            return Err(Error::new("E120", format!("`{name}` contains {} meshes", alone.meshes.len()))
                .expected("one mesh")
                .help("use `[[import]]` to place its meshes"));
        };
        let number = b.mesh((**mesh).clone())? as i64;
        self.meshes.insert(file, number);
        Ok(Value::Int(number))
    }
}

/// Returns the folders that files must be in: that of the current file, and that of the scene.
pub(super) fn roots(b: &Builder<'_>, folder: PathBuf) -> Vec<PathBuf> {
    let scene = b.document.file.as_ref().and_then(|f| f.parent()).map(PathBuf::from);
    [folder].into_iter().chain(scene).collect()
}
