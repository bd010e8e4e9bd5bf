//! The functions of Python that need nothing but their arguments.

use std::{cmp::Ordering, rc::Rc};

use super::{
    operators::{binary, items_of},
    syntax::Operator,
};
use crate::{
    error::{Result, fail},
    limits::Budget,
    value::{
        Dict, Entries, Range, Value,
        number::{float_from_text, int_from_text, round_to_int, round_to_places, truncated},
        text::{repr, to_text},
    },
};

type Named = [(Rc<str>, Value)];

/// Calls one of them.
pub(super) fn call(name: &'static str, arguments: &[Value], named: &Named, budget: &mut Budget) -> Result<Value> {
    match (name, arguments) {
        ("len", [value]) => match value {
            Value::Text(text) => {
                budget.spend(text.len() / 8)?;
                Ok(Value::Int(text.chars().count() as i64))
            }
            Value::Range(range) => Ok(Value::Int(range.count as i64)),
            Value::View(view) if !view.kind.starts_with("dict_") => fail!("what {}() returns has no length", view.kind),
            Value::List(list) => Ok(Value::Int(list.items().items.len() as i64)),
            Value::Dict(dict) => Ok(Value::Int(dict.len() as i64)),
            _ => Ok(Value::Int(items_of(value, budget)?.len() as i64)),
        },
        ("str", []) => Ok(Value::text("")),
        ("str", [value]) => to_text(value, budget).map(Value::Text),
        ("repr", [value]) => repr(value, budget).map(Value::text),
        ("bool", []) => Ok(Value::Bool(false)),
        ("bool", [value]) => Ok(Value::Bool(value.is_true())),
        ("float", []) => Ok(Value::Float(0.0)),
        ("float", [value]) => to_float(value),
        ("int", []) => Ok(Value::Int(0)),
        ("int", [value]) => to_int(value),
        ("int", [Value::Text(text), base]) => from_base(text, base),
        ("list", []) => Value::list(Vec::new()),
        ("list", [value]) => Value::list(items_of(value, budget)?),
        ("tuple", []) => Value::tuple(Vec::new()),
        ("tuple", [value]) => Value::tuple(items_of(value, budget)?),
        ("dict", [] | [_]) => to_dict(arguments.first(), named, budget),
        ("min" | "max", [_, ..]) => extreme(name, arguments, budget),
        ("round", [value] | [value, Value::None]) => match value.as_int() {
            Some(int) => Ok(Value::Int(int)),
            None => round_to_int(float_of(value, name)?).map(Value::Int),
        },
        ("round", [value, places]) => {
            let Some(places) = places.as_int() else { fail!("round() takes an int as its second argument") };
            match value.as_int() {
                Some(int) => round_int(int, places),
                None => {
                    // Places before the point need all digits of the number.
                    budget.spend(if places < 0 { 100 } else { 4 })?;
                    Ok(Value::Float(round_to_places(float_of(value, name)?, places)))
                }
            }
        }
        ("abs", [value]) => match value.as_int() {
            Some(int) => match int.checked_abs() {
                Some(int) => Ok(Value::Int(int)),
                None => fail!("abs({int}) has more than 64 bits"),
            },
            None => Ok(Value::Float(float_of(value, name)?.abs())),
        },
        ("sum", [sequence] | [sequence, _]) => {
            let mut sum = arguments.get(1).cloned().unwrap_or(Value::Int(0));
            if matches!(sum, Value::Text(_)) {
                fail!("sum() does not join texts: use ''.join(...)");
            }
            for item in items_of(sequence, budget)? {
                sum = binary(Operator::Add, &sum, &item, budget)?;
            }
            Ok(sum)
        }
        ("all" | "any", [sequence]) => {
            let any = name == "any";
            Ok(Value::Bool(items_of(sequence, budget)?.iter().any(|item| item.is_true() == any) == any))
        }
        ("range", [_] | [_, _] | [_, _, _]) => range(arguments),
        ("divmod", [a, b]) => {
            Value::tuple(vec![binary(Operator::FloorDivide, a, b, budget)?, binary(Operator::Remainder, a, b, budget)?])
        }
        ("enumerate", [sequence] | [sequence, _]) => {
            let start = arguments.get(1).map_or(Some(0), Value::as_int);
            let Some(start) = start else { fail!("enumerate() takes an int as its second argument") };
            let items = items_of(sequence, budget)?;
            budget.items(items.len().saturating_mul(2))?;
            let pair = |(i, item)| Value::tuple(vec![Value::Int(start.saturating_add(i)), item]);
            Value::view("enumerate", (0..).zip(items).map(pair).collect::<Result<_>>()?)
        }
        ("zip", _) => {
            let mut columns = Vec::new();
            for sequence in arguments {
                columns.push(items_of(sequence, budget)?.into_iter());
            }
            let rows = columns.iter().map(ExactSizeIterator::len).min().unwrap_or(0);
            let row = |_| Value::tuple(columns.iter_mut().filter_map(Iterator::next).collect());
            Value::view("zip", (0..rows).map(row).collect::<Result<_>>()?)
        }
        ("reversed", [sequence]) => {
            let mut items = items_of(sequence, budget)?;
            items.reverse();
            Value::view("reversed", items)
        }
        ("ord", [Value::Text(text)]) => {
            let mut chars = text.chars();
            match (chars.next(), chars.next()) {
                (Some(c), None) => Ok(Value::Int(i64::from(u32::from(c)))),
                _ => fail!("ord() takes a text of one character"),
            }
        }
        ("isinstance", [value, kinds]) => is_instance(value, kinds).map(Value::Bool),
        _ => fail!("{name}() cannot be called with {} arguments of these kinds", arguments.len()),
    }
}

