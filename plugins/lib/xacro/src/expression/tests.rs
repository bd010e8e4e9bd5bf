//! Expressions by themselves. Expected values are those of Python 3.11.

use proptest::prelude::*;

use super::{
    context::{Context, Severity},
    evaluation::evaluate,
};
use crate::{
    error::{Result, fail},
    limits::{Budget, Limits},
    value::{Value, text::to_text},
};

/// A context with one property: `x` is 3.
struct LoneExpression(Budget);

impl Context for LoneExpression {
    fn budget(&mut self) -> &mut Budget {
        &mut self.0
    }
    fn property(&mut self, name: &str) -> Result<Option<Value>> {
        Ok((name == "x").then_some(Value::Int(3)))
    }
    fn property_in(&mut self, _: usize, _: &str) -> Result<Option<Value>> {
        Ok(None)
    }
    fn argument(&mut self, name: &str) -> Result<Value> {
        fail!("no argument {name}")
    }
    fn file_name(&mut self, name: &str) -> String {
        name.to_owned()
    }
    fn load_yaml(&mut self, name: &str) -> Result<Value> {
        fail!("no file {name}")
    }
    fn say(&mut self, _: Severity, _: &str) {}
    fn note(&mut self, _: &'static str, _: &str) {}
}

fn result(text: &str) -> std::result::Result<String, String> {
    let mut context = LoneExpression(Budget::new(Limits { work: 1_000_000, ..Limits::default() }));
    let value = evaluate(text, &mut context).and_then(|value| to_text(&value, context.budget()));
    value.map(|text| text.to_string()).map_err(|fault| fault.message)
}

#[track_caller]
fn all_give(expected: &[(&str, &str)]) {
    for (text, value) in expected {
        assert_eq!(result(text).as_deref(), Ok(*value), "{text}");
    }
}

#[track_caller]
fn all_fail(texts: &[(&str, &str)]) {
    for (text, words) in texts {
        let message = result(text).expect_err(text);
        assert!(message.contains(words), "{text}: {message}");
    }
}

#[test]
fn arithmetic_is_that_of_python() {
    all_give(&[
        ("2*0.5", "1.0"),
        ("7/2", "3.5"),
        ("4/2", "2.0"),
        ("7//2", "3"),
        ("-7//2", "-4"),
        ("-7%3", "2"),
        ("7.5%-2", "-0.5"),
        ("-2**2", "-4"),
        ("2**-1", "0.5"),
        ("2**3**2", "512"),
        ("0.1+0.2", "0.30000000000000004"),
        ("True+1", "2"),
        ("not 1 == 2", "True"),
        ("1 < x <= 3 != 4", "True"),
        ("0 or 'a' and 'b'", "b"),
        ("5 if x > 3 else 6", "6"),
        ("1, 2", "(1, 2)"),
        ("(1,)", "(1,)"),
        ("~5 & 0xff | 1 << 3", "250"),
        ("1 is not None", "True"),
        ("9007199254740993 == 9007199254740992.0", "False"),
    ]);
}

#[test]
fn texts_lists_and_dictionaries_work_as_in_python() {
    all_give(&[
        ("'a' + 'b'*3", "abbb"),
        ("'a b  c'.split()", "['a', 'b', 'c']"),
        ("'a,b,,c'.split(',', 1)", "['a', 'b,,c']"),
        ("'x'.upper() + 'Y'.lower()", "Xy"),
        ("'-'.join(['a', 'b'])", "a-b"),
        ("'{0}_{}_{n}'.format(1, n=2)", "1_1_2"),
        ("'%s=%.2f' % ('a', 1.005)", "a=1.00"),
        ("'{:03d}|{:>4}|{:.1f}'.format(7, 'a', 0.25)", "007|   a|0.2"),
        ("[1, 2.0, 'a\\'b', None, True][::-1]", "[True, None, \"a'b\", 2.0, 1]"),
        ("'hello'[1:-1]", "ell"),
        ("[1,2,3][-1]", "3"),
        ("dict(a=1, b=[2])['b'][0]", "2"),
        ("{'a': 1, 1.0: 2, True: 3}", "{'a': 1, 1.0: 3}"),
        ("xacro.dotify(dict(a=dict(b=4))).a.b", "4"),
        ("dict(a=1).get('b', 9)", "9"),
        ("list(dict(a=1, b=2).items())", "[('a', 1), ('b', 2)]"),
        ("2 in [1, 2] and 'b' in 'abc' and 3 not in (1, 2)", "True"),
        ("list(map(float, '1 2'.split()))", "[1.0, 2.0]"),
        ("python.sorted([3, 1, 2], reverse=True)", "[3, 2, 1]"),
        ("list(python.range(5, 0, -2))", "[5, 3, 1]"),
        ("python.isinstance('a', (int, str))", "True"),
    ]);
}

#[test]
fn functions_return_the_values_of_python() {
    all_give(&[
        ("round(2.5)", "2"),
        ("round(2.675, 2)", "2.67"),
        ("round(-1250, -2)", "-1200"),
        ("int('-7') + int(2.9)", "-5"),
        ("float('1e3')", "1000.0"),
        ("str(1e-7)", "1e-07"),
        ("radians(180) == pi", "True"),
        ("math.floor(-0.5)", "-1"),
        ("max(1, 2.5)", "2.5"),
        ("min([3, 1])", "1"),
        ("python.sum([1, 2.5])", "3.5"),
        ("python.abs(-3)", "3"),
        ("len('äb')", "2"),
        ("xacro.tokenize('a, b;c')", "['a', 'b', 'c']"),
        ("bool('')", "False"),
    ]);
}

#[test]
fn errors_name_the_flaw_of_an_expression() {
    all_fail(&[
        ("1 +", "ends too early"),
        ("1 2", "expected an operator"),
        ("y", "`y` is not defined"),
        ("1/0", "division by zero"),
        ("'a'+1", "use str()"),
        ("9223372036854775807+1", "more than 64 bits"),
        ("99999999999999999999", "more than 64 bits"),
        ("(-8)**0.5", "complex"),
        ("10.0**400", "too large"),
        ("sqrt(-1)", "not defined"),
        ("[1][1]", "outside of a list of 1"),
        ("dict(a=1)['b']", "it has a"),
        ("().__class__", "two underscores"),
        ("[i for i in x]", "loops and lambda"),
        ("f'{x}'", "format"),
        ("1 < 'a'", "cannot be compared"),
        ("1 not 2", "expected an operator"),
        ("open('x')", "`open` is not defined"),
        ("sin", "is a function"),
        ("[1].append([2])", "cannot add a list"),
    ]);
}

#[test]
fn costs_are_bounded() {
    all_fail(&[
        ("'a'*1000*1000*1000*1000", "bytes"),
        ("list(python.range(10**15))", "items"),
        ("[0]*10**9", "items"),
        ("('a'*1000).replace('', 'a'*100000)", "bytes"),
        ("'{:99999999}'.format(1)*1000", "bytes"),
        (&"(".repeat(1000), "deeper"),
        (&"-".repeat(1000), "deeper"),
        (&"[".repeat(1000), "deeper"),
        (&("1".to_owned() + &"+1".repeat(1000)), "in a row"),
        (&("1".to_owned() + &"**1".repeat(1000)), "deeper"),
        (&("x".to_owned() + &"[0]".repeat(1000)), "in a row"),
        (&("1".to_owned() + &" if 1 else 1".repeat(1000)), "deeper"),
    ]);
    all_give(&[("[]*10**18", "[]"), ("''*10**18", "")]);
}

proptest! {
    #[test]
    fn no_text_causes_a_panic(text in "\\PC{0,40}") {
        let _ = result(&text);
    }

    #[test]
    fn no_sequence_of_tokens_causes_a_panic(parts in prop::collection::vec(prop::sample::select(vec![
        "1", "0", "-1", "2.5", "'a'", "''", "x", "[", "]", "(", ")", "{", "}", ",", ":", ".", "+", "-", "*", "/", "//", "%",
        "**", "<", "==", "and", "or", "not", "in", "is", "if", "else", "True", "None", "len", "str", "int", "float", "dict",
        "list", "round", "min", "sorted", "range", "split", "format", "pop", "join", "python", "math", "xacro", "sin", "=",
        "9223372036854775807", "1e308", "'{:>9.3f}'", "'%d'", "<<", ">>", "~", "math.gcd", "python.divmod", "[::-1]", "inf",
        "nan", "xacro.tokenize", "(-9223372036854775807-1)", "'é€'",
    ]), 0..14)) {
        let _ = result(&parts.concat());
        let _ = result(&parts.join(" "));
    }
}
