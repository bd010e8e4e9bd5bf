//! The grammar of files: objects consist of elements and end with `EOO`; an element consists of a tag, a length, and a
//! payload of this length.
//!
//! The elements of an object are listed in a table of [`ElementTag`]s. If a quantity has an older tag, with 4-byte
//! numbers, and a newer one, with 8-byte numbers, a single row describes both.

use super::{
    cursor::{ByteSpan, Cursor, ReadResult},
    unknown::UnknownElements,
};

/// A function that reads the payload of an element into `T`.
pub type ElementReader<T> = fn(&mut T, &mut Cursor<'_>, &mut UnknownElements) -> ReadResult;

/// A row of a table: the meaning of an element.
pub struct ElementTag<T> {
    /// Tag of the form with 4-byte numbers, or without numbers; may be empty.
    pub single: &'static str,
    /// Tag of the form with 8-byte numbers; may be empty.
    pub double: &'static str,
    /// Function that reads the element's payload.
    pub read: ElementReader<T>,
}

/// Builds a table of tags: `"Prt" | "_rt" => |j, c, _| ...`.
macro_rules! tags {
    ($of:ty { $($single:literal $(| $double:literal)? => $read:expr,)* }) => {
        &[$($crate::read::section::ElementTag::<$of> {
            single: $single,
            double: $crate::read::section::tags!(@double $($double)?),
            read: $read,
        }),*]
    };
    (@double $double:literal) => { $double };
    (@double) => { "" };
}
pub(crate) use tags;

/// The marker that ends an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndMarker {
    /// `EOO`, or the end of the bytes.
    Object,
    /// `NXT`, after which the part specific to the object's kind follows.
    Next,
    /// `EOF`, the end of the file.
    File,
}

/// An element of a file.
pub struct Element<'a> {
    /// The three characters that identify the element.
    pub tag: String,
    /// Cursor over the payload of the element.
    pub body: Cursor<'a>,
}

/// Reads the next element or end marker.
pub fn next<'a>(c: &mut Cursor<'a>) -> ReadResult<Result<Element<'a>, EndMarker>> {
    if c.remaining() == 0 {
        return Ok(Err(EndMarker::Object));
    }
    let at = c.at();
    let raw = c.tag()?;
    match &raw {
        b"EOO" => return Ok(Err(EndMarker::Object)),
        b"NXT" => return Ok(Err(EndMarker::Next)),
        b"EOF" => return Ok(Err(EndMarker::File)),
        _ => {}
    }
    let tag: String = raw.iter().map(|b| if b.is_ascii_graphic() { char::from(*b) } else { '?' }).collect();
    let length = c.count().map_err(|e| e.within(&tag))?;
    if length > c.remaining() {
        let what = format!("the section declares {length} bytes, but only {} remain", c.remaining());
        return Err(super::cursor::ReadError::new(at, what).within(&tag));
    }
    let body = c.part(length, false).map_err(|e| e.within(&tag))?;
    Ok(Ok(Element { tag, body }))
}

/// Reads an object with its table of tags. Elements whose tags are in `ignored` are skipped; all other elements that
/// are not in the table are recorded as unknown.
pub fn object<T>(
    c: &mut Cursor<'_>,
    tags: &[ElementTag<T>],
    ignored: &[&str],
    into: &mut T,
    unknown: &mut UnknownElements,
) -> ReadResult<EndMarker> {
    loop {
        let mut element = match next(c)? {
            Ok(element) => element,
            Err(end) => return Ok(end),
        };
        let tag = element.tag.as_str();
        let row = tags.iter().find(|row| row.single == tag || row.double == tag);
        match row {
            Some(row) => {
                element.body.has_doubles = row.double == tag;
                unknown.enter(tag);
                let done = (row.read)(into, &mut element.body, unknown);
                unknown.leave();
                done.map_err(|e| e.within(tag))?;
            }
            None if ignored.contains(&tag) => {}
            None => unknown.add(tag, ByteSpan { at: element.body.at(), len: element.body.remaining() }),
        }
    }
}

/// Reads all consecutive objects in the remaining bytes; `EOO` may occur more than once.
pub fn objects<T>(
    c: &mut Cursor<'_>,
    tags: &[ElementTag<T>],
    ignored: &[&str],
    into: &mut T,
    unknown: &mut UnknownElements,
) -> ReadResult {
    while c.remaining() > 0 {
        object(c, tags, ignored, into, unknown)?;
    }
    Ok(())
}
