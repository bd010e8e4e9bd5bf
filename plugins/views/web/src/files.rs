//! Serves the embedded files of the page.

use base64::{Engine, engine::general_purpose::STANDARD};
use sha2::{Digest, Sha256};
use tatu_services_common::listener::FileResponse;

include!(concat!(env!("OUT_DIR"), "/files.rs"));

/// Placeholder in `index.html` for the import map.
const IMPORT_MAP_PLACEHOLDER: &str = "<!-- import map -->";

/// Header of files whose path contains the version, so that a browser stores them and never asks for them again.
const STORED: (&str, &str) = ("Cache-Control", "max-age=31536000, immutable");

/// Returns the embedded file for the path of a request, or `None` if there is none.
pub fn embedded_file(path: &str) -> Option<FileResponse> {
    serve_file(path, HAS_LIBRARIES)
}

/// Returns the path of a file without the version, if it contains the version.
fn without_version(path: &str) -> Option<&str> {
    path.strip_prefix('/')?.strip_prefix(VERSION)
}

fn serve_file(path: &str, whole: bool) -> Option<FileResponse> {
    let path = if path == "/" { "/page/index.html" } else { path };
    let versioned = without_version(path);
    let path = versioned.unwrap_or(path);
    let (_, kind, bytes) = FILES.iter().find(|(name, _, _)| *name == path)?;
    if path != "/page/index.html" {
        let (name, value) = STORED;
        return Some((kind, bytes.to_vec(), versioned.map(|_| (name, value.to_owned())).into_iter().collect()));
    }
    let text = if whole {
        let head = format!("<script type=\"importmap\">{IMPORT_MAP}</script>\n{}", preloads());
        let page = String::from_utf8_lossy(bytes).replace("\"/page/", &format!("\"/{VERSION}/page/"));
        page.replace(IMPORT_MAP_PLACEHOLDER, &head)
    } else {
        MISSING_PAGE.to_owned()
    };
    Some((kind, text.into_bytes(), vec![("Content-Security-Policy", policy())]))
}

/// Prefixes of modules that are not preloaded: those of films, and those of the script editor, which are loaded when a
/// script is opened.
const LAZY_MODULES: &[&str] = &[
    "/page/film/",
    "/page/documents/code_field.js",
    "/lib/@codemirror",
    "/lib/@lezer",
    "/lib/@marijn",
    "/lib/crelt",
    "/lib/style-mod",
    "/lib/w3c-keyname",
];

/// Returns preload tags for all modules that `LAZY_MODULES` does not exclude. Without the tags, the browser would
/// discover one module after another by following imports.
fn preloads() -> String {
    let later = |path: &&str| LAZY_MODULES.iter().any(|start| path.starts_with(start));
    let modules = FILES.iter().map(|(path, _, _)| *path).filter(|path| path.ends_with(".js") && !later(path));
    modules.map(|path| format!("<link rel=\"modulepreload\" href=\"/{VERSION}{path}\">\n")).collect()
}

/// The page of a program that was built without the page's libraries.
const MISSING_PAGE: &str = "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>Tatu</title>\n\
    <p id=\"missing\">This program was built without the libraries of its page: install <code>npm</code>, and build the \
    program again.</p>\n</html>\n";

/// Returns the content security policy of the page. Scripts must come from this server; the inline import map is
/// allowed by its hash.
fn policy() -> String {
    let sum = STANDARD.encode(Sha256::digest(IMPORT_MAP.as_bytes()));
    format!(
        "default-src 'none'; script-src 'self' 'sha256-{sum}'; style-src 'self' 'unsafe-inline'; connect-src 'self'; \
         img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn page_policy_allows_only_own_scripts() {
        let (kind, text, headers) = embedded_file("/").unwrap();
        assert!(kind.starts_with("text/html"));
        let text = String::from_utf8(text).unwrap();
        let (name, policy) = &headers[0];
        assert_eq!(*name, "Content-Security-Policy");
        assert!(policy.contains("default-src 'none'") && !policy.contains("script-src 'self' 'unsafe"));
        assert!(!policy.contains("http"), "{policy}");
        // The import map is the only inline script, and its hash is the allowed one.
        assert!(text.matches("<script").count() <= 2);
        if HAS_LIBRARIES {
            let map = text.split("importmap\">").nth(1).and_then(|t| t.split("</script>").next()).unwrap();
            assert!(policy.contains(&STANDARD.encode(Sha256::digest(map.as_bytes()))));
        }
        assert!(embedded_file("/page/../Cargo.toml").is_none() && embedded_file("/etc/passwd").is_none());
    }

    #[test]
    fn modules_in_folders_are_embedded_without_their_tests() {
        let (kind, _, _) = embedded_file("/page/net/connection.js").unwrap();
        assert!(kind.starts_with("text/javascript"), "{kind}");
        let (kind, _, _) = embedded_file("/page/run/exercise.lua").unwrap();
        assert!(kind.starts_with("text/plain"), "{kind}");
        let entry = format!("\"tatu/net/connection\":\"/{VERSION}/page/net/connection.js\"");
        assert!(IMPORT_MAP.contains(&entry), "{IMPORT_MAP}");
        assert!(!FILES.iter().any(|(path, _, _)| path.contains("/tests/") || path.contains("/node_modules/")));
        let preloads = preloads();
        assert!(preloads.contains("/page/view/renderer.js") && preloads.contains("/page/run/film_recorder.js"));
        for lazy in LAZY_MODULES.iter().filter(|start| start.starts_with("/page/")) {
            assert!(FILES.iter().any(|(path, _, _)| path.starts_with(lazy)) && !preloads.contains(lazy), "{lazy}");
        }
    }

    #[test]
    fn only_files_of_this_version_are_stored_by_browsers() {
        let (_, text, headers) = embedded_file(&format!("/{VERSION}/page/net/connection.js")).unwrap();
        assert_eq!(headers, [(STORED.0, STORED.1.to_owned())]);
        assert_eq!(embedded_file("/page/net/connection.js").unwrap(), ("text/javascript; charset=utf-8", text, vec![]));
        assert!(embedded_file("/0123456789abcdef/page/net/connection.js").is_none());
        let (_, page, headers) = embedded_file("/").unwrap();
        assert!(!headers.iter().any(|(name, _)| *name == STORED.0));
        let page = String::from_utf8(page).unwrap();
        assert_eq!(page.contains(&format!("/{VERSION}/page/style.css")), HAS_LIBRARIES);
        assert!(!page.contains("\"/page/"), "{page}");
    }

    #[test]
    fn page_without_libraries_shows_only_a_message() {
        let (_, text, _) = serve_file("/", false).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains("install <code>npm</code>, and build the program again"), "{text}");
        assert!(!["<script", "<link", "http", "src="].iter().any(|part| text.contains(part)), "{text}");
    }
}
