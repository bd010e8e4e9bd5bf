//! Commands that set the image of a vision sensor, and create vision sensors.

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
    offer.command(
        both(["sim.createVisionSensor", "simCreateVisionSensor"], MINUS_ONE, |c| {
            let made = c.world().create("dummy", 0, "visionSensor")?;
            let ints: [f64; 2] = numbers(c, 1)?;
            let floats: [f64; 2] = numbers(c, 2)?;
            let keys = ["vision.columns", "vision.rows", "vision.near", "vision.far"];
            for (key, x) in keys.into_iter().zip([ints[0], ints[1], floats[0], floats[1]]) {
                tags::set_number(c, made, key, x)?;
            }
            c.ret(handle(made));
            Ok(())
        })
        .param(Param::int("options"))
        .param(table("integers", "{columns, rows, 0, 0}"))
        .param(table("floats", "{near, far, angle or size, and eight more}"))
        .param(Param::any("color").optional())
        .returns(Param::int("sensor").text("a dummy that represents the sensor"))
        .text("Creates a vision sensor.")
        .partial(
            "Only the scene can create sensors: the new one has the requested resolution and planes, but is blind.",
        ),
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

/// Converts an image with one or three bytes per pixel to three bytes per pixel.
fn bytes_to_rgb(bytes: &[u8], pixels: usize, grey: bool) -> Result<Vec<u8>> {
    let each = if grey { 1 } else { 3 };
    if bytes.len() != each * pixels {
        return Err(Fail::argument(format!(
            "argument 2: an image of {pixels} pixels requires {} values, found {}",
            each * pixels,
            bytes.len()
        )));
    }
    Ok(if grey { bytes.iter().flat_map(|x| [*x; 3]).collect() } else { bytes.to_vec() })
}
