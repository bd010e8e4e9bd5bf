//! Tests of moving and turning objects by the mouse, by keys and by typed numbers, in a browser.

use super::drive::ScenePage;

const FLOOR: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";
const BLOCK: &str = "[[object]]\nkind = \"shape\"\nalias = \"block\"\nsize_m = [0.4, 0.4, 0.4]\n\
                     position_m = [0.0, 0.0, 0.2]\n";
/// A block whose parent is rotated by 90 degrees.
const CHILD: &str = "[[object]]\nkind = \"dummy\"\nalias = \"base\"\nposition_m = [1.0, 0.0, 0.0]\n\
                     orientation_deg = [0.0, 0.0, 90.0]\n[[object]]\nkind = \"shape\"\nalias = \"block\"\n\
                     parent = \"base\"\nsize_m = [0.2, 0.2, 0.2]\nposition_m = [0.0, 0.5, 0.1]\n";

/// A JavaScript expression for half the length of an arrow of the gizmo in the frame of an object, m.
const ARROW_LENGTH_JS: &str = "(() => { const c = view.camera; \
     const far = objects.groups.get(of('block').id).getWorldPosition(new three.Vector3()).distanceTo(c.position); \
     return 0.1 * far * Math.min(1.9 * Math.tan(Math.PI * c.fov / 360), 7); })()";

