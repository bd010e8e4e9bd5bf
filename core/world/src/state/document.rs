//! Which scene a snapshot is of: a number over all that decides how a document runs.

use tatu_scene::document::{Document, ObjectSpec};
use xxhash_rust::xxh3::Xxh3;

/// The same for equal scenes, wherever their files lie; seed and overrides count, names of files do not.
pub fn fingerprint(document: &Document) -> u64 {
    let mut h = Xxh3::new();
    let mut put = |text: String| {
        h.update(&(text.len() as u64).to_le_bytes());
        h.update(text.as_bytes());
    };
    // The derived texts hold every field, and floats in full.
    put(format!("{:?}", document.settings));
    for object in &document.objects {
        let ObjectSpec { kind, alias, parent, rows, device, scripts, placement, group, place: _ } = object;
        put(format!("{:?}", (kind, alias, parent, rows, device, placement, group)));
        for s in scripts {
            put(format!("{:?}", (s.language, &s.dialect, &s.kind, s.priority, &s.text)));
        }
    }
    for mesh in &document.meshes {
        put(format!("{:?}", mesh.triangles));
        put(format!("{:?}", mesh.vertices));
    }
    h.digest()
}
