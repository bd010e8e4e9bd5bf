//! Packs numbers into little-endian bytes, and unpacks them.

use crate::kit::*;

/// An element type, and the commands that pack and unpack its values.
struct ElementType {
    name: &'static str,
    /// Names of the packing command: current, flat and oldest.
    pack_names: [&'static str; 3],
    /// Names of the unpacking command, in the same order.
    unpack_names: [&'static str; 3],
    size: usize,
    pack: fn(f64, &mut Vec<u8>),
    unpack: UnpackFunction,
}

/// Converts the bytes of an element.
#[derive(Clone, Copy)]
enum UnpackFunction {
    Float(fn(&[u8]) -> f64),
    Int(fn(&[u8]) -> i64),
}

macro_rules! element {
    ($name:literal, $pack:expr, $unpack:expr, $t:ty, $narrow:expr, $widen:expr) => {
        ElementType {
            name: $name,
            pack_names: $pack,
            unpack_names: $unpack,
            size: size_of::<$t>(),
            pack: |x, out| {
                let narrow: fn(f64) -> $t = $narrow;
                out.extend_from_slice(&narrow(x).to_le_bytes());
            },
            unpack: $widen(|bytes| <$t>::from_le_bytes(bytes.try_into().unwrap_or_default()).into()),
        }
    };
}

/// The element types. Integers outside the range of a type wrap around.
const ELEMENTS: &[ElementType] = &[
    element!(
        "Float",
        ["sim.packFloatTable", "simPackFloatTable", "simPackFloats"],
        ["sim.unpackFloatTable", "simUnpackFloatTable", "simUnpackFloats"],
        f32,
        |x| x as f32,
        UnpackFunction::Float
    ),
    element!(
        "Double",
        ["sim.packDoubleTable", "simPackDoubleTable", "simPackDoubles"],
        ["sim.unpackDoubleTable", "simUnpackDoubleTable", "simUnpackDoubles"],
        f64,
        |x| x,
        UnpackFunction::Float
    ),
    element!(
        "Int32",
        ["sim.packInt32Table", "simPackInt32Table", "simPackInts"],
        ["sim.unpackInt32Table", "simUnpackInt32Table", "simUnpackInts"],
        i32,
        |x| x as i64 as i32,
        UnpackFunction::Int
    ),
    element!(
        "UInt32",
        ["sim.packUInt32Table", "simPackUInt32Table", "simPackUInts"],
        ["sim.unpackUInt32Table", "simUnpackUInt32Table", "simUnpackUInts"],
        u32,
        |x| x as i64 as u32,
        UnpackFunction::Int
    ),
    element!(
        "UInt16",
        ["sim.packUInt16Table", "simPackUInt16Table", "simPackWords"],
        ["sim.unpackUInt16Table", "simUnpackUInt16Table", "simUnpackWords"],
        u16,
        |x| x as i64 as u16,
        UnpackFunction::Int
    ),
    element!(
        "UInt8",
        ["sim.packUInt8Table", "simPackUInt8Table", "simPackBytes"],
        ["sim.unpackUInt8Table", "simUnpackUInt8Table", "simUnpackBytes"],
        u8,
        |x| x as i64 as u8,
        UnpackFunction::Int
    ),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for e in ELEMENTS {
        let ([pack_name, old_pack, oldest_pack], [unpack_name, old_unpack, oldest_unpack]) =
            (e.pack_names, e.unpack_names);
        offer.command(
            Cmd::new(pack_name, |c| {
                let v = c.arg(0);
                if !is_table(v) {
                    return Err(Fail::argument("argument 1: expected a table of numbers"));
                }
                let range = selected_range(v.len(), int_or(c, 1, 0)?, int_or(c, 2, 0)?);
                let bytes = pack(e, range.map(|i| v.number(i).unwrap_or(0.0)));
                if !bytes.is_empty() {
                    c.ret(Value::Bytes(bytes));
                }
                Ok(())
            })
            .old_name(oldest_pack, NIL)
            .old_name(old_pack, NIL)
            .param(Param::any("numbers").text("a table; values that are not numbers are packed as 0"))
            .param(Param::int("start").default(0).optional().text("from 0"))
            .param(Param::int("count").default(0).optional().text("0: all remaining elements"))
            .returns(Param::bytes("data").text("no value if no numbers are selected"))
            .text(format!("Packs numbers as {}.", described(e)))
            .example(format!("data = {pack_name}({{1, 2, 3}})")),
        );
        offer.command(
            Cmd::new(unpack_name, |c| {
                let (start, count) = (int_or(c, 1, 0)?, int_or(c, 2, 0)?);
                let skip = usize::try_from(int_or(c, 3, 0)?).unwrap_or(0);
                let bytes = c.bytes(0)?;
                // In a run without a scene, a missing script parameter is replaced with the string "1", which is not
                // packed data; it is unpacked to zeros.
                let stands_in = bytes == b"1" && c.world().makes_stand_ins();
                let bytes = if stands_in { STAND_IN_DATA } else { bytes };
                let values = unpack(e, bytes.get(skip..).unwrap_or_default(), start, count)?;
                c.ret(values);
                Ok(())
            })
            .old_name(oldest_unpack, NIL)
            .old_name(old_unpack, NIL)
            .param(Param::string("data"))
            .param(Param::int("start").default(0).optional().text("from 0"))
            .param(Param::int("count").default(0).optional().text("0: all remaining elements"))
            .param(Param::int("byteOffset").default(0).optional().text("number of bytes to skip"))
            .returns(Param::list("numbers").text("an incomplete element at the end is ignored"))
            .text(format!("Unpacks numbers that were packed as {}.", described(e)))
            .example(format!("numbers = {unpack_name}(data)")),
        );
    }
}

fn described(e: &ElementType) -> String {
    let what = match e.name {
        "Float" | "Double" => "floats",
        "Int32" => "signed integers",
        _ => "unsigned integers",
    };
    format!("{what} of {} bytes", e.size)
}

/// Returns the range of the selected elements, clamped to `n`.
fn selected_range(n: usize, start: i64, count: i64) -> std::ops::Range<usize> {
    let start = usize::try_from(start).unwrap_or(0).min(n);
    let end = match usize::try_from(count) {
        Ok(count) if count > 0 => (start + count).min(n),
        _ => n,
    };
    start..end
}

fn pack(e: &ElementType, numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    let mut out = Vec::new();
    numbers.for_each(|x| (e.pack)(x, &mut out));
    out
}

fn unpack(e: &ElementType, bytes: &[u8], start: i64, count: i64) -> Result<Value> {
    let whole = bytes.len() / e.size;
    let range = selected_range(whole, start, count);
    tables::check_count(range.len(), 8)?;
    let elements = bytes.chunks_exact(e.size).skip(range.start).take(range.len());
    Ok(match e.unpack {
        UnpackFunction::Float(f) => Value::Floats(elements.map(f).collect()),
        UnpackFunction::Int(f) => Value::Ints(elements.map(f).collect()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(name: &str) -> &'static ElementType {
        ELEMENTS.iter().find(|e| e.name == name).unwrap()
    }

    #[test]
    fn floats_are_four_bytes() {
        let e = element("Float");
        let data = pack(e, [1.5, -2.0].into_iter());
        assert_eq!(data, [0, 0, 0xC0, 0x3F, 0, 0, 0, 0xC0]);
        let unpacked = |data: &[u8], start, count| unpack(e, data, start, count).unwrap();
        assert_eq!(unpacked(&data, 0, 0), Value::Floats(vec![1.5, -2.0]));
        assert_eq!(unpacked(&data, 1, 1), Value::Floats(vec![-2.0]));
        assert_eq!(unpacked(&data[..7], 0, 0), Value::Floats(vec![1.5]));
        assert_eq!(unpacked(b"", 0, 0), Value::Floats(vec![]));
    }

    #[test]
    fn integers_wrap_to_their_size() {
        assert_eq!(pack(element("UInt8"), [256.0, -1.0, 7.9].into_iter()), [0, 255, 7]);
        assert_eq!(pack(element("UInt16"), [258.0].into_iter()), [2, 1]);
        let all = pack(element("UInt32"), [-1.0].into_iter());
        assert_eq!(unpack(element("Int32"), &all, 0, 0).unwrap(), Value::Ints(vec![-1]));
        assert_eq!(unpack(element("UInt32"), &all, 0, 0).unwrap(), Value::Ints(vec![0xFFFF_FFFF]));
    }

    #[test]
    fn selected_range_is_clamped() {
        assert_eq!(selected_range(5, 0, 0), 0..5);
        assert_eq!(selected_range(5, 2, 2), 2..4);
        assert_eq!(selected_range(5, 9, 2), 5..5);
        assert_eq!(selected_range(5, -1, 99), 0..5);
    }
}
