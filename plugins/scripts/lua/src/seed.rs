//! Whether Lua was built with a fixed hash seed.

use mlua::ffi::*;

/// The seed of `.cargo/config.toml`.
const SEED: u32 = 0x5EED;

/// Lua's hash of a short text.
pub(crate) fn hash(text: &[u8]) -> u32 {
    let begin = SEED ^ text.len() as u32;
    text.iter().rev().fold(begin, |h, b| h ^ (h << 5).wrapping_add(h >> 2).wrapping_add(u32::from(*b)))
}

/// The order in which `pairs` visits the keys k1..k16 when strings are hashed with the seed of `.cargo/config.toml`.
const EXPECTED: &str = "k1k2k3k4k6k5k8k7k11k9k13k15k14k12k10k16";

/// The order of some text keys in a fresh state.
fn order() -> String {
    const TEXT: &[u8] =
        b"local t, s = {}, '' for i = 1, 16 do t['k' .. i] = i end for k in pairs(t) do s = s .. k end return s";
    // SAFETY: a state of our own; a failed call leaves a text too.
    unsafe {
        let l = luaL_newstate();
        if l.is_null() {
            return String::new();
        }
        luaL_requiref(l, c"_G".as_ptr(), luaopen_base, 1);
        luaL_loadbuffer(l, TEXT.as_ptr().cast(), TEXT.len(), c"=seed".as_ptr());
        lua_pcall(l, 0, 1, 0);
        let mut len = 0;
        let text = lua_tolstring(l, -1, &mut len);
        let order = if text.is_null() {
            String::new()
        } else {
            String::from_utf8_lossy(std::slice::from_raw_parts(text.cast(), len)).into_owned()
        };
        lua_close(l);
        order
    }
}

/// Whether the seed is the one that the build should have set.
pub(crate) fn pinned() -> bool {
    order() == EXPECTED
}

#[cfg(test)]
mod tests {
    #[test]
    fn seed_is_pinned() {
        assert_eq!(super::order(), super::EXPECTED);
    }
}
