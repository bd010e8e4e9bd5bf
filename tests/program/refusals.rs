//! Plugins that are refused, each made on purpose: the sentence names file, cause and mend, and a scene that does not
//! need the plugin runs as without it.

use std::fs;

use crate::{kit::*, made::*};

/// Runs a scene that does not need the plugin: exit 0, and standard error has these words and the file's name.
#[track_caller]
fn told(name: &str, source: &Source, words: &[&str]) {
    let place = place("");
    compile(&place, name, &source.text());
    let done = place.run(&["--steps", "2"]).good();
    done.tells(words);
    done.tells(&[&library(&format!("tatu_{name}")), "help: "]);
    // Told once.
    assert_eq!(done.err.matches(words[0]).count(), 1, "{}", done.err);
}

#[test]
fn another_major_is_refused() {
    let source = Source::new("major").with(|s| s.major = "7".into());
    told("major", &source, &["E301", "built for ABI 7.1, this host has 0.1", "rebuild it"]);
}

#[test]
fn other_drafts_are_refused_by_their_number() {
    let source =
        Source::new("old").with(|s| s.extension = s.extension.replace("TATU_COMMAND", "\"tatu.command/draft.0\""));
    told("old", &source, &["E320", "built for draft 0 of `tatu.command`, this host has draft 1", "rebuild it"]);
    let source = eye("new", "far_eye", "");
    let source = source.with(|s| s.extension = s.extension.replace("TATU_SENSOR", "\"tatu.sensor/draft.9\""));
    told("new", &source, &["E320", "built for draft 9 of `tatu.sensor`, this host has draft 1", "rebuild it"]);
    // The command of that plugin works, and a scene that needs its sensor names the file that came closest.
    let place = place(&watcher("w", "function sysCall_init() assert(new.one() == 1) end"));
    compile(&place, "new", &source.text());
    place.run(&["--steps", "1"]).good();
    let scene = place.read("scene.toml") + "[[object]]\nkind = \"sensor\"\nsensor = \"far_eye\"\n";
    place.write("scene.toml", &scene);
    place.run(&[]).refused(&["E108", "`far_eye`", "came closest", &library("tatu_new"), "draft 9"]);
}

#[test]
fn needs_that_are_not_met_are_refused_and_wishes_noted() {
    let need = |id: &str, optional: u32| {
        Source::new("needs").with(|s| {
            s.before += &format!(
                "static const tatu_need a_need = {{.size = sizeof(tatu_need), .optional = {optional}, .id = \"{id}\"}};
static const tatu_need *const all_needs[] = {{&a_need, NULL}};\n"
            );
            s.needs = "all_needs".into();
        })
    };
    let draft = "built for draft 9 of `tatu.host.scene`, this host has draft 1";
    told(
        "needs",
        &need("tatu.host.scene/draft.9", 0),
        &["E301", "it needs `tatu.host.scene/draft.9`", draft, "rebuild"],
    );
    told(
        "needs",
        &need("tatu.host.dreams/1", 0),
        &["E301", "it needs `tatu.host.dreams/1`", "does not offer", "rebuild"],
    );
    // A wish is only noted, and the plugin works.
    let place = place(&watcher("w", "function sysCall_init() assert(needs.one() == 1) end"));
    compile(&place, "needs", &need("tatu.host.dreams/1", 1).text());
    let done = place.run(&["--steps", "1"]).good();
    done.tells(&["note: ", "would like `tatu.host.dreams/1`", &library("tatu_needs")]);
    assert!(!done.err.contains("warning"), "{}", done.err);
}

#[test]
fn a_start_that_fails_is_told() {
    let source =
        Source::new("sulk").with(|s| s.init = "return tatu_fail(e, TATU_ERR, \"the licence has run out\");".into());
    told("sulk", &source, &["E301", "tatu_plugin.init of `org.test.sulk`) failed: the licence has run out"]);
    let source = Source::new("mute").with(|s| s.init = "return TATU_ERR;".into());
    told("mute", &source, &["E301", "no reason was given"]);
    // One that fails because of a service of another draft is told so, whatever it says itself.
    let source = Source::new("ask").with(|s| {
        s.init =
            "return host->service(host, \"tatu.host.scene/draft.0\") ? TATU_OK : tatu_fail(e, TATU_ERR, \"no scene\");"
                .into();
    });
    told(
        "ask",
        &source,
        &["E301", "no scene; it is built for draft 0 of `tatu.host.scene`, this host has draft 1", "rebuild"],
    );
}

