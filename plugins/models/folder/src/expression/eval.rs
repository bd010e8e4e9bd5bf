//! Evaluation of expressions.

use std::{cell::Cell, collections::BTreeMap};

use super::{functions, parse::Tree, room::Room, value::Value};
use crate::wrong::{Result, Wrong};

/// The values of parameters and constants by name.
pub type Names = BTreeMap<String, Value>;

/// Maximum total number of values that the lists `[... for ...]` of an expression can compute.
const MOST_VALUES: usize = 10_000;

/// The names that a part of an expression can use, and the limits on its results.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    names: &'a Names,
    /// The variable of the innermost `for`, its value, and the enclosing scope.
    inner: Option<(&'a str, &'a Value, &'a Scope<'a>)>,
    /// Number of values that lists with `for` can still compute.
    left: &'a Cell<usize>,
    /// Limits the total size of results.
    room: &'a Room,
}

impl<'a> Scope<'a> {
    fn get(&self, name: &str) -> Option<&'a Value> {
        match self.inner {
            Some((inner, value, _)) if inner == name => Some(value),
            Some((_, _, outer)) => outer.get(name),
            None => self.names.get(name),
        }
    }
}

/// Evaluates an expression.
pub fn evaluated(tree: &Tree, names: &Names, room: &Room) -> Result<Value> {
    eval(tree, &Scope { names, inner: None, left: &Cell::new(MOST_VALUES), room })
}

fn eval(tree: &Tree, names: &Scope<'_>) -> Result<Value> {
    let value = match tree {
        Tree::Number(x) => Value::Number(*x),
        Tree::Text(t) => Value::Text(t.clone()),
        Tree::List(trees) => Value::List(all(trees, names)?),
        Tree::Name(name) => named(name, names)?,
        Tree::Call(name, args) if name == "if" => {
            let [condition, yes, no] = &args[..] else {
                return Err(Wrong::new(format!("`if` requires three arguments, but has {}", args.len()))
                    .help("if(condition, value if true, value if false)"));
            };
            return eval(if truth(&eval(condition, names)?, "the condition of `if`")? { yes } else { no }, names);
        }
        Tree::Call(name, args) => functions::call(name, &all(args, names)?)?,
        Tree::Each(each, name, list) => listed(each, name, &eval(list, names)?, names)?,
        Tree::Index(list, indices) => indexed(list, indices, names)?,
        Tree::Negative(tree) => scaled(eval(tree, names)?, &|x| Ok(-x), "-")?,
        Tree::Not(tree) => Value::Bool(!truth(&eval(tree, names)?, "the operand of `not`")?),
        Tree::Row(first, rest) => {
            let mut left = eval(first, names)?;
            for (operator, right) in rest {
                left = applied(operator, left, right, names)?;
            }
            return Ok(left);
        }
    };
    names.room.take(&value)?;
    Ok(value)
}

fn all(trees: &[Tree], names: &Scope<'_>) -> Result<Vec<Value>> {
    trees.iter().map(|t| eval(t, names)).collect()
}

/// Returns the element that a sequence of indices selects from a list and from the lists nested in it.
fn indexed(list: &Tree, indices: &[Tree], names: &Scope<'_>) -> Result<Value> {
    // A named list is borrowed, because copying a long list for one of its elements is expensive.
    let kept = if let Tree::Name(name) = list { names.get(name) } else { None };
    let computed = if kept.is_none() { Some(eval(list, names)?) } else { None };
    let Some(mut at) = kept.or(computed.as_ref()) else { return Err(Wrong::new("expected a list to index")) };
    for index in indices {
        at = element(at, &eval(index, names)?)?;
    }
    Ok(at.clone())
}

/// Applies an operator to a value and its right operand.
fn applied(operator: &str, left: Value, right: &Tree, names: &Scope<'_>) -> Result<Value> {
    let value = match operator {
        // The right operand is evaluated only if the left operand does not determine the result.
        "and" | "or" => {
            let side = format!("an operand of `{operator}`");
            let left = truth(&left, &side)?;
            Value::Bool(if left == (operator == "or") { left } else { truth(&eval(right, names)?, &side)? })
        }
        "==" | "!=" => Value::Bool(equal(&left, &eval(right, names)?)? == (operator == "==")),
        "<" | "<=" | ">" | ">=" => {
            let right = eval(right, names)?;
            let (Value::Number(a), Value::Number(b)) = (&left, &right) else {
                return Err(unfit(operator, &left, &right));
            };
            Value::Bool(match operator {
                "<" => a < b,
                "<=" => a <= b,
                ">" => a > b,
                _ => a >= b,
            })
        }
        _ => arithmetic(operator, left, eval(right, names)?)?,
    };
    names.room.take(&value)?;
    Ok(value)
}

