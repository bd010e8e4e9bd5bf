//! The data of a snapshot.

use serde::{Deserialize, Serialize};
use tatu_plugin_api::safe::*;

/// A value; strings and objects are indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum ImageValue {
    Nil,
    Bool(bool),
    Int(i64),
    /// The bits of a float.
    Float(u64),
    Text(u32),
    Object(u32),
}

/// A node of a table's hash part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum ImageNode {
    /// A node that was never used.
    Free,
    /// A key with a value.
    Live { key: ImageValue, value: ImageValue },
    /// A key whose value was removed, or `None` if the key was collected, too.
    Dead { key: Option<ImageValue> },
}

/// A table, including its memory layout.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct ImageTable {
    pub array: Vec<ImageValue>,
    /// Lua's field `alimit`, which is the size of the array part unless `is_hint` is set.
    pub limit: u32,
    /// Whether `limit` is only a hint for the length operator.
    pub is_hint: bool,
    /// The nodes of the hash part; their number is 0 or a power of two.
    pub nodes: Vec<ImageNode>,
    pub meta: Option<u32>,
}

/// Identifies a function by the source that contains it, and its index in this source in order of appearance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct FunctionRef {
    /// 0 for the script's own source, otherwise a one-based index into [`SnapshotImage::texts`].
    pub text: u32,
    pub function: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum ObjectContent {
    Table(ImageTable),
    /// A Lua function and its upvalues; `piece` is missing if it existed before the script ran.
    Function {
        piece: Option<FunctionRef>,
        cells: Vec<u32>,
    },
    /// A C function of the plugin and its upvalues; `function` is missing if it existed before the script ran.
    Native {
        function: Option<u8>,
        upvalues: Vec<ImageValue>,
    },
    /// Userdata that existed before the script ran, such as the state of the random generator.
    Bytes(Vec<u8>),
    /// A coroutine that has ended.
    DeadCoroutine,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ImageObject {
    /// Index among the objects that existed before the script ran, if the object is one of them.
    pub baseline: Option<u32>,
    pub kind: ObjectContent,
}

/// The plugin's own data about a script.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct PluginState {
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

/// The whole content of a snapshot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct SnapshotImage {
    /// Hash of the list of objects that existed before the script ran.
    pub baseline: u64,
    /// Hash of the code of the script's source.
    pub code: u64,
    pub objects: Vec<ImageObject>,
    /// Upvalues, each shared by all functions that refer to it.
    pub cells: Vec<ImageValue>,
    pub strings: Vec<Vec<u8>>,
    /// Sources that the script loaded: chunk name and source.
    pub texts: Vec<(Vec<u8>, Vec<u8>)>,
    /// Objects, with the numbers that `tostring` returns in place of their addresses.
    pub numbers: Vec<(u32, i64)>,
    pub plugin_data: PluginState,
}

impl SnapshotImage {
    /// Checks that all indices are in range, because the bytes may come from any file.
    pub(super) fn check(&self) -> Result<()> {
        let value = |v: &ImageValue| match v {
            ImageValue::Text(n) => (*n as usize) < self.strings.len(),
            ImageValue::Object(n) => (*n as usize) < self.objects.len(),
            _ => true,
        };
        let is_table =
            |n: &u32| matches!(self.objects.get(*n as usize), Some(ImageObject { kind: ObjectContent::Table(_), .. }));
        let node = |n: &ImageNode| match n {
            ImageNode::Free => true,
            ImageNode::Live { key, value: v } => {
                value(key) && value(v) && *key != ImageValue::Nil && *v != ImageValue::Nil
            }
            ImageNode::Dead { key } => {
                key.iter().all(value) && !matches!(key, Some(ImageValue::Nil | ImageValue::Object(_)))
            }
        };
        let object = |o: &ImageObject| match &o.kind {
            ObjectContent::Table(t) => {
                let n = t.nodes.len();
                t.array.iter().all(value)
                    && (n == 0 || n.is_power_of_two())
                    && t.nodes.iter().all(node)
                    && t.meta.iter().all(is_table)
            }
            ObjectContent::Function { piece, cells } => {
                let known = piece.is_none_or(|p| p.text as usize <= self.texts.len());
                known && cells.len() < 256 && cells.iter().all(|c| (*c as usize) < self.cells.len())
            }
            ObjectContent::Native { upvalues, .. } => upvalues.len() < 256 && upvalues.iter().all(value),
            ObjectContent::Bytes(_) | ObjectContent::DeadCoroutine => true,
        };
        let numbers = self.numbers.iter().all(|(n, _)| (*n as usize) < self.objects.len());
        if self.objects.iter().all(object) && self.cells.iter().all(value) && numbers {
            return Ok(());
        }
        Err(Fail::new("the saved state is damaged: an index is out of range"))
    }
}
