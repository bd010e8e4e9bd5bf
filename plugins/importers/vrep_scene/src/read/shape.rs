//! Shapes: the specific part of objects in section `SHP`.

use super::{
    legacy_mesh::{self, SharedArrays},
    material::{self, Material},
    mesh::{self, MeshPart},
    section::{ElementTag, tags},
};

/// The specific part of a shape.
#[derive(Debug, Clone)]
pub struct Shape {
    /// The root of the shape's mesh tree.
    pub root: Option<MeshPart>,
    /// Shared arrays of serialization 15.
    pub shared: Option<SharedArrays>,
    /// Material of the shape; since 3.4.
    pub material: Option<Material>,
    /// Collision mask: the low byte applies within a tree of objects, the high byte between trees.
    pub mask: u16,
    /// Initial linear, then angular velocity, m/s and rad/s.
    pub velocity: [f64; 6],
    /// Whether physics moves the shape.
    pub dynamic: bool,
    /// Whether the shape initially sleeps.
    pub asleep: bool,
    /// Whether the shape collides with other respondable shapes.
    pub respondable: bool,
}

impl Default for Shape {
    fn default() -> Self {
        Shape {
            root: None,
            shared: None,
            material: None,
            mask: 0xFFFF,
            velocity: [0.0; 6],
            dynamic: false,
            asleep: false,
            respondable: false,
        }
    }
}

/// Tags of the elements in the part that is specific to shapes.
pub const TAGS: &[ElementTag<Shape>] = tags!(Shape {
    "Ge2" => |s, c, u| Ok(s.root = mesh::read_tree(c, u)?),
    "Geo" => |s, c, u| {
        let (root, shared) = legacy_mesh::read(c, u)?;
        Ok((s.root, s.shared) = (root, Some(shared)))
    },
    "Mat" => |s, c, u| Ok(s.material = Some(material::read(c, u)?)),
    "Dc2" => |s, c, _| Ok(s.mask = c.u16()?),
    "Idv" | "_dv" => |s, c, _| Ok(s.velocity = c.reals()?),
    "Sss" => |s, c, _| {
        let bits = c.u8()?;
        Ok((s.dynamic, s.asleep) = (bits & 0x80 != 0, bits & 0x40 != 0))
    },
    "Ss2" => |s, c, _| Ok(s.respondable = c.u8()? & 1 != 0),
    "Ss3" => |s, c, _| Ok(s.respondable = c.u8()? & 1 != 0),
});

/// Known elements that are not used.
pub const IGNORED: &[&str] = &["Sco", "Sc2", "Eco", "Ewt", "Cv2"];
