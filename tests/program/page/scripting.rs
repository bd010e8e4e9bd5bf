//! Tests of the script editor and of windows of scripts, in a browser.

use serde_json::json;

use super::{
    drive::ScenePage,
    program::{call, next},
};
use crate::{kit::*, plugins::outside::built_for_its_scene};

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_editor_saves_marks_errors_and_follows_other_clients() {
    let mut shown = ScenePage::new("[[object]]\nkind = \"dummy\"\nalias = \"brain\"\nscript = { text = \"x = 1\" }\n");
    shown.until("of('brain')?.scripts.length === 1");
    let row = format!("#tree [data-id=\"{}\"]", shown.ask("of('brain').id"));
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    let text = "document.querySelector('.cm-content')?.cmView?.view?.state.doc.toString() ?? \
                document.querySelector('.cm-content')?.textContent";
    shown.until(&format!("({text}) === 'x = 1'"));
    let source = "net.call('tatu.getScript', of('brain').scripts[0].id).then(([t]) => atob(t.bytes))";
    shown.page.key("End", 35);
    shown.page.enter("2");
    shown.page.key_event("keyDown", "s", 83, 2);
    shown.page.key_event("keyUp", "s", 83, 2);
    shown.until(&format!("{source}.then((t) => t === 'x = 12')"));
    shown.page.key("End", 35);
    shown.page.enter(" = =");
    shown.page.click_on("#script-save");
    shown.page.until("document.querySelector('.cm-lintRange-error') !== null");
    assert_eq!(shown.ask(source), "x = 12");
    // A text saved by another client does not replace unsaved changes.
    let mut socket = shown.served.socket();
    next(&mut socket, "scene");
    let script = shown.ask("of('brain').scripts[0].id");
    call(&mut socket, "tatu.setScript", json!([script, "x = 3"]));
    shown.until(&format!("{source}.then((t) => t === 'x = 3')"));
    shown.until(&format!("({text}) === 'x = 12 = ='"));
    shown.page.click_on("#script-close");
    shown.answer("Discard");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.until(&format!("({text}) === 'x = 3'"));
    call(&mut socket, "tatu.setScript", json!([script, "x = 4"]));
    shown.until(&format!("({text}) === 'x = 4'"));
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn windows_of_scripts_are_dragged_used_and_closed() {
    let scene = std::fs::read_to_string(root().join("plugins/commands/simui/demo.toml")).unwrap();
    let place = TestFolder::new();
    place.write("scene.toml", &scene);
    let mut shown = ScenePage::of(place, &["open", "scene.toml", "--no-browser"]);
    shown.page.click_on("#play");
    shown.page.until("document.querySelector('.window .title') !== null");
    let slider = shown.page.middle(".window input[type=range]");
    let width = shown.page.js("document.querySelector('.window input[type=range]').clientWidth").as_f64().unwrap();
    shown.page.drag(slider, [slider[0] + 0.6 * width, slider[1]], false);
    shown.page.mouse("mouseReleased", [slider[0] + 0.6 * width, slider[1]], 1, false);
    shown.page.until("document.querySelector('.window').textContent.includes('6.0 rad/s')");
    shown.until("get('Pioneer_p3dx_leftMotor', 'joint.target_velocity').then((v) => v === 6)");
    let place =
        "(() => { const b = document.querySelector('.window').getBoundingClientRect(); return [b.left, b.top]; })()";
    let before = shown.page.js(place);
    let title = shown.page.js(
        "(() => { const b = document.querySelector('.window .title').getBoundingClientRect(); return [b.left + b.width / 2, b.top + 4]; })()",
    );
    let from = [0, 1].map(|i| title[i].as_f64().unwrap());
    shown.page.drag(from, [from[0] + 50.0, from[1] + 30.0], false);
    shown.page.mouse("mouseReleased", [from[0] + 50.0, from[1] + 30.0], 1, false);
    let after = shown.page.js(place);
    let moved = [0, 1].map(|i| after[i].as_f64().unwrap() - before[i].as_f64().unwrap());
    assert_eq!(moved, [50.0, 30.0]);
    shown.page.click_on(".window .title button");
    shown.page.until("document.querySelector('.window:not([hidden])') === null");
    shown.end();
}

/// A scene with two legacy button windows, as the importer stores them: a panel, and a window that is shown while its
/// object is selected.
const PANELS: &str = r#"dialect = "3.2"
data = { "\u0001registered" = '{"collections":[],"collisions":[],"distances":[],"ik_groups":[],"windows":[{"name":"Panel","handle":2060000,"object":-1,"attributes":5,"cells":[12,4],"buttons":[{"handle":3,"attributes":8274,"cells":[12,1,0,0],"labels":["",""],"slider":-0.5},{"handle":4,"attributes":8209,"cells":[12,1,0,1],"labels":["",""],"slider":0},{"handle":5,"attributes":16,"cells":[6,1,0,2],"labels":["&&fg900Go",""],"slider":0},{"handle":6,"attributes":24,"cells":[6,1,6,2],"labels":["Off","On"],"slider":0},{"handle":7,"attributes":19,"cells":[12,1,0,3],"labels":["name",""],"slider":0}]},{"name":"Of the ball","handle":2060001,"object":7,"attributes":1029,"cells":[4,1],"buttons":[]}]}' }

[[object]]
kind = "shape"
alias = "ball"
primitive = "sphere"
size_m = [0.2, 0.2, 0.2]
position_m = [0, 0, 1]
data = { "\u0001handle" = "7" }
script.text = """
if sim_call_type == sim_childscriptcall_initialization then
    panel = simGetUIHandle('Panel')
end
if sim_call_type == sim_childscriptcall_sensing then
    local button, values = simGetUIEventButton(panel)
    if button ~= -1 then last = button .. ' ' .. values[1] end
    local name = simGetUIButtonLabel(panel, 7)
    simSetUIButtonLabel(panel, 4, 'gain ' .. simGetUISlider(panel, 3) .. ', last ' .. tostring(last) .. ', ' .. name)
end
"""
"#;

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn old_windows_of_buttons_are_used() {
    let mut shown = ScenePage::new(PANELS);
    shown.page.click_on("#play");
    let says = |text: &str| format!("document.querySelector('.window').textContent.includes({text:?})");
    shown.page.until("document.querySelector('.window') !== null");
    shown.page.until(&says("gain 250, last nil, name"));
    let slider = shown.page.middle(".window input[type=range]");
    let width = shown.page.js("document.querySelector('.window input[type=range]').clientWidth").as_f64().unwrap();
    shown.page.mouse("mousePressed", slider, 1, false);
    shown.page.mouse("mouseReleased", slider, 1, false);
    shown.page.until(r"/gain (49|50)[0-9], last 3 (49|50)[0-9]/.test(document.querySelector('.window').textContent)");
    shown.page.drag(slider, [slider[0] + width, slider[1]], false);
    shown.page.mouse("mouseReleased", [slider[0] + width, slider[1]], 1, false);
    shown.page.until(&says("gain 1000, last 3 1000"));
    shown.page.click_on(".window button:nth-of-type(1)");
    shown.page.until(&says("last 5 0"));
    shown.page.click_on(".window button:nth-of-type(2)");
    shown.page.until(&says("last 6 1"));
    shown.page.until("document.querySelector('.window button:nth-of-type(2)').textContent === 'On'");
    shown.page.click_on(".window input[type=text]");
    shown.page.enter("r");
    shown.page.press_enter();
    shown.page.until(&says("last 7 0, "));
    shown.page.until("document.querySelectorAll('.window:not([hidden])').length === 1");
    shown.ask("store.select(of('ball').id)");
    shown.page.until("document.querySelectorAll('.window:not([hidden])').length === 2");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
#[cfg_attr(no_cxx, ignore = "there is no C++ compiler")]
fn a_window_of_a_plugin_is_used() {
    let place = built_for_its_scene("speedometer");
    let mut shown = ScenePage::of(place, &["open", "scene.toml", "--no-browser", "--allow", "plugins"]);
    shown.page.click_on("#play");
    // The ball drifts until the button stops it.
    let speed = "Number.parseFloat(document.querySelector('.window td:nth-child(2)')?.textContent ?? '0')";
    shown.page.until(&format!("{speed} === 0.02"));
    assert_eq!(shown.page.js("document.querySelector('.window .title').textContent"), json!("Speedometer"));
    let drawn = "(() => { const c = document.querySelector('.window canvas'); \
                 return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((x) => x > 0); })()";
    shown.page.until(drawn);
    shown.page.click_on(".window button:last-of-type");
    shown.page.until(&format!("{speed} === 0"));
    shown.end();
}

/// A script in Python with an error in line 8, which is in a function that line 5 calls, and one in a module.
const PYTHON: &str = "[[object]]
kind = \"dummy\"
alias = \"brain\"
script = { text = '''#python
# Fails in its first step.
def sysCall_actuation():
    sim = require('sim')
    fail('x')

def fail(key):
    {}[key]
''' }

[[object]]
kind = \"dummy\"
alias = \"hand\"
script = \"hand.py\"
";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn scripts_in_python_are_highlighted_and_their_errors_marked() {
    let place = TestFolder::scene(PYTHON);
    place.write("hand.py", "import helper\n\ndef sysCall_sensing():\n    helper.fail()\n");
    place.write("helper.py", "def fail():\n\n\n\n\n\n\n    raise ValueError('in the module')\n");
    let mut shown = ScenePage::of(place, &["open", "scene.toml", "--no-browser", "--allow", "python"]);
    let open = |shown: &mut ScenePage, alias: &str| {
        shown.until(&format!("of({alias:?})?.scripts.length === 1"));
        let row = shown.row(alias);
        let at = shown.page.middle(&row);
        shown.page.click_at(at, 2);
    };
    let style = |word: &str, key: &str| {
        format!(
            "(() => {{ const found = [...document.querySelectorAll('.cm-line span')].find((s) => s.textContent === {word:?}); \
             return found ? getComputedStyle(found).{key} : ''; }})()"
        )
    };
    let marked =
        "[...document.querySelectorAll('.cm-line')].find((l) => l.querySelector('.cm-lintRange-error'))?.textContent";
    open(&mut shown, "brain");
    shown.page.until(&format!("{} === '600'", style("def", "fontWeight")));
    shown.page.until(&format!("{} === 'italic'", style("# Fails in its first step.", "fontStyle")));
    shown.page.click_on("#play");
    shown.page.until(&format!("{marked} === '    {{}}[key]'"));
    shown.page.click_on("#stop");
    open(&mut shown, "hand");
    shown.page.until(&format!("{} === '600'", style("import", "fontWeight")));
    shown.page.click_on("#play");
    shown.page.until(&format!("{marked} === '    helper.fail()'"));
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_page_says_which_permission_scripts_in_python_need() {
    let mut shown = ScenePage::new(PYTHON.replace("script = \"hand.py\"\n", "").as_str());
    shown.page.click_on("#play");
    shown.page.until("document.body.textContent.includes('allow them with `--allow python`')");
    shown.end();
}

/// A script that prints 8 numbers in pieces on a console, then 300 lines in each step.
const CONSOLE: &str = r#"[[object]]
kind = "dummy"
alias = "brain"
script = { text = """
function sysCall_init()
    out = sim.auxiliaryConsoleOpen('Numbers', 100, 0)
    for i = 1, 8 do sim.auxiliaryConsolePrint(out, '0.5 ') end
    sim.auxiliaryConsolePrint(out, '\\nnext')
end
function sysCall_actuation()
    for i = 1, 300 do sim.auxiliaryConsolePrint(out, '\\n' .. i) end
end
""" }
"#;

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_console_is_shown_and_its_lines_are_continued() {
    let mut shown = ScenePage::new(CONSOLE);
    shown.until("of('brain')?.scripts.length === 1");
    shown.page.click_on("#step");
    // The tab of a new console is opened, with the panel.
    shown.page.until("document.querySelector('#tabs .on').textContent === 'Numbers'");
    shown.page.until("document.getElementById('footer').classList.contains('open')");
    // The newest message, such as a line in the log, is still in the status line.
    shown.page.until("document.getElementById('last-line').textContent !== ''");
    assert_eq!(shown.page.js("getComputedStyle(document.getElementById('last-line')).visibility"), "visible");
    let lines = "[...document.querySelectorAll('#output > div')].map((d) => d.textContent)";
    shown.page.until(&format!("{lines}.length === 302"));
    assert_eq!(
        shown.page.js(&format!("{lines}.slice(0, 3)")),
        json!(["0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 ", "next", "1"])
    );
    let is_at_end = "(() => { const o = document.getElementById('output'); \
                     return o.scrollHeight > o.clientHeight && o.scrollTop + o.clientHeight >= o.scrollHeight - 8; })()";
    assert_eq!(shown.page.js(is_at_end), true);
    // The scroll position is read once per frame, not for each line, and the oldest lines are dropped.
    shown.page.js(
        "(() => { window.reads = window.frames_ = 0; const d = Object.getOwnPropertyDescriptor(Element.prototype, 'scrollHeight'); \
         Object.defineProperty(document.getElementById('output'), 'scrollHeight', { get() { window.reads++; return d.get.call(this); } }); \
         const f = () => { window.frames_++; requestAnimationFrame(f); }; f(); })()",
    );
    for _ in 0..6 {
        shown.page.click_on("#step");
    }
    shown.page.until(&format!("{lines}.length === 1000 && {lines}.at(-1) === '300'"));
    shown.page.until("document.getElementById('time').textContent.endsWith('0.35')");
    assert_eq!(shown.page.js("window.reads <= 2 * window.frames_"), true);
    shown.page.until(is_at_end);
    // The reader of earlier lines is not taken to the end.
    shown.page.js("document.getElementById('output').scrollTop = 100");
    shown.page.click_on("#step");
    shown.page.until("document.getElementById('time').textContent.endsWith('0.40')");
    assert_eq!(shown.page.js("document.getElementById('output').scrollTop < 200"), true);
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn an_undo_that_removes_the_object_of_the_open_script_is_explained() {
    let mut shown = ScenePage::new("[[object]]\nkind = \"dummy\"\nalias = \"base\"\n");
    shown.until("of('base') !== undefined");
    let add = "import('tatu/scene/edits').then((e) => e.edit('Add brain', [['tatu.add', \
               'format = 1\\n[[object]]\\nkind = \"dummy\"\\nalias = \"brain\"\\nscript = { text = \"x = 1\" }\\n']]))";
    shown.ask(add);
    shown.until("of('brain')?.scripts.length === 1");
    let row = shown.row("brain");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.page.until("document.querySelector('.cm-content')?.textContent === 'x = 1'");
    shown.page.key("End", 35);
    shown.page.enter("2");
    let is_noted = "document.getElementById('script-note').offsetHeight > 0";
    assert_eq!(shown.page.js(is_noted), false);
    shown.page.click_on("#undo");
    shown.until("of('brain') === undefined");
    shown.page.until(is_noted);
    assert_eq!(shown.page.js("document.getElementById('script-save').disabled"), true);
    assert_eq!(shown.page.js("document.querySelector('#output .error') === null"), true);
    // The text returns with the object.
    shown.page.click_on("#redo");
    shown.until("of('brain') !== undefined");
    shown.page.until(&format!("!({is_noted})"));
    shown.page.click_on("#script-save");
    shown.until("net.call('tatu.getScript', of('brain').scripts[0].id).then(([t]) => atob(t.bytes) === 'x = 12')");
    shown.end();
}
