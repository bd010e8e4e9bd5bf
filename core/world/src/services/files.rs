//! `tatu.host.files`: access to files within the folders that the run allows.

use std::{fs::File, path::Path};

use tatu_plugin_api::abi::*;

use super::answer::{AnswerContext, lend, require, with_context};
use tatu_scene::folders::OpenError;

use crate::cell::{Connections, HostFunction, ScriptFolders, WorldCell, calls::cost::FILE_COST};

pub static TABLE: tatu_host_files = tatu_host_files {
    size: size_of::<tatu_host_files>() as u32,
    reserved: 0,
    resolve: Some(resolve),
    open: Some(open),
};

/// The parts of the world that the functions of this table use.
struct FileContext<'a> {
    folders: &'a ScriptFolders,
    outside: &'a Connections,
    answer: AnswerContext<'a>,
}

impl<'a> From<&'a WorldCell> for FileContext<'a> {
    fn from(world: &'a WorldCell) -> Self {
        FileContext { folders: &world.run.folders, outside: &world.run.connections, answer: world.into() }
    }
}

extern "C" fn resolve<'a>(w: WorldRef<'a>, name: Lent<'_>, mode: u32, out: Option<&mut Lent<'a>>) -> tatu_status {
    with_context(w, HostFunction::read_only("files.resolve"), |c: FileContext<'_>| {
        let out = require(c.answer, "a pointer for the path", out)?;
        let mode = if mode == TATU_FILE_WRITE { TATU_FILE_WRITE } else { TATU_FILE_READ };
        c.answer.calls.cost.charge(FILE_COST);
        let name = name.text();
        let path = c.folders.resolve(Path::new(name.as_ref()), mode).map_err(|why| refuse(c.answer, why))?;
        note_opened(c.outside, &name, mode);
        let Some(path) = path.to_str() else {
            return Err(c.answer.calls.refuse(TATU_ERR_MISSING, "the path is not UTF-8"));
        };
        *out = lend(c.answer, path.as_bytes())?;
        Ok(())
    })
}

extern "C" fn open(w: WorldRef<'_>, name: Lent<'_>, mode: u32, out: Option<&mut i64>) -> tatu_status {
    let function = match mode {
        TATU_FILE_READ => HostFunction::read_only("files.open"),
        _ => HostFunction::mutating("files.open"),
    };
    with_context(w, function, |c: FileContext<'_>| {
        let out = require(c.answer, "a pointer for the file", out)?;
        if !is_valid_mode(mode) {
            let text = format!("files.open: {mode} is not a valid combination of TATU_FILE_*");
            return Err(c.answer.calls.refuse(TATU_ERR_ARGUMENT, &text));
        }
        c.answer.calls.cost.charge(FILE_COST);
        let name = name.text();
        let file = c.folders.open(Path::new(name.as_ref()), mode).map_err(|why| refuse(c.answer, why))?;
        note_opened(c.outside, &name, mode);
        *out = hand_over(file);
        Ok(())
    })
}

/// Returns whether a combination of mode bits is valid: it contains no unknown bits; the file is opened for reading,
/// writing or appending; writing and appending exclude each other, as do `TATU_FILE_UPDATE` and `TATU_FILE_NEW`, which
/// require writing; and `TATU_FILE_FOLDERS` requires writing or appending.
fn is_valid_mode(mode: u32) -> bool {
    let has = |bits| mode & bits != 0;
    let known =
        TATU_FILE_READ | TATU_FILE_WRITE | TATU_FILE_APPEND | TATU_FILE_UPDATE | TATU_FILE_NEW | TATU_FILE_FOLDERS;
    mode & !known == 0
        && has(TATU_FILE_READ | TATU_FILE_WRITE | TATU_FILE_APPEND)
        && !(has(TATU_FILE_WRITE) && has(TATU_FILE_APPEND))
        && !(has(TATU_FILE_UPDATE) && has(TATU_FILE_NEW))
        && (has(TATU_FILE_WRITE) || !has(TATU_FILE_UPDATE | TATU_FILE_NEW))
        && (has(TATU_FILE_WRITE | TATU_FILE_APPEND) || !has(TATU_FILE_FOLDERS))
}

/// Records the name of a file that is opened for reading, so that the program can warn that a replay reads the file
/// from disk: its contents are not part of the input log.
fn note_opened(outside: &Connections, name: &str, mode: u32) {
    if mode & TATU_FILE_READ != 0 {
        outside.opened_files.borrow_mut().insert(name.to_owned());
    }
}

#[cold]
fn refuse(answer: AnswerContext<'_>, why: OpenError) -> tatu_status {
    let (status, text) = match why {
        OpenError::Missing(text) => (TATU_ERR_MISSING, text),
        OpenError::Irregular(text) | OpenError::Forbidden(text) => (TATU_ERR, text),
    };
    answer.calls.refuse(status, &text)
}

#[cfg(unix)]
fn hand_over(file: File) -> i64 {
    std::os::fd::IntoRawFd::into_raw_fd(file).into()
}
#[cfg(windows)]
fn hand_over(file: File) -> i64 {
    std::os::windows::io::IntoRawHandle::into_raw_handle(file) as i64
}
