//! Recorded runs: packed scenes with the input log and the hashes of a run, which `tatu verify` repeats.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use tatu_core::{
    World,
    document::Document,
    errors::Error,
    plugins::Registry,
    session::file::{AddonEntry, InputLogHeader, InputLogWriter},
};
use tatu_embed::pack::{self, PACKED_SCENE};
use tempfile::TempDir;

use super::pack::{check_name, files_of, warn_of_private_paths};
use crate::hashes::RunHashes;

/// The input log in a recorded run.
pub const INPUTS_NAME: &str = "run/inputs.jsonl";
/// The hashes in a recorded run.
pub const HASHES_NAME: &str = "run/hashes.jsonl";

/// A run that is being recorded.
pub struct Capsule {
    output: PathBuf,
    scene: PathBuf,
    /// The files of the packed scene.
    files: Vec<(String, Vec<u8>)>,
    /// The folder of the input log while it is being written.
    folder: TempDir,
    hashes: RunHashes,
}

impl Capsule {
    /// Packs the document of a run that is about to start, and creates its input log. `scene` is the scene file, and
    /// `added` are files that its scripts read. If `is_session` is set, the log begins before the start of the
    /// simulation.
    pub fn begin(
        output: &Path,
        scene: &Path,
        (document, registry): (&Arc<Document>, &Arc<Registry>),
        added: &[PathBuf],
        is_session: bool,
    ) -> Result<(Self, InputLogWriter), Error> {
        check_name(output)?;
        // What came through services is in the log, so a repetition starts none, and does not need their plugins.
        let mut without_services = Document::clone(document);
        without_services.requests.services.clear();
        let files = files_of(scene, &Arc::new(without_services), registry, added)?;
        let folder = tempfile::tempdir()
            .map_err(|e| Error::new("E105", format!("cannot create a temporary folder for the record: {e}")))?;
        let mut header = InputLogHeader::of_pack(Path::new(PACKED_SCENE), registry);
        header.session = is_session;
        let log = InputLogWriter::create(&folder.path().join("inputs.jsonl"), &header)?;
        let (output, scene, hashes) = (output.to_owned(), scene.to_owned(), RunHashes::default());
        Ok((Capsule { output, scene, files, folder, hashes }, log))
    }

    /// Records the hashes after a step, or after the start.
    pub fn step(&mut self, world: &World) {
        self.hashes.push(world.steps(), &world.hash());
    }

    /// Writes the file, after the end of the input log has been written.
    pub fn write(mut self) -> Result<(), Error> {
        let inputs = self.folder.path().join("inputs.jsonl");
        let inputs = fs::read(&inputs)
            .map_err(|e| Error::new("E105", format!("cannot read the input log {}: {e}", inputs.display())))?;
        self.files.push((INPUTS_NAME.to_owned(), inputs));
        self.files.push((HASHES_NAME.to_owned(), self.hashes.to_bytes()));
        warn_of_private_paths(&self.scene, &self.files);
        pack::write(&self.output, &self.files)
    }
}

/// Fails with E105 if add-ons run: a record does not contain them.
pub fn refuse_addons(entries: &[AddonEntry]) -> Result<(), Error> {
    let names: Vec<&str> = entries.iter().map(|addon| addon.name.as_str()).collect();
    if names.is_empty() {
        return Ok(());
    }
    let error = Error::new("E105", format!("cannot record a run with add-ons: {}", names.join(", ")));
    Err(error.help("run it without them, `--no-addons`; or record only its input: `--log FILE`"))
}

/// Returns the names of files, without the folders in which they are, which others need not know.
pub fn without_folders(files: &[String]) -> Vec<String> {
    let name = |file: &String| Path::new(file).file_name().map(|name| name.to_string_lossy().into_owned());
    files.iter().filter_map(name).collect()
}
