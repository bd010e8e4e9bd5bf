//! Commands that return the images and depths of vision sensors.

use super::{
    handle::current_result,
    view::{VisionView, packed, pair},
};
use crate::kit::*;

/// Flag that scripts add to a handle to request one value per pixel, for images, or packed values, for depths.
const PACKED_FLAG: i64 = 0x40_0000;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    old_image_commands(offer);
    modern_ones(offer);
}

/// Returns one value per pixel, the mean of red, green and blue.
fn grey(rgb: &[u8]) -> Vec<u8> {
    rgb.as_chunks::<3>().0.iter().map(|p| (p.iter().map(|x| u16::from(*x)).sum::<u16>() / 3) as u8).collect()
}

/// Adds an alpha value to each pixel: 255 up to the depth `most`, 0 beyond.
fn with_alpha(pixels: &[u8], each: usize, depth: &[f32], most: f64) -> Vec<u8> {
    let alpha = depth.iter().map(|z| if f64::from(*z) <= most { 255 } else { 0 });
    pixels.chunks(each).zip(alpha).flat_map(|(p, a)| p.iter().copied().chain([a])).collect()
}

/// Returns the bytes and the size of a part of an image, optionally in grey, and with alpha values by depth.
fn bytes(
    c: &Ctx<'_>,
    mut view: VisionView,
    at: [i64; 2],
    size: [i64; 2],
    one: bool,
    alpha: Option<f64>,
) -> Result<(Vec<u8>, [i64; 2])> {
    let part = view.region(at, size)?;
    let image = current_result(c, &view)?;
    let rgb = part.of(&image.rgb(c, &view), view.columns, 3);
    let mut out = if one { grey(&rgb) } else { rgb };
    if let Some(most) = alpha {
        let depth = part.of(&image.depth(c, &view), view.columns, 1);
        out = with_alpha(&out, if one { 1 } else { 3 }, &depth, most);
    }
    Ok((out, [part.columns as i64, part.rows as i64]))
}

/// Returns the depths of a part of an image, from 0 to 1 or in m, and its size.
fn depths(
    c: &Ctx<'_>,
    mut view: VisionView,
    at: [i64; 2],
    size: [i64; 2],
    metres: bool,
) -> Result<(Vec<f32>, [i64; 2])> {
    let part = view.region(at, size)?;
    let image = current_result(c, &view)?;
    let mut out = part.of(&image.depth(c, &view), view.columns, 1);
    if metres {
        // Pixels that could not be measured have the depth 0.
        let lost = image.is_depth_measured().then(|| view.metres(c)).flatten().map(|z| part.of(&z, view.columns, 1));
        for (i, z) in out.iter_mut().enumerate() {
            let none = lost.as_ref().is_some_and(|l| l.get(i) == Some(&0.0));
            *z = if none { 0.0 } else { view.metres_of(*z) };
        }
    }
    Ok((out, [part.columns as i64, part.rows as i64]))
}

/// Adds the image commands of versions before 4.4.
fn old_image_commands(offer: &mut Offer<Vrep>) {
    let with_size = |command: Cmd| {
        command
            .param(flagged("sensor"))
            .param(Param::int("x").default(0).optional())
            .param(Param::int("y").default(0).optional())
            .param(Param::int("width").default(0).optional().text("0: all"))
            .param(Param::int("height").default(0).optional().text("0: all"))
    };
    let rect = |c: &Ctx<'_>| -> Result<([i64; 2], [i64; 2])> {
        Ok(([int_or(c, 1, 0)?, int_or(c, 2, 0)?], [int_or(c, 3, 0)?, int_or(c, 4, 0)?]))
    };
    let one = |c: &Ctx<'_>| c.i64(0).map(|h| h & PACKED_FLAG != 0);
    offer.command(
        with_size(both(["sim.getVisionSensorImage", "simGetVisionSensorImage"], NIL, move |c| {
            let (at, size) = rect(c)?;
            let (out, _) = bytes(c, VisionView::of(c, 0)?, at, size, one(c)?, None)?;
            match int_or(c, 5, 0)? {
                0 => c.ret(out.iter().map(|x| f64::from(*x) / 255.0).collect::<Vec<_>>()),
                _ => c.ret(Value::Bytes(out)),
            }
            Ok(())
        }))
        .param(Param::int("type").default(0).optional().text("1: as a string of bytes"))
        .returns(
            Param::any("image").text("numbers from 0 to 1, or bytes: red, green, blue, or grey with the flag 0x400000"),
        )
        .text("Returns the image of a vision sensor, bottom row first."),
    );
    offer.command(
        with_size(both(["sim.getVisionSensorCharImage", "simGetVisionSensorCharImage"], NIL, move |c| {
            let (at, size) = rect(c)?;
            let most = if c.has(5) { c.f64(5)? } else { 0.0 };
            let alpha = (most != 0.0).then_some(most);
            let (out, size) = bytes(c, VisionView::of(c, 0)?, at, size, one(c)?, alpha)?;
            c.ret(Value::Bytes(out));
            c.ret(size[0]);
            c.ret(size[1]);
            Ok(())
        }))
        .param(
            Param::float("cutOff").default(0.0).optional().text("not 0: adds alpha, 255 up to this depth and 0 beyond"),
        )
        .returns(Param::bytes("image"))
        .returns(Param::int("width"))
        .returns(Param::int("height"))
        .text("Returns the image of a vision sensor as bytes, bottom row first."),
    );
    offer.command(
        with_size(both(["sim.getVisionSensorDepthBuffer", "simGetVisionSensorDepthBuffer"], NIL, move |c| {
            let (at, size) = rect(c)?;
            let (out, _) = depths(c, VisionView::of(c, 0)?, at, size, false)?;
            match c.i64(0)? & PACKED_FLAG {
                0 => c.ret(out.iter().map(|x| f64::from(*x)).collect::<Vec<_>>()),
                _ => c.ret(Value::Bytes(packed(&out))),
            }
            Ok(())
        }))
        .returns(Param::any("depths").text("0: near plane, 1: far plane; packed if the handle has the flag 0x400000"))
        .text("Returns the depth image of a vision sensor, bottom row first."),
    );
    offer.command(
        both(["sim.getVisionSensorResolution", "simGetVisionSensorResolution"], NIL, resolution)
            .param(flagged("sensor"))
            .returns(Param::list("resolution").text("{width, height}"))
            .text("Returns the resolution of a vision sensor."),
    );
}

