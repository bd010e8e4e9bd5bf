//! Evaluation of expressions.

use std::collections::BTreeMap;

use super::{functions, parse::Tree, value::Value};
use crate::wrong::{Result, Wrong};

/// The values of names.
pub type Names = BTreeMap<String, Value>;

/// Evaluates an expression.
pub fn eval(tree: &Tree, names: &Names) -> Result<Value> {
    let all = |trees: &[Tree]| trees.iter().map(|t| eval(t, names)).collect::<Result<Vec<_>>>();
    match tree {
        Tree::Number(x) => Ok(Value::Number(*x)),
        Tree::Text(t) => Ok(Value::Text(t.clone())),
        Tree::List(trees) => all(trees).map(Value::List),
        Tree::Name(name) => named(name, names),
        Tree::Call(name, args) if name == "if" => {
            let [condition, yes, no] = &args[..] else {
                return Err(Wrong::new(format!("`if` takes a condition and two values, found {}", args.len())));
            };
            eval(if truth(&eval(condition, names)?, "the condition of `if`")? { yes } else { no }, names)
        }
        Tree::Call(name, args) => functions::call(name, &all(args)?),
        Tree::Index(list, index) => element(eval(list, names)?, &eval(index, names)?),
        Tree::Negative(tree) => scaled(eval(tree, names)?, &|x| Ok(-x), "-"),
        Tree::Not(tree) => truth(&eval(tree, names)?, "what follows `not`").map(|b| Value::Bool(!b)),
        // The right side of these counts only if the left one does not decide.
        Tree::Both(operator @ ("and" | "or"), left, right) => {
            let side = format!("a side of `{operator}`");
            let left = truth(&eval(left, names)?, &side)?;
            if left == (*operator == "or") {
                return Ok(Value::Bool(left));
            }
            truth(&eval(right, names)?, &side).map(Value::Bool)
        }
        Tree::Both(operator @ ("==" | "!="), left, right) => {
            let same = equal(&eval(left, names)?, &eval(right, names)?)?;
            Ok(Value::Bool(same == (*operator == "==")))
        }
        Tree::Both(operator @ ("<" | "<=" | ">" | ">="), left, right) => {
            let (left, right) = (eval(left, names)?, eval(right, names)?);
            let (Value::Number(a), Value::Number(b)) = (&left, &right) else {
                return Err(unfit(operator, &left, &right));
            };
            Ok(Value::Bool(match *operator {
                "<" => a < b,
                "<=" => a <= b,
                ">" => a > b,
                _ => a >= b,
            }))
        }
        Tree::Both(operator, left, right) => arithmetic(operator, eval(left, names)?, eval(right, names)?),
    }
}

fn named(name: &str, names: &Names) -> Result<Value> {
    match (name, names.get(name)) {
        (_, Some(value)) => Ok(value.clone()),
        ("pi", _) => Ok(Value::Number(std::f64::consts::PI)),
        ("true", _) => Ok(Value::Bool(true)),
        ("false", _) => Ok(Value::Bool(false)),
        _ => {
            let known = names.keys().map(String::as_str).chain(["pi"]);
            Err(Wrong::new(format!("there is no parameter or number `{name}`")).known(name, known))
        }
    }
}

/// Returns a value as true or false.
pub fn truth(value: &Value, what: &str) -> Result<bool> {
    match value {
        Value::Bool(b) => Ok(*b),
        other => Err(Wrong::new(format!("{what} must be true or false, found {}", other.describe()))),
    }
}

fn element(list: Value, index: &Value) -> Result<Value> {
    let (Value::List(mut all), Value::Number(i)) = (list.clone(), index) else {
        let text = format!("an element of {} cannot be taken by {}", list.describe(), index.describe());
        return Err(Wrong::new(text).help("elements of lists are numbered from 0"));
    };
    if *i < 0.0 || *i >= all.len() as f64 || *i != libm::floor(*i) {
        let text = format!("there is no element {i} in a list of {}", all.len());
        return Err(Wrong::new(text).help("elements of lists are numbered from 0"));
    }
    Ok(all.swap_remove(*i as usize))
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
    Wrong::new(format!("`{operator}` does not work between {} and {}", a.describe(), b.describe()))
}

/// Applies a function to a number, or to each number of a list.
fn scaled(value: Value, f: &dyn Fn(f64) -> Result<f64>, operator: &str) -> Result<Value> {
    match value {
        Value::Number(x) => f(x).map(Value::Number),
        Value::List(all) => all.into_iter().map(|v| scaled(v, f, operator)).collect::<Result<_>>().map(Value::List),
        other => Err(Wrong::new(format!("`{operator}` does not work with {}", other.describe()))),
    }
}

/// Computes with numbers, with lists of equal length element by element, and with a list and a number.
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
