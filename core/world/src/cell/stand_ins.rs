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
use tatu_scene::{
    Data, Joint, Scene, Shape,
    document::DeviceSpec,
    rows::{KINDS, Of, Row, kind_name},
};

use super::WorldCell;

/// What an object is until its use tells more.
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
    /// Begins to listen: every object of the document is a stand-in.
    pub fn begin(&self, world: &WorldCell, values: &[String]) {
        *self.values.borrow_mut() = values.iter().cloned().collect();
        let (scene, origins) = (world.scene.borrow(), world.origins.borrow());
        let schema = |d: &DeviceSpec| world.registry.sensors.get(d.kind).and_then(|k| k.schemas.first().cloned());
        self.on.set(true);
        *self.list.borrow_mut() = world
            .document
            .objects
            .iter()
            .zip(origins.iter())
            .map(|(spec, id)| {
                let suffix = scene.resolve(*id).ok().and_then(|s| scene.get(s)).map_or(-1, |o| o.suffix());
                let kind = match spec.kind {
                    TATU_KIND_SENSOR => spec.device.as_ref().and_then(schema),
                    _ => None,
                };
                let kind = kind.unwrap_or_else(|| kind_name(spec.kind).to_owned());
                (
                    *id,
                    StandIn {
                        parent: spec.parent,
                        alias: spec.alias.clone(),
                        suffix,
                        kind,
                        script: !spec.scripts.is_empty(),
                    },
                )
            })
            .collect();
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
    fn add(&self, scene: &mut Scene, parent: u32, alias: &str) -> Option<u32> {
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

/// The object of a path or unique name, made if it is not there; `from`: what "." means, and what unique names are made
/// below. `None`: these are no names, or there are too many.
pub(crate) fn find_or_make(world: &WorldCell, from: u32, name: &str) -> Option<tatu_object> {
    let mut scene = world.scene.try_borrow_mut().ok()?;
    let scene = &mut *scene;
    if let Some(slot) = scene.find(from, name) {
        return Some(scene.id(slot));
    }
    let stand_ins = &world.stand_ins;
    if name.starts_with(['/', '.', ':']) {
        let (mut at, rest) = scene.start_of(from, name)?;
        for part in rest.split('/').filter(|p| !p.is_empty()) {
            at = match scene.below(at, part) {
                Some(slot) => slot,
                None => make_part(stand_ins, scene, at, part)?,
            };
        }
        return (at != 0).then(|| scene.id(at));
    }
    let (alias, suffix) = match name.split_once('#') {
        Some((alias, n)) => (alias, n.parse().unwrap_or(-1)),
        None => (name, -1),
    };
    // The smaller numbers come first, as they did when the object got its own.
    for _ in -1..suffix.clamp(-1, 63) + 1 {
        stand_ins.add(scene, from, &alias.replace('/', "_"))?;
        if let Some(slot) = scene.find_name(name) {
            return Some(scene.id(slot));
        }
    }
    None
}

/// Makes what a part of a path means, with those that stand before it by its index.
fn make_part(stand_ins: &StandIns, scene: &mut Scene, at: u32, part: &str) -> Option<u32> {
    let alias = part.split(['[', '{']).next()?.replace(['*', '?'], "x");
    for _ in 0..64 {
        let made = stand_ins.add(scene, at, &alias)?;
        if let Some(slot) = scene.below(at, part) {
            return Some(slot);
        }
        // A wildcard that fits no name fits this one.
        if !part.contains(['[', '{']) {
            return Some(made);
        }
    }
    None
}

/// An object was used as one of a kind, or as a sensor that fills a schema; whether it is one now.
pub(crate) fn becomes(world: &WorldCell, object: tatu_object, kind: &str) -> bool {
    if !world.stand_ins.is_on() {
        return false;
    }
    let (Ok(mut scene), Ok(mut list)) = (world.scene.try_borrow_mut(), world.stand_ins.list.try_borrow_mut()) else {
        return false;
    };
    let Ok(slot) = scene.resolve(object) else { return false };
    let id = scene.id(slot);
    let Some((_, stand_in)) = list.iter_mut().find(|(o, s)| *o == id && s.kind == UNKNOWN) else { return false };
    kind.clone_into(&mut stand_in.kind);
    let data = match KINDS.iter().find(|(n, _)| *n == kind).map(|(_, k)| *k) {
        Some(TATU_KIND_SHAPE) => {
            Data::Shape(Box::new(Shape { dynamic: true, respondable: true, ..Default::default() }))
        }
        Some(TATU_KIND_JOINT) => Data::Joint(Box::<Joint>::default()),
        Some(TATU_KIND_FORCE_SENSOR) => Data::ForceSensor(Box::default()),
        // Made with the next document.
        _ => return false,
    };
    scene.change_kind(slot, data)
}

/// A row was asked for that belongs to another kind of object; whether the object is of that kind now.
pub(crate) fn becomes_by_row(world: &WorldCell, object: tatu_object, row: Row) -> bool {
    match row.info().of {
        Of::Kind(kind) if world.stand_ins.is_on() => becomes(world, object, kind_name(kind)),
        _ => false,
    }
}
