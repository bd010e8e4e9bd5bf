//! The course's scripts in Python drive its robots exactly as those in Lua do.

use crate::kit::*;

/// Scenes, and the scripts of their objects.
const SCENES: &[(&str, &[(&str, &str)])] = &[
    ("pioneer_braitenberg", &[("/Pioneer_p3dx", "avoid")]),
    ("pioneer_pose", &[("/Pioneer_p3dx", "print_pose")]),
    ("pioneer_console", &[("/Pioneer_p3dx", "print_sonars")]),
    ("pioneer_log_append", &[("/Pioneer_p3dx", "append_log")]),
    ("pioneer_statusbar", &[("/Pioneer_p3dx", "tell_sonars")]),
    ("pioneer_signals", &[("/Pioneer_p3dx", "tell_speeds"), ("/Hokuyo", "show_speeds")]),
    ("pioneer_follows_laser_signal", &[("/Pioneer_p3dx", "follow_laser")]),
    ("manta_keyboard_statusbar", &[("/Manta", "drive_by_keys")]),
    ("kinect_capture", &[("/kinect", "capture_kinect")]),
    ("gps", &[("/Pioneer_p3dx", "compare_gps")]),
];

#[test]
fn scripts_in_python_and_in_lua_lead_to_the_same_states() {
    for (scene, scripts) in SCENES {
        let file = root().join(format!("scenes/course/{scene}.toml")).display().to_string();
        // In this dialect, numbers pass as 32-bit floats, and readings are those of the time of the scripts in Lua.
        let common = ["run", &file, "--seconds", "10", "--keys", "keys", "--json", "--set", "scene.dialect=3.2"];
        let hash = |more: &[&str]| {
            let place = TestFolder::new();
            place.write("keys", "1.0 down\n2.0 left\n3.0 w\n4.0 right\n");
            let done = place.tatu(&[&common[..], more].concat()).good();
            (done.json()["hash"].clone(), std::fs::read(place.path().join("kinect_1_rgb.png")).ok())
        };
        let replaced: Vec<String> = scripts
            .iter()
            .map(|(object, script)| {
                format!("{object}={}", root().join(format!("scenes/course/python/{script}.py")).display())
            })
            .collect();
        let more: Vec<&str> = replaced.iter().flat_map(|r| ["--script", r]).chain(["--allow", "python"]).collect();
        assert_eq!(hash(&more), hash(&[]), "{scene}");
    }
}
