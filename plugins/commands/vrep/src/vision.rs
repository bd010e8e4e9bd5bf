//! Vision sensors: there are none yet, and what scripts ask of one is answered as for a sensor that sees nothing.
//!
//! An image is black, depths lie at the far plane, and a sensor that was not handled reads -1.

use crate::{Vrep, kit::*};

const WHY: &str = "there are no vision sensors: images are black, and depths lie at the far plane";
/// Pixels of an image, in each direction, where nothing else is asked for.
const SIDE: i64 = 32;
/// No image is larger than this, in each direction.
const MOST: i64 = 4096;
/// Added to a handle: one value per pixel; of depths: packed.
const FLAG: i64 = 0x40_0000;
/// The 15 values of the packet that every sensor has: least, greatest and mean intensity, red, green, blue and depth.
const PACKET: [f64; 15] = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Width and height of what is asked for.
fn size(c: &Ctx<'_>, at: usize) -> Result<[i64; 2]> {
    let asked = |i: usize| Ok::<_, Fail>(int_or(c, i, 0)?.clamp(0, MOST));
    Ok(match [asked(at)?, asked(at + 1)?] {
        [w, h] if w > 0 && h > 0 => [w, h],
        _ => [SIDE, SIDE],
    })
}
/// Likewise where it is a table.
fn size_table(c: &Ctx<'_>, at: usize) -> [i64; 2] {
    let asked = |k: usize| c.arg(at).number(k).map_or(0, |x| (x as i64).clamp(0, MOST));
    match [asked(0), asked(1)] {
        [w, h] if w > 0 && h > 0 => [w, h],
        _ => [SIDE, SIDE],
    }
}
fn pixels(size: [i64; 2]) -> usize {
    (size[0] * size[1]) as usize
}
/// Depths as 32-bit floats.
fn packed_depths(n: usize) -> Vec<u8> {
    1.0_f32.to_le_bytes().repeat(n)
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let sensor = || flagged("sensor");
    let more = || Param::any("arguments").rest();
    offer.command(
        both("readVisionSensor", MINUS, |c| {
            living(c, 0)?;
            c.ret(-1_i64);
            Ok(())
        })
        .param(sensor())
        .returns(Param::int("result").text("-1: never handled"))
        .text("Reads what a vision sensor has detected.")
        .stub(WHY),
    );
    offer.command(
        both("handleVisionSensor", MINUS, |c| {
            let one = c.i64(0)? >= 0;
            if one {
                living(c, 0)?;
            }
            c.ret(0_i64);
            if one {
                c.ret::<[f64]>(&PACKET[..]);
            }
            Ok(())
        })
        .param(sensor().text("a handle, sim.handle_all or sim.handle_all_except_explicit"))
        .returns(Param::int("count").text("0"))
        .returns(Param::floats("packet", 15).text("of one sensor: black, nothing near"))
        .text("Lets vision sensors take an image.")
        .stub(WHY),
    );
    for (name, what) in [("resetVisionSensor", "Forgets what vision sensors have seen."), ("checkVisionSensor", LOOKS)]
    {
        offer.command(
            both(name, MINUS, |c| {
                if c.i64(0)? >= 0 {
                    living(c, 0)?;
                }
                c.ret(0_i64);
                Ok(())
            })
            .param(sensor())
            .param(more())
            .returns(Param::int("result").text("0"))
            .text(what)
            .stub(WHY),
        );
    }
    offer.command(
        both("checkVisionSensorEx", NIL, |c| {
            living(c, 0)?;
            let (n, image) = (pixels([SIDE, SIDE]), c.arg(2).truthy());
            let all = if image { vec![0.0; 3 * n] } else { vec![1.0; n] };
            c.ret::<[f64]>(&all[..]);
            Ok(())
        })
        .param(sensor())
        .param(Param::int("entity"))
        .param(Param::any("image").optional().text("true: colours, else depths"))
        .returns(Param::floats("buffer", 0))
        .text(LOOKS)
        .stub(WHY),
    );
    old_images(offer);
    images(offer);
    handling(offer);
}

