//! Tests of large scenes: the time to load them is proportional to their size, and excessive growth is refused.

use std::fmt::Write;

use crate::kit::*;

/// If the time were quadratic, each of these scenes would take many minutes, and the test kit would kill the program.
#[test]
fn a_hundred_thousand_objects_of_one_alias_load() {
    let mut text = String::new();
    for _ in 0..100_000 {
        text += "[[object]]\nkind = \"dummy\"\nalias = \"d\"\n";
    }
    let place = TestFolder::scene(&text);
    place.run(&["--steps", "1"]).good();
}

#[test]
fn a_long_chain_and_many_models_load() {
    let mut text = String::new();
    for i in 0..20_000 {
        let above = if i % 4000 == 0 { String::new() } else { format!("parent = \"d{}\"\n", i - 1) };
        write!(text, "[[object]]\nkind = \"dummy\"\nalias = \"d{i}\"\n{above}").unwrap();
    }
    for _ in 0..10_000 {
        text += "[[model]]\nmodel = \"one.toml\"\n";
    }
    let place = TestFolder::scene(&text);
    place.write("one.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"q\"\n");
    let done = place.run(&["--steps", "1"]).good();
    assert_eq!(done.json()["objects"].as_object().unwrap().len(), 10_000);
}

#[test]
fn a_script_makes_many_objects() {
    let script = "function sysCall_init() for i = 1, 100000 do sim.createDummy(0.01) end \
                  print('last', sim.getObject('/Dummy[99999]')) end";
    let place = TestFolder::scene(&watcher("d", script));
    place.run(&["--steps", "1"]).good();
}

#[test]
fn scenes_that_double_are_refused() {
    let place = TestFolder::scene("[[model]]\nmodel = \"x0.toml\"\n");
    for i in 0..31 {
        place.write(
            &format!("x{i}.toml"),
            &format!("format = 1\n{}", format!("[[model]]\nmodel = \"x{}.toml\"\n", i + 1).repeat(2)),
        );
    }
    place.write("x31.toml", "format = 1\n");
    place.run(&[]).refused(&["error[E124]", "at most 16 deep"]);
    // The scenes are nested only five deep, but each includes the next twelve times: 12^5 copies.
    for i in 0..5 {
        place.write(
            &format!("x{i}.toml"),
            &format!("format = 1\n{}", format!("[[model]]\nmodel = \"x{}.toml\"\n", i + 1).repeat(12)),
        );
    }
    place.write("x5.toml", "format = 1\n");
    place.run(&[]).refused(&["error[E124]", "20000"]);
}
