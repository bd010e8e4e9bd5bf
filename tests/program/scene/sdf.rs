//! Tests of the SDF importer: masses, poses and joints against formulas, includes, worlds, sensors and drives.

use std::{
    f64::consts::{FRAC_PI_2, PI},
    fs,
    sync::Arc,
};

use serde_json::Value as Json;
use tatu_core::{
    World, document,
    plugins::{FolderOrigin, SearchPath},
};

use crate::kit::*;

/// Returns a file with a model of these elements.
pub fn sdf(version: &str, elements: &str) -> String {
    format!("<?xml version=\"1.0\"?>\n<sdf version=\"{version}\">\n<model name=\"m\">\n{elements}\n</model>\n</sdf>\n")
}

/// Returns a link of 1 kg at a pose, with a small inertia.
pub fn link(name: &str, pose: &str) -> String {
    format!(
        "<link name=\"{name}\"><pose>{pose}</pose><inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy>\
         <izz>.01</izz></inertia></inertial></link>"
    )
}

/// Returns a joint between two links.
fn joint(name: &str, kind: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!("<joint name=\"{name}\" type=\"{kind}\"><parent>{parent}</parent><child>{child}</child>{more}</joint>")
}

/// Returns what `tatu check --numbers` prints of a file.
pub fn figures(text: &str) -> Json {
    let place = TestFolder::new();
    place.write("m.sdf", text);
    let done = place.tatu(&["check", "m.sdf", "--numbers"]).good();
    serde_json::from_str(done.out.lines().last().unwrap()).unwrap()
}

pub fn close(found: &[f64], wanted: &[f64]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * b.abs().max(1.0);
    assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(near), "{found:?} instead of {wanted:?}");
}

/// Returns the position of an object with all joints at 0.
pub fn position(figures: &Json, path: &str) -> Vec<f64> {
    let pose = &figures["configurations"][0]["poses"][path];
    assert!(pose.is_array(), "no {path} in {}", figures["configurations"][0]["poses"]);
    numbers(pose)[..3].to_vec()
}

/// Runs files in a folder for a while; returns the last line of the trace for these objects.
fn last(place: &TestFolder, file: &str, seconds: &str, watch: &[&str]) -> TraceLine {
    let mut args = vec!["run", file, "--seconds", seconds, "--trace", "t.jsonl"];
    watch.iter().for_each(|path| args.extend(["--watch", path]));
    place.tatu(&args).good();
    place.lines("t.jsonl").pop().unwrap()
}

#[test]
fn masses_of_fixed_links_are_combined_with_their_turned_axes() {
    let base = "<link name='base'><inertial><mass>2</mass><pose>0 0 0.1 0 0 1.5707963267948966</pose>\
                <inertia><ixx>.1</ixx><iyy>.2</iyy><izz>.25</izz></inertia></inertial></link>";
    let found = figures(&sdf(
        "1.9",
        &format!("{base}{}{}", link("tip", "1 0 0.1 0 0 0"), joint("f", "fixed", ["base", "tip"], "")),
    ));
    let body = &found["bodies"]["/m"];
    // The axes of the first inertia are turned by a quarter about z, so x and y are exchanged.
    let (mass, com) = (3.0, [1.0 / 3.0, 0.0, 0.1]);
    close(&[body["mass_kg"].as_f64().unwrap()], &[mass]);
    close(&numbers(&body["com_m"]), &com);
    // Parallel axes: 2 kg at 1/3 m and 1 kg at 2/3 m along x from the common centre.
    let steiner = 2.0 / 9.0 + 4.0 / 9.0;
    for (i, wanted) in [0.2 + 0.01, 0.1 + 0.01 + steiner, 0.25 + 0.01 + steiner].into_iter().enumerate() {
        close(&[body["inertia_kg_m2"][i][i].as_f64().unwrap()], &[wanted]);
    }
    // Without an inertial, a link has 1 kg and 1 kg m^2.
    let plain = figures(&sdf("1.6", "<link name='l'/>"));
    close(
        &[
            plain["bodies"]["/m"]["mass_kg"].as_f64().unwrap(),
            plain["bodies"]["/m"]["inertia_kg_m2"][1][1].as_f64().unwrap(),
        ],
        &[1.0; 2],
    );
    // One that is computed: a ball of 0.1 m at a density of 500 kg/m^3.
    let ball = "<link name='l'><inertial auto='true'><density>500</density></inertial><collision name='c'><pose>0 0 1 0 0 0</pose>\
                <geometry><sphere><radius>.1</radius></sphere></geometry></collision></link>";
    let ball = figures(&sdf("1.11", ball));
    let mass = 500.0 * 4.0 / 3.0 * PI * 1e-3;
    close(&[ball["bodies"]["/m"]["mass_kg"].as_f64().unwrap()], &[mass]);
    close(&[ball["bodies"]["/m"]["inertia_kg_m2"][0][0].as_f64().unwrap()], &[0.4 * mass * 0.01]);
    close(&numbers(&ball["bodies"]["/m"]["com_m"]), &[0.0, 0.0, 1.0]);
}

