//! Tests with a limited address space, as set by clusters and `ulimit -v`: the results are the same, or an error is
//! reported.
#![cfg(target_os = "linux")]

use std::process::Command;

use crate::kit::*;

/// Creates scripts that iterate over a table whose keys are tables and functions. Ordinary Lua would order these by
/// their addresses.
fn scene(scripts: usize) -> TestFolder {
    let script = "
        function sysCall_init()
          local keys, all = {}, {}
          for i = 1, 50 do keys[i] = {i} all[keys[i]] = i all[function() end] = -i end
          local order = ''
          for _, v in pairs(all) do order = order .. v .. ' ' end
          print('> ' .. order)
        end";
    TestFolder::scene(&(0..scripts).map(|i| watcher(&format!("w{i}"), script)).collect::<String>())
}

/// Runs the scripts with an address space of `mb` MB. Returns the lines that they print, and the result of the run.
fn orders(place: &TestFolder, mb: usize) -> (Vec<String>, RunOutput) {
    let line = format!("ulimit -v {}; exec \"$0\" run scene.toml --steps 2", mb << 10);
    let output = Command::new("sh").args(["-c", &line]).arg(program()).current_dir(place.path()).output().unwrap();
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    let done = RunOutput {
        code: output.status.code().unwrap_or(-1),
        signal: None,
        out: text(&output.stdout),
        err: text(&output.stderr),
    };
    let all = done.out.clone() + &done.err;
    (all.lines().filter(|l| l.starts_with("> ")).map(str::to_owned).collect(), done)
}

#[test]
fn eight_scripts_need_no_more_than_their_slots() {
    let place = scene(8);
    let free = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    let all = free.out.clone() + &free.err;
    let whole: Vec<&str> = all.lines().filter(|l| l.starts_with("> ")).collect();
    assert_eq!(whole.len(), 8);
    let (short, done) = orders(&place, 5000);
    assert_eq!((short, done.code), (whole.iter().map(|s| (*s).to_owned()).collect(), 0), "{}", done.err);
    assert!(!done.err.contains("address space"), "{}", done.err);
}

#[test]
fn too_little_address_space_is_reported() {
    let (lines, done) = orders(&scene(8), 1200);
    assert_eq!((lines.len(), done.code), (8, 0), "{}", done.err);
    done.reports(&["address space is too small", "ulimit -v"]);
    assert_eq!(done.err.matches("address space is too small").count(), 1);
}

#[test]
fn a_strict_run_fails_on_warnings() {
    let place = scene(8);
    let line = format!("ulimit -v {}; exec \"$0\" run scene.toml --steps 2 --strict", 1200 << 10);
    let output = Command::new("sh").args(["-c", &line]).arg(program()).current_dir(place.path()).output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{err}");
    assert!(err.contains("address space is too small") && err.contains("error[E123]"), "{err}");
    let done = place.run(&["--steps", "2", "--strict"]).good();
    assert_eq!(done.json()["warnings"], serde_json::json!([]));
    // A script logs a warning during the run.
    let place = TestFolder::scene(&watcher(
        "d",
        "function sysCall_actuation() sim.addLog(sim.verbosity_warnings, 'low battery') end",
    ));
    let done = place.run(&["--steps", "2", "--strict"]);
    assert_eq!(done.code, 1, "{}", done.err);
    assert!(done.json()["warnings"][0].as_str().unwrap().contains("low battery"), "{}", done.out);
    place.run(&["--steps", "2"]).good();
}

/// Scripts reserve most of the address space, but leave enough for the rest of the program.
#[test]
fn reservations_of_scripts_leave_room_for_the_rest() {
    let place = scene(12);
    let camera =
        "[[object]]\nkind = \"sensor\"\nalias = \"eye\"\nsensor = \"depth_camera\"\ncolumns = 2048\nrows = 2048\n";
    let text = place.read("scene.toml");
    place.write("scene.toml", &format!("{text}{camera}"));
    for mb in (1800..2120).step_by(32) {
        let (lines, done) = orders(&place, mb);
        assert_eq!((lines.len(), done.code), (12, 0), "{mb} MB: {}", done.err);
    }
}

/// An image that does not fit into memory is an error of its sensor.
#[test]
fn an_image_beyond_memory_is_reported() {
    let camera =
        "[[object]]\nkind = \"sensor\"\nalias = \"eye\"\nsensor = \"depth_camera\"\ncolumns = 8192\nrows = 8192\n";
    let (_, done) = orders(&TestFolder::scene(camera), 2000);
    assert!((0..=2).contains(&done.code), "{}: {}", done.code, done.err);
    done.reports(&["8192 x 8192 pixels", "ulimit -v"]);
}
