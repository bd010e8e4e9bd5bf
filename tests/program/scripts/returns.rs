//! Tests of what commands return to scripts for version 4.2 or later: one row per call, as observed in CoppeliaSim 4.9
//! (tests/facts/call-order.md, 5), and the value here if it differs; each difference is listed in the guide, "Coming
//! from V-REP".
//!
//! Rows of the observations about spherical joints, vision sensors and unknown names are left out.

use std::collections::BTreeMap;

use crate::kit::*;

/// A call, its result in CoppeliaSim (number of values, and the values), and the result here if it differs.
#[rustfmt::skip]
const CALL_RESULTS: &[(&str, &str, &str)] = &[
    ("sim.getObject('/box')", "1: int <box>", ""),
    ("sim.getObject('/missing')", "raises", ""),
    ("sim.getObject('/missing',{noError=true})", "1: int -1", ""),
    ("sim.getObject('box')", "raises", ""),
    ("sim.getObject('./x')", "raises", ""),
    ("sim.getObject('')", "raises", ""),
    ("sim.getObject(5)", "raises", ""),
    ("sim.getObject()", "raises", ""),
    ("sim.getObject(':/box')", "1: int <box>", ""),
    ("sim.getObject('/box[0]')", "1: int <box>", ""),
    ("sim.getObject('/box[1]')", "raises", ""),
    ("sim.getObject('../')", "raises", ""),
    ("sim.getObjectHandle('box')", "1: int <box>", ""),
    ("sim.getObjectHandle('missing')", "raises", ""),
    ("sim.getObjectHandle('box#')", "1: int <box>", ""),
    ("sim.getObjectHandle('box#0')", "raises", ""),
    ("sim.getObjectHandle('missing@silentError')", "1: int -1", ""),
    ("sim.getObjectHandle('missing',{noError=true})", "1: int -1", ""),
    ("simGetObjectHandle('box')", "1: int <box>", ""),
    ("simGetObjectHandle('missing')", "raises", ""),
    ("simGetObjectHandle('missing@silentError')", "1: int -1", ""),
    ("sim.getObjectPosition(box,-1)", "1: {0, 0, 1}", ""),
    ("sim.getObjectPosition(box)", "1: {0, 0, 1}", ""),
    ("sim.getObjectPosition(wrong,-1)", "raises", ""),
    ("sim.getObjectPosition(-5,-1)", "raises", ""),
    ("sim.getObjectPosition(nil)", "raises", ""),
    ("sim.getObjectPosition('box',-1)", "raises", ""),
    ("sim.getObjectPosition(box, wrong)", "raises", ""),
    ("sim.getObjectOrientation(box,-1)", "1: {0, 0, 0}", ""),
    ("sim.getObjectOrientation(box)", "1: {0, 0, 0}", ""),
    ("sim.getObjectOrientation(wrong,-1)", "raises", ""),
    ("sim.getObjectOrientation(-5,-1)", "raises", ""),
    ("sim.getObjectOrientation(nil)", "raises", ""),
    ("sim.getObjectOrientation('box',-1)", "raises", ""),
    ("sim.getObjectOrientation(box, wrong)", "raises", ""),
    ("sim.getObjectQuaternion(box,-1)", "1: {0, 0, 0, 1}", ""),
    ("sim.getObjectQuaternion(box)", "1: {0, 0, 0, 1}", ""),
    ("sim.getObjectQuaternion(wrong,-1)", "raises", ""),
    ("sim.getObjectQuaternion(-5,-1)", "raises", ""),
    ("sim.getObjectQuaternion(nil)", "raises", ""),
    ("sim.getObjectQuaternion('box',-1)", "raises", ""),
    ("sim.getObjectQuaternion(box, wrong)", "raises", ""),
    ("sim.getObjectPose(box,-1)", "1: {0, 0, 1, 0, 0, 0, 1}", ""),
    ("sim.getObjectPose(box)", "1: {0, 0, 1, 0, 0, 0, 1}", ""),
    ("sim.getObjectPose(wrong,-1)", "raises", ""),
    ("sim.getObjectPose(-5,-1)", "raises", ""),
    ("sim.getObjectPose(nil)", "raises", ""),
    ("sim.getObjectPose('box',-1)", "raises", ""),
    ("sim.getObjectPose(box, wrong)", "raises", ""),
    ("sim.getObjectMatrix(box,-1)", "1: {1, 0, 0, 0, 0, 1, 0, 0, ...} (12)", ""),
    ("sim.getObjectMatrix(box)", "1: {1, 0, 0, 0, 0, 1, 0, 0, ...} (12)", ""),
    ("sim.getObjectMatrix(wrong,-1)", "raises", ""),
    ("sim.getObjectMatrix(-5,-1)", "raises", ""),
    ("sim.getObjectMatrix(nil)", "raises", ""),
    ("sim.getObjectMatrix('box',-1)", "raises", ""),
    ("sim.getObjectMatrix(box, wrong)", "raises", ""),
    ("simGetObjectPosition(wrong,-1)", "raises", ""),
    ("sim.setObjectPosition(box,-1,{1,2,3})", "0 values", ""),
    ("sim.setObjectPosition(box,{1,2,3},-1)", "0 values", ""),
    ("sim.setObjectPosition(box,{1,2,3})", "0 values", ""),
    ("sim.setObjectPosition(box,{1,2})", "raises", ""),
    ("sim.setObjectPosition(wrong,{1,2,3})", "raises", ""),
    ("sim.setObjectPosition(box,{'a',2,3})", "raises", ""),
    ("sim.setObjectPosition(box,{0/0,0,0})", "raises", ""),
    ("sim.setObjectPosition(box,{0,0,1})", "0 values", ""),
    ("sim.setObjectOrientation(box,-1,{0,0,1})", "0 values", ""),
    ("sim.setObjectQuaternion(box,{0,0,0,2})", "0 values", ""),
    ("sim.getObjectQuaternion(box)", "1: {0, 0, 0, 1}", ""),
    ("sim.setObjectQuaternion(box,{0,0,0,0})", "0 values", "raises"),
    ("sim.getObjectQuaternion(box)", "1: {-nan, -nan, -nan, -nan}", "1: {0, 0, 0, 1}"),
    ("sim.getJointPosition(joint)", "1: float 0", ""),
    ("sim.getJointPosition(box)", "raises", ""),
    ("sim.getJointPosition(wrong)", "raises", ""),
    ("sim.setJointTargetVelocity(joint,1)", "1: int 1", ""),
    ("sim.setJointTargetVelocity(box,1)", "raises", ""),
    ("sim.setJointTargetVelocity(joint,'x')", "raises", ""),
    ("sim.setJointTargetVelocity(joint,'2')", "1: int 1", ""),
    ("sim.setJointTargetVelocity(joint)", "raises", ""),
    ("sim.setJointTargetVelocity(joint,nil)", "raises", ""),
    ("sim.getJointTargetVelocity(joint)", "1: float 2", ""),
    ("simSetJointTargetVelocity(box,1)", "raises", ""),
    ("sim.setJointPosition(kinematic,100)", "1: int 1", ""),
    ("sim.getJointPosition(kinematic)", "1: float 1", ""),
    ("sim.setJointTargetPosition(joint,0.5)", "1: int 1", ""),
    ("sim.setJointMaxForce(joint,5)", "1: int 1", ""),
    ("sim.setJointForce(joint,5)", "1: int 1", ""),
    ("sim.setJointTargetForce(joint,5)", "0 values", ""),
    ("sim.getJointForce(joint)", "1: float 0", ""),
    ("sim.getJointForce(kinematic)", "1: float 0", ""),
    ("sim.getJointInterval(joint)", "2: boolean false ; {-1, 2}", ""),
    ("sim.getJointMode(joint)", "2: int 5 ; int 0", ""),
    ("sim.getJointVelocity(joint)", "1: float 0", ""),
    ("sim.getJointType(joint)", "1: int 10", ""),
    ("sim.getJointType(box)", "raises", ""),
    ("sim.readProximitySensor(prox)", "5: int 0 ; float 0 ; {0, 0, 0} ; int -1 ; {0, 0, 0}", ""),
    ("sim.readProximitySensor(box)", "raises", ""),
    ("sim.readProximitySensor(wrong)", "raises", ""),
    ("simReadProximitySensor(prox)", "5: int 0 ; float 0 ; {0, 0, 0} ; int -1 ; {0, 0, 0}", ""),
    ("sim.handleProximitySensor(prox)", "5: int 0 ; float 0 ; {0, 0, 0} ; int -1 ; {0, 0, 0}", ""),
    ("sim.readProximitySensor(prox)", "5: int 0 ; float 0 ; {0, 0, 0} ; int -1 ; {0, 0, 0}", ""),
    ("sim.checkProximitySensor(prox,box)", "5: int 0 ; float 0 ; {0, 0, 0} ; int -1 ; {0, 0, 0}", ""),
    ("sim.checkProximitySensor(prox,sim.handle_all)", "5: int 0 ; float 0 ; {0, 0, 0} ; int -1 ; {0, 0, 0}", ""),
    ("sim.resetProximitySensor(prox)", "1: int 1", ""),
    ("sim.readVisionSensor(box)", "raises", ""),
    ("sim.readForceSensor(force)", "3: int 2 ; {0, 0, 0} ; {0, 0, 0}", ""),
    ("sim.readForceSensor(box)", "raises", ""),
    ("sim.getInt32Signal('unset')", "0 values", ""),
    ("sim.getFloatSignal('unset')", "0 values", ""),
    ("sim.getStringSignal('unset')", "0 values", ""),
    ("sim.getInt32Signal(5)", "0 values", ""),
    ("sim.getInt32Signal()", "raises", ""),
    ("sim.setInt32Signal('s',3)", "1: int 1", ""),
    ("sim.getInt32Signal('s')", "1: int 3", ""),
    ("sim.setInt32Signal('s',3.7)", "1: int 1", ""),
    ("sim.getInt32Signal('s')", "1: int 3", ""),
    ("sim.getFloatSignal('s')", "0 values", ""),
    ("sim.setStringSignal('str','ab')", "1: int 1", ""),
    ("sim.getStringSignal('str')", "1: string(2) ab", ""),
    ("sim.clearInt32Signal('s')", "1: int 1", ""),
    ("sim.clearInt32Signal('never')", "1: int 0", ""),
    ("sim.getIntegerSignal('unset')", "0 values", ""),
    ("simGetIntegerSignal('unset')", "0 values", ""),
    ("sim.setIntegerSignal('x',1)", "1: int 1", ""),
    ("sim.getIntegerSignal('x')", "1: int 1", ""),
    ("sim.getSignalName(0,0)", "1: string(1) x", ""),
    ("sim.setInt32Signal('a')", "raises", ""),
    ("sim.packTable({1,2})", "1: buffer", "text"),
    ("sim.unpackTable('garbage')", "raises", ""),
    ("sim.unpackTable('')", "1: {}", ""),
    ("sim.unpackTable(sim.packTable({a=1}))", "1: {a=1}", ""),
    ("sim.packTable(5)", "raises", ""),
    ("sim.packInt32Table({1,2})", "1: buffer", "text"),
    ("sim.unpackInt32Table('abc')", "1: {}", ""),
    ("sim.unpackInt32Table('')", "1: {}", ""),
    ("sim.packFloatTable({1.5})", "1: buffer", "text"),
    ("sim.unpackFloatTable(sim.packFloatTable({1,2}))", "1: {1, 2}", ""),
    ("sim.packFloatTable({})", "0 values", ""),
    ("sim.packFloatTable({'a'})", "1: buffer", "text"),
    ("sim.packUInt8Table({256,-1})", "1: buffer", "text"),
    ("sim.getObjectParent(box)", "1: int -1", ""),
    ("sim.getObjectParent(wrong)", "raises", ""),
    ("sim.getObjectChild(box,0)", "1: int -1", ""),
    ("sim.getObjectChild(box,99)", "1: int -1", ""),
    ("sim.getObjectType(box)", "1: int 0", ""),
    ("sim.getObjectType(wrong)", "raises", ""),
    ("sim.isHandle(box)", "1: boolean true", ""),
    ("sim.isHandle(wrong)", "1: boolean false", ""),
    ("sim.isHandleValid(box)", "1: int 1", ""),
    ("sim.isHandleValid(wrong)", "1: int 0", ""),
    ("sim.getObjectName(box)", "1: string(3) box", ""),
    ("sim.getObjectName(wrong)", "raises", ""),
    ("sim.getObjectAlias(box)", "1: string(3) box", ""),
    ("sim.getObjectAlias(box,1)", "1: string(4) /box", ""),
    ("sim.getObjectAlias(box,4)", "1: string(8) box__<box>__", ""),
    ("sim.getObjectAlias(box,5)", "1: string(4) /box", ""),
    ("sim.setObjectAlias(box,'a b!')", "0 values", ""),
    ("sim.getObjectAlias(box)", "1: string(4) a_b_", ""),
    ("sim.setObjectAlias(box,'')", "0 values", ""),
    ("sim.setObjectAlias(box,'box')", "0 values", ""),
    ("sim.getObjects(0,sim.handle_all)", "1: int 0", "1: int <box>"),
    ("sim.getObjects(999,sim.handle_all)", "1: int -1", ""),
    ("sim.getObjectsInTree(wrong)", "raises", ""),
    ("sim.getObjectsInTree(box,sim.handle_all,1)", "1: {}", ""),
    ("sim.getShapeMass(box)", "1: float 0.5", ""),
    ("sim.getShapeMass(joint)", "raises", ""),
    ("sim.setShapeMass(box,-1)", "0 values", ""),
    ("sim.getShapeMass(box)", "1: float 1e-07", ""),
    ("sim.setShapeMass(box,1)", "0 values", ""),
    ("sim.getVelocity(box)", "2: {0, 0, 0} ; {0, 0, 0}", ""),
    ("sim.getObjectVelocity(box)", "2: {0, 0, 0} ; {0, 0, 0}", ""),
    ("sim.getObjectVelocity(joint)", "2: {0, 0, 0} ; {0, 0, 0}", ""),
    ("sim.addForce(box,{0,0,0},{0,0,1})", "1: int 1", ""),
    ("sim.addForceAndTorque(joint,{0,0,0},{0,0,0})", "raises", ""),
    ("sim.getObjectInt32Param(box,3003)", "1: int 1", ""),
    ("sim.getObjectInt32Param(box,99999)", "0 values", ""),
    ("sim.getObjectFloatParam(box,99999)", "0 values", ""),
    ("sim.getObjectInt32Parameter(box,3003)", "2: int 1 ; int 1", ""),
    ("sim.setObjectInt32Param(joint,3003,1)", "raises", ""),
    ("sim.getInt32Param(99999)", "raises", ""),
    ("sim.getBoolParam(99999)", "raises", ""),
    ("sim.readCustomDataBlock(box,'unset')", "1: nil nil", ""),
    ("sim.writeCustomDataBlock(box,'t','abc')", "1: int 1", ""),
    ("sim.readCustomDataBlock(box,'t')", "1: string(3) abc", ""),
    ("sim.readCustomStringData(box,'t')", "1: string(3) abc", ""),
    ("sim.readCustomTableData(box,'unset')", "1: {}", ""),
    ("sim.readCustomDataBlock(wrong,'t')", "1: nil nil", ""),
    ("sim.readCustomDataBlockTags(box)", "1: {t}", ""),
    ("sim.checkCollision(box,dummy)", "2: int 0 ; {-1, -1}", ""),
    ("sim.checkDistance(box,box)", "3: int 0 ; {0, 0, 0, 0, 0, 0, 0} ; {-1, -1}", ""),
    ("sim.getSimulationTime()", "1: float 0.05", ""),
    ("sim.getSimulationState()", "1: int 17", ""),
    ("sim.getSimulationTimeStep()", "1: float 0.05", ""),
    ("sim.getSystemTime()", "1: float 0.057", "1: float 0.05"),
    ("sim.getSystemTimeInMs(-1)", "1: int 57", "1: int 50"),
    ("sim.getLastError()", "1: string(18) invalid parameter.", "0 values"),
    ("sim.removeObject(wrong)", "raises", ""),
    ("sim.removeObjects({wrong})", "raises", ""),
    ("sim.loadModel('missing.ttm')", "raises", ""),
    ("sim.getCollectionHandle('missing')", "raises", ""),
    ("sim.getCollisionHandle('missing')", "raises", ""),
    ("sim.getDistanceHandle('missing')", "raises", ""),
    ("sim.getIkGroupHandle('missing')", "raises", ""),
    ("sim.getScript(1,box)", "1: int -1", ""),
    ("sim.getScriptAssociatedWithObject(box)", "1: int -1", ""),
    ("sim.callScriptFunction('f',wrong)", "raises", ""),
    ("sim.getUserParameter(box,'x')", "0 values", ""),
    ("sim.getScriptSimulationParameter(sim.handle_self,'x')", "raises", "0 values"),
    ("sim.getPathPosition(box,0,0)", "raises", ""),
    ("sim.getPositionOnPath(box,0)", "raises", ""),
    ("sim.wait(0)", "1: float 0", ""),
    ("sim.switchThread()", "0 values", ""),
    ("sim.step()", "0 values", ""),
    ("sim.addLog(sim.verbosity_msgs,'x')", "0 values", ""),
    ("sim.addStatusbarMessage('x')", "1: int 1", ""),
    ("sim.startSimulation()", "0 values", ""),
    ("sim.tubeOpen(0,'t',1)", "1: int 0", ""),
    ("sim.sendData(sim.handle_all,0,'n','d')", "1: int 1", ""),
    ("sim.receiveData(0,'none')", "0 values", ""),
    ("sim.createDummy(0.01)", "1: int <new>", ""),
    ("sim.createPureShape(0,16,{1,1,1},1)", "1: int <new>", ""),
    ("sim.buildMatrix({0,0,0},{0,0,0})", "1: {1, 0, 0, 0, 0, 1, 0, 0, ...} (12)", ""),
    ("sim.getEulerAnglesFromMatrix(sim.buildIdentityMatrix())", "1: {0, 0, 0}", ""),
    ("sim.multiplyMatrices(sim.buildIdentityMatrix(),{1,2,3})", "raises", ""),
    ("sim.copyPasteObjects({box},0)", "1: {<new>}", ""),
    ("sim.unknown_constant", "1: nil nil", ""),
];

