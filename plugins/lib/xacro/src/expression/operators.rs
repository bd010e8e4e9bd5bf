//! Arithmetic, comparison and indexing, with Python's rules for kinds of values.

use super::{
    format::percent,
    syntax::{Comparator, Operator},
};
use crate::{
    error::{Result, fail},
    limits::Budget,
    value::{
        Range, Value,
        number::{divide_floats, divide_ints, exact_int, float_text, small_power},
        text::repr,
    },
};

pub(super) fn binary(operator: Operator, a: &Value, b: &Value, budget: &mut Budget) -> Result<Value> {
    if let (Some(x), Some(y)) = (a.as_int(), b.as_int()) {
        let both_are_bool = matches!((a, b), (Value::Bool(_), Value::Bool(_)));
        return ints(operator, x, y, both_are_bool);
    }
    if let (Some(x), Some(y)) = (a.as_float(), b.as_float()) {
        return floats(operator, x, y);
    }
    match (operator, a, b) {
        (Operator::Add, Value::Text(x), Value::Text(y)) => {
            budget.text(x.len() + y.len())?;
            return Ok(Value::text(format!("{x}{y}")));
        }
        (Operator::Add, Value::List(x), Value::List(y)) => {
            return Value::list(joined(&x.items().items, &y.items().items, budget)?);
        }
        (Operator::Add, Value::Tuple(x), Value::Tuple(y)) => return Value::tuple(joined(&x.items, &y.items, budget)?),
        (Operator::Remainder, Value::Text(format), _) => return percent(format, b, budget).map(Value::text),
        (Operator::Multiply, sequence, count) | (Operator::Multiply, count, sequence)
            if count.as_int().is_some() && matches!(sequence, Value::Text(_) | Value::List(_) | Value::Tuple(_)) =>
        {
            return repeated(sequence, count.as_int().unwrap_or(0), budget);
        }
        (Operator::BitOr, Value::Dict(x), Value::Dict(y)) => {
            let mut entries = (*x.entries()).clone();
            budget.items(entries.len())?;
            for (key, value) in y.entries().pairs() {
                entries.set(key.clone(), value.clone(), budget)?;
            }
            return Ok(Value::Dict(crate::value::Dict::new(entries)));
        }
        _ => {}
    }
    fail!(
        "`{}` is not possible with {} and {}{}",
        operator.symbol(),
        a.kind(),
        b.kind(),
        if matches!((a, b), (Value::Text(_), _) | (_, Value::Text(_))) { ": use str(), int() or float()" } else { "" }
    )
}

fn ints(operator: Operator, a: i64, b: i64, both_are_bool: bool) -> Result<Value> {
    let checked = match operator {
        Operator::Add => a.checked_add(b),
        Operator::Subtract => a.checked_sub(b),
        Operator::Multiply => a.checked_mul(b),
        Operator::Divide | Operator::FloorDivide | Operator::Remainder if b == 0 => fail!("division by zero"),
        Operator::Divide => return Ok(Value::Float(divide_ints(a, b))),
        Operator::FloorDivide => {
            let rest = a.checked_rem(b).unwrap_or(0);
            let floor = if rest != 0 && (rest < 0) != (b < 0) { 1 } else { 0 };
            a.checked_div(b).map(|quotient| quotient - floor)
        }
        Operator::Remainder => {
            let rest = a.checked_rem(b).unwrap_or(0);
            Some(if rest != 0 && (rest < 0) != (b < 0) { rest + b } else { rest })
        }
        Operator::Power if b < 0 => return floats(operator, a as f64, b as f64),
        Operator::Power => match u32::try_from(b) {
            Ok(b) => a.checked_pow(b),
            Err(_) => [0, 1].contains(&a).then_some(a).or((a == -1).then_some(if b % 2 == 0 { 1 } else { -1 })),
        },
        Operator::BitOr | Operator::BitXor | Operator::BitAnd if both_are_bool => {
            let (a, b) = (a != 0, b != 0);
            return Ok(Value::Bool(match operator {
                Operator::BitOr => a | b,
                Operator::BitXor => a ^ b,
                _ => a & b,
            }));
        }
        Operator::BitOr => Some(a | b),
        Operator::BitXor => Some(a ^ b),
        Operator::BitAnd => Some(a & b),
        Operator::ShiftLeft | Operator::ShiftRight if b < 0 => fail!("a shift by {b}, which is negative"),
        Operator::ShiftLeft if a == 0 => Some(0),
        Operator::ShiftLeft => {
            u32::try_from(b).ok().and_then(|b| 1_i64.checked_shl(b).filter(|_| b < 63)).and_then(|p| a.checked_mul(p))
        }
        Operator::ShiftRight => Some(a >> b.min(63)),
    };
    match checked {
        Some(value) => Ok(Value::Int(value)),
        None => fail!("{a} {} {b} has more than 64 bits: write a number with a decimal point", operator.symbol()),
    }
}

