//! Saves a state by traversing all reachable objects, each once.

use std::{collections::HashMap, ffi::CStr};

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use super::{
    image::{FunctionRef, ImageNode, ImageObject, ImageTable, ImageValue, ObjectContent, SnapshotImage},
    roots::{ROOT_NAMES, roots},
};
use crate::{
    lua_internals::{self, NodeKey, RawTable},
    run::commands::{call_foreign, command, index},
    stack::{bytes, reg, registry},
    state::ScriptState,
    stdlib::strings::gmatch_next,
};

/// How an object was reached from another object; used to identify the object in messages.
#[derive(Clone, Copy)]
enum ReferenceStep {
    Root(usize),
    Key(ImageValue),
    /// The object is the value of the upvalue with this name.
    Variable(u32),
    Metatable,
    /// The object is a key of a table.
    AsKey,
}

/// Stack slots of the list of objects, each at its index plus one, and of the list of objects that existed before the
/// script ran.
const OBJECTS_SLOT: i32 = 1;
const BASELINE_SLOT: i32 = 2;

/// A traversal in progress. It is owned outside Lua, so that a Lua error does not leak memory.
pub(super) struct Saver {
    image: SnapshotImage,
    ids: HashMap<usize, u32>,
    /// The object and step through which each object was reached.
    from: Vec<(u32, ReferenceStep)>,
    cells: HashMap<usize, u32>,
    strings: HashMap<Vec<u8>, u32>,
    baseline: HashMap<usize, u32>,
    pieces: HashMap<Vec<u8>, FunctionRef>,
    dump: Vec<u8>,
    /// Buffers for the object that is being described.
    array: Vec<ImageValue>,
    nodes: Vec<ImageNode>,
    list: Vec<u32>,
    /// The reason why the state cannot be saved, if there is one.
    refused: Option<String>,
}

impl Saver {
    pub(super) fn new() -> Self {
        Saver {
            image: SnapshotImage::default(),
            ids: HashMap::new(),
            from: Vec::new(),
            cells: HashMap::new(),
            strings: HashMap::new(),
            baseline: HashMap::new(),
            pieces: HashMap::new(),
            dump: Vec::new(),
            array: Vec::new(),
            nodes: Vec::new(),
            list: Vec::new(),
            refused: None,
        }
    }

    /// Returns the image, or the reason why the state cannot be saved.
    pub(super) fn finish(self) -> Result<SnapshotImage> {
        match self.refused {
            None => Ok(self.image),
            Some(reason) => Err(Fail::unsupported(reason)),
        }
    }

    /// Traverses the state.
    ///
    /// # Safety
    /// Must run in protected mode, with the collector stopped.
    pub(super) unsafe fn run(&mut self, l: *mut lua_State, s: &ScriptState) {
        luaL_checkstack(l, 40, std::ptr::null());
        if !lua_internals::knows_tables(l) {
            self.refused = Some("this build of Lua has an unknown memory layout of tables".to_owned());
            return;
        }
        lua_newtable(l);
        if registry(l, reg::BASELINE_OBJECTS) != LUA_TTABLE {
            self.refused = Some("the script's source has not been loaded".to_owned());
            return;
        }
        self.prepare(l, s);
        let n = roots(l) as usize;
        for i in 0..n {
            lua_pushvalue(l, BASELINE_SLOT + 1 + i as i32);
            self.object(l, 0, ReferenceStep::Root(i));
            lua_pop(l, 1);
        }
        lua_settop(l, BASELINE_SLOT);
        let mut id = 0;
        while id < self.from.len() && self.refused.is_none() {
            lua_rawgeti(l, OBJECTS_SLOT, id as i64 + 1);
            let kind = self.describe(l, id as u32);
            self.image.objects.push(ImageObject { baseline: self.baseline_index(l, BASELINE_SLOT + 1), kind });
            lua_settop(l, BASELINE_SLOT);
            id += 1;
        }
        if self.refused.is_none() {
            self.save_unreachable_data(l);
        }
    }

    /// Indexes the objects that existed before the script ran, and the functions of all sources.
    unsafe fn prepare(&mut self, l: *mut lua_State, s: &ScriptState) {
        for k in 0..lua_rawlen(l, BASELINE_SLOT) {
            lua_rawgeti(l, BASELINE_SLOT, k as i64 + 1);
            self.baseline.insert(lua_topointer(l, -1) as usize, k as u32);
            lua_pop(l, 1);
        }
        self.image.baseline = fingerprint(l, BASELINE_SLOT);
        if registry(l, reg::SCRIPT_CHUNK) == LUA_TFUNCTION {
            self.index_functions(l, 0);
        }
        lua_pop(l, 1);
        self.image.texts.clone_from(&s.sources.loaded_sources.borrow());
        for i in 0..self.image.texts.len() {
            if compile(l, &self.image.texts[i]) {
                self.index_functions(l, i as u32 + 1);
            }
            lua_pop(l, 1);
        }
    }

