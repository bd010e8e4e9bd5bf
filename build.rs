//! Writes down which plugin packages belong to the program, so that it opens only those in cargo's `deps` folder and
//! can say which are missing when it has been copied away from them.

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
}