const LOOKS: &str = "Looks at one entity through a vision sensor.";

/// Images as scripts of before 4.4 get them.
fn old_images(offer: &mut Offer<Vrep>) {
    let with_size = |command: Cmd| {
        command
            .param(flagged("sensor"))
            .param(Param::int("x").default(0).optional())
            .param(Param::int("y").default(0).optional())
            .param(Param::int("width").default(0).optional().text("0: all"))
            .param(Param::int("height").default(0).optional().text("0: all"))
            .stub(WHY)
    };
    offer.command(
        with_size(both("getVisionSensorImage", NIL, |c| {
            living(c, 0)?;
            let n = pixels(size(c, 3)?) * if c.i64(0)? & FLAG != 0 { 1 } else { 3 };
            match int_or(c, 5, 0)? {
                0 => c.ret::<[f64]>(&vec![0.0; n][..]),
                _ => c.ret::<[u8]>(&vec![0; n][..]),
            }
            Ok(())
        }))
        .param(Param::int("type").default(0).optional().text("1: as text"))
        .returns(Param::any("image").text("numbers of 0 to 1, or bytes"))
        .text("Gives the image of a vision sensor."),
    );
    offer.command(
        with_size(both("getVisionSensorCharImage", NIL, |c| {
            living(c, 0)?;
            let size = size(c, 3)?;
            let n = pixels(size) * if c.i64(0)? & FLAG != 0 { 1 } else { 3 };
            c.ret::<[u8]>(&vec![0; n][..]);
            c.ret(size[0]);
            c.ret(size[1]);
            Ok(())
        }))
        .param(Param::any("cutOff").optional())
        .returns(Param::string("image").text("bytes"))
        .returns(Param::int("width"))
        .returns(Param::int("height"))
        .text("Gives the image of a vision sensor as bytes."),
    );
    offer.command(
        with_size(both("getVisionSensorDepthBuffer", NIL, |c| {
            living(c, 0)?;
            let n = pixels(size(c, 3)?);
            match c.i64(0)? & FLAG {
                0 => c.ret::<[f64]>(&vec![1.0; n][..]),
                _ => c.ret::<[u8]>(&packed_depths(n)[..]),
            }
            Ok(())
        }))
        .returns(Param::any("depths").text("0: near plane, 1: far plane; packed if the handle has that flag"))
        .text("Gives the depths that a vision sensor sees."),
    );
    offer.command(
        both("getVisionSensorResolution", NIL, resolution)
            .param(flagged("sensor"))
            .returns(Param::list("resolution").text("{width, height}"))
            .text("Gives the resolution of a vision sensor.")
            .stub(WHY),
    );
}

fn resolution(c: &mut Ctx<'_>) -> Result {
    living(c, 0)?;
    c.ret::<[i64]>(&[SIDE, SIDE][..]);
    Ok(())
}

