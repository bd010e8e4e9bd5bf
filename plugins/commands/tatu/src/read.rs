//! The command `tatu.read`, which returns the last reading of any sensor by the names of its fields.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Offer, Param, Reading, Result, Value},
};

use crate::plugin::{Cmd, SharedCtx, Tatu};

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::side_by_side("tatu.read", |c| {
            let out = read(c)?;
            c.ret(Value::Map(out));
            Ok(())
        })
        .param(Param::int("sensor").text("a handle"))
        .returns(Param::map("reading").text(
            "time in s, sequence (0: never measured), and each field by its name without the schema; if two fields \
             share this name, also by their full names. Scalar fields are numbers, one-dimensional fields tables; \
             images and all other fields with rows are strings of packed little-endian numbers, accompanied by the \
             integers rows and columns. An object is given by its handle; -1: no object",
        ))
        .text("Returns the last reading of a sensor of any kind, in SI units and radians.")
        .example(
            "function sysCall_sensing()\n  \
               local r = tatu.read(sim.getObject('/sonar'))\n  \
               assert(r.sequence > 0 and r.time == sim.getSimulationTime())\n  \
               assert(r.detected == 0 and r.distance == 0 and #r.point == 3 and r.object == -1)\n\
             end",
        ),
    );
}

type NamedFields = Vec<(Value, Value)>;

fn read(c: &SharedCtx<'_>) -> Result<NamedFields> {
    let world = c.world();
    let o = world.look(c.i64(0)? as u64)?;
    let mut out = Vec::new();
    let mut image = None;
    let mut last: Option<Reading> = None;
    for index in 0.. {
        let Some((name, dims)) = world.field_of(o.id, index) else { break };
        let reading = world.reading(o.id, world.host().prop(name))?;
        let (value, packed) = value(&reading, dims);
        if packed && image.is_none() {
            image = Some((dims[0], dims[1]));
        }
        out.push((name, value));
        last = Some(reading);
    }
    let Some(last) = last else {
        let path = world.get(o.id, world.host().prop("object.path"))?;
        let path = path.as_str().unwrap_or_default().into_owned();
        return Err(Fail::argument(format!(
            "object {} `{path}` has no readings because it is not a sensor",
            o.handle()
        )));
    };
    let mut entries = with_short_names(out);
    entries.push((Value::text("time"), Value::Float(last.time())));
    entries.push((Value::text("sequence"), Value::Int(last.sequence() as i64)));
    if let Some((rows, columns)) = image {
        entries.push((Value::text("rows"), Value::Int(rows.into())));
        entries.push((Value::text("columns"), Value::Int(columns.into())));
    }
    Ok(entries)
}

/// Returns the fields by their short names. If several fields share a short name, it refers to the first of them, and
/// all of them are also returned by their full names.
fn with_short_names(fields: Vec<(&str, Value)>) -> NamedFields {
    let short = |name: &str| name.split_once('.').map_or(name, |(_, short)| short).to_owned();
    let all: Vec<String> = fields.iter().map(|(name, _)| short(name)).collect();
    let mut out = NamedFields::new();
    for ((i, key), (name, value)) in all.iter().enumerate().zip(fields) {
        if all.iter().filter(|k| *k == key).count() > 1 {
            out.push((Value::text(name), value.clone()));
        }
        if !all[..i].contains(key) {
            out.push((Value::text(key), value));
        }
    }
    out
}

/// Converts a field to a value for scripts, and returns it with whether it is packed into a string.
fn value(r: &Reading, dims: [u32; 3]) -> (Value, bool) {
    if dims[1] != 1 || dims[2] != 1 {
        return (Value::Bytes(bytes(r)), true);
    }
    let handle = |o: &u64| if *o == 0 { -1 } else { i64::from(tatu_slot(*o)) };
    let value = match r.elem() {
        TATU_ELEM_F64 => Value::Floats(r.f64s().to_vec()),
        TATU_ELEM_F32 => Value::Floats(r.f32s().iter().map(|x| f64::from(*x)).collect()),
        TATU_ELEM_I32 => Value::Ints(r.i32s().iter().map(|x| i64::from(*x)).collect()),
        TATU_ELEM_U16 => Value::Ints(r.u16s().iter().map(|x| i64::from(*x)).collect()),
        TATU_ELEM_OBJECT => Value::Ints(r.objects().iter().map(handle).collect()),
        _ => Value::Ints(r.u8s().iter().map(|x| i64::from(*x)).collect()),
    };
    let value = match value {
        Value::Floats(v) if dims == [1; 3] && v.len() == 1 => Value::Float(v[0]),
        Value::Ints(v) if dims == [1; 3] && v.len() == 1 => Value::Int(v[0]),
        other => other,
    };
    (value, false)
}

/// Returns all elements as packed little-endian bytes.
pub(crate) fn bytes(r: &Reading) -> Vec<u8> {
    match r.elem() {
        TATU_ELEM_F64 => r.f64s().iter().flat_map(|x| x.to_le_bytes()).collect(),
        TATU_ELEM_F32 => r.f32s().iter().flat_map(|x| x.to_le_bytes()).collect(),
        TATU_ELEM_I32 => r.i32s().iter().flat_map(|x| x.to_le_bytes()).collect(),
        TATU_ELEM_U16 => r.u16s().iter().flat_map(|x| x.to_le_bytes()).collect(),
        TATU_ELEM_OBJECT => r.objects().iter().flat_map(|o| tatu_slot(*o).to_le_bytes()).collect(),
        _ => r.u8s().to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unambiguous_fields_have_short_names() {
        let entry = |k: &str, n: i64| (Value::text(k), Value::Int(n));
        assert_eq!(
            with_short_names(vec![("a.x", Value::Int(1)), ("a.y", Value::Int(2)), ("b.y", Value::Int(3))]),
            [entry("x", 1), entry("a.y", 2), entry("y", 2), entry("b.y", 3)]
        );
    }
}
