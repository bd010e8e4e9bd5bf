//! Tests of building a scene by the mouse and keys, in a browser.

use super::drive::ScenePage;
use crate::kit::*;

const FLOOR: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";

fn block(alias: &str, x: f64) -> String {
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nsize_m = [0.4, 0.4, 0.4]\nposition_m = [{x:.1}, 0.0, 0.2]\n"
    )
}

/// Shows a scene with two blocks on a floor.
fn blocks() -> ScenePage {
    let mut shown = ScenePage::new(&format!("{FLOOR}{}{}", block("left", -0.5), block("right", 0.5)));
    shown.until("of('left') !== undefined");
    shown.until_shown("right");
    shown
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_new_scene_is_built_by_drags_and_clicks_and_saved() {
    let place = TestFolder::new();
    place.write("scenes/.keep", "");
    let mut shown = ScenePage::of(place, &["open", "--no-browser"]);
    shown.page.until("document.getElementById('dialog').open");
    shown.page.key("Escape", 27);
    shown.page.until("!document.getElementById('dialog').open");
    shown.page.click_on("#new");
    shown.until("store.scene.file.endsWith('untitled.toml')");
    shown.until_shown("floor");
    // An entry is dragged into the view, and placed on the floor.
    shown.page.click_on("#add");
    shown.page.until("document.querySelectorAll('#items .entry').length > 20");
    for kind in ["box", "wall", "revolute", "proximity", "dummy", "pioneer_p3dx"] {
        shown.page.until(&format!("document.querySelector('#items [data-item={kind}]') !== null"));
    }
    let entry = shown.page.middle("#items [data-item=box]");
    let view = shown.page.middle("#view");
    shown.page.drag(entry, view, false);
    shown.page.mouse("mouseReleased", view, 1, false);
    shown.until("of('box') !== undefined && store.selected() === of('box').id");
    shown.until("get('box', 'object.position').then((p) => Math.abs(p[2] - 0.1) < 1e-3)");
    shown.until("get('box', 'shape.dynamic')");
    // A second entry is clicked and placed by a click on the box. A third one is cancelled.
    shown.page.click_on("#items [data-item=sphere]");
    shown.page.key("Escape", 27);
    shown.page.click_at(view, 1);
    shown.page.click_on("#items [data-item=cylinder]");
    let top = shown.pixel("box", [0.0, 0.0, 0.1]);
    shown.page.click_at(top, 1);
    shown.until("of('cylinder') !== undefined && of('sphere') === undefined");
    shown.until("get('cylinder', 'object.position').then((p) => Math.abs(p[2] - 0.35) < 2e-3)");
    // An entry chosen by keys is placed at the centre of the view.
    shown.page.js("(() => { const s = document.getElementById('find-item'); s.value = 'pioneer_p3dx'; s.oninput(); document.querySelector('#items [data-item=pioneer_p3dx]').focus(); })()");
    shown.page.press_enter();
    shown.until("of('Pioneer_p3dx') !== undefined && store.selected() === of('Pioneer_p3dx').id");
    shown.page.until("document.getElementById('undo').title === 'Undo Add pioneer_p3dx (Ctrl+Z)'");
    // A new scene asks for its name.
    shown.page.js("document.getElementById('view').focus()");
    shown.ctrl("s", 83);
    shown.page.until("document.querySelector('dialog.question input') !== null");
    shown.page.js("document.querySelector('dialog.question input').select()");
    shown.page.enter("scenes/built.toml");
    shown.answer("Save");
    shown.page.until(
        "document.getElementById('unsaved').hidden && document.getElementById('name').textContent === 'built.toml'",
    );
    shown.page.until("document.getElementById('output').textContent.includes('Saved scenes/built.toml')");
    let text = std::fs::read_to_string(shown.folder().join("scenes/built.toml")).unwrap();
    assert!(text.contains("alias = \"box\"") && text.contains("model = \"pioneer_p3dx\""), "{text}");
    assert!(!text.contains("service"), "the page must not be saved as part of the scene: {text}");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn twenty_edits_are_undone_and_done_again() {
    let mut shown = blocks();
    let at = shown.pixel("left", [0.0, 0.0, 0.2]);
    shown.page.click_at(at, 1);
    shown.until("store.selected() === of('left').id");
    // The block is deleted, which is undone, and is then copied twenty times.
    shown.page.key("Delete", 46);
    shown.until("of('left') === undefined");
    shown.ctrl("z", 90);
    shown.until("of('left') !== undefined");
    shown.page.click_at(at, 1);
    shown.until("store.selected() === of('left').id");
    let count =
        |n: usize| format!("[...store.scene.objects.values()].filter((o) => o.alias === 'left').length === {n}");
    for n in 2..=21 {
        shown.ctrl("d", 68);
        shown.until(&format!("{} && store.selected() !== of('left').id", count(n)));
    }
    for n in (1..=20).rev() {
        shown.ctrl("z", 90);
        shown.until(&count(n));
    }
    shown.until("document.getElementById('unsaved').hidden && document.getElementById('undo').disabled");
    for n in 2..=21 {
        shown.ctrl("y", 89);
        shown.until(&count(n));
    }
    shown.until("!document.getElementById('unsaved').hidden && document.getElementById('redo').disabled");
    // While the simulation is running, undo is disabled, and the button explains why.
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('undo').title.includes('Not while the simulation runs')");
    assert_eq!(shown.page.js("document.getElementById('undo').disabled"), true);
    shown.page.click_on("#stop");
    shown.page.until("!document.getElementById('undo').disabled");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn objects_are_copied_renamed_and_attached() {
    let mut shown = blocks();
    let at = shown.pixel("left", [0.0, 0.0, 0.2]);
    shown.page.click_at(at, 1);
    shown.until("store.selected() === of('left').id");
    // Copies are pasted where the pointer is on the ground.
    shown.ctrl("c", 67);
    let there = shown.pixel("floor", [-0.2, -0.8, 0.0]);
    shown.page.mouse("mouseMoved", there, 0, false);
    shown.ctrl("v", 86);
    shown.until("store.selected() !== of('left').id && store.scene.objects.get(store.selected())?.alias === 'left'");
    shown.until("(async () => { const [p] = await net.call('tatu.get', store.selected(), 'object.position'); return Math.abs(p[0] + 0.2) < 0.02 && Math.abs(p[1] + 0.8) < 0.02 && Math.abs(p[2] - 0.2) < 1e-6; })()");
    // The object is renamed in the tree.
    shown.page.key("F2", 113);
    shown.page.until("document.querySelector('#tree input') !== null");
    shown.page.enter("mug");
    shown.page.key("Enter", 13);
    shown.until("of('mug') !== undefined");
    shown.page.until("document.getElementById('undo').title === 'Undo Rename left to mug (Ctrl+Z)'");
    // Dragging an object in the tree attaches it to another one without moving it. It is then detached again.
    let (mug, right) = (shown.row("mug"), shown.row("right"));
    let (from, to) = (shown.page.middle(&mug), shown.page.middle(&right));
    shown.page.drag(from, to, false);
    shown.page.mouse("mouseReleased", to, 1, false);
    shown.until("of('mug').parent === of('right').id");
    shown.until(
        "get('mug', 'object.world_pose').then((p) => Math.abs(p[0] + 0.2) < 0.02 && Math.abs(p[1] + 0.8) < 0.02)",
    );
    let from = shown.page.middle(&mug);
    let empty = shown.page.js("(() => { const b = document.getElementById('tree').getBoundingClientRect(); return [b.left + 40, b.bottom - 20]; })()");
    let empty = [0, 1].map(|i| empty[i].as_f64().unwrap());
    shown.page.drag(from, empty, false);
    shown.page.mouse("mouseReleased", empty, 1, false);
    shown.until("of('mug').parent === 0");
    // A selection box selects all three objects, which are then aligned.
    let corners = shown.page.js("(() => { const b = document.getElementById('view').getBoundingClientRect(); \
         return [b.left + 5, b.top + 60, b.right - 5, b.bottom - 5]; })()");
    let [x, y, right, bottom] = [0, 1, 2, 3].map(|i| corners[i].as_f64().unwrap());
    let (a, b) = ([x, y], [right, bottom]);
    shown.page.drag(a, b, true);
    shown.page.mouse("mouseReleased", b, 1, true);
    shown.until("store.selection().length === 3 && !store.selection().includes(of('floor').id)");
    shown.page.js("(() => { document.querySelector('#arrange select').value = 'y'; })()");
    shown.page.click_on("#align-middle");
    shown.until("Promise.all(['left', 'mug', 'right'].map((a) => get(a, 'object.position'))).then((all) => all.every((p) => Math.abs(p[1] - all[0][1]) < 1e-5))");
    shown.page.key("Delete", 46);
    shown.until("of('mug') === undefined && of('left') === undefined && of('right') === undefined");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_click_selects_the_model_and_a_second_one_its_part() {
    let mut shown = ScenePage::new(&format!("{FLOOR}[[model]]\nmodel = \"pioneer_p3dx\"\n"));
    shown.until_shown("Pioneer_p3dx");
    let wheel = "[...store.scene.objects.values()].find((o) => o.alias === 'Pioneer_p3dx_rightWheel').alias";
    let alias = shown.ask(wheel).as_str().unwrap().to_owned();
    let at = shown.pixel(&alias, [0.0, 0.0, 0.0]);
    shown.page.click_at(at, 1);
    shown.until("store.selected() === of('Pioneer_p3dx').id");
    shown.page.click_at(at, 1);
    shown.until("store.selected() !== of('Pioneer_p3dx').id && store.selected() !== 0");
    shown.page.key("Escape", 27);
    shown.until("store.selected() === of('Pioneer_p3dx').id");
    shown.page.key("Escape", 27);
    shown.until("store.selected() === 0");
    // The menu of the tree adds a script, and undo removes it.
    let row = shown.row("floor");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 1);
    shown.page.js(&format!("document.querySelector({row:?}).dispatchEvent(new MouseEvent('contextmenu', {{ bubbles: true, clientX: {}, clientY: {} }}))", at[0], at[1]));
    shown.page.until("document.querySelector('.menu') !== null");
    shown.page.js("[...document.querySelectorAll('.menu button')].find((b) => b.textContent.includes('Add script')).id = 'add-script'");
    shown.page.click_on("#add-script");
    shown.until("(of('floor').scripts ?? []).length === 1");
    shown.ctrl("z", 90);
    shown.until("(of('floor').scripts ?? []).length === 0");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn everything_in_the_palette_can_be_added_and_undone() {
    let mut shown = blocks();
    let failed = shown.ask(
        "(async () => { \
         const [stock, edits] = await Promise.all(['tatu/edit/palette_items', 'tatu/scene/edits'].map((m) => import(m))); \
         const [[kinds], [models]] = await Promise.all([net.call('tatu.kinds'), net.call('tatu.models')]); \
         const items = [...stock.FIXED, ...stock.devices(kinds), ...stock.models(models)].flatMap((s) => s.items); \
         const failed = items.length > 30 ? [] : ['there are few entries']; \
         for (const i of items) { \
           const call = i.model ? ['tatu.addModel', i.model] : ['tatu.add', i.toml, 0, [1, 1, 1]]; \
           try { await edits.edit(`Add ${i.name}`, [call]); } catch (e) { failed.push(`${i.name}: ${e.error}`); continue; } \
           if (await edits.undo() !== `Add ${i.name}`) failed.push(`${i.name}: not undone`); \
         } \
         return failed; })()",
    );
    assert_eq!(failed, serde_json::json!([]));
    shown.until("store.scene.objects.size === 3 && document.getElementById('unsaved').hidden");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn two_objects_are_assembled_and_new_ones_snap_to_the_grid() {
    let mut shown = blocks();
    let (left, right) = (shown.row("left"), shown.row("right"));
    shown.page.click_on(&left);
    let at = shown.page.middle(&right);
    shown.page.mouse("mouseMoved", at, 0, false);
    for kind in ["mousePressed", "mouseReleased"] {
        shown.page.mouse(kind, at, 1, true);
    }
    shown.until("store.selection().length === 2");
    shown.page.click_on("#assemble");
    shown.until("of('right').parent === of('left').id");
    shown.until("get('right', 'object.world_pose').then((p) => Math.abs(p[0] - 0.5) < 1e-6)");
    shown.ctrl("z", 90);
    shown.until("of('right').parent === 0");
    // Placed objects snap to the grid.
    shown.page.js("(() => { const s = document.getElementById('snap-length'); s.value = '0.5'; s.dispatchEvent(new Event('change')); })()");
    shown.page.click_on("#add");
    shown.page.until("document.querySelector('#items [data-item=box]') !== null");
    shown.page.click_on("#items [data-item=box]");
    let middle = shown.page.middle("#view");
    shown.page.click_at(middle, 1);
    shown.until(
        "of('box') !== undefined && get('box', 'object.position').then((p) => p[0] % 0.5 === 0 && p[1] % 0.5 === 0)",
    );
    shown.end();
}
