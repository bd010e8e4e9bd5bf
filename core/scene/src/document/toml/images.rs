//! Images of textures, which a scene refers to by the names of PNG files.

use std::{io::Cursor, path::Path};

use png::{BitDepth, ColorType, Decoder, Encoder, Limits, Transformations};
use tatu_errors::{Error, Result};
use tatu_geometry::{Image, MAX_IMAGE_PIXELS};
use tatu_plugin_api::safe::Value;

use super::{super::DocumentBuilder, SceneFileReader};

impl SceneFileReader<'_> {
    /// Replaces the file name of the image in a texture by its number.
    pub(super) fn with_image(&mut self, b: &mut DocumentBuilder<'_>, texture: &mut Value) -> Result {
        let Value::Map(entries) = texture else { return Ok(()) };
        for (_, value) in entries.iter_mut().filter(|(key, _)| *key == Value::text("image")) {
            if let Value::Text(name) = value {
                *value = Value::Int(self.image(b, &String::from_utf8_lossy(name))?);
            }
        }
        Ok(())
    }

    /// Returns the number of the image in a file, which the document must be permitted to name.
    fn image(&mut self, b: &mut DocumentBuilder<'_>, name: &str) -> Result<i64> {
        let folder = self.text.file.parent().unwrap_or(Path::new(""));
        let file = folder.join(name);
        if let Some(number) = self.images.get(&file) {
            return Ok(*number);
        }
        let lacks = || {
            Error::new("E105", format!("cannot read the image `{name}`"))
                .expected(format!("a PNG file {}", file.display()))
        };
        let bytes = b.read_named_file(folder, name)?.ok_or_else(lacks)?;
        let (columns, rows, rgba) = decode(&bytes).map_err(|why| {
            Error::new("E120", format!("`{name}` cannot be read as an image: {why}"))
                .expected(format!("a PNG file of at most {MAX_IMAGE_PIXELS} pixels"))
        })?;
        let number = b.image(columns, rows, rgba)? as i64;
        self.images.insert(file, number);
        Ok(number)
    }
}

/// Decodes a PNG file. Returns the number of columns and rows, and 4 bytes (RGBA) per pixel, top row first.
fn decode(bytes: &[u8]) -> std::result::Result<(u32, u32, Vec<u8>), String> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 8 * MAX_IMAGE_PIXELS });
    decoder.set_transformations(Transformations::normalize_to_color8() | Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let (columns, rows) = reader.info().size();
    if u64::from(columns) * u64::from(rows) > MAX_IMAGE_PIXELS as u64 {
        return Err(format!("it has {columns} x {rows} pixels"));
    }
    let mut out = vec![0; reader.output_buffer_size()];
    let info = reader.next_frame(&mut out).map_err(|e| e.to_string())?;
    out.truncate(info.buffer_size());
    let rgba = match info.color_type {
        ColorType::Rgba => out,
        ColorType::Rgb => out.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect(),
        ColorType::GrayscaleAlpha => out.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]).collect(),
        ColorType::Grayscale => out.iter().flat_map(|p| [*p, *p, *p, 255]).collect(),
        ColorType::Indexed => return Err("its palette is missing".into()),
    };
    Ok((columns, rows, rgba))
}

/// Encodes an image as a PNG file, without an alpha channel if all pixels are opaque.
pub fn encode_png(image: &Image) -> Vec<u8> {
    let opaque = image.rgba().chunks_exact(4).all(|p| p[3] == 255);
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, image.columns(), image.rows());
    encoder.set_color(if opaque { ColorType::Rgb } else { ColorType::Rgba });
    encoder.set_depth(BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| match opaque {
        true => {
            writer.write_image_data(&image.rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>())
        }
        false => writer.write_image_data(image.rgba()),
    });
    // Writing to memory cannot fail, and the size was checked when the image was created.
    debug_assert!(written.is_ok());
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_round_trip_preserves_pixels() {
        for opacity in [255, 7] {
            let rgba = [[1, 2, 3, 255], [4, 5, 6, opacity]].concat();
            let image = Image::new(2, 1, rgba.clone()).unwrap();
            assert_eq!(decode(&encode_png(&image)), Ok((2, 1, rgba)));
        }
        assert!(decode(b"no image").is_err());
        let mut huge = encode_png(&Image::new(1, 1, vec![9; 4]).unwrap());
        // These bytes of the header are the numbers of columns and rows. The change makes the image too large and its
        // checksum wrong.
        huge[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
        assert!(decode(&huge).is_err());
    }
}
