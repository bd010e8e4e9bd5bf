//! STL, as text or binary.

use std::io::Cursor;

use crate::model::{MeshPiece, check_triangle_count};

/// Bytes of a binary file before its triangles, and of each triangle.
const HEADER_BYTES: usize = 84;
const TRIANGLE_BYTES: usize = 50;

/// Returns the length of a binary file, bytes, or `None` if the file is text. Some programs write further bytes after
/// the triangles; such a file is binary if its header contains bytes that no text has.
fn binary_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES)?;
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize;
    let length = count.checked_mul(TRIANGLE_BYTES)?.checked_add(HEADER_BYTES)?;
    let is_text = |b: &u8| matches!(b, b'\t' | b'\n' | b'\r' | b' '..=b'~');
    let has_trailing_bytes = count > 0 && length < bytes.len() && !bytes[..HEADER_BYTES].iter().all(is_text);
    (length == bytes.len() || has_trailing_bytes).then_some(length)
}

pub fn is_stl(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let start = text.trim_ascii_start().get(..5).unwrap_or_default();
    start.eq_ignore_ascii_case(b"solid") || binary_length(bytes).is_some()
}

/// Returns the text as the parser knows it: in lower case, and all triangles in one solid, which has a name.
fn single_solid(text: &[u8]) -> Vec<u8> {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text).to_ascii_lowercase();
    let mut out = b"solid a\n".to_vec();
    for line in text.split(|b| *b == b'\n') {
        let word = line.trim_ascii_start();
        if !word.starts_with(b"solid") && !word.starts_with(b"endsolid") {
            out.extend_from_slice(line);
            out.push(b'\n');
        }
    }
    out.extend_from_slice(b"endsolid a\n");
    out
}

pub fn read(bytes: &[u8]) -> Result<MeshPiece, String> {
    let mut bytes = bytes.to_vec();
    match binary_length(&bytes) {
        Some(length) => {
            bytes.truncate(length);
            // Many programs write binary files whose header begins with `solid`, which the parser would read as text.
            bytes[..HEADER_BYTES - 4].fill(b' ');
        }
        None => bytes = single_solid(&bytes),
    }
    // The parser's message contains what it could not read, which can be anything, of any length.
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|_| {
        "the STL file is incomplete or damaged: expected `facet normal`, `outer loop` and three `vertex` for each \
         triangle, or the binary form"
            .to_owned()
    })?;
    check_triangle_count(mesh.faces.len())?;
    Ok(MeshPiece {
        points: mesh.vertices.iter().map(|v| [v[0], v[1], v[2]].map(f64::from)).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices.map(|i| i as u32)).collect(),
        ..Default::default()
    })
}
