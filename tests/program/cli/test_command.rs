//! Tests of `tatu test`, which runs scenes as tests.

use crate::kit::*;

const FALLING: &str = r#"format = 1

[scene]
duration_s = 0.5

[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true

[[object]]
kind = "shape"
alias = "Ball"
primitive = "sphere"
size_m = [0.1, 0.1, 0.1]
position_m = [0.0, 0.0, 0.5]
dynamic = true
respondable = true
"#;

fn exercise(goals: &str) -> String {
    format!(
        "{FALLING}\n[[object]]\nkind = \"dummy\"\nalias = \"Exercise\"\nscript = \"goals.lua\"\n\
         data = {{ \"exercise.goals\" = \"{goals}\" }}\n"
    )
}

fn place() -> TestFolder {
    let place = TestFolder::new();
    let goals = std::fs::read_to_string(root().join("scenes/learn/exercise.lua")).unwrap();
    place.write("tests/goals.lua", &goals).write("tests/falls.toml", FALLING);
    place.write("tests/deep/er/no_test.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"a\"\n");
    place.write("tests/settings.toml", "[table]\nkey = 1\n").write("tests/.hidden/broken.toml", "duration_s = ");
    place
}

#[test]
fn scenes_with_goals_or_a_duration_are_tests() {
    let place = place();
    place.write("tests/lands.toml", &exercise("Touch the floor: /Ball touches /floor before 0.4 s"));
    let run = place.tatu(&["test", "tests"]).good();
    assert!(run.out.contains("pass  tests/falls.toml") && run.out.contains("pass  tests/lands.toml"), "{}", run.out);
    assert!(run.out.contains("2 of 2 tests pass"), "{}", run.out);

    place.write("tests/early.toml", &exercise("Land soon: /Ball touches /floor before 0.1 s"));
    let run = place.tatu(&["test", "tests", "-j", "2", "--junit", "out.xml"]);
    assert_eq!(run.code, 3, "{}{}", run.out, run.err);
    assert!(run.out.contains("not reached: Land soon (at 0.10 s)"), "{}", run.out);
    assert!(run.out.contains("tatu look failed/tests-early.tatu --at 0.10"), "{}", run.out);
    // The record is that of the failed run.
    let verified = place.tatu(&["verify", "failed/tests-early.tatu"]).good();
    assert!(verified.out.starts_with("same: "), "{}", verified.out);
    let junit = place.read("out.xml");
    assert!(
        junit.contains("tests=\"3\"") && junit.contains("failures=\"1\"") && junit.contains("Land soon"),
        "{junit}"
    );

    // A goal that cannot be read is found by a check.
    place.write("odd.toml", &exercise("/Ball flies").replace("goals.lua", "tests/goals.lua"));
    place.tatu(&["check", "odd.toml"]).reports(&["the goal \"/Ball flies\" cannot be read"]);

    // An error outweighs goals.
    place.write("tests/wrong.toml", &format!("{FALLING}script = {{ text = \"error('broken')\" }}\n"));
    let run = place.tatu(&["test", "tests", "--json"]);
    assert_eq!(run.code, 1, "{}{}", run.out, run.err);
    let rows = run.json();
    let results: Vec<_> = rows
        .as_array()
        .unwrap()
        .iter()
        .map(|r| (r["scene"].as_str().unwrap(), r["result"].as_str().unwrap()))
        .collect();
    assert_eq!(
        results,
        [
            ("tests/early.toml", "goals failed"),
            ("tests/falls.toml", "passed"),
            ("tests/lands.toml", "passed"),
            ("tests/wrong.toml", "error"),
        ]
    );
    assert!(rows[3]["error"].as_str().unwrap().contains("broken"), "{rows}");
}

#[test]
fn runs_that_do_not_end_and_scenes_that_do_not_start_fail() {
    let place = place();
    place.write("slow.toml", &FALLING.replace("duration_s = 0.5", "duration_s = 1e6"));
    place.write("bad.toml", "format = 1\n[[object]]\nkind = \"shapes\"\n");
    let run = place.tatu(&["test", "slow.toml", "bad.toml", "--timeout", "1"]);
    assert_eq!(run.code, 1, "{}", run.out);
    assert!(run.out.contains("it was ended after 1 s") && run.out.contains("did you mean `shape`"), "{}", run.out);
    assert!(!place.path().join("failed").exists());
    place.tatu(&["test", "tests/deep"]).refused(&["there is no scene to test", "duration_s"]);
    place.tatu(&["test", "nowhere.toml"]).refused(&["nowhere.toml"]);
}
