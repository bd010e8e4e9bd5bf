//! Tests of files in other formats: imported by `[[import]]` or given in place of a scene; and of the URDF importer.

use std::{f64::consts::TAU, fs};

use tatu_core::{
    document,
    plugins::SearchPath,
    scene::{get, property_table::Property},
};
use tatu_plugin_api::safe::Value;

use crate::kit::*;

/// A bar of 1 m and 2 kg on a hinge about y at a height of 2 m. Its centre of mass is 0.5 m below the hinge.
const PENDULUM: &str = r#"<?xml version="1.0"?>
<robot name="pendulum">
  <link name="world"/>
  <link name="bar">
    <inertial>
      <origin xyz="0 0 -0.5"/>
      <mass value="2.0"/>
      <inertia ixx="0.1667" ixy="0" ixz="0" iyy="0.1667" iyz="0" izz="0.01"/>
    </inertial>
    <visual><origin xyz="0 0 -0.5"/><geometry><box size="0.04 0.04 1.0"/></geometry></visual>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="world"/><child link="bar"/>
    <origin xyz="0 0 2" rpy="0 0 0.3"/>
    <axis xyz="0 1 0"/>
  </joint>
</robot>
"#;

/// Copies the importer's test folder with its robot.
fn robot(place: &TestFolder) {
    let from = root().join("plugins/importers/urdf");
    for file in ["robot.urdf", "mast.stl"] {
        fs::copy(from.join(file), place.path().join(file)).unwrap();
    }
}

/// Reads a scene file into a document in this process, with the plugins next to the program.
fn read(place: &TestFolder, scene: &str) -> tatu_core::document::Document {
    let mut search = SearchPath::default();
    search.folders.push((program().with_file_name("deps"), tatu_core::plugins::FolderOrigin::Built));
    search.built = ["tatu_importers_urdf", "tatu_scripts_lua"].map(str::to_owned).to_vec();
    let registry = load_registry(search);
    document::load(&place.path().join(scene), &registry, &Default::default()).unwrap()
}

#[test]
fn a_pendulum_swings_as_long_as_it_should() {
    let place = TestFolder::new();
    place.write("pendulum.urdf", PENDULUM);
    let args = [
        "run",
        "pendulum.urdf",
        "--set",
        "/pendulum.default_effort=0",
        "--set",
        "/pendulum/hinge.joint_position_deg=3",
        "--set",
        "scene.dt_s=0.01",
        "--seconds",
        "10",
        "--trace",
        "t.jsonl",
        "--watch",
        "/pendulum/hinge",
        "--json",
    ];
    place.tatu(&args).good();
    // The times at which the bar passes the vertical, interpolated between two lines of the trace.
    let lines = place.lines("t.jsonl");
    let at = |l: &TraceLine| l.0["objects"]["/pendulum/hinge"]["joint"]["position"].as_f64().unwrap();
    let mut crossed = Vec::new();
    for pair in lines.windows(2) {
        let (a, b) = (at(&pair[0]), at(&pair[1]));
        if a < 0.0 && b >= 0.0 {
            crossed.push(pair[0].time() + (pair[1].time() - pair[0].time()) * a / (a - b));
        }
    }
    let n = crossed.len();
    assert!(n >= 4, "{crossed:?}");
    let period = (crossed[n - 1] - crossed[0]) / (n - 1) as f64;
    // The period of a physical pendulum is 2 pi sqrt(I / (m g l)) with the inertia I about the hinge. The amplitude of
    // 3 degrees adds 0.02 %.
    let inertia: f64 = 0.1667 + 2.0 * 0.5 * 0.5;
    let wanted = TAU * (inertia / (2.0 * 9.81 * 0.5)).sqrt();
    assert!((period / wanted - 1.0).abs() < 0.01, "{period} s, {wanted} s expected");
}