    /// Indexes the functions of the compiled source on top of the stack.
    unsafe fn index_functions(&mut self, l: *mut lua_State, text: u32) {
        let mut pieces = Vec::new();
        lua_internals::dump_all(l, &mut pieces);
        for (i, piece) in pieces.into_iter().enumerate() {
            self.pieces.entry(piece).or_insert(FunctionRef { text, function: i as u32 });
        }
    }

    unsafe fn baseline_index(&self, l: *mut lua_State, idx: i32) -> Option<u32> {
        self.baseline.get(&(lua_topointer(l, idx) as usize)).copied()
    }

    /// Saves the data that is not reachable from objects: the numbers that `tostring` prints in place of addresses.
    /// Refuses the snapshot while a thread function or coroutine is waiting.
    unsafe fn save_unreachable_data(&mut self, l: *mut lua_State) {
        let waits = [
            (reg::PLUGIN_COROUTINES, "its thread function is waiting"),
            (reg::WAITING_COROUTINES, "one of its coroutines is waiting"),
        ];
        for (place, what) in waits {
            if self.refused.is_some() {
                return;
            }
            registry(l, place);
            lua_pushnil(l);
            if lua_next(l, -2) != 0 {
                self.refused = Some(what.to_owned());
            }
            lua_settop(l, BASELINE_SLOT);
        }
        registry(l, reg::OBJECT_NUMBERS);
        lua_pushnil(l);
        while lua_next(l, BASELINE_SLOT + 1) != 0 {
            if let Some(id) = self.ids.get(&(lua_topointer(l, -2) as usize)) {
                self.image.numbers.push((*id, lua_tointeger(l, -1)));
            }
            lua_pop(l, 1);
        }
        lua_settop(l, BASELINE_SLOT);
    }

    /// Describes the value on top of the stack, which was reached from the object `id` by `step`.
    unsafe fn value(&mut self, l: *mut lua_State, id: u32, step: ReferenceStep) -> ImageValue {
        match lua_type(l, -1) {
            LUA_TNIL => ImageValue::Nil,
            LUA_TBOOLEAN => ImageValue::Bool(lua_toboolean(l, -1) != 0),
            LUA_TNUMBER if lua_isinteger(l, -1) != 0 => ImageValue::Int(lua_tointeger(l, -1)),
            LUA_TNUMBER => ImageValue::Float(lua_tonumber(l, -1).to_bits()),
            LUA_TSTRING => ImageValue::Text(self.text(bytes(l, -1))),
            _ => self.object(l, id, step),
        }
    }

    fn text(&mut self, text: &[u8]) -> u32 {
        if let Some(known) = self.strings.get(text) {
            return *known;
        }
        let number = self.image.strings.len() as u32;
        self.image.strings.push(text.to_vec());
        self.strings.insert(text.to_vec(), number);
        number
    }

    /// Queues the object on top of the stack for description, and returns a reference to it.
    unsafe fn object(&mut self, l: *mut lua_State, id: u32, step: ReferenceStep) -> ImageValue {
        let pointer = lua_topointer(l, -1) as usize;
        if let Some(known) = self.ids.get(&pointer) {
            return ImageValue::Object(*known);
        }
        let number = self.from.len() as u32;
        lua_pushvalue(l, -1);
        lua_rawseti(l, OBJECTS_SLOT, i64::from(number) + 1);
        self.ids.insert(pointer, number);
        self.from.push((id, step));
        ImageValue::Object(number)
    }

    fn refuse(&mut self, id: u32, what: &str) -> ObjectContent {
        if self.refused.is_none() {
            self.refused = Some(format!("{} {what}", self.name(id)));
        }
        ObjectContent::DeadCoroutine
    }

