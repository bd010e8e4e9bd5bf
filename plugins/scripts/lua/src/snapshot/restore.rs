//! Restores a state: creates the objects first, then fills them.

use std::ffi::{c_char, c_void};

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use super::{
    image::{FunctionRef, ImageObject, ImageValue, ObjectContent, SnapshotImage},
    key_order,
    save::{compile, fingerprint, native_functions},
};
use crate::{
    lua_internals::{self, RawTable},
    run::budget,
    stack::{self, reg, registry},
    state::ScriptState,
};

/// Stack slots, as in `save`; the table that is being filled is above these.
const OBJECTS_SLOT: i32 = 1;
const BASELINE_SLOT: i32 = 2;

/// A restore in progress. It is owned outside Lua, so that a Lua error does not leak memory.
pub(super) struct Restorer {
    image: SnapshotImage,
    /// The functions of each source, as binary chunks.
    pieces: Vec<Vec<Vec<u8>>>,
    refused: Option<String>,
}

/// The binary chunk that `lua_load` reads.
struct BytecodeChunk {
    bytes: *const u8,
    len: usize,
}

unsafe extern "C-unwind" fn read_chunk(_: *mut lua_State, chunk: *mut c_void, n: *mut usize) -> *const c_char {
    let chunk = &mut *chunk.cast::<BytecodeChunk>();
    *n = std::mem::take(&mut chunk.len);
    chunk.bytes.cast()
}

impl Restorer {
    pub(super) fn new(image: SnapshotImage) -> Self {
        Restorer { image, pieces: Vec::new(), refused: None }
    }

    /// Returns the image, or the reason why the state could not be restored.
    pub(super) fn finish(self) -> Result<SnapshotImage> {
        match self.refused {
            None => Ok(self.image),
            Some(reason) => Err(Fail::unsupported(reason)),
        }
    }

    fn refuse(&mut self, reason: &str) {
        if self.refused.is_none() {
            self.refused = Some(reason.to_owned());
        }
    }

