//! Custom data of objects and scenes, and parameters of scripts.

use std::collections::BTreeMap;

use super::{
    cursor::{Cursor, ReadResult},
    section::{object, tags},
    unknown::UnknownElements,
};

/// Header number of the container of tagged data, in files before 4.3.
const TAGGED_HEADER: i32 = 356_248_756;

/// Custom data of an object or a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CustomData {
    /// Data since 4.3, by tag.
    new: BTreeMap<String, Vec<u8>>,
    /// Data before 4.3, by tag; used only if `new` is empty.
    old: BTreeMap<String, Vec<u8>>,
    /// Data before 3.3, by header number.
    numbered: BTreeMap<i32, Vec<u8>>,
}

impl CustomData {
    /// Returns the data that is in use, by tag.
    pub fn tagged(&self) -> &BTreeMap<String, Vec<u8>> {
        if self.new.is_empty() { &self.old } else { &self.new }
    }
    /// Returns the data of versions before 3.3, by the header number of the developer who stored it.
    pub fn numbered(&self) -> &BTreeMap<i32, Vec<u8>> {
        &self.numbered
    }
}

/// Reads `Cda` or `CDA`: data since 4.3.
pub fn tagged(into: &mut CustomData, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    let tags = tags!(CustomData {
        "Cdt" => |d, c, _| {
            let (tag, bytes) = (c.text()?, c.blob()?);
            d.new.insert(tag, bytes);
            Ok(())
        },
    });
    object(c, tags, &[], into, unknown).map(drop)
}

/// Reads `Cod` or `CDS`: data before 4.3.
pub fn numbered(into: &mut CustomData, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    let tags = tags!(CustomData {
        "Dat" => |d, c, _| {
            let header = c.i32()?;
            let n = c.count()?;
            if header != TAGGED_HEADER {
                d.numbered.insert(header, c.take(n)?.to_vec());
                return Ok(());
            }
            let mut records = c.part(n, false)?;
            while records.remaining() > 0 {
                record(d, &mut records)?;
            }
            Ok(())
        },
    });
    object(c, tags, &[], into, unknown).map(drop)
}

/// Reads a record: its size, the length of its name including a final zero, the name, the data.
fn record(into: &mut CustomData, c: &mut Cursor<'_>) -> ReadResult {
    let size = c.count()?;
    let Some(rest) = size.checked_sub(4) else {
        return Err(c.error(format!("a data record has an invalid size of {size} bytes")));
    };
    let mut c = c.part(rest, false)?;
    let n = c.count()?;
    let name = c.take(n)?;
    let name = super::cursor::decode(name.strip_suffix(&[0]).unwrap_or(name));
    let left = c.remaining();
    into.old.insert(name, c.take(left)?.to_vec());
    Ok(())
}

/// A parameter of a script, which users can edit in V-REP.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScriptParameter {
    /// Name by which scripts access the parameter.
    pub name: String,
    /// Name of the unit, for display only.
    pub unit: String,
    /// Value, which is always stored as a string.
    pub value: String,
    /// Bits that affect the user interface.
    pub properties: i32,
}

/// Reads `Lsp` or `Prm`: parameters of a script.
pub fn parameters(into: &mut Vec<ScriptParameter>, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    let tags = tags!(Vec<ScriptParameter> {
        "Par" => |list, c, _| {
            for _ in 0..c.count()? {
                let (name, unit, value) = (c.text()?, c.text()?, c.text()?);
                list.push(ScriptParameter { name, unit, value, properties: c.i32()? });
            }
            Ok(())
        },
    });
    object(c, tags, &[], into, unknown).map(drop)
}