#[test]
fn poses_are_relative_to_the_frames_that_they_name() {
    let elements = "<frame name='f' attached_to='a'><pose>0 1 0 0 0 1.5707963267948966</pose></frame>\
                    <link name='a'><pose>1 0 0 0 0 0</pose></link>\
                    <link name='b'><pose relative_to='f'>2 0 0 0 0 0</pose></link>\
                    <link name='c'><pose relative_to='j' degrees='true'>0 0 1 0 90 0</pose></link>\
                    <joint name='j' type='revolute'><pose relative_to='b'>0 0 3 0 0 0</pose><parent>f</parent><child>c</child>\
                    <axis><xyz expressed_in='f'>1 0 0</xyz></axis></joint>\
                    <joint name='k' type='fixed'><parent>a</parent><child>b</child></joint>";
    let found = figures(&sdf("1.9", elements));
    // The frame is at 1 1 0 and its x axis is the model's y axis, so b is at 1 3 0.
    close(&position(&found, "/m/b"), &[1.0, 3.0, 0.0]);
    close(&position(&found, "/m/j"), &[1.0, 3.0, 3.0]);
    close(&position(&found, "/m/j/c"), &[1.0, 3.0, 4.0]);
    // The axis is the z axis of the joint object.
    let turn = numbers(&found["configurations"][0]["poses"]["/m/j"]);
    let [x, y, z, w] = [turn[3], turn[4], turn[5], turn[6]];
    close(&[2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], &[0.0, 1.0, 0.0]);
    // The pose of a placement frame is that of the model.
    let placed = sdf("1.8", &link("l", "0 0 2 0 0 0"))
        .replace("name=\"m\">", "name=\"m\" placement_frame=\"l\"><pose>5 0 0 0 0 0</pose>");
    close(&position(&figures(&placed), "/m"), &[5.0, 0.0, -2.0]);
}

#[test]
fn axes_have_the_frame_of_their_version() {
    let of = |version: &str, more: &str| {
        let links = format!("{}{}", link("a", "0 0 0 0 0 0"), link("b", &format!("0 0 1 0 0 {FRAC_PI_2}")));
        let axis = format!("<axis><xyz>1 0 0</xyz>{more}</axis>");
        let found = figures(&sdf(version, &format!("{links}{}", joint("j", "revolute", ["a", "b"], &axis))));
        let turn = numbers(&found["configurations"][0]["poses"]["/m/j"]);
        let [x, y, z, w] = [turn[3], turn[4], turn[5], turn[6]];
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
    };
    // Up to 1.4, that of the model; later that of the joint, which is the child's.
    close(&of("1.4", ""), &[1.0, 0.0, 0.0]);
    close(&of("1.6", ""), &[0.0, 1.0, 0.0]);
    close(&of("1.6", "<use_parent_model_frame>1</use_parent_model_frame>"), &[1.0, 0.0, 0.0]);
}

