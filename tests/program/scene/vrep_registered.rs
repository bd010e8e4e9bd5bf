//! Tests of what V-REP scenes contain in addition to their objects, and what the importer stores with the scene:
//! collections, collision and distance objects, windows with buttons.

use crate::kit::*;

const SCENE: &str = r#"format = 1
[scene]
data = { "\u0001registered" = '{"collections":[{"name":"Boxes","handle":2000000,"items":[{"object":-1,"kind":5,"remove":false},{"object":7,"kind":0,"remove":true}]}],"collisions":[{"name":"Touch","handle":2010000,"of":[7,2000000],"threshold":0.0,"explicit":false}],"distances":[{"name":"Gap","handle":2020000,"of":[7,8],"threshold":0.0,"explicit":true}],"ik_groups":[{"name":"Arm","handle":2030000,"elements":[]}],"windows":[{"name":"Panel","handle":2060000,"object":7,"attributes":1,"cells":[4,2],"buttons":[{"handle":3,"attributes":2,"cells":[1,1,0,0],"labels":["on",""],"slider":-0.5}]}]}' }

[[object]]
kind = "shape"
alias = "ball"
primitive = "sphere"
size_m = [0.2, 0.2, 0.2]
position_m = [0, 0, 1]
data = { "\u0001handle" = "7" }
script = { file = "ball.lua", dialect = "3.2" }

[[object]]
kind = "shape"
alias = "box"
size_m = [0.2, 0.2, 0.2]
position_m = [1, 0, 1]
data = { "\u0001handle" = "8" }

[[object]]
kind = "path"
alias = "way"
points = [0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 1]
rounding = [0.9, 0.9, 10, 0.9, 0.9, 10, 0.9, 0.9, 10]

[[object]]
kind = "light"
alias = "lamp"
color = [0.25, 0.5, 1.0]

[[object]]
kind = "camera"
alias = "view"
"#;

const SCRIPT: &str = r"
if sim_call_type == sim_childscriptcall_initialization then
    local ball, box = simGetObjectHandle('ball'), simGetObjectHandle('box')
    local all = simGetCollectionObjects(simGetCollectionHandle('Boxes'))
    for _, o in ipairs(all) do assert(o ~= ball) end
    assert(#all == 4)

    local touch = simGetCollisionHandle('Touch')
    assert(simReadCollision(touch) == 0)
    simSetObjectPosition(box, -1, {0.15, 0, 1})
    local state, pair = simReadCollision(touch)
    assert(state == 1 and (pair[1] == box or pair[2] == box))

    local gap = simGetDistanceHandle('Gap')
    assert(simReadDistance(gap) == 0, 'explicit, and never handled')
    simSetObjectPosition(box, -1, {1, 0, 1})
    local r, d = simHandleDistance(gap)
    assert(r == 1 and math.abs(d - 0.8) < 1e-6)
    r, d = simReadDistance(gap)
    assert(r == 1 and math.abs(d - 0.8) < 1e-6)
    simResetDistance(sim_handle_all)
    assert(simReadDistance(gap) == 0)

    assert(simGetIkGroupHandle('Arm') == 2030000)

    local panel = simGetUIHandle('Panel')
    assert(simGetUIButtonLabel(panel, 3) == 'on' and simGetUISlider(panel, 3) == 250)
    simSetUIButtonLabel(panel, 3, nil, 'off')
    assert(simGetUIButtonLabel(panel, 3) == 'on')

    local way = simGetObjectHandle('way')
    assert(simGetObjectType(way) == sim_object_path_type)
    local length = simGetPathLength(way)
    assert(length > 1.6 and length < 1.95, 'the corner is rounded')

    assert(simGetObjectType(simGetObjectHandle('lamp')) == sim_object_light_type)
    local on, _, diffuse = simGetLightParameters(simGetObjectHandle('lamp'))
    assert(on == 1 and diffuse[1] == 0.25 and diffuse[3] == 1)
    assert(simGetObjectType(simGetObjectHandle('view')) == sim_object_camera_type)
    simAddStatusbarMessage('all is there')
end
";

#[test]
fn registered_objects_of_a_scene_are_found_by_scripts() {
    let place = TestFolder::scene("");
    place.write("scene.toml", SCENE).write("ball.lua", SCRIPT);
    let said = |args: &[&str]| {
        let done = place.tatu(args).good();
        format!("{}{}", done.out, done.err)
    };
    assert!(said(&["run", "scene.toml", "--steps", "2"]).contains("all is there"));
    // The registered objects are part of a saved scene.
    said(&["run", "scene.toml", "--steps", "2", "--save", "again.toml"]);
    assert!(said(&["run", "again.toml", "--steps", "2"]).contains("all is there"));
}
