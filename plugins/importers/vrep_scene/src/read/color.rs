//! Colors of meshes and lights.

use super::{
    cursor::{Cursor, ReadResult},
    section::{object, tags},
    unknown::UnknownElements,
};

/// The color of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Color {
    /// Red, green, blue of diffuse light, 0 to 1.
    pub diffuse: [f64; 3],
    /// Color of the light emitted by a light object.
    pub light: [f64; 3],
    /// Emissive color of a surface.
    pub emission: [f64; 3],
    /// Opacity from 0 (clear) to 1, if the surface is translucent.
    pub opacity: Option<f64>,
    /// Name by which scripts refer to the part with this color.
    pub name: String,
    factor: f64,
}

impl Default for Color {
    fn default() -> Self {
        Color {
            diffuse: [0.7; 3],
            light: [0.0; 3],
            emission: [0.0; 3],
            opacity: None,
            name: String::new(),
            factor: 0.5,
        }
    }
}

/// Combines ambient and diffuse color, which were separate before 3.1.3.
fn merged(ambient: [f64; 3], diffuse: [f64; 3]) -> [f64; 3] {
    let mean = diffuse.iter().sum::<f64>() / 3.0;
    ambient.map(|a| ((a + mean / 2.0) / 0.85).min(1.0))
}

/// Reads the elements of a color.
pub fn read(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<Color> {
    let mut color = Color::default();
    let tags = tags!(Color {
        "Cl3" => |k, c, _| {
            k.diffuse = c.reals()?;
            k.light = c.reals()?;
            let _specular: [f64; 3] = c.reals()?;
            Ok(k.emission = c.reals()?)
        },
        "Cl2" => |k, c, _| Ok(k.diffuse = merged(c.reals()?, c.reals()?)),
        "Cls" => |k, c, _| Ok(k.diffuse = merged(c.reals()?, c.reals()?)),
        "Trf" => |k, c, _| Ok(k.factor = c.single()?),
        // The bit is set if the color is opaque.
        "Var" => |k, c, _| Ok(k.opacity = (c.u8()? & 4 == 0).then_some(k.factor)),
        "Cnm" => |k, c, _| Ok(k.name = c.text()?),
    });
    object(c, tags, &["Sh2", "Shi", "Fi3", "Rst", "Pov"], &mut color, unknown)?;
    let sound = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.7 };
    color.diffuse = color.diffuse.map(sound);
    color.light = color.light.map(sound);
    color.emission = color.emission.map(sound);
    color.opacity = color.opacity.map(|_| sound(color.factor));
    Ok(color)
}
