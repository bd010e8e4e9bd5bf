//! Plots a scan seen from above, with the forward direction of the sensor pointing up.

use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use tatu_core::Reading;

use super::canvas::{Canvas, CanvasPoint, HPos, RGBColor, VPos, round_step, rounded, title};
use crate::plot::GRID_COLOR;

const PLOT_SIZE: u32 = 800;
const HEADER_HEIGHT: u32 = 76;
const MARGIN: f64 = 40.0;
const FREE_COLOR: RGBColor = RGBColor(232, 241, 250);
const BEAM_COLOR: RGBColor = RGBColor(205, 222, 240);
const POINT_COLOR: RGBColor = RGBColor(200, 40, 40);
const SENSOR_COLOR: RGBColor = RGBColor(40, 44, 52);

/// Plots a reading that contains distances along beams; returns `None` for other readings.
pub fn draw(reading: &Reading) -> Result<Option<Canvas>, String> {
    let (Some(distances), Some(angles)) = (reading.floats("range_scan.distance"), reading.floats("range_scan.angle"))
    else {
        return Ok(None);
    };
    let limits = reading.floats("range_scan.limits").unwrap_or(&[]);
    let farthest = limits.get(1).copied().filter(|x| x.is_finite() && *x > 0.0);
    // Seen from above, inclined beams appear shorter.
    let rise = reading.floats("range_scan.elevation").unwrap_or(&[]);
    let layered = rise.iter().any(|e| *e != 0.0);
    let flat = |i: usize, d: f64| d * rise.get(i).map_or(1.0, |e| libm::cos(*e));
    let beams: Vec<(f64, f64)> =
        angles.iter().copied().zip(distances.iter().enumerate().map(|(i, d)| flat(i, *d))).collect();
    let hit = |d: f64| d.is_finite() && d > 0.0;
    let hits: Vec<(f64, f64)> = beams.iter().copied().filter(|(_, d)| hit(*d)).collect();
    let seen = hits.iter().fold(0.0_f64, |m, (_, d)| m.max(*d));
    // Beams without a hit are drawn a little beyond the farthest hit, or to the sensor's range.
    let shown =
        if seen > 0.0 { seen * if hits.len() < beams.len() { 1.15 } else { 1.0 } } else { farthest.unwrap_or(1.0) };
    let shown = farthest.map_or(shown, |f| shown.min(f)).max(1e-3);
    let end = |d: f64| if hit(d) { d.min(shown) } else { shown };

    let mut canvas = Canvas::new(PLOT_SIZE, PLOT_SIZE + HEADER_HEIGHT);
    // Coordinates in the picture, m, rightwards and downwards; the plot must contain the sensor and all ends of beams.
    let place = |(a, d): &(f64, f64)| (-end(*d) * libm::sin(*a), -end(*d) * libm::cos(*a));
    let (mut low, mut high) = ((0.0_f64, 0.0_f64), (0.0_f64, 0.0_f64));
    for (x, y) in beams.iter().map(place) {
        low = (low.0.min(x), low.1.min(y));
        high = (high.0.max(x), high.1.max(y));
    }
    let wide = (high.0 - low.0).max(high.1 - low.1).max(1e-3);
    let scale = (f64::from(PLOT_SIZE) - 2.0 * MARGIN) / wide;
    let middle: CanvasPoint = (
        f64::from(PLOT_SIZE) / 2.0 - scale * (low.0 + high.0) / 2.0,
        f64::from(HEADER_HEIGHT) + f64::from(PLOT_SIZE) / 2.0 - scale * (low.1 + high.1) / 2.0,
    );
    // A point to the left of the sensor is on the left in the picture.
    let at = |angle: f64, d: f64| (middle.0 - scale * d * libm::sin(angle), middle.1 - scale * d * libm::cos(angle));

    if !layered {
        let mut outline = vec![middle];
        outline.extend(beams.iter().map(|(a, d)| at(*a, end(*d))));
        canvas.fill(&outline, FREE_COLOR)?;
        let rays: Vec<[CanvasPoint; 2]> = thinned(&hits).map(|(a, d)| [middle, at(*a, d.min(shown))]).collect();
        canvas.lines(&rays, BEAM_COLOR, 0.5)?;
    }
    let mut heights = String::new();
    let step = round_step(wide / 6.0);
    let rings = (1..).map(|i| f64::from(i) * step).take_while(|r| *r <= 1.5 * wide);
    for r in rings {
        canvas.ring(middle, r * scale, GRID_COLOR)?;
        let label = format!("{} m", rounded(r, step));
        canvas.text((middle.0 + 4.0, middle.1 - r * scale - 8.0), &label, 13.0, (HPos::Left, VPos::Center))?;
    }
    let (bottom, right) = (f64::from(PLOT_SIZE + HEADER_HEIGHT), f64::from(PLOT_SIZE));
    canvas.lines(
        &[[(middle.0, f64::from(HEADER_HEIGHT)), (middle.0, bottom)], [(0.0, middle.1), (right, middle.1)]],
        GRID_COLOR,
        0.5,
    )?;
    if layered {
        // Higher points are brighter.
        let high = |i: usize| distances[i] * rise.get(i).map_or(0.0, |e| libm::sin(*e));
        let seen = |i: &usize| hit(beams[*i].1);
        let all = (0..beams.len()).filter(seen);
        let (low, top) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, t), i| (l.min(high(i)), t.max(high(i))));
        for (i, (a, d)) in beams.iter().enumerate().filter(|(i, (_, d))| seen(i) && *d <= shown) {
            let RGBColor(r, g, b) = ViridisRGB.get_color((high(i) - low) / (top - low).max(1e-9) * 0.9);
            canvas.dots(&[at(*a, *d)], 1.5, RGBColor(r, g, b))?;
        }
        if low <= top {
            heights = format!("; height {low:.2} m to {top:.2} m, brighter is higher");
        }
    } else {
        let points: Vec<CanvasPoint> = hits.iter().filter(|(_, d)| *d <= shown).map(|(a, d)| at(*a, *d)).collect();
        canvas.dots(&points, 1.5, POINT_COLOR)?;
    }
    let nose = |dx: f64, dy: f64| (middle.0 + dx, middle.1 + dy);
    canvas.fill(&[nose(0.0, -9.0), nose(6.0, 6.0), nose(-6.0, 6.0)], SENSOR_COLOR)?;

    canvas.fill(
        &[(0.0, 0.0), (right, 0.0), (right, f64::from(HEADER_HEIGHT) - 4.0), (0.0, f64::from(HEADER_HEIGHT) - 4.0)],
        RGBColor(255, 255, 255),
    )?;
    canvas.title(&title(reading))?;
    let mut line = format!("{} beams, {} hits", beams.len(), hits.len());
    let nearest = hits.iter().map(|(_, d)| *d).min_by(f64::total_cmp);
    if let Some(nearest) = nearest {
        line += &format!(", {nearest:.3} m to {seen:.3} m");
    }
    if let Some(farthest) = farthest {
        line += &format!("; range {farthest} m");
    }
    canvas.text((20.0, 52.0), &(line + &heights), 15.0, (HPos::Left, VPos::Center))?;
    Ok(Some(canvas))
}

/// Returns at most `MAX_DRAWN_BEAMS` points, evenly spaced: more could not be distinguished in the picture.
fn thinned(hits: &[(f64, f64)]) -> impl Iterator<Item = &(f64, f64)> {
    hits.iter().step_by(hits.len().div_ceil(MAX_DRAWN_BEAMS).max(1))
}

const MAX_DRAWN_BEAMS: usize = 180;
