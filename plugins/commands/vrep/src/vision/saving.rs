//! Commands that read and write image files, and convert images.
//!
//! Images in the API start with the bottom row, images in files with the top row.

use std::io::Cursor;

use image::{
    ColorType, ImageError, ImageFormat, ImageOutputFormat,
    codecs::pnm::{PnmSubtype, SampleEncoding},
    io::Limits,
};

use super::view::pair;
use crate::kit::*;

/// Bit of an image's options that selects four bytes per pixel.
const ALPHA_OPTION: i64 = 1;
/// Maximum number of pixels of an image.
const MAX_PIXELS: i64 = 1 << 26;
/// Maximum size of a file that is read, in bytes.
const MAX_FILE_BYTES: u64 = 256 << 20;

/// An image passed by a script: bytes, columns, rows and bytes per pixel.
#[derive(Debug, Clone, PartialEq)]
struct PixelImage {
    columns: usize,
    rows: usize,
    bytes_per_pixel: usize,
    bytes: Vec<u8>,
}

impl PixelImage {
    /// Reads an image from argument `i`, and its size from the next argument.
    fn of(c: &Ctx<'_>, i: usize, each: usize) -> Result<Self> {
        let (bytes, [columns, rows]) = (c.bytes(i)?, pair(c, i + 1));
        if columns < 1 || rows < 1 || columns.saturating_mul(rows) > MAX_PIXELS {
            return Err(Fail::argument(format!(
                "argument {}: expected at least 1 x 1 and at most {MAX_PIXELS} pixels, found {columns} x {rows}",
                i + 2
            )));
        }
        let (columns, rows) = (columns as usize, rows as usize);
        if bytes.len() != columns * rows * each {
            return Err(Fail::argument(format!(
                "argument {}: expected {columns} x {rows} pixels with {} bytes in total, found {} bytes",
                i + 1,
                columns * rows * each,
                bytes.len()
            )));
        }
        Ok(PixelImage { columns, rows, bytes_per_pixel: each, bytes: bytes.to_vec() })
    }
    fn pixel(&self, column: usize, row: usize) -> &[u8] {
        let first = (row * self.columns + column) * self.bytes_per_pixel;
        &self.bytes[first..first + self.bytes_per_pixel]
    }
    fn flipped(&self, x: bool, y: bool) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.bytes.len());
        for row in 0..self.rows {
            for column in 0..self.columns {
                let column = if x { self.columns - 1 - column } else { column };
                let row = if y { self.rows - 1 - row } else { row };
                out.extend_from_slice(self.pixel(column, row));
            }
        }
        out
    }
    /// Converts the picture to `each` (3 or 4) bytes per pixel; an added alpha channel is opaque.
    fn with(self, each: usize) -> Self {
        if each == self.bytes_per_pixel {
            return self;
        }
        let pixels = self.bytes.chunks(self.bytes_per_pixel);
        let bytes = pixels.flat_map(|p| [p[0], p[1], p[2], 255].into_iter().take(each)).collect();
        PixelImage { bytes_per_pixel: each, bytes, ..self }
    }
    /// Returns the pixels resampled to a different size: bilinear if `smooth` is set, otherwise nearest neighbour.
    fn scaled(&self, columns: usize, rows: usize, smooth: bool) -> Vec<u8> {
        let mut out = Vec::with_capacity(columns * rows * self.bytes_per_pixel);
        let place = |i: usize, n: usize, side: usize| {
            ((i as f64 + 0.5) * side as f64 / n as f64 - 0.5).clamp(0.0, side as f64 - 1.0)
        };
        for row in 0..rows {
            let y = place(row, rows, self.rows);
            for column in 0..columns {
                let x = place(column, columns, self.columns);
                if !smooth {
                    out.extend_from_slice(self.pixel(x.round() as usize, y.round() as usize));
                    continue;
                }
                let (left, low) = (x.floor() as usize, y.floor() as usize);
                let (right, high) = ((left + 1).min(self.columns - 1), (low + 1).min(self.rows - 1));
                let (u, v) = (x - left as f64, y - low as f64);
                for k in 0..self.bytes_per_pixel {
                    let at = |c, r| f64::from(self.pixel(c, r)[k]);
                    let below = at(left, low) * (1.0 - u) + at(right, low) * u;
                    let above = at(left, high) * (1.0 - u) + at(right, high) * u;
                    out.push((below * (1.0 - v) + above * v).round() as u8);
                }
            }
        }
        out
    }
}

