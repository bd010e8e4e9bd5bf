//! Numbers as Python writes, reads, divides, compares and rounds them.

use std::cmp::Ordering;

use crate::error::{Result, fail};

/// Returns a number as Python writes it: the shortest text that is read as the same number.
pub(crate) fn float_text(value: f64) -> String {
    if value.is_nan() {
        return "nan".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "inf" } else { "-inf" }.to_owned();
    }
    let scientific = format!("{value:e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..16).contains(&exponent) {
        let plain = format!("{value}");
        if plain.contains('.') { plain } else { plain + ".0" }
    } else {
        let sign = if exponent < 0 { '-' } else { '+' };
        format!("{mantissa}e{sign}{:02}", exponent.abs())
    }
}

/// Reads a text as `int()` does; `None` if it is none or has more than 64 bits.
pub(crate) fn int_from_text(text: &str) -> Option<i64> {
    let text = text.trim();
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    without_underscores(digits)?;
    let digits: String = text.chars().filter(|c| *c != '_').collect();
    digits.parse().ok()
}

/// Whether a text consists of digits with single underscores between them.
fn without_underscores(digits: &str) -> Option<()> {
    let mut after_digit = false;
    for c in digits.chars() {
        match c {
            '0'..='9' => after_digit = true,
            '_' if after_digit => after_digit = false,
            _ => return None,
        }
    }
    after_digit.then_some(())
}

/// Reads a text as `float()` does.
pub(crate) fn float_from_text(text: &str) -> Option<f64> {
    let text = text.trim();
    let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
    let is_word = ["inf", "infinity", "nan"].iter().any(|word| unsigned.eq_ignore_ascii_case(word));
    if !is_word && !unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return None;
    }
    let mut last = ' ';
    for c in unsigned.chars() {
        if (c == '_' || last == '_') && !(if c == '_' { last } else { c }).is_ascii_digit() {
            return None;
        }
        last = c;
    }
    if last == '_' {
        return None;
    }
    let value: f64 = text.chars().filter(|c| *c != '_').collect::<String>().parse().ok()?;
    Some(value)
}

/// Returns a float as an integer if it is one of 64 bits.
pub(crate) fn exact_int(value: f64) -> Option<i64> {
    // 2^63 itself is not in the range; its negative is.
    const END: f64 = 9_223_372_036_854_775_808.0;
    (value.trunc() == value && (-END..END).contains(&value)).then_some(value as i64)
}

/// A number with its kind.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Number {
    Int(i64),
    Float(f64),
}

/// The order of two numbers; `None` with NaN.
pub(crate) fn compare(a: Number, b: Number) -> Option<Ordering> {
    match (a, b) {
        (Number::Int(a), Number::Int(b)) => Some(a.cmp(&b)),
        (Number::Int(a), Number::Float(b)) => int_with_float(a, b),
        (Number::Float(a), Number::Int(b)) => int_with_float(b, a).map(Ordering::reverse),
        (Number::Float(a), Number::Float(b)) => a.partial_cmp(&b),
    }
}

/// Compares exactly, also where integers are denser than floats.
fn int_with_float(a: i64, b: f64) -> Option<Ordering> {
    if b.is_nan() {
        return None;
    }
    Some(match exact_int(b.floor()) {
        Some(floor) => a.cmp(&floor).then(if b > b.floor() { Ordering::Less } else { Ordering::Equal }),
        None if b > 0.0 => Ordering::Less,
        None => Ordering::Greater,
    })
}

/// Divides integers with one rounding.
pub(crate) fn divide_ints(a: i64, b: i64) -> f64 {
    let is_negative = (a < 0) != (b < 0);
    let (a, b) = (u128::from(a.unsigned_abs()), u128::from(b.unsigned_abs()));
    if a == 0 {
        return if is_negative { -0.0 } else { 0.0 };
    }
    // The quotient has at least 63 bits; the last one tells whether something remains.
    let shift = a.leading_zeros();
    let shifted = a << shift;
    let quotient = (shifted / b) | u128::from(shifted % b != 0);
    let value = libm::scalbn(quotient as f64, -(shift as i32));
    if is_negative { -value } else { value }
}

