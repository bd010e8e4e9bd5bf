//! Access to files by the paths that scripts use, in the folders that the run allows.

use crate::abi::*;
use crate::safe::{Fail, Result, World, call::shared_world::service, value::plain::read_opened};

impl World<'_> {
    /// Opens a regular file by the path that a script uses; `mode` is a bitwise OR of `TATU_FILE_*`. The file must be in the
    /// folders that the run allows; links, `..` and a changed working folder cannot bypass this check.
    pub fn open_file(&self, name: &[u8], mode: u32) -> Result<std::fs::File> {
        let mut file = -1;
        self.check(service!(self.files.open)(self.raw(), name.into(), mode, Some(&mut file)))?;
        Ok(own_file(file))
    }
    /// Opens a file as [`open_file`](Self::open_file) does, and returns its content, which must not exceed `most`
    /// bytes.
    pub fn read_file(&self, name: &[u8], most: u64) -> Result<Vec<u8>> {
        let file = self.open_file(name, TATU_FILE_READ)?;
        read_opened(file, most)
            .map_err(|e| Fail::missing(format!("`{}` cannot be read: {e}", String::from_utf8_lossy(name))))
    }
    /// Opens a file as [`open_file`](Self::open_file) does, creates or truncates it, and writes `content` to it.
    pub fn write_file(&self, name: &[u8], content: &[u8]) -> Result {
        let mut file = self.open_file(name, TATU_FILE_WRITE)?;
        std::io::Write::write_all(&mut file, content)
            .map_err(|e| Fail::new(format!("`{}` cannot be written: {e}", String::from_utf8_lossy(name))))
    }
    /// Returns the resolved path of a file whose name a script passed, for host functions that require one; `mode` is
    /// `TATU_FILE_READ` or `TATU_FILE_WRITE`. To read or write the file, use [`open_file`](Self::open_file).
    pub fn file(&self, name: &[u8], mode: u32) -> Result<Vec<u8>> {
        let mut path = Lent::EMPTY;
        self.check(service!(self.files.resolve)(self.raw(), name.into(), mode, Some(&mut path)))?;
        Ok(path.bytes().to_vec())
    }
}

#[cfg(unix)]
fn own_file(file: i64) -> std::fs::File {
    // SAFETY: the host returned this open descriptor and passed its ownership to the plugin.
    unsafe { std::os::fd::FromRawFd::from_raw_fd(file as i32) }
}
#[cfg(windows)]
fn own_file(file: i64) -> std::fs::File {
    // SAFETY: the host returned this open handle and passed its ownership to the plugin.
    unsafe { std::os::windows::io::FromRawHandle::from_raw_handle(file as *mut core::ffi::c_void) }
}
