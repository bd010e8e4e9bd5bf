//! Reads numbers and strings at a position in the unpacked data, and never reads beyond its end.

use std::fmt;

/// The reason that a file cannot be read, and the position of the error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadError {
    /// Offset in the unpacked data.
    pub at: usize,
    /// Tags of the sections that contain the position, innermost first.
    pub within: Vec<String>,
    /// Description of the error, as shown to the user.
    pub what: String,
}

/// The result of reading a part of a file.
pub type ReadResult<T = ()> = Result<T, ReadError>;

impl ReadError {
    /// Creates an error at an offset.
    pub fn new(at: usize, what: impl Into<String>) -> Self {
        ReadError { at, within: Vec::new(), what: what.into() }
    }

    /// Adds the section in which the error was found.
    pub fn within(mut self, tag: &str) -> Self {
        self.within.push(tag.to_owned());
        self
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path: Vec<&str> = self.within.iter().rev().map(String::as_str).collect();
        match path.is_empty() {
            true => write!(f, "byte {} of the unpacked data: {}", self.at, self.what),
            false => write!(f, "byte {} of the unpacked data, in section {}: {}", self.at, path.join("/"), self.what),
        }
    }
}

/// A range of bytes in the unpacked data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ByteSpan {
    /// Offset of the first byte.
    pub at: usize,
    /// Number of bytes.
    pub len: usize,
}

impl ByteSpan {
    /// Returns the bytes, or an empty slice if the span is outside `data`.
    pub fn of<'a>(&self, data: &'a [u8]) -> &'a [u8] {
        data.get(self.at..self.at.saturating_add(self.len)).unwrap_or_default()
    }
}

/// Maximum nesting depth of sections; real files have a depth of 9.
pub const MAX_DEPTH: usize = 64;

/// A position in the data, and the end of the section that is being read.
#[derive(Clone)]
pub struct Cursor<'a> {
    data: &'a [u8],
    at: usize,
    end: usize,
    /// Whether real numbers have 8 bytes instead of 4, which depends on the tag of the element.
    pub has_doubles: bool,
    depth: usize,
}

impl<'a> Cursor<'a> {
    /// Creates a cursor at the beginning of the data.
    pub fn new(data: &'a [u8]) -> Self {
        Cursor { data, at: 0, end: data.len(), has_doubles: false, depth: 0 }
    }
    /// Returns the offset of the next byte.
    pub fn at(&self) -> usize {
        self.at
    }
    /// Returns the number of remaining bytes.
    pub fn remaining(&self) -> usize {
        self.end - self.at
    }
    /// Creates an error at this position.
    pub fn error(&self, what: impl Into<String>) -> ReadError {
        ReadError::new(self.at, what)
    }
    /// Returns the next `n` bytes.
    pub fn take(&mut self, n: usize) -> ReadResult<&'a [u8]> {
        if n > self.remaining() {
            return Err(self.error(format!("expected {n} more bytes, found {}", self.remaining())));
        }
        let bytes = &self.data[self.at..self.at + n];
        self.at += n;
        Ok(bytes)
    }
    /// Returns a cursor over the next `n` bytes, one level deeper.
    pub fn part(&mut self, n: usize, wide: bool) -> ReadResult<Cursor<'a>> {
        if self.depth >= MAX_DEPTH {
            return Err(self.error(format!("sections are nested more than {MAX_DEPTH} levels deep")));
        }
        let at = self.at;
        self.take(n)?;
        Ok(Cursor { data: self.data, at, end: at + n, has_doubles: wide, depth: self.depth + 1 })
    }
    /// Returns the span of all remaining bytes, and advances to the end.
    pub fn take_rest(&mut self) -> ByteSpan {
        let span = ByteSpan { at: self.at, len: self.remaining() };
        self.at = self.end;
        span
    }
    fn array<const N: usize>(&mut self) -> ReadResult<[u8; N]> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?);
        Ok(out)
    }
    /// Reads a tag: three characters.
    pub fn tag(&mut self) -> ReadResult<[u8; 3]> {
        self.array()
    }
    /// Reads a byte.
    pub fn u8(&mut self) -> ReadResult<u8> {
        Ok(self.array::<1>()?[0])
    }
    /// Reads a little-endian 2-byte unsigned integer.
    pub fn u16(&mut self) -> ReadResult<u16> {
        Ok(u16::from_le_bytes(self.array()?))
    }
    /// Reads a little-endian 4-byte signed integer.
    pub fn i32(&mut self) -> ReadResult<i32> {
        Ok(i32::from_le_bytes(self.array()?))
    }
    /// Reads a little-endian 8-byte unsigned integer.
    pub fn u64(&mut self) -> ReadResult<u64> {
        Ok(u64::from_le_bytes(self.array()?))
    }
    /// Reads a count of bytes or items: a 4-byte integer that is not negative.
    pub fn count(&mut self) -> ReadResult<usize> {
        let at = self.at;
        let n = self.i32()?;
        usize::try_from(n).map_err(|_| ReadError::new(at, format!("expected a length, found {n}")))
    }
    /// Reads a real number of 4 or 8 bytes.
    pub fn real(&mut self) -> ReadResult<f64> {
        if self.has_doubles { Ok(f64::from_le_bytes(self.array()?)) } else { self.single() }
    }
    /// Reads a real number of 4 bytes.
    pub fn single(&mut self) -> ReadResult<f64> {
        Ok(f64::from(f32::from_le_bytes(self.array()?)))
    }
    /// Reads `N` consecutive real numbers, of 4 or 8 bytes each.
    pub fn reals<const N: usize>(&mut self) -> ReadResult<[f64; N]> {
        let mut out = [0.0; N];
        for x in &mut out {
            *x = self.real()?;
        }
        Ok(out)
    }
    /// Reads `n` real numbers; checks first that they are present.
    pub fn list(&mut self, n: usize) -> ReadResult<Vec<f64>> {
        let bytes = n.saturating_mul(if self.has_doubles { 8 } else { 4 });
        if bytes > self.remaining() {
            return Err(self.error(format!("expected {n} numbers, found {} bytes", self.remaining())));
        }
        (0..n).map(|_| self.real()).collect()
    }
    /// Reads a string preceded by its length in bytes. The encoding is UTF-8 or, if the bytes are not valid UTF-8,
    /// Latin-1.
    pub fn text(&mut self) -> ReadResult<String> {
        let n = self.count()?;
        Ok(decode(self.take(n)?))
    }
    /// Reads bytes preceded by their count.
    pub fn blob(&mut self) -> ReadResult<Vec<u8>> {
        let n = self.count()?;
        Ok(self.take(n)?.to_vec())
    }
}

/// Decodes text as UTF-8, or as Latin-1 if it is not valid UTF-8.
pub fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_beyond_the_end_are_errors() {
        let mut c = Cursor::new(&[5, 0, 0, 0, b'a']);
        assert_eq!(c.text().unwrap_err().what, "expected 5 more bytes, found 1");
        let mut c = Cursor::new(&[0xFF; 8]);
        assert_eq!(c.count().unwrap_err(), ReadError::new(0, "expected a length, found -1"));
        assert_eq!(Cursor::new(&[0; 3]).i32().unwrap_err().at, 0);
        let mut c = Cursor::new(&[1, 0, 0, 0]);
        assert!(c.list(usize::MAX).is_err());
    }

    #[test]
    fn invalid_utf8_is_decoded_as_latin_1() {
        assert_eq!(decode("é".as_bytes()), "é");
        assert_eq!(decode(&[0xE9]), "é");
    }
}
