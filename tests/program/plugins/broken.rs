//! Tests of the diagnoses of `tatu plugin why` for libraries that are broken in all known ways.

#![cfg(target_os = "linux")]

use std::{fs, os::unix::net::UnixListener, process::Command};

use super::why::{ask, file, folder, good, good_bytes};
use crate::{kit::plugin_sources::*, kit::said::*, kit::*};

impl OutputSnapshot {
    /// Compiles a plugin in C, and adds its diagnosis to the snapshot.
    #[track_caller]
    fn of_source(&mut self, tried: &str, source: &str, more: &[&str]) {
        let place = folder();
        compile_with(&place, "x", source, more);
        self.because(tried, &place, &["x"]);
    }
    /// Writes a file with these bytes, and adds its diagnosis to the snapshot.
    #[track_caller]
    fn of_bytes(&mut self, tried: &str, bytes: &[u8]) {
        let place = folder();
        fs::write(file(&place, "x"), bytes).unwrap();
        self.because(tried, &place, &["x"]);
    }
}

/// Returns the source of a plugin whose descriptor has the declaration `how`.
fn declared(how: &str) -> String {
    good().text().replace("TATU_EXPORT const tatu_plugin_t tatu_plugin", how)
}

#[test]
fn files_that_are_no_library_are_reported_by_type() {
    let mut said = said!();
    said.of_bytes("empty", b"");
    said.of_bytes("a text", b"int main(void) { return 0; }\n");
    said.of_bytes("a script", b"#!/bin/sh\necho not a library\n");
    said.of_bytes("for Windows", b"MZ\x90\0\x03\0\0\0\x04\0\0\0\xff\xff");
    said.of_bytes("for macOS", b"\xcf\xfa\xed\xfe\x07\0\0\x01\x03\0\0\0");
    said.of_bytes("zipped", b"PK\x03\x04\x14\0\0\0");
    said.of_bytes("gzipped", b"\x1f\x8b\x08\0\0\0\0\0");
    said.of_bytes("random bytes", b"\x01\x02\x03\x04");
    let whole = good_bytes();
    said.of_bytes("the first half", &whole[..whole.len() / 2]);
    said.of_bytes("all but the last byte", &whole[..whole.len() - 1]);
}

#[test]
fn libraries_with_foreign_file_names_are_reported() {
    let mut said = said!();
    for (name, bytes) in [("tatu_x.dll", &b"MZ\x90\0"[..]), ("libtatu_x.dylib", b"\xcf\xfa\xed\xfe\x07\0\0\x01")] {
        let place = folder();
        fs::write(place.path().join("mine").join(name), bytes).unwrap();
        said.because(name, &place, &["x"]);
    }
}

#[test]
#[cfg(target_arch = "x86_64")]
fn libraries_for_other_processors_are_reported() {
    let mut said = said!();
    let whole = good_bytes();
    // Offsets in the ELF header: class (1: 32 bit) at 4, byte order (2: big-endian) at 5, machine at 18.
    let changed = |changes: &[(usize, u8)]| {
        let mut bytes = whole.clone();
        changes.iter().for_each(|(at, to)| bytes[*at] = *to);
        bytes
    };
    said.of_bytes("32 bit", &changed(&[(4, 1), (18, 3)]));
    said.of_bytes("32 bit of this processor", &changed(&[(4, 1)]));
    said.of_bytes("aarch64", &changed(&[(18, 183)]));
    said.of_bytes("big-endian", &changed(&[(5, 2)]));
    said.of_bytes("an unknown processor", &changed(&[(18, 250), (19, 250)]));
}

