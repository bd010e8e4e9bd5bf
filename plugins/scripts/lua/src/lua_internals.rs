//! Access to Lua beyond its C interface, for determinism, budgets and snapshots.
//!
//! The accessors are in `lua_internals.c`, which is compiled against Lua's own headers. `build.rs` sets the definitions
//! for Lua's files.
//!
//! | item | purpose | check | if it fails |
//! |---|---|---|---|
//! | `luai_makeseed(L)=0x5EED` | Lua derives its hash seed from addresses and the clock, and `pairs` would visit string keys in a different order in each run | [`failed_checks`], at start | error in the log |
//! | `STRCACHE_N=1`, `STRCACHE_M=1` | Lua caches C strings by their address, which would decide when a string is collected | [`failed_checks`], at start | error in the log |
//! | `lua_math.h` before every file | the results of functions such as `sin` depend on the C library and the processor | a test compares their bits | the test fails |
//! | `strspn=tatu_lua_strspn` | text of floats in scripts for Lua 5.1, see [`NumberFormat`] | [`failed_checks`], at start | error in the log |
//! | `lua_gc` with a negative step | collections at fixed numbers of calls, see `gc` | [`failed_checks`], at start | error in the log |
//! | `build/charges.rs`, `lua_charges.h` | loops in C are charged to the budget | the build finds each edited text; [`meter`], in each state | C code is not charged |
//! | `lua_State.hookcount` | exact instruction counts per call | [`hook_count`], in each state | instructions are counted in thousands |
//! | `lua_State.stack`, `CallInfo.func` | where a script ran out of memory, even while its stack was growing | a test | no position is reported |
//! | `ImageTable`, `ImageNode` | snapshots restore keys to their nodes, so that `pairs` continues in the same order | [`knows_tables`], before each snapshot | snapshots are refused, and the run is replayed |
//! | hashes of strings and floats | main positions of keys in a restored table | all nodes are verified after a restore | the snapshot is refused |
//! | `Proto` | snapshots refer to functions by their index in a source | a function is looked up by its bytecode | the snapshot is refused |
//!
//! Lua also hashes objects by the low 32 bits of their addresses; `alloc` ensures that these are the same in every run.

use std::{
    cell::Cell,
    ffi::{CStr, c_int, c_void},
    ptr::null_mut,
};

use mlua_sys::*;

/// The hash seed set by `build.rs`.
const HASH_SEED: u32 = 0x5EED;

/// The struct that `tatu_lua_node` fills; must match `lua_internals.c`.
#[repr(C)]
struct RawNode {
    kind: u8,
    has_value: u8,
    bits: u64,
    text: *const u8,
}

const KEY_NIL: u8 = 0;
const KEY_BOOL: u8 = 1;
const KEY_INT: u8 = 2;
const KEY_FLOAT: u8 = 3;
const KEY_TEXT: u8 = 4;
const KEY_DEAD: u8 = 6;

unsafe extern "C" {
    fn tatu_lua_set_plain_floats(plain: c_int) -> c_int;
    fn tatu_lua_hook_count(l: *mut lua_State) -> *mut c_int;
    fn tatu_lua_meter(l: *mut lua_State) -> *mut WorkMeter;
    fn tatu_lua_enter(l: *mut lua_State) -> *mut lua_State;
    fn tatu_lua_count_here(units: u64);
    fn tatu_lua_seed(l: *mut lua_State) -> u32;
    fn tatu_lua_has_small_string_cache(l: *mut lua_State) -> c_int;
    fn tatu_lua_gc_debt(l: *mut lua_State) -> isize;
    fn tatu_lua_is_stack(l: *mut lua_State, block: *const c_void) -> c_int;
    fn tatu_lua_point_frames(l: *mut lua_State);
    fn tatu_lua_unpoint_frames(l: *mut lua_State);
    fn tatu_lua_hash_text(text: *const u8, len: usize) -> u32;
    fn tatu_lua_hash_float(x: f64) -> u32;
    fn tatu_lua_nodes(t: *const c_void) -> usize;
    fn tatu_lua_array_size(t: *const c_void) -> usize;
    fn tatu_lua_limit(t: *const c_void, is_hint: *mut c_int) -> u32;
    fn tatu_lua_set_limit(t: *const c_void, limit: u32, is_hint: c_int) -> c_int;
    fn tatu_lua_node_at(t: *const c_void, i: usize, out: *mut RawNode);
    fn tatu_lua_kill_key(t: *const c_void, i: usize);
    fn tatu_lua_exchange(a: *const c_void, b: *const c_void);
    fn tatu_lua_dump_nested(l: *mut lua_State, n: u32, writer: lua_Writer, out: *mut c_void) -> c_int;
    fn tatu_lua_hash_code(l: *mut lua_State) -> u64;
}

