//! Tests of the simulator as a library for C: `libtatu.so` and `tatu_world.h`.

use std::{fs, path::PathBuf, process::Command};

use crate::kit::*;

/// Returns the folder into which cargo puts the libraries that the tests depend on.
fn built() -> PathBuf {
    program().parent().unwrap().join("deps")
}

fn compiled(place: &TestFolder, source: &str, language: &str) -> PathBuf {
    let (folder, program) = (built(), place.path().join("program"));
    let include = |path: &str| format!("-I{}", root().join(path).display());
    let done = Command::new(compiler(language))
        .args(["-Wall", "-Wextra", "-Werror", &include("hosts/libtatu/include"), &include("plugin-api/include")])
        .arg(source)
        .arg("-o")
        .arg(&program)
        .arg(format!("-L{}", folder.display()))
        .args(["-ltatu", "-lm", &format!("-Wl,-rpath,{}", folder.display())])
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    program
}

#[test]
fn a_c_program_runs_worlds_with_the_same_bits() {
    let place = TestFolder::new();
    let source = root().join("hosts/libtatu/examples/pioneer.c");
    let program = compiled(&place, source.to_str().unwrap(), "cc");
    let out = Command::new(program).current_dir(place.path()).output().unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(out.status.success(), "{said}{}", String::from_utf8_lossy(&out.stderr));
    let scene = root().join("scenes/first/pioneer_avoids_walls.toml");
    let run = Command::new(crate::kit::program())
        .args(["run", scene.to_str().unwrap(), "--steps", "100", "--json"])
        .output()
        .unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(said.contains(&format!("hash {}", summary["hash"].as_str().unwrap())), "{said}\n{summary}");
    for part in [
        "100 steps of 0.05 s",
        "7 numbers",
        "1 result",
        "the copy agrees, the restored one agrees",
        "the picture is rendered",
        "there is no object `/Nobody`",
        "has been closed",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

/// Fields keep their offsets, on which programs depend that were compiled with an earlier header.
#[test]
fn the_layout_of_the_setup_is_the_recorded_one() {
    let place = TestFolder::new();
    let recorded = [
        ("size", 0),
        ("threads", 4),
        ("scene", 8),
        ("text", 16),
        ("folder", 32),
        ("set", 40),
        ("scripts", 48),
        ("allow", 56),
        ("plugins", 64),
        ("seed", 72),
        ("has_seed", 80),
        ("reserved", 84),
    ];
    let checks = recorded.map(|(f, at)| format!("if (offsetof(tatu_world_setup, {f}) != {at}) return {};\n", at + 1));
    let source = format!(
        "#include <stddef.h>\n#include \"tatu_world.h\"\nint main(void) {{\n{}return sizeof(tatu_world_setup) == 88 ? 0 : 99;\n}}\n",
        checks.concat()
    );
    let file = place.path().join("layout.c");
    fs::write(&file, source).unwrap();
    let out = Command::new(compiled(&place, file.to_str().unwrap(), "cc")).output().unwrap();
    assert_eq!(out.status.code(), Some(0));
}
