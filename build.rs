//! Writes down which plugin packages belong to the program, so that it opens only those in cargo's `deps` folder and
//! can say which are missing when it has been copied away from them. Tells tests what this machine lacks, so that those
//! which cannot run count as ignored.

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=Cargo.toml");
    let text = std::fs::read_to_string("Cargo.toml").unwrap_or_default();
    let manifest: toml_edit::DocumentMut = text.parse().unwrap_or_default();
    let mut names: Vec<String> = Vec::new();
    if let Some(dependencies) = manifest.get("dependencies").and_then(|d| d.as_table()) {
        for (name, item) in dependencies {
            let path = item.get("path").and_then(|p| p.as_str()).unwrap_or("");
            if path.starts_with("plugins/") {
                names.push(name.replace('-', "_"));
            }
        }
    }
    names.sort();
    println!("cargo::rustc-env=TATU_BUILT_PLUGINS={}", names.join(","));
    tell_what_is_missing();
}

/// `no_shared`: there is no folder `../shared` with data that is not part of the repository; `no_cxx`: no C++ compiler;
/// `no_pypi`: no Python that can install packages, or `TATU_OFFLINE` is set; `no_browser`: no Chromium, or the page was
/// built without its libraries.
fn tell_what_is_missing() {
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
    let page = has_folder("plugins/views/web/page/node_modules/three");
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
