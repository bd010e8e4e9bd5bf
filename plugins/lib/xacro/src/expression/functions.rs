//! Functions of Python and xacro, and the names under which expressions find them.

use std::{cmp::Ordering, rc::Rc};

use super::{
    builtins,
    context::{Context, Severity},
    math,
    operators::items_of,
};
use crate::{
    error::{Result, fail},
    limits::Budget,
    value::{Namespace, Value, text::to_text},
};

/// Functions with their bare names.
const BARE: [&str; 11] = ["list", "dict", "map", "len", "str", "float", "int", "bool", "min", "max", "round"];
/// Functions whose bare names still work, with a warning.
const DISCOURAGED: [(&str, &str); 5] =
    [("sorted", "python"), ("range", "python"), ("load_yaml", "xacro"), ("abs_filename", "xacro"), ("dotify", "xacro")];
/// Functions that are only in the namespace `python`.
const PYTHON: [&str; 13] = [
    "abs",
    "all",
    "any",
    "divmod",
    "enumerate",
    "filter",
    "isinstance",
    "ord",
    "repr",
    "reversed",
    "sum",
    "tuple",
    "zip",
];
const PYTHON_REFUSED: [&str; 8] = ["complex", "frozenset", "hash", "issubclass", "set", "slice", "type", "vars"];
const XACRO: [&str; 7] = ["arg", "message", "warning", "error", "print_location", "fatal", "tokenize"];

