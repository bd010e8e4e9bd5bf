//! Tests of the state of sensors that measure after each physics step: the same readings with any number of threads,
//! after a snapshot, and in a replay.

use crate::kit::*;

fn sensor(kind: &str, parent: &str, keys: &str) -> String {
    format!("[[object]]\nkind = \"sensor\"\nalias = \"{kind}\"\nsensor = \"{kind}\"\nparent = \"{parent}\"\n{keys}\n")
}

/// Returns a cart with a wheel and a tool, on which boxes fall, and the paths of its sensors: one of each kind that
/// measures after each physics step. Together, their noise uses every stage that has state.
fn cart() -> (String, Vec<&'static str>) {
    let body = "dynamic = true\nrespondable = true\n";
    let walk = "random_walk = 0.01, walk = { sigma = 0.01, tau_s = 1.0 }, density = 0.001";
    let cart = cuboid("cart", [0.6, 0.4, 0.1], [0.0, 0.0, 0.25], &format!("{body}mass_kg = 4.0"));
    let motor = "[[object]]\nkind = \"joint\"\nalias = \"motor\"\nparent = \"/cart\"\nposition_m = [0.0, 0.3, -0.1]\n\
        orientation_deg = [-90.0, 0.0, 0.0]\ncontrol = \"velocity\"\ntarget_velocity_rad_s = 9.0\nmax_force_nm = 5.0\n";
    let wheel = format!(
        "[[object]]\nkind = \"shape\"\nalias = \"wheel\"\nparent = \"/cart/motor\"\nprimitive = \"cylinder\"\n\
         size_m = [0.3, 0.3, 0.05]\n{body}mass_kg = 0.5\n"
    );
    let wrist =
        "[[object]]\nkind = \"force_sensor\"\nalias = \"wrist\"\nparent = \"/cart\"\nposition_m = [0.3, 0.0, 0.0]\n";
    let tool =
        cuboid("tool", [0.2, 0.05, 0.05], [0.12, 0.0, 0.0], &format!("parent = \"/cart/wrist\"\n{body}mass_kg = 0.3"));
    let boxes: String = (0..4)
        .map(|i| {
            cuboid(
                &format!("box_{i}"),
                [0.1; 3],
                [0.1 * f64::from(i) - 0.2, 0.03, 1.0 + 0.4 * f64::from(i)],
                &format!("{body}mass_kg = 0.7"),
            )
        })
        .collect();
    let scene = [
        FLOOR.to_owned(),
        cart,
        motor.to_owned(),
        wheel,
        wrist.to_owned(),
        tool,
        boxes,
        sensor("imu", "/cart", &format!("noise.acceleration = {{ {walk} }}\nnoise.angular_velocity = {{ {walk} }}")),
        sensor("wheel_encoder", "/cart/motor", "rate_hz = 77.0"),
        sensor("contact", "/cart", "noise.normal_force = { sigma = 0.1 }"),
        sensor("force_torque", "/cart/wrist", "preset = \"ati_axia80_m20\"\nnoise.latency_s = 0.03"),
        sensor("compass", "/cart", "preset = \"hmc5883l\""),
        sensor("floor", "/cart", "preset = \"qtr_8\"\nrange_m = 1.0\norientation_deg = [180.0, 0.0, 0.0]"),
        sensor("barometer", "/cart", "preset = \"bmp280\""),
        sensor(
            "battery",
            "/cart",
            "preset = \"lipo_3s\"\njoint = \"../motor\"\nidle_current_a = 1.0\ncapacity_ah = 0.01",
        ),
    ];
    let paths = vec![
        "/cart/imu",
        "/cart/motor/wheel_encoder",
        "/cart/contact",
        "/cart/wrist/force_torque",
        "/cart/compass",
        "/cart/floor",
        "/cart/barometer",
        "/cart/battery",
    ];
    (format!("seed = 9\n{}", scene.concat()), paths)
}

#[test]
fn inertial_readings_are_the_same_with_any_threads_after_a_snapshot_and_in_a_replay() {
    let (scene, paths) = cart();
    let place = TestFolder::scene(&scene);
    let watched: Vec<&str> = paths.iter().flat_map(|p| ["--watch", *p]).collect();
    let trace = |name: &str, more: &[&str]| {
        let all = [&["--seconds", "4", "--trace", name][..], &watched, more].concat();
        place.run(&all).good();
        place.read(name).lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let whole = trace("one.jsonl", &["--threads", "1", "--log", "run.log"]);
    assert_eq!(whole, trace("two.jsonl", &["--threads", "2"]), "2 threads");
    assert_eq!(whole, trace("four.jsonl", &["--threads", "4"]), "4 threads");
    assert_eq!(whole, trace("written.jsonl", &["--snapshot-at", "1.7", "state"]), "saving a snapshot changes the run");
    let rest = trace("rest.jsonl", &["--from", "state"]);
    let done = whole.len() - rest.len();
    assert!((30..40).contains(&done), "the resumed run starts after {done} steps");
    assert_eq!(whole[done..], rest, "the run from the snapshot differs");
    let all = [&["run", "--replay", "run.log", "--trace", "again.jsonl"][..], &watched].concat();
    place.tatu(&all).good();
    let again: Vec<String> = place.read("again.jsonl").lines().map(str::to_owned).collect();
    assert_eq!(whole[..80], again[..80], "the replay differs");
    // Each sensor has measured something.
    let lines = place.lines("one.jsonl");
    for path in paths {
        let told = |l: &TraceLine| l.0["readings"][path].to_string();
        let different: std::collections::BTreeSet<String> = lines.iter().map(told).collect();
        assert!(different.len() > 20, "{path} has only {} different readings", different.len());
    }
}
