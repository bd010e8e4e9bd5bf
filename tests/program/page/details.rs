//! Tests of the properties of the selection and of the sliders of joints, in a browser.

use super::drive::ScenePage;
use crate::kit::*;

const FLOOR: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";
const ARM: &str = r#"
[[object]]
kind = "shape"
alias = "arm"
size_m = [0.2, 0.2, 0.1]
position_m = [0.0, 0.0, 0.05]
model_base = true
[[object]]
kind = "joint"
alias = "shoulder"
parent = "arm"
position_m = [0.0, 0.0, 0.05]
mode = "kinematic"
limits_deg = [-90.0, 90.0]
[[object]]
kind = "shape"
alias = "upper"
parent = "shoulder"
size_m = [0.4, 0.05, 0.05]
position_m = [0.2, 0.0, 0.03]
[[object]]
kind = "joint"
alias = "slide"
type = "prismatic"
parent = "upper"
position_m = [0.2, 0.0, 0.0]
mode = "kinematic"
limits_m = [0.0, 0.3]
"#;

impl ScenePage {
    /// Selects an object, and waits until its properties are shown.
    fn details_of(&mut self, alias: &str) {
        self.ask(&format!("store.select(of({alias:?}).id)"));
        self.page.until(&format!(
            "document.getElementById('what').textContent.startsWith({alias:?}) && \
             document.querySelectorAll('#rows .row').length > 5"
        ));
    }
    /// Replaces the text of a field by typing.
    fn replace(&mut self, selector: &str, text: &str) {
        self.page.click_on(selector);
        self.page.key_event("keyDown", "a", 65, 2);
        self.page.key_event("keyUp", "a", 65, 2);
        self.page.enter(text);
    }
}

