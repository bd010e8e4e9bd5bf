//! Tests of the script editor and of windows of scripts, in a browser.

use serde_json::json;

use super::{
    drive::Shown,
    program::{call, next},
};
use crate::kit::*;

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_editor_saves_marks_errors_and_follows_other_clients() {
    let mut shown = Shown::new("[[object]]\nkind = \"dummy\"\nalias = \"brain\"\nscript = { text = \"x = 1\" }\n");
    shown.until("of('brain')?.scripts.length === 1");
    let row = format!("#tree [data-id=\"{}\"]", shown.ask("of('brain').id"));
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    let text = "document.querySelector('.cm-content')?.cmView?.view?.state.doc.toString() ?? \
                document.querySelector('.cm-content')?.textContent";
    shown.until(&format!("({text}) === 'x = 1'"));
    let source = "net.call('tatu.getScript', of('brain').scripts[0].id).then(([t]) => atob(t.bytes))";
    shown.page.key("End", 35);
    shown.page.enter("2");
    shown.page.key_event("keyDown", "s", 83, 2);
    shown.page.key_event("keyUp", "s", 83, 2);
    shown.until(&format!("{source}.then((t) => t === 'x = 12')"));
    shown.page.key("End", 35);
    shown.page.enter(" = =");
    shown.page.click_on("#script-save");
    shown.page.until("document.querySelector('.cm-lintRange-error') !== null");
    assert_eq!(shown.ask(source), "x = 12");
    // What another client saves does not replace what is being written, but the text as it was last saved.
    let mut socket = shown.served.socket();
    next(&mut socket, "scene");
    let script = shown.ask("of('brain').scripts[0].id");
    call(&mut socket, "tatu.setScript", json!([script, "x = 3"]));
    shown.until(&format!("{source}.then((t) => t === 'x = 3')"));
    shown.until(&format!("({text}) === 'x = 12 = ='"));
    shown.page.click_on("#script-close");
    shown.answer("Discard");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.until(&format!("({text}) === 'x = 3'"));
    call(&mut socket, "tatu.setScript", json!([script, "x = 4"]));
    shown.until(&format!("({text}) === 'x = 4'"));
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn windows_of_scripts_are_dragged_used_and_closed() {
    let scene = std::fs::read_to_string(root().join("plugins/commands/simui/demo.toml")).unwrap();
    let place = Place::new();
    place.write("scene.toml", &scene);
    let mut shown = Shown::of(place, &["open", "scene.toml", "--no-browser"]);
    shown.page.click_on("#play");
    shown.page.until("document.querySelector('.window .title') !== null");
    let slider = shown.page.middle(".window input[type=range]");
    let width = shown.page.js("document.querySelector('.window input[type=range]').clientWidth").as_f64().unwrap();
    shown.page.drag(slider, [slider[0] + 0.6 * width, slider[1]], false);
    shown.page.mouse("mouseReleased", [slider[0] + 0.6 * width, slider[1]], 1, false);
    shown.page.until("document.querySelector('.window').textContent.includes('6.0 rad/s')");
    shown.until("get('Pioneer_p3dx_leftMotor', 'joint.target_velocity').then((v) => v === 6)");
    let place =
        "(() => { const b = document.querySelector('.window').getBoundingClientRect(); return [b.left, b.top]; })()";
    let before = shown.page.js(place);
    let title = shown.page.js(
        "(() => { const b = document.querySelector('.window .title').getBoundingClientRect(); return [b.left + b.width / 2, b.top + 4]; })()",
    );
    let from = [0, 1].map(|i| title[i].as_f64().unwrap());
    shown.page.drag(from, [from[0] + 50.0, from[1] + 30.0], false);
    shown.page.mouse("mouseReleased", [from[0] + 50.0, from[1] + 30.0], 1, false);
    let after = shown.page.js(place);
    let moved = [0, 1].map(|i| after[i].as_f64().unwrap() - before[i].as_f64().unwrap());
    assert_eq!(moved, [50.0, 30.0]);
    shown.page.click_on(".window .title button");
    shown.page.until("document.querySelector('.window:not([hidden])') === null");
    shown.end();
}
