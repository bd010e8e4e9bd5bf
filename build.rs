//! Writes down which plugin packages belong to the program, so that it opens only those in cargo's `deps` folder and
//! can say which are missing when it has been copied away from them. Tells tests what this machine lacks, so that those
//! which cannot run count as ignored.

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

/// `no_shared`: there is no folder `../shared` with data that is not part of the repository; `no_cxx`: no C++ compiler.
fn tell_what_is_missing() {
    println!("cargo::rustc-check-cfg=cfg(no_shared, no_cxx)");
    let shared = std::path::Path::new("../shared/seeds/scripts");
    if shared.is_dir() {
        println!("cargo::rerun-if-changed={}", shared.display());
    } else {
        println!("cargo::rustc-cfg=no_shared");
    }
    println!("cargo::rerun-if-env-changed=CXX");
    println!("cargo::rerun-if-env-changed=PATH");
    let cxx = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    if std::process::Command::new(cxx).arg("--version").output().is_err() {
        println!("cargo::rustc-cfg=no_cxx");
    }
}
