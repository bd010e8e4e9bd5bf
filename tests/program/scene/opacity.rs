//! Tests of translucent shapes and of the colours of their parts: images of vision sensors, commands of both dialects,
//! scene files, imported files.

use crate::kit::*;

/// A red pane 1 m below a camera that looks down, and a white floor 2 m below it.
const SCENE: &str = r#"
[[object]]
kind = "shape"
alias = "pane"
size_m = [4, 4, 0.1]
position_m = [0, 0, 0.95]
color = [1, 0, 0]

[[object]]
kind = "shape"
alias = "floor"
size_m = [9, 9, 0.2]
position_m = [0, 0, -0.1]
color = [1, 1, 1]

[[object]]
kind = "sensor"
alias = "eye"
sensor = "depth_camera"
columns = 8
rows = 8
perspective_angle_deg = 60
near_m = 0.1
far_m = 5
position_m = [0, 0, 2]
orientation_deg = [180, 0, 0]
script = { file = "eye.lua", DIALECT }
"#;

/// Compares the images for three opacities: with a quarter of red, each channel is a quarter of that of the opaque pane
/// and three quarters of that of the bare floor. The depth is that of the pane, at 1 m of 0.1 to 5 m. Scripts of the
/// older dialect run from top to bottom in each step, so `seen` is global.
const CHECK: &str = r"
values, seen = {1, 0, 0.25}, seen or {}
function check(image, depth)
    seen[#seen + 1] = {image(1), image(2), image(3)}
    assert(math.abs(depth - 0.9 / 4.9) < 1e-5, depth)
    if #seen < 3 then return values[#seen + 1] end
    for i = 1, 3 do
        local wanted = 0.25 * seen[1][i] + 0.75 * seen[2][i]
        assert(math.abs(seen[3][i] - wanted) <= 1.5 / 255, seen[3][i] .. ' for ' .. wanted)
    end
    assert(seen[1][1] > 0.5 and seen[1][2] == 0 and seen[2][2] > 0.5)
    print('mixed by opacity')
end
";

fn mixes(dialect: &str, script: &str) {
    let place = TestFolder::scene(&SCENE.replace("DIALECT", dialect));
    place.write("eye.lua", &format!("{CHECK}{script}"));
    let done = place.tatu(&["run", "scene.toml", "--steps", "4"]).good();
    assert!(done.out.contains("mixed by opacity") || done.err.contains("mixed by opacity"), "{}", done.err);
}

#[test]
fn transparency_of_the_newer_dialect_is_the_opacity() {
    mixes(
        "dialect = \"4.1\"",
        r"
function sysCall_sensing()
    if #seen == 3 then return end
    local eye, pane = sim.getObject('/eye'), sim.getObject('/pane')
    local image, depth = sim.getVisionSensorImg(eye), sim.getVisionSensorDepthBuffer(eye)
    if type(depth) == 'string' then depth = sim.unpackFloatTable(depth) end
    local value = check(function(i) return image:byte(i) / 255 end, depth[1])
    if not value then return end
    sim.setShapeColor(pane, nil, sim.colorcomponent_transparency, {value})
    local result, back = sim.getShapeColor(pane, nil, sim.colorcomponent_transparency)
    assert(result == 1 and back[1] == value)
    assert(sim.getObjectColor(pane, 0, sim.colorcomponent_transparency)[1] == value)
end",
    );
}

#[test]
fn transparency_of_the_older_dialect_is_the_opacity() {
    mixes(
        "dialect = \"3.2\"",
        r"
if sim_call_type == sim_childscriptcall_sensing and #seen < 3 then
    local eye, pane = simGetObjectHandle('eye'), simGetObjectHandle('pane')
    local image, depth = simGetVisionSensorImage(eye), simGetVisionSensorDepthBuffer(eye)
    local value = check(function(i) return image[i] end, depth[1])
    if value then
        simSetShapeColor(pane, nil, sim_colorcomponent_transparency, {value})
        local result, back = simGetShapeColor(pane, nil, sim_colorcomponent_transparency)
        assert(result == 1 and back[1] == value)
    end
end",
    );
}

/// Returns the scene that a file is converted to.
pub fn converted(name: &str, bytes: &[u8]) -> String {
    let place = TestFolder::new();
    std::fs::write(place.path().join(name), bytes).unwrap();
    place.tatu(&["convert", name, "converted.toml"]).good();
    place.read("converted.toml")
}

#[test]
fn opacities_of_shapes_and_parts_are_converted() {
    let scene = "[[object]]\nkind = \"shape\"\nalias = \"s\"\nprimitive = \"compound\"\nopacity = 0.5\n\
                 parts = [{ primitive = \"box\", opacity = 0.25 }, { primitive = \"sphere\" }]\n";
    let text = converted("scene.toml", format!("format = 1\n{scene}").as_bytes());
    assert!(text.contains("opacity = 0.5") && text.contains("opacity = 0.25"), "{text}");
    assert_eq!(text.matches("opacity").count(), 2, "{text}");
    for (from, to) in [("opacity = 0.5", "opacity = 1.5"), ("opacity = 0.25", "opacity = -1")] {
        TestFolder::scene(&scene.replace(from, to)).run(&["--steps", "1"]).refused(&["opacity", "from 0 to 1"]);
    }
}

#[test]
fn opacity_of_urdf_files_is_imported() {
    let urdf = r#"<robot name="r"><link name="base"><visual><geometry><box size="1 1 1"/></geometry>
        <material name="glass"><color rgba="0.5 0.5 1 0.25"/></material></visual></link></robot>"#;
    let text = converted("glass.urdf", urdf.as_bytes());
    assert!(text.contains("opacity = 0.25"), "{text}");
    let text = converted("plain.urdf", urdf.replace("0.25", "1").as_bytes());
    assert!(!text.contains("opacity"), "{text}");
}

/// Appends a tag, the length, and the bytes of an element of a V-REP file.
pub fn element(tag: &str, bytes: Vec<u8>) -> Vec<u8> {
    [tag.as_bytes(), &(bytes.len() as i32).to_le_bytes(), &bytes].concat()
}

pub fn singles(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Returns the part of a mesh that is red: a tetrahedron whose first corner is at `x`.
fn tetrahedron(x: f32, translucent: bool, factor: f32) -> Vec<u8> {
    let flags = if translucent { 0 } else { 4 };
    let color = [element("Trf", singles(&[factor])), element("Var", vec![flags])];
    painted(x, &[[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]].concat(), color.concat())
}

/// Returns the same in any colour, whose other elements are `more`.
fn painted(x: f32, color: &[f32], more: Vec<u8>) -> Vec<u8> {
    let color = [element("Cl3", singles(color)), more, b"EOO".to_vec()];
    let indices: Vec<u8> = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2_i32].iter().flat_map(|i| i.to_le_bytes()).collect();
    let corners = [x, 0.0, 0.0, x + 1.0, 0.0, 0.0, x, 1.0, 0.0, x, 0.0, 1.0];
    let leaf = [element("Cl0", color.concat()), element("Ver", singles(&corners)), element("Ind", indices)];
    [element("Mas", singles(&[1.0])), b"NXT".to_vec(), leaf.concat(), b"EOO".to_vec()].concat()
}

/// Returns a V-REP scene of 4.1 with the given sections.
pub fn vrep_file(sections: Vec<u8>) -> Vec<u8> {
    let mut head = vec![0; 1021];
    head[..4].copy_from_slice(b"VREP");
    head[4..8].copy_from_slice(&25_i32.to_le_bytes());
    head[8..12].copy_from_slice(&25_i32.to_le_bytes());
    head[21..23].copy_from_slice(&40_100_u16.to_le_bytes());
    head[28] = 1;
    let sections = [sections, b"EOF".to_vec()].concat();
    head[13..17].copy_from_slice(&(sections.len() as i32).to_le_bytes());
    [head, sections].concat()
}

/// Returns a V-REP scene with one shape.
fn ttt(root: Vec<u8>) -> Vec<u8> {
    let common = [
        element("Ids", [1_i32.to_le_bytes(), (-1_i32).to_le_bytes()].concat()),
        element("Nme", [5_i32.to_le_bytes().as_slice(), b"glass"].concat()),
        element("Cfq", singles(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])),
        b"NXT".to_vec(),
    ];
    let shape = [common.concat(), element("Ge2", [root, b"EOO".to_vec()].concat()), b"EOO".to_vec()].concat();
    vrep_file(element("SHP", shape))
}

