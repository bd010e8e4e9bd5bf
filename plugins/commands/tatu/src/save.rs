//! The command `tatu.save`, which writes sensor fields to files as pictures or raw data.
//!
//! Sensor images start with the bottom row, picture files with the top row.

use std::fmt::Display;

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Offer, Param, Reading, Result},
};

use crate::{
    plugin::{Cmd, Ctx, Tatu},
    read::bytes,
};

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.save", save)
            .param(Param::int("sensor").text("a handle"))
            .param(Param::string("field").text("its name, with or without the schema: depth, rgb"))
            .param(Param::string("file").text(
                "in a folder that scripts may use. Its suffix determines the format: .png or .pgm: lengths as 16-bit \
                 integers in mm, 0 where no length was measured or it exceeds 65.535 m; .png or .ppm: colours, 8 bits \
                 per channel; .raw: the unchanged data, little-endian, bottom row first",
            ))
            .text("Writes a field of a sensor's last reading to a file.")
            .example(
                "local eye = sim.getObject('/eye')\n\
                 function sysCall_sensing()\n  \
                   tatu.save(eye, 'depth', 'example_depth.png')\n  \
                   tatu.save(eye, 'rgb', 'example_color.ppm')\n  \
                   local file = io.open('example_color.ppm', 'rb')\n  \
                   assert(file:read(2) == 'P6')\n  \
                   file:close()\n\
                 end",
            ),
    );
}

/// A field as pixels of a picture, top row first.
enum FieldPicture {
    /// Depths in mm.
    Lengths(Vec<u16>),
    /// Red, green and blue, one byte each.
    Colors(Vec<u8>),
}

fn save(c: &mut Ctx<'_>) -> Result {
    let (world, field, file) = (c.world(), c.text(1)?, c.text(2)?);
    let o = world.look(c.i64(0)? as u64)?;
    let names = || (0..).map_while(|i| world.field_of(o.id, i));
    let short = |name: &str| name.split_once('.').map_or(name, |(_, short)| short).to_owned();
    let found = names().find(|(n, _)| *n == field).or_else(|| names().find(|(n, _)| short(n) == field));
    let Some((name, dims)) = found else {
        let known: Vec<String> = names().map(|(n, _)| short(n)).collect();
        let known =
            if known.is_empty() { "it has no fields".into() } else { format!("expected one of: {}", known.join(", ")) };
        return Err(Fail::argument(format!("object {} has no field `{field}`; {known}", o.handle())));
    };
    let reading = world.reading(o.id, world.host().prop(name))?;
    if reading.sequence() == 0 {
        return Err(Fail::missing(format!("sensor {} has not been measured yet", o.handle())));
    }
    let ending = file.rsplit_once('.').map_or("", |(_, end)| end).to_lowercase();
    let [rows, columns, _] = dims;
    let content = match (ending.as_str(), picture(&reading, dims)) {
        ("raw", _) => bytes(&reading),
        ("png", Some(picture)) => png_of(&picture, rows, columns).map_err(|e| broken(&file, e))?,
        ("pgm", Some(FieldPicture::Lengths(mm))) => {
            let head = format!("P5\n{columns} {rows}\n65535\n").into_bytes();
            head.into_iter().chain(mm.iter().flat_map(|x| x.to_be_bytes())).collect()
        }
        ("ppm", Some(FieldPicture::Colors(rgb))) => [format!("P6\n{columns} {rows}\n255\n").into_bytes(), rgb].concat(),
        _ => {
            return Err(Fail::unsupported(format!("`{name}` cannot be written as `{file}`"))
                .help("use .png, .pgm or .raw for depths, .png, .ppm or .raw for colours, .raw for other fields"));
        }
    };
    world.write_file(file.as_bytes(), &content)
}

fn broken(file: &str, e: impl Display) -> Fail {
    Fail::new(format!("`{file}` cannot be written: {e}"))
}

/// Converts a field to a picture, or returns `None` unless it is a non-empty image of 32-bit depths, m, or of three
/// bytes per pixel.
fn picture(r: &Reading, [rows, columns, each]: [u32; 3]) -> Option<FieldPicture> {
    let columns = columns as usize;
    if rows == 0 || columns == 0 {
        return None;
    }
    match (r.elem(), each) {
        (TATU_ELEM_F32, 1) => {
            Some(FieldPicture::Lengths(r.f32s().chunks(columns).rev().flatten().map(millimetres).collect()))
        }
        (TATU_ELEM_U8, 3) => Some(FieldPicture::Colors(r.u8s().chunks(3 * columns).rev().flatten().copied().collect())),
        _ => None,
    }
}

/// Converts metres to whole millimetres; 0 if the value is not finite or does not fit.
fn millimetres(metres: &f32) -> u16 {
    let mm = (f64::from(*metres) * 1000.0).round();
    if (0.0..=65_535.0).contains(&mm) { mm as u16 } else { 0 }
}

fn png_of(picture: &FieldPicture, rows: u32, columns: u32) -> Result<Vec<u8>, png::EncodingError> {
    let mut out = Vec::new();
    let mut png = png::Encoder::new(&mut out, columns, rows);
    let data = match picture {
        FieldPicture::Lengths(mm) => {
            png.set_color(png::ColorType::Grayscale);
            png.set_depth(png::BitDepth::Sixteen);
            mm.iter().flat_map(|x| x.to_be_bytes()).collect()
        }
        FieldPicture::Colors(rgb) => {
            png.set_color(png::ColorType::Rgb);
            png.set_depth(png::BitDepth::Eight);
            rgb.clone()
        }
    };
    let mut writer = png.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_rounded_to_millimetres() {
        let metres = [0.0, 0.0014, 1.2346, 65.535, 65.54, f32::INFINITY, -1.0];
        assert_eq!(metres.map(|z| millimetres(&z)), [0, 1, 1235, 65_535, 0, 0, 0]);
    }

    #[test]
    fn depth_png_has_sixteen_bits() {
        let bytes = png_of(&FieldPicture::Lengths(vec![1, 500, 1000, 65_535]), 2, 2).unwrap();
        let mut reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().bit_depth), (2, png::BitDepth::Sixteen));
        let mut data = vec![0; reader.output_buffer_size()];
        reader.next_frame(&mut data).unwrap();
        assert_eq!(data, [0, 1, 1, 244, 3, 232, 255, 255]);
    }
}
