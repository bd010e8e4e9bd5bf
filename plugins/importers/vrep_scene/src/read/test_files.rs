//! Builds small files byte by byte, for tests and the fuzzer.

/// Size of the header since serialization 17.
const HEADER_BYTES: usize = 1021;

/// Returns an unpacked file with the given sections.
pub fn file(serialization: i32, sections: &[u8]) -> Vec<u8> {
    let mut out = vec![0; HEADER_BYTES];
    out[..4].copy_from_slice(b"VREP");
    out[4..8].copy_from_slice(&serialization.to_le_bytes());
    out[8..12].copy_from_slice(&serialization.to_le_bytes());
    out[13..17].copy_from_slice(&i32::try_from(sections.len()).unwrap_or(i32::MAX).to_le_bytes());
    // Program version 4.1.0; a scene.
    out[21..23].copy_from_slice(&40_100_u16.to_le_bytes());
    out[28] = 1;
    out.extend_from_slice(sections);
    out
}

/// A sequence of elements: tag, length, bytes.
#[derive(Default, Clone)]
pub struct ElementBytes(pub Vec<u8>);

impl ElementBytes {
    /// Creates an empty sequence.
    pub fn new() -> Self {
        ElementBytes::default()
    }
    /// Appends an element with the payload `of`.
    pub fn element(mut self, tag: &str, of: ElementBytes) -> Self {
        self.0.extend_from_slice(tag.as_bytes());
        self.i32(i32::try_from(of.0.len()).unwrap_or(i32::MAX)).bytes(&of.0)
    }
    /// Appends a tag without length: `EOO`, `NXT`, `EOF`.
    pub fn mark(self, tag: &str) -> Self {
        self.bytes(tag.as_bytes())
    }
    /// Appends bytes.
    pub fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.extend_from_slice(bytes);
        self
    }
    /// Appends a 4-byte integer.
    pub fn i32(self, x: i32) -> Self {
        self.bytes(&x.to_le_bytes())
    }
    /// Appends 4-byte real numbers.
    pub fn f32(self, numbers: &[f32]) -> Self {
        numbers.iter().fold(self, |out, x| out.bytes(&x.to_le_bytes()))
    }
    /// Appends a text preceded by its length.
    pub fn text(self, text: &str) -> Self {
        self.i32(i32::try_from(text.len()).unwrap_or(i32::MAX)).bytes(text.as_bytes())
    }
}
