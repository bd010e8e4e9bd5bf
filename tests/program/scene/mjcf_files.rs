//! Tests of MJCF files as files: what is included and omitted, errors with their lines, and hostile contents.

use std::{fs, sync::Arc};

use tatu_core::{
    World, document,
    plugins::{FolderOrigin, Registry, SearchPath},
};

use crate::kit::*;

const BALL: &str = "<mujoco model=\"m\"><worldbody><body name=\"b\" pos=\"0 0 1\"><freejoint/><geom size=\".1\"/></body>\
                    </worldbody></mujoco>";

#[test]
fn a_model_is_recognised_by_its_root_element() {
    let place = TestFolder::new();
    place.write("m.xml", BALL).write("m.txt", BALL).write("other.xml", "<robot_model/>");
    place.tatu(&["check", "m.xml"]).good();
    place.tatu(&["check", "m.txt"]).good();
    place.tatu(&["check", "other.xml"]).refused(&["E120", "other.xml:1", "<robot_model>", "expected <mujoco>"]);
}

#[test]
fn included_files_become_part_of_the_model() {
    let place = TestFolder::new();
    place
        .write("m.xml", "<mujoco model=\"m\"><include file=\"parts/robot.xml\"/><worldbody><geom type=\"plane\" size=\"1 1 1\"/></worldbody></mujoco>")
        // The name is relative to the main file's folder; the other one is found beside the including file.
        .write("parts/robot.xml", "<any><include file=\"parts/defaults.xml\"/><worldbody><include file=\"body.xml\"/></worldbody></any>")
        .write("parts/defaults.xml", "<x><default><geom density=\"500\"/></default></x>")
        .write("parts/body.xml", "<y><body name=\"b\" pos=\"0 0 1\"><freejoint/><geom size=\"1\"/></body></y>");
    let checked = place.tatu(&["check", "m.xml", "--json"]).good().json();
    assert_eq!(checked["bodies"][1]["path"], "/b");
    place.write("parts/body.xml", "<y><include file=\"parts/robot.xml\"/></y>");
    place.tatu(&["check", "m.xml"]).refused(&["E120", "parts/body.xml:1", "`parts/robot.xml` includes itself"]);
    place.write("parts/body.xml", "<y>\n<include file=\"none.xml\"/></y>");
    place.tatu(&["check", "m.xml"]).refused(&["E120", "parts/body.xml:2", "`none.xml` does not exist"]);
}

#[test]
fn files_outside_the_allowed_folders_are_not_read() {
    let place = TestFolder::new();
    place.write("secret.xml", "<x/>").write("inner/m.xml", "");
    let inner = place.path().join("inner");
    let mesh = |file: &str| {
        format!(
            "<mujoco><asset><mesh name=\"a\" file=\"{file}\"/></asset><worldbody><geom type=\"mesh\" mesh=\"a\"/></worldbody></mujoco>"
        )
    };
    let secret = place.path().join("secret.xml");
    let check = |text: &str| {
        place.write("inner/m.xml", text);
        run(program(), &inner, &["check", "m.xml"], &[])
    };
    for file in ["../secret.xml", secret.to_str().unwrap()] {
        let done = check(&format!("<mujoco><include file=\"{file}\"/></mujoco>"));
        done.refused(&["E120", "m.xml:1", "is outside the folders that the import may read"]);
    }
    // The model is read without the mesh.
    for file in ["../secret.stl", "../../../../etc/passwd.stl"] {
        check(&mesh(file)).good().reports(&["is outside the folders that may be read", "the mesh `a` is omitted"]);
    }
    // Only files of known formats are read as meshes.
    place.write("inner/m.xml", &mesh("notes.txt")).write("inner/notes.txt", "secret");
    run(program(), &inner, &["check", "m.xml"], &[])
        .good()
        .reports(&["the mesh `a` is omitted: the format is not supported"]);
}

#[test]
fn omitted_parts_are_reported_once_for_each_kind() {
    let place = TestFolder::new();
    place.write(
        "m.xml",
        "<mujoco model=\"m\">\n<worldbody>\n<geom size=\".1\" solref=\".1 1\" fluidcoef=\"1 1 1 1 1\"/>\n\
         <geom size=\".1\" solimp=\".9 .9 .1\" fluidcoef=\"1 1 1 1 1\"/>\n<body><joint name=\"j\"/><geom size=\".1\"/></body>\n\
         <plugin/>\n</worldbody>\n<actuator><muscle joint=\"j\"/></actuator>\n<deformable/>\n\
         <sensor><clock/></sensor>\n<tendon><spatial/></tendon>\n</mujoco>\n",
    );
    let done = place.tatu(&["check", "m.xml"]).good();
    done.reports(&[
        "the softness of contacts and limits",
        "(2 times, first in line 3)",
        "`fluidcoef` of <geom> is omitted (2 times, first in line 3)",
        "<plugin> is omitted (line 6)",
        "actuators of the kind <muscle> are omitted",
        "<deformable> is omitted (line 9)",
        "sensors of the kind `clock` are omitted",
        "spatial tendons are omitted (line 11)",
    ]);
    assert_eq!(done.err.matches("fluidcoef").count(), 1, "{}", done.err);
}

