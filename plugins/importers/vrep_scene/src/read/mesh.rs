//! Meshes of shapes: a tree whose leaves have triangles.

use super::{
    color::{self, Color},
    cursor::{ByteSpan, Cursor, ReadResult},
    material::{self, Material},
    pool::IndexArray,
    pose::{IDENTITY, StoredPose, position_first},
    section::{ElementTag, object, objects, tags},
    texture::{self, TextureMapping},
    unknown::UnknownElements,
};

/// A part of a shape: a compound of parts, or a leaf.
#[derive(Debug, Clone)]
pub struct MeshPart {
    /// Name of the part.
    pub name: String,
    /// Mass, kg; only the mass of the root part is used.
    pub mass: f64,
    /// Id in the material list of versions before 3.4; -1: no material.
    pub material: i32,
    /// Whether the part is marked as convex, in files from before 4.5.1.
    pub convex: bool,
    /// Material parameters, which serialization 16 stores here.
    pub own_material: Option<Material>,
    /// Principal axes in the shape's frame.
    pub axes: StoredPose,
    /// Principal moments divided by the mass, m^2.
    pub moments: [f64; 3],
    /// Frame of the part in the frame of its parent; since 4.5.1. The root's frame is ignored.
    pub frame: Option<StoredPose>,
    /// Centre of mass in `frame`, m; since 4.5.1.
    pub com: Option<[f64; 3]>,
    /// Inertia divided by the mass, about the centre of mass, along the axes of `frame`, m^2; since 4.5.1.
    pub inertia: Option<[f64; 9]>,
    /// Frame of the vertices in `frame`; since 4.5.1.
    pub vertex_frame: Option<StoredPose>,
    /// Parts of a compound, in order.
    pub children: Vec<MeshPart>,
    /// The triangles of a leaf.
    pub leaf: Option<Box<MeshLeaf>>,
}

impl Default for MeshPart {
    fn default() -> Self {
        MeshPart {
            name: String::new(),
            mass: 0.0,
            material: -1,
            convex: false,
            own_material: None,
            axes: IDENTITY,
            moments: [0.0; 3],
            frame: None,
            com: None,
            inertia: None,
            vertex_frame: None,
            children: Vec::new(),
            leaf: None,
        }
    }
}

/// The primitive that a leaf represents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum LeafPrimitive {
    #[default]
    None,
    Plane,
    Disc,
    Cuboid,
    Spheroid,
    Cylinder,
    Cone,
    Heightfield,
    Capsule,
}

impl LeafPrimitive {
    /// Returns the primitive with the given number in the file, or [`LeafPrimitive::None`] for unknown numbers.
    pub fn of(number: i32) -> Self {
        use LeafPrimitive::*;
        let all = [None, Plane, Disc, Cuboid, Spheroid, Cylinder, Cone, Heightfield, Capsule];
        usize::try_from(number).ok().and_then(|n| all.get(n).copied()).unwrap_or(None)
    }
}

/// The location of the arrays of a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "each form has its sentence")]
pub enum ArrayLocation {
    /// The arrays are in the pool, by index.
    Pool { vertices: i32, indices: i32 },
    /// The arrays are in the leaf itself.
    Own { vertices: ByteSpan, indices: Option<IndexArray> },
    /// A range of the shape's shared arrays (serialization 15): first and count of vertices, and of triangles.
    Range { vertices: [i32; 2], triangles: [i32; 2] },
}

/// A leaf of a shape's mesh tree: triangles and their appearance.
#[derive(Debug, Clone)]
pub struct MeshLeaf {
    /// Color of the outer side of the triangles.
    pub color: Color,
    /// The location of the leaf's arrays.
    pub arrays: ArrayLocation,
    /// The primitive that the leaf represents.
    pub primitive: LeafPrimitive,
    /// Full extents of the primitive, m.
    pub size: [f64; 3],
    /// 1 if the primitive is solid; less if it is hollow.
    pub inside: f64,
    /// Frame of the vertices in the shape's frame, in files before 4.5.1.
    pub old_frame: StoredPose,
    /// Flags. Bit 0: edges; bit 1: culling; bit 2: wireframe.
    pub bits: u8,
    /// Whether the leaf is marked as convex.
    pub convex: bool,
    /// Number of points of a heightfield along x and y; 0 for other leaves.
    pub heights: [i32; 2],
    /// Span of the heights, and whether they have 8 bytes each instead of 4.
    pub height_data: (ByteSpan, bool),
    /// Mapping of an image to the surface, if it is textured.
    pub texture: Option<TextureMapping>,
}

impl Default for MeshLeaf {
    fn default() -> Self {
        MeshLeaf {
            color: Color::default(),
            arrays: ArrayLocation::Pool { vertices: -1, indices: -1 },
            primitive: LeafPrimitive::None,
            size: [0.0; 3],
            inside: 1.0,
            old_frame: IDENTITY,
            bits: 0,
            convex: false,
            heights: [0; 2],
            height_data: (ByteSpan::default(), false),
            texture: None,
        }
    }
}

impl MeshLeaf {
    fn pool_vertices(&mut self, number: i32) {
        let indices = if let ArrayLocation::Pool { indices, .. } = self.arrays { indices } else { -1 };
        self.arrays = ArrayLocation::Pool { vertices: number, indices };
    }
    fn pool_indices(&mut self, number: i32) {
        let vertices = if let ArrayLocation::Pool { vertices, .. } = self.arrays { vertices } else { -1 };
        self.arrays = ArrayLocation::Pool { vertices, indices: number };
    }
    fn indices(&mut self, new: IndexArray) {
        let vertices =
            if let ArrayLocation::Own { vertices, .. } = self.arrays { vertices } else { ByteSpan::default() };
        self.arrays = ArrayLocation::Own { vertices, indices: Some(new) };
    }
    fn vertices(&mut self, new: ByteSpan) {
        let indices = if let ArrayLocation::Own { indices, .. } = self.arrays { indices } else { None };
        self.arrays = ArrayLocation::Own { vertices: new, indices };
    }
}