fn floats(operator: Operator, a: f64, b: f64) -> Result<Value> {
    let divides = matches!(operator, Operator::Divide | Operator::FloorDivide | Operator::Remainder);
    if divides && b == 0.0 {
        fail!("division by zero");
    }
    Ok(Value::Float(match operator {
        Operator::Add => a + b,
        Operator::Subtract => a - b,
        Operator::Multiply => a * b,
        Operator::Divide => a / b,
        Operator::FloorDivide => divide_floats(a, b).0,
        Operator::Remainder => divide_floats(a, b).1,
        Operator::Power => power(a, b)?,
        _ => fail!("`{}` is only possible with integers", operator.symbol()),
    }))
}

/// `a ** b` of floats.
pub(super) fn power(a: f64, b: f64) -> Result<f64> {
    if a == 0.0 && b < 0.0 {
        fail!("0.0 cannot be raised to the negative power {}", float_text(b));
    }
    if a < 0.0 && a.is_finite() && b.is_finite() && b.fract() != 0.0 {
        fail!("({}) ** {} is a complex number, which has no use here", float_text(a), float_text(b));
    }
    let result = small_power(a, b).unwrap_or_else(|| libm::pow(a, b));
    if result.is_infinite() && a.is_finite() && b.is_finite() {
        fail!("({}) ** {} is too large for a number", float_text(a), float_text(b));
    }
    Ok(result)
}

fn joined(a: &[Value], b: &[Value], budget: &mut Budget) -> Result<Vec<Value>> {
    budget.items(a.len() + b.len())?;
    Ok(a.iter().chain(b).cloned().collect())
}

fn repeated(sequence: &Value, count: i64, budget: &mut Budget) -> Result<Value> {
    let count = usize::try_from(count).unwrap_or(0);
    let many = |items: &[Value], budget: &mut Budget| -> Result<Vec<Value>> {
        budget.items(items.len().saturating_mul(count))?;
        // Without items, the count has no bound.
        let count = if items.is_empty() { 0 } else { count };
        Ok(std::iter::repeat_n(items, count).flatten().cloned().collect())
    };
    match sequence {
        Value::Text(text) => {
            budget.text(text.len().saturating_mul(count))?;
            Ok(Value::text(text.repeat(if text.is_empty() { 0 } else { count })))
        }
        Value::List(list) => Value::list(many(&list.items().items, budget)?),
        Value::Tuple(items) => Value::tuple(many(&items.items, budget)?),
        other => fail!("a {} cannot be repeated", other.kind()),
    }
}

