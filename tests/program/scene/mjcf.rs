//! Tests of the MJCF importer: masses, poses, joints and drives, against formulas.

use std::{fs, sync::Arc};

use tatu_core::{
    document,
    plugins::{FolderOrigin, Registry, SearchPath},
    scene::{Scene, get, property_table::Property},
};
use tatu_plugin_api::safe::Value;

use crate::kit::*;

/// Reads a file into a scene in this process, with the plugins next to the program.
fn scene(place: &TestFolder, file: &str) -> Scene {
    let mut search = SearchPath::default();
    search.folders.push((program().with_file_name("deps"), FolderOrigin::Built));
    search.built = vec!["tatu_importers_mjcf".into()];
    let registry = Arc::new(Registry::load(search, tatu_core::host_tables()));
    document::load(&place.path().join(file), &registry, &Default::default()).unwrap().instantiate().0
}

fn value(scene: &Scene, path: &str, row: Property) -> Vec<f64> {
    let slot = scene.find(0, path).unwrap_or_else(|| panic!("there is no {path}"));
    match get(scene, slot, row).unwrap() {
        Value::Floats(f) => f,
        Value::Float(f) => vec![f],
        other => panic!("{other:?}"),
    }
}

fn close(found: &[f64], wanted: &[f64], within: f64) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= within * b.abs().max(1.0);
    assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(near), "{found:?} instead of {wanted:?}");
}

/// Returns a model with these elements in its world, and what follows the world.
fn mjcf(world: &str, more: &str) -> String {
    format!("<mujoco model=\"m\">\n<worldbody>\n{world}\n</worldbody>\n{more}\n</mujoco>\n")
}

/// Runs a model for a while; returns the last line of the trace for these objects.
fn last(text: &str, seconds: &str, watch: &[&str]) -> TraceLine {
    let place = TestFolder::new();
    place.write("m.xml", text);
    let mut args =
        vec!["run", "m.xml", "--set", "scene.dt_s=0.01", "--seconds", seconds, "--trace", "t.jsonl", "--json"];
    watch.iter().for_each(|path| args.extend(["--watch", path]));
    place.tatu(&args).good();
    place.lines("t.jsonl").pop().unwrap()
}

fn joint(line: &TraceLine, path: &str, what: &str) -> f64 {
    line.0["objects"][path]["joint"][what].as_f64().unwrap()
}

#[test]
fn masses_follow_from_classes_densities_and_stated_inertias() {
    let place = TestFolder::new();
    let text = mjcf(
        r#"<body name="a" pos="0 0 1" childclass="heavy"><freejoint/>
             <geom type="box" size=".1 .2 .3"/>
             <geom class="light" type="sphere" size=".1" pos="0 0 .5" contype="0" conaffinity="0"/>
             <body name="fixed" pos="1 0 0" euler="0 0 90"><inertial pos="0 .5 0" mass="2" diaginertia=".1 .2 .25"/></body>
           </body>"#,
        r#"<default><default class="heavy"><geom density="2000"/><default class="light"><geom mass="3"/></default>
           </default></default>"#,
    );
    place.write("m.xml", &text);
    let scene = scene(&place, "m.xml");
    // Full extents of 0.2, 0.4 and 0.6 m at 2000 kg/m^3; the ball states its mass; the fixed body is turned, so that its
    // y axis points along -x.
    let (solid, ball, fixed) = (96.0, 3.0, 2.0);
    let mass: f64 = solid + ball + fixed;
    close(&value(&scene, "/m/a", Property::MASS), &[mass], 1e-12);
    let com = [(0.5 * fixed) / mass, 0.0, 0.5 * ball / mass];
    close(&value(&scene, "/m/a", Property::COM), &com, 1e-12);
    // Parallel axes: x and y of the fixed body are exchanged.
    let of_box = [0.2f64, 0.4, 0.6].map(|x| x * x / 12.0);
    let of_ball = 0.4 * ball * 0.01;
    let about = |i: usize, own: [f64; 3], m: f64, at: [f64; 3]| {
        let d: Vec<f64> = (0..3).map(|k| at[k] - com[k]).collect();
        own[i] + m * (d[(i + 1) % 3] * d[(i + 1) % 3] + d[(i + 2) % 3] * d[(i + 2) % 3])
    };
    let own = [solid * (of_box[1] + of_box[2]), solid * (of_box[0] + of_box[2]), solid * (of_box[0] + of_box[1])];
    let inertia = value(&scene, "/m/a", Property::INERTIA);
    for i in 0..3 {
        let wanted = about(i, own, solid, [0.0; 3])
            + about(i, [of_ball; 3], ball, [0.0, 0.0, 0.5])
            + about(i, [0.2, 0.1, 0.25], fixed, [0.5, 0.0, 0.0]);
        close(&[inertia[4 * i]], &[wanted], 1e-12);
    }
}

