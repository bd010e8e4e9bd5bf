//! Tests of the contents of script windows.

use crate::kit::*;

/// An SVG drawing can be in a file, in the description of the window, or in the script. If it cannot be read, the
/// window still opens.
#[test]
fn svg_drawings_are_loaded_from_files_windows_and_scripts() {
    let script = r#"
simUI = require 'simUI'
function sysCall_init()
    local ui = simUI.create([[<ui>
        <svg id="1" file="a.svg"/>
        <svg id="2"><svg width="8"><rect width="4" height="4"/></svg></svg>
        <svg id="3" file="nowhere.svg"/>
        <svg id="4" file="words.txt"/>
        <label id="5" text="x"/>
    </ui>]])
    local function data(n)
        for _, w in ipairs(tatu.windows()) do
            if w.window == ui then return w.widgets[n + 1].values.data end
        end
    end
    assert(data(1):find('circle') and data(2):find('<rect', 1, true) and data(3) == nil and data(4) == '')
    simUI.svgLoadFile(ui, 3, 'a.svg')
    assert(data(3) == data(1))
    simUI.svgLoadData(ui, 3, '<svg><path/></svg>')
    assert(data(3):find('path'))
    simUI.svgLoadData(ui, 3, '<svg>')
    assert(data(3) == '')
    for _, wrong in ipairs{{5, 'a.svg', 'expected an <svg>, found a <label>'}, {9, 'a.svg', 'no widget with the id 9'}, {1, 'b.svg', 'b.svg'}} do
        local ok, e = pcall(simUI.svgLoadFile, ui, wrong[1], wrong[2])
        assert(not ok and tostring(e):find(wrong[3], 1, true), tostring(e))
    end
    print('all')
end
"#;
    let place = TestFolder::scene(&format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = {{ text = '''{script}''' }}\n"
    ));
    place.write("a.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"><circle r=\"5\"/></svg>\n");
    place.write("words.txt", "no drawing");
    let done = place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
    assert!(done.out.contains("all"), "{}", done.err);
    assert!(done.err.contains("<svg file=\"nowhere.svg\">"), "{}", done.err);
}
