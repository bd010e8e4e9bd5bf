//! The inside of tables and texts of Lua 5.4, which is compiled in: sizes, places of keys, chains.
//!
//! Read after [`is_known`] has looked at a table whose content is known. Written are only the hint of the length, and
//! two tables' contents in exchange.

use mlua::ffi::*;

// Offsets in `Table`, `Node` and `TString` of lobject.h, on machines with 64-bit pointers.
const FLAGS: usize = 10;
const LOG_SIZE: usize = 11;
const LIMIT: usize = 12;
const ARRAY: usize = 16;
const NODE: usize = 24;
const LAST_FREE: usize = 32;
const NODE_BYTES: usize = 24;
const VALUE_TAG: usize = 8;
const KEY_TAG: usize = 9;
const KEY: usize = 16;
const SHORT_LEN: usize = 11;
const LONG_LEN: usize = 16;
const CONTENT: usize = 24;

/// The flag that says that the limit is a hint.
const HINT: u8 = 1 << 7;
const FALSE: u8 = 0x01;
const TRUE: u8 = 0x11;
const INT: u8 = 0x03;
const FLOAT: u8 = 0x13;
const SHORT: u8 = 0x44;
const LONG: u8 = 0x54;
const GONE: u8 = 11;

/// A key as it stands in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Key<'a> {
    Nil,
    Bool(bool),
    Int(i64),
    Float(u64),
    Text(&'a [u8]),
    /// A table, function, coroutine or block of bytes.
    Object,
    /// The collector has taken it.
    Gone,
}

/// The inside of a table.
#[derive(Clone, Copy)]
pub(super) struct Raw(*mut u8);

impl Raw {
    /// # Safety
    /// There is a table at `idx`, which lives while this is used.
    pub(super) unsafe fn of(l: *mut lua_State, idx: i32) -> Raw {
        Raw(lua_topointer(l, idx).cast_mut().cast())
    }
    unsafe fn at<T: Copy>(self, offset: usize) -> T {
        self.0.add(offset).cast::<T>().read()
    }
    unsafe fn put<T>(self, offset: usize, value: T) {
        self.0.add(offset).cast::<T>().write(value);
    }
    /// Places of the hash part; 0: it has none.
    pub(super) unsafe fn nodes(self) -> usize {
        if self.at::<*mut u8>(LAST_FREE).is_null() { 0 } else { 1 << self.at::<u8>(LOG_SIZE) }
    }
    /// The limit, and whether it is a hint only.
    pub(super) unsafe fn limit(self) -> (u32, bool) {
        (self.at(LIMIT), self.at::<u8>(FLAGS) & HINT != 0)
    }
    /// Sets them. Refused if the array would get another size.
    pub(super) unsafe fn set_limit(self, limit: u32, is_hint: bool) -> bool {
        if size_of_array(limit, is_hint) != self.array() {
            return false;
        }
        self.put(LIMIT, limit);
        self.put(FLAGS, self.at::<u8>(FLAGS) & !HINT | if is_hint { HINT } else { 0 });
        true
    }
    /// Places of the array part.
    pub(super) unsafe fn array(self) -> usize {
        let (limit, is_hint) = self.limit();
        size_of_array(limit, is_hint)
    }
    unsafe fn node(self, i: usize) -> *mut u8 {
        self.at::<*mut u8>(NODE).add(i * NODE_BYTES)
    }
    /// Whether a place holds a value.
    pub(super) unsafe fn has_value(self, i: usize) -> bool {
        *self.node(i).add(VALUE_TAG) & 0x0F != 0
    }
    /// The key in a place.
    pub(super) unsafe fn key<'a>(self, i: usize) -> Key<'a> {
        let node = self.node(i);
        let value = node.add(KEY);
        match *node.add(KEY_TAG) {
            FALSE => Key::Bool(false),
            TRUE => Key::Bool(true),
            INT => Key::Int(value.cast::<i64>().read()),
            FLOAT => Key::Float(value.cast::<u64>().read()),
            tag @ (SHORT | LONG) => {
                let text = value.cast::<*const u8>().read();
                let len = match tag {
                    SHORT => usize::from(*text.add(SHORT_LEN)),
                    _ => text.add(LONG_LEN).cast::<usize>().read(),
                };
                Key::Text(std::slice::from_raw_parts(text.add(CONTENT), len))
            }
            GONE => Key::Gone,
            tag if tag & 0x0F == 0 => Key::Nil,
            _ => Key::Object,
        }
    }
    /// Makes the key in a place, whose value has been taken out, one that the collector has taken.
    pub(super) unsafe fn forget(self, i: usize) {
        self.node(i).add(KEY_TAG).write(GONE);
    }
    /// Exchanges the contents of two tables; metatables stay.
    ///
    /// # Safety
    /// The collector rests, and both are of one colour.
    pub(super) unsafe fn exchange(self, other: Raw) {
        let (a, b) = (self.at::<u8>(FLAGS) & HINT, other.at::<u8>(FLAGS) & HINT);
        // The other bits remember which metamethods are missing: asked again when needed.
        self.put(FLAGS, b);
        other.put(FLAGS, a);
        std::ptr::swap(self.0.add(LOG_SIZE), other.0.add(LOG_SIZE));
        std::ptr::swap(self.0.add(LIMIT).cast::<u32>(), other.0.add(LIMIT).cast());
        for pointer in [ARRAY, NODE, LAST_FREE] {
            std::ptr::swap(self.0.add(pointer).cast::<usize>(), other.0.add(pointer).cast());
        }
    }
}

fn size_of_array(limit: u32, is_hint: bool) -> usize {
    if is_hint { (limit as usize).next_power_of_two() } else { limit as usize }
}

/// Whether tables are laid out as this file says.
///
/// # Safety
/// Protected; five free places on the stack.
pub(super) unsafe fn is_known(l: *mut lua_State) -> bool {
    if size_of::<usize>() != 8 {
        return false;
    }
    lua_createtable(l, 3, 4);
    lua_pushinteger(l, 7);
    lua_rawseti(l, -2, 1000);
    lua_pushboolean(l, 1);
    lua_setfield(l, -2, c"key".as_ptr());
    let t = Raw::of(l, -1);
    let mut keys = (0, 0, 0);
    let right = t.nodes() == 4 && t.limit() == (3, false);
    if right {
        for i in 0..4 {
            match (t.key(i), t.has_value(i)) {
                (Key::Int(1000), true) => keys.0 += 1,
                (Key::Text(b"key"), true) => keys.1 += 1,
                (Key::Nil, false) => keys.2 += 1,
                _ => {}
            }
        }
    }
    lua_pop(l, 1);
    right && keys == (1, 1, 2)
}
