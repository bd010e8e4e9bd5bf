//! Methods of texts, lists and dictionaries.

use std::rc::Rc;

use super::{
    format::braces,
    operators::{compare, index, items_of},
    syntax::Comparator,
};
use crate::{
    error::{Result, fail},
    limits::Budget,
    value::{Dict, List, Value, text::repr},
};

pub(super) type Named = [(Rc<str>, Value)];

/// Calls `of.name(arguments)`.
pub(super) fn call(of: &Value, name: &str, arguments: &[Value], named: &Named, budget: &mut Budget) -> Result<Value> {
    if !named.is_empty() && !matches!((of, name), (Value::Text(_), "format") | (Value::Dict(_), "update")) {
        fail!("{name}() takes no arguments with names here");
    }
    match of {
        Value::Text(text) => of_text(text, name, arguments, named, budget),
        Value::List(list) => of_list(list, name, arguments, budget),
        Value::Tuple(items) => of_items(&items.items, name, arguments, budget),
        Value::Dict(dict) => of_dict(dict, name, arguments, named, budget),
        Value::Float(float) if name == "is_integer" => Ok(Value::Bool(float.is_finite() && float.trunc() == *float)),
        other => fail!("a {} has no method `{name}`", other.kind()),
    }
}

fn text_of<'a>(value: &'a Value, method: &str) -> Result<&'a Rc<str>> {
    match value {
        Value::Text(text) => Ok(text),
        other => fail!("{method}() takes a str, not a {}", other.kind()),
    }
}

/// Whether a text begins or ends with a text, or one of a tuple.
fn has_affix(value: &Value, method: &str, test: impl Fn(&str) -> bool) -> Result<Value> {
    if let Value::Tuple(items) = value {
        for item in &items.items {
            if test(text_of(item, method)?) {
                return Ok(Value::Bool(true));
            }
        }
        return Ok(Value::Bool(false));
    }
    Ok(Value::Bool(test(text_of(value, method)?)))
}

