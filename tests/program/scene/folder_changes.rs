//! Tests of the changes that scenes make to models: slots, `remove`, `replace`.

use super::folder_models::{CLAW, flat, has, object, place};
use crate::kit::*;

#[test]
fn devices_go_into_slots() {
    let place = place(
        "[[model]]\nmodel = \"rover\"\nalias = \"a\"\nlength_m = 1.0\n\
         [model.slots]\nfront = { model = \"claw\", reach_m = 0.5, alias = \"nose\", position_m = [0.0, 0.0, 0.1] }\n\
         top = [{ sensor = \"proximity\", alias = \"eye\", range_m = 3.0 }, { kind = \"dummy\", alias = \"mark\" }]\n",
    );
    let text = flat(&place, &[]);
    has(&text, "nose", &["parent = \"front\"", "size_m = [0.5, 0.02, 0.02]", "position_m = [0.0, 0.0, 0.1]"]);
    has(&text, "eye", &["parent = \"top\"", "range_m = 3.0"]);
    has(&text, "mark", &["parent = \"top\""]);
    // A parameter of a device in a slot can be set by its path.
    let text = flat(&place, &["--set", "/a/front/nose.reach_m=0.25"]);
    has(&text, "nose", &["size_m = [0.25, 0.02, 0.02]"]);
}

/// A sensor can replace another one, both in a model built by a plugin and in a model without code.
#[test]
fn parts_are_removed_and_replaced() {
    let place = place(
        "[[model]]\nmodel = \"rover\"\nalias = \"a\"\nremove = [\"led_0\", \"arm/tip\"]\n\
         [[model]]\nmodel = \"rover\"\nalias = \"b\"\n\
         replace = { \"top\" = { sensor = \"proximity\", alias = \"eye\" }, \"arm\" = { model = \"claw\", reach_m = 0.7 } }\n",
    );
    let text = flat(&place, &[]);
    let names = |name: &str| text.matches(&format!("alias = \"{name}\"\n")).count();
    assert_eq!((names("led_0"), names("led_1"), names("arm"), names("claw"), names("tip")), (1, 2, 1, 1, 1), "{text}");
    // The new sensor has the position of the old one, half a wheel's radius above the middle.
    has(&text, "eye", &["parent = \"b#0\"", "position_m = [0.0, 0.0, 0.05]"]);
    assert!(object(&text, "claw").contains("size_m = [0.7, 0.02, 0.02]"), "{text}");
    // Settings of the model for a removed part are dropped with it.
    let place = super::folder_models::place("[[model]]\nmodel = \"rover\"\nremove = [\"led_1\"]\n");
    assert!(!flat(&place, &[]).contains("led_1"));

    let sonars: Vec<String> = (1..=8).map(|n| format!("\"Pioneer_p3dx_ultrasonicSensor{n}\"")).collect();
    let scene = |more: &str| format!("[[model]]\nmodel = \"pioneer_p3dx\"\n{more}");
    let whole = flat(&TestFolder::scene(&scene("")), &[]).matches("sensor = ").count();
    let place = TestFolder::scene(&scene(&format!("remove = [{}]\n", sonars.join(", "))));
    assert_eq!(flat(&place, &[]).matches("sensor = ").count(), whole - 8);
    place.run(&["--steps", "5"]).good();
}

#[test]
fn parts_of_imports_and_plain_scenes_are_changed() {
    let place = TestFolder::scene(
        "[[import]]\nfile = \"b.urdf\"\nremove = [\"lid\"]\n\
         [[model]]\nmodel = \"part.toml\"\nreplace = { hook = { kind = \"dummy\", alias = \"loop\" } }\n",
    );
    place.write(
        "b.urdf",
        "<robot name=\"bench\"><link name=\"base\"/><link name=\"lid\"/><joint name=\"hinge\" type=\"fixed\">\
         <parent link=\"base\"/><child link=\"lid\"/></joint></robot>",
    );
    place.write(
        "part.toml",
        "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"bar\"\n\
         [[object]]\nkind = \"dummy\"\nalias = \"hook\"\nparent = \"bar\"\nposition_m = [1.0, 2.0, 3.0]\n",
    );
    let text = flat(&place, &[]);
    assert!(!text.contains("\"lid\"") && !text.contains("\"hook\""), "{text}");
    has(&text, "loop", &["parent = \"bar\"", "position_m = [1.0, 2.0, 3.0]"]);
}

