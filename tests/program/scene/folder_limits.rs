//! Tests of model folders that would need excessive resources: each is refused with its line, or its cost is bounded.

use crate::kit::*;

/// Creates a scene with a model; `text` follows the table `[model]` in its file.
fn of(text: &str) -> TestFolder {
    let place = TestFolder::scene("[[model]]\nmodel = \"much\"\n");
    place.write("models/much/model.toml", &format!("format = 1\n[model]\ntext = \"T.\"\n{text}"));
    place
}

#[track_caller]
fn refused(text: &str, line: usize, words: &str) {
    let done = of(text).tatu(&["check", "scene.toml"]);
    done.refused(&["E111", words, &format!("models/much/model.toml:{line}:")]);
}

const BASE: &str = "[[object]]\nkind = \"dummy\"\nalias = \"base\"\n";

#[test]
fn expressions_are_limited() {
    let sized = |e: String| format!("[[object]]\nkind = \"shape\"\nsize_m = [\"={e}\", 1, 1]\n");
    refused(&sized(format!("1{}", "+1".repeat(200_000))), 6, "has 400001 bytes, but the maximum is 65536");
    refused(&sized(format!("[1]{}", "[0]".repeat(200_000))), 6, "the expression has 600003 bytes");
    refused(&sized(format!("[1]{}", "[0]".repeat(20_000))), 6, "cannot index the number 1");
    of(&sized(format!("1{}", "*1".repeat(30_000)))).tatu(&["check", "scene.toml"]).good();
}

/// Each value doubles the size of the previous one, so the 20th exceeds the limit.
#[test]
fn values_are_limited() {
    let numbers = |first: &str, then: &str| {
        let next = |i: usize| {
            let value = then.replace('a', &format!("a{}", i - 1));
            format!("a{i} = {{ value = \"={value}\", source = \"estimate: x\" }}\n")
        };
        let all: String = (1..40).map(next).collect();
        format!("[model.numbers]\na0 = {{ value = {first}, source = \"estimate: x\" }}\n{all}{BASE}")
    };
    let words = "expressions compute more than 4194304 numbers and characters";
    refused(&numbers("\"x\"", "a + a"), 5 + 20, words);
    refused(&numbers("1", "[a, a]"), 5 + 20, words);
}

#[test]
fn repetitions_are_limited_in_all() {
    let entry = "[[object]]\nkind = \"dummy\"\nrepeat = 6000\n";
    refused(&format!("{BASE}{entry}{entry}"), 12, "the model has more than 10000 repetitions in total");
    // Each repetition of the object repeats the empty lines in its entry.
    let entry = format!("[[object]]\nkind = \"dummy\"\n{}repeat = 10000\n", "\n".repeat(2_000_000));
    refused(&format!("{BASE}{entry}"), 2_000_009, "the text of the model's repetitions exceeds 64 MiB");
}