#[test]
fn a_cart_drives_as_fast_as_its_wheels_turn() {
    let script = "function sysCall_init()
        for _, side in ipairs{'left', 'right'} do
            sim.setJointTargetVelocity(sim.getObject('./' .. side .. '_motor'), 5)
        end
    end";
    let place = TestFolder::scene(&format!(
        "{FLOOR}[[import]]\nfile = \"robot.urdf\"\nscript = {{ text = '''\n{script}\n''' }}\n[set]\n\"/cart.friction\" = 0.0\n"
    ));
    robot(&place);
    let lines = place.trace(&["/cart"], &["--seconds", "4"]);
    let x = |l: &TraceLine| l.object::<3>("/cart", "position")[0];
    let (from, to) = (&lines[19], &lines[79]);
    let speed = (x(to) - x(from)) / (to.time() - from.time());
    // The wheels have a radius of 0.1 m and rotate at 5 rad/s.
    assert!((speed / 0.5 - 1.0).abs() < 0.01, "{speed} m/s");
    let [_, y, z] = to.object::<3>("/cart", "position");
    assert!(y.abs() < 0.01 && z.abs() < 0.005, "the robot must drive straight ahead on the floor: {y} {z}");
    let hashes: Vec<String> = lines.iter().map(|l| l.hash().to_owned()).collect();
    let again = place.trace(&["/cart"], &["--seconds", "4", "--threads", "2"]);
    assert_eq!(again.iter().map(TraceLine::hash).collect::<Vec<_>>(), hashes, "two runs differ");
}