/// Each error states its location, what was expected, and the most similar name if there is one.
#[test]
fn wrong_changes_are_refused() {
    for (wrong, words) in [
        ("slots = { frnt = { model = \"claw\" } }", &["E110", "no slot `frnt`", "one of front, top", "`front`?"][..]),
        ("slots = { front = { model = \"clw\" } }", &["E107", "no model `clw`", "did you mean `claw`?"]),
        ("slots = { front = 3 }", &["E102", "`front`: expected a table or a list of tables"]),
        ("slots = { front = { sensor = \"proximity\", parent = \"top\" } }", &["E101", "the model determines it"]),
        ("slots = { front = { model = \"bolt\" } }", &["E102", "accepts `sensor-plate`", "mounted by `thread`"]),
        ("slots = 3", &["E102", "`slots` is not a table"]),
        ("remove = [\"amr\"]", &["E110", "no object `amr`", "did you mean `arm`?"]),
        ("remove = [\"body\"]", &["E110", "`body` is not below the base"]),
        ("remove = \"arm\"", &["E102", "expected a list of paths"]),
        ("replace = { arm = [] }", &["E102", "one table"]),
        ("replace = { amr = { model = \"claw\" } }", &["E110", "no object `amr`"]),
    ] {
        let place = place(&format!("[[model]]\nmodel = \"rover\"\n{wrong}\n"));
        place.write("models/bolt/model.toml", &CLAW.replace("[\"sensor-plate\", \"flange\"]", "\"thread\""));
        let done = place.tatu(&["check", "scene.toml"]);
        done.refused(words);
        assert!(done.err.contains("scene.toml:"), "{wrong}: {}", done.err);
    }
}

/// The `[set]` of a model moves its parts before they are replaced, both models and single objects.
#[test]
fn a_replaced_part_has_the_pose_set_by_the_model() {
    let place = TestFolder::scene(
        "[[model]]\nmodel = \"outer\"\nalias = \"a\"\n\
         replace = { tip = { kind = \"dummy\", alias = \"loop\" }, hook = { model = \"claw\", alias = \"other\" } }\n",
    );
    place.write("models/claw/model.toml", CLAW);
    let object = |rest: &str| format!("[[object]]\n{rest}\n");
    place.write(
        "models/outer/model.toml",
        &[
            "format = 1\n[model]\ntext = \"T.\"\n".to_owned(),
            object("kind = \"dummy\"\nalias = \"base\""),
            object("kind = \"dummy\"\nalias = \"arm\"\nposition_m = [0, 0, 1]"),
            object("kind = \"dummy\"\nalias = \"tip\"\nparent = \"./arm\"\nposition_m = [1, 0, 0]\norientation_deg = [0, 0, 90]"),
            object("model = \"claw\"\nalias = \"hook\"\nposition_m = [0, 2, 0]"),
            "[set]\n\"arm/tip.position_m\" = [7, 0, 0]\n\"hook.position_m\" = [0, 0, 3]\n\"arm.position_m\" = [0, 0, 5]\n"
                .to_owned(),
        ]
        .concat(),
    );
    let text = flat(&place, &[]);
    has(&text, "loop", &["position_m = [7.0, 0.0, 0.0]", "orientation_deg = [-0.0, 0.0, 90.0]", "parent = \"arm\""]);
    has(&text, "other", &["position_m = [0.0, 2.0, 3.0]", "parent = \"a\""]);
    has(&text, "arm", &["position_m = [0.0, 0.0, 5.0]"]);
}

/// The cost of a change depends on the size of the model and not of the scene; otherwise this test would take minutes.
#[test]
fn many_models_are_changed() {
    let place = TestFolder::scene("[[model]]\nmodel = \"crowd\"\n");
    let dummy = |alias: &str| format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\n");
    let model = |parts: &str| format!("format = 1\n[model]\ntext = \"T.\"\n{parts}");
    place.write("models/leaf/model.toml", &model(&(dummy("leaf") + &dummy("sub") + &dummy("second"))));
    let change = "remove = [\"sec*\"]\nreplace = { sub = { kind = \"dummy\", alias = \"new\" } }";
    let leaves = format!("[[object]]\nmodel = \"leaf\"\n{change}\nrepeat = 8000\n");
    place.write("models/crowd/model.toml", &model(&(dummy("base") + &leaves)));
    let text = flat(&place, &[]);
    let count = |alias: &str| text.matches(&format!("alias = \"{alias}\"\n")).count();
    assert_eq!(["leaf", "new", "sub", "second"].map(count), [8000, 8000, 0, 0]);
}