unsafe extern "C-unwind" {
    /// Public in Lua since 5.4.6; `mlua-sys` declares it only when it compiles Lua itself.
    pub(crate) fn lua_closethread(l: *mut lua_State, from: *mut lua_State) -> c_int;
}

/// Runs all checks; returns the failed ones, each with its consequence.
pub(crate) fn failed_checks() -> Vec<&'static str> {
    let mut problems = Vec::new();
    // SAFETY: the state is created here, and checked not to be null; a new state has LUA_MINSTACK free slots. Only a
    // lack of memory could raise an error.
    unsafe {
        let l = luaL_newstate();
        if l.is_null() {
            return problems;
        }
        if tatu_lua_seed(l) != HASH_SEED {
            problems.push("Lua's hash seed is not fixed: the order of `pairs` may differ between runs");
        }
        if tatu_lua_has_small_string_cache(l) == 0 {
            problems.push("Lua caches strings by address: the times of garbage collections may differ between runs");
        }
        defer_gc(l, 1);
        if tatu_lua_gc_debt(l) != -1024 {
            problems.push("Lua's collector cannot be deferred: the order of `pairs` may differ after a snapshot");
        }
        let _plain = NumberFormat::begin(true);
        lua_pushnumber(l, 5.0);
        let text = lua_tolstring(l, -1, null_mut());
        if text.is_null() || CStr::from_ptr(text) != c"5" {
            problems.push("Lua's number format cannot be set: scripts of old dialects print 5.0 instead of 5");
        }
        lua_close(l);
    }
    problems
}

/// Restarts the collector; its next collection happens after `kib` more KiB have been allocated.
///
/// # Safety
/// `l` must belong to a live state.
pub(crate) unsafe fn defer_gc(l: *mut lua_State, kib: c_int) {
    lua_gc(l, LUA_GCRESTART);
    lua_gc(l, LUA_GCSTEP, -kib);
}

/// Sets the number format of this OS thread while the value is alive: whether a float with an integral value is written
/// as `5`, as in Lua 5.1, or as `5.0`. Lua formats numbers in a single function, which calls `strspn` to decide whether
/// to append ".0". The build replaces `strspn`, so that the format applies to `..` and `string.format` as well as to
/// `tostring`, at no cost.
pub(crate) struct NumberFormat(c_int);

impl NumberFormat {
    /// Sets the format; if `plain`, integral floats are written without ".0".
    pub(crate) fn begin(plain: bool) -> Self {
        // SAFETY: the function only exchanges a thread-local integer.
        NumberFormat(unsafe { tatu_lua_set_plain_floats(c_int::from(plain)) })
    }
}

impl Drop for NumberFormat {
    fn drop(&mut self) {
        // SAFETY: the function only exchanges a thread-local integer.
        unsafe { tatu_lua_set_plain_floats(self.0) };
    }
}

/// Returns the address of a thread's countdown of instructions to the next run of its hook, or null if the check fails.
///
/// # Safety
/// `l` must not be running, and must just have been given a hook.
pub(crate) unsafe fn hook_count(l: *mut lua_State) -> *mut c_int {
    let left = tatu_lua_hook_count(l);
    if *left == lua_gethookcount(l) { left } else { null_mut() }
}

/// Counter of a state's work, in units (`lua_charges.h`): the units used, and the limit at which C code raises an
/// error.
#[repr(C)]
pub(crate) struct WorkMeter {
    pub used: Cell<u64>,
    pub limit: Cell<u64>,
}

/// Units per instruction, and units per byte that is examined individually.
pub(crate) const UNITS_PER_INSTRUCTION: u64 = 64;
pub(crate) const UNITS_PER_BYTE: u64 = 16;

/// Returns the meter of a state, or null if Lua was compiled with a memory layout other than that of [`WorkMeter`].
///
/// # Safety
/// `l` must belong to a live state, which outlives the meter.
pub(crate) unsafe fn meter(l: *mut lua_State) -> *const WorkMeter {
    tatu_lua_meter(l)
}

/// Charges units to the Lua thread that runs in this OS thread, if any.
pub(crate) fn count_here(units: u64) {
    // SAFETY: the C function has no effect if no thread is running; a running thread is alive, because `RunningThread`
    // resets it before its state can be closed.
    unsafe { tatu_lua_count_here(units) };
}

/// Marks `l` as the Lua thread running in this OS thread while the value is alive; C code charges its work to it.
pub(crate) struct RunningThread(*mut lua_State);

impl RunningThread {
    /// # Safety
    /// `l` must outlive the returned value.
    pub(crate) unsafe fn begin(l: *mut lua_State) -> Self {
        RunningThread(tatu_lua_enter(l))
    }
}

