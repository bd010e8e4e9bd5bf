//! Passes the names of the program's plugin packages to this crate, in the environment variable `TATU_BUILT_PLUGINS`.

fn main() {
    let path = "../../Cargo.toml";
    println!("cargo::rerun-if-changed={path}");
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let manifest: toml_edit::DocumentMut = text.parse().unwrap_or_default();
    let dependencies = manifest.get("dependencies").and_then(|d| d.as_table());
    let is_plugin =
        |item: &toml_edit::Item| item.get("path").and_then(|p| p.as_str()).is_some_and(|p| p.starts_with("plugins/"));
    let plugins = dependencies.into_iter().flatten().filter(|(_, item)| is_plugin(item));
    let names: Vec<String> = plugins.map(|(name, _)| name.replace('-', "_")).collect();
    println!("cargo::rustc-env=TATU_BUILT_PLUGINS={}", names.join(","));
}
