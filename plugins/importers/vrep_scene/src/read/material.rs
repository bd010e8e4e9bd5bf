//! Materials: friction and restitution of shapes, per engine.

use super::{
    cursor::{Cursor, ReadResult},
    section::{ElementTag, object, tags},
    unknown::UnknownElements,
};

/// Parameters of an engine: real numbers and integers, as many as the file declares.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EngineBlock {
    /// The real parameters, in the order of the file.
    pub reals: Vec<f64>,
    /// The integer parameters, in the order of the file.
    pub ints: Vec<i32>,
}

impl EngineBlock {
    /// Reads a block: the counts of reals and integers, then the values.
    pub fn read(c: &mut Cursor<'_>) -> ReadResult<Self> {
        let (reals, ints) = (c.count()?, c.count()?);
        let reals = c.list(reals)?;
        let ints = (0..ints).map(|_| c.i32()).collect::<ReadResult<_>>()?;
        Ok(EngineBlock { reals, ints })
    }
    /// Returns the real number at index `i`, if it exists and is finite.
    pub fn real(&self, i: usize) -> Option<f64> {
        self.reals.get(i).copied().filter(|x| x.is_finite())
    }
    /// Returns the integer at index `i`, if it exists.
    pub fn int(&self, i: usize) -> Option<i32> {
        self.ints.get(i).copied()
    }
}

/// A physical material, with separate parameters for each engine.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Material {
    /// Id in the material list of versions before 3.4.
    pub id: i32,
    /// Name of the material.
    pub name: String,
    /// Bullet: restitution, friction in Bullet 2.78, friction in later versions, linear and angular damping, ... Bit 0
    /// of the first integer: sticky.
    pub bullet: EngineBlock,
    /// ODE: friction, ERP, CFM, linear and angular damping.
    pub ode: EngineBlock,
    /// Newton: static and kinetic friction, restitution, linear and angular drag.
    pub newton: EngineBlock,
    /// MuJoCo: friction, solref, solimp, ...
    pub mujoco: EngineBlock,
    /// Vortex; the parameters are not used.
    pub vortex: EngineBlock,
    /// Flags of the older format. Bit 1: sticky.
    old_bits: u8,
}

/// Reads Bullet's parameters of versions before 3.4, which have a single friction for both versions of the engine.
fn read_old_bullet(m: &mut Material, c: &mut Cursor<'_>) -> ReadResult {
    let [restitution, friction, linear, angular] = c.reals()?;
    m.bullet.reals = vec![restitution, friction, friction, linear, angular];
    Ok(())
}

fn read_old_ode(m: &mut Material, c: &mut Cursor<'_>) -> ReadResult {
    let contacts = c.i32()?;
    m.ode = EngineBlock { reals: c.list(5)?, ints: vec![contacts] };
    Ok(())
}

/// Tags of the elements of a material.
pub const TAGS: &[ElementTag<Material>] = tags!(Material {
    "Ipa" => |m, c, _| Ok(m.id = c.i32()?),
    "Gon" => |m, c, _| Ok(m.name = c.text()?),
    "Bul" => |m, c, _| read_old_bullet(m, c),
    "Bu2" => |m, c, _| read_old_bullet(m, c),
    "Ode" => |m, c, _| read_old_ode(m, c),
    "Od2" => |m, c, _| read_old_ode(m, c),
    "Var" => |m, c, _| {
        m.old_bits = c.u8()?;
        m.bullet.ints = vec![i32::from(m.old_bits >> 1 & 1)];
        Ok(())
    },
    "BuN" | "_uN" => |m, c, _| Ok(m.bullet = EngineBlock::read(c)?),
    "OdN" | "_dN" => |m, c, _| Ok(m.ode = EngineBlock::read(c)?),
    "Nw1" | "_w1" => |m, c, _| Ok(m.newton = EngineBlock::read(c)?),
    "Mj1" | "_j1" => |m, c, _| Ok(m.mujoco = EngineBlock::read(c)?),
    "Vo4" | "_o4" => |m, c, _| Ok(m.vortex = EngineBlock::read(c)?),
});

/// Known elements that are not used: older forms of elements listed above, and those for the user interface.
pub const IGNORED: &[&str] = &["Bcv", "Vo2", "Vo3", "Cv2", "Uis", "Ups"];

/// Reads the elements of a material.
pub fn read(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<Material> {
    let mut material = Material { id: -1, ..Default::default() };
    object(c, TAGS, IGNORED, &mut material, unknown)?;
    Ok(material)
}
