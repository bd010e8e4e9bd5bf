//! Checks the results of a plugin against the contract before they are read.

use tatu_plugin_api::{abi::*, safe::MAX_DEPTH};

/// Checks that the number and types of the results are valid, and sets the length of spans at a null pointer to 0.
/// Nested values are not checked.
pub(crate) fn check_results(f: &mut tatu_call) -> Result<(), String> {
    if f.n_results > f.results_cap {
        return Err(format!(
            "broke the contract: it returned {} results, but there is space for only {}",
            f.n_results, f.results_cap
        ));
    }
    for (i, v) in results(f).iter_mut().enumerate() {
        if v.tag > TATU_OBJECT {
            return Err(format!("broke the contract: result {} has the unknown type {}", i + 1, v.tag));
        }
        if span(v).is_some_and(|s| s.ptr.is_null()) {
            v.u.s.len = 0;
        }
    }
    Ok(())
}

/// Checks the contents of spans, lists and maps in a command's results. They are checked immediately, because it is no
/// longer known which plugin returned them when they are read.
pub(super) fn check_nested(f: &mut tatu_call) -> Result<(), String> {
    for (i, v) in results(f).iter().enumerate() {
        if let Some(flaw) = span_flaw(v, 0) {
            return Err(format!("broke the contract: result {} {flaw}", i + 1));
        }
    }
    Ok(())
}

/// Maximum size of a span, bytes. A world's arena does not have more memory.
const MAX_SPAN_BYTES: u64 = 256 << 20;

/// Returns the results of a call that has just returned.
fn results(f: &mut tatu_call) -> &mut [tatu_value] {
    let n = f.n_results.min(f.results_cap) as usize;
    if n == 0 {
        return &mut [];
    }
    // SAFETY: `f.results` points to an array of `results_cap` values that lives during the call, and `n <= results_cap`.
    unsafe { std::slice::from_raw_parts_mut(f.results, n) }
}

/// Returns the span of a value, if it has one.
fn span(v: &tatu_value) -> Option<tatu_span_t> {
    // SAFETY: the contract requires `s` to be the active member of the union for these tags.
    if (TATU_TEXT..=TATU_MAP).contains(&v.tag) { Some(unsafe { v.u.s }) } else { None }
}

/// Returns a description of the first error in the span of a value, if there is one.
fn span_flaw(v: &tatu_value, depth: usize) -> Option<String> {
    let tatu_span_t { ptr, len } = span(v)?;
    let each = match v.tag {
        TATU_F64S | TATU_I64S => 8,
        TATU_F32S | TATU_I32S => 4,
        TATU_LIST => size_of::<tatu_value>() as u64,
        TATU_MAP => 2 * size_of::<tatu_value>() as u64,
        _ => 1,
    };
    if len.checked_mul(each).is_none_or(|bytes| bytes > MAX_SPAN_BYTES) {
        return Some(format!("has {len} elements, which exceed the limit of {} MB", MAX_SPAN_BYTES >> 20));
    }
    if len > 0 && !(ptr as u64).is_multiple_of(each.min(8)) {
        return Some("is at an address that is not aligned to its elements".into());
    }
    if !matches!(v.tag, TATU_LIST | TATU_MAP) || len == 0 {
        return None;
    }
    if ptr.is_null() {
        return Some(format!("contains a list or map of {len} elements at a null pointer"));
    }
    if depth >= MAX_DEPTH {
        return Some(format!("is nested deeper than {MAX_DEPTH} levels: it may contain itself"));
    }
    let n = if v.tag == TATU_MAP { 2 * len } else { len } as usize;
    // SAFETY: the contract requires a span to contain `len` values (two per pair of a map) that live until the call has
    // returned; address, alignment and size were checked above.
    let values = unsafe { std::slice::from_raw_parts(ptr.cast::<tatu_value>(), n) };
    for (i, inner) in values.iter().enumerate() {
        let is_key = v.tag == TATU_MAP && i % 2 == 0;
        let flaw = match inner.tag {
            tag if tag > TATU_OBJECT => Some(format!("contains a value of the unknown type {tag}")),
            // SAFETY: the tag is `TATU_F64`, so `f` is the active member of the union.
            TATU_F64 if is_key && unsafe { inner.u.f.is_nan() } => Some("contains a map with the key NaN".into()),
            tag if is_key
                && !matches!(
                    tag,
                    TATU_BOOL | TATU_I64 | TATU_F64 | TATU_TEXT | TATU_BYTES | TATU_OBJECT | TATU_NIL
                ) =>
            {
                Some(format!(
                    "contains a map with a key of type {tag}: keys must be strings, numbers, Booleans or objects"
                ))
            }
            TATU_TEXT..=TATU_MAP => span_flaw(inner, depth + 1),
            _ => None,
        };
        if flaw.is_some() {
            return flaw;
        }
    }
    None
}