#[test]
fn translucent_colours_of_vrep_scenes_are_imported() {
    // The factor is used only if the colour is translucent.
    let whole = |translucent| converted("glass.ttt", &ttt(element("Gst", tetrahedron(0.0, translucent, 0.25))));
    let text = whole(true);
    assert!(text.contains("\nopacity = 0.25"), "{text}");
    assert!(!whole(false).contains("opacity"));
    // Parts with different opacities have their own.
    let parts = [element("Geo", tetrahedron(0.0, true, 0.25)), element("Geo", tetrahedron(2.0, false, 0.25))];
    let compound = [element("Mas", singles(&[1.0])), parts.concat(), b"EOO".to_vec()].concat();
    let text = converted("glass.ttt", &ttt(element("Gsg", compound)));
    assert!(text.contains("opacity = 0.25") && text.contains("opacity = 1"), "{text}");
    assert!(!text.contains("\nopacity"), "{text}");
}

/// Returns a part of a mesh with a named colour.
fn named(x: f32, rgb: [f32; 3], name: &str) -> Vec<u8> {
    let name = [(name.len() as i32).to_le_bytes().as_slice(), name.as_bytes()].concat();
    painted(x, &[rgb, [0.0; 3], [0.0; 3], [0.0; 3]].concat(), [element("Var", vec![4]), element("Cnm", name)].concat())
}

fn compound(parts: &[Vec<u8>]) -> Vec<u8> {
    let parts: Vec<u8> = parts.iter().flat_map(|part| element("Geo", part.clone())).collect();
    element("Gsg", [element("Mas", singles(&[1.0])), parts, b"EOO".to_vec()].concat())
}

