//! Shapes of serialization 15 (2.6.6), which consist of arrays for the whole shape, and of components that refer to
//! ranges of these arrays.

use super::{
    color,
    cursor::{ByteSpan, Cursor, ReadResult},
    material::EngineBlock,
    mesh::{ArrayLocation, LEAF, LeafPrimitive, MeshLeaf, MeshPart},
    pool::IndexArray,
    pose::position_first,
    section::{ElementTag, object, tags},
    unknown::UnknownElements,
};

/// The arrays of a shape, in its own frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct SharedArrays {
    /// Vertex coordinates, 4 bytes each, m.
    pub vertices: ByteSpan,
    /// Vertex indices of the triangles.
    pub indices: Option<IndexArray>,
}

/// The content of the element `Geo`.
#[derive(Default)]
struct LegacyGeometry {
    shared: SharedArrays,
    root: Option<MeshPart>,
}

/// Elements of a component that differ from those of later leaves. A component can have its own triangles in addition
/// to its children.
const COMPONENT: &[ElementTag<MeshPart>] = tags!(MeshPart {
    "Nme" => |p, c, _| Ok(p.name = c.text()?),
    "Mas" => |p, c, _| Ok(p.mass = c.real()?),
    "Ine" => |p, c, _| Ok((p.axes, p.moments) = (position_first(c)?, c.reals()?)),
    "Vrt" => |p, c, _| {
        let vertices = [c.i32()?, c.i32()?];
        range(p, Some(vertices), None);
        Ok(())
    },
    "Tri" => |p, c, _| {
        let triangles = [c.i32()?, c.i32()?];
        range(p, None, Some(triangles));
        Ok(())
    },
    "Dyp" => |p, c, _| {
        let [restitution, friction, linear, angular] = c.reals()?;
        let reals = vec![restitution, friction, friction, linear, angular];
        p.own_material.get_or_insert_default().bullet = EngineBlock { reals, ints: Vec::new() };
        Ok(())
    },
    "Od1" => |p, c, _| {
        let contacts = c.i32()?;
        p.own_material.get_or_insert_default().ode = EngineBlock { reals: c.list(5)?, ints: vec![contacts] };
        Ok(())
    },
    "Cl0" => |p, c, u| Ok(leaf(p).color = color::read(c, u)?),
    "Ppr" => |p, c, _| {
        let leaf = leaf(p);
        Ok((leaf.primitive, leaf.size) = (LeafPrimitive::of(c.i32()?), c.reals()?))
    },
    "Ppf" => |p, c, _| Ok(leaf(p).old_frame = position_first(c)?),
    "Shc" => |p, c, u| Ok(p.children.push(component(c, u)?)),
});

const IGNORED: &[&str] = &["Cl2", "Ecl", "Lvl", "Rdo", "Gsa", "Ewt", "Ved", "Bcm", "Cv2", "Uis"];

fn leaf(p: &mut MeshPart) -> &mut MeshLeaf {
    p.leaf.get_or_insert_default()
}

fn range(p: &mut MeshPart, vertices: Option<[i32; 2]>, triangles: Option<[i32; 2]>) {
    let leaf = leaf(p);
    let (v, t) = match leaf.arrays {
        ArrayLocation::Range { vertices, triangles } => (vertices, triangles),
        _ => ([0; 2], [0; 2]),
    };
    leaf.arrays = ArrayLocation::Range { vertices: vertices.unwrap_or(v), triangles: triangles.unwrap_or(t) };
}

fn component(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<MeshPart> {
    let mut part = MeshPart::default();
    range(&mut part, None, None);
    // All other elements are read as in later leaves: images, heightfields.
    let mut tags: Vec<&ElementTag<MeshPart>> = COMPONENT.iter().collect();
    tags.extend(LEAF.iter().filter(|t| ["Hfd", "Toj"].contains(&t.single)));
    let rows: Vec<ElementTag<MeshPart>> =
        tags.into_iter().map(|t| ElementTag { single: t.single, double: t.double, read: t.read }).collect();
    object(c, &rows, IGNORED, &mut part, unknown)?;
    Ok(part)
}

/// Reads `Geo` of a shape: its root component and the shared arrays.
pub fn read(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<(Option<MeshPart>, SharedArrays)> {
    let mut geometry = LegacyGeometry::default();
    let tags = tags!(LegacyGeometry {
        "Ver" => |g, c, _| Ok(g.shared.vertices = c.take_rest()),
        "Ind" => |g, c, _| Ok(g.shared.indices = Some(IndexArray::Plain(c.take_rest()))),
        "In2" => |g, c, _| Ok(g.shared.indices = Some(IndexArray::Packed(c.take_rest()))),
        "Gst" => |g, c, u| Ok(g.root = Some(component(c, u)?)),
    });
    object(c, tags, &["Var", "Nor", "No2", "Ved", "Cv2"], &mut geometry, unknown)?;
    Ok((geometry.root, geometry.shared))
}
