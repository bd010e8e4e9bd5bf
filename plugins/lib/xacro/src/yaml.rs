//! Files with YAML, read as PyYAML reads them: YAML 1.1, with xacro's units (`!degrees 90`).

use saphyr_parser::{Event, Parser, ScalarStyle, Tag};

use crate::{
    error::{Result, fail},
    expression::{
        context::{Context, Severity},
        evaluation::evaluate,
    },
    limits::{Budget, MAX_NESTING},
    value::{Dict, Entries, Value, number::float_from_text},
};

/// A list or mapping that is not yet complete.
struct OpenCollection {
    anchor: usize,
    contents: Contents,
}

enum Contents {
    List(Vec<Value>),
    Mapping { entries: Entries, key: Option<Value>, merged: Vec<Value> },
}

/// Reads a document.
pub(crate) fn load(text: &str, context: &mut dyn Context) -> Result<Value> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut anchors: std::collections::BTreeMap<usize, Value> = std::collections::BTreeMap::new();
    let mut open: Vec<OpenCollection> = Vec::new();
    let mut result = None;
    for event in Parser::new_from_str(text) {
        let (event, span) = match event {
            Ok(event) => event,
            Err(error) => {
                fail!("line {}, column {}: {}", error.marker().line(), error.marker().col() + 1, error.info())
            }
        };
        let line = span.start.line();
        context.budget().spend(1)?;
        let (value, anchor) = match event {
            Event::Scalar(text, style, anchor, tag) => match scalar(&text, style, tag.as_deref(), context) {
                Ok(value) => (value, anchor),
                Err(fault) => fail!("line {line}: {}", fault.message),
            },
            Event::Alias(anchor) => match anchors.get(&anchor) {
                Some(value) => (value.clone(), 0),
                None => fail!("line {line}: the anchor is not complete: a value cannot contain itself"),
            },
            Event::SequenceStart(anchor, tag) | Event::MappingStart(anchor, tag)
                if tag.is_some() || open.len() >= MAX_NESTING =>
            {
                let _ = anchor;
                match tag {
                    Some(tag) => fail!("line {line}: the tag {tag} is not supported for lists and mappings"),
                    None => fail!("line {line}: lists are nested deeper than {MAX_NESTING}"),
                }
            }
            Event::SequenceStart(anchor, _) => {
                open.push(OpenCollection { anchor, contents: Contents::List(Vec::new()) });
                continue;
            }
            Event::MappingStart(anchor, _) => {
                let contents = Contents::Mapping { entries: Entries::default(), key: None, merged: Vec::new() };
                open.push(OpenCollection { anchor, contents });
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(OpenCollection { anchor, contents }) => (complete(contents, context.budget())?, anchor),
                None => continue,
            },
            Event::DocumentStart(_) if result.is_some() => fail!("line {line}: a second document begins: expected one"),
            _ => continue,
        };
        if anchor != 0 {
            anchors.insert(anchor, value.clone());
        }
        match open.last_mut().map(|open| &mut open.contents) {
            None => result = Some(value),
            Some(Contents::List(items)) => {
                context.budget().another_item(items.len())?;
                items.push(value);
            }
            Some(Contents::Mapping { entries, key, merged }) => match key.take() {
                None => *key = Some(value),
                Some(Value::Text(name)) if &*name == "<<" => merged.push(value),
                Some(key) => entries.set(key, value, context.budget())?,
            },
        }
    }
    Ok(result.unwrap_or(Value::None))
}

fn complete(contents: Contents, budget: &mut Budget) -> Result<Value> {
    match contents {
        Contents::List(items) => {
            budget.items(items.len())?;
            Value::list(items)
        }
        Contents::Mapping { entries, merged, .. } if merged.is_empty() => Ok(Value::Dict(Dict::new(entries))),
        Contents::Mapping { entries: own, merged, .. } => {
            // Merged keys come first, and the mapping's own replace their values.
            let mut entries = Entries::default();
            for source in merged {
                let sources = match &source {
                    Value::List(list) => list.items().items.clone(),
                    single => vec![single.clone()],
                };
                for source in sources {
                    let Value::Dict(dict) = source else { fail!("`<<` takes a mapping, or a list of them") };
                    for (key, value) in dict.entries().pairs() {
                        if entries.get(&key.as_key(budget)?).is_none() {
                            entries.set(key.clone(), value.clone(), budget)?;
                        }
                    }
                }
            }
            for (key, value) in own.pairs() {
                entries.set(key.clone(), value.clone(), budget)?;
            }
            Ok(Value::Dict(Dict::new(entries)))
        }
    }
}

