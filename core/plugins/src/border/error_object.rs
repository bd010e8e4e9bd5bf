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
        self.object().clear();
        self.raw()
    }
    /// Returns a pointer to the object, for plugins. It is valid until another method that changes the object is called.
    pub fn raw(&mut self) -> *mut tatu_error {
        self.raw.ctx = (&raw mut *self.texts).cast();
        &raw mut *self.raw
    }
    /// Returns access to the object.
    pub fn object(&mut self) -> ErrorObject<'_> {
        ErrorObject { raw: &mut self.raw, texts: &mut self.texts }
    }
    /// Stores an error in the object.
    pub fn set(&mut self, status: tatu_status, text: &str) {
        self.object().set(status, text);
    }
    /// Returns a copy of the object's contents.
    pub fn contents(&self) -> ErrorContents {
        ErrorContents::new(&self.raw, &self.texts)
    }
    /// Like [`ErrorObject::check_status`].
    pub fn check_status(&mut self, status: tatu_status, may_wait: bool) -> tatu_status {
        self.object().check_status(status, may_wait)
    }
    /// Like [`ErrorObject::name_plugin`].
    pub fn name_plugin(&mut self, status: tatu_status, plugin: &str, call: PluginCall) {
        self.object().name_plugin(status, plugin, call);
    }
    /// Returns the status of the error, or `TATU_OK` if there is none.
    pub fn code(&self) -> tatu_status {
        self.raw.code
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
#[derive(Default)]
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
    fn new(raw: &tatu_error, texts: &ErrorTexts) -> Self {
        let part = |shown: tatu_str, text: &[u8]| (shown.len > 0).then(|| String::from_utf8_lossy(text).into_owned());
        ErrorContents {
            text: part(raw.text, &texts.text),
            help: part(raw.help, &texts.help),
            file: part(raw.file, &texts.file),
            line: raw.line,
            traceback: part(raw.traceback, &texts.traceback),
        }
    }
}

/// Access to an error object of the host.
pub struct ErrorObject<'a> {
    raw: &'a mut tatu_error,
    /// The texts that `raw` points to, unless they are empty.
    texts: &'a mut ErrorTexts,
}

