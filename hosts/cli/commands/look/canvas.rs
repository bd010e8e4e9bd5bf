//! A canvas for plots of sensor readings, drawn at twice the resolution of the picture for smooth edges.

use plotters::{coord::Shift, prelude::*, style::text_anchor::Pos};
use tatu_core::Reading;
use tatu_render::Picture;

use crate::plot::{INK_COLOR, register_fonts};

pub use plotters::style::{
    RGBColor,
    text_anchor::{HPos, VPos},
};

/// Pixels of the canvas per pixel of the picture, along each side.
const OVERSAMPLING: u32 = 2;

/// A canvas; positions are in pixels of the picture, measured from its upper left corner.
pub struct Canvas {
    columns: u32,
    rows: u32,
    rgb: Vec<u8>,
}

type DrawResult = Result<(), String>;
/// A position on a canvas.
pub type CanvasPoint = (f64, f64);

impl Canvas {
    /// Creates a white canvas.
    pub fn new(columns: u32, rows: u32) -> Self {
        register_fonts();
        let bytes = (columns * OVERSAMPLING) as usize * (rows * OVERSAMPLING) as usize * 3;
        Canvas { columns, rows, rgb: vec![255; bytes] }
    }

    fn draw_on<E: std::fmt::Display>(
        &mut self,
        f: impl Fn(&DrawingArea<BitMapBackend<'_>, Shift>) -> Result<(), E>,
    ) -> DrawResult {
        let size = (self.columns * OVERSAMPLING, self.rows * OVERSAMPLING);
        let area = BitMapBackend::with_buffer(&mut self.rgb, size).into_drawing_area();
        f(&area).map_err(|e| e.to_string())?;
        area.present().map_err(|e| e.to_string())
    }

    /// Draws a line through points.
    pub fn path(&mut self, points: &[CanvasPoint], color: RGBColor, width: f64) -> DrawResult {
        let points: Vec<_> = points.iter().map(to_canvas_pixel).collect();
        let style = color.stroke_width((width * f64::from(OVERSAMPLING)).round() as u32);
        self.draw_on(|area| area.draw(&PathElement::new(points.clone(), style)))
    }

    /// Draws separate lines, each between two points.
    pub fn lines(&mut self, lines: &[[CanvasPoint; 2]], color: RGBColor, width: f64) -> DrawResult {
        let style = color.stroke_width((width * f64::from(OVERSAMPLING)).round() as u32);
        self.draw_on(|area| {
            lines.iter().try_for_each(|l| area.draw(&PathElement::new(l.map(|p| to_canvas_pixel(&p)).to_vec(), style)))
        })
    }

    /// Draws a filled polygon.
    pub fn fill(&mut self, points: &[CanvasPoint], color: RGBColor) -> DrawResult {
        let points: Vec<_> = points.iter().map(to_canvas_pixel).collect();
        self.draw_on(|area| area.draw(&Polygon::new(points.clone(), color.filled())))
    }

    /// Draws filled discs.
    pub fn dots(&mut self, points: &[CanvasPoint], radius: f64, color: RGBColor) -> DrawResult {
        let radius = (radius * f64::from(OVERSAMPLING)).round() as i32;
        self.draw_on(|area| {
            points.iter().try_for_each(|p| area.draw(&Circle::new(to_canvas_pixel(p), radius, color.filled())))
        })
    }

    /// Draws a circle.
    pub fn ring(&mut self, middle: CanvasPoint, radius: f64, color: RGBColor) -> DrawResult {
        let point = |i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 180.0;
            (middle.0 + radius * libm::cos(angle), middle.1 + radius * libm::sin(angle))
        };
        self.path(&(0..=180).map(point).collect::<Vec<_>>(), color, 0.5)
    }

    /// Draws text, anchored at a position; `height` is in pixels of the picture.
    pub fn text(&mut self, at: CanvasPoint, text: &str, height: f64, anchor: (HPos, VPos)) -> DrawResult {
        let style = ("sans-serif", height * f64::from(OVERSAMPLING))
            .into_font()
            .color(&INK_COLOR)
            .pos(Pos::new(anchor.0, anchor.1));
        self.draw_on(|area| area.draw(&Text::new(text.to_owned(), to_canvas_pixel(&at), style.clone())))
    }

