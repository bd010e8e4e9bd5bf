//! Embeds the files that `tatu new` writes: the headers, the crate for plugins and the templates, as lists of path and
//! text.

use std::path::Path;

fn main() {
    let api = Path::new(&std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("../../plugin-api");
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
