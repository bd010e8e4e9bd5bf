//! Tests that no work is lost, in a browser: saving, questions about unsaved changes, recovery, two pages that edit the
//! same script, and dropped files.

use std::path::PathBuf;

use serde_json::json;

use super::{
    drive::ScenePage,
    program::{PageServer, call, next},
};
use crate::{
    kit::browser::{BrowserPage, browser},
    kit::*,
};

const SCENE: &str = "# A cup on a floor.\nformat = 1\n\n[scene]\ntext = \"cups\" # for tests\n\n\
    [[object]]\nkind = \"shape\"\nalias = \"cup\"   # made of clay\nsize_m = [0.1, 0.1, 0.1]\n\
    position_m = [0.0, 0.0, 0.05]\n";

fn cup() -> ScenePage {
    let place = TestFolder::new();
    place.write("scenes/cup.toml", SCENE).write("scenes/other.toml", "format = 1\n");
    let mut shown = ScenePage::of(place, &["open", "scenes/cup.toml", "--no-browser"]);
    shown.until_shown("cup");
    shown
}

/// Renames an object in the tree.
fn rename(shown: &mut ScenePage, from: &str, to: &str) {
    let row = shown.row(from);
    shown.page.click_on(&row);
    shown.page.key("F2", 113);
    shown.page.until("document.querySelector('#tree input') !== null");
    shown.page.enter(to);
    shown.page.key("Enter", 13);
    shown.until(&format!("of({to:?}) !== undefined && !document.getElementById('unsaved').hidden"));
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_save_changes_one_line_and_says_where() {
    let mut shown = cup();
    let file = shown.folder().join("scenes/cup.toml");
    rename(&mut shown, "cup", "mug");
    shown.ctrl("s", 83);
    shown.page.until("document.getElementById('output').textContent.includes('Saved scenes/cup.toml')");
    shown.page.until("document.getElementById('unsaved').hidden");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), SCENE.replace("\"cup\"  ", "\"mug\"  "));
    // The page asks before it overwrites a file that another program has changed.
    rename(&mut shown, "mug", "jar");
    std::fs::write(&file, SCENE).unwrap();
    shown.ctrl("s", 83);
    shown.answer("Cancel");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), SCENE);
    shown.ctrl("s", 83);
    shown.answer("Replace");
    shown.page.until("document.getElementById('unsaved').hidden");
    assert!(std::fs::read_to_string(&file).unwrap().contains("jar"));
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn unsaved_changes_are_asked_for() {
    let mut shown = cup();
    rename(&mut shown, "cup", "mug");
    let open = |shown: &mut ScenePage| {
        shown.page.click_on("#gallery");
        let card = "[...document.querySelectorAll('#files .scene')].find((b) => b.title === 'scenes/other.toml')";
        // The list is sent again whenever the gallery opens, and cards may move.
        shown
            .page
            .until(&format!("{card} !== undefined && !document.getElementById('files').hasAttribute('aria-busy')"));
        shown.page.js(&format!("{card}.id = 'other'"));
        shown.page.click_on("#other");
    };
    open(&mut shown);
    shown.answer("Cancel");
    shown.until("of('mug') !== undefined");
    open(&mut shown);
    shown.answer("Save");
    shown.until("store.scene.file.endsWith('other.toml')");
    assert!(std::fs::read_to_string(shown.folder().join("scenes/cup.toml")).unwrap().contains("\"mug\""));
    // The browser asks when a page with unsaved changes is closed.
    shown.page.click_on("#new");
    shown.until("of('floor') !== undefined");
    let asked = "(() => { const e = new Event('beforeunload', { cancelable: true }); dispatchEvent(e); return e.defaultPrevented; })()";
    assert_eq!(shown.page.js(asked), false);
    rename(&mut shown, "floor", "ground");
    assert_eq!(shown.page.js(asked), true);
    shown.page.click_on("#new");
    shown.answer("Discard");
    shown.until("of('floor') !== undefined && document.getElementById('unsaved').hidden");
    shown.end();
}

#[cfg(unix)]
#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_recovery_copy_of_a_killed_program_is_offered() {
    let mut shown = cup();
    rename(&mut shown, "cup", "mug");
    let copy = shown.folder().join("scenes/.cup.toml.recovery/scene.toml");
    let wait = std::time::Duration::from_secs(60);
    crate::kit::browser::wait_for("a copy", wait, || copy.is_file().then_some(()));
    shown.served.process.kill().unwrap();
    shown.served.process.wait().unwrap();
    let served = PageServer::new(shown.folder(), &["open", "scenes/cup.toml", "--no-browser"]);
    let mut page = BrowserPage::open(&browser(), &served.url);
    let text = "document.querySelector('dialog.question')?.textContent ?? ''";
    page.until(&format!("({text}).includes('Restore unsaved changes?')"));
    page.js("document.querySelector('dialog.question button[value=Restore]').id = 'restore'");
    page.click_on("#restore");
    page.until("import('tatu/scene/store').then((s) => [...s.scene.objects.values()].some((o) => o.alias === 'mug'))");
    page.until("!document.getElementById('unsaved').hidden");
    assert_eq!(std::fs::read_to_string(shown.folder().join("scenes/cup.toml")).unwrap(), SCENE);
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}

