//! What the targets do with a file that was read: everything that makes a scene of it looks at the same things.

use tatu_importers_vrep_scene::read::{
    file::{File, Kind},
    surface::leaves,
};

/// Reads a file and looks at all surfaces of its shapes.
pub fn look_at(bytes: &[u8]) {
    let Ok(file) = File::read(bytes) else { return };
    for o in &file.objects {
        let Kind::Shape(s) = &o.kind else { continue };
        for part in s.root.as_ref().map(leaves).unwrap_or_default() {
            let _ = file.surface(part.leaf, s.shared.as_ref(), o.section.at);
        }
    }
}
