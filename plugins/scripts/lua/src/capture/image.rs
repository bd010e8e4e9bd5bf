//! What is written of a state.

use serde::{Deserialize, Serialize};
use tatu_plugin_api::safe::*;

/// A value; texts and objects by their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Val {
    Nil,
    Bool(bool),
    Int(i64),
    /// The bits of a float.
    Float(u64),
    Text(u32),
    Object(u32),
}

/// One place of a table's hash part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum Node {
    /// Never used.
    Free,
    /// A key with a value.
    Live { key: Val, value: Val },
    /// A key whose value was taken out; none: the collector has taken the key too.
    Dead { key: Option<Val> },
}

/// A table, place by place.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Table {
    pub array: Vec<Val>,
    /// What Lua takes for the array's size when it looks for the length; often its size.
    pub limit: u32,
    /// Whether `limit` is not the array's size.
    pub is_hint: bool,
    /// None, or a power of two.
    pub nodes: Vec<Node>,
    pub meta: Option<u32>,
}

/// Where a function stands: the text, and the number of the function in it, in order of appearance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Piece {
    /// 0: the script's own text; else [`Image::texts`], from 1.
    pub text: u32,
    pub function: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Kind {
    Table(Table),
    /// A function in Lua and the cells of its outer variables; of a fresh one the piece is not needed.
    Function {
        piece: Option<Piece>,
        cells: Vec<u32>,
    },
    /// A function of the plugin, by its number; of a fresh one none is needed.
    Native {
        function: Option<u8>,
        upvalues: Vec<Val>,
    },
    /// A fresh block of bytes, such as the state of the random generator.
    Bytes(Vec<u8>),
    /// A coroutine that has ended.
    Ended,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Object {
    /// Its number among what was there before the text ran.
    pub fresh: Option<u32>,
    pub kind: Kind,
}

/// What the plugin knows of a script beside its Lua state.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Known {
    pub token: u64,
    pub borrowed: u32,
    pub returned: u32,
    pub kept: u32,
    pub numbers: i64,
    pub entries: u64,
    pub generation: u64,
    pub style: u8,
    pub names: Vec<(u32, Vec<u8>)>,
    pub line: Vec<u8>,
}

/// The whole state.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Image {
    /// Over what was there before the text ran.
    pub fresh: u64,
    /// Over the code of the script's own text.
    pub code: u64,
    pub objects: Vec<Object>,
    /// Outer variables, each shared by all functions that name it.
    pub cells: Vec<Val>,
    pub strings: Vec<Vec<u8>>,
    /// Texts that the script loaded: chunk name and text.
    pub texts: Vec<(Vec<u8>, Vec<u8>)>,
    /// Numbers that objects were shown by.
    pub numbers: Vec<(u32, i64)>,
    pub known: Known,
}

impl Image {
    /// Refuses what points to nothing: bytes may come from anywhere.
    pub(super) fn check(&self) -> Result<()> {
        let value = |v: &Val| match v {
            Val::Text(n) => (*n as usize) < self.strings.len(),
            Val::Object(n) => (*n as usize) < self.objects.len(),
            _ => true,
        };
        let is_table = |n: &u32| matches!(self.objects.get(*n as usize), Some(Object { kind: Kind::Table(_), .. }));
        let node = |n: &Node| match n {
            Node::Free => true,
            Node::Live { key, value: v } => value(key) && value(v) && *key != Val::Nil && *v != Val::Nil,
            Node::Dead { key } => key.iter().all(value) && !matches!(key, Some(Val::Nil | Val::Object(_))),
        };
        let object = |o: &Object| match &o.kind {
            Kind::Table(t) => {
                let n = t.nodes.len();
                t.array.iter().all(value)
                    && (n == 0 || n.is_power_of_two())
                    && t.nodes.iter().all(node)
                    && t.meta.iter().all(is_table)
            }
            Kind::Function { piece, cells } => {
                let known = piece.is_none_or(|p| p.text as usize <= self.texts.len());
                known && cells.len() < 256 && cells.iter().all(|c| (*c as usize) < self.cells.len())
            }
            Kind::Native { upvalues, .. } => upvalues.len() < 256 && upvalues.iter().all(value),
            Kind::Bytes(_) | Kind::Ended => true,
        };
        let numbers = self.numbers.iter().all(|(n, _)| (*n as usize) < self.objects.len());
        if self.objects.iter().all(object) && self.cells.iter().all(value) && numbers {
            return Ok(());
        }
        Err(Fail::new("its state is damaged: something in it points to nothing"))
    }
}
