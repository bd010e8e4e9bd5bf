//! Tests of `tatu export`, which writes robots and scenes as URDF and MJCF files.

use std::fs;

use serde_json::Value;

use crate::kit::*;

/// Returns the numbers of a file, read with these parameters of the importer.
fn numbers(place: &TestFolder, file: &str, set: &[&str]) -> Value {
    let mut args = vec!["check", file, "--numbers"];
    set.iter().for_each(|set| args.extend(["--set", set]));
    place.tatu(&args).good().json()
}

/// Returns the last part of a path.
fn name(path: &str) -> &str {
    path.rsplit('/').next().unwrap()
}

/// Requires that two sets of numbers are equal to 1e-9, except for what `skips` names.
fn assert_equal(a: &Value, b: &Value, place: &str, skips: &[&str]) {
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            assert!((x - y).abs() <= 1e-9 * x.abs().max(1.0), "{place}: {x} and {y}");
        }
        (Value::Array(x), Value::Array(y)) => {
            assert_eq!(x.len(), y.len(), "{place}");
            x.iter().zip(y).enumerate().for_each(|(i, (x, y))| assert_equal(x, y, &format!("{place}/{i}"), skips));
        }
        (Value::Object(x), Value::Object(y)) => {
            for (key, value) in x.iter().filter(|(key, _)| !skips.contains(&name(key))) {
                let found = y.iter().find(|(other, _)| name(other) == name(key));
                let (_, other) = found.unwrap_or_else(|| panic!("{place}: no {key}"));
                assert_equal(value, other, &format!("{place}/{key}"), skips);
            }
        }
        (Value::String(x), Value::String(y)) => assert_eq!(name(x), name(y), "{place}"),
        _ => assert_eq!(a, b, "{place}"),
    }
}

/// A robot with a fixed base: a hinge with everything that URDF states of it, a slide that mimics it, a fixed link.
const ARM: &str = r#"<robot name="arm">
  <link name="world"/>
  <joint name="foot" type="fixed"><parent link="world"/><child link="base"/><origin xyz="0 0 0.1"/></joint>
  <link name="base"><collision><geometry><box size="0.2 0.3 0.1"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0.1 0.2 0.3" rpy="0.4 1.2 -2.5"/>
    <axis xyz="0.3 -0.4 0.5"/><limit lower="-1.5" upper="2.25" effort="30" velocity="3"/><dynamics damping="0.7" friction="0.2"/></joint>
  <link name="upper">
    <inertial><origin xyz="0.01 0.02 0.3" rpy="0.1 0.2 0.3"/><mass value="2.5"/>
      <inertia ixx="0.04" ixy="0.001" ixz="-0.002" iyy="0.05" iyz="0.003" izz="0.03"/></inertial>
    <visual><origin xyz="0 0 0.3"/><geometry><cylinder radius="0.04" length="0.5"/></geometry>
      <material name="a &amp; &quot;b&quot;"><color rgba="1 0.5 0 0.5"/></material></visual>
    <collision><geometry><capsule radius="0.05" length="0.5"/></geometry></collision>
    <collision><origin xyz="0 0 0.6"/><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic"><parent link="upper"/><child link="finger"/><origin xyz="0 0 0.6" rpy="0 1.5707963267948966 0"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="8" velocity="0.5"/><mimic joint="turn" multiplier="0.25" offset="0.01"/></joint>
  <link name="finger"><inertial><mass value="0.3"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.0012" iyz="0" izz="0.0009"/></inertial></link>
  <joint name="tip_joint" type="fixed"><parent link="finger"/><child link="tip"/><origin xyz="0 0.05 0" rpy="0.5 0 0"/></joint>
  <link name="tip"/>
  <gazebo reference="upper"><mu1>0.6</mu1><mu2>0.6</mu2></gazebo>
</robot>"#;

