//! Tests of the windows over the view, in a browser: plots, images of cameras, the list of sensors.

use serde_json::Value;

use super::drive::ScenePage;

/// A scene with a cart that slides along x at 0.5 m/s, an inertial unit, a camera that looks down, a vision sensor, and
/// a sonar.
const SCENE: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n\
    [[object]]\nkind = \"shape\"\nalias = \"cart\"\nsize_m = [0.2, 0.2, 0.2]\nposition_m = [0.0, 0.0, 1.0]\n\
    color = [1.0, 0.0, 0.0]\nscript = { text = \"\"\"\nfunction sysCall_actuation()\n\
    sim.setObjectPosition(sim.getObject('..'), -1, {0.5 * sim.getSimulationTime(), 0, 1})\nend\"\"\" }\n\
    [[object]]\nkind = \"sensor\"\nalias = \"feels\"\nparent = \"/cart\"\nsensor = \"imu\"\n\
    [[object]]\nkind = \"shape\"\nalias = \"block\"\nsize_m = [0.2, 0.2, 0.2]\nposition_m = [0.0, 2.0, 1.0]\n\
    [[object]]\nkind = \"sensor\"\nalias = \"hears\"\nposition_m = [0.0, 2.0, 3.0]\norientation_deg = [180.0, 0.0, 0.0]\n\
    sensor = \"proximity\"\nrange_m = 4.0\n\
    [[object]]\nkind = \"camera\"\nalias = \"above\"\nposition_m = [0.0, 0.0, 2.0]\norientation_deg = [180.0, 0.0, 0.0]\n\
    [[object]]\nkind = \"sensor\"\nalias = \"sees\"\nsensor = \"depth_camera\"\nposition_m = [0.0, 0.0, 3.0]\n\
    orientation_deg = [180.0, 0.0, 0.0]\npreset = \"kinect_v1\"\n";

fn shown() -> ScenePage {
    let mut shown = ScenePage::new(SCENE);
    shown.until_shown("cart");
    shown
}

/// Opens a window from the menu.
fn open(shown: &mut ScenePage, name: &str) {
    shown.page.click_on("#windows");
    let entry = format!("[...document.querySelectorAll('.menu button')].find((b) => b.textContent.includes({name:?}))");
    shown.page.until(&format!("{entry} !== undefined"));
    shown.page.js(&format!("{entry}.click()"));
}

