//! Tests of the Lua modules that come with V-REP and CoppeliaSim: the examples in the page about them run, and the
//! modules work in a scene.

use crate::kit::*;

/// Returns the Lua code blocks of a page.
fn blocks(page: &str) -> Vec<&str> {
    page.split("```lua\n").skip(1).filter_map(|b| b.split("```").next()).collect()
}

#[test]
fn examples_of_their_page_run() {
    let page = std::fs::read_to_string(root().join("docs/reference/modules.md")).unwrap();
    let blocks = blocks(&page);
    assert_eq!(blocks.len(), page.matches("\n## ").count());
    for text in blocks {
        let kind = if text.contains("defaultMainScript") { "main" } else { "child" };
        let place = TestFolder::scene(&format!(
            "[[object]]\nkind = \"graph\"\nalias = \"g\"\n\
             script = {{ kind = \"{kind}\", text = '''\n{text}\nprint('it ran')\n''' }}\n"
        ));
        let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
        assert!(done.out.contains("it ran"), "{text}\n{}{}", done.out, done.err);
    }
}

/// Examples of RFC 8949, appendix A.
#[test]
fn cbor_is_that_of_the_standard() {
    let script = r#"
local cbor = require 'org.conman.cbor'
local function hex(s) return (s:gsub('.', function(c) return string.format('%02x', c:byte()) end)) end
local function bytes(s) return (s:gsub('..', function(c) return string.char(tonumber(c, 16)) end)) end
for _, pair in ipairs{
    {0, '00'}, {23, '17'}, {24, '1818'}, {100, '1864'}, {1000, '1903e8'}, {1000000, '1a000f4240'},
    {1000000000000, '1b000000e8d4a51000'}, {-1, '20'}, {-10, '29'}, {-100, '3863'}, {-1000, '3903e7'},
    {0.0, 'f90000'}, {-0.0, 'f98000'}, {1.0, 'f93c00'}, {1.1, 'fb3ff199999999999a'}, {1.5, 'f93e00'},
    {65504.0, 'f97bff'}, {100000.0, 'fa47c35000'}, {3.4028234663852886e+38, 'fa7f7fffff'},
    {1.0e+300, 'fb7e37e43c8800759c'}, {5.960464477539063e-8, 'f90001'}, {0.00006103515625, 'f90400'},
    {-4.0, 'f9c400'}, {-4.1, 'fbc010666666666666'}, {math.huge, 'f97c00'}, {-math.huge, 'f9fc00'},
    {false, 'f4'}, {true, 'f5'}, {'', '60'}, {'a', '6161'}, {'IETF', '6449455446'}, {'"\\', '62225c'},
    {'\xc3\xbc', '62c3bc'}, {'\xff\0', '42ff00'},
} do
    local encoded = hex(cbor.encode(pair[1]))
    assert(encoded == pair[2], tostring(pair[1]) .. ': ' .. encoded)
    local back, after = cbor.decode(bytes(pair[2]))
    assert(back == pair[1] and math.type(back) == math.type(pair[1]) and after == #pair[2] / 2 + 1, pair[2])
end
assert(hex(cbor.encode{}) == 'a0' and hex(cbor.encode{1, {2, 3}, {4, 5}}) == '8301820203820405')
-- Items of indefinite length, tagged items, and a list that contains null.
assert(cbor.decode(bytes'7f657374726561646d696e67ff') == 'streaming')
assert(#cbor.decode(bytes'9f018202039f0405ffff') == 3 and cbor.decode(bytes'bf61610161629f0203ffff').b[2] == 3)
assert(select(3, cbor.decode(bytes'c11a514b67b0')) == 'TAG_1' and cbor.decode(bytes'c11a514b67b0') == 1363896240)
assert(cbor.decode(bytes'83f60102')[3] == 2 and select(3, cbor.decode(bytes'f6')) == 'null')
-- Invalid CBOR raises an error.
for _, wrong in ipairs{'18', '62', '9b7fffffffffffffff', '5b7fffffffffffffff', '1c', 'ff', ('81'):rep(5000)} do
    assert(not pcall(cbor.decode, bytes(wrong)), wrong:sub(1, 20))
end
local round = {}
round[1] = round
assert(not pcall(cbor.encode, round) and not pcall(cbor.encode, print))
print('all')
"#;
    let place = TestFolder::scene(&format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = {{ text = '''{script}''' }}"
    ));
    let done = place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
    assert!(done.out.contains("all"), "{}", done.err);
}

/// A box on a static conveyor is transported at the requested speed.
#[test]
fn a_conveyor_carries_what_lies_on_it() {
    let place = TestFolder::scene(
        r#"
[[object]]
kind = "dummy"
alias = "conveyor"
[[object]]
kind = "shape"
alias = "forwarder"
parent = "conveyor"
primitive = "box"
size_m = [2.0, 0.4, 0.1]
dynamic = false
respondable = true
[[object]]
kind = "dummy"
alias = "program"
parent = "conveyor"
scripts = [
  { kind = "customization", text = """
sim.writeCustomTableData(sim.getObject('/conveyor'), '__config__', {accel = 0.5})
conveyor = require 'models.efficientconveyor_customization-3'
""" },
]
[[object]]
kind = "shape"
alias = "parcel"
primitive = "box"
size_m = [0.1, 0.1, 0.1]
mass_kg = 1.0
dynamic = true
respondable = true
position_m = [-0.8, 0.0, 0.1]
[[object]]
kind = "dummy"
alias = "user"
script = { text = '''
function sysCall_init()
    conveyor = sim.getObject('/conveyor')
    sim.writeCustomTableData(conveyor, '__ctrl__', {vel = 0.2})
end
function sysCall_cleanup()
    local state = sim.readCustomTableData(conveyor, '__state__')
    local x = sim.getObjectPosition(sim.getObject('/parcel'), -1)[1]
    printf('vel %.3f pos %.3f parcel %.3f', state.vel, state.pos, x + 0.8)
end
''' }
"#,
    );
    let done = place.tatu(&["run", "scene.toml", "--seconds", "3"]).good();
    let line = done.out.lines().find(|l| l.contains("parcel")).unwrap_or_else(|| panic!("{}", done.err));
    let number = |key: &str| -> f64 {
        line.split(&format!("{key} ")).nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    assert_eq!(number("vel"), 0.2, "{line}");
    assert!((number("parcel") - number("pos")).abs() < 0.03 && number("pos") > 0.3, "{line}");
}

/// Runs a script of a dummy `d` that has a joint and a box below it, and returns its output.
fn printed(script: &str) -> String {
    let scene = format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = {{ text = '''{script}''' }}\n\
         [[object]]\nkind = \"joint\"\nalias = \"hinge\"\nparent = \"d\"\nposition_m = [0, 0, 1]\n\
         [[object]]\nkind = \"shape\"\nalias = \"box\"\nparent = \"hinge\"\ndynamic = true\nmass_kg = 3.0\n"
    );
    TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", "1"]).good().out
}

/// See tests/facts/script-api.md, 10. The length of an arc is the angle times the radius.
#[test]
fn gcode_programs_become_paths() {
    let script = r#"
require 'gcode'
loglevel = LOG.ERROR
local g = GCodeInterpreter:new()
local function run(text) return g:runProgram(text) end
local function near(a, b) if math.abs(a - b) > 1e-9 then error(a .. ' is not ' .. b, 2) end end
-- The last point of a path, and the longest step of a path.
local function last(way) return table.unpack(way[2], #way[2] - 5) end
local function step(way)
    local most, p = 0, way[2]
    for i = 7, #p, 6 do most = math.max(most, math.sqrt((p[i] - p[i - 6]) ^ 2 + (p[i + 1] - p[i - 5]) ^ 2)) end
    return most
end
-- 2 inches at 60 inches per minute, relative, with angles.
local ways = run('G20 G91 F60\nG1 X1 (one)\n  x1 C90\nG4 P250')
near(last(ways[1]), 0.0254)
near(last(ways[2]), 0.0508)
near(select(6, last(ways[2])), math.pi / 2)
near(ways[1][1], 1)
assert(#ways == 3 and ways[3][1] == 0.25 and #ways[3][2] == 6)
-- A quarter turn counterclockwise about (0, 0), and one clockwise back; then a full circle.
ways = run('G1 X100 F6000\nG3 X0 Y100 I-100 J0\nG2 X100 Y0 I0 J-100\nG2 I-100')
near(ways[2][1], math.pi / 2)
near(ways[3][1], math.pi / 2)
near(ways[4][1], 2 * math.pi)
local x, y = last(ways[4])
near(x, 0.1) near(y, 0)
for _, way in ipairs(ways) do assert(step(way) <= 1 / 150 + 1e-12) end
for _, way in ipairs{ways[2], ways[4]} do
    for i = 1, #way[2], 6 do near(way[2][i] ^ 2 + way[2][i + 1] ^ 2, 0.01) end
end
-- By radius: half a turn about (100, 0), and three quarters of one.
ways = run('F60\nG3 X200 R100\nG0 X0 Y0\nG2 X100 Y100 R-100')
near(ways[1][1], math.pi * 100)
near(ways[3][1], 1.5 * math.pi * 100)
assert(#run('G0 X10 Y20 Z30\nG28') == 2 and last(run('G0 X10\nG28')[2]) == 0)
for text, told in pairs{
    ['G1 X1\nG2 X50 I10'] = 'line 2', ['G3 X10 Z5 I5'] = 'the arc changes Z', ['G2 X0 R5'] = 'end at its start point',
    ['G2 X100 R10'] = 'too small', ['G1 X1.2.3'] = "a number after X, found '1.2.3'", ['G1 X'] = 'expected a number',
} do
    local ok, e = pcall(run, text)
    assert(not ok and e:find(told, 1, true), tostring(e))
end
local _, green, red, blue = g:runProgram('G0 X10\nG1 Y10', true)
assert(green and red and blue and green ~= red)
print('all')
"#;
    assert!(printed(script).contains("all"));
}

/// The module `sim-2` returns objects with properties and methods in place of handles (tests/facts/script-api.md, 10).
#[test]
fn objects_replace_handles_in_sim_2() {
    let script = r#"
local plain = sim
local sim = require 'sim-2'
function sysCall_init()
    local d, hinge, box = sim.scene:getObject('/d'), sim.scene:getObject('/d/hinge'), sim.scene:getObject('/d/hinge/box')
    assert(sim.self.parent == d and d.parent == nil and box.parent == hinge and hinge ~= box)
    assert(d:getObject('./hinge/box') == box and d.children[1] == hinge and #box.children == 0)
    assert(box.handle == plain.getObject('/d/hinge/box') and tostring(box):find("'/d/hinge/box'"))
    -- Properties by either name, with their own types.
    assert(box.mass == 3 and box.dynamic == true and box.alias == 'box' and box.worldPosition[3] == 1)
    box.mass, box.alias = 2, 'cube'
    assert(plain.getShapeMass(box.handle) == 2 and plain.getObject('/cube') == box.handle)
    box.worldPosition = {1, 2, 3}
    assert(box:getPosition(d)[3] == 3 and box.worldPose[2] == 2)
    box.customData.n, sim.scene.signal.n = 7, 8
    assert(box.customData.n == 7 and plain.getInt32Signal('n') == 8 and box.customData.m == nil)
    -- Methods read and set properties of a given type.
    box:setColorProperty('shape.color', {1, 0, 0.5})
    assert(box:getColorProperty('shape.color')[3] == 0.5 and #d:getPoseProperty('object.pose') == 7)
    sim.scene:setIntProperty('signal.k', 4)
    assert(sim.scene:getIntProperty('signal.k') == 4 and plain.getInt32Signal('k') == 4)
    -- Methods by the names for the kind of object.
    hinge:setTargetVelocity(0.5)
    assert(plain.getJointTargetVelocity(hinge.handle) == 0.5 and hinge.targetVelocity == 0.5)
    box:setParent(d, true)
    assert(box.parent == d)
    box.parent = nil
    assert(box.parent == nil)
    -- Functions of `sim` accept objects in place of handles.
    assert(sim.getObjectAlias(box) == 'cube' and sim.Object(box.handle) == box)
    assert(sim.scene.simulationTime == 0 and sim.app.platform == 2 and sim.version == 2)
    assert(#sim.scene:getObjects() >= 3)
    for _, f in ipairs{function() return box.colour end, function() box.colour = 1 end, function() return sim.scene.colour end} do
        local ok, e = pcall(f)
        assert(not ok and tostring(e):find('colour'), tostring(e))
    end
    box:remove()
    assert(plain.getObject('/cube', {noError = true}) == -1)
    print('all')
end
"#;
    assert!(printed(script).contains("all"));
}

#[test]
fn unsupported_modules_raise_an_error_with_help() {
    let scene = "[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = { text = \"require 'simSubprocess'\" }";
    let done = TestFolder::scene(scene).run(&["--steps", "1"]);
    done.reports(&["the module `simSubprocess` of the original is not available", "--allow exec"]);
}