fn resolution(c: &mut Ctx<'_>) -> Result {
    let view = VisionView::of(c, 0)?;
    c.ret(&[view.columns as i64, view.rows as i64][..]);
    Ok(())
}

/// Adds the image commands of versions since 4.4.
fn modern_ones(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getVisionSensorRes", resolution)
            .param(flagged("sensor"))
            .returns(Param::list("resolution").text("{width, height}"))
            .text("Returns the resolution of a vision sensor."),
    );
    offer.command(
        Cmd::new("sim.getVisionSensorImg", |c| {
            let options = int_or(c, 1, 0)?;
            let most = if c.has(2) { c.f64(2)? } else { 0.0 };
            let alpha = if most != 0.0 { Some(most) } else { (options & 2 != 0).then_some(1.0) };
            let (out, size) = bytes(c, VisionView::of(c, 0)?, pair(c, 3), pair(c, 4), options & 1 != 0, alpha)?;
            c.ret(Value::Bytes(out));
            c.ret(&size[..]);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("options").default(0).optional().text("1: grey, 2: with alpha"))
        .param(
            Param::float("cutOff").default(0.0).optional().text("not 0: adds alpha, 255 up to this depth and 0 beyond"),
        )
        .param(Param::any("position").optional().text("{x, y} of a part of the image"))
        .param(Param::any("size").optional().text("{width, height} of that part; omitted: the whole image"))
        .returns(Param::bytes("image"))
        .returns(Param::list("resolution").text("{width, height}"))
        .text("Returns the image of a vision sensor, bottom row first."),
    );
    offer.command(
        Cmd::new("sim.getVisionSensorDepth", |c| {
            let options = int_or(c, 1, 0)?;
            let (out, size) = depths(c, VisionView::of(c, 0)?, pair(c, 2), pair(c, 3), options & 1 != 0)?;
            c.ret(Value::Bytes(packed(&out)));
            c.ret(&size[..]);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("options").default(0).optional().text(
            "1: in m, the far plane if nothing was hit, 0 if the pixel could not be measured; otherwise 0 \
                       to 1",
        ))
        .param(Param::any("position").optional().text("{x, y} of a part of the image"))
        .param(Param::any("size").optional().text("{width, height} of that part; omitted: the whole image"))
        .returns(Param::bytes("depths").text("packed 32-bit floats"))
        .returns(Param::list("resolution").text("{width, height}"))
        .text("Returns the depth image of a vision sensor, bottom row first."),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_and_alpha() {
        assert_eq!(grey(&[30, 60, 90, 255, 255, 255]), [60, 255]);
        assert_eq!(with_alpha(&[1, 2, 3, 4, 5, 6], 3, &[0.5, 0.6], 0.5), [1, 2, 3, 255, 4, 5, 6, 0]);
        assert_eq!(with_alpha(&[1, 2], 1, &[1.0, 0.0], 0.5), [1, 0, 2, 255]);
        assert_eq!(packed(&[1.0]), 1.0_f32.to_le_bytes());
    }
}