#[test]
fn recovery_copies_of_program_scenes_are_in_the_state_folder() {
    let scene = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/first/pioneer_avoids_walls.toml");
    let place = TestFolder::new();
    let state = place.path().join("state");
    let served = PageServer::with_state(place.path(), &["open", scene.to_str().unwrap(), "--no-browser"], &state);
    let mut socket = served.socket();
    let scene_message = next(&mut socket, "scene");
    let objects = scene_message["objects"].as_array().unwrap();
    let id = &objects.iter().find(|o| o["alias"] == "crate").unwrap()["id"];
    call(&mut socket, "tatu.edit", json!(["Rename crate to chest", [["tatu.set", id, "object.alias", "chest"]]]));
    let is_copied = || {
        let all = std::fs::read_dir(state.join("tatu/recovery")).into_iter().flatten().flatten();
        all.map(|e| e.path().join("scene.toml")).find(|file| file.is_file())
    };
    let copy = crate::kit::browser::wait_for("a copy", std::time::Duration::from_secs(60), is_copied);
    assert!(std::fs::read_to_string(copy).unwrap().contains("alias = \"chest\""));
    assert!(!scene.with_file_name(".pioneer_avoids_walls.toml.recovery").exists());
    // The copy is offered to the same user only: one with another state folder has none.
    let recovery = |state: &std::path::Path| {
        let served = PageServer::with_state(place.path(), &["open", scene.to_str().unwrap(), "--no-browser"], state);
        next(&mut served.socket(), "state")["recovery"].is_number()
    };
    drop(served);
    assert!(recovery(&state));
    assert!(!recovery(&place.path().join("other")));
}

