//! Tests of plugins that are rejected, each for one reason: the error states the file, the cause and the remedy, and a
//! scene that does not need the plugin runs as if it did not exist.

use std::fs;

use crate::{kit::plugin_sources::*, kit::said::*, kit::*};

impl OutputSnapshot {
    /// Runs a scene that does not need the plugin. The exit code must be 0, and standard error must name the file once.
    #[track_caller]
    fn add_rejected(&mut self, name: &str, source: &PluginSource) {
        let place = place("");
        compile(&place, name, &source.text());
        let done = place.run(&["--steps", "2"]).good();
        assert_eq!(done.err.matches("help: ").count(), 1, "{}", done.err);
        done.reports(&[&library(&format!("tatu_{name}"))]);
        self.add(name, &place, &done.err);
    }
}

#[test]
fn another_major_is_refused() {
    let mut said = said!();
    let source = PluginSource::new("major").with(|s| s.major = "7".into());
    said.add_rejected("major", &source);
}

#[test]
fn other_drafts_are_refused_by_their_number() {
    let mut said = said!();
    let source = PluginSource::new("old")
        .with(|s| s.extension = s.extension.replace("TATU_COMMAND", "\"tatu.command/draft.0\""));
    said.add_rejected("old", &source);
    let source = eye("new", "far_eye", "");
    let source = source.with(|s| s.extension = s.extension.replace("TATU_SENSOR", "\"tatu.sensor/draft.9\""));
    said.add_rejected("new", &source);
    // The command of that plugin works. For a scene that needs its sensor, the error names the most similar kind.
    let place = place(&watcher("w", "function sysCall_init() assert(new.one() == 1) end"));
    compile(&place, "new", &source.text());
    place.run(&["--steps", "1"]).good();
    let scene = place.read("scene.toml") + "[[object]]\nkind = \"sensor\"\nsensor = \"far_eye\"\n";
    place.write("scene.toml", &scene);
    place.run(&[]).refused(&["E108", "`far_eye`", "the closest match", &library("tatu_new"), "draft 9"]);
}

#[test]
fn unmet_needs_are_refused_and_optional_ones_noted() {
    let mut said = said!();
    let need = |id: &str, optional: u32| {
        PluginSource::new("needs").with(|s| {
            s.before += &format!(
                "static const tatu_need a_need = {{.size = sizeof(tatu_need), .optional = {optional}, .id = \"{id}\"}};
static const tatu_need *const all_needs[] = {{&a_need, NULL}};\n"
            );
            s.needs = "all_needs".into();
        })
    };
    said.add_rejected("needs", &need("tatu.host.scene/draft.9", 0));
    said.add_rejected("needs", &need("tatu.host.dreams/1", 0));
    // If an optional service is missing, a note is logged and the plugin works.
    let place = place(&watcher("w", "function sysCall_init() assert(needs.one() == 1) end"));
    compile(&place, "needs", &need("tatu.host.dreams/1", 1).text());
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["note: ", "can use `tatu.host.dreams/1`", &library("tatu_needs")]);
    assert!(!done.err.contains("warning"), "{}", done.err);
}

#[test]
fn a_failed_start_is_reported() {
    let mut said = said!();
    let source = PluginSource::new("sulk")
        .with(|s| s.init = "return tatu_fail(e, TATU_ERR, \"the licence has run out\");".into());
    said.add_rejected("sulk", &source);
    let source = PluginSource::new("mute").with(|s| s.init = "return TATU_ERR;".into());
    said.add_rejected("mute", &source);
    // If a plugin fails because a service exists only in another draft, the error states this in addition to the error
    // of the plugin.
    let source = PluginSource::new("ask").with(|s| {
        s.init =
            "return host->service(host, \"tatu.host.scene/draft.0\") ? TATU_OK : tatu_fail(e, TATU_ERR, \"no scene\");"
                .into();
    });
    said.add_rejected("ask", &source);
}

#[test]
fn descriptors_that_lack_something_are_refused() {
    let mut said = said!();
    let cut = |size: &str| PluginSource::new("cut").with(|s| s.size = size.into());
    said.add_rejected("cut", &cut("offsetof(tatu_plugin_t, extension)"));
    // A field that extends beyond the size of the table is ignored.
    said.add_rejected("cut", &cut("offsetof(tatu_plugin_t, extension) + 4"));
    said.add_rejected("cut", &cut("4"));
    said.add_rejected("cut", &PluginSource::new("cut").with(|s| s.id = "NULL".into()));
    said.add_rejected("cut", &PluginSource::new("cut").with(|s| s.id = "\"\"".into()));
    said.add_rejected("cut", &PluginSource::new("cut").with(|s| s.extension = "NULL".into()));
}

