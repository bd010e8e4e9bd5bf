//! Vertex and index arrays shared by shapes, and their encoding.

use super::{
    cursor::{ByteSpan, Cursor, ReadResult},
    section::{object, tags},
    unknown::UnknownElements,
};

/// An encoded array of indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IndexArray {
    /// Unpacked indices: 4-byte integers.
    Plain(ByteSpan),
    /// Packed differences of one to four bytes each, preceded by their count.
    Packed(ByteSpan),
}

/// The arrays of `VIN`, as spans of the data; they are decoded when a mesh needs them.
#[derive(Debug, Clone, Default)]
pub struct ArrayPool {
    /// Vertex coordinates, 4 bytes each.
    pub vertices: Vec<ByteSpan>,
    /// Vertex indices, three per triangle.
    pub indices: Vec<IndexArray>,
    /// Number of arrays of normals, which are skipped.
    pub normals: usize,
    /// Number of arrays of visible edges, which are skipped.
    pub edges: usize,
}

/// Reads the section `VIN`, which contains shared arrays.
pub fn read(pool: &mut ArrayPool, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    let tags = tags!(ArrayPool {
        "Ver" => |p, c, _| Ok(p.vertices.push(c.take_rest())),
        "Ind" => |p, c, _| Ok(p.indices.push(IndexArray::Plain(c.take_rest()))),
        "In2" => |p, c, _| Ok(p.indices.push(IndexArray::Packed(c.take_rest()))),
        "Nor" => |p, _, _| Ok(p.normals += 1),
        "No2" => |p, _, _| Ok(p.normals += 1),
        "Ved" => |p, _, _| Ok(p.edges += 1),
    });
    object(c, tags, &[], pool, unknown).map(drop)
}

/// Decodes an array of vertex coordinates into points, m.
pub fn points(data: &[u8], span: ByteSpan) -> Vec<[f32; 3]> {
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    span.of(data).chunks_exact(12).map(|p| [number(p), number(&p[4..]), number(&p[8..])]).collect()
}

/// Decodes vertex indices, three per triangle.
pub fn corners(data: &[u8], indices: IndexArray) -> ReadResult<Vec<u32>> {
    match indices {
        IndexArray::Plain(span) => {
            Ok(span.of(data).chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
        }
        IndexArray::Packed(span) => unpack(data, span),
    }
}

/// Returns the number of indices without decoding them.
pub fn count(data: &[u8], indices: IndexArray) -> usize {
    match indices {
        IndexArray::Plain(span) => span.len / 4,
        IndexArray::Packed(span) => {
            let told = span.of(data).get(..4).map_or(0, |b| i32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            // Each index occupies at least one byte.
            usize::try_from(told).unwrap_or(0).min(span.len.saturating_sub(4))
        }
    }
}

/// Decodes packed integers. The two most significant bits of the first byte of an integer are the number of bytes that
/// follow it.
fn unpack(data: &[u8], span: ByteSpan) -> ReadResult<Vec<u32>> {
    const OFFSETS: [i64; 4] = [31, 8191, 2_097_151, 536_870_911];
    let bytes = span.of(data);
    let broken = |at: usize, what: &str| super::cursor::ReadError::new(span.at + at, what);
    let head =
        bytes.get(..4).ok_or_else(|| broken(0, "expected packed indices, which begin with their count in 4 bytes"))?;
    let told = i32::from_le_bytes([head[0], head[1], head[2], head[3]]);
    let n = usize::try_from(told).map_err(|_| broken(0, &format!("expected a length, found {told}")))?;
    if n > bytes.len() - 4 {
        return Err(broken(0, &format!("expected {n} packed indices, found {} bytes", bytes.len() - 4)));
    }
    let (mut out, mut at, mut value) = (Vec::with_capacity(n), 4, 0_i64);
    for _ in 0..n {
        let first =
            *bytes.get(at).ok_or_else(|| broken(at, "the packed indices end before all of them are unpacked"))?;
        let extra = usize::from(first >> 6);
        let more = bytes
            .get(at + 1..at + 1 + extra)
            .ok_or_else(|| broken(at, "the packed indices end before all of them are unpacked"))?;
        let raw =
            more.iter().enumerate().fold(i64::from(first & 63), |raw, (i, b)| raw + (i64::from(*b) << (6 + 8 * i)));
        value += raw - OFFSETS[extra];
        out.push(u32::try_from(value).map_err(|_| broken(at, &format!("the vertex index {value} is out of range")))?);
        at += 1 + extra;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_index_test_vector_is_decoded() {
        let data = [7, 0, 0, 0, 0x1F, 0x20, 0x20, 0x1F, 0x65, 0x80, 0x57, 0x7F, 0x8F, 0x9C, 0x80];
        let whole = IndexArray::Packed(ByteSpan { at: 0, len: data.len() });
        assert_eq!(corners(&data, whole).unwrap(), [0, 1, 2, 2, 40, 0, 10_000]);
        assert_eq!(count(&data, whole), 7);
        for len in 0..data.len() {
            assert!(corners(&data, IndexArray::Packed(ByteSpan { at: 0, len })).is_err(), "truncated at {len}");
        }
    }
}
