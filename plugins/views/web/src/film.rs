//! The service `film`, which records a run and writes it as a page that plays without a server.

use std::{
    cell::{RefCell, RefMut},
    fs::File,
    io::Write,
    path::PathBuf,
};

use tatu_plugin_api::{
    abi::*,
    safe::{Answer, Fail, Host, Param, Params, Result, Service, Session, Turn, ValueRef},
};

use crate::{
    film_page,
    plugin::{Props, WebPage},
    recorder::{FilmRecorder, RECORDED_EVENTS},
};

/// Maximum compressed size of a recording, bytes.
const MAX_RECORDING_BYTES: usize = 500 << 20;

/// The service `film`, which records a run and writes the page of the film when the run ends.
pub struct FilmService {
    p: Props,
    session: Session,
    /// Path of the page to be written.
    file: PathBuf,
    recorder: RefCell<FilmRecorder>,
}

impl Service for FilmService {
    type Plugin = WebPage;
    const ID: &'static str = "film";
    const TEXT: &'static str = "Records a run and writes it as a page that plays the recording without the program.";
    const EVENTS: &'static [&'static str] = RECORDED_EVENTS;

    fn params() -> Vec<Param> {
        vec![Param::string("page").text("path of the page, which is written when the run ends")]
    }

    fn start(plugin: &WebPage, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let file = PathBuf::from(params.string("page")?);
        film_page::require_libraries()?;
        // Creates the file now, so that an invalid path is reported before the run and not after it.
        let made = File::options().append(true).create(true).open(&file);
        made.map_err(|e| Fail::new(format!("the file `{}` could not be created: {e}", file.display())))?;
        Ok(FilmService { p: plugin.p, session, file, recorder: RefCell::new(FilmRecorder::new(MAX_RECORDING_BYTES)) })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer> {
        if turn.state() != TATU_STOPPED {
            self.recorder()?.record_step(turn, &self.p, step)?;
        }
        Ok(Answer::Go)
    }

    fn event(&self, turn: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut recorder) = self.recorder() else { return };
        recorder.event(turn, &self.p, name, payload);
        if name == "stopped" {
            self.write(&mut recorder);
        }
    }
}

/// Writes the film if the session ends before the world is stopped.
impl Drop for FilmService {
    fn drop(&mut self) {
        if let Ok(mut recorder) = self.recorder.try_borrow_mut() {
            self.write(&mut recorder);
        }
    }
}

impl FilmService {
    fn recorder(&self) -> Result<RefMut<'_, FilmRecorder>> {
        self.recorder.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the film is in use"))
    }

    /// Writes the page of the finished recording, if there is one, and logs errors.
    fn write(&self, recorder: &mut FilmRecorder) {
        let Some(recording) = recorder.finish() else { return };
        let file = self.file.display();
        let done =
            recording.and_then(|bytes| File::create(&self.file)?.write_all(film_page::build_page(&bytes).as_bytes()));
        match (done, recorder.full_at()) {
            (Err(e), _) => self.session.log(TATU_LOG_ERROR, &format!("the film `{file}` could not be written: {e}")),
            (Ok(()), Some(time)) => {
                let text = format!(
                    "the film `{file}` ends at {time:.1} s, because a recording is limited to {MAX_RECORDING_BYTES} bytes"
                );
                self.session.log(TATU_LOG_WARNING, &text);
            }
            (Ok(()), None) => {}
        }
    }
}