#[test]
fn tables_that_lack_something_are_refused() {
    let mut said = said!();
    for table in [
        ", .measure = NULL",
        ", .size = offsetof(tatu_sensor, measure)",
        ", .size = offsetof(tatu_sensor, measure) + 4",
        ", .id = NULL",
        ", .id = \"\"",
    ] {
        said.add_rejected("eye", &eye("eye", "eye", table));
    }
    for (from, to) in [
        (".create = create, ", ""),
        (", .destroy = destroy", ""),
        (".size = sizeof(tatu_life)", ".size = 8"),
        (", .call = one", ""),
        (".names = one_names, ", ""),
    ] {
        let source = eye("eye", "eye", "").with(|s| {
            assert!(s.before.contains(from));
            s.before = s.before.replace(from, to);
        });
        said.add_rejected("eye", &source);
    }
}

#[test]
fn missing_required_functions_are_refused() {
    let mut said = said!();
    for from in [
        ", .build = build",
        ", .load = load",
        ", .find = find",
        ", .call = call",
        ", .resume = resume",
        ", .keep_func = keep",
        ", .drop_func = drop",
        ", .call_func = call",
        ", .life = &script_life",
        ", .apply = apply",
        ".suffixes = endings, .load = read",
        ", .life = &butlers",
        ", .barrier = barrier",
        ", .destroy = stop",
    ] {
        let source = all("parts", "a").with(|s| {
            assert!(s.before.contains(from), "{from}");
            s.before = s.before.replace(from, "");
        });
        said.add_rejected("parts", &source);
    }
}