#[test]
fn limits_and_dynamics_of_joints_are_those_of_the_file() {
    let elements = format!(
        "{}{}{}{}{}{}",
        link("a", "0 0 0 0 0 0"),
        link("b", "0 0 1 0 0 0"),
        link("c", "0 0 2 0 0 0"),
        link("d", "0 0 3 0 0 0"),
        joint(
            "free",
            "revolute",
            ["a", "b"],
            "<axis><limit><lower>-1e16</lower><upper>1e16</upper><effort>-1</effort></limit>\
              <dynamics><damping>.3</damping><friction>.2</friction></dynamics></axis>"
        ),
        joint(
            "held",
            "prismatic",
            ["b", "c"],
            "<axis><limit><lower>-.5</lower><upper>.25</upper><effort>40</effort>\
              <velocity>2</velocity></limit></axis>"
        ),
    ) + &joint(
        "follower",
        "revolute",
        ["c", "d"],
        "<axis><xyz>1 0 0</xyz><mimic joint='free' axis='axis'><multiplier>2</multiplier>\
               <offset>.1</offset><reference>.3</reference></mimic></axis>",
    );
    let found = figures(&sdf("1.11", &elements));
    let joint = |path: &str| found["joints"][path].clone();
    let (free, held) = (joint("/m/free"), joint("/m/free/b/held"));
    assert!(free["limits"].is_null(), "{free}");
    close(&[free["damping"].as_f64().unwrap(), free["dry_friction"].as_f64().unwrap()], &[0.3, 0.2]);
    close(&numbers(&held["limits"]), &[-0.5, 0.25]);
    close(&[held["max_force"].as_f64().unwrap(), held["max_velocity"].as_f64().unwrap()], &[40.0, 2.0]);
    let follower = joint("/m/free/b/held/c/follower");
    // 2 (q - 0.3) + 0.1
    close(&[follower["follow_factor"].as_f64().unwrap(), follower["follow_offset"].as_f64().unwrap()], &[2.0, -0.5]);
}

#[test]
fn joints_with_two_axes_become_two_and_screws_have_a_lead() {
    let links = format!("{}{}", link("a", "0 0 0 0 0 0"), link("b", "0 0 1 0 0 0"));
    let axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>";
    let found = figures(&sdf("1.9", &format!("{links}{}", joint("u", "universal", ["a", "b"], axes))));
    let total = found["total"]["mass_kg"].as_f64().unwrap();
    close(&[total, found["bodies"]["/m/u/u_link"]["mass_kg"].as_f64().unwrap()], &[2.0, 1e-4]);
    close(&position(&found, "/m/u/u_link/u_axis2/b"), &[0.0, 0.0, 1.0]);
    // A position of 1 rad moves by the lead over a full turn.
    for (pitch, lead) in
        [("<screw_thread_pitch>.02</screw_thread_pitch>", 0.02), ("<thread_pitch>-100</thread_pitch>", PI / 50.0)]
    {
        let limit = "<axis><limit><lower>0</lower><upper>4</upper></limit></axis>";
        let found =
            figures(&sdf("1.9", &format!("{links}{}", joint("s", "screw", ["a", "b"], &format!("{limit}{pitch}")))));
        let turned = &found["configurations"][1];
        let angle = turned["positions"]["/m/s"].as_f64().unwrap();
        close(&[turned["poses"]["/m/s/b"][2].as_f64().unwrap()], &[1.0 + lead * angle / (2.0 * PI)]);
    }
}

#[test]
fn pendulums_without_a_controller_swing() {
    let place = TestFolder::new();
    let bar = "<link name='bar'><pose>0 0 2 0 0 0</pose><inertial><pose>.5 0 0 0 0 0</pose><mass>1</mass><inertia><ixx>.001</ixx>\
               <iyy>.08</iyy><izz>.08</izz></inertia></inertial></link>";
    let hinge = joint("hinge", "revolute", ["world", "bar"], "<axis><xyz>0 1 0</xyz></axis>");
    let plugin = "<plugin filename='gz-sim-joint-position-controller-system' name='gz::sim::systems::JointPositionController'>\
                  <joint_name>hinge</joint_name></plugin>";
    place
        .write("free.sdf", &sdf("1.9", &format!("{bar}{hinge}")))
        .write("held.sdf", &sdf("1.9", &format!("{bar}{hinge}{plugin}")));
    let fallen = |file: &str, more: &str| {
        let angle = last(&place, file, more, &["/m/hinge"]);
        angle.0["objects"]["/m/hinge"]["joint"]["position"].as_f64().unwrap()
    };
    // Released level, it falls by g l / (k^2 + l^2) t^2 / 2 at first, with l = 0.5 and k^2 = 0.08.
    let angle = fallen("free.sdf", "0.1");
    let wanted = 9.81 * 0.5 / (0.08 + 0.25) * 0.01 / 2.0;
    assert!((angle / wanted - 1.0).abs() < 0.15, "{angle} {wanted}");
    assert!(fallen("held.sdf", "1").abs() < 1e-3);
}