const SCENE: &str = r#"
dialect = "4.9"
[[object]]
kind = "shape"
alias = "box"
size_m = [0.2, 0.2, 0.2]
position_m = [0, 0, 1]
mass_kg = 0.5
[[object]]
kind = "dummy"
alias = "dummy"
[[object]]
kind = "joint"
alias = "joint"
limits_rad = [-1, 1]
[[object]]
kind = "joint"
alias = "kinematic"
mode = "kinematic"
limits_rad = [-1, 1]
[[object]]
kind = "sensor"
sensor = "proximity"
alias = "prox"
volume = "ray"
range_m = 1
position_m = [0, 0, 30]
[[object]]
kind = "force_sensor"
alias = "force"
[[object]]
kind = "dummy"
alias = "caller"
script = { file = "calls.lua" }
"#;

/// A script that makes each call in the second actuation, as the script that ran in CoppeliaSim did, and prints the
/// results.
const CALL_SCRIPT: &str = r#"
local names, known, named = {}, 0, false
local function one(v)
    if named and math.type(v) == 'integer' and names[v] then return '<' .. names[v] .. '>' end
    if named and math.type(v) == 'integer' and v > known and v < 100 then return '<new>' end
    return math.type(v) == 'float' and string.format('%.14g', v) or tostring(v)