pub(super) fn compare(comparator: Comparator, a: &Value, b: &Value, budget: &mut Budget) -> Result<bool> {
    Ok(match comparator {
        Comparator::Equal => a.is_equal(b, budget)?,
        Comparator::NotEqual => !a.is_equal(b, budget)?,
        Comparator::In => contains(b, a, budget)?,
        Comparator::NotIn => !contains(b, a, budget)?,
        Comparator::Is => is_same(a, b, budget)?,
        Comparator::IsNot => !is_same(a, b, budget)?,
        Comparator::Less => a.order(b, budget)?.is_some_and(|o| o.is_lt()),
        Comparator::LessEqual => a.order(b, budget)?.is_some_and(|o| o.is_le()),
        Comparator::Greater => a.order(b, budget)?.is_some_and(|o| o.is_gt()),
        Comparator::GreaterEqual => a.order(b, budget)?.is_some_and(|o| o.is_ge()),
    })
}

/// `is`: only meaningful for None, True and False; for others, values of one kind are compared.
fn is_same(a: &Value, b: &Value, budget: &mut Budget) -> Result<bool> {
    Ok(a.kind() == b.kind() && a.is_equal(b, budget)?)
}

fn contains(container: &Value, item: &Value, budget: &mut Budget) -> Result<bool> {
    match (container, item) {
        (Value::Text(text), Value::Text(part)) => {
            budget.spend(1 + (text.len() + part.len()) / 8)?;
            Ok(text.contains(&**part))
        }
        (Value::Text(_), other) => fail!("`in` a str needs a str before it, not a {}", other.kind()),
        (Value::Dict(dict), key) => {
            let key = key.as_key(budget)?;
            Ok(dict.entries().get(&key).is_some())
        }
        (Value::Range(range), item) => {
            let int = item.as_int().or_else(|| item.as_float().and_then(exact_int));
            Ok(int.is_some_and(|int| range_has(range, int)))
        }
        (container, item) => {
            for other in items_of(container, budget)? {
                if other.is_equal(item, budget)? {
                    return Ok(true);
                }
            }
            Ok(false)
        }
    }
}

fn range_has(range: &Range, item: i64) -> bool {
    let offset = i128::from(item) - i128::from(range.start);
    let steps = offset / i128::from(range.step);
    offset % i128::from(range.step) == 0 && (0..range.count as i128).contains(&steps)
}

/// The items that a walk through a value visits.
pub(super) fn items_of(value: &Value, budget: &mut Budget) -> Result<Vec<Value>> {
    let copied = |items: &[Value], budget: &mut Budget| -> Result<Vec<Value>> {
        budget.items(items.len())?;
        Ok(items.to_vec())
    };
    match value {
        Value::List(list) if list.from_yaml => {
            Ok(copied(&list.items().items, budget)?.into_iter().map(Value::wrapped).collect())
        }
        Value::List(list) => copied(&list.items().items, budget),
        Value::Tuple(items) => copied(&items.items, budget),
        Value::View(view) => copied(&view.items.items, budget),
        Value::Dict(dict) => {
            budget.items(dict.len())?;
            Ok(dict.entries().pairs().map(|(key, _)| key.clone()).collect())
        }
        Value::Range(range) => {
            budget.items(range.count)?;
            Ok((0..range.count as i64)
                .map(|i| Value::Int(range.start.wrapping_add(range.step.wrapping_mul(i))))
                .collect())
        }
        Value::Text(text) => {
            budget.items(text.chars().count())?;
            Ok(text.chars().map(|c| Value::text(c.to_string())).collect())
        }
        other => fail!("a {} has no items: expected a list, a tuple, a dict or a str", other.kind()),
    }
}

