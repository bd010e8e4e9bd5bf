//! Tests of errors in model files: each refers to a line of `model.toml`.

use super::folder_models::{ROVER, place};

/// Replaces a part of the rover's file and checks that the error refers to a line of the new text.
fn refused(old: &str, new: &str, words: &[&str]) {
    let begin = ROVER.find(old).unwrap();
    let first = 1 + ROVER[..begin].matches('\n').count();
    check_error_line((old, new), first..=first + new.matches('\n').count(), words);
}

/// Removes a line and checks that the error refers to the line `at`, because a missing key has no line.
fn check_missing_line(old: &str, at: &str, words: &[&str]) {
    let line = 1 + ROVER[..ROVER.find(at).unwrap()].matches('\n').count();
    check_error_line((old, ""), line..=line, words);
}

fn check_error_line((old, new): (&str, &str), mut lines: std::ops::RangeInclusive<usize>, words: &[&str]) {
    let text = ROVER.replacen(old, new, 1);
    assert_ne!(text, ROVER, "{old}");
    let place = place("[[model]]\nmodel = \"rover\"\n");
    place.write("models/rover/model.toml", &text);
    let done = place.tatu(&["check", "scene.toml"]);
    done.refused(words);
    let here = lines.any(|line| done.err.contains(&format!("models/rover/model.toml:{line}:")));
    assert!(here, "{old} > {new}: the error is at another line\n{}", done.err);
    // Scenes that do not use the model are not affected.
    place.write("other.toml", "format = 1\n[[model]]\nmodel = \"claw\"\n");
    place.tatu(&["check", "other.toml"]).good();
}

#[test]
fn errors_in_expressions_are_at_their_line() {
    let at = "\"=wheel_radius / 2\"";
    refused(at, "\"=wheel_radus / 2\"", &["E111", "no parameter or number `wheel_radus`", "`wheel_radius`?"]);
    refused(at, "\"=wheel_radius / 0\"", &["E111", "division by zero"]);
    refused(at, "\"=wheel_radius + look\"", &["E111", "cannot be applied to the number 0.1 and the string 'plain'"]);
    refused(at, "\"=sqr(2)\"", &["E111", "no function `sqr`", "did you mean `sqrt`?"]);
    refused(at, "\"=(1\"", &["E111", "expected `)`"]);
    // Results of expressions are checked like literal values.
    refused("\"=length / 4\"", "\"=look\"", &["E102", "`reach_m`", "found the text \"plain\"", "scene.toml:"]);
    refused(
        "size_m = [\"=length\"",
        "siz_m = [\"=length\"",
        &["E101", "unknown key `siz_m`", "did you mean `size_m`?"],
    );
    refused("if = \"=with_arm\"", "if = \"=length\"", &["E111", "`if`: expected true or false, found the number 0.4"]);
    refused("repeat = \"=if(with_arm, 2, 3)\"", "repeat = 1.5", &["E111", "`repeat`: expected a whole number"]);
}

#[test]
fn errors_in_declarations_are_at_their_line() {
    refused("text = \"A robot on two wheels.\"", "txt = \"x\"", &["E111", "a model has no key `txt`", "`text`?"]);
    refused("type = \"bool\"", "type = \"boole\"", &["E111", "no type `boole`", "did you mean `bool`?"]);
    refused("default = 0.4", "default = 4.0", &["E111", "4 is not within 0.1 to 2"]);
    check_missing_line("default = 0.4\n", "type = \"float\"", &["E111", "`length` has no default"]);
    refused("default = \"plain\"", "default = \"plane\"", &["E111", "expected one of plain, bright"]);
    let length = "default = 0.4";
    refused(length, "default = \"=1 + true\"", &["E111", "cannot be applied to the number 1 and true"]);
    refused(length, "default = \"=2 + 2\"", &["E111", "4 is not within 0.1 to 2"]);
    refused(length, "default = \"='a'\"", &["E111", "`default`: expected a number, found the string 'a'"]);
    refused(length, "default = \"=look\"", &["E111", "no parameter or number `look`"]);
    refused("range = [0.1, 2.0]", "range = [2.0, 0.1]", &["E111", "the minimum 2 is greater than the maximum 0.1"]);
    refused("numbers.paint]", "numbers.pi]", &["E111", "`pi` is a reserved name in expressions"]);
    refused("numbers.paint]", "numbers.length]", &["E111", "`length` is both a parameter and a number"]);
    refused("params.look]", "params.alias]", &["E111", "`alias` cannot be a parameter"]);
    check_missing_line(
        "source = \"estimate: a quarter of the length\"",
        "value = 0.1",
        &["E111", "`wheel_radius` has no `source`"],
    );
    refused("base = \"body\"", "base = \"bodi\"", &["E111", "no object has the alias `bodi`", "did you mean `body`?"]);
    let arm = "model = \"claw\"\nalias = \"arm\"\nreach_m = \"=length / 4\"";
    refused(arm, "model = \"rover\"", &["E106", "contains itself"]);
    refused("[[object]]\nkind = \"shape\"", "[[model]]\nmodel = \"claw\"", &["E111", "duplicate key", "[[object]]"]);
}