/// Returns the leaf of a part, creating it if necessary.
fn leaf(p: &mut MeshPart) -> &mut MeshLeaf {
    p.leaf.get_or_insert_default()
}

/// Elements that every part can have.
const PART: &[ElementTag<MeshPart>] = tags!(MeshPart {
    "Nme" => |p, c, _| Ok(p.name = c.text()?),
    "Mas" | "_as" => |p, c, _| Ok(p.mass = c.real()?),
    "Dmi" => |p, c, _| Ok(p.material = c.i32()?),
    "Ine" | "_ne" => |p, c, _| Ok((p.axes, p.moments) = (position_first(c)?, c.reals()?)),
    "" | "Ifr" => |p, c, _| Ok(p.frame = Some(position_first(c)?)),
    "" | "Com" => |p, c, _| Ok(p.com = Some(c.reals()?)),
    "" | "Imx" => |p, c, _| Ok(p.inertia = Some(c.reals()?)),
    "" | "Bbf" => |p, c, _| Ok(p.vertex_frame = Some(position_first(c)?)),
    "Bul" => |p, c, u| own_material(p, "Bul", c, u),
    "Bu2" => |p, c, u| own_material(p, "Bu2", c, u),
    "Ode" => |p, c, u| own_material(p, "Ode", c, u),
    "Geo" => |p, c, u| Ok(p.children.push(read_leaf(c, u)?)),
    "Wrp" => |p, c, u| Ok(p.children.push(read_wrapper(c, u)?)),
    "Var" => |p, c, _| Ok(p.convex = c.u8()? & 4 != 0),
});

const PART_IGNORED: &[&str] = &["Vtb", "_tb", "Bbs", "Cv2", "Uis", "Ups"];

fn own_material(p: &mut MeshPart, tag: &str, c: &mut Cursor<'_>, u: &mut UnknownElements) -> ReadResult {
    match material::TAGS.iter().find(|t| t.single == tag) {
        Some(row) => (row.read)(p.own_material.get_or_insert_default(), c, u),
        None => Ok(()),
    }
}

/// Elements that only leaves have. Components of serialization 15 use some of them, too.
pub const LEAF: &[ElementTag<MeshPart>] = tags!(MeshPart {
    "Cl0" => |p, c, u| Ok(leaf(p).color = color::read(c, u)?),
    "Vev" => |p, c, _| Ok(leaf(p).pool_vertices(c.i32()?)),
    "Inv" => |p, c, _| Ok(leaf(p).pool_indices(c.i32()?)),
    "Ver" => |p, c, _| Ok(leaf(p).vertices(c.take_rest())),
    "Ind" => |p, c, _| Ok(leaf(p).indices(IndexArray::Plain(c.take_rest()))),
    "In2" => |p, c, _| Ok(leaf(p).indices(IndexArray::Packed(c.take_rest()))),
    "Ppr" | "_pr" => |p, c, _| {
        let leaf = leaf(p);
        Ok((leaf.primitive, leaf.size) = (LeafPrimitive::of(c.i32()?), c.reals()?))
    },
    "Pp2" | "_p2" => |p, c, _| Ok(leaf(p).inside = c.real()?),
    "Ppf" | "_pf" => |p, c, _| Ok(leaf(p).old_frame = position_first(c)?),
    "Var" => |p, c, _| Ok(leaf(p).bits = c.u8()?),
    "Va2" => |p, c, _| Ok(leaf(p).convex = c.u8()? & 1 != 0),
    "Hfd" | "_fd" => |p, c, _| {
        let wide = c.has_doubles;
        let leaf = leaf(p);
        leaf.heights = [c.i32()?, c.i32()?];
        Ok(leaf.height_data = (c.take_rest(), wide))
    },
    "Toj" => |p, c, u| Ok(leaf(p).texture = Some(texture::property(c, u)?)),
});

const LEAF_IGNORED: &[&str] =
    &["Cl2", "Ecl", "Nov", "Vvd", "Nor", "No2", "Ved", "Gsa", "_sa", "Gs2", "_s2", "Cv2", "Uis", "Ups"];

/// Reads `Gst` or `Geo`: the elements of a part and of its leaf.
pub fn read_leaf(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<MeshPart> {
    let mut part = MeshPart::default();
    object(c, PART, PART_IGNORED, &mut part, unknown)?;
    leaf(&mut part);
    objects(c, LEAF, LEAF_IGNORED, &mut part, unknown)?;
    Ok(part)
}

/// Reads `Gsg` or `Wrp`: a compound.
pub fn read_wrapper(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<MeshPart> {
    let mut part = MeshPart::default();
    object(c, PART, PART_IGNORED, &mut part, unknown)?;
    Ok(part)
}

/// Reads `Ge2`: the root part.
pub fn read_tree(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<Option<MeshPart>> {
    let mut root = None;
    let tags = tags!(Option<MeshPart> {
        "Gst" => |r, c, u| Ok(*r = Some(read_leaf(c, u)?)),
        "Gsg" => |r, c, u| Ok(*r = Some(read_wrapper(c, u)?)),
    });
    object(c, tags, &["Coj", "Cv2"], &mut root, unknown)?;
    Ok(root)
}
