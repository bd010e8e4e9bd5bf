//! `tatu convert`: converts a scene of any format to a scene file, with meshes and scripts next to it.

use std::{path::Path, process::ExitCode};

use tatu_core::{
    World,
    document::{self, SceneFiles, SourceFiles},
    errors::Error,
    state::write_atomically,
};
use tatu_terminal::{Watchdog, report};

use crate::args::ConvertArgs;

/// Converts a scene; the exit code is 0 if it was written, otherwise 2.
pub fn convert(args: &ConvertArgs) -> ExitCode {
    match converted(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn converted(args: &ConvertArgs) -> Result<(), Error> {
    check_name(&args.output)?;
    let watchdog = Watchdog::start(args.watchdog, false);
    let registry = super::registry(Some(&args.scene), &SourceFiles::default(), &args.changes, &watchdog)?;
    let document = super::load(&args.scene, &args.changes.options(&[])?, &registry)?;
    let written = document::write(&document, &registry, &document::folder_beside(&args.output))?;
    save(&args.output, &written)?;
    let (objects, files) = (document.objects.len(), written.files.len());
    report::out!("{}: {objects} objects, {files} files next to it", args.output.display());
    Ok(())
}

/// Saves a running world as a scene file.
pub fn save_world(file: &Path, world: &World) -> Result<(), Error> {
    check_name(file)?;
    save(file, &document::write(&world.to_document(), &world.registry(), &document::folder_beside(file))?)
}

/// Checks that a file name has the suffix by which scene files are recognized.
pub fn check_name(file: &Path) -> Result<(), Error> {
    if file.extension().is_some_and(|e| e == "toml") {
        return Ok(());
    }
    let error = Error::new("E105", format!("cannot write {}", file.display()));
    Err(error.expected("a name that ends with `.toml`, as the names of all scene files do"))
}

/// Writes a scene file and the files next to it, and reports what a scene file cannot express.
fn save(scene: &Path, written: &SceneFiles) -> Result<(), Error> {
    document::save(scene, written, &write_atomically)?;
    for what in &written.left_out {
        report::note(&format!("{}: `{what}` is omitted: a scene file cannot express it", scene.display()));
    }
    Ok(())
}
