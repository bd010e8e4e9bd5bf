//! Reads arguments and resolves the objects that they identify; builds the errors for invalid arguments.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Object, Prop, Result, ValueRef},
};

use super::{
    algebra as al,
    plugin::{Ctx, SharedCtx},
};

pub(crate) const HANDLE_ALL: i64 = -2;
pub(crate) const HANDLE_ALL_EXCEPT_EXPLICIT: i64 = -3;
pub(crate) const HANDLE_SELF: i64 = -4;
pub(crate) const HANDLE_MAIN_SCRIPT: i64 = -5;
pub(crate) const HANDLE_TREE: i64 = -6;
pub(crate) const HANDLE_CHAIN: i64 = -7;
pub(crate) const HANDLE_PARENT: i64 = -11;
pub(crate) const HANDLE_SCENE: i64 = -12;
/// Mask of the bits that form the handle in an argument; higher bits are flags.
pub(crate) const HANDLE_BITS: i64 = TATU_SLOT_BITS as i64;

/// Returns the handle by which scripts identify an object, or -1 for no object.
pub(crate) fn handle(id: tatu_object) -> i64 {
    match id & HANDLE_BITS as u64 {
        0 => -1,
        slot => slot as i64,
    }
}

/// Returns the id of the object in argument `i`, without checking that it exists.
#[inline]
pub(crate) fn id(c: &SharedCtx<'_>, i: usize) -> Result<tatu_object> {
    id_of(c.arg(i), i)
}
/// Converts a value to the id of an object. The value is an object or a handle, whose flags are ignored; `i` is its
/// argument index for messages.
#[inline]
pub(crate) fn id_of(v: ValueRef<'_>, i: usize) -> Result<tatu_object> {
    let id = match v.as_i64() {
        Some(n) if n > 0 => (n & HANDLE_BITS) as u64,
        Some(n) => return Err(Fail::missing(format!("there is no object {n}"))),
        None => v.as_object().ok_or_else(|| Fail::argument(format!("argument {}: expected a handle", i + 1)))?,
    };
    if id == 0 {
        return Err(Fail::missing("there is no object 0"));
    }
    Ok(id)
}
/// Returns the object in argument `i`, or an error if it does not exist.
pub(crate) fn existing_object(c: &SharedCtx<'_>, i: usize) -> Result<Object> {
    let id = id(c, i)?;
    c.world().look(id).map_err(|e| no_object(id, &e))
}
/// Returns the object in argument `i`, or an error if it does not exist or is not of the given kind.
pub(crate) fn of_kind(c: &SharedCtx<'_>, i: usize, kind: i32) -> Result<tatu_object> {
    let o = existing_object(c, i)?;
    if o.kind == kind || c.world().used_as(o.id, kind_key(kind)) { Ok(o.id) } else { Err(wrong_kind(c, o, kind)) }
}
fn no_object(id: tatu_object, why: &Fail) -> Fail {
    Fail::with_code(why.code(), format!("there is no object {}", handle(id)))
}
fn wrong_kind(c: &SharedCtx<'_>, o: Object, wanted: i32) -> Fail {
    Fail::argument(format!(
        "object {} `{}` is {}, not {}",
        o.handle(),
        path(c, o.id),
        kind_name(o.kind),
        kind_name(wanted)
    ))
}
/// Returns the error for a failed access to an object: that it does not exist, that it is not of the kind `wanted`, or
/// otherwise `fail`, the host's error.
#[cold]
pub(crate) fn explain(c: &SharedCtx<'_>, id: tatu_object, wanted: i32, fail: Fail) -> Fail {
    match c.world().look(id) {
        Err(e) => no_object(id, &e),
        Ok(o) if o.kind != wanted => {
            c.world().used_as(o.id, kind_key(wanted));
            wrong_kind(c, o, wanted)
        }
        Ok(_) => fail,
    }
}
/// Like [`explain`], but for commands that accept objects of any kind.
#[cold]
pub(crate) fn explain_any(c: &SharedCtx<'_>, id: tatu_object, fail: Fail) -> Fail {
    match c.world().look(id) {
        Err(e) => no_object(id, &e),
        Ok(_) => fail,
    }
}
/// Returns the value of the property `object.kind` for a kind.
pub(crate) fn kind_key(kind: i32) -> &'static str {
    match kind {
        TATU_KIND_SHAPE => "shape",
        TATU_KIND_JOINT => "joint",
        TATU_KIND_DUMMY => "dummy",
        TATU_KIND_SENSOR => "sensor",
        TATU_KIND_ACTUATOR => "actuator",
        TATU_KIND_FORCE_SENSOR => "force_sensor",
        TATU_KIND_CAMERA => "camera",
        TATU_KIND_LIGHT => "light",
        TATU_KIND_GRAPH => "graph",
        TATU_KIND_PATH => "path",
        TATU_KIND_PART => "part",
        _ => "",
    }
}
/// Returns the name of a kind of object with its article, for messages.
fn kind_name(kind: i32) -> &'static str {
    match kind {
        TATU_KIND_SHAPE => "a shape",
        TATU_KIND_JOINT => "a joint",
        TATU_KIND_DUMMY => "a dummy",
        TATU_KIND_SENSOR => "a sensor",
        TATU_KIND_ACTUATOR => "an actuator",
        TATU_KIND_FORCE_SENSOR => "a force sensor",
        TATU_KIND_SCRIPT => "a script",
        TATU_KIND_CAMERA => "a camera",
        TATU_KIND_LIGHT => "a light",
        TATU_KIND_GRAPH => "a graph",
        TATU_KIND_PATH => "a path",
        TATU_KIND_PART => "a part",
        _ => "an object of a different kind",
    }
}
/// Returns the path of an object, for messages.
pub(crate) fn path(c: &SharedCtx<'_>, id: tatu_object) -> String {
    text_of(c, id, c.plugin().p.path).unwrap_or_default()
}
/// Returns the value of a string property.
pub(crate) fn text_of(c: &SharedCtx<'_>, id: tatu_object, prop: Prop) -> Result<String> {
    let v = c.world().get(id, prop).map_err(|e| explain_any(c, id, e))?;
    v.as_str().map(|s| s.into_owned()).ok_or_else(|| Fail::new("the host returned a value that is not a string"))
}
/// Returns the value of a boolean property.
pub(crate) fn bool_of(c: &SharedCtx<'_>, id: tatu_object, prop: Prop) -> Result<bool> {
    Ok(c.world().get(id, prop)?.truthy())
}
/// Returns the value of an integer property.
pub(crate) fn int_of(c: &SharedCtx<'_>, id: tatu_object, prop: Prop) -> Result<i64> {
    c.world().get(id, prop)?.as_i64().ok_or_else(|| Fail::new("the host returned a value that is not an integer"))
}
/// Returns the parent of an object, or 0 if it has none.
pub(crate) fn parent(c: &SharedCtx<'_>, id: tatu_object) -> Result<tatu_object> {
    let v = c.world().get(id, c.plugin().p.parent).map_err(|e| explain_any(c, id, e))?;
    Ok(v.as_object().unwrap_or(0))
}

