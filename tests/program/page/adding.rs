//! Tests of what is added to a scene besides the object that was asked for: scripts of robots, the bodies that carry
//! sensors, and what dropped meshes become, in a browser.

use serde_json::json;

use super::drive::ScenePage;
use crate::kit::*;

const FLOOR: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";
/// A square of two triangles.
const MESH: &str = "v 0 0 0\nv 0.4 0 0\nv 0.4 0.3 0\nv 0 0.3 0.2\nf 1 2 3\nf 1 3 4\n";

fn output(text: &str) -> String {
    format!("document.getElementById('output').textContent.includes({text:?})")
}

/// Shows the item of a model in the palette, and clicks it.
fn click_model(shown: &mut ScenePage, model: &str) {
    shown.page.until("document.querySelectorAll('#items .entry').length > 20");
    let item = format!("#items [data-item={model}]");
    shown.page.js(&format!(
        "(() => {{ const i = document.querySelector({item:?}); i.closest('details').open = true; \
         i.scrollIntoView({{ block: 'center' }}); }})()"
    ));
    shown.page.click_on(&item);
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn robots_without_a_script_get_one_that_drives_them() {
    let mut shown = ScenePage::new(FLOOR);
    shown.until_shown("floor");
    shown.page.click_on("#add");
    for (model, alias) in [("pioneer_p3dx", "Pioneer_p3dx"), ("manta", "Manta")] {
        click_model(&mut shown, model);
        let view = shown.page.middle("#view");
        shown.page.click_at(view, 1);
        shown.until(&format!("of({alias:?})?.scripts?.length === 1"));
        shown.page.until(&output(&format!("{alias} has a script that drives it around")));
        let start = shown.ask(&format!("get({alias:?}, 'object.position')"));
        shown.page.click_on("#play");
        shown.until(&format!(
            "get({alias:?}, 'object.position').then((p) => Math.hypot(p[0] - {}, p[1] - {}) > 0.3)",
            start[0], start[1]
        ));
        shown.page.click_on("#stop");
        shown.until("document.getElementById('stop').disabled");
        // The robot and its script are added by one edit.
        shown.page.until(&format!("document.getElementById('undo').title === 'Undo Add {model} (Ctrl+Z)'"));
        shown.page.click_on("#undo");
        shown.until(&format!("of({alias:?}) === undefined"));
        shown.page.until("document.getElementById('undo').disabled");
    }
    // A robot with a script of its own gets no other one.
    click_model(&mut shown, "turtlebot3");
    let view = shown.page.middle("#view");
    shown.page.click_at(view, 1);
    shown.until(
        "store.selected() !== 0 && [...store.scene.objects.values()].flatMap((o) => o.scripts ?? []).length === 1",
    );
    assert_eq!(shown.page.js(&output("turtlebot3 has")), false);
    // Text boxes that the page offers are those of the model's own name and its kind.
    let titles = shown
        .page
        .js("[...document.querySelectorAll('#items details')].map((d) => [d.querySelector('summary').textContent, \
         [...d.querySelectorAll('strong')].map((s) => s.textContent)]).filter(([s]) => s === 'Mobile robots')[0]?.[1]");
    let titles: Vec<&str> = titles.as_array().unwrap().iter().filter_map(|t| t.as_str()).collect();
    assert!(titles.contains(&"Pioneer P3-DX") && titles.contains(&"TurtleBot3 Burger"), "{titles:?}");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn sensors_are_attached_to_the_body_that_they_are_put_on() {
    let mut shown = ScenePage::new(&format!("{FLOOR}[[model]]\nmodel = \"pioneer_p3dx\"\n"));
    shown.until_shown("Pioneer_p3dx");
    shown.page.click_on("#add");
    click_model(&mut shown, "hokuyo");
    let deck = shown.pixel("Pioneer_p3dx_connection1", [0.0, 0.0, 0.0]);
    shown.page.click_at(deck, 1);
    shown.until("store.selected() !== 0 && store.scene.objects.get(store.selected()).model");
    let sensor = shown.ask("store.scene.objects.get(store.selected()).alias");
    let sensor = sensor.as_str().unwrap();
    assert_ne!(sensor, "Pioneer_p3dx");
    shown.until(&format!("of({sensor:?}).parent === of('Pioneer_p3dx').id"));
    // The robot, which was folded in the tree, is unfolded.
    let row = shown.row(sensor);
    shown.page.until(&format!("document.querySelector(\"{row}\")?.getAttribute('aria-selected') === 'true'"));
    shown.page.until(&output("is attached to Pioneer_p3dx"));
    // On the deck, which is 0.237 m above the floor.
    let height = shown.ask(&format!("get({sensor:?}, 'object.world_pose')"))[2].as_f64().unwrap();
    assert!((0.2..0.4).contains(&height), "{height}");
    shown.page.click_on("#undo");
    shown.until(&format!("of({sensor:?}) === undefined && document.getElementById('undo').disabled"));
    // On the floor before the robot, it is attached to nothing.
    click_model(&mut shown, "hokuyo");
    let floor = shown.pixel("floor", [-0.2, -0.6, 0.0]);
    shown.page.click_at(floor, 1);
    shown.until(&format!("of({sensor:?})?.parent === 0"));
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn new_scripts_have_a_name_and_are_open_at_once() {
    let mut shown = ScenePage::new(&format!("{FLOOR}[[model]]\nmodel = \"pioneer_p3dx\"\n"));
    shown.until_shown("Pioneer_p3dx");
    let row = shown.row("Pioneer_p3dx");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.page.until("document.getElementById('script-name').textContent === 'script of Pioneer_p3dx'");
    shown.page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('sysCall_actuation')");
    shown.page.js("(async () => { const { EditorView } = await import('@codemirror/view'); \
         const v = EditorView.findFromDOM(document.querySelector('.cm-editor')); \
         v.dispatch({ changes: { from: 0, insert: 'function (\\n' } }); })()");
    shown.page.click_on("#script-save");
    shown.page.until(&output("the new source of script of Pioneer_p3dx cannot be loaded"));
    assert_eq!(shown.page.js("/tatu\\.\\w+: /.test(document.getElementById('output').textContent)"), false);
    shown.page.js("(async () => { const { EditorView } = await import('@codemirror/view'); \
         const v = EditorView.findFromDOM(document.querySelector('.cm-editor')); \
         v.dispatch({ changes: { from: 0, to: v.state.doc.line(2).from, insert: '' } }); \
         v.dispatch({ changes: { from: 0, insert: '-- my own\\n' } }); })()");
    shown.page.click_on("#script-save");
    shown.page.until(&output("script of Pioneer_p3dx: the new text is in the scene"));
    shown.page.until("document.getElementById('undo').title === 'Undo Change script of Pioneer_p3dx (Ctrl+Z)'");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_mesh_alone_becomes_a_shape() {
    let place = TestFolder::new();
    place.write("apart/ramp.obj", MESH).write("work/.keep", "").write("apart/box/box.obj", MESH);
    place.write("apart/box/box.mtl", "newmtl red\nKd 1 0 0\n");
    let mesh = place.path().join("apart/ramp.obj");
    let folder = place.path().join("apart/box");
    let mut shown = ScenePage::of(place, &["open", "--no-browser"]);
    shown.page.until("document.getElementById('dialog').open");
    shown.page.key("Escape", 27);
    // Without a scene, it is added to a new one.
    shown.page.drop_files([600.0, 300.0], std::slice::from_ref(&mesh));
    shown.until("of('ramp')?.kind === 'shape' && of('floor') !== undefined");
    shown.page.until(&output("Added ramp"));
    shown.until("store.selected() === of('ramp').id");
    // Beside a file with materials, in a folder, it is added to the open scene, on the surface under the pointer.
    shown.until_shown("floor");
    let at = shown.pixel("floor", [0.8, -0.6, 0.0]);
    shown.page.drop_files(at, &[folder]);
    shown.until("of('box')?.kind === 'shape' && of('ramp') !== undefined");
    shown.page.until(&output("Added box"));
    let middle = "(() => { const b = new three.Box3().setFromObject(objects.groups.get(of('box').id)); \
                  const c = b.getCenter(new three.Vector3()); return [c.x, c.y, b.min.z]; })()";
    shown.until(&format!("{middle}[0] > 0.7"));
    let found = shown.ask(middle);
    for (i, wanted) in [0.8, -0.6, 0.0].into_iter().enumerate() {
        assert!((found[i].as_f64().unwrap() - wanted).abs() < 0.03, "{found}");
    }
    shown.page.click_on("#undo");
    shown.until("of('box') === undefined && of('ramp') !== undefined");
    shown.page.click_on("#redo");
    shown.until("of('box')?.kind === 'shape'");
    // Its size is that of the bounding box, and cannot be set; an infinite plane has none.
    let size = "document.querySelector(\"#rows [data-key='shape.size']\")";
    shown.ask("store.select(of('ramp').id)");
    shown.page.until(&format!("{size}?.querySelector('.fixed')?.textContent === '0.4, 0.3, 0.2 m'"));
    shown.ask("store.select(of('floor').id)");
    shown.page.until(&format!("document.getElementById('what').textContent.startsWith('floor') && {size} === null"));
    shown.page.until("document.querySelector(\"#rows [data-key='shape.color']\") !== null");
    assert_eq!(shown.page.js(&format!("{size} === null")), json!(true));
    shown.end();
}