/// `a ** b` for small integers `b`, rounded once, as nearly always by the C library that Python uses; the last bit of
/// `libm::pow` differs from it in one result of ten. `None` where intermediate results could be too large or too small.
pub(crate) fn small_power(a: f64, b: f64) -> Option<f64> {
    const MAX_EXPONENT: f64 = 32.0;
    const MAX_RESULT: f64 = 1e140;
    if b.trunc() != b || b.abs() > MAX_EXPONENT || b == 0.0 || !a.is_finite() {
        return None;
    }
    // The product is `high + low`, with twice the digits.
    let (mut high, mut low) = (1.0_f64, 0.0_f64);
    for _ in 0..b.abs() as u32 {
        let product = high * a;
        let error = libm::fma(high, a, -product) + low * a;
        high = product + error;
        low = error - (high - product);
        if !(1.0 / MAX_RESULT..MAX_RESULT).contains(&high.abs()) {
            return None;
        }
    }
    if b > 0.0 {
        return Some(high);
    }
    let inverse = 1.0 / high;
    Some(inverse + inverse * (libm::fma(-inverse, high, 1.0) - inverse * low))
}

/// Floor and remainder of a division of floats, whose signs are those of the divisor.
pub(crate) fn divide_floats(a: f64, b: f64) -> (f64, f64) {
    let mut rest = libm::fmod(a, b);
    let mut quotient = (a - rest) / b;
    if rest != 0.0 {
        if (b < 0.0) != (rest < 0.0) {
            rest += b;
            quotient -= 1.0;
        }
    } else {
        rest = libm::copysign(0.0, b);
    }
    let floor = if quotient != 0.0 {
        let floor = quotient.floor();
        if quotient - floor > 0.5 { floor + 1.0 } else { floor }
    } else {
        libm::copysign(0.0, a / b)
    };
    (floor, rest)
}

/// The integer part of a number.
pub(crate) fn truncated(value: f64) -> Result<i64> {
    match exact_int(value.trunc()) {
        Some(int) => Ok(int),
        None if value.is_finite() => fail!("{} has more than 64 bits as an integer", float_text(value)),
        None => fail!("{} is no integer", float_text(value)),
    }
}

/// Rounds to an integer, halves to the even one.
pub(crate) fn round_to_int(value: f64) -> Result<i64> {
    match exact_int(value.round_ties_even()) {
        Some(int) => Ok(int),
        None if value.is_finite() => fail!("{} has more than 64 bits as an integer", float_text(value)),
        None => fail!("{} cannot be rounded to an integer", float_text(value)),
    }
}

