//! Tests of robots in URDF files as people publish them: in packages, with flaws, without efforts.

use std::fs;

use super::urdf::cube;
use crate::kit::*;

/// An inertial of 1 kg.
const INERTIAL: &str = "<inertial><mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" \
                        izz=\"0.01\"/></inertial>";

/// A floor at a height of 0.
const FLOOR: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";

/// Returns a robot of one fixed link that is seen as a mesh.
fn seen(mesh: &str) -> String {
    format!(
        "<robot name=\"r\">\n<link name=\"world\">\n<visual><geometry><mesh filename=\"{mesh}\"/></geometry></visual>\
         </link></robot>"
    )
}

/// Writes a package with a robot and a mesh, beside another package with a mesh.
fn packages(place: &TestFolder, mesh: &str) {
    place.write("src/arm/package.xml", "<package><name>arm_description</name></package>");
    place.write("src/arm/urdf/arm.urdf", &seen(mesh));
    place.write("src/other/package.xml", "<package><name>other_meshes</name></package>");
    place.write("far/group/third/package.xml", "<package><name>third</name></package>");
    place.write("src/arm/scripts/run.lua", "print('secret')").write("src/.ssh/id_rsa.stl", "secret");
    for folder in ["src/arm/meshes", "src/other/meshes", "far/group/third/meshes", "empty"] {
        fs::create_dir_all(place.path().join(folder)).unwrap();
        fs::write(place.path().join(folder).join("part.stl"), cube([0.0; 3])).unwrap();
    }
}

/// Checks the robot from a folder that contains none of its files.
fn check(place: &TestFolder, args: &[&str], env: &[(&str, &str)]) -> RunOutput {
    let file = place.path().join("src/arm/urdf/arm.urdf");
    let args = [&["check", file.to_str().unwrap()], args].concat();
    run(program(), &place.path().join("empty"), &args, env).good()
}

#[test]
fn packages_are_found_from_any_folder() {
    let place = TestFolder::new();
    for mesh in [
        "package://arm_description/meshes/part.stl",
        "package://other_meshes/meshes/part.stl",
        // Some files name the folder instead of the package.
        "package://arm/meshes/part.stl",
        "package:\\\\arm_description\\meshes\\part.stl",
        "../meshes/part.stl",
    ] {
        packages(&place, mesh);
        let told = check(&place, &[], &[]);
        assert!(!told.err.contains("warning"), "{mesh}: {}", told.err);
    }
    // Capitals that differ are told.
    packages(&place, "package://arm_description/Meshes/Part.stl");
    check(&place, &[], &[]).reports(&["`meshes/part.stl`", "with other capitals"]);
    // The message about a missing file names one with the same name; that about a package, how to find it.
    packages(&place, "package://arm_description/visual/part.stl");
    check(&place, &[], &[]).reports(&["does not exist in", "there is `meshes/part.stl`"]);
    packages(&place, "package://third/meshes/part.stl");
    check(&place, &[], &[]).reports(&[
        "the package `third` was not found above the file",
        "--package-path",
        "TATU_PACKAGE_PATH",
    ]);
    let far = place.path().join("far").display().to_string();
    for told in [
        check(&place, &["--package-path", &far], &[]),
        check(&place, &[], &[("ROS_PACKAGE_PATH", &far)]),
        check(&place, &[], &[("TATU_PACKAGE_PATH", &far)]),
    ] {
        assert!(!told.err.contains("warning"), "{}", told.err);
    }
}

#[test]
fn only_meshes_and_images_of_packages_are_read() {
    let place = TestFolder::new();
    fs::write(place.path().join("secret.stl"), cube([0.0; 3])).unwrap();
    packages(&place, "");
    #[cfg(unix)]
    std::os::unix::fs::symlink(place.path().join("secret.stl"), place.path().join("src/arm/meshes/link.stl")).unwrap();
    #[cfg(unix)]
    for (link, target) in [("key.stl", "../scripts/run.lua"), ("hidden.stl", "../../.ssh/id_rsa.stl")] {
        std::os::unix::fs::symlink(target, place.path().join("src/arm/meshes").join(link)).unwrap();
    }
    for (mesh, word) in [
        ("package://.ssh/id_rsa.stl", "does not name a package"),
        ("package://arm_description/../.ssh/id_rsa.stl", "is not a path in the package"),
        ("package://arm_description/../../secret.stl", "is not a path in the package"),
        ("package://arm_description/.git/a.stl", "is not a path in the package"),
        #[cfg(unix)]
        ("package://arm_description/meshes/link.stl", "is a link that leads out of"),
        #[cfg(unix)]
        ("package://arm/meshes/key.stl", "is a link that leads out of"),
        ("package://arm_description/scripts/run.lua", "the format is not supported"),
        ("file:///etc/part.stl", "is outside the folders that may be read"),
    ] {
        place.write("src/arm/urdf/arm.urdf", &seen(mesh));
        check(&place, &[], &[]).reports(&[word]);
    }
}

