//! Writes pictures as PNG files.

use std::{io, path::Path};

use tatu_core::{errors::Error, state::write_atomically};
use tatu_render::Picture;

/// Writes a picture. An existing file is replaced only after the new one has been written completely.
pub fn write(path: &Path, picture: &Picture) -> Result<(), Error> {
    encode(picture).and_then(|bytes| write_atomically(path, &bytes)).map_err(|e| {
        let error = Error::new("E105", format!("cannot write {}: {e}", path.display()));
        error.help("check that the folder exists and is writable")
    })
}

fn encode(picture: &Picture) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.columns, picture.rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Best);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.rgb)?;
    writer.finish()?;
    Ok(bytes)
}