/// Rounds to decimal places, exact halves to the even digit.
pub(crate) fn round_to_places(value: f64, places: i64) -> f64 {
    if !value.is_finite() || places > 323 {
        return value;
    }
    if places >= 0 {
        return format!("{value:.*}", places as usize).parse().unwrap_or(value);
    }
    if places < -308 {
        return libm::copysign(0.0, value);
    }
    // All digits of the number: what remains below the place decides exactly.
    let exact = format!("{:.1074}", value.abs());
    let (whole, fraction) = exact.split_once('.').unwrap_or((&exact, ""));
    let padded = format!("{whole:0>width$}", width = places.unsigned_abs() as usize + 1);
    let (head, tail) = padded.split_at(padded.len() - places.unsigned_abs() as usize);
    let is_odd = head.ends_with(['1', '3', '5', '7', '9']);
    let rest_is_zero = |digits: &str| digits.bytes().all(|b| b == b'0');
    let rounds_up = match tail.as_bytes().first().copied().unwrap_or(b'0') {
        b'5' if rest_is_zero(&tail[1..]) && rest_is_zero(fraction) => is_odd,
        first => first >= b'5',
    };
    let mut digits = head.as_bytes().to_vec();
    if rounds_up {
        let mut at = digits.len();
        loop {
            if at == 0 {
                digits.insert(0, b'1');
                break;
            }
            at -= 1;
            if digits[at] == b'9' {
                digits[at] = b'0';
            } else {
                digits[at] += 1;
                break;
            }
        }
    }
    let digits = String::from_utf8(digits).unwrap_or_default();
    let rounded = format!("{digits}e{}", places.unsigned_abs()).parse().unwrap_or(value);
    libm::copysign(rounded, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_written_as_python_writes_them() {
        let expected = [
            (1.0, "1.0"),
            (-0.0, "-0.0"),
            (0.1 + 0.2, "0.30000000000000004"),
            (1e15, "1000000000000000.0"),
            (1e16, "1e+16"),
            (1.5e-7, "1.5e-07"),
            (0.0001, "0.0001"),
            (0.00001, "1e-05"),
            (1.7976931348623157e308, "1.7976931348623157e+308"),
            (f64::INFINITY, "inf"),
        ];
        for (value, text) in expected {
            assert_eq!(float_text(value), text);
        }
    }

    #[test]
    fn texts_are_read_as_python_reads_them() {
        assert_eq!(int_from_text(" 007 "), Some(7));
        assert_eq!(int_from_text("-1_000"), Some(-1000));
        assert_eq!(["", "1__0", "_1", "1_", "0x10", "1.0", "+-1"].map(int_from_text), [None; 7]);
        assert_eq!(float_from_text("1e3"), Some(1000.0));
        assert_eq!(float_from_text("-.5"), Some(-0.5));
        assert_eq!(float_from_text("5."), Some(5.0));
        assert_eq!(float_from_text("-Infinity"), Some(f64::NEG_INFINITY));
        assert_eq!(["", ".", "e3", "1e", "0x1", "1 2", "1_.0", "infinit"].map(float_from_text), [None; 8]);
    }

    #[test]
    fn halves_round_to_even_digits() {
        assert_eq!([0.5, 1.5, 2.5, -0.5].map(|x| round_to_int(x).ok()), [Some(0), Some(2), Some(2), Some(0)]);
        assert_eq!(round_to_places(0.125, 2), 0.12);
        assert_eq!(round_to_places(2.675, 2), 2.67);
        assert_eq!(round_to_places(1250.0, -2), 1200.0);
        assert_eq!(round_to_places(-1350.0, -2), -1400.0);
        assert_eq!(round_to_places(9950.5, -2), 10000.0);
        assert_eq!(round_to_places(40.0, -2), 0.0);
        assert_eq!(round_to_places(50.1, -2), 100.0);
    }

    #[test]
    fn small_powers_are_rounded_once() {
        // Values of Python, which are the exact ones rounded.
        let expected = [
            (1.1, 2.0, 1.2100000000000002),
            (0.1, 3.0, 0.0010000000000000002),
            (20.0, -20.0, 9.5367431640625e-27),
            (-0.3, 5.0, -0.0024299999999999994),
            (7.0, 22.0, 3.9098210485829883e18),
            (3.0, -1.0, 1.0 / 3.0),
        ];
        for (a, b, value) in expected {
            assert_eq!(small_power(a, b), Some(value), "{a} ** {b}");
        }
        assert_eq!(
            [(1e100, 2.0), (1e-100, 2.0), (2.0, 0.5), (2.0, 33.0), (f64::NAN, 2.0)].map(|(a, b)| small_power(a, b)),
            [None; 5]
        );
    }

    #[test]
    fn integers_are_divided_and_compared_exactly() {
        assert_eq!(divide_ints(7, 2), 3.5);
        assert_eq!(divide_ints(-1, 3), -1.0 / 3.0);
        assert_eq!(divide_ints(i64::MIN, -1), 9_223_372_036_854_775_808.0);
        assert_eq!(divide_ints(9_007_199_254_740_993, 1), 9_007_199_254_740_992.0);
        let big = Number::Int(9_007_199_254_740_993);
        assert_eq!(compare(big, Number::Float(9_007_199_254_740_992.0)), Some(Ordering::Greater));
        assert_eq!(compare(Number::Float(0.5), Number::Int(1)), Some(Ordering::Less));
        assert_eq!(divide_floats(-7.5, 2.0), (-4.0, 0.5));
    }
}