/// Returns the image format for a file name.
fn format_of(name: &str) -> Result<ImageFormat> {
    let end = name.rsplit_once('.').map_or("", |(_, end)| end);
    let written = |f: &ImageFormat| FORMATS.contains(f);
    ImageFormat::from_extension(end).filter(written).ok_or_else(|| {
        Fail::unsupported(format!("images cannot be written as `{name}`"))
            .help("use the suffix .png, .jpg, .bmp, .tiff or .ppm")
    })
}

const FORMATS: [ImageFormat; 5] =
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp, ImageFormat::Tiff, ImageFormat::Pnm];

/// Default quality of lossy formats, percent.
const DEFAULT_QUALITY: u8 = 90;

/// Encodes a picture as the content of a file. `quality`, 0 to 100, applies to lossy formats; negative: the default.
fn encode(picture: PixelImage, format: ImageFormat, quality: i64) -> Result<Vec<u8>> {
    let has_alpha = matches!(format, ImageFormat::Png | ImageFormat::Tiff);
    let picture = if has_alpha { picture } else { picture.with(3) };
    let output = match format {
        ImageFormat::Jpeg => {
            ImageOutputFormat::Jpeg(u8::try_from(quality).map_or(DEFAULT_QUALITY, |quality| quality.clamp(1, 100)))
        }
        ImageFormat::Pnm => ImageOutputFormat::Pnm(PnmSubtype::Pixmap(SampleEncoding::Binary)),
        format => format.into(),
    };
    let color = if picture.bytes_per_pixel == 4 { ColorType::Rgba8 } else { ColorType::Rgb8 };
    let (columns, rows) = (picture.columns as u32, picture.rows as u32);
    let mut out = Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut out, &picture.flipped(false, true), columns, rows, color, output)
        .map_err(|e| Fail::new(format!("the image could not be encoded: {e}")))?;
    Ok(out.into_inner())
}

/// Decodes a file's content to an image of `each` (3 or 4) bytes per pixel.
fn decode(bytes: &[u8], each: usize) -> Result<PixelImage> {
    let unreadable = |e: ImageError| Fail::argument(format!("the image could not be decoded: {e}"));
    let mut reader =
        image::io::Reader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| unreadable(e.into()))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(8 * MAX_PIXELS as u64);
    reader.limits(limits);
    let image = reader.decode().map_err(unreadable)?;
    let (columns, rows) = (image.width() as usize, image.height() as usize);
    let bytes = if each == 4 { image.into_rgba8().into_raw() } else { image.into_rgb8().into_raw() };
    let mut out = PixelImage { columns, rows, bytes_per_pixel: each, bytes };
    out.bytes = out.flipped(false, true);
    Ok(out)
}