/// Without a package, the folder above a robot may be read, but not what is hidden there, nor by links with other names.
#[cfg(unix)]
#[test]
fn hidden_files_near_a_robot_are_left_out() {
    let place = TestFolder::new();
    packages(&place, "");
    fs::remove_file(place.path().join("src/arm/package.xml")).unwrap();
    let meshes = place.path().join("src/arm/urdf");
    place.write("src/arm/.hid/part.stl", "secret").write("src/arm/notes.txt", "secret");
    std::os::unix::fs::symlink("../.hid/part.stl", meshes.join("a.stl")).unwrap();
    std::os::unix::fs::symlink("../notes.txt", meshes.join("b.stl")).unwrap();
    let file = place.path().join("src/arm/urdf/arm.urdf");
    for mesh in ["a.stl", "b.stl", "../.hid/part.stl"] {
        place.write("src/arm/urdf/arm.urdf", &seen(mesh));
        let told = run(program(), &place.path().join("empty"), &["check", file.to_str().unwrap()], &[]);
        told.good().reports(&["is outside the folders that may be read"]);
    }
}

/// A replay reads the meshes of packages from the log, also those that were found with other capitals.
#[test]
fn packages_are_recorded_in_input_logs() {
    let place = TestFolder::new();
    packages(&place, "package://other_meshes/Meshes/Part.stl");
    let robot = place.path().join("src/arm/urdf/arm.urdf");
    let told = place.tatu(&["run", robot.to_str().unwrap(), "--steps", "2", "--log", "log"]).good();
    let hash = |out: &str| out.split("hash ").nth(1).unwrap().split_whitespace().next().unwrap().to_owned();
    fs::remove_dir_all(place.path().join("src")).unwrap();
    let replayed = place.tatu(&["run", "--replay", "log"]).good();
    assert_eq!(hash(&told.err), hash(&replayed.err));
    assert!(!replayed.err.contains("is ignored"), "{}", replayed.err);
}

/// A xacro file is expanded with its included files, and errors name the place in these.
#[test]
fn macros_of_xacro_are_expanded() {
    let place = TestFolder::new();
    let header = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">";
    let main = format!(
        "{header}\n<xacro:arg name=\"mass\" default=\"2\"/>\n<xacro:include filename=\"$(find arm_description)/urdf/part.xacro\"/>\n\
         <link name=\"world\"/>\n<xacro:part name=\"a\" mass=\"$(arg mass)\"/>\n<xacro:part name=\"b\" mass=\"${{1 + 2}}\"/>\n</robot>"
    );
    let part = |more: &str| {
        format!(
            "{header}\n<xacro:macro name=\"part\" params=\"name mass\">\n<link name=\"${{name}}\"><inertial><mass \
             value=\"${{mass}}\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\n\
             <joint name=\"${{name}}_joint\" type=\"revolute\"><parent link=\"world\"/><child link=\"${{name}}\"/>{more}\
             </joint>\n</xacro:macro>\n</robot>"
        )
    };
    packages(&place, "");
    place.write("src/arm/urdf/arm.urdf", &main).write("src/arm/urdf/part.xacro", &part(""));
    let masses = |args: &[&str]| {
        let json = check(&place, &[&["--numbers"], args].concat(), &[]).json();
        ["a", "b"].map(|name| json["bodies"][&format!("/r/{name}_joint/{name}")]["mass_kg"].as_f64().unwrap())
    };
    assert_eq!(masses(&[]), [2.0, 3.0]);
    assert_eq!(masses(&["--set", "/r.arguments=mass:=5"]), [5.0, 3.0]);
    assert_eq!(masses(&["--set", "file.arguments=mass:=5"]), [5.0, 3.0]);
    place.write("src/arm/urdf/part.xacro", &part("<axis xyz=\"0 0\"/>"));
    let file = place.path().join("src/arm/urdf/arm.urdf");
    place.tatu(&["check", file.to_str().unwrap()]).refused(&["E120", "part.xacro:4", "expected 3 numbers"]);
    place.write("src/arm/urdf/part.xacro", &part("<axis xyz=\"${nothing} 0 0\"/>"));
    place.tatu(&["check", file.to_str().unwrap()]).refused(&["E120", "part.xacro:4", "nothing"]);
}

