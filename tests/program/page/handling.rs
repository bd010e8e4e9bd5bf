//! Tests of moving objects by the mouse and keys, in a browser.

use super::drive::ScenePage;

const FLOOR: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";
const BLOCK: &str = "[[object]]\nkind = \"shape\"\nalias = \"block\"\nsize_m = [0.4, 0.4, 0.4]\n\
                     position_m = [0.0, 0.0, 0.2]\n";

/// A JavaScript expression for the length of an arrow of the gizmo in the frame of an object, m.
const ARROW_LENGTH_JS: &str = "(() => { const c = view.camera; \
     const far = objects.groups.get(of('block').id).getWorldPosition(new three.Vector3()).distanceTo(c.position); \
     return far * Math.min(1.9 * Math.tan(Math.PI * c.fov / 360), 7) / 4; })()";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_drag_moves_the_selected_object_to_its_very_end() {
    let mut shown = ScenePage::new(&format!("{FLOOR}{BLOCK}"));
    shown.until_shown("block");
    let at = shown.pixel("block", [0.0, 0.0, 0.2]);
    shown.page.click_at(at, 1);
    shown.until("store.selected() === of('block').id");
    // The arrows can be dragged only after they have been drawn.
    let drawn = shown.ask("view.drawn");
    shown.page.click_on("#move");
    shown.until(&format!("view.drawn > {drawn}"));
    assert_eq!(shown.ask("document.getElementById('move').getAttribute('aria-pressed')"), "true");
    let arrow = 0.4 * shown.ask(ARROW_LENGTH_JS).as_f64().unwrap();
    let (from, to) = (shown.pixel("block", [arrow, 0.0, 0.0]), shown.pixel("block", [arrow + 0.6, 0.0, 0.0]));
    // The arrow can be dragged only after it has been highlighted under the pointer.
    let drawn = shown.ask("view.drawn");
    shown.page.mouse("mouseMoved", from, 0, false);
    shown.until(&format!("view.drawn > {drawn}"));
    shown.page.drag(from, to, false);
    shown.page.mouse("mouseReleased", to, 1, false);
    // The last of twelve steps of 5 cm has been applied.
    shown
        .until("get('block', 'object.position').then(([x, y, z]) => Math.abs(x - 0.6) < 0.02 && y === 0 && z === 0.2)");
    shown.until("!document.getElementById('unsaved').hidden");
    // The object remains at its new position.
    shown.until("Math.abs(objects.groups.get(of('block').id).position.x - 0.6) < 0.02");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn shift_and_a_drag_push_a_body_while_it_runs() {
    let mut shown =
        ScenePage::new(&format!("{FLOOR}{BLOCK}dynamic = true\nrespondable = true\nmass_kg = 2.0\nfriction = 0.1\n"));
    shown.until_shown("block");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('play').classList.contains('on')");
    let (from, to) = (shown.pixel("block", [0.0, 0.0, 0.2]), shown.pixel("block", [1.5, 0.0, 0.2]));
    shown.page.drag(from, to, true);
    shown.until("get('block', 'object.position').then(([x]) => x > 0.3)");
    shown.page.mouse("mouseReleased", to, 1, true);
    shown.page.click_on("#stop");
    shown.until("get('block', 'object.position').then(([x]) => x === 0)");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn keys_of_the_view_reach_scripts_and_drive_the_selected_robot() {
    let robot = "[[model]]\nmodel = \"pioneer_p3dx\"\nscript = { text = \"\"\"\nfunction sysCall_actuation()\n\
                 local kind, data = sim.getSimulatorMessage()\n\
                 while kind ~= -1 do\n if kind == sim.message_keypress then print('key ' .. data[1]) end\n\
                 kind, data = sim.getSimulatorMessage()\n end\nend\"\"\" }\n";
    let mut shown = ScenePage::new(&format!("{FLOOR}{robot}"));
    shown.until_shown("Pioneer_p3dx");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('play').classList.contains('on')");
    shown.ask("store.select(of('Pioneer_p3dx').id)");
    shown.page.js("document.getElementById('view').focus()");
    shown.page.key("a", 65);
    shown.page.until("document.getElementById('output').textContent.includes('key 97')");
    shown.page.key_event("keyDown", "ArrowUp", 38, 0);
    shown.until("get('Pioneer_p3dx_leftMotor', 'joint.target_velocity').then((v) => v === 4)");
    shown.page.key_event("keyUp", "ArrowUp", 38, 0);
    shown.until("get('Pioneer_p3dx_leftMotor', 'joint.target_velocity').then((v) => v === 0)");
    shown.end();
}
