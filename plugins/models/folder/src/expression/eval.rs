//! Evaluation of expressions.

use std::{cell::Cell, collections::BTreeMap};

use super::{budget::SizeBudget, functions, parse::ExpressionTree, value::ExpressionValue};
use crate::error::{ModelError, Result};

/// The values of parameters and constants by name.
pub type NamedValues = BTreeMap<String, ExpressionValue>;

/// Maximum total number of values that the lists `[... for ...]` of an expression can compute.
const MAX_LOOP_VALUES: usize = 10_000;

/// The names that a part of an expression can use, and the limits on its results.
#[derive(Clone, Copy)]
pub struct EvaluationScope<'a> {
    names: &'a NamedValues,
    /// The variable of the innermost `for`, its value, and the enclosing scope.
    inner: Option<(&'a str, &'a ExpressionValue, &'a EvaluationScope<'a>)>,
    /// Number of values that lists with `for` can still compute.
    values_left: &'a Cell<usize>,
    /// Limits the total size of results.
    budget: &'a SizeBudget,
}

impl<'a> EvaluationScope<'a> {
    fn get(&self, name: &str) -> Option<&'a ExpressionValue> {
        match self.inner {
            Some((inner, value, _)) if inner == name => Some(value),
            Some((_, _, outer)) => outer.get(name),
            None => self.names.get(name),
        }
    }
}

/// Evaluates an expression. Fails if a name is unknown, a value has the wrong type, or a limit is exceeded.
pub fn evaluate_tree(tree: &ExpressionTree, names: &NamedValues, room: &SizeBudget) -> Result<ExpressionValue> {
    eval(tree, &EvaluationScope { names, inner: None, values_left: &Cell::new(MAX_LOOP_VALUES), budget: room })
}

fn eval(tree: &ExpressionTree, names: &EvaluationScope<'_>) -> Result<ExpressionValue> {
    let value = match tree {
        ExpressionTree::Number(x) => ExpressionValue::Number(*x),
        ExpressionTree::Text(t) => ExpressionValue::Text(t.clone()),
        ExpressionTree::List(trees) => ExpressionValue::List(eval_all(trees, names)?),
        ExpressionTree::Name(name) => eval_name(name, names)?,
        ExpressionTree::Call(name, args) if name == "if" => {
            let [condition, yes, no] = &args[..] else {
                return Err(ModelError::new(format!("`if` requires three arguments, but has {}", args.len()))
                    .help("if(condition, value if true, value if false)"));
            };
            return eval(if expect_bool(&eval(condition, names)?, "the condition of `if`")? { yes } else { no }, names);
        }
        ExpressionTree::Call(name, args) => functions::call(name, &eval_all(args, names)?)?,
        ExpressionTree::Each(each, name, list) => eval_each(each, name, &eval(list, names)?, names)?,
        ExpressionTree::Index(list, indices) => eval_index(list, indices, names)?,
        ExpressionTree::Negative(tree) => map_numbers(eval(tree, names)?, &|x| Ok(-x), "-")?,
        ExpressionTree::Not(tree) => ExpressionValue::Bool(!expect_bool(&eval(tree, names)?, "the operand of `not`")?),
        ExpressionTree::Chain(first, rest) => {
            let mut left = eval(first, names)?;
            for (operator, right) in rest {
                left = apply_operator(operator, left, right, names)?;
            }
            return Ok(left);
        }
    };
    names.budget.spend(&value)?;
    Ok(value)
}

fn eval_all(trees: &[ExpressionTree], names: &EvaluationScope<'_>) -> Result<Vec<ExpressionValue>> {
    trees.iter().map(|t| eval(t, names)).collect()
}

