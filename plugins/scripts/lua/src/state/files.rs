//! Open files of a script. They are stored outside the Lua state, so they are closed however the state is destroyed.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom, Write},
};

use tatu_plugin_api::abi::*;

const BLOCK_BYTES: usize = 8 << 10;
/// Maximum number of bytes that a read returns.
const MAX_READ_BYTES: usize = crate::alloc::SLOT_BYTES;

/// Open files, by the number that Lua userdata stores.
#[derive(Default)]
pub(crate) struct OpenFiles(Vec<Option<OpenFile>>);

impl OpenFiles {
    /// Adds a file and returns its number.
    pub(crate) fn add(&mut self, file: OpenFile) -> usize {
        match self.0.iter().position(Option::is_none) {
            Some(free) => {
                self.0[free] = Some(file);
                free
            }
            None => {
                self.0.push(Some(file));
                self.0.len() - 1
            }
        }
    }
    /// Returns the open file with this number, if any.
    pub(crate) fn get(&mut self, number: usize) -> Option<&mut OpenFile> {
        self.0.get_mut(number)?.as_mut()
    }
    /// Flushes and closes a file.
    pub(crate) fn close(&mut self, number: usize) -> io::Result<()> {
        match self.0.get_mut(number).and_then(Option::take) {
            Some(mut file) => file.flush(),
            None => Ok(()),
        }
    }
}

/// An open file, with its buffers.
pub(crate) struct OpenFile {
    file: File,
    /// Written bytes that have not been flushed yet.
    write_buffer: Vec<u8>,
    /// Read buffer, and the number of its bytes that have been consumed.
    read_buffer: Vec<u8>,
    at: usize,
    /// The result of the last read.
    pub out: Vec<u8>,
}

/// Converts Lua's mode string to `TATU_FILE_*` flags.
pub(crate) fn mode(mode: &[u8]) -> Option<u32> {
    let (kind, rest) = mode.split_first()?;
    let plus = rest.contains(&b'+');
    if rest.iter().any(|b| !b"+b".contains(b)) {
        return None;
    }
    let reads = if plus { TATU_FILE_READ } else { 0 };
    Some(match kind {
        b'r' if plus => TATU_FILE_READ | TATU_FILE_WRITE | TATU_FILE_UPDATE,
        b'r' => TATU_FILE_READ,
        b'w' => TATU_FILE_WRITE | reads,
        b'a' => TATU_FILE_APPEND | reads,
        _ => return None,
    })
}

impl OpenFile {
    pub(crate) fn new(file: File) -> Self {
        OpenFile { file, write_buffer: Vec::new(), read_buffer: Vec::new(), at: 0, out: Vec::new() }
    }
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.at < self.read_buffer.len() {
            let back = self.read_buffer.len() - self.at;
            self.file.seek(SeekFrom::Current(-(back as i64)))?;
        }
        self.read_buffer.clear();
        self.at = 0;
        self.write_buffer.extend_from_slice(bytes);
        if self.write_buffer.len() >= BLOCK_BYTES {
            self.flush()?;
        }
        Ok(())
    }
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        let done = self.file.write_all(&self.write_buffer);
        self.write_buffer.clear();
        done
    }
    /// Seeks; returns the new position relative to the start.
    pub(crate) fn seek(&mut self, whence: u8, offset: i64) -> io::Result<u64> {
        self.flush()?;
        let back = (self.read_buffer.len() - self.at) as i64;
        self.read_buffer.clear();
        self.at = 0;
        self.file.seek(match whence {
            b's' => SeekFrom::Start(u64::try_from(offset).map_err(|_| io::Error::from(io::ErrorKind::InvalidInput))?),
            b'e' => SeekFrom::End(offset),
            _ => SeekFrom::Current(offset - back),
        })
    }
    /// Fills the read buffer; returns false at the end of the file.
    fn fill(&mut self) -> io::Result<bool> {
        if self.out.len() > MAX_READ_BYTES {
            self.out = Vec::new();
            return Err(io::Error::new(io::ErrorKind::OutOfMemory, "the result exceeds the script's memory limit"));
        }
        if self.at < self.read_buffer.len() {
            return Ok(true);
        }
        if !self.write_buffer.is_empty() {
            self.flush()?;
        }
        self.read_buffer.resize(BLOCK_BYTES, 0);
        self.at = 0;
        let n = self.file.read(&mut self.read_buffer);
        self.read_buffer.truncate(*n.as_ref().unwrap_or(&0));
        Ok(n? > 0)
    }
    /// Reads a line into `out`; returns false at the end of the file.
    pub(crate) fn read_line(&mut self, keep_end: bool) -> io::Result<bool> {
        self.out.clear();
        while self.fill()? {
            let rest = &self.read_buffer[self.at..];
            let end = rest.iter().position(|b| *b == b'\n');
            self.out.extend_from_slice(&rest[..end.unwrap_or(rest.len())]);
            self.at += end.map_or(rest.len(), |e| e + 1);
            if end.is_some() {
                if keep_end {
                    self.out.push(b'\n');
                }
                return Ok(true);
            }
        }
        Ok(!self.out.is_empty())
    }
    /// Reads at most `n` bytes into `out`; returns false at the end of the file.
    pub(crate) fn read_bytes(&mut self, n: usize) -> io::Result<bool> {
        self.out.clear();
        let mut more = self.fill()?;
        while more && self.out.len() < n {
            let rest = &self.read_buffer[self.at..];
            let part = rest.len().min(n - self.out.len());
            self.out.extend_from_slice(&rest[..part]);
            self.at += part;
            more = self.out.len() < n && self.fill()?;
        }
        Ok(!self.out.is_empty() || (n == 0 && more))
    }
    /// Reads the characters of a number into `out`.
    pub(crate) fn read_number(&mut self) -> io::Result<bool> {
        self.out.clear();
        while self.fill()? {
            let byte = self.read_buffer[self.at];
            if self.out.is_empty() && byte.is_ascii_whitespace() {
                self.at += 1;
                continue;
            }
            if !(byte.is_ascii_alphanumeric() || b"+-.".contains(&byte)) || self.out.len() >= 200 {
                break;
            }
            self.out.push(byte);
            self.at += 1;
        }
        Ok(!self.out.is_empty())
    }
}

impl Drop for OpenFile {
    fn drop(&mut self) {
        let _ = self.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mode_strings_are_converted_to_flags() {
        let update = TATU_FILE_READ | TATU_FILE_WRITE | TATU_FILE_UPDATE;
        for (text, bits) in [
            ("r", TATU_FILE_READ),
            ("rb", TATU_FILE_READ),
            ("r+", update),
            ("a", TATU_FILE_APPEND),
            ("w+b", TATU_FILE_WRITE | TATU_FILE_READ),
        ] {
            assert_eq!(mode(text.as_bytes()), Some(bits), "{text}");
        }
        assert!(mode(b"x").is_none() && mode(b"rw").is_none() && mode(b"").is_none());
    }
}
