//! The command `tatu.options`, which returns the options with which an add-on was started.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Offer, Param, Result, Value, ValueRef},
};

use crate::plugin::{Cmd, Ctx, Tatu};

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.options", |c| {
            let given = given_options(c)?;
            let options = match c.arg(0) {
                defaults if defaults.is_nil() || defaults.tag() == TATU_LIST && defaults.is_empty() => given,
                defaults => merge_options(defaults, &given)?,
            };
            c.ret(Value::Map(options));
            Ok(())
        })
        .param(Param::any("defaults").optional().text("a table of the known options and their default values"))
        .returns(Param::map("options").text("values of the same types as the defaults; without defaults: strings"))
        .text("Returns the options with which the calling script was started: `--addon NAME:KEY=VALUE,KEY=VALUE`.")
        .example(
            "local o = tatu.options{period = 0.5, file = 'out.csv'}\nassert(o.period == 0.5 and o.file == 'out.csv')",
        ),
    );
}

/// Returns the options with which the calling script was started, with strings as values.
fn given_options(c: &Ctx<'_>) -> Result<Vec<(Value, Value)>> {
    if c.caller_script() == 0 {
        return Ok(Vec::new());
    }
    match c.world().script_options(c.caller_script())?.to_value()? {
        Value::Map(all) => Ok(all),
        _ => Ok(Vec::new()),
    }
}

/// Returns the defaults, overridden by the given options. Each option is converted to the type of its default.
fn merge_options(defaults: ValueRef<'_>, given: &[(Value, Value)]) -> Result<Vec<(Value, Value)>> {
    let Value::Map(mut out) = defaults.to_value()? else {
        return Err(Fail::argument("argument 1: expected a table with string keys, such as {period = 0.5}"));
    };
    for (key, value) in given {
        let (Value::Text(key), Value::Text(text)) = (key, value) else { continue };
        let slot = out.iter_mut().find(|(k, _)| matches!(k, Value::Text(k) if k == key));
        let Some((_, slot)) = slot else {
            let mut known: Vec<String> = out.iter().filter_map(|(k, _)| key_of(k)).collect();
            known.sort();
            let key = String::from_utf8_lossy(key);
            return Err(Fail::argument(format!("there is no option `{key}`; expected one of: {}", known.join(", "))));
        };
        *slot = converted(slot, text).ok_or_else(|| {
            let (key, text) = (String::from_utf8_lossy(key), String::from_utf8_lossy(text));
            Fail::argument(format!("option `{key}`: expected {}, found `{text}`", kind(slot)))
        })?;
    }
    Ok(out)
}

fn key_of(key: &Value) -> Option<String> {
    match key {
        Value::Text(k) => Some(String::from_utf8_lossy(k).into_owned()),
        _ => None,
    }
}

fn converted(default: &Value, text: &[u8]) -> Option<Value> {
    let str = std::str::from_utf8(text).ok().map(str::trim);
    match default {
        Value::Bool(_) => match str? {
            "true" | "yes" | "1" => Some(Value::Bool(true)),
            "false" | "no" | "0" => Some(Value::Bool(false)),
            _ => None,
        },
        // A script can write `period = 1` as the default of any number, so an integer default also accepts a fraction.
        Value::Int(_) => {
            let float = || str?.parse().ok().filter(|x: &f64| x.is_finite()).map(Value::Float);
            str?.parse().ok().map(Value::Int).or_else(float)
        }
        Value::Float(_) => str?.parse().ok().filter(|x: &f64| x.is_finite()).map(Value::Float),
        _ => Some(Value::Text(text.to_vec())),
    }
}

fn kind(default: &Value) -> &'static str {
    match default {
        Value::Bool(_) => "true or false",
        Value::Int(_) | Value::Float(_) => "a number",
        _ => "a string",
    }
}

#[cfg(test)]
mod tests {
    use tatu_plugin_api::safe::Owned;

    use super::*;

    fn pairs(all: &[(&str, Value)]) -> Vec<(Value, Value)> {
        all.iter().map(|(k, v)| (Value::text(k), v.clone())).collect()
    }

    #[test]
    fn options_are_converted_to_the_types_of_their_defaults() {
        assert_eq!(converted(&Value::Int(1), b"2"), Some(Value::Int(2)));
        assert_eq!(converted(&Value::Int(1), b"0.5"), Some(Value::Float(0.5)));
        assert_eq!(converted(&Value::Float(1.5), b" 2 "), Some(Value::Float(2.0)));
        assert_eq!(converted(&Value::Float(1.5), b"inf"), None);
        assert_eq!(converted(&Value::Bool(false), b"yes"), Some(Value::Bool(true)));
        assert_eq!(converted(&Value::Bool(false), b"perhaps"), None);
        assert_eq!(converted(&Value::text("a"), b"7"), Some(Value::text("7")));
    }

    #[test]
    fn unknown_option_is_an_error_that_lists_the_known_ones() {
        let defaults = Value::Map(pairs(&[("period", Value::Float(0.5)), ("file", Value::text("a.csv"))]));
        let mut owned = Owned::default();
        let defaults = owned.value(&defaults);
        let out = merge_options(defaults, &pairs(&[("period", Value::text("2"))])).unwrap();
        assert!(out.contains(&(Value::text("period"), Value::Float(2.0))));
        assert!(out.contains(&(Value::text("file"), Value::text("a.csv"))));
        let wrong = merge_options(defaults, &pairs(&[("perid", Value::text("2"))])).unwrap_err().to_string();
        assert!(wrong.contains("`perid`") && wrong.contains("file, period"), "{wrong}");
        let wrong = merge_options(defaults, &pairs(&[("period", Value::text("often"))])).unwrap_err().to_string();
        assert!(wrong.contains("expected a number, found `often`"), "{wrong}");
    }
}
