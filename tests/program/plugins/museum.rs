//! Tests of old plugin binaries: they can be loaded, and behave as they did when they were built.

use std::{fs, path::PathBuf};

use sha2::{Digest, Sha256};

use crate::kit::*;

/// Returns the folders of `tests/museum`, one for each draft of the plugin interface that this host accepts. Each has
/// subfolders ("exhibits") with a binary, its scene, and the expected output.
fn rooms() -> Vec<PathBuf> {
    folders(&root().join("tests/museum"))
}

fn folders(of: &std::path::Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(of).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect();
    all.sort();
    assert!(!all.is_empty(), "{}", of.display());
    all
}

/// Returns the lines that the scripts of an exhibit's scene print, with this number of threads.
fn prints(exhibit: &std::path::Path, threads: &str) -> String {
    let place = TestFolder::new();
    copy(exhibit, place.path());
    // Some scripts need more steps than the others.
    let steps = match exhibit.file_name().and_then(|name| name.to_str()) {
        Some("cart") => "120",
        Some("holder") => "200",
        Some("magnet") => "20",
        Some("tether" | "uwb") => "110",
        _ => "40",
    };
    let args =
        ["run", "scene.toml", "--steps", steps, "--no-addons", "--allow", "plugins", "--threads", threads, "--json"];
    let done = run(program(), place.path(), &args, &[("TATU_PLUGIN_PATH", ".")]).good();
    assert!(!done.err.contains("warning") && !done.err.contains("error"), "{}: {}", exhibit.display(), done.err);
    // Keeps only the lines of scripts.
    let own = |l: &&str| !l.starts_with("plugin ");
    done.err.lines().filter(own).map(|l| format!("{l}\n")).collect()
}

#[test]
#[cfg_attr(not(all(target_arch = "x86_64", target_os = "linux")), ignore = "the binaries are of x86-64 Linux")]
fn archived_plugins_load_and_behave_as_recorded() {
    for room in rooms() {
        for exhibit in folders(&room) {
            let recorded = fs::read_to_string(exhibit.join("expected.txt")).unwrap();
            assert!(!recorded.is_empty());
            for threads in ["1", "2"] {
                assert_eq!(prints(&exhibit, threads), recorded, "{}", exhibit.display());
            }
        }
    }
}

#[test]
fn archived_files_match_their_checksums() {
    let mut bytes = 0;
    for room in rooms() {
        let sums = fs::read_to_string(room.join("SHA256SUMS")).unwrap();
        let listed: Vec<&str> = sums.lines().filter_map(|l| l.split_once("  ").map(|(_, file)| file)).collect();
        for line in sums.lines() {
            let (sum, file) = line.split_once("  ").unwrap();
            let content = fs::read(room.join(file)).unwrap();
            let now: String = Sha256::digest(&content).iter().map(|b| format!("{b:02x}")).collect();
            assert_eq!(now, sum, "{file}");
        }
        for exhibit in folders(&room) {
            for file in fs::read_dir(&exhibit).unwrap().map(|f| f.unwrap().path()) {
                let name = file.strip_prefix(&room).unwrap().to_str().unwrap().to_owned();
                assert!(listed.contains(&name.as_str()), "{name} has no checksum");
                bytes += fs::metadata(&file).unwrap().len();
            }
        }
    }
    assert!(bytes <= 2 << 20, "the museum has {bytes} bytes; the limit is 2 MiB");
}