    /// Returns the name by which the script refers to an object.
    fn name(&self, id: u32) -> String {
        let mut tail = String::new();
        let mut at = id;
        for _ in 0..20 {
            let (from, step) = self.from[at as usize];
            let text = |n: u32| String::from_utf8_lossy(&self.image.strings[n as usize]).into_owned();
            match step {
                ReferenceStep::Root(0) => return format!("the table of globals{tail}"),
                ReferenceStep::Root(n) => {
                    return format!("{}{}{tail}", ROOT_NAMES[n], if tail.is_empty() { "" } else { ": " });
                }
                ReferenceStep::Variable(name) => return format!("local variable `{}{tail}`", text(name)),
                ReferenceStep::Key(ImageValue::Text(key)) if from == 0 => {
                    return format!("variable `{}{tail}`", text(key));
                }
                ReferenceStep::Key(ImageValue::Text(key)) => tail = format!(".{}{tail}", text(key)),
                ReferenceStep::Key(ImageValue::Int(i)) => tail = format!("[{i}]{tail}"),
                ReferenceStep::Key(ImageValue::Float(bits)) => tail = format!("[{}]{tail}", f64::from_bits(bits)),
                ReferenceStep::Key(_) => tail = format!("[...]{tail}"),
                ReferenceStep::Metatable => tail = format!(" (its metatable){tail}"),
                ReferenceStep::AsKey => tail = format!(" (a key){tail}"),
            }
            at = from;
        }
        format!("a deeply nested value in its variables, at `{tail}`")
    }

    /// Describes the object on top of the stack, which is also in slot `BASELINE + 1`.
    unsafe fn describe(&mut self, l: *mut lua_State, id: u32) -> ObjectContent {
        match lua_type(l, -1) {
            LUA_TTABLE => self.table(l, id),
            LUA_TFUNCTION if lua_iscfunction(l, -1) != 0 => self.native(l, id),
            LUA_TFUNCTION => self.function(l, id),
            LUA_TUSERDATA if self.baseline_index(l, -1).is_some() => {
                if lua_getmetatable(l, -1) != 0 {
                    // This is one of the library's standard files, which have no state in Lua.
                    lua_pop(l, 1);
                    return ObjectContent::Bytes(Vec::new());
                }
                let (ptr, n) = (lua_touserdata(l, -1).cast::<u8>(), lua_rawlen(l, -1));
                ObjectContent::Bytes(std::slice::from_raw_parts(ptr, n).to_vec())
            }
            LUA_TUSERDATA => self.refuse(id, "is an open file"),
            LUA_TTHREAD => {
                let thread = lua_tothread(l, -1);
                match lua_status(thread) {
                    LUA_YIELD => self.refuse(id, "is a suspended coroutine"),
                    LUA_OK if lua_gettop(thread) > 0 => self.refuse(id, "is a coroutine that has not started yet"),
                    _ => ObjectContent::DeadCoroutine,
                }
            }
            _ => self.refuse(id, "is of a type that cannot be saved"),
        }
    }

    unsafe fn native(&mut self, l: *mut lua_State, id: u32) -> ObjectContent {
        let f = lua_tocfunction(l, -1);
        self.array.clear();
        let mut n = 1;
        while !lua_getupvalue(l, BASELINE_SLOT + 1, n).is_null() {
            if lua_type(l, -1) == LUA_TTHREAD {
                return self.refuse(id, "is a coroutine created by `coroutine.wrap`");
            }
            let v = self.value(l, id, ReferenceStep::Key(ImageValue::Nil));
            self.array.push(v);
            lua_pop(l, 1);
            n += 1;
        }
        let upvalues = std::mem::take(&mut self.array);
        if self.baseline_index(l, BASELINE_SLOT + 1).is_some() {
            return ObjectContent::Native { function: None, upvalues };
        }
        let known = native_functions();
        match known.iter().position(|k| f.is_some_and(|f| f as usize == *k as usize)) {
            Some(i) => ObjectContent::Native { function: Some(i as u8), upvalues },
            None => self.refuse(id, "is a library function that cannot be saved"),
        }
    }

    unsafe fn function(&mut self, l: *mut lua_State, id: u32) -> ObjectContent {
        let mut piece = None;
        if self.baseline_index(l, -1).is_none() {
            lua_internals::dump(l, &mut self.dump);
            piece = self.pieces.get(&self.dump).copied();
            if piece.is_none() {
                return self.refuse(id, "is a function whose source is no longer known");
            }
        }
        self.list.clear();
        for n in 1..=255 {
            let name = lua_getupvalue(l, BASELINE_SLOT + 1, n);
            if name.is_null() {
                break;
            }
            let cell = lua_upvalueid(l, BASELINE_SLOT + 1, n) as usize;
            let number = match self.cells.get(&cell) {
                Some(known) => *known,
                None => {
                    let number = self.image.cells.len() as u32;
                    self.cells.insert(cell, number);
                    self.image.cells.push(ImageValue::Nil);
                    let name = self.text(CStr::from_ptr(name).to_bytes());
                    let v = self.value(l, id, ReferenceStep::Variable(name));
                    self.image.cells[number as usize] = v;
                    number
                }
            };
            self.list.push(number);
            lua_pop(l, 1);
        }
        ObjectContent::Function { piece, cells: std::mem::take(&mut self.list) }
    }