#[test]
fn a_robot_has_the_same_numbers_after_export_as_urdf() {
    let place = TestFolder::new();
    place.write("arm.urdf", ARM);
    let told = place.tatu(&["export", "arm.urdf", "-o", "out/copy.urdf"]).good();
    assert!(told.out.contains("written: out/copy.urdf"), "{}", told.out);
    assert!(told.out.contains("URDF has no capsules: each is a cylinder and two spheres: /arm"), "{}", told.out);
    assert_equal(&numbers(&place, "arm.urdf", &[]), &numbers(&place, "out/copy.urdf", &[]), "", &[]);
    let text = place.read("out/copy.urdf");
    for words in [
        "<robot name=\"arm\">",
        "<limit lower=\"-1.5\" upper=\"2.25\" effort=\"30\" velocity=\"3\"/>",
        "<dynamics damping=\"0.7\" friction=\"0.2\"/>",
        "<mimic joint=\"turn\" multiplier=\"0.25\" offset=\"0.01\"/>",
        "<color rgba=\"1 0.5 0 0.5\"/>",
        "<mu1>0.6</mu1>",
        "<cylinder radius=\"0.05\" length=\"0.5\"/>",
    ] {
        assert!(text.contains(words), "{words} in\n{text}");
    }
    // Nothing is added each time.
    place.tatu(&["export", "out/copy.urdf", "-o", "again/copy.urdf"]).good();
    let elements = |file: &str| place.read(file).matches('<').count();
    assert_eq!(elements("again/copy.urdf"), elements("out/copy.urdf"));
}

#[test]
fn a_robot_has_the_same_numbers_after_export_as_mjcf() {
    let place = TestFolder::new();
    place.write("arm.urdf", ARM);
    let told = place.tatu(&["export", "arm.urdf", "-o", "copy.xml"]).good();
    assert!(told.out.contains("changed or left out: position control becomes a servo"), "{}", told.out);
    // MJCF does not hold the greatest speed of position control; the coupled joint has no motor of its own.
    let (a, b) = (numbers(&place, "arm.urdf", &[]), numbers(&place, "copy.xml", &["file.servos=hold"]));
    let mut first = a["joints"]["/arm/turn"].clone();
    first.as_object_mut().unwrap().remove("max_velocity");
    let turn = b["joints"].as_object().unwrap().iter().find(|(path, _)| name(path) == "turn").unwrap().1;
    assert_equal(&first, turn, "turn", &[]);
    assert_equal(&a["bodies"], &b["bodies"], "bodies", &[]);
    assert_equal(&a["total"], &b["total"], "total", &[]);
    // The zero about the axis of a joint is a matter of convention.
    let skips = ["turn", "slide", "world"];
    assert_equal(&a["configurations"], &b["configurations"], "configurations", &skips);
}