fn scalar(text: &str, style: ScalarStyle, tag: Option<&Tag>, context: &mut dyn Context) -> Result<Value> {
    context.budget().text(text.len())?;
    let name = match tag {
        None if style == ScalarStyle::Plain => return plain(text),
        None => return Ok(Value::text(text)),
        Some(tag) => tag.to_string(),
    };
    let factor = match name.as_str() {
        "!radians" | "!meters" => 1.0,
        "!degrees" => std::f64::consts::PI / 180.0,
        "!millimeters" => 0.001,
        "!foot" => 0.3048,
        "!inches" => 0.0254,
        "!" => return Ok(Value::text(text)),
        _ => {
            let suffix = tag.filter(|tag| tag.is_yaml_core_schema()).map_or("", |tag| &tag.suffix);
            let value = plain(text)?;
            return match (suffix, &value) {
                ("str", _) => Ok(Value::text(text)),
                ("int", Value::Int(_))
                | ("float", Value::Float(_))
                | ("bool", Value::Bool(_))
                | ("null", Value::None) => Ok(value),
                ("float", _) => match float_from_text(text) {
                    Some(float) => Ok(Value::Float(float)),
                    None => fail!("`{text}` is no float"),
                },
                _ => fail!("the tag {name} is not supported with `{text}`: expected !degrees, !radians, !meters, ..."),
            };
        }
    };
    let value = evaluate(text, &mut WithoutProperties(context))?;
    let float = match &value {
        Value::Text(text) => float_from_text(text),
        other => other.as_float(),
    };
    match float {
        Some(float) => Ok(Value::Float(float * factor)),
        None => fail!("{name} takes a number, not a {}", value.kind()),
    }
}

/// A text without quotes: PyYAML's rules tell numbers and truth values from texts.
fn plain(text: &str) -> Result<Value> {
    let digits_of = |text: &str| text.strip_prefix(['+', '-']).unwrap_or(text).to_owned();
    Ok(match text {
        "" | "~" | "null" | "Null" | "NULL" => Value::None,
        "yes" | "Yes" | "YES" | "true" | "True" | "TRUE" | "on" | "On" | "ON" => Value::Bool(true),
        "no" | "No" | "NO" | "false" | "False" | "FALSE" | "off" | "Off" | "OFF" => Value::Bool(false),
        ".nan" | ".NaN" | ".NAN" => Value::Float(f64::NAN),
        _ if matches!(digits_of(text).as_str(), ".inf" | ".Inf" | ".INF") => {
            Value::Float(if text.starts_with('-') { f64::NEG_INFINITY } else { f64::INFINITY })
        }
        _ if is_date(text) => fail!("`{text}` is a date, which is not supported: write it in quotes"),
        _ => match number(text, &digits_of(text))? {
            Some(value) => value,
            None => Value::text(text),
        },
    })
}

fn is_date(text: &str) -> bool {
    let parts: Vec<&str> = text.splitn(3, '-').collect();
    let all_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    match parts.as_slice() {
        [year, month, day] => {
            let day_len = day.find(|c: char| !c.is_ascii_digit()).unwrap_or(day.len());
            let time_follows = day[day_len..].starts_with(['T', 't', ' ', '\t']) && day.contains(':');
            all_digits(year)
                && year.len() == 4
                && all_digits(month)
                && month.len() <= 2
                && (1..=2).contains(&day_len)
                && (day_len == day.len() || time_follows)
        }
        _ => false,
    }
}