#[test]
fn several_joints_of_a_body_act_in_order_and_count_from_their_reference() {
    let place = TestFolder::new();
    let text = mjcf(
        r#"<body name="b" pos="0 0 1"><joint name="x" type="slide" axis="1 0 0" ref=".5"/>
           <joint name="turn" axis="0 0 1" pos="1 0 0" range="-180 180"/><geom size=".1" mass="1"/></body>"#,
        r#"<keyframe><key name="home" qpos=".75 1.5707963267948966"/></keyframe>"#,
    );
    place.write("m.xml", &text);
    let scene = scene(&place, "m.xml");
    // The slide moves by 0.75 - 0.5; then the body turns by 90 degrees about a point 1 m in front of it.
    let pose = value(&scene, "/m/b_base/x/b_link_1/turn/b", Property::WORLD_POSE);
    close(&pose[..3], &[1.25, -1.0, 1.0], 1e-12);
    let half = 0.5f64.sqrt();
    close(&pose[3..], &[0.0, 0.0, half, half], 1e-12);
    // Body and link together have the mass of the file.
    let mass = |path: &str| value(&scene, path, Property::MASS)[0];
    close(&[mass("/m/b_base/x/b_link_1/turn/b") + mass("/m/b_base/x/b_link_1")], &[1.0], 1e-15);
}

#[test]
fn frames_and_replicas_move_masses_and_turn_offsets() {
    let place = TestFolder::new();
    let text = mjcf(
        r#"<body name="b" pos="0 0 1"><freejoint/><frame pos="1 0 0" euler="0 0 90"><geom size=".1" pos="2 0 0" mass="1"/></frame></body>
           <replicate count="3" offset="1 0 0" euler="0 0 90"><body name="r"><geom size=".1"/></body></replicate>"#,
        "",
    );
    place.write("m.xml", &text);
    let scene = scene(&place, "m.xml");
    close(&value(&scene, "/m/b", Property::COM), &[1.0, 2.0, 0.0], 1e-12);
    // The second offset is along the axes of the second replica, which is turned by 90 degrees.
    close(&value(&scene, "/m/r2", Property::WORLD_POSE), &[1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], 1e-12);
}

#[test]
fn a_motor_accelerates_its_joint_by_gear_and_armature() {
    let text = mjcf(
        r#"<body name="b"><joint name="j" type="slide" axis="1 0 0" armature="0.5"/><geom size=".1" mass="2"/></body>"#,
        r#"<actuator><motor joint="j" gear="10" ctrlrange="-1 1"/></actuator>
           <keyframe><key name="home" qpos="0" ctrl="3"/></keyframe>"#,
    );
    // The control is limited to 1: v = 10 N / 2.5 kg * t.
    let line = last(&text, "1", &["/m/b_base/j"]);
    close(&[joint(&line, "/m/b_base/j", "velocity")], &[10.0 / 2.5 * line.time()], 1e-6);
}

#[test]
fn a_motor_accelerates_a_joint_among_several_as_if_there_were_no_links() {
    let text = mjcf(
        r#"<body name="b"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
           <joint name="turn" axis="0 0 1"/><geom type="box" size=".1 .1 .1" mass="2"/></body>"#,
        r#"<option gravity="0 0 0"/><actuator><motor joint="x"/><motor joint="turn"/></actuator>
           <keyframe><key name="home" qpos="0 0 0" ctrl="4 .01"/></keyframe>"#,
    );
    let [x, turn] = ["/m/b_base/x", "/m/b_base/x/b_link_1/y/b_link_2/turn"];
    let line = last(&text, "1", &[x, turn]);
    // v = F t / m; w = M t / I, with I = 2 kg * 0.2^2 m^2 / 6. The links make up 2/10,000 of the mass.
    close(&[joint(&line, x, "velocity")], &[2.0 * line.time()], 1e-6);
    let wanted = 0.01 / (2.0 * 0.04 / 6.0) * line.time();
    close(&[joint(&line, turn, "velocity") / wanted], &[1.0], 3e-4);
}

