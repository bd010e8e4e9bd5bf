//! Snapshots of standard error, one per test. When a message changes, `cargo insta accept` (or
//! `INSTA_UPDATE=always cargo test --test program`) updates them; the tests do not have to be edited.

use std::{env::consts, fmt::Write};

use crate::kit::*;

/// The output collected by one test. When dropped, it is compared with
/// `tests/program/snapshots/<folder>__<module>__<test>.snap`.
pub struct OutputSnapshot {
    test: String,
    texts: String,
}

/// Creates the `OutputSnapshot` of the enclosing test function.
macro_rules! said {
    () => {{
        fn here() {}
        $crate::kit::said::OutputSnapshot::of(std::any::type_name_of_val(&here))
    }};
}
pub(crate) use said;

impl OutputSnapshot {
    pub fn of(here: &str) -> OutputSnapshot {
        // The path is, for example, `program::scene::scene_errors::name_of_the_test::here`.
        let test = here.trim_end_matches("::here").trim_start_matches("program::").replace("::", "__");
        OutputSnapshot { test, texts: String::new() }
    }

    /// Adds the output of a run in `place`, under a heading that names the case. The path of the folder is replaced
    /// by `FOLDER`, because it is different in each run.
    pub fn add(&mut self, tried: &str, place: &TestFolder, text: &str) {
        assert!(!text.contains("panicked"), "a panic:\n{text}");
        let mut text = text.replace(consts::DLL_SUFFIX, ".so");
        for folder in [place.path().canonicalize().unwrap().as_path(), place.path()] {
            text = text.replace(&*folder.to_string_lossy(), "FOLDER");
        }
        let _ = writeln!(self.texts, "======== {tried}\n{}\n", text.trim_end());
    }

    /// Runs the program, which must refuse to start, and adds its output.
    #[track_caller]
    pub fn not_started(&mut self, place: &TestFolder, args: &[&str]) {
        let done = place.tatu(args);
        assert_eq!(done.code, 2, "{args:?}\n{}\n{}", done.err, done.out);
        // `check` prints one line on standard output, the verdict that the scene cannot run.
        let verdict = args[0] == "check" && done.out.contains(": cannot run: ") && done.out.lines().count() == 1;
        assert!(done.out.is_empty() || verdict, "a run has started: {}", done.out);
        self.add(&args.join(" "), place, &done.err);
    }

    /// Adds the errors of a scene that both `run` and `check` must refuse at the line that contains `wrong`.
    #[track_caller]
    pub fn refused(&mut self, scene: &str, wrong: &str) {
        self.refused_in(&TestFolder::new(), scene, wrong);
    }

    #[track_caller]
    pub fn refused_in(&mut self, place: &TestFolder, scene: &str, wrong: &str) {
        place.write("scene.toml", scene);
        let line = scene.lines().position(|l| l.contains(wrong)).expect("the scene has the wrong line");
        let [run, check] = [&["run", "scene.toml", "--json"][..], &["check", "scene.toml"]].map(|c| place.tatu(c));
        assert_eq!((run.code, check.code), (2, 2), "{}\n{}", run.err, run.out);
        assert_eq!(run.err, check.err);
        run.reports(&[&format!("scene.toml:{}:", line + 1)]);
        assert!(run.out.is_empty(), "a run has started: {}", run.out);
        self.add(scene.lines().nth(line).unwrap(), place, &run.err);
    }
}

impl Drop for OutputSnapshot {
    fn drop(&mut self) {
        if std::thread::panicking() {
            return;
        }
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path(root().join("tests/program/snapshots"));
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.bind(|| insta::assert_snapshot!(self.test.as_str(), self.texts));
    }
}