#[test]
fn masses_and_inertias_are_those_of_the_file() {
    let place = TestFolder::scene("[[import]]\nfile = \"robot.urdf\"\n");
    robot(&place);
    let (scene, _) = read(&place, "scene.toml").instantiate();
    let numbers = |path: &str, row: Property| {
        let slot = scene.find(0, path).unwrap_or_else(|| panic!("there is no {path}"));
        match get(&scene, slot, row).unwrap() {
            Value::Floats(f) => f,
            Value::Float(f) => vec![f],
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(numbers("/cart/left_motor/left_wheel", Property::MASS), [0.5]);
    // The joint's z axis is the y axis of the file. The wheel has its own frame, so its inertias are those in the file.
    let wheel = numbers("/cart/left_motor/left_wheel", Property::INERTIA);
    for (i, wanted) in [(0, 0.0014), (4, 0.0025), (8, 0.0014), (1, 0.0)] {
        assert!((wheel[i] - wanted).abs() < 1e-12, "{i}: {wheel:?}");
    }
    // Base, ball and mast form one body in the frame of the footprint. Its mass is the sum, its centre of mass the
    // weighted mean, and its inertia follows from the parallel axis theorem.
    let parts: [(f64, [f64; 3], [f64; 3]); 3] = [
        (5.0, [0.06, 0.0, 0.15], [0.06, 0.09, 0.14]),
        (0.2, [0.15, 0.0, 0.05], [0.0002; 3]),
        (0.3, [-0.1, 0.0, 0.3], [0.001, 0.001, 0.0001]),
    ];
    let mass: f64 = parts.iter().map(|p| p.0).sum();
    let com = [0, 1, 2].map(|i| parts.iter().map(|p| p.0 * p.1[i]).sum::<f64>() / mass);
    assert!((numbers("/cart", Property::MASS)[0] - mass).abs() < 1e-12);
    let (found, inertia) = (numbers("/cart", Property::COM), numbers("/cart", Property::INERTIA));
    for i in 0..3 {
        assert!((found[i] - com[i]).abs() < 1e-12, "{found:?} {com:?}");
        let others = [(i + 1) % 3, (i + 2) % 3];
        let wanted: f64 =
            parts.iter().map(|p| p.2[i] + p.0 * others.iter().map(|j| (p.1[*j] - com[*j]).powi(2)).sum::<f64>()).sum();
        assert!((inertia[i * 4] - wanted).abs() < 1e-12, "{i}: {inertia:?} {wanted}");
    }
    // All links have objects with their names.
    for path in ["/cart/base_footprint", "/cart/base_link", "/cart/ball", "/cart/mast", "/cart/right_motor/right_wheel"]
    {
        assert!(scene.find(0, path).is_some(), "{path}");
    }
}

#[test]
fn a_turned_axis_turns_about_it() {
    // A rotation by a third of a turn about the axis (1, 1, 1) maps x to y.
    let place = TestFolder::new();
    let urdf =
        PENDULUM.replace("xyz=\"0 1 0\"", "xyz=\"1 1 1\"").replace(" rpy=\"0 0 0.3\"", "").replace("0 0 -0.5", "1 0 0");
    place.write("a.urdf", &urdf);
    let args = [
        "run",
        "a.urdf",
        "--set",
        "/pendulum/hinge.joint_position_deg=120",
        "--set",
        "scene.gravity_m_s2=[0,0,0]",
        "--steps",
        "1",
        "--trace",
        "t.jsonl",
        "--watch",
        "/pendulum/hinge/bar",
        "--watch",
        "/pendulum/hinge/bar/bar_visual",
        "--json",
    ];
    place.tatu(&args).good();
    let lines = place.lines("t.jsonl");
    let [x, y, z] = lines[0].object::<3>("/pendulum/hinge/bar/bar_visual", "position");
    assert!(x.abs() < 1e-6 && (y - 1.0).abs() < 1e-6 && (z - 2.0).abs() < 1e-6, "{x} {y} {z}");
}

#[test]
fn two_of_one_file_have_names_of_their_own() {
    let place = TestFolder::scene(
        "[[import]]\nfile = \"robot.urdf\"\n[[import]]\nfile = \"robot.urdf\"\nposition_m = [0.0, 2.0, 0.0]\norientation_deg = [0.0, 0.0, 90.0]\n\
         [[import]]\nfile = \"robot.urdf\"\nalias = \"third\"\nfixed_base = true\nposition_m = [0.0, 4.0, 1.0]\n",
    );
    robot(&place);
    let done = place.run(&["--steps", "1", "--set", "scene.gravity_m_s2=[0,0,0]"]).good().json();
    let objects = done["objects"].as_object().unwrap();
    assert_eq!(objects.len(), 3, "{objects:?}");
    let (scene, _) = read(&place, "scene.toml").instantiate();
    for name in ["cart", "cart#0", "left_wheel", "left_wheel#0", "left_wheel#1", "third#1"] {
        assert!(scene.find_name(name).is_some(), "{name}");
    }
    // The import has a position like a model and is rotated by 90 degrees, so the left wheel is in the direction -x.
    let wheel = scene.world(scene.find_name("left_wheel#0").unwrap()).translation.vector;
    assert!((wheel.x + 0.2).abs() < 1e-9 && (wheel.y - 2.0).abs() < 1e-9, "{wheel}");
    // A robot with a fixed base does not fall.
    let lines = place.trace(&["/third", "/cart[0]"], &["--steps", "20"]);
    assert_eq!(lines[19].object::<3>("/third", "position"), [0.0, 4.0, 1.0]);
    assert!(lines[19].object::<3>("/cart[0]", "position")[2] < -1.0, "a robot without a fixed base must fall");
}

/// Returns a binary STL file of a cube of 0.2 m, centred at `at`.
pub fn cube(at: [f32; 3]) -> Vec<u8> {
    let mut out = b"solid, says the header of this binary file".to_vec();
    out.resize(80, b' ');
    out.extend(12u32.to_le_bytes());
    for axis in 0..3 {
        for side in [-0.1f32, 0.1] {
            let corner = |a: f32, b: f32| {
                let mut p = [0.0f32; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, a * side.signum(), b);
                [p[0] + at[0], p[1] + at[1], p[2] + at[2]]
            };
            let [a, b, c, d] = [corner(-0.1, -0.1), corner(0.1, -0.1), corner(0.1, 0.1), corner(-0.1, 0.1)];
            for triangle in [[a, b, c], [a, c, d]] {
                [0.0f32; 3].iter().chain(triangle.iter().flatten()).for_each(|x| out.extend(x.to_le_bytes()));
                out.extend([0, 0]);
            }
        }
    }
    out
}

#[test]
fn a_mesh_beside_the_file_is_seen_where_it_is() {
    let eye = "[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"eye\"\nrange_m = 5.0\norientation_deg = [0.0, 90.0, 0.0]\n";
    let urdf = r#"<robot name="block"><link name="world"><visual><origin xyz="0.3 0 0"/>
        <geometry><mesh filename="NAME" scale="2 1 1"/></geometry></visual></link></robot>"#;
    for (name, file, root_) in [
        ("package://block_description/meshes/cube.stl", "robots/meshes/cube.stl", ""),
        (
            "package://block_description/meshes/cube.stl",
            "packages/block_description/meshes/cube.stl",
            "package_root = \"../packages\"\n",
        ),
        ("meshes/cube.STL", "robots/meshes/cube.STL", ""),
    ] {
        let place = TestFolder::scene(&format!(
            "{eye}[[import]]\nfile = \"robots/block.urdf\"\nposition_m = [1.0, 0.0, 0.0]\n{root_}"
        ));
        place.write("robots/block.urdf", &urdf.replace("NAME", name)).write(file, "");
        fs::write(place.path().join(file), cube([0.5, 0.0, 0.0])).unwrap();
        let lines = place.trace(&["/eye"], &["--steps", "1"]);
        // The distance is 1 m to the origin of the robot, plus 0.3 m to the origin of the visual, plus 0.8 m to the
        // near side of the cube, which is scaled by 2.
        let distance = lines[0].sensor("/eye", "proximity.distance");
        assert!((distance - 2.1).abs() < 1e-6, "{name}: {distance}");
    }
}

#[test]
fn files_outside_are_not_read() {
    let place = TestFolder::new();
    let urdf = |name: &str| {
        format!(
            "<robot name=\"r\"><link name=\"world\"><visual><geometry><mesh filename=\"{name}\"/></geometry></visual></link></robot>"
        )
    };
    fs::create_dir_all(place.path().join("inner/robots")).unwrap();
    fs::write(place.path().join("secret.stl"), cube([0.0; 3])).unwrap();
    fs::write(place.path().join("inner/mine.stl"), cube([0.0; 3])).unwrap();
    place.write("inner/scene.toml", "format = 1\n[[import]]\nfile = \"robots/a.urdf\"\n");
    let inner = place.path().join("inner");
    let secret = place.path().join("secret.stl");
    #[cfg(unix)]
    std::os::unix::fs::symlink(&secret, inner.join("robots/link.stl")).unwrap();
    let names = ["../../secret.stl", "../../nothing.stl", secret.to_str().unwrap()];
    for name in names.into_iter().chain(cfg!(unix).then_some("link.stl")) {
        place.write("inner/robots/a.urdf", &urdf(name));
        // The robot is loaded without the mesh, as if it did not exist.
        run(program(), &inner, &["check", "scene.toml"], &[]).good().reports(&[
            "a.urdf",
            "is outside",
            "does not exist",
        ]);
    }
    // The mesh is in a parent folder of the robot, but within the scene's folder.
    place.write("inner/robots/a.urdf", &urdf("../mine.stl"));
    run(program(), &inner, &["check", "scene.toml"], &[]).good();
    // A missing mesh is reported, and the robot is loaded without it.
    place.write("inner/robots/a.urdf", &urdf("none.stl"));
    run(program(), &inner, &["check", "scene.toml"], &[]).good().reports(&["none.stl", "the file does not exist"]);
}

#[test]
fn errors_name_the_file_and_the_line() {
    let wrong: &[(&str, &str, usize, &str)] = &[
        ("<mass value=\"2.0\"/>", "<mass value=\"nan\"/>", 4, "NaN"),
        ("<mass value=\"2.0\"/>", "<mass value=\"-2\"/>", 4, "-2 kg"),
        ("<mass value=\"2.0\"/>", "<mass value=\"two\"/>", 7, "the link `bar` cannot be read"),
        ("<mass value=\"2.0\"/>", "<mass value=\"two\"/>", 7, "is \"two\"; expected a number (column 13)"),
        ("<mass value=\"2.0\"/>", "", 5, "<inertial> has no <mass> (column 5)"),
        ("xyz=\"0 1 0\"", "xyz=\"0 1\"", 15, "expected 3 numbers"),
        ("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><axis/>", 15, "<joint> has more than one <axis>"),
        ("child link=\"bar\"", "child link=\"baar\"", 12, "`baar`"),
        ("child link=\"bar\"", "child link=\"world\"", 12, "to itself"),
        ("type=\"continuous\"", "type=\"rubber\"", 12, "rubber"),
        ("name=\"bar\"", "name=\"world\"", 4, "two links are named `world`"),
        ("</inertial>", "</inertia>", 9, "not well-formed"),
        ("<robot name=\"pendulum\">", "<robt name=\"x\">", 2, "the root element is <robt>"),
    ];
    for (from, to, line, word) in wrong {
        let place = TestFolder::new();
        let text = PENDULUM.replacen(from, to, 1);
        let text = if *to == "<robt name=\"x\">" { text.replace("</robot>", "</robt>") } else { text };
        assert_ne!(text, PENDULUM);
        place.write("robots/p.urdf", &text).write("scene.toml", "format = 1\n[[import]]\nfile = \"robots/p.urdf\"\n");
        for (command, at) in [(["run", "scene.toml"], "scene.toml:3"), (["check", "robots/p.urdf"], "")] {
            place.tatu(&command).refused(&["E120", &format!("p.urdf:{line}"), word, at]);
        }
    }
}

#[test]
fn scenes_with_wrong_imports_are_refused() {
    let place = TestFolder::new();
    robot(&place);
    place.write("notes.txt", "hello");
    for (text, words) in [
        ("importr = \"urdf\"", &["unknown key `importr`", "did you mean `importer`?"][..]),
        ("importer = \"urfd\"", &["E121", "`urfd`", "did you mean `urdf`?"]),
        ("fixed_bas = true", &["`fixed_bas`", "did you mean `fixed_base`?"]),
        ("motors = \"velocty\"", &["velocty", "\"velocity\""]),
        ("link_friction = -1.0", &["link_friction", "0"]),
    ] {
        place.write("scene.toml", &format!("format = 1\n[[import]]\nfile = \"robot.urdf\"\n{text}\n"));
        place.tatu(&["check", "scene.toml"]).refused(&[words, &["scene.toml:4"]].concat());
    }
    for (text, words) in [
        ("file = \"none.urdf\"", &["E105", "none.urdf", "scene.toml:3"][..]),
        ("file = \"notes.txt\"", &["E121", "notes.txt", "urdf", "scene.toml:3"]),
        ("alias = \"x\"", &["E104", "has no `file`"]),
    ] {
        place.write("scene.toml", &format!("format = 1\n[[import]]\n{text}\n"));
        place.tatu(&["check", "scene.toml"]).refused(words);
    }
    // A file with an unknown suffix is recognised by its contents. A file that no importer accepts is refused.
    place.write("robot.xml", PENDULUM).tatu(&["check", "robot.xml"]).good();
    fs::write(place.path().join("noise.bin"), [0xFFu8, 0, 1, 2]).unwrap();
    place.tatu(&["check", "noise.bin"]).refused(&["E121", "noise.bin"]);
    place.tatu(&["run", "none.urdf"]).refused(&["E105", "none.urdf"]);
}

#[test]
fn cut_files_are_refused_with_a_sentence() {
    let place = TestFolder::new();
    robot(&place);
    let whole = fs::read(place.path().join("robot.urdf")).unwrap();
    let end = whole.windows(8).rposition(|w| w == b"</robot>").unwrap() + 8;
    for n in (0..end).step_by(640) {
        fs::write(place.path().join("cut.urdf"), &whole[..n]).unwrap();
        place.tatu(&["check", "cut.urdf"]).refused(&["E120", "cut.urdf"]);
    }
}

#[test]
fn importers_are_listed_with_their_parameters() {
    let list = TestFolder::new().tatu(&["list", "importers", "--json"]).good().json();
    let urdf = list.as_array().unwrap().iter().find(|i| i["id"] == "urdf").unwrap();
    assert_eq!(urdf["suffixes"], serde_json::json!([".urdf", ".xacro"]));
    assert!(urdf["parameters"].as_array().unwrap().iter().any(|p| p["name"] == "fixed_base"));
}

/// Fingers that mimic each other move together; their damping slows them down.
#[test]
fn joints_mimic_and_are_damped() {
    let place = TestFolder::new();
    let link = |name: &str, y: f64| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 {y} 0\"/><mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>\n"
        )
    };
    let joint = |name: &str, child: &str, more: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"world\"/><child link=\"{child}\"/><axis xyz=\"1 0 0\"/>{more}</joint>\n"
        )
    };
    let text = ["<robot name=\"g\"><link name=\"world\"/>".to_owned(), link("a", 0.2), link("b", 0.0)].concat()
        + &joint("one", "a", "<dynamics damping=\"0.05\" friction=\"0.1\"/>")
        + &joint("two", "b", "<mimic joint=\"one\" multiplier=\"-1\"/>")
        + "</robot>";
    place.write("g.urdf", &text);
    let free = ["--set", "/g.default_effort=0"];
    let args = ["run", "g.urdf", "--seconds", "60", "--trace", "t.jsonl", "--watch", "/g/one", "--watch", "/g/two"];
    place.tatu(&[&args[..], &free].concat()).good();
    let lines = place.lines("t.jsonl");
    let at = |i: usize, path: &str| lines[i].0["objects"][path]["joint"]["position"].as_f64().unwrap();
    for i in (0..lines.len()).step_by(100) {
        assert!((at(i, "/g/one") + at(i, "/g/two")).abs() < 1e-3, "{i}");
    }
    assert!((at(5, "/g/one") - at(1, "/g/one")).abs() > 0.1, "the fingers do not move");
    let last = lines.len() - 1;
    assert!((at(last, "/g/one") - at(last - 20, "/g/one")).abs() < 1e-4, "the fingers do not come to rest");
}

