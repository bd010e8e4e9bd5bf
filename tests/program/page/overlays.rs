//! Tests of overlays and of the camera, in a browser.

use serde_json::json;

use super::drive::ScenePage;

/// A scene with a resting block of 2 kg and a ball that flies away.
const SCENE: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n\
    [[object]]\nkind = \"shape\"\nalias = \"block\"\nsize_m = [0.2, 0.2, 0.2]\nposition_m = [0.0, 0.0, 0.1]\n\
    dynamic = true\nrespondable = true\nmass_kg = 2.0\n\
    [[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.1, 0.1, 0.1]\n\
    position_m = [1.0, 0.0, 2.0]\ndynamic = true\nmass_kg = 1.0\ninitial_velocity_m_s = [0.0, 0.0, 150.0]\n";

/// Returns a JavaScript expression for the coordinates (x, y, z of each point in turn) of the end points of the
/// overlay's line segments in a colour.
fn lines(color: &str) -> String {
    format!(
        "(() => {{ const out = []; view.stage.traverse((x) => {{ if (x.isLineSegments && \
         x.material.color.getHexString() === '{color}' && x.material.depthTest === false) \
         out.push(...x.geometry.attributes.position.array); }}); return out; }})()"
    )
}

/// Toggles an overlay by its position in the menu.
fn switch(shown: &mut ScenePage, index: usize) {
    shown.page.click_on("#overlays");
    shown.page.js(&format!("document.querySelectorAll('#overlay-menu input')[{index}].click()"));
    shown.page.click_on("#overlays");
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn overlays_show_forces_masses_and_velocities() {
    let mut shown = ScenePage::new(SCENE);
    shown.until_shown("block");
    switch(&mut shown, 0);
    switch(&mut shown, 4);
    shown.page.click_on("#play");
    // The forces at up to four corners add up to the weight of 2 kg.
    let sum = "await new Promise((done) => net.on('overlays', (m) => { const f = m.contacts.filter((c) => \
               c.pair.includes(of('block').id)).map((c) => Math.abs(c.force[2])); \
               const s = f.reduce((a, b) => a + b, 0); if (Math.abs(s - 19.62) < 0.2) done(s); }))";
    assert!(shown.ask(sum).as_f64().is_some());
    shown.until(&format!("{}.length >= 18", lines("e0352b")));
    shown.until(&format!("{}.length === 18", lines("2b7de0")));
    shown.page.click_on("#stop");
    shown.until(&format!("{}.length === 0", lines("e0352b")));
    shown.end();
}

/// A scene with a hinge with limits, an invisible shape that collides, and a bar with the inertia of a homogeneous box.
const MECHANISM: &str = "[[object]]\nkind = \"shape\"\nalias = \"bar\"\nsize_m = [0.4, 0.1, 0.2]\ndynamic = true\n\
    position_m = [0.0, 0.0, 1.0]\norientation_deg = [0.0, 0.0, 30.0]\nmass_kg = 3.0\nvisible = false\nrespondable = true\n\
    [[object]]\nkind = \"joint\"\nalias = \"hinge\"\ntype = \"revolute\"\nlimits_deg = [-30.0, 60.0]\n";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn overlays_show_inertia_collision_shapes_and_limits() {
    let mut shown = ScenePage::new(MECHANISM);
    shown.until_shown("bar");
    // The indices of these overlays in the menu: boxes of equal inertia, colliding shapes, and axes.
    for index in [2, 3, 5] {
        switch(&mut shown, index);
    }
    // A box of uniform density has the same inertia as the displayed box.
    shown.until(&format!("{}.length > 0", lines("8a3ffc")));
    let scale = "(() => { let s = null; view.stage.traverse((x) => { if (x.isLineSegments && \
                 x.material.color.getHexString() === '8a3ffc') s = x.scale.toArray().sort(); }); return s; })()";
    let size: Vec<f64> = shown.ask(scale).as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!(size.iter().zip([0.1, 0.2, 0.4]).all(|(a, b)| (a - b).abs() < 1e-6), "{size:?}");
    assert!(shown.ask(&format!("{}.length", lines("0d8a6a"))).as_f64().unwrap() > 0.0);
    // An arc of 90 degrees is drawn around the hinge: all of its points have the same distance from the axis, except
    // those on the axis.
    let radii = format!(
        "(() => {{ const p = {}; const r = []; for (let i = 0; i < p.length; i += 3) r.push(Math.hypot(p[i], p[i + 1])); \
         return r.filter((x) => x > 1e-6); }})()",
        lines("b35900")
    );
    let radii = shown.ask(&radii);
    let radii: Vec<f64> = radii.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!(radii.len() >= 20 && radii.iter().all(|r| (r - radii[0]).abs() < 1e-5), "{radii:?}");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_body_that_flies_away_is_listed_once() {
    let mut shown = ScenePage::new(SCENE);
    shown.until_shown("block");
    shown.page.click_on("#play");
    let told =
        "[...document.querySelectorAll('#output .warning')].filter((l) => l.textContent.includes('/ball moves at'))";
    shown.until(&format!("{told}.length === 1"));
    assert!(shown.page.js("document.getElementById('last-line').textContent").as_str().unwrap().contains("/ball"));
    shown.page.js(&format!("{told}[0].querySelector('button').click()"));
    shown.until("store.selected() === of('ball').id");
    shown.until("document.getElementById('time').textContent > '00:00:03'");
    assert_eq!(shown.page.js(&format!("{told}.length")), 1);
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_camera_turns_with_the_object_it_follows() {
    let mut shown = ScenePage::new(SCENE);
    shown.until_shown("block");
    shown.ask("store.select(of('block').id)");
    shown.page.click_on("#follow");
    let offset = "(() => { const g = objects.groups.get(of('block').id); g.updateWorldMatrix(true, false); \
                  return g.worldToLocal(view.camera.position.clone()).toArray(); })()";
    shown.until("new Promise((done) => requestAnimationFrame(() => done(true)))");
    // The camera looks at the object from the start.
    let off = "(() => { const p = objects.groups.get(of('block').id).getWorldPosition(new three.Vector3()); \
               return p.distanceTo(view.controls.target); })()";
    assert!(shown.ask(off).as_f64().unwrap() < 1e-6);
    let before = shown.ask(offset);
    // The selection does not affect which object is followed.
    shown.ask("store.select(of('ball').id)");
    for pose in [json!([0.5, 0, 0.1, 0, 0, 0.3826834, 0.9238795]), json!([0.5, 0.7, 0.1, 0, 0, 1, 0])] {
        shown.ask(&format!("net.call('tatu.set', of('block').id, 'object.pose', {pose})"));
        shown.until(&format!("Math.abs(objects.groups.get(of('block').id).position.y - {}) < 1e-3", pose[1]));
        let after = shown.ask(offset);
        let far = |i: usize| (before[i].as_f64().unwrap() - after[i].as_f64().unwrap()).abs();
        assert!((0..3).all(|i| far(i) < 1e-2), "{before} {after}");
    }
    // In a parallel projection from above, the position of a point on the screen does not depend on its height.
    shown.page.click_on("#flat");
    shown.page.js("(() => { const v = document.getElementById('views'); v.value = '5'; v.onchange(); })()");
    let across = "(() => { view.camera.updateMatrixWorld(); const x = (z) => \
                  new three.Vector3(0.7, 0.7, z).project(view.camera).x; return Math.abs(x(0) - x(0.5)); })()";
    assert!(shown.ask(across).as_f64().unwrap() < 0.01);
    shown.end();
}

/// An arm with links of 0.5 and 0.4 m, bent by 60 degrees at the elbow.
const ARM: &str = "[[object]]\nkind = \"joint\"\nalias = \"shoulder\"\ntype = \"revolute\"\nmode = \"kinematic\"\n\
    [[object]]\nkind = \"joint\"\nalias = \"elbow\"\nparent = \"shoulder\"\ntype = \"revolute\"\nmode = \"kinematic\"\n\
    position_m = [0.5, 0.0, 0.0]\njoint_position_deg = 60.0\n\
    [[object]]\nkind = \"shape\"\nalias = \"hand\"\nparent = \"elbow\"\nsize_m = [0.1, 0.1, 0.1]\n\
    position_m = [0.4, 0.0, 0.0]\n";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn overlay_of_manipulability_has_the_singular_values_of_the_arm() {
    let mut shown = ScenePage::new(ARM);
    shown.until_shown("hand");
    shown.ask("store.select(of('hand').id)");
    switch(&mut shown, 7);
    let color = "c2185b";
    shown.until(&format!("{}.length > 18", lines(color)));
    // The last three segments are the axes; one of them has the length 0, as the arm moves in a plane.
    let axes = format!(
        "(() => {{ const n = {}.slice(-18); return [0, 6, 12].map((i) => \
         Math.hypot(n[i] - n[i + 3], n[i + 1] - n[i + 4], n[i + 2] - n[i + 5])).sort((a, b) => a - b); }})()",
        lines(color)
    );
    let axes = shown.ask(&axes);
    let axis = |i: usize| axes[i].as_f64().unwrap();
    assert!(axis(0) < 1e-6, "{axes}");
    // The Jacobian is [-0.3464, -0.3464; 0.7, 0.2], with the singular values 0.8537 and 0.2029.
    assert!((axis(1) / axis(2) - 0.2029 / 0.8537).abs() < 1e-3, "{axes}");
    shown.ask("store.select(0)");
    shown.until(&format!("{}.length === 0", lines(color)));
    shown.end();
}
