//! Tests of how the page displays a scene, in a browser.

use serde_json::json;

use super::{
    drive::ScenePage,
    program::{call, next},
};
use crate::kit::*;

/// Returns a JavaScript expression that is true if an object of the three.js class `what` is drawn for a sensor's
/// reading.
fn draws(sensor: &str, what: &str) -> String {
    format!(
        "(() => {{ let found = false; objects.groups.get(of({sensor:?}).id).traverse((x) => {{ \
         found = found || (x instanceof three.{what} && !store.scene.objects.has(x.userData.id)); }}); return found; }})()"
    )
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn readings_are_drawn_in_layers_until_a_stop() {
    let sensor = |alias: &str, kind: &str, more: &str| {
        format!("[[object]]\nkind = \"sensor\"\nalias = \"{alias}\"\nsensor = \"{kind}\"\n{more}")
    };
    let wall =
        "[[object]]\nkind = \"shape\"\nalias = \"wall\"\nsize_m = [4.0, 4.0, 0.1]\nposition_m = [0.0, 0.0, 1.0]\n";
    let laser = "rays = 5\nlayers = 2\nvertical_field_deg = 20.0\nrange_m = 3.0\nstart_angle_deg = -30.0\nend_angle_deg = 30.0\n";
    let mut shown = ScenePage::new(&format!(
        "{wall}{}{}{}",
        sensor("eye", "proximity", "range_m = 2.0\nvolume = \"cone\"\nangle_deg = 20.0\n"),
        sensor("fan", "laser", laser),
        sensor("receiver", "gps", "position_m = [0.5, 0.0, 0.0]\n")
    ));
    shown.until_shown("fan");
    assert_eq!(shown.ask(&draws("fan", "Mesh")), false);
    // The volume of a sensor is drawn while the sensor is selected.
    assert_eq!(shown.ask(&draws("eye", "Mesh")), false);
    shown.ask("store.select(of('eye').id)");
    shown.until(&draws("eye", "Mesh"));
    shown.ask("net.call('tatu.set', of('eye').id, 'proximity.range', 1.5)");
    shown.until("of('eye').volume.range === 1.5");
    shown.ask("store.select(0)");
    assert_eq!(shown.ask(&draws("eye", "Mesh")), false);
    shown.page.click_on("#play");
    shown.until(&draws("fan", "Mesh"));
    shown.until(&draws("eye", "Points"));
    shown.until(&draws("receiver", "Points"));
    // Two layers of five beams yield eight triangles, not nine.
    let triangles = "(() => { let n = 0; objects.groups.get(of('fan').id).traverse((x) => { \
                     if (x.isMesh) n += x.geometry.index.count / 3; }); return n; })()";
    assert_eq!(shown.ask(triangles), 8);
    shown.page.click_on("#rays");
    assert_eq!(shown.ask(&draws("fan", "Mesh")), false);
    shown.page.click_on("#rays");
    shown.until(&draws("fan", "Mesh"));
    shown.page.click_on("#stop");
    shown.until(&format!("!{} && !{}", draws("fan", "Mesh"), draws("eye", "Points")));
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn drawings_of_scripts_appear() {
    let mut shown = ScenePage::new(
        "[[object]]\nkind = \"dummy\"\nalias = \"pen\"\nscript = { text = \"\"\"\nfunction sysCall_init()\n\
         local d = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 10, {0, 1, 0})\n\
         sim.addDrawingObjectItem(d, {0, 0, 0, 1, 0, 1})\nend\"\"\" }\n",
    );
    shown.until_shown("pen");
    let lines = "(() => { let ends = []; view.stage.traverse((x) => { if (x.isLineSegments && !x.isGridHelper && \
                 x.material.color.getHexString() === '00ff00') ends.push(...x.geometry.attributes.position.array); }); \
                 return ends; })()";
    shown.page.click_on("#play");
    shown.until(&format!("{lines}.length === 6"));
    assert_eq!(shown.ask(lines), json!([0, 0, 0, 1, 0, 1]));
    shown.end();
}

const TREE: &str = "[[object]]\nkind = \"dummy\"\nalias = \"base\"\n[[object]]\nkind = \"shape\"\nalias = \"block\"\n\
                    parent = \"base\"\n[[object]]\nkind = \"dummy\"\nalias = \"tip\"\n";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_tree_selects_closes_finds_and_follows_changes() {
    let mut shown = ScenePage::new(TREE);
    let text = "[...document.querySelectorAll('#tree .item')].map((e) => e.lastChild.textContent).join()";
    shown.until(&format!("{text} === 'base,block,tip'"));
    let row =
        |shown: &mut ScenePage, alias: &str| format!("#tree [data-id=\"{}\"]", shown.ask(&format!("of('{alias}').id")));
    let block = row(&mut shown, "block");
    shown.page.click_on(&block);
    shown.until("store.selected() === of('block').id");
    shown.page.js("document.getElementById('tree').focus()");
    shown.page.key("ArrowDown", 40);
    shown.until("store.selected() === of('tip').id");
    let base = row(&mut shown, "base");
    shown.page.click_on(&format!("{base} .twist"));
    shown.until(&format!("{text} === 'base,tip'"));
    shown.page.click_on(&format!("{base} .twist"));
    shown.page.click_on("#search");
    shown.page.enter("loc");
    shown.until(&format!("{text} === 'base,block'"));
    // Another client changes the name and the parent of the block.
    let mut socket = shown.served.socket();
    next(&mut socket, "scene");
    let (block, tip) = (shown.ask("of('block').id"), shown.ask("of('tip').id"));
    call(&mut socket, "tatu.set", json!([block, "object.alias", "lock"]));
    shown.until(&format!("{text} === 'base,lock'"));
    call(&mut socket, "tatu.set", json!([block, "object.parent", { "object": tip }]));
    shown.until(&format!("{text} === 'tip,lock'"));
    shown.until("objects.groups.get(of('lock').id).parent === objects.groups.get(of('tip').id)");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn fields_of_the_details_change_the_view() {
    let mut shown = ScenePage::new(TREE);
    shown.until_shown("block");
    shown.ask("store.select(of('block').id)");
    let field = |key: &str| format!("#rows [data-key='{key}'] input");
    shown.page.until(&format!("document.querySelector({:?}) !== null", field("shape.color")));
    // A colour field opens a dialog of the browser, which reports the choice by these events.
    shown.page.js(&format!(
        "(() => {{ const i = document.querySelector({:?}); i.value = '#ff0000'; \
         for (const kind of ['input', 'change']) i.dispatchEvent(new Event(kind, {{ bubbles: true }})); }})()",
        field("shape.color")
    ));
    let body = "objects.groups.get(of('block').id).userData.bodies[0]";
    shown.until(&format!("{body}.material.color.getHexString() === 'ff0000'"));
    shown.page.js(&format!("document.querySelector({:?}).scrollIntoView({{ block: 'center' }})", field("shape.size")));
    shown.page.click_on(&field("shape.size"));
    shown.page.js(&format!("document.querySelector({:?}).select()", field("shape.size")));
    shown.page.enter("2");
    shown.page.key("Enter", 13);
    shown.until(&format!("{body}.scale.x === 2"));
    shown.page.js(&format!("document.querySelector({:?}).click()", field("object.visible")));
    shown.until(&format!("{body}.visible === false"));
    shown.end();
}

/// The page draws an image on a surface.
#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn images_are_drawn_on_surfaces() {
    let place = TestFolder::scene(
        "[[object]]\nkind = \"shape\"\nalias = \"wall\"\nsize_m = [2, 2, 0.1]\ncolor = [1, 1, 1]\n\
         texture = { image = \"square.png\", size_m = [4, 4], smooth = false }\n",
    );
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0]).unwrap();
    std::fs::write(place.path().join("square.png"), image).unwrap();
    let mut shown = ScenePage::of(place, &["open", "scene.toml", "--no-browser"]);
    // The wall is red in the middle of the view.
    shown.until(
        "(() => { const map = objects.groups.get(of('wall').id)?.userData.bodies[0].material.map; \
         return map && map.image.data.slice(0, 3).join() === '255,0,0'; })()",
    );
    let red = "(() => { const c = document.querySelector('#view canvas'); const d = document.createElement('canvas'); \
               [d.width, d.height] = [c.width, c.height]; const g = d.getContext('2d'); g.drawImage(c, 0, 0); \
               const [r, green, b] = g.getImageData(c.width / 2, c.height / 2, 1, 1).data; \
               return r > 60 && green < r / 3 && b < r / 3; })()";
    shown.until(red);
    shown.end();
}
