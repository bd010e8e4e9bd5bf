//! Images, and their mapping to meshes.

use super::{
    cursor::{ByteSpan, Cursor, ReadResult},
    pose::{IDENTITY, StoredPose, quaternion_first},
    section::{object, tags},
    unknown::UnknownElements,
};

/// An image that shapes can use as a texture.
#[derive(Debug, Clone, Default)]
pub struct Texture {
    /// Id of the texture.
    pub id: i32,
    /// Resolution: columns and rows of pixels.
    pub size: [i32; 2],
    /// Name of the texture.
    pub name: String,
    /// Whether pixels have 4 bytes instead of 3.
    pub alpha: bool,
    /// Pixel data, row by row.
    pub pixels: ByteSpan,
}

/// Reads the section `TEX`, which contains an image.
pub fn read(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<Texture> {
    let mut texture = Texture { id: -1, ..Default::default() };
    let tags = tags!(Texture {
        "Ipa" => |t, c, _| Ok((t.id, t.size) = (c.i32()?, [c.i32()?, c.i32()?])),
        "Gon" => |t, c, _| Ok(t.name = c.text()?),
        "Bst" => |t, c, _| Ok(t.alpha = c.u8()? & 1 != 0),
        "Img" => |t, c, _| Ok(t.pixels = c.take_rest()),
    });
    let at = c.at();
    object(c, tags, &["Cv2", "Ups", "Uis"], &mut texture, unknown)?;
    let [w, h] = texture.size.map(|n| usize::try_from(n).unwrap_or(0));
    let wanted = w.saturating_mul(h).saturating_mul(if texture.alpha { 4 } else { 3 });
    if texture.pixels.len < wanted {
        let text = format!("expected {w} x {h} pixels in {wanted} bytes, found {} bytes", texture.pixels.len);
        return Err(super::cursor::ReadError::new(at, text));
    }
    Ok(texture)
}

/// The mapping of an image to a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureMapping {
    /// Id of the image, or handle of the vision sensor that provides it.
    pub texture: i32,
    /// Mapping that computes texture coordinates: 0 plane, 1 cylinder, 2 sphere, 3 box.
    pub mode: i32,
    /// Scale along u and v.
    pub scale: [f64; 2],
    /// Frame of the projection in the frame of the shape.
    pub pose: StoredPose,
    /// Whether colors between pixels are interpolated.
    pub smooth: bool,
    /// Whether the image repeats along u and v.
    pub repeat: [bool; 2],
    /// How the image is combined with the color of the shape: 0 modulates it, 1 covers it, 2 is added to it.
    pub apply: i32,
}

/// Reads the element `Toj`, which maps an image to a mesh.
pub fn property(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<TextureMapping> {
    let mut property = TextureMapping {
        texture: -1,
        mode: 0,
        scale: [1.0; 2],
        pose: IDENTITY,
        smooth: true,
        repeat: [true; 2],
        apply: 0,
    };
    let tags = tags!(TextureMapping {
        "Tob" | "_ob" => |p, c, _| Ok((p.texture, p.mode, p.scale) = (c.i32()?, c.i32()?, c.reals()?)),
        "Trc" | "_rc" => |p, c, _| Ok(p.pose = quaternion_first(c)?),
        "Bst" => |p, c, _| Ok(p.apply = i32::from(c.u8()? & 2 != 0)),
        "Bs2" => |p, c, _| {
            let bits = c.u8()?;
            Ok((p.smooth, p.repeat) = (bits & 1 != 0, [bits & 4 != 0, bits & 8 != 0]))
        },
        "Apm" => |p, c, _| Ok(p.apply = c.i32()?),
    });
    object(c, tags, &["Ftc", "Cv2"], &mut property, unknown)?;
    Ok(property)
}
