//! STL, as text or binary.

use std::io::Cursor;

use crate::model::{MeshPiece, check_triangle_count};

/// Returns whether the file has exactly the size of a binary STL file with the declared number of triangles.
fn is_binary(bytes: &[u8]) -> bool {
    let Some(count) = bytes.get(80..84) else { return false };
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
    (bytes.len() - 84) as u64 == 50 * u64::from(count)
}

pub fn is_stl(bytes: &[u8]) -> bool {
    is_binary(bytes) || bytes.trim_ascii_start().starts_with(b"solid")
}

pub fn read(bytes: &[u8]) -> Result<MeshPiece, String> {
    let mut bytes = bytes.to_vec();
    if is_binary(&bytes) {
        // Many programs write binary files whose header begins with `solid`, which the parser would read as text.
        bytes[..80].fill(b' ');
    }
    let mesh =
        stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| format!("the STL file is incomplete or damaged: {e}"))?;
    check_triangle_count(mesh.faces.len())?;
    Ok(MeshPiece {
        points: mesh.vertices.iter().map(|v| [v[0], v[1], v[2]].map(f64::from)).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices.map(|i| i as u32)).collect(),
        ..Default::default()
    })
}