/// Light links whose joint mimics another one, or is mimicked, get a rotor inertia, which URDF files do not contain,
/// and a note is logged. Heavy links, and links whose joint is not coupled, get none.
#[test]
fn light_geared_links_get_a_rotor() {
    let place = TestFolder::new();
    let link = |name: &str, mass: f64| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.03 0 0\"/><mass value=\"{mass}\"/><inertia ixx=\"1e-5\" ixy=\"0\" ixz=\"0\" iyy=\"1e-5\" iyz=\"0\" izz=\"1e-5\"/></inertial></link>\n"
        )
    };
    let joint = |kind: &str, child: &str, more: &str| {
        format!(
            "<joint name=\"j{child}\" type=\"{kind}\"><parent link=\"world\"/><child link=\"{child}\"/><axis xyz=\"0 1 0\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"9\" velocity=\"1\"/>{more}</joint>\n"
        )
    };
    let masses = [("a", 0.015), ("b", 0.015), ("c", 0.02), ("d", 0.5), ("e", 0.5), ("f", 0.015)];
    let text = masses.map(|(name, mass)| link(name, mass)).concat()
        + &joint("prismatic", "a", "")
        + &joint("prismatic", "b", "<mimic joint=\"ja\"/>")
        + &joint("revolute", "c", "<mimic joint=\"ja\"/>")
        + &joint("prismatic", "d", "")
        + &joint("prismatic", "e", "<mimic joint=\"jd\"/>")
        + &joint("prismatic", "f", "");
    place.write("g.urdf", &format!("<robot name=\"g\"><link name=\"world\"/>{text}</robot>"));
    let told = place.tatu(&["convert", "g.urdf", "scene.toml"]).good().err;
    let scene = place.read("scene.toml");
    assert_eq!(scene.matches("armature_kg = 0.05").count(), 2, "{scene}");
    // The centre of mass of link `c` is 30 mm from its axis, so a length of 60 mm is assumed: 0.05 kg (0.06 m)^2 =
    // 1.8e-4 kg m^2, written as 0.00017999...
    assert_eq!(scene.matches("armature_kg_m2 = 0.00017").count(), 1, "{scene}");
    let note = "only 15 g: an armature of 5.00e-2 kg is assumed";
    assert_eq!(told.matches(note).count(), 1, "{told}");
    assert_eq!(told.matches("(and in 2 more places)").count(), 1, "{told}");
}