/// Returns a box with four wheels of 0.1 m, whose joints have no limits.
fn cart() -> String {
    let wheel = |name: &str, x: f64, y: f64| {
        format!(
            "<link name=\"{name}\">{INERTIAL}<collision><origin rpy=\"1.570796326794897 0 0\"/><geometry><cylinder \
             radius=\"0.1\" length=\"0.05\"/></geometry></collision></link><joint name=\"{name}_joint\" \
             type=\"continuous\"><parent link=\"base\"/><child link=\"{name}\"/><origin xyz=\"{x} {y} 0\"/><axis \
             xyz=\"0 1 0\"/></joint>\n"
        )
    };
    let wheels = [("a", 0.2, 0.2), ("b", 0.2, -0.2), ("c", -0.2, 0.2), ("d", -0.2, -0.2)];
    let wheels = wheels.map(|(name, x, y)| wheel(name, x, y)).concat();
    format!(
        "<robot name=\"cart\"><link name=\"base\">{INERTIAL}<collision><geometry><box size=\"0.4 0.2 0.1\"/></geometry>\
         </collision></link>\n{wheels}</robot>"
    )
}

#[test]
fn wheels_without_a_stated_effort_drive() {
    let script = "function sysCall_init()\n for _, w in ipairs({'a', 'b', 'c', 'd'}) do \
                  sim.setJointTargetVelocity(sim.getObject('/cart/' .. w .. '_joint'), 5) end\nend";
    let scene = |more: &str| {
        format!(
            "{FLOOR}[[import]]\nfile = \"cart.urdf\"\non_floor = true\n{more}\nscript = {{ text = '''\n{script}\n''' }}\n"
        )
    };
    let place = TestFolder::scene(&scene(""));
    place.write("cart.urdf", &cart());
    place
        .tatu(&["check", "scene.toml"])
        .good()
        .reports(&["4 of 4 joints without a stated effort: motors of 1.2 N m are assumed"]);
    let lines = place.trace(&["/cart"], &["--seconds", "4"]);
    let [x, _, z] = lines.last().unwrap().object::<3>("/cart", "position");
    // Wheels of 0.1 m at 5 rad/s, which are as fast after less than 0.2 s; `on_floor` puts them on the floor.
    assert!((1.8..2.0).contains(&x) && (z - 0.1).abs() < 1e-3, "{x} {z}");
    place.write("scene.toml", &format!("format = 1\n{}", scene("default_effort = 0.0")));
    place.tatu(&["check", "scene.toml"]).good().reports(&["4 of 4 joints without a stated effort: no motor"]);
    let lines = place.trace(&["/cart"], &["--seconds", "4"]);
    assert!(lines.last().unwrap().object::<3>("/cart", "position")[0].abs() < 1e-3);
}

/// A file can describe only where joints are.
#[test]
fn robots_without_masses_have_motors() {
    let place = TestFolder::new();
    let joint = "<joint name=\"j\" type=\"revolute\"><parent link=\"world\"/><child link=\"a\"/><limit lower=\"-1\" \
                 upper=\"1\"/></joint>";
    place.write("r.urdf", &format!("<robot name=\"r\"><link name=\"world\"/><link name=\"a\"/>{joint}</robot>"));
    place.tatu(&["check", "r.urdf"]).good().reports(&["1 of 1 joints without a stated effort: motors of 1 N m"]);
}

/// The wheel of a castor, and its swivel, turn freely.
#[test]
fn castors_have_no_motor() {
    let link = |name: &str| format!("<link name=\"{name}\">{INERTIAL}</link>");
    let joint = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin \
             xyz=\"0.1 0 0\"/><axis xyz=\"{axis}\"/></joint>"
        )
    };
    let links = ["base", "wheel", "fork", "castor"].map(link).concat();
    let joints = [
        joint("drive", "base", "wheel", "0 1 0"),
        joint("swivel", "base", "fork", "0 0 1"),
        joint("hub", "fork", "castor", "0 1 0"),
    ];
    let place = TestFolder::new();
    place.write("r.urdf", &format!("<robot name=\"r\">{links}{}</robot>", joints.concat()));
    let told = place.tatu(&["check", "r.urdf", "--numbers"]).good();
    told.reports(&["1 of 3 joints without a stated effort"]);
    let force = |path: &str| told.json()["joints"][path]["max_force"].as_f64().unwrap();
    assert!(force("/r/drive") > 0.0);
    assert_eq!([force("/r/swivel"), force("/r/swivel/fork/hub")], [0.0, 0.0]);
}