    unsafe fn table(&mut self, l: *mut lua_State, id: u32) -> ObjectContent {
        let at = BASELINE_SLOT + 1;
        let t = RawTable::of(l, at);
        let mut meta = None;
        if lua_getmetatable(l, at) != 0 {
            lua_pushlstring(l, c"__mode".as_ptr(), 6);
            if lua_rawget(l, -2) != LUA_TNIL {
                return self.refuse(id, "is a weak table");
            }
            lua_pop(l, 1);
            if let ImageValue::Object(m) = self.object(l, id, ReferenceStep::Metatable) {
                meta = Some(m);
            }
            lua_pop(l, 1);
        }
        self.array.clear();
        for i in 1..=t.array() as i64 {
            lua_rawgeti(l, at, i);
            let v = self.value(l, id, ReferenceStep::Key(ImageValue::Int(i)));
            self.array.push(v);
            lua_pop(l, 1);
        }
        self.describe_nodes(l, id, t);
        let (limit, is_hint) = t.limit();
        let (array, nodes) = (std::mem::take(&mut self.array), std::mem::take(&mut self.nodes));
        ObjectContent::Table(ImageTable { array, limit, is_hint, nodes, meta })
    }

    /// Describes the hash part: the nodes as stored in memory, with the values from Lua's own traversal, which visits
    /// them in the same order.
    unsafe fn describe_nodes(&mut self, l: *mut lua_State, id: u32, t: RawTable) {
        let n = t.nodes();
        self.nodes.clear();
        let mut objects = 0;
        lua_pushnil(l);
        if n > 0 {
            // Lua's traversal visits the array part first, so continue after the last value of this part.
            for i in (1..=t.array() as i64).rev() {
                if self.array[i as usize - 1] != ImageValue::Nil {
                    lua_pop(l, 1);
                    lua_pushinteger(l, i);
                    break;
                }
            }
        }
        for i in 0..n {
            let node = match t.node(i) {
                (NodeKey::Nil, _) => ImageNode::Free,
                (key, true) => {
                    if lua_next(l, BASELINE_SLOT + 1) == 0 {
                        self.refuse(id, "is a table that cannot be traversed");
                        return;
                    }
                    objects += usize::from(key == NodeKey::Object);
                    lua_pushvalue(l, -2);
                    let key = self.value(l, id, ReferenceStep::AsKey);
                    lua_pop(l, 1);
                    let value = self.value(l, id, ReferenceStep::Key(key));
                    lua_pop(l, 1);
                    ImageNode::Live { key, value }
                }
                (key, false) => {
                    let key = match key {
                        NodeKey::Bool(b) => Some(ImageValue::Bool(b)),
                        NodeKey::Int(x) => Some(ImageValue::Int(x)),
                        NodeKey::Float(x) => Some(ImageValue::Float(x)),
                        NodeKey::Text(x) => Some(ImageValue::Text(self.text(x))),
                        _ => None,
                    };
                    ImageNode::Dead { key }
                }
            };
            self.nodes.push(node);
        }
        lua_settop(l, BASELINE_SLOT + 1);
        if objects > 0 && n > 1 {
            self.refuse(id, "has keys that are tables or functions, whose order cannot be restored");
        }
    }
}

/// Returns the C functions that the plugin creates while a script runs.
pub(super) fn native_functions() -> [lua_CFunction; 4] {
    [command, index, call_foreign, gmatch_next]
}

/// Compiles a source and pushes the function, or an error message; returns whether the source could be compiled.
///
/// # Safety
/// Must run in protected mode, since it may raise an error.
pub(super) unsafe fn compile(l: *mut lua_State, text: &(Vec<u8>, Vec<u8>)) -> bool {
    // As a Lua string, the name ends with a zero byte.
    lua_pushlstring(l, text.0.as_ptr().cast(), text.0.len());
    let name = lua_tolstring(l, -1, std::ptr::null_mut());
    let status = luaL_loadbufferx(l, text.1.as_ptr().cast(), text.1.len(), name, c"t".as_ptr());
    lua_remove(l, -2);
    status == LUA_OK
}

/// Returns a hash of the kinds of the objects in the list at `idx`.
///
/// # Safety
/// There must be a list at `idx`, and one free stack slot.
pub(super) unsafe fn fingerprint(l: *mut lua_State, idx: i32) -> u64 {
    let mut h = 0xcbf2_9ce4_8422_2325_u64;
    for k in 1..=lua_rawlen(l, idx) as i64 {
        let kind = lua_rawgeti(l, idx, k) as u64 * 2 + u64::from(lua_iscfunction(l, -1) != 0);
        lua_pop(l, 1);
        h = (h ^ kind).wrapping_mul(0x0100_0000_01b3);
    }
    h
}
