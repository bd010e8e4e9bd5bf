//! Shapes: what an object of section `SHP` adds.

use super::{
    legacy_mesh::{self, Shared},
    material::{self, Material},
    mesh::{self, Part},
    section::{Tag, tags},
};

/// A shape.
#[derive(Debug, Clone)]
pub struct Shape {
    /// The root of its meshes.
    pub root: Option<Part>,
    /// Arrays of serialization 15.
    pub shared: Option<Shared>,
    /// Its material; from 3.4.
    pub material: Option<Material>,
    /// With whom it collides: low byte within its tree, high byte with others.
    pub mask: u16,
    /// Linear, then angular velocity at the start, m/s and rad/s.
    pub velocity: [f64; 6],
    /// Whether forces move it.
    pub dynamic: bool,
    /// Whether it starts asleep.
    pub asleep: bool,
    /// Whether it collides.
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

/// Its elements.
pub const TAGS: &[Tag<Shape>] = tags!(Shape {
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

/// Known and without meaning here.
pub const IGNORED: &[&str] = &["Sco", "Sc2", "Eco", "Ewt", "Cv2"];