    /// First phase: creates and fills all objects.
    ///
    /// # Safety
    /// Must run in protected mode; the collector must be stopped, and all objects must have the same color.
    pub(super) unsafe fn run(&mut self, l: *mut lua_State, s: &ScriptState) {
        luaL_checkstack(l, 40, std::ptr::null());
        if !lua_internals::knows_tables(l) {
            return self.refuse("this build of Lua has an unknown memory layout of tables");
        }
        lua_createtable(l, self.image.objects.len().min(1 << 24) as i32, 0);
        if registry(l, reg::BASELINE_OBJECTS) != LUA_TTABLE || fingerprint(l, BASELINE_SLOT) != self.image.baseline {
            return self.refuse("the state was saved with a different library or different preludes");
        }
        self.prepare(l);
        for id in 0..self.image.objects.len() {
            if !self.create_object(l, s, id) {
                return self.refuse("the objects that existed before the script ran are different");
            }
            lua_rawseti(l, OBJECTS_SLOT, id as i64 + 1);
        }
        // Set metatables while they are empty, so that Lua does not find finalizers in them.
        for id in 0..self.image.objects.len() {
            self.set_meta(l, id);
        }
        self.join_upvalues(l);
        for id in 0..self.image.objects.len() {
            if !self.fill(l, id) {
                return self.refuse("a table could not be restored with its original size");
            }
        }
        registry(l, reg::OBJECT_NUMBERS);
        for (id, number) in &self.image.numbers {
            lua_rawgeti(l, OBJECTS_SLOT, i64::from(*id) + 1);
            lua_pushinteger(l, *number);
            lua_rawset(l, BASELINE_SLOT + 1);
        }
        // Store the objects for the second phase, and to protect them from the collector.
        lua_settop(l, OBJECTS_SLOT);
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::RESTORED_OBJECTS);
    }

    /// Second phase, which does not allocate: removes the values of dead keys and verifies every node.
    ///
    /// # Safety
    /// Must run in protected mode, since it may raise an error.
    pub(super) unsafe fn verify(&mut self, l: *mut lua_State) {
        if self.refused.is_some() {
            return;
        }
        lua_settop(l, 0);
        registry(l, reg::RESTORED_OBJECTS);
        for (id, object) in self.image.objects.iter().enumerate() {
            let ObjectContent::Table(t) = &object.kind else { continue };
            lua_rawgeti(l, OBJECTS_SLOT, id as i64 + 1);
            if !key_order::verify(l, OBJECTS_SLOT + 1, t, &mut |l, v| push(l, &self.image, v)) {
                self.refused = Some("the keys of a table could not be restored in their original order".to_owned());
                break;
            }
            lua_settop(l, OBJECTS_SLOT);
        }
        lua_pushnil(l);
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::RESTORED_OBJECTS);
    }

    unsafe fn prepare(&mut self, l: *mut lua_State) {
        self.pieces.resize(self.image.texts.len() + 1, Vec::new());
        if registry(l, reg::SCRIPT_CHUNK) == LUA_TFUNCTION {
            lua_internals::dump_all(l, &mut self.pieces[0]);
        }
        lua_pop(l, 1);
        for (text, pieces) in self.image.texts.iter().zip(&mut self.pieces[1..]) {
            if compile(l, text) {
                lua_internals::dump_all(l, pieces);
            }
            lua_pop(l, 1);
        }
    }

    /// Pushes a new, empty object; returns false if it cannot be created.
    unsafe fn create_object(&mut self, l: *mut lua_State, s: &ScriptState, id: usize) -> bool {
        let ImageObject { baseline, kind } = &self.image.objects[id];
        if let Some(k) = baseline {
            let there = lua_rawgeti(l, BASELINE_SLOT, i64::from(*k) + 1);
            return match kind {
                ObjectContent::Table(_) => there == LUA_TTABLE,
                ObjectContent::Function { cells, .. } => {
                    let n = cells.len() as i32;
                    there == LUA_TFUNCTION && lua_iscfunction(l, -1) == 0 && has_upvalues(l, n)
                }
                ObjectContent::Native { .. } => there == LUA_TFUNCTION && lua_iscfunction(l, -1) != 0,
                ObjectContent::Bytes(bytes) => there == LUA_TUSERDATA && put_bytes(l, bytes),
                ObjectContent::DeadCoroutine => false,
            };
        }
        match kind {
            ObjectContent::Table(t) => lua_createtable(l, t.array.len() as i32, t.nodes.len() as i32),
            ObjectContent::Function { piece: Some(piece), cells } => {
                return self.create_function(l, *piece, cells.len() as i32);
            }
            ObjectContent::Native { function: Some(n), upvalues } => {
                let Some(f) = native_functions().get(usize::from(*n)).copied() else { return false };
                for _ in upvalues {
                    lua_pushnil(l);
                }
                lua_pushcclosure(l, f, upvalues.len() as i32);
            }
            ObjectContent::DeadCoroutine => {
                budget::charge_coroutine(s);
                lua_newthread(l);
            }
            _ => return false,
        }
        true
    }

    /// Pushes a function of one of the sources. Its bytecode was produced by the compiler, never read from the image.
    unsafe fn create_function(&self, l: *mut lua_State, piece: FunctionRef, cells: i32) -> bool {
        let text = self.pieces.get(piece.text as usize);
        let Some(code) = text.and_then(|t| t.get(piece.function as usize)) else { return false };
        let mut chunk = BytecodeChunk { bytes: code.as_ptr(), len: code.len() };
        lua_load(l, read_chunk, (&raw mut chunk).cast(), c"=text".as_ptr(), c"b".as_ptr()) == LUA_OK
            && has_upvalues(l, cells)
    }

    unsafe fn set_meta(&self, l: *mut lua_State, id: usize) {
        let ObjectContent::Table(t) = &self.image.objects[id].kind else { return };
        if t.meta.is_none() && self.image.objects[id].baseline.is_none() {
            return;
        }
        lua_rawgeti(l, OBJECTS_SLOT, id as i64 + 1);
        match t.meta {
            Some(meta) => {
                lua_rawgeti(l, OBJECTS_SLOT, i64::from(meta) + 1);
            }
            None => lua_pushnil(l),
        }
        lua_setmetatable(l, -2);
        lua_pop(l, 1);
    }

    /// Restores upvalues: the first function that refers to an upvalue owns it, the others share it.
    unsafe fn join_upvalues(&mut self, l: *mut lua_State) {
        lua_createtable(l, self.image.cells.len().min(1 << 24) as i32, 0);
        let owners = lua_gettop(l);
        for (id, object) in self.image.objects.iter().enumerate() {
            lua_rawgeti(l, OBJECTS_SLOT, id as i64 + 1);
            let at = lua_gettop(l);
            match &object.kind {
                ObjectContent::Function { cells, .. } => {
                    for (i, cell) in cells.iter().enumerate() {
                        let n = i as i32 + 1;
                        // `owners` contains the object that owns each upvalue, and the upvalue's index in this object.
                        if lua_rawgeti(l, owners, i64::from(*cell) + 1) == LUA_TNUMBER {
                            let owner = lua_tointeger(l, -1);
                            lua_rawgeti(l, OBJECTS_SLOT, owner >> 8);
                            lua_upvaluejoin(l, at, n, -1, (owner & 0xFF) as i32);
                        } else {
                            lua_pushinteger(l, (id as i64 + 1) << 8 | i64::from(n));
                            lua_rawseti(l, owners, i64::from(*cell) + 1);
                            push(l, &self.image, self.image.cells[*cell as usize]);
                            lua_setupvalue(l, at, n);
                        }
                        lua_settop(l, at);
                    }
                }
                ObjectContent::Native { function: Some(_), upvalues } => {
                    for (i, v) in upvalues.iter().enumerate() {
                        push(l, &self.image, *v);
                        lua_setupvalue(l, at, i as i32 + 1);
                    }
                }
                _ => {}
            }
            lua_settop(l, owners);
        }
        lua_settop(l, BASELINE_SLOT);
    }

    /// Fills a table. A table that existed before the script ran retains its identity, but gets the content of a new
    /// table.
    unsafe fn fill(&self, l: *mut lua_State, id: usize) -> bool {
        let ImageObject { baseline, kind: ObjectContent::Table(t) } = &self.image.objects[id] else { return true };
        lua_rawgeti(l, OBJECTS_SLOT, id as i64 + 1);
        let old = lua_gettop(l);
        if baseline.is_some() {
            lua_createtable(l, t.array.len() as i32, t.nodes.len() as i32);
        }
        let at = lua_gettop(l);
        let done = key_order::fill(l, at, t, &self.image.strings, &mut |l, v| push(l, &self.image, v));
        if baseline.is_some() {
            RawTable::of(l, old).exchange(RawTable::of(l, at));
        }
        lua_settop(l, BASELINE_SLOT);
        done
    }
}

