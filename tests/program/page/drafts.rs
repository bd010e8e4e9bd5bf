//! Tests of texts in the script editor that have not been saved, in a browser: those that are saved with the scene or a
//! run, and those that are kept when their scene is closed.

use serde_json::json;

use super::{
    drive::ScenePage,
    program::{call, next},
};
use crate::kit::*;

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

/// Opens the script of `brain`, and appends to its text.
fn write(shown: &mut ScenePage, text: &str, addition: &str) {
    shown.until("of('brain')?.scripts.length === 1");
    let row = shown.row("brain");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.until(&format!("({TEXT}) === {text:?}"));
    shown.page.key("End", 35);
    shown.page.enter(addition);
}

/// JavaScript that is true if the scene has this text as the script of `brain`.
fn source_is(text: &str) -> String {
    format!("net.call('tatu.getScript', of('brain').scripts[0].id).then(([t]) => atob(t.bytes) === {text:?})")
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_scene_is_saved_and_run_with_the_text_in_the_editor() {
    let mut shown = ScenePage::new(SCENE);
    let is_unsaved = "!document.getElementById('unsaved').hidden";
    shown.until("of('brain')?.scripts.length === 1");
    assert_eq!(shown.page.js(is_unsaved), false);
    write(&mut shown, "x = 1", "2");
    shown.page.until(is_unsaved);
    shown.page.click_on("#save");
    shown.page.until("document.getElementById('last-line').textContent.startsWith('Saved')");
    shown.page.until(&format!("!({is_unsaved})"));
    shown.until(&source_is("x = 12"));
    let saved = std::fs::read_to_string(shown.folder().join("scene_files/brain.lua")).unwrap();
    assert_eq!(saved.trim(), "x = 12");
    // A run starts with the new text.
    shown.page.click_on(".cm-content");
    shown.page.key("End", 35);
    shown.page.enter("3");
    shown.page.click_on("#play");
    shown.until(&source_is("x = 123"));
    shown.page.until("document.getElementById('play').classList.contains('on')");
    shown.page.click_on("#stop");
    shown.page.until("document.getElementById('stop').disabled");
    // It does not start with a text that cannot be loaded.
    shown.page.click_on(".cm-content");
    shown.page.key("End", 35);
    shown.page.enter(" = = ");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('last-line').textContent.startsWith('Not started')");
    assert_eq!(shown.page.js("document.getElementById('stop').disabled"), true);
    shown.until(&source_is("x = 123"));
    // The scene can be saved nevertheless, and the text remains unsaved.
    shown.page.click_on("#save");
    shown.page.until("document.getElementById('output').textContent.includes('The file will not have the new text')");
    shown.page.until("document.getElementById('last-line').textContent.startsWith('Saved')");
    assert_eq!(shown.page.js(is_unsaved), true);
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn drafts_are_stored_during_writing_and_belong_to_one_scene() {
    let place = TestFolder::new();
    let scene = format!("format = 1\n{SCENE}");
    place.write("one/scene.toml", &scene).write("two/scene.toml", &scene.replace("x = 1", "y = 1"));
    let mut shown = ScenePage::of(place, &["open", "one/scene.toml", "--no-browser"]);
    write(&mut shown, "x = 1", "2");
    let drafts = "Object.keys(localStorage).filter((k) => k.startsWith('tatu draft ')).length";
    shown.page.until(&format!("{drafts} === 1"));
    // A scene in another folder has a file of the same name, and a script at the same place.
    let mut socket = shown.served.socket();
    next(&mut socket, "scene");
    call(&mut socket, "tatu.open", json!(["two/scene.toml"]));
    shown.until("store.scene.file.includes('two') && document.getElementById('script').hidden");
    write(&mut shown, "y = 1", "3");
    shown.page.until(&format!("{drafts} === 2"));
    shown.page.click_on("#script-save");
    shown.until(&source_is("y = 13"));
    shown.page.until(&format!("{drafts} === 1"));
    call(&mut socket, "tatu.open", json!(["one/scene.toml"]));
    shown.until("store.scene.file.includes('one') && of('brain')?.scripts.length === 1");
    let row = shown.row("brain");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown
        .page
        .until(r"/a text of .*\d.* that was not saved/.test(document.querySelector('dialog.question')?.textContent)");
    shown.answer("Discard");
    shown.until(&format!("({TEXT}) === 'x = 1'"));
    shown.page.until(&format!("{drafts} === 0"));
    shown.end();
}
