//! Tests of names: types are nouns, bounds are called `MAX_...`, and names of tests state subject and outcome.
//!
//! A reader who is familiar with robotics and Rust can guess such names and find them with grep. The allowed numbers
//! are those of well-maintained code bases: see `docs/decisions/0061-names-of-the-field.md`.

use std::{collections::BTreeMap, fs};

use regex::Regex;

use super::tree::files;
use crate::kit::*;

/// Participles, pronouns, prepositions and adjectives that are meaningless as the only word of a type name.
#[rustfmt::skip]
const BARE_WORDS: [&str; 108] = [
    "After", "Again", "All", "Around", "Ask", "Asked", "Away", "Bad", "Before", "Beside", "Best", "Between", "Broken",
    "Called", "Carried", "Caught", "Changed", "Collected", "Computed", "Copied", "Counted", "Crowded", "Described",
    "Done", "Drawn", "Dropped", "Due", "Edited", "Ended", "Ending", "Examined", "Far", "Felt", "Few", "Found", "Fresh",
    "Generated", "Given", "Gives", "Good", "Guarded", "Half", "Handed", "Held", "Inside", "Issued", "Keep", "Kept",
    "Known", "Laid", "Learned", "Lent", "Limited", "Lit", "Living", "Loaded", "Locked", "Made", "Many", "Meant",
    "Measured", "Meet", "Met", "Missed", "Missing", "More", "Most", "Mounted", "Moved", "Named", "Near", "New", "Noted",
    "Now", "Observed", "Offered", "Old", "Opened", "Others", "Outer", "Outside", "Over", "Owned", "Parting", "Patched",
    "Pending", "Placed", "Posted", "Queued", "Ran", "Read", "Ready", "Recent", "Refused", "Said", "Sealed", "Seen",
    "Sent", "Shared", "Shown", "Stored", "Stuck", "Taken", "Told", "Touched", "Under", "Want", "Who",
];
/// Suffixes that add no meaning to the name of a type.
const VAGUE_SUFFIXES: [&str; 6] = ["Data", "Info", "Manager", "Helper", "Util", "Utils"];
/// Exceptions: names in the interface for plugin authors, in libc, and V-REP's term "custom data".
const SUFFIXES_ALLOWED: [&str; 4] = ["InstanceInfo", "ModelInfo", "DlInfo", "CustomData"];
/// Words that make the name of a test obscure.
const OBSCURE_TEST_WORDS: &str = "(^|_)(told|tells?|whom?|nobody|nothing|stands?|stood|comes?|came|keeps?|kept|hears?|\
    heard|may_not|what_(is|was|are|has|cannot|a|the)|mended|holds|gives?|takes?|put_back)(_|$)";

/// Returns the Rust files of the repository as pairs of path and text, except frozen copies and plugins with faults.
fn sources() -> Vec<(String, String)> {
    let of = |path: std::path::PathBuf| {
        let name = path.strip_prefix(root()).unwrap().to_str()?.to_owned();
        let is_copy = ["tests/faults", "tests/museum", "tests/compat"].iter().any(|f| name.starts_with(f));
        (name.ends_with(".rs") && !is_copy).then(|| (name, fs::read_to_string(path).unwrap()))
    };
    files(root()).into_iter().filter_map(of).collect()
}

/// Returns the names of all types outside of tests, each with a file that declares it.
fn types() -> BTreeMap<String, String> {
    let declaration = Regex::new(r"(?m)^\s*(?:pub(?:\([a-z ]+\))? )?(?:struct|enum|trait) ([A-Z]\w*)").unwrap();
    let mut types = BTreeMap::new();
    for (file, text) in sources().iter().filter(|(f, _)| !f.starts_with("tests/") && !f.contains("/template/")) {
        for found in declaration.captures_iter(text) {
            types.insert(found[1].to_owned(), file.clone());
        }
    }
    types
}

#[test]
fn types_are_nouns_of_more_than_one_word() {
    let types = types();
    let bare: Vec<_> = types.keys().filter(|t| BARE_WORDS.contains(&t.as_str())).collect();
    assert!(100 * bare.len() < types.len(), "participles, pronouns or prepositions alone: {bare:?}");
    let one_word = types.keys().filter(|t| !t[1..].contains(|c: char| c.is_ascii_uppercase())).count();
    assert!(2 * one_word < types.len(), "{one_word} of {} types are one word", types.len());
}

#[test]
fn types_have_no_vague_suffixes() {
    let is_vague = |t: &str| VAGUE_SUFFIXES.iter().any(|s| t.ends_with(s)) && !SUFFIXES_ALLOWED.contains(&t);
    let vague: Vec<_> = types().into_iter().filter(|(t, _)| is_vague(t)).collect();
    assert!(vague.is_empty(), "name these types after what they are: {vague:#?}");
}

#[test]
fn upper_bounds_are_called_max() {
    let bound = Regex::new(r"\b(?:const|static) (MOST\w*|FEW|MANY|PATIENCE|STILL|AGAIN|OFTEN|ROOM)\s*:").unwrap();
    let mut found = Vec::new();
    for (file, text) in sources() {
        found.extend(bound.captures_iter(&text).map(|c| format!("{} in {file}", &c[1])));
    }
    // The former name of `MAX_FILE_BYTES`, for plugins that use it.
    found.retain(|f| f != "MOST_BYTES in plugin-api/src/safe/value/plain.rs");
    assert!(found.is_empty(), "call an upper bound `MAX_...`, and say what it bounds: {found:#?}");
}

#[test]
fn tests_say_subject_and_outcome() {
    let test = Regex::new(r"#\[test\](?:\s*#\[[^\]]*\])*\s*(?:pub )?fn (\w+)").unwrap();
    let obscure = Regex::new(OBSCURE_TEST_WORDS).unwrap();
    let mut found = Vec::new();
    for (file, text) in sources() {
        let names = test.captures_iter(&text).map(|c| c[1].to_owned());
        found.extend(names.filter(|n| obscure.is_match(n)).map(|n| format!("{n} in {file}")));
    }
    assert!(found.is_empty(), "state subject and outcome in the names of these tests: {found:#?}");
}
