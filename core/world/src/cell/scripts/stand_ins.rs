//! Stand-ins: objects created because scripts look them up, in a run without a scene.
//!
//! They are created only if [`World::enable_stand_ins`](crate::run::World::enable_stand_ins) was called. If a script
//! then looks up an object that does not exist, the object is created as a dummy. A dummy that is used as a different
//! kind becomes an object of that kind, if the host can change it in a live world. From the list of stand-ins, the
//! caller can build a document that contains them from the start, because some objects, such as sensors, must exist
//! when the world is created.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeSet,
};

use nalgebra::Isometry3;
use tatu_plugin_api::abi::*;
use tatu_scene::{ObjectVariant, Scene};

/// Kind of a stand-in whose use has not implied a different kind yet.
const UNKNOWN_KIND: &str = "dummy";
/// Maximum number of objects that are created.
const MAX_STAND_INS: usize = 2000;

/// A stand-in for an object that a script looked up and that does not exist.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StandIn {
    /// Index of the parent stand-in in the list, or `None` for the world.
    pub parent: Option<usize>,
    /// Alias of the object.
    pub alias: String,
    /// The number after `#` in the object's unique name, or -1 if there is none.
    pub suffix: i32,
    /// The kind of object, such as "joint", or the schema if the object was read as a sensor, such as "pose/1"; "dummy"
    /// if it is unknown.
    pub kind: String,
    /// Whether a script of this object was requested.
    pub script: bool,
}

impl StandIn {
    /// Returns the stand-in's unique name.
    pub fn name(&self) -> String {
        if self.suffix < 0 { self.alias.clone() } else { format!("{}#{}", self.alias, self.suffix) }
    }
}

/// An object that a script requested but may not need, such as a parent, or a child by index. It should be created only
/// if the script cannot continue without it: see [`World::optional_objects`](crate::run::World::optional_objects).
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum OptionalObject {
    /// The parent of a stand-in.
    Parent,
    /// A child of this kind, or of any kind if the string is empty.
    Child(String),
    /// A script attached to a stand-in.
    Script,
}

/// The stand-ins of a world.
#[derive(Default)]
pub(crate) struct StandIns {
    enabled: Cell<bool>,
    list: RefCell<Vec<(tatu_object, StandIn)>>,
    optional_objects: RefCell<BTreeSet<(tatu_object, OptionalObject)>>,
    /// Names of values, such as signals, that scripts requested but that do not exist.
    missing_values: RefCell<BTreeSet<String>>,
    values: RefCell<BTreeSet<String>>,
}

impl StandIns {
    pub fn is_on(&self) -> bool {
        self.enabled.get()
    }
    /// Starts recording, with these objects of the document as stand-ins. `values` are the names of the values, such as
    /// signals, that this run provides.
    pub fn begin(&self, list: Vec<(tatu_object, StandIn)>, values: &[String]) {
        *self.values.borrow_mut() = values.iter().cloned().collect();
        self.enabled.set(true);
        *self.list.borrow_mut() = list;
    }
    /// Records the kind that an object is used as. Returns `false` if it is not a stand-in or its kind is already
    /// known.
    pub fn set_kind(&self, object: tatu_object, kind: &str) -> bool {
        let Ok(mut list) = self.list.try_borrow_mut() else { return false };
        let Some((_, stand_in)) = list.iter_mut().find(|(o, s)| *o == object && s.kind == UNKNOWN_KIND) else {
            return false;
        };
        kind.clone_into(&mut stand_in.kind);
        true
    }
    /// Returns the stand-ins, in the order in which they were requested.
    pub fn list(&self) -> Vec<StandIn> {
        self.list.borrow().iter().map(|(_, s)| s.clone()).collect()
    }
    /// Returns whether this run provides a value; if not, records that it was requested.
    pub fn has_value(&self, name: &str) -> bool {
        let has = self.values.borrow().contains(name);
        if !has && self.missing_values.borrow().len() < MAX_STAND_INS {
            self.missing_values.borrow_mut().insert(name.to_owned());
        }
        has
    }
    /// Returns the names of values that were requested but do not exist.
    pub fn missing_values(&self) -> Vec<String> {
        self.missing_values.borrow().iter().cloned().collect()
    }
    /// Returns the optional objects that scripts requested, each with the index of its stand-in in the list.
    pub fn optional_objects(&self) -> Vec<(usize, OptionalObject)> {
        let (list, wishes) = (self.list.borrow(), self.optional_objects.borrow());
        wishes.iter().filter_map(|(o, w)| Some((list.iter().position(|(id, _)| id == o)?, w.clone()))).collect()
    }
    /// Records that a script requested an optional object of a stand-in.
    pub fn note_optional(&self, object: tatu_object, wish: OptionalObject) {
        self.optional_objects.borrow_mut().insert((object, wish));
    }
    pub fn add(&self, scene: &mut Scene, parent: u32, alias: &str) -> Option<u32> {
        let mut list = self.list.borrow_mut();
        if list.len() >= MAX_STAND_INS || alias.is_empty() {
            return None;
        }
        let above = scene.id(parent);
        let slot = scene.add(parent, alias, Isometry3::identity(), ObjectVariant::Dummy(None))?;
        scene.make_unique(&[slot]);
        let suffix = scene.get(slot).map_or(-1, |o| o.suffix());
        let parent = if above == 0 { None } else { list.iter().position(|(id, _)| *id == above) };
        list.push((
            scene.id(slot),
            StandIn { parent, alias: alias.to_owned(), suffix, kind: UNKNOWN_KIND.into(), script: false },
        ));
        Some(slot)
    }
}