#[test]
fn descriptors_that_lack_something_are_refused() {
    let cut = |size: &str| Source::new("cut").with(|s| s.size = size.into());
    told("cut", &cut("offsetof(tatu_plugin_t, extension)"), &["E301", "too short", "`extension`", "sizeof"]);
    // In the middle of a field: that field does not count.
    told("cut", &cut("offsetof(tatu_plugin_t, extension) + 4"), &["E301", "too short", "`extension`", "sizeof"]);
    told("cut", &cut("4"), &["E301", "too short", "`id`"]);
    told("cut", &Source::new("cut").with(|s| s.id = "NULL".into()), &["E301", "has no `id`"]);
    told("cut", &Source::new("cut").with(|s| s.id = "\"\"".into()), &["E301", "its id is empty", "org.example"]);
    told("cut", &Source::new("cut").with(|s| s.extension = "NULL".into()), &["E301", "has no `extension`"]);
}

#[test]
fn tables_that_lack_something_are_refused() {
    for (table, words) in [
        (", .measure = NULL", &["its sensor `eye` has no `measure`, which is required"][..]),
        (", .size = offsetof(tatu_sensor, measure)", &["its sensor `eye` is too short", "`measure`"]),
        (", .size = offsetof(tatu_sensor, measure) + 4", &["its sensor `eye` is too short", "`measure`"]),
        (", .id = NULL", &["its sensor has no `id`"]),
        (", .id = \"\"", &["its sensor has an empty `id`"]),
    ] {
        told("eye", &eye("eye", "eye", table), &[&[words[0], "E303", "fill what is required"], &words[1..]].concat());
    }
    for (from, to, words) in [
        (".create = create, ", "", "the `life` of its sensor `eye` has no `create`"),
        (", .destroy = destroy", "", "the `life` of its sensor `eye` has no `destroy`"),
        (".size = sizeof(tatu_life)", ".size = 8", "the `life` of its sensor `eye` is too short"),
        (", .call = one", "", "its command `eye.one` has no `call`"),
        (".names = one_names, ", "", "its command has no `names`"),
    ] {
        let source = eye("eye", "eye", "").with(|s| {
            assert!(s.before.contains(from));
            s.before = s.before.replace(from, to);
        });
        told("eye", &source, &[words, "E303", "fill what is required"]);
    }
}

#[test]
fn every_required_function_is_asked_for() {
    for (from, words) in [
        (", .build = build", "its model `thing` has no `build`"),
        (", .load = load", "its language `tongue` has no `load`"),
        (", .find = find", "its language `tongue` has no `find`"),
        (", .call = call", "its language `tongue` has no `call`"),
        (", .resume = resume", "its language `tongue` has no `resume`"),
        (", .keep_func = keep", "its language `tongue` has no `keep_func`"),
        (", .drop_func = drop", "its language `tongue` has no `drop_func`"),
        (", .call_func = call", "its language `tongue` has no `call_func`"),
        (", .life = &script_life", "its language `tongue` has no `life`"),
        (", .apply = apply", "its actuator `arm` has no `apply`"),
        (".suffixes = endings, .load = read", "its importer `reader` has no `load`"),
        (", .start = start", "its service `butler` has no `start`"),
        (", .barrier = barrier", "its service `butler` has no `barrier`"),
    ] {
        let source = all("parts", "a").with(|s| {
            assert!(s.before.contains(from), "{from}");
            s.before = s.before.replace(from, "");
        });
        told("parts", &source, &[words, "E303", "fill what is required"]);
    }
}

/// Puts a file `mine/libtatu_bad.so` beside a good one, and checks that it is told and the run goes on.
#[cfg(target_os = "linux")]
#[track_caller]
fn file_told(change: impl FnOnce(Vec<u8>) -> Vec<u8>, words: &[&str]) {
    let place = place(&watcher("w", "function sysCall_init() assert(good.one() == 1) end"));
    compile(&place, "good", &Source::new("good").text());
    compile(&place, "bad", &Source::new("bad").text());
    let file = place.path().join("mine").join(library("tatu_bad"));
    let bytes = change(fs::read(&file).unwrap());
    // A new file: the loader must not see the old one.
    fs::remove_file(&file).unwrap();
    fs::write(&file, bytes).unwrap();
    let done = place.run(&["--steps", "2"]).good();
    done.tells(words);
    done.tells(&["E301", &library("tatu_bad"), "help: "]);
}

