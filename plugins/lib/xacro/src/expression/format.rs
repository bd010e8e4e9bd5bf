//! `'...'.format(...)`, `'...' % ...` and the specifications of both.

use crate::{
    error::{Result, excerpt, fail},
    limits::Budget,
    value::{Value, number::float_text, text::to_text},
};

/// How a value is written: `[[fill]align][sign][0][width][.precision][type]`.
#[derive(Default)]
struct Specification {
    fill: Option<char>,
    align: Option<char>,
    sign: Option<char>,
    zeros: bool,
    width: usize,
    precision: Option<usize>,
    kind: Option<char>,
}

impl Specification {
    fn parse(text: &str) -> Result<Self> {
        let mut out = Specification::default();
        let mut chars: Vec<char> = text.chars().collect();
        let is_align = |c: Option<&char>| matches!(c, Some('<' | '>' | '^'));
        if is_align(chars.get(1)) {
            out.fill = Some(chars[0]);
            out.align = Some(chars[1]);
            chars.drain(..2);
        } else if is_align(chars.first()) {
            out.align = Some(chars.remove(0));
        }
        let mut rest = chars.into_iter().peekable();
        out.sign = rest.next_if(|c| matches!(c, '+' | '-' | ' '));
        out.zeros = rest.next_if_eq(&'0').is_some();
        let number = |rest: &mut std::iter::Peekable<std::vec::IntoIter<char>>| {
            let mut value = None;
            while let Some(digit) = rest.peek().and_then(|c| c.to_digit(10)) {
                rest.next();
                value = Some((value.unwrap_or(0_usize) * 10 + digit as usize).min(10_000));
            }
            value
        };
        out.width = number(&mut rest).unwrap_or(0);
        if rest.next_if_eq(&'.').is_some() {
            out.precision = number(&mut rest);
        }
        out.kind = rest.next();
        if rest.next().is_some() || !matches!(out.kind, None | Some('d' | 'f' | 'F' | 'e' | 'g' | 's' | 'x' | '%')) {
            fail!("the format `{}` is not supported: expected one such as 3d, .2f, >8 or 03d", excerpt(text));
        }
        Ok(out)
    }

    fn apply(&self, value: &Value, budget: &mut Budget) -> Result<String> {
        let (text, is_number) = self.plain(value, budget)?;
        let len = text.chars().count();
        budget.text(text.len() + self.width)?;
        let missing = self.width.saturating_sub(len);
        let fill = |count| self.fill.unwrap_or(' ').to_string().repeat(count);
        Ok(match self.align {
            None if self.zeros && is_number => {
                let (sign, digits) = text.split_at(usize::from(text.starts_with(['+', '-', ' '])));
                format!("{sign}{}{digits}", "0".repeat(missing))
            }
            Some('>') => fill(missing) + &text,
            Some('^') => fill(missing / 2) + &text + &fill(missing - missing / 2),
            Some(_) => text + &fill(missing),
            None if is_number => fill(missing) + &text,
            None => text + &fill(missing),
        })
    }

    /// The value without padding, and whether it is a number.
    fn plain(&self, value: &Value, budget: &mut Budget) -> Result<(String, bool)> {
        let signed = |text: String| match self.sign {
            Some(sign @ ('+' | ' ')) if !text.starts_with('-') => format!("{sign}{text}"),
            _ => text,
        };
        let kind = self.kind.unwrap_or(match value {
            Value::Int(_) => 'd',
            Value::Float(_) if self.precision.is_some() => 'g',
            Value::Float(_) => 'r',
            _ => 's',
        });
        let text = match (kind, value.as_int(), value.as_float()) {
            ('d', Some(int), _) => {
                let sign = if int < 0 { "-" } else { "" };
                format!("{sign}{:0>width$}", int.unsigned_abs(), width = self.precision.unwrap_or(1))
            }
            ('x', Some(int), _) if int >= 0 => format!("{int:x}"),
            ('r', _, Some(float)) => float_text(float),
            ('f' | 'F' | '%', _, Some(float)) => {
                let float = if kind == '%' { float * 100.0 } else { float };
                fixed(float, self.precision.unwrap_or(6)) + if kind == '%' { "%" } else { "" }
            }
            ('e', _, Some(float)) => scientific(float, self.precision.unwrap_or(6)),
            ('g', _, Some(float)) => general(float, self.precision.unwrap_or(6).max(1), self.kind.is_none()),
            ('s', ..) if self.kind.is_none() || matches!(value, Value::Text(_)) => {
                let text = to_text(value, budget)?;
                let text = self.precision.map_or_else(|| text.to_string(), |count| text.chars().take(count).collect());
                return Ok((text, false));
            }
            _ => fail!("the format `{kind}` is not possible with a {}", value.kind()),
        };
        Ok((signed(text), true))
    }
}

fn fixed(value: f64, places: usize) -> String {
    if value.is_finite() { format!("{value:.places$}") } else { float_text(value) }
}

