//! Tests of texts that were not saved when their scene was closed, and of what a page does while nothing happens, in a
//! browser.

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

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_stopped_scene_causes_no_messages() {
    let mut shown = ScenePage::new(SCENE);
    shown.until("of('brain')?.scripts.length === 1");
    shown.ask("store.select(of('brain').id)");
    shown.page.until("document.querySelector('#rows .row') !== null");
    shown.page.js("(() => { window.sent = 0; window.received = 0; const real = WebSocket.prototype.send; \
         WebSocket.prototype.send = function (m) { window.sent++; return real.call(this, m); }; })()");
    shown.ask("net.on('frame', () => { window.received++; })");
    // Whatever is still on its way arrives first.
    let quiet = "new Promise((done) => setTimeout(() => { const n = [window.sent, window.received]; \
                 setTimeout(() => done([window.sent - n[0], window.received - n[1]]), 3000); }, 2000))";
    let seen = shown.page.js(quiet);
    assert_eq!(seen, json!([0, 0]), "messages sent and frames received");
    shown.page.click_on("#play");
    shown.page.until("window.received > 3");
    shown.end();
}