/// An arm of 1 kg and 0.5 m whose effort is 0, absent or negative holds its position.
#[test]
fn arms_without_a_stated_effort_hold() {
    for limit in ["effort=\"0\"", "", "effort=\"-1\""] {
        let place = TestFolder::new();
        let link = INERTIAL.replace("<mass", "<origin xyz=\"0.5 0 0\"/><mass");
        let arm = format!(
            "<robot name=\"arm\"><link name=\"world\"/><link name=\"bar\">{link}</link><joint name=\"shoulder\" \
             type=\"revolute\"><parent link=\"world\"/><child link=\"bar\"/><axis xyz=\"0 1 0\"/><limit lower=\"-2\" \
             upper=\"2\" {limit} velocity=\"2\"/></joint></robot>"
        );
        place.write("arm.urdf", &arm);
        place.tatu(&["run", "arm.urdf", "--seconds", "2", "--trace", "t.jsonl", "--watch", "/arm/shoulder"]).good();
        let lines = place.lines("t.jsonl");
        let at = lines.last().unwrap().0["objects"]["/arm/shoulder"]["joint"]["position"].as_f64().unwrap();
        assert!(at.abs() < 0.01, "{limit}: {at}");
    }
}

/// The bounding box of two cubes, 0.8 m apart, has room for a ball between them.
#[test]
fn meshes_of_one_link_collide_as_their_own_hulls() {
    let place = TestFolder::new();
    let part = |x: f64| {
        format!("<collision><origin xyz=\"{x} 0 0\"/><geometry><mesh filename=\"cube.stl\"/></geometry></collision>")
    };
    let robot = format!("<robot name=\"r\"><link name=\"world\">{}{}</link></robot>", part(-0.4), part(0.4));
    fs::write(place.path().join("cube.stl"), cube([0.0; 3])).unwrap();
    place.write("r.urdf", &robot);
    let ball = |alias: &str, x: f64| {
        format!(
            "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nprimitive = \"sphere\"\nsize_m = [0.1, 0.1, 0.1]\n\
             position_m = [{x}, 0.0, 1.2]\ndynamic = true\nrespondable = true\n"
        )
    };
    let import = "[[import]]\nfile = \"r.urdf\"\nposition_m = [0.0, 0.0, 0.5]\n";
    place.write("scene.toml", &format!("format = 1\n{FLOOR}{}{}{import}", ball("between", 0.0), ball("on", 0.4)));
    let lines = place.trace(&["/between", "/on"], &["--seconds", "3"]);
    let height = |path: &str| lines.last().unwrap().object::<3>(path, "position")[2];
    assert!((height("/between") - 0.05).abs() < 1e-3, "{}", height("/between"));
    assert!((height("/on") - 0.65).abs() < 1e-3, "{}", height("/on"));
}

#[test]
fn a_plate_on_a_vertical_axis_is_not_a_wheel() {
    let robot = format!(
        "<robot name=\"r\"><link name=\"base\">{INERTIAL}<collision><geometry><box size=\"0.3 0.3 0.1\"/></geometry>\
         </collision></link><link name=\"plate\">{INERTIAL}<collision><geometry><cylinder radius=\"0.5\" \
         length=\"0.05\"/></geometry></collision></link><joint name=\"turn\" type=\"continuous\"><parent link=\"base\"/>\
         <child link=\"plate\"/><origin xyz=\"0 0 0.1\"/><axis xyz=\"0 0 1\"/></joint></robot>"
    );
    let place = TestFolder::scene(&format!("{FLOOR}[[import]]\nfile = \"r.urdf\"\nposition_m = [0.0, 0.0, 0.05]\n"));
    place.write("r.urdf", &robot);
    let lines = place.trace(&["/r"], &["--seconds", "2"]);
    assert!((lines.last().unwrap().object::<3>("/r", "position")[2] - 0.05).abs() < 1e-3);
}