/// JavaScript that replaces downloads: the files are stored in `window.saved`.
pub const CAPTURE_DOWNLOADS_JS: &str = "(() => { window.saved = []; const real = URL.createObjectURL; URL.createObjectURL = (b) => { \
    window.saved.push(b); return real(b); }; HTMLAnchorElement.prototype.click = () => {}; })()";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_click_plots_a_property_in_each_step() {
    let mut shown = shown();
    shown.page.js(CAPTURE_DOWNLOADS_JS);
    shown.ask("store.select(of('cart').id)");
    let chart = ".row[data-key='object.position'] .chart";
    shown.page.until(&format!("document.querySelector(\"{chart}\") !== null"));
    shown.page.js(&format!("document.querySelector(\"{chart}\").click()"));
    shown.page.until("document.querySelectorAll('.pane .legend li').length === 3");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('time').textContent > '00:00:02'");
    shown.page.click_on("#pause");
    // The table has a row for each step, however fast the page draws. The x of a row is half the time of the previous
    // step.
    shown.page.js("[...document.querySelectorAll('.pane .tools button')].find((b) => b.textContent === 'CSV').click()");
    shown.page.until("window.saved.length === 1");
    let table = shown.page.js("window.saved[0].text()");
    let lines: Vec<&str> = table.as_str().unwrap().lines().collect();
    assert_eq!(lines[0], "time (s),cart position x (m),cart position y (m),cart position z (m)");
    let rows: Vec<Vec<f64>> =
        lines[1..].iter().map(|l| l.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect()).collect();
    assert!(rows.len() > 30, "{}", rows.len());
    for pair in rows.windows(2) {
        assert!((pair[1][0] - pair[0][0] - 0.05).abs() < 1e-9, "{pair:?}");
    }
    for row in &rows[1..] {
        assert!((row[1] - 0.5 * (row[0] - 0.05)).abs() < 1e-9 && row[3] == 1.0, "{row:?}");
    }
    // One curve is plotted against another and saved as a table of pairs, the picture is saved as PNG, and a curve is
    // removed.
    shown.page.js(
        "(() => { const s = document.querySelector('.pane .tools select'); s.selectedIndex = 1; s.onchange(); })()",
    );
    for name in ["CSV", "PNG"] {
        shown.page.js(&format!(
            "[...document.querySelectorAll('.pane .tools button')].find((b) => b.textContent === '{name}').click()"
        ));
    }
    shown.page.until("window.saved.length === 3");
    let head = shown.page.js("window.saved[1].text()");
    assert!(head.as_str().unwrap().starts_with("cart position x (m),cart position y (m),"), "{head}");
    assert_eq!(shown.page.js("window.saved[2].type"), "image/png");
    // A second value is added to the plot, and the first one can be removed.
    shown.page.js("document.querySelector(\".row[data-key='object.visible'] .chart\").click()");
    shown.page.until("document.querySelectorAll('.pane .legend li').length === 4");
    shown.page.js("document.querySelector('.pane .legend button').click()");
    shown.page.until("document.querySelectorAll('.pane .legend li').length === 3");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn camera_windows_show_images_and_reopen_after_a_reload() {
    let mut shown = shown();
    for name in ["above", "sees"] {
        open(&mut shown, name);
    }
    shown.page.click_on("#play");
    // The red cart is below both cameras at the start. After a second, it has moved in both images.
    let reds = "[...document.querySelectorAll('canvas.seen')].map((c) => { const k = new OffscreenCanvas(c.width, c.height)\
                .getContext('2d', { willReadFrequently: true }); k.drawImage(c, 0, 0); const d = k.getImageData(0, 0, c.width, \
                c.height).data; let n = 0; for (let i = 0; i < d.length; i += 4) if (d[i] > 90 && d[i + 1] < 60 && \
                d[i + 2] < 60) n++; return n; })";
    shown.page.until(&format!("{reds}.length === 2 && {reds}.every((n) => n > 100)"));
    shown.page.click_on("#stop");
    shown.page.js("location.reload()");
    shown.page.until("document.querySelectorAll('canvas.seen').length === 2");
    shown.page.until("[...document.querySelectorAll('canvas.seen')].some((c) => c.width > 100)");
    // Escape closes the window that has the focus; the window then remains closed.
    shown.page.js("document.querySelector('.pane .title').focus()");
    shown.page.key("Escape", 27);
    shown.page.until("document.querySelectorAll('canvas.seen').length === 1");
    shown.page.js("location.reload()");
    shown.page.until("document.querySelectorAll('canvas.seen').length === 1");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn all_sensors_are_in_one_list_with_what_they_read() {
    let mut shown = shown();
    open(&mut shown, "Sensors");
    shown.page.until("document.querySelectorAll('table.sensors tr').length === 3");
    shown.page.click_on("#play");
    let value = |name: &str| {
        format!(
            "[...document.querySelectorAll('table.sensors tr')].find((r) => r.textContent.startsWith({name:?}))\
             .querySelector('.value').textContent"
        )
    };
    // The sonar detects the block below it; the inertial unit measures gravity.
    shown.page.until(&format!("{}.startsWith('1.9 m')", value("hears")));
    shown.page.until(&format!("/9\\.8/.test({})", value("feels")));
    shown
        .page
        .js("[...document.querySelectorAll('table.sensors button')].find((b) => b.textContent === 'hears').click()");
    shown.until("store.selected() === of('hears').id");
    // Readings are no longer shown after the stop.
    shown.page.click_on("#stop");
    shown.page.until(&format!("{} === '\u{2014}'", value("hears")));
    let seen: Value = shown.page.js(&value("feels"));
    assert_eq!(seen, "\u{2014}");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_graph_shows_the_curves_that_it_declares() {
    let scene = crate::kit::root().join("scenes/course/laser_scanner_2d_signal_tube_log.toml");
    let args = ["open", scene.to_str().unwrap(), "--no-browser"];
    let mut shown = ScenePage::of(crate::kit::TestFolder::new(), &args);
    shown.page.js(CAPTURE_DOWNLOADS_JS);
    // The plot opens at the first start, in a corner.
    shown.page.click_on("#play");
    shown.page.until("document.querySelectorAll('.pane .legend').length === 1");
    let share =
        shown.page.js("(() => { const [b, v] = [document.querySelector('.pane'), document.getElementById('view')]; \
         return b.offsetWidth * b.offsetHeight / v.clientWidth / v.clientHeight; })()");
    assert!(share.as_f64().unwrap() < 1.0 / 6.0, "{share}");
    shown.page.until("document.getElementById('time').textContent > '00:00:01'");
    let axis = "document.querySelector('.pane select')";
    shown.page.until(&format!("{axis}?.selectedOptions[0]?.textContent === 'curves of the graph'"));
    // The outline of the room: most points of a scan differ in x and y.
    let csv = "(async () => { const b = [...document.querySelectorAll('.pane button')].find((b) => b.textContent === 'CSV'); \
               b.click(); return (await window.saved.at(-1).text()).trim().split('\\n').slice(1).map((l) => l.split(',').map(Number)); })()";
    shown.page.until(&format!("{csv}.then((rows) => rows.length > 50)"));
    let rows = shown.page.js(csv);
    let extent = |k: usize| {
        let values = rows.as_array().unwrap().iter().filter_map(|r| r[k].as_f64());
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    assert!(extent(0) > 1.0 && extent(1) > 1.0, "the curve is {} by {} m", extent(0), extent(1));
    // A plot that was closed remains closed.
    shown.page.click_on(".pane .title button");
    shown.page.click_on("#stop");
    shown.page.until("document.getElementById('stop').disabled");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('time').textContent > '00:00:00.5'");
    assert_eq!(shown.page.js("document.querySelector('.pane') === null"), true);
    open(&mut shown, "LaserScannerGraph_2D");
    shown.page.until("document.querySelectorAll('.pane .legend').length === 1");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn depths_are_shown_with_their_scale() {
    let mut shown = ScenePage::new(&format!(
        "{SCENE}{}",
        SCENE[SCENE.rfind("[[object]]").unwrap()..].replace("sees", "sees_depth")
    ));
    shown.until_shown("cart");
    for name in ["sees", "sees_depth"] {
        open(&mut shown, name);
        shown.page.until("document.querySelector('.menu') === null");
    }
    shown.page.until("document.querySelectorAll('canvas.seen').length === 2");
    shown.page.click_on("#play");
    let scale = |i: usize| format!("document.querySelectorAll('.depth-scale')[{i}].textContent.trim()");
    shown.page.until(&format!("/^0\\.\\d+ m.*\\d m$/.test({})", scale(1)));
    assert_eq!(
        shown.page.js("[...document.querySelectorAll('.depth-scale')].map((s) => s.hidden)"),
        serde_json::json!([true, false])
    );
    // Depths are grey, and the cart is nearer than the floor.
    let color = |i: usize| {
        format!(
            "(() => {{ const c = document.querySelectorAll('canvas.seen')[{i}]; const k = new OffscreenCanvas(c.width, c.height)\
             .getContext('2d'); k.drawImage(c, 0, 0); return [...k.getImageData(c.width / 2, c.height / 2, 1, 1).data]; }})()"
        )
    };
    shown.page.until(&format!("{}[0] > 60 && {}[0] === {}[1]", color(1), color(1), color(1)));
    shown.page.until(&format!("{}[0] > 2 * {}[1]", color(0), color(0)));
    // The choice is kept.
    shown.page.js(
        "(() => { const s = document.querySelectorAll('.pane .tools select')[0]; s.value = 'depth'; s.onchange(); })()",
    );
    shown.page.until(&format!("{}[0] === {}[1] && {}[0] > 60", color(0), color(0), color(0)));
    shown.page.js("location.reload()");
    shown
        .page
        .until("[...document.querySelectorAll('.pane .tools select')].map((s) => s.value).join() === 'depth,depth'");
    shown.end();
}
