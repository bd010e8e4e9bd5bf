//! Builds the page of a film as a single file. Its modules are `data:` URLs in the import map and import each other by
//! bare specifiers, because a page opened from disk cannot import modules by path.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Map, json};
use tatu_plugin_api::safe::{Fail, Result};

use crate::files::{FILES, HAS_LIBRARIES};

/// Modules that the film shares with the live page, by their paths in the folder of the page.
const SHARED_MODULES: &[&str] = &[
    "lib/dom",
    "lib/icons",
    "lib/language",
    "lib/portuguese",
    "lib/plot",
    "net/calls",
    "net/binary_messages",
    "net/model_copies",
    "net/subscriptions",
    "scene/store",
    "scene/hierarchy",
    "scene/messages",
    "view/light",
    "view/instancing",
    "view/textures",
    "view/objects",
    "view/software_rendering",
    "view/renderer",
    "view/picking",
    "view/camera_controls",
    "view/scan_surface",
    "view/sensor_readings",
    "view/sensor_volumes",
    "view/volume_geometry",
    "view/drawings",
    "panels/tree",
    "panels/output",
    "film/player",
    "film/recording",
    "film/connection",
];
/// Modules of the live page that are replaced in films, and the modules that replace them.
const REPLACED_MODULES: &[(&str, &str)] =
    &[("net/connection", "film/connection"), ("documents/script_editor", "film/script_viewer")];
/// The libraries: the specifier by which modules import each of them, and the path of its embedded file.
const LIBRARIES: &[(&str, &str)] = &[
    ("three", "/lib/three/build/three.module.min.js"),
    ("three/core", "/lib/three/build/three.core.min.js"),
    ("three/controls", "/lib/three/examples/jsm/controls/OrbitControls.js"),
];
/// The relative import of `three.core` in `three`, and the bare specifier that replaces it.
const CORE_IMPORT: (&str, &str) = ("\"./three.core.min.js\"", "\"three/core\"");

/// Fails if the libraries, which a film needs, are not embedded in this program.
pub fn require_libraries() -> Result {
    if HAS_LIBRARIES {
        return Ok(());
    }
    Err(Fail::unsupported("films are not available, because this program was built without the libraries of its page")
        .help("install npm, and build the program again"))
}

/// Returns the content of an embedded file as text; empty if there is no such file.
fn file(path: &str) -> String {
    let found = FILES.iter().find(|(name, _, _)| *name == path);
    String::from_utf8_lossy(found.map_or(&[][..], |f| f.2)).into_owned()
}

/// Builds the page of a film from a recording that is compressed with gzip.
pub fn build_page(recording: &[u8]) -> String {
    let mut imports = Map::new();
    let mut put = |name: String, text: String| {
        imports.insert(name, json!(format!("data:text/javascript;base64,{}", STANDARD.encode(text))));
    };
    for name in SHARED_MODULES {
        put(format!("tatu/{name}"), file(&format!("/page/{name}.js")));
    }
    for (name, own) in REPLACED_MODULES {
        put(format!("tatu/{name}"), file(&format!("/page/{own}.js")));
    }
    for (name, path) in LIBRARIES {
        put((*name).to_owned(), file(path).replace(CORE_IMPORT.0, CORE_IMPORT.1));
    }
    file("/page/film.html")
        .replace("/* style */", &file("/page/style.css"))
        .replace(
            "<!-- import map -->",
            &format!("<script type=\"importmap\">{}</script>", json!({ "imports": imports })),
        )
        .replace("<!-- recording -->", &STANDARD.encode(recording))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn film_page_fetches_no_resources() {
        if !HAS_LIBRARIES {
            return;
        }
        let page = build_page(b"x");
        let map = page.split("importmap\">").nth(1).and_then(|t| t.split("</script>").next()).unwrap();
        let map: serde_json::Value = serde_json::from_str(map).unwrap();
        for (name, address) in map["imports"].as_object().unwrap() {
            let text = address.as_str().and_then(|a| a.strip_prefix("data:text/javascript;base64,")).unwrap();
            let text = String::from_utf8(STANDARD.decode(text).unwrap()).unwrap();
            assert!(text.len() > 100 && !text.contains("from\"./") && !text.contains("from './"), "{name}");
        }
        assert!(page.contains(&STANDARD.encode("x")) && !page.contains("src=\"/"));
    }
}
