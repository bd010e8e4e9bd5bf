//! Draws any reading as a sheet of text, with one line per field.

use tatu_core::{Reading, ReadingField};
use tatu_plugin_api::safe::Value;

use super::canvas::{Canvas, HPos, VPos, title};

const ROW_HEIGHT: u32 = 24;
const FONT_SIZE: f64 = 16.0;
/// Maximum number of elements shown per field.
const MAX_ELEMENTS: usize = 12;

/// Draws a sheet that lists all fields.
pub fn draw(reading: &Reading) -> Result<Canvas, String> {
    let lines: Vec<(String, String)> = reading.fields.iter().map(line).collect();
    let widest = |column: &dyn Fn(&(String, String)) -> String| -> Result<f64, String> {
        lines.iter().try_fold(0.0_f64, |w, l| Ok(w.max(Canvas::width_of(&column(l), FONT_SIZE)?)))
    };
    let names = widest(&|l| l.0.clone())?;
    let width = (names + widest(&|l| l.1.clone())? + 80.0).max(Canvas::width_of(&title(reading), 19.0)? + 40.0);
    let mut canvas = Canvas::new(width.ceil().min(4000.0) as u32, 64 + ROW_HEIGHT * lines.len() as u32);
    canvas.title(&title(reading))?;
    for (i, (name, text)) in lines.iter().enumerate() {
        let y = 60.0 + f64::from(ROW_HEIGHT) * i as f64;
        canvas.text((24.0, y), name, FONT_SIZE, (HPos::Left, VPos::Center))?;
        canvas.text((24.0 + names + 24.0, y), text, FONT_SIZE, (HPos::Left, VPos::Center))?;
    }
    Ok(canvas)
}

fn line(field: &ReadingField) -> (String, String) {
    let unit = field.unit.as_deref().filter(|u| *u != "1").unwrap_or_default();
    let all: Vec<String> = match &field.value {
        Value::Floats(f) => f.iter().take(MAX_ELEMENTS + 1).map(|x| number(*x, unit)).collect(),
        Value::Ints(f) => f.iter().take(MAX_ELEMENTS + 1).map(i64::to_string).collect(),
        Value::Bytes(b) => b.iter().take(MAX_ELEMENTS + 1).map(u8::to_string).collect(),
        other => vec![format!("{other:?}")],
    };
    let more = if all.len() > MAX_ELEMENTS { " ..." } else { "" };
    let text = all.into_iter().take(MAX_ELEMENTS).collect::<Vec<_>>().join("   ");
    let unit = if unit == "rad" { "" } else { unit };
    (field.name.clone(), format!("{text}{more} {unit}").trim_end().to_owned())
}

/// Formats a number. Angles are shown in rad and degrees, with more digits because they may be latitudes or longitudes.
fn number(x: f64, unit: &str) -> String {
    match unit {
        "rad" => format!("{x:.9} rad ({:.7}\u{b0})", x.to_degrees()),
        _ if x != 0.0 && x.abs() < 1e-3 => format!("{x:.9}"),
        _ => format!("{x:.4}"),
    }
}
