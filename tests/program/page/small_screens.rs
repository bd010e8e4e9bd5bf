//! Tests of the page on small screens and in windows that are enlarged, in a browser.

use serde_json::json;

use super::drive::ScenePage;

const ROBOT: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n\
                     [[model]]\nmodel = \"pioneer_p3dx\"\n";

fn resize(shown: &mut ScenePage, width: u32, height: u32) {
    let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
    shown.page.send("Emulation.setDeviceMetricsOverride", size);
    shown.page.until(&format!("innerWidth === {width} && innerHeight === {height}"));
}

/// Whether the middle of an element, which is completely on the screen, is the element itself or in it.
fn is_on_top(selector: &str) -> String {
    format!(
        "(() => {{ const e = document.querySelector({selector:?}); const b = e.getBoundingClientRect(); \
         const top = document.elementFromPoint(b.left + b.width / 2, b.top + b.height / 2); \
         return b.width > 0 && b.left >= 0 && b.top >= 0 && b.right <= innerWidth && b.bottom <= innerHeight \
         && (top === e || e.contains(top)); }})()"
    )
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn small_screens_show_the_view_with_one_drawer_at_a_time() {
    let mut shown = ScenePage::new(ROBOT);
    shown.until_shown("Pioneer_p3dx");
    for [width, height] in [[390, 844], [683, 384], [800, 500], [900, 700]] {
        resize(&mut shown, width, height);
        shown.page.until(
            "(() => { const b = document.getElementById('view').getBoundingClientRect(); \
             return b.width * b.height >= innerWidth * innerHeight / 2 && b.width === innerWidth; })()",
        );
        let buttons = shown.page.js(
            "(() => { const all = [...document.querySelectorAll('#camera > button')].map((b) => b.getBoundingClientRect()); \
             return [new Set(all.map((b) => b.top)).size, Math.max(...all.map((b) => b.right)) <= innerWidth, all.length]; })()",
        );
        assert_eq!(buttons, json!([1, true, 9]), "{width} x {height}");
        for button in ["#play", "#stop", "#add", "#save", "#move", "#show-objects", "#show-details"] {
            shown.page.until(&is_on_top(button));
        }
        shown.page.click_on("#show-objects");
        shown.page.until(&is_on_top("#objects"));
        shown.page.click_on("#show-details");
        shown.page.until(&is_on_top("#details"));
        assert_eq!(shown.page.js("document.getElementById('objects').offsetWidth"), 0);
        // A press in the view closes the drawer.
        let at = shown.page.middle("#tools");
        let below = [at[0], f64::from(height) - 60.0];
        shown.page.click_at(below, 1);
        shown.page.until("document.getElementById('details').offsetWidth === 0");
        shown.page.click_on("#more-camera");
        shown.page.until(&is_on_top("#views"));
        shown.page.click_on("#more-camera");
        shown.page.until("document.getElementById('views').offsetWidth === 0");
    }
    // The palette takes the place of a drawer, and the other way round.
    shown.page.click_on("#show-objects");
    shown.page.click_on("#add");
    shown
        .page
        .until("document.getElementById('objects').offsetWidth === 0 && !document.getElementById('palette').hidden");
    shown.page.click_on("#show-objects");
    shown.page.until("document.getElementById('palette').hidden && document.getElementById('objects').offsetWidth > 0");
    // On a wide screen, the panels and tools are back in their places.
    resize(&mut shown, 1366, 768);
    shown.page.until(
        "document.querySelector('header > #tools') !== null && document.getElementById('details').offsetWidth > 200 \
         && document.getElementById('show-objects').offsetWidth === 0",
    );
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn coordinates_are_not_covered_by_the_palette() {
    let mut shown = ScenePage::new(ROBOT);
    shown.until_shown("Pioneer_p3dx");
    resize(&mut shown, 1366, 768);
    shown.ask("store.select(of('Pioneer_p3dx').id)");
    shown.page.click_on("#move");
    shown.page.click_on("#add");
    shown.page.until("!document.querySelector('.typed').hidden");
    for part in [".typed", ".typed strong", ".typed select", "#camera"] {
        shown.page.until(&is_on_top(part).replace("top === e ||", "true ||"));
        let covered = "(() => { const p = document.getElementById('palette').getBoundingClientRect(); \
                       return document.querySelector(PART).getBoundingClientRect().left < p.right; })()";
        assert_eq!(shown.page.js(&covered.replace("PART", &format!("{part:?}"))), false, "{part}");
    }
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn windows_menus_and_hints_fit_on_small_screens() {
    let camera = "[[object]]\nkind = \"camera\"\nalias = \"a_camera_with_quite_a_long_name_at_the_ceiling\"\nposition_m = [0.0, 0.0, 3.0]\n";
    let mut shown = ScenePage::new(&format!("{ROBOT}{camera}"));
    shown.until_shown("Pioneer_p3dx");
    // A window that was at the right of a large view is completely in a small one.
    shown.page.js("localStorage.setItem('tatu window sensors', '1300 700 320 270')");
    resize(&mut shown, 390, 844);
    shown.page.click_on("#windows");
    shown.page.until("document.querySelector('.menu') !== null");
    let is_inside = |selector: &str, of: &str| {
        format!(
            "(() => {{ const [b, v] = [document.querySelector({selector:?}), document.querySelector({of:?})].map((e) => e.getBoundingClientRect()); \
             return b.width > 0 && b.left >= v.left && b.right <= v.right && b.top >= v.top && b.bottom <= v.bottom; }})()"
        )
    };
    assert_eq!(shown.page.js(&is_inside(".menu", "html")), true);
    shown.page.js("document.querySelector('.menu button').click()");
    shown.page.until(&is_inside(".pane", "#view"));
    // Open menus of the camera are above windows and tools.
    shown.page.js("Object.assign(document.querySelector('.pane').style, { left: '0', top: '30px' })");
    let title = shown.page.middle(".pane .title span");
    shown.page.click_at(title, 1);
    shown.page.click_on("#overlays");
    shown.page.until(&is_on_top("#overlay-menu label"));
    // Keys and what they do are readable in both languages.
    for language in ["en", "pt"] {
        shown.page.js(&format!("localStorage.setItem('tatu language', '{language}'); location.reload()"));
        shown.page.until(&format!("document.documentElement?.lang === '{language}'"));
        for [width, height] in [[390, 844], [1366, 768]] {
            resize(&mut shown, width, height);
            shown.page.until("document.querySelectorAll('.hints dd').length > 5");
            if width < 1000 {
                shown.page.click_on("#show-details");
            }
            shown.page.until("[...document.querySelectorAll('.hints dd')].every((d) => d.clientWidth >= 100)");
        }
    }
    shown.end();
}