end
local function show(v)
    if type(v) == 'table' then
        local n, out = #v, {}
        if n == 0 then
            for k, x in pairs(v) do out[#out + 1] = tostring(k) .. '=' .. one(x) end
            return '{' .. table.concat(out, ', ') .. '}'
        end
        for i = 1, math.min(n, 8) do out[i] = math.type(v[i]) == 'integer' and v[i] < 1 and tostring(v[i]) or one(v[i]) end
        return '{' .. table.concat(out, ', ') .. (n > 8 and ', ...} (' .. n .. ')' or '}')
    elseif type(v) == 'string' then
        return 'string(' .. #v .. ') ' .. v:gsub('[^%g ]', '?')
    end
    return (math.type(v) == 'integer' and 'int ' or math.type(v) == 'float' and 'float ' or type(v) .. ' ') .. one(v)
end
function sysCall_actuation()
    if done or sim.getSimulationTime() == 0 then return end
    done = true
    for _, alias in ipairs{'box', 'dummy', 'joint', 'kinematic', 'prox', 'force'} do
        _G[alias] = sim.getObject('/' .. alias)
        names[_G[alias]] = alias
    end
    wrong, known = 777777, sim.getScript(sim.handle_self)
    for i, call in ipairs(calls) do
        local f = assert(load('return ' .. call))
        -- A small number denotes an object only where a handle is expected.
        local r, out = table.pack(pcall(f)), {}
        named = handles[i]
        for k = 2, r.n do out[k - 1] = show(r[k]) end
        print('ROW ' .. i .. ' ' .. (not r[1] and 'raises' or r.n == 1 and '0 values'
            or (r.n - 1) .. ': ' .. table.concat(out, ' ; ')))
    end
end
"#;

/// Removes the sign of negative zeros.
fn unsigned(text: &str) -> String {
    let mut out = text.to_owned();
    for end in [",", "}", " "] {
        out = out.replace(&format!("-0{end}"), &format!("0{end}"));
    }
    out
}

#[test]
fn values_are_those_of_the_original() {
    let calls: Vec<String> = CALL_RESULTS.iter().map(|(call, ..)| format!("[==[{call}]==]")).collect();
    let handles: Vec<String> =
        CALL_RESULTS.iter().map(|(_, e, o)| (e.contains('<') || o.contains('<')).to_string()).collect();
    let place = TestFolder::scene(SCENE);
    let tables = format!("calls = {{ {} }}\nhandles = {{ {} }}\n", calls.join(",\n"), handles.join(", "));
    place.write("calls.lua", &(tables + CALL_SCRIPT));
    let done = place.tatu(&["run", "scene.toml", "--steps", "3"]).good();
    let mut got: BTreeMap<usize, String> = BTreeMap::new();
    for line in done.out.lines().chain(done.err.lines()) {
        if let Some((_, row)) = line.split_once("ROW ") {
            let (i, text) = row.split_once(' ').unwrap();
            got.insert(i.parse().unwrap(), unsigned(text));
        }
    }
    let mut wrong = Vec::new();
    for (i, (call, original, ours)) in CALL_RESULTS.iter().enumerate() {
        let found = got.get(&(i + 1)).map_or("nothing was printed", String::as_str);
        let expected = if ours.is_empty() { original } else { ours };
        let same = match *expected {
            "text" => found.starts_with("1: string("),
            // In names, `__<box>__` stands for the handle of the box.
            e if e.contains("__<box>__") => found.starts_with("1: string"),
            e => found == e,
        };
        if !same {
            wrong.push(format!("{call}\n    expected {expected}\n    found    {found}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {} rows differ:\n{}", wrong.len(), CALL_RESULTS.len(), wrong.join("\n"));
}

#[test]
fn each_difference_is_in_the_guide() {
    let guide = std::fs::read_to_string(root().join("docs/guide/coming-from-vrep.md")).unwrap();
    for (call, original, ours) in CALL_RESULTS.iter().filter(|r| !r.2.is_empty()) {
        let row = guide.lines().find(|l| l.starts_with(&format!("| `{call}`")) && l.contains(original));
        let row = row.unwrap_or_else(|| panic!("docs/guide/coming-from-vrep.md does not list `{call}`"));
        assert!(*ours == "text" || row.contains(&ours.replace(['<', '>'], "")), "{call}: {row}");
    }
}

#[test]
fn each_row_of_the_guide_names_its_test() {
    let guide = std::fs::read_to_string(root().join("docs/guide/coming-from-vrep.md")).unwrap();
    let (_, tables) = guide.split_once("## What differs").unwrap();
    let mut rows = 0;
    for row in tables.lines().filter(|l| l.starts_with("| ") && !l.ends_with("| test |")) {
        let cell = row.trim_end_matches(" |").rsplit(" | ").next().unwrap_or_default();
        let (file, name) = cell.trim_matches('`').split_once("::").unwrap_or_else(|| panic!("no test in {row}"));
        let find =
            |folder: &str| std::fs::read_to_string(root().join(format!("tests/program/{folder}/{file}.rs"))).ok();
        let folders = ["scripts", "scene", "sensors", "robots", "plugins", "remote", "state", "cli"];
        let text = folders.into_iter().find_map(find).unwrap_or_default();
        assert!(text.contains(&format!("\nfn {name}()")), "there is no test {cell}: {row}");
        rows += 1;
    }
    assert!(rows > 40, "{rows} rows");
}

/// Up to 4.1, errors of commands called by flat names are reported, and the result is -1 or nil; errors of commands
/// with `sim.` names are raised. Since 4.2 all are raised (tests/facts/script-api.md, 2; tests/facts/call-order.md, 5).
#[test]
fn errors_of_flat_names_follow_the_era() {
    let script = "
        function sysCall_actuation()
            print('FLAT ' .. tostring(select(2, pcall(simSetJointTargetVelocity, 777777, 1))))
            print('NIL ' .. tostring(select(2, pcall(simGetObjectPosition, 777777, -1))))
            print('SIM ' .. tostring(pcall(sim.setJointTargetVelocity, 777777, 1)))
        end";
    for (dialect, flat, nil, sim) in [
        ("3.2", "FLAT -1", "NIL nil", "SIM false"),
        ("4.1", "FLAT -1", "NIL nil", "SIM false"),
        ("4.2", "there is no object", "there is no object", "SIM false"),
        ("4.9", "there is no object", "there is no object", "SIM false"),
    ] {
        let scene = format!(
            "dialect = \"{dialect}\"\n[[object]]\nkind = \"dummy\"\nalias = \"a\"\nscript = {{ text = '''{script}''' }}\n"
        );
        let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", "1"]);
        let all = format!("{}{}", done.out, done.err);
        let line = |mark: &str| all.lines().find(|l| l.contains(mark)).unwrap_or_default().to_owned();
        assert!(line("FLAT ").contains(flat), "{dialect}: {all}");
        assert!(line("NIL ").contains(nil), "{dialect}: {all}");
        assert!(line("SIM ").contains(sim), "{dialect}: {all}");
    }
}

/// Without a detection, a sensor returns one value before 4.2, which is -1 in the first actuation and 0 afterwards, and
/// five values since 4.2 (tests/facts/script-api.md, 2; tests/facts/call-order.md, 5).
#[test]
fn proximity_sensors_answer_as_the_era_expects() {
    let script = "
        function sysCall_actuation()
            local r = {simReadProximitySensor(sim.getObjectHandle('eye'))}
            print('EYE ' .. #r .. ' ' .. r[1] .. ' ' .. tostring(r[2]))
        end";
    for (dialect, first, then) in
        [("3.2", "1 -1 nil", "1 0 nil"), ("4.1", "1 -1 nil", "1 0 nil"), ("4.2", "5 0 0", "5 0 0")]
    {
        let scene = format!(
            "dialect = \"{dialect}\"\n[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"eye\"\nvolume = \"ray\"\n\
             range_m = 1\n[[object]]\nkind = \"dummy\"\nalias = \"a\"\nscript = {{ text = '''{script}''' }}\n"
        );
        let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", "2"]).good();
        let all = format!("{}{}", done.out, done.err);
        let found: Vec<&str> = all.lines().filter_map(|l| l.split_once("EYE ").map(|p| p.1)).collect();
        let shown = |expected: &str, found: &str| found.replace("0.0", "0") == expected;
        // Two steps, and three passes to the end.
        let rest = found.iter().skip(1).all(|f| shown(then, f));
        assert!(found.len() == 5 && shown(first, found[0]) && rest, "{dialect}: {found:?}");
    }
}
