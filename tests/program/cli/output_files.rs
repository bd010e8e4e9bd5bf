//! Tests that files written by the program are complete or an error is reported, and that files are checked when read.

use std::{fs, path::Path, process::Command};

use crate::kit::*;

fn scene() -> TestFolder {
    TestFolder::scene(&format!(
        "{FLOOR}{}",
        cuboid("box", [0.1; 3], [0.0, 0.0, 0.5], "dynamic = true\nrespondable = true")
    ))
}

#[test]
#[cfg(unix)]
fn snapshots_and_pictures_preserve_modes_links_and_pipes() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    let place = scene();
    let at = |name: &str| place.path().join(name);
    let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode() & 0o777;
    place.write("kept", "old");
    fs::set_permissions(at("kept"), fs::Permissions::from_mode(0o600)).unwrap();
    symlink("kept", at("link")).unwrap();
    succeed(Command::new("mkfifo").arg(at("pipe")));
    let snapshot = |name: &str| place.run(&["--seconds", "0.5", "--snapshot-at", "0.2", name]);
    let look = |name: &str| {
        place.tatu(&["look", "scene.toml", "--from", "1,1,1", "--to", "0,0,0", "--size", "16x16", "-o", name])
    };
    for write in [&snapshot as &dyn Fn(&str) -> RunOutput, &look] {
        write("link").good();
        assert!(fs::symlink_metadata(at("link")).unwrap().is_symlink() && fs::metadata(at("kept")).unwrap().len() > 10);
        assert_eq!(mode(&at("kept")), 0o600);
        let done = write("pipe");
        assert_ne!(done.code, 0);
        done.reports(&["error[E105]", "not a plain file"]);
        assert!(fs::symlink_metadata(at("pipe")).unwrap().file_type().is_fifo());
        write("new").good();
        assert_eq!(mode(&at("new")) & 0o600, 0o600);
        write("nowhere/file").reports(&["error[E105]", "nowhere/file"]);
    }
    // No incomplete file is left behind.
    let rest = fs::read_dir(place.path())
        .unwrap()
        .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().ends_with(".part"));
    assert_eq!(rest.count(), 0);
}

/// The checksums are valid, but the contents are not.
#[test]
fn forged_snapshots_end_in_an_error_or_in_a_run() {
    let place = scene();
    place.run(&["--seconds", "0.5", "--snapshot-at", "0.2", "snap"]).good();
    let whole = fs::read(place.path().join("snap")).unwrap();
    for n in 1..40 {
        let mut forged = whole.clone();
        let at = 20 + (whole.len() - 20) * n / 40;
        forged[at] ^= 1 << (n % 8);
        let sum = xxhash_rust::xxh3::xxh3_64(&forged[20..]);
        forged[12..20].copy_from_slice(&sum.to_le_bytes());
        fs::write(place.path().join("forged"), forged).unwrap();
        let done = place.run(&["--seconds", "0.5", "--from", "forged"]);
        assert!((0..=2).contains(&done.code) && !done.err.contains("panicked"), "{at}: {} {}", done.code, done.err);
    }
}

#[test]
fn the_line_of_a_damaged_file_is_shown() {
    let place = scene();
    place.run(&["--steps", "20", "--trace", "a.jsonl"]).good();
    let trace = place.read("a.jsonl");
    let mut lines: Vec<&str> = trace.lines().collect();
    lines[6] = "{ nonsense";
    place.write("b.jsonl", &lines.join("\n"));
    let done = place.tatu(&["diff", "a.jsonl", "b.jsonl"]);
    done.refused(&["error[E119]", "b.jsonl:7:", "nonsense"]);
}

#[test]
fn traces_that_differ_in_any_field_are_not_equal() {
    let place = scene();
    place.run(&["--steps", "20", "--trace", "a.jsonl"]).good();
    let trace = place.read("a.jsonl");
    let changed = trace.lines().enumerate().map(|(i, l)| match i {
        4 => l.replacen('{', "{\"wind\":3,", 1) + "\n",
        _ => format!("{l}\n"),
    });
    place.write("b.jsonl", &changed.collect::<String>());
    let done = place.tatu(&["diff", "a.jsonl", "b.jsonl"]);
    assert_eq!(done.code, 1, "{}", done.out);
    assert!(done.out.starts_with("step 5 ") && done.out.contains("`wind`: nothing and 3"), "{}", done.out);
    assert_eq!(place.tatu(&["diff", "a.jsonl", "a.jsonl"]).good().out, "equal: 20 steps\n");
}

