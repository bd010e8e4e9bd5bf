//! Reads `[model.params]`, the parameters of a model.

use std::ops::Range;

use tatu_plugin_api::safe::{Param, Value as Host};
use toml_edit::{Item, TableLike};

use crate::{
    error::{ModelError, Result},
    expression::{ExpressionValue, NamedValues, SizeBudget, evaluate},
    table::{
        NamedTable, check_keys, check_name, key_range, named_tables, optional_string, required_string, string_list,
    },
};

const PARAM_KEYS: &[&str] = &["type", "unit", "range", "default", "choices", "count", "text"];
const PARAM_TYPES: &[&str] = &["float", "int", "bool", "text", "floats", "list"];
/// Keys of every placed model, which cannot be names of parameters.
const RESERVED_KEYS: &[&str] = &[
    "model",
    "file",
    "alias",
    "parent",
    "position",
    "orientation",
    "quaternion",
    "script",
    "scripts",
    "set",
    "remove",
    "replace",
    "slots",
    "kind",
    "repeat",
];

/// A default that is computed from the parameters declared above it.
pub struct ComputedDefault {
    expression: String,
    span: Option<Range<usize>>,
    constraints: DefaultConstraints,
}

/// The part of a parameter's declaration that its default must satisfy.
struct DefaultConstraints {
    kind: String,
    count: u32,
    choices: Vec<String>,
    /// The declared parameter, if it has a range, which `Param::fill` checks.
    ranged: Option<Param>,
}

impl ComputedDefault {
    /// Computes the default from the values of the parameters above it.
    pub fn value(&self, names: &NamedValues, room: &SizeBudget) -> Result<ExpressionValue> {
        let value =
            evaluate(&self.expression, names, room).and_then(|v| check_default(&self.constraints, &v).map(|_| v));
        value.map_err(|e| e.at(self.span.clone()))
    }
}

/// Reads the parameters, in the order of the file.
pub fn read(table: Option<&dyn TableLike>) -> Result<Vec<(Param, Option<ComputedDefault>)>> {
    named_tables(table, "a parameter")?.into_iter().map(param).collect()
}

fn param((key, table, place): NamedTable<'_>) -> Result<(Param, Option<ComputedDefault>)> {
    let what = format!("the parameter `{key}`");
    check_name(key).map_err(|e| e.at(place.clone()))?;
    if RESERVED_KEYS.contains(&key) {
        let wrong = ModelError::new(format!("`{key}` cannot be a parameter, because every placed model has this key"));
        return Err(wrong.at(place));
    }
    check_keys(table, PARAM_KEYS, &what)?;
    let kind = required_string(table, "type", &what)
        .map_err(|e| e.help(format!("type = one of {}", PARAM_TYPES.join(", "))))?;
    let at = |key: &str| key_range(table, Some(key));
    let count = table.get("count").map_or(Some(0), |i| i.as_integer().and_then(|n| u32::try_from(n).ok()));
    let count = count.ok_or_else(|| ModelError::new("`count`: expected a whole number, at least 0").at(at("count")))?;
    let mut param = match kind.as_str() {
        "float" => Param::float(key),
        "int" => Param::int(key),
        "bool" => Param::bool(key),
        "text" => Param::string(key),
        "floats" => Param::floats(key, count),
        "list" => Param::list(key),
        other => {
            let wrong = ModelError::new(format!("{what}: there is no type `{other}`"));
            return Err(wrong.suggest(other, PARAM_TYPES.iter().copied()).at(at("type")));
        }
    };
    param = param.text(required_string(table, "text", &what)?);
    let unit = optional_string(table, "unit")?;
    if !unit.is_empty() {
        param = param.unit(unit);
    }
    if let Some(item) = table.get("range") {
        let ends: Option<Vec<f64>> = item.as_array().and_then(|a| a.iter().map(number).collect());
        let Some([low, high]) = ends.as_deref() else {
            return Err(ModelError::new("`range`: expected two numbers, the minimum and the maximum").at(at("range")));
        };
        if low > high {
            let wrong = ModelError::new(format!("`range`: the minimum {low} is greater than the maximum {high}"));
            return Err(wrong.at(at("range")));
        }
        param = param.range(*low, *high);
    }
    let choices = string_list(table, "choices")?;
    let default =
        table.get("default").and_then(Item::as_value).and_then(ExpressionValue::from_toml).ok_or_else(|| {
            let wrong = ModelError::new(format!("{what} has no default")).at(at("default"));
            wrong.help("every parameter must have a default, because a model can be placed without parameters")
        })?;
    let ranged = table.contains_key("range").then(|| param.clone());
    let declared = DefaultConstraints { kind, count, choices, ranged };
    param = param.choices_of(declared.choices.clone());
    let default = match default {
        ExpressionValue::Text(t) if t.starts_with("==") => ExpressionValue::Text(t[1..].to_owned()),
        ExpressionValue::Text(t) if t.starts_with('=') => {
            let computed =
                ComputedDefault { expression: t[1..].to_owned(), span: at("default"), constraints: declared };
            return Ok((param.optional(), Some(computed)));
        }
        other => other,
    };
    let fallback = check_default(&declared, &default).map_err(|e| e.at(at("default")))?;
    Ok((param.default(fallback), None))
}

fn number(value: &toml_edit::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// Converts a default to a value of the host, or returns an error if it does not satisfy the declaration.
fn check_default(declared: &DefaultConstraints, default: &ExpressionValue) -> Result<Host> {
    let DefaultConstraints { kind, count, choices, ranged } = declared;
    let wrong = |wanted: &str| ModelError::new(format!("`default`: expected {wanted}, found {}", default.describe()));
    let host = match (kind.as_str(), default, default.to_host()) {
        ("float", ExpressionValue::Number(_), host)
        | ("bool", ExpressionValue::Bool(_), host)
        | ("floats", _, host @ Host::Floats(_)) => host,
        ("int", ExpressionValue::Number(x), _) if *x == libm::floor(*x) => Host::Int(*x as i64),
        ("text", ExpressionValue::Text(t), host) if choices.is_empty() || choices.contains(t) => host,
        ("text", ExpressionValue::Text(_), _) => return Err(wrong(&format!("one of {}", choices.join(", ")))),
        ("list", ExpressionValue::List(_), host) => match host {
            Host::Floats(all) => Host::List(all.into_iter().map(Host::Float).collect()),
            host => host,
        },
        ("int", ..) => return Err(wrong("an integer")),
        ("bool", ..) => return Err(wrong("true or false")),
        ("text", ..) => return Err(wrong("a string")),
        ("floats", ..) => return Err(wrong("a list of numbers")),
        ("list", ..) => return Err(wrong("a list")),
        _ => return Err(wrong("a number")),
    };
    if let Host::Floats(all) = &host
        && *count != 0
        && all.len() != *count as usize
    {
        return Err(wrong(&format!("{count} numbers")));
    }
    if let Some(param) = ranged {
        let declared = [param.clone()];
        Param::fill(&declared, &[(param.key(), host.clone())]).map_err(|e| ModelError::new(e.text()))?;
    }
    Ok(host)
}
