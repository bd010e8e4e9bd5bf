//! The host's error objects, which plugins fill through two functions that copy the texts.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;

use crate::{
    border::{bytes, raw},
    texts,
    watchdog::PluginCall,
};

/// An error object and the texts that it points to. Both are boxed, so pointers to them remain valid when the slot is
/// moved.
pub struct ErrorSlot {
    raw: Box<tatu_error>,
    texts: Box<ErrorTexts>,
}

#[derive(Default)]
struct ErrorTexts {
    text: Vec<u8>,
    help: Vec<u8>,
    file: Vec<u8>,
    traceback: Vec<u8>,
}

const EMPTY_STR: tatu_str = tatu_str { ptr: std::ptr::null(), len: 0 };

impl Default for ErrorSlot {
    fn default() -> Self {
        Self::new()
    }
}

impl ErrorSlot {
    /// Creates an empty error object.
    pub fn new() -> Self {
        let mut texts = Box::<ErrorTexts>::default();
        let raw = Box::new(tatu_error {
            size: size_of::<tatu_error>() as u32,
            code: TATU_OK,
            ctx: (&raw mut *texts).cast::<c_void>(),
            say: Some(say),
            add: Some(add),
            text: EMPTY_STR,
            help: EMPTY_STR,
            file: EMPTY_STR,
            traceback: EMPTY_STR,
            line: 0,
        });
        ErrorSlot { raw, texts }
    }
    /// Clears the object and returns a pointer to it.
    pub fn reset(&mut self) -> *mut tatu_error {
        self.raw.ctx = (&raw mut *self.texts).cast();
        self.raw.code = TATU_OK;
        (self.raw.text, self.raw.help, self.raw.file, self.raw.traceback) =
            (EMPTY_STR, EMPTY_STR, EMPTY_STR, EMPTY_STR);
        self.raw.line = 0;
        self.raw()
    }
    /// Returns a pointer to the object.
    pub fn raw(&mut self) -> *mut tatu_error {
        &raw mut *self.raw
    }
    /// Stores an error in the object.
    pub fn set(&mut self, status: tatu_status, text: &str) {
        let error = self.reset();
        // SAFETY: `error` points to this object, which is alive during the call; `say` copies the text.
        unsafe { say(error, status, raw(text.as_bytes())) };
    }
    /// Returns a copy of the object's contents.
    pub fn contents(&self) -> ErrorContents {
        // SAFETY: `self.raw` and the texts that it points to, in `self.texts`, live as long as `self`.
        unsafe { ErrorContents::of(&self.raw) }
    }
    /// Like [`check_status`], for a function to which this object was passed.
    pub fn check_status(&mut self, status: tatu_status, may_wait: bool) -> tatu_status {
        // SAFETY: `self.raw()` points to this object, which is alive during the call.
        unsafe { check_status(status, may_wait, self.raw()) }
    }
    /// Like [`name_plugin`], for this object.
    pub fn name_plugin(&mut self, status: tatu_status, plugin: &str, call: PluginCall) {
        // SAFETY: `self.raw()` points to this object, which is alive during the call.
        unsafe { name_plugin(status, self.raw(), plugin, call) };
    }
    /// Returns whether the object contains an error.
    pub fn has_error(&self) -> bool {
        self.raw.code != TATU_OK
    }
    /// Returns the message, with its hint.
    pub fn text(&self) -> String {
        let said = self.contents();
        let mut out = said.text.unwrap_or_default();
        if let Some(help) = said.help {
            out += &format!(" ({help})");
        }
        if out.is_empty() { "no reason was given".into() } else { out }
    }
}

/// The contents of an error object, copied. Empty parts are `None`.
pub struct ErrorContents {
    /// The message.
    pub text: Option<String>,
    /// The hint, which suggests what to do.
    pub help: Option<String>,
    /// The file in which the error occurred.
    pub file: Option<String>,
    /// The line in that file, from 1; 0 if there is none.
    pub line: u64,
    /// The traceback of a script.
    pub traceback: Option<String>,
}

impl ErrorContents {
    /// Copies the contents of an error object.
    ///
    /// # Safety
    /// `error` must be an error object of the host, whose texts are alive.
    pub unsafe fn of(error: &tatu_error) -> Self {
        // SAFETY: the caller guarantees that the texts that `error` points to are alive during this call; they are
        // copied.
        let part = |s| Some(unsafe { crate::border::text(s) }.into_owned()).filter(|s| !s.is_empty());
        ErrorContents {
            text: part(error.text),
            help: part(error.help),
            file: part(error.file),
            line: error.line,
            traceback: part(error.traceback),
        }
    }
}