impl ErrorObject<'_> {
    /// Returns access to the object at a pointer, or `None` for null.
    ///
    /// # Safety
    /// `error` must be null, or point to an object of an [`ErrorSlot`] that lives as long as the result and is not
    /// accessed otherwise in the meantime.
    pub unsafe fn at(error: *mut tatu_error) -> Option<Self> {
        // SAFETY: the caller guarantees a live object, whose `ctx` points to the texts of its slot.
        unsafe {
            let raw = error.as_mut()?;
            let texts = raw.ctx.cast::<ErrorTexts>().as_mut()?;
            Some(ErrorObject { raw, texts })
        }
    }

    /// Returns the status of the error, or `TATU_OK` if there is none.
    pub fn code(&self) -> tatu_status {
        self.raw.code
    }
    /// Returns a copy of the object's contents.
    pub fn contents(&self) -> ErrorContents {
        ErrorContents::new(self.raw, self.texts)
    }

    fn clear(&mut self) {
        self.raw.code = TATU_OK;
        (self.raw.text, self.raw.help, self.raw.file, self.raw.traceback) =
            (EMPTY_STR, EMPTY_STR, EMPTY_STR, EMPTY_STR);
        self.raw.line = 0;
    }
    /// Stores an error, whose text has been cleaned.
    fn say(&mut self, code: tatu_status, text: Vec<u8>) {
        self.clear();
        self.raw.code = if code < 0 { code } else { TATU_ERR };
        self.texts.text = text;
        self.raw.text = raw(&self.texts.text);
    }
    /// Adds a part, whose text has been cleaned, to the error.
    fn add(&mut self, part: u32, text: Vec<u8>, line: u64) {
        let (place, shown) = match part {
            TATU_PART_HELP => (&mut self.texts.help, &mut self.raw.help),
            TATU_PART_FILE => {
                self.raw.line = line;
                (&mut self.texts.file, &mut self.raw.file)
            }
            TATU_PART_TRACEBACK => (&mut self.texts.traceback, &mut self.raw.traceback),
            _ => return,
        };
        *place = text;
        *shown = raw(place);
    }

    /// Stores an error, and returns its status.
    pub fn set(&mut self, status: tatu_status, text: &str) -> tatu_status {
        self.say(status, texts::clean_error(text.as_bytes()));
        status
    }
    /// Adds a hint to the error.
    pub fn add_help(&mut self, help: &str) {
        self.add(TATU_PART_HELP, texts::clean_error(help.as_bytes()), 0);
    }
    /// Copies the contents of another object.
    pub fn copy_from(&mut self, from: &ErrorObject<'_>) {
        self.say(from.raw.code, if from.raw.text.len > 0 { from.texts.text.clone() } else { Vec::new() });
        for (part, shown, text) in [
            (TATU_PART_HELP, from.raw.help, &from.texts.help),
            (TATU_PART_FILE, from.raw.file, &from.texts.file),
            (TATU_PART_TRACEBACK, from.raw.traceback, &from.texts.traceback),
        ] {
            if shown.len > 0 {
                self.add(part, text.clone(), from.raw.line);
            }
        }
    }

    /// Checks the status returned by a plugin's function. Returns `TATU_OK`, the errors that are defined for this host
    /// and, if `may_wait` is set, `TATU_WAIT` unchanged. For any other status, returns `TATU_ERR`; the object then
    /// contains the plugin's message or, if it gave none, one about the status.
    pub fn check_status(&mut self, status: tatu_status, may_wait: bool) -> tatu_status {
        if status == TATU_OK || status == TATU_WAIT && may_wait || (TATU_ERR_MEMORY..0).contains(&status) {
            return status;
        }
        let text = match status {
            // The status does not matter if there is a message.
            ..0 if self.raw.code != TATU_OK => return TATU_ERR,
            ..0 => format!("failed with status {status}, which is unknown to this host: the plugin may be newer"),
            _ => format!("broke the contract: it returned the status {status}, which is not defined for this call"),
        };
        self.set(TATU_ERR, &text)
    }

    /// Adds the plugin and its function to the error, if it is the plugin's own. An error of a script that the plugin
    /// ran has a position in the script, and is left unchanged.
    pub fn name_plugin(&mut self, status: tatu_status, plugin: &str, call: PluginCall) {
        let ErrorContents { text, help, .. } = self.contents();
        let said = text.unwrap_or_default();
        let placed = self.raw.line > 0 || self.raw.traceback.len > 0;
        let own = ["panicked", "broke the contract"].iter().any(|own| said.starts_with(own));
        if own || status == TATU_ERR && !placed {
            let how = if own { "" } else { "failed: " };
            let said = if said.is_empty() { "no reason was given".into() } else { said };
            self.set(status, &format!("plugin `{plugin}` {how}{said} [{}]", call.text()));
            if let Some(help) = help {
                self.add_help(&help);
            }
        }
    }
}

unsafe extern "C" fn say(error: *mut tatu_error, code: tatu_status, text: tatu_str) {
    // SAFETY: the header requires `error` to be the live object that was passed to the plugin, and `text` to be valid
    // during the call. The text can be one of the object's own, so it is copied before the object is accessed.
    let (text, error) = unsafe { (texts::clean_error(bytes(text)), ErrorObject::at(error)) };
    if let Some(mut error) = error {
        error.say(code, text);
    }
}

unsafe extern "C" fn add(error: *mut tatu_error, part: u32, text: tatu_str, line: u64) {
    // SAFETY: as for `say`.
    let (text, error) = unsafe { (texts::clean_error(bytes(text)), ErrorObject::at(error)) };
    if let Some(mut error) = error {
        error.add(part, text, line);
    }
}