impl Drop for RunningThread {
    fn drop(&mut self) {
        // SAFETY: `self.0` is null, or the thread that was running when this value was created. The `RunningThread` of
        // that thread is still alive, so the thread is alive, too.
        unsafe { tatu_lua_enter(self.0) };
    }
}

/// Calls `look`, which examines the running functions of a thread, while the allocator refuses to grow `block`. If
/// `block` is the stack, Lua has converted all pointers into the stack to offsets. The pointers are restored for
/// `look`, because dereferencing an offset would crash.
///
/// # Safety
/// Only the allocator may call this; `look` may only read which functions run.
pub(crate) unsafe fn with_frames(l: *mut lua_State, block: *const u8, look: impl FnOnce()) {
    let moves = !l.is_null() && !block.is_null() && tatu_lua_is_stack(l, block.cast()) != 0;
    if moves {
        tatu_lua_point_frames(l);
    }
    look();
    if moves {
        tatu_lua_unpoint_frames(l);
    }
}

/// Returns Lua's hash of a string.
pub(crate) fn hash_text(text: &[u8]) -> u32 {
    // SAFETY: the pointer and the length are those of the slice, and the function only reads.
    unsafe { tatu_lua_hash_text(text.as_ptr(), text.len()) }
}

/// Returns Lua's hash of a float without an integral value.
pub(crate) fn hash_float(x: f64) -> u32 {
    // SAFETY: the function only uses its argument.
    unsafe { tatu_lua_hash_float(x) }
}

/// The key of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum NodeKey<'a> {
    Nil,
    Bool(bool),
    Int(i64),
    Float(u64),
    Text(&'a [u8]),
    /// A table, function, coroutine or userdata.
    Object,
    /// A key that has been collected; its node has no value.
    Dead,
}

/// Direct access to the memory of a table.
#[derive(Clone, Copy)]
pub(crate) struct RawTable(*const c_void);

impl RawTable {
    /// Returns access to the table at `idx`, which must outlive the result.
    pub(crate) unsafe fn of(l: *mut lua_State, idx: i32) -> Self {
        RawTable(lua_topointer(l, idx))
    }
    /// Returns the number of nodes of the hash part.
    pub(crate) unsafe fn nodes(self) -> usize {
        tatu_lua_nodes(self.0)
    }
    /// Returns the size of the array part.
    pub(crate) unsafe fn array(self) -> usize {
        tatu_lua_array_size(self.0)
    }
    /// Returns Lua's limit of the array part, and whether it is only a hint for the length operator.
    pub(crate) unsafe fn limit(self) -> (u32, bool) {
        let mut is_hint = 0;
        let limit = tatu_lua_limit(self.0, &mut is_hint);
        (limit, is_hint != 0)
    }
    /// Sets the limit and whether it is a hint. Returns false, and sets nothing, if that would change the size of the
    /// array.
    pub(crate) unsafe fn set_limit(self, limit: u32, is_hint: bool) -> bool {
        tatu_lua_set_limit(self.0, limit, c_int::from(is_hint)) != 0
    }
    /// Returns the key of a node, and whether the node has a value.
    pub(crate) unsafe fn node<'a>(self, i: usize) -> (NodeKey<'a>, bool) {
        let mut node = RawNode { kind: KEY_NIL, has_value: 0, bits: 0, text: std::ptr::null() };
        tatu_lua_node_at(self.0, i, &mut node);
        let key = match node.kind {
            KEY_NIL => NodeKey::Nil,
            KEY_BOOL => NodeKey::Bool(node.bits != 0),
            KEY_INT => NodeKey::Int(node.bits.cast_signed()),
            KEY_FLOAT => NodeKey::Float(node.bits),
            KEY_TEXT => NodeKey::Text(std::slice::from_raw_parts(node.text, node.bits as usize)),
            KEY_DEAD => NodeKey::Dead,
            _ => NodeKey::Object,
        };
        (key, node.has_value != 0)
    }
    /// Marks the key of a node without a value, which must be a string, as collected.
    pub(crate) unsafe fn kill_key(self, i: usize) {
        tatu_lua_kill_key(self.0, i);
    }
    /// Exchanges the contents of two tables, but not their metatables.
    ///
    /// # Safety
    /// The collector must be stopped, and both tables must have the same colour.
    pub(crate) unsafe fn exchange(self, other: RawTable) {
        tatu_lua_exchange(self.0, other.0);
    }
}

