//! The code that the fuzz targets share. It exercises the same functions as the importer that builds a scene from a
//! file.

use tatu_importers_vrep_scene::read::{
    file::{ObjectKind, VrepFile},
    surface::leaves,
};

/// Parses a file and computes the surfaces of all its shapes. Errors are ignored; only panics and crashes are failures.
pub fn look_at(bytes: &[u8]) {
    let Ok(file) = VrepFile::read(bytes) else { return };
    for o in &file.objects {
        let ObjectKind::Shape(s) = &o.kind else { continue };
        for part in s.root.as_ref().map(leaves).unwrap_or_default() {
            let _ = file.surface(part.leaf, s.shared.as_ref(), o.section.at);
        }
    }
}
