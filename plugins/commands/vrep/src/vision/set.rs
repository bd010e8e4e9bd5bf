//! Commands that set the image of a vision sensor.

use super::{
    handle::{current_result, process_image},
    results::VisionResult,
    view::{VisionView, pair},
};
use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for names in [
        ["sim.setVisionSensorImage", "simSetVisionSensorImage"],
        ["sim.setVisionSensorCharImage", "simSetVisionSensorCharImage"],
    ] {
        offer.command(
            set_image(both(names, MINUS_ONE, |c| {
                let view = VisionView::of(c, 0)?;
                let rgb = image(c, &view)?;
                let trigger = apply_image(c, &view, rgb, None)?;
                c.ret(i64::from(trigger));
                Ok(())
            }))
            .returns(Param::int("result").text("1: something was detected in the image, 0: nothing"))
            .text("Replaces the image of a vision sensor; its scripts receive it as the sensor's own image."),
        );
    }
    offer.command(
        set_image(Cmd::new("sim.setVisionSensorImg", |c| {
            let mut view = VisionView::of(c, 0)?;
            let options = int_or(c, 2, 0)?;
            let part = view.region(pair(c, 3), pair(c, 4))?;
            let given = bytes_to_rgb(c.bytes(1)?, part.columns * part.rows, options & 1 != 0)?;
            let seen = current_result(c, &view)?;
            let mut rgb = seen.rgb(c, &view).into_owned();
            for (y, row) in given.chunks(3 * part.columns).enumerate() {
                let first = 3 * ((part.y + y) * view.columns + part.x);
                rgb[first..first + row.len()].copy_from_slice(row);
            }
            let trigger = apply_image(c, &view, rgb, seen.depth)?;
            c.ret(i64::from(trigger));
            Ok(())
        }))
        .param(Param::int("options").default(0).optional().text("1: one byte per pixel, grey"))
        .param(Param::any("position").optional().text("{x, y} of a part of the image"))
        .param(Param::any("size").optional().text("{width, height} of that part; omitted: the whole image"))
        .returns(Param::int("result").text("1: something was detected in the image, 0: nothing"))
        .text("Replaces the image of a vision sensor; its scripts receive it as the sensor's own image."),
    );
}

fn set_image(command: Cmd) -> Cmd {
    command
        .param(flagged("sensor"))
        .param(Param::any("image").text("bytes, or a table of numbers from 0 to 1; bottom row first"))
}

/// Sets the image of a sensor, and returns whether something was detected in it.
pub(super) fn apply_image(c: &Ctx<'_>, view: &VisionView, rgb: Vec<u8>, depth: Option<Vec<f32>>) -> Result<bool> {
    Ok(process_image(c, view, VisionResult::with_image(rgb, depth))?.trigger)
}

/// Returns the image in argument 1: bytes, or numbers from 0 to 1.
fn image(c: &Ctx<'_>, view: &VisionView) -> Result<Vec<u8>> {
    let n = view.pixels();
    match c.arg(1).as_bytes() {
        Some(bytes) => bytes_to_rgb(bytes, n, c.i64(0)? & 0x40_0000 != 0),
        None => {
            let all = c
                .arg(1)
                .numbers()
                .ok_or_else(|| Fail::argument("argument 2: expected a string or a table of numbers"))?;
            let bytes: Vec<u8> = all.iter().map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
            bytes_to_rgb(&bytes, n, c.i64(0)? & 0x40_0000 != 0)
        }
    }
}

/// Converts an image to three bytes per pixel. It has one value per pixel if `grey` is set, otherwise three; the values
/// are bytes, or packed floats from 0 to 1.
fn bytes_to_rgb(bytes: &[u8], pixels: usize, grey: bool) -> Result<Vec<u8>> {
    let each = if grey { 1 } else { 3 };
    let triple = |values: Vec<u8>| match values.len() == pixels {
        true => values.into_iter().flat_map(|x| [x; 3]).collect(),
        false => values,
    };
    match bytes.len() {
        n if n == each * pixels => Ok(triple(bytes.to_vec())),
        n if n == 4 * each * pixels => {
            let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]).clamp(0.0, 1.0);
            Ok(triple(bytes.chunks_exact(4).map(|b| (float(b) * 255.0).round() as u8).collect()))
        }
        n => Err(Fail::argument(format!(
            "argument 2: an image of {pixels} pixels requires {} values, found {n}",
            each * pixels
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::bytes_to_rgb;

    #[test]
    fn images_are_bytes_or_packed_floats_with_one_or_three_values_a_pixel() {
        let rgb = vec![0, 51, 255, 10, 20, 30];
        assert_eq!(bytes_to_rgb(&rgb, 2, false).unwrap(), rgb);
        assert_eq!(bytes_to_rgb(&[7, 9], 2, true).unwrap(), [7, 7, 7, 9, 9, 9]);
        let packed: Vec<u8> = [0.0_f32, 0.2, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(bytes_to_rgb(&packed, 1, false).unwrap(), [0, 51, 255]);
        assert_eq!(bytes_to_rgb(&packed, 3, true).unwrap(), [0, 0, 0, 51, 51, 51, 255, 255, 255]);
        assert!(bytes_to_rgb(&[1, 2], 2, false).is_err());
    }
}
