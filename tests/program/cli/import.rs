//! Tests of `tatu import`, which writes a model, and of the numbers that `tatu check --numbers` prints.

use std::fs;

use serde_json::Value;

use crate::kit::*;

/// Copies the robot of the URDF importer and its mesh.
fn robot(place: &TestFolder) {
    for file in ["robot.urdf", "mast.stl"] {
        fs::copy(root().join("plugins/importers/urdf").join(file), place.path().join(file)).unwrap();
    }
}

/// Returns the numbers of a file.
fn numbers(place: &TestFolder, file: &str) -> Value {
    place.tatu(&["check", file, "--numbers"]).good().json()
}

#[test]
fn an_imported_model_has_the_numbers_of_its_source() {
    let place = TestFolder::new();
    robot(&place);
    let told = place.tatu(&["import", "robot.urdf", "-o", "models/mine"]).good();
    for words in ["taken: 3 moving bodies of", "2 joints, 2 motors", "written: models/mine/model.toml"] {
        assert!(told.out.contains(words), "{}", told.out);
    }
    assert_eq!(numbers(&place, "models/mine/model.toml"), numbers(&place, "robot.urdf"));
    assert!(place.read("models/mine/README.md").contains("taken: 3 moving bodies"));
    // The model needs neither the file nor its meshes, and is found by its name.
    fs::remove_file(place.path().join("robot.urdf")).unwrap();
    fs::remove_file(place.path().join("mast.stl")).unwrap();
    place.write("scene.toml", "format = 1\n[[model]]\nmodel = \"mine\"\n");
    place.tatu(&["check", "scene.toml"]).good();
    // What is there is not overwritten.
    robot(&place);
    place.tatu(&["import", "robot.urdf", "-o", "models/mine"]).refused(&["E105", "models/mine exists"]);
}

/// A model refers to its objects by name, so a link with the name of a joint gets another one.
#[test]
fn objects_of_a_written_model_have_different_names() {
    let place = TestFolder::new();
    let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
    let part = |name: &str, parent: &str| {
        format!(
            "<link name=\"{name}\">{inertial}</link><joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/>\
             <child link=\"{name}\"/></joint>"
        )
    };
    let text = [part("a", "world"), part("b", "a")].concat();
    place.write("r.urdf", &format!("<robot name=\"r\"><link name=\"world\"/>{text}</robot>"));
    place.tatu(&["import", "r.urdf", "-o", "r"]).good().reports(&["2 objects with the name of another one"]);
    place.tatu(&["check", "r/model.toml"]).good();
    let paths = numbers(&place, "r/model.toml")["bodies"].as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(paths, ["/r/a/a_link", "/r/a/a_link/b/b_link"]);
}

#[test]
fn strict_import_of_a_damaged_file_is_an_error() {
    let place = TestFolder::new();
    let text = "<robot name=\"r\"><link name=\"world\"><visual><geometry><box size=\"0 1 1\"/></geometry></visual></link></robot>";
    place.write("r.urdf", text);
    let told = place.tatu(&["import", "r.urdf", "-o", "out"]).good();
    assert!(told.out.contains("changed or left out: line 1: visual of the link `world`"), "{}", told.out);
    place.tatu(&["import", "r.urdf", "-o", "strict", "--strict"]).refused(&["E123", "1 part(s) of the file"]);
    assert!(!place.path().join("strict").exists());
}

#[test]
fn numbers_are_those_of_the_file() {
    let place = TestFolder::new();
    // Two boxes on rails: one of 2 kg whose joint ends at 0.5 m, and one of 1 kg that follows it twice as far.
    let link = |name: &str, mass: f64| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 0.25\"/><mass value=\"{mass}\"/><inertia ixx=\"1\" \
             ixy=\"0\" ixz=\"0\" iyy=\"2\" iyz=\"0\" izz=\"2\"/></inertial></link>"
        )
    };
    let joint = |name: &str, more: &str| {
        format!(
            "<joint name=\"{name}_rail\" type=\"prismatic\"><parent link=\"world\"/><child link=\"{name}\"/><axis \
             xyz=\"1 0 0\"/><limit lower=\"0\" upper=\"0.5\" effort=\"3\" velocity=\"2\"/>{more}</joint>"
        )
    };
    let follows = joint("b", "<mimic joint=\"a_rail\" multiplier=\"2\"/>");
    let text = [link("a", 2.0), link("b", 1.0), joint("a", ""), follows].concat();
    place.write("r.urdf", &format!("<robot name=\"r\"><link name=\"world\"/>{text}</robot>"));
    let all = numbers(&place, "r.urdf");
    let at = |path: &str| all.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {path} in {all}"));
    assert_eq!(at("/total/mass_kg"), 3.0);
    assert_eq!(at("/total/com_m/2"), 0.25);
    // Both centres of mass are in one place, so the moments are the sums.
    assert_eq!([at("/total/inertia_kg_m2/0/0"), at("/total/inertia_kg_m2/1/1")], [2.0, 4.0]);
    assert_eq!(at("/bodies/~1r~1a_rail~1a/mass_kg"), 2.0);
    assert_eq!(at("/joints/~1r~1a_rail/max_force"), 3.0);
    assert_eq!(at("/joints/~1r~1b_rail/follow_factor"), 2.0);
    // In the second configuration, joints are at a quarter of their range.
    assert_eq!(at("/configurations/1/positions/~1r~1a_rail"), 0.125);
    assert_eq!(at("/configurations/1/positions/~1r~1b_rail"), 0.25);
    assert!((at("/configurations/1/poses/~1r~1b_rail~1b/0") - 0.25).abs() < 1e-15);
}
