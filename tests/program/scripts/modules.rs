//! Lua modules that came with the original: their page runs, and what they do in a scene.

use crate::kit::*;

/// Blocks of Lua in a page.
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
        let place = Place::scene(&format!(
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
-- Of unknown length, tagged, and with a null in it.
assert(cbor.decode(bytes'7f657374726561646d696e67ff') == 'streaming')
assert(#cbor.decode(bytes'9f018202039f0405ffff') == 3 and cbor.decode(bytes'bf61610161629f0203ffff').b[2] == 3)
assert(select(3, cbor.decode(bytes'c11a514b67b0')) == 'TAG_1' and cbor.decode(bytes'c11a514b67b0') == 1363896240)
assert(cbor.decode(bytes'83f60102')[3] == 2 and select(3, cbor.decode(bytes'f6')) == 'null')
-- What is not CBOR is an error, and nothing worse.
for _, wrong in ipairs{'18', '62', '9b7fffffffffffffff', '5b7fffffffffffffff', '1c', 'ff', ('81'):rep(5000)} do
    assert(not pcall(cbor.decode, bytes(wrong)), wrong:sub(1, 20))
end
local round = {}
round[1] = round
assert(not pcall(cbor.encode, round) and not pcall(cbor.encode, print))
print('all')
"#;
    let place =
        Place::scene(&format!("[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = {{ text = '''{script}''' }}"));
    let done = place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
    assert!(done.out.contains("all"), "{}", done.err);
}

/// A box on a conveyor that does not move is carried on; its speed follows what others ask for.
#[test]
fn a_conveyor_carries_what_lies_on_it() {
    let place = Place::scene(
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

#[test]
fn modules_that_cannot_be_here_say_what_to_do() {
    for (module, advice) in [("simZMQ", "--service zmq_remote"), ("simSubprocess", "--allow exec")] {
        let scene =
            format!("[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = {{ text = \"require '{module}'\" }}");
        let done = Place::scene(&scene).run(&["--steps", "1"]);
        done.tells(&[&format!("the module `{module}` of the original is not available"), advice]);
    }
}