/// Checks the status returned by a plugin's function. Returns `TATU_OK`, the errors that this host knows and, if
/// `may_wait` is set, `TATU_WAIT` unchanged. For any other status, returns `TATU_ERR`; the error object then contains
/// the plugin's message or, if it gave none, one about the status.
///
/// # Safety
/// `error` must point to a live error object of the host.
pub unsafe fn check_status(status: tatu_status, may_wait: bool, error: *mut tatu_error) -> tatu_status {
    if status == TATU_OK || status == TATU_WAIT && may_wait || (TATU_ERR_MEMORY..0).contains(&status) {
        return status;
    }
    // SAFETY: the caller guarantees that `error` points to a live object during this call.
    unsafe {
        let text = match status {
            // The status does not matter if there is a message.
            ..0 if (*error).code != TATU_OK => return TATU_ERR,
            ..0 => format!("failed with status {status}, which is unknown to this host: the plugin may be newer"),
            _ => format!("broke the contract: it returned the status {status}, which is not defined for this call"),
        };
        say(error, TATU_ERR, raw(text.as_bytes()));
    }
    TATU_ERR
}

/// Adds the plugin and its function to an error, if the error is the plugin's own. An error of a script that the plugin
/// ran has a position in the script, and is left unchanged.
///
/// # Safety
/// `error` must point to a live error object of the host.
pub unsafe fn name_plugin(status: tatu_status, error: *mut tatu_error, plugin: &str, call: PluginCall) {
    // SAFETY: the caller guarantees that `error` and its texts are live.
    unsafe {
        let said = crate::border::text((*error).text).into_owned();
        let placed = (*error).line > 0 || (*error).traceback.len > 0;
        let own = ["panicked", "broke the contract"].iter().any(|own| said.starts_with(own));
        if own || status == TATU_ERR && !placed {
            let how = if own { "" } else { "failed: " };
            let said = if said.is_empty() { "no reason was given".into() } else { said };
            let help = crate::border::text((*error).help).into_owned();
            say(error, status, raw(format!("plugin `{plugin}` {how}{said} [{}]", call.text()).as_bytes()));
            if !help.is_empty() {
                add(error, TATU_PART_HELP, raw(help.as_bytes()), 0);
            }
        }
    }
}

/// Copies the contents of one error object into another.
///
/// # Safety
/// Both must point to live error objects of the host.
pub unsafe fn copy(from: *const tatu_error, to: *mut tatu_error) {
    // SAFETY: the caller guarantees that both are live; `say` and `add` copy the texts.
    unsafe {
        say(to, (*from).code, (*from).text);
        for (part, s) in
            [(TATU_PART_HELP, (*from).help), (TATU_PART_FILE, (*from).file), (TATU_PART_TRACEBACK, (*from).traceback)]
        {
            if s.len > 0 {
                add(to, part, s, (*from).line);
            }
        }
    }
}

unsafe extern "C" fn say(error: *mut tatu_error, code: tatu_status, text: tatu_str) {
    // SAFETY: the header requires `error` to be the live object that was passed to the plugin; its `ctx` points to its
    // `ErrorTexts`. `text` must be valid during the call.
    unsafe {
        let Some(e) = error.as_mut().filter(|e| !e.ctx.is_null()) else { return };
        let texts = &mut *e.ctx.cast::<ErrorTexts>();
        e.code = if code < 0 { code } else { TATU_ERR };
        // The text can be one of the object's own, so it is copied before the object is overwritten.
        let new = texts::clean_error(bytes(text));
        texts.text = new;
        e.text = raw(&texts.text);
        (e.help, e.file, e.traceback, e.line) = (EMPTY_STR, EMPTY_STR, EMPTY_STR, 0);
    }
}

unsafe extern "C" fn add(error: *mut tatu_error, part: u32, text: tatu_str, line: u64) {
    // SAFETY: the header requires `error` to be the live object that was passed to the plugin; its `ctx` points to its
    // `ErrorTexts`.
    unsafe {
        let Some(e) = error.as_mut().filter(|e| !e.ctx.is_null()) else { return };
        let texts = &mut *e.ctx.cast::<ErrorTexts>();
        let new = texts::clean_error(bytes(text));
        match part {
            TATU_PART_HELP => {
                texts.help = new;
                e.help = raw(&texts.help);
            }
            TATU_PART_FILE => {
                texts.file = new;
                e.file = raw(&texts.file);
                e.line = line;
            }
            TATU_PART_TRACEBACK => {
                texts.traceback = new;
                e.traceback = raw(&texts.traceback);
            }
            _ => {}
        }
    }
}
