//! `tatu new addon`, `scene`, `robot`: folders without code to compile.

use tatu_core::errors::Result;

use super::{choice::Named, files::Files, sdk};

pub fn addon(named: &Named) -> Result {
    make(named, "addon", "my_addon", &["tatu run FOLDER/scene.toml --addon FOLDER/NAME.lua"])
}

pub fn scene(named: &Named) -> Result {
    make(named, "scene", "my_scene", &["tatu run FOLDER/scene.toml", "tatu open FOLDER/scene.toml"])
}

pub fn robot(named: &Named) -> Result {
    make(named, "robot", "my_robot", &["tatu run FOLDER/scene.toml"])
}

/// Writes the files of a template, and prints the commands `next`, in which FOLDER and NAME are replaced.
fn make(named: &Named, template: &str, own: &str, next: &[&str]) -> Result {
    let mut files = Files::new(named)?;
    for (path, text) in sdk::template(template) {
        files.put(path, text, own);
    }
    let (folder, name) = (files.shown(), files.name().to_owned());
    let next: Vec<String> = next.iter().map(|l| l.replace("FOLDER", &folder).replace("NAME", &name)).collect();
    files.write(&next)
}
