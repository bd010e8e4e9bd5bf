//! Errors of plugins.

use std::{borrow::Cow, fmt};

use crate::abi::*;

/// An error: a code and a message, and optionally a hint, a position and a traceback.
#[derive(Clone, PartialEq)]
pub struct Fail(Box<FailBody>);

#[derive(Clone, PartialEq)]
struct FailBody {
    code: tatu_status,
    text: String,
    help: Option<String>,
    file: Option<(String, u64)>,
    traceback: Option<String>,
}

/// The result of plugin functions.
pub type Result<T = (), E = Fail> = std::result::Result<T, E>;

impl Fail {
    /// Creates an error with one of the `TATU_ERR_*` codes; a code that is not negative is replaced by `TATU_ERR`.
    pub fn with_code(code: tatu_status, text: impl Into<String>) -> Self {
        let code = if code < 0 { code } else { TATU_ERR };
        Fail(Box::new(FailBody { code, text: text.into(), help: None, file: None, traceback: None }))
    }
    /// Creates an error with the general code `TATU_ERR`.
    pub fn new(text: impl Into<String>) -> Self {
        Self::with_code(TATU_ERR, text)
    }
    /// Creates an error about an argument of the wrong type, count, size or range.
    pub fn argument(text: impl Into<String>) -> Self {
        Self::with_code(TATU_ERR_ARGUMENT, text)
    }
    /// Creates an error about a missing object, property, field or file.
    pub fn missing(text: impl Into<String>) -> Self {
        Self::with_code(TATU_ERR_MISSING, text)
    }
    /// Creates an error about something that is recognized but not supported.
    pub fn unsupported(text: impl Into<String>) -> Self {
        Self::with_code(TATU_ERR_UNSUPPORTED, text)
    }
    /// Adds a hint: what to do instead.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.0.help = Some(text.into());
        self
    }
    /// Adds the position in a file; lines are counted from 1.
    pub fn at(mut self, file: impl Into<String>, line: u64) -> Self {
        self.0.file = Some((file.into(), line));
        self
    }
    /// Adds the traceback of a script.
    pub fn traceback(mut self, text: impl Into<String>) -> Self {
        self.0.traceback = Some(text.into());
        self
    }
    /// Returns the code, one of `TATU_ERR_*`.
    pub fn code(&self) -> tatu_status {
        self.0.code
    }
    /// Returns the message.
    pub fn text(&self) -> &str {
        &self.0.text
    }
    /// Returns the hint, if the error has one.
    pub fn help_text(&self) -> Option<&str> {
        self.0.help.as_deref()
    }
    /// Returns the position of the error, file and line, if it has one.
    pub fn place(&self) -> Option<(&str, u64)> {
        self.0.file.as_ref().map(|(f, l)| (f.as_str(), *l))
    }
    /// Returns the traceback of a script, innermost call first, if the error has one.
    pub fn traceback_text(&self) -> Option<&str> {
        self.0.traceback.as_deref()
    }

    /// Writes the error to the host's error object, unless `error` is null, and returns the code.
    ///
    /// # Safety
    /// `error` must be null or point to a live error object of the host.
    pub unsafe fn write(&self, error: *mut tatu_error) -> tatu_status {
        // SAFETY: the caller guarantees that `error` is null or points to an object that is alive during the call; the
        // host's functions copy the texts passed to them.
        unsafe {
            if let Some(say) = error.as_ref().and_then(|e| e.say) {
                say(error, self.0.code, text_raw(&self.0.text));
                if let Some(add) = (*error).add {
                    if let Some(help) = &self.0.help {
                        add(error, TATU_PART_HELP, text_raw(help), 0);
                    }
                    if let Some((file, line)) = &self.0.file {
                        add(error, TATU_PART_FILE, text_raw(file), *line);
                    }
                    if let Some(traceback) = &self.0.traceback {
                        add(error, TATU_PART_TRACEBACK, text_raw(traceback), 0);
                    }
                }
            }
        }
        self.0.code
    }

    /// Creates an error with this code and the texts of the host's error object.
    ///
    /// # Safety
    /// `error` must be null or point to a live error object of the host.
    pub unsafe fn read(code: tatu_status, error: *const tatu_error) -> Self {
        // SAFETY: the caller guarantees that `error` is null or points to an object that is alive during the call.
        let Some(e) = (unsafe { error.as_ref() }) else {
            return Self::with_code(code, "the call failed without an error message");
        };
        let some = |s: tatu_str| (s.len > 0).then(|| lossy(s).into_owned());
        Fail(Box::new(FailBody {
            code,
            text: some(e.text).unwrap_or_else(|| "the call failed without an error message".into()),
            help: some(e.help),
            file: some(e.file).map(|f| (f, e.line)),
            traceback: some(e.traceback),
        }))
    }
}

impl fmt::Display for Fail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.text)?;
        if let Some(help) = &self.0.help {
            write!(f, " ({help})")?;
        }
        Ok(())
    }
}

impl fmt::Debug for Fail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Fail({}: {self})", self.0.code)
    }
}

impl std::error::Error for Fail {}

/// Converts a borrowed text to the ABI form.
pub(crate) fn text_raw(s: &str) -> tatu_str {
    Lent::from(s).raw()
}

/// Converts borrowed bytes to the ABI form.
pub(crate) fn bytes_raw(s: &[u8]) -> tatu_str {
    Lent::from(s).raw()
}

/// Returns the bytes of an ABI text.
///
/// # Safety
/// `s` must point to `len` bytes that live for `'a`, or be empty.
pub unsafe fn bytes_of<'a>(s: tatu_str) -> &'a [u8] {
    // SAFETY: the caller guarantees that `s` is empty or points to `len` bytes that live for `'a`.
    unsafe { Lent::new(s) }.bytes()
}

fn lossy<'a>(s: tatu_str) -> Cow<'a, str> {
    // SAFETY: `s` is a text of an error object and lives as long as the object; the result is copied at once.
    String::from_utf8_lossy(unsafe { bytes_of(s) })
}