#[test]
fn object_files_and_programs_are_reported() {
    let mut said = said!();
    let place = folder();
    place.write("a.c", "int a(void);\nint a(void) { return 1; }\nint main(void) { return a(); }\n");
    let cc = || {
        let mut cc = Command::new(compiler("cc"));
        cc.current_dir(place.path());
        cc
    };
    let target = file(&place, "x");
    succeed(cc().args(["-c", "a.c", "-o"]).arg(&target));
    said.because("an object file", &place, &["x"]);
    fs::remove_file(&target).unwrap();
    succeed(cc().args(["-c", "a.c", "-o", "a.o"]));
    succeed(Command::new("ar").arg("rcs").arg(&target).arg("a.o").current_dir(place.path()));
    said.because("a static library", &place, &["x"]);
    for option in ["-no-pie", "-pie"] {
        fs::remove_file(&target).unwrap();
        succeed(cc().args([option, "-fPIE", "a.c", "-o"]).arg(&target));
        said.because(&format!("a program, {option}"), &place, &["x"]);
    }
}

#[test]
fn folders_pipes_and_devices_are_reported() {
    let mut said = said!();
    let place = folder();
    let x = file(&place, "x");
    fs::create_dir(&x).unwrap();
    said.because("a folder", &place, &["x"]);
    fs::remove_dir(&x).unwrap();
    succeed(Command::new("mkfifo").arg(&x));
    said.because("a pipe", &place, &["x"]);
    // Opening the pipe would block because it has no writer.
    let done = run(program(), place.path(), &["list", "plugins"], &[("TATU_PLUGIN_PATH", "mine")]).good();
    done.reports(&["E301", "it is a pipe, socket or device, not a file"]);
    fs::remove_file(&x).unwrap();
    let socket = UnixListener::bind(&x).unwrap();
    said.because("a socket", &place, &["x"]);
    drop(socket);
    fs::remove_file(&x).unwrap();
    std::os::unix::fs::symlink("/dev/null", &x).unwrap();
    said.because("a device", &place, &["x"]);
}

#[test]
fn links_are_followed_one_by_one() {
    use std::os::unix::fs::symlink;
    let mut said = said!();
    let place = folder();
    let x = file(&place, "x");
    symlink("../gone.so", &x).unwrap();
    said.because("dangling", &place, &["x"]);
    fs::remove_file(&x).unwrap();
    symlink("libtatu_y.so", &x).unwrap();
    symlink("libtatu_x.so", file(&place, "y")).unwrap();
    said.because("a loop", &place, &["x"]);
    fs::remove_file(file(&place, "y")).unwrap();
    // For a valid link, the output shows the target, which is loaded.
    symlink("../second.so", file(&place, "y")).unwrap();
    symlink("third.so", place.path().join("second.so")).unwrap();
    fs::write(place.path().join("third.so"), good_bytes()).unwrap();
    let out = ask(&place, &["x"]).good().out;
    for to in ["mine/libtatu_y.so", "mine/../second.so", "mine/../third.so"] {
        assert!(out.contains(&format!("  links to   {to}\n")), "{to}:\n{out}");
    }
}

/// Runs a command without root's capability to read all files.
fn as_anybody(command: &mut Command) -> &mut Command {
    use std::os::unix::process::CommandExt;
    // The numbers of CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH in linux/capability.h.
    let drop = || {
        for capability in [1, 2] {
            // SAFETY: the call only removes capabilities from the new process, or fails if it has none.
            unsafe { libc::prctl(libc::PR_CAPBSET_DROP, capability, 0, 0, 0) };
        }
        Ok(())
    };
    // SAFETY: the closure only makes system calls, which are allowed between fork and exec.
    unsafe { command.pre_exec(drop) }
}

#[test]
fn unreadable_files_are_reported() {
    use std::os::unix::fs::PermissionsExt;
    let mut said = said!();
    let place = folder();
    compile(&place, "x", &good().text());
    let ask = |what: &str| {
        let mut command = Command::new(program());
        command.args(["plugin", "why", what]).current_dir(place.path()).env("TATU_PLUGIN_PATH", "mine");
        let done = as_anybody(&mut command).output().unwrap();
        assert_eq!(done.status.code(), Some(1));
        String::from_utf8(done.stdout).unwrap()
    };
    fs::set_permissions(file(&place, "x"), fs::Permissions::from_mode(0o000)).unwrap();
    said.add("a file", &place, ask("x").rsplit_once("\n\n").unwrap().1);
    fs::set_permissions(place.path().join("mine"), fs::Permissions::from_mode(0o000)).unwrap();
    let out = ask("x");
    fs::set_permissions(place.path().join("mine"), fs::Permissions::from_mode(0o755)).unwrap();
    assert!(out.contains("  1. mine (TATU_PLUGIN_PATH): cannot be read: Permission denied"), "{out}");
    said.add("a folder", &place, out.rsplit_once("\n\n").unwrap().1);
}