#[test]
fn a_second_joint_above_a_link_closes_the_loop() {
    let place = TestFolder::new();
    // A parallelogram whose lower bar stays level.
    let bar = |name: &str, x: &str, z: &str| link(name, &format!("{x} 0 {z} 0 0 0"));
    let hinge = |name: &str, ends: [&str; 2], x: &str, z: &str| {
        let pose = format!("<pose relative_to='__model__'>{x} 0 {z} 0 0 0</pose><axis><xyz>0 1 0</xyz></axis>");
        joint(name, "revolute", ends, &pose)
    };
    let elements = [
        bar("left", "0", "1.5"),
        bar("right", "1", "1.5"),
        bar("low", ".5", "1"),
        hinge("a", ["world", "left"], "0", "2"),
        hinge("b", ["world", "right"], "1", "2"),
        hinge("c", ["left", "low"], "0", "1"),
        hinge("d", ["right", "low"], "1", "1"),
        "<plugin filename='x' name='gz::sim::systems::JointController'><joint_name>a</joint_name>\
         <initial_velocity>.5</initial_velocity></plugin>"
            .to_owned(),
    ];
    place.write("m.sdf", &sdf("1.9", &elements.concat()));
    place.tatu(&["check", "m.sdf"]).good().reports(&["the joint `d` closes a loop"]);
    let line = last(&place, "m.sdf", "1", &["/m/a/left/c/low", "/m/a"]);
    let angle = line.0["objects"]["/m/a"]["joint"]["position"].as_f64().unwrap();
    assert!(angle.abs() > 0.3, "{angle}");
    // Its middle moves on a circle of 1 m, and it does not turn.
    let [x, _, z] = line.object("/m/a/left/c/low", "position");
    let [_, turn, _, w] = line.object("/m/a/left/c/low", "quaternion");
    assert!((x - 0.5 + angle.sin()).abs() < 0.01 && (z - 2.0 + angle.cos()).abs() < 0.01, "{x} {z} {angle}");
    assert!((turn / w).abs() < 0.01, "{turn}");
}

/// Writes a world and the models that it includes.
fn world(place: &TestFolder) {
    let solid = |form: &str| format!("<collision name='c'><geometry>{form}</geometry></collision>");
    let cube = solid("<box><size>1 1 1</size></box>");
    place.write(
        "models/cube/model.config",
        "<?xml version='1.0'?><model><sdf version='1.4'>old.sdf</sdf><sdf version='1.6'>cube.sdf</sdf></model>",
    );
    place.write(
        "models/cube/cube.sdf",
        &format!(
            "<sdf version='1.6'><model name='cube'><pose>9 9 9 0 0 0</pose><link name='l'>{cube}</link></model></sdf>"
        ),
    );
    place.write("models/cube/old.sdf", "<sdf version='1.4'/>");
    let plane = solid("<plane><normal>0 0 1</normal><size>10 10</size></plane>");
    place.write(
        "models/ground/model.sdf",
        &format!(
            "<sdf version='1.6'><model name='ground'><static>true</static><link name='l'>{plane}</link></model></sdf>"
        ),
    );
    let include = |uri: &str, more: &str| format!("<include><uri>{uri}</uri>{more}</include>");
    let text = [
        "<sdf version='1.6'><world name='w'><gravity>0 0 -5</gravity>",
        &include("model://ground", ""),
        &include("model://cube", "<pose>0 0 0.6 0 0 0</pose>"),
        &include("../models/cube/cube.sdf", "<name>second</name><pose>3 0 2 0 0 0</pose><static>1</static>"),
        &include("https://fuel.gazebosim.org/1.0/Open/models/Cube That Is Far", ""),
        "<light name='sun' type='directional'><direction>1 0 -1</direction></light>",
        "<plugin filename='libx' name='gz::sim::systems::Physics'/><plugin filename='libmine.so' name='mine'/>",
        "</world></sdf>",
    ];
    place.write("worlds/w.sdf", &text.concat());
}