/// Replaces a text in the editor.
fn write(page: &mut BrowserPage, from: &str, to: &str) {
    page.until(&format!("(document.querySelector('.cm-content')?.textContent ?? '').includes({from:?})"));
    page.js(&format!(
        "(async () => {{ const {{ EditorView }} = await import('@codemirror/view'); \
         const v = EditorView.findFromDOM(document.querySelector('.cm-editor')); \
         const at = v.state.doc.toString().indexOf({from:?}); \
         v.dispatch({{ changes: {{ from: at, to: at + {}, insert: {to:?} }} }}); }})()",
        from.len()
    ));
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn two_pages_on_one_script_lose_no_edits() {
    let script = "script = { text = \"\"\"\nlocal cruise = 3\nfunction sysCall_init()\nend\"\"\" }\n";
    let mut mine = ScenePage::new(&format!("[[object]]\nkind = \"shape\"\nalias = \"cup\"\n{script}"));
    mine.until("of('cup')?.scripts?.length === 1");
    let mut theirs = BrowserPage::open(&browser(), &mine.served.url);
    theirs.until("document.querySelector('#tree .tool') !== null");
    mine.page.click_on("#tree .tool");
    theirs.click_on("#tree .tool");
    write(&mut mine.page, "cruise = 3", "cruise = 1");
    write(&mut theirs, "cruise = 3", "cruise = 2");
    let text = |shown: &mut ScenePage| {
        shown.ask("net.call('tatu.getScript', of('cup').scripts[0].id).then(([t]) => t.bytes ? atob(t.bytes) : t)")
    };
    theirs.click_on("#script-save");
    theirs.until("document.getElementById('output').textContent.includes('the new text is in the scene')");
    mine.page.until("document.getElementById('output').textContent.includes('was changed elsewhere')");
    mine.page.click_on("#script-save");
    mine.page.until("document.getElementById('theirs') !== null");
    let value =
        |page: &mut BrowserPage, id: &str| page.js(&format!("document.getElementById({id:?}).value")).to_string();
    assert!(
        value(&mut mine.page, "mine").contains("cruise = 1") && value(&mut mine.page, "theirs").contains("cruise = 2")
    );
    assert!(text(&mut mine).to_string().contains("cruise = 2"), "nothing was overwritten");
    mine.answer("Keep mine");
    mine.until("net.call('tatu.getScript', of('cup').scripts[0].id).then(([t]) => (t.bytes ? atob(t.bytes) : t).includes('cruise = 1'))");
    // The other page, which has no unsaved changes, shows the new text.
    theirs.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('cruise = 1')");
    // The editor asks about unsaved text before it closes.
    write(&mut mine.page, "cruise = 1", "cruise = 4");
    mine.page.click_on("#script-close");
    mine.answer("Cancel");
    assert!(mine.page.text(".cm-content").contains("cruise = 4"));
    mine.page.click_on("#script-close");
    mine.answer("Save");
    mine.page.until("document.getElementById('script').hidden");
    assert!(text(&mut mine).to_string().contains("cruise = 4"));
    mine.end();
}

/// Creates a folder with a scene and its script.
fn room(place: &TestFolder) -> PathBuf {
    place
        .write(
            "apart/room/room.toml",
            "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"lamp\"\nscript = \"scripts/lamp.lua\"\n",
        )
        .write("apart/room/scripts/lamp.lua", "function sysCall_init()\nend\n")
        .write("apart/room/notes.exe", "not taken");
    place.path().join("apart/room")
}

/// Opens a page without a scene in an empty folder, `work`, beside the folder of [`room`].
fn empty_page() -> (TestFolder, PathBuf, PageServer, BrowserPage) {
    let place = TestFolder::new();
    let room = room(&place);
    place.write("work/.keep", "");
    let served = PageServer::new(&place.path().join("work"), &["open", "--no-browser"]);
    let mut page = BrowserPage::open(&browser(), &served.url);
    page.until("document.getElementById('dialog')?.open");
    (place, room, served, page)
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_dropped_folder_is_opened_with_all_its_files() {
    let (place, room, _served, mut page) = empty_page();
    let lamp = "import('tatu/scene/store').then((s) => [...s.scene.objects.values()].some((o) => o.alias === 'lamp' && o.scripts.length === 1))";
    let files = |name: &str| {
        let at = |file: &str| place.path().join("work/dropped").join(name).join(file);
        (at("room.toml").is_file(), at("scripts/lamp.lua").is_file(), at("notes.exe").exists())
    };
    page.drop_files([600.0, 300.0], std::slice::from_ref(&room));
    page.until(lamp);
    assert_eq!(files("room"), (true, true, false));
    // The same file chosen in a dialog does not replace anything.
    page.click("#gallery");
    page.choose_files("#choose-folder", std::slice::from_ref(&room));
    page.until("document.getElementById('output').textContent.includes('files are in dropped/room-2')");
    page.until("import('tatu/scene/store').then((s) => s.scene.file.includes('room-2'))");
    assert_eq!(files("room-2"), (true, true, false));
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn dropped_robots_of_every_format_are_opened() {
    let (place, _room, _served, mut page) = empty_page();
    let box_of = "<geometry><box size=\"1 1 1\"/></geometry>";
    let link = format!("<link name=\"body\"><visual>{box_of}</visual></link>");
    let sdf_box = "<geometry><box><size>1 1 1</size></box></geometry>";
    let files = [
        (
            "one.sdf",
            format!(
                "<sdf version='1.9'><model name='one'><link name='l'><visual name='v'>{sdf_box}</visual></link></model></sdf>"
            ),
        ),
        (
            "two.xml",
            "<mujoco model='two'><worldbody><body name='b'><geom size='1'/></body></worldbody></mujoco>".to_owned(),
        ),
        ("three.xacro", format!("<robot name='three' xmlns:xacro='http://ros.org/wiki/xacro'>{link}</robot>")),
    ];
    for (name, text) in &files {
        let stem = name.split('.').next().unwrap();
        // A folder, so that each is opened instead of being added.
        place.write(&format!("apart/{stem}/{name}"), text);
        place.write(&format!("apart/{stem}/package.xml"), "<package><name>p</name></package>");
        page.drop_files([600.0, 300.0], &[place.path().join("apart").join(stem)]);
        page.until(&format!(
            "import('tatu/scene/store').then((s) => s.scene.file.includes('{name}') && s.scene.objects.size > 0)"
        ));
    }
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_folder_is_sent_again_if_the_connection_was_lost() {
    let (_place, room, _served, mut page) = empty_page();
    // The connection is closed in place of the first request for a folder.
    page.js("{ const { send } = WebSocket.prototype;
           WebSocket.prototype.send = function (text) {
             if (!String(text).includes('\"folder\"')) return send.call(this, text);
             WebSocket.prototype.send = send;
             this.close();
           }; }");
    page.drop_files([600.0, 300.0], &[room]);
    page.until("document.getElementById('output').textContent.includes('files are in dropped/room')");
    page.until("import('tatu/scene/store').then((s) => [...s.scene.objects.values()].some((o) => o.alias === 'lamp'))");
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}
