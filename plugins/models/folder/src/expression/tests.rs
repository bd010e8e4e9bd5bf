use super::{ExpressionValue, NamedValues, SizeBudget};
use crate::error::Result;

fn evaluate(text: &str, names: &NamedValues) -> Result<ExpressionValue> {
    super::evaluate(text, names, &SizeBudget::default())
}

fn names() -> NamedValues {
    let vector = |v: &[f64]| ExpressionValue::List(v.iter().map(|x| ExpressionValue::Number(*x)).collect());
    NamedValues::from([
        ("length".to_owned(), ExpressionValue::Number(0.4)),
        ("count".to_owned(), ExpressionValue::Number(3.0)),
        ("arm".to_owned(), ExpressionValue::Bool(true)),
        ("preset".to_owned(), ExpressionValue::Text("wide".into())),
        ("color".to_owned(), vector(&[0.5, 0.25, 1.0])),
        ("poses".to_owned(), ExpressionValue::List(vec![vector(&[1.0, 2.0]), vector(&[3.0, 4.0])])),
    ])
}

fn toml(text: &str) -> String {
    evaluate(text, &names()).unwrap().to_toml().unwrap()
}

#[test]
fn expressions_follow_arithmetic() {
    for (text, wanted) in [
        ("1 + 2 * 3", "7.0"),
        ("(1 + 2) * 3", "9.0"),
        ("2 - 3 - 4", "-5.0"),
        ("-2 ^ 2", "-4.0"),
        ("2 ^ 3 ^ 2", "512.0"),
        ("2 ^ -1", "0.5"),
        ("7 % 4", "3.0"),
        ("-1 % 4", "3.0"),
        ("1e-3 * 1E+3", "1.0"),
        ("length / 2", "0.2"),
        ("if(preset == 'wide', 0.1, 1 / 0)", "0.1"),
        ("if(preset != \"wide\", 0.1, 0.2)", "0.2"),
        ("if(arm and count >= 3, 'yes', 'no')", "\"yes\""),
        ("not arm or count < 2", "false"),
        ("not arm == false", "true"),
        ("color", "[0.5, 0.25, 1.0]"),
        ("color[count - 2]", "0.25"),
        ("poses[1][0]", "3.0"),
        ("poses", "[[1.0, 2.0], [3.0, 4.0]]"),
        ("[length, 0, -length] * 2", "[0.8, 0.0, -0.8]"),
        ("poses[0] + poses[1]", "[4.0, 6.0]"),
        ("min(3, 1, 2) + max(color)", "2.0"),
        ("sqrt(16) + abs(-1) + floor(1.9) + ceil(0.1)", "7.0"),
        ("deg(pi)", "180.0"),
        ("rad(180) == pi", "true"),
        ("atan2(0, -1) == pi and cos(0) == 1 and sin(0) == tan(0)", "true"),
        ("len(poses)", "2.0"),
        ("'leg_' + text(count)", "\"leg_3\""),
        ("'a\"' + preset", "\"a\\\"wide\""),
        ("order", "1.0"),
        ("[2 * i for i in 3]", "[0.0, 2.0, 4.0]"),
        ("[p[1] - p[0] for p in poses]", "[1.0, 1.0]"),
        ("[[x + length for x in p] for p in poses][1]", "[3.4, 4.4]"),
        ("[x for x in []]", "[]"),
        ("flat([0, [1, 2], [[3]]])", "[0.0, 1.0, 2.0, [3.0]]"),
        ("flat([[i, 10 * i] for i in 2])", "[0.0, 0.0, 1.0, 10.0]"),
        ("[for_x for for_x in 1]", "[0.0]"),
    ] {
        let mut names = names();
        names.insert("order".into(), ExpressionValue::Number(1.0));
        assert_eq!(evaluate(text, &names).unwrap().to_toml().unwrap(), wanted, "{text}");
    }
    assert_eq!(toml("0.1"), "0.1");
}