/// Returns the element that a sequence of indices selects from a list and from the lists nested in it.
fn eval_index(
    list: &ExpressionTree,
    indices: &[ExpressionTree],
    names: &EvaluationScope<'_>,
) -> Result<ExpressionValue> {
    // A named list is borrowed, because copying a long list for one of its elements is expensive.
    let kept = if let ExpressionTree::Name(name) = list { names.get(name) } else { None };
    let computed = if kept.is_none() { Some(eval(list, names)?) } else { None };
    let Some(mut at) = kept.or(computed.as_ref()) else { return Err(ModelError::new("expected a list to index")) };
    for index in indices {
        at = element(at, &eval(index, names)?)?;
    }
    Ok(at.clone())
}

/// Applies an operator to a value and its right operand.
fn apply_operator(
    operator: &str,
    left: ExpressionValue,
    right: &ExpressionTree,
    names: &EvaluationScope<'_>,
) -> Result<ExpressionValue> {
    let value = match operator {
        // The right operand is evaluated only if the left operand does not determine the result.
        "and" | "or" => {
            let side = format!("an operand of `{operator}`");
            let left = expect_bool(&left, &side)?;
            ExpressionValue::Bool(if left == (operator == "or") {
                left
            } else {
                expect_bool(&eval(right, names)?, &side)?
            })
        }
        "==" | "!=" => ExpressionValue::Bool(equal(&left, &eval(right, names)?)? == (operator == "==")),
        "<" | "<=" | ">" | ">=" => {
            let right = eval(right, names)?;
            let (ExpressionValue::Number(a), ExpressionValue::Number(b)) = (&left, &right) else {
                return Err(operator_error(operator, &left, &right));
            };
            ExpressionValue::Bool(match operator {
                "<" => a < b,
                "<=" => a <= b,
                ">" => a > b,
                _ => a >= b,
            })
        }
        _ => arithmetic(operator, left, eval(right, names)?)?,
    };
    names.budget.spend(&value)?;
    Ok(value)
}

/// Evaluates `each` for every element of a list, or for every integer from 0 to n - 1, and returns the list of results.
fn eval_each(
    each: &ExpressionTree,
    name: &str,
    of: &ExpressionValue,
    scope: &EvaluationScope<'_>,
) -> Result<ExpressionValue> {
    let value =
        |value: &ExpressionValue| {
            let left = scope.values_left.get().checked_sub(1);
            scope.values_left.set(left.ok_or_else(|| {
                ModelError::new(format!("lists with `for` compute more than {MAX_LOOP_VALUES} values"))
            })?);
            eval(each, &EvaluationScope { inner: Some((name, value, scope)), ..*scope })
        };
    match of {
        ExpressionValue::List(all) => all.iter().map(value).collect::<Result<_>>().map(ExpressionValue::List),
        ExpressionValue::Number(n) if *n >= 0.0 && *n == libm::floor(*n) => {
            let n = n.min(MAX_LOOP_VALUES as f64 + 1.0) as usize;
            (0..n).map(|i| value(&ExpressionValue::Number(i as f64))).collect::<Result<_>>().map(ExpressionValue::List)
        }
        other => {
            let wrong = ModelError::new(format!(
                "`for {name} in`: expected a list or a whole number, found {}",
                other.describe()
            ));
            Err(wrong.help(format!("`for {name} in 3` counts 0, 1, 2")))
        }
    }
}

fn eval_name(name: &str, names: &EvaluationScope<'_>) -> Result<ExpressionValue> {
    match (name, names.get(name)) {
        (_, Some(value)) => Ok(value.clone()),
        ("pi", _) => Ok(ExpressionValue::Number(std::f64::consts::PI)),
        ("true", _) => Ok(ExpressionValue::Bool(true)),
        ("false", _) => Ok(ExpressionValue::Bool(false)),
        _ => {
            let known = names.names.keys().map(String::as_str).chain(["pi"]);
            Err(ModelError::new(format!("there is no parameter or number `{name}`")).suggest(name, known))
        }
    }
}

/// Returns the value of a boolean. For a value of another type, returns an error in which `what` describes its role.
pub fn expect_bool(value: &ExpressionValue, what: &str) -> Result<bool> {
    match value {
        ExpressionValue::Bool(b) => Ok(*b),
        other => Err(ModelError::new(format!("{what} must be true or false, found {}", other.describe()))),
    }
}

