//! Tests of texts that were not saved when their scene was closed, in a browser.

use serde_json::json;

use super::{
    drive::ScenePage,
    program::{call, next},
};

const SCENE: &str = "[[object]]\nkind = \"dummy\"\nalias = \"brain\"\nscript = { text = \"x = 1\" }\n";

/// JavaScript that returns the text in the editor.
const TEXT: &str = "document.querySelector('.cm-content')?.textContent";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn an_unsaved_text_survives_another_client_that_opens_a_scene() {
    let mut shown = ScenePage::new(SCENE);
    shown.until("of('brain')?.scripts.length === 1");
    let file = shown.ask("store.scene.file");
    shown.ask("store.select(of('brain').id)");
    let row = shown.row("brain");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.until(&format!("({TEXT}) === 'x = 1'"));
    shown.page.key("End", 35);
    shown.page.enter("2");
    let mut socket = shown.served.socket();
    next(&mut socket, "scene");
    call(&mut socket, "tatu.newScene", json!([]));
    shown.until("of('brain') === undefined && document.getElementById('script').hidden");
    shown.page.until("document.getElementById('output').textContent.includes('is kept')");
    assert_eq!(shown.ask("store.selection().length"), 0, "an object of the new scene is selected");
    // The text is offered when the script is opened again.
    call(&mut socket, "tatu.open", json!([file]));
    shown.until("of('brain')?.scripts.length === 1");
    let row = shown.row("brain");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.answer("Continue");
    shown.until(&format!("({TEXT}) === 'x = 12'"));
    shown.page.click_on("#script-save");
    shown.until("net.call('tatu.getScript', of('brain').scripts[0].id).then(([t]) => atob(t.bytes) === 'x = 12')");
    shown.end();
}