#[cfg(target_os = "linux")]
impl OutputSnapshot {
    /// Writes `mine/libtatu_bad.so` beside a valid plugin. The file must be reported, and the run must continue.
    #[track_caller]
    fn add_rejected_file(&mut self, change: impl FnOnce(Vec<u8>) -> Vec<u8>) {
        let place = place(&watcher("w", "function sysCall_init() assert(good.one() == 1) end"));
        compile(&place, "good", &PluginSource::new("good").text());
        compile(&place, "bad", &PluginSource::new("bad").text());
        let file = place.path().join("mine").join(library("tatu_bad"));
        let bytes = change(fs::read(&file).unwrap());
        let size = format!("{} bytes", bytes.len());
        // The file is removed first, because the loader could reuse the old one.
        fs::remove_file(&file).unwrap();
        fs::write(&file, bytes).unwrap();
        let done = place.run(&["--steps", "2"]).good();
        done.reports(&["E301", &library("tatu_bad"), "help: "]);
        // The sizes of files depend on the compiler.
        let text = done.err.replace(&size, "SIZE bytes");
        let text = text.split(' ').map(|w| if w.parse::<u64>().is_ok_and(|n| n > 100) { "SIZE" } else { w });
        self.add("bad", &place, &text.collect::<Vec<_>>().join(" "));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn truncated_and_foreign_files_are_refused() {
    let mut said = said!();
    said.add_rejected_file(|_| Vec::new());
    said.add_rejected_file(|_| b"#!/bin/sh\necho not a library\n".to_vec());
    said.add_rejected_file(|b| b[..4096].to_vec());
    said.add_rejected_file(|b| b[..b.len() / 2].to_vec());
    said.add_rejected_file(|b| b[..b.len() - 1].to_vec());
    // Field e_machine of the ELF header, at byte 18: 8 is MIPS.
    let foreign = |mut b: Vec<u8>| {
        b[18] = 8;
        b
    };
    said.add_rejected_file(foreign);
}

#[test]
fn missing_folders_and_misnamed_libraries_are_reported() {
    let place = place("");
    compile(&place, "good", &PluginSource::new("good").text());
    let from = place.path().join("mine").join(library("tatu_good"));
    fs::copy(&from, place.path().join("mine").join(library("good"))).unwrap();
    let env = [("TATU_PLUGIN_PATH", "nowhere")];
    let done = run(program(), place.path(), &["run", "scene.toml", "--json", "--steps", "1"], &env).good();
    done.reports(&[
        "E311",
        "TATU_PLUGIN_PATH contains the folder nowhere",
        "is a library, but its name is not a plugin's",
    ]);
    done.reports(&[&library("good"), &library("tatu_NAME")]);
}

#[test]
fn a_library_without_the_symbol_is_refused() {
    let place = place("");
    compile(&place, "mute", "int nothing(void);\nint nothing(void) { return 0; }\n");
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["E301", &library("tatu_mute"), "exports no `tatu_plugin`", "in C++ include tatu.h"]);
}

/// Sets flush-to-zero by an instruction, and another locale by the C library, as some libraries do.
const MODE_CHANGE: &str = "#include <locale.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
static void fast(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }
#else
static void fast(void) { uint64_t r; __asm__ volatile(\"mrs %0, fpcr\" : \"=r\"(r)); r |= 1u << 24; __asm__ volatile(\"msr fpcr, %0\" :: \"r\"(r)); }
#endif
static void abroad(void) { setlocale(LC_ALL, \"C.UTF-8\"); }
";

#[test]
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
fn a_changed_floating_point_mode_or_locale_is_restored_and_reported_once() {
    let robot = pioneer("function sysCall_actuation() end", "");
    let clean = place(&robot).run(&["--seconds", "1"]).good().json()["hash"].clone();
    let constructor = |call: &str| {
        PluginSource::new("fast").with(|s| {
            s.before +=
                &format!("{MODE_CHANGE}__attribute__((constructor)) static void before_all(void) {{ {call} }}\n");
        })
    };
    let init = |call: &str| {
        PluginSource::new("fast").with(|s| {
            s.before += MODE_CHANGE;
            s.init = format!("{call} return TATU_OK;");
        })
    };
    let (mode, locale) = ("changes the floating-point mode when", "changes the locale of the process when");
    for (source, words) in [
        (constructor("fast();"), mode),
        (init("fast();"), mode),
        (constructor("abroad();"), locale),
        (init("abroad();"), locale),
    ] {
        let place = place(&robot);
        compile(&place, "fast", &source.text());
        let done = place.run(&["--seconds", "1"]).good();
        done.reports(&["E321", words, &library("tatu_fast"), "it was restored", "-ffast-math"]);
        assert_eq!(done.err.matches(words).count(), 1, "{}", done.err);
        assert_eq!(done.json()["hash"], clean);
    }
    // The modes change during a run: in a command, in a measurement, and when an instance is created.
    let command = PluginSource::new("fast").with(|s| {
        s.before = format!("{MODE_CHANGE}{}", s.before.replace("{ return tatu_return", "{ fast(); return tatu_return"));
    });
    let calls = "function sysCall_actuation() assert(fast.one() == 1) end";
    let place = place(&(robot.clone() + &watcher("w", calls)));
    compile(&place, "fast", &command.text());
    let done = place.run(&["--seconds", "1"]);
    let errors = done.errors();
    // The first time, any command called by the script can be the cause. From then on every call is checked.
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!(errors[0]["message"].as_str().unwrap().contains("org.test.fast"), "{errors:?}");
    assert_eq!((errors[1]["plugin"].as_str(), errors[1]["count"].as_u64()), (Some("org.test.fast"), Some(22)));
    done.reports(&["F207", "`org.test.fast` changed the floating-point mode in tatu_command.call", "it was restored"]);
    let robot_hash = |done: &RunOutput| done.json()["objects"]["/Pioneer_p3dx"]["hash"].clone();
    place.write("scene.toml", &place.read("scene.toml").replace("fast.one()", "1"));
    assert_eq!(robot_hash(&done), robot_hash(&place.run(&["--seconds", "1"]).good()));

    compile(&place, "fast", &command.with(|s| s.before = s.before.replace("fast();", "abroad();")).text());
    place.write("scene.toml", &place.read("scene.toml").replace("assert(1", "assert(fast.one()"));
    let done = place.run(&["--seconds", "1"]);
    assert_eq!(done.errors().len(), 1, "{}", done.err);
    done.reports(&["F207", "changed the locale of the process in actuation", "org.test.fast"]);

    let sensor = "[[object]]\nkind = \"sensor\"\nsensor = \"eye\"\nalias = \"eye\"\n";
    let measure =
        eye("fast", "eye", "").with(|s| s.before = format!("{MODE_CHANGE}#define MEASURE fast();\n{}", s.before));
    let place = self::place(&(robot + sensor));
    compile(&place, "fast", &measure.text());
    let done = place.run(&["--seconds", "1"]);
    let errors = done.errors();
    assert_eq!((errors.len(), errors[0]["object"].as_str()), (1, Some("/eye")), "{errors:?}");
    done.reports(&["F207", "`org.test.fast`", "measure changed the floating-point mode", "/eye is switched off"]);
}
