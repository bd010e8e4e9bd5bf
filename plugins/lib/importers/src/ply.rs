//! PLY, as text or binary.

use std::io::{BufReader, Cursor};

use ply_rs_bw::{
    parser::{Parser, Reader},
    ply::{Property, PropertyAccess, PropertyAccessResult},
};

use crate::model::{MeshPiece, check_triangle_count};

/// A vertex of a PLY file: its position and its texture coordinates, for which several property names are common.
#[derive(Default)]
struct PlyVertex {
    position: [f64; 3],
    place: [Option<f64>; 2],
}

impl PropertyAccess for PlyVertex {
    fn new() -> Self {
        PlyVertex::default()
    }
    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let x = match property {
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            Property::Int(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            _ => return PropertyAccessResult::Set,
        };
        match key {
            "x" => self.position[0] = x,
            "y" => self.position[1] = x,
            "z" => self.position[2] = x,
            "s" | "u" | "texture_u" => self.place[0] = Some(x),
            "t" | "v" | "texture_v" => self.place[1] = Some(x),
            _ => {}
        }
        PropertyAccessResult::Set
    }
}

/// A face of a PLY file; properties other than its vertex indices are ignored.
#[derive(Default)]
struct PlyFace(Vec<u32>);

impl PropertyAccess for PlyFace {
    fn new() -> Self {
        PlyFace::default()
    }
    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        // Files use either of these names.
        if matches!(key, "vertex_index" | "vertex_indices") {
            self.0 = property.to_u32_list().unwrap_or_default();
        }
        PropertyAccessResult::Set
    }
}

pub fn read(bytes: &[u8]) -> Result<MeshPiece, String> {
    let wrong = |e: &dyn std::fmt::Display| format!("the PLY file is incomplete or damaged: {e}");
    let mut reader = Reader::new(BufReader::new(Cursor::new(bytes)));
    let points = Parser::<PlyVertex>::new();
    let faces = Parser::<PlyFace>::new();
    let header = points.read_header(&mut reader).map_err(|e| wrong(&e))?;
    // Every element occupies at least one byte, so a larger count is invalid; the parser would allocate memory for it.
    if let Some((name, e)) = header.elements.iter().find(|(_, e)| e.count > bytes.len()) {
        return Err(format!(
            "the PLY file is incomplete or damaged: it declares {} elements `{name}`, more than it has bytes",
            e.count
        ));
    }
    let mut out = MeshPiece::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read = points.read_payload_for_element(&mut reader, element, &header).map_err(|e| wrong(&e))?;
                let places: Option<Vec<_>> =
                    read.iter().map(|v| Some([v.place[0]? as f32, v.place[1]? as f32])).collect();
                out.coordinates = places.unwrap_or_default();
                out.points = read.into_iter().map(|v| v.position).collect();
            }
            "face" => {
                let read = faces.read_payload_for_element(&mut reader, element, &header).map_err(|e| wrong(&e))?;
                for corners in read.iter().map(|f| f.0.as_slice()) {
                    // Triangulate the polygon as a fan.
                    let fan = corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]);
                    out.triangles.extend(fan);
                    check_triangle_count(out.triangles.len())?;
                }
            }
            _ => drop(points.read_payload_for_element(&mut reader, element, &header).map_err(|e| wrong(&e))?),
        }
    }
    Ok(out)
}
