//! A place in the unpacked file: reads numbers and texts, and never beyond what is there.

use std::fmt;

/// Why a file cannot be read: what, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Broken {
    /// Byte of the unpacked data, from 0.
    pub at: usize,
    /// Tags of the sections around it, innermost first.
    pub within: Vec<String>,
    /// What is wrong.
    pub what: String,
}

/// The result of reading.
pub type Read<T = ()> = Result<T, Broken>;

impl Broken {
    /// Something wrong at a byte.
    pub fn new(at: usize, what: impl Into<String>) -> Self {
        Broken { at, within: Vec::new(), what: what.into() }
    }

    /// Tells in which section it was found.
    pub fn within(mut self, tag: &str) -> Self {
        self.within.push(tag.to_owned());
        self
    }
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path: Vec<&str> = self.within.iter().rev().map(String::as_str).collect();
        match path.is_empty() {
            true => write!(f, "byte {} of the unpacked data: {}", self.at, self.what),
            false => write!(f, "byte {} of the unpacked data, in section {}: {}", self.at, path.join("/"), self.what),
        }
    }
}

/// Where some bytes of the unpacked data lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Span {
    /// The first.
    pub at: usize,
    /// How many.
    pub len: usize,
}

impl Span {
    /// The bytes themselves; none if the span is of other data.
    pub fn of<'a>(&self, data: &'a [u8]) -> &'a [u8] {
        data.get(self.at..self.at.saturating_add(self.len)).unwrap_or_default()
    }
}

/// Sections nest no deeper; in real files they nest 9 deep.
pub const MOST_DEPTH: usize = 64;

/// Bytes that are being read.
#[derive(Clone)]
pub struct Cursor<'a> {
    data: &'a [u8],
    at: usize,
    end: usize,
    /// Whether real numbers are of 8 bytes, not 4: the newer one of two tags for the same thing.
    pub wide: bool,
    depth: usize,
}

impl<'a> Cursor<'a> {
    /// At the beginning of the data.
    pub fn new(data: &'a [u8]) -> Self {
        Cursor { data, at: 0, end: data.len(), wide: false, depth: 0 }
    }
    /// The next byte's place in the data.
    pub fn at(&self) -> usize {
        self.at
    }
    /// Bytes that are left.
    pub fn left(&self) -> usize {
        self.end - self.at
    }
    /// An error here.
    pub fn broken(&self, what: impl Into<String>) -> Broken {
        Broken::new(self.at, what)
    }
    /// The next `n` bytes.
    pub fn take(&mut self, n: usize) -> Read<&'a [u8]> {
        if n > self.left() {
            return Err(self.broken(format!("{n} bytes are wanted, {} are left", self.left())));
        }
        let bytes = &self.data[self.at..self.at + n];
        self.at += n;
        Ok(bytes)
    }
    /// The next `n` bytes, to be read by themselves, one level deeper.
    pub fn part(&mut self, n: usize, wide: bool) -> Read<Cursor<'a>> {
        if self.depth >= MOST_DEPTH {
            return Err(self.broken(format!("sections nest more than {MOST_DEPTH} deep")));
        }
        let at = self.at;
        self.take(n)?;
        Ok(Cursor { data: self.data, at, end: at + n, wide, depth: self.depth + 1 })
    }
    /// All that is left.
    pub fn rest(&mut self) -> Span {
        let span = Span { at: self.at, len: self.left() };
        self.at = self.end;
        span
    }
    fn array<const N: usize>(&mut self) -> Read<[u8; N]> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?);
        Ok(out)
    }
    /// A tag: three characters.
    pub fn tag(&mut self) -> Read<[u8; 3]> {
        self.array()
    }
    /// A byte.
    pub fn u8(&mut self) -> Read<u8> {
        Ok(self.array::<1>()?[0])
    }
    /// An integer of 2 bytes.
    pub fn u16(&mut self) -> Read<u16> {
        Ok(u16::from_le_bytes(self.array()?))
    }
    /// An integer of 4 bytes.
    pub fn i32(&mut self) -> Read<i32> {
        Ok(i32::from_le_bytes(self.array()?))
    }
    /// An integer of 8 bytes.
    pub fn u64(&mut self) -> Read<u64> {
        Ok(u64::from_le_bytes(self.array()?))
    }
    /// A number of bytes or items: an integer of 4 bytes that is not negative.
    pub fn count(&mut self) -> Read<usize> {
        let at = self.at;
        let n = self.i32()?;
        usize::try_from(n).map_err(|_| Broken::new(at, format!("{n} is not a length")))
    }
    /// A real number, of 4 or 8 bytes.
    pub fn real(&mut self) -> Read<f64> {
        if self.wide { Ok(f64::from_le_bytes(self.array()?)) } else { self.single() }
    }
    /// A real number of 4 bytes.
    pub fn single(&mut self) -> Read<f64> {
        Ok(f64::from(f32::from_le_bytes(self.array()?)))
    }
    /// Real numbers.
    pub fn reals<const N: usize>(&mut self) -> Read<[f64; N]> {
        let mut out = [0.0; N];
        for x in &mut out {
            *x = self.real()?;
        }
        Ok(out)
    }
    /// As many real numbers as are declared, if they are present.
    pub fn list(&mut self, n: usize) -> Read<Vec<f64>> {
        let bytes = n.saturating_mul(if self.wide { 8 } else { 4 });
        if bytes > self.left() {
            return Err(self.broken(format!("{n} numbers are wanted, {} bytes are left", self.left())));
        }
        (0..n).map(|_| self.real()).collect()
    }
    /// A text with its length before it; UTF-8, or else Latin-1.
    pub fn text(&mut self) -> Read<String> {
        let n = self.count()?;
        Ok(decode(self.take(n)?))
    }
    /// Bytes with their number before them.
    pub fn blob(&mut self) -> Read<Vec<u8>> {
        let n = self.count()?;
        Ok(self.take(n)?.to_vec())
    }
}

/// Text of any file: UTF-8, or else Latin-1.
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
    fn nothing_is_read_beyond_the_end() {
        let mut c = Cursor::new(&[5, 0, 0, 0, b'a']);
        assert_eq!(c.text().unwrap_err().what, "5 bytes are wanted, 1 are left");
        let mut c = Cursor::new(&[0xFF; 8]);
        assert_eq!(c.count().unwrap_err(), Broken::new(0, "-1 is not a length"));
        assert_eq!(Cursor::new(&[0; 3]).i32().unwrap_err().at, 0);
        let mut c = Cursor::new(&[1, 0, 0, 0]);
        assert!(c.list(usize::MAX).is_err());
    }

    #[test]
    fn texts_that_are_no_utf8_are_latin_1() {
        assert_eq!(decode("é".as_bytes()), "é");
        assert_eq!(decode(&[0xE9]), "é");
    }
}