/// A flaw that does not concern how the robot moves costs one element, and is told with its line.
#[test]
fn a_flaw_costs_one_element() {
    let link = |more: &str| format!("<link name=\"world\">\n{more}</link>");
    let with = |joint: &str| {
        format!(
            "<link name=\"world\"/>\n<link name=\"part\">{INERTIAL}</link>\n<joint name=\"j\" type=\"revolute\"><parent \
             link=\"world\"/><child link=\"part\"/>{joint}</joint>"
        )
    };
    let visual = |geometry: &str| link(&format!("<visual><geometry>{geometry}</geometry></visual>"));
    let fixed = with("<axis xzy=\"0 0 1\"/>").replace("revolute", "fixed");
    let doubled =
        "<visual><geometry><box size=\"1 1 1\"/></geometry><material name=\"a\"/><material name=\"b\"/></visual>";
    for (content, words) in [
        (visual("<box size=\"0.1 0 0.1\"/>"), "line 3: visual of the link `world`: expected a length greater than 0"),
        (visual("<ring/>"), "line 3: a visual of the link `world` is left out: <geometry> contains <ring>"),
        (visual("<box size=\"1 1\"/>"), "line 3: a visual of the link `world` is left out"),
        (link(doubled), "line 3: <visual> has more than one <material>"),
        (format!("{}<gazebo><sensor:camera/></gazebo>", link("")), "the namespace prefix `sensor:` is not declared"),
        (fixed, "line 4: the axis of a joint that cannot move is ignored"),
        (with("<axis xyz=\"0 0 0\"/>"), "line 4: the axis of the joint `j` is 0 0 0; it is treated as fixed"),
        (
            with("<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>"),
            "`lower` 1 exceeds `upper` -1: swapped",
        ),
        (with(""), "the joint `j` states no limits, which are 0 then: it cannot move"),
        (with("<mimic joint=\"k\"/>"), "the joint `j` mimics `k`, which does not exist: it moves by itself"),
        (with("<limit lower=\"-1\" upper=\"1\" effort=\"1\"/>"), "line 4: a limit states no `velocity`"),
        (with("<limit lower=\"1\" upper=\"2\" effort=\"1\" velocity=\"1\"/>"), "exclude 0: it starts at 1"),
        (
            with("").replace(" ixy=\"0\" ixz=\"0\"", ""),
            "line 3: an inertia states no `ixy`; 0 is assumed (and in one more",
        ),
        (with("").replace(INERTIAL, ""), "line 3: the link `part` can move but has no mass"),
    ] {
        let place = TestFolder::new();
        place.write("r.urdf", &format!("<robot name=\"r\">\n{content}</robot>"));
        place.tatu(&["check", "r.urdf"]).good().reports(&[words]);
    }
}

/// The hull of two cubes in one mesh has no room for a ball between them, its convex parts do.
#[test]
fn hollows_of_decomposed_meshes_are_open() {
    let place = TestFolder::new();
    let (mut both, second) = (cube([-0.4, 0.0, 0.0]), cube([0.4, 0.0, 0.0]));
    both.extend(&second[84..]);
    both[80..84].copy_from_slice(&24u32.to_le_bytes());
    fs::write(place.path().join("cubes.stl"), both).unwrap();
    let robot = "<robot name=\"r\"><link name=\"world\"><collision><geometry><mesh filename=\"cubes.stl\"/></geometry>\
                 </collision></link></robot>";
    place.write("r.urdf", robot);
    let ball = "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.1, 0.1, 0.1]\n\
                position_m = [0.0, 0.0, 1.2]\ndynamic = true\nrespondable = true\n";
    for (more, expected) in [("", 0.65), ("decompose = 8\n", 0.05)] {
        let import = format!("[[import]]\nfile = \"r.urdf\"\nposition_m = [0.0, 0.0, 0.5]\n{more}");
        place.write("scene.toml", &format!("format = 1\n{FLOOR}{ball}{import}"));
        let lines = place.trace(&["/ball"], &["--seconds", "3"]);
        let z = lines.last().unwrap().object::<3>("/ball", "position")[2];
        assert!((z - expected).abs() < 1e-3, "{more}: {z}");
    }
}

/// Meshes are often in a folder beside that of the robot, which has no package.
#[test]
fn meshes_beside_the_folder_of_a_robot_are_found_from_anywhere() {
    let place = TestFolder::new();
    packages(&place, "../meshes/part.stl");
    fs::remove_file(place.path().join("src/arm/package.xml")).unwrap();
    assert!(!check(&place, &[], &[]).err.contains("warning"));
    place.write("src/arm/urdf/arm.urdf", &seen("../../other/meshes/part.stl"));
    let file = place.path().join("src/arm/urdf/arm.urdf");
    let empty = place.path().join("empty");
    let told = run(program(), &empty, &["check", file.to_str().unwrap()], &[]);
    told.good().reports(&["is outside the folders that may be read"]);
}

