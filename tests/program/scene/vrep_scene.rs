//! Tests of 41 V-REP scene files: the importer finds the same contents as an independent reader, and all scenes run.

use std::{fs, path::PathBuf};

use serde_json::Value;

use crate::kit::*;

fn files() -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(shared("corpus/ttt"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|x| x == "ttt" || x == "ttm"))
        .collect();
    all.sort();
    all
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn files_are_read_as_an_independent_reader_does() {
    let mut count = 0;
    for file in files() {
        let wanted: Value =
            serde_json::from_str(&fs::read_to_string(file.with_extension("expected.json")).unwrap()).unwrap();
        let done = TestFolder::new().tatu(&["check", file.to_str().unwrap(), "--json"]).good();
        let mut found = done.json();
        assert!(found["report"].is_array(), "{}: no report", file.display());
        found.as_object_mut().unwrap().remove("report");
        // The file does not contain the solvers of mechanisms, which Tatu chooses.
        found.as_object_mut().unwrap().remove("mechanisms");
        let differs: Vec<&String> =
            wanted.as_object().unwrap().iter().filter(|(k, v)| found.get(*k) != Some(*v)).map(|(k, _)| k).collect();
        assert!(differs.is_empty() && found == wanted, "{}: {differs:?} differ", file.display());
        count += 1;
    }
    assert_eq!(count, 41);
}

/// Files whose scripts also raise errors in V-REP. Each error that they raise here must contain one of the strings,
/// which are separated by `|`.
const KNOWN_SCRIPT_ERRORS: &[(&str, &str)] = &[
    ("v30003_quadcopter", "simExtQuadcopterReadSensors"),
    ("v30103_3Rob_freeEnvironm", "dlgStyle"),
    ("v30203_Lab2_Environment", "there is no object -1"),
    ("v30301_Pioneer_p3dx_traj_DEMO", "CustomDataFromHeader|a nil value"),
    ("v40000_ur10-rg2-rack-bottles-box", "module `"),
    ("v40300_testSceneForModelDevelopment", "module `blimp`"),
    ("v41000_locomocao", "simZMQ"),
];

/// Scripts from eleven years run without an error, or with the errors that they also raise in V-REP.
#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn files_run() {
    let mut good = 0;
    for file in files() {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let done =
            TestFolder::new().tatu(&["run", file.to_str().unwrap(), "--steps", "30", "--json", "--allow", "python"]);
        assert!(!done.err.contains("panicked"), "{name}: {}", done.err);
        match KNOWN_SCRIPT_ERRORS.iter().find(|(n, _)| *n == name) {
            Some((_, words)) => {
                for e in done.errors() {
                    let text = e["message"].as_str().unwrap();
                    assert!(words.split('|').any(|w| text.contains(w)), "{name}: {text}");
                }
            }
            None => {
                done.good();
                good += 1;
            }
        }
    }
    assert_eq!(good, 41 - KNOWN_SCRIPT_ERRORS.len());
}

/// V-REP applies position targets directly, once per step. Imported scenes do the same, so their targets are not
/// interpolated between steps.
#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn targets_jump_as_in_the_original() {
    let place = TestFolder::new();
    let file = shared("corpus/ttt/v20606_ackermannControlExample.ttt");
    place.tatu(&["convert", file.to_str().unwrap(), "scene.toml"]).good();
    let scene = place.read("scene.toml");
    let joints = scene.matches("kind = \"joint\"").count();
    assert!(joints > 0);
    assert_eq!(scene.matches("smooth_target = false").count(), joints);
}

/// A file that is truncated or has flipped bits is read, or refused with an offset, but never crashes the program.
#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn damaged_files_are_refused() {
    let smallest = files().into_iter().min_by_key(|f| fs::metadata(f).unwrap().len()).unwrap();
    let whole = fs::read(&smallest).unwrap();
    let place = TestFolder::new();
    for i in 0..60 {
        let mut bytes = whole.clone();
        let at = (i * 7919 + 31) % whole.len();
        if i % 2 == 0 {
            bytes.truncate(at);
        } else {
            bytes[at] ^= 1 << (i % 8);
        }
        let name = if smallest.extension().is_some_and(|x| x == "ttm") { "d.ttm" } else { "d.ttt" };
        fs::write(place.path().join(name), &bytes).unwrap();
        let done = place.tatu(&["check", name]);
        assert!(matches!(done.code, 0 | 2), "{at}: exit {}\n{}", done.code, done.err);
        assert!(!done.err.contains("panicked"), "{at}: {}", done.err);
    }
}