#[test]
fn prismatic_joints_stop_at_their_limits_and_unsupported_tags_are_reported() {
    let place = TestFolder::new();
    let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial>";
    let joint = |name: &str, kind: &str, parent: &str, child: &str, more: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{more}</joint>\n"
        )
    };
    let limit = "<axis xyz=\"0 0 -1\"/><limit lower=\"0\" upper=\"0.3\" effort=\"0\" velocity=\"1\"/><dynamics damping=\"0.1\"/>";
    place.write(
        "slide.urdf",
        &format!(
            "<robot name=\"slide\">\n<link name=\"world\"/><link name=\"weight\">{inertial}</link><link name=\"plate\">{inertial}\
             <visual><geometry><mesh filename=\"a.dae\"/></geometry></visual></link><link name=\"light\"/>\n{}{}{}\
             <sensor name=\"t\"/></robot>",
            joint("rail", "prismatic", "world", "weight", limit),
            joint("table", "planar", "weight", "plate", ""),
            joint("swivel", "continuous", "plate", "light", ""),
        ),
    );
    let args = [
        "run",
        "slide.urdf",
        "--set",
        "/slide.default_effort=0",
        "--seconds",
        "2",
        "--trace",
        "t.jsonl",
        "--watch",
        "/slide/rail",
        "--watch",
        "/slide/rail/weight",
    ];
    let done = place.tatu(&args).good();
    for words in [
        "`table` has the type planar",
        "the mesh `a.dae` is ignored: the file does not exist",
        "1 x <sensor>",
        "the link `light` can move but has no mass: 0.020 kg is assumed",
    ] {
        done.reports(&[words]);
    }
    assert!(
        done.err.lines().filter(|l| l.starts_with("note: ")).all(|l| l.starts_with("note: slide.urdf: ")),
        "{}",
        done.err
    );
    // The link slides down along its axis to the end of its range.
    let lines = place.lines("t.jsonl");
    let last = lines.last().unwrap();
    let at = last.0["objects"]["/slide/rail"]["joint"]["position"].as_f64().unwrap();
    let [_, _, z] = last.object::<3>("/slide/rail/weight", "position");
    assert!((at - 0.3).abs() < 0.002 && (z + 0.3).abs() < 0.002, "{at} {z}");
    // Before that it falls freely: by g t^2 / 2 after 0.15 s.
    let line = &lines[2];
    assert!((line.object::<3>("/slide/rail/weight", "position")[2] + 9.81 / 2.0 * 0.15 * 0.15).abs() < 0.01);
}

