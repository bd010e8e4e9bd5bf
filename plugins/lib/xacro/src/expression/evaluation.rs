//! The value of an expression.

use std::rc::Rc;

use super::{
    context::Context,
    functions::{self, global, member},
    methods,
    operators::{binary, compare, index, slice},
    parser::parse,
    syntax::{Call, Expression, Operator},
};
use crate::{
    error::{Result, fail},
    value::{Dict, Entries, Value},
};

/// Attributes of dictionaries that are methods, whatever keys they have.
const DICT_METHODS: [&str; 11] =
    ["clear", "copy", "fromkeys", "get", "items", "keys", "pop", "popitem", "setdefault", "update", "values"];

/// Parses and evaluates a text, such as that between `${` and `}`.
pub(crate) fn evaluate(text: &str, context: &mut dyn Context) -> Result<Value> {
    context.budget().text(text.len())?;
    value(&parse(text)?, context)
}

fn value(expression: &Expression, context: &mut dyn Context) -> Result<Value> {
    context.budget().enter_expression()?;
    let result = value_inside(expression, context);
    context.budget().leave_expression();
    result
}

fn value_inside(expression: &Expression, context: &mut dyn Context) -> Result<Value> {
    match expression {
        Expression::Value(value) => Ok(value.clone()),
        Expression::Name(name) => match context.property(name)? {
            Some(value) => Ok(value),
            None => global(name, context),
        },
        Expression::Attribute(of, name) => {
            let of = value(of, context)?;
            attribute(&of, name, context)
        }
        Expression::Index(both) => {
            let (of, at) = pair(both, context)?;
            match (&of, &at) {
                (Value::Namespace(space), Value::Text(name)) => member(*space, name, context),
                _ => index(&of, &at, context.budget()),
            }
        }
        Expression::Slice(parts) => {
            let of = value(&parts.0, context)?;
            let mut bounds = [None, None, None];
            for (bound, part) in bounds.iter_mut().zip(&parts.1) {
                *bound = part.as_ref().map(|part| value(part, context)).transpose()?;
            }
            slice(&of, &bounds, context.budget())
        }
        Expression::Call(called) => call(called, context),
        Expression::Negative(of) => match value(of, context)? {
            Value::Float(float) => Ok(Value::Float(-float)),
            of if of.as_int().is_some() => binary(Operator::Subtract, &Value::Int(0), &of, context.budget()),
            of => fail!("`-` is not possible with a {}", of.kind()),
        },
        Expression::Positive(of) => match value(of, context)? {
            of @ Value::Float(_) => Ok(of),
            of => match of.as_int() {
                Some(int) => Ok(Value::Int(int)),
                None => fail!("`+` is not possible with a {}", of.kind()),
            },
        },
        Expression::Inverse(of) => {
            let of = value(of, context)?;
            match of.as_int() {
                Some(int) => Ok(Value::Int(!int)),
                None => fail!("`~` is not possible with a {}", of.kind()),
            }
        }
        Expression::Not(of) => Ok(Value::Bool(!value(of, context)?.is_true())),
        Expression::Binary(operator, both) => {
            let (a, b) = pair(both, context)?;
            binary(*operator, &a, &b, context.budget())
        }
        Expression::Comparison(chain) => {
            let mut left = value(&chain.0, context)?;
            for (comparator, right) in &chain.1 {
                let right = value(right, context)?;
                if !compare(*comparator, &left, &right, context.budget())? {
                    return Ok(Value::Bool(false));
                }
                left = right;
            }
            Ok(Value::Bool(true))
        }
        Expression::And(both) => {
            let first = value(&both.0, context)?;
            if first.is_true() { value(&both.1, context) } else { Ok(first) }
        }
        Expression::Or(both) => {
            let first = value(&both.0, context)?;
            if first.is_true() { Ok(first) } else { value(&both.1, context) }
        }
        Expression::Choice(parts) => {
            let [condition, yes, no] = &**parts;
            let chosen = if value(condition, context)?.is_true() { yes } else { no };
            value(chosen, context)
        }
        Expression::List(items) => Value::list(values(items, context)?),
        Expression::Tuple(items) => Value::tuple(values(items, context)?),
        Expression::Dict(pairs) => {
            let mut entries = Entries::default();
            for (key, entry) in pairs {
                let (key, entry) = (value(key, context)?, value(entry, context)?);
                entries.set(key, entry, context.budget())?;
            }
            Ok(Value::Dict(Dict::new(entries)))
        }
    }
}

fn pair(both: &(Expression, Expression), context: &mut dyn Context) -> Result<(Value, Value)> {
    Ok((value(&both.0, context)?, value(&both.1, context)?))
}

fn values(items: &[Expression], context: &mut dyn Context) -> Result<Vec<Value>> {
    context.budget().items(items.len())?;
    items.iter().map(|item| value(item, context)).collect()
}

/// `of.name` that is not called.
fn attribute(of: &Value, name: &Rc<str>, context: &mut dyn Context) -> Result<Value> {
    match of {
        Value::Namespace(space) => member(*space, name, context),
        Value::Dict(dict) if DICT_METHODS.contains(&&**name) => {
            let is_key = dict.entries().get(&Value::Text(name.clone()).as_key(context.budget())?).is_some();
            let advice = if is_key { format!("the key is read by ['{name}']") } else { format!("call {name}()") };
            fail!("`.{name}` is a method of dictionaries: {advice}")
        }
        Value::Dict(dict) if dict.from_yaml => index(of, &Value::Text(name.clone()), context.budget()),
        Value::Dict(_) => {
            fail!("`.{name}`: the keys of this dictionary are read by ['{name}'], or make it with xacro.dotify(...)")
        }
        other => fail!("a {} has no attribute `{name}`", other.kind()),
    }
}

fn call(called: &Call, context: &mut dyn Context) -> Result<Value> {
    // A method is looked up in the value before the dot.
    let (function, method_of) = match &called.function {
        Expression::Attribute(of, name) => match value(of, context)? {
            Value::Namespace(space) => (member(space, name, context)?, None),
            Value::Dict(dict) if dict.from_yaml && !DICT_METHODS.contains(&&**name) => {
                (attribute(&Value::Dict(dict), name, context)?, None)
            }
            of => (Value::None, Some((of, name))),
        },
        other => (value(other, context)?, None),
    };
    let arguments = values(&called.arguments, context)?;
    let mut named = Vec::new();
    for (name, argument) in &called.named {
        named.push((name.clone(), value(argument, context)?));
    }
    match (method_of, function) {
        (Some((of, name)), _) => methods::call(&of, name, &arguments, &named, context.budget()),
        (None, Value::Function(function)) => functions::call(function, &arguments, &named, context),
        (None, other) => fail!("a {} cannot be called", other.kind()),
    }
}
