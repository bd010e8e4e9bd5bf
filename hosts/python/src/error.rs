//! Errors of the simulator as exceptions.

use pyo3::{create_exception, exceptions::PyException, prelude::*};
use tatu_core::errors::{Error as Wrong, Fault, FaultKind, Refusal};
use tatu_plugin_api::safe::Fail;

create_exception!(
    tatu_sim,
    Error,
    PyException,
    "An error of the simulator. `code` is explained in the reference of errors; `text` describes the problem, `help` \
     how to correct it, `file` and `line` its location. Each of them can be None."
);

fn new_exception(message: String, code: &str, text: &str, help: Option<&str>, place: Option<(String, usize)>) -> PyErr {
    Python::attach(|py| {
        let e = Error::new_err(message);
        let value = e.value(py);
        let (file, line) = place.unzip();
        let set = value
            .setattr("code", code)
            .and_then(|()| value.setattr("text", text))
            .and_then(|()| value.setattr("help", help))
            .and_then(|()| value.setattr("file", file))
            .and_then(|()| value.setattr("line", line.filter(|l| *l > 0)));
        set.err().unwrap_or(e)
    })
}

/// Converts an error that prevented a start to an exception.
pub fn to_exception(e: &Wrong) -> PyErr {
    let place = e.place.as_ref().map(|p| (p.file.display().to_string(), p.line));
    new_exception(e.to_string(), e.code, &e.text, e.help.as_deref(), place)
}

/// Converts a refusal to read or set a property to an error.
pub fn refusal_error(r: &Refusal) -> Wrong {
    Wrong::new(FaultKind::of(r.0).code(), r.1.clone())
}

/// Converts a fault of a command to an error.
pub fn fault_error(f: &Fault) -> Wrong {
    let mut text = f.message.clone();
    if let Some(traceback) = &f.traceback {
        text = format!("{text}\n{traceback}");
    }
    Wrong { help: f.help.clone(), ..Wrong::new(f.code, text) }
}

/// Converts the error of a command that a script called to an exception.
pub fn from_fail(fail: &Fail) -> PyErr {
    let code = FaultKind::of(fail.code()).code();
    let message = match fail.help_text() {
        Some(help) => format!("{} ({help})", fail.text()),
        None => fail.text().to_owned(),
    };
    new_exception(message, code, fail.text(), fail.help_text(), None)
}