/// An integer (also 0x, 0b, octal with a leading 0, and to the base 60) or a float (which has a point, and no sign before
/// one).
fn number(text: &str, unsigned: &str) -> Result<Option<Value>> {
    let sign = if text.starts_with('-') { "-" } else { "" };
    let is_made_of = |text: &str, allowed: &str| !text.is_empty() && text.chars().all(|c| allowed.contains(c));
    let (radix, digits, allowed) = match unsigned.as_bytes() {
        [b'0', b'b', ..] => (2, &unsigned[2..], "01_"),
        [b'0', b'x', ..] => (16, &unsigned[2..], "0123456789abcdefABCDEF_"),
        [b'0', _, ..] => (8, &unsigned[1..], "01234567_"),
        [b'0'] | [b'1'..=b'9', ..] => (10, unsigned, "0123456789_"),
        _ => (10, "", ""),
    };
    if is_made_of(digits, allowed) {
        let digits = digits.replace('_', "");
        let digits = if digits.is_empty() && radix == 8 { "0" } else { &digits };
        return match i64::from_str_radix(&format!("{sign}{digits}"), radix) {
            Ok(int) => Ok(Some(Value::Int(int))),
            // Such as a serial number: it stays as it is written.
            Err(_) if radix == 10 => Ok(Some(Value::text(text))),
            Err(_) => fail!("`{text}` is no integer of 64 bits: write it in quotes"),
        };
    }
    if unsigned.contains(':') {
        return Ok(sexagesimal(unsigned, sign == "-"));
    }
    let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (unsigned, None),
    };
    let has_exponent = exponent.is_none_or(|exponent| {
        exponent.strip_prefix(['+', '-']).is_some_and(|digits| is_made_of(digits, "0123456789"))
    });
    let starts_well = unsigned.starts_with(|c: char| c.is_ascii_digit())
        || text.strip_prefix('.').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    let is_float =
        starts_well && has_exponent && mantissa.matches('.').count() == 1 && is_made_of(mantissa, "0123456789._");
    Ok(if is_float { text.replace('_', "").parse().ok().map(Value::Float) } else { None })
}

/// `1:30` is 90, `1:30.5` is 90.5.
fn sexagesimal(unsigned: &str, is_negative: bool) -> Option<Value> {
    let is_digits = |text: &str, more: &str| text.chars().all(|c| c.is_ascii_digit() || more.contains(c));
    let (whole, fraction) = match unsigned.split_once('.') {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (unsigned, None),
    };
    let mut parts = whole.split(':');
    let first = parts.next()?;
    let starts_well = match fraction {
        Some(fraction) => first.starts_with(|c: char| c.is_ascii_digit()) && is_digits(fraction, "_"),
        None => first.starts_with(|c: char| ('1'..='9').contains(&c)),
    };
    let below_60 = |part: &str| is_digits(part, "") && part.parse::<u8>().is_ok_and(|n| n < 60) && part.len() <= 2;
    if !starts_well || !is_digits(first, "_") || !parts.all(below_60) {
        return None;
    }
    let clean = unsigned.replace('_', "");
    let (mut total, mut unit) = (0.0, 1.0);
    for part in clean.split(':').rev() {
        total += part.parse::<f64>().ok()? * unit;
        unit *= 60.0;
    }
    let total = if is_negative { -total } else { total };
    Some(if fraction.is_some() { Value::Float(total) } else { Value::Int(total as i64) })
}

/// What expressions with a unit may use: numbers and functions.
struct WithoutProperties<'a>(&'a mut dyn Context);

impl Context for WithoutProperties<'_> {
    fn budget(&mut self) -> &mut Budget {
        self.0.budget()
    }
    fn property(&mut self, _: &str) -> Result<Option<Value>> {
        Ok(None)
    }
    fn property_in(&mut self, _: usize, _: &str) -> Result<Option<Value>> {
        Ok(None)
    }
    fn argument(&mut self, name: &str) -> Result<Value> {
        self.0.argument(name)
    }
    fn file_name(&mut self, name: &str) -> String {
        self.0.file_name(name)
    }
    fn load_yaml(&mut self, _: &str) -> Result<Value> {
        fail!("load_yaml() is not possible within YAML")
    }
    fn say(&mut self, severity: Severity, text: &str) {
        self.0.say(severity, text);
    }
    fn note(&mut self, kind: &'static str, text: &str) {
        self.0.note(kind, text);
    }
}