fn float_of(value: &Value, function: &str) -> Result<f64> {
    match value.as_float() {
        Some(float) => Ok(float),
        None => fail!("{function}() takes a number, not a {}", value.kind()),
    }
}

fn to_float(value: &Value) -> Result<Value> {
    if let Value::Text(text) = value {
        return match float_from_text(text) {
            Some(float) => Ok(Value::Float(float)),
            None => fail!("float(): `{text}` is no number"),
        };
    }
    float_of(value, "float").map(Value::Float)
}

fn to_int(value: &Value) -> Result<Value> {
    let int = match (value, value.as_int()) {
        (_, Some(int)) => Some(int),
        (Value::Text(text), _) => match int_from_text(text) {
            Some(int) => Some(int),
            None => fail!("int(): `{text}` is no integer of 64 bits"),
        },
        (Value::Float(float), _) => Some(truncated(*float)?),
        _ => None,
    };
    match int {
        Some(int) => Ok(Value::Int(int)),
        None => fail!("int() takes a number or a str, not a {}", value.kind()),
    }
}

fn from_base(text: &str, base: &Value) -> Result<Value> {
    let base = base.as_int().and_then(|base| u32::try_from(base).ok()).filter(|base| (2..=36).contains(base));
    let Some(base) = base else { fail!("int() takes a base from 2 to 36") };
    let lower = text.trim().to_ascii_lowercase();
    let digits = match base {
        16 => lower.strip_prefix("0x").unwrap_or(&lower),
        8 => lower.strip_prefix("0o").unwrap_or(&lower),
        2 => lower.strip_prefix("0b").unwrap_or(&lower),
        _ => &lower,
    };
    match i64::from_str_radix(digits, base) {
        Ok(int) => Ok(Value::Int(int)),
        Err(_) => fail!("int(): `{text}` is no integer of base {base} with 64 bits"),
    }
}

fn to_dict(from: Option<&Value>, named: &Named, budget: &mut Budget) -> Result<Value> {
    let mut entries = Entries::default();
    match from {
        Some(Value::Dict(dict)) => {
            budget.items(dict.len())?;
            entries = (*dict.entries()).clone();
        }
        Some(pairs) => {
            for pair in items_of(pairs, budget)? {
                match items_of(&pair, budget)?.as_slice() {
                    [key, value] => entries.set(key.clone(), value.clone(), budget)?,
                    _ => fail!("dict() takes pairs of a key and a value"),
                }
            }
        }
        None => {}
    }
    for (key, value) in named {
        entries.set(Value::Text(key.clone()), value.clone(), budget)?;
    }
    Ok(Value::Dict(Dict::new(entries)))
}

fn extreme(name: &str, arguments: &[Value], budget: &mut Budget) -> Result<Value> {
    let items = match arguments {
        [sequence] => items_of(sequence, budget)?,
        several => several.to_vec(),
    };
    let wanted = if name == "min" { Ordering::Less } else { Ordering::Greater };
    let mut items = items.into_iter();
    let Some(mut best) = items.next() else { fail!("{name}() of nothing") };
    for item in items {
        if item.order(&best, budget)? == Some(wanted) {
            best = item;
        }
    }
    Ok(best)
}

fn round_int(int: i64, places: i64) -> Result<Value> {
    if places >= 0 {
        return Ok(Value::Int(int));
    }
    let unit =
        u32::try_from(places.unsigned_abs()).ok().and_then(|places| 10_i128.checked_pow(places)).unwrap_or(i128::MAX);
    let (whole, rest) = (i128::from(int).div_euclid(unit), i128::from(int).rem_euclid(unit));
    let up = match (rest.saturating_mul(2)).cmp(&unit) {
        Ordering::Less => 0,
        Ordering::Equal => whole.rem_euclid(2),
        Ordering::Greater => 1,
    };
    // Beyond the largest unit, everything rounds to 0.
    let rounded = if unit == i128::MAX { Some(0) } else { (whole + up).checked_mul(unit) };
    match rounded.and_then(|rounded| i64::try_from(rounded).ok()) {
        Some(int) => Ok(Value::Int(int)),
        None => fail!("round({int}, {places}) has more than 64 bits"),
    }
}

fn range(arguments: &[Value]) -> Result<Value> {
    let mut ints = Vec::new();
    for argument in arguments {
        match argument.as_int() {
            Some(int) => ints.push(int),
            None => fail!("range() takes integers, not a {}", argument.kind()),
        }
    }
    let (start, stop, step) = match ints.as_slice() {
        [stop] => (0, *stop, 1),
        [start, stop] => (*start, *stop, 1),
        [start, stop, step, ..] => (*start, *stop, *step),
        [] => fail!("range() takes one to three integers"),
    };
    let span = if step > 0 { i128::from(stop) - i128::from(start) } else { i128::from(start) - i128::from(stop) };
    let width = i128::from(step.unsigned_abs());
    if width == 0 {
        fail!("the step of range() is 0");
    }
    let count = usize::try_from((span + width - 1).div_euclid(width).max(0)).unwrap_or(usize::MAX);
    Ok(Value::Range(Range { start, stop, step, count }))
}

fn is_instance(value: &Value, kinds: &Value) -> Result<bool> {
    match kinds {
        Value::Function(kind @ ("int" | "float" | "str" | "bool" | "list" | "dict" | "tuple" | "range")) => {
            Ok(value.kind() == *kind || (*kind == "int" && value.kind() == "bool"))
        }
        Value::Tuple(kinds) => {
            for kind in &kinds.items {
                if is_instance(value, kind)? {
                    return Ok(true);
                }
            }
            Ok(false)
        }
        _ => fail!("isinstance() takes a type such as str, int, float, list or dict as its second argument"),
    }
}
