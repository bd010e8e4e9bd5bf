//! Parsers of mesh files. The format is detected from the bytes.

use std::io::{BufReader, Cursor};

use ply_rs_bw::{
    parser::{Parser, Reader},
    ply::{Property, PropertyAccess, PropertyAccessResult},
};

/// Most triangles of a file.
const MOST_TRIANGLES: usize = 4_000_000;

/// A triangle mesh, in the unit of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    pub points: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

/// Parses a mesh; the error is one sentence.
pub fn mesh(bytes: &[u8]) -> Result<Mesh, String> {
    let mesh = match bytes {
        _ if bytes.starts_with(b"ply") => ply(bytes)?,
        _ if is_stl(bytes) => stl(bytes)?,
        _ => obj(bytes)?,
    };
    if mesh.triangles.is_empty() {
        return Err("the file contains no triangles".into());
    }
    let n = mesh.points.len();
    if mesh.triangles.iter().flatten().any(|i| *i as usize >= n) {
        return Err("a face refers to a point that does not exist".into());
    }
    if mesh.points.iter().flatten().any(|x| !x.is_finite()) {
        return Err("a point is not finite".into());
    }
    Ok(mesh)
}

/// Returns the number of triangles declared by a binary STL file; `None` if the file's length does not match it.
fn binary_stl(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..84)?;
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize;
    ((bytes.len() - 84) as u64 == 50 * count as u64).then_some(count)
}

fn is_stl(bytes: &[u8]) -> bool {
    binary_stl(bytes).is_some() || bytes.trim_ascii_start().starts_with(b"solid")
}

fn stl(bytes: &[u8]) -> Result<Mesh, String> {
    let mut bytes = bytes.to_vec();
    if binary_stl(&bytes).is_some() {
        // Many programs begin the header of binary files with `solid`, so that they look like text; blanks avoid that.
        bytes[..80].fill(b' ');
    }
    let mesh =
        stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| format!("the STL file is incomplete or damaged: {e}"))?;
    few(mesh.faces.len())?;
    Ok(Mesh {
        points: mesh.vertices.iter().map(|v| [v[0], v[1], v[2]].map(f64::from)).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices.map(|i| i as u32)).collect(),
    })
}

/// Parses Wavefront OBJ; all groups are merged, materials are ignored.
fn obj(bytes: &[u8]) -> Result<Mesh, String> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials)
        .map_err(|e| format!("the OBJ file is incomplete or damaged: {e}"))?;
    let mut out = Mesh::default();
    for m in models {
        let first = out.points.len() as u32;
        out.points.extend(m.mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]].map(f64::from)));
        out.triangles.extend(m.mesh.indices.chunks_exact(3).map(|t| [t[0] + first, t[1] + first, t[2] + first]));
        few(out.triangles.len())?;
    }
    Ok(out)
}

/// A vertex of a PLY file; properties other than its position are ignored.
#[derive(Default)]
struct Point([f64; 3]);

impl PropertyAccess for Point {
    fn new() -> Self {
        Point::default()
    }
    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let place = ["x", "y", "z"].iter().position(|k| *k == key);
        let x = match property {
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            Property::Int(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            _ => return PropertyAccessResult::Set,
        };
        if let Some(i) = place {
            self.0[i] = x;
        }
        PropertyAccessResult::Set
    }
}

/// A face of a PLY file; properties other than its vertex indices are ignored.
#[derive(Default)]
struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Face::default()
    }
    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        // Both names are common.
        if matches!(key, "vertex_index" | "vertex_indices") {
            self.0 = property.to_u32_list().unwrap_or_default();
        }
        PropertyAccessResult::Set
    }
}

fn ply(bytes: &[u8]) -> Result<Mesh, String> {
    let wrong = |e: &dyn std::fmt::Display| format!("the PLY file is incomplete or damaged: {e}");
    let mut reader = Reader::new(BufReader::new(Cursor::new(bytes)));
    let points = Parser::<Point>::new();
    let faces = Parser::<Face>::new();
    let header = points.read_header(&mut reader).map_err(|e| wrong(&e))?;
    // Every element takes at least one byte, so a larger count is invalid; the parser would reserve memory for it.
    if let Some((name, e)) = header.elements.iter().find(|(_, e)| e.count > bytes.len()) {
        return Err(format!(
            "the PLY file is incomplete or damaged: it declares {} elements `{name}`, more than it has bytes",
            e.count
        ));
    }
    let mut out = Mesh::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read = points.read_payload_for_element(&mut reader, element, &header).map_err(|e| wrong(&e))?;
                out.points = read.into_iter().map(|p| p.0).collect();
            }
            "face" => {
                let read = faces.read_payload_for_element(&mut reader, element, &header).map_err(|e| wrong(&e))?;
                for corners in read.iter().map(|f| f.0.as_slice()) {
                    // Polygons are triangulated as fans.
                    let fan = corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]);
                    out.triangles.extend(fan);
                    few(out.triangles.len())?;
                }
            }
            _ => drop(points.read_payload_for_element(&mut reader, element, &header).map_err(|e| wrong(&e))?),
        }
    }
    Ok(out)
}

fn few(triangles: usize) -> Result<(), String> {
    match triangles > MOST_TRIANGLES {
        true => Err(format!("the mesh has {triangles} triangles; at most {MOST_TRIANGLES} are supported")),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendloop\nendfacet\nendsolid a\n";
    const PLY: &str = "ply\nformat ascii 1.0\ncomment a triangle\nelement vertex 3\nproperty double x\nproperty double y\n\
        property double z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 9\n1 0 0 9\n0 2 0 9\n3 0 1 2\n";

    #[test]
    fn all_formats_give_the_same_triangle() {
        let wanted = Mesh { points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]], triangles: vec![[0, 1, 2]] };
        assert_eq!(mesh(STL.as_bytes()).unwrap(), wanted);
        assert_eq!(mesh(PLY.as_bytes()).unwrap(), wanted);
        assert_eq!(mesh(b"# a comment\nv 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n").unwrap(), wanted);
        assert_eq!(mesh(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap().triangles.len(), 2);
        assert_eq!(mesh(PLY.replace("3 0 1 2", "4 0 1 2 1").as_bytes()).unwrap().triangles, [[0, 1, 2], [0, 2, 1]]);
    }

    /// Numbers written with all digits are read back exactly, and points keep their order.
    #[test]
    fn numbers_of_ply_are_exact() {
        let text = PLY.replace("1 0 0 9", "0.1 1e-300 -123456.78901234567 9");
        assert_eq!(mesh(text.as_bytes()).unwrap().points[1], [0.1, 1e-300, -123456.78901234567]);
    }

    #[test]
    fn cut_and_wrong_files_are_errors() {
        for text in [STL, PLY, "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n"] {
            for n in 0..text.len() {
                let _ = mesh(&text.as_bytes()[..n]);
                let mut bytes = text.as_bytes().to_vec();
                bytes[n] ^= 21;
                let _ = mesh(&bytes);
            }
        }
        assert!(mesh(PLY.replace("element vertex 3", "element vertex 4000000000").as_bytes()).is_err());
        assert!(mesh(PLY.replace("3 0 1 2", "3 0 1 7").as_bytes()).is_err());
        assert!(mesh(PLY.replace("3 0 1 2", "3 0 1 -1").as_bytes()).is_err());
        assert!(mesh(b"v 0 0 0\n").is_err() && mesh(b"").is_err());
    }
}
