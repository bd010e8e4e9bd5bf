//! Converts image messages to the form that scripts receive.

use tatu_plugin_api::safe::{Fail, Result, Value};

/// Returns the data, width and height of an image for scripts. The data consist of a red, a green and a blue byte per
/// pixel, starting with the bottom row.
pub(crate) fn pixels(message: &Value) -> Result<[Value; 3]> {
    let field = |key: &str| match message {
        Value::Map(entries) => entries.iter().find(|(k, _)| *k == Value::text(key)).map(|(_, v)| v),
        _ => None,
    };
    let whole = |key: &str| match field(key) {
        Some(Value::Int(i)) => usize::try_from(*i).unwrap_or(0),
        _ => 0,
    };
    let (width, height) = (whole("width"), whole("height"));
    let encoding = match field("encoding") {
        Some(Value::Text(text)) => String::from_utf8_lossy(text).into_owned(),
        _ => String::new(),
    };
    // The number of bytes per pixel, and the indices of red, green and blue within a pixel.
    let (bytes, colors) = match encoding.as_str() {
        "rgb8" => (3, [0, 1, 2]),
        "bgr8" => (3, [2, 1, 0]),
        "rgba8" => (4, [0, 1, 2]),
        "bgra8" => (4, [2, 1, 0]),
        "mono8" | "8UC1" => (1, [0, 0, 0]),
        other => {
            return Err(Fail::unsupported(format!(
                "image encoding `{other}` is not supported: expected rgb8, bgr8, rgba8, bgra8 or mono8"
            )));
        }
    };
    let row = width.saturating_mul(bytes);
    let step = match whole("step") {
        0 => row,
        step => step,
    };
    let data: &[u8] = match field("data") {
        Some(Value::Bytes(data)) => data,
        _ => &[],
    };
    // All rows have the length `step`, except the last, which may lack padding.
    let needed = if height == 0 { 0 } else { step.saturating_mul(height - 1).saturating_add(row) };
    if step < row || data.len() < needed || width == 0 && height > 0 {
        return Err(Fail::argument(format!(
            "invalid image of {width} x {height} pixels in {encoding} with {step} bytes per row: expected at least \
             {needed} bytes, found {} bytes",
            data.len()
        )));
    }
    let mut out = Vec::with_capacity(if needed == 0 { 0 } else { width * height * 3 });
    for line in (0..height).rev() {
        let line = &data[line * step..line * step + row];
        out.extend(line.chunks_exact(bytes).flat_map(|pixel| colors.map(|i| pixel[i])));
    }
    Ok([Value::Text(out), Value::Int(width as i64), Value::Int(height as i64)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(encoding: &str, size: [i64; 2], step: i64, data: &[u8]) -> Value {
        let pair = |key: &str, value: Value| (Value::text(key), value);
        Value::Map(vec![
            pair("width", Value::Int(size[0])),
            pair("height", Value::Int(size[1])),
            pair("encoding", Value::text(encoding)),
            pair("step", Value::Int(step)),
            pair("data", Value::Bytes(data.to_vec())),
        ])
    }

    #[test]
    fn image_rows_are_flipped_and_colors_reordered() {
        let rgb = |message: &Value| {
            let [Value::Text(data), _, _] = pixels(message).unwrap() else { unreachable!() };
            data
        };
        assert_eq!(rgb(&image("rgb8", [1, 2], 3, &[1, 2, 3, 4, 5, 6])), [4, 5, 6, 1, 2, 3]);
        assert_eq!(rgb(&image("bgr8", [1, 1], 0, &[1, 2, 3])), [3, 2, 1]);
        assert_eq!(rgb(&image("rgba8", [1, 1], 4, &[1, 2, 3, 9])), [1, 2, 3]);
        // Rows may end with padding.
        assert_eq!(rgb(&image("mono8", [1, 2], 2, &[7, 0, 8])), [8, 8, 8, 7, 7, 7]);
        assert!(rgb(&image("rgb8", [0, 0], 0, &[])).is_empty());
        for (wrong, told) in [
            (image("32FC1", [1, 1], 4, &[0; 4]), "32FC1"),
            (image("rgb8", [2, 2], 6, &[0; 11]), "11 bytes"),
            (image("rgb8", [2, 1], 3, &[0; 6]), "3 bytes per row"),
            (image("rgb8", [i64::MAX, i64::MAX], 0, &[]), "0 bytes"),
        ] {
            assert!(pixels(&wrong).unwrap_err().text().contains(told), "{wrong:?}");
        }
    }
}