#[test]
fn transmissions_and_controllers_become_custom_data() {
    let place = TestFolder::new();
    place.write(
        "m.urdf",
        "<robot name=\"m\"><link name=\"base\"/>\n<transmission name=\"a\"><type>x &amp; y</type></transmission>\n\
         <ros2_control name=\"c\" type=\"system\"/><transmission name=\"b\"/></robot>",
    );
    place.write(
        "s.toml",
        "format = 1\n[[import]]\nfile = \"m.urdf\"\n[[object]]\nkind = \"dummy\"\n[object.script]\ntext = \"\"\"\n\
         function sysCall_init()\n  local robot = sim.getObject('/m')\n  \
         print(sim.readCustomStringData(robot, 'transmission'), sim.readCustomStringData(robot, 'ros2_control'))\n\
         end\n\"\"\"\n",
    );
    let done = place.tatu(&["run", "s.toml", "--seconds", "0.1"]).good();
    let all = [done.out.as_str(), done.err.as_str()].concat();
    for text in ["<type>x &amp; y</type></transmission>", "<transmission name=\"b\"/>", "type=\"system\"/>"] {
        assert!(all.contains(text), "{text}: {all}");
    }
}

#[test]
fn sensors_of_gazebo_elements_are_built_at_their_links() {
    let place = TestFolder::new();
    place.write(
        "m.urdf",
        "<robot name=\"m\"><link name=\"base\"/><link name=\"head\"/>\n\
         <joint name=\"neck\" type=\"fixed\"><parent link=\"base\"/><child link=\"head\"/><origin xyz=\"0 0 1\"/></joint>\n\
         <gazebo reference=\"head\"><sensor name=\"eye\" type=\"ray\"><pose>0.5 0 0 0 0 0</pose><ray><scan><horizontal>\
         <samples>11</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>\
         <range><min>0.1</min><max>7</max></range></ray></sensor></gazebo>\n\
         <gazebo reference=\"tail\"><sensor name=\"lost\" type=\"imu\"/></gazebo></robot>",
    );
    place.write(
        "s.toml",
        "format = 1\n[[import]]\nfile = \"m.urdf\"\n[[object]]\nkind = \"dummy\"\n[object.script]\ntext = \"\"\"\n\
         function sysCall_init()\n  local eye = sim.getObject('//eye')\n  local p = sim.getObjectPosition(eye, -1)\n  \
         print('eye', sim.getProperty(eye, 'laser.rays'), sim.getProperty(eye, 'laser.range'), p[1], p[3])\n\
         end\n\"\"\"\n",
    );
    let done = place.tatu(&["run", "s.toml", "--seconds", "0.1"]).good();
    done.reports(&["the sensor `lost` is left out: there is no link `tail`", "line 4"]);
    let all = [done.out.as_str(), done.err.as_str()].concat();
    let line = all.lines().find(|line| line.starts_with("eye")).unwrap_or_else(|| panic!("{all}"));
    let numbers: Vec<f64> = line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
    let wanted = [11.0, 7.0, 0.5, 1.0];
    assert!(numbers.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{line}");
}