/// Returns whether `RawTable` reads the nodes of a table with known content correctly.
///
/// # Safety
/// Must run in protected mode, with five free stack slots.
pub(crate) unsafe fn knows_tables(l: *mut lua_State) -> bool {
    lua_createtable(l, 3, 4);
    lua_pushinteger(l, 7);
    lua_rawseti(l, -2, 1000);
    lua_pushboolean(l, 1);
    lua_setfield(l, -2, c"key".as_ptr());
    let t = RawTable::of(l, -1);
    let mut found = [0; 3];
    let right = t.nodes() == 4 && t.limit() == (3, false);
    for i in 0..if right { 4 } else { 0 } {
        match t.node(i) {
            (NodeKey::Int(1000), true) => found[0] += 1,
            (NodeKey::Text(b"key"), true) => found[1] += 1,
            (NodeKey::Nil, false) => found[2] += 1,
            _ => {}
        }
    }
    lua_pop(l, 1);
    found == [1, 1, 2]
}

unsafe extern "C-unwind" fn extend(_: *mut lua_State, bytes: *const c_void, n: usize, out: *mut c_void) -> c_int {
    if n > 0 {
        (*out.cast::<Vec<u8>>()).extend_from_slice(std::slice::from_raw_parts(bytes.cast::<u8>(), n));
    }
    0
}

/// Writes the function on top of the stack as a binary chunk; writes nothing if it is not a Lua function.
///
/// # Safety
/// There must be a value on top.
pub(crate) unsafe fn dump(l: *mut lua_State, out: &mut Vec<u8>) {
    out.clear();
    tatu_lua_dump_nested(l, 0, extend, (&raw mut *out).cast());
}

/// Writes the function on top of the stack and all functions nested in it, depth first, each in the format in which
/// `dump` writes its closure.
///
/// # Safety
/// There must be a value on top.
pub(crate) unsafe fn dump_all(l: *mut lua_State, out: &mut Vec<Vec<u8>>) {
    loop {
        let mut chunk = Vec::new();
        if tatu_lua_dump_nested(l, out.len() as u32, extend, (&raw mut chunk).cast()) == 0 {
            return;
        }
        out.push(chunk);
    }
}

/// Returns a hash of the bytecode of the Lua function on top of the stack, including nested functions, but not line
/// numbers or comments. Returns 0 if it is not a Lua function.
///
/// # Safety
/// There must be a value on top.
pub(crate) unsafe fn hash_code(l: *mut lua_State) -> u64 {
    tatu_lua_hash_code(l)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Order in which `pairs` visits the keys k1..k16 with the seed of `build.rs`.
    const EXPECTED_KEY_ORDER: &str = "k1k2k3k4k6k5k8k7k11k9k13k15k14k12k10k16";

    /// Returns the result of a chunk in a new state, as text.
    fn run(text: &str) -> String {
        // SAFETY: the state is created and closed here; `lua_pcall` leaves a result or a message on the stack.
        unsafe {
            let l = luaL_newstate();
            luaL_openlibs(l);
            luaL_loadbuffer(l, text.as_ptr().cast(), text.len(), c"=test".as_ptr());
            lua_pcall(l, 0, 1, 0);
            let text = CStr::from_ptr(lua_tolstring(l, -1, null_mut())).to_str().unwrap().to_owned();
            lua_close(l);
            text
        }
    }

    #[test]
    fn all_checks_of_lua_pass() {
        assert_eq!(failed_checks(), [""; 0]);
    }

    #[test]
    fn string_keys_are_in_the_expected_order() {
        let text =
            "local t, s = {}, '' for i = 1, 16 do t['k' .. i] = i end for k in pairs(t) do s = s .. k end return s";
        assert_eq!(run(text), EXPECTED_KEY_ORDER);
    }

    #[test]
    fn number_formats_nest() {
        let text = "return 5.0 .. ' ' .. 5 .. ' ' .. -2.5 .. string.format(' %05.1f %s', 1, 2.0)";
        assert_eq!(run(text), "5.0 5 -2.5 001.0 2.0");
        let _plain = NumberFormat::begin(true);
        assert_eq!(run(text), "5 5 -2.5 001.0 2");
        {
            let _modern = NumberFormat::begin(false);
            assert_eq!(run("return 1e15 .. ''"), "1e+15");
            assert_eq!(run("return 3.0 .. ''"), "3.0");
        }
        assert_eq!(run("return 3.0 .. ''"), "3");
    }

    #[test]
    fn float_keys_are_at_their_hash_positions() {
        // SAFETY: the state is created and closed here, and the stack has room for the few values pushed.
        unsafe {
            let l = luaL_newstate();
            for x in [0.5, -3.25, 1e300, 5e-324, f64::INFINITY, -1.0 / 3.0] {
                lua_createtable(l, 0, 8);
                lua_pushnumber(l, x);
                lua_pushboolean(l, 1);
                lua_rawset(l, -3);
                let home = hash_float(x) as usize % 7;
                assert_eq!(RawTable::of(l, -1).node(home), (NodeKey::Float(x.to_bits()), true), "{x}");
            }
            lua_close(l);
        }
    }
}
