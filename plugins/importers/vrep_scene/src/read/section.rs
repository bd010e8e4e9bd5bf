//! The grammar: elements of a tag, a length and that many bytes, in objects that end with `EOO`.
//!
//! What an object may hold is a table of [`Tag`]s. Where a quantity has an older tag, with numbers of 4 bytes, and a
//! newer one, with numbers of 8, one row serves both.

use super::{
    cursor::{Cursor, Read, Span},
    unknown::Unknowns,
};

/// How a tag is read into what is being made.
pub type Reader<T> = fn(&mut T, &mut Cursor<'_>, &mut Unknowns) -> Read;

/// A row: what an element means.
pub struct Tag<T> {
    /// Tag of the form with numbers of 4 bytes, or without any; empty: there is none.
    pub single: &'static str,
    /// Tag of the form with numbers of 8 bytes; empty: there is none.
    pub double: &'static str,
    /// Reads its bytes.
    pub read: Reader<T>,
}

/// Writes a table of tags: `"Prt" | "_rt" => |j, c, _| ...`.
macro_rules! tags {
    ($of:ty { $($single:literal $(| $double:literal)? => $read:expr,)* }) => {
        &[$($crate::read::section::Tag::<$of> {
            single: $single,
            double: $crate::read::section::tags!(@double $($double)?),
            read: $read,
        }),*]
    };
    (@double $double:literal) => { $double };
    (@double) => { "" };
}
pub(crate) use tags;

/// How an object ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// `EOO`, or no bytes were left.
    Object,
    /// `NXT`: what its kind adds follows.
    Next,
    /// `EOF`
    File,
}

/// An element as it stands.
pub struct Element<'a> {
    /// Its tag, as text.
    pub tag: String,
    /// Its payload.
    pub body: Cursor<'a>,
}

/// The next element, or the end.
pub fn next<'a>(c: &mut Cursor<'a>) -> Read<Result<Element<'a>, End>> {
    if c.left() == 0 {
        return Ok(Err(End::Object));
    }
    let at = c.at();
    let raw = c.tag()?;
    match &raw {
        b"EOO" => return Ok(Err(End::Object)),
        b"NXT" => return Ok(Err(End::Next)),
        b"EOF" => return Ok(Err(End::File)),
        _ => {}
    }
    let tag: String = raw.iter().map(|b| if b.is_ascii_graphic() { char::from(*b) } else { '?' }).collect();
    let length = c.count().map_err(|e| e.within(&tag))?;
    if length > c.left() {
        let what = format!("the section declares {length} bytes, {} are left", c.left());
        return Err(super::cursor::Broken::new(at, what).within(&tag));
    }
    let body = c.part(length, false).map_err(|e| e.within(&tag))?;
    Ok(Ok(Element { tag, body }))
}

/// Reads an object by its table; what the table lacks is kept as unknown, what `ignored` names is skipped.
pub fn object<T>(
    c: &mut Cursor<'_>,
    tags: &[Tag<T>],
    ignored: &[&str],
    into: &mut T,
    unknown: &mut Unknowns,
) -> Read<End> {
    loop {
        let mut element = match next(c)? {
            Ok(element) => element,
            Err(end) => return Ok(end),
        };
        let tag = element.tag.as_str();
        let row = tags.iter().find(|row| row.single == tag || row.double == tag);
        match row {
            Some(row) => {
                element.body.wide = row.double == tag;
                unknown.enter(tag);
                let done = (row.read)(into, &mut element.body, unknown);
                unknown.leave();
                done.map_err(|e| e.within(tag))?;
            }
            None if ignored.contains(&tag) => {}
            None => unknown.add(tag, Span { at: element.body.at(), len: element.body.left() }),
        }
    }
}

/// Reads all objects that stand one after the other in what is left: `EOO` may come more than once.
pub fn objects<T>(c: &mut Cursor<'_>, tags: &[Tag<T>], ignored: &[&str], into: &mut T, unknown: &mut Unknowns) -> Read {
    while c.left() > 0 {
        object(c, tags, ignored, into, unknown)?;
    }
    Ok(())
}