const RING: &str = "
local robots = {}
function sysCall_init()
    for _, s in ipairs(sim.getObjectsInTree(sim.handle_scene, sim.object_proximitysensor_type)) do
        if sim.getObjectAlias(s):find('ultrasonic') then
            local top = s
            while sim.getObjectParent(top) ~= -1 do top = sim.getObjectParent(top) end
            if not robots[top] then
                robots[top] = {}
                robots[#robots + 1] = top
            end
            table.insert(robots[top], s)
        end
    end
    for i, top in ipairs(robots) do
        local p = sim.getObjectPosition(top, -1)
        sim.setObjectPosition(top, -1, {500 + 20 * i, 500, p[3]})
    end
end
local function seen(top)
    local count, nearest, farthest = 0, math.huge, 0
    for _, s in ipairs(robots[top]) do
        local result, distance = sim.handleProximitySensor(s)
        if result == 1 then
            count, nearest, farthest = count + 1, math.min(nearest, distance), math.max(farthest, distance)
        end
    end
    return count, nearest, farthest
end
function sysCall_sensing()
    if done then return end
    done = true
    local free = {}
    for i, top in ipairs(robots) do
        free[i] = seen(top)
    end
    -- A ring of walls, 0.3 m from a robot that is about 0.5 m long.
    for i = 1, #robots do
        for k = 0, 3 do
            local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {2, 0.1, 1})
            sim.setObjectInt32Param(wall, sim.shapeintparam_respondable, 0)
            sim.setObjectSpecialProperty(wall, sim.objectspecialproperty_detectable)
            local angle = k * math.pi / 2
            sim.setObjectPosition(wall, -1, {500 + 20 * i - 0.6 * math.sin(angle), 500 + 0.6 * math.cos(angle), 0.3})
            sim.setObjectOrientation(wall, -1, {0, 0, angle})
        end
    end
    for i, top in ipairs(robots) do
        print(string.format('SONARS %d %d %d %.3f %.3f', #robots[top], free[i], seen(top)))
    end
end
";

/// A robot's sonars detect a wall but not the robot's own shell, for files of all versions, which store the detectable
/// objects and the minimum distance in different ways.
#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn sonars_of_pioneers_see_walls_and_not_themselves() {
    let mut robots = 0;
    for file in files() {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        if !fs::read(file.with_extension("expected.json")).unwrap().windows(10).any(|w| w == b"ultrasonic") {
            continue;
        }
        let place = TestFolder::new();
        place.tatu(&["convert", file.to_str().unwrap(), "scene.toml"]).good();
        let text = fs::read_to_string(place.path().join("scene.toml")).unwrap();
        let kept: Vec<&str> =
            text.lines().filter(|l| !l.starts_with("script =") && !l.starts_with("scripts =")).collect();
        let driver = "[[object]]\nkind = \"dummy\"\nalias = \"measuring\"\nscript = { file = \"ring.lua\", dialect = \"4.9\" }\n";
        place.write("scene.toml", &format!("{}\n{driver}", kept.join("\n")));
        place.write("ring.lua", RING);
        let done = place.tatu(&["run", "scene.toml", "--steps", "3", "--no-addons"]).good();
        for line in done.out.lines().chain(done.err.lines()).filter_map(|l| l.split_once("SONARS ")) {
            let numbers: Vec<f64> = line.1.split(' ').map(|x| x.parse().unwrap()).collect();
            let [all, free, seen, nearest, farthest] = numbers[..] else { panic!("{name}: {}", line.1) };
            assert_eq!((free, seen), (0.0, all), "{name}: {}", line.1);
            assert!(nearest > 0.2 && farthest < 0.8, "{name}: {}", line.1);
            robots += 1;
        }
    }
    assert!(robots >= 10, "{robots} robots");
}
