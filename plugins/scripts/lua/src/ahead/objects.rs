//! Lua 5.4's objects as they lie in a slot: words of them, wherever they may lead.
//!
//! Nothing here is relied on: what is read in the wrong place is a number that leads nowhere, or to memory that is asked for
//! in vain.

use std::ffi::c_void;

use crate::alloc::Slot;

/// The address of an object.
pub(super) type At = *const c_void;

/// What a value is, as tags tell.
const TABLE: u8 = 0x45;
const LUA_FUNCTION: u8 = 0x46;
const C_FUNCTION: u8 = 0x66;
const SHORT_TEXT: u8 = 0x44;
const WHOLE_NUMBER: u8 = 3;

/// Bytes of a table, of a node of one, of a value, of a text but for its bytes, of a prototype, of a call.
pub(super) const TABLE_BYTES: usize = 56;
pub(super) const NODE: usize = 24;
pub(super) const VALUE: usize = 16;
pub(super) const TEXT_BYTES: usize = 24;
pub(super) const PROTOTYPE: usize = 128;
pub(super) const CALL: usize = 64;

/// What a value is, and where.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Value {
    Table(At),
    Function(At),
    Command(At),
    Text(At),
    Other,
}

/// A list of so many bytes.
pub(super) type List = (At, usize);

/// Reads a slot.
#[derive(Clone, Copy)]
pub(super) struct Objects<'a>(pub &'a Slot);

impl Objects<'_> {
    /// What stands somewhere; zero outside of what was taken from the slot.
    fn read<T: Copy + Default>(self, at: At, offset: usize) -> T {
        let from = at.cast::<u8>().wrapping_add(offset);
        if !self.0.holds(from, size_of::<T>()) {
            return T::default();
        }
        // SAFETY: within the slot; what is there is a number for us, whatever it means.
        unsafe { from.cast::<T>().read_unaligned() }
    }
    fn address(self, at: At, offset: usize) -> At {
        self.read::<usize>(at, offset) as At
    }
    /// A value.
    pub fn value(self, at: At) -> Value {
        let to = self.address(at, 0);
        match self.read::<u8>(at, 8) {
            TABLE => Value::Table(to),
            LUA_FUNCTION => Value::Function(to),
            C_FUNCTION => Value::Command(to),
            SHORT_TEXT => Value::Text(to),
            _ => Value::Other,
        }
    }
    /// The list part of a table.
    pub fn list(self, table: At) -> List {
        (self.address(table, 16), self.read::<u32>(table, 12) as usize * VALUE)
    }
    /// The metatable of a table, or null.
    pub fn metatable(self, table: At) -> At {
        self.address(table, 40)
    }
    /// The first node of a table,
    pub fn nodes(self, table: At) -> At {
        self.address(table, 24)
    }
    /// and how many there are.
    fn count(self, table: At) -> usize {
        1 << self.read::<u8>(table, 11).min(24)
    }
    /// The nodes that are looked at for a short text, and whether the last of them has it.
    pub fn way_to_text(self, table: At, text: At) -> (Vec<At>, bool) {
        let hash = self.read::<u32>(text, 12) as usize;
        self.way(table, hash & (self.count(table) - 1), |node| {
            self.read::<u8>(node, 9) == SHORT_TEXT && self.address(node, 16) == text
        })
    }
    /// The same for a number of a few digits.
    pub fn way_to_number(self, table: At, number: usize) -> (Vec<At>, bool) {
        self.way(table, number % ((self.count(table) - 1) | 1), |node| {
            self.read::<u8>(node, 9) == WHOLE_NUMBER && self.read::<usize>(node, 16) == number
        })
    }
    fn way(self, table: At, first: usize, is_it: impl Fn(At) -> bool) -> (Vec<At>, bool) {
        let mut node = self.nodes(table).wrapping_byte_add(first * NODE);
        let mut way = Vec::new();
        while way.len() < LONGEST {
            way.push(node);
            if is_it(node) {
                return (way, true);
            }
            match self.read::<i32>(node, 12) {
                0 => break,
                next => node = node.wrapping_byte_offset(next as isize * NODE as isize),
            }
        }
        (way, false)
    }
    /// The prototype of a function.
    pub fn prototype(self, function: At) -> At {
        self.address(function, 24)
    }
    /// The variables of a function from outside.
    pub fn variables(self, function: At) -> impl Iterator<Item = At> {
        (0..self.read::<u8>(function, 10) as usize).map(move |i| self.address(function, 32 + 8 * i))
    }
    /// The value of such a variable.
    pub fn of_variable(self, variable: At) -> Value {
        self.value(self.address(variable, 16))
    }
    /// Constants of a prototype.
    pub fn constants(self, prototype: At) -> List {
        (self.address(prototype, 56), self.read::<u32>(prototype, 20) as usize * VALUE)
    }
    /// Its code.
    pub fn code(self, prototype: At) -> List {
        (self.address(prototype, 64), self.read::<u32>(prototype, 24) as usize * 4)
    }
    /// What a thread notes of calls: of the first ones within each other.
    pub fn calls(self, thread: At) -> impl Iterator<Item = At> {
        // The outermost is a part of the thread.
        let first = self.address(thread, 96 + 24);
        std::iter::successors(Some(first), move |call| Some(self.address(*call, 24)))
            .take_while(|call| !call.is_null())
            .take(DEEP)
    }
    /// The words of some memory that lead into the slot.
    pub fn words(self, at: At, words: std::ops::RangeInclusive<usize>) -> impl Iterator<Item = At> {
        words.map(move |i| self.address(at, 8 * i)).filter(move |to| self.0.holds(to.cast(), 1) && to.addr() % 8 == 0)
    }
}

