//! Stand-ins: what scripts ask for in a run that has no scene of its own.
//!
//! Off unless [`World::make_stand_ins`](crate::run::World::make_stand_ins) was called. Then an object that a script asks for
//! and that is not there is made as a dummy, and a dummy that is used as something else becomes that, where the host can
//! change it while the world lives. What was learned is kept in order, so that the next run's document can have it from
//! the start: a sensor, for one, must be there before the world is.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeSet,
};

use nalgebra::Isometry3;
use tatu_plugin_api::abi::*;
use tatu_scene::{Data, Scene};

/// What an object is until its use shows more.
const UNKNOWN: &str = "dummy";
/// No script asks for more objects than this.
const MOST: usize = 2000;

/// An object that stands in for one that a script asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StandIn {
    /// The stand-in above, by its place in the list.
    pub parent: Option<usize>,
    /// Its alias.
    pub alias: String,
    /// The number after `#` in its unique name; -1: none.
    pub suffix: i32,
    /// A kind of object, or a schema where a sensor was read: "joint", "pose/1". "dummy": nothing was learned.
    pub kind: String,
    /// A script of its own was asked for.
    pub script: bool,
}

impl StandIn {
    /// Its unique name.
    pub fn name(&self) -> String {
        if self.suffix < 0 { self.alias.clone() } else { format!("{}#{}", self.alias, self.suffix) }
    }
}

/// What was asked for in passing, and would be strange to make unless it is missed: see [`World::wishes`](crate::run::World::wishes).
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wish {
    /// What a stand-in hangs on.
    Parent,
    /// What hangs on it, of a kind; empty: of any.
    Child(String),
    /// Its script.
    Script,
}

/// The stand-ins of a world.
#[derive(Default)]
pub(crate) struct StandIns {
    on: Cell<bool>,
    list: RefCell<Vec<(tatu_object, StandIn)>>,
    wishes: RefCell<BTreeSet<(tatu_object, Wish)>>,
    /// Values that were asked for by name and are not there, and those that this run is to have.
    missed: RefCell<BTreeSet<String>>,
    values: RefCell<BTreeSet<String>>,
}

impl StandIns {
    pub fn is_on(&self) -> bool {
        self.on.get()
    }
    /// Begins to listen: these objects of the document are stand-ins.
    pub fn begin(&self, list: Vec<(tatu_object, StandIn)>, values: &[String]) {
        *self.values.borrow_mut() = values.iter().cloned().collect();
        self.on.set(true);
        *self.list.borrow_mut() = list;
    }
    /// Notes what an object is used as; `false`: it is no stand-in, or was known already.
    pub fn learn(&self, object: tatu_object, kind: &str) -> bool {
        let Ok(mut list) = self.list.try_borrow_mut() else { return false };
        let Some((_, stand_in)) = list.iter_mut().find(|(o, s)| *o == object && s.kind == UNKNOWN) else {
            return false;
        };
        kind.clone_into(&mut stand_in.kind);
        true
    }
    /// What is known now, in the order in which it was asked for.
    pub fn list(&self) -> Vec<StandIn> {
        self.list.borrow().iter().map(|(_, s)| s.clone()).collect()
    }
    /// Whether this run is to have a value; if not, that it was asked for is noted.
    pub fn has_value(&self, name: &str) -> bool {
        let has = self.values.borrow().contains(name);
        if !has && self.missed.borrow().len() < MOST {
            self.missed.borrow_mut().insert(name.to_owned());
        }
        has
    }
    /// Values that were asked for in vain.
    pub fn missed(&self) -> Vec<String> {
        self.missed.borrow().iter().cloned().collect()
    }
    /// What was asked for in passing, by places in the list.
    pub fn wishes(&self) -> Vec<(usize, Wish)> {
        let (list, wishes) = (self.list.borrow(), self.wishes.borrow());
        wishes.iter().filter_map(|(o, w)| Some((list.iter().position(|(id, _)| id == o)?, w.clone()))).collect()
    }
    /// Notes it.
    pub fn wish(&self, object: tatu_object, wish: Wish) {
        self.wishes.borrow_mut().insert((object, wish));
    }
    pub fn add(&self, scene: &mut Scene, parent: u32, alias: &str) -> Option<u32> {
        let mut list = self.list.borrow_mut();
        if list.len() >= MOST || alias.is_empty() {
            return None;
        }
        let above = scene.id(parent);
        let slot = scene.add(parent, alias, Isometry3::identity(), Data::Dummy(None))?;
        scene.make_unique(&[slot]);
        let suffix = scene.get(slot).map_or(-1, |o| o.suffix());
        let parent = if above == 0 { None } else { list.iter().position(|(id, _)| *id == above) };
        list.push((
            scene.id(slot),
            StandIn { parent, alias: alias.to_owned(), suffix, kind: UNKNOWN.into(), script: false },
        ));
        Some(slot)
    }
}
