//! Lua's transcendental functions, for `lua_math.h`; results are bit-identical with any C library and on any processor.

/// Defines functions that are called from C.
macro_rules! functions {
    ($($name:ident($($x:ident),+) = $function:path;)*) => {
        $(
            #[unsafe(no_mangle)]
            extern "C" fn $name($($x: f64),+) -> f64 {
                $function($($x),+)
            }
        )*
    };
}
functions! {
    tatu_lua_sin(x) = libm::sin;
    tatu_lua_cos(x) = libm::cos;
    tatu_lua_tan(x) = libm::tan;
    tatu_lua_asin(x) = libm::asin;
    tatu_lua_acos(x) = libm::acos;
    tatu_lua_atan2(y, x) = libm::atan2;
    tatu_lua_sinh(x) = libm::sinh;
    tatu_lua_cosh(x) = libm::cosh;
    tatu_lua_tanh(x) = libm::tanh;
    tatu_lua_exp(x) = libm::exp;
    tatu_lua_log(x) = libm::log;
    tatu_lua_log2(x) = libm::log2;
    tatu_lua_log10(x) = libm::log10;
    tatu_lua_pow(x, y) = libm::pow;
}
