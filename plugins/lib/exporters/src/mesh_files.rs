//! Meshes as OBJ files beside the exported file.

use std::{collections::BTreeMap, fmt::Write as _};

use crate::{
    names::{NameSpace, file_name},
    numbers::number,
};

/// Folder of the mesh files.
const FOLDER: &str = "meshes";

/// The mesh files of an export. Equal meshes are one file.
#[derive(Default)]
pub struct MeshFiles {
    /// Names by content.
    by_text: BTreeMap<String, String>,
    /// Names in small letters, since some file systems do not distinguish capital ones.
    taken: NameSpace,
}

impl MeshFiles {
    /// Adds a mesh; returns the name of its file relative to the exported file. `wanted` is its name, which may get a
    /// number.
    pub fn add(&mut self, wanted: &str, points: &[[f64; 3]], triangles: &[[u32; 3]]) -> String {
        let text = obj(points, triangles);
        if let Some(name) = self.by_text.get(&text) {
            return name.clone();
        }
        let wanted = file_name(wanted);
        let small = wanted.to_ascii_lowercase();
        let free = self.taken.derived(&small);
        let name = format!("{FOLDER}/{wanted}{}.obj", &free[small.len()..]);
        self.by_text.insert(text, name.clone());
        name
    }

    /// Returns the files: name and content.
    pub fn finish(self) -> BTreeMap<String, String> {
        self.by_text.into_iter().map(|(text, name)| (name, text)).collect()
    }
}

/// Returns a mesh as the text of an OBJ file. Coordinates are read back with all their bits.
fn obj(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> String {
    let mut text = String::with_capacity(40 * points.len() + 20 * triangles.len());
    for [x, y, z] in points {
        let _ = writeln!(text, "v {} {} {}", number(*x), number(*y), number(*z));
    }
    for t in triangles {
        let [a, b, c] = t.map(|i| u64::from(i) + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_meshes_are_one_file_and_names_differ() {
        let mut files = MeshFiles::default();
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.1, 0.0]];
        assert_eq!(files.add("a b", &points, &[[0, 1, 2]]), "meshes/a_b.obj");
        assert_eq!(files.add("other", &points, &[[0, 1, 2]]), "meshes/a_b.obj");
        assert_eq!(files.add("A b", &points, &[[2, 1, 0]]), "meshes/A_b_2.obj");
        let all = files.finish();
        assert_eq!(all["meshes/a_b.obj"], "v 0 0 0\nv 1 0 0\nv 0 0.1 0\nf 1 2 3\n");
        assert_eq!(all.len(), 2);
    }
}