#[test]
fn errors_name_the_file_and_the_line() {
    let wrong: &[(&str, &str, &str)] = &[
        ("size=\".1\"", "size=\"one\"", "`size` of <geom> is \"one\"; expected numbers"),
        ("size=\".1\"", "size=\"0\"", "expected 1 lengths greater than 0"),
        ("size=\".1\"", "type=\"cone\" size=\".1\"", "expected a type of geoms"),
        ("size=\".1\"", "type=\"mesh\" mesh=\"none\"", "there is no mesh `none`"),
        ("size=\".1\"", "size=\".1\" class=\"none\"", "there is no default class `none`"),
        ("pos=\"0 0 1\"", "pos=\"0 0\"", "`pos` of <body> is \"0 0\"; expected 3 numbers"),
        ("pos=\"0 0 1\"", "quat=\"0 0 0 0\"", "expected a quaternion that is not 0"),
        ("<freejoint/>", "<joint axis=\"0 0 0\"/>", "expected a vector that is not 0"),
        ("<freejoint/>", "<joint range=\"1 -1\"/>", "expected the lower limit first"),
        ("<freejoint/>", "<freejoint/><joint/>", "must be at the top level and have no other joints"),
        ("<worldbody>", "<compiler coordinate=\"global\"/><worldbody>", "expected `local`"),
        ("</worldbody>", "</worldbdy>", "not well-formed XML"),
    ];
    for (from, to, words) in wrong {
        let place = TestFolder::new();
        let text = BALL.replacen(from, to, 1);
        assert_ne!(text, BALL);
        place.write("m.xml", &format!("\n\n{text}"));
        place.tatu(&["check", "m.xml"]).refused(&["E120", "m.xml:3", words]);
    }
}

#[test]
fn frames_replicas_and_attached_files_place_their_bodies() {
    let place = TestFolder::new();
    place
        .write(
            "m.xml",
            "<mujoco model=\"m\"><asset><model name=\"arm\" file=\"arm.xml\"/></asset><worldbody>\n\
             <replicate count=\"11\" offset=\"1 0 0\" sep=\"-\"><body name=\"r\" pos=\"0 1 0\"><geom size=\".1\"/></body></replicate>\n\
             <frame pos=\"0 0 2\" euler=\"0 0 90\"><attach model=\"arm\" body=\"hand\" prefix=\"left_\"/></frame>\n\
             </worldbody></mujoco>",
        )
        .write(
            "arm.xml",
            "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"hand\" pos=\"1 0 0\"><joint name=\"wrist\" range=\"-1 1\"/>\
             <geom size=\".1\"/></body></worldbody><actuator><motor joint=\"wrist\"/></actuator></mujoco>",
        );
    let lines = {
        let args = [
            "run",
            "m.xml",
            "--steps",
            "1",
            "--trace",
            "t.jsonl",
            "--watch",
            "/m/r-03",
            "--watch",
            "/m/left_hand_base/left_wrist/left_hand",
            "--json",
        ];
        place.tatu(&args).good();
        place.lines("t.jsonl")
    };
    assert_eq!(lines[0].object::<3>("/m/r-03", "position"), [3.0, 1.0, 0.0]);
    let [x, y, z] = lines[0].object::<3>("/m/left_hand_base/left_wrist/left_hand", "position");
    assert!(x.abs() < 1e-9 && (y - 1.0).abs() < 1e-9 && (z - 2.0).abs() < 1e-9, "{x} {y} {z}");
}

#[test]
fn hostile_files_are_refused_or_bounded() {
    let place = TestFolder::new();
    let refused = |text: &str, words: &[&str]| {
        place.write("m.xml", text);
        place.tatu(&["check", "m.xml"]).refused(words);
    };
    // Entities are not expanded.
    let laughs = "<!DOCTYPE m [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;\">]><mujoco model=\"&b;\"/>";
    // Such a file is not recognised by its first bytes, but by its suffix.
    refused(laughs, &["E120", "m.xml:1", "a document type declaration is not supported"]);
    let deep = format!("<mujoco>{}{}</mujoco>", "<worldbody>".repeat(400), "</worldbody>".repeat(400));
    refused(&deep, &["E120", "nests elements more than 200 levels deep"]);
    let replicas = |inner: &str| format!("<mujoco><worldbody>{inner}</worldbody></mujoco>");
    refused(&replicas("<replicate count=\"1000000000\"/>"), &["E120", "expected 0 to 10000"]);
    let nested = (0..4).fold("<site/>".to_owned(), |inner, _| format!("<replicate count=\"9999\">{inner}</replicate>"));
    refused(&replicas(&nested), &["E120", "the model has more than 50000"]);
    let empty = (0..60).fold(String::new(), |inner, _| format!("<replicate count=\"9999\">{inner}</replicate>"));
    refused(&replicas(&empty), &["E120", "the model has more than 50000"]);
    let field = "<mujoco><asset><hfield name=\"h\" nrow=\"1000000\" ncol=\"1000000\" size=\"1 1 1 1\"/></asset>\
                 <worldbody><geom type=\"hfield\" hfield=\"h\"/></worldbody></mujoco>";
    refused(field, &["E120", "samples in total"]);
}