fn each_of(options: i64) -> usize {
    if options & ALPHA_OPTION != 0 { 4 } else { 3 }
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.saveImage", "simSaveImage"], MINUS_ONE, |c| {
            let picture = PixelImage::of(c, 0, each_of(int_or(c, 2, 0)?))?;
            let name = c.text(3)?;
            let content = encode(picture, format_of(&name)?, int_or(c, 4, -1)?)?;
            // For a name that consists only of an extension, return the content instead of writing a file.
            if name.starts_with('.') && !name.contains(['/', '\\']) {
                c.ret(Value::Bytes(content));
                return Ok(());
            }
            c.world().write_file(name.as_bytes(), &content)?;
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::string("image").text("bytes, bottom row first"))
        .param(Param::any("resolution").text("{width, height}"))
        .param(Param::int("options").default(0).optional().text("1: with alpha"))
        .param(Param::string("file").text(
            "in a folder that scripts may use, as .png, .jpg, .bmp, .tiff or .ppm; a suffix alone: returns the content",
        ))
        .param(Param::int("quality").default(-1).optional().text("quality of .jpg, 0 to 100; -1: 90"))
        .returns(Param::any("result").text("1, or the content"))
        .text("Writes an image to a file."),
    );
    offer.command(
        both(["sim.loadImage", "simLoadImage"], NIL, |c| {
            let each = each_of(c.i64(0)?);
            let given = c.bytes(1)?;
            // An argument with a zero byte is the content of a file, because file names never contain one. Almost all
            // image files do.
            let picture = if given.contains(&0) {
                decode(given, each)?
            } else {
                decode(&c.world().read_file(given, MAX_FILE_BYTES)?, each)?
            };
            c.ret(Value::Bytes(picture.bytes));
            c.ret(&[picture.columns as i64, picture.rows as i64][..]);
            Ok(())
        })
        .param(Param::int("options").text("1: with alpha"))
        .param(Param::string("file").text("in a folder that scripts may use; or the file's content"))
        .returns(Param::bytes("image").text("bottom row first"))
        .returns(Param::list("resolution").text("{width, height}"))
        .text("Reads an image from a file: .png, .jpg, .bmp, .tiff or .ppm."),
    );
    offer.command(
        both(["sim.getScaledImage", "simGetScaledImage"], NIL, |c| {
            let options = int_or(c, 3, 0)?;
            let picture = PixelImage::of(c, 0, each_of(options))?.with(if options & 2 != 0 { 4 } else { 3 });
            let [w, h] = pair(c, 2);
            if w < 1 || h < 1 || w.saturating_mul(h) > MAX_PIXELS {
                return Err(Fail::argument(format!(
                    "argument 3: expected at least 1 x 1 and at most {MAX_PIXELS} pixels, found {w} x {h}"
                )));
            }
            let (mut w, mut h) = (w as usize, h as usize);
            if options & 12 != 0 {
                // Compute the largest size that fits into the requested size, or the smallest size that covers it.
                let (x, y) = (w as f64 / picture.columns as f64, h as f64 / picture.rows as f64);
                let scale = if options & 4 != 0 { x.min(y) } else { x.max(y) };
                w = ((picture.columns as f64 * scale).round() as usize).max(1);
                h = ((picture.rows as f64 * scale).round() as usize).max(1);
            }
            c.ret(Value::Bytes(picture.scaled(w, h, options & 16 != 0)));
            c.ret(&[w as i64, h as i64][..]);
            Ok(())
        })
        .param(Param::string("image").text("bytes"))
        .param(Param::any("resolution").text("{width, height}"))
        .param(Param::any("wanted").text("{width, height}"))
        .param(Param::int("options").default(0).optional().text(
            "1: the image has alpha, 2: the result has alpha, 4: keeps the aspect ratio and fits into the requested \
             size, 8: keeps the aspect ratio and covers the requested size, 16: smooth",
        ))
        .returns(Param::bytes("image"))
        .returns(Param::list("resolution").text("{width, height}"))
        .text("Scales an image."),
    );
    offer.command(
        both(["sim.transformImage", "simTransformImage"], MINUS_ONE, |c| {
            let options = int_or(c, 2, 0)?;
            let picture = PixelImage::of(c, 0, each_of(options))?;
            c.ret(1_i64);
            c.ret(Value::Bytes(picture.flipped(options & 2 != 0, options & 4 != 0)));
            Ok(())
        })
        .param(Param::string("image").text("bytes"))
        .param(Param::any("resolution").text("{width, height}"))
        .param(Param::int("options").text("1: with alpha, 2: flips along x, 4: along y"))
        .returns(Param::int("result").text("1"))
        .returns(Param::bytes("image").text("the transformed image"))
        .text("Mirrors an image.")
        .partial("V-REP modifies the string in place, which is impossible here; use the second result."),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> PixelImage {
        // Lower row: red, green; upper row: blue, white.
        PixelImage {
            columns: 2,
            rows: 2,
            bytes_per_pixel: 3,
            bytes: vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255],
        }
    }

    #[test]
    fn saved_images_are_upright_and_restored() {
        let write = |name: &str| encode(small(), format_of(name).unwrap(), -1).unwrap();
        let ppm = write("a.ppm");
        assert_eq!(ppm, [b"P6\n2 2 255\n".as_slice(), &[0, 0, 255, 255, 255, 255, 255, 0, 0, 0, 255, 0]].concat());
        for name in ["a.b.png", ".BMP", "a.tiff", "a.ppm"] {
            assert_eq!(decode(&write(name), 3).unwrap(), small(), "{name}");
            assert_eq!(decode(&write(name), 4).unwrap(), small().with(4), "{name}");
        }
        let jpeg = decode(&write("a.jpeg"), 3).unwrap();
        assert_eq!((jpeg.columns, jpeg.rows), (2, 2));
        let alpha = encode(small().with(4), ImageFormat::Png, -1).unwrap();
        assert_eq!(decode(&alpha, 4).unwrap(), small().with(4));
        assert_eq!(small().with(4).bytes[..8], [255, 0, 0, 255, 0, 255, 0, 255]);
        assert!(decode(b"\x89PNG no", 3).is_err());
        assert!(format_of("a.gif").is_err() && format_of("png").is_err());
    }

    #[test]
    fn images_are_flipped_and_scaled() {
        assert_eq!(small().flipped(true, false)[..3], [0, 255, 0]);
        assert_eq!(small().flipped(false, true)[..3], [0, 0, 255]);
        let twice = small().scaled(4, 2, false);
        assert_eq!(twice[..12], [255, 0, 0, 255, 0, 0, 0, 255, 0, 0, 255, 0]);
        // The mean of all four pixels.
        assert_eq!(small().scaled(1, 1, true), [128, 128, 128]);
    }
}