/// Converts a V-REP scene, adds a script, and runs it; returns what it prints.
fn run_with_script(file: &[u8], script: &str, steps: &str) -> String {
    let place = TestFolder::new();
    std::fs::write(place.path().join("glass.ttt"), file).unwrap();
    place.tatu(&["convert", "glass.ttt", "scene.toml"]).good();
    let text = format!("{}\n{}", place.read("scene.toml"), watcher("painter", script));
    place.write("scene.toml", &text);
    let done = place.tatu(&["run", "scene.toml", "--steps", steps]).good();
    format!("{}{}", done.out, done.err)
}

#[test]
fn one_colour_of_a_vrep_shape_is_that_of_the_shape() {
    let red = [1.0, 0.0, 0.0];
    for root in [element("Gst", named(0.0, red, "")), compound(&[named(0.0, red, "A"), named(2.0, red, "B")])] {
        let text = converted("glass.ttt", &ttt(root.clone()));
        assert!(text.contains("\ncolor = [1.0, 0.0, 0.0]"), "{text}");
        assert_eq!(text.matches("color = ").count(), 1, "{text}");
        let out = run_with_script(
            &ttt(root),
            "function sysCall_init()
                local sim = require 'sim'
                local shape = sim.getObject('/glass')
                local r, rgb = sim.getShapeColor(shape, nil, sim.colorcomponent_ambient_diffuse)
                assert(r == 1 and rgb[1] == 1 and rgb[2] == 0)
                sim.setShapeColor(shape, nil, sim.colorcomponent_ambient_diffuse, {0, 1, 0})
                r, rgb = sim.getShapeColor(shape, nil, sim.colorcomponent_ambient_diffuse)
                assert(rgb[1] == 0 and rgb[2] == 1)
                print('painted')
            end",
            "1",
        );
        assert!(out.contains("painted"), "{out}");
    }
}

#[test]
fn parts_of_a_vrep_shape_are_painted_by_the_names_of_their_colours() {
    let root = compound(&[
        named(0.0, [1.0, 0.0, 0.0], "BODY"),
        named(2.0, [0.0, 0.0, 1.0], "LAMP"),
        named(4.0, [0.0, 0.0, 1.0], "LAMP"),
    ]);
    let text = converted("glass.ttt", &ttt(root.clone()));
    assert!(!text.contains("\ncolor"), "{text}");
    assert_eq!(text.matches("color = ").count(), 3, "{text}");
    let out = run_with_script(
        &ttt(root),
        "function sysCall_init()
            local sim = require 'sim'
            local shape = sim.getObject('/glass')
            local function is(name, r, g, b)
                local _, c = sim.getShapeColor(shape, name, 0)
                assert(c[1] == r and c[2] == g and c[3] == b, name)
            end
            is(nil, 1, 0, 0) is('LAMP', 0, 0, 1)
            sim.setShapeColor(shape, 'LAMP', 0, {1, 1, 0})
            is('BODY', 1, 0, 0) is('LAMP', 1, 1, 0)
            sim.setShapeColor(shape, 'LAMP', sim.colorcomponent_transparency, {0.5})
            local _, o = sim.getShapeColor(shape, 'LAMP', sim.colorcomponent_transparency)
            assert(o[1] == 0.5)
            _, o = sim.getShapeColor(shape, 'BODY', sim.colorcomponent_transparency)
            assert(o[1] == 1)
            local before = sim.changeEntityColor(shape, {0, 1, 0})
            is('BODY', 0, 1, 0) is('LAMP', 0, 1, 0)
            sim.restoreEntityColor(before)
            is('BODY', 1, 0, 0) is('LAMP', 1, 1, 0)
            sim.setShapeColor(shape, '@compound', 0, {0, 0, 0})
            is('BODY', 0, 0, 0) is('LAMP', 0, 0, 0) is(nil, 0, 0, 0)
            print('painted by name')
        end",
        "1",
    );
    assert!(out.contains("painted by name"), "{out}");
}

#[test]
fn images_show_the_new_colour_of_a_compound_with_coloured_parts() {
    let pane = "primitive = \"compound\"\nparts = [{ primitive = \"box\", size_m = [4, 4, 0.1], color = [1, 0, 0] }]";
    let scene = SCENE
        .replace("size_m = [4, 4, 0.1]", pane)
        .replacen("color = [1, 0, 0]\n\n", "\n\n", 1)
        .replace("DIALECT", "dialect = \"4.6\"");
    let place = TestFolder::scene(&scene);
    place.write(
        "eye.lua",
        "function sysCall_sensing()
            local pixel = {sim.getVisionSensorImg(sim.getObject('/eye')):byte(1, 3)}
            print(pixel[1] > 128 and 'red' or pixel[3] > 128 and 'blue' or 'else')
            sim.setShapeColor(sim.getObject('/pane'), nil, 0, {0, 0, 1})
        end",
    );
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    let shown = format!("{}{}", done.out, done.err);
    assert!(shown.contains("red") && shown.contains("blue") && !shown.contains("else"), "{shown}");
}