/// Images as scripts get them since 4.4.
fn images(offer: &mut Offer<Vrep>) {
    offer.command(
        modern("getVisionSensorRes", resolution)
            .param(flagged("sensor"))
            .returns(Param::list("resolution").text("{width, height}"))
            .text("Gives the resolution of a vision sensor.")
            .stub(WHY),
    );
    offer.command(
        modern("getVisionSensorImg", |c| {
            living(c, 0)?;
            let (size, options) = (size_table(c, 4), int_or(c, 1, 0)?);
            let each = if options & 1 != 0 { 1 } else { 3 } + usize::from(options & 2 != 0);
            c.ret::<[u8]>(&vec![0; pixels(size) * each][..]);
            c.ret::<[i64]>(&size[..]);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("options").default(0).optional().text("1: grey, 2: with alpha"))
        .param(Param::float("cutOff").default(0.0).optional())
        .param(Param::any("position").optional())
        .param(Param::any("size").optional())
        .returns(Param::string("image").text("bytes"))
        .returns(Param::list("resolution").text("{width, height}"))
        .text("Gives the image of a vision sensor.")
        .stub(WHY),
    );
    offer.command(
        modern("getVisionSensorDepth", |c| {
            living(c, 0)?;
            let size = size_table(c, 3);
            c.ret::<[u8]>(&packed_depths(pixels(size))[..]);
            c.ret::<[i64]>(&size[..]);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("options").default(0).optional().text("1: in m"))
        .param(Param::any("position").optional())
        .param(Param::any("size").optional())
        .returns(Param::string("depths").text("packed 32-bit floats"))
        .returns(Param::list("resolution").text("{width, height}"))
        .text("Gives the depths that a vision sensor sees.")
        .stub(WHY),
    );
}

/// What is done to images and sensors.
fn handling(offer: &mut Offer<Vrep>) {
    for name in ["setVisionSensorImage", "setVisionSensorCharImage"] {
        offer.command(set_image(both(name, MINUS, taken)));
    }
    offer.command(set_image(modern("setVisionSensorImg", taken)));
    offer.command(
        both("getVisionSensorFilter", MINUS, |c| {
            living(c, 0)?;
            c.ret(-1_i64);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("index"))
        .returns(Param::int("type").text("-1: there is none"))
        .text("Gives a filter of a vision sensor.")
        .stub(WHY),
    );
    offer.command(
        both("setVisionSensorFilter", MINUS, taken)
            .param(flagged("sensor"))
            .param(Param::any("arguments").rest())
            .returns(Param::int("result"))
            .text("Sets a filter of a vision sensor.")
            .stub(WHY),
    );
    offer.command(
        both("createVisionSensor", MINUS, |c| {
            let made = c.world().create("dummy", 0, "visionSensor")?;
            c.ret(handle(made));
            Ok(())
        })
        .param(Param::int("options"))
        .param(Param::any("arguments").rest())
        .returns(Param::int("sensor").text("a dummy stands for it"))
        .text("Makes a vision sensor.")
        .stub(WHY),
    );
    offer.command(
        both("getScaledImage", NIL, |c| {
            let (from, to) = (size_table(c, 1), size_table(c, 2));
            let each = (c.bytes(0)?.len() / pixels(from).max(1)).clamp(1, 4);
            c.ret::<[u8]>(&vec![0; pixels(to) * each][..]);
            c.ret::<[i64]>(&to[..]);
            Ok(())
        })
        .param(Param::string("image"))
        .param(Param::any("resolution"))
        .param(Param::any("wanted"))
        .param(Param::any("options").optional())
        .returns(Param::string("image").text("black"))
        .returns(Param::list("resolution").text("{width, height}"))
        .text("Scales an image.")
        .stub(WHY),
    );
    for name in ["transformImage", "saveImage"] {
        offer.command(
            both(name, MINUS, |c| {
                c.ret(-1_i64);
                Ok(())
            })
            .param(Param::string("image"))
            .param(Param::any("arguments").rest())
            .returns(Param::int("result").text("-1: not done"))
            .text(if name == "saveImage" { "Writes an image to a file." } else { "Changes an image." })
            .stub("images are not written and changed"),
        );
    }
    offer.command(
        both("loadImage", NIL, |_| Ok(()))
            .param(Param::any("options"))
            .param(Param::string("file"))
            .returns(Param::string("image").text("nothing: it was not read"))
            .text("Reads an image from a file.")
            .stub("images are not read"),
    );
}

fn set_image(command: Cmd) -> Cmd {
    command
        .param(flagged("sensor"))
        .param(Param::any("image"))
        .param(Param::any("arguments").rest())
        .returns(Param::int("result").text("0: nothing was detected"))
        .text("Gives a vision sensor an image from elsewhere.")
        .stub(WHY)
}
fn taken(c: &mut Ctx<'_>) -> Result {
    living(c, 0)?;
    c.ret(0_i64);
    Ok(())
}