/// Calls within each other: ours, the script's, a command's.
const DEEP: usize = 4;

/// Nodes on a way; longer ones do not occur in tables of names.
const LONGEST: usize = 16;

#[cfg(test)]
mod tests {
    use mlua::ffi::*;

    use super::*;
    use crate::alloc::lua_alloc;

    const TEXT: &[u8] = b"count, list = 0, {7, 8, 9} function add(x) count = count + #list + x end";

    /// What Lua says of its objects is what is read of them.
    #[test]
    fn objects_lie_as_expected() {
        let Some(slot) = Slot::in_test(3) else { return };
        let objects = Objects(&slot);
        // SAFETY: a state of our own, in a slot that outlives it; nothing here raises.
        unsafe {
            let l = lua_newstate(lua_alloc, (&raw const *slot).cast_mut().cast());
            assert_eq!(luaL_loadbuffer(l, TEXT.as_ptr().cast(), TEXT.len(), c"=text".as_ptr()), LUA_OK);
            assert_eq!(lua_pcall(l, 0, 0, 0), LUA_OK);
            lua_pushcclosure(l, nothing, 0);
            lua_pushinteger(l, 1);
            lua_pushcclosure(l, nothing, 1);
            lua_setglobal(l, c"command".as_ptr());
            lua_pushglobaltable(l);
            let globals = lua_topointer(l, -1);
            let of = |name: &std::ffi::CStr| {
                lua_pushstring(l, name.as_ptr());
                let (way, found) = objects.way_to_text(globals, lua_tostring(l, -1).wrapping_sub(TEXT_BYTES).cast());
                assert_eq!(found, lua_getglobal(l, name.as_ptr()) != LUA_TNIL, "{name:?}");
                (found.then(|| objects.value(way[way.len() - 1])), lua_topointer(l, -1))
            };
            let (add, at) = of(c"add");
            assert_eq!(add, Some(Value::Function(at)));
            let (list, table) = of(c"list");
            assert_eq!((list, objects.list(table).1), (Some(Value::Table(table)), 3 * VALUE));
            let (command, closure) = of(c"command");
            assert_eq!(command, Some(Value::Command(closure)));
            assert_eq!(of(c"nobody").0, None);
            let prototype = objects.prototype(at);
            let (constants, bytes) = objects.constants(prototype);
            let texts = (0..bytes).step_by(VALUE).map(|i| objects.value(constants.wrapping_byte_add(i)));
            assert_eq!(texts.filter(|v| matches!(v, Value::Text(_))).count(), 2, "count and list");
            assert!(objects.code(prototype).1 >= 6 * 4);
            assert_eq!(objects.variables(at).map(|v| objects.of_variable(v)).next(), Some(Value::Table(globals)));
            // A table as the registry is: a number that is none of its list.
            lua_pushinteger(l, 5);
            lua_rawseti(l, LUA_REGISTRYINDEX, 13);
            let places = lua_topointer(l, LUA_REGISTRYINDEX);
            assert!(objects.way_to_number(places, 13).1 && !objects.way_to_number(places, 14).1);
            lua_createtable(l, 0, 0);
            lua_setmetatable(l, -3);
            assert!(objects.calls(l.cast_const().cast()).count() >= 1);
            lua_close(l);
        }
    }

    unsafe extern "C-unwind" fn nothing(_: *mut lua_State) -> i32 {
        0
    }
}
