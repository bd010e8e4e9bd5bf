//! Tests of model cards, which compare measurements with the data sheet, and of payloads.

use crate::kit::*;

const CART: &str = r#"
format = 1
[model]
text = "A cart that falls."
[model.params.mass]
type = "float"
unit = "kg"
default = 2.0
text = "Mass."
[model.numbers.height]
value = 10.0
unit = "m"
source = "the drop tower's sheet"
[[object]]
kind = "shape"
alias = "cart"
dynamic = true
mass_kg = "=mass"
position_m = [0.0, 0.0, "=height"]
"#;

const CARD_SCRIPT: &str = "function fall()
    local from = sim.getObjectPosition(measure.model())[3]
    sim.wait(1)
    return from - sim.getObjectPosition(measure.model())[3]
end
function mass()
    return measure.mass(measure.model())
end
function endless()
    while true do sim.step() end
end
function text()
    return 'much'
end
function stops()
    sim.stopSimulation()
    sim.wait(1)
    return 1
end
function broken()
    return nothing.at.all
end
";

fn measure(name: &str, expected: f64, more: &str) -> String {
    format!(
        "[[measure]]\nname = \"{name}\"\ntext = \"T\"\nunit = \"m\"\nexpected = {expected:?}\nsource = \"S\"\n{more}\n"
    )
}

fn place(card: &str) -> TestFolder {
    let place = TestFolder::new();
    place.write("models/cart/model.toml", CART).write("models/cart/card.lua", CARD_SCRIPT);
    place.write("models/cart/card.toml", &format!("format = 1\nnot_shown = [\"air\"]\n{card}"));
    place
}

#[test]
fn the_behaviour_of_a_model_is_measured_written_and_graded() {
    let card = measure("fall", 4.905, "") + &measure("mass", 3.0, "params = { mass_kg = 3.0 }");
    let place = place(&card);
    // The card contains no measured values yet.
    let first = place.tatu(&["measure", "cart"]);
    assert_eq!(first.code, 1);
    assert!(first.out.contains("not recorded: use --write") && first.out.contains("grade B"), "{}", first.out);
    let written = place.tatu(&["measure", "models/cart", "--write"]).good();
    assert!(written.out.contains("grade A"), "{}", written.out);
    assert!(place.read("models/cart/card.toml").contains("measured = 3.0\n"));
    place.tatu(&["measure", "models/cart/model.toml", "--only", "mass"]).good();
    let told = place.tatu(&["describe", "cart", "--json"]).good().json();
    assert!(told["grade"].as_str().unwrap().starts_with("A: "), "{told}");
    assert_eq!((&told["measures"][1]["measured"], &told["not_shown"][0]), (&3.0.into(), &"air".into()));
    // First the value recorded in the card differs from the measurement, then the measurement from the data sheet.
    let stale = place.read("models/cart/card.toml").replace("measured = 3.0\n", "measured = 3.05\n");
    place.write("models/cart/card.toml", &stale);
    let said = place.tatu(&["measure", "cart"]);
    assert!(said.code == 1 && said.out.contains("recorded otherwise"), "{}", said.out);
    place.write("models/cart/model.toml", &CART.replace("\"=mass\"", "\"=1.1 * mass\""));
    let said = place.tatu(&["measure", "cart", "--json"]);
    assert_eq!((said.code, &said.json()[1]["verdict"]), (1, &"off".into()));
}

#[test]
fn functions_that_fail_are_named() {
    let all = measure("endless", 1.0, "seconds = 2.0")
        + &measure("broken", 1.0, "")
        + &measure("missing", 1.0, "")
        + &measure("text", 1.0, "")
        + &measure("stops", 1.0, "");
    let place = place(&all);
    for (name, words) in [
        ("endless", "`endless` of models/cart/card.lua returned no number within 2 s"),
        ("broken", "card.lua:21"),
        ("missing", "`missing` of models/cart/card.lua failed"),
        ("text", "text returned a string: expected a number"),
        ("stops", "`stops` of models/cart/card.lua ended the run"),
    ] {
        place.tatu(&["measure", "models/cart", "--only", name]).refused(&["error[E126]", words]);
    }
    place
        .tatu(&["measure", "cart", "--only", "fal"])
        .refused(&["error[E130]", "endless, broken, missing, text, stops"]);
    place.tatu(&["measure", "carts"]).refused(&["error[E130]", "no model `carts`"]);
}

#[test]
fn mistakes_in_cards_name_the_line() {
    for (card, words) in [
        ("[[measure]]\nname = \"a\"\ntxt = \"T\"\n", ["error[E101]", "card.toml:5:1"]),
        ("[[measure]]\nname = \"a b\"\n", ["error[E102]", "card.toml:4:8"]),
        (&measure("a", 0.0, ""), ["error[E104]", "`within`"]),
        (&measure("a", 1.0, "tolerance = -1"), ["error[E102]", "greater than 0"]),
        ("", ["error[E104]", "no [[measure]]"]),
        (&measure("a", 1.0, "measured = \"much\""), ["error[E102]", "`measured` is not a finite number"]),
        ("measure = 1\n", ["error[E102]", "[[measure]]"]),
        ("[[measure]\n", ["error[E100]", "card.toml:3"]),
    ] {
        place(card).tatu(&["measure", "cart"]).refused(&words);
    }
    let place = TestFolder::new();
    place.write("models/cart/model.toml", CART);
    place.tatu(&["measure", "cart"]).refused(&["error[E105]", "no card.toml"]);
    let told = place.tatu(&["describe", "cart", "--json"]).good().json();
    assert!(told["grade"].as_str().unwrap().starts_with("C: "), "{told}");
}

#[test]
fn a_payload_above_the_sheet_is_warned_of() {
    let arm = "format = 1\n[model]\ntext = \"An arm.\"\n[model.slots.flange]\npayload_kg = 3.0\n\
               [[object]]\nkind = \"shape\"\nalias = \"arm\"\n[[object]]\nkind = \"dummy\"\nalias = \"flange\"\n";
    let load = |mass: f64| {
        let box_of = format!("kind = \"shape\", dynamic = true, mass_kg = {mass:?}");
        let place = TestFolder::scene(&format!("[[model]]\nmodel = \"arm\"\nslots = {{ flange = {{ {box_of} }} }}\n"));
        place.write("models/arm/model.toml", arm);
        place.run(&["--steps", "1"]).good().err
    };
    assert!(load(3.5).contains("the slot `flange` of `arm` carries 3.500 kg; its payload is 3 kg"), "{}", load(3.5));
    assert!(!load(2.5).contains("payload"));
    let place = TestFolder::new();
    place.write("models/arm/model.toml", &arm.replace("3.0", "-1"));
    place.tatu(&["check", "models/arm/model.toml"]).refused(&["`payload_kg`", "greater than 0"]);
}
