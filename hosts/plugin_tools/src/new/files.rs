//! Collects and writes the files of a new folder; never overwrites anything.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use tatu_core::errors::Result;

use super::{
    choice::{NewItemArgs, refused},
    name,
};
use tatu_terminal::report;

/// The files of a new folder, each with its path relative to that folder.
pub struct NewFiles {
    folder: PathBuf,
    name: String,
    all: Vec<(String, String)>,
}

impl NewFiles {
    /// Creates an empty list of files. Fails with E610 if the name is invalid, or if the folder already exists.
    pub fn new(named: &NewItemArgs) -> Result<Self> {
        name::check(&named.name)?;
        let folder = named.to.join(&named.name);
        if folder.symlink_metadata().is_ok() {
            return Err(refused(format!("{} already exists", folder.display()))
                .help("choose another name, or another folder with `--to DIR`; nothing was changed"));
        }
        Ok(NewFiles { folder, name: named.name.clone(), all: Vec::new() })
    }
    /// Returns the name of the new folder.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Adds a file of a template, and replaces the template's name `own` in its path and its text by the new name.
    pub fn add_renamed(&mut self, path: &str, text: &str, own: &str) {
        self.add(&name::replace_name(path, own, &self.name), &name::replace_name(text, own, &self.name));
    }
    /// Adds a file without any replacement.
    pub fn add(&mut self, path: &str, text: &str) {
        self.all.push((path.to_owned(), text.to_owned()));
    }
    /// Writes all files, and prints the commands `next` for the user to run.
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
    /// Returns the path of the folder for display in command lines.
    pub fn shown(&self) -> String {
        self.folder.strip_prefix(".").unwrap_or(&self.folder).display().to_string()
    }
}

/// Creates a file, which must not exist yet, and its parent folders.
fn write_new(file: &Path, text: &str) -> Result {
    let written = file.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| {
        let mut new = fs::OpenOptions::new().write(true).create_new(true).open(file)?;
        new.write_all(text.as_bytes())
    });
    written.map_err(|e| refused(format!("cannot write {}: {e}", file.display())))
}