#[test]
fn a_log_that_was_edited_is_found() {
    let place = scene();
    place.write("keys", "0.1 a\n0.3 b\n0.5 c\n0.7 d\n");
    place.run(&["--seconds", "1", "--keys", "keys", "--log", "run.log"]).good();
    place.tatu(&["run", "--replay", "run.log"]).good();
    let log = place.read("run.log");
    let lines: Vec<&str> = log.lines().collect();
    assert_eq!(lines.len(), 6, "header, four keys, end: {log}");
    let replay = |lines: &[&str]| {
        place.write("bad.log", &(lines.join("\n") + "\n"));
        place.tatu(&["run", "--replay", "bad.log"])
    };
    // One line is missing, two are swapped, or one is repeated.
    for (order, line) in [([0, 1, 3, 4, 5, 5], 3), ([0, 2, 1, 3, 4, 5], 2), ([0, 1, 1, 2, 3, 4], 3)] {
        replay(&order.map(|i| lines[i])).refused(&["error[E116]", &format!("bad.log:{line}:"), "damaged"]);
    }
    // A digit is changed in each line in turn.
    for (i, line) in lines.iter().enumerate() {
        for at in (0..line.len()).filter(|at| line.as_bytes()[*at].is_ascii_digit()).step_by(7) {
            let mut changed = line.as_bytes().to_vec();
            changed[at] = if changed[at] == b'9' { b'1' } else { changed[at] + 1 };
            let changed = String::from_utf8(changed).unwrap();
            let mut all = lines.clone();
            all[i] = &changed;
            replay(&all).refused(&["error[E116]"]);
        }
    }
    // A log truncated at the end is replayed up to its last line, with a note.
    replay(&lines[..4]).good().reports(&["did not end normally"]);
    // A valid log of another run is detected at the end.
    let other = sealed_anew(&log, |l| match l.split_once(",\"hash\":") {
        Some((open, _)) => format!("{open},\"hash\":\"{:016x}\"", 7),
        None => l.to_owned(),
    });
    place.write("other.log", &other);
    let done = place.tatu(&["run", "--replay", "other.log"]);
    assert_eq!(done.code, 1);
    done.reports(&["error[E504]", "0000000000000007"]);
}

/// Pipes are refused, because they may be endless.
#[test]
#[cfg(unix)]
fn scenes_and_scripts_are_plain_files() {
    let place = scene();
    succeed(Command::new("mkfifo").arg(place.path().join("pipe.toml")));
    succeed(Command::new("mkfifo").arg(place.path().join("pipe.lua")));
    place.tatu(&["check", "pipe.toml"]).refused(&["error[E105]", "pipe.toml", "not a plain file"]);
    let done = place.tatu(&["check", "scene.toml", "--script", "/box=pipe.lua"]);
    done.refused(&["pipe.lua", "not a plain file"]);
    // Devices are refused for the same reason, even behind symbolic links.
    std::os::unix::fs::symlink("/dev/zero", place.path().join("zero.jsonl")).unwrap();
    place.write("one.jsonl", "{\"step\": 0, \"hash\": \"0\"}\n");
    for args in [
        ["diff", "zero.jsonl", "zero.jsonl"],
        ["diff", "one.jsonl", "pipe.toml"],
        ["run", "--replay", "zero.jsonl"],
        ["run", "--replay", "pipe.toml"],
    ] {
        place.tatu(&args).refused(&["error[E105]", "not a plain file"]);
    }
    for args in [
        ["run", "scene.toml", "--from", "zero.jsonl"],
        ["run", "--stand-ins", "--script", "pipe.lua"],
        ["run", "scene.toml", "--addon", "pipe.lua"],
    ] {
        place.tatu(&args).refused(&["not a plain file"]);
    }
}

/// The program waits for keys from a pipe to which nothing is written, and exits on a signal.
#[test]
#[cfg(target_os = "linux")]
fn a_signal_ends_a_run_that_waits_for_keys() {
    let place = scene();
    succeed(Command::new("mkfifo").arg(place.path().join("pipe")));
    for signal in ["-INT", "-TERM"] {
        let mut child = Command::new(program());
        let mut child = child.args(["run", "scene.toml", "--keys", "pipe"]).current_dir(place.path()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(500));
        succeed(Command::new("kill").args([signal, &child.id().to_string()]));
        let ended = (0..200).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            child.try_wait().unwrap().is_some()
        });
        if !ended {
            child.kill().unwrap();
        }
        assert!(ended, "{signal}");
    }
}