#[test]
fn a_world_has_its_included_models_and_lights() {
    let place = TestFolder::new();
    world(&place);
    let done = place.tatu(&["check", "worlds/w.sdf"]).good();
    done.reports(&[
        "the folder of the model `Cube That Is Far` was not found",
        "is left out",
        "the plugin `mine` is not run",
    ]);
    assert!(!done.err.contains("Physics"), "{}", done.err);
    // The cube falls onto the ground, the other one does not move.
    let line = last(&place, "worlds/w.sdf", "3", &["/w/cube", "/w/second", "/w/sun"]);
    let [_, _, z] = line.object("/w/cube", "position");
    assert!((z - 0.5).abs() < 2e-3, "{z}");
    assert_eq!(line.object::<3>("/w/second", "position"), [3.0, 0.0, 2.0]);
    // The z axis of the light is its direction.
    let [x, y, z, w] = line.object("/w/sun", "quaternion");
    let along = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
    close(&along, &[0.5f64.sqrt(), 0.0, -0.5f64.sqrt()]);
    // From elsewhere, with the folder of models in the environment of Gazebo.
    let file = place.path().join("worlds/w.sdf");
    fs::create_dir_all(place.path().join("empty")).unwrap();
    let moved = place.path().join("far");
    fs::rename(place.path().join("models"), &moved).unwrap();
    let text = fs::read_to_string(&file).unwrap().replace("../models/cube/cube.sdf", "model://cube");
    fs::write(&file, text).unwrap();
    let env = [("GZ_SIM_RESOURCE_PATH", moved.to_str().unwrap())];
    let done = run(program(), &place.path().join("empty"), &["check", file.to_str().unwrap()], &env).good();
    assert!(!done.err.contains("`cube`") && !done.err.contains("`ground`"), "{}", done.err);
}

#[test]
fn nested_and_merged_models_are_parts_of_the_one_around() {
    let inner = format!("<model name='arm'><pose>0 0 1 0 0 0</pose>{}</model>", link("hand", "0 0 1 0 0 0"));
    let joint = joint("j", "fixed", ["a", "arm::hand"], "");
    let found = figures(&sdf("1.8", &format!("{}{inner}{joint}", link("a", "0 0 0 0 0 0"))));
    close(&position(&found, "/m/arm::hand"), &[0.0, 0.0, 2.0]);
    let place = TestFolder::new();
    place.write("arm/model.sdf", &format!("<sdf version='1.9'>{inner}</sdf>"));
    let include = "<include merge='true'><uri>arm</uri><pose relative_to='a'>1 0 0 0 0 0</pose></include>";
    let joint = joint.replace("arm::hand", "hand");
    place.write("m.sdf", &sdf("1.9", &format!("{}{include}{joint}", link("a", "0 5 0 0 0 0"))));
    let done = place.tatu(&["check", "m.sdf", "--numbers"]).good();
    let found: Json = serde_json::from_str(done.out.lines().last().unwrap()).unwrap();
    close(&position(&found, "/m/hand"), &[1.0, 5.0, 1.0]);
}