fn of_text(text: &Rc<str>, name: &str, arguments: &[Value], named: &Named, budget: &mut Budget) -> Result<Value> {
    budget.spend(1 + text.len() / 8)?;
    let same = |text: String| Ok(Value::text(text));
    let texts = |parts: Vec<&str>, budget: &mut Budget| {
        budget.items(parts.len())?;
        Value::list(parts.into_iter().map(Value::text).collect())
    };
    match (name, arguments) {
        ("format", _) => braces(text, arguments, named, budget).map(Value::text),
        ("upper", []) => same(text.to_uppercase()),
        ("lower", []) => same(text.to_lowercase()),
        ("capitalize", []) => {
            let mut chars = text.chars();
            let first: String = chars.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
            same(first + &chars.as_str().to_lowercase())
        }
        ("title", []) => {
            let mut after_letter = false;
            let mut out = String::new();
            for c in text.chars() {
                if after_letter {
                    out.extend(c.to_lowercase())
                } else {
                    out.extend(c.to_uppercase())
                }
                after_letter = c.is_alphabetic();
            }
            same(out)
        }
        ("strip", _) => stripped(text, name, arguments, true, true),
        ("lstrip", _) => stripped(text, name, arguments, true, false),
        ("rstrip", _) => stripped(text, name, arguments, false, true),
        ("startswith", [part]) => has_affix(part, name, |part| text.starts_with(part)),
        ("endswith", [part]) => has_affix(part, name, |part| text.ends_with(part)),
        ("split" | "rsplit", [] | [_] | [_, _]) => {
            let limit = arguments.get(1).map_or(Some(-1), Value::as_int);
            let Some(limit) = limit else { fail!("{name}() takes an int as its second argument") };
            let limit = usize::try_from(limit).unwrap_or(usize::MAX - 1);
            let parts = match arguments.first() {
                None | Some(Value::None) if limit < usize::MAX - 1 => {
                    fail!("{name}() with a limit needs a separator that is a str");
                }
                None | Some(Value::None) => text.split_whitespace().collect(),
                Some(separator) => {
                    let separator = &**text_of(separator, name)?;
                    if separator.is_empty() {
                        fail!("{name}() takes a separator that is not empty");
                    }
                    if name == "split" {
                        text.splitn(limit + 1, separator).collect()
                    } else {
                        let mut parts: Vec<&str> = text.rsplitn(limit + 1, separator).collect();
                        parts.reverse();
                        parts
                    }
                }
            };
            texts(parts, budget)
        }
        ("splitlines", []) => texts(text.lines().collect(), budget),
        ("partition", [separator]) => {
            let separator = text_of(separator, name)?;
            let (before, found, after) = match text.split_once(&**separator) {
                _ if separator.is_empty() => fail!("partition() takes a separator that is not empty"),
                Some((before, after)) => (before, &**separator, after),
                None => (&**text, "", ""),
            };
            Value::tuple([before, found, after].map(Value::text).to_vec())
        }
        ("replace", [from, to] | [from, to, _]) => {
            let (from, to) = (text_of(from, name)?, text_of(to, name)?);
            let limit = arguments.get(2).map_or(Some(-1), Value::as_int);
            let Some(limit) = limit else { fail!("replace() takes an int as its third argument") };
            let found = text.matches(&**from).count();
            let count = usize::try_from(limit).unwrap_or(found).min(found);
            budget.text(text.len() + count.saturating_mul(to.len()))?;
            same(text.replacen(&**from, to, count))
        }
        ("join", [parts]) => {
            let parts = items_of(parts, budget)?;
            let mut out = String::new();
            for (i, part) in parts.iter().enumerate() {
                let part = text_of(part, name)?;
                if out.len() + part.len() + text.len() > budget.limits.text_bytes {
                    budget.text(out.len() + part.len() + text.len())?;
                }
                out.push_str(if i > 0 { text } else { "" });
                out.push_str(part);
            }
            budget.text(out.len())?;
            same(out)
        }
        ("find" | "rfind" | "index", [part]) => {
            let part = text_of(part, name)?;
            let found = if name == "rfind" { text.rfind(&**part) } else { text.find(&**part) };
            match found {
                Some(at) => Ok(Value::Int(text[..at].chars().count() as i64)),
                None if name == "index" => fail!("index(): the text is not found"),
                None => Ok(Value::Int(-1)),
            }
        }
        ("count", [part]) => {
            let part = text_of(part, name)?;
            Ok(Value::Int(text.matches(&**part).count() as i64))
        }
        ("zfill", [width]) => {
            let Some(width) = width.as_int() else { fail!("zfill() takes an int") };
            let missing = usize::try_from(width).unwrap_or(0).saturating_sub(text.chars().count());
            budget.text(text.len().saturating_add(missing))?;
            let (sign, digits) = text.split_at(usize::from(text.starts_with(['+', '-'])));
            same(format!("{sign}{}{digits}", "0".repeat(missing)))
        }
        ("isdigit" | "isdecimal" | "isnumeric", []) => {
            Ok(Value::Bool(!text.is_empty() && text.chars().all(|c| c.is_ascii_digit())))
        }
        ("isalpha", []) => Ok(Value::Bool(!text.is_empty() && text.chars().all(char::is_alphabetic))),
        ("isalnum", []) => Ok(Value::Bool(!text.is_empty() && text.chars().all(char::is_alphanumeric))),
        ("isspace", []) => Ok(Value::Bool(!text.is_empty() && text.chars().all(char::is_whitespace))),
        ("isupper", []) => Ok(Value::Bool(**text != text.to_lowercase() && **text == text.to_uppercase())),
        ("islower", []) => Ok(Value::Bool(**text != text.to_uppercase() && **text == text.to_lowercase())),
        _ => fail!("a str has no method `{name}` with {} arguments", arguments.len()),
    }
}

fn stripped(text: &str, name: &str, arguments: &[Value], start: bool, end: bool) -> Result<Value> {
    let chars = match arguments {
        [] | [Value::None] => None,
        [chars] => Some(text_of(chars, name)?),
        _ => fail!("{name}() takes one argument at most"),
    };
    let goes = |c: char| chars.map_or(c.is_whitespace(), |chars| chars.contains(c));
    let text = if start { text.trim_start_matches(goes) } else { text };
    Ok(Value::text(if end { text.trim_end_matches(goes) } else { text }))
}

fn of_items(items: &[Value], name: &str, arguments: &[Value], budget: &mut Budget) -> Result<Value> {
    match (name, arguments) {
        ("count" | "index", [wanted]) => {
            let mut count = 0;
            for (i, item) in items.iter().enumerate() {
                if compare(Comparator::Equal, item, wanted, budget)? {
                    if name == "index" {
                        return Ok(Value::Int(i as i64));
                    }
                    count += 1;
                }
            }
            if name == "index" {
                fail!("index(): {} is not in the list", repr(wanted, budget)?);
            }
            Ok(Value::Int(count))
        }
        _ => fail!("a list or tuple has no method `{name}` with {} arguments", arguments.len()),
    }
}

