//! Tests of third-party importers in C: which importer is chosen, and how the program handles failures and invalid
//! results; and of URDF files with arbitrary contents.

use std::{fs, process::Command, sync::Arc};

use tatu_core::{
    World, document,
    plugins::{FolderOrigin, SearchPath},
};

use crate::kit::*;

/// A plugin with an importer `also`, which accepts URDF files with the same confidence as the built-in one, and an
/// importer `faulty`, which fails in the way that the first letter of the file selects.
const IMPORTER_PLUGIN: &str = r#"
#include "tatu.h"

static uint32_t sniff(void *self, tatu_str head) {
  static const char mark[] = "<robot";
  (void)self;
  for (uint64_t i = 0; i + 6 <= head.len; i++) {
    uint64_t n = 0;
    while (n < 6 && head.ptr[i + n] == mark[n]) n++;
    if (n == 6) return 80;
  }
  return 0;
}
static tatu_status load(void *self, tatu_str bytes, const tatu_builder *b, const tatu_value *params, tatu_error *e) {
  (void)self; (void)bytes; (void)params; (void)e;
  b->object(b, "dummy", 0, tatu_text("also_read"));
  b->report(b, TATU_REPORT_NOTE, 1, tatu_text("seen by the other one"));
  return TATU_OK;
}
static tatu_status fail(void *self, tatu_str bytes, const tatu_builder *b, const tatu_value *params, tatu_error *e) {
  char what = bytes.len ? bytes.ptr[0] : '0';
  tatu_value wrong = tatu_float(-1);
  tatu_str file;
  uint32_t object = b->object(b, "shape", 0, tatu_text("half"));
  (void)self; (void)params;
  switch (what) {
  case 's': return TATU_ERR;                                             /* silent */
  case 'l': tatu_fail(e, TATU_ERR, "a bad line"); e->add(e, TATU_PART_FILE, tatu_text(""), 3); return TATU_ERR;
  case 'n': tatu_fail(e, TATU_ERR, "a bad part"); e->add(e, TATU_PART_FILE, tatu_text("part.bin"), 7); return TATU_ERR;
  case 'm': b->set(b, object, "mass", &wrong); return TATU_OK;           /* what the host refuses is no success */
  case 'p': b->object(b, "shape", 99, tatu_text("lost")); return TATU_OK;
  case 'k': b->object(b, "spoon", 0, tatu_text("x")); return TATU_OK;
  case 'r': b->report(b, TATU_REPORT_ERROR, object, tatu_text("beyond repair")); return TATU_OK;
  case 'f': return b->file(b, tatu_text("none.bin"), &file) == TATU_ERR_MISSING ? TATU_OK : TATU_ERR;
  default: return tatu_fail(e, TATU_ERR, "another reason");
  }
}
static tatu_status nothing(void *self, tatu_str bytes, const tatu_builder *b, const tatu_value *params, tatu_error *e) {
  (void)self; (void)bytes; (void)b; (void)params; (void)e;
  return TATU_OK;
}
static const char *const urdf[] = {".urdf", 0};
static const char *const bad[] = {".bad", 0};
static const char *const none[] = {".none", 0};
static const tatu_importer also = {sizeof(tatu_importer), 0, "also", "The other one.", urdf, 0, sniff, load};
static const tatu_importer faulty = {sizeof(tatu_importer), 0, "faulty", "Fails.", bad, 0, 0, fail};
static const tatu_importer empty = {sizeof(tatu_importer), 0, "empty", "Builds nothing.", none, 0, 0, nothing};
static const tatu_importer broken = {sizeof(tatu_importer), 0, "broken", "Has no load.", none, 0, 0, 0};
static const tatu_importer *const importers[] = {&also, &faulty, &empty, &broken, 0};
static const tatu_ext_importer ext = {sizeof(tatu_ext_importer), 0, importers};
static const void *extension(void *self, const char *id) {
  const char *wanted = TATU_IMPORTER;
  (void)self;
  while (*id && *id == *wanted) id++, wanted++;
  return *id == *wanted ? (const void *)&ext : 0;
}
const tatu_plugin_t tatu_plugin = {sizeof(tatu_plugin_t), TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.other", "Other",
                                   "1", "MIT", 0, 0, 0, extension};
"#;