/// Evaluates `each` for every element of a list, or for every integer from 0 to n - 1, and returns the list of results.
fn listed(each: &Tree, name: &str, of: &Value, scope: &Scope<'_>) -> Result<Value> {
    let value = |value: &Value| {
        let left = scope.left.get().checked_sub(1);
        scope
            .left
            .set(left.ok_or_else(|| Wrong::new(format!("lists with `for` compute more than {MOST_VALUES} values")))?);
        eval(each, &Scope { inner: Some((name, value, scope)), ..*scope })
    };
    match of {
        Value::List(all) => all.iter().map(value).collect::<Result<_>>().map(Value::List),
        Value::Number(n) if *n >= 0.0 && *n == libm::floor(*n) => {
            let n = n.min(MOST_VALUES as f64 + 1.0) as usize;
            (0..n).map(|i| value(&Value::Number(i as f64))).collect::<Result<_>>().map(Value::List)
        }
        other => {
            let wrong =
                Wrong::new(format!("`for {name} in`: expected a list or a whole number, found {}", other.describe()));
            Err(wrong.help(format!("`for {name} in 3` counts 0, 1, 2")))
        }
    }
}

fn named(name: &str, names: &Scope<'_>) -> Result<Value> {
    match (name, names.get(name)) {
        (_, Some(value)) => Ok(value.clone()),
        ("pi", _) => Ok(Value::Number(std::f64::consts::PI)),
        ("true", _) => Ok(Value::Bool(true)),
        ("false", _) => Ok(Value::Bool(false)),
        _ => {
            let known = names.names.keys().map(String::as_str).chain(["pi"]);
            Err(Wrong::new(format!("there is no parameter or number `{name}`")).known(name, known))
        }
    }
}

/// Returns the value of a boolean. For a value of another type, returns an error in which `what` describes its role.
pub fn truth(value: &Value, what: &str) -> Result<bool> {
    match value {
        Value::Bool(b) => Ok(*b),
        other => Err(Wrong::new(format!("{what} must be true or false, found {}", other.describe()))),
    }
}

fn element<'v>(list: &'v Value, index: &Value) -> Result<&'v Value> {
    let (Value::List(all), Value::Number(i)) = (list, index) else {
        let text = format!("cannot index {} with {}", list.describe(), index.describe());
        return Err(Wrong::new(text).help("only a list can be indexed, with an integer that counts from 0"));
    };
    let at = if *i >= 0.0 && *i == libm::floor(*i) { all.get(*i as usize) } else { None };
    at.ok_or_else(|| {
        let text = format!("index {i} is not valid for a list of length {}", all.len());
        Wrong::new(text).help("the index of an element is an integer that counts from 0")
    })
}

fn equal(a: &Value, b: &Value) -> Result<bool> {
    match (a, b) {
        (Value::Number(_), Value::Number(_))
        | (Value::Text(_), Value::Text(_))
        | (Value::Bool(_), Value::Bool(_))
        | (Value::List(_), Value::List(_)) => Ok(a == b),
        _ => Err(unfit("==", a, b)),
    }
}

fn unfit(operator: &str, a: &Value, b: &Value) -> Wrong {
    Wrong::new(format!("`{operator}` cannot be applied to {} and {}", a.describe(), b.describe()))
}

/// Applies a function to a number, or to each number in a list and in the lists nested in it.
fn scaled(value: Value, f: &dyn Fn(f64) -> Result<f64>, operator: &str) -> Result<Value> {
    match value {
        Value::Number(x) => f(x).map(Value::Number),
        Value::List(all) => all.into_iter().map(|v| scaled(v, f, operator)).collect::<Result<_>>().map(Value::List),
        other => Err(Wrong::new(format!("`{operator}` cannot be applied to {}", other.describe()))),
    }
}

/// Applies an arithmetic operator to numbers, to lists of equal length element by element, or to a list and a number.
/// `+` also concatenates strings.
fn arithmetic(operator: &str, left: Value, right: Value) -> Result<Value> {
    match (left, right) {
        (Value::Number(a), Value::Number(b)) => number(operator, a, b).map(Value::Number),
        (Value::List(a), Value::List(b)) if a.len() == b.len() && matches!(operator, "+" | "-") => {
            let pairs = a.into_iter().zip(b);
            pairs.map(|(a, b)| arithmetic(operator, a, b)).collect::<Result<_>>().map(Value::List)
        }
        (list @ Value::List(_), Value::Number(b)) if matches!(operator, "*" | "/") => {
            scaled(list, &|a| number(operator, a, b), operator)
        }
        (Value::Number(a), list @ Value::List(_)) if operator == "*" => {
            scaled(list, &|b| number(operator, a, b), operator)
        }
        (Value::Text(a), Value::Text(b)) if operator == "+" => Ok(Value::Text(a + &b)),
        (a, b) => Err(unfit(operator, &a, &b)),
    }
}

fn number(operator: &str, a: f64, b: f64) -> Result<f64> {
    let result = match operator {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" | "%" if b == 0.0 => return Err(Wrong::new(format!("division by zero: {a} {operator} 0"))),
        "/" => a / b,
        "%" => a - b * libm::floor(a / b),
        _ => libm::pow(a, b),
    };
    match result.is_finite() {
        true => Ok(result),
        false => Err(Wrong::new(format!("{a} {operator} {b} is not a finite number"))),
    }
}
