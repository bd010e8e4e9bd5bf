//! Keys back to their places.
//!
//! A table of the same sizes gets first the keys that stand where their hashes say, and then the others from the last
//! place to the first, which is the order in which Lua hands out free places. Keys without a value are set and taken
//! out again, since their places are not free. In the end every place is looked at.

use mlua::ffi::*;

use super::{
    image::{Node, Table, Val},
    raw::{Key, Raw},
};
use crate::seed;

/// A key that stands in for one that the collector took.
type StandIn = ([u8; 20], usize);

/// A text whose hash leads to the place `head` of `n`, the `count`-th try and later ones.
fn stand_in(head: u32, n: usize, count: &mut u32) -> StandIn {
    loop {
        *count += 1;
        let mut text = *b"\0\0gone..............";
        text[6..10].copy_from_slice(&count.to_le_bytes());
        if seed::hash(&text[..10]) as usize & (n - 1) == head as usize {
            return (text, 10);
        }
    }
}

/// Fills the table at `at`, which is empty and has room for exactly this; `push` pushes a value. False: a key stands
/// elsewhere than it did.
///
/// # Safety
/// Protected, the collector rests, and there is room on the stack.
pub(super) unsafe fn fill(
    l: *mut lua_State,
    at: i32,
    table: &Table,
    push: &mut dyn FnMut(*mut lua_State, Val),
) -> bool {
    let t = Raw::of(l, at);
    if t.array() != table.array.len() || t.nodes() != table.nodes.len() {
        return false;
    }
    for (i, v) in table.array.iter().enumerate() {
        if *v != Val::Nil {
            push(l, *v);
            lua_rawseti(l, at, i as i64 + 1);
        }
    }
    let n = table.nodes.len();
    let mut count = 0;
    for i in 0..n {
        set(l, at, table, i, false, &mut count, push);
    }
    for i in (0..n).rev() {
        set(l, at, table, i, true, &mut count, push);
    }
    // Values come last, by the keys as they now stand.
    for (i, node) in table.nodes.iter().enumerate() {
        match node {
            Node::Live { key, value, .. } => {
                push(l, *key);
                push(l, *value);
                lua_rawset(l, at);
            }
            Node::Dead { .. } => {
                if !clear(l, at, t, i) {
                    return false;
                }
            }
            Node::Free => {}
        }
    }
    t.set_limit(table.limit, table.is_hint) && (0..n).all(|i| is_there(l, t, table, i, push))
}

/// Sets the key of one place, if it is of this sort, to `true`.
unsafe fn set(
    l: *mut lua_State,
    at: i32,
    table: &Table,
    i: usize,
    wanted: bool,
    count: &mut u32,
    push: &mut dyn FnMut(*mut lua_State, Val),
) {
    match table.nodes[i] {
        Node::Live { key, chained, .. } | Node::Dead { key: Some(key), chained, .. } if chained == wanted => {
            push(l, key)
        }
        Node::Dead { key: None, chained, head } if chained == wanted => {
            let (text, len) = stand_in(head, table.nodes.len(), count);
            lua_pushlstring(l, text.as_ptr().cast(), len);
        }
        _ => return,
    }
    lua_pushboolean(l, 1);
    lua_rawset(l, at);
}

/// Takes out the value in a place.
unsafe fn clear(l: *mut lua_State, at: i32, t: Raw, i: usize) -> bool {
    match t.key(i) {
        Key::Bool(b) => lua_pushboolean(l, i32::from(b)),
        Key::Int(x) => lua_pushinteger(l, x),
        Key::Float(x) => lua_pushnumber(l, f64::from_bits(x)),
        Key::Text(x) => crate::state::push(l, x),
        Key::Object | Key::Nil | Key::Gone => return false,
    }
    lua_pushnil(l);
    lua_rawset(l, at);
    true
}

/// Whether a place holds what it should.
unsafe fn is_there(
    l: *mut lua_State,
    t: Raw,
    table: &Table,
    i: usize,
    push: &mut dyn FnMut(*mut lua_State, Val),
) -> bool {
    match table.nodes[i] {
        Node::Free => t.key(i) == Key::Nil,
        Node::Dead { .. } => !t.has_value(i) && t.key(i) != Key::Nil,
        Node::Live { key, .. } => {
            if !t.has_value(i) {
                return false;
            }
            push(l, key);
            let same = match t.key(i) {
                Key::Bool(b) => key == Val::Bool(b),
                Key::Int(x) => key == Val::Int(x),
                Key::Float(x) => key == Val::Float(x),
                Key::Text(x) => lua_type(l, -1) == LUA_TSTRING && crate::state::bytes(l, -1) == x,
                // One of its kind: see `walk`.
                Key::Object => matches!(key, Val::Object(_)) && table.nodes.len() == 1,
                Key::Nil | Key::Gone => false,
            };
            lua_pop(l, 1);
            same
        }
    }
}
