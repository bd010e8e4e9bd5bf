//! Tests of `tatu plugin install`: plugins are installed in the user's folder, and invalid archives are refused as a
//! whole.

#![cfg(target_os = "linux")]

use std::{fs, io::Write, os::unix::fs::PermissionsExt, path::PathBuf};

use crate::{kit::plugin_sources::*, kit::*};

/// The folder in which plugins are installed, relative to the test's folder.
const INSTALL_FOLDER: &str = ".data/tatu/plugins";

/// Creates a folder with a plugin `mine/libtatu_<name>.so` that has the given id and version.
fn built(name: &str, id: &str, version: &str) -> TestFolder {
    let place = TestFolder::new();
    make(&place, name, id, version);
    place
}

fn make(place: &TestFolder, name: &str, id: &str, version: &str) {
    fs::create_dir_all(place.path().join("mine")).unwrap();
    let source = PluginSource::new(name).with(|s| s.id = format!("\"{id}\"")).text();
    compile(place, name, &source.replace(".version = \"1\"", &format!(".version = \"{version}\"")));
}

fn install(place: &TestFolder, args: &[&str]) -> RunOutput {
    place.tatu(&[&["plugin", "install"], args].concat())
}

/// Returns the names of the installed files.
fn installed(place: &TestFolder) -> Vec<String> {
    let entries = fs::read_dir(place.path().join(INSTALL_FOLDER)).into_iter().flatten();
    let mut all: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    all.sort();
    all
}

#[test]
fn an_installed_plugin_is_loaded_everywhere_until_it_is_removed() {
    let place = built("hello", "org.test.hello", "1.0.0");
    let done = install(&place, &["mine/libtatu_hello.so"]).good();
    assert!(
        done.out.starts_with("installed `org.test.hello` 1.0.0: ") && done.out.ends_with("libtatu_hello.so\n"),
        "{}",
        done.out
    );
    assert!(done.err.is_empty(), "{}", done.err);
    assert_eq!(installed(&place), ["libtatu_hello.so"]);
    let mode = |path: &str| fs::metadata(place.path().join(path)).unwrap().permissions().mode() & 0o777;
    assert_eq!((mode(INSTALL_FOLDER), mode(&format!("{INSTALL_FOLDER}/libtatu_hello.so"))), (0o755, 0o644));
    let listed = || place.tatu(&["list", "plugins", "--json"]).good().json().to_string();
    assert!(listed().contains("org.test.hello"));
    place.tatu(&["plugin", "why", "hello"]).good();
    let rows = place.tatu(&["plugin", "list", "--json"]).good().json();
    assert_eq!(rows.as_array().unwrap().last().unwrap()["from"], "user");
    install(&place, &["--remove", "org.test.helo"]).refused(&[
        "error[E332]",
        "`org.test.helo`",
        "did you mean `org.test.hello`?",
    ]);
    let done = install(&place, &["--remove", "org.test.hello"]).good();
    assert!(done.out.starts_with("removed `org.test.hello` 1.0.0: "), "{}", done.out);
    assert!(installed(&place).is_empty() && !listed().contains("org.test.hello"));
    install(&place, &["--remove", "org.test.hello"]).refused(&["error[E332]", "tatu plugin list"]);
}

#[test]
fn a_plugin_is_replaced_by_force_only() {
    let place = built("hello", "org.test.hello", "1.0.0");
    install(&place, &["mine/libtatu_hello.so"]).good();
    make(&place, "hello", "org.test.hello", "2.0.0");
    let done = install(&place, &["mine/libtatu_hello.so"]);
    done.refused(&["error[E331]", "version 1.0.0", "this is version 2.0.0", "`--force` replaces it"]);
    let done = install(&place, &["mine/libtatu_hello.so", "--force"]).good();
    assert!(done.out.starts_with("replaced `org.test.hello` 1.0.0 by 2.0.0: "), "{}", done.out);
    // With a new file name, the old file is removed.
    make(&place, "renamed", "org.test.hello", "3.0.0");
    install(&place, &["mine/libtatu_renamed.so"]).refused(&["error[E331]"]);
    install(&place, &["mine/libtatu_renamed.so", "--force"]).good();
    assert_eq!(installed(&place), ["libtatu_renamed.so"]);
    // The file of another plugin is never replaced, even with `--force`.
    make(&place, "renamed", "org.test.another", "1.0.0");
    for args in [&["mine/libtatu_renamed.so"][..], &["mine/libtatu_renamed.so", "--force"]] {
        install(&place, args).refused(&["error[E331]", "it is the plugin `org.test.hello`", "--remove org.test.hello"]);
    }
    // A file that is not a plugin is replaced with `--force`.
    fs::write(place.path().join(INSTALL_FOLDER).join("libtatu_renamed.so"), "damaged").unwrap();
    install(&place, &["mine/libtatu_renamed.so"]).refused(&["error[E331]", "it is not a plugin that can be loaded"]);
    install(&place, &["mine/libtatu_renamed.so", "--force"]).good();
    assert_eq!(installed(&place), ["libtatu_renamed.so"]);
}