#[test]
fn a_position_actuator_yields_under_load_as_its_gains_say() {
    let model = |more: &str| {
        mjcf(
            r#"<body name="b"><joint name="j" type="slide" axis="0 0 1" damping="20"/><geom size=".1" mass="2"/></body>"#,
            &format!("<actuator>{more}</actuator><keyframe><key name=\"home\" qpos=\"0\" ctrl=\"0.2\"/></keyframe>"),
        )
    };
    let weight = 2.0 * 9.81;
    for (actuator, wanted) in [
        ("<position joint=\"j\" kp=\"200\"/>", 0.2 - weight / 200.0),
        ("<position joint=\"j\" kp=\"200\" kv=\"10\" gear=\"2\"/>", 0.2 / 2.0 - weight / 800.0),
        // The gain on the control differs from that on the length.
        (
            "<general joint=\"j\" gainprm=\"50\" biastype=\"affine\" biasprm=\"10 -100\"/>",
            (50.0 * 0.2 + 10.0 - weight) / 100.0,
        ),
        // Without the type of the bias, its parameters mean nothing: a constant force of 50 * 0.2 N against damping.
        ("<position class=\"stiff\" joint=\"j\"/>", 0.2 - weight / 500.0),
    ] {
        let text = model(actuator).replace(
            "<worldbody>",
            "<default><default class=\"stiff\"><position kp=\"500\"/></default></default>\n<worldbody>",
        );
        let line = last(&text, "6", &["/m/b_base/j"]);
        close(&[joint(&line, "/m/b_base/j", "position")], &[wanted], 1e-5);
    }
    // As a servo that holds its target, it does not yield.
    let place = TestFolder::scene("[[import]]\nfile = \"m.xml\"\nservos = \"hold\"\n");
    place.write("m.xml", &model("<position joint=\"j\" kp=\"200\" forcerange=\"-100 100\"/>"));
    let lines = place.trace(&["/m/b_base/j"], &["--seconds", "3"]);
    close(&[joint(lines.last().unwrap(), "/m/b_base/j", "position")], &[0.2], 1e-4);
}

#[test]
fn a_velocity_actuator_creeps_under_load() {
    let text = mjcf(
        r#"<body name="b"><joint name="j" type="slide" axis="0 0 1"/><geom size=".1" mass="2"/></body>"#,
        "<actuator><velocity joint=\"j\" kv=\"40\"/></actuator>",
    );
    // The load of 2 kg lowers the velocity by m g / kv.
    let line = last(&text, "2", &["/m/b_base/j"]);
    close(&[joint(&line, "/m/b_base/j", "velocity")], &[-2.0 * 9.81 / 40.0], 1e-6);
}

#[test]
fn coupled_fingers_follow_the_driven_one() {
    let finger = |name: &str, sign: f64| {
        format!(
            "<body name=\"{name}\" pos=\"0 {} 0\"><joint name=\"{name}\" type=\"slide\" axis=\"0 {sign} 0\" damping=\"5\"/>\
             <geom size=\".01\" mass=\".1\"/></body>",
            0.1 * sign
        )
    };
    let hand =
        format!("<body name=\"hand\"><geom size=\".05\"/>{}{}</body>", finger("left", 1.0), finger("right", -1.0));
    let couple = r#"<equality><joint joint1="right" joint2="left" polycoef="0 1 0 0 0"/></equality>"#;
    let tendon = r#"<tendon><fixed name="both"><joint joint="left" coef=".5"/><joint joint="right" coef=".5"/></fixed></tendon>"#;
    for (actuator, target) in [
        ("<position joint=\"left\" kp=\"100\"/>", 0.03),
        // The driven finger leads, although the constraint names it as the follower.
        ("<position joint=\"right\" kp=\"100\"/>", 0.03),
        ("<position tendon=\"both\" kp=\"100\"/>", 0.03),
    ] {
        let more = format!(
            "{tendon}{couple}<actuator>{actuator}</actuator><keyframe><key name=\"home\" ctrl=\"0.03\"/></keyframe>"
        );
        let line = last(&mjcf(&hand, &more), "4", &["/m/hand/left", "/m/hand/right"]);
        for side in ["left", "right"] {
            close(&[joint(&line, &format!("/m/hand/{side}"), "position")], &[target], 1e-4);
        }
    }
}

#[test]
fn a_standing_quadruped_has_the_height_that_mujoco_computes() {
    let place = TestFolder::new();
    fs::copy(root().join("plugins/importers/mjcf/quadruped.xml"), place.path().join("m.xml")).unwrap();
    let trunk = "/quadruped/trunk";
    place.tatu(&["run", "m.xml", "--seconds", "3", "--trace", "t.jsonl", "--watch", trunk, "--json"]).good();
    let line = place.lines("t.jsonl").pop().unwrap();
    let [_, _, height] = line.object::<3>(trunk, "position");
    // `mujoco` 4.0.0 after 3 s from the keyframe.
    assert!((height - 0.3205).abs() < 0.005, "{height}");
}