#[test]
fn a_library_without_the_entry_is_reported_with_its_symbols() {
    let mut said = said!();
    said.of_source("no symbols", "static int a(void) { return 1; }\n", &[]);
    let other = "TATU_EXPORT int go(void);\nTATU_EXPORT int go(void) { return 1; }\nTATU_EXPORT int stop;\n";
    said.of_source("other symbols", &format!("#include \"tatu.h\"\n{other}"), &[]);
    said.of_source("a misspelt symbol", &declared("TATU_EXPORT const tatu_plugin_t tatu_plugins"), &[]);
    said.of_source("hidden", "const int tatu_plugin = 1;\n", &[]);
    said.of_source("static", "__attribute__((used)) static const int tatu_plugin = 1;\n", &[]);
    let function = "TATU_EXPORT void tatu_plugin(void);\nTATU_EXPORT void tatu_plugin(void) {}\n";
    said.of_source(
        "a function",
        &format!("#define tatu_plugin gone\n#include \"tatu.h\"\n#undef tatu_plugin\n{function}"),
        &[],
    );
    let used = "extern const int tatu_plugin;\n__attribute__((visibility(\"default\"))) const int *x(void);\nconst int *x(void) { return &tatu_plugin; }\n";
    said.of_source("used but not defined", used, &[]);
    let foreign = "__attribute__((visibility(\"default\"))) int simInit(void);\nint simInit(void) { return 1; }\n";
    said.of_source("of CoppeliaSim", foreign, &[]);
}

#[test]
#[cfg_attr(no_cxx, ignore = "there is no C++ compiler")]
fn mangled_entry_names_are_reported() {
    let mut said = said!();
    // In C++, a constant at file scope has internal linkage, and names in a namespace are mangled.
    for (tried, source) in [
        (
            "a constant",
            "__attribute__((used)) static const int keep = 1;\n__attribute__((used)) const int tatu_plugin = 1;\n",
        ),
        (
            "in a name space",
            "namespace mine { __attribute__((visibility(\"default\"))) extern const int tatu_plugin = 1; }\n",
        ),
    ] {
        let place = folder();
        place.write("x.cpp", source);
        succeed(
            Command::new(compiler("c++"))
                .args(["-shared", "-fPIC", "x.cpp", "-o"])
                .arg(file(&place, "x"))
                .current_dir(place.path()),
        );
        said.because(tried, &place, &["x"]);
    }
}

