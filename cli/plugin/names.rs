//! Names of plugins' files: what was asked for, what a file is called, and whether both mean the same.

use std::{
    env::consts::{DLL_PREFIX, DLL_SUFFIX},
    path::Path,
};

use tatu_core::{
    errors::nearest,
    plugins::{Search, Source},
};

/// Endings of libraries and of what is taken for one, here or on other systems.
const ENDINGS: [&str; 9] = [".so", ".dylib", ".dll", ".a", ".o", ".lib", ".rlib", ".bundle", ".pyd"];

/// What was asked for: an id, or the name of a library in one of its forms.
pub struct Wanted {
    /// As it was given.
    pub text: String,
    /// What the name comes to: `hello`.
    core: String,
}

impl Wanted {
    pub fn new(text: &str) -> Self {
        // Of an id the last part, which is what its file is mostly called.
        let last = if Self::is_id(text) { text.rsplit('.').next().unwrap_or(text) } else { text };
        Wanted { text: text.to_owned(), core: core(last) }
    }
    /// Whether a text is an id rather than the name of a file: it has a `.`, and no ending that a library has.
    pub fn is_id(text: &str) -> bool {
        text.contains('.') && without_ending(&text.to_lowercase()).is_none()
    }
    /// How the file of such a plugin is called: `libtatu_hello.so`.
    pub fn file(&self) -> String {
        right(&self.core)
    }
    /// Whether a file's name means this one, rightly spelt or not.
    pub fn is_meant_by(&self, file: &Path) -> bool {
        !self.core.is_empty() && core(&name(file)) == self.core
    }
    /// The name that is spelt nearly so, if there is one.
    pub fn near<'a>(&self, files: impl IntoIterator<Item = &'a Path>) -> Option<&'a Path> {
        let all: Vec<(String, &Path)> = files.into_iter().map(|f| (core(&name(f)), f)).collect();
        let found = nearest(&self.core, all.iter().map(|(c, _)| c.as_str()))?;
        all.iter().find(|(c, _)| c == found).map(|(_, f)| *f)
    }
}

/// The last part of a path, as text.
pub fn name(file: &Path) -> String {
    file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Whether the name of a file is that of a plugin on this system.
pub fn is_right(file: &Path) -> bool {
    Search::default().may_be_plugin(file, Source::User)
}

/// How a file should be called: `libtatu_hello.so` for `hello.so`.
pub fn should_be(file: &Path) -> String {
    right(&core(&name(file)))
}

/// How files of plugins are called: `libtatu_NAME.so`.
pub fn form() -> String {
    right("NAME")
}

fn right(core: &str) -> String {
    format!("{DLL_PREFIX}tatu_{}{DLL_SUFFIX}", if core.is_empty() { "NAME" } else { core })
}

/// Without the ending of a library, or of what stands for one; also without the version behind it: `libx.so.1.2`.
fn without_ending(name: &str) -> Option<&str> {
    let plain = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
    let versioned = plain.ends_with(".so") && name[plain.len()..].starts_with('.');
    let name = if versioned { plain } else { name };
    ENDINGS.iter().find_map(|e| name.strip_suffix(e))
}

/// A name without what systems, compilers and habits put around it: `hello` for `libtatu_hello.so.1`, `tatu-hello`.
fn core(name: &str) -> String {
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
    fn all_forms_of_a_name_mean_the_same() {
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
            assert_eq!(Wanted::new(given).file(), right("hello"), "{given}");
            assert!(Wanted::new("hello").is_meant_by(Path::new(given)) || given.starts_with("org."), "{given}");
        }
        for given in ["hello2", "help", "hello_world", "lib", "tatu", ""] {
            assert_ne!(Wanted::new(given).file(), right("hello"), "{given}");
        }
    }

    #[test]
    fn only_names_of_plugins_are_right() {
        let name = |s: &str| format!("{DLL_PREFIX}{s}{DLL_SUFFIX}");
        assert!(is_right(Path::new(&name("tatu_hello"))));
        assert!(is_right(Path::new(&format!("a/tatu_hello{DLL_SUFFIX}"))));
        for wrong in [name("hello"), format!("{}.1", name("tatu_hello")), name("Tatu_hello"), "tatu_hello".into()] {
            assert!(!is_right(Path::new(&wrong)), "{wrong}");
        }
    }
}