#[test]
fn a_connected_rod_swings_like_a_hinged_one() {
    let rod = r#"<geom type="box" size=".5 .02 .02" mass="1"/>"#;
    let hinged = mjcf(
        &format!("<body name=\"a\" pos=\"0 0 1\"><joint name=\"j\" axis=\"0 1 0\" pos=\"-.5 0 0\"/>{rod}</body>"),
        "",
    );
    let connected = mjcf(
        &format!("<body name=\"a\" pos=\"0 0 1\"><freejoint/>{rod}</body>"),
        "<equality><connect body1=\"a\" anchor=\"-.5 0 0\"/></equality>",
    );
    let at = |text: &str, path: &str| last(text, "0.6", &[path]).object::<3>(path, "position");
    let (one, other) = (at(&hinged, "/m/a_base/j/a"), at(&connected, "/m/a"));
    // The ends swing by a few m/s; the loop is closed by impulses, and its link has a mass.
    close(&other, &one, 0.01);
    assert!(one[2] < 0.9, "{one:?}");
}

#[test]
fn welded_bodies_hang_together() {
    let ball = |name: &str, y: f64| {
        format!("<body name=\"{name}\" pos=\"0 {y} 1\"><freejoint/><geom size=\".1\" mass=\"1\"/></body>")
    };
    let text = mjcf(
        &(ball("v", 0.0) + &ball("w", 1.0)),
        "<equality><weld body1=\"v\"/><weld body1=\"v\" body2=\"w\"/></equality>",
    );
    let line = last(&text, "1", &["/m/v", "/m/w"]);
    close(&line.object::<3>("/m/v", "position"), &[0.0, 0.0, 1.0], 2e-3);
    close(&line.object::<3>("/m/w", "position"), &[0.0, 1.0, 1.0], 5e-3);
}

#[test]
fn sites_carry_the_sensors_of_the_file() {
    let text = mjcf(
        r#"<geom type="plane" size="1 1 1"/>
           <body name="b" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/><site name="s"/>
             <site name="sole" pos="0 0 -.1" type="box" size=".11 .11 .01"/>
             <site name="eye" pos="0 0 .1"/></body><geom type="box" size=".1 .1 .1" pos="0 0 1.3"/>"#,
        r#"<sensor><gyro name="g" site="s"/><accelerometer name="a" site="s"/><touch name="t" site="sole"/>
           <rangefinder name="r" site="eye"/></sensor>"#,
    );
    let [imu, touch, eye] = ["/m/b/s/g", "/m/b/sole/t", "/m/b/eye/r"];
    let line = last(&text, "1", &[imu, touch, eye]);
    let value = |path: &str, field: &str| line.sensor(path, field);
    close(&numbers(&line.0["readings"][imu]["imu.acceleration"])[2..], &[9.81], 1e-3);
    close(&[value(touch, "contact.normal_force")], &[9.81], 1e-3);
    // From the top of the box at 0.2 m to the bottom of the one at 1.2 m.
    close(&[value(eye, "proximity.distance")], &[1.0], 2e-3);
}

#[test]
fn self_collisions_are_those_of_mujoco() {
    let place = TestFolder::new();
    let body = |name: &str, attributes: &str, children: &str| {
        format!(
            "<body name=\"{name}\"><joint axis=\"0 1 0\"/><geom type=\"box\" size=\".1 .1 .1\" {attributes}/>{children}\
             </body>"
        )
    };
    // a carries b and e; b carries c, and c carries d.
    let chain = body("b", "", &body("c", "", &body("d", "contype=\"2\" conaffinity=\"2\"", "")));
    let all = body("a", "", &format!("{chain}{}", body("e", "", "")));
    let excluded = r#"<contact><exclude body1="b" body2="e"/></contact>"#;
    place.write("m.xml", &mjcf(&all, excluded));
    place.write("s.toml", "format = 1\n[[import]]\nfile = \"m.xml\"\nself_collision = true\n");
    let scene = scene(&place, "s.toml");
    let mask = |name: &str| {
        let slot = scene.find(0, &format!("//{name}")).unwrap_or_else(|| panic!("there is no {name}"));
        match get(&scene, slot, Property::RESPONDABLE_MASK).unwrap() {
            Value::Int(mask) => mask & 0xFF,
            other => panic!("{other:?}"),
        }
    };
    let pairs = ["ab", "ac", "ad", "ae", "bc", "bd", "be", "cd", "ce", "de"];
    let collides = |pair: &&str| mask(&pair[..1]) & mask(&pair[1..]) != 0;
    let found: Vec<&str> = pairs.into_iter().filter(collides).collect();
    assert_eq!(found, ["ac", "ce"]);
}
