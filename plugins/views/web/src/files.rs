//! The page as it was embedded.

use base64::{Engine, engine::general_purpose::STANDARD};
use sha2::{Digest, Sha256};
use tatu_services_common::listener::Page;

include!(concat!(env!("OUT_DIR"), "/files.rs"));

/// Where the import map stands in the page.
const MAP: &str = "<!-- import map -->";

/// What a path is answered with.
pub fn page(path: &str) -> Option<Page> {
    let path = if path == "/" { "/page/index.html" } else { path };
    let (_, kind, bytes) = FILES.iter().find(|(name, _, _)| *name == path)?;
    if path != "/page/index.html" {
        return Some((kind, bytes.to_vec(), Vec::new()));
    }
    let mut map = format!("<script type=\"importmap\">{IMPORT_MAP}</script>");
    if !WHOLE {
        map += MISSING;
    }
    let text = String::from_utf8_lossy(bytes).replace(MAP, &map);
    Some((kind, text.into_bytes(), vec![("Content-Security-Policy", policy(WHOLE))]))
}

/// Where libraries come from that are not embedded: each file by its version and its sum. Untested where there is no internet.
const ELSEWHERE: &str = "https://cdn.jsdelivr.net";
/// What stands on the page until its modules run.
const MISSING: &str = "<p id=\"missing\">The libraries of this page are not in this program: they are fetched from \
    cdn.jsdelivr.net. If nothing else appears, run <code>npm ci</code> in <code>plugins/views/web/page</code>, and build \
    the program again.</p>";

/// Scripts come from here alone, and from elsewhere only where the libraries are not embedded; the one that stands in the page is
/// known by its sum.
fn policy(whole: bool) -> String {
    let sum = STANDARD.encode(Sha256::digest(IMPORT_MAP.as_bytes()));
    let elsewhere = if whole { String::new() } else { format!(" {ELSEWHERE}") };
    format!(
        "default-src 'none'; script-src 'self' 'sha256-{sum}'{elsewhere}; style-src 'self' 'unsafe-inline'; connect-src 'self'; \
         img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_come_from_here_alone() {
        let (kind, text, headers) = page("/").unwrap();
        assert!(kind.starts_with("text/html"));
        let text = String::from_utf8(text).unwrap();
        let (name, policy) = &headers[0];
        assert_eq!(*name, "Content-Security-Policy");
        assert!(policy.contains("default-src 'none'") && !policy.contains("script-src 'self' 'unsafe"));
        // No script but the import map stands in the page, and its sum is the one that is allowed.
        assert!(text.matches("<script").count() <= 2);
        if WHOLE {
            let map = text.split("importmap\">").nth(1).and_then(|t| t.split("</script>").next()).unwrap();
            assert!(policy.contains(&STANDARD.encode(Sha256::digest(map.as_bytes()))));
        }
        assert_eq!(super::policy(true), super::policy(false).replace(&format!(" {ELSEWHERE}"), ""));
        assert!(page("/page/../Cargo.toml").is_none() && page("/etc/passwd").is_none());
    }

    /// The addresses and sums of libraries that are not embedded are those of the files that `npm ci` brought.
    #[test]
    fn libraries_from_elsewhere_are_pinned() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("page/integrity.json");
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        for name in LIBRARIES {
            assert!(std::env::var_os("TATU_BLESS").is_some() || text.contains(name), "{name} is not pinned");
        }
        if !WHOLE {
            println!("1 skipped: `npm ci` was not run in plugins/views/web/page");
            return;
        }
        let modules = file.with_file_name("node_modules");
        let lock = std::fs::read_to_string(file.with_file_name("package-lock.json")).unwrap();
        let lock: serde_json::Value = serde_json::from_str(&lock).unwrap();
        let mut pinned = serde_json::Map::new();
        for name in LIBRARIES {
            let parts = if name.starts_with('@') { 2 } else { 1 };
            let at = name.match_indices('/').nth(parts - 1).unwrap().0;
            let version = lock["packages"][format!("node_modules/{}", &name[..at])]["version"].as_str().unwrap();
            let sum = STANDARD.encode(sha2::Sha384::digest(std::fs::read(modules.join(name)).unwrap()));
            let address = format!("{ELSEWHERE}/npm/{}@{version}{}", &name[..at], &name[at..]);
            let entry = serde_json::json!({ "address": address, "integrity": format!("sha384-{sum}") });
            pinned.insert((*name).to_owned(), entry);
        }
        let now = serde_json::to_string_pretty(&pinned).unwrap() + "\n";
        if std::env::var_os("TATU_BLESS").is_some() {
            std::fs::write(&file, &now).unwrap();
        } else {
            assert_eq!(text, now, "TATU_BLESS=1 cargo test -p tatu-views-web writes page/integrity.json anew");
        }
    }
}