pub(super) fn index(of: &Value, at: &Value, budget: &mut Budget) -> Result<Value> {
    budget.spend(1)?;
    match of {
        Value::Dict(dict) => {
            let entries = dict.entries();
            let key = at.as_key(budget)?;
            match entries.get(&key) {
                Some(value) if dict.from_yaml => Ok(value.clone().wrapped()),
                Some(value) => Ok(value.clone()),
                None => fail!("the dictionary has no key {}{}", repr(at, budget)?, known_keys(&entries)),
            }
        }
        Value::List(list) => {
            let items = list.items();
            let item = items.items[position(at, items.items.len(), "list")?].clone();
            Ok(if list.from_yaml { item.wrapped() } else { item })
        }
        Value::Tuple(items) => Ok(items.items[position(at, items.items.len(), "tuple")?].clone()),
        Value::Range(range) => {
            let i = position(at, range.count, "range")? as i64;
            Ok(Value::Int(range.start.wrapping_add(range.step.wrapping_mul(i))))
        }
        Value::Text(text) => {
            budget.spend(text.len() / 8)?;
            let count = text.chars().count();
            let found = text.chars().nth(position(at, count, "str")?);
            Ok(Value::text(found.map(String::from).unwrap_or_default()))
        }
        other => fail!("a {} has no index: expected a list, a tuple, a dict or a str before [...]", other.kind()),
    }
}

/// A sentence with the keys of a dictionary, if they are few.
fn known_keys(entries: &crate::value::Entries) -> String {
    const MAX_NAMED: usize = 12;
    let names: Vec<&str> =
        entries.pairs().filter_map(|(k, _)| if let Value::Text(t) = k { Some(&**t) } else { None }).collect();
    if names.is_empty() || names.len() > MAX_NAMED { String::new() } else { format!(": it has {}", names.join(", ")) }
}

fn position(at: &Value, len: usize, kind: &str) -> Result<usize> {
    let Some(index) = at.as_int() else { fail!("the index of a {kind} must be an int, not a {}", at.kind()) };
    let from_start = if index < 0 { index.saturating_add(len as i64) } else { index };
    match usize::try_from(from_start) {
        Ok(position) if position < len => Ok(position),
        _ => fail!("the index {index} is outside of a {kind} of {len}"),
    }
}

pub(super) fn slice(of: &Value, bounds: &[Option<Value>; 3], budget: &mut Budget) -> Result<Value> {
    let mut ints = [None; 3];
    for (bound, int) in bounds.iter().zip(&mut ints) {
        *int = match bound {
            None | Some(Value::None) => None,
            Some(value) => match value.as_int() {
                Some(i) => Some(i),
                None => fail!("the bounds of a slice must be int, not {}", value.kind()),
            },
        };
    }
    let pick = |items: &[Value], budget: &mut Budget| -> Result<Vec<Value>> {
        budget.items(items.len())?;
        Ok(positions(items.len(), ints)?.into_iter().filter_map(|i| items.get(i).cloned()).collect())
    };
    match of {
        Value::List(list) => {
            let picked = Value::list(pick(&list.items().items, budget)?)?;
            Ok(if list.from_yaml { picked.wrapped() } else { picked })
        }
        Value::Tuple(items) => Value::tuple(pick(&items.items, budget)?),
        Value::Text(text) => {
            budget.items(text.len().min(budget.limits.items))?;
            let chars: Vec<char> = text.chars().collect();
            let picked = positions(chars.len(), ints)?.into_iter().filter_map(|i| chars.get(i));
            Ok(Value::text(picked.collect::<String>()))
        }
        other => fail!("a {} cannot be sliced: expected a list, a tuple or a str", other.kind()),
    }
}

/// The positions that a slice takes from a sequence.
fn positions(len: usize, [start, stop, step]: [Option<i64>; 3]) -> Result<Vec<usize>> {
    let step = step.unwrap_or(1);
    if step == 0 {
        fail!("the step of a slice is 0");
    }
    let len = len as i64;
    let (low, high) = if step > 0 { (0, len) } else { (-1, len - 1) };
    let clamp = |bound: i64| (if bound < 0 { bound.saturating_add(len) } else { bound }).clamp(low, high);
    let start = start.map_or(if step > 0 { low } else { high }, clamp);
    let stop = stop.map_or(if step > 0 { high } else { low }, clamp);
    let mut out = Vec::new();
    let mut at = start;
    while if step > 0 { at < stop } else { at > stop } {
        out.extend(usize::try_from(at));
        at = at.saturating_add(step);
    }
    Ok(out)
}
