//! The page of a film, a single file. Its modules are `data:` URLs in the import map and import each other by bare
//! names, because a page opened from disk cannot import modules by path.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Map, json};
use tatu_plugin_api::safe::{Fail, Result};

use crate::files::{FILES, WHOLE};

/// Modules that the live page also has, and modules that replace others.
const SAME: &[&str] = &[
    "dom", "icons", "calls", "geometry", "parse", "wants", "store", "tree", "output", "light", "plain", "view",
    "looking", "objects", "crowd", "surfaces", "sensing", "volumes", "drawings", "plot",
];
const OTHER: &[(&str, &str)] =
    &[("net", "film_net"), ("film_net", "film_net"), ("editor", "film_script"), ("film", "film")];
/// Libraries: the name by which modules import them, and the file.
const LIBRARIES: &[(&str, &str)] = &[
    ("three", "/lib/three/build/three.module.min.js"),
    ("three/core", "/lib/three/build/three.core.min.js"),
    ("three/controls", "/lib/three/examples/jsm/controls/OrbitControls.js"),
];
/// Relative path by which one library imports another, and the bare name that replaces it.
const BESIDE: (&str, &str) = ("\"./three.core.min.js\"", "\"three/core\"");

/// Checks that films can be created.
pub fn check() -> Result {
    if WHOLE {
        return Ok(());
    }
    Err(Fail::unsupported("this program was built without the libraries of its page, which films require")
        .help("install npm, and build the program again"))
}

fn file(path: &str) -> String {
    let found = FILES.iter().find(|(name, _, _)| *name == path);
    String::from_utf8_lossy(found.map_or(&[][..], |f| f.2)).into_owned()
}

/// Builds the page with a compressed recording.
pub fn page(recording: &[u8]) -> String {
    let mut imports = Map::new();
    let mut put = |name: String, text: String| {
        imports.insert(name, json!(format!("data:text/javascript;base64,{}", STANDARD.encode(text))));
    };
    for name in SAME {
        put(format!("tatu/{name}"), file(&format!("/page/{name}.js")));
    }
    for (name, own) in OTHER {
        put(format!("tatu/{name}"), file(&format!("/page/{own}.js")));
    }
    for (name, path) in LIBRARIES {
        put((*name).to_owned(), file(path).replace(BESIDE.0, BESIDE.1));
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
    fn nothing_is_fetched() {
        if !WHOLE {
            return;
        }
        let page = page(b"x");
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
