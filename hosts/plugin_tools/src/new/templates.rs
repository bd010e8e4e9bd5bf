//! `tatu new addon`, `scene`, `robot`, `course`: folders without code to compile.

use tatu_core::errors::Result;

use super::{choice::NewItemArgs, files::NewFiles, sdk};

pub fn addon(named: &NewItemArgs) -> Result {
    create_from_template(named, "addon", "my_addon", &["tatu run FOLDER/scene.toml --addon FOLDER/NAME.lua"])
}

pub fn scene(named: &NewItemArgs) -> Result {
    create_from_template(named, "scene", "my_scene", &["tatu run FOLDER/scene.toml", "tatu open FOLDER/scene.toml"])
}

pub fn robot(named: &NewItemArgs) -> Result {
    create_from_template(named, "robot", "my_robot", &["tatu run FOLDER/scene.toml"])
}

pub fn course(named: &NewItemArgs) -> Result {
    create_from_template(
        named,
        "course",
        "my_course",
        &[
            "tatu open FOLDER/scene.toml",
            "tatu grade FOLDER/scene.toml FOLDER/teacher/criteria.lua FOLDER/teacher/solution.lua",
        ],
    )
}

/// Writes the files of a template, and prints the commands `next`, in which FOLDER and NAME are replaced.
fn create_from_template(named: &NewItemArgs, template: &str, own: &str, next: &[&str]) -> Result {
    let mut files = NewFiles::new(named)?;
    for (path, text) in sdk::template(template) {
        files.add_renamed(path, text, own);
    }
    let (folder, name) = (files.shown(), files.name().to_owned());
    let next: Vec<String> = next.iter().map(|l| l.replace("FOLDER", &folder).replace("NAME", &name)).collect();
    files.write(&next)
}