/// Creates a folder with the plugin and a robot.
fn with_other() -> TestFolder {
    let place = TestFolder::new();
    place.write("mine/other.c", IMPORTER_PLUGIN).write("robot.urdf", "<robot name=\"r\"><link name=\"base\"/></robot>");
    succeed(
        Command::new(compiler("cc"))
            .args(["-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["-o", &library("tatu_other"), "other.c"])
            .current_dir(place.path().join("mine")),
    );
    place
}

/// Runs `tatu check` on a scene with an `[[import]]` that has these keys, and with this table `[providers]`.
fn imported(place: &TestFolder, keys: &str, providers: &str) -> RunOutput {
    place.write(
        "scene.toml",
        &format!("format = 1\n[scene]\nplugins = [\"mine\"]\n[providers]\n{providers}\n[[import]]\n{keys}\n"),
    );
    place.tatu(&["check", "scene.toml"])
}

#[test]
fn the_most_confident_importer_is_used_and_ties_are_reported_once() {
    let place = with_other();
    let tie = imported(&place, "file = \"robot.urdf\"", "").good();
    tie.reports(&[
        "note: robot.urdf: the importers also, urdf can read the file; `also` is used",
        "robot.urdf: `also_read`: seen by the other one",
    ]);
    assert_eq!(tie.err.matches("can read the file").count(), 1, "{}", tie.err);
    for (keys, providers) in [
        ("file = \"robot.urdf\"\nimporter = \"urdf\"", ""),
        ("file = \"robot.urdf\"", "\".urdf\" = \"urdf\""),
        ("file = \"robot.urdf\"", "\".urdf\" = \"tatu.importer.urdf\""),
    ] {
        let done = imported(&place, keys, providers).good();
        assert!(!done.err.contains("also"), "{keys} {providers}: {}", done.err);
    }
    imported(&place, "file = \"robot.urdf\"", "\".urdf\" = \"faulty\"").refused(&["E113", "faulty", "also", "urdf"]);
    // An importer without `load` is ignored and reported.
    tie.reports(&["warning[E303]", "org.example.other", "`broken` has no `load`, which is required"]);
}

#[test]
fn failing_importers_leave_only_an_error_text() {
    let place = with_other();
    for (letter, words) in [
        ("s", &["cannot import x.bad: `faulty` gave no reason"][..]),
        ("l", &["x.bad:3: a bad line"]),
        ("n", &["part.bin:7: a bad part"]),
        ("m", &["x.bad", "`shape.mass`: expected a number above 0"]),
        ("p", &["x.bad", "the parent of `lost` does not exist"]),
        ("k", &["x.bad", "`spoon`"]),
        ("r", &["x.bad", "beyond repair"]),
        ("e", &["x.bad", "another reason"]),
    ] {
        place.write("x.bad", &format!("{letter}\n\nthird line\n"));
        let done = imported(&place, "file = \"x.bad\"", "");
        done.refused(&[words, &["E120", "imported in scene.toml:7"]].concat());
    }
    // A missing second file is reported by the importer that requests it.
    place.write("x.bad", "f");
    imported(&place, "file = \"x.bad\"", "").good();
    place.write("x.none", "");
    imported(&place, "file = \"x.none\"", "").refused(&["E120", "the importer `empty` found nothing in it"]);
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

#[test]
fn any_urdf_file_runs_or_is_refused() {
    let mut search = SearchPath::default();
    search.folders.push((program().with_file_name("deps"), FolderOrigin::Built));
    search.built = vec!["tatu_importers_urdf".into()];
    let registry = load_registry(search);
    let folder = root().join("plugins/importers/urdf");
    let place = TestFolder::new();
    fs::copy(folder.join("mast.stl"), place.path().join("mast.stl")).unwrap();
    let robot = fs::read_to_string(folder.join("robot.urdf")).unwrap();
    let file = place.path().join("robot.urdf");
    let (mut good, mut bad) = (0, 0);
    let mut attempt = |text: &[u8], what: &str| {
        fs::write(&file, text).unwrap();
        match document::load(&file, &registry, &Default::default()) {
            Ok(document) => {
                let world = World::new(Arc::new(document), registry.clone()).unwrap_or_else(|e| panic!("{what}: {e}"));
                world.start();
                for _ in 0..3 {
                    world.step();
                }
                let faults = world.faults();
                assert!(faults.is_empty(), "{what}: {faults:?}");
                good += 1;
            }
            Err(e) => {
                assert_eq!(e.code, "E120", "{what}: {e}");
                assert!(e.place.as_ref().is_some_and(|p| p.file == file) && !e.text.contains("panick"), "{what}: {e}");
                bad += 1;
            }
        }
    };
    attempt(robot.as_bytes(), "whole");
    for n in (0..robot.len()).step_by(64) {
        attempt(&robot.as_bytes()[..n], &format!("{n} bytes"));
    }
    for range in values(&robot) {
        for with in [
            "",
            "0",
            "-1",
            "nan",
            "inf 0 0",
            "1e300",
            "1e-300",
            "base_link",
            "left_wheel",
            "a/b",
            "0 0 0",
            "1e9 -1e9 1e9",
            "../..",
            "\u{0}",
        ] {
            let mut text = robot.clone();
            text.replace_range(range.clone(), with);
            attempt(text.as_bytes(), &format!("`{}` at {} becomes `{with}`", &robot[range.clone()], range.start));
        }
    }
    assert!(good > 100 && bad > 100, "{good} {bad}");
}