#[test]
fn missing_libraries_are_reported_with_their_dependents() {
    let mut said = said!();
    // Links a plugin to a library and then removes the library.
    let made = |place: &TestFolder, more: &[&str]| {
        place.write("helper.c", "int helper(void);\nint helper(void) { return 2; }\n");
        let cc = ["-shared", "-fPIC", "helper.c", "-o", "mine/libhelper_of_mine.so"];
        succeed(Command::new(compiler("cc")).args(cc).current_dir(place.path()));
        let source = good().with(|s| {
            s.before = s.before.replace("tatu_int(1)", "tatu_int(helper())");
            s.before.insert_str(0, "int helper(void);\n");
        });
        compile_with(place, "x", &source.text(), &[&["-L.", "-lhelper_of_mine"], more].concat());
    };
    let place = folder();
    made(&place, &[]);
    said.because("in the folder of the plugin", &place, &["x"]);
    // The library is found with the right linker option, and by LD_LIBRARY_PATH.
    let args = ["plugin", "why", "x"];
    run(program(), place.path(), &args, &[("TATU_PLUGIN_PATH", "mine"), ("LD_LIBRARY_PATH", "mine")]).good();
    for option in ["-Wl,-rpath,$ORIGIN", "-Wl,--disable-new-dtags,-rpath,${ORIGIN}/."] {
        let place = folder();
        made(&place, &[option]);
        let done = ask(&place, &["x"]).good();
        assert!(done.out.contains("libhelper_of_mine.so ("), "{}", done.out);
    }
    fs::remove_file(place.path().join("mine/libhelper_of_mine.so")).unwrap();
    said.because("not installed", &place, &["x"]);
    // The loader cannot open the plugin, because this library is missing.
    let done = run(program(), place.path(), &["list", "plugins"], &[("TATU_PLUGIN_PATH", "mine")]).good();
    done.reports(&["E301", "libhelper_of_mine.so"]);

    // A library of the plugin needs another one, which is missing.
    let place = folder();
    place.write("deep.c", "int deep(void);\nint deep(void) { return 2; }\n");
    place.write("helper.c", "int deep(void);\nint helper(void);\nint helper(void) { return deep(); }\n");
    let cc = |args: &[&str]| succeed(Command::new(compiler("cc")).args(args).current_dir(place.path()));
    cc(&["-shared", "-fPIC", "deep.c", "-o", "libdeep_of_mine.so"]);
    cc(&["-shared", "-fPIC", "helper.c", "-o", "mine/libhelper.so", "-L.", "-ldeep_of_mine"]);
    let source = good().with(|s| s.before = s.before.replace("tatu_int(1)", "tatu_int(helper())"));
    let source = format!("int helper(void);\n{}", source.text());
    let links = ["-L.", "-lhelper", "-Wl,-rpath,$ORIGIN", "-Wl,--allow-shlib-undefined"];
    compile_with(&place, "x", &source, &links);
    said.because("an indirect dependency", &place, &["x"]);
}

#[test]
fn missing_symbols_and_versions_are_reported() {
    let mut said = said!();
    let calls = |all: &[&str]| {
        let declared: String = all.iter().map(|n| format!("int {n}(void);\n")).collect();
        let sum: Vec<String> = all.iter().map(|n| format!("{n}()")).collect();
        let source =
            good().with(|s| s.before = s.before.replace("tatu_int(1)", &format!("tatu_int({})", sum.join("+"))));
        declared + &source.text()
    };
    said.of_source("one symbol", &calls(&["nobody_has_this"]), &[]);
    said.of_source("many symbols", &calls(&["a_1", "a_2", "a_3", "a_4", "a_5", "a_6"]), &[]);
    said.of_source("of C++", &calls(&["_ZN4mine5thingEv"]), &[]);
    // A missing weak symbol is not an error.
    let place = folder();
    let weak = calls(&["nobody_has_this"])
        .replace("int nobody_has_this(void);", "__attribute__((weak)) int nobody_has_this(void);");
    compile(&place, "x", &weak);
    ask(&place, &["x"]).good();
    // The plugin was linked with a newer version of a library than the installed one.
    let place = folder();
    place.write("helper.c", "int helper(void);\nint helper(void) { return 2; }\n");
    place.write("old.map", "HELPER_1.9 { global: helper; local: *; };\n");
    place.write("new.map", "HELPER_1.9 { };\nHELPER_1.10 { global: helper; local: *; };\n");
    let build = |map: &str| {
        let script = format!("-Wl,--version-script={map}");
        let cc = ["-shared", "-fPIC", "helper.c", "-Wl,-soname,libhelper.so", &script, "-o", "mine/libhelper.so"];
        succeed(Command::new(compiler("cc")).args(cc).current_dir(place.path()));
    };
    build("new.map");
    compile_with(&place, "x", &calls(&["helper"]), &["-L.", "-lhelper", "-Wl,-rpath,$ORIGIN"]);
    ask(&place, &["x"]).good();
    fs::remove_file(place.path().join("mine/libhelper.so")).unwrap();
    build("old.map");
    said.because("an old version", &place, &["x"]);
}

