//! Publishes windows of buttons to views, in the event `ui.window`.

use super::windows::{MAX_SLIDER_POSITION, Window, WindowButton, bits};
use crate::kit::*;

/// The event that publishes windows to views.
const WINDOW_EVENT: &str = "ui.window";
/// The command with which views report user actions.
pub(crate) const ACTION_COMMAND: &str = "tatu.actOnButtons";
/// Words in labels that represent a symbol, and the character that replaces each of them. In files, buttons that close
/// a window are labelled `Check`.
const LABEL_SYMBOLS: &[(&str, &str)] = &[
    ("ArrowRight", "\u{2192}"),
    ("ArrowLeft", "\u{2190}"),
    ("ArrowUp", "\u{2191}"),
    ("ArrowDown", "\u{2193}"),
    ("Minimize", "\u{2013}"),
    ("Square", "\u{25a1}"),
    ("Check", "\u{2715}"),
    ("Cross", "\u{2715}"),
    ("Pause", "\u{2016}"),
    ("Box", "\u{25a0}"),
];

fn map<const N: usize>(entries: [(&str, Value); N]) -> Value {
    Value::Map(entries.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}

fn ints(all: &[i64]) -> Value {
    Value::List(all.iter().map(|x| Value::Int(*x)).collect())
}

/// Returns the text of a label with its marks applied, and the text colour that they specify: `&&fg900` sets the colour
/// to red, `&&n` breaks the line, `&&Box` inserts a square.
fn parse_label(label: &str) -> (String, Option<String>) {
    let mut parts = label.split("&&");
    let mut text = parts.next().unwrap_or("").to_owned();
    let mut color = None;
    for part in parts {
        let digits = part.get(2..5).filter(|d| d.bytes().all(|b| b.is_ascii_digit()));
        let drawn = LABEL_SYMBOLS.iter().find_map(|(word, sign)| Some((sign, part.strip_prefix(word)?)));
        if let Some((sign, rest)) = drawn {
            text.push_str(sign);
            text.push_str(rest);
        } else if let (Some(digits), true) = (digits, part.starts_with("fg") || part.starts_with("bg")) {
            if part.starts_with("fg") {
                color = Some(rgb(digits.bytes().map(|b| f64::from(b - b'0') / 9.0)));
            }
            text.push_str(&part[5..]);
        } else if let Some(rest) = part.strip_prefix('n') {
            text.push('\n');
            text.push_str(rest);
        } else {
            text.push_str("&&");
            text.push_str(part);
        }
    }
    (text, color)
}

/// Formats a colour, whose components range from 0 to 1, as `#rrggbb`.
fn rgb(parts: impl Iterator<Item = f64>) -> String {
    parts.fold("#".to_owned(), |all, x| format!("{all}{:02x}", (x.clamp(0.0, 1.0) * 255.0).round() as u8))
}

/// Returns the type of element by which views represent a button, and the element's values.
fn widget(w: &Window, b: &WindowButton) -> (&'static str, Value) {
    let hidden = is_rolled_up(w, b);
    let (text, color) = parse_label(b.label());
    let [columns, rows, column, row] = b.cells;
    let mut values = vec![
        ("cell", ints(&[column, row, columns, rows])),
        ("visible", Value::Bool(!hidden)),
        ("enabled", Value::Bool(b.kind() == bits::LABEL || b.is_active())),
        ("centered", Value::Bool(b.has(bits::CENTERED))),
        ("clear", Value::Bool(b.has(bits::TRANSPARENT | bits::NO_BACKGROUND))),
    ];
    let given = b.colors[2].map(|c| rgb(c.into_iter()));
    if let Some(color) = color.or(given) {
        values.push(("color", Value::text(color)));
    }
    if let Some(color) = b.colors[usize::from(b.has(bits::IS_DOWN))] {
        values.push(("background", Value::text(rgb(color.into_iter()))));
    }
    let element = match b.kind() {
        bits::LABEL => "label",
        bits::SLIDER => {
            values.extend([
                ("minimum", Value::Int(0)),
                ("maximum", Value::Int(MAX_SLIDER_POSITION as i64)),
                ("value", Value::Int(b.slider as i64)),
            ]);
            if rows > columns { "vslider" } else { "hslider" }
        }
        bits::EDIT => {
            values.push(("value", Value::text(&text)));
            "edit"
        }
        _ => {
            values.extend([
                ("checkable", Value::Bool(b.has(bits::STAYS_DOWN | bits::DOWN_AND_UP))),
                ("checked", Value::Bool(b.has(bits::IS_DOWN))),
                ("held", Value::Bool(b.has(bits::DOWN_AND_UP))),
            ]);
            "button"
        }
    };
    if b.kind() != bits::EDIT {
        values.push(("text", Value::text(text)));
    }
    (element, Value::Map(values.into_iter().map(|(k, v)| (Value::text(k), v)).collect()))
}

/// Returns whether a button is hidden because its window is rolled up, which leaves only the first row visible.
fn is_rolled_up(w: &Window, b: &WindowButton) -> bool {
    w.attributes & bits::ROLLED_UP != 0 && b.cells[3] > 0
}

/// Returns the widgets of a window: the window itself, then its buttons in order. `object` is the object to which the
/// window belongs, or 0.
fn widgets(w: &Window, object: i64) -> Value {
    let one = |element: &str, above: Value, values: Value| {
        map([("element", Value::text(element)), ("above", above), ("values", values)])
    };
    let only_selected = w.attributes & bits::WHEN_SELECTED != 0 && object != 0;
    let window = map([
        ("title", Value::text(&w.name)),
        ("layout", Value::text("cells")),
        ("cells", ints(&w.cells)),
        ("visible", Value::Bool(w.attributes & bits::VISIBLE != 0)),
        ("for", if only_selected { Value::Int(object) } else { Value::Nil }),
    ]);
    let buttons = w.buttons.iter().map(|b| {
        let (element, values) = widget(w, b);
        one(element, Value::Int(0), values)
    });
    Value::List(std::iter::once(one("ui", Value::Nil, window)).chain(buttons).collect())
}

/// Publishes an event about a window.
pub(crate) fn publish<const N: usize>(c: &Ctx<'_>, window: i64, rest: [(&str, Value); N]) -> Result {
    let mut all = vec![(Value::text("window"), Value::Int(window)), (Value::text("act"), Value::text(ACTION_COMMAND))];
    all.extend(rest.into_iter().map(|(k, v)| (Value::text(k), v)));
    c.world().publish_value(WINDOW_EVENT, &Value::Map(all))
}

/// Publishes a whole window, new or changed. `object` is the object to which the window belongs, or 0.
pub(crate) fn publish_window(c: &Ctx<'_>, window: &Window, object: tatu_object) -> Result {
    publish(c, window.handle, [("widgets", widgets(window, handle(object).max(0)))])
}

/// Returns the values of the `n`-th button for views.
pub(crate) fn button_values(w: &Window, n: usize) -> Value {
    widget(w, &w.buttons[n]).1
}

#[cfg(test)]
mod tests {
    use super::parse_label;

    #[test]
    fn marks_in_labels_are_converted() {
        assert_eq!(parse_label("X & Y"), ("X & Y".to_owned(), None));
        assert_eq!(parse_label("&&fg900&&Box"), ("\u{25a0}".to_owned(), Some("#ff0000".to_owned())));
        assert_eq!(parse_label("&&Boxes").0, "\u{25a0}es");
        assert_eq!(parse_label("one&&ntwo &&unknown"), ("one\ntwo &&unknown".to_owned(), None));
        assert_eq!(parse_label("&&fg0\u{e9}"), ("&&fg0\u{e9}".to_owned(), None));
    }
}
