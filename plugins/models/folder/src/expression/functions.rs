//! The functions of expressions. `libm` replaces those functions of the standard library whose results can differ
//! between platforms.

use super::value::ExpressionValue;
use crate::error::{ModelError, Result};

type UnaryFunction = fn(f64) -> f64;
/// The functions of one number, by name.
const UNARY_FUNCTIONS: &[(&str, UnaryFunction)] = &[
    ("abs", f64::abs),
    ("sqrt", libm::sqrt),
    ("sin", libm::sin),
    ("cos", libm::cos),
    ("tan", libm::tan),
    ("asin", libm::asin),
    ("acos", libm::acos),
    ("deg", f64::to_degrees),
    ("rad", f64::to_radians),
    ("floor", libm::floor),
    ("ceil", libm::ceil),
];

/// Names that parameters and constants cannot have.
pub const RESERVED: &[&str] = &[
    "abs", "sqrt", "sin", "cos", "tan", "asin", "acos", "deg", "rad", "floor", "ceil", "atan2", "min", "max", "len",
    "flat", "text", "if", "pi", "true", "false", "not", "and", "or", "for", "in", "index",
];

/// Names of all functions.
pub const FUNCTIONS: &[&str] = &[
    "abs", "sqrt", "sin", "cos", "tan", "asin", "acos", "deg", "rad", "floor", "ceil", "atan2", "min", "max", "len",
    "flat", "text", "if",
];

/// Calls a function with evaluated arguments. `if` is handled by the evaluator, which evaluates only the chosen value.
pub fn call(name: &str, args: &[ExpressionValue]) -> Result<ExpressionValue> {
    let wrong =
        |wanted: &str| ModelError::new(format!("`{name}` requires {wanted}, found {}", describe_arguments(args)));
    if let Some((_, function)) = UNARY_FUNCTIONS.iter().find(|(n, _)| *n == name) {
        let [ExpressionValue::Number(x)] = args else { return Err(wrong("one number")) };
        let y = function(*x);
        return match y.is_nan() {
            true => Err(ModelError::new(format!("`{name}({x})` is not defined"))),
            false => Ok(ExpressionValue::Number(y)),
        };
    }
    match name {
        "atan2" => match args {
            [ExpressionValue::Number(y), ExpressionValue::Number(x)] => {
                Ok(ExpressionValue::Number(libm::atan2(*y, *x)))
            }
            _ => Err(wrong("two numbers")),
        },
        "text" => match args {
            [ExpressionValue::Number(x)] => Ok(ExpressionValue::Text(format!("{x}"))),
            _ => Err(wrong("one number")),
        },
        "len" => match args {
            [ExpressionValue::List(all)] => Ok(ExpressionValue::Number(all.len() as f64)),
            _ => Err(wrong("one list")),
        },
        "flat" => {
            let inner =
                |v: &ExpressionValue| if let ExpressionValue::List(all) = v { all.clone() } else { vec![v.clone()] };
            match args {
                [ExpressionValue::List(all)] => Ok(ExpressionValue::List(all.iter().flat_map(inner).collect())),
                _ => Err(wrong("one list")),
            }
        }
        "min" | "max" => {
            let args = if let [ExpressionValue::List(all)] = args { all } else { args };
            let numbers = args.iter().map(|v| if let ExpressionValue::Number(x) = v { Some(*x) } else { None });
            let numbers = numbers.collect::<Option<Vec<f64>>>().ok_or_else(|| wrong("numbers"))?;
            let pick = |a: f64, b: f64| if (name == "min") == (b < a) { b } else { a };
            numbers.into_iter().reduce(pick).map(ExpressionValue::Number).ok_or_else(|| wrong("at least one number"))
        }
        _ => Err(ModelError::new(format!("there is no function `{name}`")).suggest(name, FUNCTIONS.iter().copied())),
    }
}

fn describe_arguments(args: &[ExpressionValue]) -> String {
    match args {
        [] => "nothing".to_owned(),
        args => args.iter().map(ExpressionValue::describe).collect::<Vec<_>>().join(", "),
    }
}