#[test]
fn descriptors_for_other_hosts_are_reported() {
    let mut said = said!();
    let constructor = "__attribute__((constructor)) static void harm(void) { *(volatile int *)0 = 1; }\n";
    let source = |change: &dyn Fn(&mut PluginSource)| good().with(|s| change(s)).text();
    // Each of these libraries has a constructor that would crash if any of its code were run.
    let broken = |change: &dyn Fn(&mut PluginSource)| {
        source(&|s| {
            change(s);
            s.tail = constructor.into();
        })
    };
    said.of_source("another ABI", &broken(&|s| s.major = "7".into()), &[]);
    said.of_source("no size", &broken(&|s| s.size = "0".into()), &[]);
    said.of_source("a size of 4", &broken(&|s| s.size = "4".into()), &[]);
    said.of_source(
        "all zero",
        &format!("#include \"tatu.h\"\nTATU_EXPORT const tatu_plugin_t tatu_plugin = {{0}};\n{constructor}"),
        &[],
    );
    // The following libraries can be opened.
    said.of_source("a truncated descriptor", &source(&|s| s.size = "offsetof(tatu_plugin_t, extension)".into()), &[]);
    said.of_source("no id", &source(&|s| s.id = "NULL".into()), &[]);
    said.of_source("an id with a space", &source(&|s| s.id = "\"my plugin\"".into()), &[]);
    let draft = |s: &mut PluginSource| s.extension = s.extension.replace("TATU_COMMAND", "\"tatu.command/draft.1\"");
    said.of_source("another draft", &source(&draft), &[]);
    said.of_source(
        "offers nothing",
        &source(&|s| s.extension = "(void)id; (void)ext_command; return NULL;".into()),
        &[],
    );
    let needs = |s: &mut PluginSource| {
        s.before += "static const tatu_need a_need = {.size = sizeof(tatu_need), .id = \"tatu.host.dreams/1\"};
static const tatu_need *const all_needs[] = {&a_need, NULL};\n";
        s.needs = "all_needs".into();
    };
    said.of_source("an unknown service", &source(&needs), &[]);
}

#[test]
fn crashes_during_a_load_are_reported_and_contained() {
    let mut said = said!();
    let init = |body: &str| {
        format!("#include <unistd.h>\n#include <stdlib.h>\n{}", good().with(|s| s.init = body.into()).text())
    };
    said.of_source("init fails", &init("return tatu_fail(e, TATU_ERR, \"the licence has run out\");"), &[]);
    said.of_source("init calls exit", &init("exit(3);"), &[]);
    said.of_source("init calls _exit", &init("_exit(3);"), &[]);
    if cfg!(target_env = "gnu") {
        said.of_source("init crashes", &init("*(volatile int *)0 = 1; return TATU_OK;"), &[]);
        said.of_source("init aborts", &init("abort();"), &[]);
        let harm = "__attribute__((constructor)) static void harm(void) { *(volatile int *)0 = 1; }\n";
        said.of_source("a constructor crashes", &good().with(|s| s.tail = harm.into()).text(), &[]);
    }
    for (tried, body) in [
        ("init never returns", "for (;;) usleep(1000);"),
        ("init loops endlessly", "for (volatile int i = 0;; i++) {}"),
    ] {
        let place = folder();
        compile(&place, "x", &init(body).replace("-std=c11", ""));
        said.because(tried, &place, &["x", "--watchdog", "1"]);
    }
    // Output of the plugin is not mistaken for the diagnosis.
    let place = folder();
    compile(
        &place,
        "x",
        &format!(
            "#include <stdio.h>\n{}",
            good().with(|s| s.init = "printf(\"{}\\nno line\"); return TATU_OK;".into()).text()
        ),
    );
    ask(&place, &["x"]).good();
}
