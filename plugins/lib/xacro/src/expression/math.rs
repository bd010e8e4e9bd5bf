//! The functions and constants of `math`, with the same bits on all platforms.

use super::operators::power;
use crate::{
    error::{Result, fail},
    value::{
        Value,
        number::{float_text, truncated},
    },
};

/// The functions, without their namespace.
pub(super) const FUNCTIONS: [&str; 46] = [
    "acos",
    "acosh",
    "asin",
    "asinh",
    "atan",
    "atan2",
    "atanh",
    "cbrt",
    "ceil",
    "copysign",
    "cos",
    "cosh",
    "degrees",
    "erf",
    "erfc",
    "exp",
    "exp2",
    "expm1",
    "fabs",
    "factorial",
    "floor",
    "fmod",
    "gamma",
    "gcd",
    "hypot",
    "isclose",
    "isfinite",
    "isinf",
    "isnan",
    "isqrt",
    "ldexp",
    "lgamma",
    "log",
    "log10",
    "log1p",
    "log2",
    "pow",
    "radians",
    "remainder",
    "sin",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "trunc",
    "modf",
];

/// The functions that only this module has names for; others of Python are refused.
pub(super) const REFUSED: [&str; 10] =
    ["comb", "dist", "frexp", "fsum", "lcm", "nextafter", "perm", "prod", "sumprod", "ulp"];

pub(super) fn constant(name: &str) -> Option<f64> {
    Some(match name {
        "pi" => std::f64::consts::PI,
        "e" => std::f64::consts::E,
        "tau" => std::f64::consts::TAU,
        "inf" => f64::INFINITY,
        "nan" => f64::NAN,
        _ => return None,
    })
}

/// Calls a function of `FUNCTIONS`.
pub(super) fn call(name: &str, arguments: &[Value]) -> Result<Value> {
    let count = match name {
        "atan2" | "copysign" | "fmod" | "ldexp" | "pow" | "remainder" => 2..=2,
        "log" => 1..=2,
        "gcd" | "hypot" => 0..=64,
        "isclose" => 2..=2,
        _ => 1..=1,
    };
    if !count.contains(&arguments.len()) {
        fail!("{name}() takes {} arguments, not {}", count.end(), arguments.len());
    }
    if matches!(name, "factorial" | "gcd" | "isqrt") {
        return integers(name, arguments);
    }
    let mut floats = Vec::new();
    for argument in arguments {
        match argument.as_float() {
            Some(float) => floats.push(float),
            None => fail!("{name}() takes numbers, not a {}", argument.kind()),
        }
    }
    let x = floats.first().copied().unwrap_or(0.0);
    let y = floats.get(1).copied().unwrap_or(0.0);
    match name {
        "ceil" | "floor" | "trunc" if arguments[0].as_int().is_some() => {
            return Ok(Value::Int(arguments[0].as_int().unwrap_or(0)));
        }
        "ceil" => return truncated(x.ceil()).map(Value::Int),
        "floor" => return truncated(x.floor()).map(Value::Int),
        "trunc" => return truncated(x).map(Value::Int),
        "isnan" => return Ok(Value::Bool(x.is_nan())),
        "isinf" => return Ok(Value::Bool(x.is_infinite())),
        "isfinite" => return Ok(Value::Bool(x.is_finite())),
        "isclose" => {
            let near = (x - y).abs() <= 1e-9 * x.abs().max(y.abs());
            return Ok(Value::Bool(x == y || (x.is_finite() && y.is_finite() && near)));
        }
        "modf" => {
            let whole = x.trunc();
            let fraction = if x.is_infinite() { 0.0 } else { x - whole };
            return Value::tuple(vec![Value::Float(libm::copysign(fraction, x)), Value::Float(whole)]);
        }
        "pow" => return power(x, y).map(Value::Float),
        "log" | "log2" | "log10" | "log1p" if x <= if name == "log1p" { -1.0 } else { 0.0 } => {
            fail!("{name}({}) is not defined", float_text(x));
        }
        "log" if floats.len() == 2 => {
            if y <= 0.0 || y == 1.0 {
                fail!("log() with base {} is not defined", float_text(y));
            }
            return Ok(Value::Float(libm::log(x) / libm::log(y)));
        }
        "fmod" | "remainder" if y == 0.0 || x.is_infinite() => {
            fail!("{name}({}, {}) is not defined", float_text(x), float_text(y))
        }
        "hypot" => return Ok(Value::Float(hypot(&floats))),
        _ => {}
    }
    let result = of_floats(name, x, y);
    if result.is_nan() && floats.iter().all(|f| !f.is_nan()) {
        fail!("{name}({}) is not defined", float_text(x));
    }
    let is_pole = matches!(name, "atanh" | "gamma" | "lgamma") && result.is_infinite() && x.is_finite();
    let overflows = matches!(name, "exp" | "exp2" | "expm1" | "sinh" | "cosh" | "ldexp" | "gamma");
    if is_pole || (overflows && result.is_infinite() && x.is_finite()) {
        fail!("{name}({}) is too large for a number", float_text(x));
    }
    Ok(Value::Float(result))
}