#[test]
fn errors_state_the_problem_and_a_hint() {
    for (text, wrong, help) in [
        ("1 / (count - 3)", "division by zero: 1 / 0", ""),
        ("lenght * 2", "no parameter or number `lenght`", "did you mean `length`?"),
        ("quite_another", "no parameter or number `quite_another`", "the known names are arm, color"),
        ("sqr(2)", "no function `sqr`", "did you mean `sqrt`?"),
        ("sqrt(-1)", "`sqrt(-1)` is not defined", ""),
        ("sqrt('a')", "`sqrt` requires one number, found the string 'a'", ""),
        ("preset + 1", "`+` cannot be applied to the string 'wide' and the number 1", ""),
        ("preset == 1", "`==` cannot be applied to", ""),
        ("if(1, 2, 3)", "the condition of `if` must be true or false, found the number 1", ""),
        ("if(arm, 2)", "`if` requires three arguments, but has 2", "if(condition, "),
        ("color[3]", "index 3 is not valid for a list of length 3", "counts from 0"),
        ("length[0]", "cannot index the number 0.4 with the number 0", "counts from 0"),
        ("1 +", "expected a value, found the end", ""),
        ("1 2", "expected an operator or the end of the expression, found `2`", ""),
        ("(1", "expected `)`, found the end", ""),
        ("'a", "the string 'a has no closing quote", ""),
        ("1.2.3", "`1.2.3` is not a number", ""),
        ("1 < 2 < 3", "found `< 3`", ""),
        ("10 ^ 400", "not a finite number", ""),
        ("color + [1]", "`+` cannot be applied to a list of length 3 and a list of length 1", ""),
        ("[i for i in 1.5]", "expected a list or a whole number, found the number 1.5", "`for i in 3` counts"),
        ("[i for pi in 3]", "`pi` is a reserved name", ""),
        ("[i for i of 3]", "expected `in`", ""),
        ("flat(1)", "`flat` requires one list, found the number 1", ""),
        ("[j for i in 3]", "no parameter or number `j`", ""),
        ("[i for i in 10001]", "more than 10000 values", ""),
        ("len([[i for i in 200] for k in 200])", "more than 10000 values", ""),
        ("ä", "expected a value, found `ä`", ""),
    ] {
        let e = evaluate(text, &names()).unwrap_err();
        assert!(e.text.contains(wrong) && e.help.unwrap_or_default().contains(help), "{text}: {}", e.text);
    }
    let deep = "(".repeat(5000);
    assert!(evaluate(&deep, &names()).unwrap_err().text.contains("nested more than"));
    assert!(evaluate(&"-".repeat(5000), &names()).unwrap_err().text.contains("nested more than"));
}

#[test]
fn long_expressions_need_no_deep_stack() {
    // One level of recursion per operator or index would overflow a small stack.
    let small = || {
        let sum = format!("1{}", "+1".repeat(30_000));
        assert_eq!(evaluate(&sum, &names()).unwrap(), ExpressionValue::Number(30_001.0));
        assert_eq!(
            evaluate(&format!("true{}", " and true".repeat(7000)), &names()).unwrap(),
            ExpressionValue::Bool(true)
        );
        assert_eq!(evaluate(&format!("{}0", "0*".repeat(30_000)), &names()).unwrap(), ExpressionValue::Number(0.0));
        let e = evaluate(&format!("[1]{}", "[0]".repeat(20_000)), &names()).unwrap_err();
        assert!(e.text.contains("cannot index the number 1"), "{}", e.text);
    };
    std::thread::Builder::new().stack_size(512 << 10).spawn(small).unwrap().join().unwrap();
    let e = evaluate(&format!("1{}", "+1".repeat(200_000)), &names()).unwrap_err();
    assert!(e.text.contains("the expression has 400001 bytes, but the maximum is 65536"), "{}", e.text);
}

#[test]
fn values_that_grow_are_refused() {
    let grow = |first: ExpressionValue, text: &str| {
        let (mut names, room) = (NamedValues::from([("a".to_owned(), first)]), SizeBudget::default());
        for _ in 0..100 {
            let value = super::evaluate(text, &names, &room)?;
            names.insert("a".to_owned(), value);
        }
        Ok::<_, crate::error::ModelError>(names)
    };
    for (first, text) in [(ExpressionValue::Text("x".into()), "a + a"), (ExpressionValue::Number(1.0), "[a, a]")] {
        let e = grow(first, text).unwrap_err();
        assert!(e.text.contains("more than 4194304 numbers and characters"), "{}", e.text);
    }
    assert!(grow(ExpressionValue::Number(1.0), "[a]").unwrap_err().text.contains("nested more than 60 levels deep"));
    let long = NamedValues::from([("t".to_owned(), ExpressionValue::Text("x".repeat(1 << 20)))]);
    assert!(evaluate("[t + 'y' for i in 10000]", &long).unwrap_err().text.contains("4194304"));
    assert!(evaluate("len([t, 'y'])", &long).is_ok());
}
