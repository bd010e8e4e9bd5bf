//! Draws pictures of graphs: a panel over time for each unit of the streams, and a panel for curves in the x-y plane.

use std::{ops::Range, path::Path, sync::Once};

use plotters::{coord::Shift, prelude::*, style::register_font};
use tatu_core::Graph;

/// Width of the picture, and height of a panel, pixels.
const PICTURE_WIDTH: u32 = 880;
const PANEL_HEIGHT: u32 = 360;
const TITLE_HEIGHT: u32 = 44;
/// Height of a row of the legend, pixels.
const LEGEND_ROW_HEIGHT: i32 = 22;
/// Maximum number of panels of streams; if there are more units, the remaining ones share the last of these panels.
const MAX_STREAM_PANELS: usize = 4;
/// Maximum number of lines in a panel with a legend; a longer legend would cover the lines, and is omitted.
const MAX_LEGEND_LINES: usize = 16;

/// Colour of text and frames.
pub const INK_COLOR: RGBColor = RGBColor(40, 44, 52);
/// Colour of grid lines.
pub const GRID_COLOR: RGBColor = RGBColor(214, 218, 224);

/// A line of a panel.
struct PanelLine {
    name: String,
    color: RGBColor,
    points: Vec<(f64, f64)>,
}

/// The content of one pair of axes.
struct Panel {
    x: String,
    y: String,
    lines: Vec<PanelLine>,
    /// Whether both axes have the same scale.
    equal_scales: bool,
}

fn rgb(c: [f64; 3]) -> RGBColor {
    let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    RGBColor(byte(c[0]), byte(c[1]), byte(c[2]))
}