/// Returns the byte ranges of the attribute values in an XML text.
fn values(text: &str) -> Vec<std::ops::Range<usize>> {
    let mut out = Vec::new();
    let mut from = 0;
    while let Some(open) = text[from..].find("=\"").map(|i| from + i + 2) {
        let close = open + text[open..].find('"').unwrap();
        out.push(open..close);
        from = close + 1;
    }
    out
}

/// A model with most kinds of elements.
const MIXED: &str = r#"<mujoco model="mixed"><compiler angle="degree" eulerseq="xyz" autolimits="true" boundmass="0.001"/>
<option timestep="0.002" gravity="0 0 -9.81"/>
<default><geom friction="1 0.005" condim="3"/><default class="c"><joint damping="1" armature="0.1"/><motor gear="5"/></default></default>
<asset><material name="red" rgba="1 0 0 1"/><mesh name="t" vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 2 1 0 1 3 0 3 2 1 2 3" scale="1 1 1"/></asset>
<worldbody><geom type="plane" size="1 1 1" material="red"/><light dir="0 0 -1"/><camera fovy="45" xyaxes="1 0 0 0 1 0"/>
<body name="a" pos="0 0 1" childclass="c"><freejoint/><geom type="capsule" fromto="0 0 0 0 0 1" size="0.1"/><site name="s" size="0.1"/>
<body name="b" pos="0 0 1" euler="0 10 0"><joint name="j" axis="0 1 0" range="-90 90" ref="5"/><joint name="k" type="slide" stiffness="10" springref="0.1"/>
<inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><geom type="mesh" mesh="t" contype="0" conaffinity="0"/></body>
<body name="d" pos="1 0 0"><joint name="l" type="ball"/><geom type="ellipsoid" size="0.1 0.2 0.1"/></body></body></worldbody>
<tendon><fixed name="f"><joint joint="j" coef="1"/></fixed></tendon>
<equality><joint joint1="k" joint2="j" polycoef="0 0.1"/><connect body1="d" body2="a" anchor="0 0 0.5"/></equality>
<actuator><motor class="c" joint="j"/><position joint="j" kp="10" dampratio="1"/><velocity tendon="f" kv="1"/></actuator>
<sensor><gyro site="s"/></sensor><keyframe><key name="home" qpos="0 0 1 1 0 0 0 5 0 1 0 0 0"/></keyframe></mujoco>"#;

#[test]
fn any_file_runs_or_is_refused() {
    let mut search = SearchPath::default();
    search.folders.push((program().with_file_name("deps"), FolderOrigin::Built));
    search.built = ["tatu_importers_mjcf", "tatu_sensors_imu"].map(str::to_owned).to_vec();
    let registry = Arc::new(Registry::load(search, tatu_core::host_tables()));
    let place = TestFolder::new();
    let file = place.path().join("m.xml");
    let (mut good, mut bad) = (0, 0);
    let mut attempt = |text: &[u8], what: &str| {
        fs::write(&file, text).unwrap();
        match document::load(&file, &registry, &Default::default()) {
            Ok(document) => {
                let world = World::new(Arc::new(document), registry.clone()).unwrap_or_else(|e| panic!("{what}: {e}"));
                world.start();
                for _ in 0..2 {
                    world.step();
                }
                good += 1;
            }
            Err(e) => {
                assert_eq!(e.code, "E120", "{what}: {e}");
                assert!(e.place.as_ref().is_some_and(|p| p.file == file) && !e.text.contains("panick"), "{what}: {e}");
                bad += 1;
            }
        }
    };
    attempt(MIXED.as_bytes(), "whole");
    for n in (0..MIXED.len()).step_by(97) {
        attempt(&MIXED.as_bytes()[..n], &format!("{n} bytes"));
    }
    for range in values(MIXED) {
        for with in ["", "0", "-1", "nan", "1e300", "inf 0 0", "a/b", "0 0 0", "1e9 -1e9 1e9"] {
            let mut text = MIXED.to_owned();
            text.replace_range(range.clone(), with);
            attempt(text.as_bytes(), &format!("`{}` at {} becomes `{with}`", &MIXED[range.clone()], range.start));
        }
    }
    assert!(good > 100 && bad > 100, "{good} {bad}");
}
