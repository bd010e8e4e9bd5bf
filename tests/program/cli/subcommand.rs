//! Tests of subcommands of the program that plugins offer.

use std::fs;

use crate::kit::*;

/// A folder with a scene of four bodies, and the plugin in C that lists the heaviest.
fn place() -> TestFolder {
    let body = |kg: f64| format!("[[object]]\nkind = \"shape\"\nmass_kg = {kg:?}\n");
    let place = plugin_sources::place(&[3.0, 7.0, 5.5, 2.0].map(body).concat());
    let source = fs::read_to_string(root().join("tests/program/plugins/heaviest_subcommand.c")).unwrap();
    plugin_sources::compile(&place, "heaviest", &source);
    place
}

const HEAVIEST: [&str; 5] = ["heaviest", "--scene", "scene.toml", "--allow", "plugins"];

#[test]
fn a_subcommand_in_c_gets_its_arguments_and_the_scene() {
    let place = place();
    let run = |more: &[&str]| place.tatu(&[&HEAVIEST[..], more].concat());
    assert_eq!(run(&["2"]).good().out, "7 kg\n5.5 kg\n");
    assert_eq!(run(&["9", "--least_kg", "5.4", "well", "done"]).good().out, "7 kg\n5.5 kg\n# well\n# done\n");
    assert_eq!(run(&["1", "--set", "/shape.mass_kg=20"]).good().out, "20 kg\n");
    // The exit code is a result of the command.
    assert_eq!(run(&["1", "--least_kg", "100"]).code, 3);
    let help = run(&["--help"]).good().out;
    for words in
        ["Lists the heaviest shapes", "<COUNT>", "an integer from 1 to 50", "--least_kg", "default: 0", "REMARKS"]
    {
        assert!(help.contains(words), "{words}: {help}");
    }
}

#[test]
fn wrong_arguments_of_subcommands_are_explained() {
    let place = place();
    let run = |more: &[&str]| place.tatu(&[&HEAVIEST[..], more].concat());
    run(&[]).refused(&["required", "<COUNT>"]);
    run(&["99"]).refused(&["E128", "count", "from 1 to 50", "found 99"]);
    run(&["two"]).refused(&["E128", "count", "an integer"]);
    run(&["1", "--most_kg", "3"]).refused(&["--most_kg"]);
    run(&["1", "--least_kg"]).refused(&["--least_kg"]);
    place.tatu(&["rum"]).refused(&["E128", "there is no subcommand `rum`", "did you mean `run`?"]);
    let arguments = ["heavyest", "--scene", "scene.toml", "--allow", "plugins"];
    place.tatu(&arguments).refused(&["of plugins: heaviest", "did you mean `heaviest`?"]);
}