#[test]
fn plugins_that_cannot_be_loaded_are_not_installed() {
    let place = built("good", "org.test.good", "1");
    let broken = |name: &str, source: &str| compile(&place, name, source);
    broken("abi", &PluginSource::new("abi").with(|s| s.major = "7".into()).text());
    broken(
        "crash",
        &PluginSource::new("crash").with(|s| s.init = "*(volatile int *)0 = 1; return TATU_OK;".into()).text(),
    );
    broken("none", "int x(void);\nint x(void) { return 1; }\n");
    for (name, words) in [
        ("abi", &["it was built for ABI 7."][..]),
        ("crash", &["it crashes (SIGSEGV) in `tatu_plugin.init`"]),
        ("none", &["therefore no `tatu_plugin`"]),
    ] {
        let file = format!("mine/libtatu_{name}.so");
        let done = install(&place, &[&file]);
        done.refused(&[&["error[E330]", &format!("cannot install {file}: it "), "help: "], words].concat());
        assert!(!done.err.contains(".tatu-"), "{}", done.err);
    }
    place.write("mine/libtatu_text.so", "text");
    install(&place, &["mine/libtatu_text.so"]).refused(&["error[E330]", "it is a text file"]);
    install(&place, &["mine/none.so"]).refused(&["error[E330]", "there is no such file"]);
    fs::copy(place.path().join("mine/libtatu_good.so"), place.path().join("mine/good.so")).unwrap();
    install(&place, &["mine/good.so"]).refused(&["error[E330]", "rename it to libtatu_good.so"]);
    assert!(!place.path().join(INSTALL_FOLDER).exists(), "a folder is left: {:?}", installed(&place));
}

#[test]
fn a_project_is_installed_from_its_folder() {
    let place = built("hello", "org.test.hello", "1");
    let build = place.path().join("project/build");
    fs::create_dir_all(&build).unwrap();
    install(&place, &["project"]).refused(&[
        "error[E330]",
        "there is no libtatu_NAME.so in it",
        "build the plugin first",
    ]);
    fs::copy(place.path().join("mine/libtatu_hello.so"), build.join("libtatu_hello.so")).unwrap();
    install(&place, &["project"]).good();
    fs::copy(place.path().join("mine/libtatu_hello.so"), build.join("libtatu_again.so")).unwrap();
    install(&place, &["project"]).refused(&[
        "error[E330]",
        "it contains 2 plugins",
        "libtatu_again.so",
        "name the library to install",
    ]);
    // The argument can be the folder that contains the library.
    install(&place, &["mine", "--force"]).good();
}

#[test]
fn a_hidden_plugin_is_installed_with_a_warning() {
    let place = built("hello", "org.test.hello", "1");
    let args = ["plugin", "install", "mine/libtatu_hello.so"];
    let done = run(program(), place.path(), &args, &[("TATU_PLUGIN_PATH", "mine")]).good();
    done.reports(&["warning[E302]", "mine/libtatu_hello.so has the same id and is searched first"]);
}

