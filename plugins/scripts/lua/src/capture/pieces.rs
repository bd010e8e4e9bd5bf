//! The functions of a text, one by one.
//!
//! Lua writes a compiled text as one nested whole, and reads one function with all that is in it. Here the whole is cut:
//! every function of the text becomes a chunk of its own, equal to what Lua writes of a living function that was made
//! there. So a function is found again by its bytes, and made anew from the text that it came from.

use std::ffi::c_void;

use mlua::ffi::*;

/// Signature, version, format, check bytes, sizes of an instruction, an integer and a float, one of each.
const HEADER: usize = 4 + 1 + 1 + 6 + 3 + 8 + 8;
/// A missing text.
const NONE: u8 = 0x80;

unsafe extern "C-unwind" fn extend(_: *mut lua_State, bytes: *const c_void, n: usize, out: *mut c_void) -> i32 {
    if n > 0 {
        let bytes = std::slice::from_raw_parts(bytes.cast::<u8>(), n);
        (*out.cast::<Vec<u8>>()).extend_from_slice(bytes);
    }
    0
}

/// The bytes of the Lua function on top.
///
/// # Safety
/// It is one; nothing is pushed, and nothing raised.
pub(super) unsafe fn dump(l: *mut lua_State, out: &mut Vec<u8>) {
    out.clear();
    lua_dump(l, extend, (&raw mut *out).cast(), 0);
}

/// Cuts a whole into its functions, in order of appearance; the first is the text itself. `None`: the bytes are of
/// another form than Lua 5.4's.
pub(super) fn cut(whole: &[u8]) -> Option<Vec<Vec<u8>>> {
    let mut reader = Reader { bytes: whole, at: HEADER + 1, found: Vec::new() };
    reader.function()?;
    if reader.at != whole.len() {
        return None;
    }
    let source = &whole[reader.found.first()?.source.clone()];
    let piece = |f: &Found| {
        let mut out = whole[..HEADER].to_vec();
        out.push(f.upvalues);
        out.extend_from_slice(if f.source.len() == 1 && whole[f.source.start] == NONE {
            source
        } else {
            &whole[f.source.clone()]
        });
        out.extend_from_slice(&whole[f.source.end..f.end]);
        out
    };
    Some(reader.found.iter().map(piece).collect())
}

/// A number over what the Lua function on top does, with all that is in it: the same wherever in its text it stands, and
/// whatever is said in comments.
///
/// # Safety
/// As of `dump`; `out` is room.
pub(super) unsafe fn meaning(l: *mut lua_State, out: &mut Vec<u8>) -> u64 {
    out.clear();
    lua_dump(l, extend, (&raw mut *out).cast(), 1);
    let mut reader = Reader { bytes: out, at: HEADER + 1, found: Vec::new() };
    let lines = |f: &Found, i: usize| f.lines.contains(&i);
    let known = reader.function().is_some();
    let mut found = std::mem::take(&mut reader.found).into_iter().peekable();
    let mut h = 0xcbf2_9ce4_8422_2325_u64;
    for (i, byte) in out.iter().enumerate() {
        while known && found.next_if(|f| f.lines.end <= i).is_some() {}
        if !known || !found.peek().is_some_and(|f| lines(f, i)) {
            h = (h ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    h
}

/// Where a function stands in the whole.
struct Found {
    /// Its first and last line in the text.
    lines: std::ops::Range<usize>,
    source: std::ops::Range<usize>,
    end: usize,
    upvalues: u8,
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    found: Vec<Found>,
}

impl Reader<'_> {
    fn skip(&mut self, n: usize) -> Option<()> {
        self.at = self.at.checked_add(n).filter(|at| *at <= self.bytes.len())?;
        Some(())
    }
    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }
    /// Seven bits a byte, the highest first; the last byte has its eighth bit set.
    fn size(&mut self) -> Option<usize> {
        let mut n = 0usize;
        loop {
            let byte = self.byte()?;
            n = n.checked_mul(128)? | usize::from(byte & 0x7F);
            if byte & 0x80 != 0 {
                return Some(n);
            }
        }
    }
    fn text(&mut self) -> Option<()> {
        let n = self.size()?;
        self.skip(n.saturating_sub(1))
    }
    fn function(&mut self) -> Option<()> {
        let start = self.at;
        self.text()?;
        let index = self.found.len();
        self.found.push(Found { lines: self.at..self.at, source: start..self.at, end: 0, upvalues: 0 });
        self.size()?; // first line
        self.size()?; // last line
        self.found[index].lines.end = self.at;
        self.skip(3)?; // parameters, whether they vary, registers
        let code = self.size()?;
        self.skip(code.checked_mul(4)?)?;
        for _ in 0..self.size()? {
            match self.byte()? {
                0x03 | 0x13 => self.skip(8)?,
                0x04 | 0x14 => self.text()?,
                0x00 | 0x01 | 0x11 => {}
                _ => return None,
            }
        }
        let upvalues = self.size()?;
        self.skip(upvalues.checked_mul(3)?)?;
        for _ in 0..self.size()? {
            self.function()?;
        }
        let lines = self.size()?;
        self.skip(lines)?;
        for _ in 0..self.size()? {
            self.size()?;
            self.size()?;
        }
        for _ in 0..self.size()? {
            self.text()?;
            self.size()?;
            self.size()?;
        }
        for _ in 0..self.size()? {
            self.text()?;
        }
        let found = &mut self.found[index];
        (found.end, found.upvalues) = (self.at, u8::try_from(upvalues).ok()?);
        Some(())
    }
}
