//! Draws images of cameras: depth as a colour map with a legend, and colours, side by side.

use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use tatu_core::{Reading, ReadingField};
use tatu_plugin_api::safe::Value;

use super::canvas::{Canvas, HPos, RGBColor, VPos, round_step, rounded, title};
use crate::plot::INK_COLOR;

const HEADER_HEIGHT: u32 = 76;
const MARGIN: u32 = 20;
const LEGEND_WIDTH: u32 = 110;
/// Length in pixels up to which the longer side of a small image is enlarged, by an integer factor.
const MIN_IMAGE_SIDE: u32 = 320;
/// Colour of pixels in which nothing was detected.
const NO_HIT_COLOR: [u8; 3] = [40, 40, 44];
/// Colour of pixels in which the depth could not be measured.
const UNMEASURED_COLOR: [u8; 3] = [120, 120, 124];

/// An image with its bottom row first.
struct ImageField<'a> {
    columns: u32,
    rows: u32,
    value: &'a Value,
}

impl<'a> ImageField<'a> {
    /// Returns a field as an image, if its dimensions are [rows, columns] or [rows, columns, each], where `each` is the
    /// number of values per pixel.
    fn of(field: &'a ReadingField, each: usize) -> Option<Self> {
        let [rows, columns, _] = field.dims;
        let len = match &field.value {
            Value::Floats(f) => f.len(),
            Value::Ints(i) => i.len(),
            Value::Bytes(b) => b.len(),
            _ => 0,
        };
        (rows > 0 && columns > 0 && len == rows as usize * columns as usize * each).then_some(ImageField {
            columns,
            rows,
            value: &field.value,
        })
    }

    /// Returns the index of the pixel at column `x` and row `y`, where row 0 is at the top.
    fn at(&self, x: u32, y: u32) -> usize {
        (self.rows - 1 - y) as usize * self.columns as usize + x as usize
    }

    fn scale(&self) -> u32 {
        (MIN_IMAGE_SIDE / self.columns.max(self.rows)).max(1)
    }
}

/// Draws the images of a reading; returns `None` if the reading contains no images.
pub fn draw(reading: &Reading) -> Result<Option<Canvas>, String> {
    let depth = reading.field("depth_image.depth").and_then(|f| ImageField::of(f, 1));
    let color = reading.field("color_image.rgb").and_then(|f| ImageField::of(f, 3));
    let wide = |i: &ImageField<'_>| i.columns * i.scale() + MARGIN;
    let high = |i: &ImageField<'_>| i.rows * i.scale();
    let all = [&depth, &color];
    if all.iter().all(|i| i.is_none()) {
        return Ok(None);
    }
    let width: u32 = MARGIN
        + all.iter().filter_map(|i| i.as_ref()).map(wide).sum::<u32>()
        + depth.as_ref().map_or(0, |_| LEGEND_WIDTH);
    let height = all.iter().filter_map(|i| i.as_ref()).map(high).max().unwrap_or(0);
    let heading = Canvas::width_of(&title(reading), 19.0)?;
    let mut canvas =
        Canvas::new(width.max(heading.ceil() as u32 + 40).max(560), HEADER_HEIGHT + height.max(160) + MARGIN);
    canvas.title(&title(reading))?;
    let (mut x, mut captions) = (MARGIN, Vec::new());
    if let (Some(image), Value::Floats(numbers)) = (&depth, depth.as_ref().map_or(&Value::Nil, |d| d.value)) {
        let seen = |d: f64| d.is_finite() && d > 0.0;
        let (low, high) = numbers
            .iter()
            .copied()
            .filter(|d| seen(*d))
            .fold((f64::INFINITY, 0.0_f64), |(l, h), d| (l.min(d), h.max(d)));
        let (low, high) = if low > high {
            (0.0, 1.0)
        } else if high - low < 1e-9 {
            (low * 0.9, low * 1.1)
        } else {
            (low, high)
        };
        let color = |d: f64| shade((d - low) / (high - low));
        let paint = |u: u32, v: u32| {
            let d = numbers[image.at(u, v)];
            match d {
                d if seen(d) => color(d),
                0.0 => UNMEASURED_COLOR,
                _ => NO_HIT_COLOR,
            }
        };
        canvas.image((x, HEADER_HEIGHT), [image.columns, image.rows], image.scale(), paint);
        x += image.columns * image.scale();
        let bar = (image.rows * image.scale()).max(160);
        canvas.image((x + 14, HEADER_HEIGHT), [18, bar], 1, |_, v| {
            color(low + (high - low) * f64::from(v) / f64::from(bar - 1).max(1.0))
        });
        let step = round_step((high - low) / 8.0);
        let first = (low / step).ceil() as i64;
        for d in (first..).map(|i| i as f64 * step).take_while(|d| *d <= high + 1e-9) {
            let y = f64::from(HEADER_HEIGHT) + f64::from(bar) * (d - low) / (high - low);
            canvas.lines(&[[(f64::from(x) + 32.0, y), (f64::from(x) + 37.0, y)]], INK_COLOR, 0.5)?;
            let label = format!("{} m", rounded(d, step));
            canvas.text((f64::from(x) + 41.0, y), &label, 13.0, (HPos::Left, VPos::Center))?;
        }
        let share = |wanted: &dyn Fn(f64) -> bool| {
            100.0 * numbers.iter().filter(|d| wanted(**d)).count() as f64 / numbers.len().max(1) as f64
        };
        let mut text = format!("depth {} x {}, {low:.3} m to {high:.3} m", image.columns, image.rows);
        for (what, share) in [("see nothing", share(&|d| d.is_infinite())), ("not measured", share(&|d| d == 0.0))] {
            if share > 0.0 {
                text += &format!(", {share:.1} % {what}");
            }
        }
        captions.push(text);
        x += LEGEND_WIDTH + MARGIN;
    }
    if let (Some(image), Some(numbers)) = (&color, color.as_ref().and_then(|c| bytes(c.value))) {
        let pixel = |u: u32, v: u32| {
            let i = image.at(u, v) * 3;
            [numbers[i], numbers[i + 1], numbers[i + 2]]
        };
        canvas.image((x, HEADER_HEIGHT), [image.columns, image.rows], image.scale(), pixel);
        captions.push(format!("colours {} x {}", image.columns, image.rows));
    }
    canvas.text((20.0, 52.0), &captions.join("; "), 15.0, (HPos::Left, VPos::Center))?;
    Ok(Some(canvas))
}

fn bytes(value: &Value) -> Option<Vec<u8>> {
    match value {
        Value::Bytes(b) => Some(b.to_vec()),
        Value::Ints(i) => Some(i.iter().map(|x| *x as u8).collect()),
        Value::Floats(f) => Some(f.iter().map(|x| *x as u8).collect()),
        _ => None,
    }
}

/// Maps a share of the depth range, 0 to 1, to a colour of a perceptually uniform map, in which near is bright.
fn shade(share: f64) -> [u8; 3] {
    let RGBColor(r, g, b) = ViridisRGB.get_color(1.0 - share.clamp(0.0, 1.0));
    [r, g, b]
}
