//! What is drawn for people: numbers over time in graphs, and points, lines and faces in space.
//!
//! - [`Figures`]: all of a world;
//! - [`Drawing`]: items in space, on an object or in the world.
//!
//! Nothing of it acts back on objects. Graphs are emptied when a run starts and keep what they have when it stops;
//! drawings go when it stops, unless they are meant to last.

mod drawing;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::*;

pub use drawing::{Drawing, Form};

use tatu_errors::Refusal;
use tatu_scene::{Data, Scene, graph::Graph};

/// Most drawings of a world: a script that adds one in each step must not fill the memory.
const MOST_DRAWINGS: usize = 10_000;

/// All graphs and drawings of a world.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Figures {
    /// By object: generation and slot.
    pub graphs: BTreeMap<u64, Graph>,
    /// By number.
    pub drawings: BTreeMap<i64, Drawing>,
    last_drawing: i64,
}

impl Figures {
    /// A run starts: graphs are as the scene describes them, and empty.
    pub fn begin(&mut self, scene: &Scene) {
        self.graphs.clear();
        for (slot, o) in scene.slots() {
            if let Data::Graph(spec) = &o.data {
                self.graphs.insert(scene.id(slot), Graph::new(spec, o.name()));
            }
        }
    }
    /// A run has stopped: what was drawn is gone.
    pub fn end(&mut self) {
        self.drawings.retain(|_, d| d.persistent);
    }
    /// The graph of an object that is one.
    pub fn graph(&mut self, scene: &Scene, object: tatu_object) -> Result<&mut Graph, Refusal> {
        let slot = tatu_slot(object);
        match scene.get(slot).map(|o| (o, &o.data)) {
            Some((o, Data::Graph(spec))) => {
                Ok(self.graphs.entry(scene.id(slot)).or_insert_with(|| Graph::new(spec, o.name())))
            }
            _ => Err(Refusal(TATU_ERR_ARGUMENT, format!("object {slot} `{}` is not a graph", scene.path(slot)))),
        }
    }
    /// What all items take, roughly.
    pub fn bytes(&self) -> u64 {
        self.drawings.values().map(|d| (d.items.len() * (8 * d.stride() + 32)) as u64).sum()
    }
    /// Adds a drawing; its number, from 1.
    pub fn draw(&mut self, drawing: Drawing) -> Result<i64, Refusal> {
        if self.drawings.len() >= MOST_DRAWINGS {
            return Err(Refusal(TATU_ERR_SPACE, format!("there are {MOST_DRAWINGS} drawings already")));
        }
        self.last_drawing += 1;
        self.drawings.insert(self.last_drawing, drawing);
        Ok(self.last_drawing)
    }
    /// Removes drawings on removed objects.
    pub fn remove_orphans(&mut self, scene: &Scene) {
        self.drawings.retain(|_, d| d.parent == 0 || scene.resolve(d.parent).is_ok());
    }
}