#[test]
#[cfg(target_os = "linux")]
fn files_that_are_no_whole_library_are_refused() {
    file_told(|_| Vec::new(), &["the file is empty", "build or copy it again"]);
    file_told(|_| b"#!/bin/sh\necho not a library\n".to_vec(), &["it is no library", "build or copy it again"]);
    file_told(|b| b[..4096].to_vec(), &["the file is cut off", "4096 bytes", "build or copy it again"]);
    file_told(|b| b[..b.len() / 2].to_vec(), &["the file is cut off", "build or copy it again"]);
    file_told(|b| b[..b.len() - 1].to_vec(), &["the file is cut off", "build or copy it again"]);
    // Field e_machine of the ELF header, at byte 18: 8 is MIPS.
    let foreign = |mut b: Vec<u8>| {
        b[18] = 8;
        b
    };
    file_told(foreign, &["built for another processor", "machine 8", "for this processor"]);
}

#[test]
fn a_library_without_the_symbol_is_refused() {
    let place = place("");
    compile(&place, "mute", "int nothing(void);\nint nothing(void) { return 0; }\n");
    let done = place.run(&["--steps", "1"]).good();
    done.tells(&["E301", &library("tatu_mute"), "exports no `tatu_plugin`", "in C++ include tatu.h"]);
}

/// Sets flush-to-zero by an instruction and another locale by the C library, as a careless library does.
const MODE: &str = "#include <locale.h>
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
fn a_changed_floating_point_mode_or_locale_is_put_back_and_named_once() {
    let robot = pioneer("function sysCall_actuation() end", "");
    let clean = place(&robot).run(&["--seconds", "1"]).good().json()["hash"].clone();
    let constructor = |call: &str| {
        Source::new("fast").with(|s| {
            s.before += &format!("{MODE}__attribute__((constructor)) static void before_all(void) {{ {call} }}\n");
        })
    };
    let init = |call: &str| {
        Source::new("fast").with(|s| {
            s.before += MODE;
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
        done.tells(&["E321", words, &library("tatu_fast"), "it was put back", "-ffast-math"]);
        assert_eq!(done.err.matches(words).count(), 1, "{}", done.err);
        assert_eq!(done.json()["hash"], clean);
    }
    // During a run: in a command, in a measure, in the making of an instance.
    let command = Source::new("fast").with(|s| {
        s.before = format!("{MODE}{}", s.before.replace("{ return tatu_return", "{ fast(); return tatu_return"));
    });
    let calls = "function sysCall_actuation() assert(fast.one() == 1) end";
    let place = place(&(robot.clone() + &watcher("w", calls)));
    compile(&place, "fast", &command.text());
    let done = place.run(&["--seconds", "1"]);
    let errors = done.errors();
    // The first time it is one of those that the script called; then every call is looked at.
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!(errors[0]["message"].as_str().unwrap().contains("org.test.fast"), "{errors:?}");
    assert_eq!((errors[1]["plugin"].as_str(), errors[1]["count"].as_u64()), (Some("org.test.fast"), Some(22)));
    done.tells(&["F207", "`org.test.fast` changed the floating-point mode in tatu_command.call", "it was put back"]);
    let robot_hash = |done: &Done| done.json()["objects"]["/Pioneer_p3dx"]["hash"].clone();
    place.write("scene.toml", &place.read("scene.toml").replace("fast.one()", "1"));
    assert_eq!(robot_hash(&done), robot_hash(&place.run(&["--seconds", "1"]).good()));

    compile(&place, "fast", &command.with(|s| s.before = s.before.replace("fast();", "abroad();")).text());
    place.write("scene.toml", &place.read("scene.toml").replace("assert(1", "assert(fast.one()"));
    let done = place.run(&["--seconds", "1"]);
    assert_eq!(done.errors().len(), 1, "{}", done.err);
    done.tells(&["F207", "changed the locale of the process in actuation", "org.test.fast"]);

    let sensor = "[[object]]\nkind = \"sensor\"\nsensor = \"eye\"\nalias = \"eye\"\n";
    let measure = eye("fast", "eye", "").with(|s| s.before = format!("{MODE}#define MEASURE fast();\n{}", s.before));
    let place = self::place(&(robot + sensor));
    compile(&place, "fast", &measure.text());
    let done = place.run(&["--seconds", "1"]);
    let errors = done.errors();
    assert_eq!((errors.len(), errors[0]["object"].as_str()), (1, Some("/eye")), "{errors:?}");
    done.tells(&["F207", "`org.test.fast`", "measure changed the floating-point mode", "/eye is switched off"]);
}
