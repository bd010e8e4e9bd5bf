//! Rounding to 32-bit floats. Before CoppeliaSim 4.5, scripts and commands exchanged numbers in this format.

use mlua_sys::*;
use tatu_plugin_api::abi::*;

use super::put;

/// Rounds to a 32-bit float. Integral values are unchanged, because they may be handles.
fn single(x: f64) -> f64 {
    if x.fract() == 0.0 { x } else { f64::from(x as f32) }
}

/// Rounds arguments in place: numbers, and arrays of numbers in the memory of this call.
///
/// # Safety
/// `first` must point to `n` values converted by `ValueReader`; they and their arrays must be valid for writes.
pub(crate) unsafe fn to_single(first: *mut tatu_value, n: usize) {
    for i in 0..n {
        let v = &mut *first.add(i);
        match v.tag {
            TATU_F64 => v.u.f = single(v.u.f),
            TATU_F64S => {
                let numbers = v.u.s.ptr.cast::<f64>().cast_mut();
                for k in 0..v.u.s.len as usize {
                    *numbers.add(k) = single(*numbers.add(k));
                }
            }
            _ => {}
        }
    }
}

/// Pushes a rounded result.
///
/// # Safety
/// The requirements of `put` apply.
pub(crate) unsafe fn put_single(l: *mut lua_State, v: &tatu_value) {
    match v.tag {
        TATU_F64 => lua_pushnumber(l, single(v.u.f)),
        TATU_F64S => {
            put(l, v);
            for i in 1..=v.u.s.len as i64 {
                lua_rawgeti(l, -1, i);
                let x = lua_tonumber(l, -1);
                lua_pop(l, 1);
                if x.fract() != 0.0 {
                    lua_pushnumber(l, single(x));
                    lua_rawseti(l, -2, i);
                }
            }
        }
        _ => put(l, v),
    }
}

#[cfg(test)]
mod tests {
    use super::single;

    /// tests/facts/script-api.md, 1: before 4.5, a parameter set to 0.1 reads back as 0.10000000149.
    #[test]
    fn a_tenth_is_rounded_to_32_bits() {
        assert_eq!(format!("{:.14}", single(0.1)), "0.10000000149012");
        assert_eq!(single(16_777_217.0), 16_777_217.0);
        assert!(single(f64::NAN).is_nan());
    }
}
