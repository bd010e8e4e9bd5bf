//! Restores the order of keys in a table.
//!
//! Lua inserts a key at its main position or, if that is occupied by a key with the same main position, at the last
//! free node. Therefore, keys that were at their main position are inserted first into a new table of the same size,
//! followed by all other keys, from the last node to the first. Dead keys also occupy nodes: they are inserted with a
//! value, which is removed at the end, when every node is verified.

use mlua_sys::*;

use super::image::{ImageNode, ImageTable, ImageValue};
use crate::{
    lua_internals::{self, NodeKey, RawTable},
    stack,
};

/// Returns the main position of a key in a table of `n` nodes, or `None` if the key is an object, of which a table has
/// at most one.
fn main_position(key: ImageValue, n: usize, strings: &[Vec<u8>]) -> Option<usize> {
    let modulo = ((n - 1) | 1) as u64;
    Some(match key {
        ImageValue::Bool(b) => usize::from(b) & (n - 1),
        ImageValue::Int(i) => (i as u64 % modulo) as usize,
        ImageValue::Float(bits) => (u64::from(lua_internals::hash_float(f64::from_bits(bits))) % modulo) as usize,
        ImageValue::Text(t) => lua_internals::hash_text(&strings[t as usize]) as usize & (n - 1),
        ImageValue::Nil | ImageValue::Object(_) => return None,
    })
}

/// Returns a string that replaces a collected key: its main position in a table of `n` nodes is `place`.
fn placeholder(place: usize, n: usize, count: &mut u32) -> [u8; 10] {
    loop {
        *count += 1;
        let mut text = *b"\0\0gone....";
        text[6..].copy_from_slice(&count.to_le_bytes());
        if lua_internals::hash_text(&text) as usize & (n - 1) == place {
            return text;
        }
    }
}

/// Fills the table at index `at`, which must be empty; `push` pushes a value. Returns false if the table does not have
/// exactly the required size.
///
/// # Safety
/// Must run in protected mode, with enough free stack slots, and with the collector stopped.
pub(super) unsafe fn fill(
    l: *mut lua_State,
    at: i32,
    table: &ImageTable,
    strings: &[Vec<u8>],
    push: &mut dyn FnMut(*mut lua_State, ImageValue),
) -> bool {
    let t = RawTable::of(l, at);
    if t.array() != table.array.len() || t.nodes() != table.nodes.len() {
        return false;
    }
    for (i, v) in table.array.iter().enumerate() {
        if *v != ImageValue::Nil {
            push(l, *v);
            lua_rawseti(l, at, i as i64 + 1);
        }
    }
    let n = table.nodes.len();
    let mut count = 0;
    for at_home in [true, false] {
        for i in (0..n).rev() {
            match table.nodes[i] {
                ImageNode::Live { key, .. } | ImageNode::Dead { key: Some(key) }
                    if main_position(key, n, strings).is_none_or(|p| p == i) == at_home =>
                {
                    push(l, key);
                }
                ImageNode::Dead { key: None } if at_home => {
                    let text = placeholder(i, n, &mut count);
                    lua_pushlstring(l, text.as_ptr().cast(), text.len());
                }
                _ => continue,
            }
            lua_pushboolean(l, 1);
            lua_rawset(l, at);
        }
    }
    for node in &table.nodes {
        if let ImageNode::Live { key, value } = node {
            push(l, *key);
            push(l, *value);
            lua_rawset(l, at);
        }
    }
    true
}

/// Removes the values of dead keys and verifies every node. Returns false if a key is not in its original node.
///
/// # Safety
/// Must run in protected mode, with enough free stack slots.
pub(super) unsafe fn verify(
    l: *mut lua_State,
    at: i32,
    table: &ImageTable,
    push: &mut dyn FnMut(*mut lua_State, ImageValue),
) -> bool {
    let t = RawTable::of(l, at);
    if t.array() != table.array.len() || t.nodes() != table.nodes.len() {
        return false;
    }
    for (i, node) in table.nodes.iter().enumerate() {
        let ImageNode::Dead { key } = node else { continue };
        if !clear(l, at, t, i) {
            return false;
        }
        if key.is_none() {
            t.kill_key(i);
        }
    }
    t.set_limit(table.limit, table.is_hint) && (0..table.nodes.len()).all(|i| is_restored(l, t, table, i, push))
}

/// Sets the value of a node to nil.
unsafe fn clear(l: *mut lua_State, at: i32, t: RawTable, i: usize) -> bool {
    match t.node(i).0 {
        NodeKey::Bool(b) => lua_pushboolean(l, i32::from(b)),
        NodeKey::Int(x) => lua_pushinteger(l, x),
        NodeKey::Float(x) => lua_pushnumber(l, f64::from_bits(x)),
        NodeKey::Text(x) => stack::push(l, x),
        NodeKey::Object | NodeKey::Nil | NodeKey::Dead => return false,
    }
    lua_pushnil(l);
    lua_rawset(l, at);
    true
}

/// Returns whether a node has its original key and state.
unsafe fn is_restored(
    l: *mut lua_State,
    t: RawTable,
    table: &ImageTable,
    i: usize,
    push: &mut dyn FnMut(*mut lua_State, ImageValue),
) -> bool {
    let found = t.node(i);
    let (key, has_value) = match table.nodes[i] {
        ImageNode::Free => return found.0 == NodeKey::Nil,
        ImageNode::Dead { key: None } => return found == (NodeKey::Dead, false),
        ImageNode::Dead { key: Some(key) } => (key, false),
        ImageNode::Live { key, .. } => (key, true),
    };
    push(l, key);
    let same = match found.0 {
        NodeKey::Bool(b) => key == ImageValue::Bool(b),
        NodeKey::Int(x) => key == ImageValue::Int(x),
        NodeKey::Float(x) => key == ImageValue::Float(x),
        NodeKey::Text(x) => lua_type(l, -1) == LUA_TSTRING && stack::bytes(l, -1) == x,
        // `save` accepts an object as a key only if it is the table's only key.
        NodeKey::Object => matches!(key, ImageValue::Object(_)) && table.nodes.len() == 1,
        NodeKey::Nil | NodeKey::Dead => false,
    };
    lua_pop(l, 1);
    same && found.1 == has_value
}
