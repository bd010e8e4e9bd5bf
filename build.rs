//! Sets cfgs for tools that this machine lacks, so that tests which need them count as ignored.

use std::path::Path;

fn main() {
    set_missing_tool_cfgs();
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