/// Returns the first `N` numbers of the table in argument `i`, which may be longer.
pub(crate) fn numbers<const N: usize>(c: &SharedCtx<'_>, i: usize) -> Result<[f64; N]> {
    numbers_of(c.arg(i), i)
}
/// Like [`numbers`], but for a value; `i` is its argument index for messages.
pub(crate) fn numbers_of<const N: usize>(v: ValueRef<'_>, i: usize) -> Result<[f64; N]> {
    let mut out = [0.0; N];
    if v.len() < N {
        return Err(Fail::argument(format!(
            "argument {}: expected a table of {N} numbers, found {}",
            i + 1,
            if is_table(v) { format!("{}", v.len()) } else { "no table".into() }
        )));
    }
    for (k, x) in out.iter_mut().enumerate() {
        *x = element(v, k)
            .filter(|x| x.is_finite())
            .ok_or_else(|| Fail::argument(format!("argument {}: element {} is not a finite number", i + 1, k + 1)))?;
    }
    Ok(out)
}
/// Returns element `k` of a table as a number. Numeric strings are converted to numbers, as in Lua.
pub(crate) fn element(v: ValueRef<'_>, k: usize) -> Option<f64> {
    let from_text = || std::str::from_utf8(v.list()?.get(k)?.as_bytes()?).ok()?.trim().parse().ok();
    v.number(k).or_else(from_text)
}
/// Returns whether a value is a table of numbers or of values.
pub(crate) fn is_table(v: ValueRef<'_>) -> bool {
    (TATU_F64S..=TATU_MAP).contains(&v.tag())
}
/// Packed data that replaces the data of a missing scene. It unpacks to zeros or to an empty table.
pub(crate) const STAND_IN_DATA: &[u8] = &[0; 512];

/// Returns an integer argument, or `otherwise` if it is not given.
pub(crate) fn int_or(c: &SharedCtx<'_>, i: usize, otherwise: i64) -> Result<i64> {
    if c.has(i) { c.i64(i) } else { Ok(otherwise) }
}
/// Reads a table of numbers of any length.
pub(crate) fn floats(c: &Ctx<'_>, i: usize) -> Result<Vec<f64>> {
    c.arg(i).numbers().ok_or_else(|| Fail::argument(format!("argument {}: expected a table of numbers", i + 1)))
}
/// Most numbers of a table that a command computes.
const MAX_RESULT_NUMBERS: usize = 10_000_000;

/// Returns an error if `rows` rows of `columns` numbers are more than a command computes.
pub(crate) fn check_result_size(rows: usize, columns: usize) -> Result {
    if rows.saturating_mul(columns) <= MAX_RESULT_NUMBERS {
        return Ok(());
    }
    Err(Fail::argument(format!(
        "the result would have {rows} rows of {columns} numbers; the maximum is {MAX_RESULT_NUMBERS} numbers in all"
    )))
}

/// Normalizes a quaternion, or returns an error if it is zero; `i` is its argument index for messages.
pub(crate) fn unit(q: al::Quaternion, i: usize) -> Result<al::Quaternion> {
    al::normalized(q).ok_or_else(|| Fail::argument(format!("argument {}: expected a nonzero quaternion", i + 1)))
}

/// Returns whether the caller is a main script.
pub(crate) fn is_main(c: &Ctx<'_>) -> Result<bool> {
    let script = c.caller_script();
    Ok(script != 0 && text_of(c, script, c.plugin().p.script_kind)? == "main")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_are_the_slots_of_ids() {
        assert_eq!(handle(0), -1);
        assert_eq!(handle(3 << 20 | 17), 17);
    }
}
