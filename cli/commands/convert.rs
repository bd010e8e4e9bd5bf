//! `tatu convert`: a scene of any format as a scene file, with meshes and scripts beside it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use tatu_core::{
    document::{self, Sources, Written},
    errors::Error,
    state::write_whole,
};

use crate::{args::Convert, report};

/// Exit code 0 if it is written, else 2.
pub fn convert(args: &Convert) -> ExitCode {
    match converted(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn converted(args: &Convert) -> Result<(), Error> {
    if args.output.extension().is_none_or(|e| e != "toml") {
        return Err(Error::new("E105", format!("cannot write {}", args.output.display()))
            .expected("a name that ends with `.toml`, by which scene files are known"));
    }
    let registry = super::registry(Some(&args.scene), &Sources::default(), &args.changes.allow)?;
    let document = super::load(&args.scene, &args.changes.options(&[])?, &registry)?;
    let written = document::write(&document, &registry, &folder_of(&args.output))?;
    save(&args.output, &written)?;
    let (objects, files) = (document.objects.len(), written.files.len());
    report::out!("{}: {objects} objects, {files} files beside it", args.output.display());
    Ok(())
}

/// The folder for what stands beside a scene file, seen from it.
pub fn folder_of(scene: &Path) -> String {
    let stem = scene.file_stem().map_or("scene".into(), |s| s.to_string_lossy().into_owned());
    format!("{stem}_files")
}

/// Writes a scene file after those that it names, so that it never names what is not there.
pub fn save(scene: &Path, written: &Written) -> Result<(), Error> {
    let above = scene.parent().unwrap_or(Path::new(""));
    let fail = |path: &Path, e: std::io::Error| Error::new("E105", format!("cannot write {}: {e}", path.display()));
    for (name, bytes) in &written.files {
        let path: PathBuf = above.join(name);
        let folder = path.parent().unwrap_or(above);
        fs::create_dir_all(folder).map_err(|e| fail(folder, e))?;
        write_whole(&path, bytes).map_err(|e| fail(&path, e))?;
    }
    write_whole(scene, written.text.as_bytes()).map_err(|e| fail(scene, e))?;
    for what in &written.left_out {
        report::note(&format!("{}: `{what}` is left out: a scene file cannot say it", scene.display()));
    }
    Ok(())
}
