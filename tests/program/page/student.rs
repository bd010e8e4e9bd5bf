//! Tests of a student's first hour with the page, in a browser.

use std::time::Duration;

use super::program::{PageServer, ROBOT};
use crate::{
    kit::browser::{BrowserPage, browser},
    kit::*,
};

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_student_drives_and_changes_a_robot() {
    let browser = browser();
    let served = PageServer::new(root(), &["open", "scenes/course/manta_keyboard_statusbar.toml", "--no-browser"]);
    let mut page = BrowserPage::open(&browser, &served.url);
    page.until("document.querySelectorAll('#tree .item').length > 1");
    page.click("#play");
    page.until("document.getElementById('play').className === 'on'");
    page.js("document.getElementById('view').focus()");
    page.key("ArrowLeft", 37);
    page.until("document.getElementById('output').textContent.includes('key 2009')");
    page.click("#pause");
    page.until("document.getElementById('pause').className === 'on'");
    let stood = page.text("#time");
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(page.text("#time"), stood);
    page.click("#step");
    page.until(&format!("document.getElementById('time').textContent !== {stood:?}"));
    page.click("#stop");
    page.until("document.getElementById('stop').className === 'on'");
    // In another scene, the script is opened and a number is changed, which makes the wheels turn more slowly.
    page.js(&format!("import('tatu/net/connection').then((m) => m.call('tatu.open', {ROBOT:?}))"));
    page.until("document.getElementById('name').textContent === 'pioneer_avoids_walls.toml'");
    // Arrow keys drive the selected robot while they are held.
    page.js("(async () => { const store = await import('tatu/scene/store'); \
         store.select([...store.scene.objects.values()].find((o) => o.alias.endsWith('leftWheel')).id); })()");
    let press = |kind: &str| {
        format!(
            "document.getElementById('view').dispatchEvent(new KeyboardEvent('{kind}', \
             {{ key: 'ArrowUp', bubbles: true, cancelable: true }}))"
        )
    };
    let speed = "(async () => { const [net, store] = [await import('tatu/net/connection'), await import('tatu/scene/store')]; \
        const j = [...store.scene.objects.values()].find((o) => o.alias.endsWith('leftMotor')); \
        return (await net.call('tatu.get', j.id, 'joint.target_velocity'))[0]; })()";
    page.until(&format!("{}, {speed}.then((v) => v === 4)", press("keydown")));
    page.js(&press("keyup"));
    page.until(&format!("{speed}.then((v) => v === 0)"));
    page.click("#tree .tool");
    page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('cruise = 3.0')");
    page.click("#play");
    page.until(&format!("{speed}.then((v) => v > 2)"));
    page.js("(async () => { const { EditorView } = await import('@codemirror/view'); \
         const v = EditorView.findFromDOM(document.querySelector('.cm-editor')); \
         const at = v.state.doc.toString().indexOf('cruise = 3.0') + 9; \
         v.dispatch({ changes: { from: at, to: at + 3, insert: '1.0' } }); \
         document.getElementById('script-save').click(); })()");
    page.until(&format!("{speed}.then((v) => v <= 1)"));
    // A script has a window. Moving its slider calls the script, which changes a label.
    // The edited script is not saved to the file, and no backup copy remains next to the file.
    page.js("import('tatu/net/connection').then((m) => m.call('tatu.recover', false).then(() => m.call('tatu.open', 'plugins/commands/simui/demo.toml')))");
    page.until("document.getElementById('name').textContent === 'demo.toml'");
    page.click("#play");
    page.until("document.querySelector('.window .title')?.textContent.startsWith('Pioneer')");
    page.js("(() => { const s = document.querySelector('.window input[type=range]'); s.value = 35; s.oninput(); })()");
    page.until("document.querySelector('.window')?.textContent.includes('3.5 rad/s')");
    page.until(&format!("{speed}.then((v) => v === 3.5)"));
    // Screen readers get a name for each control.
    assert_eq!(
        page.js(
            "[...document.querySelectorAll('button, input, select, [tabindex]')].filter((e) => !e.closest('[hidden]') && \
             !(e.ariaLabel || e.title || e.textContent.trim() || e.placeholder || e.labels?.[0]?.textContent.trim())).length",
        ),
        0
    );
    // The view shows more than its background, and the robot is at its start again.
    page.click("#stop");
    page.until("document.getElementById('stop').className === 'on'");
    page.until(
        "(() => { const c = document.querySelector('#view canvas'); const p = document.createElement('canvas'); \
         p.width = c.width; p.height = c.height; const x = p.getContext('2d'); x.drawImage(c, 0, 0); \
         const d = x.getImageData(0, 0, p.width, p.height).data; const s = new Set(); \
         for (let i = 0; i < d.length; i += 4000) s.add(`${d[i]},${d[i + 1]},${d[i + 2]}`); return s.size > 8; })()",
    );
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}