/// Errors that are detected after all objects were created also refer to the right line, although expressions and
/// omitted entries have different lengths in the generated text and in the file.
#[test]
fn errors_found_later_are_at_their_line() {
    let place = crate::kit::TestFolder::scene("[[model]]\nmodel = \"m\"\n");
    let text = "format = 1\n[model]\ntext = \"T.\"\n[model.params.n]\ntype = \"int\"\ndefault = 2\ntext = \"N.\"\n\
                [[object]]\nkind = \"dummy\"\nalias = \"base\"\n[[object]]\nkind = \"dummy\"\nlayer = \"=1 + 0 * n\"\n";
    let encoder = "[[object]]\nkind = \"sensor\"\nsensor = \"wheel_encoder\"\nalias = \"enc\"\njoint = \"nothing\"\n";
    place.write("models/m/model.toml", &format!("{text}{encoder}"));
    let done = place.tatu(&["run", "scene.toml", "--steps", "1"]);
    done.refused(&["E402", "models/m/model.toml:15:", "15 | kind = \"sensor\""]);
    place.write("models/m/model.toml", &format!("{text}[set]\n\"base.layr\" = 1\n"));
    place.tatu(&["check", "scene.toml"]).refused(&["E101", "models/m/model.toml:15:", "15 | \"base.layr\" = 1"]);
}

/// A file that is not a model file is reported with its path.
#[test]
fn files_that_are_no_models_are_named() {
    let place = crate::kit::TestFolder::scene("[[model]]\nmodel = \"m\"\n");
    place.write("models/m/model.toml", "format = 1\n[model]\ntext = \"T.\"\n[[object]]\nkind = \"dummy\"\n");
    place.write("other.toml", "format = 1\n[[model]]\nmodel = \"m\"\nlength = 1\n");
    place.tatu(&["check", "other.toml"]).refused(&[
        "E101",
        "unknown key `length`",
        "note: expected of every model: model",
    ]);
    let told = |words: &[&str]| place.tatu(&["check", "scene.toml"]).refused(words);
    for text in ["", "format = 1\nmodel = 3\n"] {
        place.write("models/m/model.toml", text);
        told(&["E111", "no plugin reads the model models/m/model.toml"]);
    }
    place.write("models/m/model.toml", "format = 1\n[model]\ntext = \"T.\"\n");
    told(&["E111", "the model has no [[object]]", "models/m/model.toml:3:"]);
    let deep = format!("format = 1\n[model]\ntext = \"T.\"\n\nx = {}{}\n", "[".repeat(500), "]".repeat(500));
    place.write("models/m/model.toml", &deep);
    told(&["E111", "not a TOML file", "models/m/model.toml:5:"]);
    std::fs::remove_file(place.path().join("models/m/model.toml")).unwrap();
    std::fs::create_dir(place.path().join("models/m/model.toml")).unwrap();
    told(&["E105", "cannot read the model `m`", "it is a folder", "models/m/model.toml"]);
}
