//! Embeds the page, and its libraries if `npm ci` was run in `page/` before; the program then needs neither Node nor a
//! network.

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use serde_json::{Map, Value, json};

/// Libraries: the name by which modules import them, and the file in `node_modules`.
const LIBRARIES: &[(&str, &str)] = &[
    ("three", "three/build/three.module.min.js"),
    ("three/controls", "three/examples/jsm/controls/OrbitControls.js"),
    ("three/gizmo", "three/examples/jsm/controls/TransformControls.js"),
    ("@codemirror/state", "@codemirror/state/dist/index.js"),
    ("@codemirror/view", "@codemirror/view/dist/index.js"),
    ("@codemirror/language", "@codemirror/language/dist/index.js"),
    ("@codemirror/commands", "@codemirror/commands/dist/index.js"),
    ("@codemirror/autocomplete", "@codemirror/autocomplete/dist/index.js"),
    ("@codemirror/lint", "@codemirror/lint/dist/index.js"),
    ("@codemirror/legacy-modes/mode/lua", "@codemirror/legacy-modes/mode/lua.js"),
    ("@lezer/common", "@lezer/common/dist/index.js"),
    ("@lezer/highlight", "@lezer/highlight/dist/index.js"),
    ("@lezer/lr", "@lezer/lr/dist/index.js"),
    ("@marijn/find-cluster-break", "@marijn/find-cluster-break/src/index.js"),
    ("crelt", "crelt/index.js"),
    ("style-mod", "style-mod/src/style-mod.js"),
    ("w3c-keyname", "w3c-keyname/index.js"),
];

/// Files that libraries import by relative path.
const BESIDE: &[&str] = &["three/build/three.core.min.js"];

fn kind(path: &Path) -> Option<&'static str> {
    Some(match path.extension()?.to_str()? {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "svg" => "image/svg+xml",
        _ => return None,
    })
}

fn main() {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo tells the folder")).join("page");
    println!("cargo::rerun-if-changed=page");
    let mut entries: Vec<(String, &'static str, PathBuf)> = Vec::new();
    let mut imports = Map::new();
    let mut names: Vec<PathBuf> = fs::read_dir(&root).expect("the page").flatten().map(|e| e.path()).collect();
    names.sort();
    for path in names.into_iter().filter(|p| p.is_file()) {
        let (Some(kind), Some(name)) = (kind(&path), path.file_name().and_then(|n| n.to_str())) else { continue };
        if let Some(stem) = name.strip_suffix(".js") {
            imports.insert(format!("tatu/{stem}"), Value::String(format!("/page/{name}")));
        }
        entries.push((format!("/page/{name}"), kind, path.clone()));
    }
    let modules = root.join("node_modules");
    let whole = LIBRARIES.iter().all(|(_, file)| modules.join(file).is_file());
    if whole {
        let files = LIBRARIES.iter().map(|(_, f)| *f).chain(BESIDE.iter().copied());
        for file in files {
            entries.push((format!("/lib/{file}"), "text/javascript; charset=utf-8", modules.join(file)));
        }
        for (name, file) in LIBRARIES {
            imports.insert((*name).to_owned(), Value::String(format!("/lib/{file}")));
        }
    } else {
        println!(
            "cargo::warning=the program is built without its page, whose libraries are missing: run `npm ci` in plugins/views/web/page, and build again"
        );
    }
    let map = json!({ "imports": imports }).to_string();
    let mut out =
        String::from("/// Path, type and bytes of each file.\npub static FILES: &[(&str, &str, &[u8])] = &[\n");
    for (name, kind, path) in &entries {
        out += &format!("    ({name:?}, {kind:?}, include_bytes!({:?})),\n", path.display().to_string());
    }
    out += &format!("];\n/// The import map.\npub const IMPORT_MAP: &str = {map:?};\n");
    out += &format!("/// Whether the libraries are embedded.\npub const WHOLE: bool = {whole};\n");
    let to = PathBuf::from(env::var_os("OUT_DIR").expect("cargo tells the folder")).join("files.rs");
    fs::write(to, out).expect("the list of files");
}