impl ScenePage {
    /// Shows a scene, selects an object, and puts the focus into the view.
    fn selecting(scene: &str, alias: &str) -> ScenePage {
        let mut shown = ScenePage::new(scene);
        shown.until_shown(alias);
        shown.ask(&format!("store.select(of({alias:?}).id)"));
        shown.page.js("document.getElementById('view').focus()");
        shown
    }
    /// Enters a number in a field of the toolbar for moving.
    fn type_number(&mut self, field: usize, text: &str) {
        self.page.click_on(&format!(".typed input:nth-of-type({field})"));
        self.page.key_event("keyDown", "a", 65, 2);
        self.page.key_event("keyUp", "a", 65, 2);
        self.page.enter(text);
        self.page.key("Enter", 13);
    }
    /// Waits until a property of an object has approximately these values.
    fn until_near(&mut self, alias: &str, key: &str, wanted: &[f64]) {
        self.until(&format!(
            "get({alias:?}, {key:?}).then((v) => {wanted:?}.every((x, i) => Math.abs(v[i] - x) < 1e-9))"
        ));
    }
    /// Undoes the last edit.
    fn undo(&mut self) {
        self.ask("net.call('tatu.undo')");
    }
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn typed_numbers_are_positions_and_degrees_in_the_chosen_frame() {
    let mut shown = ScenePage::selecting(&format!("{FLOOR}{CHILD}"), "block");
    shown.page.key("g", 71);
    // The y axis of the parent points along the world's -x axis, so the block is at (0.5, 0, 0.1) in the world.
    shown.page.until("document.querySelector('.typed input')?.value === '0.5'");
    shown.type_number(1, "0.75");
    shown.until_near("block", "object.position", &[0.0, 0.25, 0.1]);
    shown.page.js("(() => { const s = document.querySelector('.typed select'); s.value = 'parent'; s.onchange(); })()");
    shown.page.until("document.querySelector('.typed input:nth-of-type(2)').value === '0.25'");
    shown.type_number(2, "-1.5");
    shown.until_near("block", "object.position", &[0.0, -1.5, 0.1]);
    // Invalid input is refused with an error; Escape leaves the field.
    shown.type_number(1, "far");
    shown.page.until("document.querySelector('.typed .why').textContent.includes('expected a number in m')");
    assert_eq!(shown.page.js("document.activeElement.value"), "far");
    shown.page.key("Escape", 27);
    shown.page.until("document.activeElement.id === 'view'");
    shown.page.key("r", 82);
    shown.type_number(3, "30");
    shown.until_near("block", "object.orientation", &[0.0, 0.0, 30_f64.to_radians()]);
    shown.until_near("block", "object.position", &[0.0, -1.5, 0.1]);
    shown.undo();
    shown.undo();
    shown.until_near("block", "object.position", &[0.0, 0.25, 0.1]);
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn keys_move_and_turn_by_steps_that_are_undone_one_by_one() {
    let mut shown = ScenePage::selecting(&format!("{FLOOR}{BLOCK}"), "block");
    shown.page.key("g", 71);
    shown.page.until("document.getElementById('move').getAttribute('aria-pressed') === 'true'");
    // Initially, the camera looks along +y and slightly along -x, so +x is to the right and +y is up on the screen.
    shown.page.key("ArrowRight", 39);
    shown.until_near("block", "object.position", &[0.05, 0.0, 0.2]);
    shown.page.key("ArrowUp", 38);
    shown.until_near("block", "object.position", &[0.05, 0.05, 0.2]);
    shown.page.key_event("keyDown", "PageUp", 33, 8);
    shown.page.key_event("keyUp", "PageUp", 33, 8);
    shown.until_near("block", "object.position", &[0.05, 0.05, 0.205]);
    // Repeats of a held key form a single edit.
    for _ in 0..4 {
        shown.page.key_event("keyDown", "PageDown", 34, 0);
    }
    shown.page.key_event("keyUp", "PageDown", 34, 0);
    shown.until_near("block", "object.position", &[0.05, 0.05, 0.005]);
    shown.undo();
    shown.until_near("block", "object.position", &[0.05, 0.05, 0.205]);
    // When the movement is restricted to z, all arrow keys move the object along z.
    shown.page.key("z", 90);
    shown.page.key("ArrowUp", 38);
    shown.until_near("block", "object.position", &[0.05, 0.05, 0.255]);
    shown.page.key("r", 82);
    shown.page.key("ArrowLeft", 37);
    shown.until_near("block", "object.orientation", &[0.0, 0.0, 5_f64.to_radians()]);
    shown.undo();
    shown.until_near("block", "object.orientation", &[0.0, 0.0, 0.0]);
    shown.page.key("Escape", 27);
    shown.page.until("document.querySelector('.typed').hidden");
    shown.page.key("ArrowRight", 39);
    shown.until("net.call('tatu.edits').then(([e]) => e.undo.length === 4)");
    shown.until_near("block", "object.position", &[0.05, 0.05, 0.255]);
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_drag_on_a_grid_ends_on_it_and_is_one_edit() {
    let mut shown =
        ScenePage::selecting(&format!("{FLOOR}{}", BLOCK.replace("[0.0, 0.0, 0.2]", "[0.03, 0.0, 0.2]")), "block");
    shown.page.js("(() => { const s = document.getElementById('snap-length'); s.value = '0.25'; \
         s.dispatchEvent(new Event('change')); })()");
    let drawn = shown.ask("view.drawn");
    shown.page.click_on("#move");
    shown.until(&format!("view.drawn > {drawn}"));
    let arrow = shown.ask(ARROW_LENGTH_JS).as_f64().unwrap();
    let (from, to) = (shown.pixel("block", [arrow, 0.0, 0.0]), shown.pixel("block", [arrow + 0.5, 0.0, 0.0]));
    let drawn = shown.ask("view.drawn");
    shown.page.mouse("mouseMoved", from, 0, false);
    shown.until(&format!("view.drawn > {drawn}"));
    shown.page.drag(from, to, false);
    shown.page.mouse("mouseReleased", to, 1, false);
    shown.until_near("block", "object.position", &[0.5, 0.0, 0.2]);
    shown.until("net.call('tatu.edits').then(([e]) => e.undo.join() === 'Move block')");
    shown.undo();
    shown.until_near("block", "object.position", &[0.03, 0.0, 0.2]);
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_push_moves_a_robot_and_does_not_tip_it() {
    let mut shown = ScenePage::selecting(&format!("{FLOOR}[[model]]\nmodel = \"pioneer_p3dx\"\n"), "Pioneer_p3dx");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('play').classList.contains('on')");
    // The page measures the tilt in each frame, and stores its maximum.
    shown.ask(
        "(() => { globalThis.tilt = 0; net.on('frame', async () => { const q = await get('Pioneer_p3dx', \
         'object.quaternion'); const up = 1 - 2 * (q[0] * q[0] + q[1] * q[1]); \
         globalThis.tilt = Math.max(globalThis.tilt, Math.acos(Math.min(1, up)) * 180 / Math.PI); }); })()",
    );
    let from = shown.pixel("Pioneer_p3dx", [0.0, 0.0, 0.095]);
    for way in [[100.0, 0.0], [0.0, -100.0]] {
        let to = [from[0] + way[0], from[1] + way[1]];
        shown.page.drag(from, to, true);
        // While the robot is pulled, an arrow with the force in N is shown.
        shown.page.until("/^[0-9.]+ N$/.test(document.querySelector('.push:not([hidden])')?.textContent ?? '')");
        std::thread::sleep(std::time::Duration::from_millis(300));
        shown.page.mouse("mouseReleased", to, 1, true);
        shown.page.until("document.querySelector('.push').hidden");
    }
    let tilt = shown.page.js("globalThis.tilt").as_f64().unwrap();
    assert!(tilt < 15.0, "tilted by {tilt} degrees");
    // A longer push overcomes the brakes of the robot's wheels.
    let place = "get('Pioneer_p3dx', 'object.position').then(([x, y]) => Math.hypot(x - at[0], y - at[1]) > 0.05)";
    shown.ask("(async () => { globalThis.at = await get('Pioneer_p3dx', 'object.position'); })()");
    let from = shown.pixel("Pioneer_p3dx", [0.0, 0.0, 0.095]);
    let to = [from[0] + 150.0, from[1]];
    shown.page.drag(from, to, true);
    shown.until(place);
    shown.page.mouse("mouseReleased", to, 1, true);
    shown.end();
}

/// An arm with links of 0.5 and 0.4 m, bent at the elbow, and a hand at its end.
const ARM: &str = "[[object]]\nkind = \"joint\"\nalias = \"shoulder\"\ntype = \"revolute\"\nmode = \"kinematic\"\n\
                   position_m = [0.0, 0.0, 0.3]\n[[object]]\nkind = \"joint\"\nalias = \"elbow\"\nparent = \"shoulder\"\n\
                   type = \"revolute\"\nmode = \"kinematic\"\nposition_m = [0.5, 0.0, 0.0]\njoint_position_deg = 60.0\n\
                   [[object]]\nkind = \"shape\"\nalias = \"hand\"\nparent = \"elbow\"\nsize_m = [0.1, 0.1, 0.1]\n\
                   position_m = [0.4, 0.0, 0.0]\n";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn arm_follows_its_hand_as_far_as_it_reaches() {
    let mut shown = ScenePage::selecting(&format!("{FLOOR}{ARM}"), "hand");
    shown.page.click_on("#guide");
    shown.page.until("document.querySelector('.typed strong').textContent === 'Guide to'");
    // 0.5 + 0.4 cos 60 degrees, 0.4 sin 60 degrees.
    shown.page.until("document.querySelector('.typed input').value === '0.7'");
    shown.type_number(1, "0.3");
    shown.until(
        "get('hand', 'object.world_pose').then((p) => Math.abs(p[0] - 0.3) < 1e-5 && Math.abs(p[1] - 0.34641) < 1e-5)",
    );
    assert_eq!(shown.ask("get('elbow', 'joint.position').then((x) => x > 0 && x < Math.PI)"), true);
    // The arm goes as near as it can, and says why not farther.
    shown.type_number(1, "2");
    shown.page.until("document.querySelector('.typed .why').textContent.includes('out of reach')");
    shown.until("get('hand', 'object.world_pose').then((p) => Math.abs(Math.hypot(p[0], p[1]) - 0.9) < 1e-3)");
    shown.undo();
    shown.undo();
    shown.until("get('elbow', 'joint.position').then((x) => Math.abs(x - Math.PI / 3) < 1e-9)");
    shown.end();
}