fn find(list: &[&'static str], name: &str) -> Option<&'static str> {
    list.iter().find(|known| **known == name).copied()
}

fn discouraged(name: &str) -> Option<(&'static str, &'static str)> {
    DISCOURAGED.iter().find(|(known, _)| *known == name).copied()
}

/// Whether a bare name is one that every file has, so that a property of this name hides it.
pub(crate) fn is_global(name: &str) -> bool {
    matches!(name, "True" | "False" | "math" | "python" | "xacro")
        || find(&BARE, name).is_some()
        || discouraged(name).is_some()
        || math::constant(name).is_some()
        || find(&math::FUNCTIONS, name).or(find(&math::REFUSED, name)).is_some()
}

/// The value of a bare name that is no property.
pub(super) fn global(name: &str, context: &mut dyn Context) -> Result<Value> {
    if let Some(found) = find(&BARE, name) {
        return Ok(Value::Function(found));
    }
    if let Some(found) = in_math(name) {
        return Ok(found);
    }
    match name {
        "math" => return Ok(Value::Namespace(Namespace::Math)),
        "python" => return Ok(Value::Namespace(Namespace::Python)),
        "xacro" => return Ok(Value::Namespace(Namespace::Xacro)),
        _ => {}
    }
    let found = discouraged(name).or_else(|| find(&PYTHON, name).map(|found| (found, "python")));
    if let Some((found, space)) = found {
        context.note("bare name", &format!("`{name}` should be written {space}.{name}"));
        return Ok(Value::Function(found));
    }
    if find(&math::REFUSED, name).is_some() || find(&PYTHON_REFUSED, name).is_some() {
        fail!("the function `{name}` is not supported");
    }
    fail!("`{name}` is not defined: expected a property, a parameter of the macro, or a function")
}

fn in_math(name: &str) -> Option<Value> {
    math::constant(name).map(Value::Float).or_else(|| find(&math::FUNCTIONS, name).map(Value::Function))
}

/// The value of `space.name`.
pub(super) fn member(space: Namespace, name: &str, context: &mut dyn Context) -> Result<Value> {
    let found = match space {
        Namespace::Table(table) => match context.property_in(table, name)? {
            Some(value) => return Ok(value),
            None => return global(name, context),
        },
        Namespace::Math => in_math(name),
        Namespace::Python => find(&BARE, name)
            .or(find(&PYTHON, name))
            .or(discouraged(name).filter(|(_, space)| *space == "python").map(|(name, _)| name))
            .map(Value::Function),
        Namespace::Xacro => find(&XACRO, name)
            .or(discouraged(name).filter(|(_, space)| *space == "xacro").map(|(name, _)| name))
            .map(Value::Function),
    };
    match found {
        Some(value) => Ok(value),
        None => {
            let space = match space {
                Namespace::Math => "math",
                Namespace::Python => "python",
                _ => "xacro",
            };
            fail!("`{space}.{name}` is not supported")
        }
    }
}

type Named = [(Rc<str>, Value)];

/// Calls a function by its name.
pub(super) fn call(name: &'static str, arguments: &[Value], named: &Named, context: &mut dyn Context) -> Result<Value> {
    context.budget().spend(1)?;
    let takes_names =
        matches!(name, "dict" | "sorted" | "tokenize" | "message" | "warning" | "error" | "print_location");
    if let (Some((key, _)), false) = (named.first(), takes_names) {
        fail!("{name}() takes no argument `{key}` here");
    }
    if find(&math::FUNCTIONS, name).is_some() {
        return math::call(name, arguments);
    }
    if find(&XACRO, name).is_some() || discouraged(name).is_some_and(|(_, space)| space == "xacro") {
        return call_xacro(name, arguments, named, context);
    }
    match (name, arguments) {
        ("map" | "filter", [Value::Function(function), sequences @ ..]) if !sequences.is_empty() => {
            let mut columns = Vec::new();
            for sequence in sequences {
                columns.push(items_of(sequence, context.budget())?);
            }
            let rows = columns.iter().map(Vec::len).min().unwrap_or(0);
            let mut out = Vec::new();
            for row in 0..rows {
                let row: Vec<Value> = columns.iter().filter_map(|column| column.get(row).cloned()).collect();
                let result = call(function, &row, &[], context)?;
                match name {
                    "map" => out.push(result),
                    _ if result.is_true() => out.extend(row.into_iter().next()),
                    _ => {}
                }
            }
            Value::view(if name == "map" { "map" } else { "filter" }, out)
        }
        ("sorted", [sequence]) => {
            let items = items_of(sequence, context.budget())?;
            let (mut reverse, mut key) = (false, None);
            for (option, value) in named {
                match (&**option, value) {
                    ("reverse", value) => reverse = value.is_true(),
                    ("key", Value::Function(function)) => key = Some(*function),
                    ("key", Value::None) => {}
                    _ => fail!("sorted() takes no argument `{option}` of this kind"),
                }
            }
            let mut pairs = Vec::new();
            for item in items {
                let by = match key {
                    Some(function) => call(function, std::slice::from_ref(&item), &[], context)?,
                    None => item.clone(),
                };
                pairs.push((by, item));
            }
            Value::list(sorted(pairs, reverse, context.budget())?)
        }
        _ => builtins::call(name, arguments, named, context.budget()),
    }
}

fn call_xacro(name: &'static str, arguments: &[Value], named: &Named, context: &mut dyn Context) -> Result<Value> {
    let severity = match name {
        "message" => Some(Severity::Message),
        "warning" => Some(Severity::Warning),
        "error" => Some(Severity::Error),
        _ => None,
    };
    match (name, arguments) {
        ("load_yaml", [Value::Text(file)]) => context.load_yaml(file),
        ("abs_filename", [Value::Text(file)]) => Ok(Value::text(context.file_name(file))),
        ("dotify", [value @ Value::Dict(_)]) => Ok(value.clone().wrapped()),
        ("arg", [Value::Text(argument)]) => context.argument(argument),
        ("print_location", _) => Ok(Value::text("")),
        ("message" | "warning" | "error" | "fatal", _) => {
            let mut text = String::new();
            for (i, argument) in arguments.iter().enumerate() {
                text.push_str(if i > 0 { " " } else { "" });
                let part = to_text(argument, context.budget())?;
                text.push_str(&part);
                context.budget().grown_text(text.len(), part.len())?;
            }
            match severity {
                Some(severity) => context.say(severity, &text),
                None => fail!("the file says: {text}"),
            }
            Ok(Value::text(""))
        }
        ("tokenize", [Value::Text(text), ..]) => {
            let option = |at: usize, key: &str| {
                let by_name = named.iter().find(|(name, _)| **name == *key).map(|(_, value)| value);
                arguments.get(at).or(by_name).cloned()
            };
            let separators = option(1, "sep").unwrap_or_else(|| Value::text(",; "));
            let Value::Text(separators) = separators else { fail!("tokenize() takes a str as its separators") };
            let keeps_empty = option(2, "skip_empty").is_some_and(|value| !value.is_true());
            let parts: Vec<&str> =
                text.split(|c| separators.contains(c)).filter(|part| keeps_empty || !part.is_empty()).collect();
            context.budget().items(parts.len())?;
            Value::list(parts.into_iter().map(Value::text).collect())
        }
        _ => fail!("xacro.{name}() cannot be called with {} arguments of these kinds", arguments.len()),
    }
}

/// Sorts pairs of a key and an item by key, equal ones in their order; returns the items. (The sort of the standard
/// library needs an order that cannot fail.)
fn sorted(mut pairs: Vec<(Value, Value)>, reverse: bool, budget: &mut Budget) -> Result<Vec<Value>> {
    let mut width = 1;
    while width < pairs.len() {
        let mut merged = Vec::with_capacity(pairs.len());
        let mut rest = pairs.into_iter().peekable();
        while rest.peek().is_some() {
            let mut left = rest.by_ref().take(width).collect::<Vec<_>>().into_iter().peekable();
            let mut right = rest.by_ref().take(width).collect::<Vec<_>>().into_iter().peekable();
            while let (Some((a, _)), Some((b, _))) = (left.peek(), right.peek()) {
                let order = if reverse { a.order(b, budget)? } else { b.order(a, budget)? };
                merged.extend(if order == Some(Ordering::Less) { right.next() } else { left.next() });
            }
            merged.extend(left);
            merged.extend(right);
        }
        pairs = merged;
        width *= 2;
    }
    Ok(pairs.into_iter().map(|(_, item)| item).collect())
}