/// Refuses to put a list into another one: lists would become as deep as the file wishes, or contain themselves.
fn plain(value: &Value, method: &str) -> Result<Value> {
    if value.depth() > 0 {
        fail!("{method}() cannot add a {} here; write `+` and a new property instead", value.kind());
    }
    Ok(value.clone())
}

fn of_list(list: &List, name: &str, arguments: &[Value], budget: &mut Budget) -> Result<Value> {
    let copy = |budget: &mut Budget| -> Result<Vec<Value>> {
        let items = list.items();
        budget.items(items.items.len() + 1)?;
        Ok(items.items.clone())
    };
    match (name, arguments) {
        ("append", [value]) => {
            let mut items = copy(budget)?;
            items.push(plain(value, name)?);
            list.replace(items);
            Ok(Value::None)
        }
        ("extend", [values]) => {
            let mut items = copy(budget)?;
            for value in items_of(values, budget)? {
                items.push(plain(&value, name)?);
            }
            budget.items(items.len())?;
            list.replace(items);
            Ok(Value::None)
        }
        ("insert", [at, value]) => {
            let mut items = copy(budget)?;
            let Some(at) = at.as_int() else { fail!("insert() takes an int as its first argument") };
            let from_start = if at < 0 { at.saturating_add(items.len() as i64) } else { at };
            let position = usize::try_from(from_start).unwrap_or(0).min(items.len());
            items.insert(position, plain(value, name)?);
            list.replace(items);
            Ok(Value::None)
        }
        ("pop", [] | [_]) => {
            let last = Value::Int(-1);
            let at = arguments.first().unwrap_or(&last);
            let mut items = copy(budget)?;
            // `index` refuses positions that the list does not have.
            index(&Value::List(list.clone()), at, budget)?;
            let at = at.as_int().unwrap_or(-1);
            let position = if at < 0 { at + items.len() as i64 } else { at };
            let value = items.remove(position as usize);
            list.replace(items);
            Ok(value)
        }
        ("reverse", []) => {
            let mut items = copy(budget)?;
            items.reverse();
            list.replace(items);
            Ok(Value::None)
        }
        ("copy", []) => Value::list(copy(budget)?),
        ("sort", _) => fail!("sort() is not supported: use python.sorted(...)"),
        _ => of_items(&list.items().items, name, arguments, budget),
    }
}

fn of_dict(dict: &Dict, name: &str, arguments: &[Value], named: &Named, budget: &mut Budget) -> Result<Value> {
    let entries = dict.entries();
    budget.spend(1)?;
    match (name, arguments) {
        ("get", [key] | [key, _]) => {
            let found = entries.get(&key.as_key(budget)?).cloned();
            Ok(found.or_else(|| arguments.get(1).cloned()).unwrap_or(Value::None))
        }
        ("keys", []) => {
            budget.items(entries.len())?;
            Value::view("dict_keys", entries.pairs().map(|(key, _)| key.clone()).collect())
        }
        ("values", []) => {
            budget.items(entries.len())?;
            Value::view("dict_values", entries.pairs().map(|(_, value)| value.clone()).collect())
        }
        ("items", []) => {
            budget.items(entries.len().saturating_mul(2))?;
            let pairs = entries.pairs().map(|(key, value)| Value::tuple(vec![key.clone(), value.clone()]));
            Value::view("dict_items", pairs.collect::<Result<_>>()?)
        }
        ("copy", []) => Ok(Value::Dict(Dict::new((*entries).clone()))),
        ("pop", [key] | [key, _]) => {
            let entry = key.as_key(budget)?;
            drop(entries);
            match (dict.remove(&entry, budget)?, arguments.get(1)) {
                (Some(value), _) => Ok(value),
                (None, Some(default)) => Ok(default.clone()),
                (None, None) => fail!("pop(): the dictionary has no key {}", repr(key, budget)?),
            }
        }
        ("update", [] | [_]) => {
            budget.items(entries.len())?;
            let mut changed = (*entries).clone();
            match arguments.first() {
                Some(Value::Dict(other)) => {
                    for (key, value) in other.entries().pairs() {
                        changed.set(key.clone(), plain(value, name)?, budget)?;
                    }
                }
                Some(other) => fail!("update() takes a dict, not a {}", other.kind()),
                None => {}
            }
            for (key, value) in named {
                changed.set(Value::Text(key.clone()), plain(value, name)?, budget)?;
            }
            dict.replace(changed);
            Ok(Value::None)
        }
        _ => fail!("a dict has no method `{name}` with {} arguments", arguments.len()),
    }
}
