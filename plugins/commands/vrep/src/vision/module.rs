//! The module `simVision`: filters as separate functions, called from `sysCall_vision`.
//!
//! Each sensor has a working image and two buffers, which exist until the end of the run.

use super::{
    filters::{FilterInput, FilterOutput, VisionFilter, step},
    handle::{current_result, store_result},
    view::{VisionView, packed},
    work::WorkingImage,
};
use crate::{kit::*, state::state};

/// An argument of a function: its type and name, and where the filter stores it.
#[derive(Debug, Clone, Copy)]
enum FilterArgument {
    /// A number.
    Float(&'static str),
    /// A table of numbers of the given length; 0: a single number, which is a factor.
    Floats(&'static str, u32),
    /// A table of two integers.
    Pair(&'static str),
    /// An integer.
    Int(&'static str),
    /// A bit of the filter's byte.
    Bit(&'static str, i64),
    /// A bit of the filter's integer that is set when the argument is false.
    NotBit(&'static str, i64),
    /// An argument that has no effect here.
    Ignored(&'static str),
}
use FilterArgument::*;

/// A function of the module: its name, the type of its filter, its arguments, whether it reports results, its
/// description, and an example. The example consists of arguments and a condition on `rgb`, the first three bytes of
/// the result for a red image.
struct FilterFunction {
    name: &'static str,
    kind: i64,
    args: &'static [FilterArgument],
    finds: bool,
    text: &'static str,
    example: (&'static str, &'static str),
}

const fn f(
    name: &'static str,
    kind: i64,
    args: &'static [FilterArgument],
    text: &'static str,
    example: (&'static str, &'static str),
) -> FilterFunction {
    FilterFunction { name, kind, args, finds: false, text, example }
}

/// Declares a function whose filter reports results.
const fn with_results(
    name: &'static str,
    kind: i64,
    args: &'static [FilterArgument],
    text: &'static str,
    example: (&'static str, &'static str),
) -> FilterFunction {
    FilterFunction { name, kind, args, finds: true, text, example }
}

const RED: &str = "rgb == '255,0,0'";
const BLACK: &str = "rgb == '0,0,0'";
const KERNEL_ARGUMENTS: [&str; 2] =
    [", 1, 1, {0, 0, 0, 0, 1, 0, 0, 0, 0}", ", 1, 1, {0,0,0,0,0, 0,0,0,0,0, 0,0,1,0,0, 0,0,0,0,0, 0,0,0,0,0}"];
const REMOVE_BUFFER: FilterArgument = Ignored("removeBuffer");

const FUNCTIONS: &[FilterFunction] = &[
    f("simVision.sensorImgToWorkImg", 1, &[], "Loads the sensor's image.", ("", "rgb == '0,255,0'")),
    f(
        "simVision.sensorDepthMapToWorkImg",
        2,
        &[],
        "Loads the sensor's depths, 0 to 1, as grey.",
        ("", "rgb == '72,72,72'"),
    ),
    f(
        "simVision.uniformImgToWorkImg",
        3,
        &[Floats("color", 3)],
        "Sets all pixels to one value.",
        (", {0, 1, 0}", "rgb == '0,255,0'"),
    ),
    f(
        "simVision.workImgToSensorImg",
        4,
        &[REMOVE_BUFFER],
        "Outputs the working image as the sensor's image.",
        ("", RED),
    ),
    f(
        "simVision.workImgToSensorDepthMap",
        38,
        &[REMOVE_BUFFER],
        "Outputs the working image as the sensor's depths.",
        ("", RED),
    ),
    f("simVision.workImgToBuffer1", 5, &[], "Copies the working image to buffer 1.", ("", RED)),
    f("simVision.workImgToBuffer2", 6, &[], "Copies the working image to buffer 2.", ("", RED)),
    f("simVision.buffer1ToWorkImg", 7, &[], "Loads buffer 1 as the working image.", ("", BLACK)),
    f("simVision.buffer2ToWorkImg", 8, &[], "Loads buffer 2 as the working image.", ("", BLACK)),
    f("simVision.swapBuffers", 9, &[], "Swaps the two buffers.", ("", RED)),
    f("simVision.addBuffer1ToWorkImg", 10, &[], "Adds buffer 1 to the image.", ("", RED)),
    f("simVision.subtractBuffer1FromWorkImg", 11, &[], "Subtracts buffer 1 from the image.", ("", RED)),
    f("simVision.multiplyWorkImgWithBuffer1", 12, &[], "Multiplies the image by buffer 1.", ("", BLACK)),
    f("simVision.horizontalFlipWorkImg", 13, &[], "Mirrors the image horizontally.", ("", RED)),
    f("simVision.verticalFlipWorkImg", 14, &[], "Mirrors the image vertically.", ("", RED)),
    f(
        "simVision.matrix3x3OnWorkImg",
        18,
        &[Int("passes"), Floats("factor", 0), Floats("matrix", 9)],
        "Replaces each pixel with a weighted sum of its neighbourhood.",
        (KERNEL_ARGUMENTS[0], RED),
    ),
    f(
        "simVision.matrix5x5OnWorkImg",
        19,
        &[Int("passes"), Floats("factor", 0), Floats("matrix", 25)],
        "Replaces each pixel with a weighted sum of its neighbourhood.",
        (KERNEL_ARGUMENTS[1], RED),
    ),
    f("simVision.sharpenWorkImg", 20, &[], "Sharpens edges.", ("", RED)),
    f(
        "simVision.edgeDetectionOnWorkImg",
        21,
        &[Float("threshold")],
        "Makes pixels white where neighbours differ, otherwise black.",
        (", 0.2", BLACK),
    ),
    f(
        "simVision.rectangularCutWorkImg",
        22,
        &[Floats("sizes", 2), Bit("copyToBuffer1", 1)],
        "Blackens everything except a rectangle in the middle, whose size is relative to the image.",
        (", {0.5, 0.5}", BLACK),
    ),
    f(
        "simVision.circularCutWorkImg",
        23,
        &[Float("radius"), Bit("copyToBuffer1", 1)],
        "Blackens everything except a circle in the middle; with radius 1, the circle touches the closer sides.",
        (", 0.5", BLACK),
    ),
    f("simVision.normalizeWorkImg", 24, &[], "Stretches the values to the range 0 to 1.", ("", RED)),
    f(
        "simVision.intensityScaleOnWorkImg",
        25,
        &[Float("start"), Float("end"), NotBit("greyScale", 1)],
        "Maps values from 0..1 to start..end.",
        (", 1, 0, false", "rgb == '0,255,255'"),
    ),
    f(
        "simVision.selectiveColorOnWorkImg",
        26,
        &[Floats("color", 3), Floats("tolerance", 3), Bit("rgbSpace", 2), Bit("keep", 1), Bit("removedToBuffer1", 4)],
        "Retains or removes pixels near a colour.",
        (", {1, 0, 0}, {0.1, 0.1, 0.1}, true, false", BLACK),
    ),
    f(
        "simVision.scaleAndOffsetWorkImg",
        27,
        &[Floats("preOffset", 3), Floats("scale", 3), Floats("postOffset", 3), Bit("rgbSpace", 2)],
        "Adds an offset, multiplies by a factor and adds another offset, for each colour component.",
        (", {0, 0, 0}, {0, 1, 1}, {0, 0, 1}, true", "rgb == '0,0,255'"),
    ),
    with_results(
        "simVision.binaryWorkImg",
        28,
        &[
            Float("threshold"),
            Float("share"),
            Float("shareOff"),
            Float("x"),
            Float("xOff"),
            Float("y"),
            Float("yOff"),
            Float("orientation"),
            Float("orientationOff"),
            Float("roundness"),
            Bit("enableTrigger", 4),
        ],
        "Makes pixels white where the intensity is above a threshold, otherwise black. The result is the white \
         fraction, its centre x and y, orientation and roundness; triggers if these are close to the given values.",
        (", 0.3, 1, 0.1, 0.5, 1, 0.5, 1, 0, 7, 0, true", "rgb == '255,255,255' and trigger"),
    ),
    f("simVision.swapWorkImgWithBuffer1", 29, &[], "Swaps the working image with buffer 1.", ("", BLACK)),
    f("simVision.addWorkImgToBuffer1", 30, &[], "Adds the image to buffer 1.", ("", RED)),
    f("simVision.subtractWorkImgFromBuffer1", 31, &[], "Subtracts the image from buffer 1.", ("", RED)),
    with_results(
        "simVision.blobDetectionOnWorkImg",
        34,
        &[Float("threshold"), Float("minSize"), Bit("diffColor", 1), Ignored("overlayColor")],
        "Finds spots above a threshold. The result is their number, 6, then per spot its fraction of the image, \
         orientation, centre x and y, width and height, relative to the image.",
        (", 0.2, 0.1, false", "trigger and sim.unpackFloatTable(packet)[1] == 1"),
    ),
    with_results(
        "simVision.coordinatesFromWorkImg",
        35,
        &[Pair("pointCount"), Bit("evenAngles", 1), Ignored("returnColors")],
        "Returns points of a depth image: their numbers along x and y, then x, y, z and distance of each, in the \
         sensor's frame, or with the flag sim.handleflag_abscoords in the world frame. With returnColors, the third \
         value contains three bytes per point, from buffer 1.",
        (", {2, 1}", "not trigger and #sim.unpackFloatTable(packet) == 10"),
    ),
    with_results(
        "simVision.changedPixelsOnWorkImg",
        36,
        &[Float("threshold")],
        "Makes pixels white where the image differs from buffer 1, otherwise black. The result is the fraction of \
         white pixels.",
        (", 0.2", "trigger"),
    ),
];

/// Flag that scripts add to a handle to request points in the world frame.
const WORLD_FRAME_FLAG: i64 = 0x80_0000;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    // The documentation has one page for functions that transfer images between buffers, and one for the others.
    let moves = |f: &&FilterFunction| {
        f.name.contains("Buffer") || f.name.contains("ensor") || f.name == "simVision.uniformImgToWorkImg"
    };
    offer.subject("images", |offer| FUNCTIONS.iter().filter(moves).for_each(|f| offer_one(offer, f)));
    offer.subject("filters", |offer| FUNCTIONS.iter().filter(|f| !moves(f)).for_each(|f| offer_one(offer, f)));
}

fn offer_one(offer: &mut Offer<Vrep>, function: &'static FilterFunction) {
    let mut command = Cmd::new(function.name, move |c| run(c, function))
        .param(flagged("sensor"))
        .text(function.text)
        .example(example(function));
    for arg in function.args {
        command = command.param(match *arg {
            Float(key) => Param::float(key).optional(),
            // A factor is a single number, not a table.
            Floats(key, 0) => Param::float(key).optional(),
            Floats(key, n) => Param::any(key).optional().text(format!("{n} numbers")),
            Pair(key) => Param::any(key).optional().text("{x, y}"),
            Int(key) => Param::int(key).optional(),
            Bit(key, _) | NotBit(key, _) => Param::any(key).optional().text("true or false"),
            Ignored(key) => Param::any(key).optional(),
        });
    }
    if function.finds {
        command = command
            .returns(Param::bool("trigger").text("whether something was found"))
            .returns(Param::bytes("packet").text("packed 32-bit floats"));
        if function.kind == 35 {
            command = command.returns(Param::bytes("colors").optional().text("three bytes per point"));
        }
    }
    offer.command(match function.kind {
        26 | 27 => command.partial("Supports only red, green and blue: rgbSpace must be true."),
        20 => command.partial("The degree of sharpening is an estimate."),
        28 => command.partial(
            "Roundness is the ratio of the sides of the white spot, which can differ from the value \
                             in V-REP.",
        ),
        34 => command.partial("Nothing is drawn over the image; diffColor colours each spot differently."),
        _ => command,
    });
}

/// Builds an example script that applies a function to a red image and raises an error if the result is not as
/// expected. Functions that load an image are applied to a green image with depths.
fn example(f: &FilterFunction) -> String {
    let ready = match f.kind {
        1 => "sim.setVisionSensorImg(eye, string.char(0, 255, 0):rep(12))",
        2 => "-- An object at 1 m fills the image; planes at 0.01 and 3.5 m: 0.28 of 255.",
        _ => "simVision.uniformImgToWorkImg(eye, {1, 0, 0})",
    };
    let call = format!("{}(eye{})", f.name, f.example.0);
    let call = if f.finds { format!("local trigger, packet = {call}") } else { call };
    format!(
        "local simVision = require 'simVision'\n\
         function sysCall_sensing()\n    \
             local eye = sim.getObject('/working')\n    \
             sim.handleVisionSensor(eye)\n    \
             simVision.uniformImgToWorkImg(eye, {{0, 0, 0}})\n    \
             simVision.workImgToBuffer1(eye)\n    \
             simVision.workImgToBuffer2(eye)\n    \
             {ready}\n    \
             {call}\n    \
             simVision.workImgToSensorImg(eye)\n    \
             local rgb = table.concat({{sim.getVisionSensorImg(eye):byte(1, 3)}}, ',')\n    \
             assert({}, rgb)\n\
         end",
        f.example.1
    )
}

fn run(c: &mut Ctx<'_>, function: &FilterFunction) -> Result {
    let view = VisionView::of(c, 0)?;
    let filter = filter(c, function)?;
    let seen = current_result(c, &view)?;
    let mut work = state(c)?.vision.work.remove(&view.id).filter(|w| (w.columns, w.rows) == (view.columns, view.rows));
    let work = work.get_or_insert_with(|| WorkingImage::new(view.columns, view.rows));
    let mut found = FilterOutput::default();
    let done = {
        // Read from the sensor only the data that the filter uses.
        let rgb = if function.kind == 1 { seen.rgb(c, &view) } else { Default::default() };
        let depth = if function.kind == 2 { seen.depth(c, &view) } else { Default::default() };
        step(&filter, &FilterInput { rgb: &rgb, depth: &depth, lens: view.lens(c) }, work, &mut found)
    };
    let colors = (function.kind == 35 && c.arg(3).truthy()).then(|| colors(work, &filter));
    let work = std::mem::take(work);
    state(c)?.vision.work.insert(view.id, work);
    done?;
    if found.rgb.is_some() || found.depth.is_some() {
        let mut seen = seen;
        seen.rgb = found.rgb.or(seen.rgb);
        seen.depth = found.depth.or(seen.depth);
        store_result(c, &view, seen)?;
    }
    if function.finds {
        let mut packet = found.packets.pop().unwrap_or_default();
        if function.kind == 35 && c.i64(0)? & WORLD_FRAME_FLAG != 0 {
            into_world(&mut packet, &c.world().pose(view.id, 0)?);
        }
        c.ret(found.trigger);
        c.ret(Value::Bytes(packed(&packet.iter().map(|x| *x as f32).collect::<Vec<_>>())));
        if let Some(colors) = colors {
            c.ret(Value::Bytes(colors));
        }
    }
    Ok(())
}

/// Builds the filter for a function, with the values of the call's arguments.
fn filter(c: &Ctx<'_>, function: &FilterFunction) -> Result<VisionFilter> {
    let mut out = VisionFilter { kind: function.kind, options: 1, bytes: vec![0], ..VisionFilter::default() };
    let (mut factor, mut whole) = (None, 0);
    for (i, arg) in function.args.iter().enumerate().map(|(i, a)| (i + 1, *a)) {
        match arg {
            Ignored(_) => {}
            Bit(_, bit) => out.bytes[0] |= if c.arg(i).truthy() { bit } else { 0 },
            NotBit(_, bit) => whole |= if c.arg(i).truthy() { 0 } else { bit },
            Int(_) => out.ints.push(int_or(c, i, 1)?),
            Pair(_) if c.has(i) => out.ints.extend(numbers::<2>(c, i)?.map(|x| x as i64)),
            Float(_) if c.has(i) => out.floats.push(c.f64(i)?),
            Floats(_, 0) if c.has(i) => factor = Some(c.f64(i)?),
            Floats(_, n) if c.has(i) => {
                let all = c.arg(i).numbers().filter(|v| v.len() >= n as usize);
                let all = all.ok_or_else(|| Fail::argument(format!("argument {}: expected {n} numbers", i + 1)))?;
                out.floats.extend(&all[..n as usize]);
            }
            Pair(_) | Float(_) | Floats(..) => {}
        }
    }
    if function.args.iter().any(|a| matches!(a, NotBit(..))) {
        out.ints.push(whole);
    }
    if function.kind == 28 && out.floats.len() > 1 {
        // In a chain, three unused numbers separate the threshold from the expected values.
        out.floats.splice(1..1, [0.0; 3]);
    }
    out.floats.extend(factor);
    Ok(out)
}

/// Returns the colours of the points of a coordinates filter, three bytes each, from buffer 1.
fn colors(work: &WorkingImage, filter: &VisionFilter) -> Vec<u8> {
    let side = |k: usize, n: usize| filter.ints.get(k).map_or(n, |x| (*x).clamp(1, 4096) as usize);
    let (nx, ny) = (side(0, work.columns), side(1, work.rows));
    let mut out = Vec::with_capacity(3 * nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            let (c, r) = ((2 * i + 1) * work.columns / (2 * nx), (2 * j + 1) * work.rows / (2 * ny));
            let pixel = work.buffers[0].get(r * work.columns + c).copied().unwrap_or_default();
            out.extend(pixel.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
    }
    out
}

/// Transforms the points of a packet to the world frame.
fn into_world(packet: &mut [f64], pose: &[f64; 7]) {
    let [px, py, pz, x, y, z, w] = *pose;
    for point in packet.get_mut(2..).unwrap_or_default().chunks_exact_mut(4) {
        let v = [point[0], point[1], point[2]];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let t = cross([x, y, z], v);
        let u = cross([x, y, z], t);
        for (k, p) in [px, py, pz].into_iter().enumerate() {
            point[k] = p + v[k] + 2.0 * (w * t[k] + u[k]);
        }
    }
}