fn scientific(value: f64, places: usize) -> String {
    if !value.is_finite() {
        return float_text(value);
    }
    let text = format!("{value:.places$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    format!("{mantissa}e{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.abs())
}

/// `precision` significant digits, without zeros at the end; `is_float`: at least one digit after the point.
fn general(value: f64, precision: usize, is_float: bool) -> String {
    if !value.is_finite() {
        return float_text(value);
    }
    let text = scientific(value, precision - 1);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "+00"));
    let places: i64 = exponent.parse().unwrap_or(0);
    // Where the form without a type changes to an exponent, one digit earlier, since it needs one after the point.
    let end = precision as i64 - i64::from(is_float);
    let shorten = |digits: &str| match digits.contains('.') {
        true => digits.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => digits.to_owned(),
    };
    if places < -4 || places >= end {
        return format!("{}e{exponent}", shorten(mantissa));
    }
    let plain = shorten(&fixed(value, (precision as i64 - 1 - places).max(0) as usize));
    if is_float && !plain.contains('.') { plain + ".0" } else { plain }
}

/// `text.format(arguments)`: `{}`, `{0}`, `{name}`, `{:spec}`, with `!r` and `!s`.
pub(super) fn braces(
    format: &str,
    arguments: &[Value],
    named: &[(std::rc::Rc<str>, Value)],
    budget: &mut Budget,
) -> Result<String> {
    let mut out = String::new();
    let mut rest = format;
    let mut next = 0;
    while let Some(at) = rest.find(['{', '}']) {
        out.push_str(&rest[..at]);
        budget.grown_text(out.len(), at)?;
        let mark = &rest[at..=at];
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix(mark) {
            out.push_str(mark);
            rest = after;
            continue;
        }
        let end = rest.find('}').filter(|_| mark == "{");
        let Some(end) = end else { fail!("`{}`: a single `{mark}`; write {mark}{mark} for one", excerpt(format)) };
        let (field, specification) = rest[..end].split_once(':').unwrap_or((&rest[..end], ""));
        rest = &rest[end + 1..];
        let (field, conversion) = field.split_once('!').unwrap_or((field, ""));
        let found = if field.is_empty() {
            next += 1;
            arguments.get(next - 1)
        } else if let Ok(position) = field.parse::<usize>() {
            arguments.get(position)
        } else {
            named.iter().find(|(name, _)| **name == *field).map(|(_, value)| value)
        };
        let Some(value) = found else {
            fail!(
                "`{}`: there is no argument for {{{field}}} (indices and attributes in it are not supported)",
                excerpt(format)
            )
        };
        let value = match conversion {
            "" => value.clone(),
            "r" => Value::text(crate::value::text::repr(value, budget)?),
            "s" => Value::Text(to_text(value, budget)?),
            other => fail!("`!{other}` in a format is not supported: expected !r or !s"),
        };
        let specification = Specification::parse(specification)?;
        if matches!(value, Value::Int(_))
            && specification.precision.is_some()
            && matches!(specification.kind, None | Some('d'))
        {
            fail!("`{}`: an int has no precision", excerpt(format));
        }
        out.push_str(&specification.apply(&value, budget)?);
    }
    out.push_str(rest);
    budget.text(out.len())?;
    Ok(out)
}

/// `format % values`: %s, %r, %d, %i, %f, %e, %g, %x, with width and precision, and names of a dictionary.
pub(super) fn percent(format: &str, values: &Value, budget: &mut Budget) -> Result<String> {
    let list = match values {
        Value::Tuple(items) => items.items.clone(),
        other => vec![other.clone()],
    };
    let mut values_left = list.iter();
    let mut out = String::new();
    let mut rest = format;
    let mut uses_names = false;
    while let Some(at) = rest.find('%') {
        out.push_str(&rest[..at]);
        budget.grown_text(out.len(), at)?;
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix('%') {
            out.push('%');
            rest = after;
            continue;
        }
        let mut named = None;
        if let Some((name, after)) = rest.strip_prefix('(').and_then(|r| r.split_once(')')) {
            let Value::Dict(dict) = values else { fail!("`{}`: %(name) needs a dict", excerpt(format)) };
            named = dict.entries().get(&Value::text(name).as_key(budget)?).cloned();
            uses_names = true;
            rest = after;
        }
        let Some(end) = rest.find(|c: char| c.is_alphabetic()) else {
            fail!("`{}`: a `%` without a type; write %% for one", excerpt(format))
        };
        let kind = rest[end..].chars().next().unwrap_or('s');
        let flags = &rest[..end];
        rest = &rest[end + kind.len_utf8()..];
        let Some(value) = named.as_ref().or_else(|| values_left.next()) else {
            fail!("`{}`: there are fewer values than `%`", excerpt(format))
        };
        let value = match (kind, value) {
            ('s', value) => Value::Text(to_text(value, budget)?),
            ('r', value) => Value::text(crate::value::text::repr(value, budget)?),
            ('d' | 'i' | 'u', Value::Float(float)) if float.is_finite() => {
                Value::Int(crate::value::number::truncated(*float)?)
            }
            (_, value) => value.clone(),
        };
        let kind = match kind {
            'r' => 's',
            'i' | 'u' => 'd',
            other => other,
        };
        let (align, flags) = match flags.strip_prefix('-') {
            Some(flags) => ("<", flags),
            None if kind == 's' => (">", flags),
            None => ("", flags),
        };
        out.push_str(&Specification::parse(&format!("{align}{flags}{kind}"))?.apply(&value, budget)?);
    }
    // As in Python, only texts, numbers and tuples are too many.
    let may_be_left = matches!(values, Value::Dict(_) | Value::List(_) | Value::Range(_));
    if !uses_names && !may_be_left && values_left.next().is_some() {
        fail!("`{}`: there are more values than `%`", excerpt(format));
    }
    out.push_str(rest);
    budget.text(out.len())?;
    Ok(out)
}
