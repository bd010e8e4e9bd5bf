//! Tests of what the SDF importer makes of elements that have no equal counterpart, and what it says about them.

use super::sdf::{close, figures, link, sdf};
use crate::kit::*;

/// Checks a model of these elements, which is accepted with these words.
fn reported(elements: &str, words: &[&str]) -> TestFolder {
    let place = TestFolder::new();
    place.write("m.sdf", &sdf("1.9", elements));
    place.tatu(&["check", "m.sdf"]).good().reports(words);
    place
}

#[test]
fn collisions_without_bits_are_left_out() {
    let collision = |name: &str, bits: &str| {
        format!(
            "<collision name=\"{name}\"><geometry><box><size>1 1 1</size></box></geometry><surface><contact>\
             <collide_bitmask>{bits}</collide_bitmask></contact></surface></collision>"
        )
    };
    let body = |inner: &str| format!("<link name=\"l\"><pose>0 0 3 0 0 0</pose>{inner}</link>");
    // On a floor, only what collides comes to rest.
    let falls = |inner: &str| {
        let place = TestFolder::new();
        place.write("m.sdf", &sdf("1.9", &body(inner)));
        place.write("s.toml", "format = 1\n[[object]]\nkind = \"shape\"\nprimitive = \"plane\"\nalias = \"floor\"\nrespondable = true\n[[import]]\nfile = \"m.sdf\"\n");
        place.tatu(&["run", "s.toml", "--seconds", "2", "--trace", "t.jsonl", "--watch", "/m"]).good();
        place.lines("t.jsonl").pop().unwrap().object::<3>("/m", "position")[2]
    };
    reported(&body(&collision("c", "0x00")), &["m.sdf: line 4: ", "the bits of a collision, `0x00`", "it is left out"]);
    reported(&body(&collision("c", "0x01")), &["m.sdf: line 4: ", "`0x01`", "it collides with everything"]);
    assert!(falls(&collision("c", "0x00")) < -5.0);
    // The link is 3 m above the frame of the model.
    assert!((falls(&collision("c", "0x01")) + 2.5).abs() < 0.01);
}

#[test]
fn computed_inertias_have_the_stated_mass() {
    let cube = "<collision name='c'><geometry><box><size>1 2 3</size></box></geometry></collision>";
    let found =
        figures(&sdf("1.12", &format!("<link name='l'><inertial auto='true'><mass>6</mass></inertial>{cube}</link>")));
    let body = &found["bodies"]["/m"];
    close(&[body["mass_kg"].as_f64().unwrap()], &[6.0]);
    // Those of a box of 6 kg: m / 12 times the squares of two edges.
    let moments: Vec<f64> = (0..3).map(|i| body["inertia_kg_m2"][i][i].as_f64().unwrap()).collect();
    close(&moments, &[6.5, 5.0, 2.5]);
}

#[test]
fn cameras_have_the_pose_in_their_sensor() {
    let sensor = "<sensor name='eye' type='camera'><pose>1 0 0 0 0 0</pose><camera><pose>0 2 0 0 0 0</pose>\
                  <horizontal_fov>4</horizontal_fov><distortion><k1>.1</k1></distortion>\
                  <image><width>99999</width><height>10</height></image></camera></sensor>";
    let words = [
        "the field of view (rad) of `eye` is 3.1 here, not 4",
        "the width in pixels of `eye` is 8192 here, not 99999",
        "the distortion of the camera `eye` is not read",
    ];
    let body = |sensor: &str| link("l", "0 0 0 0 0 0").replace("</link>", &format!("{sensor}</link>"));
    let place = reported(&body(sensor), &words);
    place.write("m.sdf", &sdf("1.9", &body(&sensor.replace("99999", "10"))));
    place.tatu(&["run", "m.sdf", "--steps", "1", "--trace", "t.jsonl", "--watch", "/m/l/eye"]).good();
    let line = place.lines("t.jsonl").pop().unwrap();
    // It falls with its link.
    close(&line.object::<3>("/m/l/eye", "position")[..2], &[1.0, 2.0]);
}

#[test]
fn broken_descriptions_of_models_are_reported() {
    let place = TestFolder::new();
    place.write("cube/model.config", "<model><sdf>cube.sdf</model>");
    place.write("cube/model.sdf", &sdf("1.9", &link("l", "0 0 0 0 0 0")));
    place.write("w.sdf", "<sdf version='1.9'><world name='w'>\n<include><uri>cube</uri></include></world></sdf>");
    place.tatu(&["check", "w.sdf"]).good().reports(&["w.sdf: line 2: `cube/model.config` cannot be read"]);
}

#[test]
fn meshes_that_a_shape_does_not_use_are_reported() {
    let place = TestFolder::scene("[[object]]\nkind = \"shape\"\nalias = \"it\"\nmesh = \"a.obj\"\n");
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    place
        .tatu(&["check", "scene.toml"])
        .good()
        .reports(&["the mesh of the shape `it` is not used", "primitive = \"mesh\""]);
}
