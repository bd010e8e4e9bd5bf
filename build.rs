//! Embeds the files that `tatu new` writes. Sets cfgs for tools that this machine lacks, so that tests which need them
//! count as ignored.

use std::path::Path;

fn main() {
    embed();
    set_missing_tool_cfgs();
}

/// Embeds the files that `tatu new` writes: the headers, the crate for plugins and the templates, as lists of path and
/// text.
fn embed() {
    let api = Path::new(&std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("plugin-api");
    // The parts of the crate that plugins need: without tests and the record of layouts.
    let of_crate = ["src", "schemas", "README.md"];
    let of_templates =
        |path: &str| !["c_command", "cpp_command", "rust_sensor"].iter().any(|own| path.starts_with(own));
    let mut text = String::new();
    let mut list = |name: &str, base: &Path, parts: &[&str], wanted: &dyn Fn(&str) -> bool| {
        let mut files = Vec::new();
        parts.iter().for_each(|part| list_files(&base.join(part), &mut files));
        files.sort();
        text += &format!("/// Path and text.\npub const {name}: &[(&str, &str)] = &[\n");
        for file in files {
            let path = file.strip_prefix(base).unwrap_or(&file).display().to_string().replace('\\', "/");
            if wanted(&path) {
                text += &format!("    ({path:?}, include_str!({:?})),\n", file.display().to_string());
            }
        }
        text += "];\n";
    };
    list("HEADERS", &api.join("include"), &["tatu.h", "tatu"], &|_| true);
    list("CRATE", &api, &of_crate, &|_| true);
    list("TESTKIT", &api.join("testkit"), &["src"], &|_| true);
    list("TEMPLATES", &api.join("template"), &[""], &of_templates);
    let to = Path::new(&std::env::var("OUT_DIR").unwrap_or_default()).join("embedded.rs");
    // A failure is ignored here: without the file, the program does not compile.
    let _ = std::fs::write(to, text);
}

/// Finds all files at or below a path, and makes cargo run this script again if one of them or a folder changes.
fn list_files(path: &Path, files: &mut Vec<std::path::PathBuf>) {
    println!("cargo::rerun-if-changed={}", path.display());
    match std::fs::read_dir(path) {
        Ok(entries) => {
            entries.flatten().filter(|e| e.file_name() != "target").for_each(|e| list_files(&e.path(), files))
        }
        Err(_) => files.push(path.to_owned()),
    }
}

/// Sets cfgs: `no_shared`: there is no folder `../shared` with data that is not part of the repository; `no_cxx`: no
/// C++ compiler; `no_pypi`: no Python that can install packages, or `TATU_OFFLINE` is set; `no_browser`: no Chromium,
/// or the page was built without its libraries.
fn set_missing_tool_cfgs() {
    println!("cargo::rustc-check-cfg=cfg(no_shared, no_cxx, no_pypi, no_browser)");
    for variable in ["CXX", "PATH", "TATU_OFFLINE"] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    let has_folder = |path: &str| {
        let is_there = Path::new(path).is_dir();
        if is_there {
            println!("cargo::rerun-if-changed={path}");
        }
        is_there
    };
    let answers = |program: &str, args: &[&str]| {
        std::process::Command::new(program).args(args).output().is_ok_and(|out| out.status.success())
    };
    let is_on_path = |names: &[&str]| {
        let path = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&path).any(|folder| names.iter().any(|name| folder.join(name).is_file()))
    };
    let cxx = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    let offline = std::env::var_os("TATU_OFFLINE").is_some();
    // Set by the build script of the page.
    let page = std::env::var_os("DEP_TATU_PAGE_WHOLE").is_some_and(|whole| whole == "true");
    // The accessibility checker that browser tests run in the page.
    println!("cargo::rustc-env=TATU_AXE={}", std::env::var("DEP_TATU_PAGE_AXE").unwrap_or_default());
    for (lacks, name) in [
        (!has_folder("../shared/seeds/scripts"), "no_shared"),
        (!answers(&cxx, &["--version"]), "no_cxx"),
        (offline || !answers("python3", &["-c", "import ensurepip, pip, venv"]), "no_pypi"),
        (!page || !is_on_path(&["chromium", "chromium-browser", "google-chrome"]), "no_browser"),
    ] {
        if lacks {
            println!("cargo::rustc-cfg={name}");
        }
    }
}
