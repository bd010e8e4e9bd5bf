//! The SDK for plugins and the templates: files of this repository, embedded by build.rs.

use super::choice::Lang;

include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// The version of Tatu to which the embedded files belong.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Returns the files of a template, each as its path in the template folder and its contents.
pub fn template(folder: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let of = move |(path, text): &(&'static str, &'static str)| {
        let name = path.split_once('/').filter(|(f, _)| *f == folder)?.1;
        Some((name, *text))
    };
    TEMPLATES.iter().filter_map(of)
}

/// Returns the text of a file in the template folder `project`, or an empty string.
pub fn common(name: &str) -> &'static str {
    template("project").find(|(n, _)| *n == name).map_or("", |(_, text)| text)
}

/// Returns the files of a project's folder `sdk`, each as its path in the project and its contents.
pub fn files(lang: Lang) -> Vec<(String, String)> {
    let headers = HEADERS.iter().map(|(path, text)| (format!("sdk/include/{path}"), (*text).to_owned()));
    let mut all: Vec<_> = headers.collect();
    if lang == Lang::Rust {
        all.extend(CRATE.iter().map(|(path, text)| (format!("sdk/rust/{path}"), (*text).to_owned())));
        all.push(("sdk/rust/Cargo.toml".into(), common("sdk.toml").replace("VERSION", VERSION)));
        all.extend(TESTKIT.iter().map(|(path, text)| (format!("sdk/testkit/{path}"), (*text).to_owned())));
        all.push(("sdk/testkit/Cargo.toml".into(), common("testkit.toml").replace("VERSION", VERSION)));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sdk_files_are_embedded() {
        let c = files(Lang::C);
        assert!(
            c.iter().any(|(p, _)| p == "sdk/include/tatu.h")
                && c.iter().any(|(p, _)| p == "sdk/include/tatu/plugin.hpp")
        );
        assert!(!c.iter().any(|(p, _)| p.starts_with("sdk/rust")));
        let rust = files(Lang::Rust);
        for path in ["src/lib.rs", "src/safe/declare/sensor.rs", "schemas/proximity.toml", "Cargo.toml"] {
            assert!(rust.iter().any(|(p, _)| *p == format!("sdk/rust/{path}")), "{path}");
        }
        assert!(rust.iter().any(|(p, _)| p == "sdk/testkit/src/measuring.rs"));
        assert!(template("sensor_c").count() == 1 && !common("README.md").is_empty());
    }
}