/// Reading attributes takes time in the square of their number.
#[test]
fn a_tag_with_many_attributes_is_refused_at_once() {
    let place = TestFolder::new();
    let attributes: String = (0..200_000).map(|i| format!(" a{i}=\"\"")).collect();
    for (file, text) in [
        ("r.urdf", format!("<robot name=\"r\">\n<link{attributes}/></robot>")),
        ("r.xml", format!("<mujoco>\n<worldbody{attributes}/></mujoco>")),
        ("r.dae", format!("<COLLADA>\n<a{attributes}/></COLLADA>")),
    ] {
        place.write(file, &text);
        let scene = format!("format = 1\n[[import]]\nfile = \"{file}\"\n");
        place.write("scene.toml", &scene);
        place.tatu(&["check", "scene.toml"]).refused(&["E120", file, "more than 256 attributes"]);
    }
}

#[test]
fn xml_of_unknown_formats_is_named() {
    let place = TestFolder::new();
    place.write("world.wrl", "<?xml version=\"1.0\"?>\n<!-- a world -->\n<x3d version=\"3.0\"><Scene/></x3d>");
    let words = ["E121", "no importer reads world.wrl", "urdf (.urdf .xacro)", "XML file with the root element <x3d>"];
    place.tatu(&["check", "world.wrl"]).refused(&words);
}

/// A joint that mimics another one starts where it shall be, and stays there.
#[test]
fn a_mimicking_joint_starts_at_its_offset() {
    let place = TestFolder::new();
    let finger = |name: &str, more: &str| {
        format!(
            "<link name=\"{name}_link\">{INERTIAL}</link><joint name=\"{name}\" type=\"prismatic\"><parent \
             link=\"world\"/><child link=\"{name}_link\"/><axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"9\" \
             effort=\"10\" velocity=\"1\"/>{more}</joint>"
        )
    };
    let text = finger("a", "") + &finger("b", "<mimic joint=\"a\" offset=\"2\"/>");
    place.write("r.urdf", &format!("<robot name=\"r\"><link name=\"world\"/>{text}</robot>"));
    let lines = place.tatu(&["run", "r.urdf", "--seconds", "1", "--trace", "t.jsonl", "--watch", "/r/b"]).good();
    assert!(!lines.err.contains("warning"), "{}", lines.err);
    for line in place.lines("t.jsonl") {
        let at = line.0["objects"]["/r/b"]["joint"]["position"].as_f64().unwrap();
        assert!((at - 2.0).abs() < 1e-6, "{at}");
    }
}

#[test]
fn a_joint_is_mimicked_although_a_link_has_its_name() {
    let place = TestFolder::new();
    let finger = |name: &str, more: &str| {
        format!(
            "<link name=\"{name}_finger\">{INERTIAL}</link><joint name=\"{name}\" type=\"prismatic\"><parent \
             link=\"left\"/><child link=\"{name}_finger\"/><axis xyz=\"0 1 0\"/><limit lower=\"-0.2\" upper=\"0.2\" \
             effort=\"10\" velocity=\"1\"/>{more}</joint>"
        )
    };
    let mount = "<link name=\"world\"/><link name=\"left\"/><joint name=\"mount\" type=\"fixed\"><parent \
                 link=\"world\"/><child link=\"left\"/></joint>";
    let fingers = finger("left", "") + &finger("right", "<mimic joint=\"left\" multiplier=\"-1\"/>");
    place.write("r.urdf", &format!("<robot name=\"r\">{mount}{fingers}</robot>"));
    let args = [
        "run",
        "r.urdf",
        "--set",
        "file.motors=velocity",
        "--set",
        "/r/left[1].target_velocity_m_s=0.1",
        "--seconds",
        "1",
        "--trace",
        "t.jsonl",
    ];
    let told = place.tatu(&[&args[..], &["--watch", "/r/right"]].concat()).good();
    assert!(!told.err.contains("should follow"), "{}", told.err);
    let lines = place.lines("t.jsonl");
    let at = lines.last().unwrap().0["objects"]["/r/right"]["joint"]["position"].as_f64().unwrap();
    assert!((at + 0.1).abs() < 0.01, "{at}");
}