fn label(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// Returns the panels of a graph. Streams whose samples were all taken at the same time are plotted against the sample
/// index, unless curves show them.
fn panels(graph: &Graph) -> Vec<Panel> {
    let mut out: Vec<Panel> = Vec::new();
    let times: Vec<f64> = graph.times.iter().copied().collect();
    let at_once = times.len() > 1 && times.iter().all(|t| *t == times[0]);
    let all = !at_once || graph.curves.is_empty();
    let shown = graph.streams.iter().filter(|s| all && !s.spec.hidden);
    let mut units: Vec<String> = Vec::new();
    for s in shown {
        let x = |i: usize| if at_once { i as f64 } else { times[i] };
        let points = s.values.iter().enumerate().map(|(i, v)| (x(i), *v)).collect();
        let found = units.iter().position(|u| *u == s.spec.unit);
        let at = found.unwrap_or(units.len()).min(MAX_STREAM_PANELS - 1);
        if at == units.len() {
            units.push(s.spec.unit.clone());
            let x = if at_once { "sample".into() } else { "time [s]".into() };
            out.push(Panel { x, y: label("", &s.spec.unit).trim().into(), lines: Vec::new(), equal_scales: false });
        }
        let strange = units[at] != s.spec.unit;
        if strange {
            out[at].y.clear();
        }
        let name = if strange { label(&s.spec.name, &s.spec.unit) } else { s.spec.name.clone() };
        out[at].lines.push(PanelLine { name, color: rgb(s.color), points });
    }
    let curves = graph.curves.iter().map(|c| {
        let points = graph.points(c).iter().map(|p| (p[0], p.get(1).copied().unwrap_or(f64::NAN))).collect();
        let seen = if c.spec.axes.len() > 2 { " (from above)" } else { "" };
        PanelLine { name: format!("{}{seen}", c.spec.name), color: rgb(c.color), points }
    });
    let lines: Vec<PanelLine> = curves.collect();
    if let Some(first) = graph.curves.first() {
        let unit = &first.spec.unit;
        let even = graph.curves.iter().all(|c| c.spec.unit == *unit);
        let unit = if even { unit.as_str() } else { "" };
        out.push(Panel { x: label("x", unit), y: label("y", unit), lines, equal_scales: even });
    }
    out
}

/// Returns the range of the finite numbers, extended on both sides by the share `room` of its width.
fn range(numbers: impl Iterator<Item = f64>, room: f64) -> Range<f64> {
    let (low, high) = numbers
        .filter(|x| x.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if low > high {
        return 0.0..1.0;
    }
    let least = 1e-9 * low.abs().max(high.abs()).max(1e-3);
    if high - low <= least {
        let around = if low == 0.0 { 1.0 } else { low.abs() * 0.1 };
        return low - around..high + around;
    }
    let more = (high - low) * room;
    low - more..high + more
}

/// Extends one of two ranges, so that both have the same scale on an area of this size in pixels.
fn equalized(x: Range<f64>, y: Range<f64>, (wide, high): (f64, f64)) -> (Range<f64>, Range<f64>) {
    let scale = ((x.end - x.start) / wide).max((y.end - y.start) / high);
    let grown = |r: Range<f64>, pixels: f64| {
        let (middle, half) = ((r.start + r.end) / 2.0, scale * pixels / 2.0);
        middle - half..middle + half
    };
    (grown(x, wide), grown(y, high))
}

/// Registers the font for "sans-serif".
pub fn register_fonts() {
    static FONT: Once = Once::new();
    FONT.call_once(|| {
        // The font is embedded in the program; if it were invalid, drawing would fail with an error.
        let _ = register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    });
}

/// Draws a graph and writes the picture.
pub fn draw(graph: &Graph, file: &Path) -> Result<(), String> {
    register_fonts();
    let mut panels = panels(graph);
    if panels.is_empty() {
        panels.push(Panel { x: "time [s]".into(), y: String::new(), lines: Vec::new(), equal_scales: false });
    }
    let high = TITLE_HEIGHT + PANEL_HEIGHT * panels.len() as u32;
    let picture = BitMapBackend::new(file, (PICTURE_WIDTH, high)).into_drawing_area();
    draw_all(&picture, graph, &panels).map_err(|e| e.to_string())?;
    picture.present().map_err(|e| e.to_string())
}

type DrawError = Box<dyn std::error::Error>;
type PlotArea<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

fn draw_all(picture: &PlotArea<'_>, graph: &Graph, panels: &[Panel]) -> Result<(), DrawError> {
    picture.fill(&WHITE)?;
    let (title, rest) = picture.split_vertically(TITLE_HEIGHT);
    let style = ("sans-serif", 24).into_font().color(&INK_COLOR);
    title.draw(&Text::new(graph.name.clone(), (24, 14), style))?;
    for (area, panel) in rest.split_evenly((panels.len(), 1)).iter().zip(panels) {
        draw_panel(area, panel)?;
    }
    Ok(())
}

/// Draws the legend above a panel; returns the number of rows of the legend.
fn draw_names(area: &PlotArea<'_>, lines: &[PanelLine], left: i32) -> Result<i32, DrawError> {
    if !(1..=MAX_LEGEND_LINES).contains(&lines.len()) {
        return Ok(0);
    }
    let style = ("sans-serif", 16).into_font().color(&INK_COLOR);
    let (mut x, mut row) = (left, 0);
    for line in lines {
        let wide = 26 + area.estimate_text_size(&line.name, &style)?.0 as i32 + 22;
        if x > left && x + wide > PICTURE_WIDTH as i32 {
            (x, row) = (left, row + 1);
        }
        let y = row * LEGEND_ROW_HEIGHT + LEGEND_ROW_HEIGHT / 2;
        area.draw(&Rectangle::new([(x, y - 1), (x + 18, y + 2)], line.color.filled()))?;
        area.draw(&Text::new(line.name.clone(), (x + 26, y - 6), style.clone()))?;
        x += wide;
    }
    Ok(row + 1)
}

/// Formats the label of a tick with as many digits as the range of the axis requires, and without "-0".
fn tick(x: f64, range: &Range<f64>) -> String {
    let digits = (2.0 - libm::log10((range.end - range.start).max(1e-300)).floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text.as_str() };
    if text == "-0" { "0".into() } else { text.to_owned() }
}

fn draw_panel(area: &PlotArea<'_>, panel: &Panel) -> Result<(), DrawError> {
    let points = || panel.lines.iter().flat_map(|l| &l.points);
    let mut x = range(points().map(|p| p.0), if panel.equal_scales { 0.04 } else { 0.0 });
    let mut y = range(points().map(|p| p.1), 0.06);
    let (left, below, margin) = (64_u32, 50_u32, 20_u32);
    let rows = draw_names(area, &panel.lines, (left + margin) as i32)?;
    let above = rows * LEGEND_ROW_HEIGHT + 8;
    if panel.equal_scales {
        let pixels =
            (f64::from(PICTURE_WIDTH - left - 2 * margin), f64::from(PANEL_HEIGHT - below) - f64::from(above) - 8.0);
        (x, y) = equalized(x, y, pixels);
    } else if x.start > 0.0 && x.start < 0.1 * x.end {
        x.start = 0.0;
    }
    let mut chart = ChartBuilder::on(area)
        .margin_left(margin)
        .margin_right(margin)
        .margin_bottom(8)
        .margin_top(above)
        .x_label_area_size(below)
        .y_label_area_size(left)
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .bold_line_style(GRID_COLOR)
        .light_line_style(TRANSPARENT)
        .axis_style(INK_COLOR)
        .label_style(("sans-serif", 16).into_font().color(&INK_COLOR))
        .axis_desc_style(("sans-serif", 17).into_font().color(&INK_COLOR))
        .x_desc(&panel.x)
        .y_desc(&panel.y)
        .x_labels(10)
        .y_labels(7)
        .x_label_formatter(&|v| tick(*v, &x))
        .y_label_formatter(&|v| tick(*v, &y))
        .draw()?;
    for line in &panel.lines {
        let color = line.color;
        for part in line.points.split(|p| !p.0.is_finite() || !p.1.is_finite()).filter(|p| !p.is_empty()) {
            match part {
                [one] => chart.draw_series(std::iter::once(Circle::new(*one, 2, color.filled())))?,
                many => chart.draw_series(LineSeries::new(many.iter().copied(), color.stroke_width(2)))?,
            };
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_ranges_have_margins() {
        assert_eq!(range([1.0, f64::NAN, 3.0].into_iter(), 0.1), 0.8..3.2);
        assert_eq!(range(std::iter::empty(), 0.1), 0.0..1.0);
        assert_eq!(range([0.0, 0.0].into_iter(), 0.1), -1.0..1.0);
        let (x, y) = equalized(0.0..4.0, 0.0..1.0, (200.0, 100.0));
        assert_eq!((x, y), (0.0..4.0, -0.5..1.5));
        assert_eq!(
            [tick(-0.0, &(-1.0..1.0)), tick(0.25, &(0.0..1.0)), tick(1500.0, &(0.0..2e3))],
            ["0", "0.25", "1500"]
        );
    }
}