#[test]
fn sensors_look_ahead_with_their_noise() {
    let place = TestFolder::new();
    let rover = fs::read_to_string(root().join("plugins/importers/sdf/rover.sdf")).unwrap();
    place.write("rover.sdf", &rover);
    // A wall ahead, whose face is 2.5 m from the scanner at 0.15 m.
    let script = "function sysCall_init()\n  robot = sim.getObject('/rover')\n  scan = sim.getObject('./scanner')\n  steps = 0\nend\n\
                  function sysCall_actuation()\n  tatu.drive(robot, steps < 20 and 0 or 0.2, 0, 0)\nend\n\
                  function sysCall_sensing()\n  steps = steps + 1\n  if steps == 20 then\n    local d = tatu.read(scan).distance\n\
                  \n    sim.addStatusbarMessage(string.format('ahead %.3f right %.1f', d[91], d[1]))\n  end\nend\n";
    place.write("drive.lua", script);
    let floor = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";
    let import = "[[import]]\nfile = \"rover.sdf\"\nscript = \"drive.lua\"\n";
    place.write(
        "s.toml",
        &format!("format = 1\n{floor}{}{import}", cuboid("wall", [0.1, 4.0, 1.0], [2.7, 0.0, 0.5], "")),
    );
    place.tatu(&["run", "s.toml", "--seconds", "6", "--trace", "t.jsonl", "--watch", "/rover"]).good();
    let lines = place.lines("t.jsonl");
    let said: Vec<&str> = lines.iter().flat_map(|line| line.status()).collect();
    let said = said.join(" ");
    let ahead: f64 = said.split("ahead ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((ahead - 2.5).abs() < 0.06 && ahead != 2.5 && said.contains("right inf"), "{said}");
    // The drive of the file moves the robot along x, with the radius and the distance of the wheels of the file.
    let [x, y, _] = lines.last().unwrap().object("/rover", "position");
    assert!((x - 1.0).abs() < 0.03 && y.abs() < 0.01, "{x} {y}");
}

#[test]
fn flawed_xml_is_read_as_by_gazebo() {
    let good = sdf(
        "1.9",
        "<link name='l'><collision name='c'><geometry><sphere><radius>0.5</radius></sphere></geometry></collision></link>",
    );
    let flawed = format!(
        "\n  {}",
        good.replace("<model name=\"m\">", "<!-- --levels -- --><model name=m ignition:x='1'><gz:y/>")
    );
    let strip = |text: &str| figures(text)["bodies"].clone();
    assert_eq!(strip(&good), strip(&flawed));
    let place = TestFolder::new();
    place.write("m.sdf", &flawed.replace("0.5", "half"));
    // The line counts from the beginning of the flawed file.
    place.tatu(&["check", "m.sdf"]).good().reports(&["line 5", "<radius> is \"half\"; expected a number"]);
}

#[test]
fn hostile_files_are_refused_quickly() {
    // Placement frames that depend on those of all models inside, and ampersands that begin no reference.
    let inside = |depth: usize| (depth..24).map(|n| format!("m{n}::")).collect::<String>();
    let nested = (1..24).rev().fold(link("l", "0 0 0 0 0 0"), |inner, depth| {
        format!("<model name='m{depth}' placement_frame='{}l'>{inner}</model>", inside(depth + 1))
    });
    figures(&sdf("1.9", &nested));
    let ampersands = format!("<frame name='f'><pose>0 0 0 0 0 0</pose>{}</frame>", "& ".repeat(1_000_000));
    figures(&sdf("1.9", &format!("{}{ampersands}", link("l", "0 0 0 0 0 0"))));
    let refused = |text: &str, words: &[&str]| {
        let place = TestFolder::new();
        place.write("a/m.sdf", text);
        fs::create_dir_all(place.path().join("b")).unwrap();
        let words = [&["E120"][..], words].concat();
        run(program(), &place.path().join("a"), &["check", "m.sdf"], &[]).refused(&words);
    };
    let include = |uri: &str| sdf("1.9", &format!("{}<include><uri>{uri}</uri></include>", link("l", "0 0 0 0 0 0")));
    refused(&include("m.sdf"), &["m.sdf:4", "`m.sdf` includes itself"]);
    refused("<!DOCTYPE s [<!ENTITY a 'aa'><!ENTITY b '&a;&a;'>]><sdf version='1.9'>&b;</sdf>", &["document type"]);
    refused(&sdf("1.9", &format!("{}{}", "<a>".repeat(500), "</a>".repeat(500))), &["64 levels deep"]);
    refused(&sdf("1.9", "<link name='l'><pose>1e300 0 0 0 0 0</pose></link>"), &["m.sdf:4", "out of range"]);
    refused(&sdf("1.9", &joint("j", "revolute", ["a", "b"], "")), &["m.sdf:4", "does not exist"]);
    refused("<sdf version='1.9'/>", &["no model and no world"]);
    // Files outside of what may be read are left out.
    let place = TestFolder::new();
    place.write("secret/m.sdf", &sdf("1.9", "")).write("a/b/m.sdf", &include("../../secret/m.sdf"));
    run(program(), &place.path().join("a/b"), &["check", "m.sdf"], &[])
        .good()
        .reports(&["`../../secret/m.sdf` is outside the folders", "m.sdf: line 4: `../../secret/m.sdf` is left out"]);
    // Each file includes the next one twice.
    for i in 0..15 {
        let twice = format!("<include><uri>m{}.sdf</uri></include>", i + 1).repeat(2);
        place.write(&format!("m{i}.sdf"), &sdf("1.9", &format!("{}{twice}", "<link name='l'/>".repeat(40))));
    }
    place.write("m15.sdf", &sdf("1.9", &(0..40).map(|i| format!("<link name='l{i}'/>")).collect::<String>()));
    place.tatu(&["check", "m0.sdf"]).refused(&["E120", "more than"]);
}

/// Returns the ranges of the texts between tags, and of the values in quotes.
fn values(text: &str) -> Vec<std::ops::Range<usize>> {
    let ends = text.match_indices(['>', '"']).map(|(at, _)| at + 1);
    ends.filter_map(|from| {
        let length = text[from..].find(['<', '"'])?;
        (length > 0 && !text[from..from + length].trim().is_empty()).then_some(from..from + length)
    })
    .collect()
}

#[test]
fn any_file_runs_or_is_refused() {
    let mut search = SearchPath::default();
    search.folders.push((program().with_file_name("deps"), FolderOrigin::Built));
    search.built = ["tatu_importers_sdf", "tatu_sensors_imu", "tatu_sensors_laser"].map(str::to_owned).to_vec();
    let registry = load_registry(search);
    let rover = fs::read_to_string(root().join("plugins/importers/sdf/rover.sdf")).unwrap();
    let place = TestFolder::new();
    let file = place.path().join("m.sdf");
    let (mut good, mut bad) = (0, 0);
    let mut attempt = |text: &str, what: &str| {
        fs::write(&file, text).unwrap();
        match document::load(&file, &registry, &Default::default()) {
            Ok(document) => {
                let world = World::new(Arc::new(document), registry.clone()).unwrap_or_else(|e| panic!("{what}: {e}"));
                world.start();
                for _ in 0..2 {
                    world.step();
                }
                assert!(world.faults().is_empty(), "{what}: {:?}", world.faults());
                good += 1;
            }
            Err(e) => {
                assert_eq!(e.code, "E120", "{what}: {e}");
                assert!(!e.text.contains("panick"), "{what}: {e}");
                bad += 1;
            }
        }
    };
    attempt(&rover, "whole");
    for n in (0..rover.len()).step_by(97) {
        attempt(&rover[..rover.floor_char_boundary(n)], &format!("{n} bytes"));
    }
    for range in values(&rover) {
        for with in ["0", "-1", "nan", "1e300", "inf", "chassis", "0 0 0", "1e9 -1e9 1e9"] {
            let mut text = rover.clone();
            text.replace_range(range.clone(), with);
            attempt(&text, &format!("`{}` at {} becomes `{with}`", &rover[range.clone()], range.start));
        }
    }
    assert!(good > 100 && bad > 100, "{good} {bad}");
}

#[test]
fn joint_with_two_axes_finds_free_names_and_followers_of_its_second_axis() {
    let links = ["a", "hip_link", "b"].map(|name| link(name, "0 0 1 0 0 0")).concat();
    let axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>";
    let mimic = "<axis><xyz>0 0 1</xyz><mimic joint='hip' axis='axis2'><multiplier>3</multiplier></mimic></axis>";
    let joints =
        [joint("hip", "universal", ["a", "hip_link"], axes), joint("follower", "revolute", ["hip_link", "b"], mimic)];
    let place = TestFolder::new();
    place.write("m.sdf", &sdf("1.11", &format!("{links}{}", joints.concat())));
    let done = place.tatu(&["run", "m.sdf", "--seconds", "0.1"]).good();
    done.reports(&["two joints, `hip` and `hip_axis2`"]);
    let done = place.tatu(&["check", "m.sdf", "--numbers"]).good();
    let found: Json = serde_json::from_str(done.out.lines().last().unwrap()).unwrap();
    let joints = found["joints"].as_object().unwrap();
    let follower = joints.iter().find(|(path, _)| path.ends_with("/follower")).unwrap().1;
    assert!(follower.to_string().contains("hip_axis2"), "{follower}");
}

#[test]
fn place_of_a_world_on_earth_is_that_of_the_file() {
    let place = TestFolder::new();
    let coordinates = |latitude: &str| {
        format!(
            "<sdf version=\"1.9\"><world name=\"w\"><spherical_coordinates><latitude_deg>{latitude}</latitude_deg>\
             <longitude_deg>9</longitude_deg><elevation>400</elevation></spherical_coordinates>\
             <light name=\"lamp\" type=\"point\"><pose relative_to=\"gone\"/></light></world></sdf>"
        )
    };
    place.write("w.sdf", &coordinates("48"));
    let done = place.tatu(&["run", "w.sdf", "--seconds", "0.1", "--save", "w.toml"]).good();
    done.reports(&["the light `lamp` is incomplete", "the frame `gone`, which does not exist"]);
    let saved = fs::read_to_string(place.path().join("w.toml")).unwrap();
    assert!(saved.contains("lat") && saved.contains("400"), "{saved}");
    place.write("w.sdf", &coordinates("480"));
    place.tatu(&["run", "w.sdf", "--seconds", "0.1"]).refused(&["w.sdf:1", "not a place on Earth"]);
}