/// Returns a tar file with the given entries: name, type and contents.
fn tar(entries: &[(&str, tar::EntryType, &[u8])]) -> Vec<u8> {
    let mut builder = tar::Builder::new(Vec::new());
    for (name, sort, bytes) in entries {
        let mut header = tar::Header::new_gnu();
        header.set_entry_type(*sort);
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        // The name is written directly into the header because the library would refuse some of these names.
        header.as_old_mut().name[..name.len()].copy_from_slice(name.as_bytes());
        if matches!(sort, tar::EntryType::Symlink | tar::EntryType::Link) {
            header.set_link_name("libtatu_hello.so").unwrap();
        }
        header.set_cksum();
        builder.append(&header, *bytes).unwrap();
    }
    builder.into_inner().unwrap()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn zip(entries: &[(&str, u32, &[u8])]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, mode, bytes) in entries {
        let options = zip::write::SimpleFileOptions::default().unix_permissions(*mode);
        writer.start_file(*name, options).unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn archive(place: &TestFolder, name: &str, bytes: &[u8]) -> PathBuf {
    let file = place.path().join(name);
    fs::write(&file, bytes).unwrap();
    file
}

#[test]
fn archives_are_unpacked_and_only_the_library_is_installed() {
    use tar::EntryType::{Directory, Regular};
    let place = built("hello", "org.test.hello", "1");
    let library = fs::read(place.path().join("mine/libtatu_hello.so")).unwrap();
    let plain = tar(&[
        ("hello-1/", Directory, b""),
        ("hello-1/README.md", Regular, b"read me"),
        ("hello-1/build/libtatu_hello.so", Regular, &library),
    ]);
    archive(&place, "hello.tar", &plain);
    archive(&place, "hello.tar.gz", &gzip(&plain));
    archive(&place, "hello.tgz", &gzip(&plain));
    archive(
        &place,
        "hello.zip",
        &zip(&[("hello/README.md", 0o644, b"read me"), ("hello/libtatu_hello.so", 0o644, &library)]),
    );
    for name in ["hello.tar", "hello.tar.gz", "hello.tgz", "hello.zip"] {
        let done = install(&place, &[name, "--force"]).good();
        assert!(done.out.contains("`org.test.hello` 1"), "{name}: {}", done.out);
        assert_eq!(installed(&place), ["libtatu_hello.so"], "{name}");
        install(&place, &["--remove", "org.test.hello"]).good();
    }
    archive(&place, "none.tar", &tar(&[("README.md", Regular, b"read me")]));
    install(&place, &["none.tar"])
        .refused(&["error[E330]", "cannot install none.tar: there is no libtatu_NAME.so in it"]);
    archive(
        &place,
        "two.tar",
        &tar(&[("a/libtatu_hello.so", Regular, &library), ("b/libtatu_hello.so", Regular, &library)]),
    );
    install(&place, &["two.tar"]).refused(&["it contains 2 plugins: `a/libtatu_hello.so` and `b/libtatu_hello.so`"]);
    archive(&place, "broken.tar", &tar(&[("libtatu_hello.so", Regular, b"text")]));
    install(&place, &["broken.tar"]).refused(&["cannot install broken.tar: it is a text file"]);
    assert!(installed(&place).is_empty());
}

#[test]
fn archives_with_anything_but_plain_files_are_refused() {
    use tar::EntryType::{Block, Char, Fifo, Link, Regular, Symlink};
    let place = built("hello", "org.test.hello", "1");
    let library = fs::read(place.path().join("mine/libtatu_hello.so")).unwrap();
    let good = ("libtatu_hello.so", Regular, library.as_slice());
    for (name, sort, words) in [
        ("../escape", Regular, "`../escape`, a path that leads out of its folder"),
        ("a/../../escape", Regular, "a path that leads out of its folder"),
        ("/escape", Regular, "an absolute path"),
        ("a\\..\\..\\escape", Regular, "a path that leads out of its folder"),
        ("D:escape", Regular, "a path with a drive"),
        ("link", Symlink, "`link`, which is a symbolic link, not a regular file"),
        ("link", Link, "which is a hard link"),
        ("null", Char, "which is a device"),
        ("disk", Block, "which is a device"),
        ("pipe", Fifo, "which is a pipe"),
    ] {
        let bytes = tar(&[good, (name, sort, b"")]);
        archive(&place, "bad.tar", &bytes);
        archive(&place, "bad.tar.gz", &gzip(&bytes));
        for file in ["bad.tar", "bad.tar.gz"] {
            install(&place, &[file]).refused(&[
                "error[E330]",
                &format!("cannot install {file}: it contains `"),
                words,
                "help: pack regular files",
            ]);
        }
    }
    for (name, mode, words) in
        [("../escape", 0o644, "a path that leads out of its folder"), ("/escape", 0o644, "an absolute path")]
    {
        archive(&place, "bad.zip", &zip(&[("libtatu_hello.so", 0o644, &library), (name, mode, b"x")]));
        install(&place, &["bad.zip"]).refused(&["error[E330]", words]);
    }
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    writer.add_symlink("link", "libtatu_hello.so", zip::write::SimpleFileOptions::default()).unwrap();
    archive(&place, "bad.zip", &writer.finish().unwrap().into_inner());
    install(&place, &["bad.zip"]).refused(&["error[E330]", "`link`, which is a symbolic link"]);
    // A small archive contains a very large file.
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    let mut header = tar::Header::new_gnu();
    header.set_path("zeros").unwrap();
    header.set_size(257 << 20);
    header.set_cksum();
    encoder.write_all(header.as_bytes()).unwrap();
    archive(&place, "bomb.tar.gz", &encoder.finish().unwrap());
    install(&place, &["bomb.tar.gz"]).refused(&["error[E330]", "more than 256 MiB"]);
    // Truncated archives are refused.
    let bytes = gzip(&tar(&[good]));
    archive(&place, "cut.tar.gz", &bytes[..bytes.len() / 2]);
    install(&place, &["cut.tar.gz"]).refused(&["error[E330]", "cannot be unpacked", "download or copy it again"]);
    archive(&place, "cut.zip", &zip(&[("libtatu_hello.so", 0o644, &library)])[..1000]);
    install(&place, &["cut.zip"]).refused(&["error[E330]", "cannot be unpacked"]);
    assert!(!place.path().join(".data").join("tatu/plugins").exists());
    assert!(!place.path().join("escape").exists() && !place.path().parent().unwrap().join("escape").exists());
}

/// A plugin that starts only if its assets say "hello".
const ASSET_PLUGIN: &str = r#"
#include "tatu.h"
#include <stdio.h>
#include <string.h>
static tatu_status init(const tatu_host *host, void **self, tatu_error *error) {
  char path[4096], text[16] = "";
  (void)self;
  if (!TATU_HAS(host, assets)) return tatu_fail(error, TATU_ERR_MISSING, "there are no assets");
  snprintf(path, sizeof path, "%s/words/greeting.txt", host->assets);
  FILE *file = fopen(path, "r");
  if (!file) return tatu_fail(error, TATU_ERR_MISSING, "there is no greeting");
  if (!fgets(text, sizeof text, file)) text[0] = 0;
  fclose(file);
  return strcmp(text, "hello") ? tatu_fail(error, TATU_ERR, "a wrong greeting") : TATU_OK;
}
static tatu_status greet(tatu_call *call) { return tatu_return(call, tatu_string("hello")); }
static const tatu_command greet_command = {.size = sizeof greet_command, .names = TATU_NAME("reader.greet"),
  .text = "Greets.", .call = greet};
static const tatu_command *const commands[] = {&greet_command, 0};
static const tatu_ext_command command = {.size = sizeof command, .commands = commands};
static const void *extension(void *self, const char *id) { (void)self; return strcmp(id, TATU_COMMAND) ? 0 : &command; }
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.test.reader", .name = "Reader", .version = "1", .licence = "MIT",
  .init = init, .extension = extension};
"#;

#[test]
fn assets_go_with_their_library() {
    let place = TestFolder::new();
    fs::create_dir_all(place.path().join("mine")).unwrap();
    compile(&place, "reader", ASSET_PLUGIN);
    install(&place, &["mine/libtatu_reader.so"]).refused(&["there are no assets"]);
    assert!(installed(&place).is_empty());
    fs::create_dir_all(place.path().join("mine/tatu_reader.assets/words")).unwrap();
    place.write("mine/tatu_reader.assets/words/greeting.txt", "hello");
    install(&place, &["mine/libtatu_reader.so"]).good();
    assert_eq!(installed(&place), ["libtatu_reader.so", "tatu_reader.assets"]);
    let listed = place.tatu(&["list", "plugins", "--json"]).good().json().to_string();
    assert!(listed.contains("org.test.reader"), "{listed}");
    // New assets replace the old ones. If the plugin refuses to start with them, nothing is changed.
    place.write("mine/tatu_reader.assets/words/greeting.txt", "goodbye");
    install(&place, &["mine/libtatu_reader.so", "--force"]).refused(&["a wrong greeting"]);
    assert_eq!(installed(&place), ["libtatu_reader.so", "tatu_reader.assets"]);
    assert_eq!(place.read(&format!("{INSTALL_FOLDER}/tatu_reader.assets/words/greeting.txt")), "hello");
    // A link to a parent folder would lead to an endless copy.
    std::os::unix::fs::symlink("..", place.path().join("mine/tatu_reader.assets/words/loop")).unwrap();
    install(&place, &["mine/libtatu_reader.so", "--force"]).refused(&["nested more than"]);
    install(&place, &["--remove", "org.test.reader"]).good();
    assert!(installed(&place).is_empty());
}

/// A plugin whose command returns what the library `dep` returns.
const DEPENDENT: &str = r#"#include "tatu/command.h"
double dep(void);
static tatu_status TATU_CALL get(tatu_call *c) { return tatu_return(c, tatu_float(dep())); }
static const tatu_command it = {.size = sizeof(tatu_command), .names = TATU_NAME("CALLED.get"), .call = get,
  .text = "Asks a library.", .example = "assert(CALLED.get() == VALUE)"};
TATU_PLUGIN(TATU_COMMANDS(&it), .id = "org.test.CALLED", .name = "Beside", .version = "1.0.0", .licence = "MIT");
"#;

/// Builds a library `dep` that returns a value, and a plugin that is linked with it. `libraries` is the folder of the
/// library, relative to that of the plugin.
fn dependent(place: &TestFolder, name: &str, value: u32, libraries: &str, rpath: &str) {
    let folder = place.path().join("mine").join(libraries);
    fs::create_dir_all(&folder).unwrap();
    place.write("mine/dep.c", &format!("double dep(void) {{ return {value}; }}\n"));
    let mut cc = std::process::Command::new(compiler("cc"));
    cc.args(["-shared", "-fPIC", "-o"]).arg(folder.join("libdep.so")).arg("dep.c");
    succeed(cc.current_dir(place.path().join("mine")));
    let source = DEPENDENT.replace("CALLED", name).replace("VALUE", &value.to_string());
    compile_with(place, name, &source, &[&format!("-L{}", folder.display()), "-ldep", rpath]);
}

/// Returns what the command of an installed plugin returns.
fn asked(place: &TestFolder, name: &str) -> String {
    place.write(
        "scene.toml",
        &format!("format = 1\n{}", watcher("w", &format!("function sysCall_init() print({name}.get()) end"))),
    );
    // The folder in which the plugin was built must not matter.
    fs::rename(place.path().join("mine"), place.path().join("moved")).unwrap();
    let done = place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
    fs::rename(place.path().join("moved"), place.path().join("mine")).unwrap();
    done.out.trim().to_owned()
}

#[test]
fn a_library_beside_a_plugin_is_installed_and_removed_with_it() {
    let place = TestFolder::new();
    dependent(&place, "beside", 42, "", "-Wl,-rpath,$ORIGIN");
    let done = install(&place, &["mine"]).good();
    assert!(done.out.ends_with("libtatu_beside.so, with libdep.so\n"), "{}", done.out);
    assert_eq!(installed(&place), ["libdep.so", "libtatu_beside.so"]);
    assert_eq!(asked(&place, "beside"), "42.0");
    let listed = place.tatu(&["plugin", "list", "--json"]).good().json();
    let files = listed.as_array().unwrap().iter().filter(|row| row["from"] == "user");
    assert_eq!(files.map(|row| &row["state"]).collect::<Vec<_>>(), ["loaded"], "{listed}");
    // Another plugin shares an equal library, which stays until neither needs it.
    dependent(&place, "other", 42, "", "-Wl,-rpath,$ORIGIN");
    install(&place, &["mine/libtatu_other.so"]).good();
    install(&place, &["--remove", "org.test.beside"]).good();
    assert_eq!(installed(&place), ["libdep.so", "libtatu_other.so"]);
    // A different library of the same name would change that plugin.
    dependent(&place, "beside", 43, "", "-Wl,-rpath,$ORIGIN");
    for force in [&["mine/libtatu_beside.so"][..], &["mine/libtatu_beside.so", "--force"]] {
        install(&place, force).refused(&["error[E331]", "libdep.so already exists", "`org.test.other` needs it"]);
    }
    assert_eq!(asked(&place, "other"), "42.0");
    install(&place, &["--remove", "org.test.other"]).good();
    assert!(installed(&place).is_empty(), "{:?}", installed(&place));
    // A new version brings its own.
    install(&place, &["mine/libtatu_beside.so"]).good();
    dependent(&place, "beside", 44, "", "-Wl,-rpath,$ORIGIN");
    install(&place, &["mine/libtatu_beside.so", "--force"]).good();
    assert_eq!(asked(&place, "beside"), "44.0");
    // Nothing is needed any longer by a version that is linked statically.
    fs::remove_file(place.path().join("mine/libdep.so")).unwrap();
    let source =
        DEPENDENT.replace("CALLED", "beside").replace("double dep(void);", "static double dep(void) { return 45; }");
    compile(&place, "beside", &source.replace("VALUE", "45"));
    install(&place, &["mine/libtatu_beside.so", "--force"]).good();
    assert_eq!(installed(&place), ["libtatu_beside.so"]);
}

#[test]
fn a_library_among_the_assets_is_installed_with_them() {
    let place = TestFolder::new();
    dependent(&place, "beside", 42, "tatu_beside.assets", "-Wl,-rpath,$ORIGIN/tatu_beside.assets");
    install(&place, &["mine"]).good();
    assert_eq!(installed(&place), ["libtatu_beside.so", "tatu_beside.assets"]);
    assert_eq!(asked(&place, "beside"), "42.0");
    install(&place, &["--remove", "org.test.beside"]).good();
    assert!(installed(&place).is_empty());
}

#[test]
fn libraries_that_an_installed_plugin_would_not_find_are_named() {
    let place = TestFolder::new();
    let refused = |words: &[&str]| {
        install(&place, &["mine"]).refused(&[&["error[E330]", "needs the library libdep.so"], words].concat());
        assert!(!place.path().join(INSTALL_FOLDER).exists(), "{:?}", installed(&place));
    };
    // In a folder that is not copied, although the plugin works where it is.
    dependent(&place, "beside", 1, "lib", "-Wl,-rpath,$ORIGIN/lib");
    refused(&["which it will not find once it is installed", "mine/lib/libdep.so", "$ORIGIN/tatu_beside.assets"]);
    // Without a path.
    dependent(&place, "beside", 1, "", "-Wl,-rpath,/nowhere");
    refused(&["which is not found", "it is in", "$ORIGIN"]);
    // A link out of the folder; one within it is followed.
    dependent(&place, "beside", 1, "", "-Wl,-rpath,$ORIGIN");
    let [library, real] = ["mine/libdep.so", "libdep.so.1"].map(|f| place.path().join(f));
    fs::rename(&library, &real).unwrap();
    std::os::unix::fs::symlink(&real, &library).unwrap();
    refused(&["which is a link out of its folder", "libdep.so.1"]);
    fs::rename(&real, place.path().join("mine/libdep.so.1")).unwrap();
    fs::remove_file(&library).unwrap();
    std::os::unix::fs::symlink("libdep.so.1", &library).unwrap();
    install(&place, &["mine"]).good();
    assert!(fs::symlink_metadata(place.path().join(INSTALL_FOLDER).join("libdep.so")).unwrap().is_file());
    assert_eq!(asked(&place, "beside"), "1.0");
}

#[test]
fn a_library_in_an_archive_is_not_taken_from_it() {
    let place = TestFolder::new();
    dependent(&place, "beside", 1, "", "-Wl,-rpath,$ORIGIN");
    let [plugin, library] =
        ["libtatu_beside.so", "libdep.so"].map(|f| fs::read(place.path().join("mine").join(f)).unwrap());
    let both =
        [("libtatu_beside.so", tar::EntryType::Regular, &plugin[..]), ("libdep.so", tar::EntryType::Regular, &library)];
    archive(&place, "both.tar", &tar(&both));
    install(&place, &["both.tar"]).refused(&["libdep.so, which is not found", "unpack the archive"]);
    assert!(!place.path().join(INSTALL_FOLDER).exists());
}

#[test]
fn a_plugin_with_a_library_beside_it_is_checked_and_reloaded() {
    let place = TestFolder::new();
    for (libraries, rpath) in [("", "$ORIGIN"), ("tatu_beside.assets", "$ORIGIN/tatu_beside.assets")] {
        dependent(&place, "beside", 42, libraries, &format!("-Wl,-rpath,{rpath}"));
        place.tatu(&["plugin", "check", "mine/libtatu_beside.so", "--only", "examples,reload"]).good();
        place.write(
            "scene.toml",
            &format!("format = 1\n{}", watcher("w", "function sysCall_init() print(beside.get()) end")),
        );
        let env = [("TATU_PLUGIN_PATH", "mine")];
        let done = run(program(), place.path(), &["run", "scene.toml", "--reload", "--steps", "2"], &env).good();
        assert!(done.out.contains("42.0"), "{}{}", done.out, done.err);
        assert!(!done.err.contains("its name is not a plugin's"), "{}", done.err);
        fs::remove_dir_all(place.path().join("mine")).unwrap();
    }
}