fn of_floats(name: &str, x: f64, y: f64) -> f64 {
    match name {
        "acos" => libm::acos(x),
        "acosh" => libm::acosh(x),
        "asin" => libm::asin(x),
        "asinh" => libm::asinh(x),
        "atan" => libm::atan(x),
        "atan2" => libm::atan2(x, y),
        "atanh" => libm::atanh(x),
        "cbrt" => libm::cbrt(x),
        "copysign" => libm::copysign(x, y),
        "cos" => libm::cos(x),
        "cosh" => libm::cosh(x),
        "degrees" => x * (180.0 / std::f64::consts::PI),
        "erf" => libm::erf(x),
        "erfc" => libm::erfc(x),
        "exp" => libm::exp(x),
        "exp2" => libm::exp2(x),
        "expm1" => libm::expm1(x),
        "fabs" => x.abs(),
        "fmod" => libm::fmod(x, y),
        "gamma" => libm::tgamma(x),
        "ldexp" => libm::scalbn(x, y.clamp(-5000.0, 5000.0) as i32),
        "lgamma" => libm::lgamma(x),
        "log" => libm::log(x),
        "log10" => libm::log10(x),
        "log1p" => libm::log1p(x),
        "log2" => libm::log2(x),
        "radians" => x * (std::f64::consts::PI / 180.0),
        "remainder" => libm::remainder(x, y),
        "sin" => libm::sin(x),
        "sinh" => libm::sinh(x),
        "sqrt" => x.sqrt(),
        "tan" => libm::tan(x),
        "tanh" => libm::tanh(x),
        _ => f64::NAN,
    }
}

fn hypot(floats: &[f64]) -> f64 {
    match floats {
        [x, y] => libm::hypot(*x, *y),
        _ => {
            let greatest = floats.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if greatest == 0.0 || !greatest.is_finite() {
                return greatest;
            }
            greatest * floats.iter().map(|x| (x / greatest) * (x / greatest)).sum::<f64>().sqrt()
        }
    }
}

fn integers(name: &str, arguments: &[Value]) -> Result<Value> {
    let mut ints = Vec::new();
    for argument in arguments {
        match argument.as_int() {
            Some(int) => ints.push(int),
            None => fail!("{name}() takes integers, not a {}", argument.kind()),
        }
    }
    let first = ints.first().copied().unwrap_or(0);
    let result = match name {
        "gcd" => {
            let gcd = ints.iter().fold(0_u64, |a, b| {
                let (mut a, mut b) = (a, b.unsigned_abs());
                while b != 0 {
                    (a, b) = (b, a % b);
                }
                a
            });
            i64::try_from(gcd).ok()
        }
        _ if first < 0 => fail!("{name}({first}) is not defined"),
        "isqrt" => Some(first.isqrt()),
        _ => (1..=first).try_fold(1_i64, |product, factor| product.checked_mul(factor)),
    };
    match result {
        Some(int) => Ok(Value::Int(int)),
        None => fail!("{name}({first}) has more than 64 bits"),
    }
}
