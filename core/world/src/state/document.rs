//! Computes the fingerprint of a document, by which a snapshot identifies its scene.

use tatu_scene::document::{Document, ObjectSpec};
use xxhash_rust::xxh3::Xxh3;

/// Returns a hash of the settings, objects, scripts, meshes and images of a document, including the seed and overrides,
/// but not the names and paths of files.
pub fn fingerprint(document: &Document) -> u64 {
    let mut h = Xxh3::new();
    let mut put = |text: String| {
        h.update(&(text.len() as u64).to_le_bytes());
        h.update(text.as_bytes());
    };
    // The `Debug` output contains every field, with floats in full precision.
    put(format!("{:?}", document.settings));
    for object in &document.objects {
        let ObjectSpec { kind, alias, parent, properties: rows, device, scripts, placement, group, place: _ } = object;
        put(format!("{:?}", (kind, alias, parent, rows, device, placement, group)));
        for s in scripts {
            put(format!("{:?}", (s.language, &s.dialect, &s.kind, s.priority, &s.text)));
            if s.side_by_side {
                put("side_by_side".to_owned());
            }
        }
    }
    for mesh in &document.meshes {
        put(format!("{:?}", mesh.triangles));
        put(format!("{:?}", mesh.vertices));
        if !mesh.coordinates.is_empty() {
            put(format!("{:?}", mesh.coordinates));
        }
    }
    for image in &document.images {
        h.update(&image.columns().to_le_bytes());
        h.update(image.rgba());
    }
    h.digest()
}
