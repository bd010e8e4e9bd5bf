//! Arrays of meshes, which shapes share, and how they are coded.

use super::{
    cursor::{Cursor, Read, Span},
    section::{object, tags},
    unknown::Unknowns,
};

/// An array of indices, as it is coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Indices {
    /// Integers of 4 bytes.
    Plain(Span),
    /// Differences of one to four bytes, with their number before them.
    Packed(Span),
}

/// The lists of `VIN`; places in the data, which stays as it is until a mesh is wanted.
#[derive(Debug, Clone, Default)]
pub struct Pool {
    /// Coordinates, 4 bytes each.
    pub vertices: Vec<Span>,
    /// Corners of triangles.
    pub indices: Vec<Indices>,
    /// How many arrays of normals there are; they are made anew where they are wanted.
    pub normals: usize,
    /// The same of visible edges.
    pub edges: usize,
}

/// `VIN`
pub fn read(pool: &mut Pool, c: &mut Cursor<'_>, unknown: &mut Unknowns) -> Read {
    let tags = tags!(Pool {
        "Ver" => |p, c, _| Ok(p.vertices.push(c.rest())),
        "Ind" => |p, c, _| Ok(p.indices.push(Indices::Plain(c.rest()))),
        "In2" => |p, c, _| Ok(p.indices.push(Indices::Packed(c.rest()))),
        "Nor" => |p, _, _| Ok(p.normals += 1),
        "No2" => |p, _, _| Ok(p.normals += 1),
        "Ved" => |p, _, _| Ok(p.edges += 1),
    });
    object(c, tags, &[], pool, unknown).map(drop)
}

/// Points, m.
pub fn points(data: &[u8], span: Span) -> Vec<[f32; 3]> {
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    span.of(data).chunks_exact(12).map(|p| [number(p), number(&p[4..]), number(&p[8..])]).collect()
}

/// Corners of triangles, three each.
pub fn corners(data: &[u8], indices: Indices) -> Read<Vec<u32>> {
    match indices {
        Indices::Plain(span) => {
            Ok(span.of(data).chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
        }
        Indices::Packed(span) => unpack(data, span),
    }
}

/// How many corners there are, without making them.
pub fn count(data: &[u8], indices: Indices) -> usize {
    match indices {
        Indices::Plain(span) => span.len / 4,
        Indices::Packed(span) => {
            let told = span.of(data).get(..4).map_or(0, |b| i32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            // Each takes a byte at least.
            usize::try_from(told).unwrap_or(0).min(span.len.saturating_sub(4))
        }
    }
}

/// Packed integers: the two top bits of the first byte are the number of bytes that follow.
fn unpack(data: &[u8], span: Span) -> Read<Vec<u32>> {
    const OFFSET: [i64; 4] = [31, 8191, 2_097_151, 536_870_911];
    let bytes = span.of(data);
    let broken = |at: usize, what: &str| super::cursor::Broken::new(span.at + at, what);
    let head = bytes.get(..4).ok_or_else(|| broken(0, "packed indices without their number"))?;
    let told = i32::from_le_bytes([head[0], head[1], head[2], head[3]]);
    let n = usize::try_from(told).map_err(|_| broken(0, &format!("{told} is not a length")))?;
    if n > bytes.len() - 4 {
        return Err(broken(0, &format!("{n} packed indices are declared, {} bytes are left", bytes.len() - 4)));
    }
    let (mut out, mut at, mut value) = (Vec::with_capacity(n), 4, 0_i64);
    for _ in 0..n {
        let first = *bytes.get(at).ok_or_else(|| broken(at, "packed indices end too early"))?;
        let extra = usize::from(first >> 6);
        let more = bytes.get(at + 1..at + 1 + extra).ok_or_else(|| broken(at, "packed indices end too early"))?;
        let raw =
            more.iter().enumerate().fold(i64::from(first & 63), |raw, (i, b)| raw + (i64::from(*b) << (6 + 8 * i)));
        value += raw - OFFSET[extra];
        out.push(u32::try_from(value).map_err(|_| broken(at, &format!("an index of {value}")))?);
        at += 1 + extra;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_vector_unpacks() {
        let data = [7, 0, 0, 0, 0x1F, 0x20, 0x20, 0x1F, 0x65, 0x80, 0x57, 0x7F, 0x8F, 0x9C, 0x80];
        let whole = Indices::Packed(Span { at: 0, len: data.len() });
        assert_eq!(corners(&data, whole).unwrap(), [0, 1, 2, 2, 40, 0, 10_000]);
        assert_eq!(count(&data, whole), 7);
        for len in 0..data.len() {
            assert!(corners(&data, Indices::Packed(Span { at: 0, len })).is_err(), "cut at {len}");
        }
    }
}