/// Pushes the Lua value that a value of the image represents.
unsafe fn push(l: *mut lua_State, image: &SnapshotImage, v: ImageValue) {
    match v {
        ImageValue::Nil => lua_pushnil(l),
        ImageValue::Bool(b) => lua_pushboolean(l, i32::from(b)),
        ImageValue::Int(i) => lua_pushinteger(l, i),
        ImageValue::Float(bits) => lua_pushnumber(l, f64::from_bits(bits)),
        ImageValue::Text(n) => stack::push(l, &image.strings[n as usize]),
        ImageValue::Object(n) => {
            lua_rawgeti(l, OBJECTS_SLOT, i64::from(n) + 1);
        }
    }
}

/// Returns whether the function on top of the stack has exactly `n` upvalues.
unsafe fn has_upvalues(l: *mut lua_State, n: i32) -> bool {
    let has = |k: i32| {
        let there = !lua_getupvalue(l, -1, k).is_null();
        if there {
            lua_pop(l, 1);
        }
        there
    };
    (n == 0 || has(n)) && !has(n + 1)
}

pub(super) unsafe fn put_bytes(l: *mut lua_State, bytes: &[u8]) -> bool {
    if lua_getmetatable(l, -1) != 0 {
        lua_pop(l, 1);
        return bytes.is_empty();
    }
    if lua_rawlen(l, -1) != bytes.len() {
        return false;
    }
    std::ptr::copy_nonoverlapping(bytes.as_ptr(), lua_touserdata(l, -1).cast(), bytes.len());
    true
}
