//! The files of a folder that is made: written only where nothing is.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use tatu_core::errors::Result;

use super::{
    choice::{Named, refused},
    name,
};
use crate::report;

/// The files of one folder, by their paths in it.
pub struct Files {
    folder: PathBuf,
    name: String,
    all: Vec<(String, String)>,
}

impl Files {
    /// For a folder `name` in another; refused if there is such a thing.
    pub fn new(named: &Named) -> Result<Self> {
        name::check(&named.name)?;
        let folder = named.to.join(&named.name);
        if folder.symlink_metadata().is_ok() {
            return Err(refused(format!("{} is there already", folder.display()))
                .help("choose another name, or another folder by `--to DIR`; nothing was changed"));
        }
        Ok(Files { folder, name: named.name.clone(), all: Vec::new() })
    }
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// A file of a template, with the name in place of the template's own, in its path and its text.
    pub fn put(&mut self, path: &str, text: &str, own: &str) {
        self.add(&name::put(path, own, &self.name), &name::put(text, own, &self.name));
    }
    /// A file as it is.
    pub fn add(&mut self, path: &str, text: &str) {
        self.all.push((path.to_owned(), text.to_owned()));
    }
    /// Writes all, and prints what to do next.
    pub fn write(self, next: &[String]) -> Result {
        for (path, text) in &self.all {
            write_new(&self.folder.join(path), text)?;
        }
        let own = |path: &&str| !path.starts_with("sdk/");
        let paths: Vec<&str> = self.all.iter().map(|(path, _)| path.as_str()).filter(own).collect();
        report::out!("created {}: {}", self.shown(), paths.join(", "));
        if let Some((first, rest)) = next.split_first() {
            report::out!("next: {first}");
            rest.iter().for_each(|line| report::out!("      {line}"));
        }
        Ok(())
    }
    /// The folder, for command lines.
    pub fn shown(&self) -> String {
        self.folder.strip_prefix(".").unwrap_or(&self.folder).display().to_string()
    }
}

/// Writes a file that is not there yet, and the folders above it.
fn write_new(file: &Path, text: &str) -> Result {
    let written = file.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| {
        let mut new = fs::OpenOptions::new().write(true).create_new(true).open(file)?;
        new.write_all(text.as_bytes())
    });
    written.map_err(|e| refused(format!("cannot write {}: {e}", file.display())))
}