fn element<'v>(list: &'v ExpressionValue, index: &ExpressionValue) -> Result<&'v ExpressionValue> {
    let (ExpressionValue::List(all), ExpressionValue::Number(i)) = (list, index) else {
        let text = format!("cannot index {} with {}", list.describe(), index.describe());
        return Err(ModelError::new(text).help("only a list can be indexed, with an integer that counts from 0"));
    };
    let at = if *i >= 0.0 && *i == libm::floor(*i) { all.get(*i as usize) } else { None };
    at.ok_or_else(|| {
        let text = format!("index {i} is not valid for a list of length {}", all.len());
        ModelError::new(text).help("the index of an element is an integer that counts from 0")
    })
}

fn equal(a: &ExpressionValue, b: &ExpressionValue) -> Result<bool> {
    match (a, b) {
        (ExpressionValue::Number(_), ExpressionValue::Number(_))
        | (ExpressionValue::Text(_), ExpressionValue::Text(_))
        | (ExpressionValue::Bool(_), ExpressionValue::Bool(_))
        | (ExpressionValue::List(_), ExpressionValue::List(_)) => Ok(a == b),
        _ => Err(operator_error("==", a, b)),
    }
}

fn operator_error(operator: &str, a: &ExpressionValue, b: &ExpressionValue) -> ModelError {
    ModelError::new(format!("`{operator}` cannot be applied to {} and {}", a.describe(), b.describe()))
}

/// Applies a function to a number, or to each number in a list and in the lists nested in it.
fn map_numbers(value: ExpressionValue, f: &dyn Fn(f64) -> Result<f64>, operator: &str) -> Result<ExpressionValue> {
    match value {
        ExpressionValue::Number(x) => f(x).map(ExpressionValue::Number),
        ExpressionValue::List(all) => {
            all.into_iter().map(|v| map_numbers(v, f, operator)).collect::<Result<_>>().map(ExpressionValue::List)
        }
        other => Err(ModelError::new(format!("`{operator}` cannot be applied to {}", other.describe()))),
    }
}

/// Applies an arithmetic operator to numbers, to lists of equal length element by element, or to a list and a number.
/// `+` also concatenates strings.
fn arithmetic(operator: &str, left: ExpressionValue, right: ExpressionValue) -> Result<ExpressionValue> {
    match (left, right) {
        (ExpressionValue::Number(a), ExpressionValue::Number(b)) => number(operator, a, b).map(ExpressionValue::Number),
        (ExpressionValue::List(a), ExpressionValue::List(b)) if a.len() == b.len() && matches!(operator, "+" | "-") => {
            let pairs = a.into_iter().zip(b);
            pairs.map(|(a, b)| arithmetic(operator, a, b)).collect::<Result<_>>().map(ExpressionValue::List)
        }
        (list @ ExpressionValue::List(_), ExpressionValue::Number(b)) if matches!(operator, "*" | "/") => {
            map_numbers(list, &|a| number(operator, a, b), operator)
        }
        (ExpressionValue::Number(a), list @ ExpressionValue::List(_)) if operator == "*" => {
            map_numbers(list, &|b| number(operator, a, b), operator)
        }
        (ExpressionValue::Text(a), ExpressionValue::Text(b)) if operator == "+" => Ok(ExpressionValue::Text(a + &b)),
        (a, b) => Err(operator_error(operator, &a, &b)),
    }
}

fn number(operator: &str, a: f64, b: f64) -> Result<f64> {
    let result = match operator {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" | "%" if b == 0.0 => return Err(ModelError::new(format!("division by zero: {a} {operator} 0"))),
        "/" => a / b,
        "%" => a - b * libm::floor(a / b),
        _ => libm::pow(a, b),
    };
    match result.is_finite() {
        true => Ok(result),
        false => Err(ModelError::new(format!("{a} {operator} {b} is not a finite number"))),
    }
}
