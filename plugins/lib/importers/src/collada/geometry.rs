//! Geometries: data sources, and the primitives that refer to them.

use std::collections::HashMap;

use roxmltree::Node;

use super::tree::{ElementIndex, child, children, numbers};
use crate::model::{MeshPiece, check_triangle_count};

/// Returns the triangles of a geometry: for each primitive, the symbol of its material and a piece with its triangles.
pub fn pieces<'a>(tree: &ElementIndex<'a>, geometry: Node<'a, 'a>) -> Result<Vec<(&'a str, MeshPiece)>, String> {
    let Some(mesh) = child(geometry, "mesh") else { return Ok(Vec::new()) };
    let mut out: Vec<(&str, MeshPiece)> = Vec::new();
    for primitive in mesh.children() {
        let corners = match primitive.tag_name().name() {
            "triangles" => polygons(primitive, PolygonLayout::Triangles),
            "polylist" => polygons(primitive, PolygonLayout::Counts),
            "polygons" | "trifans" => polygons(primitive, PolygonLayout::Polygons),
            "tristrips" => polygons(primitive, PolygonLayout::Strips),
            _ => continue,
        };
        let symbol = primitive.attribute("material").unwrap_or_default();
        let piece = piece(tree, primitive, &corners?)?;
        out.push((symbol, piece));
    }
    Ok(out)
}

/// How the indices of a primitive are divided into polygons.
#[derive(Clone, Copy)]
enum PolygonLayout {
    Triangles,
    /// Polygons whose numbers of corners are listed in `<vcount>`.
    Counts,
    /// A polygon per `<p>`.
    Polygons,
    Strips,
}

/// Returns the number of indices per corner.
fn stride(primitive: Node<'_, '_>) -> usize {
    let offsets = primitive.children().filter_map(|n| n.attribute("offset")?.parse::<usize>().ok());
    // A file with more than a thousand inputs is damaged; reading its corners will fail.
    offsets.max().map_or(1, |last| last.min(1000) + 1)
}

/// Returns the corners of all triangles, and the list of indices. A corner is the position of its first index in that
/// list.
fn polygons(primitive: Node<'_, '_>, cut: PolygonLayout) -> Result<(Vec<usize>, Vec<u32>), String> {
    let stride = stride(primitive);
    let (mut corners, mut indices) = (Vec::new(), Vec::new());
    let lists = primitive.children().filter_map(|n| match n.tag_name().name() {
        "p" => Some(n),
        // `<ph>` is a polygon with holes, which are ignored.
        "ph" => child(n, "p"),
        _ => None,
    });
    let counts: Vec<usize> = child(primitive, "vcount").map(numbers).unwrap_or_default();
    for list in lists {
        let first = indices.len();
        indices.extend(numbers::<u32>(list));
        let n = (indices.len() - first) / stride;
        let corner = |i: usize| first + i * stride;
        let mut fan = |begin: usize, n: usize| {
            corners.extend((2..n).flat_map(|i| [begin, begin + i - 1, begin + i]).map(corner));
        };
        match cut {
            PolygonLayout::Triangles => (0..n / 3).for_each(|i| fan(3 * i, 3)),
            PolygonLayout::Polygons => fan(0, n),
            PolygonLayout::Counts => {
                let mut begin = 0;
                for count in &counts {
                    if *count > n - begin {
                        return Err(
                            "the COLLADA file is damaged: its polygons have more corners than there are indices".into(),
                        );
                    }
                    fan(begin, *count);
                    begin += count;
                }
            }
            PolygonLayout::Strips => corners.extend((2..n).flat_map(|i| {
                let (a, b) = if i % 2 == 0 { (i - 2, i - 1) } else { (i - 1, i - 2) };
                [a, b, i].map(corner)
            })),
        }
        check_triangle_count(corners.len() / 3)?;
    }
    Ok((corners, indices))
}