/// Returns the CSS selector of the field of a property.
fn field(key: &str) -> String {
    format!("#rows [data-key='{key}'] input")
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn sliders_move_the_joints_of_a_model() {
    let mut shown = ScenePage::new(&format!("{FLOOR}{ARM}"));
    shown.until_shown("arm");
    shown.details_of("arm");
    shown.page.until("document.querySelectorAll('.joints .joint').length === 2");
    let from = shown.page.middle(".joint input[type=range]");
    // The middle of the slider is the middle of the limits. It is dragged towards 90 degrees.
    let to = [from[0] + 60.0, from[1]];
    shown.page.drag(from, to, false);
    shown.page.mouse("mouseReleased", to, 1, false);
    shown.until("get('shoulder', 'joint.position').then((x) => x > 0.5 && x < 1.2)");
    // The whole drag is one edit.
    shown.until("net.call('tatu.edits').then(([e]) => e.undo.join() === 'Move shoulder')");
    // A typed number is in degrees, or in m for a prismatic joint.
    shown.replace(".joint input[type=text]", "30");
    shown.page.key("Enter", 13);
    shown.until("get('shoulder', 'joint.position').then((x) => Math.abs(x - Math.PI / 6) < 1e-9)");
    shown.replace(".joint:nth-child(2) input[type=text]", "0.25");
    shown.page.key("Enter", 13);
    shown.until("get('slide', 'joint.position').then((x) => x === 0.25)");
    shown.page.click_on(".joints > button");
    shown.until("get('shoulder', 'joint.position').then((x) => x === 0)");
    shown.until("get('slide', 'joint.position').then((x) => x === 0)");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_slider_sets_the_target_of_a_driven_joint_in_a_run() {
    let driven = ARM.replacen("mode = \"kinematic\"", "control = \"position\"\nmax_force_nm = 50.0", 1);
    let mut shown = ScenePage::new(&format!(
        "{FLOOR}{}",
        driven.replacen("size_m = [0.4, 0.05, 0.05]", "size_m = [0.4, 0.05, 0.05]\ndynamic = true", 1)
    ));
    shown.until_shown("arm");
    shown.details_of("shoulder");
    shown.page.until("document.querySelectorAll('.joints .joint').length === 1");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('play').classList.contains('on')");
    shown.replace(".joint input[type=text]", "45");
    shown.page.key("Enter", 13);
    shown.until("get('shoulder', 'joint.target_position').then((x) => Math.abs(x - Math.PI / 4) < 1e-9)");
    shown.until("get('shoulder', 'joint.position').then((x) => Math.abs(x - Math.PI / 4) < 0.02)");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn angles_are_typed_in_degrees_and_names_are_words() {
    let mut shown = ScenePage::new(&format!("{FLOOR}{ARM}"));
    shown.until_shown("arm");
    shown.details_of("shoulder");
    shown.replace(&field("joint.limits"), "-45");
    shown.page.key("Enter", 13);
    shown.until("get('shoulder', 'joint.limits').then(([a, b]) => Math.abs(a + Math.PI / 4) < 1e-9 && Math.abs(b - Math.PI / 2) < 1e-9)");
    assert_eq!(shown.page.text("#rows [data-key='joint.max_force'] .name"), "Maximum force");
    shown.page.click_on(".raw input");
    assert_eq!(shown.page.text("#rows [data-key='joint.max_force'] .name"), "joint.max_force");
    // The button for help also works by keyboard.
    shown.page.js("document.querySelector(\"#rows [data-key='joint.max_force'] .ask\").focus()");
    shown.page.key(" ", 32);
    shown.page.until("!document.querySelector(\"#rows [data-key='joint.max_force'] .help\").hidden");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_refused_value_shows_the_reason_and_does_not_lose_the_focus() {
    let mut shown = ScenePage::new(&format!("{FLOOR}{ARM}"));
    shown.until_shown("arm");
    shown.details_of("upper");
    let mass = shown.page.js(&format!("document.querySelector({:?}).value", field("shape.mass")));
    shown.page.js(&format!("globalThis.mass = document.querySelector({:?})", field("shape.mass")));
    shown.replace(&field("shape.mass"), "-3");
    shown.page.key("Enter", 13);
    let why = "#rows [data-key='shape.mass'] .why";
    shown
        .page
        .until(&format!("document.querySelector({why:?}).textContent.includes('expected a number above 0, found -3')"));
    // New values update the other fields, but not the field that is being edited.
    shown.ask("net.call('tatu.set', of('upper').id, 'shape.friction', 0.5)");
    shown.page.until(&format!("document.querySelector({:?}).value === '0.5'", field("shape.friction")));
    assert_eq!(shown.page.js("document.activeElement === globalThis.mass && globalThis.mass.value"), "-3");
    shown.page.key("Escape", 27);
    assert_eq!(shown.page.js("document.activeElement === globalThis.mass && globalThis.mass.value"), mass);
    assert_eq!(shown.page.text(why), "");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn every_value_is_shown_in_readable_form() {
    let place =
        TestFolder::scene(&format!("{FLOOR}[[model]]\nmodel = \"pioneer_p3dx\"\n[[model]]\nmodel = \"hokuyo\"\n"));
    let mut shown = ScenePage::of(place, &["open", "scene.toml", "--no-browser"]);
    shown.until_shown("Pioneer_p3dx");
    shown.page.js("localStorage.setItem('tatu details More', '1')");
    let ids = shown.ask("[...store.scene.objects.keys()]");
    for id in ids.as_array().unwrap() {
        shown.ask(&format!("store.select({id})"));
        shown.page.until("document.querySelectorAll('#rows .row').length > 5");
        let wrong = shown.page.js(
            "(document.querySelector('aside').innerText + [...document.querySelectorAll('aside input')].map((i) => \
             i.value).join()).match(/.*(object Object|undefined|NaN).*/)?.[0] ?? ''",
        );
        assert_eq!(wrong, "", "object {id}");
    }
    // The parent is shown as a link that selects it. Once the slider above the link is shown, its position is final.
    shown.details_of("Pioneer_p3dx_leftMotor");
    shown.page.until("document.querySelectorAll('.joints:not([hidden]) .joint').length === 1");
    shown
        .page
        .js("document.querySelector(\"#rows [data-key='object.parent'] .link\").scrollIntoView({ block: 'center' })");
    shown.page.click_on("#rows [data-key='object.parent'] .link");
    shown.page.until("document.getElementById('what').textContent.startsWith('Pioneer_p3dx ')");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn fields_accept_expressions_and_units() {
    let mut shown = ScenePage::new(&format!("{FLOOR}{ARM}"));
    shown.until_shown("upper");
    shown.details_of("upper");
    let position = field("object.position");
    for (text, value) in [("2*3", 6.0), ("10 cm", 0.1), ("1,5 + 5 mm", 1.505)] {
        shown.replace(&position, text);
        shown.page.key("Enter", 13);
        shown.until(&format!("get('upper', 'object.position').then((p) => Math.abs(p[0] - {value}) < 1e-9)"));
    }
    shown.replace(&position, "2 kg");
    shown.page.key("Enter", 13);
    shown.page.until(
        "document.querySelector(\"#rows [data-key='object.position'] .why\").textContent.includes('\"kg\" is not a unit')",
    );
    shown.page.key("Escape", 27);
    shown.replace(&field("object.orientation"), "(pi/2) rad");
    shown.page.key("Enter", 13);
    shown.until("get('upper', 'object.orientation').then((o) => Math.abs(o[0] - Math.PI / 2) < 1e-9)");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn panel_shows_the_scene_without_a_selection_and_no_empty_group() {
    let scene = format!(
        "# An arm.\n# Try: bend it.\nformat = 1\n{FLOOR}[[object]]\nkind = \"dummy\"\nalias = \"mark\"\n\
         script = {{ language = \"lua\", text = \"x = 1\" }}\n[[model]]\nmodel = \"pioneer_p3dx\"\n"
    );
    let place = TestFolder::new();
    place.write("bent_arm.toml", &scene);
    let mut shown = ScenePage::of(place, &["open", "bent_arm.toml", "--no-browser"]);
    shown.until_shown("Pioneer_p3dx");
    let about = "document.getElementById('about-scene')";
    shown.page.until("document.getElementById('what').textContent === 'bent arm'");
    let text = shown.page.text("#about-scene");
    for part in ["An arm.", "Try: bend it.", "Objects", "in one model", "50 ms", "mark", "F5"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // A robot whose base is a hidden body is visible.
    shown.details_of("Pioneer_p3dx");
    assert_eq!(shown.page.js(&format!("{about}.hidden")), true);
    shown.page.until("document.querySelector(\"#rows [data-key='object.visible']\").textContent.includes('yes')");
    assert_eq!(shown.page.text("#what"), "Pioneer_p3dx \u{2014} model");
    shown.details_of("mark");
    shown.page.until("[...document.querySelectorAll('#rows details')].every((d) => d.querySelector('.row') !== null)");
    // Parts of models are named without the name of the model, and models are collapsed until a part is selected.
    let row = "document.querySelector(`#tree [data-id='${of('Pioneer_p3dx_leftMotor').id}'] .alias`)";
    assert_eq!(shown.ask(&format!("{row} === null")), true);
    shown.ask("store.select(of('Pioneer_p3dx_leftMotor').id)");
    shown.until(&format!("{row}.textContent === 'leftMotor' && {row}.title === 'Pioneer_p3dx_leftMotor'"));
    shown.ask("store.select(0)");
    shown.page.until(&format!("!{about}.hidden"));
    shown.page.js(&format!("{about}.querySelector('.link').id = 'script-link'"));
    shown.page.click_on("#script-link");
    shown.page.until("!document.getElementById('script').hidden");
    shown.end();
}
