//! Names of plugin files: compares a given name with the names of files.

use std::{
    env::consts::{DLL_PREFIX, DLL_SUFFIX},
    path::Path,
};

use tatu_core::{
    errors::nearest,
    plugins::{FolderOrigin, SearchPath},
};

/// Suffixes of libraries, and of files mistaken for them, on all systems.
const LIBRARY_SUFFIXES: [&str; 9] = [".so", ".dylib", ".dll", ".a", ".o", ".lib", ".rlib", ".bundle", ".pyd"];

/// The plugin that is searched for: an id, or the name of a library in any form.
pub struct PluginQuery {
    /// The text that was given.
    pub text: String,
    /// The base name, such as `hello`.
    core: String,
}

impl PluginQuery {
    pub fn new(text: &str) -> Self {
        // The last part of an id, which is usually the base name of the file.
        let last = if Self::is_id(text) { text.rsplit('.').next().unwrap_or(text) } else { text };
        PluginQuery { text: text.to_owned(), core: base_name(last) }
    }
    /// Returns whether a text is an id and not a file name: it contains a `.`, but has no suffix of a library.
    pub fn is_id(text: &str) -> bool {
        text.contains('.') && without_ending(&text.to_lowercase()).is_none()
    }
    /// Returns the expected file name, such as `libtatu_hello.so`.
    pub fn file(&self) -> String {
        library_name(&self.core)
    }
    /// Returns whether a file name refers to this plugin, even if it is not spelled correctly.
    pub fn matches(&self, file: &Path) -> bool {
        !self.core.is_empty() && base_name(&name(file)) == self.core
    }
    /// Returns the file with the most similar name, if there is one.
    pub fn nearest_file<'a>(&self, files: impl IntoIterator<Item = &'a Path>) -> Option<&'a Path> {
        let all: Vec<(String, &Path)> = files.into_iter().map(|f| (base_name(&name(f)), f)).collect();
        let found = nearest(&self.core, all.iter().map(|(c, _)| c.as_str()))?;
        all.iter().find(|(c, _)| c == found).map(|(_, f)| *f)
    }
}

/// Returns the last component of a path, as text.
pub fn name(file: &Path) -> String {
    file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Returns whether a file name is that of a plugin on this system.
pub fn is_plugin_name(file: &Path) -> bool {
    SearchPath::default().may_be_plugin(file, FolderOrigin::User)
}

/// Returns the expected file name: `libtatu_hello.so` for `hello.so`.
pub fn expected_name(file: &Path) -> String {
    library_name(&base_name(&name(file)))
}

/// Returns the pattern of plugin file names: `libtatu_NAME.so`.
pub fn form() -> String {
    library_name("NAME")
}

fn library_name(core: &str) -> String {
    format!("{DLL_PREFIX}tatu_{}{DLL_SUFFIX}", if core.is_empty() { "NAME" } else { core })
}

/// Removes the suffix of a library, and a version after it, as in `libx.so.1.2`.
fn without_ending(name: &str) -> Option<&str> {
    let plain = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
    let versioned = plain.ends_with(".so") && name[plain.len()..].starts_with('.');
    let name = if versioned { plain } else { name };
    LIBRARY_SUFFIXES.iter().find_map(|e| name.strip_suffix(e))
}

/// Returns the base name without conventional prefixes and suffixes: `hello` for `libtatu_hello.so.1` and `tatu-hello`.
fn base_name(name: &str) -> String {
    let name = name.to_lowercase().replace('-', "_");
    let stem = without_ending(&name).unwrap_or(&name);
    let stem = stem.strip_prefix("lib").filter(|s| !s.is_empty()).unwrap_or(stem);
    let stem = stem.strip_prefix("tatu").map(|s| s.trim_start_matches('_')).filter(|s| !s.is_empty()).unwrap_or(stem);
    stem.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_spellings_of_a_plugin_name_match() {
        for given in [
            "hello",
            "tatu_hello",
            "tatu-hello",
            "libtatu_hello.so",
            "hello.so",
            "libhello.so",
            "libtatu-hello.so",
            "libtatu_hello.so.1",
            "libtatu_hello.so.1.2.3",
            "libtatuhello.so",
            "LibTatu_Hello.SO",
            "tatu_hello.dll",
            "libtatu_hello.dylib",
            "libtatu_hello.a",
            "org.example.hello",
        ] {
            assert_eq!(PluginQuery::new(given).file(), library_name("hello"), "{given}");
            assert!(PluginQuery::new("hello").matches(Path::new(given)) || given.starts_with("org."), "{given}");
        }
        for given in ["hello2", "help", "hello_world", "lib", "tatu", ""] {
            assert_ne!(PluginQuery::new(given).file(), library_name("hello"), "{given}");
        }
    }

    #[test]
    fn only_plugin_file_names_are_accepted() {
        let name = |s: &str| format!("{DLL_PREFIX}{s}{DLL_SUFFIX}");
        assert!(is_plugin_name(Path::new(&name("tatu_hello"))));
        assert!(is_plugin_name(Path::new(&format!("a/tatu_hello{DLL_SUFFIX}"))));
        for wrong in [name("hello"), format!("{}.1", name("tatu_hello")), name("Tatu_hello"), "tatu_hello".into()] {
            assert!(!is_plugin_name(Path::new(&wrong)), "{wrong}");
        }
    }
}