/// The numbers of a source, `stride` per element.
struct FloatSource {
    numbers: Vec<f64>,
    stride: usize,
    /// Position of the index into this source among the indices of a corner.
    offset: usize,
}

impl FloatSource {
    fn read<'a>(tree: &ElementIndex<'a>, input: Node<'a, 'a>, offset: usize) -> Option<Self> {
        let source = tree.follow(input, "source")?;
        let accessor = child(child(source, "technique_common")?, "accessor")?;
        let array = tree.follow(accessor, "source").or_else(|| child(source, "float_array"))?;
        let number = |name: &str, or: usize| accessor.attribute(name).and_then(|n| n.parse().ok()).unwrap_or(or);
        let (stride, skipped) = (number("stride", 1).max(1), number("offset", 0));
        let mut numbers: Vec<f64> = numbers(array);
        numbers.drain(..skipped.min(numbers.len()));
        Some(FloatSource { numbers, stride, offset })
    }

    fn get<const N: usize>(&self, index: u32) -> Option<[f64; N]> {
        let first = (index as usize).checked_mul(self.stride)?;
        self.numbers.get(first..first.checked_add(N)?)?.try_into().ok()
    }
}

/// Returns the first input with the given semantic, of the primitive or of the vertices to which it refers.
fn input<'a>(tree: &ElementIndex<'a>, primitive: Node<'a, 'a>, semantic: &str) -> Option<FloatSource> {
    let is = |n: &Node<'a, 'a>, what: &str| n.attribute("semantic") == Some(what);
    let offset = |n: Node<'_, '_>| n.attribute("offset").and_then(|o| o.parse().ok()).unwrap_or(0);
    // If there are several sets of coordinates, use the set with the lowest number.
    let set = |n: &Node<'a, 'a>| n.attribute("set").and_then(|s| s.parse::<u32>().ok()).unwrap_or(0);
    let own = children(primitive, "input").filter(|n| is(n, semantic)).min_by_key(set);
    if let Some(own) = own {
        return FloatSource::read(tree, own, offset(own));
    }
    let vertex = children(primitive, "input").find(|n| is(n, "VERTEX"))?;
    let shared = children(tree.follow(vertex, "source")?, "input").find(|n| is(n, semantic))?;
    FloatSource::read(tree, shared, offset(vertex))
}

/// Builds a piece in which corners with equal indices of position and texture coordinates share a point.
fn piece<'a>(
    tree: &ElementIndex<'a>,
    primitive: Node<'a, 'a>,
    corners: &(Vec<usize>, Vec<u32>),
) -> Result<MeshPiece, String> {
    let (corners, indices) = corners;
    let lacks = |what: &str| format!("the COLLADA file is damaged: a primitive has no {what}");
    let positions = input(tree, primitive, "POSITION").ok_or_else(|| lacks("positions"))?;
    let coordinates = input(tree, primitive, "TEXCOORD");
    let mut out = MeshPiece::default();
    let mut known: HashMap<(u32, Option<u32>), u32> = HashMap::new();
    let mut whole = Vec::with_capacity(corners.len());
    for corner in corners {
        let index = |source: &FloatSource| indices.get(corner.checked_add(source.offset)?).copied();
        let position = index(&positions).ok_or_else(|| lacks("index for one of its corners"))?;
        let place = coordinates.as_ref().and_then(index);
        let number = match known.get(&(position, place)) {
            Some(number) => *number,
            None => {
                let point = positions.get(position).ok_or_else(|| lacks(&format!("position {position}")))?;
                out.points.push(point);
                if let Some([x, y]) = coordinates.as_ref().zip(place).and_then(|(c, i)| c.get::<2>(i)) {
                    out.coordinates.push([x as f32, y as f32]);
                }
                known.insert((position, place), out.points.len() as u32 - 1);
                out.points.len() as u32 - 1
            }
        };
        whole.push(number);
    }
    out.triangles = whole.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    Ok(out)
}
