//! Combines images of six sensors that face all directions into a single image whose columns and rows are angles.

use super::{handle::take_image, results::VisionResult, set::apply_image, view::VisionView, work::ImageProjection};
use crate::kit::*;

/// Minimum horizontal and vertical angle of the image, rad.
const MIN_ANGLE_RAD: f64 = 0.087;

/// Source of a pixel of the panorama: the sensor, the pixel in its image, and the ratio of distance to depth at this
/// pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PixelSource {
    sensor: usize,
    pixel: usize,
    slant: f64,
}

/// A sensor whose image is a source: its axes in the frame of the first sensor, its projection, and its resolution.
struct PanoramaSensor {
    axes: [[f64; 3]; 3],
    lens: ImageProjection,
    size: [usize; 2],
}

/// Returns the axes of one frame, expressed in another frame; both are given as poses.
fn axes([.., x, y, z, w]: &[f64; 7], seen_from: &[f64; 7]) -> [[f64; 3]; 3] {
    let [.., a, b, c, d] = *seen_from;
    // The rotation from one frame to the other: the inverse of the first quaternion times the second.
    let q = [
        d * x - a * w - b * z + c * y,
        d * y + a * z - b * w - c * x,
        d * z - a * y + b * x - c * w,
        d * w + a * x + b * y + c * z,
    ];
    let [x, y, z, w] = q;
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Finds the source for a direction, which is in the image of the sensor with the closest viewing direction. Among
/// equally close sensors, the first is selected. Returns `None` if no sensor covers the direction.
fn source(eyes: &[PanoramaSensor], direction: &[f64; 3]) -> Option<PixelSource> {
    let ahead = |eye: &PanoramaSensor| dot(&eye.axes[2], direction);
    let mut best = None;
    // Directions outside the view of all sensors have no source; the tolerance covers rounding errors.
    let mut z = 1e-9;
    for (n, eye) in eyes.iter().enumerate() {
        if ahead(eye) > z + 1e-9 {
            (best, z) = (Some((n, eye)), ahead(eye));
        }
    }
    let (sensor, eye) = best?;
    let [fx, fy, cx, cy] = eye.lens.intrinsics;
    let nearest = |place: f64, side: usize| (place.round().max(0.0) as usize).min(side.saturating_sub(1));
    // The sensor's x axis points left in its image, y up, towards higher rows.
    let column = nearest(cx - fx * dot(&eye.axes[0], direction) / z, eye.size[0]);
    let row = nearest(cy + fy * dot(&eye.axes[1], direction) / z, eye.size[1]);
    Some(PixelSource { sensor, pixel: row * eye.size[0] + column, slant: 1.0 / z })
}

/// Returns the sources of the pixels of an image whose columns and rows divide the angles `across` and `up` evenly,
/// from left to right and bottom to top.
fn sources(eyes: &[PanoramaSensor], [columns, rows]: [usize; 2], [across, up]: [f64; 2]) -> Vec<Option<PixelSource>> {
    let angle = |i: usize, n: usize, whole: f64| if n < 2 { 0.0 } else { whole * (i as f64 / (n - 1) as f64 - 0.5) };
    let mut out = Vec::with_capacity(columns * rows);
    for j in 0..rows {
        let (sin_up, cos_up) = libm::sincos(angle(j, rows, up));
        for i in 0..columns {
            let (sin, cos) = libm::sincos(angle(i, columns, across));
            out.push(source(eyes, &[-sin * cos_up, sin_up, cos * cos_up]));
        }
    }
    out
}

fn run(c: &mut Ctx<'_>) -> Result {
    let own =
        |c: &Ctx<'_>, i: usize| if c.has(i) && c.i64(i)? != -1 { VisionView::of(c, i).map(Some) } else { Ok(None) };
    let (color, depth) = (own(c, 0)?, own(c, 4)?);
    let Some(first) = color.or(depth) else {
        return Err(Fail::argument("arguments 1 and 5: at least one of them must be a sensor, but both are -1"));
    };
    if let (Some(a), Some(b)) = (color, depth)
        && (a.columns, a.rows) != (b.columns, b.rows)
    {
        let text = format!(
            "the sensor for colours has {} x {} pixels, but the sensor for depths has {} x {}: expected equal sizes",
            a.columns, a.rows, b.columns, b.rows
        );
        return Err(Fail::argument(text));
    }
    let handles: [f64; 6] = numbers(c, 1)?;
    let angles = [(2, std::f64::consts::TAU), (3, std::f64::consts::PI)].map(|(i, most)| -> Result<f64> {
        let angle = c.f64(i)?;
        if angle.is_nan() {
            return Err(Fail::argument(format!("argument {}: expected an angle in rad, found NaN", i + 1)));
        }
        Ok(angle.clamp(MIN_ANGLE_RAD, most))
    });
    let [across, up] = angles;
    let mut views = Vec::new();
    for handle in handles {
        let found = c.world().look((handle as i64 & HANDLE_BITS) as u64);
        let found = found.map_err(|_| Fail::missing(format!("argument 2: there is no object {handle}")))?;
        views.push(VisionView::of_object(c, found)?);
    }
    let front = c.world().pose(views[0].id, 0)?;
    let mut eyes = Vec::new();
    for view in &views {
        let axes = axes(&c.world().pose(view.id, 0)?, &front);
        eyes.push(PanoramaSensor { axes, lens: view.lens(c), size: [view.columns, view.rows] });
    }
    let sources = sources(&eyes, [first.columns, first.rows], [across?, up?]);
    // Take images only with the sensors that are sources of pixels.
    let mut taken: Vec<Option<(VisionView, VisionResult)>> = Vec::new();
    for (n, view) in views.iter().enumerate() {
        let needed = sources.iter().flatten().any(|s| s.sensor == n);
        taken.push(if needed { Some(take_image(c, view.id, 0)?) } else { None });
    }
    if let Some(view) = color {
        let images: Vec<_> = taken.iter().map(|t| t.as_ref().map(|(v, seen)| seen.rgb(c, v).into_owned())).collect();
        let pixel =
            |s: &PixelSource| images[s.sensor].as_ref().and_then(|rgb| rgb.as_chunks::<3>().0.get(s.pixel).copied());
        let rgb = sources.iter().flat_map(|s| s.as_ref().and_then(pixel).unwrap_or([0; 3])).collect();
        apply_image(c, &view, rgb, None)?;
    }
    if let Some(view) = depth {
        let images: Vec<_> = taken.iter().map(|t| t.as_ref().map(|(v, seen)| seen.depth(c, v).into_owned())).collect();
        let [near, far] = views[0].planes;
        let grey = |s: &PixelSource| {
            let depth = f64::from(*images[s.sensor].as_ref()?.get(s.pixel)?);
            let along = (near + depth * (far - near)) * s.slant;
            let part = if far > near { (along - near) / (far - near) } else { 1.0 };
            Some((part.clamp(0.0, 1.0) * 255.0).round() as u8)
        };
        let rgb = sources.iter().flat_map(|s| [s.as_ref().and_then(grey).unwrap_or(255); 3]).collect();
        apply_image(c, &view, rgb, None)?;
    }
    c.ret(1_i64);
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.subject("images", |offer| {
        offer.command(
            Cmd::new("simVision.handleSpherical", run)
                .param(Param::int("rgbSensor").text("the sensor that receives the panorama; -1: none"))
                .param(table("sensors", "six handles: front, top, back, bottom, left, right"))
                .param(Param::float("horizontalAngle").unit("rad").text("0.087 to 2 pi"))
                .param(Param::float("verticalAngle").unit("rad").text("0.087 to pi"))
                .param(Param::int("depthSensor").default(-1).optional().text(
                    "the sensor that receives the distances, in grey: near plane to far plane of the \
                               front sensor",
                ))
                .returns(Param::int("result").text("1"))
                .text(
                    "Takes images with six sensors at the same position and combines them: columns are angles from \
                     left to right, rows from bottom to top, relative to the front sensor.",
                )
                .partial(
                    "The direction that each sensor covers is determined by its pose, not by the order of the handles; \
                     lights are not changed.",
                )
                .example(
                    "local simVision = require 'simVision'\n\
                     local eye, out = sim.getObject('/eye'), sim.getObject('/working')\n\
                     assert(simVision.handleSpherical(out, {eye, eye, eye, eye, eye, eye}, 1, 1, -1) == 1)",
                ),
        );
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four columns and rows at 90 degrees: the focal length is half a side.
    fn eye(pose: [f64; 7]) -> PanoramaSensor {
        let lens = ImageProjection { intrinsics: [2.0, 2.0, 1.5, 1.5], parallel: false, planes: [0.1, 10.0] };
        PanoramaSensor { axes: axes(&pose, &FRONT), lens, size: [4, 4] }
    }
    /// A pose rotated by 120 degrees about (1, 1, 1), to check that directions are relative to the front sensor.
    const FRONT: [f64; 7] = [0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5];

    /// Returns a frame rotated from the front one by +90 or -90 degrees about one of its axes.
    fn rotated_frame(axis: usize, sign: f64) -> [f64; 7] {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut q = [0.0, 0.0, 0.0, half];
        q[axis] = sign * half;
        let ([a, b, c, d], [x, y, z, w]) = ([0.5; 4], q);
        [
            0.0,
            0.0,
            0.0,
            d * x + a * w + b * z - c * y,
            d * y - a * z + b * w + c * x,
            d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z,
        ]
    }

    #[test]
    fn direction_is_sampled_from_the_sensor_facing_it() {
        // Left is +x of the front sensor: a positive rotation about y, which is up.
        let eyes = [eye(FRONT), eye(rotated_frame(0, -1.0)), eye(rotated_frame(1, 1.0)), eye(rotated_frame(1, -1.0))];
        let of = |d: [f64; 3]| source(&eyes, &d).map(|s| s.sensor);
        assert_eq!(of([0.0, 0.0, 1.0]), Some(0));
        assert_eq!(of([0.0, 1.0, 0.0]), Some(1));
        assert_eq!(of([1.0, 0.0, 0.0]), Some(2));
        assert_eq!(of([-1.0, 0.0, 0.0]), Some(3));
        // No sensor faces down or back.
        assert_eq!(of([0.0, -1.0, 0.0]), None);
        assert_eq!(of([0.0, 0.0, -1.0]), None);
    }

    #[test]
    fn columns_and_rows_are_angles() {
        // 90 degrees across and 0 degrees up: the middle row, from the first column to the last.
        let eyes = [eye(FRONT)];
        let right_angle = std::f64::consts::FRAC_PI_2;
        let all = sources(&eyes, [5, 1], [right_angle, 1.0]);
        let pixels: Vec<usize> = all.iter().map(|s| s.unwrap().pixel % 4).collect();
        // Columns 1.5 + 2 tan(-45, -22.5, 0, 22.5, 45 degrees): -0.5, 0.67, 1.5, 2.33, 3.5.
        assert_eq!(pixels, [0, 1, 2, 2, 3]);
        // At 45 degrees the distance to a point is sqrt(2) times its depth.
        assert!((all[0].unwrap().slant - std::f64::consts::SQRT_2).abs() < 1e-12);
        let rows = sources(&eyes, [1, 3], [1.0, right_angle]);
        let rows: Vec<usize> = rows.iter().map(|s| s.unwrap().pixel / 4).collect();
        assert_eq!(rows, [0, 2, 3]);
    }
}