    /// Returns the width of a text of this height, in pixels of the picture.
    pub fn width_of(text: &str, height: f64) -> Result<f64, String> {
        register_fonts();
        let font = ("sans-serif", height).into_font();
        font.box_size(text).map(|(w, _)| f64::from(w)).map_err(|e| e.to_string())
    }

    /// Draws a title at the top.
    pub fn title(&mut self, text: &str) -> DrawResult {
        self.text((20.0, 24.0), text, 19.0, (HPos::Left, VPos::Center))
    }

    /// Draws an image, top row first, with each pixel enlarged to a square.
    pub fn image(
        &mut self,
        (x, y): (u32, u32),
        [columns, rows]: [u32; 2],
        scale: u32,
        pixel: impl Fn(u32, u32) -> [u8; 3],
    ) {
        let side = scale * OVERSAMPLING;
        for v in 0..(rows * side).min((self.rows.saturating_sub(y)) * OVERSAMPLING) {
            for u in 0..(columns * side).min((self.columns.saturating_sub(x)) * OVERSAMPLING) {
                let at = ((y * OVERSAMPLING + v) as usize * (self.columns * OVERSAMPLING) as usize
                    + (x * OVERSAMPLING + u) as usize)
                    * 3;
                self.rgb[at..at + 3].copy_from_slice(&pixel(u / side, v / side));
            }
        }
    }

    /// Copies a picture onto the canvas, with its upper left corner at a position.
    pub fn put(&mut self, at: (u32, u32), picture: &Picture) {
        let pixel = |x: u32, y: u32| {
            let i = (y as usize * picture.columns as usize + x as usize) * 3;
            [picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]]
        };
        self.image(at, [picture.columns, picture.rows], 1, pixel);
    }

    /// Returns the canvas scaled down to the resolution of the picture.
    pub fn picture(&self) -> Picture {
        let wide = (self.columns * OVERSAMPLING) as usize;
        let mut rgb = Vec::with_capacity(self.columns as usize * self.rows as usize * 3);
        for y in 0..self.rows as usize {
            for x in 0..self.columns as usize {
                for c in 0..3 {
                    let fine = |u: usize, v: usize| u32::from(self.rgb[((y * 2 + v) * wide + x * 2 + u) * 3 + c]);
                    let sum = fine(0, 0) + fine(1, 0) + fine(0, 1) + fine(1, 1);
                    rgb.push(((sum + 2) / (OVERSAMPLING * OVERSAMPLING)) as u8);
                }
            }
        }
        Picture { columns: self.columns, rows: self.rows, rgb }
    }
}

fn to_canvas_pixel(p: &CanvasPoint) -> (i32, i32) {
    let to = |x: f64| (x * f64::from(OVERSAMPLING)).round().clamp(-1e6, 1e6) as i32;
    (to(p.0), to(p.1))
}

/// Returns a round number: the smallest value of the form 1, 2 or 5 times a power of ten that is at least `x`.
pub fn round_step(x: f64) -> f64 {
    let power = libm::exp10(libm::log10(x.max(1e-9)).floor());
    [1.0, 2.0, 5.0].into_iter().map(|f| f * power).find(|s| *s >= x * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// Formats a number with as many decimals as are needed to distinguish values that are `step` apart.
pub fn rounded(x: f64, step: f64) -> String {
    let digits = (-libm::log10(step).floor()).clamp(0.0, 6.0) as usize;
    format!("{x:.digits$}")
}

/// Returns the title of a picture: the sensor, and the time of its reading.
pub fn title(reading: &Reading) -> String {
    format!("{}  ({})  at {:.3} s", reading.path, reading.kind, reading.time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_steps_are_round_numbers() {
        let all = [0.013, 0.02, 0.3, 1.0, 1.1, 4.0, 70.0].map(round_step);
        let wanted = [0.02, 0.02, 0.5, 1.0, 2.0, 5.0, 100.0];
        assert!(all.iter().zip(wanted).all(|(a, w)| (a - w).abs() < 1e-9 * w), "{all:?}");
        assert_eq!([rounded(1.0, 0.5), rounded(0.02, 0.02), rounded(40.0, 20.0)], ["1.0", "0.02", "40"]);
    }
}