/// A floor, a loose ball, and a mechanism with a spring, a force-driven slide, a ball joint and a loop.
const MECHANISM: &str = r#"format = 1
[scene]
friction_rule = "greatest"
[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
size_m = [10.0, 20.0, 0.1]
respondable = true
[[object]]
kind = "shape"
alias = "ball"
primitive = "sphere"
size_m = [0.2, 0.2, 0.2]
position_m = [1.0, 2.0, 3.0]
dynamic = true
respondable = true
friction = 0.4
[[object]]
kind = "shape"
alias = "stand"
size_m = [0.3, 0.3, 0.4]
position_m = [0.0, 0.0, 0.2]
[[object]]
kind = "joint"
alias = "spring"
parent = "/stand"
type = "revolute"
position_m = [0.0, 0.0, 0.3]
orientation_deg = [90.0, 0.0, 0.0]
joint_position_rad = 0.25
control = "spring"
stiffness_nm_rad = 40.0
target_position_rad = 0.5
damping_nms_rad = 0.3
armature_kg_m2 = 0.01
limits_rad = [-1.0, 2.0]
[[object]]
kind = "shape"
alias = "lever"
parent = "/stand/spring"
size_m = [0.05, 0.4, 0.05]
position_m = [0.0, 0.2, 0.02]
dynamic = true
respondable = true
[[object]]
kind = "joint"
alias = "rail"
parent = "/stand/spring/lever"
type = "prismatic"
position_m = [0.0, 0.2, 0.0]
control = "force"
max_force_n = -1.5
dry_friction_n = 0.125
[[object]]
kind = "shape"
alias = "slider"
parent = "/stand/spring/lever/rail"
primitive = "capsule"
size_m = [0.04, 0.04, 0.2]
dynamic = true
[[object]]
kind = "dummy"
alias = "tool"
parent = "/stand/spring/lever/rail/slider"
position_m = [0.0, 0.0, 0.1]
[[object]]
kind = "joint"
alias = "socket"
parent = "/stand/spring/lever/rail/slider"
type = "spherical"
position_m = [0.0, 0.0, -0.1]
[[object]]
kind = "shape"
alias = "pendulum"
parent = "/stand/spring/lever/rail/slider/socket"
primitive = "cylinder"
size_m = [0.03, 0.03, 0.3]
position_m = [0.0, 0.0, -0.15]
dynamic = true
"#;

#[test]
fn a_scene_has_the_same_numbers_after_export_as_mjcf() {
    let place = TestFolder::new();
    place.write("scene.toml", MECHANISM);
    let told = place.tatu(&["export", "scene.toml", "-o", "scene.xml", "--strict"]).good();
    assert!(!told.out.contains("left out"), "{}", told.out);
    let text = place.read("scene.xml");
    for words in [
        "<geom name=\"floor\" type=\"plane\" size=\"5 10 1\"",
        "<freejoint/>",
        "<joint name=\"spring\" type=\"hinge\"",
        "<position name=\"spring\" joint=\"spring\" kp=\"40\"/>",
        "<motor name=\"rail\" joint=\"rail\"/>",
        "<joint name=\"socket\" type=\"ball\"",
        "<site name=\"tool\" pos=\"0 0 0.1\"/>",
        "friction=\"0.4\"",
        // Free ball, spring, rail, socket; then spring and rail.
        "<key name=\"home\" qpos=\"1 2 3 1 0 0 0 0.25 0 1 0 0 0\" ctrl=\"0.5 -1.5\"/>",
    ] {
        assert!(text.contains(words), "{words} in\n{text}");
    }
    let (a, b) = (numbers(&place, "scene.toml", &[]), numbers(&place, "scene.xml", &[]));
    assert_equal(&a["bodies"], &b["bodies"], "bodies", &[]);
    assert_equal(&a["joints"], &b["joints"], "joints", &["max_velocity"]);
    assert_equal(&a["configurations"], &b["configurations"], "configurations", &["spring", "rail", "socket"]);
}

#[test]
fn an_mjcf_file_has_the_same_numbers_after_export() {
    let place = TestFolder::new();
    fs::copy(root().join("plugins/importers/mjcf/quadruped.xml"), place.path().join("q.xml")).unwrap();
    place.tatu(&["export", "q.xml", "-o", "copy.xml"]).good();
    assert_equal(&numbers(&place, "q.xml", &[]), &numbers(&place, "copy.xml", &[]), "", &[]);
}

#[test]
fn meshes_are_written_beside_the_file_with_all_their_bits() {
    let place = TestFolder::new();
    for file in ["robot.urdf", "mast.stl"] {
        fs::copy(root().join("plugins/importers/urdf").join(file), place.path().join(file)).unwrap();
    }
    place.tatu(&["export", "robot.urdf", "-o", "out/r.urdf"]).good().reports(&[]);
    let meshes: Vec<_> = fs::read_dir(place.path().join("out/meshes")).unwrap().collect();
    assert_eq!(meshes.len(), 1, "{meshes:?}");
    assert_equal(&numbers(&place, "robot.urdf", &[]), &numbers(&place, "out/r.urdf", &[]), "", &[]);
    // Equal meshes are shared; other files are not overwritten.
    place.tatu(&["export", "robot.urdf", "-o", "out/r.xml"]).good();
    let mesh = fs::read_dir(place.path().join("out/meshes")).unwrap().next().unwrap().unwrap().path();
    fs::write(&mesh, "mine").unwrap();
    place.tatu(&["export", "robot.urdf", "-o", "out/new.urdf"]).refused(&["E105", ".obj exists", "`--overwrite`"]);
    assert!(!place.path().join("out/new.urdf").exists());
    assert_eq!(fs::read_to_string(&mesh).unwrap(), "mine");
    place.tatu(&["export", "robot.urdf", "-o", "out/new.urdf", "--overwrite"]).good();
    assert!(fs::read_to_string(&mesh).unwrap().starts_with("v "));
}

#[test]
fn losses_of_an_export_are_named_with_their_objects() {
    let place = TestFolder::scene(&pioneer("", ""));
    let told = place.tatu(&["export", "scene.toml", "-o", "p.urdf", "--object", "/Pioneer_p3dx"]).good();
    for words in [
        "changed or left out: scripts are left out: /Pioneer_p3dx",
        "changed or left out: sensors are left out, with their noise; their frames are links: /Pioneer_p3dx/",
        " and 11 more",
    ] {
        assert!(told.out.contains(words), "{words} in\n{}", told.out);
    }
    place.tatu(&["check", "p.urdf"]).good();
    place.tatu(&["export", "scene.toml", "-o", "q.urdf", "--strict"]).refused(&["E123", "kind(s) of parts"]);
    assert!(!place.path().join("q.urdf").exists());
}

#[test]
fn a_model_is_exported_by_its_name() {
    let place = TestFolder::new();
    place.tatu(&["export", "pioneer_p3dx", "-o", "p.urdf"]).good();
    assert!(place.read("p.urdf").contains("<robot name=\"Pioneer_p3dx\">"));
    place.tatu(&["export", "pioneer_p3dx", "-o", "p.xml"]).good();
    place.tatu(&["check", "p.xml"]).good();
}

#[test]
fn impossible_exports_are_refused_with_the_reason() {
    let place = TestFolder::new();
    let robot = |alias: &str| {
        let object = |kind: &str, alias: &str, parent: &str, more: &str| {
            format!("[[object]]\nkind = \"{kind}\"\nalias = \"{alias}\"\n{parent}{more}")
        };
        let below = |path: &str| format!("parent = \"/{alias}{path}\"\n");
        [
            object("shape", alias, "", "dynamic = true\n"),
            object("joint", "hip", &below(""), ""),
            object("shape", "leg", &below("/hip"), "dynamic = true\n"),
        ]
        .concat()
    };
    place.write("two.toml", &format!("format = 1\n{}{}", robot("a"), robot("b")));
    place.tatu(&["export", "two.toml", "-o", "x.urdf"]).refused(&["E127", "there are 2: /a, /b", "--object /path"]);
    place.tatu(&["export", "two.toml", "-o", "x.urdf", "--object", "/b"]).good();
    place.tatu(&["export", "two.toml", "-o", "x.urdf", "--object", "/c"]).refused(&["E110", "no object `/c`"]);
    place.tatu(&["export", "two.toml", "-o", "x.step"]).refused(&["E127", "no exporter writes", ".mjcf, .urdf, .xml"]);
    place.tatu(&["export", "two.toml", "-o", "x.toml"]).refused(&["E127", "`tatu convert` writes scene files"]);
    place.write("empty.toml", "format = 1\n");
    place.tatu(&["export", "empty.toml", "-o", "y.urdf"]).refused(&["E127", "no robot to export"]);
    place.tatu(&["export", "empty.toml", "-o", "y.xml"]).refused(&["E127", "the scene has no objects"]);
}

#[test]
fn odd_names_are_escaped_and_made_unique() {
    let place = TestFolder::new();
    let names = ["a \\\"<&>\\\" ü", "twin", "twin", "100%"];
    let mut text = "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"base\"\ndynamic = true\n".to_owned();
    for name in names {
        text += &format!(
            "[[object]]\nkind = \"dummy\"\nalias = \"{name}\"\nparent = \"/base\"\nposition_m = [0.0, 0.0, 1.0]\n"
        );
    }
    place.write("odd.toml", &text);
    for file in ["odd.urdf", "odd.xml"] {
        let told = place.tatu(&["export", "odd.toml", "-o", file]).good();
        assert!(told.out.contains("must differ: `twin` is `twin_2`"), "{}", told.out);
        let copy = numbers(&place, file, &[]);
        let poses = copy["configurations"][0]["poses"].as_object().unwrap();
        for name in ["a \"<&>\" ü", "twin", "twin_2", "100%"] {
            assert!(poses.keys().any(|path| path.ends_with(name)), "{name} in {poses:?}");
        }
    }
}

#[test]
fn ten_thousand_objects_are_exported() {
    let place = TestFolder::new();
    let mut text = "format = 1\n".to_owned();
    for i in 0..10_000 {
        text += &format!(
            "[[object]]\nkind = \"shape\"\nalias = \"s{i}\"\ndynamic = true\nposition_m = [{i}.0, 0.0, 0.0]\n"
        );
    }
    place.write("many.toml", &text);
    place.tatu(&["export", "many.toml", "-o", "many.xml"]).good();
    assert_eq!(place.read("many.xml").matches("<freejoint/>").count(), 10_000);
    place.tatu(&["export", "many.toml", "-o", "many.urdf"]).refused(&["there are 10000", "and 9980 more"]);
}

#[test]
fn a_script_exports_the_same_text_as_the_program() {
    let place = TestFolder::new();
    place.write("arm.urdf", ARM);
    place.tatu(&["export", "arm.urdf", "-o", "arm.xml"]).good();
    let script = "function sysCall_init()\n  local text, files, report = export.xml(nil, 'arm')\n  local file = \
                  io.open('script.xml', 'w')\n  file:write(text)\n  file:close()\n  assert(#report > 0 and report[1].text)\nend\n";
    place.write("main.lua", script);
    place.tatu(&["run", "arm.urdf", "--steps", "1", "--script", "/arm=main.lua"]).good().reports(&[]);
    // The script belongs to the scene, and is reported, but is no part of the text.
    assert_eq!(place.read("script.xml"), place.read("arm.xml"));
}

#[test]
fn an_exporter_in_c_is_found_by_its_suffix() {
    let place = plugin_sources::place("");
    let source = fs::read_to_string(root().join("tests/program/plugins/blocks_exporter.c")).unwrap();
    plugin_sources::compile(&place, "blocks", &source);
    let told = place.tatu(&["export", "scene.toml", "-o", "room.blocks", "--allow", "plugins"]).good();
    assert!(told.out.contains("changed or left out: masses are left out\n"), "{}", told.out);
    assert_eq!(place.read("room.blocks").lines().count(), 1);
    let arguments = ["export", "scene.toml", "-o", "b.blocks", "--allow", "plugins", "--strict"];
    place.tatu(&arguments).refused(&["E123"]);
    assert!(!place.path().join("b.blocks").exists());
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    let place = TestFolder::new();
    let mesh = "[[object]]\nkind = \"shape\"\nprimitive = \"mesh\"\nmesh = \"m.obj\"\n";
    place.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    place.write("s.toml", &format!("format = 1\n{mesh}")).write("far/kept.txt", "kept").write("out/a", "");
    let out = |name: &str| place.path().join("out").join(name);
    std::os::unix::fs::symlink(place.path().join("far"), out("meshes")).unwrap();
    place.tatu(&["export", "s.toml", "-o", "out/s.xml", "--overwrite"]).refused(&["E105", "out/meshes is a link"]);
    fs::remove_file(out("meshes")).unwrap();
    std::os::unix::fs::symlink(place.path().join("far/kept.txt"), out("s.xml")).unwrap();
    place.tatu(&["export", "s.toml", "-o", "out/s.xml", "--overwrite"]).refused(&["E105", "out/s.xml is a link"]);
    assert_eq!(fs::read_to_string(place.path().join("far/kept.txt")).unwrap(), "kept");
    assert_eq!(fs::read_dir(place.path().join("far")).unwrap().count(), 1);
}
