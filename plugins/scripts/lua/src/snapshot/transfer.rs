//! Transfers plain data of a snapshot to a script whose source has changed.
//!
//! The new script has already run. Globals with plain data (numbers, strings, booleans, tables of these without
//! metatables) get the values of the old script, unless the new script has set them to a different type; the random
//! generator is transferred as well. Functions and local variables are those of the new script.

use mlua_sys::*;

use super::{
    image::{ImageNode, ImageObject, ImageValue, ObjectContent, SnapshotImage},
    restore::put_bytes,
    save::fingerprint,
};
use crate::stack::{self, reg, registry};

/// Stack slots, from the bottom: the created tables, by object index; the objects that existed before the script ran;
/// the globals.
const OBJECTS_SLOT: i32 = 1;
const BASELINE_SLOT: i32 = 2;
const GLOBALS_SLOT: i32 = 3;

/// A transfer in progress. It is owned outside Lua, so that a Lua error does not leak memory.
pub(super) struct GlobalsTransfer {
    image: SnapshotImage,
    /// Whether each object is a table of plain data.
    plain: Vec<bool>,
    pub(super) refused: Option<&'static str>,
}

impl GlobalsTransfer {
    pub(super) fn new(image: SnapshotImage) -> Self {
        let plain = plain_tables(&image);
        GlobalsTransfer { image, plain, refused: None }
    }

    fn is_plain(&self, v: ImageValue) -> bool {
        if let ImageValue::Object(n) = v { self.plain[n as usize] } else { true }
    }

    /// Runs the transfer.
    ///
    /// # Safety
    /// Must run in protected mode, with an empty stack.
    pub(super) unsafe fn run(&mut self, l: *mut lua_State) {
        luaL_checkstack(l, 20, std::ptr::null());
        lua_createtable(l, 0, 0);
        if registry(l, reg::BASELINE_OBJECTS) != LUA_TTABLE || fingerprint(l, BASELINE_SLOT) != self.image.baseline {
            self.refused = Some("the state was saved with a different library or different preludes");
            return;
        }
        lua_pushglobaltable(l);
        for (id, object) in self.image.objects.iter().enumerate() {
            match object {
                ImageObject { baseline: Some(k), kind: ObjectContent::Bytes(bytes) } => {
                    if lua_rawgeti(l, BASELINE_SLOT, i64::from(*k) + 1) == LUA_TUSERDATA {
                        put_bytes(l, bytes);
                    }
                    lua_settop(l, GLOBALS_SLOT);
                }
                ImageObject { kind: ObjectContent::Table(t), .. } if self.plain[id] => {
                    lua_createtable(l, t.array.len() as i32, t.nodes.len() as i32);
                    lua_rawseti(l, OBJECTS_SLOT, id as i64 + 1);
                }
                _ => {}
            }
        }
        for (id, object) in self.image.objects.iter().enumerate() {
            let ObjectContent::Table(t) = &object.kind else { continue };
            if self.plain[id] {
                lua_rawgeti(l, OBJECTS_SLOT, id as i64 + 1);
                for (i, v) in t.array.iter().enumerate() {
                    self.push(l, *v);
                    lua_rawseti(l, -2, i as i64 + 1);
                }
                for node in &t.nodes {
                    if let ImageNode::Live { key, value } = node {
                        self.push(l, *key);
                        self.push(l, *value);
                        lua_rawset(l, -3);
                    }
                }
            } else if let Some(k) = object.baseline {
                lua_rawgeti(l, BASELINE_SLOT, i64::from(k) + 1);
                if lua_rawequal(l, -1, GLOBALS_SLOT) != 0 {
                    for node in &t.nodes {
                        self.global(l, node);
                    }
                }
            }
            lua_settop(l, GLOBALS_SLOT);
        }
    }

    /// Sets a global variable if it is plain data and the new script has not set it to a different type.
    unsafe fn global(&self, l: *mut lua_State, node: &ImageNode) {
        let ImageNode::Live { key: key @ ImageValue::Text(_), value } = node else { return };
        if !self.is_plain(*value) {
            return;
        }
        self.push(l, *key);
        self.push(l, *value);
        lua_pushvalue(l, -2);
        let now = lua_rawget(l, GLOBALS_SLOT);
        let was = lua_type(l, -2);
        lua_pop(l, 1);
        if now == LUA_TNIL || now == was {
            lua_rawset(l, GLOBALS_SLOT);
        } else {
            lua_pop(l, 2);
        }
    }

    unsafe fn push(&self, l: *mut lua_State, v: ImageValue) {
        match v {
            ImageValue::Nil => lua_pushnil(l),
            ImageValue::Bool(b) => lua_pushboolean(l, i32::from(b)),
            ImageValue::Int(i) => lua_pushinteger(l, i),
            ImageValue::Float(bits) => lua_pushnumber(l, f64::from_bits(bits)),
            ImageValue::Text(n) => stack::push(l, &self.image.strings[n as usize]),
            ImageValue::Object(n) => {
                lua_rawgeti(l, OBJECTS_SLOT, i64::from(n) + 1);
            }
        }
    }
}

/// Returns for each object whether it is a table that contains only plain data, at any depth.
fn plain_tables(image: &SnapshotImage) -> Vec<bool> {
    let own = |o: &ImageObject| o.baseline.is_none() && matches!(&o.kind, ObjectContent::Table(t) if t.meta.is_none());
    let mut plain: Vec<bool> = image.objects.iter().map(own).collect();
    // A table is not plain if it refers to an object that is not plain.
    let mut referrers: Vec<Vec<u32>> = vec![Vec::new(); image.objects.len()];
    for (id, object) in image.objects.iter().enumerate() {
        let ObjectContent::Table(t) = &object.kind else { continue };
        let of_nodes = t.nodes.iter().flat_map(|n| match n {
            ImageNode::Live { key, value } => [*key, *value],
            _ => [ImageValue::Nil, ImageValue::Nil],
        });
        for v in t.array.iter().copied().chain(of_nodes) {
            if let ImageValue::Object(n) = v {
                referrers[n as usize].push(id as u32);
            }
        }
    }
    let mut others: Vec<usize> = (0..plain.len()).filter(|i| !plain[*i]).collect();
    while let Some(id) = others.pop() {
        for holder in &referrers[id] {
            if std::mem::take(&mut plain[*holder as usize]) {
                others.push(*holder as usize);
            }
        }
    }
    plain
}
